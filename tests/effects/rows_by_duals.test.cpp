// SPDX-License-Identifier: MIT
//
// J, φ̇, φ̈ and their slopes against formulas by hand.

#include "qdot/effects/equations/rows_by_duals.hpp"

#include <cmath>
#include <tuple>
#include <type_traits>

#include "../catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/equations/scene_rows_of.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/mechanics/system.hpp"

namespace {

using namespace qdot;
using detail::Column;
using detail::Table;

constexpr double rounding = 1e-14;  // of sums of a few numbers of size 1

// φ = x² + y² − t² = 0 in both its rows, the second doubled, and a = ẏ sin x − ẋ cos x + t = 0, for n point masses.
template <int n>
auto scene_of() {
  using std::cos, std::sin;
  const auto circle = holonomic("circle", [](const auto& q, const auto& t) {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    const S phi = q[0] * q[0] + q[1] * q[1] - t * t;
    return Vector<S, 2>(phi, 2.0 * phi);
  });
  const auto blade = nonholonomic("blade", [](const auto& q, const auto& v, const auto& t) { return sin(q[0]) * v[1] - cos(q[0]) * v[0] + t; });
  return scene(mechanical_system<n>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return q[1]; }), circle, blade);
}

struct At {
  double x = 0.7, y = -0.4, vx = 0.3, vy = 1.1, ax = -0.6, ay = 0.2, t = 0.5;
};

// Two numbers and zeros for the other coordinates.
template <int n>
Column two(double x, double y) {
  Column all(n, 0.0);
  all[0] = x;
  all[1] = y;
  return all;
}

template <int n>
void check_rows() {
  const auto s = scene_of<n>();
  const detail::SceneRowsOf<std::remove_cvref_t<decltype(s)>> rows(s);
  const At at;
  const Column q = two<n>(at.x, at.y), v = two<n>(at.vx, at.vy), a = two<n>(at.ax, at.ay), z(0);
  const double sx = std::sin(at.x), cx = std::cos(at.x);
  REQUIRE(rows.rows() == 3);
  CHECK((rows.is_of_positions(0) && rows.is_of_positions(1) && !rows.is_of_positions(2)));

  const Column phi = rows.residual(at.t, q, z), rate = rows.velocity(at.t, q, v, z), second = rows.row_accelerations(at.t, q, v, a, z);
  const double circle = at.x * at.x + at.y * at.y - at.t * at.t, moves = 2.0 * (at.x * at.vx + at.y * at.vy - at.t);
  const double bends = 2.0 * (at.vx * at.vx + at.vy * at.vy + at.x * at.ax + at.y * at.ay - 1.0);
  const double turns = cx * at.vx * at.vy + sx * at.ay + sx * at.vx * at.vx - cx * at.ax + 1.0;
  for (const auto& [found, first, third] : {std::tuple(phi, circle, 0.0), {rate, moves, sx * at.vy - cx * at.vx + at.t}, {second, bends, turns}}) {
    CHECK_THAT(found[0], WithinAbs(first, rounding));
    CHECK_THAT(found[1], WithinAbs(2.0 * first, rounding));
    CHECK_THAT(found[2], WithinAbs(third, rounding));
  }

  const Table J = rows.jacobian(at.t, q, v, z);
  const double J_by_hand[3][2] = {{2.0 * at.x, 2.0 * at.y}, {4.0 * at.x, 4.0 * at.y}, {-cx, sx}};
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < n; ++j) CHECK_THAT(J(i, j), WithinAbs(j < 2 ? J_by_hand[i][j] : 0.0, rounding));

  Table dc(3, 2 * n, 0.0), dr(n, 2 * n, 0.0);
  rows.write_slopes_of_accelerations(at.t, q, v, a, z, dc);
  const double of_circle[4] = {2.0 * at.ax, 2.0 * at.ay, 4.0 * at.vx, 4.0 * at.vy};
  const double of_blade[4] = {-sx * at.vx * at.vy + cx * at.ay + cx * at.vx * at.vx + sx * at.ax, 0.0, cx * at.vy + 2.0 * sx * at.vx, cx * at.vx};
  for (Eigen::Index k = 0; k < 2 * n; ++k) {
    const Eigen::Index place = k < 2 ? k : k >= n && k < n + 2 ? k - n + 2 : -1;
    CHECK_THAT(dc(0, k), WithinAbs(place < 0 ? 0.0 : -of_circle[place], rounding));
    CHECK_THAT(dc(1, k), WithinAbs(place < 0 ? 0.0 : -2.0 * of_circle[place], rounding));
    CHECK_THAT(dc(2, k), WithinAbs(place < 0 ? 0.0 : -of_blade[place], rounding));
  }

  Column lambda(3);
  lambda[0] = 0.3;
  lambda[1] = -0.2;
  lambda[2] = 1.7;
  rows.add_slopes_of_reactions(at.t, q, v, lambda, z, dr);
  const double along = 2.0 * lambda[0] + 4.0 * lambda[1];
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index k = 0; k < 2 * n; ++k) {
      double expected = i == k && i < 2 ? along : 0.0;
      if (k == 0 && i < 2) expected += lambda[2] * (i == 0 ? sx : cx);
      CHECK_THAT(dr(i, k), WithinAbs(expected, rounding));
    }
}

}  // namespace

TEST_CASE("rows of two coordinates are what they are by hand, of positions and of velocities") { check_rows<2>(); }
TEST_CASE("rows of nine coordinates, more than numbers have directions at once, are the same") { check_rows<9>(); }
