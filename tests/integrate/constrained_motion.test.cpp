// SPDX-License-Identifier: MIT
#include <cmath>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/any_system.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/event.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

namespace {

using Eigen::Vector2d;

// Period of a pendulum of length 1 from 1 rad at g = 9.81: 4 √(l/g) K(sin² ½).
constexpr double period = 2.13913760055869;

// Rounding of x² + y² − 1 and of 2 (x ẋ + y ẏ) on a unit circle at speeds up to 3 m/s.
constexpr double position_rounding = 1e-15;
constexpr double velocity_rounding = 4e-15;

const auto pendulum = qdot::scene(qdot::mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); },
                                                             [](const auto& q) { return 9.81 * q[1]; })
                                      .with_names({"x", "y"}),
                                  qdot::holonomic("rod", [](const auto& q) { return q.squaredNorm() - 1.0; }));
const qdot::State<2> released{0.0, Vector2d(std::sin(1.0), -std::cos(1.0)), Vector2d(0.0, 0.0)};

template <class Method>
auto after_periods(double periods, const Method& method, const qdot::Options& options = {}) {
  return qdot::simulate(pendulum, released, periods * period, method, options);
}

TEST_CASE("a pendulum in Cartesian coordinates stays on its circle and returns after its period") {
  const auto check = [](const auto& run, double error) {
    REQUIRE(run.completed());
    CHECK(run.statistics.projections >= run.statistics.steps);
    CHECK(run.statistics.constraint_residual <= position_rounding);
    CHECK(run.statistics.constraint_velocity <= velocity_rounding);
    CHECK((run.y.head(2) - released.q).norm() < error);
  };
  // Local errors of 1e-10 add up over ten periods to 1e-9 (order 8) and 1e-7 (BDF).
  check(after_periods(10, qdot::Dop853{}, {.rtol = 1e-10, .atol = 1e-12}), 1e-9);
  check(after_periods(10, qdot::CvodeBdf{}, {.rtol = 1e-10, .atol = 1e-12}), 1e-7);
}

// A thousand are in tests/optimized/million_periods.test.cpp.
TEST_CASE("a hundred periods neither drift off the circle nor gain energy") {
  const auto run = after_periods(100, qdot::Dop853{}, {.keep_trajectory = false});
  REQUIRE(run.completed());
  CHECK(std::abs(run.y.head(2).norm() - 1.0) < position_rounding);
  const double drift = energy(pendulum, run.y.head(2), run.y.tail(2)) - energy(pendulum, released.q, released.qdot);
  CHECK(std::abs(drift) < 3e-6);  // local errors of 1e-9 in 3000 steps, all of one sign
}

TEST_CASE("output between steps lies on the constraints too") {
  qdot::Options options;
  for (int i = 1; i < 50; ++i) options.output_times.push_back(0.05 * i);
  const auto run = qdot::simulate(pendulum, released, 2.5, qdot::Dop853{}, options);
  REQUIRE(run.samples.t.size() == 49);
  for (Eigen::Index i = 0; i < run.samples.y.cols(); ++i) {
    const Eigen::Vector4d y = run.samples.y.col(i);
    CHECK(std::abs(y.head<2>().squaredNorm() - 1.0) <= position_rounding);
    CHECK(std::abs(y.head<2>().dot(y.tail<2>())) <= velocity_rounding);
  }
}

TEST_CASE("of a kick that an event gives, constraints leave what they allow: the part along the circle") {
  const auto kicked = qdot::event("bottom", [](const auto& q) { return q[0]; }).action([](qdot::State<2>& s) {
    s.qdot[0] *= 0.5;
    s.qdot[1] += 1.0;  // along the rod
  });
  const auto run = qdot::simulate(pendulum, released, 0.3 * period, qdot::Dop853{}, {.rtol = 1e-11, .atol = 1e-12}, kicked);
  REQUIRE(run.completed());
  REQUIRE(run.events.size() == 1);
  CHECK(std::abs(run.events[0].t - 0.25 * period) < 1e-9);
  const auto after = run.trajectory.at(run.events[0].t);
  const double speed = std::sqrt(2 * 9.81 * (1.0 - std::cos(1.0)));  // at the bottom, of the energy
  CHECK(std::abs(after.qdot[0] + 0.5 * speed) < 1e-9);
  CHECK(std::abs(after.q.dot(after.qdot)) <= velocity_rounding);
}

TEST_CASE("a function that a constraint keeps at zero has no events, whatever the start, the method and the tolerance") {
  const auto kept = [](const auto& start, const auto& method, const qdot::Options& options) {
    const auto run = qdot::simulate(pendulum, start, 5.0, method, options,
                                    qdot::events(qdot::event("on the circle", [](const auto& q) { return q[0] * q[0] + q[1] * q[1] - 1.0; }),
                                                 qdot::event("along it", [](const auto& q, const auto& v) { return q[0] * v[0] + q[1] * v[1]; })));
    INFO(run.message);
    REQUIRE(run.completed());
    CHECK(run.events.empty());
    CHECK(run.statistics.unresolved_events == 0);
  };
  for (const Vector2d& from : {Vector2d(1.0, 0.0), Vector2d(std::sin(1.0), -std::cos(1.0)), Vector2d(0.6, -0.8)})
    for (const double speed : {0.0, 1e-6, 2.0, 20.0})
      for (const qdot::Options& options : {qdot::Options{}, qdot::Options{.rtol = 1e-4}, qdot::Options{.rtol = 1e-12}}) {
        CAPTURE(from[0], speed, options.rtol);
        const qdot::State<2> start{0.0, from, Vector2d(-speed * from[1], speed * from[0])};
        kept(start, qdot::Dop853{}, options);
        kept(start, qdot::CvodeBdf{}, {.rtol = std::max(1e-10, options.rtol)});
      }
}

TEST_CASE("backward in time the pendulum retraces its way") {
  const auto there = qdot::simulate(pendulum, released, 3.0, qdot::Dop853{}, {.rtol = 1e-12, .atol = 1e-13});
  const auto back = qdot::simulate(pendulum, there.state(), 0.0, qdot::Dop853{}, {.rtol = 1e-12, .atol = 1e-13});
  REQUIRE(back.completed());
  CHECK((back.y.head(2) - released.q).norm() < 1e-10);
}

TEST_CASE("a method that cannot keep constraints refuses them") {
  CHECK_THROWS_WITH(after_periods(1, qdot::CvodeAdams{}),
                    "a system with constraints needs a method that can project onto them, but cvode_adams cannot (CVODE "
                    "projects with BDF only); use CvodeBdf, Dop853 or Dopri5");
}

TEST_CASE("what hides a system's type hides neither that it has constraints nor that it has none") {
  const qdot::AnySystem held = pendulum;
  CHECK_THROWS_WITH(qdot::simulate(held, released, 1.0, qdot::CvodeAdams{}),
                    Catch::Matchers::StartsWith("a system with constraints needs a method that can project onto them, but cvode_adams cannot"));
  const auto free = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.5 * q[0] * q[0]; });
  const qdot::State<1> start{0.0, qdot::Vector<double, 1>(1.0), qdot::Vector<double, 1>(0.0)};
  const auto run = qdot::simulate(qdot::AnySystem(free), start, 2.0, qdot::CvodeAdams{}, {.rtol = 1e-10, .atol = 1e-10});
  REQUIRE(run.completed());
  CHECK(std::abs(run.y[0] - std::cos(2.0)) < 1e-8);
  CHECK(run.y == qdot::simulate(free, start, 2.0, qdot::CvodeAdams{}, {.rtol = 1e-10, .atol = 1e-10}).y);
}

TEST_CASE("a start off its constraints is refused with the coordinate and the remedy") {
  CHECK_THROWS_WITH(qdot::simulate(pendulum, qdot::State<2>{0.0, Vector2d(1, 1), Vector2d(0, 0)}, 1.0, qdot::Dop853{}),
                    "a start must satisfy the constraints, but x = 1 would have to be 0.7071067812; take "
                    "consistent_state(scene, start).state");
}

TEST_CASE("constraints that stop making sense end the run in a named outcome and keep it so far") {
  // The guide's slope is bounded at the start and vertical later: x = t while x² + y² = 1 can follow until t = 1.
  const auto s = qdot::scene(qdot::mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }),
                             qdot::holonomic("circle", [](const auto& q) { return q.squaredNorm() - 1.0; }),
                             qdot::prescribed("slide", 0, [](const auto& t) { return t; }));
  const auto run = qdot::simulate(s, qdot::State<2>{0.0, Vector2d(0, 1), Vector2d(1, 0)}, 2.0, qdot::Dop853{});
  CHECK(run.outcome == qdot::Outcome::constraint_failure);
  CHECK((run.message.find("'slide'") != std::string::npos || run.message.find("'circle'") != std::string::npos));
  CHECK(run.t > 0.9);
  CHECK(run.t <= 1.0 + 1e-6);
  CHECK(run.trajectory.back_time() == run.t);
}

}  // namespace
