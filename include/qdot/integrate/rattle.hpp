#pragma once
// SPDX-License-Identifier: MIT
//
// Rattle: symplectic steps on constraints φ(q) = 0, for T(q̇) and V(q).
//
// A free step that is projected onto φ = 0 afterwards is as accurate, but not symplectic: the projection takes or gives a little
// energy each time, always with the same sign. Rattle lets the constraint forces act within the step, once at each end:
//
//     q̇½ = q̇ + h/2 M⁻¹ (F(q) + J(q)ᵀ λ) ,     q₁ = q + h q̇½ ,     λ such that φ(q₁) = 0
//     q̇₁ = q̇½ + h/2 M⁻¹ (F(q₁) + J(q₁)ᵀ μ) ,                      μ such that J(q₁) q̇₁ = 0 ,      F = −∂V/∂q.
//
// It is of order 2, symplectic on φ = 0, J q̇ = 0, its own inverse with −h, and keeps momenta of linear symmetries to rounding.
// Higher orders are palindromes of such steps (integrate/steps/symplectic_schemes.hpp): 3 for order 4, 9 for 6, 17 for 8. φ(q, t)
// and redundant rows are kept as well. What does not fit: T(q, q̇), forces, friction, nonholonomic constraints. Gauss takes those.
//
// Reference: H. C. Andersen, J. Comput. Phys. 52 (1983) 24; E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration,
// 2nd ed., Springer 2006, VII.1.4.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/stepper.hpp"
#include "qdot/integrate/steps/fixed_step.hpp"
#include "qdot/integrate/steps/symplectic_schemes.hpp"

namespace qdot {

namespace detail {

// Scenes of T(q̇), V(q) and holonomic constraints that last.
template <class F>
struct fits_rattle : std::false_type {};
template <class Sys, class... Effects>
struct fits_rattle<SceneForm<Scene<Sys, Effects...>>>
    : std::bool_constant<Scene<Sys, Effects...>::has_constraints && !Scene<Sys, Effects...>::has_forces && !Scene<Sys, Effects...>::has_phases &&
                         !Scene<Sys, Effects...>::has_states && !(NonholonomicEffect<Effects, Sys::dof_at_compile_time> || ...) &&
                         Scene<Sys, Effects...>::SystemType::kinetic_signature == KineticSignature::velocity> {};

// Lengths of the substeps that make a step of this order; empty for an order that is not here.
inline std::span<const double> rattle_substeps(int order) {
  static constexpr double one[] = {1.0};
  const auto all_but_last = [](const auto& drifts) { return std::span<const double>(drifts).first(drifts.size() - 1); };
  switch (order) {
    case 2: return one;
    case 4: return all_but_last(yoshida_4_steps.drifts);
    case 6: return all_but_last(kahan_li_6_steps.drifts);
    case 8: return all_but_last(kahan_li_8_steps.drifts);
    default: return {};
  }
}

}  // namespace detail

/// A Stepper that makes equal Rattle steps on the constraints of a scene. Movable.
template <class F>
class RattleStepper : public detail::FixedStepOf<F> {
  using Base = detail::FixedStepOf<F>;
  using Sc = std::remove_cvref_t<decltype(std::declval<const F&>().scene())>;
  using Base::n, Base::dof;
  static constexpr int m = Sc::constraints_at_compile_time;
  using Vec = Vector<double, n>;
  using Rows = Vector<double, m>;

 public:
  static constexpr bool projects_itself = true;

  /// @throws InvalidValue  step is not positive, order is not 2, 4, 6 or 8, the mass matrix depends on the velocities
  RattleStepper(const F& system, int order, double step, const Options& options)
      : Base(system, "rattle", order, step, options), substeps_(detail::rattle_substeps(order)) {
    detail::require_option(!substeps_.empty(), "order", "must be 2, 4, 6 or 8", order, "4 is usual");
    q_ = v_ = a_ = lost_q_ = lost_v_ = Vec::Zero(dof());
    invert_mass_matrix();
  }

  /// Starts (afresh) at (t, y), which must satisfy the constraints; evaluates the accelerations once there.
  ///
  /// @throws as RungeKuttaStepper::reset
  void reset(const TimePoint& at, const Eigen::Ref<const Eigen::VectorXd>& y) {
    this->begin(at, y);
    invert_mass_matrix();
    arrived_ = false;
  }

  /// One step towards t_limit: the way there is divided into equal steps.
  bool step(double t_limit) {
    const double end = this->next_end(t_limit);
    q_ = this->y_.head(dof());
    v_ = this->y_.tail(dof());
    lost_q_ = this->lost_.head(dof());
    lost_v_ = this->lost_.tail(dof());
    bool converged = true;
    const bool evaluated = this->attempt([&] {
      double reached = 0.0;
      if (!arrived_) arrive(this->clock_.shown(this->elapsed_));
      for (std::size_t i = 0; i < substeps_.size() && converged; ++i) {
        const double t = this->clock_.shown(this->elapsed_ + reached * this->h_);
        reached += substeps_[i];
        const double next = i + 1 == substeps_.size() ? end : this->elapsed_ + reached * this->h_;
        converged = substep(substeps_[i] * this->h_, t, this->clock_.shown(next));
      }
    });
    if (!evaluated || !converged) {
      arrived_ = false;
      ++this->statistics_.rejected_by_corrector;
      if (evaluated)
        this->failure_ = {Outcome::corrector_failure, "the constraints could not be met at the end of a step in " +
                                                          std::to_string(most_iterations) + " iterations; take a shorter step"};
      return this->give_up(this->h_);
    }
    this->y_old_ = this->y_;
    this->y_ << q_, v_;
    this->lost_ << lost_q_, lost_v_;
    this->finish(end);
    return true;
  }

 private:
  static constexpr int most_iterations = 50;

  const Sc& scene() const { return this->form().scene(); }

  void invert_mass_matrix() {
    M_ = detail::constant_mass_matrix(scene().system(), "Rattle");
    inverse_ = detail::inverse_mass_matrix(scene().system(), M_, 0.0);
  }

  // Force and normals at q_.
  void arrive(double t) {
    const Vec force = detail::lagrangian_gradient<n>(scene().system().energies(), q_, v_, t);
    ++this->statistics_.evaluations;
    a_.noalias() = inverse_ * force;
    factors_.emplace(M_, Matrix<double, m, n>(constraint_jacobian(scene(), q_, v_, t)), default_rank_cutoff);
    ++this->statistics_.linear_setups;
    arrived_ = true;
  }

  // From t to t_new = t + h; false if no λ was found.
  bool substep(double h, double t, double t_new) {
    const detail::SceneNames<Sc> names{scene()};
    const Vec free = q_ + h * (v_ + 0.5 * h * a_);
    Vec pushed = Vec::Zero(dof());  // h²/2 M⁻¹ Jᵀ λ
    double before = std::numeric_limits<double>::infinity();
    bool converged = false;
    for (int iteration = 0; iteration < most_iterations && !converged; ++iteration) {
      const Vec correction = factors_->displacement(Rows(-constraint_residual(scene(), Vec(free + pushed), t_new)), t, names);
      pushed += correction;
      double change = 0.0;  // relative to the size of each coordinate
      for (Eigen::Index i = 0; i < dof(); ++i) change = std::max(change, std::abs(correction[i]) / (1.0 + std::abs(free[i])));
      if (!correction.allFinite()) throw NonFinite("a constraint", t_new, "the constraints became infinite or NaN");
      converged = change == 0.0 || (change < 1e-12 && change >= 0.5 * before);
      before = change;
    }
    if (!converged) return false;
    for (Eigen::Index i = 0; i < dof(); ++i) {
      const double kick = 0.5 * h * a_[i] + pushed[i] / h;
      detail::add_compensated(q_[i], lost_q_[i], h * (v_[i] + 0.5 * h * a_[i]) + pushed[i]);
      detail::add_compensated(v_[i], lost_v_[i], kick);
    }
    arrive(t_new);
    const Vec kicked = v_ + 0.5 * h * a_;
    const Vec turned = factors_->displacement(Rows(-constraint_velocity(scene(), q_, kicked, t_new)), t_new, names);
    for (Eigen::Index i = 0; i < dof(); ++i) detail::add_compensated(v_[i], lost_v_[i], 0.5 * h * a_[i] + turned[i]);

    auto& s = this->statistics_;
    ++s.projections;
    s.constraint_residual = std::max(s.constraint_residual, constraint_residual(scene(), q_, t_new).cwiseAbs().maxCoeff());
    s.constraint_velocity = std::max(s.constraint_velocity, constraint_velocity(scene(), q_, v_, t_new).cwiseAbs().maxCoeff());
    return true;
  }

  std::span<const double> substeps_;
  Matrix<double, n> M_, inverse_;
  std::optional<detail::ConstrainedFactors<n, m>> factors_;  // of the normals at q_
  Vec q_, v_, a_, lost_q_, lost_v_;                          // a_ = M⁻¹ F(q_)
  bool arrived_ = false;                                     // factors_ and a_ belong to the present state
};

/// Symplectic steps on holonomic constraints, for T(qdot) quadratic and V(q).
struct Rattle {
  static constexpr std::string_view name = "rattle";  ///< as statistics call it

  double step = 0.01;  ///< longest |h|; the way to t_end is divided equally
  int order = 4;       ///< 2, 4, 6 or 8

  /// A stepper for the form of a scene, which it copies.
  ///
  /// @throws InvalidValue  step is not positive, order is not 2, 4, 6 or 8, the mass matrix depends on the velocities
  template <class Sc>
  RattleStepper<SceneForm<Sc>> stepper(const SceneForm<Sc>& system, const Options& options) const {
    static_assert(detail::fits_rattle<SceneForm<Sc>>::value,
                  "qdot: Rattle needs T(qdot), V(q) and holonomic constraints, and no forces, frictions or contacts; use Gauss");
    return {system, order, step, options};
  }
};

}  // namespace qdot
