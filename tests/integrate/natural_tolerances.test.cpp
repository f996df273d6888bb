// SPDX-License-Identifier: MIT
//
// Motions of any size: the springs below swing as q₀ cos ω(t − t₀), and what is asked is the same part of q₀ in all units.
#include "../catch2_bridge.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include "qdot/analysis/sensitivity.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/any_system.hpp"
#include "qdot/integrate/many_in_lanes.hpp"
#include "qdot/integrate/simulator.hpp"
#include "qdot/integrate/taylor.hpp"

using namespace qdot;

namespace {

constexpr double two_pi = 2 * std::numbers::pi;

// Two springs that do not know of each other, ω₁ and ω₂, of mass m.
struct Springs {
  double m, omega_1, omega_2;
  auto T(const auto& v) const { return 0.5 * m * (v[0] * v[0] + v[1] * v[1]); }
  auto V(const auto& q) const { return 0.5 * m * (omega_1 * omega_1 * q[0] * q[0] + omega_2 * omega_2 * q[1] * q[1]); }
};

// rtol = 1e-9 in each of some thousand steps; what adds up is some 1e-8.
constexpr double adds_up = 2e-7;

template <class Method>
void check_in_all_units(const Method& method) {
  struct Units {
    double m, q, omega;
  };
  // 1, a nanometre and less at 1 Hz, a molecule, a planet in SI units
  for (const Units u : {Units{1.0, 1.0, two_pi}, {1.0, 1e-9, two_pi}, {1.0, 1e-15, two_pi}, {1e-26, 1e-11, two_pi * 1e13}, {1e30, 1e11, two_pi / 3e7}}) {
    const auto system = mechanical_system<2>(Springs{u.m, u.omega, 0.5 * u.omega});
    const auto swung = simulate(system, State<2>{0.0, {u.q, u.q}, {0.0, 0.0}}, 40 * two_pi / u.omega, method);
    INFO("q = " << u.q << ", " << swung.message);
    REQUIRE(swung.completed());
    CHECK_THAT(swung.y[0], WithinRel(u.q, adds_up));
    CHECK_THAT(swung.y[1], WithinRel(u.q, adds_up));
    const auto kicked = simulate(system, State<2>{0.0, {0.0, 0.0}, {u.q * u.omega, u.q * u.omega}}, 40.25 * two_pi / u.omega, method);
    REQUIRE(kicked.completed());
    CHECK_THAT(kicked.y[0], WithinRel(u.q, adds_up));
  }
}

}  // namespace

TEST_CASE("a spring swings to the same digits in whatever units, from a displacement and from a kick") {
  check_in_all_units(Dop853{});
  check_in_all_units(Taylor{});
}

TEST_CASE("a motion of 1e-12 beside one of 1 keeps its digits, and one of 1e-10 at 1e10 Hz beside one of 1e11") {
  const auto beside = simulate(mechanical_system<2>(Springs{1.0, two_pi, 2 * two_pi}), State<2>{0.0, {1.0, 1e-12}, {0.0, 0.0}}, 10.0, Dop853{});
  CHECK_THAT(beside.y[0], WithinRel(1.0, adds_up));
  CHECK_THAT(beside.y[1], WithinRel(1e-12, adds_up));
  const auto apart = simulate(mechanical_system<2>(Springs{1.0, 1e-7, two_pi * 1e10}), State<2>{0.0, {1e11, 1e-10}, {0.0, 0.0}}, 40e-10, Dop853{});
  CHECK_THAT(apart.y[1], WithinRel(1e-10, adds_up));
}

TEST_CASE("what rests at the start and is pushed later swings as the push has it") {
  // q̈ + ω² q = a sin t from rest: q = a/(ω² − 1) (sin t − sin(ω t)/ω)
  const double omega = two_pi, a = 1e-12, t = 3.0;
  const auto pushed = scene(mechanical_system<2>(Springs{1.0, omega, omega}), generalized_force([a](const auto& q, const auto&, const auto& time) {
                              using std::sin;
                              auto Q = q;
                              Q[0] = a * sin(time);
                              Q[1] = 0.0 * q[1];
                              return Q;
                            }));
  const auto run = simulate(pushed, State<2>{0.0, {0.0, 0.0}, {0.0, 0.0}}, t, Dop853{});
  CHECK_THAT(run.y[0], WithinRel(a / (omega * omega - 1.0) * (std::sin(t) - std::sin(omega * t) / omega), adds_up));
  CHECK(run.y[1] == 0.0);
}

TEST_CASE("lanes, a simulator, a hidden system and derivatives know the size of a motion, too") {
  const double omega = two_pi * 1e13, q0 = 1e-11, end = 10 * two_pi / omega;
  const auto system = mechanical_system<2>(Springs{1e-26, omega, omega});
  const auto start_of = [&](std::size_t i) { return State<2>{0.0, {q0 * std::pow(1e-3, static_cast<double>(i)), q0}, {0.0, 0.0}}; };
  const auto ends = ensemble(system, 3, start_of, end, Dop853{});
  for (std::size_t i = 0; i < ends.size(); ++i) {
    REQUIRE(ends[i].completed());
    CHECK_THAT(ends[i].value->state.q[0], WithinRel(start_of(i).q[0], adds_up));
  }
  Simulator simulator(system, start_of(0), Dop853{});
  for (int k = 1; k <= 40; ++k) REQUIRE(simulator.advance(end * k / 40).outcome == Outcome::completed);
  CHECK_THAT(simulator.q()[0], WithinRel(q0, adds_up));
  const AnySystem hidden(system);
  CHECK_THAT(simulate(hidden, start_of(0), end, Dop853{}).y[0], WithinRel(q0, adds_up));
  // a quarter of a period later Φ = (0, 1/ω; −ω, 0)
  const auto s = sensitivities(system, start_of(0), 10.25 * two_pi / omega, Dop853{});
  REQUIRE(s.completed());
  CHECK_THAT(s.Phi(0, 2), WithinRel(1.0 / omega, adds_up));
  CHECK_THAT(s.Phi(2, 0), WithinRel(-omega, adds_up));
}

TEST_CASE("without an absolute tolerance components are judged by their size alone, where the method can") {
  const auto system = mechanical_system<2>(Springs{1.0, two_pi, two_pi});
  const auto run = simulate(system, State<2>{0.0, {1e-12, 0.0}, {0.0, 1.0}}, 10.0, Dop853{}, {.atol = 0.0});
  CHECK_THAT(run.y[0], WithinRel(1e-12, adds_up));
  CHECK_THAT(run.y[3], WithinRel(1.0, adds_up));
  CHECK_THROWS_AS(simulate(system, State<2>{0.0, {1e-12, 0.0}, {0.0, 1.0}}, 10.0, Taylor{}, {.atol = 0.0}), InvalidValue);
}

TEST_CASE("a run whose tolerances are larger than its motion does not count as completed") {
  const auto system = mechanical_system<2>(Springs{1.0, two_pi, two_pi});
  for (const double q0 : {1e-12, 1e-14}) {
    const auto run = simulate(system, State<2>{0.0, {q0, 0.0}, {0.0, 0.0}}, 100.0, Dop853{}, {.atol = 1e-12});
    CHECK(run.outcome == Outcome::energy_drift);
    CHECK(run.message.find("are too loose for this motion") != std::string::npos);
  }
}

TEST_CASE("a way of next to nothing, from zero, ends") {
  const auto system = mechanical_system<2>(Springs{1.0, two_pi, two_pi});
  for (const double way : {1e-3, 1e-200, 1e-320})
    CHECK_THAT(simulate(system, State<2>{0.0, {0.0, 1e-9}, {1.0, 0.0}}, way, Dop853{}).y[0], WithinRel(std::sin(two_pi * way) / two_pi, 1e-3));
}

TEST_CASE("what rounding moves has no size: a stuck block and a pendulum on its top take a few steps") {
  constexpr long few = 100;
  const auto mass = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.0 * q[0]; });
  const auto pushed = scene(mass, dry_friction("a", 0, 0.5, 1.0), dry_friction("b", 0, 1.0, 2.0),
                            generalized_force([](const auto& q, const auto&, const auto& t) { return vector(0.1 * t + 0.0 * q[0]); }));
  for (const double place : {0.0, 1e-5, 0.3}) {  // slips at 3 N, then (F_s − F_k) τ²/2 + τ³/60
    const auto run = simulate(pushed, State<1>{0.0, Vector<double, 1>(place), Vector<double, 1>(0.0)}, 31.0, Dop853{});
    REQUIRE(run.completed());
    CHECK(run.statistics.steps < few);
    CHECK(std::abs(run.y[0] - place - (0.75 + 1.0 / 60.0)) < 1e-8);
  }
  const auto pendulum = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) {
    using std::cos;
    return -9.81 * cos(q[0]);
  });
  const auto on_top = simulate(pendulum, State<1>{0.0, Vector<double, 1>(std::acos(-1.0)), Vector<double, 1>(0.0)}, 5.0, Dop853{});
  REQUIRE(on_top.completed());
  CHECK(on_top.statistics.steps < few);
}
