// SPDX-License-Identifier: MIT
//
// Random trees of bodies under random constraints, against the whole matrix
//
//     ┌ M  −Jᵀ ┐ ┌ q̈ ┐   ┌ rhs ┐
//     └ J   0  ┘ └ λ  ┘ = └  γ  ┘
//
// solved in long double, with M and rhs of Newton's and Euler's equations and J and γ derived by hand.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "catch2_bridge.hpp"
#include "mechanism.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/scene_motion.hpp"
#include "seed.hpp"

namespace {

using namespace qdot;
using fuzz::Real;
using fuzz::Reals;
constexpr int n = 5;
using Vec = Vector<double, n>;

// φ = Σ aₖ sin(qₖ + wₖ t + cₖ) + d qᵢ qⱼ
struct Row {
  Vec a, w, c;
  double d = 0.0;
  int i = 0, j = 1;

  template <class S>
  S phi(const Vector<S, n>& q, const S& t) const {
    using std::sin;
    S sum = d * (q[i] * q[j]);
    for (int k = 0; k < n; ++k) sum = sum + a[k] * sin(q[k] + w[k] * t + c[k]);
    return sum;
  }
  Real slope(int k, const Vec& q, double t) const {
    const Real product = (k == i ? static_cast<Real>(q[j]) : 0) + (k == j ? static_cast<Real>(q[i]) : 0);
    return a[k] * std::cos(static_cast<Real>(q[k]) + static_cast<Real>(w[k]) * t + c[k]) + d * product;
  }
  // φ̈ where q̈ = 0
  Real bend(const Vec& q, const Vec& v, double t) const {
    Real sum = 2 * static_cast<Real>(d) * v[i] * v[j];
    for (int k = 0; k < n; ++k) {
      const Real rate = static_cast<Real>(v[k]) + w[k];
      sum -= a[k] * std::sin(static_cast<Real>(q[k]) + static_cast<Real>(w[k]) * t + c[k]) * rate * rate;
    }
    return sum;
  }
};

// a = Σ eₖ cos(q_{k+1}) q̇ₖ + f sin t
struct Skate {
  Vec e;
  double f = 0.0;

  template <class S>
  S of(const Vector<S, n>& q, const Vector<S, n>& v, const S& t) const {
    using std::cos, std::sin;
    S sum = f * sin(t);
    for (int k = 0; k < n; ++k) sum = sum + e[k] * (cos(q[(k + 1) % n]) * v[k]);
    return sum;
  }
  Real slope(int k, const Vec& q) const { return e[k] * std::cos(static_cast<Real>(q[(k + 1) % n])); }
  Real bend(const Vec& q, const Vec& v, double t) const {
    Real sum = f * std::cos(static_cast<Real>(t));
    for (int k = 0; k < n; ++k) sum -= e[k] * std::sin(static_cast<Real>(q[(k + 1) % n])) * v[(k + 1) % n] * v[k];
    return sum;
  }
};

Vec random_vector(fuzz::Random& random, double largest) {
  Vec x;
  for (int i = 0; i < n; ++i) x[i] = fuzz::uniform(random, -largest, largest);
  return x;
}

Row random_row(fuzz::Random& random) {
  return {random_vector(random, 1.0), random_vector(random, 1.0), random_vector(random, 3.0), fuzz::uniform(random, -1.0, 1.0),
          std::uniform_int_distribution<int>(0, n - 1)(random), std::uniform_int_distribution<int>(0, n - 1)(random)};
}

struct MechanismSamples {
  double acceleration = 0.0, reaction = 0.0, power = 0.0;
  bool ranks_are_right = true;
};

// Largest differences over random mechanisms. The third row is the first and a third of the second, plus an own one unless it `depends`.
MechanismSamples differences(std::uint64_t seed, bool depends) {
  fuzz::Random random(seed);
  MechanismSamples worst;
  for (int sample = 0; sample < 25; ++sample) {
    const fuzz::Tree tree = fuzz::random_tree(random, n, false, true);
    const std::array<Row, 3> rows{random_row(random), random_row(random), random_row(random)};
    const double own = depends ? 0.0 : 1.0;
    const std::size_t m = depends ? 3 : 4;  // independent rows: the skate's and two or three
    const Skate skate{random_vector(random, 1.0), fuzz::uniform(random, -1.0, 1.0)};
    const auto all = [rows, own](const auto& q, const auto& t) {
      const auto first = rows[0].phi(q, t), second = rows[1].phi(q, t);
      return vector(first, second, first + second / 3.0 + own * rows[2].phi(q, t));
    };
    const auto s = scene(mechanical_system<n>(fuzz::Energies{tree}), holonomic("rows", all),
                         nonholonomic("skate", [skate](const auto& q, const auto& v, const auto& t) { return skate.of(q, v, t); }));
    const Vec q = random_vector(random, 3.0), v = random_vector(random, 2.0);
    const double t = fuzz::uniform(random, 0.0, 5.0);

    const fuzz::TreeEquations free = fuzz::equations_of(tree, Reals(q.data(), q.data() + n), Reals(v.data(), v.data() + n));
    std::vector<Reals> K(n + m, Reals(n + m, 0));
    Reals right = free.rhs;
    std::vector<Reals> J(m);
    for (std::size_t r = 0; r < m; ++r) {  // the same space of rows: of the third its own part is enough
      for (int k = 0; k < n; ++k) J[r].push_back(r + 1 < m ? rows[r].slope(k, q, t) : skate.slope(k, q));
      right.push_back(-(r + 1 < m ? rows[r].bend(q, v, t) : skate.bend(q, v, t)));
    }
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) K[i][j] = free.M[i][j];
      for (std::size_t r = 0; r < m; ++r) {
        K[i][n + r] = -J[r][i];
        K[n + r][i] = J[r][i];
      }
    }
    const Reals exact = fuzz::solved(K, right);
    const auto solution = constrained_acceleration(s, q, v, t);
    const Vec force = reactions(s, q, v, t);
    double size = 1.0, strength = 1.0;
    for (std::size_t i = 0; i < n; ++i) size = std::max(size, static_cast<double>(std::abs(exact[i])));
    for (std::size_t r = 0; r < m; ++r) strength = std::max(strength, static_cast<double>(std::abs(exact[n + r])));
    Real work = 0;
    for (std::size_t i = 0; i < n; ++i) {
      Real reaction = 0;
      for (std::size_t r = 0; r < m; ++r) reaction += J[r][i] * exact[n + r];
      const auto k = static_cast<Eigen::Index>(i);
      worst.acceleration = std::max(worst.acceleration, std::abs(solution.qddot[k] - static_cast<double>(exact[i])) / size);
      worst.reaction = std::max(worst.reaction, std::abs(force[k] - static_cast<double>(reaction)) / strength);
      work += reaction * static_cast<Real>(v[k]);
    }
    worst.power = std::max(worst.power, std::abs(power(s, q, v, t) - static_cast<double>(work)) / strength);
    worst.ranks_are_right = worst.ranks_are_right && solution.rank == static_cast<Eigen::Index>(m);
  }
  return worst;
}

// Rounding times the condition of the whole, which random rows bring to 1e6.
constexpr double rounded = 1e-9;

}  // namespace

TEST_CASE("random mechanisms under random constraints move as the whole matrix says, with the same reactions") {
  const MechanismSamples worst = differences(fuzz::seed(), false);
  INFO(fuzz::seed_text() << ", differences " << worst.acceleration << ", " << worst.reaction);
  CHECK(worst.acceleration < rounded);
  CHECK(worst.reaction < rounded);
  CHECK(worst.power < 10 * rounded);  // five terms, velocities up to 2
  CHECK(worst.ranks_are_right);
}

TEST_CASE("a row that depends on others changes neither the motion nor the reactions") {
  const MechanismSamples worst = differences(fuzz::seed() + 1, true);
  INFO(fuzz::seed_text() << ", differences " << worst.acceleration << ", " << worst.reaction);
  CHECK(worst.acceleration < rounded);
  CHECK(worst.reaction < rounded);
  CHECK(worst.power < 10 * rounded);  // five terms, velocities up to 2
  CHECK(worst.ranks_are_right);
}
