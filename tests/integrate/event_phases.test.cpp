// SPDX-License-Identifier: MIT
//
// Which phase follows when several are possible: resting or one more hop, one support or two, the edge of the model.
#include <cmath>
#include <string>
#include <vector>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

using qdot::contact;
using qdot::Dop853;
using qdot::scene;
using qdot::simulate;
using qdot::State;

namespace {

using Eigen::Vector2d;
using V1 = qdot::Vector<double, 1>;
constexpr double g = 9.81;

const auto falling = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return g * q[0]; });
const auto height = [](const auto& q) { return q[0]; };

std::vector<std::string> names(const std::vector<qdot::RecordedEvent>& list) {
  std::vector<std::string> result;
  for (const auto& e : list) result.push_back(e.name);
  return result;
}

}  // namespace

TEST_CASE("hops lower than a hundred tolerances are left out, and no others") {
  // From the height 1 the k-th hop rises to e²ᵏ: the first below 100 atol = 1e-6 is the 31st of e = 0.8.
  const auto run = simulate(scene(falling, contact("floor", height, qdot::restitution(0.8))), State<1>{0.0, V1(1.0), V1(0.0)}, 5.0, Dop853{},
                            {.rtol = 1e-9, .atol = 1e-8});
  REQUIRE(run.completed());
  REQUIRE(run.events.size() == 32);
  CHECK(run.events[30].name == "floor");
  CHECK(run.events[31].name == "floor rests");
  CHECK(run.events[31].t == run.events[30].t);
  CHECK(run.y[1] == 0.0);
}

TEST_CASE("a beam that is loaded beyond one of its supports leaves the other") {
  // Height y of the middle, slope θ, supports at x = ±1; m = 1, J = 4, and a weight of 2 m g that pulls at x = 2. If both supports held, the
  // left one would have to pull with m g / 2. So it opens, and about the right one (m + J) θ̈ = −m g.
  const auto beam = qdot::mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + 4.0 * v[1] * v[1]); },
                                               [](const auto& q) { return g * q[0] + 2.0 * g * (q[0] + 2.0 * q[1]); });
  const auto s = scene(beam, contact("left", [](const auto& q) { return q[0] - q[1]; }), contact("right", [](const auto& q) { return q[0] + q[1]; }));
  const State<2> start{0.0, Vector2d(0, 0), Vector2d(0, 0)};
  const auto z = settled_states(s, start);
  CHECK(z == Vector2d(0, 1));  // apart, closed
  const auto solution = constrained_acceleration(s, start.q, start.qdot, 0.0, z);
  CHECK_THAT(solution.lambda[1], WithinAbs(3.2 * g, 1e-12));
  CHECK((solution.qddot - 0.2 * g * Vector2d(1, -1)).norm() < 1e-12);
  const auto run = simulate(s, start, 0.1, Dop853{});
  REQUIRE(run.completed());
  CHECK(run.events.empty());
  CHECK_THAT(run.y[0], WithinAbs(0.001 * g, 1e-12));
}

TEST_CASE("a run ends at the edge of what its model describes") {
  const auto run = simulate(scene(falling, qdot::boundary("edge", [](const auto& q) { return q[0] - 0.5; })), State<1>{0.0, V1(1.0), V1(0.0)}, 5.0,
                            Dop853{});
  REQUIRE(run.outcome == qdot::Outcome::stopped_by_event);
  CHECK(names(run.events) == std::vector<std::string>{"edge"});
  CHECK_THAT(run.t, WithinAbs(std::sqrt(1.0 / g), 1e-10));
  CHECK_THAT(run.y[0], WithinAbs(0.5, 1e-12));
  CHECK(run.y[1] < -3.0);  // no blow
}

TEST_CASE("friction at a crank's slider turns at each dead centre and takes F times the way, until it sticks") {
  // Scotch yoke: x = cos θ, T = ½ (J θ̇² + m ẋ²), J = 1. From x = 1 with θ̇ = 3 the energy 4.5 lasts for a way of 4.5/0.4 = 11.25,
  // five strokes of length 2 and 1.25 of the sixth.
  const auto yoke = qdot::mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + 0.5 * v[1] * v[1]); }).with_names({"theta", "x"});
  const auto s = scene(yoke, qdot::holonomic("slot", [](const auto& q) {
                         using std::cos;
                         return q[1] - cos(q[0]);
                       }),
                       qdot::dry_friction("slider", 1, 0.4));
  const auto run = simulate(s, State<2>{0.0, Vector2d(0, 1), Vector2d(3, 0)}, 20.0, Dop853{}, {.rtol = 1e-12, .atol = 1e-13});
  REQUIRE(run.completed());
  std::vector<std::string> expected(5, "slider turns");
  expected.push_back("slider sticks");
  REQUIRE(names(run.events) == expected);
  for (std::size_t k = 0; k < 5; ++k) {
    const auto at = run.trajectory.at(run.events[k].t);
    CHECK_THAT(at.q[0], WithinAbs(static_cast<double>(k + 1) * std::acos(-1.0), 1e-9));
    CHECK_THAT(at.qdot[0] * at.qdot[0], WithinAbs(9.0 - 1.6 * static_cast<double>(k + 1), 1e-9));
  }
  CHECK_THAT(run.y[1], WithinAbs(0.25, 1e-9));
  constexpr double rounding_of_rounding = 1e-30;  // a projection leaves 1e-16 of the velocity, 1e-14, with which it sticks
  CHECK(std::abs(run.y[2]) < rounding_of_rounding);
}

TEST_CASE("friction on a driven coordinate turns at each dead centre, at all tolerances") {
  // x = sin t turns at π/2, 3π/2, …, 32 times before t = 100; no friction holds it.
  const auto driven = scene(qdot::mechanical_system<1>([](const auto& v) { return v[0] * v[0]; }, [](const auto& q) { return 0.0 * q[0]; }),
                            qdot::prescribed("drive", 0, [](const auto& t) {
                              using std::sin;
                              return sin(t);
                            }),
                            qdot::dry_friction("bearing", 0, 3.0));
  for (const double rtol : {1e-6, 1e-9, 1e-11, 1e-12}) {
    const auto run = simulate(driven, State<1>{0.0, V1(0.0), V1(1.0)}, 100.0, Dop853{}, {.rtol = rtol, .atol = 1e-3 * rtol});
    REQUIRE(run.completed());
    REQUIRE(names(run.events) == std::vector<std::string>(32, "bearing turns"));
    // The root is that of a step's polynomial, which the projection onto the drive then moves by the step's error.
    for (std::size_t k = 0; k < 32; ++k) CHECK_THAT(run.events[k].t, WithinAbs((static_cast<double>(k) + 0.5) * std::acos(-1.0), 100 * rtol));
  }
}

TEST_CASE("frictions on one mass slip together, when no split of the load is within their limits") {
  // The push t/10 reaches F_s = 1 + 2 at t = 30; then x = (F_s − F_k) τ²/2 + τ³/60.
  const auto mass = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.0 * q[0]; });
  const auto push = qdot::generalized_force([](const auto& q, const auto&, const auto& t) { return qdot::vector(0.1 * t + 0.0 * q[0]); });
  const auto a = qdot::dry_friction("a", 0, 0.5, 1.0), b = qdot::dry_friction("b", 0, 1.0, 2.0);
  const State<1> rest{0.0, V1(0.0), V1(0.0)};
  for (const auto& run : {simulate(scene(mass, a, b, push), rest, 31.0, Dop853{}), simulate(scene(mass, b, a, push), rest, 31.0, Dop853{})}) {
    REQUIRE(run.completed());
    REQUIRE(run.events.size() == 2);
    for (const auto& e : run.events) CHECK_THAT(e.t, WithinAbs(30.0, 1e-9));
    CHECK_THAT(run.y[0], WithinAbs(0.75 + 1.0 / 60.0, 1e-8));
  }
  // A wall that the mass is pressed against takes what friction leaves: they part where the pull is F_s of the friction.
  const auto pull = qdot::generalized_force([](const auto& q, const auto&, const auto& t) { return qdot::vector(0.1 * t - 2.0 + 0.0 * q[0]); });
  const auto run = simulate(scene(mass, a, contact("wall", height), pull), rest, 31.0, Dop853{});
  REQUIRE(names(run.events) == std::vector<std::string>{"a slips", "wall opens"});
  CHECK_THAT(run.events[1].t, WithinAbs(30.0, 1e-9));
  CHECK_THAT(run.y[0], WithinAbs(0.25 + 1.0 / 60.0, 1e-8));
}

TEST_CASE("a closed contact opens where its floor is taken away, and is refused where the floor is raised into the body") {
  double floor = 0.0;
  const auto ball = scene(falling, contact("floor", [&floor](const auto& q) { return q[0] - floor; }, qdot::restitution(0.5)));
  const State<1> rest{0.0, V1(0.0), V1(0.0)};
  const auto half = qdot::event("half", [](const auto&, const auto&, const auto& t) { return t - 0.5; });
  const auto moved_to = [&](double level) {
    floor = 0.0;
    return simulate(ball, rest, 1.0, Dop853{}, {}, half.action([&floor, level](State<1>&) { floor = level; }));
  };
  const auto dropped = moved_to(-10.0);
  REQUIRE(dropped.completed());
  CHECK(names(dropped.events) == std::vector<std::string>{"half", "floor opens"});
  CHECK_THAT(dropped.y[0], WithinAbs(-g / 8, 1e-9));
  const auto raised = moved_to(0.1);
  REQUIRE(raised.outcome == qdot::Outcome::constraint_failure);
  CHECK(raised.message.find("that of 'floor' is -0.1") != std::string::npos);
  CHECK(raised.y[0] == 0.0);
  CHECK(moved_to(1e-13).completed());  // less than the method can tell
  // A floor that jumps at a stop time, and a force that does.
  qdot::Options stops;
  stops.stop_times = {0.5};
  const auto by_time = scene(falling, contact("floor", [](const auto& q, const auto& t) { return q[0] + (t > 0.5 ? 1.0 : 0.0); }));
  CHECK_THAT(simulate(by_time, rest, 0.9, Dop853{}, stops).y[0], WithinAbs(-0.08 * g, 1e-9));
  const auto gust = qdot::generalized_force([](const auto& q, const auto&, const auto& t) { return qdot::vector((t > 0.5 ? 20.0 : 0.0) + 0.0 * q[0]); });
  CHECK_THAT(simulate(scene(falling, contact("floor", height), gust), rest, 0.9, Dop853{}, stops).y[0], WithinAbs(0.08 * (20.0 - g), 1e-9));
  // One that moves smoothly takes the ball along.
  const auto wave = scene(falling, contact("floor", [](const auto& q, const auto& t) {
                            using std::sin;
                            return q[0] - 0.1 * sin(3.0 * t);
                          }));
  const auto carried = simulate(wave, State<1>{0.0, V1(0.0), V1(0.3)}, 0.9, Dop853{}, stops);
  CHECK(carried.events.empty());
  CHECK_THAT(carried.y[0], WithinAbs(0.1 * std::sin(2.7), 1e-12));
}

TEST_CASE("an action that kicks what rests is felt: contacts only push, and friction bears no blow") {
  const auto half = qdot::event("half", [](const auto&, const auto&, const auto& t) { return t - 0.5; });
  const State<1> rest{0.0, V1(0.0), V1(0.0)};
  const auto kick = [](double speed) { return [speed](State<1>& s) { s.qdot[0] = speed; }; };
  const auto ball = scene(falling, contact("floor", height, qdot::restitution(0.5)));
  CHECK_THAT(simulate(ball, rest, 0.6, Dop853{}, {}, half.action(kick(1.0))).y[0], WithinAbs(0.1 - 0.005 * g, 1e-9));
  CHECK_THAT(simulate(ball, rest, 0.55, Dop853{}, {}, half.action(kick(-1.0))).y[0], WithinAbs(0.025 - 0.00125 * g, 1e-9));  // it comes back with 0.5
  const auto block = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.0 * q[0]; });
  const auto run = simulate(scene(block, qdot::dry_friction("ground", 0, 0.5, 1.0)), rest, 1.0, Dop853{}, {}, half.action(kick(1.0)));
  CHECK(names(run.events) == std::vector<std::string>{"half", "ground slips"});
  CHECK_THAT(run.y[0], WithinAbs(0.5 - 0.25 * 0.25, 1e-9));
}

TEST_CASE("a crank at rest at its dead centre starts, however strong the friction at its slider") {
  const auto yoke = qdot::mechanical_system<2>([](const auto& v) { return 0.5 * v[0] * v[0] + 0.05 * v[1] * v[1]; },
                                               [](const auto& q) { return -q[0]; });  // a torque of 1
  const auto s = scene(yoke, qdot::holonomic("slot", [](const auto& q) {
                         using std::cos;
                         return q[1] - cos(q[0]);
                       }),
                       qdot::dry_friction("slider", 1, 2.0));
  // The torque's work θ is used up by friction, 2 (1 − cos θ), at θ = 1.1091441816596; there it sticks, as 2 sin θ > 1.
  const auto run = simulate(s, State<2>{0.0, Vector2d(0, 1), Vector2d(0, 0)}, 10.0, Dop853{}, {.rtol = 1e-12, .atol = 1e-13});
  REQUIRE(run.completed());
  REQUIRE_FALSE(run.events.empty());
  CHECK(run.events.back().name == "slider sticks");
  CHECK_THAT(run.y[0], WithinAbs(1.1091441816596, 1e-9));
  CHECK(std::abs(run.y[2]) < 1e-12);
}

TEST_CASE("a push on a pendulum in Cartesian coordinates is felt along its circle only") {
  const auto s = scene(qdot::mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return g * q[1]; }),
                       qdot::holonomic("rod", [](const auto& q) { return q.squaredNorm() - 1.0; }));
  const auto push = [](State<2>& state) { state.qdot += Vector2d(0.5, 3.0); };
  const auto run = simulate(s, State<2>{0.0, Vector2d(-0.6, -0.8), Vector2d(0, 0)}, 1.0, Dop853{}, {.rtol = 1e-12, .atol = 1e-13},
                            qdot::events(qdot::event("bottom", height).rising().action(push)));
  REQUIRE(names(run.events) == std::vector<std::string>{"bottom"});
  const auto before = run.trajectory.before(run.events[0].t), after = run.trajectory.at(run.events[0].t);
  CHECK_THAT(before.qdot[0], WithinAbs(std::sqrt(0.4 * g), 1e-9));
  CHECK((after.qdot - Vector2d(before.qdot[0] + 0.5, 0.0)).norm() < 1e-9);
  CHECK(run.statistics.constraint_velocity < 1e-14);
}

TEST_CASE("a run backward in time ends where it meets an impact, and says why") {
  const auto s = scene(falling, contact("floor", height, qdot::restitution(0.5)));
  const auto run = simulate(s, State<1>{1.0, V1(0.5), V1(1.0)}, 0.0, Dop853{});
  REQUIRE(run.outcome == qdot::Outcome::constraint_failure);
  CHECK(run.message.find("a run backward in time must not meet an impact") != std::string::npos);
  CHECK_THAT(run.t, WithinAbs(1.0 - (std::sqrt(1.0 + g) - 1.0) / g, 1e-9));
  CHECK(simulate(s, State<1>{1.0, V1(0.5), V1(1.0)}, 0.8, Dop853{}).completed());
}

TEST_CASE("a run goes on from where another ended, phases and all") {
  // A block that sticks on a spring stays there, a ball that rests keeps resting: y holds the phases.
  const auto s = scene(falling, contact("floor", height, qdot::restitution(0.5)));
  const auto first = simulate(s, State<1>{0.0, V1(1.0), V1(0.0)}, 3.0, Dop853{});
  const auto second = simulate(s, qdot::FirstOrderState{first.t, first.y}, 4.0, Dop853{});
  REQUIRE(second.completed());
  CHECK(second.events.empty());
  CHECK(second.y == first.y);
}
