// SPDX-License-Identifier: MIT
//
// Far from t = 0: a Unix time, t = 1.7e9, is known to 2.4e-7, and t = 1e12 to 1.2e-4. The motion must not be rougher for it, with any
// method; all motions here have closed forms in t − t₀, which is exact.

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/cvode_automatic.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/rattle.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/symplectic.hpp"
#include "qdot/integrate/taylor.hpp"

using namespace qdot;
using Eigen::Vector2d;
using One = Vector<double, 1>;

namespace {

const Options fine{.rtol = 1e-10, .atol = 1e-12};
constexpr double good = 1e-7;           // BDF at these tolerances over four periods; 3e-8 was seen, 1e-10 with one-step methods
constexpr double restarted = 1e-3;      // a multistep method that begins 1000 times; 6e-5 was seen
constexpr double folded_error = 1e-10;   // of a free motion from wall to wall, a hundred times; 1.4e-11 was seen with Gauss, 1e-13 else
constexpr double rounding = 1e-12;       // of the state at an event

constexpr double far_times[] = {0.0, 1.7e9, -1.7e9, 1e12, -1e12};

struct Oscillator {
  double omega;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const { return 0.5 * omega * omega * q[0] * q[0]; }
};
auto oscillator(double omega) { return mechanical_system<1>(Oscillator{omega}); }
using Method = AnyMethod<decltype(oscillator(1.0))>;

// All methods; those with a fixed step take a tenth of 1/ω.
std::vector<std::pair<std::string, Method>> methods(double omega) {
  const double h = 0.1 / omega;
  return {{"Dop853", Dop853{}},      {"Dopri5", Dopri5{}},       {"Taylor", Taylor{}},         {"Gauss", Gauss{.step = h, .stages = 4}},
          {"Splitting", Splitting{.step = h}}, {"CvodeBdf", CvodeBdf{}}, {"CvodeAdams", CvodeAdams{}}, {"Automatic", Automatic{}}};
}

State<1> at(double t, double q, double v) { return {t, One(q), One(v)}; }

// The shortest way that doubles near t can tell, times some: 20 µs at 1.7e9, 2 ms at 1e12.
double way(double t) { return std::abs(t) > 1e10 ? 16.0 / 8192 : std::abs(t) > 1.0 ? 88.0 / 4194304 : 2e-5; }

TEST_CASE("a motion far from t = 0 is the motion, with every method, forward and backward") {
  for (const double t0 : far_times) {
    for (const double direction : {1.0, -1.0}) {
      const double length = way(t0), omega = 25.0 / length, t_end = t0 + direction * length;
      REQUIRE((t_end - t0 == direction * length || t0 == 0.0));
      std::vector<double> outputs;  // every double on the way, where there are few
      for (int i = 1; i < 16; ++i) outputs.push_back(t0 + direction * length * i / 16);
      for (const auto& [name, method] : methods(omega)) {
        CAPTURE(name, t0, direction);
        Options options = fine;
        options.output_times = outputs;
        const auto run = simulate(oscillator(omega), at(t0, 1.0, 0.0), t_end, method, options);
        INFO(run.message);
        REQUIRE(run.completed());
        REQUIRE(run.t == t_end);
        CHECK(std::abs(run.y[0] - std::cos(25.0)) < good);
        REQUIRE(run.samples.t.size() == outputs.size());
        for (std::size_t i = 0; i < outputs.size(); ++i) {
          const double exact = std::cos(omega * (outputs[i] - t0));
          CHECK(std::abs(run.samples.y(0, static_cast<Eigen::Index>(i)) - exact) < good);
          CHECK(std::abs(run.trajectory.at(outputs[i]).q[0] - exact) < good);
        }
        CHECK(run.trajectory.front().q[0] == 1.0);
        CHECK(run.trajectory.back().q[0] == run.y[0]);
      }
    }
  }
}

TEST_CASE("the way of 20 µs from a Unix time is gone by steps, not in one hop") {
  // ω = 1e5 over 2e-5 s from 1.7e9: cos(ω (t_end − t₀)) = −0.418615 (t_end as a double).
  for (const auto& [name, method] : methods(1e5)) {
    CAPTURE(name);
    const auto run = simulate(oscillator(1e5), at(1.7e9, 1.0, 0.0), 1.7e9 + 2e-5, method, {.rtol = 1e-9, .atol = 1e-11});
    CHECK(std::abs(run.y[0] - -0.418615) < 1e-6);
  }
}

TEST_CASE("stop times every 20 µs from a Unix time lose nothing") {
  // ω = 500 over 0.02 s: cos 10 = −0.8391.
  Options options{.rtol = 1e-8, .atol = 1e-10};
  const double t0 = 1.7e9, t_end = t0 + 0.02;
  for (int i = 1; i < 1000; ++i) options.stop_times.push_back(t0 + i * 2e-5);
  for (const auto& [name, method] : methods(500.0)) {
    CAPTURE(name);
    const auto run = simulate(oscillator(500.0), at(t0, 1.0, 0.0), t_end, method, options);
    INFO(run.message);
    REQUIRE(run.completed());
    CHECK(std::abs(run.y[0] - std::cos(500.0 * (t_end - t0))) < restarted);
    CHECK(std::abs(run.y[0] - -0.8391) < restarted);
  }
}

TEST_CASE("walls far from t = 0 turn a body round when it meets them") {
  // Free motion between q = 0 and q = 1 at speed 1/d, turned at each wall: the distance gone, folded. d is a fraction of a rounding unit
  // of t = 1e12, and many of 1.7e9.
  const auto free = oscillator(0.0);
  const auto turn = [](State<1>& s) { s.qdot = -s.qdot; };
  const auto folded = [](double x) { return std::abs(x - 2 * std::round(x / 2)); };
  for (const double t0 : far_times) {
    const double length = way(t0), speed = 40.25 / length;
    for (const double direction : {1.0, -1.0}) {
      for (const auto& [name, method] : methods(1e5)) {
        CAPTURE(name, t0, direction);
        Options options = fine;
        options.stop_times = {t0 + direction * length * 0.5};
        options.output_times = {t0 + direction * length * 0.25, t0 + direction * length * 0.75};
        const auto run = simulate(free, at(t0, 0.25, direction * speed), t0 + direction * length, method, options,
                                  events(event("left", [](const auto& q) { return q[0]; }).falling().action(turn),
                                         event("right", [](const auto& q) { return 1.0 - q[0]; }).falling().action(turn)));
        INFO(run.message);
        REQUIRE(run.completed());
        CHECK(run.events.size() == 40);
        const double gone = 0.25 + speed * std::abs(run.t - t0);
        CHECK(std::abs(run.y[0] - folded(gone)) < folded_error);
        for (Eigen::Index i = 0; i < 2; ++i) {
          const double t = run.samples.t[static_cast<std::size_t>(i)];
          CHECK(std::abs(run.samples.y(0, i) - folded(0.25 + speed * std::abs(t - t0))) < folded_error);
        }
        for (const RecordedEvent& wall : run.events) {  // both sides of the jump, though many have the same t
          CHECK(std::abs(wall.t - t0) <= length);
          CHECK(std::abs(std::abs(run.trajectory.at(wall.t).qdot[0]) - speed) < rounding * speed);
        }
      }
    }
  }
}

TEST_CASE("the state at an event is as sharp as the step, though its t is rounded") {
  for (const double t0 : {1.7e9, 1e12}) {
    const double length = way(t0), omega = 25.0 / length;
    for (const auto& [name, method] : methods(omega)) {
      CAPTURE(name, t0);
      const auto run = simulate(oscillator(omega), at(t0, 1.0, 0.0), t0 + length, method, fine,
                                events(event("middle", [](const auto& q) { return q[0]; }).rising().stop()));
      REQUIRE(run.outcome == Outcome::stopped_by_event);
      CHECK(std::abs(run.y[0]) < rounding);
      CHECK(std::abs(run.y[1] / omega - 1.0) < good);
      CHECK(run.trajectory.back().q[0] == run.y[0]);
      CHECK(std::abs((run.t - t0) * omega - 4.71238898) < 0.6 * omega * (std::nextafter(t0, 2e12) - t0) + good);
    }
  }
}

TEST_CASE("events that follow each other within 20 µs of a Unix time are two, and in their order") {
  const auto free = oscillator(0.0);
  std::vector<std::string> met;
  int kicks = 0;
  const auto run = simulate(free, at(1.7e9, 0.0, 1.0), 1.7e9 + 1.0, Dop853{}, {},
                            events(event("second", [](const auto& q) { return q[0] - 0.5 - 1e-6; }).action([&](State<1>&) { met.push_back("second"); }),
                                   event("first", [](const auto& q) { return q[0] - 0.5; }).action([&](State<1>&) { met.push_back("first"); }),
                                   event("comb", [](const auto& q) { return std::sin(1e5 * q[0]) + (q[0] < 0.6 || q[0] > 0.6003 ? 9.0 : 0.0); })
                                       .action([&](State<1>&) { ++kicks; })));
  INFO(run.message);
  REQUIRE(run.completed());
  CHECK(met == std::vector<std::string>{"first", "second"});
  CHECK(kicks >= 9);  // sin is zero nine or ten times in the gap, 30/π
  CHECK(std::abs(run.y[0] - 1.0) < rounding);
}

TEST_CASE("a push at a moment far from t = 0 is given once, and the run goes on") {
  for (const double t0 : far_times) {
    const double pushed_at = t0 + 1.25;
    const auto run = simulate(oscillator(1.0), at(t0, 1.0, 0.0), t0 + 4.0, Dop853{}, fine,
                              events(event("push", [pushed_at](const auto&, const auto&, const auto& t) {
                                       return t - pushed_at;
                                     }).action([](State<1>& s) { s.qdot[0] += 0.5; })));
    CAPTURE(t0, run.message);
    REQUIRE(run.completed());
    CHECK(run.events.size() == 1);
    const double blurred = 2 * (std::nextafter(std::abs(t0), 2e12) - std::abs(t0));  // t − pushed_at is zero for as long as t can't tell
    CHECK(std::abs(run.y[0] - (std::cos(4.0) + 0.5 * std::sin(2.75))) < good + blurred);
  }
}

// q̈ = 0, and 1 from t = middle on; the moment itself counts to what comes then, or to what was.
struct Switched {
  double middle;
  bool early;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q, const auto& t) const { return ((early ? t < middle : !(t > middle)) ? 0.0 : -1.0) * q[0]; }
};
auto switched(double middle, bool early) { return mechanical_system<1>(Switched{middle, early}); }

TEST_CASE("a switch at a stop time is felt there and not before, whichever side the model counts it to") {
  for (const double t0 : {0.0, 1.7e9, 1e12}) {
    const double length = t0 > 1e10 ? 0.25 : 1e-3, middle = t0 + length / 2, t_end = t0 + length;
    const double exact = t_end - middle;  // velocity at the end
    Options options = fine;
    options.stop_times = {middle};
    options.atol = 1e-16;
    const std::vector<std::pair<std::string, AnyMethod<decltype(switched(0.0, true))>>> each = {
        {"Dop853", Dop853{}}, {"Dopri5", Dopri5{}}, {"Gauss", Gauss{.step = length / 8}},
        {"Splitting", Splitting{.step = length / 8}}, {"CvodeBdf", CvodeBdf{}}, {"CvodeAdams", CvodeAdams{}}};
    for (const auto& [name, method] : each) {
      CAPTURE(name, t0);
      const auto a = simulate(switched(middle, true), at(t0, 0.0, 0.0), t_end, method, options);
      const auto b = simulate(switched(middle, false), at(t0, 0.0, 0.0), t_end, method, options);
      REQUIRE((a.completed() && b.completed()));
      CHECK(std::abs(a.y[1] / exact - 1.0) < 1e-9);
      CHECK(std::abs(b.y[1] / exact - 1.0) < 1e-9);
      CHECK(a.statistics.rejected_by_error_test == b.statistics.rejected_by_error_test);
    }
  }
}

TEST_CASE("a body on a circle turns as far from t = 0 as at it") {
  const auto body = mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }, [](const auto& q) { return 0.0 * q[0]; });
  const auto circle = scene(body, holonomic("circle", [](const auto& q) { return q[0] * q[0] + q[1] * q[1] - 1.0; }));
  for (const double t0 : {1.7e9, 1e12}) {
    const double length = way(t0), omega = 5.0 / length;
    const State<2> start{t0, Vector2d(1.0, 0.0), Vector2d(0.0, omega)};
    Options options = fine;
    options.atol = {1e-12, 1e-12, 1e-12 * omega, 1e-12 * omega};
    const auto check = [&](const char* name, const auto& method) {
      CAPTURE(name, t0);
      const auto run = simulate(circle, start, t0 + length, method, options);
      INFO(run.message);
      REQUIRE(run.completed());
      CHECK(std::hypot(run.y[0] - std::cos(5.0), run.y[1] - std::sin(5.0)) < good);
    };
    check("Rattle", Rattle{.step = length / 400, .order = 6});
    check("Dop853", Dop853{});
    check("CvodeBdf", CvodeBdf{});
  }
}

TEST_CASE("a stepper that is driven by hand says t_limit when it is there, and not before") {
  const double t0 = 1e12, next = std::nextafter(t0, 2e12), omega = 10.0 / (next - t0);
  const auto form = first_order_form(oscillator(omega));
  for (const auto& [name, method] : methods(omega)) {
    CAPTURE(name);
    AnyStepper stepper = method.stepper(form, fine);
    stepper.reset(t0, Vector2d(1.0, 0.0));
    int steps = 0;
    Eigen::VectorXd middle(2);
    for (; stepper.t() != next; ++steps) {
      REQUIRE(stepper.step(next));
      stepper.interpolate(t0, middle);  // within the step as far as that goes
      REQUIRE(middle.allFinite());
      REQUIRE(std::abs(middle[0]) < 1.0 + good);
    }
    CHECK(steps > 2);
    CHECK(std::abs(stepper.y()[0] - std::cos(10.0)) < good);
  }
}

}  // namespace
