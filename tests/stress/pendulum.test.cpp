// SPDX-License-Identifier: MIT
//
// A pendulum beside its separatrix, and forces that jump, run away or cease to exist.

#include <cmath>
#include <numbers>

#include "catch2_bridge.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

using namespace qdot;

namespace {

constexpr double fine_error = 1e-12;  // of times of fall at rtol = 1e-13; 5e-14 was seen
constexpr double below_error = 3e-7;  // δd/d/√g = 2e-8 for one rounding, and more for those on the way; 8e-8 was seen
constexpr double blind_error = 1e-8;  // of a step across a jump, or up to a branch point, at rtol = 1e-9 and 1e-10; 6e-10 was seen
constexpr double pole_error = 1e-9;   // of the time of a pole that is approached in steps of t's rounding; 3e-11 was seen
constexpr double rounding = 2e-14;

using V1 = Vector<double, 1>;

// One coordinate, so that all cases share one type.
struct Model {
  enum { hanging, standing, jump, well, root } kind = hanging;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q, const auto& t) const {
    using std::abs, std::cos, std::log, std::sqrt;
    auto energy = 0.0 * (q[0] + t);
    if (kind == hanging) energy = -9.81 * cos(q[0]);
    if (kind == standing) energy = 9.81 * cos(q[0]);
    if (kind == jump) energy = (t > 1.0 ? 2.0 : -1.0) * q[0];
    if (kind == well) energy = log(q[0]) + 0.0 * t;
    if (kind == root) energy = sqrt(2.0 - t) * q[0];
    return energy;
  }
};
auto system_of(const Model& model) { return mechanical_system<1>(model).with_names({"x"}); }

// Time from rest at a distance d from the top to the bottom: K(cos² d/2)/√g, by the arithmetic-geometric mean of 1 and sin d/2.
long double time_of_fall(long double d) {
  long double a = 1.0L, b = std::sin(d / 2);
  for (int i = 0; i < 12; ++i) {
    const long double mean = (a + b) / 2;
    b = std::sqrt(a * b);
    a = mean;
  }
  return std::numbers::pi_v<long double> / (2 * a * std::sqrt(9.81L));
}

TEST_CASE("a pendulum let go 1e-8 from the top falls in the time of the elliptic integral") {
  const auto fall = [](Model model, double start, double bottom, double atol) {
    const auto reached = event("bottom", [=](const auto& q) { return (start - bottom > 0 ? 1.0 : -1.0) * (q[0] - bottom); }).falling().stop();
    const auto run = simulate(system_of(model), State<1>{0.0, V1(start), V1(0.0)}, 100.0, Dop853{}, {.rtol = 1e-13, .atol = atol}, events(reached));
    INFO(run.message);
    REQUIRE(run.outcome == Outcome::stopped_by_event);
    return run.t;
  };
  // From the top: the distance is the coordinate, and has all its digits.
  for (const double d : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10}) {
    CAPTURE(d);
    CHECK(std::abs(fall({.kind = Model::standing}, d, std::numbers::pi, 1e-13 * d) - static_cast<double>(time_of_fall(d))) < fine_error);
  }
  // From below, π − 1e-8 is a number rounded to 4e-16, and sin θ has eight digits: the time is δd/d/√g uncertain.
  const double theta = std::numbers::pi - 1e-8;
  const long double d = std::numbers::pi_v<long double> - theta;
  CHECK(std::abs(fall({.kind = Model::hanging}, theta, 0.0, 1e-13) - static_cast<double>(time_of_fall(d))) < below_error);
}

TEST_CASE("a force that jumps at a time costs no more steps where the run has to find it than where it is told") {
  // ẍ = 1 up to t = 1 and −2 after it: x(3) = ½ + 2 − 4 = −1.5
  const auto blind = simulate(system_of({.kind = Model::jump}), State<1>{0.0, V1(0.0), V1(0.0)}, 3.0, Dop853{}, {.rtol = 1e-10, .atol = 1e-12});
  const auto told = simulate(system_of({.kind = Model::jump}), State<1>{0.0, V1(0.0), V1(0.0)}, 3.0, Dop853{},
                             {.rtol = 1e-10, .atol = 1e-12, .stop_times = {1.0}});
  INFO(blind.message);
  INFO(told.message);
  REQUIRE(blind.completed());
  REQUIRE(told.completed());
  CHECK(std::abs(blind.state().q[0] + 1.5) < blind_error);
  CHECK(std::abs(told.state().q[0] + 1.5) < rounding);
  CHECK(blind.statistics.steps <= told.statistics.steps);
}

TEST_CASE("a force that runs away ends the run in front of its pole, by name") {
  // V = ln x: from x = 1 at rest, x = 0 at t = √(π/2).
  const auto run = simulate(system_of({.kind = Model::well}), State<1>{0.0, V1(1.0), V1(0.0)}, 2.0, Dop853{});
  INFO(run.message);
  CHECK(run.outcome == Outcome::step_too_small);
  CHECK(std::abs(run.t - std::sqrt(std::numbers::pi / 2)) < pole_error);
  CHECK(run.trajectory.back_time() == run.t);
}

TEST_CASE("a force that ceases to exist ends the run where it does, by name") {
  // ẍ = −√(2 − t) until t = 2; ẋ(2) = −(2/3) 2^{3/2}
  const auto run = simulate(system_of({.kind = Model::root}), State<1>{0.0, V1(0.0), V1(0.0)}, 3.0, Dop853{});
  INFO(run.message);
  CHECK(run.outcome == Outcome::non_finite);
  CHECK(std::abs(run.t - 2.0) < rounding);
  CHECK(std::abs(run.state().qdot[0] + 2.0 / 3.0 * std::pow(2.0, 1.5)) < blind_error);
}

}  // namespace
