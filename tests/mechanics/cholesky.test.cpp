// SPDX-License-Identifier: MIT
#include "qdot/mechanics/equations/cholesky.hpp"

#include "../catch2_bridge.hpp"
#include "qdot/ad/dual_eigen.hpp"

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// M = L Lᵀ with L = [2 0 0; 6 1 0; −8 5 3], all in whole numbers, so that no rounding occurs.
Matrix3d whole_numbers() {
  Matrix3d M;
  M << 4, 12, -16, 12, 37, -43, -16, -43, 98;
  return M;
}

TEST_CASE("Cholesky's factor solves a system of whole numbers exactly") {
  qdot::Cholesky<double, 3> factor;
  REQUIRE(factor.compute(whole_numbers()));
  CHECK(factor.solve<1>(whole_numbers() * Vector3d(1, -2, 3)) == Vector3d(1, -2, 3));
  // pivots 4, 1, 9 of diagonal entries 4, 37, 98
  CHECK(factor.smallest_pivot() == 1.0 / 37.0);
  Vector3d lower(4, 13, -1);
  factor.solve_lower<1>(lower);
  CHECK(lower == Vector3d(2, 1, 10.0 / 3.0));
  Vector3d upper(0, 11, 6);
  factor.solve_upper<1>(upper);
  CHECK(upper == Vector3d(5, 1, 2));
}

TEST_CASE("a matrix that is not positive definite has no factor") {
  qdot::Cholesky<double, 2> factor;
  Eigen::Matrix2d M;
  M << 1, 2, 2, 4;  // singular
  CHECK_FALSE(factor.compute(M));
  M << 1, 0, 0, -1;  // negative
  CHECK_FALSE(factor.compute(M));
  CHECK(factor.smallest_pivot() == 0.0);
  M << 1, 0, 0, std::nan("");
  CHECK_FALSE(factor.compute(M));
}

TEST_CASE("the smallest pivot is blind to units") {
  qdot::Cholesky<double, 2> factor;
  Eigen::Matrix2d M;
  M << 1e-12, 0.5, 0.5, 1e12;  // correlation ½: pivot 3/4 of its diagonal
  REQUIRE(factor.compute(M));
  CHECK_THAT(factor.smallest_pivot(), WithinRel(0.75, 1e-15));
}

TEST_CASE("the factorization of duals is differentiated") {
  // x = b/m: dx/dm = −b/m²
  using D = qdot::Dual<double, 1>;
  qdot::Cholesky<D, 1> factor;
  qdot::Matrix<D, 1> M;
  M(0, 0) = D::variable(4.0, 0);
  REQUIRE(factor.compute(M));
  qdot::Matrix<D, 1, 1> b;
  b(0, 0) = D(6.0);
  const qdot::Matrix<D, 1, 1> x = factor.solve<1>(b);
  CHECK(x(0, 0).value == 1.5);
  CHECK(x(0, 0).tangent[0] == -0.375);
}

TEST_CASE("run-time sizes are factored like fixed ones") {
  qdot::Cholesky<double, qdot::Dynamic> factor;
  const Eigen::MatrixXd M = whole_numbers();
  REQUIRE(factor.compute(M));
  const Eigen::VectorXd b = whole_numbers() * Vector3d(1, -2, 3);
  CHECK(factor.solve<1>(b) == Eigen::VectorXd(Vector3d(1, -2, 3)));
}

}  // namespace
