#pragma once
// SPDX-License-Identifier: MIT
//
// Proofs that no zero of an event's function is hidden, for a function that is a formula.
//
// Between samples of g a bump of a millionth may lie. A g that takes every scalar can be called with intervals
// (ad/formula/interval.hpp). Over a part of a step, m − r ≤ s ≤ m + r, the polynomial and its rate are
//
//     y(s) ∈ y(m) ± (r |y′(m)| + ½ r² B + ρ) ,     y′(s) ∈ y′(m) ± (r B + ρ′) ,     B = Σ k (k − 1) |cₖ| Sᵏ⁻² ≥ |y″| ,
//
// where S is the largest |s| of the step, and ρ = 2ε Σ (k + 1) |cₖ| Sᵏ covers the rounding of Horner's rule. The formula gives
// bounds G of g, and with dual numbers of intervals D of dg/ds. t is a double: all between t at both ends. A part is decided by
//
//     0 ∉ G, no zero;      0 ∉ D, at most one zero, which the signs at the ends show;      0 ∉ g(m) + [−r, r] D, no zero.
//
// The third misses by r² only, and so decides extrema near zero. What is not decided is halved (event_finder.hpp). That does not
// end where g touches zero to within its rounding, or where a comparison in g has no one answer.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "qdot/ad/dual.hpp"
#include "qdot/ad/dual_math.hpp"
#include "qdot/ad/formula/interval.hpp"
#include "qdot/ad/forward/functor_result.hpp"
#include "qdot/ad/vector.hpp"
#include "qdot/integrate/event.hpp"
#include "qdot/integrate/time_point.hpp"
#include "qdot/integrate/steps/polynomial.hpp"

namespace qdot::detail {

// How many of q, q̇ and t a function takes, given in this scalar.
template <class G, class S, int n>
consteval int arguments_of() {
  using Q = Vector<S, n>;
  if (detail::is_callable<const G&, const Q&, const Q&, const S&>) return 3;
  if (detail::is_callable<const G&, const Q&, const Q&>) return 2;
  return detail::is_callable<const G&, const Q&> ? 1 : 0;
}

// A function of an event in any scalar.
template <class S, class G, int n>
S formula_value(const G& g, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) {
  constexpr int count = arguments_of<G, S, n>();
  static_assert(
      arguments_of<G, double, n>() > 0,
      "qdot: the function of an event that is a formula must be callable as g(q), g(q, qdot) or g(q, qdot, t); leave formula() out "
      "where it looks at the effects' own states");
  static_assert(count == arguments_of<G, double, n>(),
                "qdot: the function of an event that is a formula must take every scalar, the time included: write "
                "`[](const auto& q, const auto& qdot, const auto& t) { … }`, or leave formula() out");
  const auto call = [&] {
    if constexpr (count == 3) return result_of(g, q, qdot, t);
    else if constexpr (count == 2) return result_of(g, q, qdot);
    else return result_of(g, q);
  };
  static_assert(std::is_constructible_v<S, decltype(call())>,
                "qdot: the function of an event that is a formula must return the scalar that it was given; say `using std::sin;` and then "
                "`sin(q[0])`, or leave formula() out");
  return S(call());
}

/// Bounds of functions over parts of one step.
class StepBounds {
 public:
  /// Takes the step of which parts will be asked for, as far as [from, to] on the clock.
  void begin(const Clock& clock, const PolynomialView& step, Eigen::Index dof, double from, double to) {
    clock_ = clock;
    step_ = step;
    dof_ = dof;
    const Eigen::Index count = dof > 0 ? 2 * dof : step.size;
    const double S = std::max(std::abs(s(from)), std::abs(s(to)));
    rounding_.resize(count), rate_rounding_.resize(count), bend_.resize(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      double sum = 0.0, first = 0.0, half_second = 0.0;  // of |cₖ| sᵏ and its derivatives, at S
      for (int k = step.degree; k >= 0; --k) {
        half_second = half_second * S + first;
        first = first * S + sum;
        sum = sum * S + std::abs(step.coefficients[k * step.size + i]);
      }
      bend_[i] = 2.0 * half_second;
      rounding_[i] = two_roundings * (sum + S * first);
      rate_rounding_[i] = 2.0 * two_roundings * (first + S * half_second);
    }
    y_.resize(count), rate_.resize(count);
  }

  /// True where g − level has no zero between a and b, or g only rises or only falls there.
  ///
  /// @tparam n  number of coordinates
  /// @throws Undecided, and what g throws
  template <int n, class G>
  bool decide(const G& g, double level, double a, double b) {
    const double m = 0.5 * (s(a) + s(b)), r = 0.5 * std::abs(s(b) - s(a)) * (1.0 + two_roundings);
    evaluate(m);
    const auto spread = [&](Eigen::Index i) { return r * (std::abs(rate_[i]) + 0.5 * r * bend_[i]) + rounding_[i]; };
    const auto value = [&](Eigen::Index i) { return wide(y_[i], spread(i)); };
    const Interval t = Interval::between(clock_.t(a), clock_.t(b));
    if (!at<n, Interval>(g, value, t, level).contains(0.0)) return true;
    using D = Dual<Interval, 1>;
    const auto moving = [](const Interval& x, const Interval& rate) {
      D d(x);
      d.tangent[0] = rate;
      return d;
    };
    const Interval slope = at<n, D>(g, [&](Eigen::Index i) { return moving(value(i), wide(rate_[i], r * bend_[i] + rate_rounding_[i])); },
                                 moving(t, Interval(step_.scale)), level).tangent[0];
    if (!slope.contains(0.0)) return true;
    const double t_middle = clock_.t(0.5 * (a + b));
    const Interval middle = at<n, Interval>(g, [&](Eigen::Index i) { return wide(y_[i], rounding_[i]); },
                                         wide(t_middle, 0.5 * two_roundings * std::abs(t_middle)), level);
    return !(middle + Interval::between(-r, r) * slope).contains(0.0);
  }

 private:
  static constexpr double two_roundings = 2 * std::numeric_limits<double>::epsilon();

  double s(double tau) const { return (tau - step_.origin) / step_.scale; }
  static Interval wide(double x, double by) { return Interval::between(x - by, x + by); }

  // The polynomial and its derivative by s.
  void evaluate(double m) {
    for (Eigen::Index i = 0; i < y_.size(); ++i) {
      double y = 0.0, rate = 0.0;
      for (int k = step_.degree; k >= 0; --k) {
        rate = rate * m + y;
        y = y * m + step_.coefficients[k * step_.size + i];
      }
      y_[i] = y;
      rate_[i] = rate;
    }
  }

  // g − level where component i is entry(i).
  template <int n, class S, class G, class Entry>
  S at(const G& g, const Entry& entry, const S& t, double level) const {
    const Eigen::Index size = dof_ > 0 ? dof_ : y_.size(), second = dof_ > 0 ? dof_ : 0;
    Vector<S, n> q(size), qdot(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      q[i] = entry(i);
      qdot[i] = entry(second + i);
    }
    const S result = formula_value<S, G, n>(g, q, qdot, t);
    return level == 0.0 ? result : result - level;
  }

  Clock clock_;
  PolynomialView step_;
  Eigen::Index dof_ = 0;
  Eigen::VectorXd y_, rate_;                          // at the middle
  Eigen::VectorXd bend_, rounding_, rate_rounding_;  // B, ρ and ρ′ of the step
};

}  // namespace qdot::detail
