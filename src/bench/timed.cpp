// SPDX-License-Identifier: MIT
//
// Two ways to q̈, timed in turn.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <limits>
#include <random>

#include "bench/eom.hpp"

namespace qdot::bench {

namespace {

struct Nanoseconds {
  double baseline = std::numeric_limits<double>::infinity();
  double measured = std::numeric_limits<double>::infinity();
};

// Time for one state of both functions over the same states, the least of many repeats in turn.
Nanoseconds times_of(const EquationsRow& row) {
  const std::size_t states = row.n <= 64 ? 64 : 4;  // long turns are interrupted by what else the machine does
  const int rounds = row.n <= 64 ? 4 : 1;
  constexpr double budget = 0.05;  // seconds for a row
  const auto n = static_cast<std::size_t>(row.n);
  const auto at_once = static_cast<std::size_t>(row.states);
  const std::size_t out = std::max(static_cast<std::size_t>(row.numbers_out), n * at_once);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> position(row.lowest, row.highest), velocity(-2.0, 2.0);
  std::vector<double> q(states * n), v(states * n), a(states * out);
  for (std::size_t i = 0; i < q.size(); ++i) q[i] = position(random) + (row.middle ? row.middle(static_cast<int>(i % n)) : 0.0);
  for (double& x : v) x = velocity(random);
  using Clock = std::chrono::steady_clock;
  const auto nanoseconds = [&](AccelerationFunction f, std::size_t states_of_call) {
    const auto began = Clock::now();
    for (int again = 0; again < rounds; ++again)
      for (std::size_t k = 0; k < states; k += states_of_call) f(&q[k * n], &v[k * n], &a[k * out / at_once]);
    return std::chrono::duration<double, std::nano>(Clock::now() - began).count() / static_cast<double>(static_cast<std::size_t>(rounds) * states);
  };
  Nanoseconds best;
  const auto began = Clock::now();
  for (int repeat = 0; repeat < 20 || (repeat < 300 && std::chrono::duration<double>(Clock::now() - began).count() < budget); ++repeat) {
    best.baseline = std::min(best.baseline, nanoseconds(row.baseline, 1));
    best.measured = std::min(best.measured, nanoseconds(row.measured, at_once));
  }
  return best;
}

}  // namespace

Row timed(const EquationsRow& row, const std::string& what) {
  const Nanoseconds time = times_of(row);
  return {.name = row.system + " n=" + std::to_string(row.n) + ", " + what,
          .value = time.measured,
          .baseline = time.baseline,
          .baseline_name = row.baseline_name,
          .unit = "ns",
          .system = row.system,
          .n = row.n,
          .door = row.door};
}

}  // namespace qdot::bench
