#pragma once
// SPDX-License-Identifier: MIT
//
// The mechanics behind a first-order form.
//
// Most methods ask for no more than ẏ = f(t, y). Some want to know what f is made of:
//
//     d/dt p = F ,    p = ∂L/∂q̇ ,    F = ∂L/∂q + Σ Q + Jᵀλ ,        ż = rates(q, q̇, z, t) ,
//
// with y = [q; q̇; z]. Mechanics<F> tells them, for a system (F = ∂L/∂q, no z) and for a scene with its effects. Terms of
// effects that belong into L are in p and ∂L/∂q already. A type that hides a system can have a Mechanics of its own.
//
// A scene's header is not included here: code that has a scene has included it.

#include <Eigen/Core>
#include <type_traits>

#include "qdot/ad/derivatives.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/energy.hpp"
#include "qdot/mechanics/first_order_form.hpp"
#include "qdot/mechanics/mass_matrix.hpp"

namespace qdot {

template <class Sc>
class SceneForm;

namespace detail {

struct RateOfStates {};  // the tag of perturbations along the motion of effects' own states

template <class F>
struct Mechanics;

template <class Sys, int n = Sys::dof_at_compile_time>
Matrix<double, n> inverse_mass_matrix(const Sys& system, const Matrix<double, n>& M, double t) {
  return solved_with_mass_matrix(system, M, Matrix<double, n>(Matrix<double, n>::Identity(system.dof(), system.dof())), t);
}

// M of a T(q̇) that must be quadratic; the error names the method by the argument.
template <class Sys, int n = Sys::dof_at_compile_time>
Matrix<double, n> constant_mass_matrix(const Sys& system, const char* who) {
  const Vector<double, n> zero = Vector<double, n>::Zero(system.dof()), one = Vector<double, n>::Ones(system.dof());
  const Matrix<double, n> M = mass_matrix(system, zero, zero);
  const Matrix<double, n> change = mass_matrix(system, zero, one) - M;
  if (!(change.cwiseAbs().maxCoeff() <= 1e-12 * M.cwiseAbs().maxCoeff()))
    throw InvalidValue(sentence(
        {who, " needs a kinetic energy that is quadratic in qdot, but its mass matrix differs between qdot = 0 and qdot = 1; use Gauss"}));
  return M;
}

template <class Sys>
struct Mechanics<FirstOrderForm<Sys>> {
  using F = FirstOrderForm<Sys>;
  static constexpr int n = Sys::dof_at_compile_time;
  static constexpr int states = 0;
  static constexpr int constraints = 0;
  static constexpr Inertia inertia = Sys::inertia;
  using Vec = Vector<double, n>;
  using States = Vector<double, states>;

  static Eigen::Index dof(const F& form) { return form.system().dof(); }
  static Vec momenta(const F& form, const Vec& q, const Vec& v, double t) { return conjugate_momenta(form.system(), q, v, t); }
  static Vec force(const F& form, const Vec& q, const Vec& v, const States&, double t) {
    return lagrangian_gradient<n>(form.system().energies(), q, v, t);
  }
  static Matrix<double, n> inverse_mass(const F& form, const Vec& q, const Vec& v, double t) {
    return inverse_mass_matrix(form.system(), mass_matrix(form.system(), q, v, t), t);
  }
};

template <class Sc>
struct Mechanics<SceneForm<Sc>> {
  using F = SceneForm<Sc>;
  static constexpr int n = Sc::dof_at_compile_time;
  static constexpr int states = Sc::states_at_compile_time;
  static constexpr int constraints = Sc::constraints_at_compile_time;
  static constexpr Inertia inertia = Sc::SystemType::inertia;
  using Vec = Vector<double, n>;
  using States = Vector<double, states>;

  static Eigen::Index dof(const F& form) { return form.dof(); }
  static Vec momenta(const F& form, const Vec& q, const Vec& v, double t) {
    return conjugate_momenta(form.scene().system(), q, v, t);
  }
  static Vec force(const F& form, const Vec& q, const Vec& v, const States& z, double t) {
    Vec sum = lagrangian_gradient<n>(form.scene().system().energies(), q, v, t);
    if constexpr (Sc::has_forces) sum += effect_forces(form.scene(), q, v, z, t);
    if constexpr (Sc::has_constraints) sum += reactions(form.scene(), q, v, t, z);
    return sum;
  }
  static Matrix<double, n> inverse_mass(const F& form, const Vec& q, const Vec& v, double t) {
    return inverse_mass_matrix(form.scene().system(), mass_matrix(form.scene().system(), q, v, t), t);
  }
  static States zdot(const F& form, const Vec& q, const Vec& v, const States& z, double t) {
    return state_rates(form.scene(), q, v, z, t);
  }
  // z̈ on a motion with accelerations a and rates w of z.
  static States zddot(const F& form, const Vec& q, const Vec& v, const Vec& a, const States& z, const States& w, double t) {
    using D = Dual<double, 1, RateOfStates>;
    const auto moving = [](const auto& x, const auto& rate) {
      Vector<D, std::remove_cvref_t<decltype(x)>::RowsAtCompileTime> both(x.size());
      for (Eigen::Index i = 0; i < x.size(); ++i) {
        both[i].value = x[i];
        both[i].tangent[0] = rate[i];
      }
      return both;
    };
    const auto rates = state_rates(form.scene(), moving(q, v), moving(v, a), moving(z, w), D::variable(t, 0));
    States result(z.size());
    for (Eigen::Index i = 0; i < z.size(); ++i) result[i] = rates[i].tangent[0];
    return result;
  }
};

}  // namespace detail
}  // namespace qdot
