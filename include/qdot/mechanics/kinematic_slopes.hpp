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
// with what ad/curved_jet.hpp knows of x. A body in the plane adds its angle as one more x, of mass I and without weight, and a potential is a
// force −1 along V. Bodies in space are left to records (equation_slopes.hpp).

#include <Eigen/Core>

#include "qdot/ad/curved_jet.hpp"
#include "qdot/mechanics/straight_line.hpp"

namespace qdot::detail {

// q_i on its way, at accelerations a.
template <int n>
Vector<CurvedJet<n>, n> curved_coordinates(const double* q, const double* qdot, const double* a) {
  Vector<CurvedJet<n>, n> x;
  for (int i = 0; i < n; ++i) x[i] = CurvedJet<n>::coordinate(i, q[i], qdot[i], a[i]);
  return x;
}

// Listens to a functor that places bodies (kinematic_bodies.hpp).
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
    for (Eigen::Index c = 0; c < r.size(); ++c) add(m, field_[c], S(r.derived().coeff(c)));
  }
  template <class Position, class Angle>
  void planar_body(double m, double I, const Eigen::MatrixBase<Position>& r, const Angle& angle) {
    point_mass(m, r);
    add(I, 0.0, S(angle));
  }
  template <class... Arguments>
  void rigid_body(const Arguments&...) { turns_ = true; }
  bool turns() const { return turns_; }

  void potential(const S& V) { add_curvature(rows_, -1.0, V); }

 private:
  void add(double m, double g, const S& x) {
    add_curvature(rows_, m * (g - x.bend), x);
    for (int i = x.first; i < x.last; ++i) {
      const double w = m * x.J[i];
      for (int j = x.first; j <= i; ++j) M_[triangle_index(i, j)] += w * x.J[j];
      for (int j = x.first; j < x.last; ++j) rows_[i][j] -= w * x.Jddot[j];
      for (int j = x.first; j < x.last; ++j) rows_[i][n + j] -= 2.0 * w * x.Jdot[j];
    }
  }

  Eigen::Vector3d field_;
  double* M_;
  Row* rows_;
  bool turns_ = false;
};

}  // namespace qdot::detail
