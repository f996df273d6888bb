#pragma once
// SPDX-License-Identifier: MIT
//
// Whether a formula is zero although it does not look like it.
//
// sin²φ + cos²φ depends on φ as a graph and not as a function. So the formula is evaluated at scattered points, and beside each value its *magnitude*:
// what the value would be if nothing were subtracted. A formula of analytic functions that is zero to the rounding of its magnitude at all of them
// cancels identically, but for coincidences that scattered numbers do not meet. A point that proves nothing is not counted: it has no value, or a
// magnitude that has underflown. Nor is a point at which a term of a sum would be lost in the rounding of another. Functions that become constant in
// floating point (tanh, erf) prove nothing at all.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "qdot/ad/formula/coefficient.hpp"
#include "qdot/ad/formula/graph.hpp"

namespace qdot::detail {

struct ValueAndMagnitude {
  double value = 0.0, magnitude = 0.0;
};

// All nodes up to `last` at these values of the variables, which are numbered as in the graph.
template <class Number>
std::vector<ValueAndMagnitude> values_of_graph(const formula::BasicGraph<Number>& graph, int last, const std::vector<double>& variables) {
  using formula::Kind;
  std::vector<ValueAndMagnitude> all;
  const auto at = [&](int node) { return node < 0 ? ValueAndMagnitude{} : all[static_cast<std::size_t>(node)]; };
  for (int w = 0; w <= last; ++w) {
    const auto& node = graph[w];
    const double ca = formula::decisive(node.ca), cb = formula::decisive(node.cb), c = formula::decisive(node.c);
    ValueAndMagnitude r;
    const ValueAndMagnitude a = node.kind == Kind::constant || node.kind == Kind::variable ? ValueAndMagnitude{} : at(node.a);
    const ValueAndMagnitude b = node.kind == Kind::constant || node.kind == Kind::variable ? ValueAndMagnitude{} : at(node.b);
    switch (node.kind) {
      case Kind::constant: r.value = c; break;
      case Kind::variable: r.value = variables[static_cast<std::size_t>(node.a)]; break;
      case Kind::affine: {
        const double second = node.b < 0 ? 0.0 : cb * b.value;
        const double of_second = node.b < 0 ? 0.0 : std::abs(cb) * b.magnitude;
        r = {ca * a.value + second + c, std::abs(ca) * a.magnitude + of_second + std::abs(c)};
        break;
      }
      case Kind::product: r = {a.value * b.value, a.magnitude * b.magnitude}; break;
      case Kind::quotient: r = {a.value / b.value, a.magnitude / std::abs(b.value)}; break;
      case Kind::power: r.value = std::pow(a.value, c); break;
      case Kind::function: r.value = formula::value_of(node.function, a.value, b.value); break;
    }
    r.magnitude = std::max(r.magnitude, std::abs(r.value));
    all.push_back(r);
  }
  return all;
}

// Scattered values of `count` variables, small ones and large ones, positive ones and others.
inline std::vector<double> scattered_point(std::size_t count, int sample) {
  constexpr double sizes[] = {1.0, 1.0, 0.01, 30.0};
  std::vector<double> x(count);
  for (std::size_t j = 0; j < count; ++j) {
    const double place = 0.6180339887498949 * (1.0 + 7.0 * sample + static_cast<double>(j) * (1.0 + 0.2360679774997897 * sample));
    const double unit = 0.25 + (place - std::floor(place));
    x[j] = sizes[sample % 4] * (sample % 8 < 4 || j % 2 == 0 ? unit : -unit);
  }
  return x;
}
inline constexpr int scattered_points = 16;

// Whether a sum of nodes is zero at all scattered points, of which half at least must say something.
template <class = void>  // compiled only where it is called
bool sum_vanishes(const formula::Graph& graph, const std::vector<int>& terms, std::size_t variables) {
  int last = -1;
  for (const int term : terms)
    if (!graph.is_constant(term, 0.0)) last = std::max(last, term);
  if (last < 0) return true;
  const std::vector<char> needed = graph.needed_for(terms);
  for (std::size_t w = 0; w < needed.size(); ++w) {
    const formula::Function f = graph.nodes()[w].function;
    if (needed[w] != 0 && (f == formula::Function::tanh || f == formula::Function::erf || f == formula::Function::erfc)) return false;
  }
  int said = 0;
  for (int sample = 0; sample < scattered_points; ++sample) {
    const std::vector<ValueAndMagnitude> all = values_of_graph(graph, last, scattered_point(variables, sample));
    ValueAndMagnitude sum;
    double least = std::numeric_limits<double>::infinity(), most = 0.0;
    for (const int term : terms) {
      if (graph.is_constant(term, 0.0)) continue;
      const ValueAndMagnitude x = all[static_cast<std::size_t>(term)];
      if (!std::isfinite(x.value) || !std::isfinite(x.magnitude) || x.magnitude < 1e-200) least = 0.0;
      if (std::abs(x.value) <= 1e-12 * x.magnitude) continue;  // zero by itself
      sum = {sum.value + x.value, sum.magnitude + x.magnitude};
      least = std::min(least, std::abs(x.value));
      most = std::max(most, std::abs(x.value));
    }
    if (!std::isfinite(sum.value) || !std::isfinite(sum.magnitude)) continue;
    if (std::abs(sum.value) > 1e-12 * sum.magnitude) return false;
    if (least > 1e-8 * most) ++said;
  }
  return 2 * said >= scattered_points;
}

// What a node is the sum of.
template <class = void>  // compiled only where it is called
std::vector<int> summands(formula::Graph& graph, int node, double factor = 1.0) {
  const auto made = graph[node];  // a copy: the graph grows
  if (made.kind != formula::Kind::affine) return {graph.scaled(node, factor)};
  std::vector<int> all = summands(graph, made.a, factor * made.ca);
  if (made.c != 0.0) all.push_back(graph.constant(factor * made.c));
  if (made.b >= 0) {
    const std::vector<int> more = summands(graph, made.b, factor * made.cb);
    all.insert(all.end(), more.begin(), more.end());
  }
  return all;
}

}  // namespace qdot::detail
