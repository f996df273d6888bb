#pragma once
// SPDX-License-Identifier: MIT
//
// M and r of systems with loops in their energies or with many coordinates: one pass of T and V that is
// recorded (ad/lagrange/graded.hpp), one sweep back (ad/records/hessian_record.hpp), and L D Lᵀ by blocks of four columns.
//
// As in mechanics/equations/straight_line.hpp, everything that could go wrong is left to the general way to look at again and to name.

#include <algorithm>

#include "qdot/ad/lagrange/euler_lagrange_math.hpp"
#include "qdot/mechanics/equations/energy_functors.hpp"
#include "qdot/mechanics/equations/moving_positions.hpp"
#include "qdot/mechanics/equations/straight_line.hpp"

namespace qdot::detail {

// Which n go this way (below, the general one is as fast), and the blocks of a row. The rows of a system of run-time size
// are as long as the largest that goes.
template <int n>
inline constexpr bool graded_pays = n == Dynamic || (n >= 1 && n <= 64);
template <int n>
inline constexpr int graded_limit = n == Dynamic ? 32 : 64;
template <int n>
inline constexpr int graded_blocks = ((n == Dynamic ? graded_limit<n> : n <= graded_limit<n> ? n : 1) + 3) / 4;

template <int n>
inline constexpr int graded_stride = 4 * graded_blocks<n>;

// b ← M⁻¹ b by L D Lᵀ, where M has rows of 4·blocks numbers, the lower triangle first; false when a pivot is below
// `threshold` of its diagonal entry or NaN. M becomes L, below its diagonal; 1/D is left in `inverse`.
template <int blocks>
bool solved_by_blocks(int n, double* M, double* b, double threshold, double* inverse) {
  constexpr int stride = 4 * blocks;
  double diagonal[stride];
  double column[4][stride];
  for (int k = 0; k < n; ++k) diagonal[k] = M[k * stride + k];
  for (int K = 0; 4 * K < n; ++K) {
    const int columns = std::min(4, n - 4 * K);
    for (int c = 0; c < columns; ++c) {
      const int k = 4 * K + c;
      const double pivot = M[k * stride + k];
      if (!(pivot > threshold * diagonal[k])) return false;
      inverse[k] = 1.0 / pivot;
      double* const below = column[c];
      for (int j = 4 * K; j <= k; ++j) below[j] = 0.0;
      for (int j = k + 1; j < n; ++j) below[j] = M[j * stride + k];
      for (int j = n; j < stride; ++j) below[j] = 0.0;
      for (int i = k + 1; i < n; ++i) {
        const double l = below[i] * inverse[k];
        add_block(M + i * stride + 4 * K, -l, below + 4 * K);
        M[i * stride + k] = l;
        b[i] -= l * b[k];
      }
    }
    for (int i = 4 * K + 4; i < n; ++i) {
      double* const row = M + i * stride;
      const double* const l = row + 4 * K;
      for (int J = K + 1; J <= i / 4; ++J) {
        Block m, c0, c1, c2, c3;
        read(m, row + 4 * J);
        read(c0, column[0] + 4 * J);
        read(c1, column[1] + 4 * J);
        read(c2, column[2] + 4 * J);
        read(c3, column[3] + 4 * J);
        m -= (l[0] * c0 + l[1] * c1) + (l[2] * c2 + l[3] * c3);
        write(row + 4 * J, m);
      }
    }
  }
  for (int k = 0; k < n; ++k) b[k] *= inverse[k];
  for (int i = n - 1; i > 0; --i)
    for (int k = 0; k < i; ++k) b[k] -= M[i * stride + k] * b[i];
  return true;
}

template <int blocks>
bool solved_by_blocks(int n, double* M, double* b, double threshold) {
  double inverse[4 * blocks];
  return solved_by_blocks<blocks>(n, M, b, threshold, inverse);
}

// M (rows of 4·blocks numbers) and X L.
template <int n, class E>
[[gnu::flatten]] void graded_equations(const E& e, const Vector<double, n>& q, const Vector<double, n>& qdot, double t, double* M, double* r) {
  constexpr int blocks = graded_blocks<n>;
  using S = Graded<HessianRecord<blocks>>;
  const int size = static_cast<int>(q.size());
  HessianRecord<blocks> record(size);
  Vector<S, n> x(size);
  Vector<S, n> v(size);
  for (int i = 0; i < size; ++i) {
    x[i] = S(q[i], qdot[i], 0.0, 1.0, 0.0, i, &record);
    v[i] = S(qdot[i], 0.0, 1.0, 0.0, 0.0, i, &record);
  }
  const S time(t, 1.0, 0.0, 0.0, 0.0, 0, nullptr);
  const S L = kinetic<n>(e, x, v, time) - potential<n>(e, x, time);
  record.equations(L.record != nullptr ? L.node : -1, L.a, L.b, L.w, M, r);
}

// The same, added to an M and an r that are there already.
template <int n, class E>
void add_graded_equations(const E& e, const double* q, const double* qdot, int size, double t, double* M, double* r) {
  constexpr int stride = 4 * graded_blocks<n>;
  double further_M[stride * stride], further_r[stride];
  const Eigen::Map<const Vector<double, n>> position(q, size), velocity(qdot, size);
  graded_equations<n>(e, Vector<double, n>(position), Vector<double, n>(velocity), t, further_M, further_r);
  for (int i = 0; i < size; ++i) {
    r[i] += further_r[i];
    for (int j = 0; j <= i; ++j) M[stride * i + j] += further_M[stride * i + j];
  }
}

// M and r, handed to use.template rows<blocks>(at, n, M, r), rows of 4·blocks numbers. False where `use` says so.
template <int n, class E, class Use>
bool graded_ways(const E& e, const Vector<double, n>& q, const Vector<double, n>& qdot, double t, const Use& use) {
  constexpr int blocks = graded_blocks<n>;
  double M[16 * blocks * blocks];
  double r[4 * blocks];
  graded_equations<n>(e, q, qdot, t, M, r);
  return use.template rows<blocks>(AtState{q.data(), qdot.data(), t}, static_cast<int>(q.size()), M, r);
}

}  // namespace qdot::detail
