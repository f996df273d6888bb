#pragma once
// SPDX-License-Identifier: MIT
//
// M and rhs of bodies whose positions are rows (ad/places/position_row.hpp): loops, many coordinates.
//
// As with jets (mechanics/places/bodies.hpp), masses are added up before anything is multiplied while the columns of J stay as
// they were for the body before, here by blocks of four columns and by comparing numbers: so M of a chain of n masses costs
// n² and not n³ operations.

#include <algorithm>

#include <Eigen/Core>

#include "qdot/ad/places/position_row.hpp"
#include "qdot/mechanics/rigid_body.hpp"

namespace qdot::detail {

template <int blocks>
class RowEquations {
 public:
  using S = PositionRow<blocks>;
  static constexpr int stride = 4 * blocks;

  // M, stride × stride, and rhs, stride, are written to by write() and must be there until then.
  RowEquations(int n, const Eigen::Vector3d& field, double* M, double* rhs)
      : used_((n + 3) / 4), field_(field), M_(M), r_(rhs) {
    std::fill(M_, M_ + 4 * used_ * stride, 0.0);
    std::fill(r_, r_ + stride, 0.0);
    for (int c = 0; c < 3; ++c) std::fill(last_[c], last_[c] + stride, 0.0);
    for (int i = 0; i < blocks; ++i) {
      for (int c = 0; c < 3; ++c) load_[c][i] = 0.0;
      for (int j = 0; j <= i; ++j) weight_[i][j] = 0.0;
    }
  }

  template <class Position>
  void point_mass(double m, const Eigen::MatrixBase<Position>& position) {
    const int axes = static_cast<int>(position.size());
    S r[3];
    for (int c = 0; c < axes; ++c) r[c] = S(position[c]);
    place(m, r);
  }
  template <class Position, class Angle>
  void planar_body(double m, double inertia, const Eigen::MatrixBase<Position>& r, const Angle& angle) {
    point_mass(m, r);
    const S a(angle);
    add_product(inertia, a.J, a.J);
    add_force(-inertia * a.bend, a.J);
  }
  template <class Tensor, class Position, class Rotation>
  void rigid_body(double m, const Eigen::MatrixBase<Tensor>& inertia, const Eigen::MatrixBase<Position>& r,
                  const Eigen::MatrixBase<Rotation>& R) {
    point_mass(m, r);
    turn(Eigen::Matrix3d(inertia), R);
  }
  template <class Position, class Rotation>
  void rigid_body(const RigidBody& body, const Eigen::MatrixBase<Position>& r, const Eigen::MatrixBase<Rotation>& R) {
    S centre[3];
    for (int c = 0; c < 3; ++c) {
      centre[c] = S(r[c]);
      for (int k = 0; k < 3; ++k)
        if (body.centre[k] != 0.0) centre[c] += body.centre[k] * S(R(c, k));
    }
    place(body.mass, centre);
    const Eigen::Vector3d& G = body.centre;  // I about the centre is I_A − M (|G|² E − G Gᵀ)
    turn(body.inertia - body.mass * (G.squaredNorm() * Eigen::Matrix3d::Identity() - G * G.transpose()), R);
  }

  void potential(const S& V) { add_force(-1.0, V.J); }

  // M: the lower triangle of blocks; rhs.
  void write() {
    for (int i = 0; i < used_; ++i) {
      settle_load(i);
      for (int j = 0; j <= i; ++j) settle_mass(i, j);
    }
  }

 private:
  // b ← block i of a row; zeros outside of its range.
  static void read_block(Block& b, const PositionGradient<blocks>& row, int i) {
    b = Block{};
    if (i >= row.first && i < row.last) read(b, row.block(i));
  }
  static bool equal(const Block& a, const Block& b) {
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2] && a[3] == b[3];
  }

  void place(double m, const S (&r)[3]) {
    bool same[blocks] = {};
    for (int i = 0; i < used_; ++i) {
      same[i] = true;
      for (int c = 0; c < 3; ++c) {
        Block old, now;
        read(old, last_[c] + 4 * i);
        read_block(now, r[c].J, i);
        same[i] = same[i] && equal(old, now);
      }
    }
    for (int i = 0; i < used_; ++i) {
      if (!same[i]) settle_load(i);
      for (int j = 0; j <= i; ++j) {
        if (!(same[i] && same[j])) settle_mass(i, j);
        weight_[i][j] += m;
      }
    }
    for (int c = 0; c < 3; ++c) {
      const double f = m * (field_[c] - r[c].bend);
      for (int i = 0; i < used_; ++i) {
        load_[c][i] += f;
        if (same[i]) continue;
        Block now;
        read_block(now, r[c].J, i);
        qdot::detail::write(last_[c] + 4 * i, now);
      }
    }
  }

  // Euler's equations of a body with constant tensor I in its own axes.
  template <class Rotation>
  void turn(const Eigen::Matrix3d& inertia, const Rotation& rotation) {
    PositionGradient<blocks> J[3];
    Eigen::Vector3d w = Eigen::Vector3d::Zero(), wdot = w;
    for (int a = 0; a < 3; ++a) {
      const int i = (a + 2) % 3, j = (a + 1) % 3;  // Ω_a = (RᵀṘ)_ij
      J[a].clear();
      for (int k = 0; k < 3; ++k) {
        const S left(rotation(k, i)), right(rotation(k, j));
        w[a] += left.value * right.rate;
        wdot[a] += left.value * right.bend + left.rate * right.rate;
        J[a].add(left.value, right.J);
      }
    }
    const Eigen::Vector3d torque = inertia * wdot + w.cross(inertia * w);
    for (int a = 0; a < 3; ++a) {
      add_force(-torque[a], J[a]);
      for (int b = 0; b < 3; ++b)
        if (inertia(a, b) != 0.0) add_product(inertia(a, b), J[a], J[b]);
    }
  }

  // M += w g hᵀ
  void add_product(double w, const PositionGradient<blocks>& g, const PositionGradient<blocks>& h) {
    for (int i = g.first; i < g.last; ++i)
      for (int j = h.first; j < std::min(h.last, i + 1); ++j) {
        Block left, right;
        read(left, g.block(i));
        read(right, h.block(j));
        add_block_product(w, left, right, i, j);
      }
  }
  void add_block_product(double w, const Block& left, const Block& right, int i, int j) {
    for (int k = 0; k < 4; ++k) {
      double* const at = M_ + (4 * i + k) * stride + 4 * j;
      Block m;
      read(m, at);
      qdot::detail::write(at, m + (w * left[k]) * right);
    }
  }
  void add_force(double f, const PositionGradient<blocks>& J) {
    for (int i = J.first; i < J.last; ++i) add_block(r_ + 4 * i, f, J.block(i));
  }
  void settle_mass(int i, int j) {
    const double w = weight_[i][j];
    if (w == 0.0) return;
    weight_[i][j] = 0.0;
    for (int c = 0; c < 3; ++c) {
      Block left, right;
      read(left, last_[c] + 4 * i);
      read(right, last_[c] + 4 * j);
      if (equal(left, Block{}) || equal(right, Block{})) continue;
      add_block_product(w, left, right, i, j);
    }
  }
  void settle_load(int i) {
    for (int c = 0; c < 3; ++c) {
      add_block(r_ + 4 * i, load_[c][i], last_[c] + 4 * i);
      load_[c][i] = 0.0;
    }
  }

  int used_;
  Eigen::Vector3d field_;
  double* M_;
  double* r_;
  // Not yet multiplied: J of the last body, the mass on each pair of its blocks, the force on each block.
  double last_[3][stride];
  double load_[3][blocks];
  double weight_[blocks][blocks];
};

}  // namespace qdot::detail
