#pragma once
// SPDX-License-Identifier: MIT
//
// q̈ and its derivatives with respect to q and q̇, which an implicit stepper asks for.
//
//     ∂q̈/∂(q, q̇) = −M⁻¹ ∂r/∂(q, q̇)  at fixed q̈ ,        r(q, q̇, q̈) = M q̈ − rhs = 0 on a motion
//
// The implicit function theorem spares differentiating the solution: first derivatives of Lagrange's equations at known
// accelerations are enough. They come in one of two ways. T and V are recorded and r is derived as lines. These are
// kept for up to eight coordinates (mechanics/derive/kept_lines.hpp), and made at each call where n is known at run
// time only. Nested duals, a direction at a time, take 2n passes: for functors that are no formulas, and for more than
// eight coordinates if n is known at compile time. Where lines give no finite number, duals are asked as well: they
// know that a constant has no derivative, however steep the root of it is. Runs ask a form
// (mechanics/first_order_form.hpp).
//
// Unrolled code of T and V on dual numbers was tried: a fifth of the code that a program with an implicit method
// compiled. A record of dual numbers, swept forward and back, was a seventh. Both were taken away.

#include <algorithm>
#include <vector>

#include "qdot/mechanics/derive/kept_equations.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/equations/limit_of_slopes.hpp"

namespace qdot {

/// q̈ and its derivatives with respect to q (n×n) and q̇ (n×n).
template <int n>
struct AccelerationJacobian {
  Vector<double, n> qddot;   ///< q̈, n
  Matrix<double, n> d_q;     ///< ∂q̈/∂q, n×n
  Matrix<double, n> d_qdot;  ///< ∂q̈/∂q̇, n×n
};

namespace detail {

template <int n>
bool is_finite(const AccelerationJacobian<n>& a) {
  return all_finite(a.qddot.data(), a.qddot.size()) && all_finite(a.d_q.data(), a.d_q.size()) && all_finite(a.d_qdot.data(), a.d_qdot.size());
}

// q̈ and its derivatives by the way that holds for everything: nested duals, a direction at a time, and what is not finite by name.
template <class E, int n, Inertia inertia>
[[gnu::cold, gnu::noinline]] void jacobian_by_duals(const System<E, n, inertia>& system, const Vector<double, n>& q, const Vector<double, n>& qdot,
                                                    double t, AccelerationJacobian<n>& result, bool or_limit = true) {
  using D = Dual<double, 1>;
  result.qddot = acceleration_of<E, n, inertia, double>(system, q, qdot, t);
  Vector<D, n> x = constants<D>(q), v = constants<D>(qdot);
  const Vector<D, n> a = constants<D>(result.qddot);
  const auto column = [&](D& number, double* derivative) {
    number.tangent[0] = 1.0;
    const Vector<D, n> r = lagrange_residual<n>(system.energies(), x, v, a, D(t));
    for (Eigen::Index i = 0; i < r.size(); ++i) derivative[i] = -r[i].tangent[0];
    number.tangent[0] = 0.0;
  };
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    column(x[j], result.d_q.data() + j * q.size());
    column(v[j], result.d_qdot.data() + j * q.size());
  }
  const Matrix<double, n> M = general_mass_matrix<n>(system.energies(), q, qdot, t);
  result.d_q = solved_with_mass_matrix(system, M, result.d_q, t);
  result.d_qdot = solved_with_mass_matrix(system, M, result.d_qdot, t);
  if (or_limit && all_finite(result.qddot.data(), result.qddot.size()) && !is_finite(result)) {
    const Eigen::Index k = q.size();
    const auto slopes_at = [&](const Eigen::VectorXd& place, Eigen::MatrixXd& J) {
      AccelerationJacobian<n> beside{result};
      using X = Vector<double, n>;
      jacobian_by_duals<E, n, inertia>(system, X(Eigen::Map<const X>(place.data(), k)), X(Eigen::Map<const X>(place.data() + k, k)), t, beside, false);
      J.resize(k, 2 * k);
      std::copy_n(beside.d_qdot.data(), k * k, std::copy_n(beside.d_q.data(), k * k, J.data()));
    };
    Eigen::VectorXd y(2 * k);
    std::copy_n(qdot.data(), k, std::copy_n(q.data(), k, y.data()));
    if (Eigen::MatrixXd J; slopes_in_the_limit(y, k, J, slopes_at)) {
      std::copy_n(J.data(), k * k, result.d_q.data());
      std::copy_n(J.data() + k * k, k * k, result.d_qdot.data());
    }
  }
  const auto row = [&](Eigen::Index i) { return sentence({"the acceleration of ", system.coordinate_name(i)}); };
  require_finite_derivatives(result.d_q, t, row, [&](Eigen::Index j) { return system.coordinate_name(j); });
  require_finite_derivatives(result.d_qdot, t, row, [&](Eigen::Index j) { return system.velocity_name(j); });
}

// The Jacobian of systems whose number of coordinates is known at run time. T and V are traced and differentiated at each call, which
// pays for many coordinates.
template <class E, Inertia inertia>
bool jacobian_traced_here(const System<E, Dynamic, inertia>& system, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, double t,
                          AccelerationJacobian<Dynamic>& result) {
  const Eigen::Index dof = system.dof();
  Eigen::VectorXd y(2 * dof), ydot(2 * dof);
  std::copy_n(qdot.data(), dof, std::copy_n(q.data(), dof, y.data()));
  Eigen::MatrixXd J(2 * dof, 2 * dof);
  if (!traced_jacobians<Dynamic>()->write(recordable(system), {}, t, y.data(), ydot.data(), J)) return false;
  std::copy_n(ydot.data() + dof, dof, result.qddot.data());
  for (Eigen::Index j = 0; j < dof; ++j) {
    std::copy_n(J.data() + 2 * dof * j + dof, dof, result.d_q.data() + dof * j);
    std::copy_n(J.data() + 2 * dof * (dof + j) + dof, dof, result.d_qdot.data() + dof * j);
  }
  return true;
}

// The Jacobian by lines of M, r and slopes, with M and r evaluated once; false where a number is not finite.
template <int n>
bool jacobian_by_lines(const DerivedLines& lines, const Vector<double, n>& q, const Vector<double, n>& qdot, double t, AccelerationJacobian<n>& result) {
  double M[n * (n + 1) / 2];
  SlopeRow<2 * n> rows[n];
  const auto solved = [&](const double* mass, double* r) {
    double factors[n * (n + 1) / 2];
    std::copy_n(mass, n * (n + 1) / 2, factors);
    const bool good = solved_in_place<n>(factors, r, singular_pivot<double>(n));
    std::copy_n(r, n, result.qddot.data());
    return good && all_finite(r, n);
  };
  if (!lines.template write_slopes<n>(q.data(), qdot.data(), t, M, rows, solved) || !solved_in_place<n>(M, rows, singular_pivot<double>(n))) return false;
  double zero = 0.0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      result.d_q(i, j) = rows[i][j];
      result.d_qdot(i, j) = rows[i][n + j];
      zero += (rows[i][j] - rows[i][j]) + (rows[i][n + j] - rows[i][n + j]);
    }
  return zero == 0.0;
}

}  // namespace detail

/// q̈ and ∂q̈/∂q, ∂q̈/∂q̇ at a state, exact, by −M⁻¹ ∂(M q̈ − rhs) at fixed q̈.
///
/// No allocation for fixed n up to 8, but for the first call, which derives the equations. Beyond 8 coordinates these cost some 2n
/// passes on nested duals here: of many states ask first_order_form(system).jacobian(), which derives slopes for any n.
///
/// @throws as acceleration(), and NonFinite where q̈ is finite but a derivative of it is not
template <class E, int n, Inertia inertia>
AccelerationJacobian<n> acceleration_jacobian(const System<E, n, inertia>& system, const Vector<double, n>& q,
                                              const Vector<double, n>& qdot, double t = 0.0) {
  detail::require_sizes(system, q, qdot);
  const Eigen::Index size = system.dof();
  AccelerationJacobian<n> result{Vector<double, n>(size), Matrix<double, n>(size, size), Matrix<double, n>(size, size)};
  if constexpr (inertia == Inertia::positive_definite && n >= 1 && n <= detail::unrolled_limit) {
    const auto written = [&](const detail::DerivedLines& lines) { return detail::jacobian_by_lines<n>(lines, q, qdot, t, result); };
    if (detail::with_lines_and_slopes<n>(system.kept_lines(), system.energies(), detail::AtState{q.data(), qdot.data(), t}, written)) return result;
  }
  if constexpr (detail::TracedSystem<System<E, n, inertia>>) {
    if (system.kept_lines()->may_be_lines() && detail::jacobian_traced_here(system, q, qdot, t, result)) return result;
  }
  detail::jacobian_by_duals(system, q, qdot, t, result);
  return result;
}
/// q̈ and its derivatives at a State, of a system or a scene.
template <HasEnergies M>
AccelerationJacobian<M::dof_at_compile_time> acceleration_jacobian(const M& model, const State<M::dof_at_compile_time>& state) {
  return acceleration_jacobian(model, state.q, state.qdot, state.t);
}

}  // namespace qdot
