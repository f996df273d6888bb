#pragma once
// SPDX-License-Identifier: MIT
//
// Momenta, forces and their slopes, as steps of Gauss ask for them (integrate/gauss.hpp), from the graph of a motion.

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "qdot/ad/series/sweep.hpp"
#include "qdot/analysis/variations/recorder.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/steps/taylor_constraints.hpp"
#include "qdot/integrate/steps/taylor_equations.hpp"

namespace qdot::detail {

// p, F and M at a state, and with them the rows of (P P_θ) and (G F_θ), from the graph of a motion. On constraints F has Wᵀλ in it, and λ follows with
// q̈ = a from two rows of equations that are zero and linear in both,
//
//     M a + (∂p/∂q) q̇ + ∂p/∂t − F − Wᵀλ = 0 ,      W a + (∂c/∂q) q̇ + ∂c/∂t = 0 ,
//
// whose slopes give those of λ.
template <class = void>  // compiled only where it is made
class RecordedMechanics {
  using Index = Eigen::Index;
  using Vec = Eigen::VectorXd;

 public:
  /// @throws NotAnalytic  T, V, a force or a constraint compares values or has a kink
  explicit RecordedMechanics(VariationalEquations& equations)
      : equations_(&equations), v_(equations.recorder->recorded(rows_of)) {
    RecordedMotion& m = v_.motion;
    formula::Graph& graph = m.recording.graph;
    rows_ = rows_of(m, static_cast<int>(v_.x.size()) + 1);  // the nodes that were there before
    for (std::size_t r = 0; r < m.rows.size(); ++r) unknown_.push_back(graph.variable(static_cast<int>(v_.x.size() + 1 + r)));
    for (std::size_t i = 0; i < m.q.size() && !unknown_.empty(); ++i) unknown_.push_back(graph.variable(static_cast<int>(v_.x.size() + 1 + m.rows.size() + i)));
    taylor::SweepOutputs outputs{.early = {}, .series = v_.x, .values = rows_, .late = {}};
    outputs.series.push_back(m.t);
    outputs.series.insert(outputs.series.end(), unknown_.begin(), unknown_.end());
    for (const auto* list : {&m.mass, &m.jacobian}) outputs.values.insert(outputs.values.end(), list->begin(), list->end());
    alone_ = taylor::Sweep(graph, outputs, 1);
    outputs.values.insert(outputs.values.end(), v_.slopes.begin(), v_.slopes.end());
    with_slopes_ = taylor::Sweep(graph, outputs, 1);
    for (Index i = 0; i < dof(); ++i) names_.columns.push_back(equations.state_name(i));
    names_.rows = m.row_names;
  }

  bool is_current() { return equations_->recorder->holds(v_); }
  Index dof() const { return equations_->dof(); }
  Index parameters() const { return v_.parameters; }
  VariationalEquations& equations() const { return *equations_; }

  Vec momenta(const Vec& q, const Vec& v, double t) {
    set(alone_, q, v, t);
    return values(alone_, 0, dof());
  }
  Vec force(const Vec& q, const Vec& v, double t) {
    set(alone_, q, v, t);
    const Vec force = values(alone_, dof(), dof());
    if (unknown_.empty()) return force;
    const Vec unknown = accelerated(t);
    return force + W_.transpose() * unknown.head(constraints());
  }
  Eigen::MatrixXd mass(const Vec& q, const Vec& v, double t) {
    set(alone_, q, v, t);
    return mass();
  }
  // (P P_θ) above (G F_θ), 2n × (2n + m).
  void write_slopes(const Vec& q, const Vec& v, double t, Eigen::MatrixXd& out) {
    if (!unknown_.empty()) set(alone_, q, v, t);
    set(with_slopes_, q, v, t, unknown_.empty() ? Vec() : accelerated(t));
    const Index width = 2 * dof() + parameters(), r = constraints();
    const auto slope = [&](Index i, Index j) { return with_slopes_.value(with_slopes_.slot(v_.slopes[static_cast<std::size_t>(i * width + j)])); };
    for (Index i = 0; i < 2 * dof(); ++i)
      for (Index j = 0; j < width; ++j) out(i, j) = slope(i, j);
    for (Index j = 0; j < width && r > 0; ++j) {
      Vec f(dof()), g(r);
      for (Index i = 0; i < dof(); ++i) f[i] = -slope(2 * dof() + i, j);
      for (Index i = 0; i < r; ++i) g[i] = -slope(3 * dof() + i, j);
      out.col(j).tail(dof()).noalias() += W_.transpose() * factors_->solution(f, g, t, names_).lambda;
    }
  }

 private:
  // p, F + Wᵀλ, and on constraints the two that are zero.
  static std::vector<int> rows_of(RecordedMotion& m, int first) {
    formula::Graph& graph = m.recording.graph;
    const std::size_t n = m.q.size(), r = m.rows.size();
    std::vector<int> rows = m.p, force = m.force, others;
    const auto variable = [&](std::size_t i) { return graph.variable(first + static_cast<int>(i)); };
    const auto rate = [&](int node, std::size_t i, const auto& slope_by_velocity) {  // along q̇ and a
      const std::vector<int> by_q = graph.gradient(node, m.q);
      int sum = graph.gradient(node, std::vector<int>{m.t})[0];
      for (std::size_t j = 0; j < n; ++j)
        sum = graph.sum(sum, graph.sum(graph.product(by_q[j], m.qdot[j]), graph.product(slope_by_velocity(i, j), variable(r + j))));
      return sum;
    };
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k < r; ++k) force[i] = graph.sum(force[i], graph.product(variable(k), m.jacobian[k * n + i]));
    rows.insert(rows.end(), force.begin(), force.end());
    if (r == 0) return rows;
    const auto mass = [&](std::size_t i, std::size_t j) { return m.mass[i < j ? j * (j + 1) / 2 + i : i * (i + 1) / 2 + j]; };
    for (std::size_t i = 0; i < n; ++i) rows.push_back(graph.difference(rate(m.p[i], i, mass), force[i]));
    for (std::size_t k = 0; k < r; ++k) rows.push_back(rate(m.rows[k], k, [&](std::size_t i, std::size_t j) { return m.jacobian[i * n + j]; }));
    return rows;
  }

  Index constraints() const { return static_cast<Index>(v_.motion.rows.size()); }

  // λ and a, where alone_ stands with zeros for them.
  Vec accelerated(double t) {
    const Index n = dof(), r = constraints();
    W_.resize(r, n);
    for (Index i = 0; i < W_.size(); ++i) W_(i / n, i % n) = alone_.value(alone_.slot(v_.motion.jacobian[static_cast<std::size_t>(i)]));
    factors_.emplace(mass(), W_, default_rank_cutoff);
    const auto both = factors_->solution(Vec(-values(alone_, 2 * n, n)), Vec(-values(alone_, 3 * n, r)), t, names_);
    Vec unknown(r + n);
    unknown << both.lambda, both.qddot;
    return unknown;
  }

  void set(taylor::Sweep& sweep, const Vec& q, const Vec& v, double t, const Vec& unknown = {}) {
    const RecordedMotion& m = v_.motion;
    for (Index i = 0; i < dof(); ++i) {
      sweep.set(sweep.slot(m.q[static_cast<std::size_t>(i)]), q[i]);
      sweep.set(sweep.slot(m.qdot[static_cast<std::size_t>(i)]), v[i]);
    }
    for (std::size_t j = 0; j < v_.theta.size(); ++j) sweep.set(sweep.slot(v_.theta[j]), equations_->recorder->parameter(static_cast<Index>(j)));
    sweep.set(sweep.slot(m.t), t);
    for (std::size_t i = 0; i < unknown_.size(); ++i) sweep.set(sweep.slot(unknown_[i]), unknown.size() > 0 ? unknown[static_cast<Index>(i)] : 0.0);
    sweep.start();
  }
  Vec values(const taylor::Sweep& sweep, Index first, Index count) const {
    Vec found(count);
    for (Index i = 0; i < count; ++i) found[i] = sweep.value(sweep.slot(rows_[static_cast<std::size_t>(first + i)]));
    return found;
  }
  Eigen::MatrixXd mass() const {
    Eigen::MatrixXd M(dof(), dof());
    std::size_t next = 0;
    for (Index i = 0; i < dof(); ++i)
      for (Index j = 0; j <= i; ++j) M(i, j) = M(j, i) = alone_.value(alone_.slot(v_.motion.mass[next++]));
    return M;
  }

  VariationalEquations* equations_;
  std::vector<int> rows_, unknown_;  // nodes; variables of λ and a, on constraints
  RecordedVariations v_;
  taylor::Sweep alone_, with_slopes_;
  ConstraintNames names_;
  Eigen::MatrixXd W_;
  std::optional<ConstrainedFactors<Dynamic, Dynamic>> factors_;  // of [M Wᵀ; W 0] where λ was asked for last
};

// y alone, for GaussStepper, whose copies share one recording.
template <class = void>  // compiled only where it is made
class RecordedForm {
 public:
  static constexpr int size_at_compile_time = Dynamic;

  explicit RecordedForm(VariationalEquations& equations) : mechanics_(std::make_shared<RecordedMechanics<>>(equations)) {}

  RecordedMechanics<>& mechanics() const { return *mechanics_; }
  Eigen::Index size() const { return 2 * mechanics_->dof(); }
  void derivative(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) const {
    mechanics_->equations().write_state_rates(t, y.data(), ydot.data());
  }
  void jacobian(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::MatrixXd> J) const {
    mechanics_->equations().write_state_jacobian(t, y.data(), J);
  }
  std::string component_name(Eigen::Index i) const { return mechanics_->equations().state_name(i); }
  void renew() {
    if (!mechanics_->is_current()) *mechanics_ = RecordedMechanics<>(mechanics_->equations());
  }

 private:
  std::shared_ptr<RecordedMechanics<>> mechanics_;
};

template <class Kind>
struct Mechanics<RecordedForm<Kind>> {
  static constexpr int n = Dynamic, states = 0, constraints = 0;
  static constexpr Inertia inertia = Inertia::positive_definite;
  using Vec = Eigen::VectorXd;
  using States = Vector<double, 0>;

  static Eigen::Index dof(const RecordedForm<Kind>& form) { return form.mechanics().dof(); }
  static Vec momenta(const RecordedForm<Kind>& form, const Vec& q, const Vec& v, double t) { return form.mechanics().momenta(q, v, t); }
  static Vec force(const RecordedForm<Kind>& form, const Vec& q, const Vec& v, const States&, double t) { return form.mechanics().force(q, v, t); }
  static Eigen::MatrixXd inverse_mass(const RecordedForm<Kind>& form, const Vec& q, const Vec& v, double t) {
    const Eigen::MatrixXd M = form.mechanics().mass(q, v, t);
    DenseConstrainedFactors<Dynamic> factors(static_cast<std::size_t>(M.rows()));
    if (!factors.compute_mass(M, singular_pivot<double>(M.rows()))) {
      std::vector<std::string> names;
      for (Eigen::Index i = 0; i < M.rows(); ++i) names.push_back(form.component_name(i));
      throw_mass_matrix_error(M, t, names);
    }
    Eigen::MatrixXd inverse(M.rows(), M.rows());
    for (Eigen::Index j = 0; j < M.rows(); ++j) {
      Vec column = Vec::Unit(M.rows(), j);
      factors.solve_mass(column.data());
      inverse.col(j) = column;
    }
    return inverse;
  }
};

}  // namespace qdot::detail
