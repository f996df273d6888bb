// SPDX-License-Identifier: MIT
#include "qdot/effects/equations/one_constraint.hpp"

#include <cmath>
#include <random>

#include <Eigen/LU>

#include "catch2_bridge.hpp"
#include "qdot/ad/vector.hpp"

using namespace qdot;

namespace {

using Wide = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using WideVector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

constexpr double rounded = 1e-12;  // times the condition, which is below 100 here
constexpr double threshold = 1e-13;

// What a solution misses of M q̈ − Jᵀλ = r and J q̈ = γ, beside the largest number, by Gauss' elimination in long double.
double miss(const Wide& M, const WideVector& J, const WideVector& r, long double gamma, const double* qddot, double lambda) {
  const Eigen::Index n = M.rows();
  Wide K = Wide::Zero(n + 1, n + 1);
  K.topLeftCorner(n, n) = M;
  K.col(n).head(n) = -J;
  K.row(n).head(n) = J.transpose();
  WideVector right(n + 1);
  right << r, gamma;
  WideVector found(n + 1);
  for (Eigen::Index i = 0; i < n; ++i) found[i] = qddot[i];
  found[n] = lambda;
  const WideVector expected = K.fullPivLu().solve(right);
  return static_cast<double>((found - expected).norm() / (1.0L + expected.norm()));
}

struct OneOfTwo {
  double M[3], J[2], r[2], gamma;

  bool solve() {
    const detail::ComponentMask present = 5U | (M[1] != 0.0 ? 2U : 0U), mask = (J[0] != 0.0 ? 1U : 0U) | (J[1] != 0.0 ? 2U : 0U);
    return detail::solved_with_one_of_two(M, present, J, mask, r, gamma, threshold);
  }
  bool answered() { return solve() && std::isfinite(r[0] + r[1] + gamma); }
  double missed() {
    Wide whole(2, 2);
    whole << M[0], M[1], M[1], M[2];
    WideVector row(2), right(2);
    row << J[0], J[1];
    right << r[0], r[1];
    const double asked = gamma;
    REQUIRE(solve());
    return miss(whole, row, right, asked, r, gamma);
  }
};

}  // namespace

TEST_CASE("a constraint on two coordinates solves the three equations") {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> entry(-1.0, 1.0);
  for (int sample = 0; sample < 50; ++sample) {
    const double a = 1.5 + entry(random), b = 0.4 * entry(random), d = 1.5 + entry(random), u = entry(random), v = entry(random);
    const double x = entry(random), y = entry(random), g = entry(random);
    CHECK(OneOfTwo{{a, b, d}, {u, v}, {x, y}, g}.missed() < rounded);
    CHECK(OneOfTwo{{a, 0.0, d}, {u, v}, {x, y}, g}.missed() < rounded);
    CHECK(OneOfTwo{{a, 0.0, a}, {u, v}, {x, y}, g}.missed() < rounded);
    CHECK(OneOfTwo{{a, b, d}, {u, 0.0}, {x, y}, g}.missed() < rounded);
    CHECK(OneOfTwo{{a, b, d}, {0.0, v}, {0.0, y}, 0.0}.missed() < rounded);
    CHECK(OneOfTwo{{a, 0.0, a}, {0.0, v}, {x, 0.0}, 0.0}.missed() < rounded);
  }
}

TEST_CASE("a bob at the lowest point of its circle pulls with its weight and m v²/l") {
  constexpr double m = 2.0, g = 9.81, l = 0.5, v = 3.0, pull = m * g + m * v * v / l;
  double a[2], lambda;
  detail::solve_material_point({m, 1}, {0.0, 0}, {-l, 1}, {0.0, 0}, {-m * g, 1}, {-v * v, 1}, a, lambda);
  CHECK(a[0] == 0.0);
  CHECK(std::abs(a[1] - v * v / l) < rounded * pull);
  CHECK(std::abs(lambda + pull / l) < rounded * pull / l);
}

TEST_CASE("a material point of which m J Jᵀ is no number of double is left to others, and not brought to rest") {
  const auto solved = [](double m, double l) {
    double a[2], lambda = 0.0;
    return detail::solve_material_point({m, 1}, {0.0, 0}, {-l, 1}, {m, 1}, {-m, 1}, {0.0, 0}, a, lambda) && std::isfinite(a[0] + a[1] + lambda);
  };
  CHECK(solved(1e200, 1e30));
  CHECK_FALSE(solved(1e200, 1e60));
  CHECK_FALSE(solved(0.0, 1.0));
  CHECK_FALSE(solved(-1.0, 1.0));
  CHECK_FALSE(solved(1.0, 0.0));
}

TEST_CASE("two coordinates without inertia along some direction, or without a constraint, are left to others") {
  CHECK_FALSE(OneOfTwo{{1.0, 1.0, 1.0}, {1.0, 0.5}, {1.0, 2.0}, 0.3}.answered());
  CHECK_FALSE(OneOfTwo{{1.0, 2.0, 1.0}, {1.0, 0.5}, {1.0, 2.0}, 0.3}.answered());
  CHECK_FALSE(OneOfTwo{{-1.0, 0.5, -1.0}, {1.0, 0.5}, {1.0, 2.0}, 0.3}.answered());
  CHECK_FALSE(OneOfTwo{{1.0, 0.0, -2.0}, {1.0, 0.5}, {1.0, 2.0}, 0.3}.answered());
  CHECK_FALSE(OneOfTwo{{-2.0, 0.0, 1.0}, {1.0, 0.5}, {1.0, 2.0}, 0.3}.answered());
  CHECK_FALSE(OneOfTwo{{0.0, 0.0, 0.0}, {1.0, 0.5}, {1.0, 2.0}, 0.3}.answered());
  CHECK_FALSE(OneOfTwo{{-1.0, 0.0, -1.0}, {1.0, 0.5}, {1.0, 2.0}, 0.3}.answered());
  for (const double coupling : {0.0, 0.3}) {
    OneOfTwo none{{1.0, coupling, 1.0}, {0.0, 0.0}, {1.0, 2.0}, 0.3};
    CHECK_FALSE(none.answered());
  }
}

TEST_CASE("a multiplier is found with the last of three coordinates whose inertias are apart") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> entry(-1.0, 1.0);
  for (int sample = 0; sample < 50; ++sample)
    for (const unsigned mask : {7U, 6U, 5U, 4U, 3U, 2U, 1U})
      for (const unsigned some : {7U, 4U, 3U, 0U}) {
        double D[6] = {}, inverse[3], B[3] = {}, z[3] = {};
        Wide M = Wide::Zero(3, 3);
        WideVector J(3), r(3);
        for (int i = 0; i < 3; ++i) {
          const double d = 1.5 + entry(random), along = entry(random), force = entry(random);
          D[detail::triangle_index(i, i)] = d;
          inverse[i] = 1.0 / d;
          if (mask >> i & 1U) B[i] = along;
          if (some >> i & 1U) z[i] = force;
          M(i, i) = d;
          J[i] = B[i];
          r[i] = z[i];
        }
        const double asked = entry(random);
        double gamma = asked;
        detail::solve_with_multiplier<3>(D, inverse, B, mask, false, z, some, gamma);
        REQUIRE(miss(M, J, r, asked, z, gamma) < 100.0 * rounded);  // B may be small
      }
}

TEST_CASE("a constraint that rests has no multiplier, and changes nothing") {
  const double D[6] = {2.0, 0.0, 4.0, 0.0, 0.0, 5.0}, inverse[3] = {0.5, 0.25, 0.2}, B[3] = {0.0, 0.0, 0.0};
  double z[3] = {1.0, 2.0, 3.0}, gamma = 0.0;
  detail::solve_with_multiplier<3>(D, inverse, B, 0U, true, z, 7U, gamma);
  CHECK(gamma == 0.0);
  CHECK(z[0] == 0.5);
  CHECK(z[1] == 0.5);
  CHECK(std::abs(z[2] - 0.6) < 1e-15);
}
