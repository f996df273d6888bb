// SPDX-License-Identifier: MIT
//
// Energies to be written out whose T is not constexpr.
// message: qdot: written_out cannot run the kinetic energy T while compiling: mark T constexpr
#include <qdot/mechanics/written_out.hpp>

struct Mass {
  double m = 1.0;
  auto T(const auto& qdot) const { return 0.5 * m * qdot[0] * qdot[0]; }
  constexpr auto V(const auto& q) const { return m * q[0]; }
};

int main() { return qdot::written_out<1>(Mass{}).replays() ? 1 : 0; }
