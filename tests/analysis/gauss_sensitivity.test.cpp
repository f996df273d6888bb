// SPDX-License-Identifier: MIT
#include "qdot/analysis/gauss_sensitivity.hpp"

#include <cmath>

#include "catch2_bridge.hpp"
#include "qdot/effects/dissipation.hpp"
#include "scenes/double_pendulum.hpp"

using qdot::Gauss;
using qdot::sensitivities;
using qdot::State;

namespace {

// An oscillator of mass m and stiffness k, pulled by g.
template <class S>
struct Oscillator {
  S m, k, g;
  auto T(const auto& v) const { return 0.5 * m * v[0] * v[0]; }
  auto V(const auto& q) const { return 0.5 * k * q[0] * q[0] + m * g * q[0]; }
};
const auto oscillator = [](const auto& p) { return Oscillator<std::remove_cvref_t<decltype(p[0])>>{p[0], p[1], p[2]}; };

// ∂(q, p)/∂(q, q̇) of the double pendulum.
Eigen::Matrix4d to_momenta(const State<2>& at) {
  using D = qdot::Dual<double, 4>;
  qdot::Vector<D, 2> q, v;
  for (int i = 0; i < 2; ++i) {
    q[i] = D::variable(at.q[i], i);
    v[i] = D::variable(at.qdot[i], 2 + i);
  }
  const auto p = qdot::gradient([&](const auto& w) {
    using S = typename std::remove_cvref_t<decltype(w)>::Scalar;
    return qdot::scenes::DoublePendulum{}.T(qdot::Vector<S, 2>(q.template cast<S>()), w);
  }, v);
  Eigen::Matrix4d J = Eigen::Matrix4d::Identity();
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 4; ++j) J(2 + i, j) = p[i].tangent[static_cast<std::size_t>(j)];
  return J;
}

}  // namespace

TEST_CASE("the tangent of the implicit midpoint rule is Cayley's transform of the oscillator's equations") {
  constexpr double error = 1e-13;  // roundings of ten steps
  const Eigen::Vector3d p(2.0, 3.0, 0.7);
  const auto s = sensitivities(oscillator, p, State<1>{0.0, {0.4}, {-0.3}}, 2.0, Gauss{.step = 0.2, .stages = 1});
  REQUIRE(s.completed());
  Eigen::Matrix2d A;
  A << 0.0, 1.0, -p[1] / p[0], 0.0;
  const Eigen::Matrix2d one = Eigen::Matrix2d::Identity(), step = (one - 0.1 * A).inverse() * (one + 0.1 * A);
  Eigen::Matrix2d whole = one;
  for (int k = 0; k < 10; ++k) whole = step * whole;
  CHECK((s.d_start() - whole).cwiseAbs().maxCoeff() < error);
}

TEST_CASE("the tangent of Gauss steps is the derivative of the numbers that they give") {
  constexpr double error = 1e-9;  // what differences of order six leave of numbers of size four
  const auto system = qdot::mechanical_system<2>(qdot::scenes::DoublePendulum{});
  const Gauss method{.step = 0.05, .stages = 2};  // far from converged: Φ of the motion itself is 1e-4 away
  const State<2> start{0.0, {1.7, 1.7}, {0, 0}};
  const auto s = sensitivities(system, start, 3.0, method);
  REQUIRE(s.completed());
  Eigen::Matrix4d differences;
  for (int j = 0; j < 4; ++j) {
    const auto end = [&](double by) {
      State<2> near = start;
      (j < 2 ? near.q[j] : near.qdot[j - 2]) += by;
      const auto run = qdot::simulate(system, near, 3.0, method);
      return Eigen::Vector4d(run.y);
    };
    const double h = 4e-3;
    differences.col(j) = (45 * (end(h) - end(-h)) - 9 * (end(2 * h) - end(-2 * h)) + (end(3 * h) - end(-3 * h))) / (60 * h);
  }
  CHECK((s.Phi - differences).cwiseAbs().maxCoeff() < error);
  CHECK((s.y - qdot::simulate(system, start, 3.0, method).y).norm() < 1e-12);  // the same sums in another order
}

TEST_CASE("the tangent of Gauss steps is symplectic in (q, p) to rounding, however rough they are") {
  constexpr double error = 1e-14;  // fifty rounding units of the products, after ten thousand steps
  const auto system = qdot::mechanical_system<2>(qdot::scenes::DoublePendulum{});
  const State<2> start{0.0, {0.3, -0.2}, {0.1, 0.2}};
  const auto s = sensitivities(system, start, 1000.0, Gauss{.step = 0.1, .stages = 2}, {.keep_trajectory = false});
  REQUIRE(s.completed());
  const Eigen::Matrix4d Phi = to_momenta(s.state()) * s.Phi * to_momenta(start).inverse();
  Eigen::Matrix4d J = Eigen::Matrix4d::Zero();
  J.topRightCorner<2, 2>().setIdentity();
  J.bottomLeftCorner<2, 2>() = -Eigen::Matrix2d::Identity();
  const double largest = Phi.cwiseAbs().maxCoeff();
  CHECK(largest > 100.0);
  CHECK((Phi.transpose() * J * Phi - J).cwiseAbs().maxCoeff() < error * largest * largest);
}

TEST_CASE("by Gauss steps an oscillator depends on its mass, stiffness and pull as the closed form says") {
  constexpr double error = 1e-11;  // of order 12 at a fiftieth of a turn, and rounding of a hundred steps
  const Eigen::Vector3d p(2.0, 3.0, 0.7);
  const double t = 2.0, w = std::sqrt(p[1] / p[0]), c = std::cos(w * t), d = std::sin(w * t), x0 = 0.4, v0 = -0.3, sag = p[0] * p[2] / p[1];
  const auto s = sensitivities(oscillator, p, State<1>{0.0, {x0}, {v0}}, t, Gauss{.step = 0.02, .stages = 6});
  REQUIRE(s.completed());
  // x = (x₀ + sag) cos wt + v₀/w sin wt − sag
  const double by_w = -(x0 + sag) * t * d - v0 / (w * w) * d + v0 / w * t * c, by_sag = c - 1.0;
  CHECK_THAT(s.Phi(0, 1), WithinAbs(d / w, error));
  CHECK_THAT(s.Phi(0, 2), WithinAbs(by_w * -w / (2 * p[0]) + by_sag * sag / p[0], error));
  CHECK_THAT(s.Phi(0, 3), WithinAbs(by_w * w / (2 * p[1]) - by_sag * sag / p[1], error));
  CHECK_THAT(s.Phi(0, 4), WithinAbs(by_sag * p[0] / p[1], error));
  // Between steps, within what the polynomial leaves.
  CHECK_THAT(s.Phi_at(1.011)(0, 0), WithinAbs(std::cos(w * 1.011), 1e-10));
}

TEST_CASE("by Gauss steps a ball that bounces is as its closed form, through the event") {
  constexpr double error = 1e-10;
  const auto falling = [](const auto& p) { return Oscillator<std::remove_cvref_t<decltype(p[0])>>{1.0, 0.0, p[0]}; };
  const double g = 9.81, h0 = 1.0, e = 0.8, fall = std::sqrt(2 * h0 / g), t = 0.7;
  const auto bounce = [](State<1>& at) { at.qdot[0] *= -0.8; };
  const auto s = sensitivities(falling, qdot::Vector<double, 1>(g), State<1>{0.0, {h0}, {0.0}}, t, Gauss{.step = 0.01, .stages = 2}, {},
                               qdot::events(qdot::event("floor", [](const auto& q) { return q[0]; }).falling().action(bounce)));
  REQUIRE(s.completed());
  REQUIRE(s.events.size() == 1);
  // After the bounce h = e g t_f (t − t_f) − g (t − t_f)²/2 with t_f = √(2 h₀/g).
  const double after = t - fall, by_fall = e * g * (t - 2 * fall) + g * after;
  CHECK_THAT(s.Phi(0, 0), WithinAbs(by_fall * fall / (2 * h0), error));
  CHECK_THAT(s.Phi(0, 2), WithinAbs(by_fall * -fall / (2 * g) + e * fall * after - after * after / 2, error));
  CHECK_THAT(s.events[0].time[0], WithinAbs(fall / (2 * h0), error));
}

TEST_CASE("errors that Gauss steps do not control cannot be left out of the control") {
  const auto system = qdot::mechanical_system<2>(qdot::scenes::DoublePendulum{});
  CHECK_THROWS_WITH(sensitivities(system, State<2>{0.0, {1.7, 1.7}, {0, 0}}, 3.0, Gauss{}, {}, {}, {.controlled = false}),
                    "derivatives are left out of the control of errors by Dop853 and Dopri5 only; leave `controlled` as it is, or take one of them");
}

TEST_CASE("by Gauss steps a damped pendulum's tangent is that of other methods") {
  constexpr double error = 1e-10;  // of order 8 at steps of 0.02
  const auto damped = qdot::scene(qdot::mechanical_system<2>(qdot::scenes::DoublePendulum{}), qdot::viscous_damping(Eigen::Vector2d(0.1, 0.3)));
  const State<2> start{0.0, {1.7, 1.7}, {0, 0}};
  const auto s = sensitivities(damped, start, 1.0, Gauss{.step = 0.02, .stages = 4});
  const auto reference = sensitivities(damped, start, 1.0, qdot::Dop853{}, {.rtol = 1e-13, .atol = 1e-14});
  REQUIRE(s.completed());
  CHECK((s.Phi - reference.Phi).cwiseAbs().maxCoeff() < error);
}
