#pragma once
// SPDX-License-Identifier: MIT
//
// Back onto the constraints.
//
// Equations solved for J q̈ = γ keep φ̈ = 0, so φ and φ̇ drift as errors add up. Projection puts a state back by the shortest way in
// the metric of M. So the system feels an impulse of the constraints' own kind, Jᵀμ, and no other. Newton's method first solves
//
//     minimize ‖q − q*‖_M   subject to   φ(q, t) = 0 ,      then one linear step gives velocities with   J q̇ + ∂φ/∂t = 0, a = 0.
//
// Rounding is not drift: φᵢ of a state that is right to its last digit is of the size ρᵢ = ε Σⱼ |Jᵢⱼ| |qⱼ|. To project that away puts
// noise into each step, most where there is least inertia: an elastic deflection of 1e-6 m beside a slider at 0.5 m rings. That cost two
// to three digits on the flexible slider crank (docs/lab/hard-cases.md). So where |φᵢ| ≤ 64 ρᵢ, and ρ would move some coordinate by more
// than 1000 ε|qⱼ|, the residual is removed by the shortest way in the metric Σ (δqⱼ/qⱼ)².
//
// M and J are factored where Newton's method begins, and again where it has moved further than 1e-8 of the coordinates from there. The
// same two steps turn a rough initial state into a consistent one, and report what they moved.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <type_traits>

#include "qdot/effects/equations/constraint_geometry.hpp"
#include "qdot/effects/equations/scene_rows.hpp"
#include "qdot/effects/equations/scene_rows_of.hpp"
#include "qdot/effects/equations/sparse_geometry.hpp"
#include "qdot/effects/projection_report.hpp"
#include "qdot/effects/rows/columns.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/effects/rows/traced_constraints.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/effects/scene_motion.hpp"

namespace qdot {

namespace detail {

// Projects q and qdot in the phases z.
template <class = void>
ProjectionReport projected(const SceneRows& rows, ConstraintGeometry& geometry, Column& q, Column& qdot, double t, const Column& z);

// Projects q and q̇ of scenes with few rows that project after each step: as fast as if it were written for the scene.
template <int n, int m>
ProjectionReport projected_by_size(const SceneRows& rows, Vector<double, n>& q, Vector<double, n>& qdot, double t, double cutoff, const Column& z);

// As project() below; `traced` are equations that a run has traced, or nothing.
template <class Sys, class... Effects, int n>
ProjectionReport projected(const Scene<Sys, Effects...>& scene, Vector<double, n>& q, Vector<double, n>& qdot, double t, double cutoff,
                           const EffectStates<Scene<Sys, Effects...>>& z, [[maybe_unused]] TracedConstraints* traced) {
  using Sc = Scene<Sys, Effects...>;
  static_assert(Sc::has_constraints, "qdot: only a scene with constraints can be projected onto them");
  const SceneRowsOf<Sc> rows(scene);
  if constexpr (are_few<n, Sc::constraints_at_compile_time>) {
    return projected_by_size<n, Sc::constraints_at_compile_time>(rows, q, qdot, t, cutoff, Column(z));
  } else {
    auto geometry = constraint_geometry(scene, rows, t, cutoff, traced);
    Column x(q), v(qdot);
    const ProjectionReport report = projected(rows, geometry, x, v, t, Column(z));
    std::copy_n(x.data(), x.size(), q.data());
    std::copy_n(v.data(), v.size(), qdot.data());
    return report;
  }
}

}  // namespace detail

/// The nearest state on the constraints: positions first, then velocities.
///
/// @param q, qdot  changed in place
/// @param z        the effects' own states, where constraints hold in some phases only
/// @param cutoff   relative size below which a row of J counts as dependent
/// @throws ConstraintError  when Newton's method finds no state nearby, with the row that is worst off
/// @throws NonFinite        when a constraint is not finite on the way
template <class Sys, class... Effects, int n, class Phases = detail::NoPhases>
ProjectionReport project(const Scene<Sys, Effects...>& scene, Vector<double, n>& q, Vector<double, n>& qdot, double t,
                         double cutoff = default_rank_cutoff, const Phases& z = {}) {
  using Sc = Scene<Sys, Effects...>;
  if constexpr (std::is_same_v<Phases, detail::NoPhases>) {
    static_assert(!Sc::has_phases,
                  "qdot: some constraints of this scene hold in some phases only: pass the effects' own states z, as "
                  "settled_states(scene, state) gives them");
    return detail::projected(scene, q, qdot, t, cutoff, scene.initial_states(), nullptr);
  } else {
    return detail::projected(scene, q, qdot, t, cutoff, EffectStates<Sc>(z), nullptr);
  }
}

/// A state on the constraints and what it took to get there.
template <int n>
struct ConsistentState {
  State<n> state;           ///< nearest one that satisfies the constraints
  ProjectionReport report;  ///< how far that is from what was given
};

/// The consistent state nearest to a rough one, as by project().
///
/// @throws ConstraintError  when there is none nearby
/// @throws InvalidValue     when the rough state is not finite
template <class Sys, class... Effects, int n>
ConsistentState<n> consistent_state(const Scene<Sys, Effects...>& scene, const State<n>& rough,
                                    double cutoff = default_rank_cutoff) {
  detail::require_sizes(scene, rough.q, rough.qdot);
  if (!detail::all_finite(rough.q) || !detail::all_finite(rough.qdot) || !std::isfinite(rough.t))
    throw InvalidValue("an initial state must be finite, but this one has NaN or infinity in it; give every entry a number");
  ConsistentState<n> result{rough, {}};
  result.report = project(scene, result.state.q, result.state.qdot, rough.t, cutoff);
  return result;
}

}  // namespace qdot

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template ProjectionReport projected<void>(const SceneRows&, ConstraintGeometry&, Column&, Column&, double, const Column&);
extern template ProjectionReport projected_by_size<1, 1>(const SceneRows&, Vector<double, 1>&, Vector<double, 1>&, double, double, const Column&);
extern template ProjectionReport projected_by_size<2, 1>(const SceneRows&, Vector<double, 2>&, Vector<double, 2>&, double, double, const Column&);
extern template ProjectionReport projected_by_size<2, 2>(const SceneRows&, Vector<double, 2>&, Vector<double, 2>&, double, double, const Column&);
extern template ProjectionReport projected_by_size<3, 1>(const SceneRows&, Vector<double, 3>&, Vector<double, 3>&, double, double, const Column&);
extern template ProjectionReport projected_by_size<3, 2>(const SceneRows&, Vector<double, 3>&, Vector<double, 3>&, double, double, const Column&);
extern template ProjectionReport projected_by_size<4, 1>(const SceneRows&, Vector<double, 4>&, Vector<double, 4>&, double, double, const Column&);
extern template ProjectionReport projected_by_size<4, 2>(const SceneRows&, Vector<double, 4>&, Vector<double, 4>&, double, double, const Column&);
}  // namespace qdot::detail
#else
#include "qdot/effects/projection.ipp"
#endif
