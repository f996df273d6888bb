#pragma once
// SPDX-License-Identifier: MIT
//
// The constraints of a scene at a state as plain numbers, a row for each, whatever type the scene has.

#include <vector>

#include <Eigen/Core>

namespace qdot::detail {

struct ConstraintsAt {
  Eigen::VectorXd phi;       // φ of holonomic rows, zero of others
  Eigen::VectorXd velocity;  // J q̇ + ∂φ/∂t, or a
  Eigen::MatrixXd slopes;    // of `velocity` in (q, q̇): m×2n, the right half is J
  std::vector<bool> holonomic;
};

}  // namespace qdot::detail
