// SPDX-License-Identifier: MIT
#include "qdot/integrate/event.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "catch2_bridge.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/cvode_automatic.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/taylor.hpp"

using qdot::Dop853;
using qdot::event;
using qdot::events;
using qdot::Outcome;
using qdot::simulate;
using qdot::State;

namespace {

using V1 = qdot::Vector<double, 1>;
constexpr double pi = std::numbers::pi;

// ẍ = −x from (1, 0): x = cos t.
const auto oscillator = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                                   [](const auto& q) { return 0.5 * q[0] * q[0]; });
const State<1> released{0.0, V1(1.0), V1(0.0)};
const qdot::Options fine{.rtol = 1e-12, .atol = 1e-13};
constexpr double fine_error = 1e-10;  // of times and states over some periods at these tolerances

const auto x = [](const auto& q) { return q[0]; };
const auto speed = [](const auto&, const auto& qdot) { return qdot[0]; };

std::vector<double> times(const std::vector<qdot::RecordedEvent>& list, const std::string& name) {
  std::vector<double> result;
  for (const auto& e : list)
    if (e.name == name) result.push_back(e.t);
  return result;
}

void check_times(const std::vector<double>& found, const std::vector<double>& expected, double error = fine_error) {
  REQUIRE(found.size() == expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) CHECK_THAT(found[i], WithinAbs(expected[i], error));
}

// ẍ = −g, x(0) = 1: a parabola, which every method of order 2 and more follows exactly.
const auto falling_ball = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                                     [](const auto& q) { return 9.81 * q[0]; });

// The impact law of a ball with restitution e on the floor x = 0.
struct Bounce {
  static constexpr bool is_barrier = true;
  double e;
  void operator()(State<1>& s) const { s.qdot[0] *= -e; }
};

}  // namespace

TEST_CASE("crossings are found at their times, in the direction asked for, with every kind of method") {
  const auto check = [](const auto& method, const qdot::Options& options, double error) {
    const auto run = simulate(oscillator, released, 10.0, method, options,
                              events(event("down", x).falling(), event("up", x).rising(), event("both", x)));
    REQUIRE(run.completed());
    check_times(times(run.events, "down"), {0.5 * pi, 2.5 * pi}, error);
    check_times(times(run.events, "up"), {1.5 * pi}, error);
    check_times(times(run.events, "both"), {0.5 * pi, 1.5 * pi, 2.5 * pi}, error);
  };
  check(Dop853{}, fine, fine_error);
  check(qdot::Dopri5{}, fine, fine_error);
  check(qdot::CvodeBdf{}, {.rtol = 1e-9}, 1e-6);  // BDF's error over ten units of time
  check(qdot::CvodeAdams{}, {.rtol = 1e-10}, 1e-7);
}

TEST_CASE("backward in time falling means falling along the run") {
  const auto run = simulate(oscillator, released, -10.0, Dop853{}, fine, events(event("down", x).falling()));
  check_times(times(run.events, "down"), {-0.5 * pi, -2.5 * pi});
}

TEST_CASE("recording changes neither steps nor motion") {
  const auto plain = simulate(oscillator, released, 10.0, Dop853{}, fine);
  const auto watched = simulate(oscillator, released, 10.0, Dop853{}, fine, events(event("zero", x), event("turn", speed)));
  CHECK(watched.y == plain.y);
  CHECK(watched.statistics.steps == plain.statistics.steps);
  CHECK(plain.events.empty());
}

TEST_CASE("the moment that is handed out lies on the far side of the root") {
  const auto run = simulate(oscillator, released, 10.0, Dop853{}, fine, events(event("down", x).falling()));
  for (const auto& e : run.events) {
    CHECK(run.trajectory.at(e.t).q[0] <= 0.0);
    CHECK(run.trajectory.at(e.t).q[0] > -1e-14);
  }
}

TEST_CASE("an event may stop the run, exactly where it is") {
  const auto run = simulate(oscillator, released, 10.0, Dop853{}, fine, events(event("zero", x).stop()));
  REQUIRE(run.outcome == Outcome::stopped_by_event);
  CHECK_FALSE(failed(run.outcome));
  CHECK_THAT(run.t, WithinAbs(0.5 * pi, fine_error));
  CHECK_THAT(run.state().qdot[0], WithinAbs(-1.0, fine_error));
  CHECK(run.trajectory.back_time() == run.t);
  CHECK(run.message.find("'zero' asked to stop") != std::string::npos);
  REQUIRE(run.events.size() == 1);
  CHECK(run.events[0].t == run.t);
}

TEST_CASE("forty impacts of a bouncing ball come at the times of the closed form") {
  constexpr double g = 9.81, e = 0.9;
  const auto run = simulate(falling_ball, released, 8.45, Dop853{}, {},
                            events(event("floor", x).falling().action(Bounce{e})));
  REQUIRE(run.completed());
  const auto found = times(run.events, "floor");
  REQUIRE(found.size() == 40);
  double t = std::sqrt(2.0 / g);  // of the first impact; the n-th flight takes 2 eⁿ √(2h/g)
  for (std::size_t i = 0; i < found.size(); ++i) {
    CHECK_THAT(found[i], WithinAbs(t, 1e-10));
    const double v = run.trajectory.before(found[i]).qdot[0];
    CHECK_THAT(v, WithinAbs(-std::sqrt(2 * g) * std::pow(e, static_cast<double>(i)), 1e-10));
    CHECK_THAT(run.trajectory.at(found[i]).qdot[0], WithinAbs(-e * v, 1e-14));
    t += 2 * std::pow(e, static_cast<double>(i + 1)) * std::sqrt(2.0 / g);
  }
  CHECK(run.statistics.restarts == 40);
  CHECK(run.trajectory.jump_times() == found);
}

TEST_CASE("infinitely many impacts end in a named outcome at their limit, and the ball never falls through") {
  for (const double e : {0.1, 0.5, 0.8}) {
    const auto run = simulate(falling_ball, released, 10.0, Dop853{}, {}, events(event("floor", x).falling().action(Bounce{e})));
    REQUIRE(run.outcome == Outcome::zeno);
    CHECK(failed(run.outcome));
    CHECK_THAT(run.t, WithinAbs(std::sqrt(2.0 / 9.81) * (1 + e) / (1 - e), 1e-10));
    CHECK(std::abs(run.y[0]) < 1e-12);
    CHECK(run.message.find("'floor'") != std::string::npos);
  }
}

TEST_CASE("a ball whose floor is a plain event never falls through it, with any method, restitution and length of step") {
  constexpr double g = 9.81;
  const auto check = [](const auto& method, double error) {
    for (const double e : {0.0, 0.1, 0.5, 0.9})
      for (const double t_end : {10.0, 1e4}) {
        CAPTURE(method.name, e, t_end);
        const auto run = simulate(falling_ball, released, t_end, method, {},
                                  events(event("floor", x).falling().action([e](State<1>& s) { s.qdot *= -e; })));
        REQUIRE(run.outcome == Outcome::zeno);
        CHECK_THAT(run.t, WithinAbs(std::sqrt(2.0 / g) * (1 + e) / (1 - e), error));
        CHECK(std::abs(run.y[0]) < error);
        CHECK(run.message.find("'floor'") != std::string::npos);
      }
  };
  constexpr double shortest_hop = 1e-7;      // to fall by the rounding of the first impact, 1e-15, takes 1e-8
  constexpr double multistep_error = 1e-3;   // hops lower than the tolerance of x, 1e-9, take 3e-5 and are no motion that BDF can tell
  check(Dop853{}, shortest_hop);
  check(qdot::Taylor{}, shortest_hop);
  check(qdot::Automatic{}, shortest_hop);
  check(qdot::CvodeBdf{}, multistep_error);
  check(qdot::CvodeAdams{}, multistep_error);
}

TEST_CASE("an action that does not turn the motion lets it through zero, from rest too") {
  // A push onward, and an action that only looks on; in both the ball goes on falling through the level.
  for (const double start : {1.0, 0.0}) {
    const auto from = State<1>{0.0, V1(start), V1(0.0)};
    int seen = 0;
    const auto looked = simulate(falling_ball, from, 2.0, qdot::Taylor{}, {}, events(event("level", x).falling().action([&](State<1>&) { ++seen; })));
    REQUIRE(looked.completed());
    CHECK(seen == 1);
    CHECK_THAT(looked.y[0], WithinRel(start - 0.5 * 9.81 * 4.0, 1e-10));
  }
  const auto pushed = simulate(falling_ball, released, 2.0, qdot::Taylor{}, {}, events(event("level", x).falling().action([](State<1>& s) { s.qdot *= 2.0; })));
  REQUIRE(pushed.completed());
  CHECK(pushed.events.size() == 1);
}

TEST_CASE("what another event's action puts onto zero counts when it then moves its way") {
  // The trap lays the ball onto the floor, falling; the floor throws it back.
  const auto run = simulate(falling_ball, released, 0.5, qdot::Taylor{}, {},
                            events(event("trap", [](const auto& q) { return q[0] - 0.5; }).falling().action([](State<1>& s) { s.q[0] = 0.0; }),
                                   event("floor", x).falling().action([](State<1>& s) { s.qdot *= -1.0; })));
  REQUIRE(run.completed());
  const double fall = std::sqrt(1.0 / 9.81), v = 9.81 * fall;
  check_times(times(run.events, "floor"), {fall}, 1e-12);
  CHECK_THAT(run.y[0], WithinAbs(v * (0.5 - fall) - 0.5 * 9.81 * (0.5 - fall) * (0.5 - fall), 1e-12));
}

TEST_CASE("all crossings of a function faster than the motion are found, whatever the step") {
  // x = cos t; g = sin(ωt + 0.1) is zero at (kπ − 0.1)/ω; sin(ωx + 0.1) as often as ωx + 0.1 passes a multiple of π.
  const auto check = [&](const auto& method, double error) {
    for (const double w : {20.0, 40.0, 300.0, 1500.0}) {
      const double t_end = w > 100.0 ? 7.0 : 30.0;  // more than a period of x, and three thousand crossings
      CAPTURE(method.name, w);
      const auto of_time = [w](const auto&, const auto&, double t) { return std::sin(w * t + 0.1); };
      const auto of_place = [w](const auto& q) { return std::sin(w * q[0] + 0.1); };
      const auto of_both = [w](const auto& q, const auto&, double t) { return (2.0 + q[0]) * std::sin(w * t + 0.1); };
      const auto run = simulate(oscillator, released, t_end, method, {.rtol = 1e-9},
                                events(event("time", of_time), event("place", of_place), event("both", of_both)));
      REQUIRE(run.completed());
      std::vector<double> expected;
      for (int k = 1; (k * pi - 0.1) / w < t_end; ++k) expected.push_back((k * pi - 0.1) / w);
      REQUIRE(times(run.events, "time").size() == expected.size());
      double worst = 0.0;
      const auto found = times(run.events, "time"), too = times(run.events, "both");
      for (std::size_t k = 0; k < expected.size(); ++k) worst = std::max(worst, std::abs(found[k] - expected[k]));
      CHECK(worst < 1e-13);  // some rounding units of t
      CHECK(too.size() == expected.size());
      double passed = 0.0;
      const auto count_at = [w](double t) { return std::floor((w * std::cos(t) + 0.1) / pi); };
      for (double t = 0.0; t < t_end; t += pi) passed += std::abs(count_at(t) - count_at(std::min(t + pi, t_end)));
      CHECK_THAT(static_cast<double>(times(run.events, "place").size()), WithinAbs(passed, error * w));
      CHECK(run.statistics.unresolved_events == 0);
    }
  };
  check(Dop853{}, 0.0);
  check(qdot::Taylor{}, 0.0);
  check(qdot::CvodeBdf{}, 0.0);
}

TEST_CASE("two roots that lie close together are found, however fast the function and short the excursion") {
  // sin ωt + 1 − δ is negative for 2 √(2δ)/ω about each of its minima, (2k + 3/2) π/ω.
  for (const double w : {1.0, 37.0, 400.0})
    for (const double below : {1e-3, 1e-8}) {
      CAPTURE(w, below);
      const auto dip = [=](double sign) {
        return event("dip", [=](const auto&, const auto&, double t) { return std::sin(w * t) + 1.0 - sign * below; });
      };
      const auto hit = simulate(oscillator, released, 10.0, qdot::Taylor{}, {.rtol = 1e-9}, events(dip(1.0)));
      const auto missed = simulate(oscillator, released, 10.0, qdot::Taylor{}, {.rtol = 1e-9}, events(dip(-1.0)));
      CHECK(missed.events.empty());
      std::vector<double> expected;
      const double half = std::acos(1.0 - below) / w;
      for (int k = 0; (2 * k + 1.5) * pi / w + half < 10.0; ++k) {
        expected.push_back((2 * k + 1.5) * pi / w - half);
        expected.push_back((2 * k + 1.5) * pi / w + half);
      }
      constexpr double rounding_of_a_root = 1e-10;  // 1e-15/√(2δ)/ω, and half of acos' own digits
      check_times(times(hit.events, "dip"), expected, rounding_of_a_root);
    }
}

TEST_CASE("of a formula every excursion across zero is found, however short, with every kind of method, backward and at large t") {
  // exp(−((t − c)/w)²) − ½ is zero at c ± w √log 2; over x = cos t the same where cos t is.
  const double half = std::sqrt(std::log(2.0));
  const auto bump = [](const auto& at, double c, double w) {
    using std::exp;
    const auto u = (at - c) / w;
    return exp(-u * u) - 0.5;
  };
  const auto check = [&](const auto& method, double t0, double t_end, double error_of_time, double error_of_place) {
    const double c = t0 + (t_end > t0 ? 3.0 : -3.0), sign = t_end > t0 ? 1.0 : -1.0;
    const auto run = simulate(oscillator, State<1>{t0, V1(1.0), V1(0.0)}, t_end, method, {.rtol = 1e-9},
                              events(event("time", [=](const auto&, const auto&, const auto& t) { return bump(t, c, 1e-5); }).formula(),
                                     event("place", [=](const auto& q) { return bump(q[0], 0.3, 1e-6); }).formula()));
    CAPTURE(t0, t_end, method.name);
    REQUIRE(run.completed());
    CHECK(run.statistics.unresolved_events == 0);
    check_times(times(run.events, "time"), {c - sign * 1e-5 * half, c + sign * 1e-5 * half}, error_of_time);
    const double in = std::acos(0.3 + 1e-6 * half), out = std::acos(0.3 - 1e-6 * half);
    check_times(times(run.events, "place"), {t0 + sign * in, t0 + sign * out, t0 + sign * (2 * pi - out), t0 + sign * (2 * pi - in)}, error_of_place);
  };
  constexpr double roundings = 1e-14, unix_time = 1.7e9, of_unix_time = 5e-7;  // two rounding units of t
  constexpr double of_motion = 1e-7, of_bdf = 1e-5;                          // what rtol = 1e-9 leaves after six units of time
  check(qdot::Taylor{}, 0.0, 6.0, roundings, of_motion);
  check(Dop853{}, 0.0, 6.0, roundings, of_motion);
  check(qdot::CvodeBdf{}, 0.0, 6.0, roundings, of_bdf);
  check(qdot::Taylor{}, 0.0, -6.0, roundings, of_motion);
  check(Dop853{}, 0.0, -6.0, roundings, of_motion);
  for (const double t0 : {unix_time, -unix_time}) {
    check(qdot::Taylor{}, t0, t0 + 6.0, of_unix_time, of_unix_time);
    check(Dop853{}, t0, t0 - 6.0, of_unix_time, of_unix_time);
  }
}

TEST_CASE("a formula that comes within 1e-12 of zero has two roots there or none, and one that touches it is reported") {
  // 1 − cos(ωt) − δ, nearest to zero at 2kπ/ω.
  constexpr double w = 7.0, t_end = 10.0;
  const auto check = [&](const auto& method, double delta) {
    CAPTURE(method.name, delta);
    const auto run = simulate(oscillator, State<1>{1.0, V1(std::cos(1.0)), V1(-std::sin(1.0))}, t_end, method, {.rtol = 1e-12, .atol = 1e-14},
                              events(event("time", [=](const auto&, const auto&, const auto& t) {
                                       using std::cos;
                                       return 1.0 - cos(w * t) - delta;
                                     }).formula()));
    REQUIRE(run.completed());
    std::vector<double> expected;
    for (int k = 2; delta > 0 && 2 * k * pi / w < t_end; ++k)
      for (const double side : {-1.0, 1.0}) expected.push_back((2 * k * pi + side * std::sqrt(2 * delta)) / w);
    constexpr double rounding_of_a_root = 1e-10;  // 1e-15, of cos at 70, over the slope, w √(2δ)
    check_times(times(run.events, "time"), expected, rounding_of_a_root);
    CHECK((run.statistics.unresolved_events > 0) == (delta == 0.0));
  };
  for (const double delta : {1e-12, -1e-12}) {
    check(qdot::Taylor{}, delta);
    check(Dop853{}, delta);
  }
  // The apex of a ball thrown up from 0 is at 1, and the level a hair below or above it.
  const State<1> thrown{0.0, V1(0.0), V1(std::sqrt(2 * 9.81))};
  for (const double hair : {1e-12, -1e-12}) {
    const auto run = simulate(falling_ball, thrown, 0.85, qdot::Taylor{}, {},
                              events(event("apex", [hair](const auto& q) { return q[0] - (1.0 - hair); }).formula()));
    const double top = std::sqrt(2 / 9.81), half = std::sqrt(2e-12 / 9.81);
    check_times(times(run.events, "apex"), hair > 0 ? std::vector<double>{top - half, top + half} : std::vector<double>{}, 1e-9);  // 1e-15 over v = 4e-6
    CHECK(run.statistics.unresolved_events == 0);
  }
  // (x − ½)² touches zero twice in a period, and no number of digits tells.
  const auto touch = simulate(oscillator, released, 6.0, Dop853{}, {},
                              events(event("touch", [](const auto& q) { return (q[0] - 0.5) * (q[0] - 0.5); }).formula()));
  CHECK(touch.completed());
  CHECK(touch.statistics.unresolved_events == 2);
  CHECK_THAT(touch.statistics.unresolved_event_time, WithinAbs(pi / 3, 0.5));  // the beginning of a step
  CHECK(touch.message.find("could not be followed") != std::string::npos);
}

TEST_CASE("a formula with a branch is followed, and one without a value for intervals is sampled, which is reported") {
  const auto kink = [](const auto& q) { return (q[0] < 0.0 ? -q[0] : q[0]) - 0.5; };  // |cos t| = ½
  const auto cube = [](const auto& q) { return q[0] * q[0] * q[0]; };
  const auto run = simulate(oscillator, released, 6.0, Dop853{}, fine, events(event("kink", kink).formula(), event("cube", cube).formula().falling()));
  check_times(times(run.events, "kink"), {pi / 3, 2 * pi / 3, 4 * pi / 3, 5 * pi / 3});
  check_times(times(run.events, "cube"), {pi / 2});
  CHECK(run.statistics.unresolved_events == 0);
  const auto refuse = [](const auto& q) {
    if constexpr (!std::is_same_v<std::remove_cvref_t<decltype(q[0])>, double>) throw std::runtime_error("not for me");
    return q[0];
  };
  const auto sampled = simulate(oscillator, released, 6.0, Dop853{}, fine, events(event("refused", refuse).formula().rising()));
  check_times(times(sampled.events, "refused"), {1.5 * pi});
  CHECK(sampled.statistics.unresolved_events > 0);
}

TEST_CASE("what a formula does to a run is what the same function does that is sampled") {
  // An impact law, a stop and a record, in every order of the words.
  const auto floor = [](const auto& q) { return q[0]; };
  const auto high = [](const auto& q, const auto& qdot) { return q[0] - 0.5 + 0.0 * qdot[0]; };
  const auto bounce = [&](const auto& first, const auto& second) {
    return simulate(falling_ball, State<1>{0.0, V1(1.0), V1(0.0)}, 3.0, Dop853{}, {}, events(first, second));
  };
  const auto plain = bounce(event("floor", floor).action(Bounce{0.8}), event("high", high));
  const auto proved = bounce(event("floor", floor).action(Bounce{0.8}).formula(), event("high", high).formula().falling());
  const auto mixed = bounce(event("floor", floor).formula().action(Bounce{0.8}), event("high", high));
  REQUIRE(times(plain.events, "floor").size() >= 4);
  REQUIRE(mixed.events.size() == plain.events.size());
  for (std::size_t k = 0; k < plain.events.size(); ++k) CHECK_THAT(mixed.events[k].t, WithinAbs(plain.events[k].t, 1e-13));  // roundings of t
  check_times(times(proved.events, "floor"), times(plain.events, "floor"), 1e-13);
  const auto stopped = simulate(oscillator, released, 6.0, Dop853{}, fine, event("down", x).stop().formula());
  CHECK(stopped.outcome == Outcome::stopped_by_event);
  CHECK_THAT(stopped.t, WithinAbs(pi / 2, fine_error));
}

TEST_CASE("a function that cannot be followed is reported, and one that jumps is not") {
  long calls = 0;
  std::minstd_rand random(1);
  const auto noise = simulate(oscillator, released, 1.0, Dop853{}, {}, events(event("noise", [&](const auto&) {
                                return ++calls, 0.1 + static_cast<double>(random()) / static_cast<double>(std::minstd_rand::max());
                              })));
  CHECK(noise.completed());
  CHECK(noise.events.empty());
  CHECK(noise.statistics.unresolved_events > 0);
  CHECK(noise.statistics.unresolved_event_time == 0.0);
  CHECK(noise.message.find("could not be followed") != std::string::npos);
  CHECK(calls < 1'000'000);
  const auto jump = simulate(oscillator, released, 3.0, Dop853{}, {}, events(event("jump", [](const auto& q) { return q[0] > 0.3 ? 1.0 : -1.0; })));
  CHECK(jump.events.empty());
  CHECK(jump.statistics.unresolved_events == 0);
}

TEST_CASE("a jump of the function across zero and a pole are no crossings, and what is steep and continuous is one") {
  // A mass that goes with the time, q = t.
  const auto mass = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.0 * q[0]; });
  const auto sawtooth = event("sawtooth", [](const auto& q) { return std::atan2(std::sin(q[0] - 0.5), std::cos(q[0] - 0.5)); });
  const auto pole = event("pole", [](const auto& q) { return 1.0 / (q[0] - 3.1); });
  const auto tangent = event("tangent", [](const auto& q) { return std::tan(q[0]); });
  const auto steep = event("steep", [](const auto& q) { return std::tanh(1e6 * (q[0] - 1.3)); });
  const auto cube_root = event("cube root", [](const auto& q) { return std::cbrt(q[0] - 1.7); });
  const auto fifth_root = event("fifth root", [](const auto& q) { return std::copysign(std::pow(std::abs(q[0] - 2.1), 0.2), q[0] - 2.1); });
  const auto flat = event("flat", [](const auto& q) { return std::pow(q[0] - 1.5, 3); });
  const auto expanded = event("expanded", [](const auto& q) { return (1e6 + q[0]) - (1e6 + 1.9); });
  const auto run = simulate(mass, State<1>{0.0, V1(0.0), V1(1.0)}, 8.0, Dop853{}, fine,
                            events(sawtooth, pole, tangent, steep, cube_root, fifth_root, flat, expanded));
  REQUIRE(run.completed());
  check_times(times(run.events, "sawtooth"), {0.5, 0.5 + 2 * pi});
  CHECK(times(run.events, "pole").empty());
  check_times(times(run.events, "tangent"), {0.0, pi, 2 * pi});
  check_times(times(run.events, "steep"), {1.3});
  check_times(times(run.events, "cube root"), {1.7});
  check_times(times(run.events, "fifth root"), {2.1});
  check_times(times(run.events, "flat"), {1.5}, 1e-5);        // a cube is nothing but rounding that near to its zero
  check_times(times(run.events, "expanded"), {1.9}, 2.5e-10);  // two units in the last place of 1e6
}

TEST_CASE("a function that rests at zero is dated where it leaves it or comes to it, by every method") {
  const auto mass = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.0 * q[0]; });
  const auto leaves = [](const auto& q) {
    using S = typename std::decay_t<decltype(q)>::Scalar;
    return q[0] > 1.0 ? S(q[0] - 1.0) : S(0.0);
  };
  const auto comes = event("comes", [](const auto& q) { return std::max(1.25 - q[0], 0.0); });
  const auto stair = [](const auto&, const auto&, const auto& t) {
    using std::floor;
    return floor(t) - 3.0;
  };
  const auto list = events(event("leaves", leaves), event("leaves, formula", leaves).formula(), comes, event("stair", stair),
                           event("stair, formula", stair).formula());
  const auto check = [&](const auto& method) {
    const auto run = simulate(mass, State<1>{0.0, V1(0.0), V1(1.0)}, 4.5, method, fine, list);
    REQUIRE(run.completed());
    check_times(times(run.events, "leaves"), {1.0});
    check_times(times(run.events, "leaves, formula"), {1.0});
    check_times(times(run.events, "comes"), {1.25});
    check_times(times(run.events, "stair"), {3.0}, 0.0);
    check_times(times(run.events, "stair, formula"), {3.0}, 0.0);
  };
  check(Dop853{});
  check(qdot::CvodeBdf{});
}

TEST_CASE("two roots within one step are both found, in their order") {
  // One step of a parabola covers the whole flight; the ball is above 0.99 for a moment only.
  const State<1> thrown{0.0, V1(0.0), V1(std::sqrt(2 * 9.81))};
  const auto run = simulate(falling_ball, thrown, 0.9, Dop853{}, {.initial_step = 0.9},
                            events(event("above", [](const auto& q) { return q[0] - 0.99; }),
                                   event("top", speed), event("half", [](const auto& q) { return q[0] - 0.5; })));
  REQUIRE(run.statistics.steps == 1);
  const double top = std::sqrt(2.0 / 9.81);
  std::vector<std::string> names;
  for (const auto& e : run.events) names.push_back(e.name);
  CHECK(names == std::vector<std::string>{"half", "above", "top", "above", "half"});
  check_times(times(run.events, "above"), {0.9 * top, 1.1 * top}, 1e-13);
}

TEST_CASE("a graze is found when it crosses, and not when it falls short") {
  // x = h − g(t − t_top)²/2 … reaches h; the level lies a hair below or above it.
  const State<1> thrown{0.0, V1(0.0), V1(std::sqrt(2 * 9.81))};
  for (const double hair : {1e-6, 1e-10, -1e-10, -1e-6}) {
    const auto run = simulate(falling_ball, thrown, 0.85, Dop853{}, {.initial_step = 0.85},
                              events(event("graze", [hair](const auto& q) { return q[0] - (1.0 - hair); })));
    REQUIRE(run.statistics.steps <= 2);
    CHECK(run.events.size() == (hair > 0 ? 2u : 0u));
  }
}

TEST_CASE("events at the same time keep the order of the list, and none is lost when one changes the state") {
  const auto flip = [](State<1>& s) { s.qdot = -s.qdot; };
  const auto run = simulate(oscillator, released, 2.0, Dop853{}, fine,
                            events(event("a", x).falling(), event("flip", x).falling().action(flip), event("b", x).falling()));
  REQUIRE(run.events.size() == 3);
  CHECK(run.events[0].name == "a");
  CHECK(run.events[1].name == "flip");
  CHECK(run.events[2].name == "b");
  CHECK(run.events[0].t == run.events[2].t);
  CHECK_THAT(run.state().q[0], WithinAbs(-std::cos(2.0), fine_error));
}

TEST_CASE("an event that has fired is muted until it leaves zero") {
  // A push at x = 0 that leaves the ball there at the same x, whichever way it then goes.
  for (const double factor : {2.0, -0.5}) {
    const auto push = [factor](State<1>& s) { s.qdot *= factor; };
    const auto run = simulate(oscillator, released, 4.0, Dop853{}, fine, events(event("push", x).action(push)));
    REQUIRE(run.completed());
    check_times(times(run.events, "push"), {0.5 * pi});
  }
}

TEST_CASE("an event at the start counts when the motion goes its way, and one at the end counts") {
  const State<1> at_zero{0.0, V1(0.0), V1(1.0)};
  const auto run = simulate(oscillator, at_zero, pi, Dop853{}, fine,
                            events(event("up", x).rising(), event("down", x).falling(),
                                   event("end", [](const auto&, const auto&, double t) { return t - pi; })));
  check_times(times(run.events, "up"), {0.0}, 0.0);
  CHECK(times(run.events, "end") == std::vector<double>{pi});
  const auto caught = simulate(falling_ball, State<1>{0.0, V1(0.0), V1(-1.0)}, 0.1, Dop853{}, {},
                               events(event("floor", x).falling().action(Bounce{0.5})));
  REQUIRE(caught.completed());
  CHECK(times(caught.events, "floor").front() == 0.0);
  CHECK_THAT(caught.trajectory.at(0.05).q[0], WithinAbs(0.5 * 0.05 - 0.5 * 9.81 * 0.0025, 1e-12));
}

TEST_CASE("a jump across zero is no crossing") {
  const auto run = simulate(falling_ball, released, 0.8, Dop853{}, {},
                            events(event("floor", x).falling().action(Bounce{0.9}), event("turn", speed)));
  CHECK(times(run.events, "floor").size() == 1);
  check_times(times(run.events, "turn"), {0.0}, 0.0);  // the start is at rest, the top comes at 0.86
}

TEST_CASE("output times at a jump show the state behind it, and the observer sees both sides") {
  const auto bouncing = events(event("floor", x).falling().action(Bounce{0.5}));
  const double t1 = times(simulate(falling_ball, released, 0.6, Dop853{}, {}, bouncing).events, "floor").at(0);  // of the same steps
  std::vector<double> seen;
  const auto run = simulate(
      falling_ball, released, 0.6, Dop853{}, {.output_times = {0.1, t1, 0.5}},
      [&](const qdot::StepView& step) {
        if (step.t() == t1) seen.push_back(step.qdot()[0]);
      },
      bouncing);
  REQUIRE(run.samples.t.size() == 3);
  CHECK_THAT(run.samples.y(1, 1), WithinAbs(0.5 * std::sqrt(2 * 9.81), 1e-12));
  REQUIRE(seen.size() == 2);
  CHECK(seen[1] == -0.5 * seen[0]);
}

TEST_CASE("an observer is told each event once, with the first state that it sees behind it") {
  std::vector<qdot::RecordedEvent> told;
  bool in_step = true;
  const auto run = simulate(
      falling_ball, released, 1.2, Dop853{}, {},
      [&](const qdot::StepView& step) {
        for (const qdot::RecordedEvent& each : step.events()) {
          told.push_back(each);
          in_step = in_step && step.t_previous() <= each.t && each.t <= step.t();
          if (each.name == "turn") in_step = in_step && std::abs(step.y_at(each.t)[1]) < 1e-12;
        }
      },
      events(event("floor", x).falling().action(Bounce{0.5}), event("turn", speed)));
  REQUIRE(run.events.size() >= 3);
  REQUIRE(told.size() == run.events.size());
  for (std::size_t i = 0; i < told.size(); ++i) CHECK((told[i].t == run.events[i].t && told[i].name == run.events[i].name));
  CHECK(in_step);
}

TEST_CASE("a first-order system may be changed as a whole, and a function without a value is named") {
  const auto run = simulate(oscillator, released, 2.0, Dop853{}, fine,
                            events(event("reset", x).action([](double, Eigen::VectorXd& y) { y << 1.0, 0.0; })));
  CHECK_THAT(run.y[0], WithinAbs(std::cos(2.0 - 0.5 * pi), fine_error));
  const auto bad = simulate(oscillator, released, 2.0, Dop853{}, fine,
                            events(event("root", [](const auto& q) { return std::sqrt(q[0]); })));
  CHECK(bad.outcome == Outcome::non_finite);
  CHECK(bad.message.find("the function of event 'root' must be finite") != std::string::npos);
}

TEST_CASE("an action that leaves no state behind ends the run by the event's name, and the motion so far is kept") {
  const double nan = std::nan("");
  const auto check = [](const auto& action, Outcome outcome, const std::string& words) {
    const auto run = simulate(oscillator, released, 2.0, Dop853{}, fine, events(event("break", x).action(action)));
    REQUIRE(run.outcome == outcome);
    CAPTURE(run.message);
    CHECK(failed(run.outcome));
    CHECK(run.message.find("the action of event 'break' at t = 1.5707963") != std::string::npos);
    CHECK(run.message.find(words) != std::string::npos);
    check_times(times(run.events, "break"), {0.5 * pi});
    CHECK_THAT(run.trajectory.at(1.0).q[0], WithinAbs(std::cos(1.0), fine_error));
    CHECK_THAT(run.t, WithinAbs(0.5 * pi, fine_error));
    CHECK_THAT(run.y[1], WithinAbs(-1.0, fine_error));
  };
  check([nan](State<1>& s) { s.q[0] = nan; }, Outcome::non_finite, "must leave finite numbers, but q0 became nan");
  check([](State<1>& s) { s.qdot /= 0.0; }, Outcome::non_finite, "must leave finite numbers, but qdot0 became -inf");
  check([nan](double, Eigen::VectorXd& y) { y[0] = nan; }, Outcome::non_finite, "must leave finite numbers, but q0 became nan");
  check([](State<1>& s) { s.t = 5.0; }, Outcome::invalid_change, "must leave the time alone, but set it to 5; only q and qdot can be changed");
  check([](double, Eigen::VectorXd& y) { y.resize(3); }, Outcome::invalid_change, "must keep the size of y, but made 3 numbers of 2");
  CHECK_THROWS_AS(simulate(oscillator, released, 2.0, Dop853{}, fine, events(event("break", x).action([](State<1>&) { throw std::runtime_error("mine"); }))),
                  std::runtime_error);
}
