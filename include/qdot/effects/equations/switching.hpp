#pragma once
// SPDX-License-Identifier: MIT
//
// Which constraints are active: the phases of contacts and dry friction, and how they change.
//
// Between events the phases are fixed and the equations smooth. Each effect has a guard, a function that is
// ≥ 0 as long as its phase lasts:
//
//     contact apart    φ            closed    λ
//     friction slides  s v          sticks    F_s² − λ²
//
// When one falls through zero (the driver finds the moment) new phases are chosen in three steps.
//
//   1. Gaps. A closed contact whose gap something has moved (an action, a jump in time) opens if φ > 0, and is refused if φ < 0.
//   2. Velocities. Contacts at φ = 0 that approach take their blow (impact.hpp), other constraints included.
//   3. Accelerations. A contact at φ = 0 without velocity may be closed, friction at v = 0 may stick; which do is what phase_choice.hpp
//      says. A contact whose next hop would not rise above what the method can tell from zero has no velocity.
//
// Those that share a force, as a table's four legs do, have one guard together (shared_forces.hpp).

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/effects/contact.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "qdot/effects/equations/phase_choice.hpp"
#include "qdot/effects/projection.hpp"

namespace qdot {

namespace detail {

/// The switching effects of a scene.
template <class Sc>
class Switching {
  static constexpr int n = Sc::dof_at_compile_time;
  static constexpr int m = Sc::constraints_at_compile_time;
  static_assert(m != Dynamic, "qdot: beside contacts and dry friction every constraint must have a number of rows known at compile time");
  using Q = Vector<double, n>;
  using Z = EffectStates<Sc>;
  using Rows = Vector<double, m>;

  static constexpr double apart = 0.0, closed = 1.0, sticks = 0.0, undecided = 2.0;

 public:
  explicit Switching(const Sc& scene) : scene_(scene) {}

  static constexpr Eigen::Index count() { return static_cast<Eigen::Index>(Sc::phases_at_compile_time); }

  // out ← the guards.
  void guards(double t, const Q& q, const Q& qdot, const Z& z, Eigen::Ref<Eigen::VectorXd> out) const {
    bool active = false;
    visit([&](Eigen::Index, const auto& e, Eigen::Index zi, Eigen::Index) { active = active || e.is_active(z[zi]); });
    Rows lambda = Rows::Zero();
    SharedForces shared;
    if (active) shared = forces(t, q, qdot, z, lambda);
    visit([&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index row) {
      if (!shared.set.empty() && shared.set[at(k)] >= 0) {
        out[k] = shared.guard[at(k)];
      } else if constexpr (is_contact<decltype(e)>) {
        out[k] = e.is_active(z[zi]) ? lambda[row] : e.phi(q, t);
      } else if (e.is_active(z[zi])) {
        const double F_s = e.sticking_limit(q, qdot, t);
        out[k] = F_s * F_s - lambda[row] * lambda[row];
      } else {
        out[k] = z[zi] * e.velocity_constraint(q, qdot, t);
      }
    });
  }

  // out ← how large each guard may be and still be zero, for tolerances of y.
  void bands(double t, const Q& q, const Q& qdot, const Z& z, const Eigen::VectorXd& tolerance, Eigen::Ref<Eigen::VectorXd> out) const {
    const auto J = constraint_jacobian(scene_, q, qdot, t, everything(z));
    const Q f = rhs(scene_, q, qdot, t, z);
    visit([&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index row) {
      if constexpr (is_contact<decltype(e)>) {
        out[k] = e.is_active(z[zi]) ? force_scale(J, f, row) * negligible_force : weighted(J, row, tolerance.head(q.size()));
      } else {
        const double F_s = e.sticking_limit(q, qdot, t);
        out[k] = e.is_active(z[zi]) ? negligible_force * F_s * F_s : weighted(J, row, tolerance.segment(q.size(), q.size()));
      }
    });
  }

  // Whether something has moved the gap of a closed contact.
  bool gap_has_moved(double t, const Q& q, const Q& qdot, const Z& z, const Eigen::VectorXd& tolerance) const {
    const auto J = constraint_jacobian(scene_, q, qdot, t, everything(z));
    bool moved = false;
    visit([&](Eigen::Index, const auto& e, Eigen::Index zi, Eigen::Index row) {
      if constexpr (is_contact<decltype(e)>) moved = moved || (e.is_active(z[zi]) && std::abs(e.phi(q, t)) > play(J, q, tolerance, row));
    });
    return moved;
  }

  // The name of guard k if the run ends where it falls through zero, otherwise nothing.
  std::string ending(Eigen::Index wanted) const {
    std::string name;
    visit([&](Eigen::Index k, const auto& e, Eigen::Index, Eigen::Index) {
      if constexpr (is_contact<decltype(e)>)
        if (k == wanted && e.ends_run) name = e.name;
    });
    return name;
  }

  // Of the effect of guard k.
  std::string name(Eigen::Index wanted) const {
    std::string name;
    visit([&](Eigen::Index k, const auto& e, Eigen::Index, Eigen::Index) {
      if (k == wanted) name = e.name;
    });
    return name;
  }

  // Chooses velocities and phases as they follow from a state and the guards that fired; names what happened. What is left out and not active stays so.
  std::vector<std::string> settle(double t, Q& q, Q& qdot, Z& z, std::vector<bool> fired, const Eigen::VectorXd& tolerance,
                                  const std::vector<bool>* left_out = nullptr) const {
    std::vector<std::string> names;
    const Z before = z;
    std::vector<Switch> all(static_cast<std::size_t>(count()));
    const auto each_left_out = [&](const auto& use) {
      visit([&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index) {
        if (left_out != nullptr && (*left_out)[at(k)] && !e.is_active(before[zi])) use(at(k), zi);
      });
    };
    each_left_out([&](std::size_t k, Eigen::Index) { fired[k] = true; });  // its gap may be negative
    if constexpr (Sc::has_lasting_constraints) project(scene_, q, qdot, t, default_rank_cutoff, nothing(z));
    look(t, q, qdot, z, fired, tolerance, all);
    each_left_out([&](std::size_t k, Eigen::Index) { all[k].fired = all[k].touches = false, all[k].still = -1.0; });  // no candidate
    strike(t, q, qdot, all, names);
    come_to_rest(t, q, qdot, z, all);
    PhaseChoice<Sc>(scene_, t, q, qdot, before, all).choose(z);
    each_left_out([&](std::size_t, Eigen::Index zi) { z[zi] = before[zi]; });
    if (!is_free(scene_, z)) project(scene_, q, qdot, t, default_rank_cutoff, z);
    visit([&](Eigen::Index, const auto& e, Eigen::Index zi, Eigen::Index) {
      if (before[zi] == undecided || before[zi] == z[zi]) return;
      if constexpr (is_contact<decltype(e)>) {
        if (before[zi] == closed) names.push_back(e.events.opens);
        if (z[zi] == closed) names.push_back(e.events.rests);
      } else {
        names.push_back(e.name + (z[zi] == sticks ? " sticks" : before[zi] == sticks ? " slips" : " turns"));
      }
    });
    return names;
  }

 protected:
  template <class E>
  static constexpr bool is_contact = UnilateralEffect<std::remove_cvref_t<E>, n>;
  static std::size_t at(Eigen::Index k) { return static_cast<std::size_t>(k); }

  template <class Visit>
  void visit(Visit&& visitor) const {
    for_each_switching(scene_, visitor);
  }
  Z everything(const Z& z) const { return with_all_active(scene_, z); }
  Z nothing(const Z& z) const { return with_none_active(scene_, z); }

  // lambda ← the forces of what is active; which of it shares them.
  SharedForces forces(double t, const Q& q, const Q& qdot, const Z& z, Rows& lambda) const {
    const auto solution = constrained_acceleration(scene_, q, qdot, t, z);
    lambda = solution.lambda;
    if (solution.rank >= asked(scene_, z)) return {};
    return ActiveRows<Sc>(scene_, t, q, qdot, z, lambda).shared(count());
  }

  // How far a closed gap may be from zero.
  template <class J>
  static double play(const J& jacobian, const Q& q, const Eigen::VectorXd& tolerance, Eigen::Index row) {
    return 100 * weighted(jacobian, row, tolerance.head(q.size())) + 64 * std::numeric_limits<double>::epsilon() * weighted(jacobian, row, q.cwiseAbs());
  }

  void look(double t, const Q& q, const Q& qdot, const Z& z, const std::vector<bool>& fired, const Eigen::VectorXd& tolerance,
            std::vector<Switch>& all) const {
    const auto J = constraint_jacobian(scene_, q, qdot, t, everything(z));
    const Rows phi = constraint_residual(scene_, q, t, everything(z));
    const Rows u = constraint_velocity(scene_, q, qdot, t, everything(z));
    give_way(t, q, qdot, z, fired, all);
    visit([&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index row) {
      Switch& one = all[at(k)];
      one.contact = is_contact<decltype(e)>;
      one.u = u[row];
      one.still = 10 * weighted(J, row, tolerance.segment(q.size(), q.size()));
      const double resolved = weighted(J, row, tolerance.head(q.size()));
      one.lowest = 100 * resolved;
      if (!one.contact) {
        if (one.fired && !e.is_active(z[zi]) && stops_here(t, q, qdot, z, zi, row, one)) one.still = std::max(one.still, std::abs(one.u));
        return;
      }
      const bool active = e.is_active(z[zi]);
      const double rounding = (z[zi] == undecided ? negligible_force : 16 * std::numeric_limits<double>::epsilon()) * weighted(J, row, q.cwiseAbs());
      const double deepest = active ? play(J, q, tolerance, row) : 100 * resolved + rounding;
      one.touches = active ? phi[row] <= deepest : one.fired || phi[row] <= 10 * resolved + rounding;
      if ((active || !one.fired) && phi[row] < -deepest)
        throw ConstraintError(e.name, t, -phi[row],
                              active ? sentence({"the gap of a closed contact must not be moved below zero, but at t = ", t, " that of '", e.name, "' is ",
                                                 phi[row], "; leave it closed, or open"})
                                     : "the gap of a contact must not be negative, but at t = " + std::to_string(t) + " that of '" + e.name + "' is " +
                                           std::to_string(phi[row]) + "; start with the contact open or just closed");
    });
  }

  // Which effects have reached their limits: those that fired, and with the first of a set all of it.
  void give_way(double t, const Q& q, const Q& qdot, const Z& z, const std::vector<bool>& fired, std::vector<Switch>& all) const {
    bool active = false;
    visit([&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index) {
      all[at(k)].fired = fired[at(k)];
      active = active || (fired[at(k)] && e.is_active(z[zi]));
    });
    if (!active) return;
    Rows lambda = Rows::Zero();
    const SharedForces shared = forces(t, q, qdot, z, lambda);
    std::vector<bool> sets(all.size(), false);
    for (std::size_t k = 0; k < shared.set.size(); ++k)
      if (shared.set[k] >= 0 && fired[k]) sets[static_cast<std::size_t>(shared.set[k])] = true;
    visit([&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index row) {
      if (!e.is_active(z[zi])) return;
      Switch& one = all[at(k)];
      const bool shares = !shared.set.empty() && shared.set[at(k)] >= 0;
      if (shares) one.fired = sets[static_cast<std::size_t>(shared.set[at(k)])];
      if (one.fired && !is_contact<decltype(e)>) one.slips = shares ? -shared.stops[at(k)] : lambda[row] > 0 ? -1 : 1;
    });
  }

  // Whether what slid has come to v = 0: not yet past it, or by no more than integration and projection can tell. A v that jumps has not.
  bool stops_here(double t, const Q& q, const Q& qdot, const Z& z, Eigen::Index zi, Eigen::Index row, const Switch& one) const {
    if (std::abs(one.u) <= one.still || one.u * z[zi] > 0) return true;
    const Q a = acceleration(scene_, q, qdot, t, z);
    return one.u * one.u < 2 * std::abs(constraint_acceleration(scene_, q, qdot, a, t, everything(z))[row]) * one.lowest;
  }

  // The blows on all contacts that approach.
  void strike(double t, const Q& q, Q& qdot, std::vector<Switch>& all, std::vector<std::string>& names) const {
    if (std::none_of(all.begin(), all.end(), [](const Switch& one) { return one.touches && one.u < -one.still; })) return;
    const Z z = scene_.initial_states();
    const auto J = constraint_jacobian(scene_, q, qdot, t, everything(z));
    const ConstrainedFactors<n, m> factors(mass_matrix(scene_, q, qdot, t), constraint_jacobian(scene_, q, qdot, t, nothing(z)),
                                           default_rank_cutoff);
    std::vector<Eigen::Index> rows, effects;
    std::vector<ImpactLaw> laws;
    visit([&](Eigen::Index k, const auto& e, Eigen::Index, Eigen::Index row) {
      if constexpr (is_contact<decltype(e)>) {
        if (!all[static_cast<std::size_t>(k)].touches) return;
        rows.push_back(row);
        effects.push_back(k);
        laws.push_back(e.law);
      }
    });
    const auto size = static_cast<Eigen::Index>(rows.size());
    Eigen::MatrixXd W(q.size(), size), A(size, size);
    Eigen::VectorXd u(size), still(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      const Q direction = J.row(rows[static_cast<std::size_t>(i)]).transpose();
      const Q change = factors.solution(direction, Rows::Zero(), t, SceneNames<Sc>{scene_}).qddot;
      for (Eigen::Index k = 0; k < q.size(); ++k) W(k, i) = change[k];
      u[i] = all[static_cast<std::size_t>(effects[static_cast<std::size_t>(i)])].u;
      still[i] = all[static_cast<std::size_t>(effects[static_cast<std::size_t>(i)])].still;
    }
    for (Eigen::Index i = 0; i < size; ++i)
      for (Eigen::Index j = 0; j < size; ++j) A(i, j) = J.row(rows[static_cast<std::size_t>(i)]).dot(W.col(j));
    Eigen::VectorXd impulse;
    try {
      impulse = impulses(A, u, laws, still);
    } catch (const NoImpulse& of) {
      refuse_blow(t, effects[static_cast<std::size_t>(of.contact)]);
    }
    qdot += W * impulse;
    const Rows after = constraint_velocity(scene_, q, qdot, t, everything(z));
    visit([&](Eigen::Index k, const auto& e, Eigen::Index, Eigen::Index row) {
      Switch& one = all[static_cast<std::size_t>(k)];
      one.u = after[row];
      if constexpr (is_contact<decltype(e)>) {
        const auto found = std::find(effects.begin(), effects.end(), k);
        if (found == effects.end() || !(impulse[found - effects.begin()] > 0)) return;
        names.push_back(e.events.hits);
      }
    });
  }

  [[noreturn, gnu::cold]] void refuse_blow(double t, Eigen::Index contact) const {
    std::string name;
    visit([&](Eigen::Index k, const auto& e, Eigen::Index, Eigen::Index) {
      if (k == contact) name = e.name;
    });
    throw ConstraintError(name, t, 0.0,
                          sentence({"contacts must leave what they strike a way out, but at t = ", t, " no finite impulse keeps the gap of '", name,
                                    "' from closing, as other constraints close against it; give one of them room, or a spring"}));
  }

  // Contacts whose next hop is too low to be told from none have no velocity.
  void come_to_rest(double t, const Q& q, const Q& qdot, const Z& z, std::vector<Switch>& all) const {
    if (std::none_of(all.begin(), all.end(), [](const Switch& one) { return one.touches && one.u > one.still; })) return;
    Z trial = nothing(z);
    visit([&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index) {
      const Switch& one = all[static_cast<std::size_t>(k)];
      if (one.contact && e.is_active(z[zi]) && one.u <= one.still) trial[zi] = closed;
      if (!one.contact && std::abs(one.u) > one.still) trial[zi] = one.u > 0 ? 1.0 : -1.0;
    });
    const Rows rate = constraint_acceleration(scene_, q, qdot, Q(acceleration_without_lines(scene_, q, qdot, t, trial)), t, everything(z));
    visit([&](Eigen::Index k, const auto&, Eigen::Index, Eigen::Index row) {
      Switch& one = all[static_cast<std::size_t>(k)];
      if (!one.touches || one.u <= one.still || rate[row] >= 0) return;
      const double height = one.u * one.u / (-2 * rate[row]), flight = 2 * one.u / -rate[row];
      if (height < one.lowest || flight < 1e3 * std::numeric_limits<double>::epsilon() * std::abs(t)) one.u = 0.0;
    });
  }

  const Sc& scene_;
};

}  // namespace detail

}  // namespace qdot
