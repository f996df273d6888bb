// SPDX-License-Identifier: MIT
//
// Four runs that stand still, each for a reason that is known, and what became NaN first.

#include <cmath>
#include <functional>
#include <string>

#include "catch2_bridge.hpp"
#include "first_order_systems.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/watch/diagnosis.hpp"

using namespace qdot;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

constexpr double room = 4e-13;  // between two walls and the middle

const FirstOrderState one{0.0, test::vector({1.0})};

test::FirstOrder of(std::function<double(double, double)> f) {
  return {{"y"},
          [f](double t, const test::In& y, test::OutVector d) { d[0] = f(t, y[0]); },
          [](double, const test::In&, test::OutMatrix J) { J(0, 0) = 0; }};
}

// The number behind `label` in a message.
double number_behind(const std::string& text, const std::string& label) {
  const std::size_t at = text.find(label);
  REQUIRE(at != std::string::npos);
  return std::stod(text.substr(at + label.size()));
}

}  // namespace

TEST_CASE("a stiff system that used up its steps is called stiff, with its fastest rate") {
  constexpr double rate = 1e6;
  const auto run = simulate(of([](double t, double y) { return -rate * (y - std::cos(t)); }), one, 10.0, Dop853{},
                            {.rtol = 1e-6, .max_steps = 3000});
  REQUIRE(run.outcome == Outcome::step_limit);
  CHECK(contains(run.message, "diagnosis: stiff"));
  CHECK_THAT(number_behind(run.message, "|lambda| = "), WithinRel(rate, 1e-3));  // ∂f/∂y = −1e6
  const double h_rho = number_behind(run.message, "h |lambda| = ");
  CHECK(h_rho > 1.0);  // Dop853 is stable up to about 6
  CHECK(h_rho < 7.0);
}

TEST_CASE("a right-hand side that points at its own jump from both sides is called discontinuous, with both values") {
  const auto run = simulate(of([](double, double y) { return y > 0 ? -1.0 : 2.0; }), one, 10.0, Dop853{}, {.max_steps = 20'000});
  REQUIRE(failed(run.outcome));
  CHECK(contains(run.message, "diagnosis: discontinuous: the derivative of y jumps from "));
  CHECK((contains(run.message, "from -1 to 2") || contains(run.message, "from 2 to -1")));
  CHECK_THAT(number_behind(run.message, "near t = "), WithinAbs(1.0, 1e-6));
}

TEST_CASE("a solution that runs to infinity is called singular, with the component") {
  const auto run = simulate(test::blow_up(), one, 2.0, Dop853{}, {.rtol = 1e-8});
  REQUIRE(failed(run.outcome));
  CHECK(contains(run.message, "diagnosis: singular: y = "));
  CHECK_THAT(run.t, WithinAbs(1.0, 1e-6));
}

TEST_CASE("a fall into a centre of attraction is called singular") {
  // From rest at r = 1 in the potential −1/r the fall takes π/√8.
  const auto fall = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return -1.0 / q[0]; });
  const auto run = simulate(fall, State<1>{0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)}, 2.0, Dop853{}, {.rtol = 1e-9});
  REQUIRE(failed(run.outcome));
  CHECK_THAT(run.t, WithinAbs(1.1107207345395915, 1e-5));
  INFO(run.message);
  CHECK((contains(run.message, "diagnosis: singular") || run.outcome == Outcome::energy_drift));
}

TEST_CASE("a mass that rattles between two walls without room is called event chatter") {
  const test::FirstOrder flight{{"x", "v"},
                                [](double, const test::In& y, test::OutVector d) { d << y[1], 0.0; },
                                [](double, const test::In&, test::OutMatrix J) { J << 0, 1, 0, 0; }};
  const auto turn = [](double, Eigen::VectorXd& y) { y[1] = -y[1]; };
  const auto walls = events(event("left", [](const auto& q) { return q[0] + room; }).falling().action(turn),
                            event("right", [](const auto& q) { return room - q[0]; }).falling().action(turn));
  const auto run = simulate(flight, FirstOrderState{0.0, test::vector({0.0, 1.0})}, 10.0, Dop853{}, {.max_steps = 2000, .keep_trajectory = false}, walls);
  REQUIRE(failed(run.outcome));
  CHECK(contains(run.message, "diagnosis: event chatter: "));
}

TEST_CASE("small steps with no such reason get no diagnosis") {
  const auto run = simulate(test::oscillator(), FirstOrderState{0.0, test::vector({1.0, 0.0})}, 1e3, Dop853{}, {.max_steps = 50});
  CHECK(run.outcome == Outcome::step_limit);
  CHECK_FALSE(contains(run.message, "diagnosis"));
}

TEST_CASE("what stops being a number is named with the time and the state of its first appearance") {
  const auto system = test::pendulum_until(0.73, [](test::OutVector d) { d[1] = test::nan; });
  const auto run = simulate(system, FirstOrderState{0.0, test::vector({1.0, 0.0})}, 5.0, Dop853{});
  REQUIRE(run.outcome == Outcome::non_finite);
  CHECK_THAT(number_behind(run.message, "first at t = "), WithinAbs(0.73, 1e-9));
  CHECK(contains(run.message, ", where the derivative of thetadot is nan"));
  CHECK(contains(run.message, " with theta = "));
}

TEST_CASE("the energy that stops being a number is named") {
  const auto edge = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                         [](const auto& q) {
                                           using std::sqrt;
                                           return -2.0 / 3.0 * (1.0 - q[0]) * sqrt(1.0 - q[0]);
                                         });
  const auto run = simulate(edge, State<1>{0.0, Vector<double, 1>(0.0), Vector<double, 1>(2.0)}, 5.0, Dop853{}, {.rtol = 1e-8});
  REQUIRE(run.outcome == Outcome::non_finite);
  CHECK_THAT(number_behind(run.message, "with q0 = "), WithinAbs(1.0, 1e-6));
  // At q = 1 itself V is 0, but the derivative of the root is not finite; behind it V is not.
  CHECK((contains(run.message, ", where V is ") || contains(run.message, "not the derivative of T - V with q0")));
}

TEST_CASE("a model that throws when it is asked for a reason leaves the run its outcome") {
  const auto system = test::pendulum_until(1.0, [](test::OutVector) { throw RecoverableError("not beyond"); });
  const auto run = simulate(system, FirstOrderState{0.0, test::vector({1.0, 0.0})}, 5.0, Dop853{});
  CHECK(run.outcome == Outcome::refused_by_model);
  CHECK(run.t <= 1.0);
}
