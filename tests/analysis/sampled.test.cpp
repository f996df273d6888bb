// SPDX-License-Identifier: MIT
#include "qdot/analysis/sampled.hpp"

#include <cmath>
#include <random>
#include <string>

#include "catch2_bridge.hpp"
#include "error_message.hpp"
#include "qdot/effects/input.hpp"

using namespace qdot;
using Eigen::MatrixXd;

namespace {

// A series to rounding, some squarings, and a few solutions of linear equations.
constexpr double rounding = 1e-13, solved = 1e-11;

struct Mass {
  double stiffness = 0.0;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const { return 0.5 * stiffness * q[0] * q[0]; }
};
Linearization pushed(double stiffness, double qdot = 0.0) {
  return linearization(mechanical_system<1>(Mass{stiffness}), State<1>{0.0, {0.0}, {qdot}},
                       input("push", 0));
}
MatrixXd of(double x) { return MatrixXd::Constant(1, 1, x); }
MatrixXd E(Eigen::Index n) { return MatrixXd::Identity(n, n); }

}  // namespace

TEST_CASE("a mass that is pushed: A_d = (1 h; 0 1), B_d = (h^2/2; h), for any h, and its drift h v") {
  for (const double h : {1e-9, 0.1, 1.0, 3e4}) {
    const SampledLinearization s = sampled(pushed(0.0, 2.0), h);
    CHECK(s.A == (MatrixXd(2, 2) << 1, h, 0, 1).finished());
    CHECK_THAT(s.B(0, 0), WithinRel(0.5 * h * h, rounding));
    CHECK_THAT(s.B(1, 0), WithinRel(h, rounding));
    CHECK_THAT(s.drift[0], WithinRel(2.0 * h, rounding));
    CHECK(s.drift[1] == 0.0);
    CHECK(s.C == s.linear.C);
    CHECK(s.D == s.linear.D);
    CHECK(s.dt == h);
  }
}

TEST_CASE("an oscillator: cos and sin of omega h, and what a constant force does meanwhile") {
  for (const double k : {4.0, 1e6, -2.25})
    for (const double h : {1e-3, 0.3}) {
      const double w = std::sqrt(std::abs(k)), c = k > 0 ? std::cos(w * h) : std::cosh(w * h), s = k > 0 ? std::sin(w * h) : std::sinh(w * h);
      const SampledLinearization map = sampled(pushed(k), h);
      // A turn by omega h = 300 is known to 300 roundings.
      const double known = rounding * std::max(1.0, w * h) * std::max(1.0, std::abs(c));
      CHECK_THAT(map.A(0, 0), WithinAbs(c, known));
      CHECK_THAT(map.A(1, 1), WithinAbs(c, known));
      CHECK_THAT(map.A(0, 1), WithinAbs(s / w, known / w));
      CHECK_THAT(map.A(1, 0), WithinAbs((k > 0 ? -w : w) * s, known * w));
      CHECK_THAT(map.B(0, 0), WithinAbs((1.0 - c) / k, known / std::abs(k)));
      CHECK_THAT(map.B(1, 0), WithinAbs(s / w, known / w));
    }
}

TEST_CASE("two short ticks are one long one") {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Linearization linear;
  linear.A = MatrixXd(5, 5), linear.B = MatrixXd(5, 2), linear.drift = Eigen::VectorXd::Zero(5);
  for (MatrixXd* m : {&linear.A, &linear.B})
    for (Eigen::Index i = 0; i < m->size(); ++i) m->data()[i] = normal(random);
  const SampledLinearization once = sampled(linear, 0.8), half = sampled(linear, 0.4);
  CHECK((half.A * half.A - once.A).norm() < rounding * once.A.norm());
  CHECK((half.A * half.B + half.B - once.B).norm() < rounding * once.B.norm());
}

TEST_CASE("one state at ticks: P is the positive root of b^2 P^2 - (a^2 r + b^2 q - r) P - q r = 0, also where it grows unseen") {
  for (const double a : {0.0, 0.5, 1.0, -1.7, 30.0})
    for (const double q : {0.0, 1e-6, 1.0, 1e6}) {
      if (q == 0.0 && std::abs(a) == 1.0) continue;  // refused below
      const double b = 0.7, r = 0.4, middle = a * a * r + b * b * q - r, root = std::sqrt(middle * middle + 4 * b * b * q * r);
      const double P = middle > 0.0 ? (middle + root) / (2 * b * b) : 2 * q * r / (root - middle);
      const SampledLqr found = sampled_lqr(of(a), of(b), of(q), of(r));
      CHECK_THAT(found.P(0, 0), WithinAbs(P, solved * P));
      CHECK_THAT(found.K(0, 0), WithinAbs(a * b * P / (r + b * b * P), solved * (1.0 + std::abs(a))));
      CHECK_THAT(found.multipliers[0].real(), WithinAbs(a * r / (r + b * b * P), solved * (1.0 + std::abs(a))));
    }
}

TEST_CASE("the discrete equation of Riccati is solved, and the loop decays, whatever the map") {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  for (int n = 1; n <= 8; ++n) {
    MatrixXd A(n, n), B(n, 2), G(n, n);
    for (MatrixXd* m : {&A, &B, &G})
      for (Eigen::Index i = 0; i < m->size(); ++i) m->data()[i] = normal(random);
    if (n > 2) A.col(0).setZero();  // a map need not be one to one
    const MatrixXd Q = G.transpose() * G, R = (MatrixXd(2, 2) << 2, 1, 1, 3).finished();
    const SampledLqr r = sampled_lqr(A, B, Q, R);
    const MatrixXd loop = A - B * r.K, left = loop.transpose() * r.P * loop + r.K.transpose() * R * r.K + Q - r.P;
    CHECK(left.norm() < solved * r.P.norm());
    CHECK((R * r.K - B.transpose() * r.P * loop).norm() < solved * r.P.norm() * B.norm());  // the cost is stationary in K
    CHECK(r.multipliers.cwiseAbs().maxCoeff() < 1.0);
    CHECK(r.residual < solved);
  }
}

TEST_CASE("with short ticks the regulator is that of all times: K = (1, sqrt 3) of a mass") {
  const double h = 1e-4;
  const SampledLqr r = lqr(sampled(pushed(0.0), h), E(2) * h, E(1) * h);
  CHECK_THAT(r.K(0, 0), WithinAbs(1.0, 2 * h));  // first order in h
  CHECK_THAT(r.K(0, 1), WithinAbs(std::sqrt(3.0), 2 * h));
  CHECK_THAT(r.P(0, 0), WithinAbs(std::sqrt(3.0), 2 * h));
}

TEST_CASE("what cannot be sampled or held at ticks is refused with the reason") {
  const auto says = [](const std::string& message, const char* what) { return message.find(what) != std::string::npos; };
  CHECK(says(error_message([] { sampled(pushed(1.0), 0.0); }), "the time between ticks must be positive and finite, but is 0"));
  CHECK(says(error_message([] { sampled(pushed(-1.0), 1e4); }), "what grows between two ticks must stay finite"));
  Linearization shaken = pushed(1.0);
  shaken.autonomous = false;
  CHECK(says(error_message([&] { sampled(shaken, 0.1); }), "A must be the same at all times"));
  CHECK(says(error_message([] { lqr(sampled(pushed(1.0, 2.0), 0.1), E(2), E(1)); }), "must be an equilibrium or a steady motion"));
  CHECK(says(error_message([] { sampled_lqr(of(2.0), of(0.0), of(1.0), of(1.0)); }), "with the multiplier 2 + 0i is not, most of it in x0"));
  CHECK(says(error_message([] { sampled_lqr(of(1.0), of(1.0), of(0.0), of(1.0)); }), "at the unit circle; give its coordinate a cost in Q"));
  CHECK(says(error_message([] { sampled_lqr(of(1.0), of(1.0), of(1.0), of(0.0)); }), "R must be positive definite"));
  CHECK(says(error_message([] { sampled_lqr(of(1.0), of(1.0), of(-1.0), of(1.0)); }), "Q must not be negative"));
  // An oscillator at ticks of half its period: the push moves it to where it is again.
  CHECK(says(error_message([] { lqr(sampled(pushed(4.0), std::acos(-1.0)), E(2), E(1)); }), "must be reached by an input"));
}
