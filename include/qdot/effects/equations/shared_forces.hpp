#pragma once
// SPDX-License-Identifier: MIT
//
// Contacts and frictions that share a force: a beam on three supports, a table on four legs, two brakes on one shaft.
//
// Their rows depend on each other, so only sums of their forces follow from the motion. Any split within the bounds is as good, λ ≥ 0 of contacts and
// |λ| ≤ F_s of friction: none opens and none slips as long as there is one. So these have one guard together, how far inside all bounds a split
// can be; and where forces are asked for, they are the shortest split within the bounds.
//
// Lasting constraints have their part in the rows first: what is left is A = J M⁻¹ Jᵀ on the motions that they allow.

#include <Eigen/Core>
#include <vector>

namespace qdot::detail {

class SceneRows;  // effects/equations/scene_rows.hpp

// What active rows that share forces have of them.
struct SharedForces {
  std::vector<int> set;         // of each switching effect: which set it belongs to, −1 if its force is its own
  std::vector<int> stops;       // the bound that the set's way out is stopped by: −1 the lower, 1 the upper, 0 none
  std::vector<double> guard;    // of the first effect of each set how far inside its bounds the set is; of the others a positive number
  std::vector<double> ease;     // the same of all effects, as a fraction of the load
};

// Of the active rows of a scene, of which at least one depends on others, with the forces lambda.
template <class = void>
SharedForces shared_forces(const SceneRows& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& z,
                           const Eigen::VectorXd& lambda);

// lambda ← the shortest within the bounds, where there is one; those of the lasting constraints follow from the others.
template <class = void>
void split_forces(const SceneRows& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& z,
                  Eigen::VectorXd& lambda);

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template SharedForces shared_forces<void>(const SceneRows&, double, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&,
                                                 const Eigen::VectorXd&);
extern template void split_forces<void>(const SceneRows&, double, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&,
                                        Eigen::VectorXd&);
}  // namespace qdot::detail
#else
#include "qdot/effects/equations/shared_forces.ipp"
#endif
