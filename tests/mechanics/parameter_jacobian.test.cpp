// SPDX-License-Identifier: MIT
//
// Derivatives with respect to masses, lengths and gravity against closed forms and against the differentiated solution.
#include "catch2_bridge.hpp"

#include <cmath>

#include "qdot/mechanics/parameter_jacobian.hpp"

using namespace qdot;

namespace {

constexpr double rounded = 1e-13;

template <class S>
struct Pendulum {
  S m, l, g;
  auto T(const auto& qdot) const { return 0.5 * m * l * l * qdot[0] * qdot[0]; }
  auto V(const auto& q) const {
    using std::cos;
    return -m * g * l * cos(q[0]);
  }
};

template <class S>
struct DoublePendulum {
  S m1, m2, l1, l2, g;
  auto T(const auto& q, const auto& qdot) const {
    using std::cos;
    return 0.5 * (m1 + m2) * l1 * l1 * qdot[0] * qdot[0] + 0.5 * m2 * l2 * l2 * qdot[1] * qdot[1] +
           m2 * l1 * l2 * qdot[0] * qdot[1] * cos(q[0] - q[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -(m1 + m2) * g * l1 * cos(q[0]) - m2 * g * l2 * cos(q[1]);
  }
};

// Oscillators on a line, each with a stiffness of its own and driven at a frequency that is a parameter: m = n + 1.
template <class S, int n>
struct DrivenOscillators {
  Vector<S, n + 1> p;
  auto T(const auto& q, const auto& qdot, const auto& t) const {
    using std::sin;
    auto sum = 0.5 * qdot[0] * qdot[0] + 0.0 * p[0];
    for (int i = 1; i < n; ++i) sum = sum + 0.5 * qdot[i] * qdot[i];
    return sum + qdot[0] * sin(p[n] * t) * q[0];
  }
  auto V(const auto& q) const {
    auto sum = 0.5 * p[0] * q[0] * q[0];
    for (int i = 1; i < n; ++i) sum = sum + 0.5 * p[i] * q[i] * q[i];
    return sum;
  }
};

}  // namespace

TEST_CASE("a pendulum's acceleration depends on l and g as −g sin θ / l does, and not on m") {
  const Vector<double, 3> p(1.3, 0.7, 9.81);
  const Vector<double, 1> q(0.8), qdot(-1.1);
  const auto J = acceleration_jacobian_wrt_parameters<Pendulum>(p, q, qdot);
  CHECK(J.qddot[0] == Approx(-p[2] * std::sin(q[0]) / p[1]).epsilon(rounded));
  CHECK(std::abs(J.d_p(0, 0)) < rounded * 10);
  CHECK(J.d_p(0, 1) == Approx(p[2] * std::sin(q[0]) / (p[1] * p[1])).epsilon(rounded));
  CHECK(J.d_p(0, 2) == Approx(-std::sin(q[0]) / p[1]).epsilon(rounded));
}

TEST_CASE("derivatives with respect to parameters equal those of the differentiated solution") {
  const Vector<double, 5> p{{1.3, 0.7, 0.9, 1.4, 9.81}};
  const Vector<double, 2> q(0.8, -0.4), qdot(1.1, -2.3);
  const auto J = acceleration_jacobian_wrt_parameters<DoublePendulum>(p, q, qdot);
  // Cramer's rule, derived by hand, on dual numbers.
  const auto by_hand = [&](const auto& x) {
    using S = typename std::remove_cvref_t<decltype(x)>::Scalar;
    const double c = std::cos(q[0] - q[1]), s = std::sin(q[0] - q[1]);
    const S a = (x[0] + x[1]) * x[2] * x[2], b = x[1] * x[2] * x[3] * c, d = x[1] * x[3] * x[3];
    const S u = -x[1] * x[2] * x[3] * s * qdot[1] * qdot[1] - (x[0] + x[1]) * x[4] * x[2] * std::sin(q[0]);
    const S w = x[1] * x[2] * x[3] * s * qdot[0] * qdot[0] - x[1] * x[4] * x[3] * std::sin(q[1]);
    const S det = a * d - b * b;
    return Vector<S, 2>((u * d - b * w) / det, (a * w - b * u) / det);
  };
  const auto expected = value_and_jacobian(by_hand, p);
  CHECK((J.qddot - expected.value).norm() < rounded * expected.value.norm());
  CHECK((J.d_p - expected.jacobian).norm() < 10 * rounded * expected.jacobian.norm());
}

TEST_CASE("parameters may be many, of run-time number, and stand beside the time") {
  constexpr int n = 19;  // 20 parameters: more than are carried at once
  const double t = 0.3;
  Eigen::VectorXd p(n + 1);
  Vector<double, n> q, qdot;
  for (int i = 0; i < n; ++i) {
    p[i] = 1.0 + 0.1 * i;
    q[i] = 0.5 - 0.07 * i;
    qdot[i] = 0.2 * i;
  }
  p[n] = 2.5;
  const auto J = acceleration_jacobian_wrt_parameters(
      [](const auto& x) {
        using S = typename std::remove_cvref_t<decltype(x)>::Scalar;
        return DrivenOscillators<S, n>{x};
      },
      p, q, qdot, t);
  // q̈_i = −p_i q_i;  of the first also −ω cos(ωt) q₀, for the rest of the product with q̇₀ is a total derivative
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= n; ++j) {
      double expected = i == j ? -q[i] : 0.0;
      if (i == 0 && j == n) expected = -q[0] * (std::cos(p[n] * t) - p[n] * t * std::sin(p[n] * t));
      CHECK(J.d_p(i, j) == Approx(expected).margin(rounded));
    }
}

template <class S>
struct RootOfParameter {
  S b;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const {
    using std::sqrt;
    return sqrt(b) * q[0];
  }
};

TEST_CASE("a derivative with a parameter that is not finite is named") {
  using V1 = Vector<double, 1>;
  CHECK_THROWS_WITH(acceleration_jacobian_wrt_parameters<RootOfParameter>(V1(0.0), V1(1.0), V1(0.0)),
                    "the derivatives of accelerations must be finite, but the derivative of the acceleration of q0 with parameter 0 is not at t = 0, "
                    "where the acceleration is; look there for the root or the power of something that is zero, and round it off, as sqrt(x*x + "
                    "e*e) does, or take a method that needs no Jacobian");
}
