#pragma once
// SPDX-License-Identifier: MIT
//
// Periodic orbits: motions that repeat
// ====================================
//
//     const auto swing = periodic_orbit_near(pendulum, State<1>{0.0, {1.3}, {0.0}}, 7.0, hold_coordinate(0));
//     swing.period, swing.multipliers, description(swing.stability)
//
// Newton's method improves a start and a guess of the period until the motion closes. Each step takes one run with its
// derivatives (analysis/sensitivity.hpp), exact through events, impacts and friction. What is held makes one orbit of a
// family:
//     hold_nothing()                                    of an autonomous system that loses and gains energy: a limit cycle
//     hold_energy(), hold_period(), hold_coordinate(i)  where Jacobi's energy h = q̇·p − L is conserved
//     driven()                                          where T, V or forces are periodic: the guess is that period, or a multiple
// An angle that goes round in each period has an advance of 2π. This is single shooting: an orbit closes with as many digits
// less as its largest multiplier has; not_closed is the outcome where that is not enough. See orbit.hpp, orbit_family.hpp.

#include <algorithm>
#include <cmath>
#include <optional>

#include "qdot/analysis/orbit.hpp"
#include "qdot/analysis/orbits/search.hpp"
#include "qdot/analysis/orbits/shooting.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/event.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/runge_kutta.hpp"

namespace qdot {

/// What is held while an orbit is sought. Made by hold_nothing(), hold_energy(), hold_period(), hold_coordinate() and driven().
struct Held {
  /// Kinds of what is held.
  enum class What {
    nothing,     ///< the nearest orbit of any energy and period
    energy,      ///< Jacobi's energy h
    period,      ///< T
    coordinate,  ///< one coordinate of the start
    drive        ///< T is that of what drives the system, or a multiple of it
  };
  What what = What::nothing;         ///< which of them
  std::optional<double> value = {};  ///< of the energy; that of the start, if it is not given
  Eigen::Index coordinate = 0;       ///< which one, from 0, where it is a coordinate
};

/// Nothing: of a limit cycle, which stands alone.
constexpr Held hold_nothing() { return {}; }
/// The energy h of the start.
constexpr Held hold_energy() { return {Held::What::energy}; }
/// The energy h, given.
constexpr Held hold_energy(double h) { return {Held::What::energy, h}; }
/// The period, which is that of the guess.
constexpr Held hold_period() { return {Held::What::period}; }
/// Coordinate i of the start, and its velocity, which is best zero: an amplitude.
constexpr Held hold_coordinate(Eigen::Index i) { return {Held::What::coordinate, std::nullopt, i}; }
/// The time and the period, which are those of a drive; nothing else.
constexpr Held driven() { return {Held::What::drive}; }

/// How a periodic orbit is sought.
struct OrbitOptions {
  int max_iterations = 30;                            ///< steps of Newton's method
  double tolerance = 1e-10;                           ///< of x(t₀ + T) − x(t₀), each component beside its extent on the orbit
  Eigen::VectorXd advance{};                          ///< of q in a period, n: 2π for an angle that goes round; empty for none
  Options integration{.rtol = 1e-13, .atol = AbsoluteTolerance::at_most(1e-14)};  ///< of the runs and their derivatives
};

namespace detail {

// The equations of an orbit whose guess is X = [x; T; p], in units of the guess's motion.
template <class = void>  // compiled only where it is called
ClosingEquations closing_equations(const char* who, const Shooting& of, const Eigen::VectorXd& X, const Held& held, const OrbitOptions& options) {
  const Eigen::Index N = of.size();
  const double period = ClosingEquations::period(X), p = ClosingEquations::parameter(X);
  const Eigen::VectorXd x = X.head(N);
  if (!(period > 0.0 && std::isfinite(period)))
    throw_invalid_value({who, ": the period must be positive and finite, but is ", period, "; give a guess of it"});
  if (!(options.tolerance > 0.0) || options.max_iterations < 1)
    throw_invalid_value({who, ": the tolerance must be positive and there must be iterations, but they are ", options.tolerance, " and ",
                         options.max_iterations, "; leave them out for 1e-10 and 30"});
  ClosingEquations equations{who, &of};
  equations.advance = Eigen::VectorXd::Zero(N);
  if (options.advance.size() > 0) {
    if (options.advance.size() != N / 2)
      throw DimensionError("advance", static_cast<long>(N / 2), static_cast<long>(options.advance.size()),
                           "give one number for each coordinate, or none at all");
    equations.advance.head(N / 2) = options.advance;
  }
  equations.driven = held.what == Held::What::drive;
  equations.phase_is_free = !equations.driven && held.what != Held::What::coordinate;
  if (!equations.driven) {
    const Eigen::VectorXd f = of.rate(x, p);
    for (const double later : {0.31 * period, 0.77 * period}) {
      const Eigen::VectorXd change = of.rate(x, p, later) - f;
      Eigen::Index i = 0;
      if (change.cwiseAbs().maxCoeff(&i) > 1e-9 * f.cwiseAbs().maxCoeff())
        throw_invalid_value({who, ": nothing may depend on the time, but the rate of ", of.name(i), " changes by ", {change[i], 6}, " within ", {later, 6},
                             "; pass driven(), with the period of what drives it"});
    }
  }
  const Shot first = of.shot(x, period, p, 1e3);
  equations.scale = Eigen::VectorXd::Ones(N + 2);
  if (first.extent.size() == N) {
    equations.measure(x, first.extent);
  }
  equations.scale[N] = period;
  equations.symmetries = symmetries_in({of, x, equations.scale.head(N), p, equations.driven ? period : 0.0});
  equations.scale[N + 1] = p != 0.0 && std::abs(p) < 1e-3 ? std::abs(p) : std::max(std::abs(p), 1.0);
  if (held.what == Held::What::coordinate && (held.coordinate < 0 || held.coordinate >= N / 2))
    throw_invalid_value({who, ": the coordinate that is held must be one of 0 to ", N / 2 - 1, ", but is ", held.coordinate, "; give its index"});
  for (Eigen::Index i = 0; i < N; ++i)
    if (held.what != Held::What::coordinate || (i != held.coordinate && i != held.coordinate + N / 2)) equations.free.push_back(i);
  if (!equations.driven && held.what != Held::What::period) equations.free.push_back(N);
  if (held.what == Held::What::energy) {
    const double h = of.energy(x, p);
    if (std::abs(of.energy(x, p, 0.31 * period) - h) > 1e-9 * std::abs(h))
      throw_invalid_value({who, ": an energy that is held must not depend on the time, but it does; pass driven() or hold_period()"});
    equations.energy = held.value ? *held.value : h;
    if (!std::isfinite(*equations.energy))
      throw_invalid_value({who, ": the energy that is held must be finite, but is ", *equations.energy, "; give it a number"});
  }
  return equations;
}

template <class = void>  // compiled only where it is called
Orbit orbit_near(const Shooting& of, Eigen::VectorXd X, const Held& held, const OrbitOptions& options) {
  constexpr const char* who = "periodic_orbit_near";
  for (Eigen::Index i = 0; i < of.size(); ++i)
    if (!std::isfinite(X[i])) throw_invalid_value({who, ": the start must be finite, but ", of.name(i), " is not; give every entry a number"});
  X.head(of.size()) = of.settled(X.head(of.size()), ClosingEquations::parameter(X));
  const ClosingEquations equations = closing_equations(who, of, X, held, options);
  return orbit_of(equations, closed(equations, X, {options.max_iterations, options.tolerance}));
}

// X = [x; T; p] of a start.
template <class System, class Start>
Eigen::VectorXd closing_guess(const System& system, const Start& start, double period, double p) {
  require_sizes(system, start.q, start.qdot);
  Eigen::VectorXd X(2 * system.dof() + 2);
  X << start.q, start.qdot, period, p;
  return X;
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template Orbit orbit_near<void>(const Shooting&, Eigen::VectorXd, const Held&, const OrbitOptions&);
#endif

}  // namespace detail

/// The periodic orbit near a start.
///
/// One run of size 2n (2n + 1) for each step of Newton's method, and two more.
///
/// @param system   a system or scene; contacts, ropes and dry friction included, but no controllers with states of their own
/// @param start    State{t, q, qdot}; put onto the constraints, if there are any, and not in the moment of an impact
/// @param period   a guess of it, or what it is (driven, hold_period)
/// @param method   Dop853{} or Dopri5{}
/// @return         the orbit and its stability, or how far the search came, with a named outcome
/// @throws         InvalidValue for a period that is not positive, a start that is not finite, and what depends on the time without driven()
/// @throws         as sensitivities() on the first run
template <class System, int n, class Method = Dop853, class... Events>
PeriodicOrbit<n> periodic_orbit_near(const System& system, const State<n>& start, double period, const Held& held, const OrbitOptions& options = {},
                                     const EventList<Events...>& events = {}, const Method& method = {}) {
  using Family = detail::OneProblem<decltype(problem(system, start, events))>;
  const detail::ShootingOf<Family, Method, false> shooting({problem(system, start, events)}, start.t, 0.0, method, options.integration);
  return {detail::orbit_near(shooting, detail::closing_guess(system, start, period, 0.0), held, options)};
}

}  // namespace qdot
