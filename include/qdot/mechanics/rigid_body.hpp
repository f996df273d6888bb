#pragma once
// SPDX-License-Identifier: MIT
//
// Kinetic energy of a rigid body
// ==============================
//
//     T = ½ M v_A·v_A  +  M v_A·(ω × AG)  +  ½ ω·I_A ω        any point A
//     T = ½ M v_G·v_G  +  ½ ω·I_G ω                           the centre of mass G (Koenig); ½ ω·I_A ω where A rests
//
// follow from v_P = v_A + ω × AP, with Σ m AP = M AG and Σ m |ω × AP|² = ω·I_A ω (inertia.hpp). Two mistakes are common:
// to drop the middle term at a general A, and to give it the sign of AG × ω. `rigid_body.test.cpp` has the numbers of
// both.
//
// All vectors and the tensor must be in the same axes, whichever. Body axes keep I_A and AG constant. So a body is M, AG
// (the centre of mass seen from the reference point A) and I_A in its own axes, and its motion a position r_A(q) and a
// rotation R(q). `kinetic_energy_of_body` takes these two functions and differentiates them itself (velocity.hpp,
// rotation.hpp). M, M AG and I_A are sums over points, so `compound` adds them up for bodies that are fixed to each other.

#include <cmath>
#include <initializer_list>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include <Eigen/Core>

#include "qdot/ad/vector.hpp"
#include "qdot/mechanics/inertia.hpp"
#include "qdot/mechanics/rotation.hpp"
#include "qdot/mechanics/velocity.hpp"

namespace qdot {

#if defined(__clang__) && defined(__OPTIMIZE__)  // ad/forward/functor_result.hpp says why
#pragma clang attribute push(__attribute__((always_inline)), apply_to = function)
#endif

namespace detail {

template <class A, class B>
auto dot(const A& a, const B& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// a·(b × c)
template <class A, class B, class C>
auto triple_product(const A& a, const B& b, const C& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

// ω·I ω of a symmetric tensor, each product once.
template <class Tensor, class W>
auto quadratic_form(const Tensor& m, const W& w) {
  return m(0, 0) * (w[0] * w[0]) + m(1, 1) * (w[1] * w[1]) + m(2, 2) * (w[2] * w[2]) +
         2.0 * (m(1, 0) * (w[0] * w[1]) + m(2, 0) * (w[0] * w[2]) + m(2, 1) * (w[1] * w[2]));
}

}  // namespace detail

/// Koenig: T = ½ M v_G·v_G + ½ ω·I_G ω.
///
/// @param M      mass
/// @param I_G    inertia tensor about the centre of mass, 3×3
/// @param v_G    velocity of the centre of mass
/// @param omega  angular velocity, in the axes of I_G; |v_G| does not care about axes
template <class Tensor, class Velocity, class Omega>
auto kinetic_energy_about_centre(double M, const Eigen::MatrixBase<Tensor>& I_G, const Eigen::MatrixBase<Velocity>& v_G,
                                 const Eigen::MatrixBase<Omega>& omega) {
  return 0.5 * (M * detail::dot(v_G, v_G) + detail::quadratic_form(I_G, omega));
}

/// About any body point A: T = ½ M v_A·v_A + M v_A·(ω × AG) + ½ ω·I_A ω, all in the same axes.
///
/// @param M      mass
/// @param AG     from A to the centre of mass
/// @param I_A    inertia tensor about A, 3×3
/// @param v_A    velocity of A
/// @param omega  angular velocity
template <class Arm, class Tensor, class Velocity, class Omega>
auto kinetic_energy_about_point(double M, const Eigen::MatrixBase<Arm>& AG, const Eigen::MatrixBase<Tensor>& I_A,
                                const Eigen::MatrixBase<Velocity>& v_A, const Eigen::MatrixBase<Omega>& omega) {
  return 0.5 * (M * detail::dot(v_A, v_A) + detail::quadratic_form(I_A, omega)) +
         M * detail::triple_product(v_A, omega, AG);
}

/// The kinetic energy of a body that moves in a plane: T = ½ M v_A·v_A + M ω (AG_x v_y − AG_y v_x) + ½ I_A ω².
///
/// @param AG     from A to the centre of mass, 2 entries, space axes
/// @param I_A    moment of inertia about the axis through A normal to the plane
/// @param v_A    velocity of A, 2 entries
/// @param omega  angular velocity, counterclockwise
template <class Arm, class Velocity, class S>
auto planar_kinetic_energy(double M, const Eigen::MatrixBase<Arm>& AG, double I_A,
                           const Eigen::MatrixBase<Velocity>& v_A, const S& omega) {
  return 0.5 * (M * (v_A[0] * v_A[0] + v_A[1] * v_A[1]) + I_A * (omega * omega)) +
         M * omega * (AG[0] * v_A[1] - AG[1] * v_A[0]);
}

#if defined(__clang__) && defined(__OPTIMIZE__)
#pragma clang attribute pop
#endif

/// What mechanics needs to know of a rigid body, in axes fixed to it, seen from its reference point A.
struct RigidBody {
  double mass;              ///< M
  Eigen::Vector3d centre;   ///< AG
  Eigen::Matrix3d inertia;  ///< I_A, about the reference point (not about G)
};

/// A body whose reference point is its centre of mass.
///
/// @throws InvalidValue for a mass that is not positive or a tensor that no body has (inertia.hpp)
inline RigidBody body_about_centre(double M, const Eigen::Matrix3d& I_G) {
  if (!(std::isfinite(M) && M > 0.0)) {
    throw InvalidValue("rigid body: the mass must be finite and positive, but it is " + detail::number_text(M) +
                       "; leave a massless body out of T");
  }
  return {M, Eigen::Vector3d::Zero(), valid_inertia(I_G)};
}

/// The body made of these points, with the origin as reference point.
inline RigidBody body_of_points(std::span<const PointMass> points) {
  return {total_mass(points), centre_of_mass(points), inertia_of_points(points, Eigen::Vector3d::Zero())};
}

/// The same body seen from another of its points: AB leads from the old reference point to the new one.
///
/// Goes through G, as the parallel-axes rule demands.
inline RigidBody seen_from(const RigidBody& body, const Eigen::Vector3d& AB) {
  const Eigen::Vector3d BG = body.centre - AB;
  const Eigen::Matrix3d I_G = inertia_at_centre(body.inertia, body.mass, body.centre);
  return {body.mass, BG, inertia_away_from_centre(I_G, body.mass, BG)};
}

/// The body mounted in the axes of another: R turns its components into theirs, A sits at `at`; seen from their origin.
inline RigidBody mounted(const RigidBody& body, const Eigen::Vector3d& at,
                         const Eigen::Matrix3d& R = Eigen::Matrix3d::Identity()) {
  const Eigen::Vector3d centre = R * body.centre;
  const RigidBody turned{body.mass, centre, turned_inertia(R, body.inertia)};
  return seen_from(turned, -at);
}

/// Bodies fixed to each other, all seen from one common point: masses, first moments and tensors add.
inline RigidBody compound(std::initializer_list<RigidBody> parts) {
  RigidBody sum{0.0, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()};
  for (const RigidBody& part : parts) {
    sum.mass += part.mass;
    sum.centre += part.mass * part.centre;
    sum.inertia += part.inertia;
  }
  if (!(sum.mass > 0.0)) {
    throw InvalidValue("compound: the total mass must be positive, but it is " + detail::number_text(sum.mass) + " over " +
                       std::to_string(parts.size()) + " parts; give at least one part with mass");
  }
  sum.centre /= sum.mass;
  return sum;
}

#if defined(__clang__) && defined(__OPTIMIZE__)  // ad/forward/functor_result.hpp says why
#pragma clang attribute push(__attribute__((always_inline)), apply_to = function)
#endif

/// T of a body whose velocity v_A is in space axes and whose angular velocity `body_omega` is in body axes.
///
/// R is needed for the middle term alone, and is not touched when A = G.
template <class R, class Velocity, class Omega>
auto kinetic_energy_of_body(const RigidBody& body, const Eigen::MatrixBase<R>& rotation,
                            const Eigen::MatrixBase<Velocity>& v_A, const Eigen::MatrixBase<Omega>& body_omega) {
  using S = std::decay_t<decltype(rotation(0, 0) * v_A[0] * body_omega[0])>;
  S T = 0.5 * (body.mass * detail::dot(v_A, v_A) + detail::quadratic_form(body.inertia, body_omega));
  if (body.centre.isZero(0.0)) return T;
  Vector<S, 3> v;  // v_A in body axes, Rᵀ v_A
  for (int i = 0; i < 3; ++i) v[i] = rotation(0, i) * v_A[0] + rotation(1, i) * v_A[1] + rotation(2, i) * v_A[2];
  return T + body.mass * detail::triple_product(v, body_omega, body.centre);
}

/// T of a body from where it is: its rotation R(q) and the position r_A(q) of its reference point, both
/// generic functions of q, or of (q, t) when a time follows q̇. ω and v_A need not be derived.
template <class Rotation, class Position, class Q, class Qdot, class... Time>
auto kinetic_energy_of_body(const RigidBody& body, const Rotation& rotation, const Position& position,
                            const Eigen::MatrixBase<Q>& q, const Eigen::MatrixBase<Qdot>& qdot, const Time&... t) {
  using S = detail::MotionScalar<Q, Qdot, Time...>;
  const Vector<S, 3> v = velocity_of(position, q, qdot, t...);
  return detail::along_motion<S>(rotation, q, qdot, [&](const auto& R, const auto& follow) __attribute__((always_inline)) {
    const Vector<S, 3> omega = detail::angular_velocity_along<detail::Axes::of_body, S>(R, follow);
    return kinetic_energy_of_body(body, detail::followed<S>(R, follow).value, v, omega);
  }, t...);
}

#if defined(__clang__) && defined(__OPTIMIZE__)
#pragma clang attribute pop
#endif

}  // namespace qdot
