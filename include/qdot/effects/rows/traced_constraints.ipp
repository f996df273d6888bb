#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of traced_constraints.hpp. A program that links qdot::compiled has them from there.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "qdot/ad/formula/in_order.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/effects/rows/sparse_solve.ipp"
#include "qdot/effects/rows/traced_constraints.hpp"
#include "qdot/mechanics/derive/traced_motion.hpp"

namespace qdot::detail {

template <class Number = double>
class ConstraintsByLines final : public TracedConstraints {
 public:
  /// @param cutoff  relative size below which a row of J counts as dependent, where it is not left to the general way
  [[gnu::cold]] ConstraintsByLines(TracedEquations<Number> equations, double cutoff)
      : lines_(std::move(equations)), cutoff_(cutoff), dependent_(clearly_independent * cutoff * cutoff) {
    TracedEquations<Number>& e = lines_.equations();
    for (std::size_t i = 0; i < e.n(); ++i)
      if (e.mass.row(i).empty() || static_cast<std::size_t>(e.mass.row(i).back().column) != i) return;
    J_.starts = e.J.starts;
    for (const auto& entry : e.J.entries) J_.entries.push_back({entry.column, 0.0});
    std::vector<int> outputs;
    if (e.mass_is_diagonal) {
      const std::vector<int> free = free_accelerations(), schur = schur_entries(), wanted = wanted_of_multipliers(free);
      factors_.emplace(e.rows(), schur_rows_, schur_columns_);
      for (std::size_t k = 0; k < schur_rows_.size(); ++k)
        if (schur_rows_[k] == schur_columns_[k]) diagonal_.push_back(k);
      outputs = schur;
      append(outputs, wanted);
      append(outputs, free);
      append(outputs, e.J.nodes());
      write_table(outputs);
      right_ = lines_.numbers(free);
      wanted_ = lines_.numbers(wanted);
      schur_ = lines_.numbers(schur);
      const std::vector<int> pulled = accelerations_of_multipliers();
      pull_table_ = lines_.written(pulled);
      pulled_ = lines_.numbers(pulled);
    } else {
      outputs = e.right;
      append(outputs, e.gamma);
      append(outputs, e.J.nodes());
      write_table(outputs);
      right_ = lines_.numbers(e.right);
      wanted_ = lines_.numbers(e.gamma);
      for (std::size_t i = 0; i < e.n(); ++i) reach_ = std::max(reach_, static_cast<Eigen::Index>(i) - e.mass.row(i)[0].column);
    }
    J_numbers_ = lines_.numbers(e.J.nodes());
    mass_ = lines_.numbers(e.mass.nodes());
    own_lambda_.resize(e.rows());
    if (e.mass_is_diagonal && e.mass_is_constant)
      for (const int node : e.mass.nodes())
        if (!(e.graph()[node].c > 0.0)) return;
    is_known_ = true;
  }

  bool is_known() const override { return is_known_; }
  std::unique_ptr<Traced> copy() const override { return std::make_unique<ConstraintsByLines>(*this); }
  bool still_holds(const RecordableForm& form) override { return lines_.still_holds(form); }
  bool are_native() const override { return lines_.are_native(); }
  bool are_long() const override { return lines_.are_long(); }
  std::size_t n() const override { return lines_.equations().n(); }
  std::size_t rows() const override { return lines_.equations().rows(); }

  bool move_to(const double* q, const double* qdot, double t, const double* z) override {
    lines_.set(q, qdot, t, z);
    lines_.carry_out(*table_);
    if (!lines_.hold_requirements() || !masses_are_positive()) return false;
    has_rows_ = false;
    if (factors_) return factors_->compute([&](std::size_t k) { return lines_[schur_[k]]; }, dependent_, redundant_pivot) && factors_->zeros() <= most_zeros_;
    M_ = mass();
    return both_.compute(M_, jacobian(), massless_pivot, dependent_);
  }

  bool write(const double* q, const double* qdot, double t, const double* z, double* a, double* lambda, double* zdot) override {
    const bool wants_lambda = lambda != nullptr;
    if (!lambda) lambda = own_lambda_.data();
    if (!move_to(q, qdot, t, z)) return false;
    double zero = 0.0;
    for (std::size_t k = 0; k < zdot_.size(); ++k) {
      zdot[k] = lines_[zdot_[k]];
      zero += zdot[k] - zdot[k];
    }
    for (std::size_t i = 0; i < n(); ++i) a[i] = lines_[right_[i]];
    for (std::size_t k = 0; k < rows(); ++k) lambda[k] = lines_[wanted_[k]];
    const double most_missed = factors_ && factors_->zeros() > 0 ? 1e2 * cutoff_ * size_of_terms(lambda, a) : 0.0;
    if (!solve(lambda, a, most_missed)) return false;
    if (wants_lambda && factors_ && factors_->zeros() > 0 && !shorten(lambda)) return false;
    for (std::size_t i = 0; i < n(); ++i) zero += a[i] - a[i];
    for (std::size_t k = 0; k < rows(); ++k) zero += lambda[k] - lambda[k];
    return zero == 0.0;
  }

  bool displacement(double* b, double* delta) override {
    std::fill_n(delta, n(), 0.0);
    return solve(b, delta, std::numeric_limits<double>::infinity());
  }

  std::size_t rank() const override { return rows() - (factors_ ? factors_->zeros() : 0); }

  void pull(const double* lambda, double* forces) override {
    std::fill_n(forces, n(), 0.0);
    const SparseRows& J = jacobian();
    for (std::size_t k = 0; k < rows(); ++k)
      for (const SparseRows::Entry* entry = J.begin(k); entry != J.end(k); ++entry) forces[entry->column] += lambda[k] * entry->value;
  }

  const SparseRows& jacobian() override {
    if (!has_rows_)
      for (std::size_t k = 0; k < J_numbers_.size(); ++k) J_.entries[k].value = lines_[J_numbers_[k]];
    has_rows_ = true;
    return J_;
  }

  BandedMatrix mass() const override {
    const SparseEntries& entries = lines_.equations().mass;
    BandedMatrix M(static_cast<Eigen::Index>(n()), reach_);
    std::size_t k = 0;
    for (std::size_t i = 0; i < n(); ++i)
      for (const auto& entry : entries.row(i)) M(static_cast<Eigen::Index>(i), entry.column) = lines_[mass_[k++]];
    return M;
  }

 private:
  static constexpr std::size_t most_zeros_ = 64;

  formula::BasicGraph<Number>& graph() { return lines_.equations().graph(); }
  // Of a diagonal M; another is factored.
  bool masses_are_positive() const {
    bool positive = true;
    if (factors_ && !lines_.equations().mass_is_constant)
      for (const int number : mass_) positive = positive && lines_[number] > 0.0;
    return positive;
  }

  int mass_of(int i) { return lines_.equations().mass.row(static_cast<std::size_t>(i))[0].what; }

  [[gnu::cold]] void write_table(std::vector<int>& outputs) {
    const TracedEquations<Number>& e = lines_.equations();
    append(outputs, e.mass.nodes());
    append(outputs, e.zdot);
    append(outputs, lines_.required());
    table_ = lines_.written(outputs);
    zdot_ = lines_.numbers(e.zdot);
  }

  [[gnu::cold]] std::vector<int> free_accelerations() {
    std::vector<int> u;
    for (std::size_t i = 0; i < n(); ++i) u.push_back(graph().quotient(lines_.equations().right[i], mass_of(static_cast<int>(i))));
    return u;
  }

  // Entries of J M⁻¹ Jᵀ on and below the diagonal, row by row.
  [[gnu::cold]] std::vector<int> schur_entries() {
    const SparseEntries& J = lines_.equations().J;
    std::vector<std::vector<std::pair<int, int>>> touching(n());  // rows and their entries in a column, so far
    std::vector<int> nodes;
    for (std::size_t k = 0; k < J.rows(); ++k) {
      std::vector<std::pair<int, int>> products;  // the other row, and what one coordinate adds
      for (const auto& [i, w] : J.row(k)) {
        auto& column = touching[static_cast<std::size_t>(i)];
        column.emplace_back(static_cast<int>(k), w);
        const int moved = graph().quotient(w, mass_of(i));
        for (const auto& [row, other] : column) products.emplace_back(row, graph().product(moved, other));
      }
      formula::put_in_order(products, [](const auto& x, const auto& y) { return x.first < y.first; });
      for (const auto& [row, part] : products) {
        if (!schur_rows_.empty() && schur_rows_.back() == static_cast<int>(k) && schur_columns_.back() == row) {
          nodes.back() = graph().sum(nodes.back(), part);
        } else {
          schur_rows_.push_back(static_cast<int>(k));
          schur_columns_.push_back(row);
          nodes.push_back(part);
        }
      }
    }
    return nodes;
  }

  // γ − J u.
  [[gnu::cold]] std::vector<int> wanted_of_multipliers(const std::vector<int>& u) {
    std::vector<int> wanted = lines_.equations().gamma;
    for (std::size_t k = 0; k < wanted.size(); ++k)
      for (const auto& [i, w] : lines_.equations().J.row(k)) wanted[k] = graph().difference(wanted[k], graph().product(w, u[static_cast<std::size_t>(i)]));
    return wanted;
  }

  // M⁻¹Jᵀλ.
  [[gnu::cold]] std::vector<int> accelerations_of_multipliers() {
    std::vector<int> pulled(n(), graph().constant(0.0));
    const SparseEntries& J = lines_.equations().J;
    const int first = static_cast<int>(3 * n() + 1 + lines_.equations().states());
    for (std::size_t k = 0; k < J.rows(); ++k) {
      const int lambda = graph().variable(first + static_cast<int>(k));
      for (const auto& [i, w] : J.row(k)) {
        int& sum = pulled[static_cast<std::size_t>(i)];
        sum = graph().sum(sum, graph().product(w, lambda));
      }
    }
    for (std::size_t i = 0; i < n(); ++i) pulled[i] = graph().quotient(pulled[i], mass_of(static_cast<int>(i)));
    return pulled;
  }

  // The largest of what cancels in a row, each in its own length: |γ − J u| + Σ |Jᵢⱼ uⱼ|.
  [[gnu::cold]] double size_of_terms(const double* wanted, const double* u) {
    const SparseRows& J = jacobian();
    double size = 0.0;
    for (std::size_t k = 0; k < rows(); ++k) {
      double terms = std::abs(wanted[k]);
      for (const SparseRows::Entry* entry = J.begin(k); entry != J.end(k); ++entry) terms += std::abs(entry->value * u[entry->column]);
      if (const double length = std::sqrt(lines_[schur_[diagonal_[k]]]); length > 0.0) size = std::max(size, terms / length);
    }
    return size;
  }

  // lambda ← the shortest of the multipliers that do the same.
  [[gnu::cold]] bool shorten(double* lambda) {
    const auto m = static_cast<Eigen::Index>(rows()), d = static_cast<Eigen::Index>(factors_->zeros());
    Matrix<Number, Dynamic> N(m, d);
    Vector<Number, Dynamic> weight(m);
    for (Eigen::Index k = 0; k < d; ++k) factors_->null_vector(static_cast<std::size_t>(k), N.col(k).data());
    for (Eigen::Index i = 0; i < m; ++i) {
      const double square = lines_[schur_[diagonal_[static_cast<std::size_t>(i)]]];
      weight[i] = square > 0.0 ? square : 1.0;  // a row of zeros has no length
    }
    const Matrix<Number, Dynamic> weighted = weight.asDiagonal() * N;
    Eigen::Map<Vector<Number, Dynamic>> l(lambda, m);
    const Vector<Number, Dynamic> parts = (N.transpose() * weighted).ldlt().solve(weighted.transpose() * l);
    l -= N * parts;
    return l.allFinite();
  }

  // lambda: what is wanted → λ; a: what is there without → with it. False where rows that depend on others miss more than `most` of what they want.
  bool solve(double* lambda, double* a, double most) {
    if (factors_) {
      if (!(factors_->solve(lambda) <= most)) return false;
      std::copy_n(lambda, rows(), lines_.multipliers());
      lines_.carry_out(*pull_table_);
      for (std::size_t i = 0; i < n(); ++i) a[i] += lines_[pulled_[i]];
      return true;
    }
    Eigen::VectorXd force = Eigen::Map<const Eigen::VectorXd>(a, static_cast<Eigen::Index>(n()));
    Eigen::VectorXd wanted = Eigen::Map<const Eigen::VectorXd>(lambda, static_cast<Eigen::Index>(rows()));
    if (!both_.solve(J_, force, wanted)) return false;
    std::copy_n(force.data(), n(), a);
    std::copy_n(wanted.data(), rows(), lambda);
    return true;
  }

  TracedLines<Number> lines_;
  double cutoff_, dependent_;
  std::shared_ptr<const formula::LineEvaluator> table_, pull_table_;
  std::vector<int> right_, wanted_, zdot_, J_numbers_, schur_, pulled_, mass_;
  std::vector<int> schur_rows_, schur_columns_;
  std::vector<std::size_t> diagonal_;  // among them
  std::optional<PatternFactors<Number>> factors_;  // of J M⁻¹ Jᵀ, or else of both
  Eigen::Index reach_ = 0;
  BandedMatrix M_{0, 0};
  EnvelopeFactors<> both_;
  SparseRows J_;
  std::vector<double> own_lambda_;
  bool has_rows_ = false, is_known_ = false;
};

template <class>
[[gnu::cold]] std::unique_ptr<TracedConstraints> traced_constraints(const RecordableForm& form, double cutoff) {
  return std::make_unique<ConstraintsByLines<>>(traced_equations(form), cutoff);
}

}  // namespace qdot::detail
