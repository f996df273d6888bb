#pragma once
// SPDX-License-Identifier: MIT
//
// The power series of a motion and of its first and second derivatives.
//
// Lagrange's equations, d/dt p = F with p = ∂L/∂q̇, are differentiated along a motion. With P = ∂p/∂(q, q̇) and G = ∂F/∂(q, q̇), for one column
// x_a = [δq; δq̇] of Φ,
//
//     d/dt (P x_a + P_θ) = G x_a + F_θ ,                                   P_θ and F_θ only in columns of parameters θ,
//
// and once more, with X_a = (x_a, and the unit vector of θ in the column of a parameter), for a pair of columns
//
//     d/dt (P x_ab + p″[X_a, X_b]) = G x_ab + F″[X_a, X_b] .
//
// Both are the same linear equations with other summands known beforehand. So order k of all columns and pairs has one recurrence: with s = (t − t₀)/τ,
//
//     M₀ δq̇_k = Σ_{j=1…k} (τ/k G_{j−1} − P_j) x_{k−j} − (∂p/∂q)₀ δq_k + τ/k f_{k−1} − r_k ,       δq_k = τ/k δq̇_{k−1} ,
//
// where M₀ = (∂p/∂q̇)₀ is factored for the motion anyway, and f, r are F_θ, P_θ or F″[X_a, X_b], p″[X_a, X_b]. The pairs' r_k needs order k of x_a and x_b,
// which are made before (analysis/variations/bilinear_series.hpp). P and G are nodes of the motion's own graph (integrate/steps/recorded_motion.hpp), by
// reverse differentiation, and θ are variables of the graph. A column or a pair costs 2n² k multiplications in order k.

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "qdot/ad/series/sweep.hpp"
#include "qdot/analysis/variations/bilinear_series.hpp"
#include "qdot/analysis/variations/recorder.hpp"
#include "qdot/analysis/variations/series_columns.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/steps/taylor_equations.hpp"

namespace qdot::detail {

class VariationSeries {
  using Index = Eigen::Index;

 public:
  /// @throws NotAnalytic  T, V or a force compares values or has a kink
  VariationSeries(VariationalEquations& equations, int highest_order)
      : equations_(&equations), highest_(highest_order), n_(equations.dof()), state_(2 * n_), m_(equations.recorder->record(theta_)) {
    parameters_ = static_cast<Index>(theta_.size());
    width_ = state_ + parameters_;
    std::vector<int> x = m_.q;
    x.insert(x.end(), m_.qdot.begin(), m_.qdot.end());
    x.insert(x.end(), theta_.begin(), theta_.end());
    taylor::SweepOutputs outputs{.early = m_.p, .series = m_.force, .values = m_.mass, .late = m_.qdot};
    for (const auto* list : {&m_.p, &m_.force})
      for (const int node : *list) append(slopes_at_, m_.recording.graph.gradient(node, x));
    const Index columns = equations.columns();
    if (equations.pairs > 0) bilinear_ = BilinearSeries(m_.recording.graph, slopes_at_, x, parameters_, columns, highest_order);
    bilinear_.append_nodes(outputs.series);
    for (const auto* list : {&slopes_at_, &m_.q, &theta_}) append(outputs.series, *list);
    outputs.series.push_back(m_.t);
    for (const auto& assumption : m_.recording.assumptions) outputs.values.push_back(assumption.node);
    sweep_ = taylor::Sweep(m_.recording.graph, outputs, highest_order);
    for (int& node : slopes_at_) node = sweep_.slot(node);
    bilinear_.find_slots(sweep_);

    for (Index i = 0; i < n_; ++i) names_.push_back(equations.state_name(i));
    columns_ = SeriesColumns(state_, columns, state_, highest_order);
    pairs_ = SeriesColumns(state_, equations.pairs, state_ * (1 + columns), highest_order);
    coefficients_.setZero(equations.size(), highest_order + 1);
    slopes_.setZero(state_ * (highest_order + 1), state_);
    by_parameters_.setZero(state_, parameters_);
    by_parameters_before_ = by_parameters_;
    weights_.setZero(slopes_.rows(), n_);
    M_.setZero(n_, n_);
    solution_.setZero(n_);
  }

  void renew() {
    if (!is_current()) *this = VariationSeries(*equations_, highest_);
  }
  bool is_current() { return equations_->recorder->holds(m_, theta_); }

  /// Orders 0 and 1.
  void start(double t, const Eigen::VectorXd& y, double time_unit) {
    unit_ = time_unit;
    equations_->note_size(y.data());
    coefficients_.col(0) = y;
    for (Index i = 0; i < n_; ++i) {
      sweep_.set(sweep_.slot(m_.q[index(i)]), y[i]);
      sweep_.set(sweep_.slot(m_.qdot[index(i)]), y[n_ + i]);
    }
    for (std::size_t j = 0; j < theta_.size(); ++j) sweep_.set(sweep_.slot(theta_[j]), equations_->recorder->parameter(static_cast<Index>(j)));
    sweep_.set(sweep_.slot(m_.t), t);
    sweep_.start();
    for (const auto& assumption : m_.recording.assumptions)
      if (sweep_.value(sweep_.slot(assumption.node)) == assumption.value)
        throw NonFinite("a Taylor coefficient", t,
                        sentence({"T, V or a force asks whether a quantity is exactly ", assumption.value, ", and at t = ", t,
                                  " it is, so the motion may not be analytic there; use Dop853"}));
    std::size_t next = 0;
    for (Index i = 0; i < n_; ++i)
      for (Index j = 0; j <= i; ++j) M_(i, j) = M_(j, i) = sweep_.value(sweep_.slot(m_.mass[next++]));
    if (!factors_.factor(M_)) throw_mass_matrix_error(M_, t, names_);
    for (SeriesColumns* of : {&columns_, &pairs_})
      for (Index c = 0; c < of->count; ++c)
        for (Index i = 0; i < state_; ++i) of->at(0, i, c) = y[of->place + state_ * c + i];
    note_slopes(0);
    if (pairs_.count > 0) bilinear_.note(sweep_, columns_, 0);
    make_order(1);
  }

  /// Orders 2 to `order`, after start().
  void expand(int order) {
    for (int k = 2; k <= order; ++k) make_order(k);
  }

  const Eigen::MatrixXd& coefficients() const noexcept { return coefficients_; }

 private:
  static std::size_t index(Index i) { return static_cast<std::size_t>(i); }
  static void append(std::vector<int>& list, const std::vector<int>& more) { list.insert(list.end(), more.begin(), more.end()); }

  void make_order(int k) {
    const double factor = unit_ / k;
    for (Index i = 0; i < n_; ++i) solution_[i] = factor * sweep_.latest(sweep_.slot(m_.force[index(i)]));
    for (const int node : theta_) sweep_.set(sweep_.slot(node), 0.0);
    for (Index i = 0; i < n_; ++i) {
      sweep_.set(sweep_.slot(m_.q[index(i)]), coefficients_(i, k) = factor * coefficients_(n_ + i, k - 1));
      sweep_.set(sweep_.slot(m_.qdot[index(i)]), 0.0);
    }
    sweep_.set(sweep_.slot(m_.t), k == 1 ? unit_ : 0.0);
    sweep_.advance(k);
    for (Index i = 0; i < n_; ++i) solution_[i] -= sweep_.latest(sweep_.slot(m_.p[index(i)]));
    factors_.solve_in_place(solution_);
    for (Index i = 0; i < n_; ++i) sweep_.set(sweep_.slot(m_.qdot[index(i)]), coefficients_(n_ + i, k) = solution_[i]);
    sweep_.complete(k);
    note_slopes(k);
    for (Index i = 0; i < n_; ++i)
      write_weights(weights_.col(i).data(), slopes_.col(i).data(), slopes_.col(n_ + i).data(), state_, k, highest_, factor);
    const Index first = columns_.count - parameters_;
    extend(columns_, k, factor, [&](Index i, Index c) {
      return c < first ? 0.0 : factor * by_parameters_before_(n_ + i, c - first) - by_parameters_(i, c - first);
    });
    if (pairs_.count == 0) return;
    bilinear_.note(sweep_, columns_, k);
    const Eigen::MatrixXd& summands = bilinear_.summands(columns_, k, factor);
    extend(pairs_, k, factor, [&](Index i, Index c) { return summands(i, c); });
  }

  // P and G, P_θ and F_θ.
  void note_slopes(int k) {
    by_parameters_.swap(by_parameters_before_);
    const int* slot = slopes_at_.data();
    for (Index r = 0; r < state_; ++r) {
      for (Index l = 0; l < state_; ++l) slopes_(state_ * (highest_ - k) + l, r) = sweep_.latest(*slot++);
      for (Index j = 0; j < parameters_; ++j) by_parameters_(r, j) = sweep_.latest(*slot++);
    }
  }

  // Order k of columns or pairs.
  void extend(SeriesColumns& of, int k, double factor, const auto& summand) {
    for (Index i = 0; i < n_; ++i) of.sum(weights_.col(i).data(), state_ * k, 0, of.sums_of(i));
    for (Index c = 0; c < of.count; ++c) {
      for (Index i = 0; i < n_; ++i) of.at(k, i, c) = factor * of.at(k - 1, n_ + i, c);
      for (Index i = 0; i < n_; ++i) {
        double sum = of.sums_of(i)[c] + summand(i, c);
        for (Index l = 0; l < n_; ++l) sum -= slopes_(state_ * highest_ + l, i) * of.at(k, l, c);
        solution_[i] = sum;
      }
      factors_.solve_in_place(solution_);
      for (Index i = 0; i < n_; ++i) of.at(k, n_ + i, c) = solution_[i];
      for (Index i = 0; i < state_; ++i) coefficients_(of.place + state_ * c + i, k) = of.at(k, i, c);
    }
  }

  VariationalEquations* equations_;
  int highest_;
  Index n_, state_, parameters_ = 0, width_ = 0;
  std::vector<int> theta_;  // variables of the parameters
  RecordedMotion m_;
  taylor::Sweep sweep_;
  std::vector<int> slopes_at_;  // slots of (P P_θ), then of (G F_θ), row by row
  std::vector<std::string> names_;
  SeriesColumns columns_, pairs_;
  BilinearSeries bilinear_;
  Eigen::MatrixXd slopes_;                                // a column for each row of P, then of G, the highest order first
  Eigen::MatrixXd by_parameters_, by_parameters_before_;  // the latest order of P_θ and F_θ, and that before
  Eigen::MatrixXd weights_, coefficients_, M_;
  MassFactors<Dynamic> factors_;
  Eigen::VectorXd solution_;
  double unit_ = 1.0;
};

}  // namespace qdot::detail
