// SPDX-License-Identifier: MIT
#include "qdot/analysis/section.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include "catch2_bridge.hpp"
#include "error_message.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/scene_form.hpp"
#include "star.hpp"

using qdot::Dop853;
using qdot::event;
using qdot::events;
using qdot::Outcome;
using qdot::poincare_section;
using qdot::SectionOutcome;
using qdot::State;
using stars::on_plane;
using stars::plane;

namespace {

const double pi = std::numbers::pi, w = std::sqrt(2.0);
const qdot::Options fine{.rtol = 1e-13, .atol = 1e-14};
constexpr double settled = 1e-10;  // what is left of the tolerances after a hundred turns

const State<2> start{0.0, {0.0, 0.4}, {1.0, 0.3}};
double y_at(double t) { return 0.4 * std::cos(w * t) + 0.3 / w * std::sin(w * t); }
double ydot_at(double t) { return 0.3 * std::cos(w * t) - 0.4 * w * std::sin(w * t); }

}  // namespace

TEST_CASE("the section of two oscillators is an ellipse on which points advance by the ratio of the frequencies") {
  constexpr long count = 100;
  const auto found = poincare_section(stars::oscillators, start, plane(), count, 1e4, Dop853{}, fine);
  INFO(found.message);
  REQUIRE(found.complete());
  REQUIRE(found.size() == count);
  CHECK(found.run_outcome == Outcome::stopped_by_observer);
  CHECK(found.t_reached < 2 * pi * (count + 1));
  const double radius = std::hypot(0.4, 0.3 / w);
  for (std::size_t k = 0; k < count; ++k) {
    const auto point = found.state(k);
    const double t = 2 * pi * static_cast<double>(k + 1);  // the start is no crossing
    CHECK(std::abs(point.t - t) < settled);
    CHECK(std::abs(point.q[0]) < 1e-15 * (t + 1.0));  // a root of the dense output, as far as t can tell
    CHECK(std::abs(point.qdot[0] - 1.0) < settled);
    CHECK(std::abs(std::hypot(point.q[1], point.qdot[1] / w) - radius) < settled);
    CHECK(std::abs(point.q[1] - y_at(t)) < settled);
    CHECK(std::abs(point.qdot[1] - ydot_at(t)) < settled);
  }
}

TEST_CASE("a run backward rises where it comes from below, and a stroboscope shows the state at each period") {
  const auto backward = poincare_section(stars::oscillators, start, plane(), 3, -100.0, Dop853{}, fine);
  REQUIRE(backward.complete());
  const auto flashes = poincare_section(stars::oscillators, start, event("flash", stars::Plane{.omega = 2.0}).rising(), 3, 100.0, Dop853{}, fine);
  REQUIRE(flashes.complete());
  const auto clock = poincare_section(stars::oscillators, start, qdot::every("flash", pi), 3, 100.0, Dop853{}, fine);
  REQUIRE(clock.complete());
  for (std::size_t k = 0; k < 3; ++k) {
    const double t = -pi * static_cast<double>(2 * k + 1), flash = pi * static_cast<double>(k + 1);
    CHECK(std::abs(backward.t[k] - t) < settled);
    CHECK(std::abs(backward.state(k).q[1] - y_at(t)) < settled);
    CHECK(std::abs(flashes.t[k] - flash) < 1e-14);
    CHECK(std::abs(clock.t[k] - flash) < 1e-14);
    CHECK(std::abs(clock.state(k).qdot[1] - ydot_at(flash)) < settled);
    CHECK(std::abs(flashes.state(k).qdot[1] - ydot_at(flash)) < settled);
  }
}

// With R: ydot ↦ −ydot the section of a potential that is even in x goes back as it came, P R P = R.
TEST_CASE("the section of Hénon's and Heiles' star keeps its energy and goes back as it came") {
  constexpr double E = 1.0 / 12.0;
  constexpr long count = 20;
  const auto there = poincare_section(stars::henon_heiles, on_plane(E, 0.1, 0.07), plane(), count, 1e4, Dop853{}, fine);
  REQUIRE(there.complete());
  for (std::size_t k = 0; k < count; ++k) {
    const auto s = there.state(k);
    CHECK(s.qdot[0] > 0.0);
    CHECK(std::abs(s.qdot[0] - on_plane(E, s.q[1], s.qdot[1]).qdot[0]) < settled);
  }
  const auto last = there.state(count - 1);
  const auto back = poincare_section(stars::henon_heiles, State<2>{0.0, last.q, {last.qdot[0], -last.qdot[1]}}, plane(), count, 1e4, Dop853{}, fine);
  REQUIRE(back.complete());
  CHECK(std::abs(back.state(count - 1).q[1] - 0.1) < settled);
  CHECK(std::abs(back.state(count - 1).qdot[1] + 0.07) < settled);
  CHECK(std::abs(back.state(0).q[1] - there.state(count - 2).q[1]) < settled);
}

// The second angle of a pair of pendula that know nothing of each other goes round: its turns take 4 K(k)/v with k = 2/v, where v is its speed below.
TEST_CASE("an angle that goes round passes its plane once in each turn") {
  const auto pendula = qdot::mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); },
                                                  [](const auto& q) {
                                                    using std::cos;
                                                    return -cos(q[0]) - cos(q[1]);
                                                  });
  const double v = 3.0, turn = 4.0 * std::comp_ellint_1(2.0 / v) / v;
  for (const double side : {1.0, -1.0}) {
    const State<2> round{0.0, {0.5, 0.0}, {0.0, side * v}};
    const auto below = event("below", [](const auto& q) {
      using std::sin;
      return sin(0.5 * q[1]);
    });
    const auto found = poincare_section(pendula, round, below, 10, 100.0, Dop853{}, fine, events(),
                                        [side](const auto&, const auto& qdot) { return side * qdot[1] > 0.0; });
    REQUIRE(found.complete());
    for (std::size_t k = 0; k < 10; ++k) {
      CHECK(std::abs(found.t[k] - turn * static_cast<double>(k + 1)) < settled);
      CHECK(std::abs(found.y(1, static_cast<Eigen::Index>(k)) - side * 2.0 * pi * static_cast<double>(k + 1)) < settled);
      CHECK(std::abs(found.y(3, static_cast<Eigen::Index>(k)) - side * v) < settled);
    }
    const auto none = poincare_section(pendula, round, below, 10, 100.0, Dop853{}, fine, events(),
                                       [side](const auto&, const auto& qdot) { return side * qdot[1] < 0.0; });
    CHECK(none.outcome == SectionOutcome::t_end_reached);
    CHECK(none.size() == 0);
  }
}

TEST_CASE("a surface that is not crossed, and a run that ends before, are told with what was found") {
  const auto far = poincare_section(stars::oscillators, start, plane(5.0), 3, 20.0, Dop853{}, fine);
  CHECK(far.outcome == SectionOutcome::t_end_reached);
  CHECK(far.run_outcome == Outcome::completed);
  CHECK(far.size() == 0);
  CHECK(far.y.cols() == 0);
  CHECK(far.t_reached == 20.0);
  CHECK(far.message.starts_with("t_end_reached: 0 of 3 crossings of 'plane' up to t = 20; its function went from -"));
  CHECK(far.message.find("give a surface that the motion crosses") != std::string::npos);

  const auto few = poincare_section(stars::oscillators, start, plane(), 9, 20.0, Dop853{}, fine);
  CHECK(few.outcome == SectionOutcome::t_end_reached);
  CHECK(few.size() == 3);
  CHECK(few.message.ends_with("give a later t_end"));

  const auto limited = poincare_section(stars::oscillators, start, plane(), 9, 1e4, Dop853{}, {.rtol = 1e-6, .atol = 1e-6, .max_steps = 40});
  CHECK(limited.outcome == SectionOutcome::run_ended);
  CHECK(limited.run_outcome == Outcome::step_limit);
  CHECK(limited.size() >= 1);
  CHECK(limited.size() < 9);
  CHECK(limited.message.find("; the run ended as step_limit") != std::string::npos);

  const auto stopped = poincare_section(stars::oscillators, start, plane(), 9, 1e4, Dop853{}, fine,
                                        events(event("end", stars::Plane{.at = 0.5}).falling().stop()));
  CHECK(stopped.outcome == SectionOutcome::run_ended);
  CHECK(stopped.run_outcome == Outcome::stopped_by_event);
  CHECK(stopped.size() == 0);
}

TEST_CASE("a section of no crossings, or with two events of one name, is refused in words") {
  CHECK(qdot::error_message([] { poincare_section(stars::oscillators, start, plane(), 0, 1.0); }) ==
        "a section must have at least one crossing, but 0 were asked for; give a positive count");
  CHECK(qdot::error_message([] {
          poincare_section(stars::oscillators, start, plane(), 1, 1.0, Dop853{}, {},
                           events(event("plane", stars::Plane{.at = 0.5}).falling().stop()));
        }) == "the surface of a section must have a name of its own, but another event is called 'plane', too; rename one");
  CHECK(qdot::error_message([] { poincare_section(stars::oscillators, start, plane(), 1, 1.0).state(0); })
            .starts_with("a crossing of a section must be one of the 0 that were found, but number 0 (from 0) was asked for"));
}

// On a circle V = ½ r² stays the same, and a bead goes round at a constant rate.
TEST_CASE("on a constraint the points of a section fulfil it") {
  const auto bead = qdot::scene(qdot::mechanical_system<2>(stars::Star{}),
                                qdot::holonomic("ring", [](const auto& q) { return q[0] * q[0] + q[1] * q[1] - 1.0; }));
  const auto found = poincare_section(bead, State<2>{0.0, {1.0, 0.0}, {0.0, 0.5}}, plane(0.6), 5, 100.0, Dop853{}, {.rtol = 1e-10, .atol = 1e-10});
  REQUIRE(found.complete());
  for (std::size_t k = 0; k < found.size(); ++k) {
    const auto s = found.state(k);
    CHECK(std::abs(s.q.squaredNorm() - 1.0) < 1e-14);
    CHECK(std::abs(s.q.dot(s.qdot)) < 1e-14);
    CHECK(std::abs(s.t - 2.0 * (2 * pi * static_cast<double>(k + 1) - std::acos(0.6))) < 1e-7);
    CHECK(std::abs(s.q[1] + 0.8) < 1e-7);
  }
}
