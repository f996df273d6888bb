// SPDX-License-Identifier: MIT
//
// Members of an ensemble move as they do alone, and a member that cannot move says so without disturbing the others.
#include "catch2_bridge.hpp"

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>

#include "bench/chain_energies.hpp"
#include "qdot/mechanics/accelerations.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/heavy_top.hpp"
#include "scenes/kepler.hpp"
#include "scenes/rod_and_ring.hpp"

using namespace qdot;

namespace {

// Rounding of both, times the condition of M.
constexpr double rounded = 1e-12;

template <int n, int order = n == 1 ? int(Eigen::RowMajor) : int(Eigen::ColMajor)>
using Members = Eigen::Matrix<double, n, Dynamic, order>;

// Random states with q in (low, high), one in each column.
template <int n>
std::pair<Members<n>, Members<n>> random_members(int count, double low, double high) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> position(low, high), velocity(-2.0, 2.0);
  Members<n> q(n, count), qdot(n, count);
  for (int k = 0; k < count; ++k)
    for (int i = 0; i < n; ++i) {
      q(i, k) = position(random);
      qdot(i, k) = velocity(random);
    }
  return {q, qdot};
}

// The worst relative difference of a member's q̈ from its q̈ alone, over both orders in memory and over packs of 4 and 8. 19 members: the
// last pack is not full.
template <int n, class E>
double difference_from_single(const E& energies, double low, double high) {
  const auto system = mechanical_system<n>(energies);
  const auto [q, qdot] = random_members<n>(19, low, high);
  const Members<n, Eigen::RowMajor> q_rows = q, qdot_rows = qdot;
  const auto by_columns = accelerations(system, q, qdot);
  const auto by_rows = accelerations(system, q_rows, qdot_rows);
  CHECK(by_columns.failures.empty());
  CHECK(by_rows.failures.empty());
  double worst = 0.0;
  const auto compare = [&](const Vector<double, n>& a, const Vector<double, n>& alone) {
    const double difference = (a - alone).norm() / (1.0 + alone.norm());
    worst = difference <= worst ? worst : difference;  // NaN counts
  };
  for (int k = 0; k < q.cols(); ++k) {
    const Vector<double, n> alone = acceleration(system, Vector<double, n>(q.col(k)), Vector<double, n>(qdot.col(k)));
    compare(by_columns.qddot.col(k), alone);
    compare(by_rows.qddot.col(k), alone);
  }
  const auto pack_of = [&]<int lanes>(std::integral_constant<int, lanes>) {
    Vector<Pack<lanes>, n> x, v;
    for (int i = 0; i < n; ++i) {
      x[i] = Pack<lanes>::of([&](int lane) { return q(i, lane); });
      v[i] = Pack<lanes>::of([&](int lane) { return qdot(i, lane); });
    }
    const auto result = accelerations(system, x, v);
    CHECK(result.good.all());
    for (int lane = 0; lane < lanes; ++lane) {
      Vector<double, n> a;
      for (int i = 0; i < n; ++i) a[i] = result.qddot[i][lane];
      compare(a, by_columns.qddot.col(lane));
    }
  };
  pack_of(std::integral_constant<int, 4>{});
  pack_of(std::integral_constant<int, 8>{});
  return worst;
}

// A bead on a wire y = f(x) whose side counts: |x| must be chosen lane by lane.
struct BentWire {
  double g = 9.81;
  auto T(const auto& q, const auto& qdot) const { return 0.5 * qdot[0] * qdot[0] * (1.0 + q[0] * q[0]); }
  auto V(const auto& q) const {
    using qdot::select;
    return g * select(q[0] < 0.0, -q[0], 2.0 * q[0]);
  }
};

// Every function that packs know, in one energy that is no physics.
struct ManyFunctions {
  auto T(const auto& q, const auto& qdot) const {
    using std::exp, std::sqrt, std::cosh, std::atan2;
    return 0.5 * qdot[0] * qdot[0] * (2.0 + exp(-q[0]) + cosh(q[1])) + 0.5 * qdot[1] * qdot[1] * (3.0 + sqrt(q[0]) + atan2(q[0], q[1])) +
           0.1 * qdot[0] * qdot[1];
  }
  auto V(const auto& q) const {
    using std::log, std::tan, std::pow, std::abs, std::max, std::hypot;
    return log(q[0]) + tan(q[1]) + pow(q[0], 3) + pow(q[1], 1.5) + pow(q[0], 0.3) + abs(q[0] - q[1]) + max(q[0], 2.0 * q[1]) +
           hypot(q[0], q[1]);
  }
};

// A bead on a rod that loses its inertia at x = 0.
struct Fading {
  auto T(const auto& q, const auto& qdot) const { return 0.5 * q[0] * q[0] * qdot[0] * qdot[0] + 0.5 * qdot[1] * qdot[1]; }
  auto V(const auto& q) const { return 0.5 * q[1] * q[1]; }
};

}  // namespace

TEST_CASE("members of an ensemble accelerate as they do alone") {
  CHECK(difference_from_single<1>(bench::UnrolledChain<1>{}, -2.0, 2.0) < rounded);
  CHECK(difference_from_single<4>(bench::UnrolledChain<4>{}, -2.0, 2.0) < rounded);
  CHECK(difference_from_single<2>(scenes::DoublePendulum{}, -2.0, 2.0) < rounded);
  CHECK(difference_from_single<2>(scenes::RodAndRing{}, 0.3, 1.2) < rounded);
  CHECK(difference_from_single<2>(scenes::Kepler{}, 0.3, 1.2) < rounded);
  CHECK(difference_from_single<3>(scenes::HeavyTop{}, 0.3, 1.2) < rounded);
}

TEST_CASE("a functor with a loop, or one that branches, has an ensemble") {
  CHECK(difference_from_single<16>(bench::LoopedChain{}, -1.0, 1.0) < rounded);
  CHECK(difference_from_single<3>(bench::LoopedChain{}, -2.0, 2.0) < rounded);
  CHECK(difference_from_single<1>(BentWire{}, -2.0, 2.0) < rounded);
  CHECK(difference_from_single<2>(ManyFunctions{}, 0.3, 1.2) < rounded);
}

TEST_CASE("a member that fails is named with its error, and the others are right") {
  const auto system = mechanical_system<2>(Fading{}).with_names({"x", "y"});
  auto [q, qdot] = random_members<2>(11, 0.5, 1.5);
  q(0, 3) = 0.0;                                       // no inertia
  q(1, 9) = std::numeric_limits<double>::quiet_NaN();  // no state
  const auto result = accelerations(system, q, qdot);
  REQUIRE(result.failures.size() == 2);
  CHECK(result.failures[0].member == 3);
  CHECK_THROWS_AS(std::rethrow_exception(result.failures[0].error), SingularMassMatrix);
  CHECK(result.failures[0].message.find("the motion with velocity along x has no kinetic energy") != std::string::npos);
  CHECK(result.failures[1].member == 9);
  CHECK_THROWS_AS(std::rethrow_exception(result.failures[1].error), NonFinite);
  for (int k = 0; k < 11; ++k) {
    if (k == 3 || k == 9) {
      CHECK(std::isnan(result.qddot(0, k)));
      continue;
    }
    CHECK(result.qddot(0, k) == Approx(-qdot(0, k) * qdot(0, k) / q(0, k)).epsilon(rounded));
    CHECK(result.qddot(1, k) == Approx(-q(1, k)).epsilon(rounded));
  }
  Vector<Pack<4>, 2> x, v;
  for (int i = 0; i < 2; ++i) {
    x[i] = Pack<4>::of([&](int lane) { return q(i, lane); });
    v[i] = 1.0;
  }
  const auto pack = accelerations(system, x, v);
  for (int lane = 0; lane < 4; ++lane) CHECK(pack.good[lane] == (lane != 3));
}

TEST_CASE("arguments beyond the range of the fast functions are no failures") {
  const auto system = mechanical_system<1>(bench::UnrolledChain<1>{});
  Members<1> q = Members<1>::Constant(1, 5, 0.4), qdot = q;
  q(0, 1) = 3e7;
  const auto result = accelerations(system, q, qdot);
  CHECK(result.failures.empty());
  CHECK(result.qddot(0, 1) == Approx(-9.81 * std::sin(3e7)).epsilon(rounded));
  CHECK(result.qddot(0, 2) == Approx(-9.81 * std::sin(0.4)).epsilon(rounded));
}

TEST_CASE("sizes of an ensemble that disagree are refused") {
  const auto system = mechanical_system<2>(scenes::DoublePendulum{});
  const Members<2> q = Members<2>::Zero(2, 5), qdot = Members<2>::Zero(2, 4);
  CHECK_THROWS_WITH(accelerations(system, q, qdot).qddot,
                    "each row of qdot must have 5 entries, but has 4; give one column for each member, as in q");
}

TEST_CASE("the number of coordinates may be known at run time only") {
  const auto system = mechanical_system(2, scenes::DoublePendulum{});
  const auto [q, qdot] = random_members<2>(5, -2.0, 2.0);
  const Eigen::MatrixXd x = q, v = qdot;
  const auto result = accelerations(system, x, v);
  const auto fixed = accelerations(mechanical_system<2>(scenes::DoublePendulum{}), q, qdot);
  CHECK((result.qddot - fixed.qddot).norm() < rounded * (1.0 + fixed.qddot.norm()));
}
