#pragma once
// SPDX-License-Identifier: MIT
//
// The phases of contacts and dry friction at a state that comes without them.
//
// They are those of step 3 of effects/equations/switching.hpp: the state is taken as it is, in front of all blows, for a blow would make
// another state of it. settled_states() has the phases behind them. Two things a state alone does not say, and where both answers fit, neither is given:
//
//     at its limit of sticking    friction with F_s > F_k may hold, or begin to slip with F_s − F_k
//     between steps of a run      a gap and a velocity of 1e-4 of their size may be none, for a dense output keeps constraints

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/effects/equations/switching.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/equations/ordinary_size.hpp"

namespace qdot {

namespace detail {

// What a state is known to where nothing says it.
template <class Q>
Eigen::VectorXd resolution_of(const Q& q, const Q& qdot) {
  Eigen::VectorXd tolerance(2 * q.size());
  const auto least = [](double most) { return most > 0.0 ? std::min(1e-12, 1e-9 * most) : 1e-12; };  // as runs have it
  tolerance << 1e-9 * q.cwiseAbs().array() + least(q.cwiseAbs().maxCoeff()), 1e-9 * qdot.cwiseAbs().array() + least(qdot.cwiseAbs().maxCoeff());
  return tolerance;
}

template <class Sc>
class PhasesAtState : Switching<Sc> {
  using Base = Switching<Sc>;

  static constexpr int n = Sc::dof_at_compile_time;
  using Q = Vector<double, n>;
  using Z = EffectStates<Sc>;
  using Rows = Vector<double, Sc::constraints_at_compile_time>;
  static constexpr double apart = static_cast<double>(ContactPhase::apart), closed = static_cast<double>(ContactPhase::closed);
  static constexpr double sticks = static_cast<double>(FrictionPhase::sticks);
  template <class E>
  static constexpr bool is_contact = Base::template is_contact<E>;

 public:
  using Base::Base;

  // The effects' own states with the phases that fit.
  //
  // @throws ConstraintError  when a gap is negative, or no phases fit together
  // @throws InvalidValue     when more than one choice fits
  Z chosen(double t, const Q& q, const Q& qdot) const {
    const Z before = this->scene_.initial_states();
    Z z = before;
    std::vector<Switch> all(static_cast<std::size_t>(this->count()));
    this->look(t, q, qdot, z, std::vector<bool>(all.size()), resolution_of(q, qdot), all);
    this->come_to_rest(t, q, qdot, z, all);
    PhaseChoice<Sc>(this->scene_, t, q, qdot, before, all).choose(z);
    require_one_choice(t, q, qdot, z, all);
    return z;
  }

  // Refuses a state at which phases are about to change: there equations have a slope on one side only.
  //
  // @throws InvalidValue  with what is at its edge
  void require_within(double t, const Q& q, const Q& qdot, const Z& z) const {
    std::vector<Switch> all(static_cast<std::size_t>(this->count()));
    this->look(t, q, qdot, z, std::vector<bool>(all.size()), resolution_of(q, qdot), all);
    const auto J = constraint_jacobian(this->scene_, q, qdot, t, this->everything(z));
    const auto now = rank_and_forces(t, q, qdot, z);
    const Q f = rhs(this->scene_, q, qdot, t, z);
    const auto edge = [t](std::initializer_list<Phrase> what) {
      throw_invalid_value({"small motions need phases of contacts and friction that last, but at t = ", {t, 6}, " ", sentence(what),
                           "; take a state off this edge, or put a constraint in place of what holds"});
    };
    this->visit([&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index row) {
      const Switch& one = all[static_cast<std::size_t>(k)];
      const double force = now.second[row];
      const auto shares = [&] {  // whether others hold with it, so that its part of a sum decides nothing
        Z other = z;
        other[zi] = is_contact<decltype(e)> ? apart : static_cast<double>(FrictionPhase::undecided);
        return rank_and_forces(t, q, qdot, other).first == now.first;
      };
      if constexpr (is_contact<decltype(e)>) {
        if (z[zi] == closed && !(force > negligible_force * force_scale(J, f, row)) && !shares())
          edge({"'", e.name, "' is closed with a reaction of ", {force + 0.0, 6}, ", and opens below 0"});
        if (z[zi] != closed && one.touches) edge({"'", e.name, "' touches without being pressed, with ", {one.u, 6}, " as the rate of its gap"});
      } else if (z[zi] == sticks) {
        const double F_s = e.sticking_limit(q, qdot, t);
        if (!(std::abs(force) < (1 - negligible_force) * F_s) && !shares())
          edge({"'", e.name, "' holds with ", {std::abs(force), 6}, " of at most ", {F_s, 6}});
      } else if (std::abs(one.u) <= one.still) {
        edge({"'", e.name, "' slides without a velocity"});
      }
    });
  }

  // Phases to begin a search for rest with: contacts without a gap are closed, friction without a velocity sticks.
  Z first_guess(double t, const Q& q, const Q& qdot) const {
    Z z = this->scene_.initial_states();
    const Z every = this->everything(z);
    const Rows phi = constraint_residual(this->scene_, q, t, every), u = constraint_velocity(this->scene_, q, qdot, t, every);
    this->visit([&](Eigen::Index, const auto& e, Eigen::Index zi, Eigen::Index row) {
      if constexpr (is_contact<decltype(e)>) z[zi] = phi[row] <= touching(q) ? closed : apart;
      else z[zi] = u[row] == 0.0 ? sticks : u[row] > 0.0 ? 1.0 : -1.0;
    });
    return z;
  }

  // z ← with the first phase changed that a state at rest contradicts; whether there was one.
  //
  // @throws InvalidValue  when friction would have to hold more than it can
  bool revise(double t, const Q& q, const Q& qdot, Z& z) const {
    const Z every = this->everything(z), before = z;
    const auto J = constraint_jacobian(this->scene_, q, qdot, t, every);
    const Rows phi = constraint_residual(this->scene_, q, t, every);
    const auto now = rank_and_forces(t, q, qdot, z);
    const Q f = rhs(this->scene_, q, qdot, t, z);
    this->visit([&](Eigen::Index, const auto& e, Eigen::Index zi, Eigen::Index row) {
      const double force = now.second[row];
      if ((z.array() != before.array()).any()) return;
      if constexpr (is_contact<decltype(e)>) {
        if (z[zi] == closed ? force < -negligible_force * force_scale(J, f, row) : phi[row] < -touching(q))
          z[zi] = z[zi] == closed ? apart : closed;
      } else if (z[zi] == sticks && std::abs(force) > (1 + negligible_force) * e.sticking_limit(q, qdot, t)) {
        throw_invalid_value({"friction must hold what rests, but near the start '", e.name, "' would have to hold ", {std::abs(force), 6}, " and holds up to ",
                             {e.sticking_limit(q, qdot, t), 6}, "; start where it can"});
      }
    });
    return (z.array() != before.array()).any();
  }

  // z ← with the open contact closed whose gap is narrowest; whether there was one.
  bool close_nearest(double t, const Q& q, Z& z) const {
    const Rows phi = constraint_residual(this->scene_, q, t, this->everything(z));
    Eigen::Index place = -1;
    double narrowest = 0.0;
    this->visit([&](Eigen::Index, const auto& e, Eigen::Index zi, Eigen::Index row) {
      if constexpr (is_contact<decltype(e)>)
        if (z[zi] != closed && (place < 0 || phi[row] < narrowest)) place = zi, narrowest = phi[row];
    });
    if (place >= 0) z[place] = closed;
    return place >= 0;
  }

 private:
  // A gap that is none.
  static double touching(const Q& q) { return 1e-9 * reach_of(q.cwiseAbs().maxCoeff()); }

  // Rank and λ in given phases.
  std::pair<Eigen::Index, Rows> rank_and_forces(double t, const Q& q, const Q& qdot, const Z& z) const {
    if (is_free(this->scene_, z)) return {0, Rows::Zero()};
    const auto solution = constrained_without_lines(this->scene_, q, qdot, t, z, default_rank_cutoff);
    return {solution.rank, solution.lambda};
  }

  // Refuses a state that fits another phase of an effect as well, with another acceleration.
  void require_one_choice(double t, const Q& q, const Q& qdot, const Z& z, const std::vector<Switch>& all) const {
    const Z every = this->everything(z);
    const auto J = constraint_jacobian(this->scene_, q, qdot, t, every);
    const Rows phi = constraint_residual(this->scene_, q, t, every), u = constraint_velocity(this->scene_, q, qdot, t, every);
    const auto now = rank_and_forces(t, q, qdot, z);
    this->visit([&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index row) {
      constexpr double blurred = 1e-4;
      const bool slow = std::abs(u[row]) <= blurred * weighted(J, row, qdot.cwiseAbs());
      const bool judged = all[static_cast<std::size_t>(k)].candidate;
      // The force that would keep its constraint, if that is none of others.
      const auto if_active = [&]() -> std::optional<double> {
        Z other = z;
        other[zi] = every[zi];
        const auto then = rank_and_forces(t, q, qdot, other);
        return then.first > now.first ? std::optional<double>(then.second[row]) : std::nullopt;
      };
      if constexpr (is_contact<decltype(e)>) {
        if (judged || z[zi] == closed || !slow || !(phi[row] <= blurred * weighted(J, row, q.cwiseAbs()))) return;
        if (const auto force = if_active(); force && *force > 0)
          refuse(t, {"'", e.name, "' may be open or closed, with a gap of ", {phi[row], 3}, " that changes at the rate ", {u[row], 3}});
      } else if (z[zi] != sticks) {
        if (judged || !slow) return;
        if (const auto force = if_active(); force && std::abs(*force) <= e.sticking_limit(q, qdot, t))
          refuse(t, {"'", e.name, "' may slide or stick, with a velocity of ", {u[row], 3}});
      } else if (const double F_s = e.sticking_limit(q, qdot, t); F_s > 0 && std::abs(now.second[row]) >= (1 - negligible_force) * F_s) {
        Z other = z;
        other[zi] = now.second[row] > 0 ? -1.0 : 1.0;
        const Q a = acceleration_without_lines(this->scene_, q, qdot, t, other);
        const double rate = constraint_acceleration(this->scene_, q, qdot, a, t, every)[row];
        if (other[zi] * rate > 1e3 * negligible_force * weighted(J, row, a.cwiseAbs()))
          refuse(t, {"'", e.name, "' may hold or begin to slip, at its limit of sticking of ", {F_s, 6}});
      }
    });
  }

  [[noreturn, gnu::cold]] static void refuse(double t, std::initializer_list<Phrase> what) {
    throw_invalid_value({"a state must decide the phases of contacts and friction, but at t = ", {t, 6}, " ", sentence(what),
                         "; pass the effects' own states z as well, which stand behind q and qdot in run.trajectory.y(t)"});
  }
};

}  // namespace detail

/// The effects' own states z at a state, with the phases of contacts and friction as they follow from it, behind a blow where there is one.
///
/// @throws ConstraintError  when a gap is negative, or no phases fit together
template <class Sys, class... Effects>
EffectStates<Scene<Sys, Effects...>> settled_states(const Scene<Sys, Effects...>& scene, const State<Sys::dof_at_compile_time>& state) {
  using Sc = Scene<Sys, Effects...>;
  EffectStates<Sc> z = scene.initial_states();
  if constexpr (Sc::has_phases) {
    auto q = state.q, qdot = state.qdot;
    const Eigen::VectorXd tolerance = detail::resolution_of(q, qdot);
    const detail::Switching<Sc> switching(scene);
    switching.settle(state.t, q, qdot, z, std::vector<bool>(static_cast<std::size_t>(switching.count())), tolerance);
  }
  return z;
}

}  // namespace qdot
