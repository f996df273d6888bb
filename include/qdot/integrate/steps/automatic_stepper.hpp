#pragma once
// SPDX-License-Identifier: MIT
//
// The stepper of the method that chooses among methods. By what it chooses is told in integrate/automatic.hpp.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/steps/spectral_radius.hpp"

namespace qdot {

/// What an AutomaticStepper chooses among.
struct AutomaticChoice {
  std::optional<AnyStepper> series;          ///< Taylor, to begin with
  AnyStepper smooth;                         ///< Dop853
  std::function<AnyStepper()> stiff;         ///< makes the stiff method's stepper, when it is wanted
  detail::SpectralRadius::Jacobian jacobian; ///< of the system
  detail::SpectralRadius::Derivative derivative;  ///< the system's own
  std::function<void()> renew = [] {};       ///< makes anew what the system of `jacobian` keeps of its functors; steppers look at theirs in reset()
  std::string reason;                        ///< why the first of them is the first
};

/// A Stepper that hands its steps to the method that suits the motion. Movable.
///
/// Allocates when it is made and when it first turns to the stiff method; not in steps.
template <class Number = double>
class BasicAutomaticStepper {
 public:
  static constexpr bool projects_itself = true;

  BasicAutomaticStepper(AutomaticChoice choice, Eigen::Index size);

  /// Starts (afresh) at (t, y), with the method for smooth motion.
  ///
  /// @throws as the stepper of the smooth method does
  void reset(const TimePoint& moment, const Eigen::Ref<const Eigen::VectorXd>& y);

  bool step(double t_limit);

  /// Takes other absolute tolerances, before a reset.
  void tolerate(const Eigen::VectorXd& atol) {
    atol_ = atol;
    for (std::optional<AnyStepper>& member : steppers_)
      if (member) member->tolerate(atol);
  }

  bool is_current() { return at(active_).is_current(); }  ///< whether what the active method has recorded still holds
  bool ends_at_branches() const noexcept { return steppers_[active_]->ends_at_branches(); }  ///< of the last step's method
  const Failure& failure() const { return steppers_[active_]->failure(); }
  double t() const noexcept { return steppers_[active_]->t(); }
  double t_previous() const noexcept { return steppers_[active_]->t_previous(); }
  TimePoint time_point() const noexcept { return steppers_[active_]->time_point(); }
  [[deprecated("qdot: say time_point()")]] TimePoint moment() const noexcept { return time_point(); }
  Eigen::Map<const Eigen::VectorXd> y() const noexcept { return steppers_[active_]->y(); }
  int order() const { return steppers_[active_]->order(); }
  const Statistics& statistics() const noexcept { return statistics_; }
  PolynomialView polynomial() { return at(active_).polynomial(); }
  void interpolate(double t, Eigen::Ref<Eigen::VectorXd> out) { at(active_).interpolate(t, out); }

 private:
  enum Member : std::size_t { series, smooth, stiff };

  static constexpr double smooth_limit = 4.0;       // of h ρ, above which accuracy is not what holds Dop853's step
  static constexpr double stable_step = 4.8;        // h ρ that Dop853 keeps up when stability holds it
  static constexpr int smooth_evaluations = 12;     // of a step of Dop853
  static constexpr double sparse_jacobian = 10.0;   // evaluations that one of many components is worth
  static constexpr Eigen::Index many_check = 100;   // steps between two looks of many components, which cost twenty evaluations
  static constexpr int stiff_check = 50;            // steps between two looks at whether the stiff method still pays
  // Undamped swings are not stiff, even at rest: BDF of order 3 and more lets them grow when h |λ| is 1 to 10. A pendulum on an undamped spring
  // of 1e6 N/m in Cartesian coordinates, 10 s at 1e-6: Taylor 1.7 ms with an error of 8e-6, BDF 36 ms with 4e-4 (docs/lab/steppers.md).
  static constexpr double least_damping = 0.1;      // −Re λ/|λ| of what is stiff and does not swing
  static constexpr double least_gain = 6.0;         // time per evaluation beside Dop853's, for which the stiff method is kept
  static constexpr double clear_gain = 60.0;        // that makes up for a change of mind
  static constexpr int first_patience = 2, longest_patience = 1 << 20;  // looks in a row that ask for the stiff method
  static constexpr long most_recordings = 1000;         // of branches, 64 of which are kept
  static constexpr std::size_t longest_reason = 1000;

  Member first() const noexcept { return steppers_[series] && !too_many_branches_ ? series : smooth; }
  AnyStepper& at(Member m) { return *steppers_[m]; }
  std::string name_of(Member m) const { return steppers_[m]->statistics().method; }

  void use(Member m) {
    if (m == active_) return;
    active_ = m;
    if (statistics_.method.find(name_of(m)) == std::string::npos) statistics_.method = detail::sentence({statistics_.method, ", ", name_of(m)});
  }

  // Adds to the reasons why the active method is active.
  void say(const std::string& why);

  // Begins with the smooth method, for what is found out of the functors only where the motion begins.
  void forgo_series(const std::string& source) {
    steppers_[series].reset(), active_ = smooth;
    statistics_.method = name_of(smooth);
    statistics_.method_reason = detail::sentence({name_of(smooth), ": ", source, " asks for a plain number, or is a constraint with a branch or a kink"});
  }

  // Lets another method go on from here; false, with nothing changed, if it cannot.
  bool turn_to(Member m);

  void begin_watch() {
    steps_ = warnings_ = 0;
    elapsed_mark_ = time_point().elapsed;
    cost_mark_ = cost();
  }

  // Right-hand sides that the active method has taken, Jacobians at their worth.
  double cost() const {
    const Statistics& s = steppers_[active_]->statistics();
    const auto size = static_cast<double>(statistics_.limited_by.size());
    return static_cast<double>(s.evaluations) + static_cast<double>(s.jacobians) * (size <= detail::SpectralRadius::most_components ? size : sparse_jacobian);
  }

  void watch();

  static std::string rounded(double x) {
    const double unit = std::pow(10.0, std::floor(std::log10(x)) - 1);
    return detail::text_of(std::round(x / unit) * unit);
  }

  void count();  // the sums over all members

  std::array<std::optional<AnyStepper>, 3> steppers_;
  std::function<AnyStepper()> make_stiff_;
  std::function<void()> renew_;
  detail::SpectralRadius radius_;
  Eigen::Index check_every_;
  Member active_ = smooth, next_ = smooth;  // next_: from the next step on
  std::string why_;                         // next_ and not active_
  long steps_ = 0;                          // of the active method since it began
  long checks_ = 0, recordings_mark_ = 0;   // Jacobians that none of the members asked for; recordings at the reset
  int warnings_ = 0;                        // looks in a row that spoke for the stiff method
  int patience_ = first_patience;           // how many of them it takes
  bool series_failed_ = false, stiff_failed_ = false, too_many_branches_ = false;  // the last for good
  double elapsed_mark_ = 0.0, cost_mark_ = 0.0;   // at the last check
  Eigen::VectorXd atol_;                          // where they are other than in the options
  Statistics statistics_;
};

template <class Number>
[[gnu::cold]] BasicAutomaticStepper<Number>::BasicAutomaticStepper(AutomaticChoice choice, Eigen::Index size)
    : steppers_{std::move(choice.series), std::move(choice.smooth), std::nullopt},
      make_stiff_(std::move(choice.stiff)),
      renew_(std::move(choice.renew)),
      radius_(size, std::move(choice.jacobian), std::move(choice.derivative)),
      check_every_(size <= detail::SpectralRadius::most_components ? std::max<Eigen::Index>(16, 4 * size) : many_check) {
  statistics_.limited_by.assign(static_cast<std::size_t>(size), 0);
  active_ = next_ = first();
  statistics_.method = name_of(active_);
  statistics_.method_reason = detail::sentence({name_of(active_), ": ", choice.reason});
  count();
}

template <class Number>
void BasicAutomaticStepper<Number>::reset(const TimePoint& moment, const Eigen::Ref<const Eigen::VectorXd>& y) {
  renew_();
  use(first());
  const auto go_on_smoothly = [&](const char* why) { use(smooth), at(smooth).reset(moment, y), say(why); };
  if (active_ == series) {
    try {
      at(series).reset(moment, y);
    } catch (const NonFinite&) {
      go_on_smoothly("the motion is not analytic at the start");
    } catch (const InvalidValue&) {  // Dop853 refuses what it cannot take itself
      go_on_smoothly("a component starts at 0 without an absolute tolerance");
    } catch (const NotAnalytic& error) {
      if (count(), statistics_.evaluations > 0) go_on_smoothly("T, V or an effect has a branch or a kink by now");
      else forgo_series(error.source()), at(smooth).reset(moment, y);
    }
  } else {
    at(smooth).reset(moment, y);
  }
  next_ = active_;
  patience_ = first_patience;
  series_failed_ = active_ != first();
  stiff_failed_ = false, recordings_mark_ = steppers_[series] ? at(series).recordings() : 0;
  begin_watch();
  count();
}

template <class Number>
bool BasicAutomaticStepper<Number>::step(double t_limit) {
  if (next_ != active_) turn_to(next_);
  bool accepted = at(active_).step(t_limit);
  const Outcome end = at(active_).failure().outcome;
  if (!accepted && active_ != smooth && end != Outcome::stopped_by_model && (end != Outcome::zeno || active_ != series)) {
    why_ = detail::sentence({"the method before ended with ", name(end)});
    (active_ == series ? series_failed_ : stiff_failed_) = true;
    if (turn_to(smooth)) {
      accepted = at(smooth).step(t_limit);
    }
  }
  count();
  if (accepted) watch();
  return accepted;
}

template <class Number>
[[gnu::cold]] void BasicAutomaticStepper<Number>::say(const std::string& why) {
  std::string& text = statistics_.method_reason;
  if (text.size() > longest_reason) return;
  text = detail::sentence({text, "; ", name_of(active_), " from t = ", t(), ": ", why});
  if (text.size() > longest_reason) text = detail::sentence({text, "; and so on"});
}

template <class Number>
bool BasicAutomaticStepper<Number>::turn_to(Member m) {
  const TimePoint from = time_point();
  const Eigen::VectorXd state = y();
  Failure ignored;
  next_ = active_;
  const bool ready = detail::attempted(ignored, [&] {
    if (m == stiff && !steppers_[stiff]) {
      steppers_[stiff] = make_stiff_();
      if (atol_.size() > 0) at(stiff).tolerate(atol_);
    }
    at(m).reset(from, state);
  });
  const std::string why = std::exchange(why_, {});
  if (!ready) return false;
  use(m);
  next_ = active_;
  say(why);
  begin_watch();
  return true;
}

// The Jacobian, and what a system keeps for it, is asked for after some steps only: to derive it takes as long as some hundred evaluations.
template <class Number>
void BasicAutomaticStepper<Number>::watch() {
  if (++steps_ % (active_ == stiff ? stiff_check : check_every_) != 0) return;
  if (active_ == series && at(series).recordings() - recordings_mark_ > most_recordings) {
    next_ = smooth, series_failed_ = too_many_branches_ = true, why_ = "there are more branches than series of them pay for";
    return;
  }
  double rho = 0.0;
  Failure ignored;
  ++checks_;
  if (!detail::attempted(ignored, [&] { rho = detail::radius_at(radius_, t(), y()); }) || !std::isfinite(rho)) return;
  const double elapsed = time_point().elapsed;
  const double advance = std::abs(elapsed - std::exchange(elapsed_mark_, elapsed));
  const double spent = cost() - std::exchange(cost_mark_, cost());
  if (active_ == stiff) {
    const double gain = smooth_evaluations * advance * rho / (stable_step * spent);
    if (gain > clear_gain) patience_ = first_patience;
    if (gain > least_gain || steps_ == stiff_check) return;  // the first steps are its start
    next_ = series_failed_ ? smooth : first();
    patience_ = std::min(4 * patience_, longest_patience);
    why_ = "an explicit method is as good here as the stiff one";
    return;
  }
  const double limit = active_ == smooth ? smooth_limit : 0.5 * (0.37 * order() + 1.4);
  const double h_rho = rho * advance / static_cast<double>(check_every_);
  warnings_ = h_rho > limit ? warnings_ + 1 : 0;
  if (warnings_ < patience_ || stiff_failed_) return;
  double damping = 0.0;
  if (!detail::attempted(ignored, [&] { damping = detail::damping_of(radius_); }) || !(damping >= least_damping)) return;
  next_ = stiff;
  why_ = detail::sentence({"stability, not accuracy, held the step of ", name_of(active_), " (h |lambda| = ", rounded(h_rho), ", |lambda| = ",
                           rounded(rho), ")"});
}

template <class Number>
void BasicAutomaticStepper<Number>::count() {
  Statistics& sum = statistics_;
  const Statistics& now = steppers_[active_]->statistics();
  sum.steps = sum.rejected_by_error_test = sum.rejected_by_corrector = sum.evaluations = sum.jacobians = sum.linear_setups = 0;
  sum.projections = 0;
  std::fill(sum.limited_by.begin(), sum.limited_by.end(), 0L);
  for (const std::optional<AnyStepper>& member : steppers_) {
    if (!member) continue;
    const Statistics& s = member->statistics();
    sum.steps += s.steps;
    sum.rejected_by_error_test += s.rejected_by_error_test;
    sum.rejected_by_corrector += s.rejected_by_corrector;
    sum.evaluations += s.evaluations;
    sum.jacobians += s.jacobians;
    sum.linear_setups += s.linear_setups;
    sum.projections += s.projections;
    sum.constraint_residual = std::max(sum.constraint_residual, s.constraint_residual);
    sum.constraint_velocity = std::max(sum.constraint_velocity, s.constraint_velocity);
    sum.smallest_step = std::min(sum.smallest_step, s.smallest_step);
    sum.highest_order = std::max(sum.highest_order, s.highest_order);
    for (std::size_t i = 0; i < sum.limited_by.size(); ++i) sum.limited_by[i] += s.limited_by[i];
  }
  sum.jacobians += checks_;
  if (sum.first_step == 0.0) sum.first_step = now.first_step;
  sum.last_step = now.last_step;
  sum.last_order = now.last_order;
  sum.evaluated_by = now.evaluated_by;
}

#ifdef QDOT_COMPILED
extern template class BasicAutomaticStepper<double>;
#endif

/// The one of simulate().
using AutomaticStepper = BasicAutomaticStepper<>;

}  // namespace qdot
