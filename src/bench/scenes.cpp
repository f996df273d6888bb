// SPDX-License-Identifier: MIT
//
// How much effects and constraints cost over what an expert writes for the same scene. Every row calls acceleration(), or
// constrained_acceleration() where there are constraints, as the steppers do. The last rows are Jacobians beside q̈ of the same scene.
#include "bench/scenes.hpp"

#include <cmath>
#include <cstddef>
#include <random>
#include <stdexcept>

#include "bench/bench.hpp"

namespace qdot::bench {

namespace {

// Both ways must agree before they are timed: times of different numbers say nothing.
void require_same_numbers(const SceneRow& row) {
  constexpr double rounded = 1e-9;  // times the condition of M; a wrong term is larger
  const EquationsRow& e = row.evaluation;
  if (e.baseline_name != "hand-derived") return;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> position(e.lowest, e.highest), velocity(-2.0, 2.0);
  const auto n = static_cast<std::size_t>(e.n), out = static_cast<std::size_t>(e.numbers_out);
  std::vector<double> q(n), v(n), a(out), b(out);
  for (int sample = 0; sample < 20; ++sample) {
    for (std::size_t i = 0; i < n; ++i) q[i] = position(random) + (e.middle ? e.middle(static_cast<int>(i)) : 0.0);
    for (double& x : v) x = velocity(random);
    e.baseline(q.data(), v.data(), a.data());
    e.measured(q.data(), v.data(), b.data());
    double size = 1.0, difference = 0.0;
    for (std::size_t i = 0; i < out; ++i) {
      size += std::abs(a[i]);
      difference += std::abs(a[i] - b[i]);
    }
    if (!(difference <= rounded * size))
      throw std::logic_error("bench scenes: both ways of a row must agree to rounding, but those of " + e.system + ", n = " + std::to_string(e.n) + ", " +
                             row.effect + " differ by " + std::to_string(difference / size) + "; one of them is wrong");
  }
}

Findings measured() {
  Findings findings;
  for (const auto rows_of :
       {system_scene_rows, body_scene_rows, unrolled_chain_scene_rows, looped_chain_scene_rows, placed_chain_scene_rows,
        hanging_chain_scene_rows, jacobian_scene_rows})
    for (const SceneRow& row : rows_of()) {
      require_same_numbers(row);
      findings.rows.push_back(timed(row.evaluation, row.effect));
      findings.rows.back().constraints = row.constraints;
      findings.rows.back().effect = row.effect;
    }
  findings.note = "q̈, and λ of constraints; 64 states (4 above n = 64) in turn, the least of up to 300 repeats in which both ways alternate.";
  return findings;
}

}  // namespace

Benchmark benchmark() { return {"scenes", "time of one q̈ with effects and constraints against the same derived by hand", measured}; }

}  // namespace qdot::bench
