#pragma once
// SPDX-License-Identifier: MIT
//
// The Jacobian of a motion from the lines of its equations.
//
//     M q̈ − Jᵀλ = r ,   J q̈ = γ                                     lines of M, r, J, γ and a solution
//     M ∂q̈ − Jᵀ∂λ = ∂(r − M q̈ + Jᵀλ) ,   J ∂q̈ = ∂(γ − J q̈)          lines of the right sides, and a solution for each component of y
//
// All are nodes of one graph (mechanics/derive/traced_equations.hpp), whose size grows with the terms, not with pairs
// of components. Of a few coordinates without constraints, one table of lines has the elimination in it, and leaves out
// zeros (mechanics/derive/solution_lines.hpp). Otherwise M and J are dense (mechanics/derive/dense_factors.hpp), and
// four columns of the right sides are solved at a time. Up to n = 4 the compiler knows n, and unrolls all that is not
// lines. The phases of contacts, ropes and dry friction are numbers in a recording, which has rows of active
// constraints only (effects/rows/recorded_effects.hpp). Each combination that is met has a recording of its own. Where
// M may be singular by itself, constraints lend it inertia: M + ϱ JᵀJ, and ϱ Jᵀ times the lower side in the upper. A
// pivot that is too small, redundant rows, and a number that is not finite are left to the caller.

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/mechanics/derive/dense_factors.hpp"
#include "qdot/mechanics/derive/recordable_form.hpp"
#include "qdot/mechanics/derive/traced.hpp"
#include "qdot/mechanics/derive/traced_equations.hpp"
#include "qdot/mechanics/derive/traced_motion.hpp"

namespace qdot::detail {

/// q̈, ż and ∂ẏ/∂y of one object, y = [q; q̇; z], and ∂ẏ/∂p of parameters that are variables.
///
/// @tparam n_at_compile_time  n, if it is small; otherwise Dynamic
template <int n_at_compile_time>
class TracedJacobian final : public Traced {
  using Factors = DenseConstrainedFactors<n_at_compile_time>;
  using Four = FourColumns;

 public:
  TracedJacobian(TracedEquations<double> equations, const LimitsOfPivots& limits);

  bool is_known() const override { return is_known_; }
  std::unique_ptr<Traced> copy() const override { return std::make_unique<TracedJacobian>(*this); }
  bool still_holds(const RecordableForm& form) override { return lines_.still_holds(form); }
  void set_parameters(const double* p) {
    const TracedEquations<double>& e = lines_.equations();
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

  void write_in_lines(const TracedEquations<double>::Slopes& slopes);
  void write_in_columns(const TracedEquations<double>::Slopes& slopes);
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
  bool is_known_ = false;
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
#include "qdot/mechanics/derive/traced_jacobian.ipp"
#endif
