// SPDX-License-Identifier: MIT
#include "catch2_bridge.hpp"

#include <cmath>
#include <type_traits>

#include "qdot/ad/derivatives.hpp"
#include "qdot/mechanics/integrability.hpp"
#include "qdot/mechanics/velocity.hpp"

using namespace qdot;

namespace {

// What a holonomic constraint leaves: derivatives of order 1, a few roundings.
constexpr double rounding = 1e-13;

// One constraint as a row.
template <class... Entries>
auto row(const Entries&... entries) {
  return vector(entries...).transpose().eval();
}

// f and an integrating factor for the forms below.
const auto surface = [](const auto& q) {
  using std::exp;
  using std::sin;
  return q[0] * q[0] * q[1] + sin(q[2]) * exp(q[0]) + q[3] * q[1];
};

}  // namespace

TEST_CASE("rolling along a line, ẋ = R θ̇, is holonomic") {
  const auto rolling = [](const auto& q) { return row(q[0] * 0.0 + 1.0, q[0] * 0.0 - 0.3); };
  const Integrability answer = integrability(rolling, Vector<double, 2>(0.4, 1.0));
  CHECK(answer.holonomic);
  CHECK(answer.opened == 0);
  CHECK(answer.residual == 0.0);
}

TEST_CASE("one constraint on two coordinates always integrates, however it looks") {
  const auto form = [](const auto& q) {
    using std::exp;
    using std::sin;
    return row(sin(q[0] * q[1]) + 2.0, exp(q[0]) - q[1] * q[1] * q[1]);
  };
  CHECK(integrability(form, Vector<double, 2>(0.4, 1.0)).holonomic);
}

TEST_CASE("the knife edge is not holonomic") {
  const auto blade = [](const auto& q) {
    using std::cos;
    using std::sin;
    return row(-sin(q[2]), cos(q[2]), q[2] * 0.0);
  };
  for (const double angle : {0.0, 0.7, 1.5707963267948966, -2.0}) {
    const Integrability answer = integrability(blade, Vector<double, 3>(0.1, -0.2, angle));
    CHECK_FALSE(answer.holonomic);
    CHECK(answer.opened == 1);
    CHECK(answer.residual > 0.5);  // a · curl a = −1: as far from integrable as can be
  }
}

TEST_CASE("the Chaplygin sleigh, its blade at a distance from G, is not holonomic") {
  const auto blade = [](const auto& q) {
    using std::cos;
    using std::sin;
    return row(-sin(q[2]), cos(q[2]), q[2] * 0.0 - 0.5);
  };
  CHECK_FALSE(integrability(blade, Vector<double, 3>(0.1, -0.2, 0.4)).holonomic);
}

TEST_CASE("an exact differential integrates") {
  const auto form = [](const auto& q) { return gradient(surface, q).transpose().eval(); };
  const Integrability answer = integrability(form, Vector<double, 4>(0.4, 1.0, -0.3, 0.8));
  CHECK(answer.holonomic);
  CHECK(answer.residual < rounding);
}

TEST_CASE("an integrating factor hides an exact differential from its curl, but not from Frobenius") {
  const auto form = [](const auto& q) {
    using std::exp;
    const auto factor = exp(q[1] * q[2]) + q[3] * q[3];
    return (factor * gradient(surface, q)).transpose().eval();
  };
  const Vector<double, 4> q(0.4, 1.0, -0.3, 0.8);
  const Eigen::MatrixXd D = jacobian([&](const auto& x) { return form(x).transpose().eval(); }, q);
  CHECK((D - D.transpose()).norm() > 0.1);  // not exact as it stands
  const Integrability answer = integrability(form, q);
  CHECK(answer.holonomic);
  CHECK(answer.residual < rounding);
}

TEST_CASE("the textbook form y dx + z dy + x dz does not integrate: a · curl a = −(x + y + z)") {
  const auto form = [](const auto& q) { return row(q[1], q[2], q[0]); };
  CHECK_FALSE(integrability(form, Vector<double, 3>(0.4, 1.0, -0.3)).holonomic);
  // where x + y + z = 0 the condition holds by accident; the points around it do not let that pass
  CHECK_FALSE(integrability(form, Vector<double, 3>(0.4, 1.0, -1.4)).holonomic);
}

TEST_CASE("a disk rolling upright on a plane: two constraints, none of them holonomic") {
  // q = (x, y, heading, roll): ẋ = R cos(heading) roll˙, ẏ = R sin(heading) roll˙
  const auto rolling = [](const auto& q) {
    using std::cos;
    using std::sin;
    using S = std::decay_t<decltype(q[0])>;
    Matrix<S, 2, 4> A;
    A << S(1), S(0), S(0), -0.3 * cos(q[2]), S(0), S(1), S(0), -0.3 * sin(q[2]);
    return A;
  };
  const Integrability answer = integrability(rolling, Vector<double, 4>(0.0, 0.0, 0.6, 1.0));
  CHECK(answer.constraints == 2);
  CHECK_FALSE(answer.holonomic);
  CHECK(answer.opened == 1);  // the second direction opens only with a second exchange
}

TEST_CASE("a disk rolling along a fixed heading: the same two constraints, both holonomic") {
  const auto rolling = [](const auto& q) {
    using S = std::decay_t<decltype(q[0])>;
    Matrix<S, 2, 3> A;
    A << S(1), S(0), S(-0.3 * std::cos(0.6)), S(0), S(1), S(-0.3 * std::sin(0.6));
    return A;
  };
  CHECK(integrability(rolling, Vector<double, 3>(0.0, 0.0, 1.0)).holonomic);
}

TEST_CASE("two differentials mixed with varying coefficients are still two holonomic constraints") {
  const auto mixed = [](const auto& q) {
    using std::cos;
    using std::exp;
    using std::sin;
    const auto f = gradient(surface, q);
    const auto g = gradient([](const auto& x) { return x[0] * x[3] - cos(x[1]) * x[2]; }, q);
    using S = std::decay_t<decltype(q[0])>;
    Matrix<S, 2, 4> A;
    A.row(0) = (exp(q[0]) * f + sin(q[2]) * g).transpose();
    A.row(1) = (q[1] * f - q[3] * g).transpose();
    return A;
  };
  const Integrability answer = integrability(mixed, Vector<double, 4>(0.4, 1.0, -0.3, 0.8));
  CHECK(answer.constraints == 2);
  CHECK(answer.holonomic);
  CHECK(answer.residual < rounding);
}

TEST_CASE("one holonomic and one nonholonomic constraint: one direction opens") {
  // knife edge in (x, y, θ), and w = x y
  const auto both = [](const auto& q) {
    using std::cos;
    using std::sin;
    using S = std::decay_t<decltype(q[0])>;
    Matrix<S, 2, 5> A;
    A << -sin(q[2]), cos(q[2]), S(0), S(0), S(0), q[1], q[0], S(0), S(-1), S(0);
    return A;
  };
  Vector<double, 5> q;
  q << 0.4, 1.0, -0.3, 0.4, 2.0;
  const Integrability answer = integrability(both, q);
  CHECK_FALSE(answer.holonomic);
  CHECK(answer.opened == 1);
}

TEST_CASE("a prescribed motion is holonomic; a skate on a turning table is not") {
  // φ̇ − ω cos t = 0, the derivative of φ − ω sin t
  const auto A = [](const auto& q, const auto&) { return row(q[0] * 0.0 + 1.0); };
  const auto b = [](const auto&, const auto& t) {
    using std::cos;
    return vector(-2.0 * cos(t));
  };
  CHECK(integrability(A, b, Vector<double, 1>(0.3), 0.2).holonomic);
  const auto blade = [](const auto& q, const auto&) {
    using std::cos;
    using std::sin;
    return row(-sin(q[2]), cos(q[2]), q[2] * 0.0);
  };
  const auto table = [](const auto& q, const auto&) {
    using std::cos;
    using std::sin;
    return vector(-(q[0] * cos(q[2]) + q[1] * sin(q[2])));
  };
  CHECK_FALSE(integrability(blade, table, Vector<double, 3>(0.3, 0.1, 0.5), 0.2).holonomic);
}

TEST_CASE("time matters: ẋ + x ẏ t = 0 integrates for fixed t only") {
  const auto A = [](const auto& q, const auto& t) { return row(q[0] * 0.0 + 1.0, q[0] * t); };
  const auto b = [](const auto& q, const auto&) { return vector(q[0] * 0.0); };
  CHECK_FALSE(integrability(A, b, Vector<double, 2>(0.7, 0.1), 1.0).holonomic);
  CHECK(integrability([&](const auto& q) { return A(q, 1.0); }, Vector<double, 2>(0.7, 0.1)).holonomic);
}

TEST_CASE("a constraint that degenerates close by is refused, as is one with the wrong number of columns") {
  const auto vanishing = [](const auto& q) { return row(q[0] * 0.0, q[0] * 0.0, 0.0 * q[0]); };
  CHECK(integrability(vanishing, Vector<double, 3>(0.0, 0.0, 0.0)).constraints == 0);
  const auto merging = [](const auto& q) {
    using S = std::decay_t<decltype(q[0])>;
    Matrix<S, 2, 3> A;
    A << S(1), S(0), S(0), S(1), q[1], S(0);
    return A;
  };
  CHECK_THROWS_AS(integrability(merging, Vector<double, 3>(0.0, 0.0, 0.0)), InvalidValue);
  const auto narrow = [](const auto& q) { return row(q[0], q[1]); };
  CHECK_THROWS_AS(integrability(narrow, Vector<double, 3>(0.0, 0.0, 0.0)), DimensionError);
}
