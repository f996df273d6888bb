// SPDX-License-Identifier: MIT
//
// The scalar of Lagrange's equations against nested duals, which know nothing of its rules.
#include "catch2_bridge.hpp"

#include <cmath>
#include <random>

#include "qdot/mechanics/equations_of_motion.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/heavy_top.hpp"
#include "scenes/kepler.hpp"
#include "scenes/rod_and_ring.hpp"
#include "systems/shaken_pendulum.hpp"

using namespace qdot;

namespace {

// A hundred operations on numbers of order one to a hundred.
constexpr double rounded = 1e-12;

// The worst relative difference of M and X L from nested duals over random states near `centre`.
template <int n, class E>
double difference_from_nested_duals(const E& energies, const Vector<double, n>& centre) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-0.3, 0.3);
  double worst = 0.0;
  for (int sample = 0; sample < 20; ++sample) {
    Vector<double, n> q, v;
    for (int i = 0; i < n; ++i) {
      q[i] = centre[i] + uniform(random);
      v[i] = 4.0 * uniform(random);
    }
    const double t = uniform(random);
    const auto L = detail::euler_lagrange_of<n>(energies, q.data(), v.data(), t);
    const Matrix<double, n> M = detail::kinetic_hessian<n>(energies, q, v, t);
    const Vector<double, n> r = detail::lagrange_rhs<n>(energies, q, v, t);
    const double scale = 1.0 + M.cwiseAbs().maxCoeff() + r.cwiseAbs().maxCoeff();
    unroll<n>([&](auto i) { worst = std::max(worst, std::abs(L.template x<i>() - r[i]) / scale); });
    unroll<n*(n + 1) / 2>([&](auto k) {
      const double entry = M(detail::triangle_row(k), detail::triangle_column(k));
      worst = std::max(worst, std::abs(L.template h<k>() - entry) / scale);
    });
  }
  return worst;
}

// The functions of two arguments, by their place in this list: one type of energy for all of them.
constexpr int functions = 16;
template <class S>
S function_of(int which, const S& x, const S& y) {
  using std::abs, std::atan2, std::cos, std::exp, std::fma, std::hypot, std::log, std::max, std::min, std::pow, std::sin, std::sqrt, std::tan, std::tanh;
  switch (which) {
    case 0: return exp(x);
    case 1: return log(x);
    case 2: return sqrt(x);
    case 3: return sin(x);
    case 4: return cos(x);
    case 5: return tan(x);
    case 6: return tanh(x);
    case 7: return abs(x);
    case 8: return x / y;
    case 9: return atan2(x, y);
    case 10: return hypot(x, y);
    case 11: return pow(x, y);
    case 12: return pow(x, 3);
    case 13: return pow(x, 1.5);
    case 14: return max(x, y) * min(x, y);
    default: return fma(x, y, x);
  }
}

// A function of an argument that has every derivative there is, as an energy that is no physics.
struct EnergyOf {
  int which;
  template <class S>
  S T(const Vector<S, 1>& q, const Vector<S, 1>& v, const S& t) const {
    return function_of(which, S(0.3 + 0.1 * q[0] * v[0] + 0.1 * t * v[0] * v[0]), S(0.4 + 0.2 * q[0] - 0.1 * v[0]));
  }
  template <class S>
  S V(const Vector<S, 1>& q) const {
    return function_of(which, q[0], S(0.3));
  }
};

}  // namespace

TEST_CASE("the scalar of Lagrange's equations gives the M and the rhs of nested duals: the scenes") {
  CHECK(difference_from_nested_duals<2>(scenes::RodAndRing{}, {0.9, 0.4}) < rounded);
  CHECK(difference_from_nested_duals<2>(scenes::DoublePendulum{}, {0.9, 0.4}) < rounded);
  CHECK(difference_from_nested_duals<3>(scenes::HeavyTop{}, {1.3, 0.2, -0.4}) < rounded);
  CHECK(difference_from_nested_duals<2>(
            KineticAndPotential<decltype([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }),
                                decltype([](const auto& q) { return q[0] * q[1]; })>{}, {0.9, 0.4}) < rounded);
}

TEST_CASE("the scalar of Lagrange's equations gives the M and the rhs of nested duals: energies that know the time") {
  CHECK(difference_from_nested_duals<1>(systems::ShakenPendulum{}, Vector<double, 1>(0.4)) < rounded);
}

TEST_CASE("the scalar of Lagrange's equations knows the functions that duals know") {
  for (int which = 0; which < functions; ++which) {
    CAPTURE(which);
    CHECK(difference_from_nested_duals<1>(EnergyOf{which}, Vector<double, 1>(0.5)) < rounded);
  }
}

TEST_CASE("X of the velocity of a position is zero") {
  using S = detail::EulerLagrange<2>;
  const S q = S::coordinate<0>(0.7, 1.3), p = S::coordinate<1>(-0.2, 0.4);
  const S qdot = S::velocity<0>(1.3), pdot = S::velocity<1>(0.4);
  // x = q² sin p
  const S xdot = 2 * q * qdot * sin(p) + q * q * cos(p) * pdot;
  CHECK(std::abs(xdot.x<0>()) < rounded);
  CHECK(std::abs(xdot.x<1>()) < rounded);
}

TEST_CASE("the unrolled solution says when a pivot is not positive") {
  double definite[] = {4.0, 2.0, 5.0};
  double b[] = {8.0, 9.0};
  CHECK(detail::solved_in_place<2>(definite, b, 1e-14));
  CHECK(b[0] == 1.375);
  CHECK(b[1] == 1.25);
  double singular[] = {1.0, 1.0, 1.0};
  CHECK_FALSE(detail::solved_in_place<2>(singular, b, 1e-14));
  double indefinite[] = {0.0, 1.0, 0.0};
  CHECK_FALSE(detail::solved_in_place<2>(indefinite, b, 1e-14));
}
