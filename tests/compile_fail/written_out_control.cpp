// SPDX-License-Identifier: MIT
//
// Energies that can be written out.
#include <qdot/mechanics/written_out.hpp>

int main() {
  const double m = 2.0;
  return qdot::written_out<1>([=](const auto& qdot) { return 0.5 * m * qdot[0] * qdot[0]; }).replays() ? 0 : 1;
}
