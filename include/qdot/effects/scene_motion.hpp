#pragma once
// SPDX-License-Identifier: MIT
//
// The motion of a scene: the same questions as for a system, with the effects in the answers.
//
//     M q̈ = rhs + Σ Q + Jᵀλ ,    J q̈ = γ
//
// rhs() of a scene holds every generalized force but those of constraints. reactions() names the constraint
// forces, and power() is what the non-conservative effects feed into the energy T + V:
//
//     dE/dt = q̇·(Σ Q + Jᵀλ)          for time-independent T, V and no terms in L of odd degree in q̇.
//
// A scene without effects calls the system's own functions and nothing else.
//
// z may be left out. The effects' own states then are at their initial values, and contacts and friction are in the phases that fit the state
// (effects/equations/phases_at_state.hpp). Where more than one fits, z must be given.

#include <algorithm>
#include <string>
#include <tuple>
#include <type_traits>

#include "qdot/effects/equations/constrained_motion.hpp"
#include "qdot/effects/equations/effect_forces.hpp"
#include "qdot/effects/equations/recordable_scene.hpp"
#include "qdot/effects/equations/scene_rows_of.hpp"
#include "qdot/effects/equations/shared_forces.hpp"
#include "qdot/effects/equations/sparse_geometry.hpp"
#include "qdot/effects/rows/columns.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"

namespace qdot {

/// ż of the effects' own states.
template <class Sys, class... Effects, class S, int n>
auto state_rates(const Scene<Sys, Effects...>& scene, const Vector<S, n>& q, const Vector<S, n>& qdot,
                 const Vector<S, Scene<Sys, Effects...>::states_at_compile_time>& z, const S& t) {
  Vector<S, Scene<Sys, Effects...>::states_at_compile_time> rate;
  Eigen::Index first = 0;
  detail::for_each(scene.effects(), [&](const auto& e) {
    using E = std::remove_cvref_t<decltype(e)>;
    if constexpr (StateEffect<E>) {
      constexpr int k = detail::states_of<E>();
      if constexpr (SwitchingEffect<E, n>) {
        std::fill_n(rate.data() + first, k, S(0.0));  // a phase changes at events only
      } else {
        static_assert(detail::require_numbers<decltype(e.state_rate(q, qdot, Vector<S, k>(), t))>());
        const Vector<S, k> part = e.state_rate(q, qdot, detail::vector_at<k>(z.data() + first, k), t);
        std::copy_n(part.data(), k, rate.data() + first);
      }
      first += k;
    }
  });
  return rate;
}

namespace detail {

template <class Sc>
class PhasesAtState;  // effects/equations/phases_at_state.hpp

// The effects' own states where none are given.
template <class Sc>
[[gnu::always_inline]] inline EffectStates<Sc> states_at(const Sc& scene, [[maybe_unused]] const Coordinates<Sc>& q,
                                                         [[maybe_unused]] const Coordinates<Sc>& qdot, [[maybe_unused]] double t) {
  require_sizes(scene, q, qdot);
  if constexpr (Sc::has_phases) {
    static_assert(requires { sizeof(PhasesAtState<Sc>); },
                  "qdot: contacts and dry friction choose their phases by <qdot/effects/scene_at_state.hpp>: include it, or pass z");
    return PhasesAtState<Sc>(scene).chosen(t, q, qdot);
  } else {
    return scene.initial_states();
  }
}

}  // namespace detail

/// Generalized forces of a scene without its constraints: the system's rhs and the effects' Q.
///
/// @param z  the effects' own states; where they are left out: as the head of this file says
/// @throws   without z and where contacts or friction switch: ConstraintError for a gap that is negative, InvalidValue where several phases fit
template <class Sys, class... Effects>
Coordinates<Sys> rhs(const Scene<Sys, Effects...>& scene, const Coordinates<Sys>& q, const Coordinates<Sys>& qdot, double t,
                     const EffectStates<Scene<Sys, Effects...>>& z) {
  Coordinates<Sys> f = rhs(scene.system(), q, qdot, t);
  if constexpr (Scene<Sys, Effects...>::has_forces) f += effect_forces(scene, q, qdot, z, t);
  return f;
}
template <class Sys, class... Effects>
[[gnu::always_inline]] inline Coordinates<Sys> rhs(const Scene<Sys, Effects...>& scene, const Coordinates<Sys>& q, const Coordinates<Sys>& qdot,
                                                   double t = 0.0) {
  return rhs(scene, q, qdot, t, detail::states_at(scene, q, qdot, t));
}

namespace detail {

// q̈ and λ where the shortest way is none: by the ways that hold for everything, and that name what is wrong.
template <class Sc>
[[gnu::noinline]] auto longer_constrained_acceleration(const Sc& scene, const Coordinates<Sc>& q, const Coordinates<Sc>& qdot, double t,
                                                       const EffectStates<Sc>& z, double cutoff) {
  ConstrainedSolution<Sc::dof_at_compile_time, Sc::constraints_at_compile_time> solution;
  if constexpr (may_be_sparse<Sc>) {
    Coordinates<Sc> Q;
    if constexpr (Sc::has_forces) Q = effect_forces(scene, q, qdot, z, t);
    if (sparse_solution(scene, q, qdot, t, z, Q, cutoff, solution)) return solution;
  }
  constexpr int n = Sc::dof_at_compile_time, m = Sc::constraints_at_compile_time;
  const auto take = [&](const auto& found) {
    solution.qddot = vector_at<n>(found.qddot.data(), found.qddot.size());
    solution.lambda = vector_at<m>(found.lambda.data(), found.lambda.size());
    solution.rank = found.rank;
    solution.smallest_pivot = found.smallest_pivot;
  };
  if constexpr (are_few<n, m>) take(general_constrained_acceleration<KnownSizes<n, m>>(SceneRowsOf<Sc>(scene), t, q, qdot, Column(z), cutoff));
  else take(general_constrained_acceleration<AnySizes>(SceneRowsOf<Sc>(scene), t, Column(q), Column(qdot), Column(z), cutoff));
  return solution;
}

// q̈ under forces, likewise.
template <class Sc>
[[gnu::noinline]] Coordinates<Sc> longer_scene_acceleration(const Sc& scene, const Coordinates<Sc>& q, const Coordinates<Sc>& qdot, double t,
                                                            const EffectStates<Sc>& z) {
  const auto blame = [&] { require_finite_forces(scene, q, qdot, t, z); };
  return acceleration_under_force(scene.system(), q, qdot, t, effect_forces(scene, q, qdot, z, t), blame);
}

// q̈ and λ by lines; false where there are none, and where rows depend on each other.
template <class Sc, int n, int m>
bool constrained_by_lines(const Sc& scene, const Coordinates<Sc>& q, const Coordinates<Sc>& qdot, double t, const EffectStates<Sc>& z,
                          ConstrainedSolution<n, m>& solution) {
  double ydot[2 * n + Sc::states_at_compile_time], active[m];
  FoundMultipliers found{active};
  if (!rates_by_lines(scene, q, qdot, t, z, ydot, &found)) return false;
  std::copy_n(ydot + n, n, solution.qddot.data());
  solution.smallest_pivot = found.smallest_pivot;
  solution.rank = 0;
  Eigen::Index row = 0, state = 0;
  for_each(scene.effects(), [&](const auto& e) {
    using E = std::remove_cvref_t<decltype(e)>;
    bool is_active = true;
    if constexpr (SwitchingEffect<E, n>) is_active = e.is_active(z[state]);
    for (int k = 0; k < constraint_rows_of<E, n>(); ++k) solution.lambda[row++] = is_active ? active[solution.rank++] : 0.0;
    state += states_of<E>();
  });
  return true;
}

// q̈ and λ, of rows that share forces some λ.
template <class Sc>
inline auto any_constrained_acceleration(const Sc& scene, const Coordinates<Sc>& q, const Coordinates<Sc>& qdot, double t, const EffectStates<Sc>& z,
                                         double cutoff) {
  constexpr int n = Sc::dof_at_compile_time, m = Sc::constraints_at_compile_time;
  if constexpr (has_rates<Sc> && m >= 1 && m <= n) {
    ConstrainedSolution<n, m> solution;
    if (cutoff == default_rank_cutoff && constrained_by_lines(scene, q, qdot, t, z, solution)) return solution;
  }
  return longer_constrained_acceleration(scene, q, qdot, t, z, cutoff);
}

// The solution with the shortest λ, where rows depend on each other.
template <class Sc, class Solution>
Solution with_shared_forces(const Sc& scene, const Coordinates<Sc>& q, const Coordinates<Sc>& qdot, double t, const EffectStates<Sc>& z, Solution solution) {
  if constexpr (Sc::has_phases && Sc::constraints_at_compile_time != Dynamic) {
    if (solution.rank < asked(scene, z)) {
      Eigen::VectorXd lambda = solution.lambda;
      split_forces(SceneRowsOf<Sc>(scene), t, q, qdot, z, lambda);
      solution.lambda = lambda;
    }
  }
  return solution;
}

// q̈ and λ in phases that are tried: no lines are derived for these.
template <class Sc>
auto constrained_without_lines(const Sc& scene, const Coordinates<Sc>& q, const Coordinates<Sc>& qdot, double t, const EffectStates<Sc>& z, double cutoff) {
  return with_shared_forces(scene, q, qdot, t, z, longer_constrained_acceleration(scene, q, qdot, t, z, cutoff));
}
template <class Sc>
Coordinates<Sc> acceleration_without_lines(const Sc& scene, const Coordinates<Sc>& q, const Coordinates<Sc>& qdot, double t, const EffectStates<Sc>& z) {
  if constexpr (Sc::has_constraints)
    if (!is_free(scene, z)) return longer_constrained_acceleration(scene, q, qdot, t, z, default_rank_cutoff).qddot;
  if constexpr (Sc::has_lasting_constraints) {
    return Coordinates<Sc>();
  } else if constexpr (Sc::has_forces) {
    return longer_scene_acceleration(scene, q, qdot, t, z);
  } else {
    return acceleration(scene.system(), q, qdot, t);
  }
}

}  // namespace detail

/// Accelerations and multipliers of a scene with constraints; where rows depend on each other, the shortest within the bounds of contacts and friction.
///
/// @param z        the effects' own states, as in rhs()
/// @param cutoff   relative size below which a row of J counts as dependent
/// @throws ConstraintError     when constraints contradict each other, or one returns another number of rows than before
/// @throws NonFinite           when a constraint, a force or an acceleration is not finite
/// @throws SingularMassMatrix  when a motion has neither inertia nor a constraint
template <class Sys, class... Effects>
inline auto constrained_acceleration(const Scene<Sys, Effects...>& scene, const Coordinates<Sys>& q, const Coordinates<Sys>& qdot,
                                     double t, const EffectStates<Scene<Sys, Effects...>>& z, double cutoff = default_rank_cutoff) {
  using Sc = Scene<Sys, Effects...>;
  static_assert(Sc::has_constraints, "qdot: multipliers need a scene with constraints");
  return detail::with_shared_forces(scene, q, qdot, t, z, detail::any_constrained_acceleration<Sc>(scene, q, qdot, t, z, cutoff));
}

template <class Sys, class... Effects>
[[gnu::always_inline]] inline auto constrained_acceleration(const Scene<Sys, Effects...>& scene, const Coordinates<Sys>& q,
                                                            const Coordinates<Sys>& qdot, double t = 0.0) {
  return constrained_acceleration(scene, q, qdot, t, detail::states_at(scene, q, qdot, t));
}

/// Accelerations q̈ of a scene at a state, constraints and effects included.
///
/// @param z  the effects' own states, as in rhs()
/// @throws as acceleration(system, …), constrained_acceleration() and rhs()
template <class Sys, class... Effects>
Coordinates<Sys> acceleration(const Scene<Sys, Effects...>& scene, const Coordinates<Sys>& q, const Coordinates<Sys>& qdot,
                              double t, const EffectStates<Scene<Sys, Effects...>>& z) {
  using Sc = Scene<Sys, Effects...>;
  if constexpr (detail::has_rates<Sc>) {
    constexpr int n = Sys::dof_at_compile_time;
    double ydot[2 * n + Sc::states_at_compile_time];
    if (detail::rates_by_lines(scene, q, qdot, t, z, ydot)) return Eigen::Map<const Coordinates<Sys>>(ydot + n);
  }
  return detail::acceleration_without_lines(scene, q, qdot, t, z);
}

template <class Sys, class... Effects>
[[gnu::always_inline]] inline Coordinates<Sys> acceleration(const Scene<Sys, Effects...>& scene, const Coordinates<Sys>& q, const Coordinates<Sys>& qdot,
                                                            double t = 0.0) {
  return acceleration(scene, q, qdot, t, detail::states_at(scene, q, qdot, t));
}

/// Power of a system: zero, for it has no effects.
template <class E, int n, Inertia inertia>
double power(const System<E, n, inertia>& system, const std::type_identity_t<Vector<double, n>>& q,
             const std::type_identity_t<Vector<double, n>>& qdot, double = 0.0) {
  detail::require_sizes(system, q, qdot);
  return 0.0;
}
/// Reactions of a system: zero, n, for it has no constraints.
template <class E, int n, Inertia inertia>
Vector<double, n> reactions(const System<E, n, inertia>& system, const std::type_identity_t<Vector<double, n>>& q,
                            const std::type_identity_t<Vector<double, n>>& qdot, double = 0.0) {
  detail::require_sizes(system, q, qdot);
  return detail::zeros<Vector<double, n>>(system.dof());
}

/// Generalized reaction forces Jᵀλ of the constraints on the system, n; zero where there are none.
template <class Sys, class... Effects>
Coordinates<Sys> reactions(const Scene<Sys, Effects...>& scene, const Coordinates<Sys>& q, const Coordinates<Sys>& qdot, double t,
                           const EffectStates<Scene<Sys, Effects...>>& z) {
  if constexpr (Scene<Sys, Effects...>::has_constraints)
    return constraint_jacobian(scene, q, qdot, t, z).transpose() * constrained_acceleration(scene, q, qdot, t, z).lambda;
  else return reactions(scene.system(), q, qdot, t);
}
template <class Sys, class... Effects>
Coordinates<Sys> reactions(const Scene<Sys, Effects...>& scene, const Coordinates<Sys>& q, const Coordinates<Sys>& qdot, double t = 0.0) {
  return reactions(scene, q, qdot, t, detail::states_at(scene, q, qdot, t));
}

/// Power of the non-conservative effects and constraints: q̇·(ΣQ + Jᵀλ).
template <class Sys, class... Effects>
double power(const Scene<Sys, Effects...>& scene, const Coordinates<Sys>& q, const Coordinates<Sys>& qdot, double t,
             const EffectStates<Scene<Sys, Effects...>>& z) {
  using Sc = Scene<Sys, Effects...>;
  double p = 0.0;
  if constexpr (Sc::has_forces) p += qdot.dot(effect_forces(scene, q, qdot, z, t));
  if constexpr (Sc::has_constraints) p += qdot.dot(reactions(scene, q, qdot, t, z));
  return p;
}
template <class Sys, class... Effects>
double power(const Scene<Sys, Effects...>& scene, const Coordinates<Sys>& q, const Coordinates<Sys>& qdot, double t = 0.0) {
  return power(scene, q, qdot, t, detail::states_at(scene, q, qdot, t));
}

/// Generalized reaction forces Jᵀλ at a State, n, of a scene or a system.
template <HasEnergies M>
Coordinates<M> reactions(const M& model, const State<M::dof_at_compile_time>& state) {
  return reactions(model, state.q, state.qdot, state.t);
}
/// Power q̇·(ΣQ + Jᵀλ) at a State, of a scene or a system.
template <HasEnergies M>
double power(const M& model, const State<M::dof_at_compile_time>& state) {
  return power(model, state.q, state.qdot, state.t);
}

}  // namespace qdot
