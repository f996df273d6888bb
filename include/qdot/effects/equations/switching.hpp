#pragma once
// SPDX-License-Identifier: MIT
//
// Which constraints are active: the phases of contacts and dry friction, and how they change.
//
// Between events the phases are fixed and the equations smooth. Each effect has a guard that is ≥ 0 as long as its phase lasts:
//
//     contact apart    φ            closed    λ
//     friction slides  s v          sticks    F_s² − |λ|²     in a plane plane_friction.hpp has that of sliding
//
// When one falls through zero (the driver finds the moment) new phases are chosen in three steps.
//
//   1. Gaps. A closed contact whose gap something has moved (an action, a jump in time) opens if φ > 0, and is refused if φ < 0.
//   2. Velocities. Contacts at φ = 0 that approach take their blow (impact.hpp), other constraints included.
//   3. Accelerations. A contact at φ = 0 without velocity may be closed, friction at v = 0 may stick (phase_choice.hpp). A contact
//      whose next hop would not rise above what the method can tell from zero has no velocity.
// Those that share a force, as a table's four legs do, have one guard together (shared_forces.hpp).

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <string>
#include <type_traits>
#include <vector>

#include "qdot/effects/equations/phase_choice.hpp"
#include "qdot/effects/equations/shared_forces.hpp"
#include "qdot/effects/equations/switching_scene.hpp"

namespace qdot::detail {

// By how much of F_k² the squared force that would hold a friction in a plane exceeds it: below zero what has just begun to slide slows down.
template <class Sc, class E>
double excess_in_plane(const Sc& scene, const E& e, double t, const Vector<double, Sc::dof_at_compile_time>& q,
                       const Vector<double, Sc::dof_at_compile_time>& qdot, const EffectStates<Sc>& z, Eigen::Index zi, Eigen::Index row) {
  EffectStates<Sc> held = z;
  held[zi] = PhaseNumber::sticks;
  const double F_k = e.sliding_limit(q, qdot, t);
  constexpr int rows = constraint_rows_of<E, Sc::dof_at_compile_time>();
  const auto solution = any_constrained_acceleration(scene, q, qdot, t, held, default_rank_cutoff);
  if (!(F_k > 0) || solution.rank < asked(scene, held)) return 1.0;  // others hold some of it as well
  return solution.lambda.template segment<rows>(row).squaredNorm() / (F_k * F_k) - 1.0;
}

// out ← the guards; are_smooth: for derivatives. A run asks for them at each step: in a scene of fixed size nothing here allocates, unless rows depend on
// each other.
template <class Sc>
void write_guards(const Sc& scene, double t, const Vector<double, Sc::dof_at_compile_time>& q, const Vector<double, Sc::dof_at_compile_time>& qdot,
                  const EffectStates<Sc>& z, Eigen::Ref<Eigen::VectorXd> out, bool are_smooth) {
  using Rows = Vector<double, Sc::constraints_at_compile_time>;
  Rows lambda = zeros<Rows>(Sc::constraints_at_compile_time);
  SharedForces shared;
  bool active = false;
  for_each_switching(scene, [&](Eigen::Index, const auto& e, Eigen::Index zi, Eigen::Index) { active = active || e.is_active(z[zi]); });
  if (active) {
    const auto solution = constrained_acceleration(scene, q, qdot, t, z);
    lambda = solution.lambda;
    if (solution.rank < asked(scene, z)) shared = shared_forces(SwitchingSceneOf<Sc>(scene), t, q, qdot, z, lambda);
  }
  for_each_switching(scene, [&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index row) {
    const auto place = static_cast<std::size_t>(k);
    if (!shared.set.empty() && shared.set[place] >= 0) {
      out[k] = shared.guard[place];
    } else if constexpr (UnilateralEffect<std::remove_cvref_t<decltype(e)>, Sc::dof_at_compile_time>) {
      out[k] = e.is_active(z[zi]) ? lambda[row] : e.phi(q, t);
    } else if (e.is_active(z[zi])) {
      constexpr int rows = constraint_rows_of<std::remove_cvref_t<decltype(e)>, Sc::dof_at_compile_time>();
      const double F_s = e.sticking_limit(q, qdot, t);
      out[k] = F_s * F_s - lambda.template segment<rows>(row).squaredNorm();
    } else if constexpr (states_of<std::remove_cvref_t<decltype(e)>>() > 1) {
      out[k] = e.guard(q, qdot, t, z.data() + zi, are_smooth);
      if (z[zi] == PhaseNumber::begins) out[k] = std::min(out[k], excess_in_plane(scene, e, t, q, qdot, z, zi, row));
    } else {
      out[k] = z[zi] * e.velocity_constraint(q, qdot, t);
    }
  });
}

// out ← how large each guard may be and still be zero, for tolerances of y.
template <class = void>
void write_guard_bands(const SwitchingScene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& z,
                       const Eigen::VectorXd& tolerance, Eigen::Ref<Eigen::VectorXd> out);

// Whether something has moved the gap of a closed contact.
template <class = void>
bool gap_has_moved(const SwitchingScene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& z,
                   const Eigen::VectorXd& tolerance);

// Chooses velocities and phases as they follow from a state and the guards that fired; names what happened. What is left out and not active stays so.
template <class = void>
[[gnu::cold]] std::vector<std::string> settle(const SwitchingScene& scene, double t, Eigen::VectorXd& q, Eigen::VectorXd& qdot, Eigen::VectorXd& z,
                                              std::vector<bool> fired, const Eigen::VectorXd& tolerance, const std::vector<bool>* left_out = nullptr);

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template void write_guard_bands<void>(const SwitchingScene&, double, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&,
                                             const Eigen::VectorXd&, Eigen::Ref<Eigen::VectorXd>);
extern template bool gap_has_moved<void>(const SwitchingScene&, double, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&,
                                         const Eigen::VectorXd&);
extern template std::vector<std::string> settle<void>(const SwitchingScene&, double, Eigen::VectorXd&, Eigen::VectorXd&, Eigen::VectorXd&,
                                                      std::vector<bool>, const Eigen::VectorXd&, const std::vector<bool>*);
}  // namespace qdot::detail
#else
#include "qdot/effects/equations/switching.ipp"
#endif
