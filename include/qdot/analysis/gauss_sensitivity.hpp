#pragma once
// SPDX-License-Identifier: MIT
//
// Sensitivities by Gauss' collocation: the tangent map of a symplectic method, which is symplectic itself.
//
//     const auto s = sensitivities(system, start, 1e4, Gauss{.step = 0.02, .stages = 3});
//
// Collocation and variation commute. With P = ∂p/∂(q, q̇) and G = ∂F/∂(q, q̇) at the stages of a step
// (integrate/gauss.hpp), a column of Φ obeys a linear system of s·n rows in the δVᵢ. It is factored once in a step for all
// columns:
//
//     δQᵢ = δq + h Σ aᵢⱼ δVⱼ ,     Pᵢ [δQᵢ; δVᵢ] + P_θ = δp + h Σ aᵢⱼ (Gⱼ [δQⱼ; δVⱼ] + F_θ) ,
//     δq₁ = δq + h Σ bⱼ δVⱼ ,      δp₁ = δp + h Σ bⱼ (Gⱼ [δQⱼ; δVⱼ] + F_θ)        P_θ, F_θ: columns of parameters only.
//
// So Φ is the derivative of the computed numbers, of order 2s like them; without forces Φᵀ J Φ = J in (q, p) to rounding,
// however long the run. Constraints add forces Wᵀλ, and a projection that is differenced: some twelve digits, and Φ is not
// symplectic there. The step is the user's, and no error is estimated; rtol and atol only say how closely events are found.

#include <Eigen/Core>
#include <Eigen/LU>
#include <vector>

#include "qdot/analysis/sensitivity.hpp"
#include "qdot/analysis/variations/recorded_mechanics.hpp"
#include "qdot/analysis/variations/recorder.hpp"
#include "qdot/integrate/gauss.hpp"

namespace qdot {

/// A Stepper that makes equal Gauss steps of a motion and of its derivatives. Movable.
template <detail::Changes changes>
class VariationalGaussStepper {
  using Index = Eigen::Index;

 public:
  /// @throws InvalidValue  step is not positive, stages is not 1 … 8
  /// @throws NotAnalytic   T, V or a force compares values or has a kink
  VariationalGaussStepper(const detail::VariationalForm<changes>& form, int stages, double step, const Options& options)
      : form_(form), recorded_(form.equations()),
        motion_(detail::GaussStepperOf<detail::RecordedForm<>>::made(recorded_, stages, step, of_motion(form, options))),
        n_(form.dof()), columns_(form.equations().columns()) {
    const detail::RecordedMechanics<>& mechanics = recorded_.mechanics();
    slopes_.assign(static_cast<std::size_t>(stages) + 1, Eigen::MatrixXd(2 * n_, 2 * n_ + mechanics.parameters()));
    dq_.setZero(n_, columns_);
    dp_ = dq_;
    A_.setZero(n_ * stages, n_ * stages);
    dV_.setZero(n_ * stages, columns_);
    dQ_ = dV_;
    y_.setZero(form.size());
    before_ = ydot_ = ydot_before_ = y_;
    dense_.setZero(form.size(), 6);
  }

  static constexpr bool has_fixed_step() noexcept { return true; }
  const Failure& failure() const noexcept { return motion_.failure(); }
  double t() const noexcept { return motion_.t(); }
  double t_previous() const noexcept { return motion_.t_previous(); }
  TimePoint time_point() const noexcept { return motion_.time_point(); }
  [[deprecated("qdot: say time_point()")]] TimePoint moment() const noexcept { return time_point(); }
  const Eigen::VectorXd& y() const noexcept { return y_; }
  int order() const noexcept { return motion_.order(); }
  const Statistics& statistics() const noexcept { return motion_.statistics(); }

  /// Starts (afresh) at (t, [y; Φ]).
  ///
  /// @throws as GaussStepper of the motion
  void reset(const TimePoint& at, const Eigen::Ref<const Eigen::VectorXd>& y) {
    motion_.reset(at, y.head(2 * n_));
    y_ = before_ = y;
    take_columns();
    is_dense_ = false;
  }

  /// Replaces the state at t() by a nearby one.
  void correct(const Eigen::Ref<const Eigen::VectorXd>& y) {
    if (y_ == y) return;
    motion_.correct(y.head(2 * n_));
    y_ = y;
    take_columns();
  }

  /// One step towards t_limit.
  bool step(double t_limit) {
    const double elapsed = motion_.time_point().elapsed;
    if (!motion_.step(t_limit)) return false;
    before_ = y_;
    move_columns(motion_.time_point().elapsed - elapsed);
    is_dense_ = false;
    return true;
  }

  /// The last step's polynomial of degree 5.
  PolynomialView polynomial() {
    PolynomialView view = motion_.polynomial();
    if (view.degree == 0) {
      view.coefficients = y_.data();
    } else {
      if (!is_dense_) make_dense(view);
      view.coefficients = dense_.data();
    }
    view.size = y_.size();
    return view;
  }

  /// out ← [y; Φ](t) for t within the last step.
  void interpolate(double t, Eigen::Ref<Eigen::VectorXd> out) { polynomial().evaluate(t, out); }

 private:
  static Options of_motion(const detail::VariationalForm<changes>& form, Options options) {
    options.atol = detail::each_atol(options, 2 * form.dof());
    return options;
  }

  // Which parameter a column belongs to; negative for none.
  Index parameter_of(Index column) const { return column - (columns_ - recorded_.mechanics().parameters()); }

  // δq and δp of y_.
  void take_columns() {
    Eigen::MatrixXd& S = slopes_.back();
    recorded_.mechanics().write_slopes(y_.head(n_), y_.segment(n_, n_), t(), S);
    for (Index c = 0; c < columns_; ++c) {
      const auto column = y_.segment(2 * n_ * (c + 1), 2 * n_);
      dq_.col(c) = column.head(n_);
      dp_.col(c).noalias() = S.block(0, 0, n_, 2 * n_) * column;
      if (const Index j = parameter_of(c); j >= 0) dp_.col(c) += S.block(0, 2 * n_ + j, n_, 1);
    }
  }

  void move_columns(double h) {
    const auto& table = motion_.table();
    const Index s = table.b.size();
    const auto P = [&](Index i) { return slopes_[static_cast<std::size_t>(i)].topRows(n_); };
    const auto G = [&](Index i) { return slopes_[static_cast<std::size_t>(i)].bottomRows(n_); };
    for (Index i = 0; i < s; ++i)
      recorded_.mechanics().write_slopes(motion_.stage_positions()[static_cast<std::size_t>(i)], motion_.stage_velocities()[static_cast<std::size_t>(i)],
                                         t_previous() + table.c[i] * h, slopes_[static_cast<std::size_t>(i)]);
    for (Index i = 0; i < s; ++i)
      for (Index l = 0; l < s; ++l) {
        auto block = A_.block(n_ * i, n_ * l, n_, n_);
        block = h * table.a(i, l) * (P(i).leftCols(n_) - G(l).middleCols(n_, n_));
        if (i == l) block += P(i).middleCols(n_, n_);
        for (Index j = 0; j < s; ++j) block -= h * h * table.a(i, j) * table.a(j, l) * G(j).leftCols(n_);
      }
    for (Index i = 0; i < s; ++i) {
      auto right = dV_.middleRows(n_ * i, n_);
      right = dp_ - P(i).leftCols(n_) * dq_;
      for (Index j = 0; j < s; ++j) right += h * table.a(i, j) * (G(j).leftCols(n_) * dq_);
      for (Index c = 0; c < columns_; ++c)
        if (const Index k = parameter_of(c); k >= 0) {
          right.col(c) -= P(i).col(2 * n_ + k);
          for (Index j = 0; j < s; ++j) right.col(c) += h * table.a(i, j) * G(j).col(2 * n_ + k);
        }
    }
    factors_.compute(A_);
    dV_ = factors_.solve(dV_).eval();
    for (Index i = 0; i < s; ++i) {
      auto sum = dQ_.middleRows(n_ * i, n_);
      sum = dq_;
      for (Index j = 0; j < s; ++j) sum += h * table.a(i, j) * dV_.middleRows(n_ * j, n_);
    }
    for (Index j = 0; j < s; ++j) {
      const auto V = dV_.middleRows(n_ * j, n_);
      dq_ += h * table.b[j] * V;
      dp_ += h * table.b[j] * (G(j).leftCols(n_) * dQ_.middleRows(n_ * j, n_) + G(j).middleCols(n_, n_) * V);
      for (Index c = 0; c < columns_; ++c)
        if (const Index k = parameter_of(c); k >= 0) dp_.col(c) += h * table.b[j] * G(j).col(2 * n_ + k);
    }
    show_columns();
  }

  // y_ from the motion, δq and δp: δq̇ = M⁻¹ (δp − ∂p/∂q δq − P_θ).
  void show_columns() {
    y_.head(2 * n_) = motion_.y();
    Eigen::MatrixXd& S = slopes_.back();
    recorded_.mechanics().write_slopes(y_.head(n_), y_.segment(n_, n_), t(), S);
    factors_at_end_.compute(S.block(0, n_, n_, n_));
    for (Index c = 0; c < columns_; ++c) {
      Eigen::VectorXd right = dp_.col(c) - S.block(0, 0, n_, n_) * dq_.col(c);
      if (const Index j = parameter_of(c); j >= 0) right -= S.block(0, 2 * n_ + j, n_, 1);
      y_.segment(2 * n_ * (c + 1), n_) = dq_.col(c);
      y_.segment(2 * n_ * (c + 1) + n_, n_) = factors_at_end_.solve(right);
    }
  }

  // Columns by δq, δq̇, δq̈ at both ends, as integrate/steps/fixed_step.hpp has the motion.
  void make_dense(const PolynomialView& motion) {
    const double h = motion.scale;
    form_.write_derivative(t_previous(), before_.data(), ydot_before_.data());
    form_.write_derivative(t(), y_.data(), ydot_.data());
    for (int k = 0; k < 6; ++k) dense_.col(k).head(2 * n_) = Eigen::Map<const Eigen::VectorXd>(motion.coefficients + 2 * n_ * k, 2 * n_);
    for (Index c = 1; c <= columns_; ++c)
      for (Index i = 2 * n_ * c; i < 2 * n_ * c + n_; ++i) {
        const Index v = i + n_;
        const double d = y_[i] - before_[i], v0 = h * before_[v], v1 = h * y_[v], a0 = h * h * ydot_before_[v], a1 = h * h * ydot_[v];
        const double power[6] = {before_[i], v0, a0 / 2, 10 * d - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1,
                                 -15 * d + 8 * v0 + 7 * v1 + 1.5 * a0 - a1, 6 * d - 3 * (v0 + v1) + 0.5 * (a1 - a0)};
        for (int k = 0; k < 6; ++k) dense_(i, k) = power[k];
        for (int k = 0; k < 5; ++k) dense_(v, k) = (k + 1) * power[k + 1] / h;
        dense_(v, 0) = before_[v];
      }
    is_dense_ = true;
  }

  detail::VariationalForm<changes> form_;
  detail::RecordedForm<> recorded_;
  GaussStepper<Dynamic, Dynamic, 0> motion_;
  Index n_, columns_;
  std::vector<Eigen::MatrixXd> slopes_;  // at the stages, and at the end
  Eigen::MatrixXd dq_, dp_, A_, dV_, dQ_, dense_;
  Eigen::PartialPivLU<Eigen::MatrixXd> factors_, factors_at_end_;
  Eigen::VectorXd y_, before_, ydot_, ydot_before_;
  bool is_dense_ = false;
};

namespace detail {

template <Changes changes>
struct GaussStepperOf<VariationalForm<changes>> {
  static VariationalGaussStepper<changes> made(const VariationalForm<changes>& form, int stages, double step, const Options& options) {
    return {form, stages, step, options};
  }
};

// What the tangent map needs of a model.
template <class Model>
struct Preparation<Gauss, Model> {
  static constexpr bool takes_branches = false;
  static void prepare(Variations<Model>& equations) {
    attach_recorder(equations);
    equations.bends_projections = true;
  }
};

}  // namespace detail
}  // namespace qdot
