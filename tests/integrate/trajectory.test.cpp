// SPDX-License-Identifier: MIT
#include "qdot/integrate/trajectory.hpp"

#include <string>

#include "catch2_bridge.hpp"
#include "first_order_systems.hpp"

using qdot::DenseOutput;
using qdot::PolynomialView;
using qdot::Trajectory;

namespace {

constexpr double rounding = 1e-14;  // a few operations on numbers of size one

// (t², t³) exactly, as a cubic about any origin and in any scale.
Eigen::MatrixXd powers(double origin, double scale) {
  const double a = origin, h = scale;
  Eigen::MatrixXd c(2, 4);
  c << a * a, 2 * a * h, h * h, 0,  //
      a * a * a, 3 * a * a * h, 3 * a * h * h, h * h * h;
  return c;
}

void append_powers(DenseOutput& output, double t_end, double origin, double scale) {
  const Eigen::MatrixXd c = powers(origin, scale);
  output.append(t_end, PolynomialView{origin, scale, c.data(), 2, 3});
}

}  // namespace

TEST_CASE("a polynomial view has the values of its polynomial and its first coefficient at the origin") {
  const Eigen::MatrixXd c = powers(2.0, -0.5);
  const PolynomialView view{2.0, -0.5, c.data(), 2, 3};
  Eigen::VectorXd y(2);
  view.evaluate(3.0, y);
  REQUIRE_THAT(y[0], WithinAbs(9.0, rounding));
  REQUIRE_THAT(y[1], WithinAbs(27.0, 10 * rounding));
  REQUIRE(view.evaluate(3.0, 1) == y[1]);
  view.evaluate(2.0, y);
  REQUIRE(y == c.col(0));
}

TEST_CASE("a trajectory of polynomial pieces of any origin and scale is the function they came from") {
  for (const double direction : {1.0, -1.0}) {
    Trajectory<> trajectory(1);
    trajectory.start(0.0, test::vector({0.0, 0.0}));
    append_powers(trajectory, direction * 1.0, direction * 1.0, direction * 1.0);  // origin at the end of the step
    append_powers(trajectory, direction * 1.5, direction * 1.0, direction * 0.5);  // at its beginning
    append_powers(trajectory, direction * 4.0, 0.0, 7.0);                          // elsewhere
    REQUIRE(trajectory.times() == std::vector<double>{0.0, direction * 1.0, direction * 1.5, direction * 4.0});
    for (const double x : {0.0, 0.3, 1.0, 1.2, 1.5, 2.7, 4.0}) {
      const double t = direction * x;
      const auto state = trajectory.at(t);
      REQUIRE(state.t == t);
      REQUIRE_THAT(state.q[0], WithinAbs(t * t, 10 * rounding));
      REQUIRE_THAT(state.qdot[0], WithinAbs(t * t * t, 100 * rounding));
    }
    REQUIRE(trajectory.front().t == 0.0);
    REQUIRE(trajectory.back().t == direction * 4.0);
    REQUIRE(trajectory.sampled(5).size() == 5);
    REQUIRE(trajectory.sampled(5)[4].t == direction * 4.0);
  }
}

TEST_CASE("a time at a jump belongs to the state after it, and the state in front of it is kept") {
  Trajectory<> trajectory(1);
  trajectory.start(0.0, test::vector({0.0, 0.0}));
  append_powers(trajectory, 1.0, 1.0, 1.0);
  trajectory.jump(test::vector({1.0, -0.8}));
  REQUIRE(trajectory.back().qdot[0] == -0.8);
  append_powers(trajectory, 2.0, 2.0, 1.0);
  REQUIRE(trajectory.at(1.0).qdot[0] == -0.8);
  REQUIRE(trajectory.before(1.0).qdot[0] == 1.0);
  REQUIRE(trajectory.at(2.0).qdot[0] == 8.0);
  REQUIRE(trajectory.steps() == 2);
  REQUIRE(trajectory.times() == std::vector<double>{0.0, 1.0, 2.0});
  REQUIRE(trajectory.jump_times() == std::vector<double>{1.0});
}

TEST_CASE("a jump at the very start is seen at the start") {
  Trajectory<> trajectory(1);
  trajectory.start(0.0, test::vector({0.0, 1.0}));
  trajectory.jump(test::vector({0.0, -1.0}));
  REQUIRE(trajectory.at(0.0).qdot[0] == -1.0);
  REQUIRE(trajectory.front().qdot[0] == 1.0);
}

TEST_CASE("a time outside the trajectory is refused with the range") {
  Trajectory<> trajectory(1);
  trajectory.start(0.0, test::vector({0.0, 0.0}));
  append_powers(trajectory, 1.0, 1.0, 1.0);
  for (const double t : {-1e-9, 1.0 + 1e-9, test::nan}) REQUIRE_THROWS_AS(trajectory.at(t), qdot::InvalidValue);
  std::string message;
  try {
    trajectory.at(1.25);
  } catch (const qdot::InvalidValue& error) {
    message = error.what();
  }
  REQUIRE(
      message ==
      "t must lie within the trajectory, from 0 to 1, but is 1.25; extend the run, or ask for a time it has reached");
}

TEST_CASE("a system without coordinates has y(t) but no states") {
  Trajectory<> trajectory(0);
  trajectory.start(0.0, test::vector({3.0}));
  REQUIRE(trajectory.y(0.0)[0] == 3.0);
  REQUIRE_THROWS_AS(trajectory.at(0.0), qdot::InvalidValue);
}
