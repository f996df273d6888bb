#pragma once
// SPDX-License-Identifier: MIT
//
// A list of operations as a graph.
//
// A list (ad/formula/trace_list.hpp) says what a user's energy does, in the order of doing. A graph (ad/formula/graph.hpp) can be differentiated and
// simplified. This header goes from one to the other, at run time or while compiling.
//
// A graph may hold for more than the list does: √x² has become x, and x x / x too, but the first has no value where x < 0, the second none at
// 0, and a force that is derived there belongs to no energy. So the graph remembers of such x where the list has a value.
//
// Arguments of calls that make nodes are made before, one by one: compilers differ in the order of arguments, and the order of nodes
// must not.

#include <cstddef>
#include <vector>

#include "qdot/ad/formula/graph.hpp"
#include "qdot/ad/formula/trace.hpp"

namespace qdot::formula {

// The function that an operation is; none if it is something else.
constexpr Function function_of(trace::Operation o) {
  using trace::Operation;
  switch (o) {
    case Operation::sin: return Function::sin;
    case Operation::cos: return Function::cos;
    case Operation::tan: return Function::tan;
    case Operation::asin: return Function::asin;
    case Operation::acos: return Function::acos;
    case Operation::atan: return Function::atan;
    case Operation::atan2: return Function::atan2;
    case Operation::hypot: return Function::hypot;
    case Operation::exp: return Function::exp;
    case Operation::expm1: return Function::expm1;
    case Operation::log: return Function::log;
    case Operation::log1p: return Function::log1p;
    case Operation::sinh: return Function::sinh;
    case Operation::cosh: return Function::cosh;
    case Operation::tanh: return Function::tanh;
    case Operation::asinh: return Function::asinh;
    case Operation::acosh: return Function::acosh;
    case Operation::atanh: return Function::atanh;
    case Operation::cbrt: return Function::cbrt;
    case Operation::erf: return Function::erf;
    case Operation::erfc: return Function::erfc;
    default: return Function::none;
  }
}

/// Says that a formula has a value only where x is in this domain.
template <class Coefficient>
constexpr void restrict_to(Domain domain, BasicGraph<Coefficient>& graph, int x) {
  const BasicNode<Coefficient> node = graph[x];
  if (node.kind == Kind::constant) return;
  if (domain == Domain::nonzero && (node.kind == Kind::power || node.kind == Kind::product)) {
    restrict_to(domain, graph, node.a);
    if (node.b >= 0) restrict_to(domain, graph, node.b);
  } else {
    graph.set_domain(x, node.domain == Domain::everything || node.domain == domain ? domain : Domain::positive);
  }
}

// Of an operation on nodes; of a power by the exponent.
template <class Coefficient>
constexpr void restrict_to_domain_of(trace::Operation o, BasicGraph<Coefficient>& graph, int a, int b, double exponent) {
  using trace::Operation;
  const auto one_less_square = [&] {
    const int square = graph.product(a, a);
    const int one = graph.constant(1.0);
    return graph.difference(one, square);
  };
  const auto shifted = [&](double by) {
    const int shift = graph.constant(by);
    return graph.sum(a, shift);
  };
  const bool whole = exponent >= -1e9 && exponent <= 1e9 && exponent == static_cast<double>(static_cast<int>(exponent));
  switch (o) {
    case Operation::divide: return restrict_to(Domain::nonzero, graph, b);
    case Operation::sqrt: return restrict_to(Domain::nonnegative, graph, a);
    case Operation::pow:
      if (whole && exponent >= 0.0) return;
      return restrict_to(whole ? Domain::nonzero : exponent < 0.0 ? Domain::positive : Domain::nonnegative, graph, a);
    case Operation::log:
    case Operation::log2:
    case Operation::log10: return restrict_to(Domain::positive, graph, a);
    case Operation::log1p: return restrict_to(Domain::positive, graph, shifted(1.0));
    case Operation::asin:
    case Operation::acos: return restrict_to(Domain::nonnegative, graph, one_less_square());
    case Operation::atanh: return restrict_to(Domain::positive, graph, one_less_square());
    case Operation::acosh: return restrict_to(Domain::nonnegative, graph, shifted(-1.0));
    default: return;
  }
}

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
        restrict_to_domain_of(step.operation, graph, a, -1, list.value[-1 - step.b]);
        return graph.power(a, list.value[-1 - step.b]);
      }
      is_known = false;
      return a;
    }
    const int b = has_two_operands(step.operation) ? operand(step.b) : -1;
    restrict_to_domain_of(step.operation, graph, a, b, 1.0);
    switch (step.operation) {
      case Operation::add: return graph.sum(a, b);
      case Operation::subtract: return graph.difference(a, b);
      case Operation::multiply: return graph.product(a, b);
      case Operation::divide: return graph.quotient(a, b);
      case Operation::negate: return graph.scaled(a, -1.0);
      case Operation::sqrt: return graph.power(a, 0.5);
      default: break;
    }
    const Function f = function_of(step.operation);
    if (f != Function::none) return graph.function(f, a, b);
    is_known = false;
    return a;
  };
  for (int i = 0; i < list.count; ++i) made.push_back(node(list.step[i]));
  return operand(list.result);
}

}  // namespace qdot::formula
