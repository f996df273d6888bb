#pragma once
// SPDX-License-Identifier: MIT
//
// The sums of Runge–Kutta methods, Σ wⱼ kⱼ, unrolled, and what is made of them.
//
// The weights are known to the compiler, so that those which are zero are not in the program. Components are independent: four of them, or two, are added
// up by one instruction where the processor has one, in the order in which one alone would be. A step of Dop853 has some eighty such terms for each
// component, and its dense output fifty; of a small system they are most of what the method itself takes. A sum stays in registers until it is the next
// stage, for compilers differ in what they make of a loop over four numbers in memory. g++ -O3 unrolls it, -O2 does not, and a step of a cart with a
// pendulum took 1.27 times as long by -O2 as by -O3. Written so, it takes the same by both.

#include <Eigen/Core>
#include <cstddef>
#include <utility>

#include "qdot/ad/unroll.hpp"
#include "qdot/ad/vector.hpp"
#include "qdot/integrate/steps/fixed_step.hpp"

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

// Several components at once; in memory they are plain numbers. Of four in all g++ takes two at a time, which is a quarter faster with AVX.
#if defined(__AVX__)
inline constexpr int components_at_once = 4;
#else
inline constexpr int components_at_once = 2;  // of wider ones GCC keeps some in memory
#endif
#if defined(__clang__)
inline constexpr int least_of_fours = 4;
#else
inline constexpr int least_of_fours = 5;
#endif
template <int lanes>
using Components [[gnu::vector_size(static_cast<int>(sizeof(double)) * lanes)]] = double;

template <class C>
[[gnu::always_inline]] inline void read(C& components, const double* from) {
  __builtin_memcpy(&components, from, sizeof components);
}
// Reads numbers that a system has just stored one by one. A load of several waits until all of them have left the processor's store buffer, and
// compilers make one load of several. With AVX an evaluation took 1.4 to 1.8 times as long.
template <class C>
[[gnu::always_inline]] inline void read_one_by_one(C& components, const double* from) {
#if defined(__AVX__)
  if constexpr (sizeof(C) == 4 * sizeof(double)) {
    double a = from[0], b = from[1], c = from[2], d = from[3];
    asm("" : "+x"(a), "+x"(b), "+x"(c), "+x"(d));
    components = C{a, b, c, d};
    return;
  } else if constexpr (sizeof(C) == 2 * sizeof(double)) {
    double a = from[0], b = from[1];
    asm("" : "+x"(a), "+x"(b));
    components = C{a, b};
    return;
  }
#endif
  read(components, from);
}
template <class C>
[[gnu::always_inline]] inline void write(double* to, const C& components) {
  __builtin_memcpy(to, &components, sizeof components);
}

// Calls f<C>(i) for the n components i, i + 1, …, as many of them at once as fit into C. What is read as several must have been
// written as several: a processor waits for numbers that were stored one by one until they are in its cache. Few components are no loop:
// g++ -O2 leaves one of three turns as it is, and loads the weights anew in each.
template <int N, class F>
[[gnu::always_inline]] inline void in_components([[maybe_unused]] Eigen::Index n, const F& f) {
  if constexpr (N != Dynamic && N <= 8) {
    constexpr int fours = components_at_once == 4 && N >= least_of_fours ? N / 4 : 0, twos = (N - 4 * fours) / 2;
    unroll<fours>([&](auto k) __attribute__((always_inline)) { f.template operator()<Components<4>>(4 * k); });
    unroll<twos>([&](auto k) __attribute__((always_inline)) { f.template operator()<Components<2>>(4 * fours + 2 * k); });
    if constexpr (N % 2 == 1) f.template operator()<double>(N - 1);
  } else {
    Eigen::Index i = 0;
    if constexpr (components_at_once == 4)
      for (; i + 4 <= n; i += 4) f.template operator()<Components<4>>(i);
    for (; i + 2 <= n; i += 2) f.template operator()<Components<2>>(i);
    for (; i < n; ++i) f.template operator()<double>(i);
  }
}

// sum ← Σ wⱼ (kⱼ − k₁) over j > 1 for components from i on, zeros left out. k holds the differences.
template <class Row, class C, class K, std::size_t... j>
[[gnu::always_inline]] inline void weigh([[maybe_unused]] const K& k, [[maybe_unused]] Eigen::Index i, C& sum, std::index_sequence<j...>) {
  sum = C{};
  [[maybe_unused]] const auto add = [&](double weight, const double* from) __attribute__((always_inline)) {
    C component;
    read(component, from);
    sum += weight * component;
  };
  ((weight_in<Row, j + 1> != 0.0 ? add(weight_in<Row, j + 1>, &k(i, static_cast<Eigen::Index>(j + 1))) : void()), ...);
}

// difference ← f − first; up to six components of f come from the system one by one, eight often by several.
template <int N>
inline void write_difference(const double* f, const double* first, double* difference, Eigen::Index n) {
  in_components<N>(n, [&]<class C>(Eigen::Index i) __attribute__((always_inline)) {
    C a, b;
    if constexpr (N != Dynamic && N <= 6) read_one_by_one(a, f + i);
    else read(a, f + i);
    read(b, first + i);
    write(difference + i, a - b);
  });
}

// sum ← sum + factor · term.
template <int N>
[[gnu::always_inline]] inline void write_sum(double* sum, const double* term, double factor, Eigen::Index n) {
  in_components<N>(n, [&]<class C>(Eigen::Index i) __attribute__((always_inline)) {
    C a, b;
    read(a, sum + i);
    read(b, term + i);
    write(sum + i, a + factor * b);
  });
}

// sums ← factor Σ wⱼ (kⱼ − k₁).
template <class Row, class K>
inline void write_weighted_sums(const K& k, double factor, double* sums) {
  in_components<K::RowsAtCompileTime>(k.rows(), [&]<class C>(Eigen::Index i) __attribute__((always_inline)) {
    C sum;
    weigh<Row>(k, i, sum, typename Row::Others{});
    write(sums + i, factor * sum);
  });
}

// stage ← y + h (c k₁ + Σ wⱼ (kⱼ − k₁)), y with what its rounding lost.
template <class Row, class K>
inline void write_stage(const K& k, double c, double h, const double* y, const double* lost, double* stage) {
  in_components<K::RowsAtCompileTime>(k.rows(), [&]<class C>(Eigen::Index i) __attribute__((always_inline)) {
    C sum, first, base, rest;
    weigh<Row>(k, i, sum, typename Row::Others{});
    read(first, k.data() + i);
    read(base, y + i);
    read(rest, lost + i);
    write(stage + i, base + (h * (c * first + sum) + rest));
  });
}

// y_new, lost_new ← y + h (k₁ + Σ wⱼ (kⱼ − k₁) + d (k_s − k₁)), compensated; s is the column `last`.
template <class Row, class K>
inline void write_end(const K& k, double d, Eigen::Index last, double h, const double* y, const double* lost, double* y_new, double* lost_new) {
  in_components<K::RowsAtCompileTime>(k.rows(), [&]<class C>(Eigen::Index i) __attribute__((always_inline)) {
    C sum, first, bend, end, rest;
    weigh<Row>(k, i, sum, typename Row::Others{});
    read(first, k.data() + i);
    read(bend, &k(i, last));
    read(end, y + i);
    read(rest, lost + i);
    bend = sum + d * bend;
    add_compensated(end, rest, h * (first + bend));
    write(y_new + i, end);
    write(lost_new + i, rest);
  });
}

}  // namespace qdot::detail
