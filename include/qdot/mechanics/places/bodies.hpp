#pragma once
// SPDX-License-Identifier: MIT
//
// What bodies contribute when their positions are known as functions of q.
//
// The functor of a kinematic system places bodies, bodies.point_mass(m, r) and so on. What becomes of that depends on the object that it is given, and
// the functor does not need to know:
//
//     KineticSum     r and R on numbers that move (velocity.hpp):   T += ½ m ṙ·ṙ + ½ Ω·I Ω ,  Ω along the body's axes;
//                    of a body about A                              T += ½ m v_A·v_A + m Rᵀv_A·(Ω × AG) + ½ Ω·I_A Ω , where R must be a rotation
//     WeightSum      r and R on any numbers:                        V −= m g·r

#include <string>
#include <type_traits>

#include <Eigen/Core>

#include "qdot/ad/unroll.hpp"
#include "qdot/mechanics/rigid_body.hpp"

namespace qdot::detail {

#if defined(__clang__) && defined(__OPTIMIZE__)  // ad/forward/functor_result.hpp says why
#pragma clang attribute push(__attribute__((always_inline)), apply_to = function)
#endif

// Whether a matrix has so many entries, as far as its type tells.
template <class M, int least, int most>
inline constexpr bool has_entries = M::SizeAtCompileTime == Dynamic || (M::SizeAtCompileTime >= least && M::SizeAtCompileTime <= most);
template <class Position>
void require_position(const Position& r) {
  static_assert(has_entries<Position, 1, 3>, "qdot: the position of a body has 1, 2 or 3 entries");
  if (r.size() < 1 || r.size() > 3) {
    throw InvalidValue("the position of a body has 1, 2 or 3 entries, but this one has " + std::to_string(r.size()) + "; give x, or x and y, or x, y and z");
  }
}
template <class Position, class Rotation>
consteval bool require_body() {
  static_assert(has_entries<Position, 3, 3> && has_entries<Rotation, 9, 9>, "qdot: the reference point of a rigid body has 3 entries, and its rotation 3 by 3");
  return true;
}

// r_A + R AG.
template <class Position, class Rotation>
auto centre_of(const RigidBody& body, const Eigen::MatrixBase<Position>& r, const Rotation& R) {
  static_assert(require_body<Position, Rotation>());
  const auto& point = r.derived().eval();
  const auto& turned = R.eval();
  using X = std::remove_cvref_t<decltype(point.coeff(0) + body.centre[0] * turned.coeff(0, 0))>;
  Vector<X, 3> centre;
  unroll<3>([&](auto i) __attribute__((always_inline)) {
    centre[i] = X(point.coeff(i));
    unroll<3>([&](auto k) __attribute__((always_inline)) {
      if (body.centre[k] != 0.0) centre[i] = centre[i] + body.centre[k] * turned.coeff(i, k);
    });
  });
  return centre;
}

// T of all bodies, where follow(entry) is the value and the rate of an entry of a position or a rotation.
template <class S, class Follow>
struct KineticSum {
  const Follow& follow;
  S T{0.0};

  template <class Position>
  void point_mass(double m, const Eigen::MatrixBase<Position>& r) {
    T = T + 0.5 * m * squared_speed(r);
  }
  template <class Position, class Angle>
  void planar_body(double m, double inertia, const Eigen::MatrixBase<Position>& r, const Angle& angle) {
    const S omega = follow(angle).rate;
    T = T + 0.5 * (m * squared_speed(r) + inertia * (omega * omega));
  }
  template <class Tensor, class Position, class Rotation>
  void rigid_body(double m, const Eigen::MatrixBase<Tensor>& inertia, const Eigen::MatrixBase<Position>& r, const Rotation& R) {
    static_assert(has_entries<Rotation, 9, 9>, "qdot: the rotation of a rigid body is a matrix of 3 by 3");
    T = T + 0.5 * (m * squared_speed(r) + quadratic_form(inertia, angular_velocity_along<Axes::of_body, S>(R, follow)));
  }
  template <class Position, class Rotation>
  void rigid_body(const RigidBody& body, const Eigen::MatrixBase<Position>& r, const Rotation& R) {
    static_assert(require_body<Position, Rotation>());
    const Vector<S, 3> omega = angular_velocity_along<Axes::of_body, S>(R, follow);
    T = T + 0.5 * (body.mass * squared_speed(r) + quadratic_form(body.inertia, omega));
    if (body.centre.isZero(0.0)) return;
    const auto& turned = R.eval();
    const auto& point = r.derived().eval();
    Vector<S, 3> v;  // v_A along the body's axes
    unroll<3>([&](auto i) __attribute__((always_inline)) {
      v[i] = S(0.0);
      unroll<3>([&](auto k) __attribute__((always_inline)) { v[i] = v[i] + follow(turned.coeff(k, i)).value * follow(point.coeff(k)).rate; });
    });
    T = T + body.mass * triple_product(v, omega, body.centre);
  }

 private:
  template <class Position>
  S squared_speed(const Eigen::MatrixBase<Position>& r) const {
    require_position(r.derived());
    S sum(0.0);
    over_entries<true>(r.derived().eval(), [&](const auto& entry, auto) __attribute__((always_inline)) {
      const S rate = follow(entry).rate;
      sum = sum + rate * rate;
    });
    return sum;
  }
};

// V of all bodies in a uniform field.
template <class S>
struct WeightSum {
  double field[3];
  S V{0.0};

  template <class Position>
  void point_mass(double m, const Eigen::MatrixBase<Position>& r) {
    require_position(r.derived());
    over_entries<true>(r.derived().eval(), [&](const auto& entry, auto i) __attribute__((always_inline)) {
      if (field[i] != 0.0) V = V - (m * field[i]) * entry;
    });
  }
  template <class Position, class Angle>
  void planar_body(double m, double, const Eigen::MatrixBase<Position>& r, const Angle&) {
    point_mass(m, r);
  }
  template <class Tensor, class Position, class Rotation>
  void rigid_body(double m, const Eigen::MatrixBase<Tensor>&, const Eigen::MatrixBase<Position>& r, const Rotation&) {
    point_mass(m, r);
  }
  template <class Position, class Rotation>
  void rigid_body(const RigidBody& body, const Eigen::MatrixBase<Position>& r, const Rotation& R) {
    point_mass(body.mass, centre_of(body, r, R));
  }
};

#if defined(__clang__) && defined(__OPTIMIZE__)
#pragma clang attribute pop
#endif

}  // namespace qdot::detail
