#pragma once
// SPDX-License-Identifier: MIT
//
// Derivatives of many outputs, each of which depends on few variables.
//
// The walk back from an output (ad/formula/graph.hpp) visits the nodes that lead to it and no others: those that are still to be visited are kept in a
// heap, the latest first. A row of a thousand rods costs what it is made of, however long the graph is.

#include <algorithm>
#include <cstddef>
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
      : graph_(graph), depends_(graph.dependence(static_cast<int>(graph.nodes().size()) - 1, variables)), adjoint_(depends_.size(), -1),
        column_(depends_.size(), -1) {
    for (std::size_t j = 0; j < variables.size(); ++j) column_[static_cast<std::size_t>(variables[j])] = static_cast<int>(j);
  }

  /// (place among the variables, node of ∂output/∂variable) of all that are not always zero, by places.
  const std::vector<std::pair<int, int>>& of(int output) {
    found_.clear();
    if (output < 0 || depends_[static_cast<std::size_t>(output)] == 0) return found_;
    const int zero = graph_.constant(0.0);
    const auto leads_on = [&](int x) { return x >= 0 && depends_[static_cast<std::size_t>(x)] != 0; };
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
  BasicGraph<Coefficient>& graph_;
  std::vector<char> depends_;
  std::vector<int> adjoint_, column_, waiting_;
  std::vector<std::pair<int, int>> found_;
};

}  // namespace qdot::formula
