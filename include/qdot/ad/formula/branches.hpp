#pragma once
// SPDX-License-Identifier: MIT
//
// The comparisons of a functor, at one place.
//
// A recording (ad/formula/recording.hpp) refuses a comparison, for a graph has no values. Given the values of its variables it answers instead, and
// notes what it was asked: each answer is a guard, a node whose sign decides. The graph is then that of one branch, and holds as long as all guards
// keep their signs. The same answers in the same order give the same branch elsewhere, too, and for other parameters.

#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "qdot/ad/formula/graph.hpp"

namespace qdot::formula {

/// A side of a level: sign · (value − level) > 0, or ≥ 0 where it is closed. NaN is on neither side.
struct Side {
  double sign = 1.0, level = 0.0;
  bool closed = false;

  bool is_side_of(const Side& other) const { return sign == other.sign && level == other.level && closed == other.closed; }
  bool has(double value) const {
    const double above = sign * (value - level);
    return above > 0.0 || (above == 0.0 && closed);
  }
};

/// What a branch needs: the side on which a node's value is.
struct Guard : Side {
  int node = -1;
  bool of_floor = false;
  std::string what = {};  ///< for messages: "the comparison < in T or V"
};

/// The guards of a recording that is given values.
struct Branches {
  std::vector<double> variables = {};            ///< by their numbers in the graph
  const std::vector<Guard>* answers = nullptr;   ///< to be given in this order, whatever the values are
  std::vector<Guard> met = {};                   ///< in the order of the comparisons
  std::vector<double> values = {};               ///< of the nodes so far
  bool read_values = false;                      ///< a functor asked for a value itself, which no guard holds
  std::string undecided = {};                    ///< a comparison with NaN, if there was one
};

/// The value of a node whose arguments have theirs, or its bounds where they are intervals.
template <class Value, class Number>
Value value_of_node(const BasicNode<Number>& node, const std::vector<Value>& variables, const std::vector<Value>& values) {
  using std::pow;
  const auto at = [&](int x) { return x < 0 ? Value(0.0) : values[static_cast<std::size_t>(x)]; };
  switch (node.kind) {
    case Kind::constant: return Value(node.c);
    case Kind::variable: return variables[static_cast<std::size_t>(node.a)];
    case Kind::affine: return node.b < 0 ? node.ca * at(node.a) + node.c : node.ca * at(node.a) + node.cb * at(node.b) + node.c;
    case Kind::product: return at(node.a) * at(node.b);
    case Kind::quotient: return at(node.a) / at(node.b);
    case Kind::power: return pow(at(node.a), node.c);
    case Kind::function: return value_of(node.function, at(node.a), at(node.b));
  }
  return Value(0.0);
}
/// values ← those of the first `count` nodes; nodes that have one already keep it.
template <class Number = double>
[[gnu::noinline]] void evaluate_nodes(const BasicGraph<Number>& graph, const std::vector<Number>& variables, std::vector<Number>& values, std::size_t count) {
  for (std::size_t i = values.size(); i < count; ++i) values.push_back(value_of_node(graph.nodes()[i], variables, values));
}

/// Whether a node's value is above a level, or at it, by the next of the given answers or by the value; noted as a guard.
template <class Number = double>
[[gnu::cold]] bool is_above(const BasicGraph<Number>& graph, Branches& branches, int node, Number level, bool or_equal, const std::string& what) {
  const std::size_t k = branches.met.size();
  bool answer = false;
  if (branches.answers != nullptr && k < branches.answers->size()) {
    answer = (*branches.answers)[k].sign > 0.0;
  } else {
    evaluate_nodes(graph, branches.variables, branches.values, static_cast<std::size_t>(node) + 1);
    const Number value = branches.values[static_cast<std::size_t>(node)];
    if (std::isnan(value) && branches.undecided.empty()) branches.undecided = what;
    answer = or_equal ? value >= level : value > level;
  }
  branches.met.push_back({{answer ? 1.0 : -1.0, level, or_equal == answer}, node, false, what});
  return answer;
}

/// ⌊node⌋ likewise, which two guards hold.
template <class Number = double>
[[gnu::cold]] Number floor_of(const BasicGraph<Number>& graph, Branches& branches, int node, const std::string& what) {
  const std::size_t k = branches.met.size();
  Number level = 0.0;
  if (branches.answers != nullptr && k < branches.answers->size()) {
    level = (*branches.answers)[k].level;
  } else {
    evaluate_nodes(graph, branches.variables, branches.values, static_cast<std::size_t>(node) + 1);
    level = std::floor(branches.values[static_cast<std::size_t>(node)]);
  }
  branches.met.push_back({{1.0, level, true}, node, true, what});
  branches.met.push_back({{-1.0, level + 1.0, false}, node, true, what});
  return level;
}

}  // namespace qdot::formula
