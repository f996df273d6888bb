#pragma once
// SPDX-License-Identifier: MIT
//
// Whether a formula is zero although it does not look like it.
//
// sin²φ + cos²φ depends on φ as a graph and not as a function. Who wants to know evaluates the formula at scattered points,
// and beside each value its *magnitude*: what the value would be if nothing were subtracted. A formula of analytic functions
// that is zero to the rounding of its magnitude at all of them cancels identically, but for coincidences that scattered
// numbers do not meet. Where a point proves nothing it is not counted: no value, or a magnitude that has underflown. Functions that
// become constant in floating point (tanh, erf) prove nothing at all.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "qdot/ad/formula/graph.hpp"

namespace qdot::detail {

struct ValueAndMagnitude {
  double value = 0.0, magnitude = 0.0;
};

// All nodes up to `last` at these values of the variables, which are numbered as in the graph.
inline std::vector<ValueAndMagnitude> values_of_graph(const formula::Graph& graph, int last, const std::vector<double>& variables) {
  using formula::Kind;
  std::vector<ValueAndMagnitude> all;
  const auto at = [&](int node) { return node < 0 ? ValueAndMagnitude{} : all[static_cast<std::size_t>(node)]; };
  for (int w = 0; w <= last; ++w) {
    const auto& node = graph[w];
    ValueAndMagnitude r;
    const ValueAndMagnitude a = node.kind == Kind::constant || node.kind == Kind::variable ? ValueAndMagnitude{} : at(node.a);
    const ValueAndMagnitude b = node.kind == Kind::constant || node.kind == Kind::variable ? ValueAndMagnitude{} : at(node.b);
    switch (node.kind) {
      case Kind::constant: r.value = node.c; break;
      case Kind::variable: r.value = variables[static_cast<std::size_t>(node.a)]; break;
      case Kind::affine: {
        const double second = node.b < 0 ? 0.0 : node.cb * b.value;
        const double of_second = node.b < 0 ? 0.0 : std::abs(node.cb) * b.magnitude;
        r = {node.ca * a.value + second + node.c, std::abs(node.ca) * a.magnitude + of_second + std::abs(node.c)};
        break;
      }
      case Kind::product: r = {a.value * b.value, a.magnitude * b.magnitude}; break;
      case Kind::quotient: r = {a.value / b.value, a.magnitude / std::abs(b.value)}; break;
      case Kind::power: r.value = std::pow(a.value, node.c); break;
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

// Whether a node is zero at all scattered points, of which half at least must say something.
inline bool vanishes(const formula::Graph& graph, int node, std::size_t variables) {
  if (graph.is_constant(node, 0.0)) return true;
  const std::vector<char> needed = graph.needed_for(std::vector<int>{node});
  for (std::size_t w = 0; w < needed.size(); ++w) {
    const formula::Function f = graph.nodes()[w].function;
    if (needed[w] != 0 && (f == formula::Function::tanh || f == formula::Function::erf || f == formula::Function::erfc)) return false;
  }
  int said = 0;
  for (int sample = 0; sample < scattered_points; ++sample) {
    const ValueAndMagnitude x = values_of_graph(graph, node, scattered_point(variables, sample)).back();
    if (!std::isfinite(x.value) || !std::isfinite(x.magnitude) || x.magnitude < 1e-200) continue;
    if (std::abs(x.value) > 1e-12 * x.magnitude) return false;
    ++said;
  }
  return 2 * said >= scattered_points;
}

}  // namespace qdot::detail
