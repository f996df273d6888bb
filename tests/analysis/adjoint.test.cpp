// SPDX-License-Identifier: MIT
#include "qdot/analysis/adjoint.hpp"

#include <cmath>
#include <string>
#include <type_traits>

#include "catch2_bridge.hpp"
#include "systems/double_pendulum_of_parameters.hpp"

using qdot::Dop853;
using qdot::adjoint_sensitivities;
using qdot::Options;
using qdot::Outcome;
using qdot::sensitivities;
using qdot::State;

namespace {

const Options fine{.rtol = 1e-13, .atol = 1e-14};
using Five = qdot::Vector<double, 5>;


// A ball above a floor, tied to the height 5 by a spring, p = (g, e, height, velocity, k), until it falls below a level.
struct Ball {
  double g = 0.0, k = 0.0;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const { return g * q[0] + 0.5 * k * (q[0] - 5.0) * (q[0] - 5.0); }
};
struct Bounce {
  double e = 1.0;
  double* touched = nullptr;
  void operator()(State<1>& s) const {
    s.qdot *= -e;
    if (touched != nullptr) *touched += 1.0;
  }
};
struct BallOf {
  double level = -1.0;
  double* touched = nullptr;
  auto operator()(const Five& p) const {
    const auto floor = qdot::event("floor", [](const auto& q) { return q[0]; }).falling().action(Bounce{p[1], touched});
    const auto low = qdot::event("level", [to = level](const auto& q) { return q[0] - to; }).falling().stop();
    return qdot::problem(qdot::mechanical_system<1>(Ball{p[0], p[4]}), State<1>{0.0, {p[2]}, {p[3]}}, qdot::events(floor, low));
  }
};
const auto height = [](const auto& q) { return q[0]; };

// Springs side by side on a unit of mass, p₁ … p₁₁, all energies times p₀.
template <class P>
struct Springs {
  P p;
  auto T(const auto& v) const { return 0.5 * p[0] * v[0] * v[0]; }
  auto V(const auto& q) const {
    auto sum = p[1];
    for (int k = 2; k < 12; ++k) sum = sum + p[k];
    return 0.5 * p[0] * sum * q[0] * q[0];
  }
};
struct SpringsOf {
  auto operator()(const auto& p) const { return Springs<std::remove_cvref_t<decltype(p)>>{p}; }
};

}  // namespace

TEST_CASE("the gradient of a number at the end of a double pendulum's motion is that of its sensitivities") {
  constexpr double error = 1e-10;
  const Five p{{1.0, 0.7, 1.1, 0.9, 9.81}};
  const State<2> start{0.0, {1.7, 1.2}, {0.3, -0.2}};
  const auto forwards = sensitivities(systems::DoublePendulumFamily{}, p, start, 3.0, Dop853{}, fine);
  const auto backwards = adjoint_sensitivities(
      systems::DoublePendulumFamily{}, p, start, 3.0,
      qdot::end_value([](const auto& q, const auto& v) { return q[0] * q[0] + 0.3 * q[1] - v[0] * v[1]; }), Dop853{}, fine);
  REQUIRE(backwards.completed());
  const Eigen::Vector4d y = forwards.y, slope(2 * y[0], 0.3, -y[3], -y[2]);
  CHECK_THAT(backwards.value, WithinAbs(y[0] * y[0] + 0.3 * y[1] - y[2] * y[3], 1e-11));
  CHECK((backwards.by_parameters - forwards.d_parameters().transpose() * slope).norm() < error);
  CHECK((backwards.by_start - forwards.d_start().transpose() * slope).norm() < error);
  CHECK_THAT(backwards.by_end, WithinAbs(forwards.ydot.dot(slope), error));
  CHECK_THAT(backwards.by_start_time, WithinAbs(-backwards.by_end, error));  // nothing depends on t itself
}

TEST_CASE("the integral of what a rate changes has the gradient of the change") {
  constexpr double error = 1e-10;
  const Five p{{1.0, 0.7, 1.1, 0.9, 9.81}};
  const State<2> start{0.0, {1.7, 1.2}, {0.3, -0.2}};
  const auto at_end = adjoint_sensitivities(systems::DoublePendulumFamily{}, p, start, 3.0,
                                            qdot::end_value([](const auto& q) { return q[0] * q[1]; }), Dop853{}, fine);
  const auto on_the_way =
      adjoint_sensitivities(systems::DoublePendulumFamily{}, p, start, 3.0,
                            qdot::integral([](const auto& q, const auto& v) { return v[0] * q[1] + q[0] * v[1]; }), Dop853{}, fine);
  CHECK_THAT(on_the_way.value, WithinAbs(at_end.value - 1.7 * 1.2, error));
  CHECK((on_the_way.by_parameters - at_end.by_parameters).norm() < error);
  CHECK((on_the_way.by_start + Eigen::Vector4d(1.2, 1.7, 0, 0) - at_end.by_start).norm() < error);
  CHECK_THAT(on_the_way.by_end, WithinAbs(at_end.by_end, error));
}

// x = 5 + cos ωt: ∫ (x − 5)² dt = T/2 + sin 2ωT/4ω, and dk = 2ω dω.
TEST_CASE("an oscillator's mean square depends on its stiffness as the closed form says") {
  constexpr double omega = 1.3, T = 7.0, error = 1e-11;
  const auto found = adjoint_sensitivities(BallOf{}, Five{{0.0, 0.5, 6.0, 0.0, omega * omega}}, T,
                                           qdot::integral([](const auto& q) { return (q[0] - 5.0) * (q[0] - 5.0); }), Dop853{}, fine);
  REQUIRE(found.completed());
  CHECK_THAT(found.value, WithinAbs(T / 2 + std::sin(2 * omega * T) / (4 * omega), error));
  CHECK_THAT(found.by_parameters[4],
             WithinAbs((T * std::cos(2 * omega * T) / (2 * omega) - std::sin(2 * omega * T) / (4 * omega * omega)) / (2 * omega), error));
  CHECK_THAT(found.by_parameters[2], WithinAbs(2 * found.value, error));  // of the square of the amplitude 1
  CHECK((found.by_parameters.segment(2, 2) - found.by_start).norm() < error);
  CHECK_THAT(found.by_end, WithinAbs(std::pow(std::cos(omega * T), 2), error));
}

// As above; nothing depends on p₀, whose slope is what rounding leaves.
TEST_CASE("of many parameters the gradient is the closed form's as well, and that of one that cancels is zero") {
  constexpr double omega = 1.3, T = 7.0, error = 1e-11;
  using Twelve = qdot::Vector<double, 12>;
  Twelve p = Twelve::Constant(omega * omega / 11);
  p[0] = 1.7;
  const auto found = adjoint_sensitivities(SpringsOf{}, p, State<1>{0.0, {1.0}, {0.0}}, T,
                                           qdot::integral([](const auto& q) { return q[0] * q[0]; }), Dop853{}, fine);
  INFO(found.message);
  REQUIRE(found.completed());
  const double by_k = (T * std::cos(2 * omega * T) / (2 * omega) - std::sin(2 * omega * T) / (4 * omega * omega)) / (2 * omega);
  CHECK_THAT(found.by_parameters[0], WithinAbs(0.0, 1e-14));
  for (int k = 1; k < 12; ++k) CHECK_THAT(found.by_parameters[k], WithinAbs(by_k, error));
}

TEST_CASE("at rest, where a run takes steps as long as it likes, what the adjoint does is followed all the same") {
  constexpr double omega = 3.0, T = 50.0, error = 1e-9;  // fifty seconds of some 1e-11 each
  const auto found = adjoint_sensitivities(BallOf{}, Five{{0.0, 0.5, 5.0, 0.0, omega * omega}}, T, qdot::end_value(height), Dop853{}, {.rtol = 1e-11});
  REQUIRE(found.completed());
  CHECK_THAT(found.by_start[0], WithinAbs(std::cos(omega * T), error));
  CHECK_THAT(found.by_start[1], WithinAbs(std::sin(omega * T) / omega, error));
}

// Eighteen digits of the closed form.
TEST_CASE("a ball's height after three bounces depends on g, e and where it began as the closed form says, backwards") {
  constexpr double error = 1e-10;
  const auto found = adjoint_sensitivities(BallOf{}, Five{{9.8, 0.8, 50.0, 0.0, 0.0}}, 15.0, qdot::end_value(height), Dop853{}, fine);
  REQUIRE(found.completed());
  CHECK(found.run.events.size() == 3);
  CHECK_THAT(found.value, WithinAbs(8.494217007606032792, error));
  CHECK_THAT(found.by_parameters[0], WithinAbs(-7.277029744509896286, error));
  CHECK_THAT(found.by_parameters[1], WithinAbs(314.568839957685554, 100 * error));
  CHECK_THAT(found.by_parameters[2], WithinAbs(1.596182170076060328, error));
  CHECK_THAT(found.by_end, WithinAbs(-9.508652199492931147, error));
  // ∫ ẋ dt is the same but for the start, though ẋ jumps at each bounce.
  const auto way = adjoint_sensitivities(BallOf{}, Five{{9.8, 0.8, 50.0, 0.0, 0.0}}, 15.0,
                                         qdot::integral([](const auto&, const auto& v) { return v[0]; }), Dop853{}, fine);
  CHECK_THAT(way.value, WithinAbs(found.value - 50, error));
  CHECK_THAT(way.by_parameters[1], WithinAbs(found.by_parameters[1], 100 * error));
  CHECK_THAT(way.by_parameters[2], WithinAbs(found.by_parameters[2] - 1, error));
}

// From the height h to 1: T = √(2(h − 1)/g), and v²/2 = g (h − 1).
TEST_CASE("where an event stops the run its time moves, and the gradient with it") {
  constexpr double g = 9.81, h = 4.0, error = 1e-11;
  const double T = std::sqrt(2 * (h - 1) / g);
  const Five p{{g, 0.5, h, 0.0, 0.0}};
  const auto time = adjoint_sensitivities(BallOf{1.0}, p, 10.0, qdot::integral([](const auto& q) { return 1.0 + 0.0 * q[0]; }), Dop853{}, fine);
  REQUIRE(time.outcome == Outcome::stopped_by_event);
  CHECK_THAT(time.value, WithinAbs(T, error));
  CHECK_THAT(time.by_parameters[0], WithinAbs(-T / (2 * g), error));
  CHECK_THAT(time.by_parameters[2], WithinAbs(1 / (g * T), error));
  CHECK_THAT(time.by_parameters[3], WithinAbs(1 / g, error));
  const auto kinetic = adjoint_sensitivities(BallOf{1.0}, p, 10.0,
                                             qdot::end_value([](const auto&, const auto& v) { return 0.5 * v[0] * v[0]; }), Dop853{}, fine);
  CHECK_THAT(kinetic.by_parameters[0], WithinAbs(h - 1, 10 * error));
  CHECK_THAT(kinetic.by_parameters[2], WithinAbs(g, 10 * error));
}

TEST_CASE("what a functional asks of parameters and of the time itself is in its gradient") {
  constexpr double g = 9.81, h = 20.0, T = 1.5, error = 1e-10;  // q = h − g t²/2
  const auto mixed = [](const auto& q, const auto&, const auto& p, const auto& t) { return p[0] * q[0] * t; };
  const auto found = adjoint_sensitivities(BallOf{}, Five{{g, 0.5, h, 0.0, 0.0}}, T, qdot::functional(mixed, mixed), Dop853{}, fine);
  // ∫ g q t dt = g h T²/2 − g² T⁴/8, and g q T = g h T − g² T³/2
  CHECK_THAT(found.value, WithinAbs(g * h * T * T / 2 - g * g * T * T * T * T / 8 + g * h * T - g * g * T * T * T / 2, error));
  CHECK_THAT(found.by_parameters[0], WithinAbs(h * T * T / 2 - g * T * T * T * T / 4 + h * T - g * T * T * T, error));
  CHECK_THAT(found.by_parameters[2], WithinAbs(g * T * T / 2 + g * T, error));
  CHECK_THAT(found.by_end, WithinAbs(g * h * T - g * g * T * T * T / 2 + g * h - 3 * g * g * T * T / 2, error));
}

TEST_CASE("where there is no gradient, none is made up") {
  double touched = 0.0;
  const auto counted = adjoint_sensitivities(BallOf{-1.0, &touched}, Five{{9.8, 0.8, 5.0, 0.0, 0.0}}, 2.0, qdot::end_value(height), Dop853{}, fine);
  CHECK(counted.completed());  // what an action notes besides the state is its own affair
  // A throw that only just reaches the level where it would end.
  const auto grazing = adjoint_sensitivities(BallOf{4.905 - 1e-13}, Five{{9.81, 0.5, 0.0, 9.81, 0.0}}, 2.0, qdot::end_value(height), Dop853{}, fine);
  INFO(grazing.message);
  CHECK(grazing.outcome == Outcome::not_differentiable);
  CHECK(grazing.message.find("'level' only grazes zero") != std::string::npos);
  CHECK(grazing.by_parameters.size() == 0);
}
