// SPDX-License-Identifier: MIT
//
// Points where coordinates degenerate: the origin of polar coordinates, the pole of spherical ones. Motions pass them at all
// distances; what starts there is named; Cartesian coordinates know nothing of it.

#include <cmath>
#include <numbers>
#include <string>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

using namespace qdot;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

const Options fine{.rtol = 1e-12, .atol = 1e-14};
constexpr double error = 5e-12;     // of positions at these tolerances over up to 700 steps; 2e-13 was seen
constexpr double rounding = 1e-14;  // of a straight line in six steps

// A free particle in the plane, (r, φ), or a pendulum of length 1 on the sphere, (θ, φ).
struct Degenerate {
  bool sphere;
  auto T(const auto& q, const auto& qdot) const {
    using std::sin;
    auto s = q[0];
    if (sphere) s = sin(q[0]);
    return 0.5 * (qdot[0] * qdot[0] + s * s * qdot[1] * qdot[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    auto v = 0.0 * q[0];
    if (sphere) v = -9.81 * cos(q[0]);
    return v;
  }
};
const auto polar = mechanical_system<2>(Degenerate{false}).with_names({"r", "phi"});
const auto spherical = mechanical_system<2>(Degenerate{true}).with_names({"theta", "phi"});

TEST_CASE("what starts at the origin or at a pole is told which coordinate has no meaning there") {
  const Vector2d v(1.0, 1.0);
  const std::string no_meaning_of_phi =
      "the mass matrix must be positive definite, but at t = 0 the motion with velocity along phi has no kinetic energy (relative inertia "
      "0); give that motion a mass or an inertia, remove the coordinate, or leave the point where the coordinates degenerate (a pole, r = 0)";
  CHECK_THROWS_WITH(simulate(polar, State<2>{0.0, Vector2d(0.0, 0.3), v}, 1.0, Dop853{}), no_meaning_of_phi);
  CHECK_THROWS_WITH(simulate(spherical, State<2>{0.0, Vector2d(0.0, 0.3), v}, 1.0, Dop853{}), no_meaning_of_phi);
  // The double next to π is 1.2e-16 off the pole, and a motion like any other starts there.
  CHECK(simulate(spherical, State<2>{0.0, Vector2d(std::numbers::pi, 0.3), v}, 0.1, Dop853{}).completed());
}

TEST_CASE("a free particle passes the origin of polar coordinates at any distance") {
  // (x, y) = (t − 1, b)
  for (const double b : {1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9}) {
    const double r = std::hypot(1.0, b);
    const auto run = simulate(polar, State<2>{0.0, Vector2d(r, std::atan2(b, -1.0)), Vector2d(-1.0 / r, -b / (r * r))}, 2.0, Dop853{},
                              {.rtol = 1e-12, .atol = 1e-14, .max_steps = 20'000});
    CAPTURE(b);
    INFO(run.message);
    CHECK(run.completed());
    const Vector2d q = run.state().q;
    CHECK(std::hypot(q[0] * std::cos(q[1]) - (run.t - 1.0), q[0] * std::sin(q[1]) - b) < error);
  }
}

TEST_CASE("a free particle goes straight through the origin, where r becomes negative") {
  const State<2> inwards{0.0, Vector2d(1.0, 0.4), Vector2d(-1.0, 0.0)};
  const auto run = simulate(polar, inwards, 2.5, Dop853{}, {.rtol = 1e-12, .atol = 1e-14});
  INFO(run.message);
  REQUIRE(run.completed());
  CHECK(std::abs(run.state().q[0] + 1.5) < rounding);
  CHECK(run.state().q[1] == 0.4);

  // A stop on the origin itself, where φ has no meaning, is named in front of it, as a start there is; or, where r comes out as rounding
  // instead of zero, passed.
  const auto stopped = simulate(polar, inwards, 2.5, Dop853{}, {.rtol = 1e-12, .atol = 1e-14, .stop_times = {1.0}});
  INFO(stopped.message);
  if (stopped.completed()) {
    CHECK(std::abs(stopped.state().q[0] + 1.5) < rounding);
  } else {
    CHECK(stopped.outcome == Outcome::singular_mass_matrix);
    constexpr double last_steps = 1e-12;  // a hundred times the shortest step
    CHECK(std::abs(stopped.t - 1.0) < last_steps);
    CHECK(std::abs(stopped.state().q[0] + (stopped.t - 1.0)) < rounding);
  }
}

TEST_CASE("a pendulum passes the pole of the sphere as it does in Cartesian coordinates") {
  const auto rod = scene(mechanical_system<3>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return 9.81 * q[2]; }),
                         holonomic("rod", [](const auto& q) { return q.squaredNorm() - 1.0; }));
  // Thrown across from θ = 1 with a little momentum about the vertical: θ_min ≈ p_φ / θ̇ at the bottom.
  for (const double p : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
    const double theta = 1.0, s = std::sin(theta), c = std::cos(theta);
    const auto angles = simulate(spherical, State<2>{0.0, Vector2d(theta, 0.0), Vector2d(0.0, p / (s * s))}, 1.5, Dop853{},
                                 {.rtol = 1e-12, .atol = 1e-14, .max_steps = 20'000});
    const auto point = simulate(rod, State<3>{0.0, Vector3d(s, 0.0, -c), Vector3d(0.0, p / s, 0.0)}, 1.5, Dop853{}, fine);
    CAPTURE(p);
    INFO(angles.message);
    REQUIRE(point.completed());
    CHECK(angles.completed());
    const Vector2d q = angles.state().q;
    const Vector3d at(std::sin(q[0]) * std::cos(q[1]), std::sin(q[0]) * std::sin(q[1]), -std::cos(q[0]));
    CHECK((at - point.state().q).norm() < error);
  }
  // Straight through the pole: the plane pendulum's half period is 4 K(sin² ½)/√9.81 / 2, and it stands at θ = 1 on the other side.
  const auto point = simulate(rod, State<3>{0.0, Vector3d(std::sin(1.0), 0.0, -std::cos(1.0)), Vector3d(0, 0, 0)}, 0.5 * 2.13913760055869, Dop853{}, fine);
  CHECK((point.state().q - Vector3d(-std::sin(1.0), 0.0, -std::cos(1.0))).norm() < error);
}

}  // namespace
