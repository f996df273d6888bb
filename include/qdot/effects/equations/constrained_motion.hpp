#pragma once
// SPDX-License-Identifier: MIT
//
// q̈ and λ, and slopes of q̈, where a run's lines have no answer. Such are rows that depend on each other, motions without inertia, phases that are only
// tried, and numbers that are not finite, which are named.
//
//     M q̈ − Jᵀ λ = r + Q ,    J q̈ = γ
//
// from the numbers of effects/equations/scene_rows.hpp, by dense factors (effects/rows/constrained_solve.hpp).

#include <Eigen/Core>

#include "qdot/effects/equations/scene_rows.hpp"
#include "qdot/effects/rows/columns.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"

namespace qdot::detail {

using AnySolution = SolutionOf<Column, Column>;

/// q̈ and λ in the phases z.
///
/// @tparam Sizes  AnySizes, or the KnownSizes of a scene with few rows
/// @throws as constrained_acceleration() of a scene
template <class Sizes>
[[gnu::cold]] SolutionOf<typename Sizes::N, typename Sizes::M> general_constrained_acceleration(const SceneRows& rows, double t, const typename Sizes::N& q,
                                                                                                const typename Sizes::N& qdot, const Column& z,
                                                                                                double cutoff);

/// ∂q̈ from M ∂q̈ − Jᵀ ∂λ = dr, J ∂q̈ = dc, column by column.
template <class = void>
[[gnu::cold]] Table constrained_slopes(const SceneRows& rows, double t, const Column& q, const Column& qdot,
                                       const Column& z, const Table& dr, const Table& dc);

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template AnySolution general_constrained_acceleration<AnySizes>(const SceneRows&, double, const Column&, const Column&, const Column&, double);
extern template SolutionOf<Vector<double, 1>, Vector<double, 1>> general_constrained_acceleration<KnownSizes<1, 1>>(
    const SceneRows&, double, const Vector<double, 1>&, const Vector<double, 1>&, const Column&, double);
extern template SolutionOf<Vector<double, 2>, Vector<double, 1>> general_constrained_acceleration<KnownSizes<2, 1>>(
    const SceneRows&, double, const Vector<double, 2>&, const Vector<double, 2>&, const Column&, double);
extern template SolutionOf<Vector<double, 2>, Vector<double, 2>> general_constrained_acceleration<KnownSizes<2, 2>>(
    const SceneRows&, double, const Vector<double, 2>&, const Vector<double, 2>&, const Column&, double);
extern template SolutionOf<Vector<double, 3>, Vector<double, 1>> general_constrained_acceleration<KnownSizes<3, 1>>(
    const SceneRows&, double, const Vector<double, 3>&, const Vector<double, 3>&, const Column&, double);
extern template SolutionOf<Vector<double, 3>, Vector<double, 2>> general_constrained_acceleration<KnownSizes<3, 2>>(
    const SceneRows&, double, const Vector<double, 3>&, const Vector<double, 3>&, const Column&, double);
extern template SolutionOf<Vector<double, 4>, Vector<double, 1>> general_constrained_acceleration<KnownSizes<4, 1>>(
    const SceneRows&, double, const Vector<double, 4>&, const Vector<double, 4>&, const Column&, double);
extern template SolutionOf<Vector<double, 4>, Vector<double, 2>> general_constrained_acceleration<KnownSizes<4, 2>>(
    const SceneRows&, double, const Vector<double, 4>&, const Vector<double, 4>&, const Column&, double);
extern template Table constrained_slopes<void>(const SceneRows&, double, const Column&, const Column&, const Column&,
                                               const Table&, const Table&);
}  // namespace qdot::detail
#else
#include "qdot/effects/equations/constrained_motion.ipp"
#endif
