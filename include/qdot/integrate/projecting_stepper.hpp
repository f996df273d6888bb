#pragma once
// SPDX-License-Identifier: MIT
//
// A one-step method that keeps the constraints by itself.
//
// Steps of a method that knows nothing of constraints leave them by a little. Here the end of every step is put back (y ← the nearest state on the
// constraints), and the stepper is told so:
//
//     step → y ← projected y → correct(y).
//
// A projection that fails fails the step: t() and y() stay those of the last good one. A state that is not finite is left as it is, and the
// caller sees it.

#include <Eigen/Core>
#include <algorithm>
#include <concepts>
#include <memory>
#include <type_traits>
#include <utility>

#include "qdot/ad/vector.hpp"
#include "qdot/integrate/stepper.hpp"
#include "qdot/integrate/steps/one_step.hpp"
#include "qdot/integrate/steps/rates.hpp"

namespace qdot {

/// A Stepper whose steps end on the constraints of its system. Movable.
template <CorrectableStepper S>
class ProjectingStepper {
 public:
  static constexpr bool projects_itself = true;

  /// A stepper that has rates() is asked for its own system, whose derived lines then serve both; others get a copy of it here.
  explicit ProjectingStepper(S stepper, std::unique_ptr<detail::Rates> system = nullptr)
      : stepper_(std::move(stepper)), system_(std::move(system)), is_constrained_(rates().is_constrained()), statistics_(stepper_.statistics()) {
    y_.setZero(rates().size());
    projected_ = y_;
  }

  void reset(const TimePoint& at, const Eigen::Ref<const Eigen::VectorXd>& y) {
    detail::reset_at(stepper_, at, y);
    if (system_) system_->renew();
    time_point_ = detail::time_point_of(stepper_);
    t_ = t_previous_ = stepper_.t();
    y_ = y;
    count();
  }

  bool step(double t_limit) {
    const bool advanced = stepper_.step(t_limit);
    if (!advanced) failure_ = stepper_.failure();
    const bool accepted = advanced && detail::attempted(failure_, [&] {
      projected_ = stepper_.y();
      if (!is_constrained_ || !detail::all_finite(projected_.data(), projected_.size())) return;
      const ProjectionReport report = rates().project(stepper_.t(), projected_);
      stepper_.correct(projected_);
      ++projections_;
      residual_ = std::max(residual_, report.residual);
      velocity_residual_ = std::max(velocity_residual_, report.velocity_residual);
    });
    count();
    if (!accepted) return false;
    t_previous_ = std::exchange(t_, stepper_.t());
    time_point_ = detail::time_point_of(stepper_);
    y_.swap(projected_);
    return true;
  }

  /// Takes other absolute tolerances, before a reset.
  void tolerate(const Eigen::VectorXd& atol)
    requires requires(S& s) { s.tolerate(atol); }
  {
    stepper_.tolerate(atol);
  }

  const Failure& failure() const noexcept { return failure_; }
  double t() const noexcept { return t_; }
  double t_previous() const noexcept { return t_previous_; }
  TimePoint time_point() const noexcept { return time_point_; }
  [[deprecated("qdot: say time_point()")]] TimePoint moment() const noexcept { return time_point(); }
  const Eigen::VectorXd& y() const noexcept { return y_; }
  int order() const noexcept { return stepper_.order(); }
  bool has_fixed_step() const noexcept { return detail::has_fixed_step(stepper_); }
  const Statistics& statistics() const noexcept { return statistics_; }
  PolynomialView polynomial() {
    const PolynomialView step = stepper_.polynomial();
    statistics_.evaluations = stepper_.statistics().evaluations;
    return step;
  }
  /// Whether what the stepper has recorded of its system still holds.
  bool is_current()
    requires requires(S& s) { s.is_current(); }
  {
    return stepper_.is_current();
  }
  void interpolate(double t, Eigen::Ref<Eigen::VectorXd> out) { polynomial().evaluate(t, out); }

  /// The stepper itself, which has made the same steps.
  const S& inner() const noexcept { return stepper_; }

 private:
  static constexpr bool has_rates = requires(const S& s) { { s.rates() } -> std::convertible_to<const detail::Rates&>; };

  const detail::Rates& rates() const {
    if constexpr (has_rates) return stepper_.rates();
    else return *system_;
  }
  void count() {
    statistics_ = stepper_.statistics();
    statistics_.projections = projections_;
    statistics_.constraint_residual = residual_;
    statistics_.constraint_velocity = velocity_residual_;
  }

  S stepper_;
  std::unique_ptr<detail::Rates> system_;  // null where the stepper has its own
  bool is_constrained_;  // a system without its type may have nothing to keep
  Eigen::VectorXd y_, projected_;
  double t_ = 0.0, t_previous_ = 0.0;
  TimePoint time_point_;
  long projections_ = 0;
  double residual_ = 0.0, velocity_residual_ = 0.0;
  Failure failure_;
  Statistics statistics_;
};

namespace detail {

/// The method's stepper for a system, with the projection where the system needs it and the stepper leaves it to others.
template <FirstOrderSystem F, SteppingMethod<F> M>
auto projecting_stepper(const M& method, const F& system, const Options& options) {
  using S = std::remove_cvref_t<decltype(method.stepper(system, options))>;
  if constexpr (ProjectableSystem<F> && !SelfProjectingStepper<S>) {
    static_assert(CorrectableStepper<S>,
                  "qdot: this method cannot keep a system on its constraints; use Dop853, Dopri5, Gauss or CvodeBdf");
    if constexpr (requires(const S& s) { s.rates(); }) return ProjectingStepper<S>(method.stepper(system, options));
    else return ProjectingStepper<S>(method.stepper(system, options), rates_of(system));
  } else {
    return method.stepper(system, options);
  }
}

}  // namespace detail
}  // namespace qdot
