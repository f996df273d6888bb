#pragma once
// SPDX-License-Identifier: MIT
//
// Steps of equal length: what structure-preserving methods need besides their formula.
//
// A symplectic method follows, up to terms that are exponentially small in 1/h, the exact motion of a Hamiltonian
// H̃ = H + hᵖ H_p + …, so its energy error stays bounded for ever. But H̃ depends on h: if h changes with the state, the motion jumps
// between different H̃ and the bound is gone. So the way to t_limit is divided into equal steps, and step k ends at start + k h.
//
// Over N steps the rounding of y ← y + δ grows like √N ulps of y, more than the method's own error when that is small. TwoSum,
//
//     s = fl(y + δ),   z = fl(s − y),   lost = (y − (s − z)) + (δ − z),
//
// gives it exactly, and `lost` is added to the next δ: half as many digits again for y, for six additions.
//
// Dense output is the polynomial of degree 5 through q, q̇, q̈ (z, ż, z̈) at both ends, and its derivative for q̇; error ~ h⁶/46080 of
// the sixth derivative of q. (Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed., Springer 2006, IX, VIII.5)

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "qdot/integrate/steps/mechanical_rates.hpp"
#include "qdot/integrate/steps/one_step.hpp"

namespace qdot::detail {

/// sum ← sum + increment, with the rounding error carried along in `lost`.
template <class S>
[[gnu::always_inline]] inline void add_compensated(S& sum, S& lost, const std::type_identity_t<S>& increment) {
  const S delta = increment + lost;
  const S s = sum + delta;
  const S z = s - sum;
  lost = (sum - (s - z)) + (delta - z);
  sum = s;
}

// A one-step method with equal steps for a mechanical system, y = [q; q̇], or a scene, y = [q; q̇; z].
//
// N components of y, n coordinates, and so many states of effects.
template <int N, int n, int states>
class FixedStep : public OneStep<N> {
  using Base = OneStep<N>;

 public:
  static constexpr bool has_fixed_step() noexcept { return true; }

  /// The last step's polynomial of degree 5; evaluates the accelerations at its ends if they are not known yet.
  ///
  /// Where they cannot be evaluated, the cubic through q and q̇ at both ends.
  PolynomialView polynomial() {
    if (this->elapsed_ == this->elapsed_before_) return this->view(this->elapsed_, 1.0, this->y_.data(), 0);
    if (!dense_is_current_) make_dense();
    return this->view(this->elapsed_before_, this->elapsed_ - this->elapsed_before_, dense_.data(), 5);
  }

  /// out ← y(t) for t within the last step.
  void interpolate(double t, Eigen::Ref<Eigen::VectorXd> out) { polynomial().evaluate(t, out); }

 protected:
  using Mechanical = MechanicalRates<n, states>;

  FixedStep(std::unique_ptr<Mechanical> system, std::string method, int order, double longest, const Options& options)
      : Base(std::move(system), std::move(method), order, options), longest_(longest) {
    require_option(longest > 0 && std::isfinite(longest), "step", "must be positive and finite", longest,
                   "a fixed-step method needs one: try a thirtieth of the shortest period");
    this->statistics_.evaluated_by = "first derivatives of T and V by dual numbers";
    dense_.setZero(this->size(), 6);
    lost_ = y_old_ = ydot_ = ydot_old_ = dense_.col(0);
  }

  const Mechanical& mechanics() const noexcept { return static_cast<const Mechanical&>(this->rates()); }
  Eigen::Index dof() const {
    if constexpr (n == Dynamic) return mechanics().dof();
    else return n;
  }

  void begin(const TimePoint& at, const Eigen::Ref<const Eigen::VectorXd>& y) {
    Base::begin(at, y);
    this->evaluate(this->elapsed_, this->y_, ydot_);
    ydot_is_current_ = true;
    lost_.setZero();
    legs_limit_ = this->elapsed_;
    steps_of_leg_ = steps_done_ = 0;
    dense_is_current_ = false;
  }

  // What will have elapsed after the next step; divides the way to a new limit into equal steps.
  double next_end(double t_limit) {
    this->head_for(t_limit);
    if (this->clock_.length() != legs_limit_ || steps_done_ == steps_of_leg_) {
      legs_start_ = this->elapsed_;
      legs_limit_ = this->clock_.length();
      const double ratio = std::abs(this->distance_left()) / std::min(longest_, this->max_step_);
      steps_of_leg_ = std::max(1.0, std::ceil(ratio * (1 - 4 * this->epsilon) - 1e-9));
      steps_done_ = 0;
    }
    h_ = (legs_limit_ - legs_start_) / steps_of_leg_;
    return steps_done_ + 1 == steps_of_leg_ ? legs_limit_ : legs_start_ + (steps_done_ + 1) * h_;
  }

  void finish(double elapsed_new) {
    ++steps_done_;
    dense_is_current_ = false;
    this->accept(elapsed_new, -1);
  }

  double h_ = 0.0;  // with its sign
  typename Base::Y lost_, y_old_;
  bool ydot_is_current_ = false;  // ydot_ is the derivative at y_

 private:
  void make_dense() {
    const bool complete = this->attempt([&] {
      this->evaluate(this->elapsed_before_, y_old_, ydot_old_);
      this->evaluate(this->elapsed_, this->y_, ydot_);
    });
    const double h = this->elapsed_ - this->elapsed_before_;
    for (Eigen::Index i = 0; i < dof(); ++i) {
      const Eigen::Index v = i + dof();
      join(i, h, y_old_[v], this->y_[v], complete, ydot_old_[v], ydot_[v]);
      for (int k = 0; k < 5; ++k) dense_(v, k) = (k + 1) * dense_(i, k + 1) / h;
      dense_(v, 0) = y_old_[v];
      dense_(v, 5) = 0.0;
    }
    if constexpr (states != 0) {
      typename Mechanical::States before = ydot_old_.tail(this->size() - 2 * dof()), after = before;
      const bool curved = complete && this->attempt([&] {
        before = zddot(this->clock_.shown(this->elapsed_before_), y_old_, ydot_old_);
        after = zddot(this->clock_.shown(this->elapsed_), this->y_, ydot_);
      });
      for (Eigen::Index k = 0; k < before.size(); ++k) {
        const Eigen::Index i = 2 * dof() + k;
        join(i, h, ydot_old_[i], ydot_[i], curved, before[k], after[k]);
      }
    }
    dense_is_current_ = true;
  }

  // Row i: from slope `from` to slope `to`, with the curvatures too if they are known.
  void join(Eigen::Index i, double h, double from, double to, bool curved, double curvature_from, double curvature_to) {
    const double d = this->y_[i] - y_old_[i], v0 = h * from, v1 = h * to;
    double a0 = 6 * d - 4 * v0 - 2 * v1, a1 = -6 * d + 2 * v0 + 4 * v1;  // of the cubic
    if (curved) {
      a0 = h * h * curvature_from;
      a1 = h * h * curvature_to;
    }
    const double c[6] = {y_old_[i], v0, a0 / 2, 10 * d - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1,
                         -15 * d + 8 * v0 + 7 * v1 + 1.5 * a0 - a1, 6 * d - 3 * (v0 + v1) + 0.5 * (a1 - a0)};
    for (int k = 0; k < 6; ++k) dense_(i, k) = c[k];
  }

  typename Mechanical::States zddot(double t, const typename Base::Y& y, const typename Base::Y& ydot) const {
    using Vec = typename Mechanical::Vec;
    using States = typename Mechanical::States;
    const Eigen::Index k = dof(), count = this->size() - 2 * k;
    return mechanics().zddot(Vec(y.head(k)), Vec(y.segment(k, k)), Vec(ydot.segment(k, k)), States(y.tail(count)), States(ydot.tail(count)), t);
  }

  double longest_;
  double legs_start_ = 0.0, legs_limit_ = 0.0;  // as elapsed
  double steps_of_leg_ = 0.0, steps_done_ = 0.0;
  bool dense_is_current_ = false;
  typename Base::Y ydot_, ydot_old_;
  Matrix<double, Base::size_at_compile_time, 6> dense_;
};

// Of the system F, for a method that asks its functors.
template <FirstOrderSystem F>
class FixedStepOf : public FixedStep<F::size_at_compile_time, Mechanics<F>::n, Mechanics<F>::states> {
 protected:
  static constexpr int n = Mechanics<F>::n;

  FixedStepOf(const F& system, std::string method, int order, double longest, const Options& options)
      : FixedStep<F::size_at_compile_time, n, Mechanics<F>::states>(std::make_unique<MechanicalRatesOf<F>>(system), std::move(method), order, longest,
                                                                    options) {}

  const F& form() const noexcept { return static_cast<const MechanicalRatesOf<F>&>(this->rates()).form(); }
};

}  // namespace qdot::detail
