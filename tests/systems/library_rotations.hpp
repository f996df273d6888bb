#pragma once
// SPDX-License-Identifier: MIT
//
// The library's rotations as functors of their coordinates.

#include "qdot/mechanics/rotation.hpp"

namespace qdot {

template <int i, int j, int k>
struct ByAngles {
  static constexpr int n = 3;
  auto operator()(const auto& q) const { return euler_rotation<i, j, k>(q[0], q[1], q[2]); }
};
struct ByVector {
  static constexpr int n = 3;
  auto operator()(const auto& u) const { return rotation_from_vector(u); }
};
struct ByQuaternion {
  static constexpr int n = 4;
  auto operator()(const auto& p) const { return rotation_from_quaternion(p); }
};

}  // namespace qdot
