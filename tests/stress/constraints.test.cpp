// SPDX-License-Identifier: MIT
//
// Constraints that say the same twice, or nearly so, in units from 1e-6 to 1e6; that lose rank on the way; and that alone
// determine a coordinate without mass.

#include <cmath>
#include <numbers>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

using namespace qdot;
using Eigen::Vector3d;

namespace {

const Options fine{.rtol = 1e-12, .atol = 1e-13};
constexpr double fine_error = 3e-11;  // of positions and times at these tolerances; 1.3e-12 was seen
constexpr double near_error = 2e-10;  // after a period at rtol = 1e-10, for all scales and distances; 2e-11 was seen
constexpr double rounding = 2e-12;    // of the crank's slider: projection beside the singular point squares its digits

// Three coordinates and two constraints each, so that all cases share one type.
struct Model {
  enum { spheres, crank, pulley } kind = spheres;
  Vector3d mass{1.0, 1.0, 1.0};
  double scale1 = 1.0, scale2 = 1.0, distance = 0.0;

  auto T(const auto& v) const { return 0.5 * (mass[0] * v[0] * v[0] + mass[1] * v[1] * v[1] + mass[2] * v[2] * v[2]); }
  auto V(const auto& q) const {
    auto energy = 0.0 * q[0];
    if (kind == spheres) energy = 9.81 * q[1];
    if (kind == pulley) energy = 2.0 * q[1] * q[1];
    return energy;
  }
  auto phi(const auto& q) const {
    auto first = q[0] * q[0] + q[1] * q[1] - 1.0, second = first;
    if (kind == spheres) {  // two unit spheres, the second moved along z: a circle in the plane between them
      first = first + q[2] * q[2];
      second = first - 2.0 * distance * q[2] + distance * distance;
    } else if (kind == crank) {  // a crank and a rod of equal length, whose slider may move on or stay in the middle
      second = (q[2] - q[0]) * (q[2] - q[0]) + q[1] * q[1] - 1.0;
    } else {  // a massless block q₁ on a rope with the mass q₀, which moves twice as far; the other mass rests
      first = q[0] - 2.0 * q[1];
      second = q[2];
    }
    return vector(scale1 * first, scale2 * second);
  }
};
auto scene_of(const Model& model) {
  return scene(mechanical_system<3>(model), holonomic("pair", [=](const auto& q) { return model.phi(q); }));
}

TEST_CASE("constraints that agree, or nearly agree, hold in any units") {
  constexpr double period_1 = 2.13913760055869;  // of a pendulum of length 1 from 1 rad at g = 9.81
  for (const double distance : {0.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8})
    for (const double scale1 : {1e-6, 1.0, 1e6})
      for (const double scale2 : {1e-6, 1e6}) {
        const double z = 0.5 * distance, l = std::sqrt(1.0 - z * z), period = period_1 * std::sqrt(l);
        const Vector3d start(l * std::sin(1.0), -l * std::cos(1.0), z);
        const auto run = simulate(scene_of({.scale1 = scale1, .scale2 = scale2, .distance = distance}), State<3>{0.0, start, Vector3d(0, 0, 0)}, period,
                                  Dop853{}, {.rtol = 1e-10, .atol = 1e-12, .max_steps = 200, .max_evaluations = 10'000});
        CAPTURE(distance, scale1, scale2);
        INFO(run.message);
        CHECK(run.completed());
        CHECK((run.state().q - start).norm() < near_error);
      }
}

TEST_CASE("a crank and a rod of equal length pass the point where their constraints lose a rank") {
  // From θ = 0.3 with θ̇ = 1 through θ = π/2, where the slider could as well stay in the middle: x₂ = 2 cos θ by inertia, and
  // (m + 4 M sin²θ) θ̇² is kept.
  const double m = 1.0, M = 0.5, theta0 = 0.3, s = std::sin(theta0), c = std::cos(theta0);
  const auto run = simulate(scene_of({.kind = Model::crank, .mass = Vector3d(m, m, M)}), State<3>{0.0, Vector3d(c, s, 2 * c), Vector3d(-s, c, -2 * s)}, 3.0,
                            Dop853{}, fine);
  INFO(run.message);
  CHECK(run.completed());
  const Vector3d q = run.state().q;
  CHECK(std::abs(q[2] - 2.0 * q[0]) < rounding);
  // Time to θ by Simpson's rule.
  const double theta = std::atan2(q[1], q[0]), h = (theta - theta0) / 2000;
  const auto slowness = [&](double at) { return std::sqrt((m + 4 * M * std::sin(at) * std::sin(at)) / (m + 4 * M * s * s)); };
  double time = 0.0;
  for (int i = 0; i < 1000; ++i) time += h / 3 * (slowness(theta0 + 2 * i * h) + 4 * slowness(theta0 + (2 * i + 1) * h) + slowness(theta0 + (2 * i + 2) * h));
  CHECK(theta > std::numbers::pi / 2);
  CHECK(std::abs(time - run.t) < fine_error);
}

TEST_CASE("a massless block that a rope determines moves with the mass on the other end") {
  // ½ẋ² and ½·4·(x/2)²: ω = 1.
  const auto run = simulate(scene_of({.kind = Model::pulley, .mass = Vector3d(1.0, 0.0, 1.0)}), State<3>{0.0, Vector3d(1.0, 0.5, 0.0), Vector3d(0, 0, 0)},
                            20.0, Dop853{}, fine);
  INFO(run.message);
  REQUIRE(run.completed());
  CHECK((run.state().q - Vector3d(std::cos(20.0), 0.5 * std::cos(20.0), 0.0)).norm() < fine_error);
}

}  // namespace
