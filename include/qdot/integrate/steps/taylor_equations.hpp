#pragma once
// SPDX-License-Identifier: MIT
//
// Lagrange's equations on power series.
//
// Written with the momenta, Lagrange's equations need no second derivative but the mass matrix:
//
//     d/dt p = g ,      p = ∂L/∂q̇,   g = ∂L/∂q .
//
// Let q, q̇, p, g be power series in s = (t − t₀)/τ. Then, order by order,
//
//     q_{k+1} = τ q̇_k / (k + 1)            p_{k+1} = τ g_k / (k + 1) .
//
// p is a function of q and q̇, so its coefficient k + 1 also is
//
//     p_{k+1} = M₀ q̇_{k+1} + r_{k+1},       r_{k+1}: the same with q̇_{k+1} = 0,
//
// for the highest coefficient enters every product only once, beside coefficients of order 0. Hence
//
//     M₀ q̇_{k+1} = τ g_k / (k + 1) − r_{k+1} .
//
// M is wanted at the expansion point only: it is factored once per step, and every further order costs two
// triangular solves and one sweep through the graphs of p and g (ad/series/sweep.hpp). These come from one
// recording of L by reverse differentiation and have a few times the operations of T and V themselves: a
// chain of n links costs O(n) per order, where its equations of motion, written out, have O(n²) terms.
//
// Forces of effects are summands of g, and effects' own states have z_{k+1} = τ ż_k/(k + 1): both need the order before only.
// Constraints make the system to be solved larger by their multipliers (integrate/steps/taylor_constraints.hpp).

#include <Eigen/LU>
#include <string>
#include <type_traits>
#include <vector>

#include "qdot/ad/series/sweep.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/steps/recorded_motion.hpp"
#include "qdot/integrate/steps/taylor_constraints.hpp"
#include "qdot/mechanics/derive/dense_factors.hpp"
#include "qdot/mechanics/mass_matrix.hpp"

namespace qdot::detail {

/// The power series of the motion of a system or a scene from a state.
///
/// @tparam F  FirstOrderForm<…> or SceneForm<…>; what is behind it is run once, in the constructor
template <class F>
class LagrangeSeries {
  static constexpr int n = Mechanics<F>::n;
  static constexpr int states = Mechanics<F>::states;
  static constexpr int rows = Mechanics<F>::constraints;
  static constexpr Inertia inertia = Mechanics<F>::inertia;

 public:
  /// @throws NotAnalytic  T, V or a force compares values or has a kink
  [[gnu::cold]] LagrangeSeries(const F& form, int highest_order) {
    recorded_ = recorded_motion(form);
    RecordedMotion& m = recorded_;
    const formula::Graph& graph = m.recording.graph;
    for (const int node : m.mass) mass_is_constant_ = mass_is_constant_ && graph[node].kind == formula::Kind::constant;
    taylor::SweepOutputs outputs{.early = m.p, .series = m.force, .values = m.mass, .late = m.qdot};
    if constexpr (rows != 0) {
      outputs.early.insert(outputs.early.end(), m.rows.begin(), m.rows.end());
      outputs.values.insert(outputs.values.end(), m.jacobian.begin(), m.jacobian.end());
      for (const int node : m.jacobian)
        if (graph[node].kind != formula::Kind::constant) outputs.series.push_back(node);
    }
    for (const auto& assumption : m.recording.assumptions) outputs.values.push_back(assumption.node);
    // Variables are series even where no output contains them: their coefficients are the motion.
    for (const auto* list : {&m.q, &m.z, &m.zdot}) outputs.series.insert(outputs.series.end(), list->begin(), list->end());
    outputs.series.push_back(m.t);
    sweep_ = taylor::sweep_of(m.recording.graph, outputs, highest_order);

    for (const auto* list : {&m.q, &m.qdot, &m.z})
      for (const int node : *list) motion_.push_back(sweep_.slot(node));
    const auto slots_of = [&](const std::vector<int>& nodes) {
      std::vector<int> result;
      for (const int node : nodes) result.push_back(sweep_.slot(node));
      return result;
    };
    p_ = slots_of(m.p);
    force_ = slots_of(m.force);
    zdot_ = slots_of(m.zdot);
    mass_ = slots_of(m.mass);
    t_ = sweep_.slot(m.t);
    for (const auto& assumption : m.recording.assumptions) assumptions_.push_back({sweep_.slot(assumption.node), assumption.value});
    const Eigen::Index dof = static_cast<Eigen::Index>(m.q.size());
    for (Eigen::Index i = 0; i < dof; ++i) names_.names.push_back(form.component_name(i));
    if constexpr (rows != 0) constraints_ = ConstraintSeries<n, rows>(m, sweep_, names_.names, highest_order);
    set_out(highest_order);
  }

  /// Runs the functors again; where they have become other formulas, or their constants others, everything is made anew.
  ///
  /// @throws NotAnalytic  one of them compares values or has a kink by now
  void renew(const F& form) {
    if (!is_of(form)) *this = LagrangeSeries(form, static_cast<int>(coefficients_.cols()) - 1);
  }

  /// Whether the functors of `form` still are the formulas that were recorded, with the same constants.
  ///
  /// @throws NotAnalytic  as renew()
  bool is_of(const F& form) {
    if constexpr (requires { run_again(recorded_, form); }) return still_holds(recorded_, form);
    return true;  // of a system that hides its functors
  }

  /// Orders 0 and 1 at a state: column 1 of coefficients() is then time_unit·[q̇; q̈].
  ///
  /// @throws MassMatrixError, NonFinite, ConstraintError  as acceleration(); NonFinite also where a formula is not analytic
  template <class Y>
  void start(double t, const Y& y, double time_unit) {
    unit_ = time_unit;
    for (Eigen::Index i = 0; i < coefficients_.rows(); ++i) sweep_.set(motion_[index(i)], coefficients_(i, 0) = y[i]);
    sweep_.set(t_, t);
    taylor::start(sweep_);
    for (const auto& [slot, value] : assumptions_)
      if (sweep_.value(slot) == value)
        throw NonFinite("a Taylor coefficient", t,
                        sentence({"T, V", rows != 0 ? ", a constraint" : "", " or a force asks whether a quantity is exactly ", value, ", and at t = ", t,
                                  " it is, so the motion may not be analytic there; use Dop853"}));
    factor_mass_matrix(t);
    make_order(1);
  }

  /// Orders 2 to `order`, after start().
  void expand(int order) {
    for (int k = 2; k <= order; ++k) {
      taylor::complete(sweep_, k - 1);
      make_order(k);
    }
  }

  /// The series: row i of column k is coefficient k of y = [q; q̇] in s = (t − t₀)/time_unit.
  const Matrix<double, F::size_at_compile_time, Dynamic>& coefficients() const noexcept { return coefficients_; }

  /// The constraints' part, with the multipliers' series.
  const auto& constraints() const noexcept
    requires(rows != 0)
  {
    return constraints_;
  }

 private:
  // Zeros in all that is numbers.
  void set_out(int highest_order) {
    const auto dof = static_cast<Eigen::Index>(p_.size());
    coefficients_.resize(static_cast<Eigen::Index>(motion_.size()), highest_order + 1);
    M_.resize(dof, dof);
    factors_ = DenseConstrainedFactors<unrolled_size<n>>(static_cast<std::size_t>(dof));
    solution_.resize(dof);
    std::fill_n(coefficients_.data(), coefficients_.size(), 0.0);
    std::fill_n(M_.data(), M_.size(), 0.0);
    std::fill_n(solution_.data(), dof, 0.0);
  }

  static std::size_t index(Eigen::Index i) { return static_cast<std::size_t>(i); }

  void make_order(int k) {
    const Eigen::Index dof = solution_.size(), size = coefficients_.rows();
    const double factor = unit_ / k;
    // All rates before any variable is set: a rate may be a variable (V = q₀ q₁).
    for (Eigen::Index i = 0; i < dof; ++i) solution_[i] = factor * sweep_.latest(force_[index(i)]);
    if constexpr (rows != 0) constraints_.add_known_reactions(sweep_, k, factor, solution_);
    if constexpr (states != 0) {
      for (Eigen::Index i = 2 * dof; i < size; ++i) coefficients_(i, k) = factor * sweep_.latest(zdot_[index(i - 2 * dof)]);
      for (Eigen::Index i = 2 * dof; i < size; ++i) sweep_.set(motion_[index(i)], coefficients_(i, k));
    }
    for (Eigen::Index i = 0; i < dof; ++i) sweep_.set(motion_[index(i)], coefficients_(i, k) = factor * coefficients_(dof + i, k - 1));
    for (Eigen::Index i = 0; i < dof; ++i) sweep_.set(motion_[index(dof + i)], 0.0);
    sweep_.set(t_, k == 1 ? unit_ : 0.0);
    taylor::advance(sweep_, k);
    for (Eigen::Index i = 0; i < dof; ++i) solution_[i] -= sweep_.latest(p_[index(i)]);
    if constexpr (rows != 0) {
      constraints_.solve(sweep_, k, factor, solution_);
    } else if constexpr (inertia == Inertia::positive_definite) {
      factors_.solve_mass(solution_.data());
    } else {
      solution_ = Vector<double, n>(inverse_ * solution_);
    }
    for (Eigen::Index i = 0; i < dof; ++i) sweep_.set(motion_[index(dof + i)], coefficients_(dof + i, k) = solution_[i]);
  }

  void factor_mass_matrix(double t) {
    if (rows == 0 && mass_is_constant_ && mass_is_factored_) return;
    std::size_t next = 0;
    for (Eigen::Index i = 0; i < M_.rows(); ++i)
      for (Eigen::Index j = 0; j <= i; ++j) M_(i, j) = M_(j, i) = sweep_.value(mass_[next++]);
    mass_is_factored_ = false;
    if constexpr (rows != 0) {
      if (!all_finite(M_)) throw_mass_matrix_error(M_, t, names_.names);
      constraints_.factor(sweep_, M_, mass_is_constant_, t);
    } else if constexpr (inertia == Inertia::positive_definite) {
      if (!factors_.compute_mass(M_, singular_pivot<double>(M_.rows()))) throw_mass_matrix_error(M_, t, names_.names);
    } else {
      inverse_ = solved_with_mass_matrix(names_, M_, Matrix<double, n>(Matrix<double, n>::Identity(M_.rows(), M_.rows())), t);
    }
    mass_is_factored_ = true;
  }

  struct Names {  // as much of a system as solving with M asks for
    static constexpr Inertia inertia = LagrangeSeries::inertia;
    std::vector<std::string> names;
    Eigen::Index dof() const { return static_cast<Eigen::Index>(names.size()); }
    std::string coordinate_name(Eigen::Index i) const { return names[index(i)]; }
  };

  Names names_;
  RecordedMotion recorded_;
  taylor::Sweep sweep_;
  std::vector<int> motion_, p_, force_, zdot_, mass_;  // slots; motion: q, q̇, then z
  int t_ = 0;
  struct Assumption {
    int slot;
    double value;
  };
  std::vector<Assumption> assumptions_;
  bool mass_is_constant_ = true, mass_is_factored_ = false;
  Matrix<double, n> M_, inverse_;
  DenseConstrainedFactors<unrolled_size<n>> factors_;
  [[no_unique_address]] std::conditional_t<rows == 0, NoConstraintSeries, ConstraintSeries<n, rows>> constraints_;
  Vector<double, n> solution_;
  double unit_ = 1.0;
  Matrix<double, F::size_at_compile_time, Dynamic> coefficients_;
};

}  // namespace qdot::detail
