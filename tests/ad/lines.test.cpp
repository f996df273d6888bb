// SPDX-License-Identifier: MIT
#include "qdot/ad/formula/lines.hpp"

#include <cmath>
#include <functional>
#include <vector>

#include "catch2_bridge.hpp"
#include "qdot/ad/formula/line_writer.hpp"

using namespace qdot;
using formula::Line;

namespace {

constexpr double rounded = 1e-15;  // of a few operations on numbers near 1

// Twelve variables, and formulas of them beside what they are in C++.
struct Formulas {
  static constexpr int inputs = 12;
  formula::BasicGraph<double> graph;
  std::vector<double> x;
  std::vector<int> v, outputs;
  std::vector<double> expected;

  Formulas() {
    for (int i = 0; i < inputs; ++i) {
      v.push_back(graph.variable(i));
      x.push_back(1.3 + 0.37 * std::sin(1.0 + 2.0 * i));
    }
  }
  void add(int node, double value) {
    outputs.push_back(node);
    expected.push_back(value);
  }

  // The largest miss of the lines of all outputs, written at once or one after the other.
  double missed(std::size_t at_once, std::size_t shortest_run = 4) const {
    formula::LineWriter<double> writer(graph, inputs, shortest_run);
    formula::LineTable table;
    for (std::size_t k = 0; k < outputs.size(); k += at_once)
      writer.write(std::vector<int>(outputs.begin() + static_cast<std::ptrdiff_t>(k),
                                    outputs.begin() + static_cast<std::ptrdiff_t>(std::min(outputs.size(), k + at_once))),
                   table);
    table.lines.emplace_back();
    std::vector<double> numbers(writer.count(), std::nan(""));
    std::copy(x.begin(), x.end(), numbers.begin());
    formula::carry_out(table, numbers.data());
    double worst = 0.0;
    for (std::size_t k = 0; k < outputs.size(); ++k) {
      const double miss = std::abs(numbers[static_cast<std::size_t>(writer.number(outputs[k]))] - expected[k]);
      worst = !(miss <= worst) ? miss : worst;
    }
    return worst;
  }
  // How many lines of some operation there are where all is written at once, and none is a run.
  std::size_t count(const std::function<bool(Line::Operation)>& is) const {
    formula::LineWriter<double> writer(graph, inputs, 1000);
    formula::LineTable table;
    writer.write(outputs, table);
    std::size_t number = 0;
    for (const Line& line : table.lines) number += is(line.operation) ? 1 : 0;
    return number;
  }
};

bool is_product(Line::Operation o) { return o == Line::Operation::product || o == Line::Operation::square; }

// Sums of a product and a number, and of two products, with these factors.
void add_sums(Formulas& f, int first, double ca, double cb) {
  const auto at = [&](int i) { return f.v[static_cast<std::size_t>((first + i) % Formulas::inputs)]; };
  const auto combination = [&](int a, double fa, int b, double fb) { return f.graph.sum(f.graph.scaled(a, fa), f.graph.scaled(b, fb)); };
  const auto x = [&](int i) { return f.x[static_cast<std::size_t>((first + i) % Formulas::inputs)]; };
  f.add(combination(f.graph.product(at(0), at(1)), ca, at(2), cb), ca * (x(0) * x(1)) + cb * x(2));
  f.add(combination(at(3), ca, f.graph.product(at(1), at(4)), cb), ca * x(3) + cb * (x(1) * x(4)));
  f.add(combination(f.graph.product(at(0), at(5)), ca, f.graph.product(at(2), at(4)), cb), ca * (x(0) * x(5)) + cb * (x(2) * x(4)));
  f.add(combination(f.graph.product(at(6), at(6)), ca, at(0), cb), ca * (x(6) * x(6)) + cb * x(0));
}

constexpr double factors[][2] = {{1.0, 1.0}, {1.0, -1.0}, {-1.0, 1.0}, {-1.0, -1.0}, {2.0, 1.0}, {1.0, -0.5}, {3.0, 0.25}};

}  // namespace

TEST_CASE("a product in one sum is part of the sum's line, whatever their factors") {
  Formulas f;
  for (const auto& [ca, cb] : factors) add_sums(f, 0, ca, cb);
  for (const std::size_t at_once : {std::size_t(1), std::size_t(3), f.outputs.size()}) CHECK(f.missed(at_once) < rounded);
}

TEST_CASE("sums of products that are alike are runs, evenly stepping or from a list") {
  for (const auto& [ca, cb] : factors) {
    CAPTURE(ca, cb);
    Formulas even, uneven;
    for (int i = 0; i < 5; ++i) add_sums(even, i, ca, cb);
    for (const int i : {0, 1, 3, 4, 8, 10}) add_sums(uneven, i, ca, cb);
    CHECK(even.missed(even.outputs.size()) < rounded);
    CHECK(uneven.missed(uneven.outputs.size()) < rounded);
    CHECK(uneven.missed(uneven.outputs.size(), 2) < rounded);
  }
}

TEST_CASE("a run ends where any of its four places steps otherwise") {
  Formulas f;
  const std::size_t places[] = {0, 1, 3, 7};
  for (std::size_t k = 0; k < 4; ++k) {
    const int even = f.graph.product(f.v[k], f.v[k + 4]), uneven = f.graph.product(f.v[places[k]], f.v[11]);
    f.add(f.graph.sum(even, uneven), f.x[k] * f.x[k + 4] + f.x[places[k]] * f.x[11]);
  }
  CHECK(f.missed(4, 2) < rounded);
  CHECK(f.missed(4, 4) < rounded);
}

TEST_CASE("alike sums of products with unlike factors have each its own") {
  Formulas f;
  for (int i = 0; i < 8; ++i) add_sums(f, i, 1.5 + i, -0.5 * i - 2.0);
  CHECK(f.missed(f.outputs.size()) < 16.0 * rounded);  // the factors are up to 9
}

TEST_CASE("a product that others ask for, too, has a line of its own, and only then") {
  Formulas f;
  const int product = f.graph.product(f.v[0], f.v[1]);
  const double value = f.x[0] * f.x[1];
  f.add(f.graph.sum(product, f.v[2]), value + f.x[2]);
  CHECK(f.count(is_product) == 0);
  SECTION("another sum") { f.add(f.graph.difference(product, f.v[3]), value - f.x[3]); }
  SECTION("a root") { f.add(f.graph.power(product, 0.5), std::sqrt(value)); }
  SECTION("an offset") { f.add(f.graph.sum(product, f.graph.constant(3.0)), value + 3.0); }
  SECTION("the user") { f.add(product, value); }
  CHECK(f.count(is_product) == 1);
  CHECK(f.missed(1) < 4.0 * rounded);
  CHECK(f.missed(2) < 4.0 * rounded);
}

TEST_CASE("a sum of many products has a line for two of them, and one for each other") {
  Formulas f;
  int sum = f.graph.product(f.v[0], f.v[1]);
  double value = f.x[0] * f.x[1];
  for (int i = 2; i < 12; i += 2) {
    sum = f.graph.sum(sum, f.graph.product(f.v[static_cast<std::size_t>(i)], f.v[static_cast<std::size_t>(i + 1)]));
    value += f.x[static_cast<std::size_t>(i)] * f.x[static_cast<std::size_t>(i + 1)];
  }
  f.add(sum, value);
  CHECK(f.count([](Line::Operation) { return true; }) == 5);
  CHECK(f.missed(1) < 16.0 * rounded);
}
