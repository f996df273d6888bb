#pragma once
// SPDX-License-Identifier: MIT
//
// The watchdog of a run, as its loop sees it.
//
// A watchdog (integrate/watch/any_watch.ipp) looks at T, V and effects besides the steps: which numbers they must have, what they ask of the time, whether M
// loses its inertia. It is compiled once, and so is the loop that holds it. If what is run has more components than the form that is watched, they stand
// behind those and are not looked at.

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "qdot/integrate/time_point.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/statistics.hpp"
#include "qdot/integrate/steps/polynomial.hpp"
#include "qdot/integrate/watch/time_formulas.hpp"
#include "qdot/integrate/watch/watched_form.hpp"

namespace qdot::detail {

/// Looks at the accepted states of one run.
class AnyWatch {
 public:
  virtual ~AnyWatch() = default;

  /// True when the state after a step of length h ought to be looked at.
  virtual bool is_due(double h) = 0;
  /// Begins at a state: the start, or behind a stop time or a change of the state, from where h is compared anew.
  ///
  /// @param another  motion of the same functors, which are believed to be as they were
  virtual void begin(double t, const Eigen::VectorXd& y, long steps, bool another) = 0;
  void begin(double t, const Eigen::VectorXd& y, long steps) { begin(t, y, steps, false); }

  virtual bool watches_time() const = 0;  // whether reach() limits steps
  /// How far towards `landing` a step from (t, y) may go (integrate/watch/time_watch.hpp).
  virtual double reach(double t, const Eigen::Ref<const Eigen::VectorXd>& y, double landing, bool switches_only) = 0;
  /// The first time that functors are to be shown of a step from the time t that reach() was asked about last.
  virtual double first_shown(double t) const = 0;
  /// Whether something in the functors switches by time, as they are now.
  virtual bool switches_by_time() const = 0;

  /// Whether steps from (t, y) may pass over a branch of the functors.
  virtual bool may_pass_branches(double t, const Eigen::VectorXd& y) = 0;
  /// What a step has passed (integrate/watch/branch_watch.hpp).
  virtual Passage passage(const Clock& clock, const PolynomialView& step, double from, double to, Course course) = 0;
  bool sees_branches = true;  // false: steps need not be asked about

  /// Looks at an accepted state; the trouble, if there is some.
  ///
  /// @param controlled  the method keeps a tolerance
  virtual std::optional<Failure> look(double t, const Eigen::VectorXd& y, long steps, bool controlled) = 0;
  /// Looks at T, V and M alone: at the start of a run there is no h to compare with.
  virtual std::optional<Failure> look_at_values_and_mass(double t, const Eigen::VectorXd& y) = 0;
  /// What the functors give now that they did not give before, asked where the method cannot go on; nothing if they are as they were.
  virtual std::optional<Failure> change(double t) = 0;
  /// Keeps what the next look compares with, at a state from which the motion goes on.
  virtual void remember(double t, const Eigen::VectorXd& y) = 0;
  /// What is to be said of a run that came to its end.
  virtual std::optional<Failure> verdict() const = 0;
  virtual double mass_rcond() const = 0;
  /// Writes what was seen.
  virtual void report(Statistics& statistics) const = 0;
};

/// A watchdog (integrate/watch/any_watch.ipp).
///
/// @tparam takes_time  T, V or effects take the time; otherwise no watch of it is compiled
template <bool takes_time>
std::unique_ptr<AnyWatch> watchdog(std::unique_ptr<const WatchedForm> form, const Options& options);

/// The watchdog of a form, whatever hides it.
template <class Form>
std::unique_ptr<AnyWatch> watch_of(const Form& form, const Options& options) {
  if constexpr (requires { form.watch(options); }) return form.watch(options);
  else if constexpr (requires { form.driven().watch(options); }) return form.driven().watch(options);
  else return watchdog<TimeOf<Form>::enters>(std::make_unique<WatchedFormOf<Form>>(form), options);
}

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template std::unique_ptr<AnyWatch> watchdog<false>(std::unique_ptr<const WatchedForm>, const Options&);
extern template std::unique_ptr<AnyWatch> watchdog<true>(std::unique_ptr<const WatchedForm>, const Options&);
}  // namespace qdot::detail
#else
#include "qdot/integrate/watch/any_watch.ipp"
#endif
