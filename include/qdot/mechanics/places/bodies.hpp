#pragma once
// SPDX-License-Identifier: MIT
//
// What bodies contribute when their positions are known as functions of q.
//
// A functor of the kinematic door places bodies, bodies.point_mass(m, r) and so on. What becomes of that depends on who
// is listening, and the functor does not need to know:
//
//     KineticSum     r on numbers that move (velocity.hpp):   T += ½ m ṙ·ṙ
//     WeightSum      r on any numbers:                        V −= m g·r
//     JetEquations   r with J, ṙ and s (ad/places/position_jet.hpp): M += m JᵀJ,  rhs −= m Jᵀ(s − g)
//
// because Lagrange's equations of T = Σ ½ m ṙ·ṙ are Newton's, projected: Σ m Jᵀ r̈ with r̈ = J q̈ + s. A body that turns adds ½ Ω·I Ω of its angular
// velocity, along its own axes, as a term of the Lagrangian.
//
// In a chain, what hangs below a link moves with it: column i of J is the same for all its masses. JetEquations sees
// that while it compiles, as two values that are known to be the same, and adds up masses before it multiplies.

#include <type_traits>

#include <Eigen/Core>

#include "qdot/ad/places/position_jet.hpp"
#include "qdot/mechanics/equations/moving_positions.hpp"
#include "qdot/mechanics/rigid_body.hpp"

namespace qdot::detail {

// The rate of an entry of a position: of a number that moves, or of a constant.
template <class S>
const S& rate_of(const AlongMotion<S>& x) { return x.tangent[0]; }
template <class S>
S rate_of(double) { return S(0.0); }

// T of all bodies.
template <class S>
struct KineticSum {
  S T{0.0};

  template <class Position>
  [[gnu::always_inline]] void point_mass(double m, const Eigen::MatrixBase<Position>& r) {
    T = T + 0.5 * m * squared_speed(r);
  }
  template <class Position, class Angle>
  [[gnu::always_inline]] void planar_body(double m, double inertia, const Eigen::MatrixBase<Position>& r, const Angle& angle) {
    const S omega = rate_of<S>(angle);
    T = T + 0.5 * (m * squared_speed(r) + inertia * (omega * omega));
  }
  template <class Tensor, class Position, class Rotation>
  void rigid_body(double m, const Eigen::MatrixBase<Tensor>& inertia, const Eigen::MatrixBase<Position>& r, const Rotation& R) {
    T = T + 0.5 * (m * squared_speed(r) + quadratic_form(inertia, angular_velocity_of_body(R)));
  }
  template <class Position, class Rotation>
  void rigid_body(const RigidBody& body, const Eigen::MatrixBase<Position>& r, const Rotation& R) {
    const Eigen::Matrix3d inertia = inertia_at_centre(body.inertia, body.mass, body.centre);
    if (body.centre.isZero(0.0)) rigid_body(body.mass, inertia, r, R);
    else rigid_body(body.mass, inertia, (r + R * body.centre.template cast<AlongMotion<S>>()).eval(), R);
  }

 private:
  template <class Rotation>
  static Vector<S, 3> angular_velocity_of_body(const Rotation& R) {
    return angular_velocity_along<Axes::of_body, S>(R, [](const auto& entry) { return split<S>(entry); });
  }
  template <class Position>
  [[gnu::always_inline]] static S squared_speed(const Position& r) {
    S sum(0.0);
    for (Eigen::Index i = 0; i < r.size(); ++i) sum = sum + rate_of<S>(r[i]) * rate_of<S>(r[i]);
    return sum;
  }
};

// V of all bodies in a uniform field.
template <class S>
struct WeightSum {
  Eigen::Vector3d field;
  S V{0.0};

  template <class Position>
  [[gnu::always_inline]] void point_mass(double m, const Eigen::MatrixBase<Position>& r) {
    for (Eigen::Index i = 0; i < r.size(); ++i) V = V - (m * field[i]) * r[i];
  }
  template <class Position, class Angle>
  [[gnu::always_inline]] void planar_body(double m, double, const Eigen::MatrixBase<Position>& r, const Angle&) {
    point_mass(m, r);
  }
  template <class Tensor, class Position, class Rotation>
  void rigid_body(double m, const Eigen::MatrixBase<Tensor>&, const Eigen::MatrixBase<Position>& r, const Eigen::MatrixBase<Rotation>&) {
    point_mass(m, r);
  }
  template <class Position, class Rotation>
  void rigid_body(const RigidBody& body, const Eigen::MatrixBase<Position>& r, const Eigen::MatrixBase<Rotation>& R) {
    point_mass(body.mass, r);
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) V = V - (body.mass * field[i] * body.centre[k]) * R(i, k);
  }
};

// M and rhs of all bodies, straight-line code for each of them.
template <int n>
class JetEquations {
 public:
  static constexpr int pairs = n * (n + 1) / 2;
  using S = PositionJet<n>;

  [[gnu::always_inline]] explicit JetEquations(const Eigen::Vector3d& field) : field_{field[0], field[1], field[2]} {
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      r_[i] = 0.0;
      r_has_[i] = 0;
      unroll<3>([&](auto c) __attribute__((always_inline)) {
        last_[c][i] = load_[c][i] = 0.0;
        last_has_[c][i] = load_has_[c][i] = 0;
      });
    });
    unroll<pairs>([&](auto k) __attribute__((always_inline)) {
      M_[k] = weight_[k] = 0.0;
      M_has_[k] = weight_has_[k] = 0;
    });
  }

  template <class Position>
  [[gnu::always_inline]] void point_mass(double m, const Eigen::MatrixBase<Position>& position) {
    constexpr int axes = Position::RowsAtCompileTime;
    static_assert(axes >= 1 && axes <= 3, "qdot: the position of a body has 1, 2 or 3 entries");
    S r[axes];
    ComponentMask moves[axes];
    unroll<axes>([&](auto c) __attribute__((always_inline)) {
      r[c] = S(position.derived().coeff(c)).whole();
      moves[c] = r[c].mask;
      unroll<n>([&](auto i) __attribute__((always_inline)) {  // 0.0 * q[0]: a way to write a constant
        r[c].mask &= ~bit(has(r[c].mask, i) & (1U ^ may_differ_from_zero(r[c].template J<i>())), i);
      });
    });
    Present same[n];  // column i of J is the one of the body before
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      same[i] = 1;
      unroll<3>([&](auto c) __attribute__((always_inline)) {
        if constexpr (c < axes) {
          const Present now = has(r[c].mask, i);
          same[i] &= static_cast<Present>(now == last_has_[c][i]);
          if (now & last_has_[c][i]) same[i] &= known_equal(r[c].template J<i>(), last_[c][i]);
        } else {
          same[i] &= 1U - last_has_[c][i];
        }
      });
    });
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      unroll<i + 1>([&](auto j) __attribute__((always_inline)) {
        constexpr int k = triangle_index(i, j);
        Present active = 0, together = 0;
        unroll<axes>([&](auto c) __attribute__((always_inline)) {
          active |= has(r[c].mask, i) & has(r[c].mask, j);
          together |= has(moves[c], i) & has(moves[c], j);
        });
        if (same[i] & same[j]) {
          weight_[k] = sum_of(weight_has_[k], weight_[k], active, m);
        } else {
          settle_mass<i, j>();
          weight_[k] = m;
        }
        weight_has_[k] = active;
        pattern_ |= bit(together, k);  // whatever is known of numbers, which Clang decides late
      });
    });
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      if (!same[i]) settle_load<i>();
      unroll<3>([&](auto c) __attribute__((always_inline)) {
        if constexpr (c < axes) {
          const double f = sum_of(1U, m * field_[c], r[c].has_bend, product_if(r[c].has_bend, -m, r[c].bend));
          const Present loaded = has(r[c].mask, i);
          load_[c][i] = sum_of(load_has_[c][i], load_[c][i], loaded, f);
          load_has_[c][i] |= loaded;
          last_[c][i] = r[c].template J<i>();
          last_has_[c][i] = loaded;
        } else {
          last_has_[c][i] = 0;
        }
      });
    });
  }

  template <class Position, class Angle>
  [[gnu::always_inline]] void planar_body(double m, double inertia, const Eigen::MatrixBase<Position>& r, const Angle& angle) {
    point_mass(m, r);
    const S a = S(angle).whole();
    pattern_of_forces_ |= a.mask;
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      const Present turns = has(a.mask, i);
      const double moment = product_if(turns, inertia, a.template J<i>());
      add_force<i>(turns & a.has_bend, product_if(turns & a.has_bend, -moment, a.bend));
      unroll<i + 1>([&](auto j) __attribute__((always_inline)) {
        const Present both = turns & has(a.mask, j);
        add_mass<triangle_index(i, j)>(both, product_if(both, moment, a.template J<j>()));
      });
    });
  }

  template <class Tensor, class Position, class Rotation>
  [[gnu::always_inline]] void rigid_body(double m, const Eigen::MatrixBase<Tensor>& inertia, const Eigen::MatrixBase<Position>& r, const Rotation& R) {
    point_mass(m, r);
    turn(inertia, R);
  }
  template <class Position, class Rotation>
  [[gnu::always_inline]] void rigid_body(const RigidBody& body, const Eigen::MatrixBase<Position>& r, const Rotation& R) {
    const auto& a = body.centre;
    const auto row = [&](auto c) __attribute__((always_inline)) {
      return S(r.derived().coeff(c)) + (S(a[0]) * S(R.coeff(c, 0)) + S(a[1]) * S(R.coeff(c, 1)) + S(a[2]) * S(R.coeff(c, 2)));
    };
    const Vector<S, 3> centre(row(std::integral_constant<int, 0>()), row(std::integral_constant<int, 1>()), row(std::integral_constant<int, 2>()));
    point_mass(body.mass, centre);
    turn(inertia_at_centre(body.inertia, body.mass, a), R);
  }

  [[gnu::always_inline]] void potential(const S& of_position) {
    const S V = of_position.whole();
    pattern_of_forces_ |= V.mask;
    unroll<n>([&](auto i) __attribute__((always_inline)) { add_force<i>(has(V.mask, i), -V.template J<i>()); });
  }
  // A further term of L.
  [[gnu::always_inline]] void lagrangian(const EulerLagrange<n>& L) {
    pattern_ |= L.h_mask;
    pattern_of_forces_ |= L.g_mask;
    unroll<n>([&](auto i) __attribute__((always_inline)) { add_force<i>(has(L.x_mask, i), L.template x<i>()); });
    unroll<pairs>([&](auto k) __attribute__((always_inline)) { add_mass<k>(has(L.h_mask, k), L.template h<k>()); });
  }

  // What may be other than zero: known to the compiler, before it knows what is the same, when all of this is straight-line code.
  [[gnu::always_inline]] ComponentMask pattern() const { return pattern_ | pattern_of_forces_; }

  // M, the packed lower triangle, and rhs.
  [[gnu::always_inline]] void write(double* M, double* rhs) {
    settle_masses();
    unroll<pairs>([&](auto k) __attribute__((always_inline)) { M[k] = M_has_[k] ? M_[k] : 0.0; });
    unroll<n>([&](auto i) __attribute__((always_inline)) { rhs[i] = r_has_[i] ? r_[i] : 0.0; });
  }

 private:
  // ½ Ω·I Ω, as a term of L.
  template <class Tensor, class Rotation>
  [[gnu::always_inline]] void turn(const Tensor& inertia, const Rotation& R) {
    const MovingPositions<EulerLagrange<n>> positions;
    const auto omega = angular_velocity_along<Axes::of_body, EulerLagrange<n>>(R, FollowBy<MovingPositions<EulerLagrange<n>>>{positions});
    lagrangian(EulerLagrange<n>(0.5 * quadratic_form(inertia, omega)).whole());
  }
  [[gnu::always_inline]] void settle_masses() {
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      unroll<i + 1>([&](auto j) __attribute__((always_inline)) { settle_mass<i, j>(); });
      settle_load<i>();
    });
  }

  template <int i, int j>
  [[gnu::always_inline]] void settle_mass() {
    constexpr int k = triangle_index(i, j);
    double dot = 0.0;
    Present any = 0;
    unroll<3>([&](auto c) __attribute__((always_inline)) {
      const Present both = weight_has_[k] & last_has_[c][i] & last_has_[c][j];
      dot = sum_of(any, dot, both, product_if(both, last_[c][i], last_[c][j]));
      any |= both;
    });
    add_mass<k>(any, product_if(any, weight_[k], dot));
    weight_has_[k] = 0;
  }
  template <int i>
  [[gnu::always_inline]] void settle_load() {
    unroll<3>([&](auto c) __attribute__((always_inline)) {
      const Present both = last_has_[c][i] & load_has_[c][i];
      add_force<i>(both, product_if(both, last_[c][i], load_[c][i]));
      load_has_[c][i] = 0;
    });
  }
  template <int k>
  [[gnu::always_inline]] void add_mass(Present present, double m) {
    M_[k] = sum_of(M_has_[k], M_[k], present, m);
    M_has_[k] |= present;
  }
  template <int i>
  [[gnu::always_inline]] void add_force(Present present, double f) {
    r_[i] = sum_of(r_has_[i], r_[i], present, f);
    r_has_[i] |= present;
  }

  double field_[3];
  ComponentMask pattern_ = 0, pattern_of_forces_ = 0;
  double M_[pairs], r_[n];
  Present M_has_[pairs], r_has_[n];
  // Not yet multiplied: the columns of J of the last body, the mass on each pair of them, the force on each of them.
  double last_[3][n], weight_[pairs], load_[3][n];
  Present last_has_[3][n], weight_has_[pairs], load_has_[3][n];
};

}  // namespace qdot::detail
