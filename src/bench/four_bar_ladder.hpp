#pragma once
// SPDX-License-Identifier: MIT
//
// A ladder of four-bar loops, each hung on the one before. Rung k goes from mass l_k to mass r_k, on rails a_k from l_{k−1} and b_k from r_{k−1};
// l₋₁ and r₋₁ are fixed at (0, 0) and (1, 0). Four Cartesian coordinates and three rods u to a loop:
//
//     m l̈_k = λa_k ua_k − λa_{k+1} ua_{k+1} − λc_k uc_k + m g ,     m r̈_k = λb_k ub_k − λb_{k+1} ub_{k+1} + λc_k uc_k + m g .
//
// The multipliers solve a block-tridiagonal system of blocks of three. The scene is what a user writes, with the number of loops known at run time.

#include <cstddef>
#include <type_traits>
#include <vector>

#include "bench/hanging_chain.hpp"

namespace qdot::bench {

/// ½ (|u|² − 1) for the two rails and the rung of each loop.
struct RodsOfLadder {
  auto operator()(const auto& q) const {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    const auto stretch = [](const S& x, const S& y) { return 0.5 * (x * x + y * y - 1.0); };
    Vector<S, Dynamic> rows(q.size() / 4 * 3);
    for (Eigen::Index k = 0; k < q.size() / 4; ++k) {
      const Eigen::Index l = 4 * k, r = 4 * k + 2;
      rows[3 * k] = k == 0 ? stretch(q[l], q[l + 1]) : stretch(q[l] - q[l - 4], q[l + 1] - q[l - 3]);
      rows[3 * k + 1] = k == 0 ? stretch(q[r] - 1.0, q[r + 1]) : stretch(q[r] - q[r - 4], q[r + 1] - q[r - 3]);
      rows[3 * k + 2] = stretch(q[r] - q[l], q[r + 1] - q[l + 1]);
    }
    return rows;
  }
};

inline auto four_bar_ladder(int loops) { return scene(mechanical_system(4 * loops, HangingMasses{}), holonomic("rods", RodsOfLadder{})); }

/// q̈, then λ, by elimination of a block of three after the other.
struct FourBarLadderByHand {
  std::size_t loops;
  double m = 1.0, g = 9.81, per_m = 1.0 / m;
  struct Loop {
    double ax, ay, bx, by, cx, cy;        // rods
    double aa, ab, ac, bb, bc, cc;        // inverse of the block
    double ya, yb, yc, za, zb, zc;        // rows a and b of the block beside it, times the inverse above
    double ra, rb, rc;                    // right side
  };
  mutable std::vector<Loop> all = std::vector<Loop>(loops);

  void operator()(const double* q, const double* v, double* out) const {
    double* const lambda = out + 4 * loops;
    double lx = 0.0, ly = 0.0, rx = 1.0, ry = 0.0, lu = 0.0, lw = 0.0, ru = 0.0, rw = 0.0;
    for (std::size_t k = 0; k < loops; ++k, q += 4, v += 4) {
      Loop& o = all[k];
      o.ax = q[0] - lx, o.ay = q[1] - ly, o.bx = q[2] - rx, o.by = q[3] - ry, o.cx = q[2] - q[0], o.cy = q[3] - q[1];
      const double au = v[0] - lu, aw = v[1] - lw, bu = v[2] - ru, bw = v[3] - rw, cu = v[2] - v[0], cw = v[3] - v[1];
      lx = q[0], ly = q[1], rx = q[2], ry = q[3], lu = v[0], lw = v[1], ru = v[2], rw = v[3];
      const double ends = (k == 0 ? 1.0 : 2.0) * per_m;
      double aa = ends * (o.ax * o.ax + o.ay * o.ay), bb = ends * (o.bx * o.bx + o.by * o.by), ab = 0.0;
      const double cc = 2.0 * per_m * (o.cx * o.cx + o.cy * o.cy), ac = -per_m * (o.ax * o.cx + o.ay * o.cy), bc = per_m * (o.bx * o.cx + o.by * o.cy);
      o.ra = -au * au - aw * aw;
      o.rb = -bu * bu - bw * bw;
      o.rc = -cu * cu - cw * cw;
      if (k == 0) {
        o.ra += g * o.ay;
        o.rb += g * o.by;
      } else {
        const Loop& p = all[k - 1];
        const double a_a = -per_m * (o.ax * p.ax + o.ay * p.ay), a_c = per_m * (o.ax * p.cx + o.ay * p.cy);
        const double b_b = -per_m * (o.bx * p.bx + o.by * p.by), b_c = -per_m * (o.bx * p.cx + o.by * p.cy);
        o.ya = a_a * p.aa + a_c * p.ac, o.yb = a_a * p.ab + a_c * p.bc, o.yc = a_a * p.ac + a_c * p.cc;
        o.za = b_b * p.ab + b_c * p.ac, o.zb = b_b * p.bb + b_c * p.bc, o.zc = b_b * p.bc + b_c * p.cc;
        aa -= o.ya * a_a + o.yc * a_c;
        ab -= o.yb * b_b + o.yc * b_c;
        bb -= o.zb * b_b + o.zc * b_c;
        o.ra -= o.ya * p.ra + o.yb * p.rb + o.yc * p.rc;
        o.rb -= o.za * p.ra + o.zb * p.rb + o.zc * p.rc;
      }
      const double minor_a = bb * cc - bc * bc, minor_b = ac * bc - ab * cc, minor_c = ab * bc - ac * bb;
      const double inverse = 1.0 / (aa * minor_a + ab * minor_b + ac * minor_c);
      o.aa = minor_a * inverse, o.ab = minor_b * inverse, o.ac = minor_c * inverse;
      o.bb = (aa * cc - ac * ac) * inverse, o.bc = (ab * ac - aa * bc) * inverse, o.cc = (aa * bb - ab * ab) * inverse;
    }
    double below_a = 0.0, below_b = 0.0, px = 0.0, py = 0.0, sx = 0.0, sy = 0.0;  // λ of the rails below, and their forces
    for (std::size_t k = loops; k-- > 0;) {
      const Loop& o = all[k];
      double a = o.aa * o.ra + o.ab * o.rb + o.ac * o.rc, b = o.ab * o.ra + o.bb * o.rb + o.bc * o.rc, c = o.ac * o.ra + o.bc * o.rb + o.cc * o.rc;
      if (k + 1 < loops) {
        const Loop& n = all[k + 1];
        a -= n.ya * below_a + n.za * below_b;
        b -= n.yb * below_a + n.zb * below_b;
        c -= n.yc * below_a + n.zc * below_b;
      }
      lambda[3 * k] = below_a = a;
      lambda[3 * k + 1] = below_b = b;
      lambda[3 * k + 2] = c;
      out[4 * k] = (a * o.ax - px - c * o.cx) * per_m;
      out[4 * k + 1] = (a * o.ay - py - c * o.cy) * per_m - g;
      out[4 * k + 2] = (b * o.bx - sx + c * o.cx) * per_m;
      out[4 * k + 3] = (b * o.by - sy + c * o.cy) * per_m - g;
      px = a * o.ax, py = a * o.ay, sx = b * o.bx, sy = b * o.by;
    }
  }
};

}  // namespace qdot::bench
