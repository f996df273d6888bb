#pragma once
// SPDX-License-Identifier: MIT
//
// Where a formula has a value.
//
// A simplified graph may have values where the user's formula has none. (√x)² has become x, and so has x x / x, but the first has no value where x < 0, the
// second none at 0. A force that is derived there belongs to no energy. So code that makes nodes of a user's operations marks where their arguments have a
// value, and the graph keeps it (BasicNode::domain).

#include "qdot/ad/formula/graph.hpp"

namespace qdot::formula {

/// Whether a value is in a domain; NaN is in none but everything.
constexpr bool is_in(Domain domain, double x) {
  switch (domain) {
    case Domain::everything: return true;
    case Domain::nonzero: return x < 0.0 || x > 0.0;
    case Domain::nonnegative: return x >= 0.0;
    case Domain::positive: return x > 0.0;
  }
  return true;
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

/// Restricts x, the base of a power, to the domain of the power.
template <class Coefficient>
constexpr void restrict_to_power(BasicGraph<Coefficient>& graph, int x, double exponent) {
  const bool whole = exponent >= -1e9 && exponent <= 1e9 && exponent == static_cast<double>(static_cast<int>(exponent));
  if (whole && exponent >= 0.0) return;
  restrict_to(whole ? Domain::nonzero : exponent < 0.0 ? Domain::positive : Domain::nonnegative, graph, x);
}

/// Restricts x, the argument of a function, to the domain of the function.
template <class Coefficient>
constexpr void restrict_to_function(BasicGraph<Coefficient>& graph, Function f, int x) {
  const auto one_less_square = [&] {
    const int square = graph.product(x, x);
    const int one = graph.constant(1.0);
    return graph.difference(one, square);
  };
  const auto shifted = [&](double by) {
    const int shift = graph.constant(by);
    return graph.sum(x, shift);
  };
  switch (f) {
    case Function::log: return restrict_to(Domain::positive, graph, x);
    case Function::log1p: return restrict_to(Domain::positive, graph, shifted(1.0));
    case Function::asin:
    case Function::acos: return restrict_to(Domain::nonnegative, graph, one_less_square());
    case Function::atanh: return restrict_to(Domain::positive, graph, one_less_square());
    case Function::acosh: return restrict_to(Domain::nonnegative, graph, shifted(-1.0));
    default: return;
  }
}

}  // namespace qdot::formula
