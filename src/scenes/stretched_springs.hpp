#pragma once
// SPDX-License-Identifier: MIT
//
// What a string and a net are made of: equal masses that move across, and stretched springs between neighbours, each with the energy
//
//     ½ k (√(a² + d²) − l)² ,      d how far one is higher than the other .
//
// a is the distance of neighbours at rest, l < a the length of a spring without tension.

#include <cmath>
#include <utility>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct StretchedSprings {
  double m = 0.02;   // each mass
  double k = 100.0;  // stiffness of each spring
  double a = 0.2;    // distance of neighbours
  double l = 0.1;    // length of a spring without tension
  double h = 0.3;    // height at the start

  auto T(const auto& qdot) const { return 0.5 * m * qdot.squaredNorm(); }

  template <class S>
  S energy(const S& d) const {
    using std::sqrt;
    const S longer = sqrt(a * a + d * d) - l;
    return 0.5 * k * longer * longer;
  }
};

/// A number of masses, and what is the same of all.
template <class Energies>
std::vector<Parameter<Energies>> with_springs(Parameter<Energies> count) {
  return {std::move(count),
          {"m", &Energies::m, "kg", Range::positive, "each mass"},
          {"k", &Energies::k, "N/m", Range::positive, "stiffness of each spring"},
          {"a", &Energies::a, "m", Range::positive, "distance of neighbours"},
          {"l", &Energies::l, "m", Range::non_negative, "length of a spring without tension"},
          {"h", &Energies::h, "m", Range::any, "height at the start"}};
}

}  // namespace qdot::scenes
