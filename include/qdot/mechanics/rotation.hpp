#pragma once
// SPDX-License-Identifier: MIT
//
// Rotation and angular velocity
// =============================
//
//     r = r_A + R p ,     ṙ = ṙ_A + (Ṙ Rᵀ) (R p) ,     RᵀR = E ,  det R = 1                  ┌  0  −c   b ┐
//     [ω×] = Ṙ Rᵀ   components along the space axes,        ṙ = ṙ_A + ω × AP          [a×] = │  c   0  −a │
//     [Ω×] = Rᵀ Ṙ   components along the body axes,         ω = R Ω                          └ −b   a   0 ┘  of (a, b, c)
//
// R turns body components p of a point into space components. R Rᵀ = E differentiated shows that Ṙ Rᵀ is antisymmetric, a
// cross product: this is what angular velocity *is*. So ω needs no formula per set of angles: `angular_velocity_of`
// evaluates R(q) on dual numbers (velocity.hpp) and reads ω off. Space components go with an inertia tensor in space axes,
// body components with the constant one in body axes. Ways to write R, all generic in the scalar so that they work inside T:
// - Euler angles, R = R_i(a) R_j(b) R_k(c): 3-1-3 (precession, nutation, spin), 3-2-1 (yaw, pitch, roll), and ten more.
// - Quaternions: four numbers, no gimbal lock. R(p) divides by |p|², hence any p ≠ 0 is a rotation.
// - The rotation vector (axis times angle), R = exp [v×]: regular around v = 0, locked at |v| = 2π.

#include <cmath>
#include <type_traits>
#include <utility>

#include <Eigen/Core>

#include "qdot/ad/unroll.hpp"
#include "qdot/ad/vector.hpp"
#include "qdot/mechanics/equations/known_rotation.hpp"
#include "qdot/mechanics/velocity.hpp"

namespace qdot {

namespace detail {
template <Symbolic S>
inline constexpr bool remembers_rotations<AlongMotion<S>> = true;
}  // namespace detail

#if defined(__clang__) && defined(__OPTIMIZE__)  // ad/forward/functor_result.hpp says why
#pragma clang attribute push(__attribute__((always_inline)), apply_to = function)
#endif

/// [a×], the matrix of the cross product: skew(a) b = a × b.
template <class A>
Matrix<typename A::Scalar, 3> skew(const Eigen::MatrixBase<A>& a) {
  using S = typename A::Scalar;
  Matrix<S, 3> m;
  m(0, 0) = m(1, 1) = m(2, 2) = S(0);
  m(0, 1) = -a[2], m(0, 2) = a[1];
  m(1, 0) = a[2], m(1, 2) = -a[0];
  m(2, 0) = -a[1], m(2, 1) = a[0];
  return m;
}

/// The vector a with [a×] = the antisymmetric part of m; inverse of `skew`.
template <class M>
Vector<typename M::Scalar, 3> axial_vector(const Eigen::MatrixBase<M>& m) {
  using S = typename M::Scalar;
  return Vector<S, 3>(0.5 * (m(2, 1) - m(1, 2)), 0.5 * (m(0, 2) - m(2, 0)), 0.5 * (m(1, 0) - m(0, 1)));
}

/// Turn by `angle` about coordinate axis 1, 2 or 3 (x, y, z), counterclockwise seen from the tip of the axis.
template <int axis, class S>
Matrix<S, 3> rotation_about_axis(const S& angle) {
  static_assert(detail::require_real<S>());
  static_assert(axis >= 1 && axis <= 3, "qdot::rotation_about_axis: the axis must be 1 (x), 2 (y) or 3 (z)");
  using std::cos;
  using std::sin;
  constexpr int i = axis % 3, j = (axis + 1) % 3;  // the plane that turns, in cyclic order
  const S c = cos(angle), s = sin(angle);
  Matrix<S, 3> R;
  R(axis - 1, axis - 1) = S(1);
  R(axis - 1, i) = R(axis - 1, j) = R(i, axis - 1) = R(j, axis - 1) = S(0);
  R(i, i) = c;
  R(i, j) = -s;
  R(j, i) = s;
  R(j, j) = c;
  return R;
}

/// Turn about x by `angle`.
template <class S>
Matrix<S, 3> rotation_x(const S& angle) {
  return rotation_about_axis<1>(angle);
}

/// Turn about y by `angle`.
template <class S>
Matrix<S, 3> rotation_y(const S& angle) {
  return rotation_about_axis<2>(angle);
}

/// Turn about z by `angle`.
template <class S>
Matrix<S, 3> rotation_z(const S& angle) {
  return rotation_about_axis<3>(angle);
}

/// Turn in the plane by `angle`: [cos −sin; sin cos].
template <class S>
Matrix<S, 2> planar_rotation(const S& angle) {
  static_assert(detail::require_real<S>());
  using std::cos;
  using std::sin;
  const S c = cos(angle), s = sin(angle);
  Matrix<S, 2> R;
  R << c, -s, s, c;
  return R;
}

/// R = R_i(a) R_j(b) R_k(c): first by a about space axis i, then by b about the turned axis j, then by c
/// about the twice turned axis k. All twelve sets of Euler angles: euler_rotation<3, 1, 3>(phi, theta, psi).
///
/// Every set has a *gimbal lock* where its axes fall together and q̇ no longer follows from ω: sin θ = 0 for i-j-i, cos b = 0 for i-j-k. There M is
/// singular, and the library throws SingularMassMatrix.
template <int i, int j, int k, class S>
auto euler_rotation(const S& a, const S& b, const S& c) {
  static_assert(i != j && j != k, "qdot::euler_rotation: two neighbouring axes must differ, or two angles do the work of one");
  using std::cos, std::sin;
  constexpr int first_axis = i - 1, J = j - 1, K = k - 1, h = 3 - first_axis - J, o = 3 - J - K, P = (K + 1) % 3, Q = (K + 2) % 3;
  constexpr bool is_next = h == (J + 1) % 3;
  const Matrix<S, 3> first = rotation_about_axis<i>(a);
  const S s_j = sin(b), c_j = cos(b), s_k = sin(c), c_k = cos(c);
  detail::RotationBy<detail::EulerTurn<i, j, k>, S> R;
  detail::unroll<3>([&](auto of) __attribute__((always_inline)) {
    constexpr int row = of;
    S two[3];  // of R_i(a) R_j(b): axis i lies in the plane of the second turn, and axis j in that of the third, so there are entries 1 and 0
    if constexpr (row == first_axis) {
      two[first_axis] = c_j;
      two[h] = is_next ? s_j : S(-s_j);
      R(row, o) = two[o] * c_k;
      R(row, J) = o == P ? S(-(two[o] * s_k)) : S(two[o] * s_k);
    } else {
      two[J] = first(row, J);
      two[first_axis] = is_next ? S(-(first(row, h) * s_j)) : S(first(row, h) * s_j);
      two[h] = first(row, h) * c_j;
      R(row, P) = two[P] * c_k + two[Q] * s_k;
      R(row, Q) = two[Q] * c_k - two[P] * s_k;
    }
    R(row, K) = two[K];
  });
  detail::remember(R, a, b, c);
  return R;
}

/// The lecture's Euler angles 3-1-3: precession φ about z, nutation θ about the line of nodes, spin ψ about the body's z.
template <class S>
auto euler_rotation_313(const S& phi, const S& theta, const S& psi) {
  return euler_rotation<3, 1, 3>(phi, theta, psi);
}

/// Yaw, pitch, roll, the angles 3-2-1 of vehicles.
template <class S>
auto euler_rotation_321(const S& yaw, const S& pitch, const S& roll) {
  return euler_rotation<3, 2, 1>(yaw, pitch, roll);
}

/// Rotation of the quaternion p = (w, x, y, z), w the scalar part; p and any multiple of it give the same R.
///
/// Homogeneous of degree 0: ṗ along p does not turn the body. p = 0 gives NaN, as 0/0 does.
template <class P>
auto rotation_from_quaternion(const Eigen::MatrixBase<P>& p) {
  using S = typename P::Scalar;
  static_assert(detail::require_real<S>());
  const S w = p[0], x = p[1], y = p[2], z = p[3];
  const S s = 2.0 / (w * w + x * x + y * y + z * z);
  detail::RotationBy<detail::QuaternionTurn, S> R;
  const S sx = s * x, sy = s * y, sz = s * z;
  const S xx = sx * x, yy = sy * y, zz = sz * z, xy = sx * y, xz = sx * z, yz = sy * z, wx = sx * w, wy = sy * w, wz = sz * w;
  R(0, 0) = 1.0 - (yy + zz), R(0, 1) = xy - wz, R(0, 2) = xz + wy;
  R(1, 0) = xy + wz, R(1, 1) = 1.0 - (zz + xx), R(1, 2) = yz - wx;
  R(2, 0) = xz - wy, R(2, 1) = yz + wx, R(2, 2) = 1.0 - (xx + yy);
  detail::remember(R, w, x, y, z);
  return R;
}

/// Exponential map: the turn by |v| about the direction of v, R = E + (sin θ/θ) [v×] + ((1 − cos θ)/θ²) [v×]², θ = |v|.
///
/// Smooth at v = 0, with all its derivatives: below θ = 1/2 the two factors are power series in θ².
template <class V>
auto rotation_from_vector(const Eigen::MatrixBase<V>& v) {
  using S = typename V::Scalar;
  static_assert(detail::require_real<S>());
  constexpr int count = detail::remembers_rotations<S> ? 4 : 2;
  const detail::Stumpff<S> of = detail::stumpff<count>(S(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
  const S a = of.c1, b = of.c2;
  // [v×]² = v vᵀ − θ² E
  const S v0 = v[0], v1 = v[1], v2 = v[2];
  detail::RotationBy<detail::VectorTurn, S> R;
  const S x0 = a * v0, x1 = a * v1, x2 = a * v2, y0 = b * v0, y1 = b * v1, y2 = b * v2;
  const S y00 = y0 * v0, y11 = y1 * v1, y22 = y2 * v2, y01 = y0 * v1, y02 = y0 * v2, y12 = y1 * v2;
  R(0, 0) = 1.0 - (y11 + y22), R(0, 1) = y01 - x2, R(0, 2) = y02 + x1;
  R(1, 0) = y01 + x2, R(1, 1) = 1.0 - (y22 + y00), R(1, 2) = y12 - x0;
  R(2, 0) = y02 - x1, R(2, 1) = y12 + x0, R(2, 2) = 1.0 - (y00 + y11);
  detail::remember(R, v0, v1, v2, of.c1, of.c2, of.c3, of.c4);
  return R;
}

/// Angular velocity along the space axes, ω with [ω×] = Ṙ Rᵀ.
template <class R, class Rdot>
Vector<typename Rdot::Scalar, 3> angular_velocity(const Eigen::MatrixBase<R>& r, const Eigen::MatrixBase<Rdot>& rdot) {
  using S = typename Rdot::Scalar;
  const auto entry = [&](int i, int j) { return S(rdot(i, 0) * r(j, 0) + rdot(i, 1) * r(j, 1) + rdot(i, 2) * r(j, 2)); };
  return Vector<S, 3>(entry(2, 1), entry(0, 2), entry(1, 0));
}

/// Angular velocity along the body axes, Ω with [Ω×] = Rᵀ Ṙ.
template <class R, class Rdot>
Vector<typename Rdot::Scalar, 3> body_angular_velocity(const Eigen::MatrixBase<R>& r,
                                                       const Eigen::MatrixBase<Rdot>& rdot) {
  using S = typename Rdot::Scalar;
  const auto entry = [&](int i, int j) { return S(r(0, i) * rdot(0, j) + r(1, i) * rdot(1, j) + r(2, i) * rdot(2, j)); };
  return Vector<S, 3>(entry(2, 1), entry(0, 2), entry(1, 0));
}

namespace detail {

enum class Axes { of_space, of_body };

// The angular velocity from what R returned along the motion; of hashes a digest of R.
template <Axes axes, class S, class R, class Follow>
[[gnu::always_inline]] inline auto angular_velocity_along(const R& rotation, const Follow& follow) {
  if constexpr (axes == Axes::of_body && is_known_rotation<std::remove_cvref_t<R>>) {
    if (rotation.is_as_made()) return known_angular_velocity<S>(rotation, follow);
  }
  if constexpr (is_hash<S>) {
    const auto& matrix = rotation.eval();
    const auto* const entries = matrix.data();
    S all(entries[0]);
    unroll<8>([&](auto k) __attribute__((always_inline)) { all = S::joined(all, S(entries[k + 1])); });
    constexpr int first = axes == Axes::of_body ? 1 : 4;
    return Vector<S, 3>(S::digest(all, first), S::digest(all, first + 1), S::digest(all, first + 2));
  } else {
    const auto both = followed<S>(rotation, follow);
    if constexpr (axes == Axes::of_body) return Vector<S, 3>(body_angular_velocity(both.value, both.rate));
    else return Vector<S, 3>(angular_velocity(both.value, both.rate));
  }
}

// The angular velocity of R(q) or R(q, t).
template <Axes axes, class Function, class Q, class Qdot, class... Time>
auto turning(const Function& rotation, const Eigen::MatrixBase<Q>& q, const Eigen::MatrixBase<Qdot>& qdot, const Time&... t) {
  using S = MotionScalar<Q, Qdot, Time...>;
  return along_motion<S>(rotation, q, qdot, [](const auto& R, const auto& follow) __attribute__((always_inline)) {
    return angular_velocity_along<axes, S>(R, follow);
  }, t...);
}

}  // namespace detail

/// Space components of the angular velocity of R(q), or of R(q, t) when a time follows q̇.
///
/// @param rotation  generic function of q (and t) that returns the 3×3 rotation matrix
template <class Function, class Q, class Qdot, class... Time>
auto angular_velocity_of(const Function& rotation, const Eigen::MatrixBase<Q>& q, const Eigen::MatrixBase<Qdot>& qdot,
                         const Time&... t) {
  return detail::turning<detail::Axes::of_space>(rotation, q, qdot, t...);
}

/// Body components of the angular velocity of R(q), or of R(q, t) when a time follows q̇.
template <class Function, class Q, class Qdot, class... Time>
auto body_angular_velocity_of(const Function& rotation, const Eigen::MatrixBase<Q>& q,
                              const Eigen::MatrixBase<Qdot>& qdot, const Time&... t) {
  return detail::turning<detail::Axes::of_body>(rotation, q, qdot, t...);
}

#if defined(__clang__) && defined(__OPTIMIZE__)
#pragma clang attribute pop
#endif

}  // namespace qdot
