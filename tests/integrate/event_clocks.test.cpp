// SPDX-License-Identifier: MIT
#include "qdot/integrate/driver/event_clocks.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "catch2_bridge.hpp"
#include "error_message.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/input.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

using namespace qdot;

namespace {

using V1 = Vector<double, 1>;

// ẍ = −x from (1, 0): x = cos t; and ẍ = u.
const auto oscillator = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.5 * q[0] * q[0]; });
const auto cart = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.0 * q[0]; });
const State<1> released{0.0, V1(1.0), V1(0.0)};
const Options fine{.rtol = 1e-12, .atol = 1e-13};
constexpr double rounding = 2.3e-16;   // of times near 1
constexpr double fine_error = 1e-10;  // of states over some seconds at these tolerances

std::vector<double> times(const std::vector<RecordedEvent>& list, const std::string& name) {
  std::vector<double> result;
  for (const auto& e : list)
    if (e.name == name) result.push_back(e.t);
  return result;
}

TEST_CASE("an event of a clock happens at first + k period, the start included and the end not, and clocks that tick together at one moment") {
  const auto run = simulate(oscillator, State<1>{0.3, V1(1.0), V1(0.0)}, 1.3, Dop853{}, fine,
                            events(every("tick", 0.1), every("late", 0.25, 0.8), every("past", 0.4, 0.1)));
  const auto ticks = times(run.events, "tick"), late = times(run.events, "late"), past = times(run.events, "past");
  REQUIRE(ticks.size() == 10);
  for (std::size_t k = 0; k < 10; ++k) CHECK_THAT(ticks[k], WithinAbs(0.3 + static_cast<double>(k) * 0.1, 4 * rounding));
  REQUIRE(late.size() == 2);
  CHECK(late[0] == ticks[5]);
  CHECK(late[1] == 0.8 + 0.25);
  CHECK(past == std::vector<double>{ticks[2], ticks[6]});
  CHECK(run.statistics.restarts == 0);  // it only looks
  CHECK_THAT(run.y[0], WithinAbs(std::cos(1.0), fine_error));
  CHECK(run.t == 1.3);
}

// u = −4 x − 2 v, held for a period: x⁺ = x + P v + ½ P² u, v⁺ = v + P u.
struct Held {
  double x = 1.0, v = 0.0, u = 0.0;
  void sample() { u = -4.0 * x - 2.0 * v; }
  void go_on(double P) {
    x += P * v + 0.5 * P * P * u;
    v += P * u;
  }
};

template <class Method>
void check_held(const Method& method, const Options& options, double error) {
  const double P = 0.05;
  double u = 0.0;
  const auto driven = scene(cart, generalized_force([&u](const auto& q, const auto&) {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    return Vector<S, 1>(S(u));
  }));
  std::vector<State<1>> seen;
  const auto controller = every("controller", P).action([&](State<1>& s) {
    seen.push_back(s);
    u = -4.0 * s.q[0] - 2.0 * s.qdot[0];
  });
  const auto run = simulate(driven, released, 2.0, method, options, controller);
  REQUIRE(run.completed());
  Held hand;
  REQUIRE(seen.size() == 40);
  for (const State<1>& s : seen) {
    CHECK_THAT(s.q[0], WithinAbs(hand.x, error));
    CHECK_THAT(s.qdot[0], WithinAbs(hand.v, error));
    hand.sample();
    hand.go_on(P);
  }
  CHECK_THAT(run.y[0], WithinAbs(hand.x, error));
  CHECK(run.statistics.restarts == 40);
}

TEST_CASE("a controller that samples and holds moves a cart as its difference equation says") {
  check_held(Dop853{}, fine, 1e-12);  // parabolas, exact for it
  check_held(CvodeBdf{}, {.rtol = 1e-10, .atol = 1e-12}, 1e-7);
}

TEST_CASE("what a controller holds may be among the effects' own states, and samples at its times are those behind it") {
  Options options = fine;
  options.output_times = {0.0, 0.5, 1.0};
  const auto driven = scene(cart, input("motor", 0));
  const auto controller = every("controller", 0.5).action([](double, Eigen::VectorXd& y) { y[2] = -4.0 * y[0] - 2.0 * y[1]; });
  const auto run = simulate(driven, released, 1.0, Dop853{}, options, controller);
  Held hand;
  for (Eigen::Index k = 0; k < 2; ++k) {
    hand.sample();
    CHECK_THAT(run.samples.y(0, k), WithinAbs(hand.x, 1e-12));
    CHECK_THAT(run.samples.y(2, k), WithinAbs(hand.u, 1e-12));
    hand.go_on(0.5);
  }
  CHECK_THAT(run.samples.y(0, 2), WithinAbs(hand.x, 1e-12));
  CHECK(run.trajectory.y_before(0.5)[2] == run.samples.y(2, 0));
  CHECK(run.trajectory.y(0.5)[2] == run.samples.y(2, 1));
}

TEST_CASE("clocks disturb neither crossings nor stop times, and one that stops ends the run at its time") {
  Options options = fine;
  options.stop_times = {0.5, 1.5};
  const auto nudge = every("nudge", 0.25).action([](State<1>&) {});
  const auto falls = event("falls", [](const auto& q) { return q[0]; }).falling();
  const auto turns = event("turns", [](const auto&, const auto& v) { return v[0]; });  // v = 0 at the start counts
  const auto run = simulate(oscillator, released, 10.0, Dop853{}, options, events(nudge, falls, turns, every("enough", 1.0, 4.0).stop()));
  CHECK(run.outcome == Outcome::stopped_by_event);
  CHECK(run.t == 4.0);
  CHECK_THAT(run.y[0], WithinAbs(std::cos(4.0), fine_error));
  CHECK(times(run.events, "nudge").size() == 17);
  CHECK(times(run.events, "enough") == std::vector<double>{4.0});
  REQUIRE(times(run.events, "falls").size() == 1);
  CHECK_THAT(times(run.events, "falls")[0], WithinAbs(std::acos(0.0), fine_error));
  REQUIRE(times(run.events, "turns").size() == 2);
  CHECK(times(run.events, "turns")[0] == 0.0);
  CHECK_THAT(times(run.events, "turns")[1], WithinAbs(2 * std::acos(0.0), fine_error));
}

TEST_CASE("an event may look at what effects have as states of their own") {
  const auto integrating = scene(cart, controller([](const auto& q, const auto&, const auto&, const auto&) { return vector(0.0 * q[0]); },
                                                  [](const auto& q, const auto&, const auto&, const auto&) { return vector(2.0 * q[0]); }, vector(0.0)));
  const auto full = event("full", [](const auto&, const auto&, const auto& z, const auto&) { return z[0] - 1.0; }).stop();
  const auto run = simulate(integrating, released, 5.0, Dop853{}, fine, full);  // ż = 2 x, and x stays at 1
  CHECK(run.outcome == Outcome::stopped_by_event);
  CHECK_THAT(run.t, WithinAbs(0.5, 1e-14));
}

TEST_CASE("an output time that is a tick but for rounding has the state behind it, however far the clock is from zero") {
  // Kicks of 1 at t₀ + 0.1 k: v = k behind the k-th.
  for (const double t0 : {0.0, 1.7e9}) {
    CAPTURE(t0);
    Options options = fine;
    for (int k = 1; k < 20; ++k) options.output_times.push_back(t0 + 0.1 * k);
    const auto kick = every("kick", 0.1, t0 + 0.1).action([](State<1>& s) { s.qdot[0] += 1.0; });
    const auto run = simulate(cart, State<1>{t0, V1(0.0), V1(0.0)}, t0 + 2.0, Dop853{}, options, kick);
    REQUIRE(run.completed());
    REQUIRE(run.samples.t.size() == 19);
    for (Eigen::Index k = 0; k < 19; ++k) CHECK_THAT(run.samples.y(1, k), WithinAbs(static_cast<double>(k + 1), 1e-12));
  }
}

TEST_CASE("a clock that cannot be is refused by rule, value and remedy") {
  CHECK_THROWS_AS(every("never", 0.0), InvalidValue);
  CHECK_THROWS_AS(every("never", std::numeric_limits<double>::infinity()), InvalidValue);
  CHECK_THROWS_AS(every("sometimes", 1.0, std::numeric_limits<double>::quiet_NaN()), InvalidValue);
  CHECK(error_message([] { (void)simulate(oscillator, released, -1.0, Dop853{}, fine, every("tick", 0.1)); }).find("needs a run forward") != std::string::npos);
  CHECK(error_message([] {
          (void)simulate(oscillator, State<1>{1e9, V1(1.0), V1(0.0)}, 1e9 + 1, Dop853{}, fine, every("tick", 1e-7));
        }).find("longer than what t can tell") != std::string::npos);
}

}  // namespace
