#pragma once
// SPDX-License-Identifier: MIT
//
// One step as a polynomial: the common currency of all methods.
//
// Whatever a method does inside a step, in the end it knows y(τ) between t_previous and t to about
// the accuracy of the step. Multistep methods have their Nordsieck vector, Runge–Kutta methods their
// dense-output formula, Taylor methods the series itself. Each of them is a polynomial per component,
//
//     y(τ) = Σₖ cₖ sᵏ,     s = (τ − origin) / scale,     k = 0 … degree,
//
// with origin and scale chosen by the method (CVODE: origin = t and scale = h, so s ∈ [−1, 0]; a
// Runge–Kutta method would take the left end, s ∈ [0, 1]). Dense output, output times, event
// location and the trajectory need nothing else, so they are written once.
//
// τ counts from `base` (time_point.hpp), so that a step may be shorter than a rounding unit of t. Such a step does not contain the
// double t that is nearest to it. For a t outside, the value is that at the end of the nearest step.

#include <Eigen/Core>
#include <algorithm>
#include <limits>

namespace qdot {

/// Polynomial in one variable with vector coefficients; a view, valid until its owner takes a step.
struct PolynomialView {
  double origin = 0.0;                   ///< τ at which s = 0, counted from base
  double scale = 1.0;                    ///< τ per unit of s, never 0; its sign is free
  const double* coefficients = nullptr;  ///< c₀ … c_degree, each `size` numbers, one after the other
  Eigen::Index size = 0;                 ///< components of y
  int degree = 0;
  double base = 0.0;                     ///< t at which τ = 0
  double begin = -std::numeric_limits<double>::infinity();  ///< τ at one end of the step
  double end = std::numeric_limits<double>::infinity();     ///< and at the other

  /// Coefficient cₖ.
  Eigen::Map<const Eigen::VectorXd> coefficient(int k) const { return {coefficients + k * size, size}; }

  /// y ← its value at t, within the step; allocates nothing.
  void evaluate(double t, Eigen::Ref<Eigen::VectorXd> y) const { at(within(t), y); }

  /// One component of evaluate(), for searching a root without the rest.
  double evaluate(double t, Eigen::Index component) const {
    const double s = (within(t) - origin) / scale;
    double value = coefficients[degree * size + component];
    for (int k = degree - 1; k >= 0; --k) value = value * s + coefficients[k * size + component];
    return value;
  }

  /// y ← Σ cₖ sᵏ at τ by Horner's rule; allocates nothing. At τ = origin the result is c₀ exactly.
  void at(double tau, Eigen::Ref<Eigen::VectorXd> y) const {
    const double s = (tau - origin) / scale;
    double* const values = y.data();
    std::copy_n(coefficients + degree * size, size, values);
    for (int k = degree - 1; k >= 0; --k) {
      const double* const c = coefficients + k * size;
      for (Eigen::Index i = 0; i < size; ++i) values[i] = values[i] * s + c[i];
    }
  }

  /// τ of a time t, moved into the step.
  double within(double t) const { return std::clamp(t - base, std::min(begin, end), std::max(begin, end)); }
};

}  // namespace qdot
