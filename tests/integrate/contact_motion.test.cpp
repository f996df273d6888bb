// SPDX-License-Identifier: MIT
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

using qdot::Dop853;
using qdot::scene;
using qdot::simulate;
using qdot::State;

namespace {

using Eigen::Vector2d;
using V1 = qdot::Vector<double, 1>;
constexpr double g = 9.81;
const qdot::Options fine{.rtol = 1e-12, .atol = 1e-13};

std::vector<std::string> names(const std::vector<qdot::RecordedEvent>& list) {
  std::vector<std::string> result;
  for (const auto& e : list) result.push_back(e.name);
  return result;
}

auto ball_on_floor(qdot::ImpactLaw law) {
  return scene(qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return g * q[0]; }),
               qdot::contact("floor", [](const auto& q) { return q[0]; }, law));
}

}  // namespace

TEST_CASE("a ball bounces as the closed form says, comes to rest near its Zeno time and stays on the floor") {
  const auto check = [](const qdot::ImpactLaw& law, double error) {
    const double e = law.e;
    const auto run = simulate(ball_on_floor(law), State<1>{0.0, V1(1.0), V1(0.0)}, 10.0, Dop853{});
    REQUIRE(run.completed());
    double t = std::sqrt(2.0 / g);
    int impacts = 0;
    for (const auto& event : run.events) {
      if (event.name != "floor") continue;
      CHECK_THAT(event.t, WithinAbs(t, error));
      t += 2 * std::pow(e, ++impacts) * std::sqrt(2.0 / g);
    }
    const double zeno = std::sqrt(2.0 / g) * (1 + e) / (1 - e);
    REQUIRE(run.events.back().name == "floor rests");
    CHECK(run.events.back().t < zeno + error);
    CHECK(zeno - run.events.back().t < 1e-3);
    CHECK(std::abs(run.y[0]) < 1e-12);
    CHECK(run.y[1] == 0.0);
    return impacts;
  };
  CHECK(check(qdot::restitution(0.8), 1e-10) >= 40);
  CHECK(check(qdot::poisson_restitution(0.5), 1e-10) >= 14);
}

TEST_CASE("a ball that lies on the floor is thrown off by a floor that drops faster than it falls") {
  const auto s = scene(qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return g * q[0]; }),
                       qdot::contact("lift", [](const auto& q, const auto& t) {
                         using std::cos;
                         return q[0] - 0.2 * cos(10.0 * t);  // its acceleration reaches −20
                       }));
  // Carried upwards from the bottom at t = −π/10; leaves where −20 cos 10t = −g.
  const double leaves = -std::acos(g / 20) / 10.0;
  const auto run = simulate(s, State<1>{-std::numbers::pi / 10, V1(-0.2), V1(0.0)}, 0.0, Dop853{}, fine);
  REQUIRE(run.completed());
  REQUIRE(names(run.events) == std::vector<std::string>{"lift opens"});
  CHECK_THAT(run.events[0].t, WithinAbs(leaves, 1e-10));
  const double x0 = 0.2 * std::cos(10 * leaves), v0 = -2.0 * std::sin(10 * leaves), t = -leaves;
  CHECK_THAT(run.y[0], WithinAbs(x0 + v0 * t - 0.5 * g * t * t, 1e-10));
}

TEST_CASE("a pendulum on a rope goes slack at the angle of the closed form, flies a parabola and is caught") {
  const auto point = [](const auto& q) { return q; };
  const auto s = scene(qdot::mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return g * q[1]; })
                           .with_names({"x", "y"}),
                       qdot::rope("rope", point, Vector2d(0.0, 0.0), 1.0));
  const double v0 = 5.5;  // at the bottom: 2 g l < v₀² < 5 g l
  const auto check = [&](const auto& run, double error) {
    REQUIRE(run.completed());
    REQUIRE(run.events.size() >= 2);
    CHECK(run.events[0].name == "rope slack");
    CHECK(run.events[1].name == "rope taut");
    CHECK_THAT(run.events[0].t, WithinAbs(0.48133798197646, error));
    const auto slack = run.trajectory.at(run.events[0].t);
    CHECK_THAT(slack.q[1], WithinAbs(-(2 - v0 * v0 / g) / 3, error));  // cos θ = (2 − v₀²/gl)/3
    CHECK_THAT(slack.qdot.norm(), WithinAbs(1.88237438713272, error));
    // The parabola from a circle meets it again at t = 4 v sin α / g, where v² = g l cos α at the slack point.
    const double t = 0.5 * (run.events[1].t - run.events[0].t);
    const Eigen::Vector2d expected = slack.q + t * slack.qdot - Vector2d(0, 0.5 * g * t * t);
    CHECK((run.trajectory.at(run.events[0].t + t).q - expected).norm() < error);
    const double rise = std::acos(slack.q[1]);  // angle from the top
    CHECK_THAT(run.events[1].t - run.events[0].t, WithinAbs(4 * slack.qdot.norm() * std::sin(rise) / g, 10 * error));
    const auto before = run.trajectory.before(run.events[1].t), after = run.trajectory.at(run.events[1].t);
    CHECK(std::abs(after.q.dot(after.qdot)) < 1e-12);
    const double tangential = before.q[0] * before.qdot[1] - before.q[1] * before.qdot[0];
    CHECK_THAT(after.q[0] * after.qdot[1] - after.q[1] * after.qdot[0], WithinAbs(tangential, 1e-9));
  };
  const State<2> start{0.0, Vector2d(0, -1), Vector2d(v0, 0)};
  check(simulate(s, start, 1.5, Dop853{}, fine), 1e-9);
  check(simulate(s, start, 1.5, qdot::CvodeBdf{}, {.rtol = 1e-10}), 1e-6);
}

TEST_CASE("a blow passes through Newton's cradle to the last ball") {
  const auto gap = [](int i) { return [i](const auto& q) { return q[i + 1] - q[i] - 0.1; }; };
  const auto cradle = scene(qdot::mechanical_system<4>([](const auto& v) { return 0.5 * v.squaredNorm(); }),
                            qdot::contact("12", gap(0), qdot::restitution(1.0)), qdot::contact("23", gap(1), qdot::restitution(1.0)),
                            qdot::contact("34", gap(2), qdot::restitution(1.0)));
  State<4> start{0.0, Eigen::Vector4d(-1.0, 0.0, 0.1, 0.2), Eigen::Vector4d(2.0, 0, 0, 0)};
  const auto run = simulate(cradle, start, 1.0, Dop853{});
  REQUIRE(run.completed());
  CHECK(names(run.events) == std::vector<std::string>{"12", "23", "34"});
  CHECK((run.y.segment<4>(4) - Eigen::Vector4d(0, 0, 0, 2.0)).norm() < 1e-14);
  start.qdot[1] = start.qdot[0] = 2.0;
  start.q << -0.6, -0.5, 0.1, 0.2;  // two balls in, two balls out
  CHECK((simulate(cradle, start, 1.0, Dop853{}).y.segment<4>(4) - Eigen::Vector4d(0, 0, 2.0, 2.0)).norm() < 1e-14);
}

TEST_CASE("a ball in a corner is thrown back by both walls, and energy never grows") {
  const auto wall_x = [](const auto& q) { return q[0]; };
  const auto wall_y = [](const auto& q) { return q[1]; };
  const auto free = qdot::mechanical_system<2>([](const auto& v) { return v[0] * v[0] + v[0] * v[1] + v[1] * v[1]; });  // coupled inertia
  const State<2> start{0.0, Vector2d(0.0, 0.0), Vector2d(-1.0, -0.6)};
  const auto kinetic = [](double a, double b) { return a * a + a * b + b * b; };
  for (const double e1 : {0.0, 0.4, 1.0})
    for (const double e2 : {0.0, 0.7, 1.0}) {
      const auto check = [&](const auto& law1, const auto& law2) {
        const auto run = simulate(scene(free, qdot::contact("x", wall_x, law1), qdot::contact("y", wall_y, law2)), start, 0.1, Dop853{});
        REQUIRE(run.completed());
        CHECK(run.events.size() >= 2);
        CHECK(run.y[0] >= -1e-14);
        CHECK(run.y[1] >= -1e-14);
        CHECK(kinetic(run.y[2], run.y[3]) <= kinetic(-1.0, -0.6) + 1e-14);
      };
      check(qdot::restitution(e1), qdot::restitution(e2));
      check(qdot::poisson_restitution(e1), qdot::poisson_restitution(e2));
      check(qdot::poisson_restitution(e1), qdot::restitution(e2));
    }
}

TEST_CASE("constraints take their part of a blow") {
  // A rod pendulum in Cartesian coordinates swings against a wall at x = 0: the rod keeps the ball on its circle.
  const auto s = scene(qdot::mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return g * q[1]; }),
                       qdot::holonomic("rod", [](const auto& q) { return q.squaredNorm() - 1.0; }),
                       qdot::contact("wall", [](const auto& q) { return q[0] + 0.6; }, qdot::restitution(0.5)));
  const auto run = simulate(s, State<2>{0.0, Vector2d(0.6, -0.8), Vector2d(0.0, 0.0)}, 1.0, Dop853{}, fine);
  REQUIRE(run.completed());
  CHECK(run.events.empty());  // it just reaches −0.6 with no velocity left
  const auto thrown = simulate(s, State<2>{0.0, Vector2d(0.6, -0.8), Vector2d(-0.8, -0.6)}, 0.8, Dop853{}, fine);
  REQUIRE(names(thrown.events) == std::vector<std::string>{"wall"});
  const auto before = thrown.trajectory.before(thrown.events[0].t), after = thrown.trajectory.at(thrown.events[0].t);
  CHECK((after.qdot + 0.5 * before.qdot).norm() < 1e-9);  // along the circle there is one direction only
  CHECK_THAT(before.qdot.norm(), WithinAbs(1.0, 1e-9));
}

TEST_CASE("a start beyond a contact is refused, one against it is struck at once") {
  CHECK_THROWS_WITH(simulate(ball_on_floor(qdot::restitution(0.5)), State<1>{0.0, V1(-0.1), V1(0.0)}, 1.0, Dop853{}),
                    "the gap of a contact must not be negative, but at t = 0.000000 that of 'floor' is -0.100000; start with the "
                    "contact open or just closed");
  const auto run = simulate(ball_on_floor(qdot::restitution(0.5)), State<1>{0.0, V1(0.0), V1(-2.0)}, 0.05, Dop853{});
  REQUIRE(names(run.events) == std::vector<std::string>{"floor"});
  CHECK(run.events[0].t == 0.0);
  CHECK_THAT(run.y[1], WithinAbs(1.0 - 0.05 * g, 1e-12));
  CHECK_THROWS_AS(qdot::restitution(1.5), qdot::InvalidValue);
}

TEST_CASE("a block with Coulomb friction loses 4F/k in amplitude each cycle and sticks where the closed form says") {
  const double k = 4.0, F = 0.3;
  const auto s = scene(qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [=](const auto& q) { return 0.5 * k * q[0] * q[0]; }),
                       qdot::dry_friction("block", 0, F));
  const auto check = [&](const auto& run, double error) {
    REQUIRE(run.completed());
    const std::vector<double> turns{-0.85, 0.7, -0.55, 0.4, -0.25, 0.1, 0.05};
    REQUIRE(run.events.size() == turns.size());
    for (std::size_t i = 0; i < turns.size(); ++i) {
      CHECK(run.events[i].name == (i + 1 == turns.size() ? "block sticks" : "block turns"));
      CHECK_THAT(run.events[i].t, WithinAbs(0.5 * std::numbers::pi * static_cast<double>(i + 1), error));
      CHECK_THAT(run.trajectory.at(run.events[i].t).q[0], WithinAbs(turns[i], error));
    }
    CHECK(run.y[1] == 0.0);
    CHECK(run.y[0] == run.trajectory.at(12.0).q[0]);
  };
  const State<1> start{0.0, V1(1.0), V1(0.0)};
  check(simulate(s, start, 20.0, Dop853{}, fine), 1e-10);
  check(simulate(s, start, 20.0, qdot::CvodeBdf{}, {.rtol = 1e-9}), 1e-6);
}

TEST_CASE("a block sticks until its load exceeds F_s, and then slips with F_k") {
  // Pulled by a spring whose end moves with w = 0.1: sticks until k w t = F_s.
  const double k = 2.0, w = 0.1, F_s = 0.5, F_k = 0.3;
  const auto s = scene(qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                                  [=](const auto& q, const auto& t) { return 0.5 * k * (w * t - q[0]) * (w * t - q[0]); }),
                       qdot::dry_friction("block", 0, F_k, F_s));
  const auto run = simulate(s, State<1>{0.0, V1(0.0), V1(0.0)}, 8.0, Dop853{}, fine);
  REQUIRE(run.completed());
  REQUIRE(run.events.size() >= 3);
  const double slips = F_s / (k * w), omega = std::sqrt(k), A = (F_s - F_k) / k;
  CHECK(names({run.events[0], run.events[1], run.events[2]}) == std::vector<std::string>{"block slips", "block sticks", "block slips"});
  CHECK_THAT(run.events[0].t, WithinAbs(slips, 1e-10));
  // x = w τ + A (1 − cos ωτ) − (w/ω) sin ωτ stops where w (1 − cos ωτ) + A ω sin ωτ = 0: tan(ωτ/2) = −A ω / w.
  const double stops = slips + 2 * (std::numbers::pi - std::atan(A * omega / w)) / omega;
  CHECK_THAT(run.events[1].t, WithinAbs(stops, 1e-9));
  const auto z = settled_states(s, State<1>{2.0, V1(0.0), V1(0.0)});
  CHECK_THAT(reactions(s, V1(0.0), V1(0.0), 2.0, z)[0], WithinAbs(-k * w * 2.0, 1e-12));
}
