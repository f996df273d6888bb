// SPDX-License-Identifier: MIT
//
// More digits through the same functors: accelerations of a double pendulum, and of a body in quaternions, in long double and in
// quadruple precision.

#include "catch2_bridge.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/rotation.hpp"
#include "qdot/mechanics/system.hpp"

#ifdef __SIZEOF_FLOAT128__

#include <cmath>
#include <compare>
#include <limits>
#include <type_traits>

namespace stress {

// Numbers of 113 bits with the arithmetic of the compiler; sine and cosine by their series.
__extension__ typedef __float128 Bits;
struct Quad {
  Bits x = 0;
  Quad() = default;
  template <class N>
    requires std::is_arithmetic_v<N>
  Quad(N v) : x(static_cast<Bits>(v)) {}
  static Quad of(Bits v) { Quad q; q.x = v; return q; }
  explicit operator double() const { return static_cast<double>(x); }
  explicit operator long double() const { return static_cast<long double>(x); }
  friend Quad operator+(Quad a, Quad b) { return of(a.x + b.x); }
  friend Quad operator-(Quad a, Quad b) { return of(a.x - b.x); }
  friend Quad operator*(Quad a, Quad b) { return of(a.x * b.x); }
  friend Quad operator/(Quad a, Quad b) { return of(a.x / b.x); }
  Quad operator-() const { return of(-x); }
  Quad operator+() const { return *this; }
  Quad& operator+=(Quad b) { x += b.x; return *this; }
  Quad& operator-=(Quad b) { x -= b.x; return *this; }
  Quad& operator*=(Quad b) { x *= b.x; return *this; }
  Quad& operator/=(Quad b) { x /= b.x; return *this; }
  friend bool operator==(Quad a, Quad b) { return a.x == b.x; }
  friend std::partial_ordering operator<=>(Quad a, Quad b) {
    if (a.x < b.x) return std::partial_ordering::less;
    if (a.x > b.x) return std::partial_ordering::greater;
    return a.x == b.x ? std::partial_ordering::equivalent : std::partial_ordering::unordered;
  }
};
inline Quad abs(Quad a) { return a.x < 0 ? -a : a; }
inline bool isfinite(Quad a) { return a.x - a.x == 0; }
inline Quad sqrt(Quad a) {
  Quad r(std::sqrt(static_cast<double>(a)));
  if (a.x > 0)
    for (int i = 0; i < 3; ++i) r = (r + a / r) / Quad(2);
  return r;
}
inline Quad sin(Quad a) {
  Quad term = a, sum = a;
  for (int k = 1; k < 30; ++k) sum += term *= -a * a / Quad(2 * k * (2 * k + 1));
  return sum;
}
inline Quad cos(Quad a) {
  Quad term = 1, sum = 1;
  for (int k = 1; k < 30; ++k) sum += term *= -a * a / Quad(2 * k * (2 * k - 1));
  return sum;
}

}  // namespace stress

template <>
struct std::numeric_limits<stress::Quad> {
  static constexpr bool is_specialized = true, is_integer = false, is_signed = true;
  static constexpr int digits = 113, digits10 = 33;
  static stress::Quad epsilon() { return stress::Quad::of(static_cast<stress::Bits>(1) / (static_cast<stress::Bits>(1) * (1ULL << 56) * (1ULL << 56))); }
};

template <>
struct Eigen::NumTraits<stress::Quad> : Eigen::GenericNumTraits<stress::Quad> {
  enum { IsComplex = 0, IsInteger = 0, IsSigned = 1, RequireInitialization = 1, ReadCost = 1, AddCost = 20, MulCost = 20 };
  using Real = stress::Quad;
  using NonInteger = stress::Quad;
  using Nested = stress::Quad;
  static Real epsilon() { return std::numeric_limits<stress::Quad>::epsilon(); }
  static Real dummy_precision() { return epsilon(); }
  static int digits10() { return 33; }
};

using namespace qdot;
using stress::Quad;

namespace {

struct DoublePendulum {
  double m1 = 1.3, m2 = 0.7, l1 = 0.9, l2 = 1.4, g = 9.81;
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return 0.5 * (m1 + m2) * l1 * l1 * v[0] * v[0] + 0.5 * m2 * l2 * l2 * v[1] * v[1] + m2 * l1 * l2 * v[0] * v[1] * cos(q[0] - q[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -(m1 + m2) * g * l1 * cos(q[0]) - m2 * g * l2 * cos(q[1]);
  }
  // The textbook's equations, solved by Cramer's rule in S.
  template <class S>
  Vector<S, 2> by_hand(const Vector<S, 2>& q, const Vector<S, 2>& v) const {
    using std::cos, std::sin;
    const S a = S((m1 + m2) * l1 * l1), d = S(m2 * l2 * l2), k = S(m2 * l1 * l2), b = k * cos(q[0] - q[1]), s = k * sin(q[0] - q[1]);
    const S f = -s * v[1] * v[1] - S((m1 + m2) * g * l1) * sin(q[0]), h = s * v[0] * v[0] - S(m2 * g * l2) * sin(q[1]);
    const S det = a * d - b * b;
    return {(d * f - b * h) / det, (a * h - b * f) / det};
  }
};

// Largest relative difference between the library's accelerations and those by hand, both in S.
template <class S>
double relative_error() {
  const DoublePendulum pendulum{.m1 = 1.25, .m2 = 0.75, .l1 = 0.875, .l2 = 1.375, .g = 9.75};  // products of them are exact in double
  const Vector<S, 2> q(S(0.7), S(-1.9)), v(S(2.3), S(-0.4));
  const Vector<S, 2> by_library = acceleration(mechanical_system<2>(pendulum), q, v), exact = pendulum.by_hand(q, v);
  using std::abs;
  return std::max(static_cast<double>(abs(by_library[0] / exact[0] - S(1))), static_cast<double>(abs(by_library[1] / exact[1] - S(1))));
}

TEST_CASE("accelerations have the digits of their scalar") {
  // Ten roundings, amplified by a condition number of 2.
  CHECK(relative_error<double>() < 20 * 2.3e-16);
  CHECK(relative_error<long double>() < 20 * 1.1e-19);
  CHECK(relative_error<Quad>() < 20 * 2e-34);
}

TEST_CASE("double precision loses no more than rounding against quadruple") {
  // T from a rotation matrix: some hundred operations.
  const auto body = mechanical_system<4>([](const auto& p, const auto& pdot) {
    const auto w = body_angular_velocity_of([](const auto& x) { return rotation_from_quaternion(x); }, p, pdot);
    const auto rate = p.dot(pdot);
    return 0.5 * (w[0] * w[0] + 2.0 * w[1] * w[1] + 3.0 * w[2] * w[2] + rate * rate);
  });
  Vector<double, 4> p(0.5, -0.25, 0.75, 0.125), pdot(0.3, 1.1, -0.7, 0.2);
  Vector<Quad, 4> P, Pdot;
  for (int i = 0; i < 4; ++i) P[i] = p[i], Pdot[i] = pdot[i];
  const Vector<double, 4> a = acceleration(body, p, pdot);
  const Vector<Quad, 4> A = acceleration(body, P, Pdot);
  for (int i = 0; i < 4; ++i) CHECK(static_cast<double>(abs(Quad(a[i]) - A[i])) < 1e-14 * a.norm());
}

}  // namespace

#endif
