// SPDX-License-Identifier: MIT
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "../catch2_bridge.hpp"
#include "qdot/ad/formula/recording.hpp"
#include "qdot/ad/series/interiors.hpp"
#include "qdot/ad/series/sweep.hpp"

namespace {

using namespace qdot;
using formula::Recorded;
using formula::Recording;
using taylor::SeriesRows;
using taylor::Sweep;

// Of a sum of ten products of numbers below one, added in another order.
constexpr double rounding = 1e-14;

// Eleven lanes, of which the last three are weighted, and three squares, in rows 0 to 12.
SeriesRows rows_of_numbers() {
  SeriesRows rows;
  std::vector<std::uint32_t> left, right, squares;
  for (std::uint32_t i = 0; i < 11; ++i) {
    left.push_back(i);
    right.push_back(20 - i);
  }
  for (std::uint32_t i = 0; i < 3; ++i) squares.push_back(3 + i);
  rows.left.set(left, 12);
  rows.right.set(right, 12);
  rows.squares.set(squares, 12);
  rows.first_weighted = 8;
  for (std::size_t k = 1; k <= 12; ++k) {
    double x[21];
    for (int i = 0; i < 21; ++i) x[i] = std::sin(0.7 * i + 1.3 * static_cast<double>(k));
    write_rows(rows, k, x);
  }
  return rows;
}

double number(std::size_t place, std::size_t k) { return std::sin(0.7 * static_cast<double>(place) + 1.3 * static_cast<double>(k)); }

}  // namespace

TEST_CASE("an interior is the sum of the products of lower coefficients, for all widths of instructions with the same bits") {
  const SeriesRows rows = rows_of_numbers();
  for (std::size_t k = 1; k <= 12; ++k) {
    double by_twos[24], fastest[24];
    taylor::add_interiors_by_any(rows, k, by_twos);
    taylor::fastest_interiors()(rows, k, fastest);
    for (std::size_t lane = 0; lane < 11; ++lane) {
      long double sum = 0.0L;
      for (std::size_t j = 1; j < k; ++j)
        sum += static_cast<long double>(number(lane, j)) * (lane < 8 ? 1.0L : static_cast<long double>(j)) * static_cast<long double>(number(20 - lane, k - j));
      INFO("order " << k << ", lane " << lane);
      CHECK_THAT(by_twos[lane], WithinAbs(static_cast<double>(sum), 12 * rounding));
      CHECK(std::bit_cast<std::uint64_t>(by_twos[lane]) == std::bit_cast<std::uint64_t>(fastest[lane]));
    }
    for (std::size_t lane = 0; lane < 3; ++lane) {
      long double sum = 0.0L;
      for (std::size_t j = 1; j < k; ++j) sum += static_cast<long double>(number(3 + lane, j)) * static_cast<long double>(number(3 + lane, k - j));
      CHECK_THAT(by_twos[16 + lane], WithinAbs(static_cast<double>(sum), rounding));
      CHECK(std::bit_cast<std::uint64_t>(by_twos[16 + lane]) == std::bit_cast<std::uint64_t>(fastest[16 + lane]));
    }
  }
}

TEST_CASE("orders of a series by machine code have the bits of those by the interpreter") {
  constexpr int order = 15;
  Recording recording;
  const int t = recording.graph.variable(0);
  const Recorded s(recording, t);
  const int w = (sin(3.0 * s) * sqrt(1.0 + s * s) / (2.0 + cos(s)) + pow(1.5 + s, 1.5) - s * s * s).node_in(recording);
  Sweep sweep(recording.graph, {.early = {}, .series = {w, t}, .values = {}, .late = {}}, order);
  const auto coefficients = [&] {
    std::vector<std::uint64_t> bits;
    sweep.set(sweep.slot(t), 0.37);
    sweep.start();
    for (int k = 1; k <= order; ++k) {
      sweep.set(sweep.slot(t), k == 1 ? 1.0 : 0.0);
      sweep.advance(k);
      sweep.complete(k);
      bits.push_back(std::bit_cast<std::uint64_t>(sweep.latest(sweep.slot(w))));
    }
    return bits;
  };
  const auto interpreted = coefficients();
  const int expansions = 2 * static_cast<int>(formula::LineEvaluator::begin_after) / order;  // after half of them there is machine code
  for (int i = 0; i < expansions; ++i) CHECK(coefficients() == interpreted);
}

TEST_CASE("a recurrence solves for late variables with the factors of M, whose zeros are left out") {
  // Two coupled masses, T = ½ (2 v₀² + 2 v₀ v₁ + 3 v₁²), force F = (−q₀, −q₁), and a third one apart, with mass 4 and force −4 q₂:
  // M = [2 1 0; 1 3 0; 0 0 4]. q₂ = cos t from q₂ = 1, v₂ = 0.
  Recording recording;
  formula::Graph& graph = recording.graph;
  std::vector<int> q, v;
  for (int i = 0; i < 3; ++i) q.push_back(graph.variable(i));
  for (int i = 0; i < 3; ++i) v.push_back(graph.variable(3 + i));
  const std::vector<int> p = {graph.sum(graph.scaled(v[0], 2.0), v[1]), graph.sum(v[0], graph.scaled(v[1], 3.0)), graph.scaled(v[2], 4.0)};
  const std::vector<int> F = {graph.scaled(q[0], -1.0), graph.scaled(q[1], -1.0), graph.scaled(q[2], -4.0)};
  const std::vector<int> M = {graph.constant(2.0), graph.constant(1.0), graph.constant(3.0), graph.constant(0.0), graph.constant(0.0), graph.constant(4.0)};
  taylor::SweepOutputs outputs{.early = p, .series = F, .values = M, .late = v};
  outputs.series.insert(outputs.series.end(), q.begin(), q.end());
  outputs.recurrence = {.variables = q, .rates = v, .late = v, .forces = F, .momenta = p, .mass = M};
  constexpr int order = 10;
  Sweep sweep(graph, outputs, order);
  for (int i = 0; i < 3; ++i) {
    sweep.set(sweep.slot(q[static_cast<std::size_t>(i)]), 1.0);
    sweep.set(sweep.slot(v[static_cast<std::size_t>(i)]), 0.0);
  }
  sweep.start();
  sweep.set_time_unit(1.0);
  const double factors[] = {0.5, 0.5, 1.0 / 2.5, 0.0, 0.0, 0.25};  // L₁₀ = 1/2, D = (2, 5/2, 4)
  for (std::size_t i = 0; i < 6; ++i) sweep.mass_factors()[i] = factors[i];
  double factorial = 1.0;
  for (int k = 1; k <= order; ++k) {
    sweep.advance(k);
    factorial *= k;
    const double of_cosine = k % 2 != 0 ? 0.0 : (k % 4 == 0 ? 1.0 : -1.0) / factorial;
    CHECK_THAT(sweep.variable(sweep.slot(q[2])), WithinAbs(of_cosine, rounding));
    if (k == 1) {  // M v₁ = F: v₁ = −(2, 1)/5
      CHECK_THAT(sweep.variable(sweep.slot(v[0])), WithinAbs(-0.4, rounding));
      CHECK_THAT(sweep.variable(sweep.slot(v[1])), WithinAbs(-0.2, rounding));
    }
    sweep.complete(k);
  }
}

TEST_CASE("a recurrence with a row solves for its multiplier, one order behind") {
  // Two masses, 2 and 3, at ends of a rigid rod along x, each on a spring: F = (−q₀, −q₁), c = v₀ − v₁ = 0. From q = 1 at rest
  // q₀ = q₁ = cos ωt with ω² = 2/5, and λ = 2 q̈₀ + q₀ = cos(ωt)/5.
  Recording recording;
  formula::Graph& graph = recording.graph;
  const std::vector<int> q = {graph.variable(0), graph.variable(1)}, v = {graph.variable(2), graph.variable(3)};
  const std::vector<int> p = {graph.scaled(v[0], 2.0), graph.scaled(v[1], 3.0)}, F = {graph.scaled(q[0], -1.0), graph.scaled(q[1], -1.0)};
  const std::vector<int> M = {graph.constant(2.0), graph.constant(0.0), graph.constant(3.0)};
  const std::vector<int> W = {graph.constant(1.0), graph.constant(-1.0)}, c = {graph.difference(v[0], v[1])};
  taylor::SweepOutputs outputs{.early = p, .series = F, .values = M, .late = v};
  outputs.early.push_back(c[0]);
  outputs.series.insert(outputs.series.end(), q.begin(), q.end());
  outputs.values.insert(outputs.values.end(), W.begin(), W.end());
  outputs.recurrence = {.variables = q, .rates = v, .late = v, .forces = F, .momenta = p, .mass = M, .rows = c, .jacobian = W};
  constexpr int order = 9;
  Sweep sweep(graph, outputs, order);
  for (const int node : q) sweep.set(sweep.slot(node), 1.0);
  for (const int node : v) sweep.set(sweep.slot(node), 0.0);
  sweep.start();
  sweep.set_time_unit(1.0);
  const double of_M[] = {0.5, 0.0, 1.0 / 3.0};
  const double of_rows[] = {0.5, -1.0 / 3.0, 1.0, -1.0, 1.0 / (1.0 / 2.0 + 1.0 / 3.0)};  // D⁻¹B, B = Wᵀ, 1/S
  for (std::size_t i = 0; i < 3; ++i) sweep.mass_factors()[i] = of_M[i];
  REQUIRE(sweep.row_factors().size() == 5);
  for (std::size_t i = 0; i < 5; ++i) sweep.row_factors()[i] = of_rows[i];
  double power = 1.0;  // (−ω²)^(k/2) / k!
  const auto of_cosine = [&](int k) { return k % 2 != 0 ? 0.0 : power; };
  double before = 1.0;
  for (int k = 1; k <= order; ++k) {
    sweep.advance(k);
    CHECK_THAT(sweep.multiplier(0), WithinAbs(before / 5.0, rounding));
    if (k % 2 == 0) power *= -0.4 / (k * (k - 1));
    before = of_cosine(k);
    for (const int node : q) CHECK_THAT(sweep.variable(sweep.slot(node)), WithinAbs(before, rounding));
    sweep.complete(k);
  }
}
