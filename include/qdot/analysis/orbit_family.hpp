#pragma once
// SPDX-License-Identifier: MIT
//
// Families of periodic orbits
// ===========================
//
//     const auto swings = continue_orbits(pendulum, State<1>{0.0, {0.3}, {0.0}}, 6.3, in_energy(0.9));
//     for (const auto& orbit : swings.orbits) … orbit.energy, orbit.period, orbit.stability
//
// Where energy is conserved there is an orbit for each energy, and a family is followed in the energy or the period. A
// limit cycle, or the answer to a drive, changes with a parameter p of p ↦ problem(scene, start, events). The curve of
// orbits is followed by its arc length (orbits/branch.hpp), so it may turn back. Special points are located on the way:
//     fold               the family turns back; a cycle that was stable is not any more
//     period doubling    a multiplier passes −1: an orbit of twice the period branches off
//     branch point       a multiplier passes 1, and it is no fold: another family crosses
//     torus              two complex multipliers leave the unit circle
// Two of one kind within one step cancel each other's signs and are missed: shorten longest_step where they lie dense.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "qdot/analysis/orbits/branch.hpp"
#include "qdot/analysis/periodic_orbit.hpp"
#include "qdot/error.hpp"

namespace qdot {

/// What an orbit of a family is.
enum class OrbitKind {
  start,            ///< where it was begun
  regular,          ///< nothing special
  fold,             ///< what the family is followed in turns back
  period_doubling,  ///< a multiplier passes −1
  branch,           ///< another family crosses
  torus,            ///< a pair of multipliers leaves the unit circle elsewhere
  end               ///< the last one
};

/// The kind's name, "period_doubling".
constexpr std::string_view name(OrbitKind kind) noexcept {
  return detail::name_in({"start", "regular", "fold", "period_doubling", "branch", "torus", "end"}, kind);
}

/// How a family ended.
enum class FamilyOutcome {
  reached,      ///< the value that was asked for
  returned,     ///< back at the value that it began with, behind a fold
  most_orbits,  ///< as many as were allowed
  lost,         ///< no orbit was found however short the step
  no_family     ///< the first orbit was not found, or stands alone, or belongs to a family of more dimensions
};

/// The outcome's name, "most_orbits".
constexpr std::string_view name(FamilyOutcome outcome) noexcept {
  return detail::name_in({"reached", "returned", "most_orbits", "lost", "no_family"}, outcome);
}

/// What a family is followed in, and how far. Made by in_energy(), in_period() and in_parameter().
struct FamilyIn {
  detail::BranchQuantity::What what;  ///< energy, period or parameter
  double until;                       ///< its value where the family ends
};
/// In Jacobi's energy h, from that of the start.
constexpr FamilyIn in_energy(double until) { return {detail::BranchQuantity::What::energy, until}; }
/// In the period.
constexpr FamilyIn in_period(double until) { return {detail::BranchQuantity::What::period, until}; }
/// In the parameter.
constexpr FamilyIn in_parameter(double until) { return {detail::BranchQuantity::What::parameter, until}; }

/// How a family is followed; lengths are in extents of the orbit.
struct FamilyOptions {
  OrbitOptions orbit{};       ///< how each orbit is sought
  double first_step = 0.05;   ///< along the family
  double longest_step = 0.3;  ///< along the family
  int most_orbits = 500;      ///< of the family
  double location = 1e-8;     ///< of special points, as a part of the step in which they lie
};

/// One orbit of a family.
struct FamilyOrbit : Orbit {
  OrbitKind kind = OrbitKind::regular;  ///< what is special about it
  double value = 0.0;                   ///< of what the family is followed in
};

/// Orbits in the order of their arc length, special points among them.
struct OrbitsOfFamily {
  FamilyOutcome outcome = FamilyOutcome::no_family;  ///< how it ended
  std::string message{};                             ///< with the numbers
  std::vector<FamilyOrbit> orbits{};                 ///< in the order of arc length
};

/// Orbits of a family, with their starts as states of the system.
template <int n>
struct OrbitFamily : OrbitsOfFamily {
  /// The start of orbit number i.
  State<n> start(std::size_t i) const {
    const Orbit& orbit = orbits.at(i);
    return State<n>{orbit.t, orbit.x.head(orbit.x.size() / 2), orbit.x.tail(orbit.x.size() / 2)};
  }
};

namespace detail {

template <class = void>  // compiled only where it is called
void require_family(const char* who, const Shooting& of, const Eigen::VectorXd& X, const FamilyIn& in, const FamilyOptions& options) {
  if (!std::isfinite(in.until)) throw_invalid_value({who, ": the value to reach must be finite, but is ", in.until, "; give it a number"});
  if (!(options.first_step > 0.0 && options.longest_step >= options.first_step && options.location > 0.0) || options.most_orbits < 2)
    throw_invalid_value({who, ": steps and the tolerance of special points must be positive, the longest step not below the first, and two orbits allowed; "
                              "leave them out for the defaults"});
  for (Eigen::Index i = 0; i < X.size(); ++i)
    if (!std::isfinite(X[i]))
      throw_invalid_value({who, ": the start must be finite, but ", i < of.size() ? of.name(i) : "the parameter", " is not; give every entry a number"});
}

// The orbit at a point of a branch; stability is not decided where it changes.
template <class = void>  // compiled only where it is called
FamilyOrbit family_orbit(const PointOfFamily& b, OrbitKind kind) {
  const ClosingEnd here{OrbitOutcome::found, b.equations.rows_of(b.point.X, b.point.shot), b.history, {}, {}};
  FamilyOrbit orbit{orbit_of(b.equations, here), kind, b.quantity};
  constexpr double apart = 1e-4;  // of multipliers that pass the circle here, as far as the place is known
  if (kind != OrbitKind::start && kind != OrbitKind::regular && kind != OrbitKind::end && std::abs(orbit.multipliers[0].value) <= 1.0 + apart)
    orbit.stability = OrbitStability::not_decided;
  return orbit;
}

constexpr bool sign_changes(double before, double after) { return (before < 0.0) != (after < 0.0); }

// The kinds of special points that lie between two points of a branch, with functions that change their signs there.
template <class = void>  // compiled only where it is called
std::vector<std::pair<OrbitKind, BranchTest>> special_between(const PointOfFamily& at, const PointOfFamily& next) {
  std::vector<std::pair<OrbitKind, BranchTest>> tests;
  const bool folds = sign_changes(at.slope, next.slope);
  if (folds) tests.push_back({OrbitKind::fold, [](const PointOfFamily& b) { return b.slope; }});
  if (sign_changes(at.at_minus_one, next.at_minus_one)) tests.push_back({OrbitKind::period_doubling, [](const PointOfFamily& b) { return b.at_minus_one; }});
  if (!folds && sign_changes(at.at_one, next.at_one)) tests.push_back({OrbitKind::branch, [](const PointOfFamily& b) { return b.at_one; }});
  if ((at.outside > 0) != (next.outside > 0)) tests.push_back({OrbitKind::torus, [](const PointOfFamily& b) { return b.outside > 0 ? 1.0 : -1.0; }});
  return tests;
}

// Follows a family from its first orbit; the equations determine all of an orbit but its place in the family.
template <class = void>  // compiled only where it is made
class FollowedFamily {
 public:
  FollowedFamily(const ClosingEquations& equations, const ClosingEnd& first, const FamilyIn& in, const FamilyOptions& options)
      : equations_(equations), quantity_{in.what}, in_(in), options_(options), nearby_{std::min(8, options.orbit.max_iterations), options.orbit.tolerance, 0.2},
        at_(point_of_family(equations, first, quantity_, nullptr)), begin_(at_.quantity), towards_(in.until >= begin_ ? 1.0 : -1.0),
        step_(options.first_step) {
    found_.orbits.push_back(family_orbit(at_, OrbitKind::start));
  }

  OrbitsOfFamily orbits() {
    constexpr double least_step = 1e-6;
    if (at_.open != 1) return no_family();
    if (at_.slope * towards_ < 0.0) {
      at_.tangent = -at_.tangent;
      at_.slope = -at_.slope;
    }
    while (static_cast<int>(found_.orbits.size()) < options_.most_orbits) {
      const ClosingEnd end = stepped(at_, step_, nearby_);
      std::optional<PointOfFamily> next = next_point(end);
      if (!next) {
        step_ *= 0.5;
        if (step_ < least_step * options_.first_step) return lost(end);
        continue;
      }
      turned_ = turned_ || sign_changes(at_.slope, next->slope);
      const std::optional<FamilyOutcome> outcome = outcome_at(*next);
      double length = step_;
      if (outcome) {
        next = located(at_, *next, step_, [&](const PointOfFamily& b) { return beyond(*outcome, b); }, quantity_, nearby_, options_.location);
        length = distance_of(*next);
      }
      add_special_points(*next, length);
      found_.orbits.push_back(family_orbit(*next, outcome ? OrbitKind::end : OrbitKind::regular));
      if (outcome) return ended(*outcome);
      at_ = std::move(*next);
      const auto iterations = static_cast<int>(end.history.size());
      if (iterations <= 4) step_ = std::min(1.5 * step_, options_.longest_step);
      if (iterations > 6) step_ *= 0.5;
    }
    return ended(FamilyOutcome::most_orbits);
  }

 private:
  // Where a step ended, if that is on the same branch: its tangent has not turned too far.
  std::optional<PointOfFamily> next_point(const ClosingEnd& end) const {
    constexpr double least_cosine = 0.9;
    if (end.outcome != OrbitOutcome::found) return {};
    PointOfFamily next = point_of_family(equations_, end, quantity_, &at_);
    const Eigen::VectorXd tangent = tangent_in_units_of(at_.equations, next);
    if (next.open == 1 && tangent.dot(at_.tangent) > least_cosine * tangent.norm()) return next;
    return {};
  }

  // How far a point lies beyond the end of the family with this outcome.
  double beyond(FamilyOutcome outcome, const PointOfFamily& b) const {
    return outcome == FamilyOutcome::reached ? towards_ * (b.quantity - in_.until) : towards_ * (begin_ - b.quantity);
  }
  std::optional<FamilyOutcome> outcome_at(const PointOfFamily& next) const {
    if (beyond(FamilyOutcome::reached, next) >= 0.0) return FamilyOutcome::reached;
    if (turned_ && beyond(FamilyOutcome::returned, next) >= 0.0) return FamilyOutcome::returned;
    return {};
  }
  double distance_of(const PointOfFamily& b) const { return at_.tangent.dot((b.point.X - at_.point.X).cwiseQuotient(at_.equations.scale)); }

  // In the order of their distances from the point before.
  void add_special_points(const PointOfFamily& next, double length) {
    std::vector<std::pair<double, FamilyOrbit>> special;
    for (const auto& [kind, test] : special_between(at_, next)) {
      const PointOfFamily point = located(at_, next, length, test, quantity_, nearby_, options_.location);
      special.push_back({distance_of(point), family_orbit(point, kind)});
    }
    std::stable_sort(special.begin(), special.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (auto& [distance, orbit] : special)
      if (!is_known(orbit)) found_.orbits.push_back(std::move(orbit));
  }

  // Where a family shrinks into an equilibrium its multipliers are known less and less, and pass 1 by rounding again and again: one point is told.
  bool is_known(const FamilyOrbit& orbit) const {
    constexpr double same_value = 1e-6, same_place = 1e-2;  // of the range, and of the first orbit
    const auto last = std::find_if(found_.orbits.rbegin(), found_.orbits.rend(), [&](const FamilyOrbit& each) { return each.kind == orbit.kind; });
    return last != found_.orbits.rend() && std::abs(last->value - orbit.value) <= same_value * std::abs(in_.until - begin_) &&
           (last->x - orbit.x).cwiseQuotient(equations_.scale.head(equations_.states())).cwiseAbs().maxCoeff() <= same_place;
  }

  OrbitsOfFamily no_family() {
    found_.message = at_.open == 0 ? sentence({equations_.who, ": orbits must come in families, but the first one stands alone in ", quantity_.name(),
                                               "; follow it in a parameter, or hold less"})
                                   : sentence({equations_.who, ": one thing must decide which orbit of the family it is, but ", at_.open,
                                               " do; hold the energy, the period or a coordinate, or make the parts of the system that do not meet one"});
    return found_;
  }
  OrbitsOfFamily ended(FamilyOutcome outcome) {
    found_.outcome = outcome;
    found_.message = sentence({name(outcome), ": ", static_cast<long>(found_.orbits.size()), " orbits, ", quantity_.name(), " from ",
                               {begin_, 8}, " to ", {found_.orbits.back().value, 8}});
    return found_;
  }
  OrbitsOfFamily lost(const ClosingEnd& end) {
    ended(FamilyOutcome::lost);
    found_.message += "; where it was lost, " +
                      (end.message.empty() ? sentence({"the motion did not close within ", nearby_.max_iterations, " iterations"}) : end.message);
    return found_;
  }

  const ClosingEquations& equations_;
  BranchQuantity quantity_;
  const FamilyIn& in_;
  const FamilyOptions& options_;
  ClosingSearch nearby_;  // a shorter step along the branch is cheaper than a long search
  PointOfFamily at_;      // where the family is known to
  double begin_, towards_;
  double step_;
  bool turned_ = false;
  OrbitsOfFamily found_;
};

// The first orbit is sought with everything held; then all is free but what `held` says.
template <class = void>  // compiled only where it is called
OrbitsOfFamily family_from(const Shooting& of, Eigen::VectorXd X, const FamilyIn& in, Held held, const FamilyOptions& options) {
  constexpr const char* who = "continue_orbits";
  using What = BranchQuantity::What;
  const Eigen::Index N = of.size();
  require_family(who, of, X, in, options);
  X.head(N) = of.settled(X.head(N), X[N + 1]);
  if (in.what == What::energy) held = hold_energy();
  if (in.what == What::period) held = hold_period();
  ClosingEquations equations = closing_equations(who, of, X, held, options.orbit);
  if (in.what == What::parameter && in.until != X[N + 1]) equations.scale[N + 1] = std::abs(in.until - X[N + 1]);
  const ClosingEnd first = closed(equations, X, ClosingSearch{options.orbit.max_iterations, options.orbit.tolerance});
  if (first.outcome != OrbitOutcome::found) {
    OrbitsOfFamily found;
    found.orbits.push_back({orbit_of(equations, first), OrbitKind::start, BranchQuantity{in.what}.value(equations, first.point.X)});
    found.message = found.orbits[0].message;
    return found;
  }
  if (in.what == What::energy) equations.energy.reset();
  if (in.what == What::period) equations.free.push_back(N);
  if (in.what == What::parameter) equations.free.push_back(N + 1);
  return FollowedFamily(equations, first, in, options).orbits();
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template OrbitsOfFamily family_from<void>(const Shooting&, Eigen::VectorXd, const FamilyIn&, Held, const FamilyOptions&);
#endif

}  // namespace detail

/// The orbits of a system or scene from the one near a start, in energy or period.
///
/// Some four runs with derivatives for each orbit, ten for each special point.
///
/// @param period  a guess of the first one; with in_period(), what it is
/// @return        the orbits in their order, special points among them, and how the family ended
/// @throws        as periodic_orbit_near(); InvalidValue for steps that are not positive
template <class System, int n, class Method = Dop853, class... Events>
OrbitFamily<n> continue_orbits(const System& system, const State<n>& start, double period, const FamilyIn& in, const FamilyOptions& options = {},
                               const EventList<Events...>& events = {}, const Method& method = {}) {
  if (in.what == detail::BranchQuantity::What::parameter)
    throw InvalidValue("continue_orbits: a family in a parameter needs p -> problem(system, start, events), but a system was given; pass such a function");
  using Family = detail::OneProblem<decltype(problem(system, start, events))>;
  const detail::ShootingOf<Family, Method, false> shooting({problem(system, start, events)}, start.t, 0.0, method, options.orbit.integration);
  return {detail::family_from(shooting, detail::closing_guess(system, start, period, 0.0), in, hold_nothing(), options)};
}

/// The orbits of a family of problems, in its parameter.
///
/// What depends on the parameter is differenced (analysis/sensitivity.hpp): six evaluations of f more for each of f.
///
/// @param family  p ↦ problem(system or scene, start, events(…)) for a Vector<double, 1>; its start is read at the first p only
/// @param p       where the family begins
/// @param held    hold_nothing() for a limit cycle, driven(), or what is held along the family where energy is conserved
/// @throws        as above, and as sensitivities() of a family
template <class Family, class Method = Dop853>
  requires std::is_invocable_v<const Family&, const Vector<double, 1>&>
auto continue_orbits(const Family& family, double p, double period, const FamilyIn& in, const Held& held, const FamilyOptions& options = {},
                     const Method& method = {}) {
  const auto first = family(Vector<double, 1>(p));
  constexpr int n = std::remove_cvref_t<decltype(first.system)>::dof_at_compile_time;
  const detail::ShootingOf<Family, Method, true> shooting(family, first.start.t, p, method, options.orbit.integration);
  return OrbitFamily<n>{detail::family_from(shooting, detail::closing_guess(first.system, first.start, period, p), in, held, options)};
}

// Old names, accepted until 0.4.

/// continue_orbits() by its old name.
template <class System, int n, class Method = Dop853, class... Events>
[[deprecated("qdot: say continue_orbits()")]]
OrbitFamily<n> family_of_orbits(const System& system, const State<n>& start, double period, const FamilyIn& in, const FamilyOptions& options = {},
                                const EventList<Events...>& events = {}, const Method& method = {}) {
  return continue_orbits(system, start, period, in, options, events, method);
}
template <class Family, class Method = Dop853>
  requires std::is_invocable_v<const Family&, const Vector<double, 1>&>
[[deprecated("qdot: say continue_orbits()")]]
auto family_of_orbits(const Family& family, double p, double period, const FamilyIn& in, const Held& held, const FamilyOptions& options = {},
                      const Method& method = {}) {
  return continue_orbits(family, p, period, in, held, options, method);
}

}  // namespace qdot
