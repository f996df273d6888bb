// SPDX-License-Identifier: MIT
//
// Bricard's mechanism, benchmark A04 of the library of computational benchmark problems for multibody dynamics: six hinges in a
// closed spatial loop. The end is computed with 34 digits; EXUDYN approaches it with h².
#include <Eigen/Geometry>
#include <array>

#include "hard/motion.hpp"
#include "qdot/effects/constraints.hpp"

namespace qdot::hard {
namespace {

// Five rods of length 1 from P₁ = (0, 0, 0) to P₆ = (0, 0, 1), hinges about y, z, x, y, z; the sixth hinge, about x, closes.
struct Bricard {
  double m = 1.0, g = 9.81, across = (1.0 + 0.01) / 12, along = 0.02 / 12;

  static constexpr std::array<int, 5> axis{1, 2, 0, 1, 2};      // of the hinge at the beginning of each rod
  static constexpr std::array<int, 5> direction{0, 1, 2, 0, 1};  // of the rod, at rest
  static constexpr std::array<double, 5> sign{1, -1, 1, -1, 1};

  // R ← R·Rot(axis, angle).
  template <class S>
  static void turn(Matrix<S, 3>& R, int about, const S& angle) {
    using std::cos, std::sin;
    const int i = (about + 1) % 3, j = (about + 2) % 3;
    const S c = cos(angle), s = sin(angle);
    for (int row = 0; row < 3; ++row) {
      const S a = R(row, i), b = R(row, j);
      R(row, i) = c * a + s * b;
      R(row, j) = c * b - s * a;
    }
  }

  template <class S>
  S T(const Vector<S, 5>& q, const Vector<S, 5>& v) const {
    Matrix<S, 3> R = Matrix<S, 3>::Identity();
    Vector<S, 3> w = Vector<S, 3>::Zero(), velocity = w;  // angular velocity and that of the hinge, in space
    S sum(0.0);
    for (std::size_t k = 0; k < 5; ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      for (int row = 0; row < 3; ++row) w[row] += R(row, axis[k]) * v[i];
      turn(R, axis[k], S(q[i]));
      Vector<S, 3> rod;
      for (int row = 0; row < 3; ++row) rod[row] = sign[k] * R(row, direction[k]);
      const Vector<S, 3> rate = w.cross(rod), centre = velocity + rate * S(0.5);
      const S spin = w.dot(rod);
      sum += 0.5 * (m * centre.squaredNorm() + across * rate.squaredNorm() + along * spin * spin);
      velocity += rate;
    }
    return sum;
  }

  template <class S>
  S V(const Vector<S, 5>& q) const {
    Matrix<S, 3> R = Matrix<S, 3>::Identity();
    S height(0.0), sum(0.0);
    for (std::size_t k = 0; k < 5; ++k) {
      turn(R, axis[k], S(q[static_cast<Eigen::Index>(k)]));
      const S rise = sign[k] * R(1, direction[k]);
      sum += m * g * (height + 0.5 * rise);
      height += rise;
    }
    return sum;
  }

  // P₆ where it is, and the last axis along x.
  template <class S>
  Vector<S, 5> closure(const Vector<S, 5>& q) const {
    Matrix<S, 3> R = Matrix<S, 3>::Identity();
    Vector<S, 3> end(S(0.0), S(0.0), S(-1.0));
    for (std::size_t k = 0; k < 5; ++k) {
      turn(R, axis[k], S(q[static_cast<Eigen::Index>(k)]));
      for (int row = 0; row < 3; ++row) end[row] += sign[k] * R(row, direction[k]);
    }
    Vector<S, 5> phi;
    phi << end, R(1, 0), R(2, 0);
    return phi;
  }
};

std::vector<Row> rows() {
  const Bricard data;
  const auto mechanism = scene(mechanical_system<5>(data), holonomic("closure", [data](const auto& q) { return data.closure(q); }));
  const auto moving = motion(mechanism);
  const double a = 0.000269048883324646512, b = -0.000268976515492639812, va = 0.0324620117409979238, vb = -0.0324445510515423647;
  const Problem problem{.name = "A04 Bricard, 10 s",
                        .t_end = 10,
                        .start = Eigen::VectorXd::Zero(10),
                        .exact = numbers({a, b, a, b, a, va, vb, va, vb, va}),
                        .reference_digits = 17,
                        .gain = 3.7,
                        .best_published = "plot only",
                        .scale = Eigen::VectorXd::Ones(10)};
  return {solved(problem, moving, By::dop853, {.rtol = 2.5e-15, .atol = 1e-15}),
          solved(problem, moving, By::dopri5, {.rtol = 2.5e-15, .atol = 2.5e-15})};
}

}  // namespace

Case bricard() {
  return {"bricard", "Bricard mechanism (A04)",
          "Six hinges in a loop: counting gives no freedom at all, and there is one. One of the five loop equations is redundant "
          "at every moment, so a plain factorization fails and the multipliers are not unique. Errors are absolute. Both rows "
          "end in rounding: with equations whose sums are added up in another order, or tolerances from 2.3e-15 to 6e-15, Dop853 reaches 13.9 to 15.2 digits.",
          rows};
}

}  // namespace qdot::hard
