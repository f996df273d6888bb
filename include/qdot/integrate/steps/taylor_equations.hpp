#pragma once
// SPDX-License-Identifier: MIT
//
// Lagrange's equations on power series.
//
// Written with momenta, d/dt p = g, p = ∂L/∂q̇, g = ∂L/∂q, they need no second derivative but the mass matrix. Let q, q̇, p, g be power
// series in s = (t − t₀)/τ. Then q_{k+1} = τ q̇_k / (k + 1) and p_{k+1} = τ g_k / (k + 1), order by order. The highest coefficient of q̇
// enters every product only once, beside coefficients of order 0. So p, a function of q and q̇, also gives
//
//     p_{k+1} = M₀ q̇_{k+1} + r_{k+1},       r_{k+1}: the same with q̇_{k+1} = 0,       hence     M₀ q̇_{k+1} = τ g_k / (k + 1) − r_{k+1} .
//
// M is needed at the expansion point only. It is factored once per step, and every further order costs two triangular solves and
// one sweep through the graphs of p and g (ad/series/sweep.hpp). These come from one recording of L by reverse differentiation
// and have a few times the operations of T and V themselves. A chain of n links costs O(n) per order, where its equations of
// motion, written out, have O(n²) terms.
//
// Forces of effects are summands of g, and effects' own states have z_{k+1} = τ ż_k/(k + 1): both need the order before only.

#include <Eigen/Core>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "qdot/ad/series/sweep.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/steps/recorded_branches.hpp"
#include "qdot/integrate/steps/recorded_motion.hpp"
#include "qdot/integrate/steps/taylor_constraints.hpp"
#include "qdot/mechanics/derive/dense_factors.hpp"
#include "qdot/mechanics/mass_matrix.hpp"

namespace qdot::detail {

struct SeriesBranches;  // integrate/steps/taylor_branches.hpp

/// A power series of a motion, order by order, as the stepper asks for it.
struct PowerSeries {
  virtual ~PowerSeries() = default;
  /// Runs the functors again; where they have become other formulas, or their constants others, everything is made anew.
  virtual void renew() = 0;
  /// Whether the functors still are the formulas that were recorded, with the same constants.
  virtual bool is_current() = 0;
  /// Orders 0 and 1 at a state: column 1 of coefficients() is then time_unit·ẏ.
  virtual void start(double t, const double* y, double time_unit) = 0;
  /// Orders 2 to `order`, after start().
  virtual void expand(int order) = 0;
  /// Row i of column k is coefficient k of y_i in s = (t − t₀)/time_unit.
  virtual const Eigen::MatrixXd& coefficients() const noexcept = 0;
  /// The part of the constraints, with the multipliers' series; nothing where there are none.
  virtual const ConstraintPart* constraints() const noexcept = 0;
  /// The branches, of which each has another series; nothing where there is one formula everywhere.
  virtual SeriesBranches* branches() noexcept { return nullptr; }
};

/// Where a series has its formulas from.
struct MotionSource {
  virtual ~MotionSource() = default;
  /// @param branches  answers comparisons, and keeps the guards; without it they are refused
  virtual RecordedMotion recorded(formula::Branches* branches = nullptr) const = 0;
  virtual bool still_holds(RecordedMotion& m) const = 0;
  virtual Eigen::Index size() const = 0;
  virtual Eigen::Index dof() const = 0;
  virtual std::string component_name(Eigen::Index i) const = 0;
  virtual bool has_definite_inertia() const = 0;
  virtual By by() const { return By::fastest; }  // never duals
  virtual std::unique_ptr<ConstraintPart> constraints(const RecordedMotion&, const taylor::Sweep&, std::vector<std::string>, int) const { return nullptr; }
};

/// A copy of a form.
template <class F>
class MotionSourceOf final : public MotionSource {
 public:
  explicit MotionSourceOf(const F& form) : form_(form) {}
  RecordedMotion recorded([[maybe_unused]] formula::Branches* branches) const override {
    if constexpr (has_branches_recorded<F>) {
      formula::Recording recording;
      recording.branches = branches;
      return recorded_motion(form_, std::move(recording));
    } else {
      return recorded_motion(form_);
    }
  }
  bool still_holds([[maybe_unused]] RecordedMotion& m) const override {
    if constexpr (requires { run_again(m, form_); }) return qdot::detail::still_holds(m, form_);
    return true;  // of a system that hides its functors
  }
  Eigen::Index size() const override { return form_.size(); }
  Eigen::Index dof() const override { return Mechanics<F>::dof(form_); }
  std::string component_name(Eigen::Index i) const override { return form_.component_name(i); }
  bool has_definite_inertia() const override { return Mechanics<F>::inertia == Inertia::positive_definite; }
  By by() const override {
    const auto way_of = [](const auto& system) {
      const By way = system.kept_lines()->by();
      if (way == By::duals) throw InvalidValue("Taylor has series of recorded formulas, and none by dual numbers; leave By::duals out, or take Dop853");
      return way;
    };
    if constexpr (requires { form_.scene().system(); }) return way_of(form_.scene().system());
    else if constexpr (requires { form_.system().kept_lines(); }) return way_of(form_.system());
    else return By::fastest;
  }
  std::unique_ptr<ConstraintPart> constraints([[maybe_unused]] const RecordedMotion& m, [[maybe_unused]] const taylor::Sweep& sweep,
                                              [[maybe_unused]] std::vector<std::string> names, [[maybe_unused]] int highest_order) const override {
    if constexpr (Mechanics<F>::constraints != 0) {
      using Factors = ConstrainedFactors<Dynamic, Mechanics<F>::constraints != 0 ? Dynamic : 0>;  // looked for only here, where its header is included
      if (!m.rows.empty()) return std::make_unique<ConstraintSeries<Factors>>(m, sweep, std::move(names), highest_order);
    }
    return nullptr;
  }

 private:
  F form_;
};

/// The power series of the motion of a system or a scene from a state.
template <class = void>  // compiled only where it is made
class LagrangeSeries final : public PowerSeries {
 public:
  /// @throws NotAnalytic  T, V, a force or a constraint compares values or has a kink
  LagrangeSeries(std::shared_ptr<const MotionSource> source, int highest_order) : LagrangeSeries(source, source->recorded(), highest_order, {}) {}

  /// @param guards  nodes that have series as well
  [[gnu::cold]] LagrangeSeries(std::shared_ptr<const MotionSource> source, RecordedMotion recorded, int highest_order, const std::vector<int>& guards)
      : source_(std::move(source)), is_definite_(source_->has_definite_inertia()), recorded_(std::move(recorded)) {
    RecordedMotion& m = recorded_;
    const formula::Graph& graph = m.recording.graph;
    for (const int node : m.mass) mass_is_constant_ = mass_is_constant_ && graph[node].kind == formula::Kind::constant;
    taylor::SweepOutputs wanted = outputs();
    wanted.series.insert(wanted.series.end(), guards.begin(), guards.end());
    sweep_ = taylor::sweep_of(m.recording.graph, wanted, highest_order);
    sweep_.begin_machine_code(machine_code_begins(source_->by()));
    for (const int node : guards) guards_.push_back(sweep_.slot(node));
    guard_coefficients_.setZero(static_cast<Eigen::Index>(guards.size()), highest_order + 1);
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
    const auto dof = static_cast<Eigen::Index>(m.q.size());
    for (Eigen::Index i = 0; i < dof; ++i) names_.names.push_back(source_->component_name(i));
    constraints_ = source_->constraints(m, sweep_, names_.names, highest_order);
    coefficients_.setZero(static_cast<Eigen::Index>(motion_.size()), highest_order + 1);
    M_.setZero(dof, dof);
    factors_ = DenseConstrainedFactors<Dynamic>(static_cast<std::size_t>(dof));
    solution_.setZero(dof);
  }

  /// @throws NotAnalytic  one of the functors compares values or has a kink by now
  void renew() override {
    if (!is_current()) *this = LagrangeSeries(source_, static_cast<int>(coefficients_.cols()) - 1);
  }
  bool is_current() override { return holds_ = holds_ && source_->still_holds(recorded_); }

  /// @throws MassMatrixError, NonFinite, ConstraintError  as acceleration(); NonFinite also where a formula is not analytic
  void start(double t, const double* y, double time_unit) override {
    unit_ = time_unit;
    for (Eigen::Index i = 0; i < coefficients_.rows(); ++i) sweep_.set(motion_[index(i)], coefficients_(i, 0) = y[i]);
    sweep_.set(t_, t);
    taylor::start(sweep_);
    for (const auto& [slot, value] : assumptions_)
      if (sweep_.value(slot) == value)
        throw NonFinite("a Taylor coefficient", t,
                        sentence({"T, V", constraints_ ? ", a constraint" : "", " or a force asks whether a quantity is exactly ", value, ", and at t = ", t,
                                  " it is, so the motion may not be analytic there; use Dop853"}));
    factor_mass_matrix(t);
    sweep_.set_time_unit(unit_);
    make_order(1);
  }

  void expand(int order) override {
    if (!guards_.empty()) return expand_with_guards(order);
    for (int k = 2; k <= order; ++k) {
      taylor::complete(sweep_, k - 1);
      make_order(k);
    }
  }
  /// Row i of column k is coefficient k of guard i, as of the last expand().
  const Eigen::MatrixXd& guard_coefficients() const noexcept { return guard_coefficients_; }
  RecordedMotion& recorded() noexcept { return recorded_; }

  const Eigen::MatrixXd& coefficients() const noexcept override { return coefficients_; }
  const ConstraintPart* constraints() const noexcept override { return constraints_.get(); }

 private:
  static std::size_t index(Eigen::Index i) { return static_cast<std::size_t>(i); }

  taylor::SweepOutputs outputs() const {
    const RecordedMotion& m = recorded_;
    taylor::SweepOutputs outputs{.early = m.p, .series = m.force, .values = m.mass, .late = m.qdot};
    const auto append = [](std::vector<int>& to, const std::vector<int>& nodes) { to.insert(to.end(), nodes.begin(), nodes.end()); };
    append(outputs.early, m.rows);
    append(outputs.values, m.jacobian);
    for (const int node : m.jacobian)
      if (m.recording.graph[node].kind != formula::Kind::constant) outputs.series.push_back(node);
    for (const auto& assumption : m.recording.assumptions) outputs.values.push_back(assumption.node);
    // Variables are series even where no output contains them: their coefficients are the motion.
    for (const auto* list : {&m.q, &m.z, &m.zdot}) append(outputs.series, *list);
    outputs.series.push_back(m.t);
    if (is_definite_) {
      outputs.recurrence = {.variables = m.q, .rates = m.qdot, .late = m.qdot, .forces = m.force, .momenta = m.p, .mass = m.mass,
                            .rows = m.rows, .jacobian = m.jacobian, .time = m.t};
      append(outputs.recurrence.variables, m.z);
      append(outputs.recurrence.rates, m.zdot);
    }
    return outputs;
  }

  void expand_with_guards(int order) {
    const auto note = [&](int k, auto&& number) {
      for (std::size_t i = 0; i < guards_.size(); ++i) guard_coefficients_(static_cast<Eigen::Index>(i), k) = number(guards_[i]);
    };
    note(0, [&](int slot) { return sweep_.value(slot); });
    for (int k = 1; k <= order; ++k) {
      taylor::complete(sweep_, k);
      note(k, [&](int slot) { return sweep_.latest(slot); });
      if (k < order) make_order(k + 1);
    }
  }

  void make_order(int k) {
    if (!is_definite_ || (constraints_ && !constraints_->is_regular())) return make_order_with_solution(k);
    taylor::advance(sweep_, k);
    if (constraints_) constraints_->note_multipliers(sweep_, k);
    double* const column = coefficients_.data() + k * coefficients_.rows();
    for (std::size_t i = 0; i < motion_.size(); ++i) column[i] = sweep_.variable(motion_[i]);
  }
  void make_order_with_solution(int k) {
    const Eigen::Index dof = solution_.size(), size = coefficients_.rows();
    const double factor = unit_ / k;
    // All rates before any variable is set: a rate may be a variable (V = q₀ q₁).
    for (Eigen::Index i = 0; i < dof; ++i) solution_[i] = factor * sweep_.latest(force_[index(i)]);
    if (constraints_) constraints_->add_known_reactions(sweep_, k, factor, solution_);
    for (Eigen::Index i = 2 * dof; i < size; ++i) coefficients_(i, k) = factor * sweep_.latest(zdot_[index(i - 2 * dof)]);
    for (Eigen::Index i = 2 * dof; i < size; ++i) sweep_.set(motion_[index(i)], coefficients_(i, k));
    for (Eigen::Index i = 0; i < dof; ++i) sweep_.set(motion_[index(i)], coefficients_(i, k) = factor * coefficients_(dof + i, k - 1));
    sweep_.set(t_, k == 1 ? unit_ : 0.0);
    taylor::advance(sweep_, k);
    for (Eigen::Index i = 0; i < dof; ++i) solution_[i] -= sweep_.latest(p_[index(i)]);
    if (constraints_) constraints_->solve(sweep_, k, factor, solution_);
    else solution_ = (inverse_ * solution_).eval();
    for (Eigen::Index i = 0; i < dof; ++i) sweep_.set(motion_[index(dof + i)], coefficients_(dof + i, k) = solution_[i]);
  }

  void factor_mass_matrix(double t) {
    if (!constraints_ && mass_is_constant_ && mass_is_factored_) return;
    std::size_t next = 0;
    for (Eigen::Index i = 0; i < M_.rows(); ++i)
      for (Eigen::Index j = 0; j <= i; ++j) M_(i, j) = M_(j, i) = sweep_.value(mass_[next++]);
    mass_is_factored_ = false;
    if (constraints_) {
      if (!all_finite(M_)) throw_mass_matrix_error(M_, t, names_.names);
      constraints_->factor(sweep_, M_, mass_is_constant_, t);
      if (is_definite_ && constraints_->is_regular()) constraints_->write_factors(sweep_);
    } else if (is_definite_) {
      if (!factors_.compute_mass(M_, singular_pivot<double>(M_.rows()))) throw_mass_matrix_error(M_, t, names_.names);
      factors_.write_mass_factors(sweep_.mass_factors().data());
    } else {
      inverse_ = solved_with_mass_matrix(names_, M_, Eigen::MatrixXd(Eigen::MatrixXd::Identity(M_.rows(), M_.rows())), t);
    }
    mass_is_factored_ = true;
  }

  struct Names {  // as much of a system as solving with an indefinite M asks for
    static constexpr Inertia inertia = Inertia::indefinite;
    std::vector<std::string> names;
    Eigen::Index dof() const { return static_cast<Eigen::Index>(names.size()); }
    std::string coordinate_name(Eigen::Index i) const { return names[index(i)]; }
  };
  struct Assumption {
    int slot;
    double value;
  };

  std::shared_ptr<const MotionSource> source_;
  bool is_definite_;
  bool holds_ = true;  // the recording, as far as it was asked; what was found to be other stays so until it is made anew
  Names names_;
  RecordedMotion recorded_;
  taylor::Sweep sweep_;
  std::vector<int> motion_, p_, force_, zdot_, mass_, guards_;  // slots; motion: q, q̇, then z
  int t_ = 0;
  std::vector<Assumption> assumptions_;
  bool mass_is_constant_ = true, mass_is_factored_ = false;
  Eigen::MatrixXd M_, inverse_;
  DenseConstrainedFactors<Dynamic> factors_;
  std::unique_ptr<ConstraintPart> constraints_;
  Eigen::VectorXd solution_;
  double unit_ = 1.0;
  Eigen::MatrixXd coefficients_, guard_coefficients_;
};

#ifdef QDOT_COMPILED
extern template class LagrangeSeries<>;
#endif

}  // namespace qdot::detail
