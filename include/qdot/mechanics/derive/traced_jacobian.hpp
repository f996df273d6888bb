#pragma once
// SPDX-License-Identifier: MIT
//
// The Jacobian of a motion from the lines of its equations.
//
// Forces, constraints and their multipliers, states of effects: all are nodes of one graph (mechanics/derive/traced_equations.hpp), and
// what implicit methods ask for is more of the same graph, as long as the terms are and not as there are pairs of components:
//
//     M q̈ − Jᵀλ = r ,   J q̈ = γ                                     lines of M, r, J, γ and a solution
//     M ∂q̈ − Jᵀ∂λ = ∂(r − M q̈ + Jᵀλ) ,   J ∂q̈ = ∂(γ − J q̈)          lines of the right sides, and a solution for each component of y
//
// M and J are small here and taken as dense (mechanics/derive/dense_factors.hpp), four columns of the right sides at a time; columns on
// which nothing depends are left out when the lines are written. Up to n = 4 the compiler knows n, and all that is not lines is
// straight-line code: at two or three coordinates it had taken more than half of the time, and each line that says that something is zero
// or constant as much as any other.
//
// Contacts, ropes and dry friction switch. Their phases are numbers in a recording (effects/rows/recorded_effects.hpp), which has rows of
// those constraints only that are active; for each combination of phases that is met there is a recording of its own.
//
// Where M may be singular by itself, constraints lend it inertia: M + ϱ JᵀJ, and ϱ Jᵀ times the lower side in the upper. Whatever is not
// as it should be (a pivot that is too small, redundant rows, a number that is not finite) is left to those who know what to do.

#include <Eigen/Core>
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/mechanics/derive/dense_factors.hpp"
#include "qdot/mechanics/derive/traced_motion.hpp"

namespace qdot::detail {

/// Sizes of pivots that are none: of M, and of the rows of constraints. Where M may be singular, constraints are to lend it inertia.
struct LimitsOfPivots {
  double singular, dependent;
  bool may_be_singular = false;
};

/// q̈, ż and ∂ẏ/∂y of one object, y = [q; q̇; z].
///
/// @tparam n_at_compile_time  n, if it is small; otherwise Dynamic
template <int n_at_compile_time>
class TracedJacobian {
  using Factors = DenseConstrainedFactors<n_at_compile_time>;
  using Four = FourColumns;

 public:
  [[gnu::cold]] TracedJacobian(TracedEquations<> equations, const LimitsOfPivots& limits)
      : lines_(std::move(equations)), limits_(limits), factors_(lines_.equations().n(), lines_.equations().rows()),
        a_(numbers_of<decltype(a_)>(lines_.equations().n())), upper_(numbers_of<decltype(upper_)>(a_.size())),
        lambda_(lines_.equations().rows()), lower_(lambda_.size()), own_ydot_(columns()) {
    TracedEquations<>& e = lines_.equations();
    if (factors_.m == 0) limits_ = {.singular = singular_pivot<double>(static_cast<Eigen::Index>(factors_.n)), .dependent = 0.0};
    const TracedEquations<>::Slopes slopes = e.slopes();
    const int zero = e.graph().constant(0.0), size = static_cast<int>(factors_.n);
    std::vector<int> mass = in_rows(e.mass, 0, size, zero), J = in_rows(e.J, 0, size, zero), blocks;
    for (int first = 0; first < static_cast<int>(columns()); first += 4) {
      std::vector<int> block = in_rows(slopes.motion, first, 4, zero);
      append(block, in_rows(slopes.constraints, first, 4, zero));
      if (std::count(block.begin(), block.end(), zero) == std::ssize(block)) {
        append(empty_columns_, {first, first + 1, first + 2, first + 3});
      } else {
        first_columns_.push_back(first);
        append(blocks, block);
      }
    }
    std::vector<int> outputs = e.right, rates = e.zdot;
    rates.resize(e.states(), zero);  // phases alone have none
    for (const std::vector<int>& more : {rates, mass, J, e.gamma, lines_.required()}) append(outputs, more);
    equations_ = lines_.written(outputs);
    outputs = blocks;
    append(outputs, slopes.states.nodes());
    further_ = lines_.written(outputs);
    right_ = lines_.numbers(e.right);
    zdot_ = lines_.numbers(rates);
    gamma_ = lines_.numbers(e.gamma);
    mass_ = lines_.numbers(mass);
    J_ = lines_.numbers(J);
    blocks_ = lines_.numbers(blocks);
    states_ = slopes.states;
    for (SparseEntries::Entry& entry : states_.entries) entry.what = lines_.numbers({entry.what})[0];
    is_known_ = further_->table().lines.size() <= most_lines;
  }

  bool is_known() const { return is_known_; }

  /// ydot ← ẏ, if it is wanted, and out ← ∂ẏ/∂y; false where another way must see to it.
  bool write(double t, const double* y, double* ydot, Eigen::Ref<Eigen::MatrixXd> out) {
    const auto n = factors_.n;
    const std::size_t m = factors_.m;
    const std::size_t states = zdot_.size();
    const Eigen::Index stride = out.outerStride();
    double* const inputs = lines_.inputs();
    each(n, [&](auto i) __attribute__((always_inline)) {
      inputs[i] = y[i];
      inputs[n + i] = y[n + i];
    });
    inputs[2 * n] = t;
    for (std::size_t k = 0; k < states; ++k) inputs[2 * n + 1 + k] = y[2 * n + k];
    lines_.carry_out(*equations_);
    if (!lines_.hold_requirements()) return false;
    each(n, [&](auto i) __attribute__((always_inline)) {
      each(n, [&](auto j) __attribute__((always_inline)) { factors_.M[i * n + j] = at(mass_, i * n + j); });
      a_[i] = at(right_, i);
    });
    for (std::size_t k = 0; k < m * n; ++k) factors_.J[k] = at(J_, k);
    for (std::size_t k = 0; k < m; ++k) lambda_[k] = at(gamma_, k);
    const double rho = limits_.may_be_singular ? lent_inertia() : 0.0;
    lend(rho, a_, lambda_);
    if (!factors_.compute(limits_.singular, limits_.dependent)) return false;
    factors_.solve(a_.data(), lambda_.data());
    if (!ydot) ydot = own_ydot_.data();
    double zero = 0.0;
    double* const accelerations = inputs + 2 * n + 1 + states;
    each(n, [&](auto i) __attribute__((always_inline)) {
      ydot[i] = y[n + i];
      ydot[n + i] = accelerations[i] = a_[i];
      zero += a_[i] - a_[i];
    });
    for (std::size_t k = 0; k < states; ++k) {
      ydot[2 * n + k] = lines_[zdot_[k]];
      zero += ydot[2 * n + k] - ydot[2 * n + k];
    }
    for (std::size_t k = 0; k < m; ++k) accelerations[n + k] = lambda_[k];
    lines_.carry_out(*further_);
    const auto write_column = [&](int j, const auto& acceleration) __attribute__((always_inline)) {
      if (j >= static_cast<int>(own_ydot_.size())) return;
      double* const column = out.data() + j * stride;
      each(n, [&](auto i) __attribute__((always_inline)) {
        column[i] = static_cast<std::size_t>(j) == n + i ? 1.0 : 0.0;
        column[n + i] = acceleration(i);
      });
      for (std::size_t k = 0; k < states; ++k) column[2 * n + k] = 0.0;
    };
    for (const int j : empty_columns_) write_column(j, [](auto) { return 0.0; });
    const int* places = blocks_.data();
    FourColumns::Two not_finite{};
    std::conditional_t<n_at_compile_time == Dynamic, decltype(upper_)&, decltype(upper_)> upper = upper_;
    for (const int first : first_columns_) {
      each(n, [&](auto i) __attribute__((always_inline)) { read(upper[i], places + 4 * i); });
      places += 4 * n;
      for (Four& row : lower_) {
        read(row, places);
        places += 4;
      }
      lend(rho, upper, lower_);
      factors_.solve(upper.data(), lower_.data());
      write_column(first, [&](auto i) { return upper[i].first[0]; });
      write_column(first + 1, [&](auto i) { return upper[i].first[1]; });
      write_column(first + 2, [&](auto i) { return upper[i].second[0]; });
      write_column(first + 3, [&](auto i) { return upper[i].second[1]; });
      each(n, [&](auto i) __attribute__((always_inline)) { not_finite += (upper[i].first - upper[i].first) + (upper[i].second - upper[i].second); });
    }
    for (std::size_t k = 0; k < states_.rows(); ++k)
      for (const auto& entry : states_.row(k)) {
        const double slope = lines_[entry.what];
        out(static_cast<Eigen::Index>(2 * n + k), entry.column) = slope;
        zero += slope - slope;
      }
    return zero + not_finite[0] + not_finite[1] == 0.0;
  }

  template <class Run>
  bool still_holds(const Run& run) {
    return lines_.still_holds(run);
  }

 private:
  static constexpr std::size_t most_lines = 100'000;

  std::size_t columns() const { return 2 * lines_.equations().n() + lines_.equations().states(); }

  double at(const std::vector<int>& numbers, std::size_t k) const { return lines_[numbers[k]]; }
  [[gnu::always_inline]] void read(Four& row, const int* numbers) const {
    row.first = FourColumns::Two{lines_[numbers[0]], lines_[numbers[1]]};
    row.second = FourColumns::Two{lines_[numbers[2]], lines_[numbers[3]]};
  }

  // Some columns of entries, row by row, with what is not there.
  [[gnu::cold]] static std::vector<int> in_rows(const SparseEntries& entries, int first, int count, int zero) {
    std::vector<int> all;
    for (std::size_t i = 0; i < entries.rows(); ++i) {
      std::vector<int> row(static_cast<std::size_t>(count), zero);
      for (const auto& [column, node] : entries.row(i))
        if (column >= first && column < first + count) row[static_cast<std::size_t>(column - first)] = node;
      append(all, row);
    }
    return all;
  }

  // M ← M + ϱ JᵀJ with a ϱ that makes both parts alike; ϱ.
  double lent_inertia() {
    const std::size_t n = factors_.n;
    own_J_ = factors_.J;
    double inertia = 0.0, size = 0.0;
    for (std::size_t i = 0; i < n; ++i) inertia += factors_.M[i * n + i];
    for (const double w : own_J_) size += w * w;
    const double rho = inertia / size;
    for (const double* row = own_J_.data(); row != own_J_.data() + own_J_.size(); row += static_cast<std::ptrdiff_t>(n))
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j <= i; ++j) factors_.M[i * n + j] += rho * row[i] * row[j];
    return rho;
  }
  // upper ← upper + ϱ Jᵀ lower.
  template <class Upper, class Lower>
  void lend(double rho, Upper& upper, const Lower& lower) const {
    if (rho == 0.0) return;
    for (std::size_t k = 0; k < factors_.m; ++k)
      for (std::size_t i = 0; i < factors_.n; ++i) add(upper[i], rho * own_J_[k * factors_.n + i], lower[k]);
  }

  TracedLines<> lines_;
  LimitsOfPivots limits_;
  Factors factors_;
  typename Factors::template Upper<double> a_;
  typename Factors::template Upper<Four> upper_;
  std::vector<double> lambda_;
  std::vector<Four> lower_;
  std::shared_ptr<const formula::LineEvaluator> equations_, further_;
  std::vector<int> right_, zdot_, gamma_, mass_, J_, first_columns_, empty_columns_, blocks_;
  SparseEntries states_;
  std::vector<double> own_J_, own_ydot_;
  bool is_known_ = false;
};

/// The traced Jacobians that a form keeps, one for each combination of phases in which it is asked: made when it is first asked for, and again where a method
/// begins and the functors are others by then.
///
/// A form has phases(y), recorded(phases), record_again(), limits_of_pivots(). Those whose Jacobian nobody asks for are not traced for it,
/// nor is that compiled.
template <class Form, int n>
class KeptJacobian {
  using Jacobian = TracedJacobian<unrolled_size<n>>;

 public:
  /// As TracedJacobian::write(); false where there is none, or where it would be too large.
  bool write(const Form& form, Eigen::Index dof, double t, const double* y, double* ydot, Eigen::Ref<Eigen::MatrixXd> out) const {
    if (dof > largest) return false;
    run_.store([](const Form& f, RecordedMotion& m) { f.record_again(m); }, std::memory_order_relaxed);
    const auto phases = form.phases(y);
    return kept_.use(phases, [&] { return Jacobian(form.recorded(phases), form.limits_of_pivots()); },
                     [&](Jacobian& jacobian) { return jacobian.write(t, y, ydot, out); });
  }
  void renew(const Form& form) {
    if (const Run run = run_.load(std::memory_order_relaxed)) kept_.renew([&](RecordedMotion& m) { run(form, m); });
  }

  KeptJacobian() = default;
  KeptJacobian(const KeptJacobian& other) : kept_(other.kept_), run_(other.run_.load(std::memory_order_relaxed)) {}
  KeptJacobian& operator=(const KeptJacobian& other) {
    kept_ = other.kept_;
    run_.store(other.run_.load(std::memory_order_relaxed), std::memory_order_relaxed);
    return *this;
  }

 private:
  using Run = void (*)(const Form&, RecordedMotion&);
  static constexpr Eigen::Index largest = 128;

  KeptMotion<Jacobian> kept_;
  mutable std::atomic<Run> run_{nullptr};  // null as long as nobody has asked
};

}  // namespace qdot::detail
