#pragma once
// SPDX-License-Identifier: MIT
//
// The solution of M x = b as lines, or as nodes of a graph; and that of M q̈ − Jᵀλ = b, J q̈ = γ.
//
// Elimination is operations like those of M and r. It is M = L D Lᵀ as in mechanics/equations/small_solve.hpp and in the same order: two pivots at a
// time, and the last two rows by Cramer's rule. Written down it leaves out what is zero in this M and this b, and numbers need not go through memory
// between the two. There are no branches in it, so pivots are results that are looked at afterwards.
//
// As lines it has the bits of small_solve.hpp. As nodes it goes on with what is constant, and with what is known from elsewhere.

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "qdot/ad/formula/lines.hpp"

namespace qdot::detail {

/// Operations on numbers that come as lines, one behind the other.
class LinesOfNumbers {
  using Line = formula::Line;
  using Operation = Line::Operation;

 public:
  /// @param count  how many numbers there are before
  explicit LinesOfNumbers(std::size_t count) : count_(static_cast<std::uint32_t>(count)) {}

  std::vector<Line> lines;  ///< without an end
  /// How many numbers there are with these lines.
  std::size_t count() const { return count_; }

  int inverse(int a) { return add(Operation::inverse, a); }
  int sum(int a, int b) { return add(Operation::sum, a, b); }
  int product(int a, int b) { return add(Operation::product, a, b); }
  int quotient(int a, int b) { return add(Operation::quotient, a, b); }
  int negative_product(int a, int b) { return add(Operation::scaled, product(a, b)); }
  int less_product(int x, int a, int b) { return add(Operation::less_product, a, b, x); }
  int plus_product(int x, int a, int b) { return add(Operation::product_sum, a, b, x); }
  int products_difference(int a, int b, int d, int e) { return add(Operation::products_difference, a, b, d, e); }

 private:
  [[gnu::cold, gnu::noinline]] int add(Operation operation, int a, int b = 0, int d = 0, int e = 0) {
    Line line{operation, formula::Function::none, count_, static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b)};
    line.d = static_cast<std::uint32_t>(d);
    line.e = static_cast<std::uint32_t>(e);
    line.ca = -1.0;  // of −a + c, where −0 adds nothing
    line.c = -0.0;
    lines.push_back(line);
    return static_cast<int>(count_++);
  }

  std::uint32_t count_;
};

/// The same operations on nodes of a graph.
template <class Graph>
struct NodesOfGraph {
  Graph& graph;

  int inverse(int a) { return graph.quotient(graph.constant(1.0), a); }
  int sum(int a, int b) { return graph.sum(a, b); }
  int product(int a, int b) { return graph.product(a, b); }
  int quotient(int a, int b) { return graph.quotient(a, b); }
  int negative_product(int a, int b) { return graph.scaled(graph.product(a, b), -1.0); }
  int less_product(int x, int a, int b) { return graph.difference(x, graph.product(a, b)); }
  int plus_product(int x, int a, int b) { return graph.sum(x, graph.product(a, b)); }
  int products_difference(int a, int b, int d, int e) { return graph.difference(graph.product(a, b), graph.product(d, e)); }
};

/// Factors M, and solves for some right sides. In what it takes and gives, −1 stands for zero.
///
/// @tparam Numbers  what its numbers are, and how they are computed with: LinesOfNumbers or NodesOfGraph
template <class Numbers>
class Elimination {
 public:
  /// @param mass  lower triangle of M, row by row
  /// @param n     rows of M
  [[gnu::cold]] Elimination(Numbers& numbers, const std::vector<int>& mass, std::size_t n)
      : numbers_(numbers), n_(static_cast<int>(n)), last_(n_ > 1 ? n_ - 2 : 0), M_(mass), factors_(mass.size(), none) {
    for (int k = 0; k < n_; ++k) {
      if (entry(k, k) == none) return;
      diagonal_.push_back(entry(k, k));
    }
    inverse_.assign(n, none);
    for (int k = 0; k < last_; ++k) {
      if (k % 2 == 0) invert(k, k + 1 < last_);
      for (int i = k + 1; i < n_; ++i) eliminate(i, k);
    }
    factor_last(last_);
    exists_ = true;
  }

  std::vector<std::pair<int, int>> pivots;  ///< of which the first of each pair must be above a fraction of the second
  /// Whether M has a number on each place of its diagonal; otherwise there is no solution.
  bool exists() const { return exists_; }

  /// M⁻¹ b.
  [[gnu::cold]] std::vector<int> solution(std::vector<int> b) {
    for (int k = 0; k < last_; ++k)
      for (int i = k + 1; i < n_; ++i) subtract(at(b, i), factor(i, k), at(b, k));
    solve_last(last_, b);
    for (int k = last_ - 1; k >= 0; --k) {
      for (int i = k + 1; i < n_; ++i) subtract(at(b, k), entry(i, k), at(b, i));
      scale(at(b, k), at(inverse_, k));
    }
    return b;
  }

 private:
  static constexpr int none = -1;

  static int& at(std::vector<int>& all, int k) { return all[static_cast<std::size_t>(k)]; }
  [[gnu::cold, gnu::noinline]] int& entry(int i, int j) { return at(M_, i * (i + 1) / 2 + j); }
  [[gnu::cold, gnu::noinline]] int& factor(int i, int j) { return at(factors_, i * (i + 1) / 2 + j); }

  // x ← x − a b, and x ← x a.
  [[gnu::cold, gnu::noinline]] void subtract(int& x, int a, int b) {
    if (a != none && b != none) x = x == none ? numbers_.negative_product(a, b) : numbers_.less_product(x, a, b);
  }
  void scale(int& x, int a) {
    if (x != none) x = numbers_.product(x, a);
  }

  // a c − b² of rows k and k + 1.
  [[gnu::cold, gnu::noinline]] int determinant(int k) {
    const int a = entry(k, k), b = entry(k + 1, k), d = numbers_.products_difference(a, entry(k + 1, k + 1), b, b);
    pivots.emplace_back(d, numbers_.product(a, at(diagonal_, k + 1)));
    return d;
  }

  // The inverses of the pivots of row k and, of two, k + 1.
  [[gnu::cold, gnu::noinline]] void invert(int k, bool two) {
    pivots.emplace_back(entry(k, k), at(diagonal_, k));
    at(inverse_, k) = numbers_.inverse(entry(k, k));
    if (!two) return;
    if (entry(k + 1, k) != none) {
      at(inverse_, k + 1) = numbers_.quotient(entry(k, k), determinant(k));
    } else {
      pivots.emplace_back(entry(k + 1, k + 1), at(diagonal_, k + 1));
      at(inverse_, k + 1) = numbers_.inverse(entry(k + 1, k + 1));
    }
  }

  [[gnu::cold, gnu::noinline]] void eliminate(int i, int k) {
    if (entry(i, k) == none) return;
    const int l = factor(i, k) = numbers_.product(entry(i, k), at(inverse_, k));
    for (int j = k + 1; j <= i; ++j) subtract(entry(i, j), l, entry(j, k));
  }

  // Of the last row, or of the last two where they meet: one over the determinant.
  [[gnu::cold, gnu::noinline]] void factor_last(int k) {
    pivots.emplace_back(entry(k, k), at(diagonal_, k));
    if (n_ == 1) {
      at(inverse_, 0) = numbers_.inverse(entry(0, 0));
    } else if (entry(k + 1, k) == none) {
      pivots.emplace_back(entry(k + 1, k + 1), at(diagonal_, k + 1));
      for (const int i : {k, k + 1}) at(inverse_, i) = numbers_.inverse(entry(i, i));
    } else {
      at(inverse_, k) = numbers_.inverse(determinant(k));
    }
  }
  [[gnu::cold, gnu::noinline]] void solve_last(int k, std::vector<int>& b) {
    if (n_ == 1 || entry(k + 1, k) == none) {
      for (int i = k; i < n_; ++i) scale(at(b, i), at(inverse_, i));
      return;
    }
    const int between = entry(k + 1, k), first = at(b, k), second = at(b, k + 1);
    const auto solved = [&](int own, int weight, int other) {  // (own weight − other between) over the determinant
      if (own == none && other == none) return none;
      const int x = own == none     ? numbers_.negative_product(other, between)
                    : other == none ? numbers_.product(own, weight)
                                    : numbers_.products_difference(own, weight, other, between);
      return numbers_.product(x, at(inverse_, k));
    };
    at(b, k) = solved(first, entry(k + 1, k + 1), second);
    at(b, k + 1) = solved(second, entry(k, k), first);
  }

  Numbers& numbers_;
  int n_, last_;
  bool exists_ = false;
  std::vector<int> M_, factors_, diagonal_, inverse_;  // M as far as it is eliminated: below the diagonal L D; and L
};

/// q̈ with M q̈ − Jᵀλ = b and J q̈ = γ, as numbers.
struct ConstrainedAcceleration {
  std::vector<int> x;  ///< empty where M or J M⁻¹ Jᵀ has a zero on its diagonal
  std::vector<std::pair<int, int>> pivots, row_pivots;  ///< of M and of J M⁻¹ Jᵀ
  std::vector<int> lambda{};                            ///< where it is asked for
};

/// q̈ on one row J, where a = M⁻¹ b, w = M⁻¹ Jᵀ and S = J w:
///
///     S q̈_i = γ w_i + Σ_j J_j (a_i w_j − a_j w_i) .
///
/// With a − w (J a − γ)/S digits are lost where a light coordinate has a large a that the constraint takes away; here it drops out before it is computed.
template <class Numbers>
[[gnu::cold]] std::vector<int> on_one_row(Numbers& numbers, const std::vector<int>& a, const std::vector<int>& J, const std::vector<int>& w, int S, int gamma) {
  constexpr int none = -1;
  const auto product = [&](int x, int y) { return x == none || y == none ? none : numbers.product(x, y); };
  const auto sum = [&](int x, int y) { return x == none ? y : y == none ? x : numbers.sum(x, y); };
  std::vector<int> found;
  for (const int way : w) found.push_back(product(gamma, way));
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {  // a_i w_j − a_j w_i
      const bool first = a[i] != none && w[j] != none, second = a[j] != none && w[i] != none;
      if (!first && !second) continue;
      const int area = !second  ? numbers.product(a[i], w[j])
                       : !first ? numbers.negative_product(a[j], w[i])
                                : numbers.products_difference(a[i], w[j], a[j], w[i]);
      found[i] = sum(found[i], product(area, J[j]));
      if (J[i] != none) found[j] = found[j] == none ? numbers.negative_product(area, J[i]) : numbers.less_product(found[j], area, J[i]);
    }
  const int inverse = numbers.inverse(S);
  for (int& x : found) x = product(x, inverse);
  return found;
}

/// Solves M for b and for each row of J, and J M⁻¹ Jᵀ λ = γ − J M⁻¹ b where there are several. Without rows it is M⁻¹ b.
///
/// @param J  row by row
template <class Numbers>
[[gnu::cold]] ConstrainedAcceleration constrained_acceleration(Numbers& numbers, const std::vector<int>& mass, const std::vector<int>& b,
                                                               const std::vector<int>& J, std::vector<int> gamma, bool with_multipliers = false) {
  constexpr int none = -1;
  const std::size_t n = b.size(), m = gamma.size();
  Elimination of_mass(numbers, mass, n);
  if (!of_mass.exists()) return {};
  ConstrainedAcceleration found{of_mass.solution(b), std::move(of_mass.pivots), {}};
  const auto add = [&](int& to, int x, int y) {
    if (x != none && y != none) to = to == none ? numbers.product(x, y) : numbers.plus_product(to, x, y);
  };
  std::vector<int> ways, schur;  // M⁻¹ Jᵀ, column by column, and J M⁻¹ Jᵀ
  for (std::size_t k = 0; k < m; ++k) {
    const auto row = J.begin() + static_cast<std::ptrdiff_t>(k * n);
    const std::vector<int> way = of_mass.solution({row, row + static_cast<std::ptrdiff_t>(n)});
    ways.insert(ways.end(), way.begin(), way.end());
    for (std::size_t l = 0; l <= k; ++l) {
      int sum = none;
      for (std::size_t i = 0; i < n; ++i) add(sum, J[k * n + i], ways[l * n + i]);
      schur.push_back(sum);
    }
  }
  if (m == 0) return found;
  const auto subtract_row = [&](std::size_t k) {  // γ_k − J_k M⁻¹ b
    for (std::size_t i = 0; i < n; ++i) {
      const int j = J[k * n + i], a = found.x[i];
      if (j != none && a != none) gamma[k] = gamma[k] == none ? numbers.negative_product(j, a) : numbers.less_product(gamma[k], j, a);
    }
  };
  if (m == 1) {
    if (schur[0] == none) return {};
    if (with_multipliers) {
      const int given = gamma[0];
      subtract_row(0);
      found.lambda = {gamma[0] == none ? none : numbers.quotient(gamma[0], schur[0])};
      gamma[0] = given;
    }
    found.x = on_one_row(numbers, found.x, J, ways, schur[0], gamma[0]);
    found.row_pivots = {{schur[0], schur[0]}};
    return found;
  }
  for (std::size_t k = 0; k < m; ++k) subtract_row(k);
  Elimination of_rows(numbers, schur, m);
  if (!of_rows.exists()) return {};
  const std::vector<int> lambda = of_rows.solution(std::move(gamma));
  for (std::size_t k = 0; k < m; ++k)
    for (std::size_t i = 0; i < n; ++i) add(found.x[i], ways[k * n + i], lambda[k]);
  found.row_pivots = std::move(of_rows.pivots);
  if (with_multipliers) found.lambda = lambda;
  return found;
}

/// λ with M q̈ − Jᵀλ = b, where q̈ is known: J Jᵀ λ = −J (b − M q̈). Nothing where J Jᵀ has a zero on its diagonal.
template <class Numbers>
[[gnu::cold]] std::vector<int> multipliers_at(Numbers& numbers, const std::vector<int>& mass, const std::vector<int>& b, const std::vector<int>& J,
                                              const std::vector<int>& qddot) {
  constexpr int none = -1;
  const std::size_t n = b.size(), m = J.size() / n;
  std::vector<int> rest = b, rows(m, none), squares;
  const auto subtract = [&](int& from, int x, int y) {
    if (x != none && y != none) from = from == none ? numbers.negative_product(x, y) : numbers.less_product(from, x, y);
  };
  const auto add = [&](int& to, int x, int y) {
    if (x != none && y != none) to = to == none ? numbers.product(x, y) : numbers.plus_product(to, x, y);
  };
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) subtract(rest[i], mass[i < j ? j * (j + 1) / 2 + i : i * (i + 1) / 2 + j], qddot[j]);
  for (std::size_t k = 0; k < m; ++k) {
    for (std::size_t i = 0; i < n; ++i) subtract(rows[k], J[k * n + i], rest[i]);
    for (std::size_t l = 0; l <= k; ++l) {
      squares.push_back(none);
      for (std::size_t i = 0; i < n; ++i) add(squares.back(), J[k * n + i], J[l * n + i]);
    }
  }
  Elimination elimination(numbers, squares, m);
  return elimination.exists() ? elimination.solution(std::move(rows)) : std::vector<int>();
}

}  // namespace qdot::detail
