#pragma once
// SPDX-License-Identifier: MIT
//
// Newton's equations of an implicit step for many coordinates, from traced equations (mechanics/derive/traced_equations.hpp).
//
// With S = ∂(r − M q̈ + Jᵀλ) and G = ∂(γ − J q̈) at fixed q̈ and λ, small changes of the state satisfy
//
//     M δq̈ − Jᵀδλ = S_q δq + S_q̇ δq̇ ,      J δq̈ = G_q δq + G_q̇ δq̇ .
//
// (1 − γ ∂f/∂y) x = b means x_q = b_q + γ x_q̇ and x_q̇ = b_q̇ + γ δq̈ with δq = x_q, δq̇ = x_q̇, so that
//
//     [ M − γ S_q̇ − γ² S_q   −Jᵀ ] [δq̈]     [ S_q (b_q + γ b_q̇) + S_q̇ b_q̇ ]
//     [ J − γ G_q̇ − γ² G_q    0  ] [δλ]  =  [ G_q (b_q + γ b_q̇) + G_q̇ b_q̇ ] .
//
// This matrix is sparse, where ∂f/∂y is dense as soon as M or J M⁻¹ Jᵀ has a dense inverse. Its pattern is known when the
// equations are traced; Eigen's SparseLU orders it once. Redundant rows of J would make it singular: the zeros of its diagonal
// are 1e-10 of that of J M⁻¹ Jᵀ, which Newton's iteration does not notice.

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>
#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/integrate/cvode/banded.hpp"
#include "qdot/integrate/cvode/newton.hpp"
#include "qdot/integrate/watch/driven_form.hpp"
#include "qdot/mechanics/derive/traced_motion.hpp"

namespace qdot::detail::cvode {

/// Of a system that has equations.
template <class Number = double>
class SparseNewton final : public NewtonEquations {
 public:
  /// @throws whatever tracing throws
  SparseNewton(const MethodForm& form, TracedEquations<double> equations, SUNContext context) : NewtonEquations(context), form_(form) {
    take(std::move(equations));
  }

  /// Traces again where the functors are others by now.
  [[gnu::cold]] void renew() override {
    const auto run = [](const void* form, RecordedMotion& m, std::vector<char>*) { static_cast<const MethodForm*>(form)->run_functors(m); };
    if (!lines_->still_holds({.form = &form_, .run = run, .key = run, .print = nullptr, .dof = form_.dof()})) take(std::move(*form_.equations()));
  }

  void linearize(double t, const Eigen::Ref<const Eigen::VectorXd>& y) override {
    form_.accelerate(t, y.data(), acceleration_.data(), multipliers_.data());
    lines_->set(y.data(), y.data() + n(), t, y.data());
    lines_->set_accelerations(acceleration_.data());
    std::copy_n(multipliers_.data(), rows(), lines_->multipliers());
    lines_->carry_out(*table_);
  }

  void assemble(double gamma) override {
    gamma_ = gamma;
    std::fill_n(A_.valuePtr(), A_.nonZeros(), 0.0);
    const double factors[] = {1.0, -1.0, -gamma, -gamma * gamma};
    for (const Part& part : parts_) A_.valuePtr()[part.place] += factors[part.power] * (*lines_)[part.number];
    for (const Part& part : softened_) {
      const double entry = (*lines_)[part.number], inertia = (*lines_)[part.power];
      if (inertia > 0.0) A_.valuePtr()[part.place] += softness * entry * entry / inertia;
    }
  }

 private:
  // factors[power] times a number, added to an entry.
  struct Part {
    Eigen::Index place;
    int power, number;
  };

  static constexpr double softness = 1e-10;

  std::size_t n() const { return acceleration_.size(); }
  std::size_t rows() const { return multipliers_.size(); }

  [[gnu::cold]] void take(TracedEquations<double> equations) {
    lines_ = std::make_unique<TracedLines<>>(std::move(equations));
    TracedEquations<double>& e = lines_->equations();
    if (e.states() > 0) throw InvalidValue("sparse Newton equations know of no states of effects");
    acceleration_.resize(e.n());
    multipliers_.resize(e.rows());
    right_.resize(static_cast<Eigen::Index>(e.n() + e.rows()));
    auto slopes = e.slopes();
    std::vector<int> outputs = slopes.motion.nodes();
    for (const SparseEntries* more : {&slopes.constraints, &e.mass, &e.J}) append(outputs, more->nodes());
    table_ = lines_->written(outputs);
    place(e, slopes);
  }

  // Entry (i, j) and its mirror are places in A; entries of the slopes are kept for the right side as well.
  [[gnu::cold]] void place(const TracedEquations<double>& e, const TracedEquations<double>::Slopes& slopes) {
    struct Entry {
      std::size_t row, column;
      int power, node;
    };
    std::vector<Entry> entries;
    const std::size_t first_row = e.n();
    const auto each = [](const SparseEntries& all, const auto& visit) {
      for (std::size_t i = 0; i < all.rows(); ++i)
        for (const auto& entry : all.row(i)) visit(i, static_cast<std::size_t>(entry.column), entry.what);
    };
    each(e.mass, [&](std::size_t i, std::size_t j, int node) {
      entries.push_back({i, j, 0, node});
      if (i != j) entries.push_back({j, i, 0, node});
    });
    each(e.J, [&](std::size_t k, std::size_t j, int node) {
      entries.push_back({first_row + k, j, 0, node});
      entries.push_back({j, first_row + k, 1, node});
    });
    slopes_.clear();
    const auto add_slopes = [&](const SparseEntries& all, std::size_t first) {
      each(all, [&](std::size_t i, std::size_t j, int node) {
        const bool of_q = j < e.n();
        entries.push_back({first + i, of_q ? j : j - e.n(), of_q ? 3 : 2, node});
        slopes_.push_back({static_cast<Eigen::Index>(first + i), static_cast<int>(j), lines_->numbers({node})[0]});
      });
    };
    add_slopes(slopes.motion, 0);
    add_slopes(slopes.constraints, first_row);
    std::vector<Eigen::Triplet<Number>> pattern;
    for (std::size_t k = 0; k < rows(); ++k) pattern.emplace_back(static_cast<int>(first_row + k), static_cast<int>(first_row + k), 1.0);
    for (const Entry& x : entries) pattern.emplace_back(static_cast<int>(x.row), static_cast<int>(x.column), 1.0);
    A_.resize(right_.size(), right_.size());
    A_.setFromTriplets(pattern.begin(), pattern.end());
    const auto place = [this](std::size_t row, std::size_t column) {
      const int *const begin = A_.innerIndexPtr() + A_.outerIndexPtr()[column], *const end = A_.innerIndexPtr() + A_.outerIndexPtr()[column + 1];
      return static_cast<Eigen::Index>(std::lower_bound(begin, end, static_cast<int>(row)) - A_.innerIndexPtr());
    };
    parts_.clear();
    for (const Entry& x : entries) parts_.push_back({place(x.row, x.column), x.power, lines_->numbers({x.node})[0]});
    softened_.clear();
    each(e.J, [&](std::size_t k, std::size_t j, int node) {
      if (!e.mass.row(j).empty() && static_cast<std::size_t>(e.mass.row(j).back().column) == j)
        softened_.push_back({place(first_row + k, first_row + k), lines_->numbers({e.mass.row(j).back().what})[0], lines_->numbers({node})[0]});
    });
    factors_.analyzePattern(A_);
  }

  int factor() override {
    factors_.factorize(A_);
    return succeeded(factors_) ? 0 : 1;  // recoverable: another step has another γ
  }

  int solve(double* x, const double* b) override {
    const std::size_t size = n();
    right_.setZero();
    for (const Part& slope : slopes_) {
      const auto j = static_cast<std::size_t>(slope.power);
      right_[slope.place] += (*lines_)[slope.number] * (j < size ? b[j] + gamma_ * b[size + j] : b[j]);
    }
    const Vector<Number, Dynamic> change = factors_.solve(right_);
    for (std::size_t i = 0; i < size; ++i) {
      x[size + i] = b[size + i] + gamma_ * change[static_cast<Eigen::Index>(i)];
      x[i] = b[i] + gamma_ * x[size + i];
    }
    return 0;
  }

  const MethodForm& form_;
  std::unique_ptr<TracedLines<>> lines_;
  std::shared_ptr<const formula::LineEvaluator> table_;
  std::vector<double> acceleration_, multipliers_;
  std::vector<Part> parts_, slopes_;  // of a slope: row of the right side, component of the state, number
  std::vector<Part> softened_;        // place, number of an inertia, number of an entry of J
  double gamma_ = 0.0;
  Eigen::VectorXd right_;
  Eigen::SparseMatrix<Number> A_;
  Eigen::SparseLU<Eigen::SparseMatrix<Number>> factors_;
};

template <class Number>
std::unique_ptr<NewtonEquations> newton_equations(const MethodForm& system, SUNContext context) {
  constexpr Eigen::Index dense_limit = 128;  // components
  if (system.size() <= dense_limit) return nullptr;
  try {
    if (auto equations = system.equations()) return std::make_unique<SparseNewton<Number>>(system, std::move(*equations), context);
  } catch (...) {  // no formulas
  }
  if (system.has_band()) return std::make_unique<BandedNewton>(system, context);
  return nullptr;
}

}  // namespace qdot::detail::cvode
