// SPDX-License-Identifier: MIT
#include "qdot/integrate/simulator.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "catch2_bridge.hpp"
#include "error_message.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/runge_kutta.hpp"

using namespace qdot;

namespace {

// A mass of 1 kg on a line, pushed by a motor; by a spring, if it has one.
struct Mass {
  double k = 0.0;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const { return 0.5 * k * q[0] * q[0]; }
};
auto pushed(double k = 0.0) { return scene(mechanical_system<1>(Mass{k}), input("motor", 0)); }
const State<1> at_rest{0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)};
const Options fine{.rtol = 1e-12, .atol = 1e-14};
constexpr double rounded = 1e-13;     // of polynomials that the method integrates exactly
constexpr double integrated = 1e-10;  // of what it integrates to rtol, over some seconds

bool same(const SimulatorState& a, const SimulatorState& b) { return a.t == b.t && a.y == b.y; }

}  // namespace

TEST_CASE("a mass that is pushed moves as Newton says, with every push held from one advance to the next") {
  Simulator plant(pushed(), at_rest, Dop853{}, fine);
  double x = 1.0, v = 0.0;
  for (int k = 1; k <= 20; ++k) {
    const double push = k % 3 - 1.0;
    plant.set_input("motor", push);
    REQUIRE(plant.advance_to(0.1 * k));
    x += 0.1 * v + 0.005 * push;
    v += 0.1 * push;
    CHECK(std::abs(plant.q()[0] - x) < rounded);
    CHECK(std::abs(plant.qdot()[0] - v) < rounded);
    CHECK(plant.t() == 0.1 * k);
    CHECK(plant.input("motor") == push);
  }
  CHECK(plant.input_names() == std::vector<std::string>{"motor"});
  CHECK(plant.state<1>().q[0] == plant.q()[0]);
  plant.reset();
  CHECK(plant.t() == 0.0);
  CHECK(plant.q()[0] == 1.0);
  CHECK(plant.input("motor") == 0.0);
}

TEST_CASE("the same bits come after save and restore, in the same simulator, in another, and through bytes") {
  const auto system = pushed(4.0);
  Simulator first(system, at_rest, Dop853{}, fine), second(system, at_rest, Dop853{}, fine);
  first.set_input(0, 0.3);
  REQUIRE(first.advance(1.7));
  const SimulatorState saved = first.save();
  const auto go_on = [](Simulator& plant) {
    for (int k = 0; k < 50; ++k) {
      plant.set_input(0, std::sin(plant.q()[0]));
      REQUIRE(plant.advance(0.013));
    }
    return plant.save();
  };
  const SimulatorState expected = go_on(first);
  first.restore(saved);
  CHECK(same(go_on(first), expected));
  second.restore(deserialized(serialized(saved)));
  CHECK(same(go_on(second), expected));
}

TEST_CASE("a harmonic oscillator in advances of a millisecond swings as its closed form") {
  Simulator plant(pushed(4.0), at_rest, Dop853{}, fine);
  for (int k = 1; k <= 1000; ++k) REQUIRE(plant.advance_to(1e-3 * k));
  CHECK(std::abs(plant.q()[0] - std::cos(2.0)) < integrated);
  CHECK(std::abs(plant.qdot()[0] + 2.0 * std::sin(2.0)) < integrated);
}

TEST_CASE("events of an advance are reported with their times, and one that stops leaves the state of its moment") {
  const auto half = event("through the middle", [](const auto& q) { return q[0]; });
  Simulator seen(pushed(4.0), at_rest, Dop853{}, fine, half);
  REQUIRE(seen.advance_to(3.0));
  REQUIRE(seen.events().size() == 2);
  CHECK(std::abs(seen.events()[0].t - std::numbers::pi / 4) < integrated);
  CHECK(std::abs(seen.events()[1].t - 3 * std::numbers::pi / 4) < integrated);
  REQUIRE(seen.advance(0.01));
  CHECK(seen.events().empty());

  Simulator stopped(pushed(4.0), at_rest, Dop853{}, fine, half.stop());
  const Advance cut = stopped.advance_to(3.0);
  CHECK(cut.outcome == Outcome::stopped_by_event);
  CHECK(std::abs(cut.t - std::numbers::pi / 4) < integrated);
  CHECK(std::abs(stopped.q()[0]) < integrated);
  const SimulatorState there = stopped.save();
  REQUIRE(stopped.advance_to(1.0));  // and it may go on
  CHECK(std::abs(stopped.q()[0] - std::cos(2.0)) < integrated);
  const SimulatorState later = stopped.save();
  stopped.restore(deserialized(serialized(there)));  // also after a restore
  REQUIRE(stopped.advance_to(1.0));
  CHECK(same(stopped.save(), later));
  CHECK(stopped.advance_to(3.0).outcome == Outcome::stopped_by_event);  // and stops when it comes again
  CHECK(std::abs(stopped.t() - 3 * std::numbers::pi / 4) < integrated);
}

TEST_CASE("a pendulum in Cartesian coordinates stays on its rod through ten thousand advances") {
  const auto pendulum = scene(mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return 9.81 * q[1]; }),
                              holonomic("rod", [](const auto& q) { return q.squaredNorm() - 1.0; }));
  Simulator plant(pendulum, State<2>{0.0, Vector<double, 2>(0.6, -0.8), Vector<double, 2>(0.0, 0.0)}, Dop853{}, fine);
  double farthest = 0.0;
  for (int k = 1; k <= 1000; ++k) {
    REQUIRE(plant.advance_to(1e-3 * k));
    farthest = std::max(farthest, std::abs(plant.q().squaredNorm() - 1.0));
  }
  CHECK(farthest < 1e-14);  // a few rounding units
  const double energy = 0.5 * plant.qdot().squaredNorm() + 9.81 * plant.q()[1];
  CHECK(std::abs(energy + 9.81 * 0.8) < integrated);
}

TEST_CASE("limits of work are those of each advance, and what was reached stays") {
  Options few = fine;
  few.max_steps = 3;
  Simulator plant(pushed(400.0), at_rest, Dop853{}, few);
  double before = 0.0;
  for (int k = 0; k < 4; ++k) {
    const Advance part = plant.advance_to(100.0);
    CHECK(part.outcome == Outcome::step_limit);
    CHECK(part.t > before);
    CHECK(plant.t() == part.t);
    before = part.t;
  }
  CHECK(plant.message().find("max_steps = 3") != std::string::npos);
  CHECK(std::abs(plant.q()[0] - std::cos(20.0 * plant.t())) < integrated);
  REQUIRE(plant.advance(1e-3));
  CHECK(plant.message().empty());
}

TEST_CASE("what functors throw is an outcome with their words, and the last good state stays") {
  const auto fragile = scene(mechanical_system<1>(Mass{}), input("motor", 0), generalized_force([](const auto& q, const auto&) {
                               if (innermost_value(q[0]) > 1.5) throw std::runtime_error("the rope is too short");
                               auto Q = q;
                               Q[0] = 0.0;
                               return Q;
                             }));
  Simulator plant(fragile, at_rest, Dop853{}, fine);
  plant.set_input("motor", 1.0);
  REQUIRE(plant.advance_to(0.5));
  const Advance end = plant.advance_to(5.0);
  CHECK(end.outcome == Outcome::refused_by_model);
  CHECK(plant.message().find("the rope is too short") != std::string::npos);
  CHECK(end.t > 0.6);  // the steps before it count: x = 1.5 at t = 1
  CHECK(std::abs(plant.q()[0] - (1.0 + 0.5 * end.t * end.t)) < rounded);
  plant.set_input("motor", -10.0);  // there is a way back
  CHECK(plant.advance(0.01));
}

TEST_CASE("a simulator refuses what it cannot do by rule, value and remedy, and keeps what it had") {
  Simulator plant(pushed(), at_rest, Dop853{}, fine);
  REQUIRE(plant.advance_to(1.0));
  const SimulatorState before = plant.save();
  CHECK(plant.advance(-0.5).outcome == Outcome::invalid_change);
  CHECK(plant.message() == "an advance must go forward to a finite t, but from t = 1 was sent to 0.5; go back by restore() of a state that was saved there");
  CHECK(plant.advance_to(std::numeric_limits<double>::quiet_NaN()).outcome == Outcome::invalid_change);
  CHECK(error_message([&] { plant.set_input("motor", std::numeric_limits<double>::infinity()); }).find("'motor' was given inf") != std::string::npos);
  CHECK(error_message([&] { plant.set_input("rudder", 1.0); }).find("'rudder' is none; it has motor") != std::string::npos);
  CHECK_THROWS_AS(plant.set_inputs(std::vector<double>{1.0, 2.0}), DimensionError);
  CHECK_THROWS_AS(plant.state<2>(), DimensionError);
  CHECK(same(plant.save(), before));

  std::vector<std::byte> bytes = serialized(before);
  for (const std::size_t i : {std::size_t(0), std::size_t(9), std::size_t(33), bytes.size() - 1}) {
    std::vector<std::byte> broken = bytes;
    broken[i] ^= std::byte(4);
    CHECK_THROWS_AS(deserialized(broken), InvalidValue);
  }
  bytes.pop_back();
  CHECK(error_message([&] { deserialized(bytes); }).find("another length") != std::string::npos);
  const Simulator other(mechanical_system<1>(Mass{}), at_rest, Dop853{});
  CHECK_THROWS_AS(plant.restore(other.save()), InvalidValue);
  CHECK(same(plant.save(), before));
  CHECK_THROWS_AS(Simulator(pushed(), at_rest, Dop853{}, {.stop_times = {0.5}}), InvalidValue);
  CHECK_THROWS_AS(Simulator(pushed(), State<1>{0.0, Vector<double, 1>(std::nan("")), Vector<double, 1>(0.0)}, Dop853{}), InvalidValue);
}

TEST_CASE("an oscillator under a force that is linear between instants moves as its closed form, however it is advanced") {
  // x'' = -4 x + a + b s from (x0, v0): x = (a + b s)/4 + (x0 - a/4) cos 2s + (v0 - b/4)/2 sin 2s.
  const auto driven = scene(mechanical_system<1>(Mass{4.0}), interpolated(input("motor", 0, 0.5)));
  Simulator in_steps(driven, at_rest, Dop853{}, fine), past_the_end(driven, at_rest, Dop853{}, fine);
  double x = 1.0, v = 0.0, u = 0.5;
  const double targets[] = {2.0, -1.0, -1.0, 0.7}, T = 0.3;
  for (int k = 0; k < 4; ++k) {
    in_steps.ramp_input("motor", targets[k], T * (k + 1));
    if (k == 2) past_the_end.set_input("motor", -1.0);
    if (k != 2) past_the_end.ramp_input("motor", targets[k], T * (k + 1));
    for (const double part : {0.4, 1.0}) REQUIRE(in_steps.advance_to(part < 1.0 ? T * (k + part) : T * (k + 1)));
    REQUIRE(past_the_end.advance_to(T * (k + 1)));
    const double b = (targets[k] - u) / T, xs = (u + b * T) / 4 + (x - u / 4) * std::cos(2 * T) + (v - b / 4) / 2 * std::sin(2 * T);
    v = b / 4 - 2 * (x - u / 4) * std::sin(2 * T) + (v - b / 4) * std::cos(2 * T);
    x = xs;
    u = targets[k];
    for (const Simulator* plant : {&in_steps, &past_the_end}) {
      CHECK(plant->input("motor") == u);
      CHECK(std::abs(plant->q()[0] - x) < integrated);
      CHECK(std::abs(plant->qdot()[0] - v) < integrated);
    }
  }
}

TEST_CASE("an advance beyond the end of a ramp holds its value from there, reports what happened before and behind it, and restores to the bit") {
  const auto crossing = event("through the middle", [](const auto& q) { return q[0] - 1.02; });
  Simulator plant(scene(mechanical_system<1>(Mass{}), interpolated(input("motor", 0))), at_rest, Dop853{}, fine, crossing);
  plant.ramp_input("motor", 1.0, 1.0);  // x = 1 + t^3/6 up to t = 1, and 7/6 + s/2 + s^2/2 behind it
  REQUIRE(plant.advance_to(0.25));
  CHECK(std::abs(plant.input("motor") - 0.25) < rounded);
  const SimulatorState saved = plant.save();
  REQUIRE(plant.advance_to(3.0));
  CHECK(plant.input("motor") == 1.0);
  CHECK(std::abs(plant.q()[0] - (7.0 / 6 + 1.0 + 2.0)) < integrated);
  REQUIRE(plant.events().size() == 1);
  CHECK(std::abs(plant.events()[0].t - std::cbrt(0.12)) < integrated);
  const SimulatorState later = plant.save();
  plant.restore(deserialized(serialized(saved)));
  REQUIRE(plant.advance_to(3.0));
  CHECK(same(plant.save(), later));

  plant.restore(saved);
  plant.ramp_input("motor", 1.0, 0.6);  // through 1.02 before the end of the ramp
  REQUIRE(plant.advance_to(0.6));
  plant.ramp_input("motor", -20.0, 0.7);  // and back behind the end of this one, in a call that passes it
  REQUIRE(plant.advance_to(3.0));
  CHECK(plant.input("motor") == -20.0);
  REQUIRE(plant.events().size() == 1);
  CHECK(plant.events()[0].t > 0.7);

  SimulatorState late = saved;  // a clock that was set on, past the end of the ramp
  late.t = 2.0;
  plant.restore(late);
  REQUIRE(plant.advance_to(2.5));
  CHECK(plant.input("motor") == 1.0);

  plant.restore(saved);
  plant.set_input("motor", 0.0);  // ends the ramp
  REQUIRE(plant.advance_to(2.0));
  CHECK(plant.input("motor") == 0.0);
  CHECK(std::abs(plant.qdot()[0] - 0.25 * 0.25 / 2) < rounded);
  plant.reset();
  CHECK(plant.component_names()[3] == "motor slope");
}

TEST_CASE("a ramp to nowhere is refused by rule, value and remedy, and nothing is changed") {
  Simulator plant(scene(mechanical_system<1>(Mass{}), interpolated(input("motor", 0)), input("held", 0)), at_rest, Dop853{}, fine);
  REQUIRE(plant.advance_to(1.0));
  const SimulatorState before = plant.save();
  const double nan = std::nan("");
  CHECK(error_message([&] { plant.ramp_input("motor", 2.0, 1.0); }) ==
        "a ramp must end at a finite time after now, but at t = 1 'motor' was sent to be there at 1; set_input() jumps");
  CHECK_THROWS_AS(plant.ramp_input("motor", 2.0, nan), InvalidValue);
  CHECK_THROWS_AS(plant.ramp_input("motor", 2.0, std::numeric_limits<double>::infinity()), InvalidValue);
  CHECK_THROWS_AS(plant.ramp_input("motor", nan, 2.0), InvalidValue);
  CHECK_THROWS_AS(plant.ramp_input(2, 1.0, 2.0), InvalidValue);
  CHECK(error_message([&] { plant.ramp_input("motor", 1e300, std::nextafter(1.0, 2.0)); }).find("finite slope") != std::string::npos);
  CHECK(error_message([&] { plant.ramp_input("held", 1.0, 2.0); }).find("'held' is held; make it interpolated(input(…))") != std::string::npos);
  CHECK(same(plant.save(), before));
}
