#pragma once
// SPDX-License-Identifier: MIT
//
// The comparisons of a functor, at one place.
//
// A recording (ad/formula/recording.hpp) refuses a comparison, for a graph has no values. Given the values of its variables it answers instead, and
// notes what it was asked: each answer is a guard, a node whose sign decides. The graph is then that of one branch, and holds as long as all guards
// keep their signs. The same answers in the same order give the same branch elsewhere, too, and for other parameters.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "qdot/ad/formula/graph.hpp"
#include "qdot/error.hpp"

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

// A loop that waits for a comparison may make guards without end: then there is no recording.
[[gnu::cold]] inline void require_few(const Branches& branches, const std::string& what) {
  const std::size_t most = 5000 + 50 * branches.variables.size();
  if (branches.met.size() >= most)
    throw NotAnalytic(detail::sentence({"functors that are recorded must compare at most ", most, " times, but ", what,
                                        " is met more often, as in a loop that waits for it; use Dop853, which takes them as they are"}),
                      what);
}

// The factor between two nodes that are the same up to their sign, 1 or −1; 0 of others.
template <class Number>
[[gnu::cold]] double sign_between(const BasicGraph<Number>& graph, int x, int y) {
  if (x == y) return 1.0;
  const auto &a = graph[x], &b = graph[y];
  if (a.kind == Kind::affine && b.kind == Kind::affine) return a.a == b.a && a.b == b.b && a.ca == -b.ca && a.cb == -b.cb && a.c == -b.c ? -1.0 : 0.0;
  const auto is_minus = [](const auto& node, int of) { return node.kind == Kind::affine && node.a == of && node.b < 0 && node.ca == -1.0 && node.c == 0.0; };
  return is_minus(a, y) || is_minus(b, x) ? -1.0 : 0.0;
}
// The side of a level on which a node is by the answers that were given before, 1 or −1; 0 where they do not say. A functor that asks twice, as sorting
// does, hears the same twice.
template <class Number>
[[gnu::cold]] double answered_side(const BasicGraph<Number>& graph, const Branches& branches, int node, double level) {
  const std::size_t given = branches.answers == nullptr ? 0 : branches.answers->size();
  for (std::size_t k = 0; k < std::min(given, branches.met.size()); ++k) {
    const Guard& guard = branches.met[k];
    const double sign = guard.of_floor ? 0.0 : sign_between(graph, guard.node, node);
    if (sign != 0.0 && sign * guard.level == level) return sign * guard.sign;
  }
  return 0.0;
}

/// Whether a node's value is above a level, or at it, by the next of the given answers or by the value; noted as a guard.
///
/// @throws NotAnalytic  there are too many guards
template <class Number = double>
[[gnu::cold]] bool is_above(const BasicGraph<Number>& graph, Branches& branches, int node, Number level, bool or_equal, const std::string& what) {
  require_few(branches, what);
  const std::size_t k = branches.met.size();
  bool answer = false;
  if (branches.answers != nullptr && k < branches.answers->size()) {
    answer = (*branches.answers)[k].sign > 0.0;
  } else if (const double side = answered_side(graph, branches, node, level); side != 0.0) {
    answer = side > 0.0;
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
  require_few(branches, what);
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
