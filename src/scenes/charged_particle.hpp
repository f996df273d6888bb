#pragma once
// SPDX-License-Identifier: MIT
//
// A charge e in a uniform magnetic field B across the plane and a uniform electric field E cos ωt along x:
//
//     T = ½ m (ẋ² + ẏ²) + ½ e B (x ẏ − y ẋ),      V = −e E cos(ωt) x.
//
// The magnetic force does no work; it comes from a term linear in the velocity, which counts to T here. V depends on the time.
// At ω = e B / m, the cyclotron's resonance, the orbit widens by the same amount every turn.

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct ChargedParticle {
  double m = 1.0;      // mass
  double e = 1.0;      // charge
  double B = 2.0;      // magnetic field, across the plane
  double E = 0.3;      // amplitude of the electric field, along x
  double omega = 2.0;  // its angular frequency

  constexpr auto T(const auto& q, const auto& qdot) const {
    return 0.5 * m * (qdot[0] * qdot[0] + qdot[1] * qdot[1]) + 0.5 * e * B * (q[0] * qdot[1] - q[1] * qdot[0]);
  }

  constexpr auto V(const auto& q, const auto& t) const {
    using std::cos;
    return -e * E * cos(omega * t) * q[0];
  }
};

inline Scene<ChargedParticle, 2> charged_particle() {
  return {
      .name = "charged_particle",
      .title = "Charged particle in a cyclotron",
      .summary = "A charge in a uniform magnetic field and an electric field that alternates at the cyclotron frequency: the orbit widens.",
      .parameters = {{"m", &ChargedParticle::m, "kg", Range::positive, "mass"},
                     {"e", &ChargedParticle::e, "C", Range::any, "charge"},
                     {"B", &ChargedParticle::B, "T", Range::any, "magnetic field, across the plane"},
                     {"E", &ChargedParticle::E, "V/m", Range::any, "amplitude of the electric field, along x"},
                     {"omega", &ChargedParticle::omega, "rad/s", Range::any, "angular frequency of the electric field"}},
      .coordinates = {{"x", "m"}, {"y", "m"}},
      .start = {0.0, 0.0, 0.1, 0.0},
      .t_end = 20.0,
      .drawing = {report::trail(0), report::disk(0, 1, 7)},
      .positions = [](const ChargedParticle&, const Vector<double, 2>& q, double) -> std::vector<Point> {
        return {{q[0], q[1]}};
      },
  };
}

}  // namespace qdot::scenes
