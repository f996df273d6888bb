// SPDX-License-Identifier: MIT
//
// Energies to be written out whose V branches on a coordinate.
// message: qdot: T or V branches on q, qdot or t
#include <qdot/mechanics/written_out.hpp>

struct Mass {
  double m = 1.0;
  constexpr auto T(const auto& qdot) const { return 0.5 * m * qdot[0] * qdot[0]; }
  constexpr auto V(const auto& q) const {
    if (q[0] < 0.0) return q[0] * q[0];
    return 0.0 * q[0];
  }
};

int main() { return qdot::written_out<1>(Mass{}).replays() ? 1 : 0; }
