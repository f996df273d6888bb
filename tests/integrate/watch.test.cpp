// SPDX-License-Identifier: MIT
#include "qdot/integrate/watch/any_watch.ipp"

#include <cmath>
#include <limits>
#include <string>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/taylor.hpp"
#include "scenes/double_pendulum.hpp"

using namespace qdot;
using Eigen::Vector2d;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

using V1 = Vector<double, 1>;

constexpr double rounding = 1e-14;  // of a pivot of a matrix with entries near 1

// Two masses and lengths of 1: M = [[2, cos Δ], [cos Δ, 1]], so what is left of the second pivot is 1 − cos²Δ/2.
const auto double_pendulum = mechanical_system<2>(scenes::DoublePendulum{});
const State<2> raised{0.0, Vector2d(1.0, 2.0), Vector2d(0.0, 0.0)};

// A mass on a spring whose stiffness is elsewhere: V depends on what its arguments do not show.
struct SpringOf {
  const double* stiffness;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const { return 0.5 * *stiffness * q[0] * q[0]; }
};
const State<1> stretched{0.0, V1(1.0), V1(0.0)};

}  // namespace

TEST_CASE("the least rcond(M) of a run and its time belong together") {
  const auto run = simulate(double_pendulum, raised, 10.0, Dop853{});
  REQUIRE(run.completed());
  const State<2> there = run.trajectory.at(run.statistics.mass_rcond_time);
  const double c = std::cos(there.q[0] - there.q[1]);
  CHECK_THAT(run.statistics.mass_rcond, WithinAbs(1.0 - 0.5 * c * c, rounding));
  CHECK(run.statistics.mass_rcond < 1.0 - 0.5 * std::pow(std::cos(1.0), 2));  // which it was at the start
  CHECK(run.statistics.mass_rcond >= 0.5);
}

TEST_CASE("rcond(M) does not change with the units of the coordinates") {
  // The first angle in millionths of a radian.
  const auto other = mechanical_system<2>([](const auto& q, const auto& v) {
    using std::cos;
    return 1e-12 * v[0] * v[0] + 0.5 * v[1] * v[1] + 1e-6 * v[0] * v[1] * cos(1e-6 * q[0] - q[1]);
  });
  const auto run = simulate(other, State<2>{0.0, Vector2d(1e6, 2.0), Vector2d(0.0, 0.0)}, 1.0, Dop853{});
  const double c = std::cos(1.0);
  CHECK_THAT(run.statistics.mass_rcond, WithinAbs(1.0 - 0.5 * c * c, rounding));
}

TEST_CASE("a direction that loses its inertia ends the run while its acceleration still has a digit, by name") {
  // T = ½ (ȧ + ḃ)² + ½ m ḃ² with m = e^(−40 t): the direction a − b is without inertia from about t = 0.75 on, where m = 1e-13.
  const auto fading = mechanical_system<2>(
                          [](const auto&, const auto& v, const auto& t) {
                            using std::exp;
                            return 0.5 * (v[0] + v[1]) * (v[0] + v[1]) + 0.5 * exp(-40.0 * t) * v[1] * v[1];
                          },
                          [](const auto& q) { return 0.5 * (q[0] + q[1]) * (q[0] + q[1]); })
                          .with_names({"a", "b"});
  const State<2> start{0.0, Vector2d(1.0, 0.0), Vector2d(0.0, 0.0)};
  const double time = std::log(1e13) / 40;
  Options options{.max_step = 0.005};
  const auto run = simulate(fading, start, 1.0, Dop853{}, options);
  REQUIRE(run.outcome == Outcome::singular_mass_matrix);
  CHECK(run.t >= time - 1e-9);
  CHECK(run.t <= time + options.max_step);
  CHECK(run.trajectory.back_time() == run.t);
  CHECK(run.statistics.mass_rcond < 1e-13);
  CHECK(run.statistics.mass_rcond_time == run.t);
  CHECK(contains(run.message, "rcond(M) must not fall below rcond_limit, but is "));
  CHECK((contains(run.message, "along a - b has") || contains(run.message, "along -a + b has")));
  options.rcond_limit = 0.0;
  const auto on = simulate(fading, start, 1.0, Dop853{}, options);
  CHECK(on.outcome == Outcome::singular_mass_matrix);  // when M cannot be factored any more
  CHECK(on.t > run.t + 0.05);
}

TEST_CASE("an M that is nearly singular at the start ends the run with its start") {
  const auto light = mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] + v[1]) * (v[0] + v[1]) + 0.5e-14 * v[1] * v[1]; });
  const auto run = simulate(light, State<2>{3.0, Vector2d(1.0, 2.0), Vector2d(0.0, 0.0)}, 4.0, Dop853{});
  CHECK(run.outcome == Outcome::singular_mass_matrix);
  CHECK(run.t == 3.0);
  CHECK(run.y[1] == 2.0);
}

TEST_CASE("rcond of two constraints is the squared sine of the angle between them") {
  constexpr double angle = 1e-3;
  const auto particle = scene(mechanical_system<3>([](const auto& v) { return 0.5 * v.squaredNorm(); }),
                              holonomic("floor", [](const auto& q) { return q[2] * 7.0; }),
                              holonomic("ramp", [](const auto& q) { return q[2] * std::cos(angle) + q[1] * std::sin(angle); }));
  const State<3> start{0.0, {0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}};
  const auto run = simulate(particle, start, 1.0, Dop853{});
  REQUIRE(run.completed());
  CHECK_THAT(run.statistics.constraint_rcond, WithinAbs(std::sin(angle) * std::sin(angle), rounding));
  const auto strict = simulate(particle, start, 1.0, Dop853{}, {.constraint_rcond_limit = 1e-4});
  CHECK(strict.outcome == Outcome::constraint_failure);
  CHECK(contains(strict.message, "'ramp' depends on those before it"));
}

TEST_CASE("a conserved energy drifts by less than the tolerances allow") {
  for (const double rtol : {1e-4, 1e-7, 1e-10, 1e-13}) {
    const auto run = simulate(double_pendulum, raised, 10.0, Dop853{}, {.rtol = rtol, .atol = rtol});
    REQUIRE(run.completed());
    CHECK(run.statistics.energy_drift > 0.0);
    CHECK(run.statistics.energy_drift < run.statistics.energy_allowed);
  }
}

// The mass falls by 0.2 where q passes 0.5, and no force shows it; nor does a comparison, for it is one of plain numbers.
struct Stair {
  auto operator()(const auto& q) const { return innermost_value(q[0]) > 0.5 ? 0.5 * q[0] * q[0] + 0.2 : 0.5 * q[0] * q[0]; }
};

TEST_CASE("a potential that is not what its derivative says is found out by the energy, and the motion so far is kept") {
  const auto stair = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, Stair{});
  const auto run = simulate(stair, stretched, 100.0, Dop853{});
  REQUIRE(run.outcome == Outcome::energy_drift);
  CHECK(failed(run.outcome));
  CHECK(run.t > 0.0);
  CHECK(run.t < 10.0);
  CHECK(run.trajectory.back_time() == run.t);
  CHECK(contains(run.message, "conserve the energy 0.7, but it has become "));
  CHECK(contains(run.message, std::string(advice(Outcome::energy_drift))));
  CHECK(run.statistics.energy_drift > 1e3 * run.statistics.energy_allowed);

  const auto unwatched = simulate(stair, stretched, 100.0, Dop853{}, {.energy_drift_limit = std::numeric_limits<double>::infinity()});
  CHECK(unwatched.completed());
  CHECK(unwatched.statistics.energy_allowed == 0.0);
}

TEST_CASE("a change of the model at a stop time is nobody's error") {
  double stiffness = 1.0;
  const auto switched = [&](const StepView& step) { stiffness = step.t() >= 5.0 ? 2.0 : 1.0; };
  const auto system = mechanical_system<1>(SpringOf{&stiffness});
  CHECK(simulate(system, stretched, 10.0, Dop853{}, {.stop_times = {5.0}}, switched).completed());
}

TEST_CASE("a step of V that its derivative does not show is found, and the time of it") {
  // Half of the way from 1 to 0 the mass drops by 0.2 without a force: at cos t = 0.5.
  const auto stair = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, Stair{});
  const auto run = simulate(stair, stretched, 100.0, Dop853{});
  REQUIRE(run.outcome == Outcome::energy_drift);
  const double fall = std::acos(0.5);
  const std::size_t at = run.message.find("between t = ");
  REQUIRE(at != std::string::npos);
  CHECK(std::stod(run.message.substr(at + 12)) <= fall);
  CHECK(std::stod(run.message.substr(run.message.find("and t = ", at) + 8)) >= fall);
}

TEST_CASE("energy that nobody promised to keep is not watched") {
  const auto driven = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                           [](const auto& q, const auto& t) { return 0.5 * (1.0 + t) * q[0] * q[0]; });
  const auto run = simulate(driven, stretched, 100.0, Dop853{});
  CHECK(run.completed());
  CHECK(run.statistics.energy_allowed == 0.0);
}

TEST_CASE("what an impact takes from the energy is no drift") {
  const auto ball = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 9.81 * q[0]; });
  const auto floor = events(event("floor", [](const auto& q) { return q[0]; }).falling().action([](State<1>& s) { s.qdot *= -0.5; }));
  const auto run = simulate(ball, stretched, 1.0, Dop853{}, {}, floor);
  CHECK(run.completed());
  CHECK(run.events.size() >= 2);
  CHECK(run.statistics.energy_drift <= run.statistics.energy_allowed);
}

TEST_CASE("a run ends by name where V has no value, though its slope would be a number") {
  const auto T = [](const auto& v) { return 0.5 * v[0] * v[0]; };
  const auto ends = [](const auto& system, const State<1>& start, const auto& method) {
    try {
      const auto run = simulate(system, start, 2.0, method);
      return std::string(name(run.outcome)) + (contains(run.message, "V is nan") ? ": V" : "");
    } catch (const NonFinite& error) {  // at the start, where there is nothing to keep
      return "non_finite: " + error.component();
    }
  };
  constexpr double k = 1.0, R = 1.5;
  const auto finite_spring = mechanical_system<1>(T, [](const auto& q) {
    using std::log;
    return -0.5 * k * R * R * log(1.0 - q[0] * q[0] / (R * R));
  });
  const State<1> too_long{0.0, V1(1.6), V1(0.0)};
  CHECK(ends(finite_spring, too_long, Dop853{}) == "non_finite: V");
  CHECK(ends(finite_spring, too_long, Taylor{}) == "non_finite: V");
  // A formula that is simpler than what it stands for: to a series, this V is q.
  const auto root_squared = mechanical_system<1>(T, [](const auto& q) {
    using std::pow, std::sqrt;
    return pow(sqrt(q[0]), 2);
  });
  const State<1> falling{0.0, V1(0.5), V1(-1.0)};
  CHECK(ends(root_squared, falling, Dop853{}) == "non_finite: V");
  CHECK(ends(root_squared, falling, Taylor{}) == "non_finite: V");
  // A constant moves nothing, but the energy is none.
  const auto lifted = mechanical_system<1>(T, [](const auto& q) {
    using std::log;
    return q[0] * q[0] + log(-R);
  });
  CHECK(ends(lifted, falling, Dop853{}) == "non_finite: V");
}

TEST_CASE("a run that loses more than a quarter of its energy does not count as completed, whatever its tolerances allow") {
  // a spring of 1 kHz over 10 s: at rtol = 1e-3 each step may change a thousandth
  const auto spring = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.5e6 * q[0] * q[0]; });
  for (const double rtol : {1e-2, 1e-3}) {
    const auto run = simulate(spring, stretched, 10.0, Dop853{}, {.rtol = rtol, .atol = rtol});
    CHECK(run.outcome == Outcome::energy_drift);
    CHECK(run.t == 10.0);
    CHECK(run.statistics.energy_drift < run.statistics.energy_allowed);
  }
  CHECK(simulate(spring, stretched, 10.0, Dop853{}, {.rtol = 1e-6, .atol = 1e-6}).completed());
}
