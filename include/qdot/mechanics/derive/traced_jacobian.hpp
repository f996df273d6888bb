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
// Without constraints, of a few coordinates, all of it is one table of lines with the elimination in it, which leaves out what is zero
// (mechanics/derive/solution_lines.hpp). Otherwise M and J are taken as dense (mechanics/derive/dense_factors.hpp), four columns of the right sides at a
// time; columns on which nothing depends are left out when the lines are written. Up to n = 4 the compiler knows n, and all that is not lines is
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

/// q̈, ż and ∂ẏ/∂y of one object, y = [q; q̇; z], and ∂ẏ/∂p of parameters that are variables.
///
/// @tparam n_at_compile_time  n, if it is small; otherwise Dynamic
template <int n_at_compile_time>
class TracedJacobian {
  using Factors = DenseConstrainedFactors<n_at_compile_time>;
  using Four = FourColumns;

 public:
  TracedJacobian(TracedEquations<> equations, const LimitsOfPivots& limits);

  bool is_known() const { return is_known_; }
  void set_parameters(const double* p) {
    const TracedEquations<>& e = lines_.equations();
    parameters_.assign(p, p + e.parameters.size());
    std::copy_n(p, parameters_.size(), lines_.inputs() + 3 * e.n() + 1 + e.states());
  }
  /// Whether all is lines: then several threads may ask write_by_lines() at once.
  bool is_solved() const { return solved_.lines != nullptr; }

  /// ydot ← ẏ, if it is wanted, and out ← ∂ẏ/∂y, then ∂ẏ/∂p; false where another way must see to it.
  bool write(double t, const double* y, double* ydot, Eigen::Ref<Eigen::MatrixXd> out) {
    return is_solved() ? write_by_lines(t, y, ydot, out) : write_by_columns(t, y, ydot, out);
  }
  bool write_by_lines(double t, const double* y, double* ydot, const Eigen::Ref<Eigen::MatrixXd>& out) const {
    return write_by_lines(t, y, ydot, const_cast<double*>(out.data()), out.outerStride());
  }

  template <class Run>
  bool still_holds(const Run& run) {
    return lines_.still_holds(run);
  }

 private:
  static constexpr std::size_t most_lines = 100'000;
  static constexpr std::size_t most_solved = 8;     // coordinates whose elimination is lines
  static constexpr std::size_t most_numbers = 2000;  // of which an evaluation has a vector on the stack

  std::size_t columns() const { return 2 * lines_.equations().n() + lines_.equations().states() + lines_.equations().parameters.size(); }

  double at(const std::vector<int>& numbers, std::size_t k) const { return lines_[numbers[k]]; }
  [[gnu::always_inline]] void read(Four& row, const int* numbers) const {
    row.first = FourColumns::Two{lines_[numbers[0]], lines_[numbers[1]]};
    row.second = FourColumns::Two{lines_[numbers[2]], lines_[numbers[3]]};
  }

  void write_in_lines(const TracedEquations<>::Slopes& slopes);
  void write_in_columns(const TracedEquations<>::Slopes& slopes);
  bool write_by_columns(double t, const double* y, double* ydot, Eigen::Ref<Eigen::MatrixXd> out);
  bool write_by_lines(double t, const double* y, double* ydot, double* out, Eigen::Index stride) const;
  static std::vector<int> in_rows(const SparseEntries& entries, int first, int count, int zero);
  double lent_inertia();
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
  std::vector<double> own_J_, own_ydot_, parameters_;
  TracedLines<>::Solved solved_;
  std::vector<std::pair<int, Requirement>> required_;  // of numbers
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
    if (const Jacobian* const ready = ready_.load(std::memory_order_acquire)) return ready->write_by_lines(t, y, ydot, out);
    renew_.store([](KeptJacobian& self, const Form& f) { self.kept_.renew([&](RecordedMotion& m) { f.record_again(m); }); }, std::memory_order_relaxed);
    const auto phases = form.phases(y);
    return kept_.use(phases, [&] { return Jacobian(form.recorded(phases), form.limits_of_pivots()); },
                     [&](Jacobian& jacobian) {
                       if (phases.empty() && jacobian.is_solved()) ready_.store(&jacobian, std::memory_order_release);
                       return jacobian.write(t, y, ydot, out);
                     });
  }
  /// Looks whether the functors are the same still. No other thread may ask meanwhile.
  void renew(const Form& form) {
    ready_.store(nullptr, std::memory_order_relaxed);
    if (const Renew renew = renew_.load(std::memory_order_relaxed)) renew(*this, form);
  }

  KeptJacobian() = default;
  KeptJacobian(const KeptJacobian& other) : kept_(other.kept_), renew_(other.renew_.load(std::memory_order_relaxed)) {}
  KeptJacobian& operator=(const KeptJacobian& other) {
    kept_ = other.kept_;
    renew_.store(other.renew_.load(std::memory_order_relaxed), std::memory_order_relaxed);
    ready_.store(nullptr, std::memory_order_relaxed);
    return *this;
  }

 private:
  using Renew = void (*)(KeptJacobian&, const Form&);
  static constexpr Eigen::Index largest = 128;

  KeptMotion<Jacobian> kept_;
  mutable std::atomic<Renew> renew_{nullptr};            // null until a Jacobian is asked for
  mutable std::atomic<const Jacobian*> ready_{nullptr};  // of forms without phases: that of kept_, if it needs no lock
};

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template class TracedJacobian<1>;
extern template class TracedJacobian<2>;
extern template class TracedJacobian<3>;
extern template class TracedJacobian<4>;
extern template class TracedJacobian<Dynamic>;
}  // namespace qdot::detail
#else
#include "qdot/mechanics/derive/jacobian_lines.hpp"
#endif
