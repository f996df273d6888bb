// SPDX-License-Identifier: MIT
//
// A lambda to be derived that captures by reference: what it refers to may change unseen.
// message: qdot: derived reads the parameters of T and V once
#include <qdot/mechanics/derived.hpp>

int main() {
  double m = 2.0;
  return qdot::derived<1>([&m](const auto& qdot) { return 0.5 * m * qdot[0] * qdot[0]; }).has_lines() ? 1 : 0;
}
