#pragma once
// SPDX-License-Identifier: MIT
//
// Derivatives of many outputs, each of which depends on few variables.
//
// The walk back from an output (ad/formula/graph.hpp) visits the nodes that lead to it and no others. Nodes that are still to be visited are kept in a
// heap, the latest first. A row of a thousand rods costs what it is made of, however long the graph is.

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "qdot/ad/formula/graph.hpp"
#include "qdot/ad/formula/in_order.hpp"

namespace qdot::formula {

/// Gradients of one graph with respect to the same variables. Adds nodes to the graph.
template <class Coefficient>
class LocalGradient {
 public:
  /// @param variables  nodes; derivatives are found of nodes that are in the graph by now
  LocalGradient(BasicGraph<Coefficient>& graph, const std::vector<int>& variables)
      : graph_(graph), first_(graph.nodes().size(), none), adjoint_(first_.size(), -1), column_(first_.size(), -1) {
    for (std::size_t j = 0; j < variables.size(); ++j) {
      const auto variable = static_cast<std::size_t>(variables[j]);
      first_[variable] = column_[variable] = static_cast<int>(j);
    }
    for (std::size_t w = 0; w < first_.size(); ++w) {
      const auto& node = graph.nodes()[w];
      if (node.kind == Kind::constant || node.kind == Kind::variable || first_[w] != none) continue;
      first_[w] = first_[static_cast<std::size_t>(node.a)];
      if (node.b >= 0) first_[w] = std::min(first_[w], first_[static_cast<std::size_t>(node.b)]);
    }
  }

  /// (place among the variables, node of ∂output/∂variable) of all that are not always zero, by places.
  ///
  /// @param most  derivatives with so many of the variables, the first ones
  const std::vector<std::pair<int, int>>& of(int output, int most = none) {
    found_.clear();
    const auto leads_on = [&](int x) { return x >= 0 && first_[static_cast<std::size_t>(x)] < most; };
    if (!leads_on(output)) return found_;
    const int zero = graph_.constant(0.0);
    const auto add = [&](int x, int contribution) {
      int& so_far = adjoint_[static_cast<std::size_t>(x)];
      if (so_far < 0) {
        so_far = contribution;
        waiting_.push_back(x);
        std::push_heap(waiting_.begin(), waiting_.end());
      } else {
        so_far = graph_.sum(so_far, contribution);
      }
    };
    add(output, graph_.constant(1.0));
    while (!waiting_.empty()) {
      std::pop_heap(waiting_.begin(), waiting_.end());
      const int w = waiting_.back();
      waiting_.pop_back();
      const int bar = std::exchange(adjoint_[static_cast<std::size_t>(w)], -1);
      if (bar == zero) continue;
      if (column_[static_cast<std::size_t>(w)] >= 0) found_.emplace_back(column_[static_cast<std::size_t>(w)], bar);
      else graph_.pass_back(w, bar, leads_on, add);
    }
    put_in_order(found_, [](const auto& x, const auto& y) { return x.first < y.first; });
    return found_;
  }

 private:
  static constexpr int none = std::numeric_limits<int>::max();

  BasicGraph<Coefficient>& graph_;
  std::vector<int> first_;  // of the variables on which a node depends; or none
  std::vector<int> adjoint_, column_, waiting_;
  std::vector<std::pair<int, int>> found_;
};

}  // namespace qdot::formula
