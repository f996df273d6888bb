// SPDX-License-Identifier: MIT
//
// A struct has a member T and no V.
// message: velocities belongs into T, and an object with a member T has a member V as well: without potential give T alone, as a function
#include <qdot/qdot.hpp>

struct Free {
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
};

int main() { return qdot::mechanical_system<1>(Free{}).dof() == 1 ? 0 : 1; }
