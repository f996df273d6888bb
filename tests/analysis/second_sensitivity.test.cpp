// SPDX-License-Identifier: MIT
#include "qdot/analysis/second_sensitivity.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>

#include "catch2_bridge.hpp"
#include "qdot/effects/dissipation.hpp"
#include "systems/double_pendulum_of_parameters.hpp"

using qdot::second_sensitivities;
using qdot::sensitivities;
using qdot::State;
using qdot::Taylor;

namespace {

const qdot::Options fine{.rtol = 1e-14, .atol = 1e-15};

// A mass m on a spring k, pulled by m g, and a pendulum besides: V = ½ k q² + m g q − pull cos q.
template <class S>
struct Oscillator {
  S m, k, g;
  double pull = 0.0;
  auto T(const auto& v) const { return 0.5 * m * v[0] * v[0]; }
  auto V(const auto& q) const {
    using std::cos;
    return 0.5 * k * q[0] * q[0] + m * g * q[0] - pull * cos(q[0]);
  }
};
struct OscillatorOf {
  double pull = 0.0;
  auto operator()(const auto& p) const { return Oscillator<std::remove_cvref_t<decltype(p[0])>>{p[0], p[1], p[2], pull}; }
};
const auto pendulum = qdot::mechanical_system<1>(OscillatorOf{1.0}(Eigen::Vector3d(1.0, 0.0, 0.0)));

// The family of double pendulums, with its parameters in either order.
using FiveNumbers = qdot::Vector<double, 5>;
struct DoublePendulums {
  bool backwards = false;
  auto operator()(const auto& p) const {
    return backwards ? systems::DoublePendulumOf<std::remove_cvref_t<decltype(p[0])>>{p[4], p[3], p[2], p[1], p[0]} : systems::DoublePendulumFamily{}(p);
  }
};
FiveNumbers masses_lengths_g() {
  FiveNumbers p;
  p << 1.0, 0.7, 1.2, 0.9, 9.81;
  return p;
}
const State<2> released{0.0, {1.1, -0.6}, {0.3, 0.8}};

}  // namespace

// x = (x₀ + s) cos wt + v₀/w sin wt − s with w² = k/m, s = mg/k
TEST_CASE("an oscillator's second derivatives by mass, stiffness, pull and start are those of the closed form") {
  constexpr double error = 1e-12;  // some rounding units of numbers below ten
  const double m = 2.0, k = 3.0, g = 0.7, t = 2.0, x0 = 0.4, v0 = -0.3;
  const double w = std::sqrt(k / m), s = m * g / k, c = std::cos(w * t), d = std::sin(w * t);
  const auto found = second_sensitivities(OscillatorOf{}, Eigen::Vector3d(m, k, g), State<1>{0.0, {x0}, {v0}}, t, Taylor{}, fine);
  INFO(found.message);
  REQUIRE(found.completed());
  REQUIRE(found.second.size() == 2);
  const double by_w = -(x0 + s) * t * d - v0 / (w * w) * d + v0 / w * t * c, by_s = c - 1.0, by_ws = -t * d;
  const double by_ww = -(x0 + s) * t * t * c + 2 * v0 / (w * w * w) * d - 2 * v0 / (w * w) * t * c - v0 / w * t * t * d;
  Eigen::Vector3d w_p(-w / (2 * m), w / (2 * k), 0.0), s_p(g / k, -s / k, m / k);
  Eigen::Matrix3d w_pp = Eigen::Matrix3d::Zero(), s_pp = Eigen::Matrix3d::Zero();
  w_pp.topLeftCorner<2, 2>() << 3 * w / (4 * m * m), -w / (4 * m * k), -w / (4 * m * k), -w / (4 * k * k);
  s_pp << 0.0, -g / (k * k), 1.0 / k, -g / (k * k), 2 * s / (k * k), -m / (k * k), 1.0 / k, -m / (k * k), 0.0;
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(5, 5);
  expected.bottomRightCorner<3, 3>() =
      by_ww * w_p * w_p.transpose() + by_ws * (w_p * s_p.transpose() + s_p * w_p.transpose()) + by_w * w_pp + by_s * s_pp;
  expected.block<1, 3>(0, 2) = -t * d * w_p.transpose();
  expected.block<1, 3>(1, 2) = (t * c / w - d / (w * w)) * w_p.transpose();
  expected.bottomLeftCorner<3, 2>() = expected.topRightCorner<2, 3>().transpose();
  CHECK((found.second[0] - expected).cwiseAbs().maxCoeff() < error);
  CHECK(found.second_at(0.0)[0].isZero(0.0));
}

// v̇ = −F tanh(v/v₀) has sinh(v/v₀) = sinh(u/v₀) exp(−Ft/v₀).
TEST_CASE("what a smooth friction slows down depends on its first speed to second order as the closed form says") {
  constexpr double error = 1e-13;  // some rounding units
  const double F = 0.5, unit = 0.8, u = 1.3, t = 1.5, E = std::exp(-F * t / unit), w = std::asinh(std::sinh(u / unit) * E);
  const auto block = qdot::scene(qdot::mechanical_system<1>(OscillatorOf{}(Eigen::Vector3d(1.0, 0.0, 0.0))), qdot::regularized_friction(0, F, unit));
  const auto found = second_sensitivities(block, State<1>{0.0, {0.2}, {u}}, t, Taylor{}, fine);
  REQUIRE(found.completed());
  const double by_u = E * std::cosh(u / unit) / std::cosh(w);
  CHECK_THAT(found.Phi(1, 1), WithinAbs(by_u, error));
  CHECK_THAT(found.second[1](1, 1), WithinAbs((E * std::sinh(u / unit) / std::cosh(w) - by_u * by_u * std::tanh(w)) / unit, error));
  CHECK(found.second[0].row(0).isZero(error));  // where it begins is added, no more
}

// Released at rest from A it is back at the time T(A): q(T(A); A) = A and q̇(T(A); A) = 0, differentiated twice. T = 4 K(sin²(A/2)) in 40 digits.
TEST_CASE("after a period a pendulum's second derivatives are those of the elliptic integral") {
  constexpr double error = 1e-11;  // of numbers below ten, over a period
  const double A = 1.3, T = 7.019250311844546549770542, by_A = 1.258165472401305335480641, by_AA = 1.405526156884728059839247;
  const auto found = second_sensitivities(pendulum, State<1>{0.0, {A}, {0.0}}, T, Taylor{}, fine);
  REQUIRE(found.completed());
  CHECK_THAT(found.second[0](0, 0), WithinAbs(-std::sin(A) * by_A * by_A, error));
  CHECK_THAT(found.second[1](0, 0), WithinAbs(std::sin(A) * by_AA + 2 * std::cos(A) * by_A, error));
}

TEST_CASE("a double pendulum's second derivatives are the differences of its first, and the same in any order of the parameters") {
  constexpr double error = 2e-9;      // of formula of order six at this step, and roundings of Φ by it
  constexpr double rounding = 1e-11;  // of numbers up to some tens
  constexpr double step = 3e-3;
  const double t_end = 1.0;
  const FiveNumbers p = masses_lengths_g();
  const auto found = second_sensitivities(DoublePendulums{}, p, released, t_end, Taylor{}, fine);
  INFO(found.message);
  REQUIRE(found.completed());
  REQUIRE(found.Phi.cols() == 9);
  const std::array<double, 3> weight{3.0 / 4, -3.0 / 20, 1.0 / 60};
  for (const Eigen::Index a : {1, 2, 5, 6}) {  // an angle, a speed, a mass, a length
    Eigen::MatrixXd slope = Eigen::MatrixXd::Zero(4, 9);
    for (int j = 1; j <= 3; ++j)
      for (const int sign : {-1, 1}) {
        FiveNumbers near = p;
        State<2> start = released;
        (a < 2 ? start.q[a] : a < 4 ? start.qdot[a - 2] : near[a - 4]) += sign * j * step;
        slope += sign * weight[static_cast<std::size_t>(j - 1)] / step * sensitivities(DoublePendulums{}, near, start, t_end, Taylor{}, fine).Phi;
      }
    for (Eigen::Index i = 0; i < 4; ++i) CHECK((slope.row(i) - found.second[static_cast<std::size_t>(i)].row(a)).cwiseAbs().maxCoeff() < error);
  }
  const auto again = second_sensitivities(DoublePendulums{true}, FiveNumbers(p.reverse()), released, t_end, Taylor{}, fine);
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::MatrixXd parameters = found.second[i].bottomRightCorner(5, 5), others = again.second[i].bottomRightCorner(5, 5).reverse();
    CHECK((parameters - others).cwiseAbs().maxCoeff() < rounding);
  }
}

// y(t; y(s)) = y(t + s) for all y: Φ f(y₀) = f(y(t)), and its derivative by y₀.
TEST_CASE("along the motion itself second derivatives are those of the equations") {
  constexpr double rounding = 1e-11;  // of numbers up to some tens
  const auto system = qdot::mechanical_system<2>(DoublePendulums{}(masses_lengths_g()));
  const auto form = qdot::first_order_form(system);
  const auto found = second_sensitivities(system, released, 2.0, Taylor{}, fine);
  REQUIRE(found.completed());
  Eigen::Vector4d before, f;
  Eigen::Matrix4d A, A_end;
  before << released.q, released.qdot;
  form.derivative(0.0, before, f);
  form.jacobian(0.0, before, A);
  form.jacobian(2.0, found.y, A_end);
  const Eigen::MatrixXd expected = A_end * found.Phi - found.Phi * A;
  for (Eigen::Index i = 0; i < 4; ++i) CHECK((found.second[static_cast<std::size_t>(i)] * f - expected.row(i).transpose()).cwiseAbs().maxCoeff() < rounding);
}

TEST_CASE("an event that stops a run stops its second derivatives, which are those of that time") {
  constexpr double error = 1e-12;
  const auto lowest = qdot::events(qdot::event("lowest", [](const auto& q) { return q[0]; }).stop());
  const auto stopped = second_sensitivities(pendulum, State<1>{0.0, {1.3}, {0.0}}, 9.0, Taylor{}, fine, lowest);
  REQUIRE(stopped.outcome == qdot::Outcome::stopped_by_event);
  REQUIRE(stopped.events.size() == 1);
  const auto run = second_sensitivities(pendulum, State<1>{0.0, {1.3}, {0.0}}, stopped.t, Taylor{}, fine);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK((stopped.second[i] - run.second[i]).cwiseAbs().maxCoeff() < error);
    CHECK((stopped.second[i] - stopped.second_at(stopped.t)[i]).cwiseAbs().maxCoeff() < error);
  }
}

// z₂ = v₂ (t − t₂) − ½ g (t − t₂)² behind the second bounce, v₁ = e √(v₀² + 2 g z₀), t₂ = t₁ + 2 v₁/g, v₂ = e v₁.
TEST_CASE("a ball's second derivatives by its start and gravity behind two bounces are those of the closed form") {
  constexpr double error = 1e-9;  // of second differences of numbers up to a hundred
  const double e = 0.8, t = 1.4;
  const auto falling = [](const auto& p) { return Oscillator<std::remove_cvref_t<decltype(p[0])>>{1.0, 0.0, p[0]}; };
  const auto bounce = [](State<1>& at) { at.qdot[0] *= -0.8; };
  const auto floor = qdot::events(qdot::event("floor", [](const auto& q) { return q[0]; }).falling().action(bounce));
  const Eigen::Vector3d x(1.0, 0.7, 9.81);  // z₀, v₀, g
  const auto found = second_sensitivities(falling, qdot::Vector<double, 1>(x[2]), State<1>{0.0, {x[0]}, {x[1]}}, t, Taylor{}, fine, floor);
  INFO(found.message);
  REQUIRE(found.completed());
  REQUIRE(found.events.size() == 2);
  const auto speed = [=](const auto& of) {
    using std::sqrt;
    const auto fall = sqrt(of[1] * of[1] + 2.0 * of[2] * of[0]), v1 = e * fall, t2 = (of[1] + fall) / of[2] + 2.0 * v1 / of[2];
    return e * v1 - of[2] * (t - t2);
  };
  const auto place = [=](const auto& of) {
    using std::sqrt;
    const auto fall = sqrt(of[1] * of[1] + 2.0 * of[2] * of[0]), v1 = e * fall, late = t - (of[1] + fall) / of[2] - 2.0 * v1 / of[2];
    return e * v1 * late - 0.5 * of[2] * late * late;
  };
  CHECK((found.second[0] - qdot::hessian(place, x)).cwiseAbs().maxCoeff() < error);
  CHECK((found.second[1] - qdot::hessian(speed, x)).cwiseAbs().maxCoeff() < error);
}

TEST_CASE("through a jump that bends the state second derivatives are those of the equations along the motion, and of differences by parameters") {
  constexpr double error = 2e-9;  // of second differences of numbers up to some tens
  const FiveNumbers p = masses_lengths_g();
  const auto kick = [](State<2>& at) {
    at.qdot[0] = -0.6 * at.qdot[0] + 0.3 * at.q[1] * at.q[1];
    at.qdot[1] += 0.2 * at.qdot[0] * at.qdot[0];
    at.q[1] += 0.1 * std::sin(at.q[1] + at.qdot[1]);
  };
  const auto meets = qdot::events(qdot::event("meets", [](const auto& q) { return q[0] - 0.5 * q[1] * q[1] - 0.3; }).falling().action(kick));
  const auto found = second_sensitivities(DoublePendulums{}, p, released, 1.0, Taylor{}, fine, meets);
  INFO(found.message);
  REQUIRE(found.completed());
  REQUIRE(found.events.size() == 1);

  const auto form = qdot::first_order_form(qdot::mechanical_system<2>(DoublePendulums{}(p)));
  Eigen::Vector4d before, f;
  Eigen::Matrix4d A, A_end;
  before << released.q, released.qdot;
  form.derivative(0.0, before, f);
  form.jacobian(0.0, before, A);
  form.jacobian(1.0, found.y, A_end);
  const Eigen::Matrix4d expected = A_end * found.d_start() - found.d_start() * A;
  for (Eigen::Index i = 0; i < 4; ++i)
    CHECK((found.second[static_cast<std::size_t>(i)].topLeftCorner<4, 4>() * f - expected.row(i).transpose()).cwiseAbs().maxCoeff() <
          error);

  constexpr double step = 3e-3, differenced = 1e-7;  // a formula of order six at this step
  for (Eigen::Index j = 0; j < 5; ++j) {
    const auto Phi = [&](double by) {
      FiveNumbers near = p;
      near[j] += by * step;
      return Eigen::MatrixXd(sensitivities(DoublePendulums{}, near, released, 1.0, Taylor{}, fine, meets).Phi);
    };
    const Eigen::MatrixXd slope = (45 * (Phi(1) - Phi(-1)) - 9 * (Phi(2) - Phi(-2)) + Phi(3) - Phi(-3)) / (60 * step);
    for (Eigen::Index i = 0; i < 4; ++i)
      CHECK((found.second[static_cast<std::size_t>(i)].col(4 + j).transpose() - slope.row(i)).cwiseAbs().maxCoeff() < differenced);
  }
}

TEST_CASE("an action without a second derivative ends the run of second derivatives, and not that of the first") {
  const auto free = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; });
  const auto kick = [](State<1>& at) { at.qdot[0] += at.q[0] * std::abs(at.q[0]); };
  const auto push = qdot::events(qdot::event("push", [](const auto&, const auto&, const auto& t) { return t - 0.5; }).action(kick));
  const State<1> start{0.0, {-0.5}, {1.0}};  // is at 0 when it is pushed
  CHECK(sensitivities(free, start, 1.0, Taylor{}, fine, push).completed());
  const auto found = second_sensitivities(free, start, 1.0, Taylor{}, fine, push);
  CHECK(found.outcome == qdot::Outcome::not_differentiable);
  CHECK(found.message.find(
            "'push' changes the state in a way that has no second derivative with respect to q0 at the start and q0 at the start") !=
        std::string::npos);
}

TEST_CASE("what is wrong with a question about second derivatives is said before the first step") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto message = [](const auto& ask) -> std::string {
    try {
      ask();
    } catch (const qdot::Error& error) {
      return error.what();
    }
    return "";
  };
  const auto none = qdot::EventList<>{};
  const State<1> start{0.0, {1.0}, {0.0}};
  CHECK(message([&] {
          second_sensitivities(pendulum, State<1>{0.0, {nan}, {0.0}}, 1.0, Taylor{});
        }) == "q0 must be finite at the start, but is nan; give it a number");
  CHECK(message([&] { second_sensitivities(OscillatorOf{}, Eigen::Vector3d(1.0, nan, 0.0), start, 1.0, Taylor{}); }) ==
        "parameter 1 must be finite, but is nan; give it a number");
  CHECK(message([&] {
          second_sensitivities(pendulum, start, 1.0, Taylor{}, {}, none, {.start = false});
        }).find("must be with respect to something") != std::string::npos);
  CHECK(message([&] { second_sensitivities(pendulum, start, 1.0, Taylor{}, {}, none, {.start_time = true}); }) ==
        "second derivatives are by the start and by parameters, but the time of the start is asked for; leave start_time out");
  CHECK(message([&] { second_sensitivities(pendulum, start, 1.0, Taylor{}, {.atol = {1e-9, 1e-9, 1e-9}}); }).find("atol") != std::string::npos);
}

TEST_CASE("a second derivative that leaves its bounds ends the run under its own name") {
  qdot::Options bounded = fine;
  bounded.state_norm_limit = 20.0;  // y, y′ and Φ stay below ten
  const auto found = second_sensitivities(pendulum, State<1>{0.0, {2.8}, {0.0}}, 30.0, Taylor{}, bounded);
  INFO(found.message);
  CHECK(found.outcome == qdot::Outcome::state_limit);
  CHECK(found.message.find("the second derivative of q0 with respect to q0 at the start and q0 at the start") != std::string::npos);
  CHECK(found.t < 30.0);
  CHECK(found.second[1].allFinite());
}
