#pragma once
// SPDX-License-Identifier: MIT
//
// Accelerations and multipliers from M and J that are dense, for one right side or for four at once:
//
//     M q̈ − Jᵀλ = x ,    J q̈ = y
//
// With M = L D Lᵀ, B = L⁻¹Jᵀ and S = Bᵀ D⁻¹ B,
//
//     S λ = y − Bᵀ D⁻¹ L⁻¹ x ,     q̈ = L⁻ᵀ D⁻¹ (L⁻¹ x + B λ) .
//
// Loops over n are unrolled where the compiler knows n, so that what is worked on stays in registers. Rows of constraints are as many as there are.

#include <array>
#include <cstddef>
#include <type_traits>
#include <vector>

#include "qdot/ad/unroll.hpp"
#include "qdot/ad/vector.hpp"

namespace qdot::detail {

// f(0), f(1), … up to a size, or up to an index below which there are others: unrolled where the compiler knows it.
template <std::size_t size, class F>
[[gnu::always_inline]] inline void each(std::integral_constant<std::size_t, size>, const F& f) {
  unroll<static_cast<int>(size)>([&](auto i) __attribute__((always_inline)) { f(std::integral_constant<std::size_t, i>{}); });
}
template <class F>
[[gnu::always_inline]] inline void each(std::size_t size, const F& f) {
  for (std::size_t i = 0; i < size; ++i) f(i);
}

// As many numbers as the compiler knows, or as there are.
template <class Number, int count>
using Numbers = std::conditional_t<count == Dynamic, std::vector<Number>, std::array<Number, static_cast<std::size_t>(count == Dynamic ? 0 : count)>>;
template <class All>
All numbers_of([[maybe_unused]] std::size_t count) {
  if constexpr (requires { All(count); }) return All(count);
  else return All{};
}

// Four columns of a right side, as pairs, which every processor computes with at once.
struct FourColumns {
  using Two = double __attribute__((vector_size(16)));
  Two first, second;
};
[[gnu::always_inline]] inline void add(double& to, double factor, double what) { to += factor * what; }
[[gnu::always_inline]] inline void add(FourColumns& to, double factor, const FourColumns& what) {
  to.first += factor * what.first;
  to.second += factor * what.second;
}
[[gnu::always_inline]] inline void scale(double& x, double factor) { x *= factor; }
[[gnu::always_inline]] inline void scale(FourColumns& x, double factor) {
  x.first *= factor;
  x.second *= factor;
}

/// L D Lᵀ of M and S, for right sides that are numbers or four of them.
///
/// @tparam n_at_compile_time  n, or Dynamic; rows are as many as there are
template <int n_at_compile_time>
class DenseConstrainedFactors {
  static constexpr bool is_fixed = n_at_compile_time != Dynamic;
  using Size = std::conditional_t<is_fixed, std::integral_constant<std::size_t, static_cast<std::size_t>(is_fixed ? n_at_compile_time : 0)>, std::size_t>;

 public:
  template <class Number>
  using Upper = Numbers<Number, n_at_compile_time>;

  explicit DenseConstrainedFactors(std::size_t size = 0, std::size_t rows = 0)
      : m(rows), M(numbers_of<decltype(M)>(size * size)), J(rows * size), inverse_(numbers_of<Upper<double>>(size)), S_(rows * rows),
        inverse_S_(rows), whole_S_(rows) {
    if constexpr (!is_fixed) n = size;
  }

  Size n{};
  std::size_t m;
  Numbers<double, is_fixed ? n_at_compile_time * n_at_compile_time : Dynamic> M;  ///< row by row, of which the lower triangle is read; then L
  std::vector<double> J;                                                          ///< row by row; then B

  /// Sets M and factors it; false as below.
  template <class Mass>
  bool compute_mass(const Mass& mass, double threshold) {
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j <= i; ++j) M[i * n + j] = mass(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    return factored(n, M.data(), inverse_.data(), threshold);
  }
  /// False where a pivot of M is not above `threshold` of its diagonal entry, or one of S not above `dependent` of its own.
  [[gnu::always_inline]] bool compute(double threshold, double dependent) {
    return factored(n, M.data(), inverse_.data(), threshold) && compute_rows(dependent);
  }
  /// The second half of it.
  [[gnu::always_inline]] bool compute_rows(double dependent) {
    for (std::size_t k = 0; k < m; ++k) {
      double* const b = &J[k * n];
      each(n, [&](auto i) __attribute__((always_inline)) { each(i, [&](auto j) __attribute__((always_inline)) { b[i] -= M[i * n + j] * b[j]; }); });
      for (std::size_t l = 0; l <= k; ++l) {
        const double* const other = &J[static_cast<std::size_t>(l * n)];
        double sum = 0.0;
        each(n, [&](auto i) __attribute__((always_inline)) { sum += b[i] * inverse_[i] * other[i]; });
        S_[k * m + l] = sum;
      }
      whole_S_[k] = S_[k * m + k];
    }
    return factored(m, S_.data(), inverse_S_.data(), dependent);
  }

  /// The row with the smallest pivot of S, as a fraction of its diagonal entry: the first that is not above `dependent`, if one is not.
  struct Weakest {
    double pivot = 1.0;
    std::size_t row = 0;
  };
  Weakest weakest(double dependent) const {
    Weakest least;
    for (std::size_t k = 0; k < m && least.pivot > dependent; ++k)
      if (const double left = S_[k * m + k]; !(left > least.pivot * whole_S_[k])) least = {whole_S_[k] > 0.0 ? left / whole_S_[k] : 0.0, k};
    return least;
  }

  /// upper ← q̈ and lower ← λ, where M q̈ − Jᵀλ = upper and J q̈ = lower.
  template <class Number>
  [[gnu::always_inline]] void solve(Number* upper, Number* lower) const {
    forward(n, M.data(), upper);
    for (std::size_t k = 0; k < m; ++k) {
      Number& row = lower[k];
      each(n, [&](auto i) __attribute__((always_inline)) { subtract(row, J[k * n + i] * inverse_[i], upper[i]); });
    }
    if (m > 0) {
      forward(m, S_.data(), lower);
      backward(m, S_.data(), inverse_S_.data(), lower);
    }
    for (std::size_t k = 0; k < m; ++k)
      each(n, [&](auto i) __attribute__((always_inline)) { subtract(upper[i], -J[k * n + i], lower[k]); });
    backward(n, M.data(), inverse_.data(), upper);
  }
  /// Lower triangle, row by row: L, and on the diagonal 1/D.
  void write_mass_factors(double* to) const {
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j <= i; ++j) *to++ = i == j ? inverse_[i] : M[i * n + j];
  }
  /// D⁻¹B and B, row of J by row, then of S the lower triangle, row by row: its L, and on the diagonal its 1/D.
  void write_row_factors(double* to) const {
    for (std::size_t i = 0; i < m * n; ++i) *to++ = J[i] * inverse_[i % n];
    for (std::size_t i = 0; i < m * n; ++i) *to++ = J[i];
    for (std::size_t k = 0; k < m; ++k)
      for (std::size_t l = 0; l <= k; ++l) *to++ = k == l ? inverse_S_[k] : S_[k * m + l];
  }
  /// upper ← M⁻¹ upper.
  void solve_mass(double* upper) const {
    forward(n, M.data(), upper);
    backward(n, M.data(), inverse_.data(), upper);
  }

 private:
  template <class Number>
  [[gnu::always_inline]] static void subtract(Number& from, double factor, const Number& what) {
    if (is_fixed || factor != 0.0) add(from, -factor, what);
  }
  template <class Any>
  [[gnu::always_inline]] static bool factored(Any size, double* A, double* inverse, double threshold) {
    bool good = true;
    each(size, [&](auto i) __attribute__((always_inline)) {
      double* const row = A + i * size;
      const double whole = row[i];
      each(i, [&](auto j) __attribute__((always_inline)) {
        double sum = row[j];
        each(j, [&](auto k) __attribute__((always_inline)) { sum -= row[k] * A[j * size + k]; });
        row[j] = sum;  // l d
      });
      each(i, [&](auto j) __attribute__((always_inline)) {
        const double l = row[j] * inverse[j];
        row[i] -= l * row[j];
        row[j] = l;
      });
          good = good && row[i] > threshold * whole;
          inverse[i] = 1.0 / row[i];
        });
    return good;
  }
  template <class Any, class Number>
  [[gnu::always_inline]] static void forward(Any size, const double* L, Number* rows) {
    each(size, [&](auto i) __attribute__((always_inline)) { each(i, [&](auto j) __attribute__((always_inline)) { subtract(rows[i],
                                                                                                                          L[i * size + j], rows[j]); }); });
  }
  template <class Any, class Number>
  [[gnu::always_inline]] static void backward(Any size, const double* L, const double* inverse, Number* rows) {
    each(size, [&](auto i) __attribute__((always_inline)) { scale(rows[i], inverse[i]); });
    each(size, [&](auto above) __attribute__((always_inline)) {
      constexpr auto mirrored = [](auto whole, auto k) {
        if constexpr (std::is_same_v<decltype(whole), std::size_t>) return whole - 1 - k;
        else return std::integral_constant<std::size_t, whole - 1 - k>{};
      };
      const auto i = mirrored(size, above);
      each(i, [&](auto j) __attribute__((always_inline)) { subtract(rows[j], L[i * size + j], rows[i]); });
    });
  }

  Upper<double> inverse_;
  std::vector<double> S_, inverse_S_, whole_S_;  // the last: its diagonal before
};

}  // namespace qdot::detail
