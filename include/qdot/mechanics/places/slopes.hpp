#pragma once
// SPDX-License-Identifier: MIT
//
// M, and how the equations of bodies change from state to state, from their positions.
//
// At accelerations that are known the equations of point masses are a sum of forces along their positions, and one derives them by the
// product rule:
//
//     r − M a = Σ F ∂x/∂q ,   F = m (g − ẍ)          ∂/∂q = Σ F H − m Jᵀ J̈ ,      ∂/∂q̇ = −2 Σ m Jᵀ J̇ ,
//
// with what ad/places/curved_jet.hpp knows of x. A body in the plane adds its angle as one more x, of mass I and without weight, and a potential is a
// force −1 along V.
//
// A body in space is all of its points, r_G + R p, and as Σ m p = 0 what they have in common is the point G, and the rest
//
//     ½ Σ m |Ṙ p|² = ½ Σ S_ab ċ_a·ċ_b ,      S = Σ m p pᵀ = ½ tr(I) E − I ,
//
// with the columns c of R: nine more x, in pairs.
//
// Forms have Jacobians from a recording that they keep (mechanics/derive/traced_jacobian.hpp). This is for a bare acceleration_jacobian(),
// which keeps nothing: of a chain of four and of a body in space it takes 0.65 and 1.8 µs here, by records 3.2 and 20, and to record and
// differentiate at each call would take 80 and 700.

#include <Eigen/Core>

#include "qdot/ad/places/curved_jet.hpp"
#include "qdot/mechanics/equations/straight_line.hpp"
#include "qdot/mechanics/rigid_body.hpp"

namespace qdot::detail {

// q_i on its way, at accelerations a.
template <int n>
Vector<CurvedJet<n>, n> curved_coordinates(const double* q, const double* qdot, const double* a) {
  Vector<CurvedJet<n>, n> x;
  for (int i = 0; i < n; ++i) x[i] = CurvedJet<n>::coordinate(i, q[i], qdot[i], a[i]);
  return x;
}

// Listens to a functor that places bodies (mechanics/places/bodies.hpp).
template <int n, class Row>
class BodySlopes {
 public:
  using S = CurvedJet<n>;

  // M, packed, and the first 2n entries of n rows.
  BodySlopes(const Eigen::Vector3d& field, double* M, Row* rows) : field_(field), M_(M), rows_(rows) {
    for (int k = 0; k < n * (n + 1) / 2; ++k) M_[k] = 0.0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < 2 * n; ++j) rows_[i][j] = 0.0;
  }

  template <class Position>
  void point_mass(double m, const Eigen::MatrixBase<Position>& r) {
    for (Eigen::Index c = 0; c < r.size(); ++c) {
      const S x(r.derived().coeff(c));
      add(m, field_[c], x, x);
    }
  }
  template <class Position, class Angle>
  void planar_body(double m, double inertia, const Eigen::MatrixBase<Position>& r, const Angle& angle) {
    point_mass(m, r);
    const S x(angle);
    add(inertia, 0.0, x, x);
  }
  template <class Tensor, class Position, class Rotation>
  void rigid_body(double m, const Eigen::MatrixBase<Tensor>& inertia, const Eigen::MatrixBase<Position>& r, const Eigen::MatrixBase<Rotation>& R) {
    point_mass(m, r);
    turn(Eigen::Matrix3d(inertia), columns_of(R));
  }
  template <class Position, class Rotation>
  void rigid_body(const RigidBody& body, const Eigen::MatrixBase<Position>& r, const Eigen::MatrixBase<Rotation>& R) {
    const auto c = columns_of(R);
    Vector<S, 3> centre;
    for (int i = 0; i < 3; ++i) {
      centre[i] = S(r.derived().coeff(i));
      for (int k = 0; k < 3; ++k)
        if (body.centre[k] != 0.0) centre[i] += body.centre[k] * c(i, k);
    }
    point_mass(body.mass, centre);
    turn(inertia_at_centre(body.inertia, body.mass, body.centre), c);
  }

  void potential(const S& V) { add_curvature(rows_, -1.0, V); }

 private:
  // One of the two halves of m ẋ ẏ, with its weight.
  void add(double m, double g, const S& x, const S& y) {
    add_curvature(rows_, m * (g - y.bend), x);
    for (int i = x.first; i < x.last; ++i) {
      const double w = m * x.J[i];
      for (int j = y.first; j < y.last; ++j) {
        if (j <= i) M_[triangle_index(i, j)] += w * y.J[j];
        rows_[i][j] -= w * y.Jddot[j];
        rows_[i][n + j] -= 2.0 * w * y.Jdot[j];
      }
    }
  }
  template <class Rotation>
  static Matrix<S, 3> columns_of(const Eigen::MatrixBase<Rotation>& R) {
    Matrix<S, 3> c;
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) c(i, k) = S(R.derived().coeff(i, k));
    return c;
  }
  void turn(const Eigen::Matrix3d& inertia, const Matrix<S, 3>& c) {
    const Eigen::Matrix3d moments = 0.5 * inertia.trace() * Eigen::Matrix3d::Identity() - inertia;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        if (moments(a, b) != 0.0)
          for (int i = 0; i < 3; ++i) add(moments(a, b), 0.0, c(i, a), c(i, b));
  }

  Eigen::Vector3d field_;
  double* M_;
  Row* rows_;
};

}  // namespace qdot::detail
