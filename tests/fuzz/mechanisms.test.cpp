// SPDX-License-Identifier: MIT
//
// Random trees of bodies move as Newton's and Euler's equations say, through both doors.
#include <algorithm>
#include <cmath>
#include <random>

#include "catch2_bridge.hpp"
#include "mechanism.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"
#include "qdot/mechanics/energy.hpp"
#include "qdot/mechanics/kinematic_system.hpp"
#include "qdot/mechanics/system.hpp"
#include "seed.hpp"

namespace {

using namespace qdot;
using fuzz::Real;
using fuzz::Reals;

// Rounding times the condition of M, which for random trees of up to nine bodies with masses from 1/7 to 7 reaches 1e5.
constexpr double rounded = 1e-10;
// A difference over 1e-6 in long double: truncation 1e-12 and rounding 1e-13 times the same.
constexpr double differenced = 1e-7;

template <int n>
Reals reals(const Vector<double, n>& x) {
  return Reals(x.data(), x.data() + x.size());
}

template <int n>
Vector<double, n> random_vector(fuzz::Random& random, Eigen::Index size, double largest) {
  Vector<double, n> x(size);
  for (Eigen::Index i = 0; i < size; ++i) x[i] = fuzz::uniform(random, -largest, largest);
  return x;
}

template <int n>
double difference(const Vector<double, n>& a, const Reals& exact) {
  double worst = 0.0, size = 1.0;
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    const auto e = static_cast<double>(exact[static_cast<std::size_t>(i)]);
    worst = std::isfinite(a[i]) ? std::max(worst, std::abs(a[i] - e)) : HUGE_VAL;
    size = std::max(size, std::abs(e));
  }
  return worst / size;
}

// ∂q̈/∂q and ∂q̈/∂q̇ by central differences of Newton's and Euler's equations.
template <int n>
double difference(const AccelerationJacobian<n>& J, const fuzz::Tree& tree, const Vector<double, n>& q, const Vector<double, n>& v) {
  double worst = 0.0;
  constexpr Real h = 1e-6L;
  for (const bool velocity : {false, true})
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      Reals x = reals<n>(q), w = reals<n>(v);
      Real& moved = (velocity ? w : x)[static_cast<std::size_t>(j)];
      const Real at = moved;
      moved = at + h;
      Reals slope = fuzz::accelerations_of(tree, x, w);
      moved = at - h;
      const Reals before = fuzz::accelerations_of(tree, x, w);
      for (std::size_t i = 0; i < slope.size(); ++i) slope[i] = (slope[i] - before[i]) / (2 * h);
      const Vector<double, n> column = velocity ? J.d_qdot.col(j) : J.d_q.col(j);
      worst = std::max(worst, difference<n>(column, slope));
    }
  return worst;
}

enum class Jacobian { too, not_here };
template <int n, Jacobian jacobian = Jacobian::too, class System>
void check(const System& system, const fuzz::Tree& tree, fuzz::Random& random, const char* door) {
  const auto size = static_cast<Eigen::Index>(tree.bodies.size());
  const Vector<double, n> q = random_vector<n>(random, size, 3.0), v = random_vector<n>(random, size, 2.0);
  INFO(fuzz::seed_text() << ", " << door << ", " << size << " bodies");
  const fuzz::TreeEquations exact = fuzz::equations_of(tree, reals<n>(q), reals<n>(v));
  CHECK(difference<n>(acceleration(system, q, v), fuzz::solved(exact.M, exact.rhs)) < rounded);
  Real T = 0;
  for (std::size_t i = 0; i < exact.M.size(); ++i)
    for (std::size_t j = 0; j < exact.M.size(); ++j) T += exact.M[i][j] * v[static_cast<Eigen::Index>(i)] * v[static_cast<Eigen::Index>(j)] / 2;
  CHECK_THAT(kinetic_energy(system, q, v), WithinRel(static_cast<double>(T), rounded));
  const auto V = static_cast<double>(fuzz::potential_of<Real>(tree, reals<n>(q)));
  CHECK_THAT(potential_energy(system, q), WithinAbs(V, rounded * (1.0 + std::abs(V))));
  if constexpr (jacobian == Jacobian::too) CHECK(difference<n>(acceleration_jacobian(system, q, v), tree, q, v) < differenced);
}

}  // namespace

TEST_CASE("random planar trees placed body by body move as Newton and Euler say") {
  fuzz::Random random(fuzz::seed());
  for (int sample = 0; sample < 30; ++sample) {
    const fuzz::Tree tree = fuzz::random_tree(random, 4, true, false);
    const auto system = kinematic_system<4>(fuzz::Places{tree, true}, uniform_gravity(tree.gravity[0], tree.gravity[1]));
    check<4, Jacobian::not_here>(system, tree, random, "planar bodies");
  }
}

TEST_CASE("random trees of up to nine bodies in space move as Newton and Euler say, through both doors") {
  fuzz::Random random(fuzz::seed() + 1);
  for (int sample = 0; sample < 30; ++sample) {
    const int n = std::uniform_int_distribution<int>(1, 9)(random);
    const fuzz::Tree tree = fuzz::random_tree(random, n, false, true);
    check<Dynamic>(mechanical_system(n, fuzz::Energies{tree}), tree, random, "T and V");
    check<Dynamic>(kinematic_system(n, fuzz::Places{tree}, fuzz::Potential{tree}), tree, random, "rigid bodies");
  }
}
