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
#include <vector>

#include "qdot/effects/equations/switching.hpp"

namespace qdot {

namespace detail {

// What a state is known to where nothing says it: of q, then of q̇.
template <class = void>
Eigen::VectorXd resolution_of(const Eigen::VectorXd& q, const Eigen::VectorXd& qdot);

// The effects' own states with the phases that fit.
//
// @throws ConstraintError  when a gap is negative, or no phases fit together
// @throws InvalidValue     when more than one choice fits
template <class = void>
[[gnu::cold]] Eigen::VectorXd phases_at_state(const SwitchingScene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot);

// Refuses a state at which phases are about to change: there equations have a slope on one side only.
//
// @throws InvalidValue  with what is at its edge
template <class = void>
[[gnu::cold]] void require_lasting_phases(const SwitchingScene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot,
                                          const Eigen::VectorXd& z);

// Phases to begin a search for rest with: contacts without a gap are closed, friction without a velocity sticks.
template <class = void>
[[gnu::cold]] Eigen::VectorXd phases_of_rest(const SwitchingScene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot);

// z ← with the first phase changed that a state at rest contradicts; whether there was one.
//
// @throws InvalidValue  when friction would have to hold more than it can
template <class = void>
[[gnu::cold]] bool revise_phases(const SwitchingScene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, Eigen::VectorXd& z);

// z ← with the open contact closed whose gap is narrowest; whether there was one.
template <class = void>
[[gnu::cold]] bool close_nearest(const SwitchingScene& scene, double t, const Eigen::VectorXd& q, Eigen::VectorXd& z);

// The phases of a scene of a given type, which it refers to.
template <class Sc>
class PhasesAtState {
  using Q = Vector<double, Sc::dof_at_compile_time>;
  using Z = EffectStates<Sc>;

 public:
  explicit PhasesAtState(const Sc& scene) : scene_(scene) {}

  Z chosen(double t, const Q& q, const Q& qdot) const { return phases_at_state(scene_, t, q, qdot); }
  void require_within(double t, const Q& q, const Q& qdot, const Z& z) const { require_lasting_phases(scene_, t, q, qdot, z); }
  Z first_guess(double t, const Q& q, const Q& qdot) const { return phases_of_rest(scene_, t, q, qdot); }
  bool revise(double t, const Q& q, const Q& qdot, Z& z) const {
    Eigen::VectorXd phases = z;
    const bool changed = revise_phases(scene_, t, q, qdot, phases);
    z = phases;
    return changed;
  }
  bool close_nearest(double t, const Q& q, Z& z) const {
    Eigen::VectorXd phases = z;
    const bool closed = detail::close_nearest(scene_, t, q, phases);
    z = phases;
    return closed;
  }

 private:
  SwitchingSceneOf<Sc> scene_;
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
    Eigen::VectorXd q = state.q, qdot = state.qdot, phases = z;
    detail::settle(detail::SwitchingSceneOf<Sc>(scene), state.t, q, qdot, phases, std::vector<bool>(Sc::phases_at_compile_time),
                   detail::resolution_of(q, qdot));
    z = phases;
  }
  return z;
}

}  // namespace qdot

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template Eigen::VectorXd resolution_of<void>(const Eigen::VectorXd&, const Eigen::VectorXd&);
extern template Eigen::VectorXd phases_at_state<void>(const SwitchingScene&, double, const Eigen::VectorXd&, const Eigen::VectorXd&);
extern template void require_lasting_phases<void>(const SwitchingScene&, double, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&);
extern template Eigen::VectorXd phases_of_rest<void>(const SwitchingScene&, double, const Eigen::VectorXd&, const Eigen::VectorXd&);
extern template bool revise_phases<void>(const SwitchingScene&, double, const Eigen::VectorXd&, const Eigen::VectorXd&, Eigen::VectorXd&);
extern template bool close_nearest<void>(const SwitchingScene&, double, const Eigen::VectorXd&, Eigen::VectorXd&);
}  // namespace qdot::detail
#else
#include "qdot/effects/equations/phases_at_state.ipp"
#endif
