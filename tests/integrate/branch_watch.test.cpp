// SPDX-License-Identifier: MIT
#include "qdot/integrate/watch/branch_watch.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "catch2_bridge.hpp"
#include "qdot/analysis/sensitivity.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/cvode_automatic.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/mechanics/energy.hpp"

using namespace qdot;

namespace {

using V1 = Vector<double, 1>;

// A body of mass 1 that coasts, but for a force F in a strip from `begins` on, which takes it from v to √(v² + 2 F width).
struct Strip {
  double begins = 1.0, width = 0.1, F = 3.0;

  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const {
    auto potential = 0.0 * q[0];
    if (q[0] > begins) potential -= F * (q[0] - begins);
    if (q[0] > begins + width) potential += F * (q[0] - begins - width);
    return potential;
  }
  double end(double v, double t) const {
    const double into = t - begins / v, out = std::sqrt(v * v + 2.0 * F * width), takes = (out - v) / F;
    return begins + width + out * (into - takes);
  }
};

// Where the strip begins and ends, steps end by their local error, 1e-9 in each of some; an error of the velocity is ten times as much of the place.
constexpr double tolerance = 1e-5;

auto start(double q, double v) { return State<1>{0.0, V1(q), V1(v)}; }

}  // namespace

TEST_CASE("a strip that a step would pass over is felt, however narrow, by every method, forward and backward") {
  const std::vector<std::pair<std::string, AnyMethod<decltype(mechanical_system<1>(Strip{}))>>> methods = {
      {"dop853", Dop853{}}, {"dopri5", Dopri5{}}, {"bdf", CvodeBdf{}}, {"adams", CvodeAdams{}}, {"automatic", Automatic{}}};
  for (const double width : {0.5, 0.1, 1e-2, 1e-4})
    for (const auto& [name, method] : methods) {
      CAPTURE(width, name);
      const Strip strip{.width = width, .F = 0.3 / width};
      const auto run = simulate(mechanical_system<1>(strip), start(0.0, 0.8), 10.0, method);
      REQUIRE(run.completed());
      CHECK(std::abs(run.y[0] - strip.end(0.8, 10.0)) < tolerance);
      const auto back = simulate(mechanical_system<1>(strip), State<1>{10.0, V1(run.y[0]), V1(run.y[1])}, 0.0, method);
      REQUIRE(back.completed());
      CHECK(std::abs(back.y[0]) < 10 * tolerance);
    }
}

TEST_CASE("a strip of a force is felt, and one that a second coordinate passes") {
  const auto free = mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }, [](const auto& q) { return 0.0 * q[0]; });
  const auto wind = generalized_force([](const auto& q, const auto&) {
    auto Q = q;
    Q[0] = 0.0 * q[0];
    Q[1] = q[0] > 1.0 && q[0] < 1.125 ? 2.0 + 0.0 * q[1] : 0.0 * q[1];
    return Q;
  });
  const auto run = simulate(scene(free, wind), State<2>{0.0, {0.0, 0.0}, {0.5, 0.0}}, 10.0, Dop853{});
  REQUIRE(run.completed());
  // In the strip for 1/4 s: q̇₁ = 1/2, then 7.75 s more of it.
  CHECK(std::abs(run.y[3] - 0.5) < tolerance);
  CHECK(std::abs(run.y[1] - (0.0625 + 7.75 * 0.5)) < 10 * tolerance);
}

TEST_CASE("derivatives see a strip that a step would pass over") {
  const Strip strip{.width = 0.05, .F = 4.0};
  const auto of = sensitivities(mechanical_system<1>(strip), start(0.0, 0.8), 10.0, Dop853{}, {.rtol = 1e-11});
  REQUIRE(of.completed());
  const double v = 0.8, out = std::sqrt(v * v + 2.0 * strip.F * strip.width);
  // q(t) = q_out + w (t − t_out) with w the velocity behind: by the place ∂q/∂q₀ = w/v, and ∂q̇/∂v = v/w.
  CHECK(std::abs(of.Phi(0, 0) - out / v) < 1e-7);
  CHECK(std::abs(of.Phi(1, 1) - v / out) < 1e-7);
}

TEST_CASE("a functor that compares nothing, and one whose branches are never left, costs no step") {
  const auto plain = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.5 * q[0] * q[0]; });
  const auto guarded = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) {
    return q[0] < 2.0 ? 0.5 * q[0] * q[0] : 0.25 * q[0] * q[0];
  });
  const auto a = simulate(plain, start(1.0, 0.0), 20.0, Dop853{}), b = simulate(guarded, start(1.0, 0.0), 20.0, Dop853{});
  CHECK(a.statistics.steps == b.statistics.steps);
  CHECK(std::abs(a.y[0] - b.y[0]) < 1e-12);
}
