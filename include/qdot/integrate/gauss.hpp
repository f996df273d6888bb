#pragma once
// SPDX-License-Identifier: MIT
//
// Gauss: symplectic steps for any T and V.
//
// Where T(q, q̇) mixes positions and velocities, no explicit method is symplectic. Gauss collocation with s stages at the zeros cᵢ
// of the Legendre polynomial P_s(2c − 1) is, and has order 2s, the highest possible. It is time-reversible and conserves quadratic
// invariants (angular momentum) to rounding. It acts on positions and momenta, with the velocities Vᵢ at the stages as unknowns:
//
//     Qᵢ = q + h Σⱼ aᵢⱼ Vⱼ          p(Qᵢ, Vᵢ) = p + h Σⱼ aᵢⱼ F(Qⱼ, Vⱼ)
//     q₁ = q + h Σⱼ bⱼ Vⱼ           p₁ = p + h Σⱼ bⱼ F(Qⱼ, Vⱼ),       p = ∂L/∂q̇,  F = ∂L/∂q + ΣQ.
//
// The iteration runs until the change is rounding: with 1e-10 left the energy would drift by 1e-10 per step. A step costs s mass
// matrices and, times about five iterations, s evaluations of p and F. With forces, or constraints (Jᵀλ, and a projection after
// each step), it is as accurate, but not symplectic; Rattle is, on constraints (rattle.hpp).
// Reference: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed., Springer 2006, II.1.3,
// VI.6.2 (variational), VIII.6 (iteration); E. Hairer, R. McLachlan, A. Razakarivony, BIT 48 (2008) 231.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "qdot/integrate/stepper.hpp"
#include "qdot/integrate/steps/fixed_step.hpp"
#include "qdot/integrate/steps/gauss_table.hpp"

namespace qdot {

/// A Stepper that makes equal Gauss steps. Movable.
template <int N, int n, int states>
class GaussStepper : public detail::FixedStep<N, n, states> {
  using Base = detail::FixedStep<N, n, states>;
  using Base::dof, Base::mechanics, typename Base::Mechanical;
  using Vec = typename Mechanical::Vec;
  using States = typename Mechanical::States;

 public:
  /// @throws InvalidValue  step is not positive, stages is not 1 … 8
  GaussStepper(std::unique_ptr<Mechanical> system, int stages, double step, const Options& options)
      : Base(std::move(system), "gauss", 2 * checked(stages), step, options), table_(stages), has_effects_(mechanics().has_effects()) {
    const Vec zero = Vec::Zero(dof());
    const std::size_t s = static_cast<std::size_t>(stages);
    V_.assign(s, zero);
    Q_ = force_ = momenta_ = V_old_ = V_;
    times_.assign(s, 0.0);
    inverse_.assign(s, Matrix<double, n>::Identity(dof(), dof()));
    const States none = States::Zero(this->size() - 2 * dof());
    Z_.assign(s, none);
    zdot_.assign(s, none);
    p_ = p_new_ = lost_p_ = lost_p_new_ = zero;
    extrapolation_.resize(stages, stages);
    for (int i = 0; i < stages; ++i)
      for (int j = 0; j < stages; ++j) extrapolation_(i, j) = table_.lagrange(j, 1 + table_.c[i]);
  }

  /// Starts (afresh) at (t, y); evaluates the accelerations once there.
  ///
  /// @throws as RungeKuttaStepper::reset
  void reset(const TimePoint& at, const Eigen::Ref<const Eigen::VectorXd>& y) {
    this->begin(at, y);
    p_ = momenta(q_of(this->y_), v_of(this->y_), this->clock_.shown(this->elapsed_));
    lost_p_.setZero();
    guess_is_known_ = false;
    for (States& rate : zdot_) rate.setZero();
    largest_v_ = largest_rate_ = 0.0;
  }

  /// Replaces the state at t() by a nearby one, such as its projection onto constraints.
  void correct(const Eigen::Ref<const Eigen::VectorXd>& y) {
    if (this->y_ == y) return;
    for (Eigen::Index i = 0; i < this->size(); ++i)
      if (this->y_[i] != y[i]) this->lost_[i] = 0.0;
    this->y_ = y;
    this->ydot_is_current_ = false;
    p_ = momenta(q_of(this->y_), v_of(this->y_), this->clock_.shown(this->elapsed_));
    lost_p_.setZero();
  }

  /// One step towards t_limit: the way there is divided into equal steps.
  bool step(double t_limit) {
    const double end = this->next_end(t_limit);
    const double h = this->h_;
    this->y_old_ = this->y_;
    const typename Base::Y lost_old = this->lost_;
    bool converged = false;
    diverges_ = false;
    this->failure_ = {};
    const bool evaluated = this->attempt([&] { converged = solve(end, h); });
    if (evaluated && converged) {
      p_ = p_new_;
      lost_p_ = lost_p_new_;
      guess_is_known_ = true;
      h_before_ = h;
      this->finish(end);
      return true;
    }
    this->y_ = this->y_old_;
    this->lost_ = lost_old;
    guess_is_known_ = false;
    ++this->statistics_.rejected_by_corrector;
    if (diverges_ && this->failure_.outcome != Outcome::stopped_by_model && !this->over_budget())
      this->failure_ = {Outcome::corrector_failure, "the iteration for the stages diverged: the step is too long for the fastest part of "
                                                    "the motion; take a shorter step"};
    else if (evaluated && !this->over_budget())
      this->failure_ = {Outcome::corrector_failure, "the equations of the stages did not converge in " +
                                                        std::to_string(most_iterations) + " iterations; take a shorter step"};
    return this->give_up(h);
  }

  /// Nodes and weights of the collocation.
  const detail::GaussTable& table() const noexcept { return table_; }

  /// q at the stages of the last step.
  const std::vector<Vec>& stage_positions() const noexcept { return Q_; }

  /// q̇ there.
  const std::vector<Vec>& stage_velocities() const noexcept { return V_; }

 private:
  static constexpr int most_iterations = 100;

  static int checked(int stages) {
    detail::require_option(stages >= 1 && stages <= 8, "stages", "must lie between 1 and 8", stages,
                           "s stages make order 2s; 2 to 4 are usual");
    return stages;
  }

  Vec q_of(const typename Base::Y& y) const { return y.head(dof()); }
  Vec v_of(const typename Base::Y& y) const { return y.segment(dof(), dof()); }
  States z_of(const typename Base::Y& y) const { return y.tail(this->size() - 2 * dof()); }

  Vec momenta(const Vec& q, const Vec& v, double t) const { return mechanics().momenta(q, v, t); }
  Matrix<double, n> inverse_mass(const Vec& q, const Vec& v, double t) const { return mechanics().inverse_mass(q, v, t); }

  // The largest change beside the largest value, as a fraction of it; numbers that have lost their digits to underflow do not change.
  static double relative(double change, double size) {
    return change < std::numeric_limits<double>::min() ? 0.0 : size > 0.0 ? change / size : change;
  }

  static constexpr Eigen::Index index(std::size_t i) { return static_cast<Eigen::Index>(i); }

  // A largest change, and the largest value beside it.
  struct Change {
    double change = 0.0, size = 0.0;
  };

  // The step of h that ends at `end`, into y and p_new; false where an iteration does not converge.
  bool solve(double end, double h) {
    guess_stages(h);
    const Vec q = q_of(this->y_);
    evaluate_stages(q, h);
    for (std::size_t i = 0; i < V_.size(); ++i) inverse_[i] = inverse_mass(Q_[i], V_[i], times_[i]);
    this->statistics_.linear_setups += static_cast<long>(V_.size());
    if (!iterate_stages(q, h)) return false;
    add_increments(h);
    return find_velocity(this->clock_.shown(end));
  }

  // The first V of a step of h: the polynomial of the step before, carried on, or q̇.
  void guess_stages(double h) {
    const std::size_t s = V_.size();
    for (std::size_t i = 0; i < s; ++i) times_[i] = this->clock_.shown(this->elapsed_ + table_.c[index(i)] * h);
    V_old_ = V_;
    for (std::size_t i = 0; i < s; ++i) {
      if (guess_is_known_ && h == h_before_) {
        V_[i].setZero();
        for (std::size_t j = 0; j < s; ++j) V_[i] += extrapolation_(index(i), index(j)) * V_old_[j];
      } else {
        V_[i] = v_of(this->y_);
      }
    }
  }

  // Q, Z, ż and the forces that belong to V; the change of ż.
  Change evaluate_stages(const Vec& q, double h) {
    const std::size_t s = V_.size();
    for (std::size_t i = 0; i < s; ++i) {
      Vec sum = Vec::Zero(dof());
      for (std::size_t j = 0; j < s; ++j) sum += table_.a(index(i), index(j)) * V_[j];
      Q_[i] = q + h * sum;
    }
    Change rate;
    if constexpr (states != 0) rate = evaluate_states(h);
    mechanics().write_forces(s, Q_.data(), V_.data(), Z_.data(), times_.data(), force_.data());
    this->statistics_.evaluations += static_cast<long>(s);
    return rate;
  }

  // Z and ż at the stages; the change of ż.
  Change evaluate_states(double h) {
    const std::size_t s = V_.size();
    const States z = z_of(this->y_);
    for (std::size_t i = 0; i < s; ++i) {
      Z_[i] = z;
      for (std::size_t j = 0; j < s; ++j) Z_[i] += h * table_.a(index(i), index(j)) * zdot_[j];
    }
    Change of_rate;
    for (std::size_t i = 0; i < s; ++i) {
      const States rate = mechanics().zdot(Q_[i], V_[i], Z_[i], times_[i]);
      for (Eigen::Index k = 0; k < rate.size(); ++k) {
        of_rate.change = std::max(of_rate.change, std::abs(rate[k] - zdot_[i][k]));
        of_rate.size = std::max(of_rate.size, std::abs(rate[k]));
      }
      zdot_[i] = rate;
    }
    return of_rate;
  }

  // Vᵢ ← Vᵢ − M⁻¹ (p(Qᵢ, Vᵢ) − p − h Σⱼ aᵢⱼ Fⱼ); the change of V.
  Change correct_velocities(double h) {
    const std::size_t s = V_.size();
    Change of_v;
    mechanics().write_momenta(s, Q_.data(), V_.data(), times_.data(), momenta_.data());
    for (std::size_t i = 0; i < s; ++i) {
      Vec wanted = Vec::Zero(dof());
      for (std::size_t j = 0; j < s; ++j) wanted += table_.a(index(i), index(j)) * force_[j];
      const Vec correction = inverse_[i] * (p_ - momenta_[i] + h * wanted);
      V_[i] += correction;
      if (!V_[i].allFinite()) throw NonFinite("a stage", this->t_, "the stages of the step became infinite or NaN");
      of_v.change = std::max(of_v.change, correction.cwiseAbs().maxCoeff());
      of_v.size = std::max(of_v.size, V_[i].cwiseAbs().maxCoeff());
    }
    return of_v;
  }

  // Corrects V until the change is rounding; whether it gets there.
  bool iterate_stages(const Vec& q, double h) {
    double before = std::numeric_limits<double>::infinity(), change_before = before;
    for (int iteration = 0; iteration < most_iterations; ++iteration) {
      if (iteration > 10 && this->over_budget()) return false;  // most steps have converged by then
      const Change of_v = correct_velocities(h);
      diverges_ = of_v.change > change_before;  // what the model says of stages beyond that is the iteration's fault
      change_before = of_v.change;
      const Change of_rate = evaluate_stages(q, h);
      double part = relative(of_v.change, of_v.size);
      bool at_rounding = false;
      if (has_effects_) {  // forces may balance, and what is left of V or ż be rounding: measured by the largest so far
        largest_v_ = std::max(largest_v_, of_v.size);
        largest_rate_ = std::max(largest_rate_, of_rate.size);
        part = std::max(relative(of_v.change, largest_v_), relative(of_rate.change, largest_rate_));
        for (const Vec& at : Q_)
          at_rounding = at_rounding || (of_rate.size == 0.0 && std::abs(h) * of_v.change <= this->epsilon * at.cwiseAbs().maxCoeff());
      }
      if (part == 0.0 || ((part < 1e-12 || at_rounding) && part >= 0.5 * before)) return true;
      before = part;
    }
    return false;
  }

  // y and p_new at the end of the step, by the weights of the method.
  void add_increments(double h) {
    const std::size_t s = V_.size();
    Vec v_sum = Vec::Zero(dof()), f_sum = v_sum;
    for (std::size_t i = 0; i < s; ++i) {
      v_sum += table_.b[index(i)] * V_[i];
      f_sum += table_.b[index(i)] * force_[i];
    }
    p_new_ = p_;
    lost_p_new_ = lost_p_;
    for (Eigen::Index k = 0; k < dof(); ++k) {
      detail::add_compensated(this->y_[k], this->lost_[k], h * v_sum[k]);
      detail::add_compensated(p_new_[k], lost_p_new_[k], h * f_sum[k]);
    }
    if constexpr (states != 0) {
      for (Eigen::Index k = 0; k < this->size() - 2 * dof(); ++k) {
        double sum = 0.0;
        for (std::size_t i = 0; i < s; ++i) sum += table_.b[index(i)] * zdot_[i][k];
        const Eigen::Index row = 2 * dof() + k;
        detail::add_compensated(this->y_[row], this->lost_[row], h * sum);
      }
    }
  }

  // q̇ with p(q, q̇) = p by Newton's method; one iteration where T is quadratic in q̇, and one to polish.
  bool find_velocity(double t) {
    const Vec q = q_of(this->y_);
    Vec v = V_.back();
    double before = std::numeric_limits<double>::infinity();
    for (int iteration = 0; iteration < most_iterations; ++iteration) {
      const Vec correction = inverse_mass(q, v, t) * (p_new_ - momenta(q, v, t));
      v += correction;
      if (!v.allFinite()) throw NonFinite("a velocity", t, "the velocity that belongs to the momenta is not finite");
      const double part = relative(correction.cwiseAbs().maxCoeff(), std::max(largest_v_, v.cwiseAbs().maxCoeff()));
      if (part < 1e-13 || (part < 1e-10 && part >= 0.5 * before)) {
        this->y_.segment(dof(), dof()) = v;
        return true;
      }
      before = part;
    }
    return false;
  }

  detail::GaussTable table_;
  bool has_effects_;
  Eigen::MatrixXd extrapolation_;
  std::vector<Vec> V_, V_old_, Q_, force_, momenta_;
  std::vector<double> times_;
  std::vector<States> Z_, zdot_;
  std::vector<Matrix<double, n>> inverse_;  // of M at the stages' first guess
  Vec p_, p_new_, lost_p_, lost_p_new_;
  double largest_v_ = 0.0, largest_rate_ = 0.0;  // entries of V and ż since reset(); of scenes only
  double h_before_ = 0.0;
  bool guess_is_known_ = false;
  bool diverges_ = false;  // the last change of the stages was larger than the one before
};

namespace detail {

// The stepper for a form.
template <class F>
struct GaussStepperOf {
  using type = GaussStepper<F::size_at_compile_time, Mechanics<F>::n, Mechanics<F>::states>;
  static type made(const F& system, int stages, double step, const Options& options) {
    return {std::make_unique<MechanicalRatesOf<F>>(system), stages, step, options};
  }
};

}  // namespace detail

/// Gauss collocation of order 2·stages with a fixed step, for any T and V and for scenes; symplectic where there are neither
/// forces nor constraints.
struct Gauss {
  static constexpr std::string_view name = "gauss";  ///< as statistics call it

  double step = 0.01;  ///< longest |h|; the way to t_end is divided equally
  int stages = 3;      ///< 1 … 8, order 2, 4, 6, 8 …

  /// A stepper for `system`, which it copies.
  ///
  /// @throws InvalidValue  step is not positive, stages is not 1 … 8
  template <FirstOrderSystem F>
    requires requires { detail::Mechanics<F>::n; }
  auto stepper(const F& system, const Options& options) const {
    return detail::GaussStepperOf<F>::made(system, stages, step, options);
  }
};

}  // namespace qdot
