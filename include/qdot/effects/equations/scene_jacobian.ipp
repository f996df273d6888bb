#pragma once
// SPDX-License-Identifier: MIT
//
// The function of scene_jacobian.hpp. A program that links qdot::compiled has it from there.

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <vector>

#include "qdot/effects/equations/constrained_motion.hpp"
#include "qdot/effects/equations/scene_jacobian.hpp"
#include "qdot/effects/rows/columns.hpp"

namespace qdot::detail {

template <class>
void write_scene_jacobian(const SceneSlopes& scene, double t, const Eigen::VectorXd& y, Eigen::Ref<Eigen::MatrixXd> J) {
  using Slope = SceneSlopes::Slope;
  const Eigen::Index states = scene.states(), k = scene.dof();
  const Column q(y.data(), k), qdot(y.data() + k, k), z(y.data() + 2 * k, states);
  const AnySolution at = scene.motion(t, q, qdot, z);
  Table dr(k, y.size(), 0.0), dc(at.lambda.size(), y.size(), 0.0);  // of both right sides
  for (Eigen::Index j = 0; j < y.size(); ++j)
    for (Eigen::Index i = 0; i < y.size(); ++i) J(i, j) = i < k && j == k + i ? 1.0 : 0.0;
  const auto n = static_cast<std::size_t>(k);
  std::vector<Slope> seeds(y.data(), y.data() + y.size()), r(n), Q(n), rates(static_cast<std::size_t>(states));
  for (Eigen::Index j = 0; j < y.size(); ++j) {
    double& along = seeds[static_cast<std::size_t>(j)].tangent[0];
    along = 1.0;
    if (j < 2 * k) scene.write_lagrange_residual(t, seeds.data(), seeds.data() + n, at.qddot, r.data());
    else std::fill(r.begin(), r.end(), Slope(0.0));
    scene.write_forces(t, seeds.data(), seeds.data() + n, seeds.data() + 2 * n, Q.data(), rates.data());
    for (std::size_t i = 0; i < n; ++i) dr(static_cast<Eigen::Index>(i), j) = Q[i].tangent[0] - r[i].tangent[0];
    for (Eigen::Index i = 0; i < states; ++i) J(2 * k + i, j) = rates[static_cast<std::size_t>(i)].tangent[0];
    along = 0.0;
  }
  scene.add_slopes_of_rows(t, q, qdot, z, at, dr, dc);
  Table slopes(k, y.size());
  if (!scene.solved(t, q, qdot, z, dr, dc, slopes)) slopes = constrained_slopes(scene, t, q, qdot, z, dr, dc);
  for (Eigen::Index j = 0; j < y.size(); ++j)
    for (Eigen::Index i = 0; i < k; ++i) J(k + i, j) = slopes(i, j);
}

}  // namespace qdot::detail
