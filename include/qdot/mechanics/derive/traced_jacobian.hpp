#pragma once
// SPDX-License-Identifier: MIT
//
// The Jacobian of a motion from the lines of its equations.
//
// Forces, constraints and their multipliers, states of effects: all are nodes of one graph (mechanics/derive/traced_equations.hpp), and what implicit methods ask for is
// more of the same graph, as long as the terms are and not as there are pairs of components:
//
//     M q̈ − Jᵀλ = r ,   J q̈ = γ                                     lines of M, r, J, γ and a solution
//     M ∂q̈ − Jᵀ∂λ = ∂(r − M q̈ + Jᵀλ) ,   J ∂q̈ = ∂(γ − J q̈)          lines of the right sides, and a solution for each component of y
//
// M and J are small here and taken as dense: with M = L D Lᵀ, B = L⁻¹Jᵀ and S = Bᵀ D⁻¹ B, rows of right sides are worked on as a whole,
//
//     S ∂λ = ∂(γ − J q̈) − Bᵀ D⁻¹ x ,     ∂q̈ = L⁻ᵀ D⁻¹ (x + B ∂λ) ,     x = L⁻¹ ∂(…) .
//
// Where M may be singular by itself, constraints lend it inertia: M + ϱ JᵀJ, and ϱ Jᵀ times the lower side in the upper. Whatever is not as it should be (a pivot that is too small, redundant
// rows, a number that is not finite) is left to those who know what to do.

#include <Eigen/Core>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "qdot/ad/records/hessian_record.hpp"
#include "qdot/mechanics/derive/traced_motion.hpp"

namespace qdot::detail {

/// L D Lᵀ of M and S for right sides of any number of columns. All matrices are row by row; a row of right sides is `columns` numbers, a multiple of four.
class DenseConstrainedFactors {
 public:
  DenseConstrainedFactors(std::size_t n, std::size_t m) : n_(n), m_(m), L_(n * n), inverse_(n), B_(m * n), S_(m * m), inverse_S_(m) {}

  double* M() { return L_.data(); }  // n×n, the lower triangle
  double* J() { return B_.data(); }  // m×n

  /// False where a pivot of M is not above `threshold` of its diagonal entry, or one of S not above `dependent` of its own.
  bool compute(double threshold, double dependent) {
    if (!factored(L_.data(), n_, inverse_.data(), threshold)) return false;
    for (std::size_t k = 0; k < m_; ++k) {
      double* const b = &B_[k * n_];
      for (std::size_t i = 0; i < n_; ++i)
        for (std::size_t j = 0; j < i; ++j) b[i] -= L_[i * n_ + j] * b[j];
      for (std::size_t l = 0; l <= k; ++l) {
        double sum = 0.0;
        for (std::size_t i = 0; i < n_; ++i) sum += b[i] * inverse_[i] * B_[l * n_ + i];
        S_[k * m_ + l] = sum;
      }
    }
    return factored(S_.data(), m_, inverse_S_.data(), dependent);
  }

  /// upper (n rows) ← M q̈ − Jᵀλ = upper, lower (m rows) ← λ, where J q̈ = lower.
  void solve(double* upper, double* lower, std::size_t columns) const {
    forward(L_.data(), n_, upper, columns);
    for (std::size_t k = 0; k < m_; ++k)
      for (std::size_t i = 0; i < n_; ++i) subtract(lower + k * columns, B_[k * n_ + i] * inverse_[i], upper + i * columns, columns);
    forward(S_.data(), m_, lower, columns);
    backward(S_.data(), m_, inverse_S_.data(), lower, columns);
    for (std::size_t k = 0; k < m_; ++k)
      for (std::size_t i = 0; i < n_; ++i) subtract(upper + i * columns, -B_[k * n_ + i], lower + k * columns, columns);
    backward(L_.data(), n_, inverse_.data(), upper, columns);
  }

 private:
  [[gnu::always_inline]] static void subtract(double* to, double factor, const double* from, std::size_t columns) {
    if (factor == 0.0) return;
    for (std::size_t c = 0; c < columns; c += 4) add_block(to + c, -factor, from + c);
  }
  static bool factored(double* A, std::size_t size, double* inverse, double threshold) {
    for (std::size_t i = 0; i < size; ++i) {
      double* const row = A + i * size;
      const double whole = row[i];
      for (std::size_t j = 0; j < i; ++j) {
        double sum = row[j];
        for (std::size_t k = 0; k < j; ++k) sum -= row[k] * A[j * size + k];
        row[j] = sum;  // l d
      }
      for (std::size_t j = 0; j < i; ++j) {
        const double l = row[j] * inverse[j];
        row[i] -= l * row[j];
        row[j] = l;
      }
      if (!(row[i] > threshold * whole)) return false;
      inverse[i] = 1.0 / row[i];
    }
    return true;
  }
  static void forward(const double* L, std::size_t size, double* rows, std::size_t columns) {
    for (std::size_t i = 1; i < size; ++i)
      for (std::size_t j = 0; j < i; ++j) subtract(rows + i * columns, L[i * size + j], rows + j * columns, columns);
  }
  static void backward(const double* L, std::size_t size, const double* inverse, double* rows, std::size_t columns) {
    for (std::size_t i = 0; i < size; ++i)
      for (std::size_t c = 0; c < columns; c += 4) set_block(rows + i * columns + c, inverse[i], rows + i * columns + c);
    for (std::size_t i = size; i-- > 1;)
      for (std::size_t j = 0; j < i; ++j) subtract(rows + j * columns, L[i * size + j], rows + i * columns, columns);
  }

  std::size_t n_, m_;
  std::vector<double> L_, inverse_, B_, S_, inverse_S_;
};

/// q̈, ż and ∂ẏ/∂y of one object, y = [q; q̇; z].
class TracedJacobian {
 public:
  /// Sizes of pivots that are none: of M, and of the rows of constraints. Where M may be singular, constraints are to lend it inertia.
  struct Limits {
    double singular, dependent;
    bool may_be_singular = false;
  };

  [[gnu::cold]] TracedJacobian(TracedEquations<> equations, const Limits& limits)
      : lines_(std::move(equations)), limits_(limits), factors_(lines_.equations().n(), lines_.equations().rows()) {
    TracedEquations<>& e = lines_.equations();
    const TracedEquations<>::Slopes slopes = e.slopes();
    std::vector<int> outputs = e.right;
    for (const std::vector<int>& more : {e.zdot, e.mass.nodes(), e.J.nodes(), e.gamma, lines_.required()}) append(outputs, more);
    equations_ = lines_.written(outputs);
    outputs = slopes.motion.nodes();
    append(outputs, slopes.constraints.nodes());
    append(outputs, slopes.states.nodes());
    further_ = lines_.written(outputs);
    right_ = lines_.numbers(e.right);
    zdot_ = lines_.numbers(e.zdot);
    gamma_ = lines_.numbers(e.gamma);
    mass_ = numbered(e.mass);
    J_ = numbered(e.J);
    motion_ = numbered(slopes.motion);
    constraints_ = numbered(slopes.constraints);
    states_ = numbered(slopes.states);
    upper_.resize(e.n() * stride());
    lower_.resize(e.rows() * stride());
    own_ydot_.resize(columns());
    is_known_ = further_->lines.size() <= most_lines;
  }

  bool is_known() const { return is_known_; }

  /// ydot ← ẏ, if it is wanted, and out ← ∂ẏ/∂y; false where another way must see to it.
  bool write(double t, const double* y, double* ydot, Eigen::Ref<Eigen::MatrixXd> out) {
    const TracedEquations<>& e = lines_.equations();
    const std::size_t n = e.n(), m = e.rows(), states = e.states();
    lines_.set(y, y + n, t, y + 2 * n);
    lines_.carry_out(*equations_);
    if (!lines_.hold_requirements()) return false;
    write_dense(mass_, factors_.M(), n);
    write_dense(J_, factors_.J(), n);
    for (std::size_t i = 0; i < n; ++i) upper_[4 * i] = lines_[right_[i]];
    for (std::size_t k = 0; k < m; ++k) lower_[4 * k] = lines_[gamma_[k]];
    const double rho = limits_.may_be_singular ? lent_inertia() : 0.0;
    lend(rho, 4);
    if (!factors_.compute(limits_.singular, limits_.dependent)) return false;
    factors_.solve(upper_.data(), lower_.data(), 4);
    if (!ydot) ydot = own_ydot_.data();
    std::copy_n(y + n, n, ydot);
    for (std::size_t i = 0; i < n; ++i) ydot[n + i] = upper_[4 * i];
    for (std::size_t k = 0; k < states; ++k) ydot[2 * n + k] = lines_[zdot_[k]];
    lines_.set_accelerations(ydot + n);
    for (std::size_t k = 0; k < m; ++k) lines_.multipliers()[k] = lower_[4 * k];
    lines_.carry_out(*further_);
    write_dense(motion_, upper_.data(), stride());
    write_dense(constraints_, lower_.data(), stride());
    lend(rho, stride());
    factors_.solve(upper_.data(), lower_.data(), stride());
    double zero = 0.0;
    for (std::size_t j = 0; j < columns(); ++j) {
      double* const column = out.data() + static_cast<std::ptrdiff_t>(j) * out.outerStride();
      for (std::size_t i = 0; i < n; ++i) {
        column[i] = j == n + i ? 1.0 : 0.0;
        column[n + i] = upper_[i * stride() + j];
        zero += column[n + i] - column[n + i];
      }
      std::fill_n(column + 2 * n, states, 0.0);
    }
    for (std::size_t k = 0; k < states; ++k)
      for (const auto& entry : states_.row(k)) {
        const double slope = lines_[entry.what];
        out(static_cast<Eigen::Index>(2 * n + k), entry.column) = slope;
        zero += slope - slope;
      }
    for (std::size_t i = 0; i < 2 * n + states; ++i) zero += ydot[i] - ydot[i];
    return zero == 0.0;
  }

  template <class Run>
  bool still_holds(const Run& run) {
    return lines_.still_holds(run);
  }

 private:
  static constexpr std::size_t most_lines = 100'000;

  std::size_t columns() const { return 2 * lines_.equations().n() + lines_.equations().states(); }

  std::size_t stride() const { return (columns() + 3) / 4 * 4; }

  SparseEntries numbered(const SparseEntries& nodes) const {
    SparseEntries places = nodes;
    const std::vector<int> numbers = lines_.numbers(nodes.nodes());
    for (std::size_t k = 0; k < numbers.size(); ++k) places.entries[k].what = numbers[k];
    return places;
  }
  void write_dense(const SparseEntries& entries, double* to, std::size_t columns) const {
    std::fill_n(to, entries.rows() * columns, 0.0);
    for (std::size_t i = 0; i < entries.rows(); ++i)
      for (const auto& entry : entries.row(i)) to[i * columns + static_cast<std::size_t>(entry.column)] = lines_[entry.what];
  }

  // M ← M + ϱ JᵀJ with a ϱ that makes both parts alike; ϱ.
  double lent_inertia() {
    const std::size_t n = lines_.equations().n();
    own_J_.assign(factors_.J(), factors_.J() + n * lines_.equations().rows());
    double inertia = 0.0, size = 0.0;
    for (std::size_t i = 0; i < n; ++i) inertia += factors_.M()[i * n + i];
    for (const double w : own_J_) size += w * w;
    const double rho = inertia / size;
    for (std::size_t k = 0; k < own_J_.size(); k += n)
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j <= i; ++j) factors_.M()[i * n + j] += rho * own_J_[k + i] * own_J_[k + j];
    return rho;
  }
  // upper ← upper + ϱ Jᵀ lower.
  void lend(double rho, std::size_t columns) {
    const std::size_t n = lines_.equations().n();
    if (rho == 0.0) return;
    for (std::size_t k = 0; k < lines_.equations().rows(); ++k)
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t c = 0; c < columns; ++c) upper_[i * columns + c] += rho * own_J_[k * n + i] * lower_[k * columns + c];
  }

  TracedLines<> lines_;
  Limits limits_;
  DenseConstrainedFactors factors_;
  std::shared_ptr<const formula::LineTable> equations_, further_;
  std::vector<int> right_, zdot_, gamma_;
  SparseEntries mass_, J_, motion_, constraints_, states_;
  std::vector<double> upper_, lower_, own_J_, own_ydot_;
  bool is_known_ = false;
};

/// The traced Jacobian that a form keeps: made when it is first asked for, and again where a method begins and the functors are others by then.
///
/// A form has recorded(), record_again(), limits_of_pivots(). Those whose Jacobian nobody asks for are not traced for it, nor is that compiled.
template <class Form>
class KeptJacobian {
 public:
  /// As TracedJacobian::write(); false where there is none, or where it would be too large.
  bool write(const Form& form, Eigen::Index dof, double t, const double* y, double* ydot, Eigen::Ref<Eigen::MatrixXd> out) const {
    if (dof > largest) return false;
    run_.store([](const Form& f, RecordedMotion& m) { f.record_again(m); }, std::memory_order_relaxed);
    return kept_.use([&form] { return TracedJacobian(form.recorded(), form.limits_of_pivots()); },
                     [&](TracedJacobian& jacobian) { return jacobian.write(t, y, ydot, out); });
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

  KeptMotion<TracedJacobian> kept_;
  mutable std::atomic<Run> run_{nullptr};  // null as long as nobody has asked
};

}  // namespace qdot::detail
