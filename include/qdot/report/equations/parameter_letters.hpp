#pragma once
// SPDX-License-Identifier: MIT
//
// From numbers back to letters.
//
// Parameters of a system are plain doubles, so a recording of T (ad/formula/recording.hpp) holds ½ m l² as the number that it happened to be.
// But T can be recorded again with other masses and lengths, as often as one likes. A number that is a formula of the parameters is found from its
// values (report/equations/parameter_formula.hpp). These are of size one, and differ from each other: m = l = 1 tells nothing about which is
// which. At last T and V themselves are compared with the formulas for the parameters as they are.
//
// A parameter that enters otherwise, as eᵖ for instance, or as an exponent, stays the number that it is. When the operations themselves depend on
// the parameters, there is no one formula, and an error is thrown.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "qdot/ad/formula/coefficient.hpp"
#include "qdot/ad/formula/graph.hpp"
#include "qdot/analysis/symmetry/vanishing.hpp"
#include "qdot/error.hpp"
#include "qdot/report/equations/parameter_formula.hpp"
#include "qdot/report/equations/source.hpp"

namespace qdot {

/// Operations of T or V depend on the values of parameters, so that no formula holds for all of them.
class NotOneFormula : public Error {
 public:
  using Error::Error;
};

namespace report {
namespace detail {

using LetteredGraph = formula::BasicGraph<formula::Coefficient>;

/// Finds the formulas of all numbers of a recording.
class ParameterLetters {
 public:
  /// @throws NotOneFormula
  ParameterLetters(RecordFormulas record, std::vector<double> values) : record_(std::move(record)), values_(std::move(values)) {
    named_.assign(values_.size(), true);
    while (!found()) {
    }
  }

  /// Whether a parameter is a letter, and not a number.
  const std::vector<bool>& named() const { return named_; }

  /// Writes the recording with letters: parameter j is variable first + j of the graph. Returns the outputs.
  ///
  /// @throws NotOneFormula  with the parameters as they are, the functors return something else
  std::vector<int> written(LetteredGraph& graph, int first) const {
    std::vector<int> made, outputs;
    std::size_t next = 0;
    for (const auto& node : sample_.recording.graph.nodes()) {
      const auto at = [&made](int i) { return i < 0 ? -1 : made[static_cast<std::size_t>(i)]; };
      switch (node.kind) {
        case formula::Kind::variable: made.push_back(graph.variable(node.a)); break;
        case formula::Kind::constant: made.push_back(sum_of(graph, first, {{next, graph.constant(1.0)}})); break;
        case formula::Kind::affine:
          if (node.b < 0) {
            made.push_back(sum_of(graph, first, {{next, at(node.a)}, {next + 2, graph.constant(1.0)}}));
          } else {
            const int a = sum_of(graph, first, {{next, at(node.a)}}), b = sum_of(graph, first, {{next + 1, at(node.b)}});
            const int c = sum_of(graph, first, {{next + 2, graph.constant(1.0)}});
            made.push_back(graph.sum(graph.sum(a, b), c));
          }
          break;
        case formula::Kind::product: made.push_back(graph.product(at(node.a), at(node.b))); break;
        case formula::Kind::quotient: made.push_back(graph.quotient(at(node.a), at(node.b))); break;
        case formula::Kind::power: made.push_back(graph.power(at(node.a), node.c)); break;
        case formula::Kind::function: made.push_back(graph.function(node.function, at(node.a), at(node.b))); break;
      }
      next += numbers_in(node.kind);
    }
    for (const int node : sample_.outputs) outputs.push_back(made[static_cast<std::size_t>(node)]);
    verify(graph, outputs, first);
    return outputs;
  }

 private:
  static constexpr const char* remedy = "; name no parameter whose value decides which operations there are";

  static double scattered(int i, int j) {  // in [0, 1), without order
    const double x = std::sin(12.9898 * (i + 20) + 78.233 * (j + 1)) * 43758.5453;
    return x - std::floor(x);
  }
  static std::size_t numbers_in(formula::Kind kind) {
    return kind == formula::Kind::affine ? 3 : kind == formula::Kind::constant || kind == formula::Kind::power ? 1 : 0;
  }

  double value(std::size_t j, int k) const {
    if (!named_[j]) return values_[j];
    // Of size one, in the order that the values have: in 1 + 10⁻¹³ the second letter could not be recognized.
    const double size = values_[j] == 0.0 ? 0.8 : std::copysign(std::pow(std::abs(values_[j]), 0.1), values_[j]);
    const double middle = size * (0.85 + 0.3 * scattered(1, static_cast<int>(j)));
    return middle * (k >= 0 ? 0.65 + 0.13 * k + 0.01 * (k % 3) : k == -1 ? 1.0 : 0.8 + 0.5 * scattered(k, static_cast<int>(j)));
  }

  // All numbers of a recording with parameters at these nodes, in the order of the graph.
  const std::vector<double>& numbers(const ParameterNodes& at) {
    const auto known = known_.find(at);
    if (known != known_.end()) return known->second;
    std::vector<double> p, all;
    for (std::size_t j = 0; j < at.size(); ++j) p.push_back(value(j, at[j]));
    const RecordedFormulas run = record_(p);
    if (known_.empty()) sample_ = run;
    const auto &nodes = run.recording.graph.nodes(), &like = sample_.recording.graph.nodes();
    bool same = nodes.size() == like.size() && run.outputs == sample_.outputs;
    for (std::size_t w = 0; same && w < nodes.size(); ++w) {
      const auto &x = nodes[w], &y = like[w];
      same = x.kind == y.kind && x.function == y.function && x.a == y.a && x.b == y.b;
      if (x.kind == formula::Kind::affine) all.insert(all.end(), {x.ca, x.b < 0 ? 0.0 : x.cb, x.c});
      if (numbers_in(x.kind) == 1) all.push_back(x.c);
    }
    if (!same)
      throw NotOneFormula(
          std::string("T and V must be the same operations for all values of the parameters, but are others when these change by a third") +
          remedy);
    return known_.emplace(at, std::move(all)).first->second;
  }

  // One attempt; false when some parameters have become numbers.
  bool found() {
    known_.clear();
    formulas_.clear();
    const ParameterNodes middle(values_.size(), -1);
    const std::size_t count = numbers(middle).size();
    std::vector<bool> is_exponent;
    for (const auto& node : sample_.recording.graph.nodes()) is_exponent.insert(is_exponent.end(), numbers_in(node.kind), node.kind == formula::Kind::power);
    for (std::size_t i = 0; i < count; ++i) {
      ParameterFormula f;
      ParameterFit<> fit([&](const ParameterNodes& at) { return numbers(at)[i]; }, [this](std::size_t j, int k) { return value(j, k); }, named_);
      if (fit.find(f) && (!is_exponent[i] || f.is_constant())) {
        formulas_.push_back(std::move(f));
        continue;
      }
      std::vector<bool> still_named = named_;
      for (std::size_t j = 0; j < values_.size(); ++j) {
        ParameterNodes other = middle;
        other[j] = 3;
        const bool some_are_unfit = std::find(fit.unfit().begin(), fit.unfit().end(), true) != fit.unfit().end();
        if (some_are_unfit ? fit.unfit()[j] : numbers(other)[i] != numbers(middle)[i]) still_named[j] = false;
      }
      if (still_named == named_) throw NotOneFormula(std::string("T and V must be formulas with the same numbers whenever they are run, but are not") + remedy);
      named_ = still_named;
      return false;
    }
    return true;
  }

  static int node_of(LetteredGraph& graph, int variable, const ParameterFactor& f) {
    return f.function != formula::Function::none ? graph.function(f.function, variable) : graph.power(variable, f.exponent);
  }

  // Σ number · node, with the parameters that all numbers have in common outside.
  int sum_of(LetteredGraph& graph, int first, const std::vector<std::pair<std::size_t, int>>& parts) const {
    std::vector<double> common;
    double size = 0.0;  // of all numbers k, if they are alike
    bool all_negative = true;
    for (const auto& [number, node] : parts)
      for (const ParameterTerm& t : formulas_[number].terms) {
        const bool is_first = common.empty();
        size = formulas_[number].root == ParameterRoot::none && (is_first || std::abs(t.k) == size) ? std::abs(t.k) : -1.0;
        all_negative = all_negative && t.k < 0.0;
        common.resize(values_.size(), 0.0);
        for (std::size_t j = 0; j < values_.size(); ++j) {
          const double e = formulas_[number].root == ParameterRoot::none && t.factors[j].function == formula::Function::none ? t.factors[j].exponent : 0.0;
          common[j] = is_first ? e : e > 0.0 && common[j] > 0.0 ? std::min(e, common[j]) : e < 0.0 && common[j] < 0.0 ? std::max(e, common[j]) : 0.0;
        }
      }
    common.resize(values_.size(), 0.0);
    const double scale = (size > 0.0 ? size : 1.0) * (all_negative && size > 0.0 ? -1.0 : 1.0);
    const auto variable = [first](std::size_t j) { return first + static_cast<int>(j); };
    int sum = graph.constant(0.0), outside = graph.constant(1.0);
    for (const auto& [number, node] : parts) {
      const ParameterFormula& f = formulas_[number];
      const double inside = f.root == ParameterRoot::reciprocal ? f.terms[0].k : 1.0;  // 1/(2 a + 2 b) is ½/(a + b)
      int factor = graph.constant(0.0);
      for (const ParameterTerm& t : f.terms) {
        int product = graph.constant(1.0);
        for (std::size_t j = 0; j < values_.size(); ++j) {
          ParameterFactor rest = t.factors[j];
          if (rest.function == formula::Function::none) rest.exponent -= common[j];
          product = graph.product(product, node_of(graph, graph.variable(variable(j)), rest));
        }
        factor = graph.sum(factor, graph.scaled(product, t.k / (inside * scale)));
      }
      if (f.root == ParameterRoot::reciprocal) factor = graph.scaled(graph.power(factor, -1.0), 1.0 / inside);
      if (f.root == ParameterRoot::root) factor = graph.scaled(graph.power(factor, 0.5), f.negative ? -1.0 : 1.0);
      sum = graph.sum(sum, graph.product(factor, node));
    }
    for (std::size_t j = 0; j < common.size(); ++j)
      outside = graph.product(outside, node_of(graph, graph.variable(variable(j)), {formula::Function::none, common[j]}));
    return graph.scaled(graph.product(outside, sum), scale);
  }

  void verify(const LetteredGraph& graph, const std::vector<int>& outputs, int first) const {
    const RecordedFormulas own = record_(values_);
    constexpr double tolerance = 1e-9;  // of sums whose terms may cancel
    for (int trial = 0; trial < 8; ++trial) {
      std::vector<double> variables;
      for (int i = 0; i < first; ++i) variables.push_back(0.3 + 0.9 * scattered(trial, i));
      variables.insert(variables.end(), values_.begin(), values_.end());
      const auto values_of = [&](const auto& all) { return qdot::detail::values_of_graph(all, static_cast<int>(all.nodes().size()) - 1, variables); };
      const auto x = values_of(own.recording.graph), y = values_of(graph);
      for (std::size_t k = 0; k < outputs.size(); ++k) {
        const double a = x[static_cast<std::size_t>(own.outputs[k])].value, b = y[static_cast<std::size_t>(outputs[k])].value;
        if (std::isfinite(a) && !(std::abs(a - b) <= tolerance * (1.0 + std::abs(a))))
          throw NotOneFormula(qdot::detail::sentence(
              {"the formulas must hold for the parameters as they are, but where T or V is ", a, " they say ", b, remedy}));
      }
    }
  }

  RecordFormulas record_;
  std::vector<double> values_;
  std::vector<bool> named_;
  std::map<ParameterNodes, std::vector<double>> known_;
  RecordedFormulas sample_;
  std::vector<ParameterFormula> formulas_;
};

}  // namespace detail
}  // namespace report
}  // namespace qdot
