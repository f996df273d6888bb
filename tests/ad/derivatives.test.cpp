// SPDX-License-Identifier: MIT
#include <cmath>

#include <Eigen/Dense>

#include "../catch2_bridge.hpp"
#include "qdot/ad/derivatives.hpp"

namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

// f = x² y + sin z:  ∇f = (2xy, x², cos z)
const auto f = [](const auto& x) {
  using std::sin;
  return x[0] * x[0] * x[1] + sin(x[2]);
};

TEST_CASE("the gradient, Jacobian and Hessian of a function equal the hand-derived ones") {
  const Vector3d x(2.0, -3.0, 0.5);
  const auto g = qdot::value_and_gradient(f, x);
  CHECK(g.value == -12.0 + std::sin(0.5));
  CHECK(g.gradient == Vector3d(-12.0, 4.0, std::cos(0.5)));
  Eigen::Matrix3d H;
  H << -6, 4, 0, 4, 0, 0, 0, 0, -std::sin(0.5);
  CHECK(qdot::hessian(f, x) == H);

  const auto polar = [](const auto& p) {
    using std::cos;
    using std::sin;
    using S = typename std::remove_cvref_t<decltype(p)>::Scalar;
    return qdot::Vector<S, 2>(p[0] * cos(p[1]), p[0] * sin(p[1]));
  };
  const Eigen::Matrix2d J = qdot::jacobian(polar, Eigen::Vector2d(2.0, 0.3));
  CHECK(J(0, 0) == std::cos(0.3));
  CHECK(J(0, 1) == -2.0 * std::sin(0.3));
  CHECK(J(1, 0) == std::sin(0.3));
  CHECK(J(1, 1) == 2.0 * std::cos(0.3));
}

TEST_CASE("run-time sizes give the same derivatives as compile-time sizes") {
  const Vector3d x(2.0, -3.0, 0.5);
  const VectorXd xd = x;
  CHECK(qdot::gradient(f, xd) == VectorXd(qdot::gradient(f, x)));
  CHECK(qdot::hessian(f, xd) == Eigen::MatrixXd(qdot::hessian(f, x)));
}

TEST_CASE("vectors longer than one pass are differentiated completely") {
  // f = ½ Σ i x_i²: gradient i x_i, Hessian diag(i), for a length that is no multiple of the chunk
  const Eigen::Index n = 2 * qdot::chunk + 3;
  const auto sum = [](const auto& x) {
    auto s = 0.0 * x[0];
    for (Eigen::Index i = 0; i < x.size(); ++i) s += 0.5 * static_cast<double>(i) * x[i] * x[i];
    return s;
  };
  const VectorXd x = VectorXd::LinSpaced(n, 1.0, 2.0);
  const VectorXd weights = VectorXd::LinSpaced(n, 0.0, static_cast<double>(n - 1));
  CHECK((qdot::gradient(sum, x) - weights.cwiseProduct(x)).norm() < 1e-13);
  CHECK((qdot::hessian(sum, x) - Eigen::MatrixXd(weights.asDiagonal())).norm() < 1e-13);
}

TEST_CASE("a derivative inside a derivative does not confuse the perturbations") {
  // d/dx [ x · d/dy (x + y) ] = 1; a confused implementation gives 2.
  const double slope = qdot::derivative(
      [](const auto& x) {
        const auto inner = qdot::derivative([&](const auto& y) { return x + y; }, std::remove_cvref_t<decltype(x)>(1.0));
        return x * inner;
      },
      1.0);
  CHECK(slope == 1.0);

  // d/dx [ x · d/dy (x y²) at y = 3 ] = d/dx [6 x²] = 12 x
  const double other = qdot::derivative(
      [](const auto& x) {
        return x * qdot::derivative([&](const auto& y) { return x * y * y; }, std::remove_cvref_t<decltype(x)>(3.0));
      },
      2.0);
  CHECK(other == 24.0);
}

TEST_CASE("a gradient of a gradient is the Hessian") {
  const Vector3d x(2.0, -3.0, 0.5);
  // ∇(∇f·∇f) = 2 H ∇f
  const auto squared = [](const auto& y) { return qdot::gradient(f, y).squaredNorm(); };
  const Vector3d expected = 2.0 * qdot::hessian(f, x) * qdot::gradient(f, x);
  CHECK((qdot::gradient(squared, x) - expected).norm() < 1e-13 * expected.norm());
}

TEST_CASE("the derivative of a matrix function is the matrix of derivatives") {
  const auto rotation = [](const auto& angle) {
    using std::cos;
    using std::sin;
    using S = std::remove_cvref_t<decltype(angle)>;
    qdot::Matrix<S, 2> R;
    R << cos(angle), -sin(angle), sin(angle), cos(angle);
    return R;
  };
  const Eigen::Matrix2d R = qdot::derivative(rotation, 0.3);
  CHECK(R(0, 0) == -std::sin(0.3));
  CHECK(R(1, 0) == std::cos(0.3));
}

TEST_CASE("Eigen's expressions compute with duals") {
  using D = qdot::Dual<double, 2>;
  qdot::Matrix<D, 2> A;
  A << D::variable(2.0, 0), 1.0, 1.0, D::variable(3.0, 1);
  qdot::Vector<D, 2> b;
  b << 1.0, 2.0;
  // det A = ab − 1: slopes b and a
  CHECK(A.determinant().value == 5.0);
  CHECK(A.determinant().tangent[0] == 3.0);
  CHECK(A.determinant().tangent[1] == 2.0);
  // A⁻¹ b by Cholesky and by LU; d(A⁻¹b) = −A⁻¹ dA A⁻¹ b with A⁻¹b = (0.2, 0.6)
  const qdot::Vector<D, 2> x = A.llt().solve(b);
  const qdot::Vector<D, 2> z = A.lu().solve(b);
  CHECK_THAT(x[0].value, WithinAbs(0.2, 1e-15));
  CHECK_THAT(x[0].tangent[0], WithinAbs(-0.6 * 0.2, 1e-15));
  CHECK_THAT(x[1].tangent[1], WithinAbs(-0.4 * 0.6, 1e-15));
  CHECK_THAT(z[1].tangent[1], WithinAbs(-0.4 * 0.6, 1e-15));
  // mixed with plain numbers, fixed and dynamic
  const Eigen::Vector2d plain(1.0, -1.0);
  const D dot = b.dot(A * plain) * 2.0;
  CHECK(dot.value == 2.0 * (1.0 * 1.0 + 2.0 * -2.0));
  qdot::Matrix<D, qdot::Dynamic> B = A;
  CHECK((B * b).norm().value == Approx(std::sqrt(16.0 + 49.0)));
}

TEST_CASE("an empty point has an empty gradient") {
  const auto nothing = [](const auto& x) { return x.sum(); };
  CHECK(qdot::gradient(nothing, VectorXd(0)).size() == 0);
}

}  // namespace
