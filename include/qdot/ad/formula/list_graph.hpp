#pragma once
// SPDX-License-Identifier: MIT
//
// A list of operations as a graph.
//
// A list (ad/formula/trace_list.hpp) says what a user's energy does, in the order of doing. A graph (ad/formula/graph.hpp) can be differentiated and
// simplified. This header goes from one to the other, at run time or while compiling.
//
// Where the list has a value the graph remembers (ad/formula/domains.hpp).
//
// Arguments of calls that make nodes are made before, one by one: compilers differ in the order of arguments, and the order of nodes
// must not.

#include <cstddef>
#include <vector>

#include "qdot/ad/formula/domains.hpp"
#include "qdot/ad/formula/graph.hpp"
#include "qdot/ad/formula/trace.hpp"

namespace qdot::formula {

/// The node that is the result of a list.
///
/// @param graph      whose variables are the inputs of the list
/// @param is_known   set to false when an operation is not analytic, or not known here
/// @param number     of constant k, as a coefficient of the graph
template <class Coefficient, class List, class NumberOf>
constexpr int node_of_list(BasicGraph<Coefficient>& graph, const List& list, int inputs, bool& is_known, const NumberOf& number) {
  using trace::Operation;
  std::vector<int> made;
  const auto operand = [&](int i) -> int {
    if (i < 0) return graph.constant(number(-1 - i));
    if (i < inputs) return graph.variable(i);
    return made[static_cast<std::size_t>(i - inputs)];
  };
  const auto node = [&](trace::Step step) -> int {
    const int a = operand(step.a);
    if (step.operation == Operation::pow) {
      if (step.b < 0 && list.literal[-1 - step.b]) {
        restrict_to_power(graph, a, list.value[-1 - step.b]);
        return graph.power(a, list.value[-1 - step.b]);
      }
      is_known = false;
      return a;
    }
    const int b = has_two_operands(step.operation) ? operand(step.b) : -1;
    switch (step.operation) {
      case Operation::add: return graph.sum(a, b);
      case Operation::subtract: return graph.difference(a, b);
      case Operation::multiply: return graph.product(a, b);
      case Operation::divide: restrict_to(Domain::nonzero, graph, b); return graph.quotient(a, b);
      case Operation::negate: return graph.scaled(a, -1.0);
      case Operation::sqrt: restrict_to_power(graph, a, 0.5); return graph.power(a, 0.5);
      default: break;
    }
    const Function f = trace::function_of(step.operation);
    if (f == Function::none) {
      is_known = false;
      return a;
    }
    restrict_to_function(graph, f, a);
    return graph.function(f, a, b);
  };
  for (int i = 0; i < list.count; ++i) made.push_back(node(list.step[i]));
  return operand(list.result);
}

}  // namespace qdot::formula
