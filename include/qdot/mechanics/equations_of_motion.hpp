#pragma once
// SPDX-License-Identifier: MIT
//
// Lagrange's equations, solved for the accelerations:
//
//     M q̈ = rhs ,      rhs = ∂L/∂q − (∂²L/∂q̇∂q) q̇ − ∂²L/∂q̇∂t .
//
// Where T or V has no value there is no q̈ either: the derivatives of functions end where the functions do (ad/forward/algebraic.hpp), and formulas
// that were simplified remember where they hold (ad/formula/domains.hpp). So NaN in q̈ is all that has to be looked for.
//
// acceleration() is what a stepper asks for; an implicit stepper asks for its derivatives besides (acceleration_jacobian.hpp).

#include <cmath>
#include <string>
#include <type_traits>

#include "qdot/mechanics/equations/banded_equations.hpp"
#include "qdot/mechanics/derive/recordable_system.hpp"
#include "qdot/mechanics/mass_and_rhs.hpp"
#include "qdot/mechanics/mass_matrix.hpp"

namespace qdot {

namespace detail {

template <class Number = double>
[[noreturn, gnu::cold]] void throw_not_finite(const std::string& name, double t) {
  throw NonFinite(name, t, sentence({"the equations of motion must be finite, but ", name, " is not at t = ", {t, 6},
                                     "; check T and V there for a division by zero, a root or logarithm outside its domain, or overflow"}));
}

// No accelerations follow from NaN and infinity.
template <class Sys, class S, int n>
void require_finite_state(const Sys& system, const Vector<S, n>& q, const Vector<S, n>& qdot, double t) {
  using std::isfinite;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (!isfinite(innermost_value(q[i]))) throw_not_finite(system.coordinate_name(i), t);
    if (!isfinite(innermost_value(qdot[i]))) throw_not_finite(system.velocity_name(i), t);
  }
}

// NaN and infinity are not accelerations: name what they came from.
template <class Sys, class S, int n>
void require_finite_acceleration(const Sys& system, const Vector<S, n>& qddot, const Vector<S, n>& q,
                                 const Vector<S, n>& qdot, const S& t) {
  using std::isfinite;
  bool finite = true;
  for (Eigen::Index i = 0; i < qddot.size(); ++i) finite = finite && isfinite(innermost_value(qddot[i]));
  if (finite) return;
  const double at = static_cast<double>(innermost_value(t));
  if constexpr (std::is_same_v<S, double>)
    if (all_finite(q.data(), q.size()) && all_finite(qdot.data(), qdot.size())) require_finite_energies(system.system().energies(), q, qdot, t);
  require_finite_state(system, q, qdot, at);
  for (Eigen::Index i = 0; i < q.size(); ++i)
    if (!isfinite(innermost_value(qddot[i]))) throw_not_finite(sentence({"the acceleration of ", system.coordinate_name(i)}), at);
}

template <class Number = double>
[[noreturn, gnu::cold]] void throw_derivative_not_finite(const std::string& what, const std::string& with, double t) {
  const std::string name = sentence({"the derivative of ", what, " with ", with});
  throw NonFinite(name, t, sentence({"the derivatives of accelerations must be finite, but ", name, " is not at t = ", {t, 6},
                                     ", where the acceleration is; look there for the root or the power of something that is zero, and "
                                     "round it off, as sqrt(x*x + e*e) does, or take a method that needs no Jacobian"}));
}

// Nor are they derivatives of what is finite: name the first.
template <class Derivatives, class RowName, class ColumnName>
void require_finite_derivatives(const Derivatives& J, double t, const RowName& row, const ColumnName& column) {
  for (Eigen::Index j = 0; j < J.cols(); ++j)
    for (Eigen::Index i = 0; i < J.rows(); ++i) {
      if (std::isfinite(J(i, j))) continue;
      throw_derivative_not_finite(row(i), column(j), t);
    }
}

// q̈ by the way that holds for everything, and that names what is wrong.
template <class E, int n, Inertia inertia, class S>
[[gnu::noinline]] Vector<S, n> general_acceleration(const System<E, n, inertia>& system, const Vector<S, n>& at, const Vector<S, n>& velocity,
                                                    const S& t) {
  require_finite_state(system, at, velocity, static_cast<double>(innermost_value(t)));
  const MassAndRhs<S, n> both = general_mass_and_rhs<n, inertia != Inertia::positive_definite>(system.energies(), at, velocity, t);
  const Vector<S, n> qddot = solved_with_mass_matrix(system, both.M, both.r, t);
  require_finite_acceleration(system, qddot, at, velocity, t);
  return qddot;
}

// q̈ where the shortest evaluation does not apply. It is written to a: a returned vector would be copied twice, which delays the caller. A function
// of its own, so that acceleration_of stays short.
template <class E, int n, Inertia inertia, class S>
[[gnu::noinline]] void write_longer_acceleration(const System<E, n, inertia>& system, const Vector<S, n>& at, const Vector<S, n>& velocity, const S& t,
                                                 Vector<S, n>& a) {
  if constexpr (std::is_same_v<S, double> && inertia == Inertia::positive_definite) {
    const AccelerationTo<n> use{a.data(), singular_pivot<double>(at.size())};
    if (with_mass_and_rhs<n>(system.energies(), at, velocity, t, use, system.kept_lines())) return;
  }
  a = general_acceleration<E, n, inertia, S>(system, at, velocity, t);
}

// q̈ from the energies, whatever they are made of. One variable is returned, made where the result is wanted.
template <class E, int n, Inertia inertia, class S>
Vector<S, n> acceleration_of(const System<E, n, inertia>& system, const Vector<S, n>& at, const Vector<S, n>& velocity, const S& t) {
  Vector<S, n> a(at.size());
  if constexpr (std::is_same_v<S, double> && inertia == Inertia::positive_definite) {
    if constexpr (system_has_rates<System<E, n, inertia>>)
      if (write_acceleration_by_lines(system, at, velocity, t, a.data())) return a;
  }
  write_longer_acceleration<E, n, inertia, S>(system, at, velocity, t, a);
  return a;
}

// q̈ from M q̈ = rhs + Q by the way that holds for everything. Where Q is not finite, `blame()` is called first, and may throw.
template <class E, int n, Inertia inertia, class Blame>
[[gnu::noinline]] Vector<double, n> general_acceleration_under_force(const System<E, n, inertia>& system, const Vector<double, n>& q,
                                                                     const Vector<double, n>& qdot, double t, const Vector<double, n>& Q,
                                                                     const Blame& blame) {
  if (!all_finite(Q)) blame();
  MassAndRhs<double, n> both = mass_and_rhs(system, q, qdot, t);
  both.r += Q;
  const Vector<double, n> a = solved_with_mass_matrix(system, both.M, both.r, t);
  require_finite_acceleration(system, a, q, qdot, t);
  return a;
}

// q̈ from M q̈ = rhs + Q by the shortest evaluation that the energies allow.
template <class E, int n, Inertia inertia, class Blame>
Vector<double, n> acceleration_under_force(const System<E, n, inertia>& system, const Vector<double, n>& q, const Vector<double, n>& qdot,
                                           double t, const Vector<double, n>& Q, const Blame& blame) {
  if constexpr (inertia == Inertia::positive_definite) {
    Vector<double, n> a = zeros<Vector<double, n>>(q.size());
    const AccelerationTo<n, true> use{a.data(), singular_pivot<double>(q.size()), Q.data()};
    if (with_mass_and_rhs<n>(system.energies(), q, qdot, t, use, system.kept_lines())) return a;
  }
  return general_acceleration_under_force(system, q, qdot, t, Q, blame);
}

#ifdef QDOT_COMPILED
extern template void throw_not_finite<double>(const std::string&, double);
extern template void throw_derivative_not_finite<double>(const std::string&, const std::string&, double);
#endif

}  // namespace detail

/// Right-hand side of M q̈ = rhs at a state: forces of V, centrifugal and Coriolis terms, explicit time.
///
/// @param q, qdot  state, n each
/// @return         generalized forces, n   [energy per unit of q]
template <class E, int n, Inertia inertia, class Q, class Qdot>
auto rhs(const System<E, n, inertia>& system, const Eigen::MatrixBase<Q>& q, const Eigen::MatrixBase<Qdot>& qdot,
         typename Q::Scalar t = typename Q::Scalar(0)) {
  using S = typename Q::Scalar;
  if constexpr (std::is_same_v<S, double>) return mass_and_rhs(system, Vector<S, n>(q), Vector<S, n>(qdot), t).r;
  else return detail::lagrange_rhs<n>(system.energies(), Vector<S, n>(q), Vector<S, n>(qdot), t);
}

/// Accelerations q̈ from Lagrange's equations at a state.
///
/// Exact to rounding times the condition of M. The first call derives the equations of T and V (15 µs for two coordinates, 100 for eight). Each later call
/// checks that T and V still are what was derived. No allocation for fixed n beyond that.
///
/// @param q, qdot  state, n each; may hold duals
/// @return         q̈, n   [units of q per unit time squared]
/// @throws         SingularMassMatrix, IndefiniteMassMatrix  with the direction in the coordinates' names
/// @throws         NonFinite       when an energy or its derivative is not finite there
/// @throws         DimensionError  when n is known at run time and a size disagrees
template <class E, int n, Inertia inertia, class Q, class Qdot>
auto acceleration(const System<E, n, inertia>& system, const Eigen::MatrixBase<Q>& q, const Eigen::MatrixBase<Qdot>& qdot,
                  typename Q::Scalar t = typename Q::Scalar(0)) {
  using S = typename Q::Scalar;
  detail::require_sizes(system, q, qdot);
  return detail::acceleration_of<E, n, inertia, S>(system, q.derived(), qdot.derived(), t);
}

/// d/dt(∂L/∂q̇) − ∂L/∂q at given accelerations: the applied generalized force that this motion needs.
///
/// Zero on a free motion (inverse dynamics). First derivatives only: no mass matrix is formed.
template <class E, int n, Inertia inertia, class Q, class Qdot, class Qddot>
auto inverse_dynamics(const System<E, n, inertia>& system, const Eigen::MatrixBase<Q>& q, const Eigen::MatrixBase<Qdot>& qdot,
                      const Eigen::MatrixBase<Qddot>& qddot, typename Q::Scalar t = typename Q::Scalar(0)) {
  using S = typename Q::Scalar;
  detail::require_sizes(system, q, qdot);
  detail::require_size(system, "qddot", qddot);
  return detail::lagrange_residual<n>(system.energies(), Vector<S, n>(q), Vector<S, n>(qdot), Vector<S, n>(qddot), t);
}

/// q̈ of a system or a scene by one way (mechanics/by.hpp), with the same errors. Copies the model.
template <HasEnergies M>
Coordinates<M> acceleration(const M& model, const Coordinates<M>& q, const Coordinates<M>& qdot, double t, By way) {
  if (way == By::fastest) return acceleration(model, q, qdot, t);
  return acceleration(model.by(way), q, qdot, t);
}

/// q̈ at a State, of a system or a scene.
///
/// @throws as for (q, qdot, t); for a scene also InvalidValue where several phases of contacts and friction fit
template <HasEnergies M>
Coordinates<M> acceleration(const M& model, const State<M::dof_at_compile_time>& state) {
  return acceleration(model, state.q, state.qdot, state.t);
}
/// q̈ of a system or a scene at a State by one way (mechanics/by.hpp).
template <HasEnergies M>
Coordinates<M> acceleration(const M& model, const State<M::dof_at_compile_time>& state, By way) {
  return acceleration(model, state.q, state.qdot, state.t, way);
}
/// The right-hand side at a State, of a system or a scene.
template <HasEnergies M>
Coordinates<M> rhs(const M& model, const State<M::dof_at_compile_time>& state) {
  return rhs(model, state.q, state.qdot, state.t);
}
/// The force that accelerations q̈ need at a State, of a system or a scene.
template <HasEnergies M>
Coordinates<M> inverse_dynamics(const M& model, const State<M::dof_at_compile_time>& state, const Coordinates<M>& qddot) {
  return inverse_dynamics(model, state.q, state.qdot, qddot, state.t);
}

// Old names, accepted until 0.4.

/// inverse_dynamics() by its old name.
template <class E, int n, Inertia inertia, class Q, class Qdot, class Qddot>
[[deprecated("qdot: say inverse_dynamics()")]]
auto motion_residual(const System<E, n, inertia>& system, const Eigen::MatrixBase<Q>& q, const Eigen::MatrixBase<Qdot>& qdot,
                     const Eigen::MatrixBase<Qddot>& qddot, typename Q::Scalar t = typename Q::Scalar(0)) {
  return inverse_dynamics(system, q, qdot, qddot, t);
}
template <HasEnergies M>
[[deprecated("qdot: say inverse_dynamics()")]]
Coordinates<M> motion_residual(const M& model, const State<M::dof_at_compile_time>& state, const Coordinates<M>& qddot) {
  return inverse_dynamics(model, state, qddot);
}

}  // namespace qdot
