// SPDX-License-Identifier: MIT
//
// L D Lᵀ by rows, in a band and along a tree: b is made from a known x.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "catch2_bridge.hpp"
#include "qdot/mechanics/equations/sparse_factors.hpp"

using namespace qdot;

namespace {

constexpr double rounded = 1e-13;  // of a well-conditioned matrix: some hundred rounding units

struct Entries {
  std::size_t size;
  std::vector<int> rows{}, columns{};
  std::vector<double> values{};
  void add(int i, int j, double value) {
    rows.push_back(i), columns.push_back(j), values.push_back(value);
  }
};

Entries full(int n) {
  Entries A{static_cast<std::size_t>(n)};
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= i; ++j) A.add(i, j, i == j ? n : std::cos(3.1 * i + j));
  return A;
}

// Bodies on m × m places with springs to their neighbours.
Entries net(int m) {
  Entries A{static_cast<std::size_t>(m) * static_cast<std::size_t>(m)};
  for (int i = 0; i < m * m; ++i) {
    if (i >= m) A.add(i, i - m, -1.0);
    if (i % m > 0) A.add(i, i - 1, -1.0);
    A.add(i, i, 4.5);
  }
  return A;
}

double error_of_solution(const Entries& A) {
  std::vector<double> x(A.size), b(A.size, 0.0);
  for (std::size_t i = 0; i < A.size; ++i) x[i] = 1.0 + std::sin(static_cast<double>(i));
  for (std::size_t k = 0; k < A.values.size(); ++k) {
    const auto i = static_cast<std::size_t>(A.rows[k]), j = static_cast<std::size_t>(A.columns[k]);
    b[i] += A.values[k] * x[j];
    if (i != j) b[j] += A.values[k] * x[i];
  }
  detail::PatternFactors<> factors(A.size, A.rows, A.columns);
  double error = 0.0;
  for (int again = 0; again < 2; ++again) {
    std::vector<double> solution = b;
    if (!factors.compute([&](std::size_t k) { return A.values[k]; }, 1e-14)) return std::numeric_limits<double>::infinity();
    factors.solve(solution.data());
    for (std::size_t i = 0; i < A.size; ++i) error = std::max(error, std::abs(solution[i] - x[i]));
  }
  return error;
}

}  // namespace

TEST_CASE("full matrices of every size, and nets, have the solution that their right side was made from") {
  for (const int n : {1, 5, 24, 47, 48, 49, 52, 100}) {
    CAPTURE(n);
    CHECK(error_of_solution(full(n)) < rounded);
  }
  for (const int m : {2, 7, 12, 30}) {
    CAPTURE(m);
    CHECK(error_of_solution(net(m)) < rounded);
  }
}

TEST_CASE("a full matrix with a number that is not finite, or that is not positive, has no factors, at 48 as at 52 rows") {
  for (const int n : {48, 52}) {
    Entries A = full(n);
    detail::PatternFactors<> factors(A.size, A.rows, A.columns);
    const auto value = [&](std::size_t k) { return A.values[k]; };
    CHECK(factors.compute(value, 1e-14));
    A.values[7] = std::numeric_limits<double>::quiet_NaN();
    CHECK_FALSE(factors.compute(value, 1e-14));
    A = full(n);
    A.values.back() = -1.0;
    CHECK_FALSE(factors.compute(value, 1e-14));
  }
}
