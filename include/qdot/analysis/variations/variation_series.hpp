#pragma once
// SPDX-License-Identifier: MIT
//
// The power series of a motion and of its first and second derivatives.
//
// Lagrange's equations, d/dt p = F, are differentiated along a motion. With P = ∂p/∂(q, q̇), G = ∂F/∂(q, q̇) and parameters θ, a
// column x_a = [δq; δq̇] of Φ, and with X_a = (x_a, unit vector of θ) a pair of columns obey
//
//     d/dt (P x_a + P_θ) = G x_a + F_θ ,          d/dt (P x_ab + p″[X_a, X_b]) = G x_ab + F″[X_a, X_b] .
//
// Both are the same linear equations, so order k of all columns and pairs has one recurrence: with s = (t − t₀)/τ,
//
//     M₀ δq̇_k = Σ_{j=1…k} (τ/k G_{j−1} − P_j) x_{k−j} − (∂p/∂q)₀ δq_k + τ/k f_{k−1} − r_k ,       δq_k = τ/k δq̇_{k−1} .
//
// M₀ = (∂p/∂q̇)₀ is factored for the motion anyway; f, r are F_θ, P_θ or F″[X_a, X_b], p″[X_a, X_b], made before from orders of x_a
// and x_b (bilinear_series.hpp). P and G are nodes of the motion's graph (integrate/steps/recorded_motion.hpp), by reverse
// differentiation; of a family, its members' nodes are differenced (recorder.hpp). A column costs 2n² k multiplications in order k.

#include <Eigen/Core>
#include <cstddef>
#include <initializer_list>
#include <string>
#include <vector>

#include "qdot/ad/series/sweep.hpp"
#include "qdot/analysis/variations/bilinear_series.hpp"
#include "qdot/analysis/variations/recorder.hpp"
#include "qdot/analysis/variations/series_columns.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/steps/taylor_constraints.hpp"
#include "qdot/integrate/steps/taylor_equations.hpp"

namespace qdot::detail {

template <class = void>  // compiled only where it is made
class VariationSeries final : public PowerSeries {
  using Index = Eigen::Index;

 public:
  /// @throws NotAnalytic  T, V or a force compares values or has a kink
  VariationSeries(VariationalEquations& equations, int highest_order)
      : equations_(&equations), highest_(highest_order), n_(equations.dof()), state_(2 * n_), recorded_(equations.recorder->recorded(rows_of)) {
    const RecordedMotion& m = recorded_.motion;
    rows_ = static_cast<Index>(m.rows.size());
    parameters_ = recorded_.parameters;
    slopes_at_ = recorded_.slopes;
    taylor::SweepOutputs outputs{.early = m.p, .series = m.force, .values = m.mass, .late = m.qdot};
    append(outputs.early, m.rows);
    append(outputs.values, m.jacobian);
    const Index columns = equations.columns();
    formula::Graph& graph = recorded_.motion.recording.graph;
    if (equations.pairs > 0) bilinear_ = BilinearSeries(graph, slopes_at_, recorded_.x, parameters_, columns, highest_order);
    bilinear_.append_nodes(outputs.series);
    for (const std::vector<int>* list : std::initializer_list<const std::vector<int>*>{&slopes_at_, &m.q, &m.jacobian, &recorded_.theta})
      append(outputs.series, *list);
    outputs.series.push_back(m.t);
    for (const auto& assumption : m.recording.assumptions) outputs.values.push_back(assumption.node);
    sweep_ = taylor::Sweep(graph, outputs, highest_order);
    const Index width = state_ + parameters_, bent = width * (state_ + rows_);  // W′ and W_θ stand behind the slopes of p, F and c
    for (Index l = bent; l < static_cast<Index>(slopes_at_.size()); ++l)
      if (!graph.is_constant(slopes_at_[index(l)], 0.0)) {
        const Index entry = (l - bent) / width;
        bends_.push_back({sweep_.slot(slopes_at_[index(l)]), entry / n_, entry % n_, (l - bent) % width, std::vector<double>(index(highest_order + 1))});
      }
    slopes_at_.resize(index(bent));
    for (int& node : slopes_at_) node = sweep_.slot(node);
    bilinear_.find_slots(sweep_);

    for (Index i = 0; i < n_; ++i) names_.push_back(equations.state_name(i));
    if (rows_ > 0) constraints_ = ConstraintSeries<>(m, sweep_, names_, highest_order);
    columns_ = SeriesColumns(state_, columns, state_, highest_order, n_ + rows_);
    pairs_ = SeriesColumns(state_, equations.pairs, state_ * (1 + columns), highest_order, n_);
    coefficients_.setZero(equations.size(), highest_order + 1);
    slopes_.setZero(state_ * (highest_order + 1), state_ + rows_ + 1);
    by_parameters_.setZero(state_ + rows_, parameters_);
    by_parameters_before_ = by_parameters_;
    weights_.setZero(slopes_.rows(), n_ + rows_);
    reactions_.setZero(rows_, columns * highest_order);
    M_.setZero(n_, n_);
    factors_ = DenseConstrainedFactors<Dynamic>(static_cast<std::size_t>(n_));
    solution_.setZero(n_);
    known_.setZero(rows_);
  }

  void renew() override {
    if (!is_current()) *this = VariationSeries(*equations_, highest_);
  }
  bool is_current() override { return holds_ = holds_ && equations_->recorder->holds(recorded_); }

  /// Orders 0 and 1.
  void start(double t, const double* y, double time_unit) override {
    const RecordedMotion& m = recorded_.motion;
    unit_ = time_unit;
    equations_->note_size(y);
    std::copy_n(y, coefficients_.rows(), coefficients_.data());
    for (Index i = 0; i < n_; ++i) {
      sweep_.set(sweep_.slot(m.q[index(i)]), y[i]);
      sweep_.set(sweep_.slot(m.qdot[index(i)]), y[n_ + i]);
    }
    for (std::size_t j = 0; j < recorded_.theta.size(); ++j)
      sweep_.set(sweep_.slot(recorded_.theta[j]), equations_->recorder->parameter(static_cast<Index>(j)));
    sweep_.set(sweep_.slot(m.t), t);
    sweep_.start();
    for (const auto& assumption : m.recording.assumptions)
      if (sweep_.value(sweep_.slot(assumption.node)) == assumption.value)
        throw NonFinite("a Taylor coefficient", t,
                        sentence({"T, V or a force asks whether a quantity is exactly ", assumption.value, ", and at t = ", t,
                                  " it is, so the motion may not be analytic there; use Dop853"}));
    std::size_t next = 0;
    for (Index i = 0; i < n_; ++i)
      for (Index j = 0; j <= i; ++j) M_(i, j) = M_(j, i) = sweep_.value(sweep_.slot(m.mass[next++]));
    if (rows_ > 0) constraints_.factor(sweep_, M_, false, t);
    else if (!factors_.compute_mass(M_, singular_pivot<double>(M_.rows()))) throw_mass_matrix_error(M_, t, names_);
    for (SeriesColumns* of : {&columns_, &pairs_})
      for (Index c = 0; c < of->count; ++c)
        for (Index i = 0; i < state_; ++i) of->at(0, i, c) = y[of->place + state_ * c + i];
    note_slopes(0);
    if (pairs_.count > 0) bilinear_.note(sweep_, columns_, 0);
    make_order(1);
  }

  /// Orders 2 to `order`, after start().
  void expand(int order) override {
    for (int k = 2; k <= order; ++k) make_order(k);
  }

  const Eigen::MatrixXd& coefficients() const noexcept override { return coefficients_; }

  /// The motion's own multipliers.
  const ConstraintPart* constraints() const noexcept override { return rows_ > 0 ? &constraints_ : nullptr; }

 private:
  // p, F, c, and W row by row.
  static std::vector<int> rows_of(RecordedMotion& m, int) {
    std::vector<int> rows = m.p;
    for (const auto* list : {&m.force, &m.rows, &m.jacobian}) append(rows, *list);
    return rows;
  }
  static std::size_t index(Index i) { return static_cast<std::size_t>(i); }
  static void append(std::vector<int>& list, const std::vector<int>& more) { list.insert(list.end(), more.begin(), more.end()); }

  void make_order(int k) {
    const RecordedMotion& m = recorded_.motion;
    const double factor = unit_ / k;
    for (Index i = 0; i < n_; ++i) solution_[i] = factor * sweep_.latest(sweep_.slot(m.force[index(i)]));
    if (rows_ > 0) constraints_.add_known_reactions(sweep_, k, factor, solution_);
    for (const int node : recorded_.theta) sweep_.set(sweep_.slot(node), 0.0);
    for (Index i = 0; i < n_; ++i) {
      sweep_.set(sweep_.slot(m.q[index(i)]), coefficients_(i, k) = factor * coefficients_(n_ + i, k - 1));
      sweep_.set(sweep_.slot(m.qdot[index(i)]), 0.0);
    }
    sweep_.set(sweep_.slot(m.t), k == 1 ? unit_ : 0.0);
    sweep_.advance(k);
    for (Index i = 0; i < n_; ++i) solution_[i] -= sweep_.latest(sweep_.slot(m.p[index(i)]));
    if (rows_ > 0) constraints_.solve(sweep_, k, factor, solution_);
    else factors_.solve_mass(solution_.data());
    for (Index i = 0; i < n_; ++i) sweep_.set(sweep_.slot(m.qdot[index(i)]), coefficients_(n_ + i, k) = solution_[i]);
    sweep_.complete(k);
    note_slopes(k);
    bend(k - 1);
    const auto slope = [&](Index row) { return slopes_.col(row).data(); };
    for (Index i = 0; i < n_; ++i) write_weights(weights_.col(i).data(), slope(i), slope(n_ + i), state_, k, highest_, factor);
    for (Index r = 0; r < rows_; ++r) write_weights(weights_.col(n_ + r).data(), slope(state_ + r), slope(state_ + rows_), state_, k, highest_, 0.0);
    const Index first = columns_.count - parameters_;
    extend(columns_, k, factor, [&](Index i, Index c) {
      if (c < first) return 0.0;
      return i < n_ ? factor * by_parameters_before_(n_ + i, c - first) - by_parameters_(i, c - first) : -by_parameters_(n_ + i, c - first);
    });
    if (pairs_.count == 0) return;
    bilinear_.note(sweep_, columns_, k);
    const Eigen::MatrixXd& summands = bilinear_.summands(columns_, k, factor);
    extend(pairs_, k, factor, [&](Index i, Index c) { return summands(i, c); });
  }

  // P, G and C, P_θ, F_θ and c_θ, and W′.
  void note_slopes(int k) {
    for (Bend& of : bends_) of.series[index(k)] = sweep_.latest(of.slot);
    by_parameters_.swap(by_parameters_before_);
    const int* slot = slopes_at_.data();
    for (Index r = 0; r < state_ + rows_; ++r) {
      for (Index l = 0; l < state_; ++l) slopes_(state_ * (highest_ - k) + l, r) = sweep_.latest(*slot++);
      for (Index j = 0; j < parameters_; ++j) by_parameters_(r, j) = sweep_.latest(*slot++);
    }
  }

  // Order k of λ·W′ and λ·W_θ, added to G and F_θ, which are that of the order before the latest.
  void bend(int k) {
    for (const Bend& of : bends_) {
      double sum = 0.0;
      for (int j = 0; j <= k; ++j) sum += constraints_.multipliers()(of.row, j) * of.series[index(k - j)];
      if (of.by < state_) slopes_(state_ * (highest_ - k) + of.by, n_ + of.force) += sum;
      else by_parameters_before_(n_ + of.force, of.by - state_) += sum;
    }
  }

  // Order k of columns or pairs.
  void extend(SeriesColumns& of, int k, double factor, const auto& summand) {
    for (Index i = 0; i < n_ + rows_; ++i) of.sum(weights_.col(i).data(), state_ * k, 0, of.sums_of(i));
    for (Index c = 0; c < of.count; ++c) {
      for (Index i = 0; i < n_; ++i) of.at(k, i, c) = factor * of.at(k - 1, n_ + i, c);
      const auto known = [&](Index i, Index row) {
        double sum = of.sums_of(i)[c] + summand(i, c);
        for (Index l = 0; l < n_; ++l) sum -= slopes_(state_ * highest_ + l, row) * of.at(k, l, c);
        return sum;
      };
      for (Index i = 0; i < n_; ++i) solution_[i] = known(i, i);
      if (rows_ > 0) solve_with_reactions(k, factor, c, known);
      else factors_.solve_mass(solution_.data());
      for (Index i = 0; i < n_; ++i) of.at(k, n_ + i, c) = solution_[i];
      for (Index i = 0; i < state_; ++i) coefficients_(of.place + state_ * c + i, k) = of.at(k, i, c);
    }
  }

  // δq̇_k in solution_, and δλ_{k−1} of column c. On constraints c = 0 with W = ∂c/∂q̇ and d/dt p = F + Wᵀλ, a column has a δλ of its own, one order behind,
  //
  //     d/dt (P x_a + P_θ) = (G + λ·W′) x_a + F_θ + λ·W_θ + Wᵀ δλ ,          C x_a + c_θ = 0 ,      C = ∂c/∂(q, q̇) = [∂c/∂q, W] ,
  //
  // and is solved for with the motion's own matrix [M₀ −W₀ᵀ; W₀ 0] (integrate/steps/taylor_constraints.hpp). There are no pairs on constraints.
  void solve_with_reactions(int k, double factor, Index c, const auto& known) {
    auto reactions = reactions_.middleCols(c * highest_, highest_);
    for (int j = 1; j < k; ++j)
      for (Index r = 0; r < rows_; ++r)
        for (Index i = 0; i < n_; ++i) solution_[i] += factor * slopes_(state_ * (highest_ - j) + n_ + i, state_ + r) * reactions(r, k - 1 - j);
    for (Index r = 0; r < rows_; ++r) known_[r] = known(n_ + r, state_ + r);
    constraints_.solve_in_place(solution_, known_);
    reactions.col(k - 1) = known_ / factor;
  }

  struct Bend {  // a slope of an entry of W, by a state or a parameter
    int slot;
    Index row, force, by;
    std::vector<double> series;
  };

  VariationalEquations* equations_;
  bool holds_ = true;  // the recording, as far as it was asked
  int highest_;
  Index n_, state_, rows_ = 0, parameters_ = 0;
  RecordedVariations recorded_;
  taylor::Sweep sweep_;
  std::vector<int> slopes_at_;  // slots of (P P_θ), (G F_θ) and (C c_θ), row by row
  std::vector<Bend> bends_;     // those that are not zero
  std::vector<std::string> names_;
  SeriesColumns columns_, pairs_;
  BilinearSeries<> bilinear_;
  ConstraintSeries<> constraints_;
  Eigen::MatrixXd slopes_;                                // a column for each row of P, G and C, the highest order first, and zeros
  Eigen::MatrixXd by_parameters_, by_parameters_before_;  // the latest order of P_θ, F_θ and c_θ, and that before
  Eigen::MatrixXd reactions_;                             // the orders of δλ, column of Φ by column
  Eigen::MatrixXd weights_, coefficients_, M_;
  DenseConstrainedFactors<Dynamic> factors_;
  Eigen::VectorXd solution_, known_;
  double unit_ = 1.0;
};

}  // namespace qdot::detail
