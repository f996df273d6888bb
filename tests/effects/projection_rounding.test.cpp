// SPDX-License-Identifier: MIT
//
// What projection does with residuals that are rounding, and with those that are not.
#include <cmath>

#include "../catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/projection.hpp"

using namespace qdot;

namespace {

// A slider at x ≈ 0.5 m with a spring of length 0.3 m + e that is fixed at its other end; the slider is 3 times heavier.
constexpr double at = 0.8;
struct Slider {
  auto T(const auto& v) const { return 0.5 * (3.0 * v[0] * v[0] + v[1] * v[1]); }
  auto V(const auto& q) const { return 0.5 * 1e7 * q[1] * q[1]; }
};
struct Bob {
  auto T(const auto& u) const { return 0.5 * (u[0] * u[0] + u[1] * u[1]); }
  auto V(const auto& u) const { return u[1]; }
};

constexpr double centre = 1e3, radius = 1e-3, unit = 1.2e-13;  // of a circle, and the last of its coordinates

auto slider() {
  return scene(mechanical_system<2>(Slider{}).with_names({"x", "e"}),
               holonomic("end", [](const auto& q) { return q[0] + (q[1] + 0.3) - at; }));
}

}  // namespace

TEST_CASE("a residual of rounding size does not move a coordinate that is far smaller than the others") {
  const double e = 1e-6, x = at - 0.3 - e;
  for (const int roundings : {-2, -1, 1, 2}) {
    Vector<double, 2> q(x + roundings * 1.1e-16, e), v = Vector<double, 2>::Zero();
    const auto report = project(slider(), q, v, 0.0);
    CHECK(report.residual <= 2.3e-16);  // ε, of sums near one
    CHECK(std::abs(q[1] - e) <= 1e-14 * e);  // the metric of M would move it by 5e-17, 5e-11 of its size
  }
}

TEST_CASE("a residual that rounding does not explain is undone by the shortest way in the metric of M") {
  const double e = 1e-6, x = at - 0.3 - e, drift = 1e-10;
  Vector<double, 2> q(x + drift, e), v = Vector<double, 2>::Zero();
  project(slider(), q, v, 0.0);
  // 3 δx = δe, δx + δe = −drift; to the rounding of x.
  CHECK(std::abs(q[0] - (x + drift - 0.25 * drift)) <= 2.3e-16);
  CHECK(std::abs(q[1] - (e - 0.75 * drift)) <= 2.3e-16);
}

TEST_CASE("coordinates of equal size share a residual of rounding size as their inertias ask") {
  // |q| = 1: the shortest way is radial, whatever rounding says.
  const auto bob = scene(mechanical_system<2>(Bob{}),
                         holonomic("rod", [](const auto& u) { return 0.5 * (u[0] * u[0] + u[1] * u[1] - 1.0); }));
  Vector<double, 2> q(0.6, 0.8 + 16 * 1.1e-16), v = Vector<double, 2>::Zero();
  project(bob, q, v, 0.0);
  const double outward = 16 * 1.1e-16 * 0.8;
  CHECK(std::abs(q[0] - (0.6 - 0.6 * outward)) <= 2.3e-16);
  CHECK(std::abs(q[1] - (0.8 + 16 * 1.1e-16 - 0.8 * outward)) <= 2.3e-16);
}

TEST_CASE("a circle that is far smaller than its coordinates is met as exactly as these can say, and so are its velocities") {
  // Radius 1 mm at 1 km: 1e-9 m off, a millionth of the radius, is 1e-12 of the coordinates. The nearest velocity is the tangential one.
  const auto ring = scene(mechanical_system<2>(Bob{}), holonomic("ring", [](const auto& u) {
                            const auto x = u[0] - centre, y = u[1] - centre;
                            return 0.5 * (x * x + y * y - radius * radius);
                          }));
  for (const double off : {1e-9, 1e-6, 2e-4}) {
    const double place = radius + off;
    Vector<double, 2> q(centre + 0.6 * place, centre + 0.8 * place), v(0.3, 0.1);
    project(ring, q, v, 0.0);
    CHECK(std::abs(q[0] - (centre + 0.6 * radius)) <= 2 * unit);
    CHECK(std::abs(q[1] - (centre + 0.8 * radius)) <= 2 * unit);
    const double x = q[0] - centre, y = q[1] - centre, along = (0.1 * x - 0.3 * y) / (x * x + y * y);
    const double tolerance = 1e-9 * 0.3;  // a unit of q, in units of the radius, turns the velocity by 1.2e-10
    CHECK(std::abs(v[0] + along * y) <= tolerance);
    CHECK(std::abs(v[1] - along * x) <= tolerance);
    CHECK(std::abs(v[0] * x + v[1] * y) <= 1e-15 * radius);  // tangential to some roundings of 0.3 m/s × 1 mm
  }
}

TEST_CASE("a constraint of velocities holds no position back that another constraint asks for") {
  // A brake that stops x beside a wall at x = 0, however far the start is off, and beside a rod in a direction of its own.
  const auto brake = nonholonomic("brake", [](const auto&, const auto& v) { return v[0]; });
  const auto wall = holonomic("wall", [](const auto& q) { return q[0]; });
  const auto rod = holonomic("rod", [](const auto& q) { return 0.5 * (q[0] * q[0] + q[1] * q[1] - 1.0); });
  const auto bob = mechanical_system<2>(Bob{});
  for (const double off : {1e-3, 1e-9, 1e-30}) {
    Vector<double, 2> q(off, 1.0), v(0.25, 0.5);
    CHECK(project(scene(bob, brake, wall), q, v, 0.0).rank == 1);
    CHECK((q[0] == 0.0 && q[1] == 1.0));
    CHECK((v[0] == 0.0 && v[1] == 0.5));
    q << off, 1.0 - off;
    v << 0.25, 0.5;
    CHECK(project(scene(bob, brake, wall, rod), q, v, 0.0).rank == 2);
    CHECK((std::abs(q[0]) <= 2.3e-16 && std::abs(q[1] - 1.0) <= 2.3e-16));
    CHECK((v[0] == 0.0 && std::abs(v[1]) <= 2.3e-16));
  }
}
