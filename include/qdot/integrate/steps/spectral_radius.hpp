#pragma once
// SPDX-License-Identifier: MIT
//
// How fast the fastest part of a motion near a state would be.
//
//     x ← J x / |J x| ,      ρ ≈ growth of |x| ,      J = ∂f/∂y
//
// Powers of J turn any x towards the eigenvalues that lead; over an even number of them a pair ±λ shows |λ|. J is exact and dense where there are few
// components. Of many the matrix would be too large, and it is not needed: J x is what f does when y moves a little along x.
//
// Loops, not Eigen's expressions: each of these is a type that every program with an Automatic would wait for.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "qdot/ad/vector.hpp"

namespace qdot::detail {

/// The largest |λ| of ∂f/∂y, estimated by powers of the Jacobian; of many components, whose matrix would be too large, by differences of f along them.
class SpectralRadius {
 public:
  using ConstVector = Eigen::Ref<const Eigen::VectorXd>;
  using Jacobian = std::function<void(double, const ConstVector&, Eigen::Ref<Eigen::MatrixXd>)>;
  using Derivative = std::function<void(double, const ConstVector&, Eigen::Ref<Eigen::VectorXd>)>;

  static constexpr Eigen::Index most_components = 1000;  // of a dense matrix

  SpectralRadius(Eigen::Index size, Jacobian jacobian, Derivative derivative)
      : jacobian_(std::move(jacobian)), derivative_(std::move(derivative)), x_(size), image_(size), second_(size) {
    if (size <= most_components) J_ = zeros<Eigen::MatrixXd>(size, size);
    else y_.resize(size), moved_.resize(size), f_.resize(size);
  }

  /// Within some percent where one eigenvalue or pair leads; allocates nothing. NaN where J is not finite.
  double at(double t, const ConstVector& y) {
    if (J_.size() > 0) {
      jacobian_(t, y, J_);
      balance();
    } else {
      t_ = t;
      y_ = y;
      derivative_(t, y, f_);
    }
    for (Eigen::Index i = 0; i < x_.size(); ++i) x_[i] = (i % 2 == 0 ? 1.0 : -1.0) / static_cast<double>(i + 1);
    double logarithm = 0.0;  // of the growth over the last `counted` powers; an even number, for pairs ±λ
    for (int k = 0; k < powers; ++k) {
      multiply(x_, image_);
      const double before = std::sqrt(product(x_, x_)), after = std::sqrt(product(image_, image_));
      if (!(after > 0.0)) return after;  // 0, or NaN
      if (k >= powers - counted) logarithm += std::log(after / before);
      for (Eigen::Index i = 0; i < x_.size(); ++i) x_[i] = image_[i] / after;
    }
    return std::exp(logarithm / counted);
  }

  /// −Re λ / |λ| of the eigenvalues that led in at(): 1 and more for what is drawn to rest, 0 for what swings for ever, below it
  /// for what grows. From λ² = a λ + b, with the a and b that come nearest to J² x = a J x + b x for the last power x.
  [[gnu::cold]] double damping() {
    constexpr double collinear = 1e-6;
    multiply(x_, image_);
    multiply(image_, second_);
    const double square = product(image_, image_), part = product(x_, image_) / square, along = product(second_, image_) / square;
    for (Eigen::Index i = 0; i < x_.size(); ++i) x_[i] -= part * image_[i];
    const double rest = product(x_, x_);
    if (!(std::sqrt(rest) > collinear)) return along < 0.0 ? 1.0 : -1.0;  // one real eigenvalue
    const double b = product(second_, x_) / rest, a = along - b * part;
    return -a / (2 * std::sqrt(std::abs(b)));
  }

 private:
  static constexpr int powers = 20, counted = 12, sweeps = 2;
  static constexpr double displacement = 1e-7;  // of a state of size 1, for differences

  // out ← J x.
  void multiply(const Eigen::VectorXd& x, Eigen::VectorXd& out) {
    if (J_.size() > 0) {
      const Eigen::Index n = x.size();
      double* const __restrict sum = out.data();
      std::fill_n(sum, n, 0.0);
      Eigen::Index j = 0;
      for (; j + 4 <= n; j += 4) {  // four columns for each time that a sum is written
        const double *const a = J_.data() + j * n, *const b = a + n, *const c = b + n, *const d = c + n;
        const double xa = x[j], xb = x[j + 1], xc = x[j + 2], xd = x[j + 3];
        for (Eigen::Index i = 0; i < n; ++i) sum[i] += (a[i] * xa + b[i] * xb) + (c[i] * xc + d[i] * xd);
      }
      for (; j < n; ++j)
        for (Eigen::Index i = 0; i < n; ++i) sum[i] += J_(i, j) * x[j];
      return;
    }
    const double most = largest(y_), extent = most > 0.0 && most < 1e-3 ? most : 1.0 + most;
    const double size = largest(x), by = size > 0.0 ? displacement * extent / size : displacement;
    for (Eigen::Index i = 0; i < x.size(); ++i) moved_[i] = y_[i] + by * x[i];
    derivative_(t_, moved_, out);
    for (Eigen::Index i = 0; i < x.size(); ++i) out[i] = (out[i] - f_[i]) / by;
  }

  static double product(const Eigen::VectorXd& u, const Eigen::VectorXd& v) {
    double sum = 0.0, others = 0.0;  // one addition need not wait for the other
    Eigen::Index i = 0;
    for (; i + 2 <= u.size(); i += 2) {
      sum += u[i] * v[i];
      others += u[i + 1] * v[i + 1];
    }
    if (i < u.size()) sum += u[i] * v[i];
    return sum + others;
  }
  static double largest(const Eigen::VectorXd& u) {
    double most = 0.0;
    for (Eigen::Index i = 0; i < u.size(); ++i) most = std::max(most, std::abs(u[i]));
    return most;
  }

  // Gives each component the unit in which its row of J is as large as its column: metres beside metres per second are not comparable.
  void balance() {
    for (int sweep = 0; sweep < sweeps; ++sweep)
      for (Eigen::Index i = 0; i < J_.rows(); ++i) {
        double row = 0.0, column = 0.0;
        for (Eigen::Index j = 0; j < J_.rows(); ++j) {
          row += std::abs(J_(i, j));
          column += std::abs(J_(j, i));
        }
        const double own = std::abs(J_(i, i)), unit = std::sqrt((row - own) / (column - own));
        if (!(unit > 0.0 && std::isfinite(unit))) continue;
        for (Eigen::Index j = 0; j < J_.rows(); ++j) J_(j, i) *= unit;
        for (Eigen::Index j = 0; j < J_.rows(); ++j) J_(i, j) /= unit;
      }
  }

  Jacobian jacobian_;
  Derivative derivative_;
  Eigen::MatrixXd J_;
  Eigen::VectorXd x_, image_, second_;
  double t_ = 0.0;
  Eigen::VectorXd y_, moved_, f_;  // where there is no matrix
};

// What a method asks of it, compiled once in a program, or in the library (qdot::compiled).
template <class Number = double>
double radius_at(SpectralRadius& radius, double t, const Eigen::Ref<const Eigen::VectorXd>& y) {
  return radius.at(t, y);
}
template <class Number = double>
double damping_of(SpectralRadius& radius) {
  return radius.damping();
}

#ifdef QDOT_COMPILED
extern template double radius_at<double>(SpectralRadius&, double, const Eigen::Ref<const Eigen::VectorXd>&);
extern template double damping_of<double>(SpectralRadius&);
#endif

}  // namespace qdot::detail
