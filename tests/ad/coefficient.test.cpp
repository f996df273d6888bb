// SPDX-License-Identifier: MIT
//
// Numbers that stand for parameters: what is told apart, what is one, and their values in an object.
#include "catch2_bridge.hpp"

#include <vector>

#include "qdot/ad/formula/coefficient.hpp"

using namespace qdot::formula;

namespace {

// Parameters 0, 1, … of a book.
std::vector<Coefficient> parameters_of(CoefficientBook& book, int count) {
  std::vector<Coefficient> p;
  for (int k = 0; k < count; ++k) p.push_back(book.parameter(k, shadow_of(k)));
  return p;
}

std::vector<double> values_of(const CoefficientBook& book, const std::vector<double>& parameters) {
  std::vector<double> values(book.steps().size());
  write_coefficients(book.steps().data(), static_cast<int>(book.steps().size()), parameters.data(), values.data());
  return values;
}

}  // namespace

TEST_CASE("a formula of parameters has the value that it has with numbers") {
  CoefficientBook book;
  const auto p = parameters_of(book, 3);
  const Coefficient x = (p[0] + 2.0 * p[1]) / p[2] - p[0] * p[1], y = -power_of(p[2], 0.5), z = power_of(p[1], -1.0) + power_of(p[0], 2.0);
  const auto v = values_of(book, {3.0, 5.0, 4.0});
  CHECK(v[static_cast<std::size_t>(x.line)] == 13.0 / 4.0 - 15.0);
  CHECK(v[static_cast<std::size_t>(y.line)] == -2.0);
  CHECK(v[static_cast<std::size_t>(z.line)] == 0.2 + 9.0);
}

TEST_CASE("what is zero or one for all parameters is a literal") {
  CoefficientBook book;
  const auto p = parameters_of(book, 4);
  CHECK((p[0] - p[0]).is(0.0));
  CHECK((0.0 * p[1]).is(0.0));
  CHECK(((p[0] + p[1]) - (p[1] + p[0])).is(0.0));
  CHECK(((p[0] + p[1] + p[2]) - p[1] - p[0] - p[2]).is(0.0));
  CHECK((p[0] * p[1] * p[2] - p[2] * p[1] * p[0]).is(0.0));
  CHECK((p[0] / (1.0 / p[1]) - p[0] * p[1]).is(0.0));
  CHECK((-p[3] + p[3]).is(0.0));
  CHECK(power_of(Coefficient(1.0), 0.3).is(1.0));
  CHECK(power_of(Coefficient(-2.0), -3.0).is(-0.125));
}

TEST_CASE("formulas of parameters that are not equal are not one: sums and differences of any four") {
  constexpr std::size_t count = 24;
  CoefficientBook book;
  const auto p = parameters_of(book, count);
  int confused = 0;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j <= i; ++j)
      for (std::size_t k = 0; k < i; ++k)
        for (std::size_t l = 0; l <= k; ++l) {
          if (k == j) continue;
          confused += are_alike(p[i] + p[j], p[k] + p[l]);
          if (i != j && k != l) confused += are_alike(p[i] - p[j], p[k] - p[l]);
        }
  CHECK(confused == 0);
}

TEST_CASE("roots of parameters are not added like parameters") {
  CoefficientBook book;
  const auto p = parameters_of(book, 2);
  const auto root = [](const Coefficient& x) { return power_of(x, 0.5); };
  CHECK(!are_alike(root(p[0]) + root(p[1]), root(p[0] + p[1])));
  CHECK(!are_alike(2.0 * root(p[0]), root(2.0 * p[0])));
  CHECK(!are_alike(power_of(p[0], 0.5), power_of(p[0], 1.5)));
  CHECK(root(p[0]).line == root(p[0]).line);
}

TEST_CASE("a summand that is small beside another is not lost") {
  CoefficientBook book;
  const auto p = parameters_of(book, 2);
  const Coefficient large = 6e24, sum = large + p[0], other = large + p[1], difference = p[0] - 1e-20 * p[1];
  CHECK(!sum.is_literal());
  CHECK(sum.line != other.line);
  CHECK(sum.line == (p[0] + large).line);
  CHECK(!(sum - large).is(0.0));
  const auto v = values_of(book, {1e24, 1e20});
  CHECK(v[static_cast<std::size_t>(sum.line)] == 6e24 + 1e24);
  CHECK(v[static_cast<std::size_t>(difference.line)] == 1e24 - 1e-20 * 1e20);
}

TEST_CASE("the magnitude of a line tells a difference of large numbers from a small number") {
  CoefficientBook book;
  const auto p = parameters_of(book, 2);
  const Coefficient rest = (p[0] + p[1]) * 3.0 - 3.0 * p[1] - p[0], small = p[0] * 2.0 / p[1];
  const auto values = values_of(book, {1e-16, 1.0});
  std::vector<double> magnitudes(values.size());
  write_magnitudes(book.steps().data(), static_cast<int>(values.size()), values.data(), magnitudes.data());
  CHECK(magnitudes[static_cast<std::size_t>(rest.line)] == Approx(6.0));
  CHECK(magnitudes[static_cast<std::size_t>(small.line)] == values[static_cast<std::size_t>(small.line)]);
}
