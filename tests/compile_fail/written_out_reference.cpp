// SPDX-License-Identifier: MIT
//
// A lambda to be written out that captures by reference: the compiler has no object to run.
// message: qdot: written_out runs T and V while compiling and needs an object for that
#include <qdot/mechanics/written_out.hpp>

int main() {
  double m = 2.0;
  return qdot::written_out<1>([&m](const auto& qdot) { return 0.5 * m * qdot[0] * qdot[0]; }).replays() ? 1 : 0;
}
