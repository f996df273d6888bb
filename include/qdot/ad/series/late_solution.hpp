#pragma once
// SPDX-License-Identifier: MIT
//
// Lines that solve for the late variables of a sweep (ad/series/sweep.hpp), and for multipliers, by the factors of order 0:
//
//     M₀ = L D Lᵀ ,   B = L⁻¹ W₀ᵀ ,   S = Bᵀ D⁻¹ B = L' D' L'ᵀ
//
// Left out is what is zero for all states: entries of M and W, where elimination fills nothing in.

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "qdot/ad/series/line_list.hpp"
#include "qdot/ad/series/sweep_outputs.hpp"

namespace qdot::taylor {

/// Numbers of the late variables' coefficients, and of multipliers.
struct LateSolution {
  std::vector<std::uint32_t> late, multipliers;
};

/// v and mu from the right sides of M v − Wᵀ mu = v, W v = mu.
///
/// @param recurrence    with slots for nodes, −1 where an entry of M or W is always zero
/// @param mass_factors  the number of the first entry of L; row_factors that of D⁻¹B, behind which B and L' stand
[[gnu::cold]] inline LateSolution late_solution(LineList& lines, const Recurrence& recurrence, std::uint32_t mass_factors, std::uint32_t row_factors,
                                                std::vector<std::uint32_t> v, std::vector<std::uint32_t> mu) {
  using Number = std::uint32_t;
  const std::size_t n = v.size(), m = mu.size();
  const auto place = [](std::size_t i, std::size_t j) { return i * (i + 1) / 2 + j; };
  // Entries of L, of B and of L' that are not zero for all states: those of M and W, and what elimination fills in.
  const auto fill_in = [&](std::vector<char>& there, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i)
      for (std::size_t j = 0; j <= i; ++j)
        for (std::size_t k = 0; k < j; ++k)
          if (there[place(i, k)] && there[place(j, k)]) there[place(i, j)] = 1;
  };
  std::vector<char> in_L(n * (n + 1) / 2), in_B(m * n), in_S(m * (m + 1) / 2);
  for (std::size_t i = 0; i < in_L.size(); ++i) in_L[i] = recurrence.mass[i] >= 0;
  fill_in(in_L, n);
  for (std::size_t r = 0; r < m; ++r)
    for (std::size_t i = 0; i < n; ++i) {
      in_B[r * n + i] = recurrence.jacobian[r * n + i] >= 0;
      for (std::size_t j = 0; j < i; ++j)
        if (in_L[place(i, j)] && in_B[r * n + j]) in_B[r * n + i] = 1;
    }
  for (std::size_t r = 0; r < m; ++r)
    for (std::size_t l = 0; l <= r; ++l)
      for (std::size_t i = 0; i < n; ++i)
        if (in_B[r * n + i] && in_B[l * n + i]) in_S[place(r, l)] = 1;
  fill_in(in_S, m);

  const auto forward = [&](std::vector<Number>& x, const std::vector<char>& there, Number factors) {
    for (std::size_t i = 0; i < x.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (there[place(i, j)]) x[i] = lines.less_product(factors + static_cast<Number>(place(i, j)), x[j], x[i]);
  };
  const auto backward = [&](std::vector<Number>& x, const std::vector<char>& there, Number factors) {
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = lines.product(factors + static_cast<Number>(place(i, i)), x[i]);
    for (std::size_t i = x.size(); i-- > 0;)
      for (std::size_t j = 0; j < i; ++j)
        if (there[place(i, j)]) x[j] = lines.less_product(factors + static_cast<Number>(place(i, j)), x[i], x[j]);
  };
  const Number scaled_B = row_factors, B = scaled_B + static_cast<Number>(m * n), S = B + static_cast<Number>(m * n);
  forward(v, in_L, mass_factors);
  for (std::size_t r = 0; r < m; ++r)
    for (std::size_t i = 0; i < n; ++i)
      if (in_B[r * n + i]) mu[r] = lines.less_product(scaled_B + static_cast<Number>(r * n + i), v[i], mu[r]);
  forward(mu, in_S, S);
  backward(mu, in_S, S);
  for (std::size_t r = 0; r < m; ++r)
    for (std::size_t i = 0; i < n; ++i)
      if (in_B[r * n + i]) v[i] = lines.product_sum(B + static_cast<Number>(r * n + i), mu[r], v[i]);
  backward(v, in_L, mass_factors);
  return {std::move(v), std::move(mu)};
}

}  // namespace qdot::taylor
