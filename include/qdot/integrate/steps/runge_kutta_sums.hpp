#pragma once
// SPDX-License-Identifier: MIT
//
// The sums of Runge–Kutta methods, Σ wⱼ kⱼ, unrolled.
//
// The weights are known to the compiler, so that those which are zero are not in the program. Components do not know of each other: four of them, and two
// where fewer are left, are added up by one instruction where the processor has one, in the order in which one alone would be. A step of Dop853 has
// some eighty such terms for each component, and its dense output fifty; of a small system they are most of what the method itself takes.

#include <Eigen/Core>
#include <cstddef>
#include <utility>

#include "qdot/ad/vector.hpp"

namespace qdot::detail {

// The rows of the table C as types, so that their zeros are known where sums are unrolled. Nothing here depends on the system:
// the compiler writes it once for all systems of one size.
template <class C, int row>
struct StageRow {
  static constexpr auto weights = C::a[row];
  using Others = std::make_index_sequence<static_cast<std::size_t>(row - 1)>;
};
template <class C>
struct ErrorRow {
  static constexpr auto weights = C::e;
  using Others = std::make_index_sequence<static_cast<std::size_t>(C::stages)>;
};
template <class C>
struct LowErrorRow {
  static constexpr auto weights = C::e_low;
  using Others = std::make_index_sequence<static_cast<std::size_t>(C::stages)>;
};
template <class C, std::size_t row>
struct DenseRow {
  static constexpr auto weights = C::dense[row];
  using Others = std::make_index_sequence<static_cast<std::size_t>(C::total - 1)>;
};
template <class Row, std::size_t j>
inline constexpr double weight_in = Row::weights[j];

// Several components at once; in memory they are plain numbers.
template <int lanes>
using Components [[gnu::vector_size(static_cast<int>(sizeof(double)) * lanes)]] = double;

// Those from i on, as many as fit into C.
template <class Row, class C, class K, std::size_t... j>
[[gnu::always_inline]] inline void write_weighted_sum(const K& k, Eigen::Index i, double* sums, std::index_sequence<j...>) {
  C sum{};
  [[maybe_unused]] const auto add = [&](double weight, const double* from) __attribute__((always_inline)) {
    C component;
    __builtin_memcpy(&component, from, sizeof component);
    sum += weight * component;
  };
  ((weight_in<Row, j + 1> != 0.0 ? add(weight_in<Row, j + 1>, &k(i, static_cast<Eigen::Index>(j + 1))) : void()), ...);
  __builtin_memcpy(sums + i, &sum, sizeof sum);
}

// difference ← f − first, in the registers in which sums will read it: what is stored number by number is read late as several.
template <class C>
[[gnu::always_inline]] inline void write_difference_at(const double* f, const double* first, double* difference) {
  C a, b;
  __builtin_memcpy(&a, f, sizeof a);
  __builtin_memcpy(&b, first, sizeof b);
  a -= b;
  __builtin_memcpy(difference, &a, sizeof a);
}
template <int N>
[[gnu::always_inline]] inline void write_difference(const double* f, const double* first, double* difference, Eigen::Index n) {
  Eigen::Index i = 0;
  if constexpr (N == Dynamic || N >= 4)
    for (; i + 4 <= n; i += 4) write_difference_at<Components<4>>(f + i, first + i, difference + i);
  if constexpr (N == Dynamic || N % 4 >= 2)
    for (; i + 2 <= n; i += 2) write_difference_at<Components<2>>(f + i, first + i, difference + i);
  if constexpr (N == Dynamic || N % 2 == 1)
    for (; i < n; ++i) write_difference_at<double>(f + i, first + i, difference + i);
}

// Σ wⱼ (kⱼ − k₁) over j > 1 for all components, zeros left out.
template <class Row, class K>
inline void write_weighted_sums(const K& k, double* sums) {
  constexpr int N = K::RowsAtCompileTime;
  const Eigen::Index n = k.rows();
  Eigen::Index i = 0;
  using Others = typename Row::Others;
  if constexpr (N == Dynamic || N >= 4)
    for (; i + 4 <= n; i += 4) write_weighted_sum<Row, Components<4>>(k, i, sums, Others{});
  if constexpr (N == Dynamic || N % 4 >= 2)
    for (; i + 2 <= n; i += 2) write_weighted_sum<Row, Components<2>>(k, i, sums, Others{});
  if constexpr (N == Dynamic || N % 2 == 1)
    for (; i < n; ++i) write_weighted_sum<Row, double>(k, i, sums, Others{});
}

}  // namespace qdot::detail
