// SPDX-License-Identifier: MIT
//
// Many members of one system at once against one after the other: q̈ of 256 states by accelerations(), which evaluates eight
// at once, beside 256 calls of acceleration().
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <limits>
#include <random>
#include <string>

#include "bench/bench.hpp"
#include "bench/chain_energies.hpp"
#include "qdot/mechanics/accelerations.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/heavy_top.hpp"
#include "scenes/kepler.hpp"
#include "scenes/rod_and_ring.hpp"

namespace qdot::bench {

namespace {

// One member in each column; of one row Eigen has only one order.
template <int n>
using Members = Eigen::Matrix<double, n, Dynamic, n == 1 ? int(Eigen::RowMajor) : int(Eigen::ColMajor)>;

template <int n, class E>
[[gnu::noinline]] void one_by_one(const System<E, n>& system, const Members<n>& q, const Members<n>& qdot, Members<n>& qddot) {
  for (Eigen::Index k = 0; k < q.cols(); ++k)
    qddot.col(k) = acceleration(system, Vector<double, n>(q.col(k)), Vector<double, n>(qdot.col(k)));
}

template <int n, class E>
void add_rows(std::vector<Row>& rows, const std::string& name, double lowest, double highest) {
  constexpr int count = 256;
  using MemberByMember = Members<n>;
  using CoordinateByCoordinate = Eigen::Matrix<double, n, Dynamic, Eigen::RowMajor>;
  const System<E, n> system = mechanical_system<n>(E{});
  std::mt19937 random(1);
  std::uniform_real_distribution<double> position(lowest, highest), velocity(-2.0, 2.0);
  MemberByMember q(n, count), qdot(n, count), qddot(n, count);
  for (Eigen::Index k = 0; k < count; ++k)
    for (Eigen::Index i = 0; i < n; ++i) {
      q(i, k) = position(random);
      qdot(i, k) = velocity(random);
    }
  const CoordinateByCoordinate q_rows = q, qdot_rows = qdot;
  CoordinateByCoordinate qddot_rows = qddot;

  double alone = std::numeric_limits<double>::infinity(), by_member = alone, by_coordinate = alone;
  std::size_t failures = 0;
  const auto shorten = [&](double& best, const auto& work) {
    const auto began = std::chrono::steady_clock::now();
    work();
    best = std::min(best, std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - began).count() / count);
  };
  for (int repeat = 0; repeat < 300; ++repeat) {
    shorten(alone, [&] { one_by_one(system, q, qdot, qddot); });
    shorten(by_member, [&] { failures += accelerations(system, q, qdot, 0.0, qddot).size(); });
    shorten(by_coordinate, [&] { failures += accelerations(system, q_rows, qdot_rows, 0.0, qddot_rows).size(); });
  }
  const std::string lost = failures == 0 ? "" : ", with failures";
  rows.push_back({name + ", ensemble, member by member" + lost, by_member, alone, "acceleration()", "ns"});
  rows.push_back({name + ", ensemble, coordinate by coordinate" + lost, by_coordinate, alone, "acceleration()", "ns"});
}

Findings measured() {
  Findings found;
  add_rows<1, UnrolledChain<1>>(found.rows, "chain n=1", -2.0, 2.0);
  add_rows<2, UnrolledChain<2>>(found.rows, "chain n=2", -2.0, 2.0);
  add_rows<3, UnrolledChain<3>>(found.rows, "chain n=3", -2.0, 2.0);
  add_rows<4, UnrolledChain<4>>(found.rows, "chain n=4", -2.0, 2.0);
  add_rows<2, scenes::DoublePendulum>(found.rows, "double_pendulum n=2", -2.0, 2.0);
  add_rows<2, scenes::RodAndRing>(found.rows, "rod_and_ring n=2", 0.3, 1.2);
  add_rows<2, scenes::Kepler>(found.rows, "kepler n=2", 0.3, 1.2);
  add_rows<3, scenes::HeavyTop>(found.rows, "heavy_top n=3", 0.3, 1.2);
  found.note = "ns for each state, 256 states in memory member by member or coordinate by coordinate, the least of 300 repeats in which "
               "all ways alternate";
  return found;
}

}  // namespace

Benchmark benchmark() {
  return {"ensemble", "time of q̈ of many states at once against one after the other", measured};
}

}  // namespace qdot::bench
