#pragma once
// SPDX-License-Identifier: MIT
//
// The power series of p″[X_a, X_b] and F″[X_a, X_b].
//
// Second derivatives of a motion by x_a and x_b obey the linear equations of Φ with these as known summands (analysis/variations/variation_series.hpp).
// p = ∂L/∂q̇ and F are differentiated twice, along the columns X of the pair: x, and the unit vector of θ in the column of a parameter.
//
// The entries of p″ and F″ are nodes of the motion's graph, gradients of the entries of P and G; many of them are zero, and left out. From their series and
// those of the columns come the matrices p″[X_a, ·] and F″[X_a, ·], for all a at once, and from these the summands, for all b ≥ a at once.
//
// With k columns order j costs z k j multiplications for the matrices, where z entries of p″ and F″ are not zero, and n² k² j for the summands.

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "qdot/ad/formula/graph.hpp"
#include "qdot/ad/series/sweep.hpp"
#include "qdot/analysis/variations/series_columns.hpp"

namespace qdot::detail {

// Weights τ/k G_{j−1} − P_j, j = k … 0, where G_{−1} is zero, of `size` entries in each order; P and G have the highest order first.
template <class = void>  // compiled only where it is called
void write_weights(double* w, const double* P, const double* G, Eigen::Index size, int k, int highest, double factor) {
  P += size * (highest - k);
  G += size * (highest - k + 1);
  for (Eigen::Index l = 0; l < size * k; ++l) w[l] = factor * G[l] - P[l];
  for (Eigen::Index l = size * k; l < size * (k + 1); ++l) w[l] = -P[l];
}

template <class = void>  // compiled only where it is made
class BilinearSeries {
  using Index = Eigen::Index;

 public:
  BilinearSeries() = default;
  // slopes: the nodes of (P P_θ), then of (G F_θ), row by row; x: the variables they are slopes by.
  BilinearSeries(formula::Graph& graph, const std::vector<int>& slopes, const std::vector<int>& x, Index parameters, Index columns, int highest_order)
      : state_(static_cast<Index>(x.size()) - parameters), parameters_(parameters), columns_(columns), highest_(highest_order) {
    const Index width = state_ + parameters;
    std::vector<int> square(x.size() * x.size());
    const auto entry = [&](Index m, Index l) -> int& { return square[static_cast<std::size_t>(m * width + l)]; };
    for (Index r = 0; r < state_; ++r) {
      for (Index m = 0; m < width; ++m) {
        const std::vector<int> row = graph.gradient(slopes[static_cast<std::size_t>(r * width + m)], std::span(x).subspan(static_cast<std::size_t>(m)));
        for (Index l = m; l < width; ++l) entry(m, l) = entry(l, m) = row[static_cast<std::size_t>(l - m)];
      }
      for (Index m = 0; m < width; ++m) {
        Row row{.of = r, .along = m};
        for (Index l = 0; l < state_; ++l)
          if (!graph.is_constant(entry(m, l), 0.0)) {
            row.components.push_back(l);
            row.nodes.push_back(entry(m, l));
          }
        for (Index l = state_; l < width; ++l) row.nodes.push_back(entry(m, l));
        row.weights.assign(row.components.size() * static_cast<std::size_t>(highest_ + 1), 0.0);
        rows_.push_back(std::move(row));
      }
    }
    along_.setZero(state_ * (highest_ + 1), state_ * columns);
    by_parameters_.setZero(state_ * columns, parameters);
    by_parameters_before_ = by_parameters_;
    weights_.setZero(state_ * (highest_ + 1));
    summands_.setZero(state_ / 2, columns * (columns + 1) / 2);
  }

  void append_nodes(std::vector<int>& to) const {
    for (const Row& row : rows_) to.insert(to.end(), row.nodes.begin(), row.nodes.end());
  }
  void find_slots(const taylor::Sweep& sweep) {
    for (Row& row : rows_)
      for (int& node : row.nodes) node = sweep.slot(node);
  }

  // Order k of p″[X_a, ·] and F″[X_a, ·].
  void note(const taylor::Sweep& sweep, SeriesColumns& columns, int k) {
    by_parameters_.swap(by_parameters_before_);
    const std::size_t orders = static_cast<std::size_t>(highest_ + 1);
    double* const sums = columns.sums_of(0);
    for (Row& row : rows_) {
      const std::size_t count = row.components.size();
      double* const weights = row.weights.data() + highest_ - k;
      for (std::size_t l = 0; l < count; ++l) weights[l * orders] = sweep.latest(row.nodes[l]);
      columns.sum_of(row.components, weights, orders, k, sums);
      for (Index a = 0; a < columns_; ++a) {
        if (const Index j = parameter_of(a); j >= 0) sums[a] += sweep.latest(row.nodes[count + static_cast<std::size_t>(j)]);
        if (row.along < state_) along_(state_ * (highest_ - k) + row.along, state_ * a + row.of) = sums[a];
        else by_parameters_(state_ * a + row.of, row.along - state_) = sums[a];
      }
    }
  }

  // τ/k F″[X_a, X_b]_{k−1} − p″[X_a, X_b]_k for a pair, row by row of the upper triangle; factor = τ/k.
  const Eigen::MatrixXd& summands(SeriesColumns& columns, int k, double factor) {
    const Index n = state_ / 2;
    for (Index a = 0, first = 0; a < columns_; first += columns_ - a, ++a)
      for (Index i = 0; i < n; ++i) {
        const Index p = state_ * a + i, F = p + n;
        double* const sums = columns.sums_of(i);
        write_weights(weights_.data(), along_.col(p).data(), along_.col(F).data(), state_, k, highest_, factor);
        columns.sum(weights_.data(), state_ * (k + 1), a, sums);
        for (Index b = a; b < columns_; ++b) {
          if (const Index j = parameter_of(b); j >= 0) sums[b] += factor * by_parameters_before_(F, j) - by_parameters_(p, j);
          summands_(i, first + b - a) = sums[b];
        }
      }
    return summands_;
  }

 private:
  // Row `along` of the second derivative of one of p and F.
  struct Row {
    Index of = 0, along = 0;
    std::vector<Index> components = {};  // by which it is not zero
    std::vector<int> nodes = {};         // of these, then by the parameters
    std::vector<double> weights = {};    // series of these, one behind the other, the highest order first
  };

  // Which parameter column c belongs to; negative for none.
  Index parameter_of(Index c) const { return c - (columns_ - parameters_); }

  Index state_ = 0, parameters_ = 0, columns_ = 0;
  int highest_ = 0;
  std::vector<Row> rows_;
  Eigen::MatrixXd along_;                                 // for each a the rows of p″[X_a, ·], then those of F″[X_a, ·], as columns
  Eigen::MatrixXd by_parameters_, by_parameters_before_;  // the latest order of their part along parameters, and that before
  Eigen::VectorXd weights_;
  Eigen::MatrixXd summands_;
};

}  // namespace qdot::detail
