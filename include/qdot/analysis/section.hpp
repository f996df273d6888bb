#pragma once
// SPDX-License-Identifier: MIT
//
// Poincaré's sections: where a motion passes through a surface
// ============================================================
//
//     const auto plane = event("x = 0", [](const auto& q) { return q[0]; }).rising();
//     const auto found = poincare_section(star, State<2>{0.0, {0.0, 0.1}, {0.4, 0.0}}, plane, 1000, 1e5, Dop853{}, {.rtol = 1e-12});
//
// The points where a motion passes a surface g(q, q̇, t) = 0 in one direction show what it is. With n = 2 and conserved
// energy they lie in a plane: a few dots are an orbit that closes, a closed curve a regular motion, an area chaos
// (Poincaré 1899; Hénon, Heiles, Astronomical Journal 69 (1964) 73). Of a drive of period T, every("flash", T) is the
// stroboscope. An angle that goes round passes its plane once in each turn, where sin((φ − φ₀)/2) changes its sign,
// alternately up and down. So take either direction, and let `where` tell which crossings count, φ̇ > 0. Crossings are
// found to rounding on the dense output; the event only looks (integrate/event.hpp), so steps stay the same. A section
// costs what the motion costs, and keeps nothing but the points. The map between them is in return_map.hpp.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "qdot/error.hpp"
#include "qdot/integrate/event.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/statistics.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot {

/// How a search for crossings ended.
enum class SectionOutcome {
  complete,       ///< all that were asked for
  t_end_reached,  ///< fewer, up to t_end
  run_ended,      ///< fewer, for the run ended otherwise: run_outcome says how
  no_derivative   ///< of a return map: the crossing was found, but what comes near it has no derivative there
};

/// The outcome's name as printed in JSON and compared in tests, e.g. "complete".
constexpr std::string_view name(SectionOutcome outcome) noexcept {
  return detail::name_in({"complete", "t_end_reached", "run_ended", "no_derivative"}, outcome);
}

/// Points at which a motion passes a surface, as far as it came.
///
/// @tparam n  number of coordinates, or Dynamic
template <int n = Dynamic>
struct PoincareSection {
  SectionOutcome outcome = SectionOutcome::complete;  ///< how it ended
  Outcome run_outcome = Outcome::completed;           ///< stopped_by_observer where all crossings were found
  std::string message;                                ///< how it ended, with the numbers and what to do
  std::vector<double> t;                              ///< of the crossings, in their order
  Eigen::MatrixXd y;                                  ///< a column for each, [q; q̇; …], in front of a jump if there is one
  double t_reached = 0.0;                             ///< as far as the run went
  Eigen::Index dof = 0;                               ///< number of coordinates
  Statistics statistics;                              ///< what the run cost

  /// Whether all crossings were found.
  bool complete() const noexcept { return outcome == SectionOutcome::complete; }
  /// How many were found.
  std::size_t size() const noexcept { return t.size(); }

  /// Crossing k as a time, coordinates and velocities.
  ///
  /// @throws InvalidValue  where there are not so many
  State<n> state(std::size_t k) const {
    if (k >= t.size() || dof < 1)
      detail::throw_invalid_value({"a crossing of a section must be one of the ", static_cast<long>(t.size()), " that were found, but number ",
                                   static_cast<long>(k), " (from 0) was asked for; look at its outcome"});
    const auto column = static_cast<Eigen::Index>(k);
    return State<n>{t[k], y.col(column).head(dof), y.col(column).segment(dof, dof)};
  }
};

namespace detail {

// What an observer makes of the crossings that it is shown.
template <class = void>  // compiled only where it is made
class CrossingRecord {
 public:
  using Value = std::function<double(double t, const Eigen::Ref<const Eigen::VectorXd>& y)>;
  using Settle = std::function<void(double t, Eigen::VectorXd& y)>;  // onto constraints, which dense output leaves; or none
  using Where = std::function<bool(double t, const Eigen::VectorXd& y)>;  // whether a crossing counts

  CrossingRecord(std::string name, long count, double t0, Value g, Settle settle, Where where)
      : name_(std::move(name)), t0_(t0), g_(std::move(g)), settle_(std::move(settle)), where_(std::move(where)) {
    if (count < 1) throw_invalid_value({"a section must have at least one crossing, but ", count, " were asked for; give a positive count"});
    wanted_ = static_cast<std::size_t>(count);
  }

  // False when there are enough.
  bool see(const StepView& step) {
    constexpr double at_once = 1e-9;  // of the first step: a start that lies on the surface to rounding
    if (start_ == 0.0) {
      start_ = at_once * std::abs(step.t() - t0_);
      note(g_(step.t_previous(), step.y_at(step.t_previous())));
    }
    note(g_(step.t(), step.y()));
    for (const RecordedEvent& event : step.events()) {
      if (event.name != name_ || (t_.empty() && std::abs(event.t - t0_) <= start_)) continue;
      Eigen::VectorXd y = event.t == step.t() ? Eigen::VectorXd(step.y()) : step.y_at(event.t);
      if (settle_) settle_(event.t, y);
      if (!where_(event.t, y)) continue;
      t_.push_back(event.t);
      numbers_.insert(numbers_.end(), y.data(), y.data() + y.size());
      if (t_.size() == wanted_) return false;
    }
    return true;
  }

  SectionOutcome outcome(Outcome of_run) const {
    if (t_.size() == wanted_) return SectionOutcome::complete;
    return of_run == Outcome::completed ? SectionOutcome::t_end_reached : SectionOutcome::run_ended;
  }

  std::string message(Outcome of_run, const std::string& of_run_in_words, double t, const Statistics& statistics) const {
    const SectionOutcome how = outcome(of_run);
    std::string text = sentence(
        {name(how), ": ", static_cast<long>(t_.size()), " of ", static_cast<long>(wanted_), " crossings of '", name_, "' up to t = ", t});
    if (how == SectionOutcome::t_end_reached && least_ <= most_)
      text += sentence({"; its function went from ", {least_, 4}, " to ", {most_, 4}, " at the ends of steps: ",
                        least_ < 0.0 && most_ > 0.0 ? "give a later t_end" : "give a surface that the motion crosses, or a later t_end"});
    if (how == SectionOutcome::run_ended) text += "; the run ended as " + of_run_in_words;
    if (statistics.unresolved_events > 0)
      text += sentence({"; crossings may have been missed, for the function could not be followed in ", statistics.unresolved_events, " steps, first at t = ",
                        statistics.unresolved_event_time, ": let it be smooth, or give a max_step"});
    return text;
  }

  std::vector<double> times() { return std::move(t_); }
  Eigen::MatrixXd states(Eigen::Index size) const {
    return Eigen::Map<const Eigen::MatrixXd>(numbers_.data(), size, static_cast<Eigen::Index>(numbers_.size()) / size);
  }

 private:
  void note(double g) {
    least_ = std::min(least_, g);
    most_ = std::max(most_, g);
  }

  std::string name_;
  std::size_t wanted_ = 0;
  double t0_, start_ = 0.0;
  Value g_;
  Settle settle_;
  Where where_;
  std::vector<double> t_, numbers_;
  double least_ = std::numeric_limits<double>::infinity(), most_ = -least_;
};

struct Everywhere {
  bool operator()(const auto&, const auto&) const { return true; }
};

}  // namespace detail

/// The first crossings of a surface by the motion of a system or scene.
///
/// One run, and memory for the points only. A start that lies on the surface is no crossing.
///
/// @param system   as simulate() has it
/// @param start    State{t, q, qdot}, or FirstOrderState{t, y}
/// @param surface  every(name, T), or event(name, g), with .rising() or .falling() for one direction: that of the run, forward or backward
/// @param count    how many crossings
/// @param t_end    where the run ends at the latest
/// @param method   any method that the system may be run with
/// @param options  of the run; no trajectory and no samples are kept
/// @param others   events(…) of the motion itself: impacts, ends
/// @param where    functor of (q, qdot) or (q, qdot, t): which crossings count; all, unless given
/// @return         the crossings that were found, and how it ended
/// @throws         as simulate(); InvalidValue for a count below 1, and for another event with the name of the surface
template <class System, class Start, class G, class Action, class Method = Dop853, class Where = detail::Everywhere, class... Events>
auto poincare_section(const System& system, const Start& start, const Event<G, Action>& surface, long count, double t_end, const Method& method = {},
                      Options options = {}, const EventList<Events...>& others = {}, const Where& where = {}) {
  static_assert(Event<G, Action>::records, "qdot: the surface of a section is an event that only looks: leave .stop() and .action() out");
  using Form = std::remove_cvref_t<decltype(first_order_form(system))>;
  constexpr int n = detail::dof_at_compile_time<Form>();
  const auto form = first_order_form(system);
  const Eigen::Index dof = detail::dof(form);
  std::apply([&](const auto&... each) {
    if (((each.name == surface.name) || ...))
      detail::throw_invalid_value({"the surface of a section must have a name of its own, but another event is called '", surface.name, "', too; rename one"});
  }, others.list);

  detail::CrossingRecord<>::Settle settle;
  if constexpr (ProjectableSystem<Form>) settle = [&form](double t, Eigen::VectorXd& y) { form.project(t, y); };
  detail::CrossingRecord<> record(surface.name, count, start.t,
                                [&](double t, const Eigen::Ref<const Eigen::VectorXd>& y) { return detail::event_value<n>(surface.g, t, y, dof); }, settle,
                                [&](double t, const Eigen::VectorXd& y) { return detail::event_value<n>(where, t, y, dof) != 0.0; });
  options.keep_trajectory = false;
  options.output_times.clear();
  const auto run = std::apply([&](const auto&... each) {
    return simulate(system, start, t_end, method, options, [&](const StepView& step) { return record.see(step); }, events(surface, each...));
  }, others.list);
  PoincareSection<n> found;
  found.outcome = record.outcome(run.outcome);
  found.run_outcome = run.outcome;
  found.message = record.message(run.outcome, run.message, run.t, run.statistics);
  found.y = record.states(form.size());
  found.t = record.times();
  found.t_reached = run.t;
  found.dof = dof;
  found.statistics = run.statistics;
  return found;
}

}  // namespace qdot
