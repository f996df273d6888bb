// SPDX-License-Identifier: MIT
#include "catch2_bridge.hpp"

#include <cmath>
#include <random>

#include <Eigen/Cholesky>

#include "qdot/analysis/lqr.hpp"

using namespace qdot;
using Eigen::MatrixXd;

namespace {

// A Schur form of a small matrix, and one solve.
constexpr double rounding = 1e-12;

MatrixXd E(Eigen::Index n) { return MatrixXd::Identity(n, n); }

}  // namespace

TEST_CASE(
    "the double integrator with unit costs has K = (1, sqrt 3) and poles on the circle of radius 1 at 30 degrees") {
  const MatrixXd A = (MatrixXd(2, 2) << 0, 1, 0, 0).finished(), B = (MatrixXd(2, 1) << 0, 1).finished();
  const Lqr r = lqr(A, B, E(2), E(1));
  CHECK_THAT(r.K(0, 0), WithinRel(1.0, rounding));
  CHECK_THAT(r.K(0, 1), WithinRel(std::sqrt(3.0), rounding));
  CHECK_THAT(r.P(0, 0), WithinRel(std::sqrt(3.0), rounding));
  CHECK_THAT(r.P(0, 1), WithinRel(1.0, rounding));
  CHECK_THAT(r.exponents[1].real(), WithinRel(-std::sqrt(3.0) / 2.0, rounding));
  CHECK_THAT(r.exponents[1].imag(), WithinRel(0.5, rounding));
}

TEST_CASE("one state: P = (a + sqrt(a^2 + q b^2 / r)) r / b^2, through sixteen powers of ten") {
  const MatrixXd one = E(1);
  for (const double a : {-3.0, 0.0, 2.0})
    for (const double q : {1e-8, 1.0, 1e8}) {
      const double b = 0.7, cost = 0.4;
      const Lqr r = lqr(a * one, b * one, q * one, cost * one);
      // without cancellation for a < 0
      const double root = std::sqrt(a * a + q * b * b / cost);
      const double P = a < 0.0 ? q / (root - a) : (a + root) * cost / (b * b);
      CHECK_THAT(r.P(0, 0), WithinRel(P, 1e-9));
    }
}

TEST_CASE("Riccati's equation is solved, and the loop decays, whatever the system") {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int n = 1; n <= 9; ++n) {
    MatrixXd A(n, n), B(n, 2), G(n, n);
    for (MatrixXd* m : {&A, &B, &G})
      for (Eigen::Index i = 0; i < m->size(); ++i) m->data()[i] = normal(random);
    const MatrixXd Q = G.transpose() * G, R = (MatrixXd(2, 2) << 2, 1, 1, 3).finished();
    const Lqr r = lqr(A, B, Q, R);
    const MatrixXd PA = r.P * A, quadratic = r.K.transpose() * MatrixXd(R * r.K),
                   K = MatrixXd(R * r.K) - MatrixXd(B.transpose() * r.P);
    const MatrixXd left = PA + PA.transpose() - quadratic + Q;
    CHECK(K.norm() < 1e-12 * r.P.norm() * B.norm());
    CHECK(left.norm() < 1e-10 * (Q.norm() + r.P.norm() * A.norm()));
    CHECK(r.exponents.real().maxCoeff() < 0.0);
    CHECK(r.P.llt().info() == Eigen::Success);
  }
}

TEST_CASE("what has no regulator is refused with the reason") {
  const MatrixXd A = (MatrixXd(2, 2) << 1, 0, 0, -2).finished(), B = (MatrixXd(2, 1) << 0, 1).finished(), one = E(1);
  CHECK_THROWS_WITH(lqr(A, B, E(2), one),
                    "lqr: every mode that does not decay by itself must be reached by an input, but that with "
                    "the exponent 1 + 0i is not, most of it in x0; "
                    "add an input that moves it, or take it out of the model");
  CHECK_NOTHROW(lqr(-A, B, E(2), one).K);
  CHECK_THROWS_WITH(lqr(A, E(2), E(2), -E(2)),
                    "lqr: R must be positive definite, but its lowest eigenvalue is -1; give every input a cost");
  CHECK_THROWS_WITH(
      lqr(A, E(2), -E(2), E(2)),
      "lqr: Q must not be negative, but its lowest eigenvalue is -1; give no deviation a negative cost");
  CHECK_THROWS_WITH(lqr(one * 0.0, one, one * 0.0, one),
                    "lqr: every mode that lasts must show in Q, but the optimal loop would leave an exponent 0 "
                    "from the imaginary axis; give its coordinate a "
                    "cost in Q");
  CHECK_THROWS_WITH(lqr(A, E(2), E(3), E(2)),
                    "lqr: Q, 2 by 2, must have 4 entries, but has 9; it is 3 by 3");
  CHECK_THROWS_WITH(lqr(A * NAN, E(2), E(2), E(2)),
                    "lqr: A must be finite, but it has NaN or infinity in it; give every entry a number");
  CHECK_THROWS_AS(lqr(A, E(2), (MatrixXd(2, 2) << 1, 0.5, 0, 1).finished(), E(2)), InvalidValue);
}
