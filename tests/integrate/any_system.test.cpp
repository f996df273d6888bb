// SPDX-License-Identifier: MIT
#include "qdot/integrate/any_system.hpp"

#include <cmath>
#include <map>
#include <string>

#include "catch2_bridge.hpp"
#include "error_message.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/input.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

using namespace qdot;

namespace {

const Options fine{.rtol = 1e-12, .atol = 1e-14};
constexpr double integrated = 1e-10;  // of rtol = 1e-12 over a second or two

const auto swing = mechanical_system<1>([](const auto& q, const auto& v) { return 0.5 * v[0] * v[0] + 0.0 * q[0]; },
                                        [](const auto& q) { return -9.81 * cos(q[0]); });
const auto plane = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return 9.81 * q[1]; });
const auto hung = scene(plane, holonomic("rod", [](const auto& q) { return q.squaredNorm() - 1.0; }));
const auto ball = scene(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 9.81 * q[0]; }),
                        contact("floor", [](const auto& q) { return q[0]; }, {0.8}));

}  // namespace

TEST_CASE("one loop over systems of different types moves each as its closed form says") {
  const auto damped = scene(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.5 * q[0] * q[0]; }),
                            viscous_damping(Vector<double, 1>(2.0)));
  struct Expected {
    AnySystem system;
    State<Dynamic> start;
    double q;
  };
  const double g = 9.81, fall = std::sqrt(2 / g), rest = 1.0 - fall;  // the ball leaves the floor with 0.8 of its speed
  const std::map<std::string, Expected> all = {
      {"creep", {damped, {0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)}, 2.0 * std::exp(-1.0)}},  // (1 + t) e^-t
      {"throw", {plane, {0.0, Vector<double, 2>(3.0, 0.0), Vector<double, 2>(-2.0, 0.0)}, 1.0}},
      {"ball", {ball, {0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)}, 0.8 * g * fall * rest - 0.5 * g * rest * rest}}};
  for (const auto& [name, expected] : all) {
    const auto run = simulate(expected.system, expected.start, 1.0, Dop853{}, fine);
    INFO(name << ": " << run.message);
    REQUIRE(run.completed());
    CHECK(std::abs(run.y[0] - expected.q) < integrated);
  }
}

TEST_CASE("a hidden system has the steps, the events and the bits of its type, on constraints, through contacts and with states of effects") {
  const auto same = [](const auto& system, const auto& start, double t_end) {
    const AnySystem hidden = system;
    const auto known = simulate(system, start, t_end, Dop853{}, fine);
    const auto run = simulate(hidden, start, t_end, Dop853{}, fine);
    REQUIRE(known.completed());
    CHECK(run.outcome == known.outcome);
    CHECK(run.y == known.y);
    CHECK(run.statistics.steps == known.statistics.steps);
    CHECK(run.statistics.evaluations == known.statistics.evaluations);
    REQUIRE(run.events.size() == known.events.size());
    for (std::size_t i = 0; i < run.events.size(); ++i) {
      CHECK(run.events[i].t == known.events[i].t);
      CHECK(run.events[i].name == known.events[i].name);
    }
    for (Eigen::Index i = 0; i < hidden.size(); ++i) CHECK(hidden.component_name(i) == first_order_form(system).component_name(i));
  };
  same(swing, State<1>{0.0, Vector<double, 1>(2.0), Vector<double, 1>(0.5)}, 5.0);
  same(hung, State<2>{0.0, {1.0, 0.0}, {0.0, 0.0}}, 2.0);
  same(ball, State<1>{0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)}, 3.0);
  same(scene(swing, input("motor", 0, 0.3)), State<1>{0.0, Vector<double, 1>(2.0), Vector<double, 1>(0.0)}, 2.0);
}

TEST_CASE("events, energies and errors of a hidden system are those of its type") {
  const AnySystem system = hung;
  const State<2> start{0.0, {1.0, 0.0}, {0.0, -1.0}};
  CHECK(energy(system, start) == 0.5);
  const auto lowest = event("lowest", [](const auto& q) { return q[0]; }).stop();
  const auto run = simulate(system, start, 2.0, Dop853{}, fine, lowest);
  REQUIRE(run.outcome == Outcome::stopped_by_event);
  CHECK(std::abs(run.state().qdot.norm() - std::sqrt(1.0 + 2 * 9.81)) < integrated);

  CHECK(error_message([&] {
          simulate(system, State<2>{0.0, {1.1, 0.0}, {0.0, 0.0}}, 1.0, Dop853{});
        }).find("a start must satisfy the constraints, but q0 = 1.1") == 0);
  CHECK_THROWS_AS(simulate(system, State<1>{0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)}, 1.0, Dop853{}), DimensionError);
  CHECK_THROWS_AS(energy(system, State<1>{0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)}), DimensionError);
}

TEST_CASE("an event that changes the mass of a hidden system changes its motion") {
  // A force of one on the mass m: q = 1/2 and v = 1 at t = 1, where m = 1 becomes 4; then 1/2 + 1 + 1/8 at t = 2. With n known at run time M is kept.
  double m = 1.0;
  const AnySystem system = mechanical_system(2, [&m](const auto& v) { return 0.5 * m * v.squaredNorm(); }, [](const auto& q) { return -1.0 * q[0]; });
  const auto loaded = event("loaded", [](const auto& q) { return q[0] - 0.5; }).action([&m](State<Dynamic>&) { m = 4.0; });
  const auto run = simulate(system, State<2>{0.0, {0.0, 0.0}, {0.0, 0.0}}, 2.0, Dop853{}, fine, loaded);
  INFO(run.message);
  REQUIRE(run.completed());
  CHECK(std::abs(run.y[0] - 1.625) < integrated);
}
