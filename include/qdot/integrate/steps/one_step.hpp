#pragma once
// SPDX-License-Identifier: MIT
//
// What all one-step methods have in common.
//
// To a one-step method every step is a fresh start. So Runge–Kutta, Taylor and symplectic methods share the bookkeeping of
// stepper.hpp's contract and differ only in how they get from y(t) to y(t + h):
//
//     start     check t and y, and the sizes; forget the past.
//     limits    A step that would end beyond t_limit, or a hair's breadth before it, ends on it, and t is set to t_limit itself.
//               So rounding of t + h leaves no rest of 1e-16 s.
//     time      Steps count what has elapsed since the origin of reset() (time_point.hpp); t is for readers and functors.
//     trouble   NonFinite, MassMatrixError and RecoverableError mean that the step was too long for the model's domain. A shorter
//               one is tried, down to the floor of some rounding units (time_point.hpp). Then the last trouble names the outcome.
//               StopRequest ends the run at once; all other exceptions pass through.
//     account   steps, rejections, the component with the largest weighted error.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "qdot/error.hpp"
#include "qdot/integrate/time_point.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/statistics.hpp"
#include "qdot/integrate/steps/polynomial.hpp"
#include "qdot/integrate/steps/rates.hpp"
#include "qdot/integrate/steps/watch_budget.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot::detail {

template <class F>
struct mechanical_form : std::false_type {};
template <class Sys>
struct mechanical_form<FirstOrderForm<Sys>> : std::true_type {};

// How the model refused, from the exception that is being handled; one that says nothing about the model is passed on.
[[gnu::cold, gnu::noinline]] inline Failure refusal() {
  try {
    throw;
  } catch (const EndOfRun& end) {
    return end.failure;
  } catch (const NonFinite& error) {
    return {Outcome::non_finite, error.what()};
  } catch (const MassMatrixError& error) {
    return {Outcome::singular_mass_matrix, error.what()};
  } catch (const ConstraintError& error) {
    return {Outcome::constraint_failure, error.what()};
  } catch (const NotAnalytic& error) {
    return {Outcome::model_changed, error.what()};
  } catch (const RecoverableError& error) {
    return {Outcome::refused_by_model, error.what()};
  } catch (const StopRequest& request) {
    return {Outcome::stopped_by_model, request.what()};
  }
}

// Runs an evaluation in which the model may refuse; false, with the trouble noted, if it did.
template <class Evaluation>
bool attempted(Failure& failure, Evaluation&& evaluation) {
  try {
    evaluation();
    return true;
  } catch (...) {
    failure = refusal();
    return false;
  }
}

// The state and the bookkeeping of a one-step method for systems of N components.
template <int N>
class OneStep {
 public:
  static constexpr int size_at_compile_time = N;
  using Y = Vector<double, N>;

  const Failure& failure() const noexcept { return failure_; }
  double t() const noexcept { return t_; }
  double t_previous() const noexcept { return t_previous_; }
  TimePoint time_point() const noexcept { return clock_.time_point(elapsed_); }
  [[deprecated("qdot: say time_point()")]] TimePoint moment() const noexcept { return time_point(); }
  const Y& y() const noexcept { return y_; }
  int order() const noexcept { return order_; }
  const Statistics& statistics() const noexcept { return statistics_; }
  /// What is evaluated: a copy of the system.
  const Rates& rates() const noexcept { return *rates_; }

  /// Whether evaluations go by the branch that functors had at the last reset, beyond its guards as well. A caller that asks for it looks for the guards
  /// along each step, and resets where one is met.
  bool holds_branch() const noexcept { return holds_branch_; }
  /// Asks for that, from here on and at each reset; or no longer.
  void hold_branches(bool wish) {
    holds_branches_ = wish;
    holds_branch_ = wish && rates_->hold_branch(clock_.shown(clock_.within(elapsed_)), y_.data());
    if (!wish) rates_->leave_branch();
  }
  /// Lets the next reset hold the branch of another state, right ahead of its own, which lies on a guard.
  void hold_next_of(double t, const Eigen::VectorXd& y) { ahead_t_ = t, ahead_ = y; }

  /// Takes other absolute tolerances, before a reset.
  void tolerate(const Eigen::VectorXd& atol) { std::copy_n(atol.data(), size(), atol_.data()); }

 protected:
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();

  OneStep(std::unique_ptr<Rates> rates, std::string method, int order, const Options& options);

  std::string component_name(Eigen::Index i) const { return rates_->component_name(i); }

  Eigen::Index size() const noexcept {
    if constexpr (size_at_compile_time == Dynamic) {
      return y_.size();
    } else {
      return size_at_compile_time;
    }
  }

  // Takes over a start, and the model as it is now; the direction of time is open again.
  void begin(const TimePoint& at, const Eigen::Ref<const Eigen::VectorXd>& y);

  // Fixes the direction at the first step after begin().
  //
  // @throws InvalidValue  when t_limit is not ahead
  void head_for(double t_limit);

  // The way to t_limit, with its sign.
  double distance_left() const noexcept { return clock_.length() - elapsed_; }

  // ydot ← f(t, y), at t by what has elapsed.
  void evaluate(double elapsed, const Y& y, Y& ydot) {
    const double t = clock_.shown(clock_.within(elapsed));
    ++statistics_.evaluations;
    rates_->derivative(t, y.data(), ydot.data());
  }

  // Runs an evaluation that may find the step too long; false, with the trouble noted, if it did.
  template <class Evaluation>
  bool attempt(Evaluation&& evaluation) {
    return attempted(failure_, evaluation);
  }

  // The weight of component i in the error test, for the larger of two values.
  double weight(Eigen::Index i, double a, double b) const {
    return atol_[i] + rtol_ * std::max(std::abs(a), std::abs(b));
  }

  // The last step's polynomial, of variable (elapsed − origin)/scale.
  PolynomialView view(double origin, double scale, const double* coefficients, int degree) const {
    return {origin, scale, coefficients, y_.size(), degree, clock_.origin(), elapsed_before_, elapsed_};
  }

  // The smallest |h| that is tried.
  double smallest_step() const noexcept { return clock_.least_step(elapsed_); }

  // Notes an accepted step, whose largest weighted error was in component `worst` (−1: none was estimated).
  void accept(double elapsed_new, Eigen::Index worst);

  // Ends an attempt for good: the failure's sentence gets its place and numbers.
  bool give_up(double h);

  // The trouble of an error test that fails however small the step; put into words by give_up(), for most such steps are
  // followed by a shorter one that does not fail.
  void blame_error_test(Eigen::Index worst) noexcept {
    failure_.outcome = Outcome::step_too_small;
    blamed_ = worst;
  }

  // True when the budget is spent, with that as the failure; asked after an attempt that was rejected.
  bool over_budget() {
    if (!budget_.is_spent(statistics_.evaluations)) return false;
    failure_ = budget_.failure(statistics_.evaluations);
    return true;
  }

  std::unique_ptr<Rates> rates_;
  Budget budget_;
  Vector<double, size_at_compile_time> atol_;
  double rtol_, max_step_;
  int order_;
  Clock clock_;
  double elapsed_ = 0.0, elapsed_before_ = 0.0;  // at the end of the last step, and its beginning
  double t_ = 0.0, t_previous_ = 0.0;            // the same for readers
  double direction_ = 0.0;  // of time since begin(); 0 before the first step
  bool holds_branches_ = false, holds_branch_ = false;
  double ahead_t_ = 0.0;
  Eigen::VectorXd ahead_;  // a state whose branch the next reset holds; or empty
  Y y_;
  Statistics statistics_;
  Failure failure_;
  Eigen::Index blamed_ = -1;  // the component with the largest error in the last step that was rejected for it
};

template <int N>
OneStep<N>::OneStep(std::unique_ptr<Rates> rates, std::string method, int order, const Options& options)
    : rates_(std::move(rates)), budget_(options), rtol_(options.rtol), max_step_(options.max_step), order_(order) {
  const Eigen::Index n = rates_->size();
  if (n < 1) throw_invalid_value({"a system must have at least 1 component, but has ", n});
  require_valid(options, n);
  atol_.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) atol_[i] = positive_atol(options.atol[i]);
  y_.resize(n);
  std::fill_n(y_.data(), n, 0.0);
  statistics_.method = std::move(method);
  statistics_.limited_by.assign(static_cast<std::size_t>(n), 0);
}

template <int N>
void OneStep<N>::begin(const TimePoint& at, const Eigen::Ref<const Eigen::VectorXd>& y) {
  const double t = at.t();
  rates_->renew();
  if (y.size() != size())
    throw DimensionError("y", static_cast<long>(size()), static_cast<long>(y.size()),
                         "pass one entry for each component of the system");
  require_option(std::isfinite(t), "t", "must be finite", t, "start at a time that is a number");
  for (Eigen::Index i = 0; i < size(); ++i)
    if (!std::isfinite(y[i]))
      throw InvalidValue(sentence({component_name(i), " must be finite at the start, but is ", y[i], "; give it a number"}));
  t_ = t_previous_ = t;
  elapsed_ = elapsed_before_ = at.elapsed;
  clock_.start(at);
  std::copy_n(y.data(), size(), y_.data());
  direction_ = 0.0;
  if (holds_branches_)
    holds_branch_ = ahead_.size() > 0 ? rates_->hold_branch(ahead_t_, ahead_.data()) : rates_->hold_branch(clock_.shown(clock_.within(elapsed_)), y_.data());
  ahead_.resize(0);
}

template <int N>
void OneStep<N>::head_for(double t_limit) {
  clock_.head_for(t_limit);
  const double distance = distance_left();
  if (distance == 0.0 || !std::isfinite(distance) || distance * direction_ < 0)
    throw InvalidValue(sentence({"t_limit must lie ahead of t = ", t_, ", but is ", t_limit, "; call reset() to turn round"}));
  direction_ = distance > 0.0 ? 1.0 : -1.0;
}

template <int N>
void OneStep<N>::accept(double elapsed_new, Eigen::Index worst) {
  elapsed_before_ = std::exchange(elapsed_, elapsed_new);
  t_previous_ = std::exchange(t_, clock_.t(elapsed_));
  statistics_.last_step = std::abs(elapsed_ - elapsed_before_);
  if (statistics_.steps++ == 0) statistics_.first_step = statistics_.last_step;
  if (elapsed_ != clock_.length()) statistics_.smallest_step = std::min(statistics_.smallest_step, statistics_.last_step);
  statistics_.last_order = order_;
  statistics_.highest_order = std::max(statistics_.highest_order, order_);
  if (worst >= 0) ++statistics_.limited_by[static_cast<std::size_t>(worst)];
}

template <int N>
[[gnu::cold, gnu::noinline]] bool OneStep<N>::give_up(double h) {
  if (failure_.outcome == Outcome::step_too_small) {
    failure_.message = blamed_ < 0 ? sentence({"the local error stayed too large"})
                                   : sentence({"the local error stayed too large, most of all in ", component_name(blamed_), " = ", y_[blamed_]});
  }
  std::string text = sentence({statistics_.method, " took no step from t = ", t_, " with h down to ", std::abs(h), ": ", failure_.message});
  failure_.message = std::move(text);
  return false;
}

}  // namespace qdot::detail
