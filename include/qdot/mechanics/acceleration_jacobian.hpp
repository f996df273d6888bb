#pragma once
// SPDX-License-Identifier: MIT
//
// q̈ and its derivatives with respect to q and q̇, which an implicit stepper asks for.
//
// The solution of the linear system is not differentiated. With the residual r(q, q̇, q̈) = M q̈ − rhs, which is zero on a motion, the
// implicit function theorem gives
//
//     ∂q̈/∂(q, q̇) = −M⁻¹ ∂r/∂(q, q̇)  at fixed q̈ ,
//
// and −r is what the scalar of Lagrange's equations calls X L when the rates of the velocities are the accelerations
// (mechanics/equations/straight_line_jacobian.hpp). Several ways, as for q̈ itself: straight-line code for few coordinates, derived lines, positions and masses
// (mechanics/equations/equation_slopes.hpp), lines that a run keeps (mechanics/derive/kept_lines.hpp), and for loops elsewhere a record of dual numbers
// (ad/records/residual_record.hpp) that is swept forwards and back. Where these give no finite number, nested duals are asked, as they are for q̈: they know that a constant has no derivative, however steep the root of it is. What
// is not finite then is an error.

#include <algorithm>

#include "qdot/mechanics/equations/equation_slopes.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"

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

// q̈ and its derivatives by records and blocks; false on a bad pivot or a number that is not finite.
template <int n, class E>
bool recorded_jacobian(const E& e, const Vector<double, n>& q, const Vector<double, n>& qdot, double t, double threshold,
                       AccelerationJacobian<n>& result) {
  constexpr int blocks = graded_blocks<n>, stride = 4 * blocks;
  constexpr int directions = residual_directions;
  const int size = static_cast<int>(q.size());
  double M[stride * stride], r[stride], inverse[stride];
  graded_equations<n>(e, q, qdot, t, M, r);
  if (!solved_by_blocks<blocks>(size, M, r, threshold, inverse)) return false;
  for (int i = 0; i < size; ++i) result.qddot[i] = r[i];
  double columns[stride][directions];
  for_each_residual<n>(e, q, qdot, result.qddot, t, [&](int i, int first, const double* residual) {
    const int count = std::min(directions, 2 * size - first), filled = (count + 3) / 4 * 4;
    for (int j = 0; j < filled; j += 4) set_block(columns[i] + j, 1.0, residual + j);
    if (i < size - 1) return;
    for (int k = 0; k < size; ++k) {  // L D Lᵀ with the L and 1/D that are there
      for (int below = k + 1; below < size; ++below)
        for (int j = 0; j < filled; j += 4) add_block(columns[below] + j, -M[below * stride + k], columns[k] + j);
      for (int j = 0; j < filled; j += 4) set_block(columns[k] + j, inverse[k], columns[k] + j);
    }
    for (int k = size - 1; k > 0; --k)
      for (int above = 0; above < k; ++above)
        for (int j = 0; j < filled; j += 4) add_block(columns[above] + j, -M[k * stride + above], columns[k] + j);
    for (int j = 0; j < count; j += 2)
      for (int k = 0; k < size; ++k) {
        const int coordinate = (first + j) / 2;
        result.d_q(k, coordinate) = columns[k][j];
        result.d_qdot(k, coordinate) = columns[k][j + 1];
      }
  });
  return is_finite(result);
}

// The same without records, for what hardly ever happens: nested duals, a direction at a time, and what is not finite by name. Half a second to
// compile.
template <class E, int n, Inertia I>
[[gnu::cold, gnu::noinline]] void jacobian_by_duals(const System<E, n, I>& system, const Vector<double, n>& q, const Vector<double, n>& qdot,
                                                    double t, AccelerationJacobian<n>& result) {
  using D = Dual<double, 1>;
  result.qddot = acceleration_of<E, n, I, double>(system, q, qdot, t);
  Vector<D, n> x = constants<D>(q), v = constants<D>(qdot);
  const Vector<D, n> a = constants<D>(result.qddot);
  const auto column = [&](D& number, auto&& derivative) {
    number.tangent[0] = 1.0;
    const Vector<D, n> r = lagrange_residual<n>(system.energies(), x, v, a, D(t));
    for (Eigen::Index i = 0; i < r.size(); ++i) derivative[i] = -r[i].tangent[0];
    number.tangent[0] = 0.0;
  };
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    column(x[j], result.d_q.col(j));
    column(v[j], result.d_qdot.col(j));
  }
  const Matrix<double, n> M = kinetic_hessian<n>(system.energies(), q, qdot, t);
  result.d_q = solved_with_mass_matrix(system, M, result.d_q, t);
  result.d_qdot = solved_with_mass_matrix(system, M, result.d_qdot, t);
  const auto row = [&](Eigen::Index i) { return "the acceleration of " + system.coordinate_name(i); };
  require_finite_derivatives(result.d_q, t, row, [&](Eigen::Index j) { return system.coordinate_name(j); });
  require_finite_derivatives(result.d_qdot, t, row, [&](Eigen::Index j) { return system.velocity_name(j); });
}

// The same with any mass matrix and any number of coordinates; false where a number is not finite.
template <class E, int n, Inertia I>
[[gnu::noinline]] bool general_jacobian(const System<E, n, I>& system, const Vector<double, n>& q, const Vector<double, n>& qdot, double t,
                                        AccelerationJacobian<n>& result) {
  result.qddot = acceleration_of<E, n, I, double>(system, q, qdot, t);
  for_each_residual<n>(system.energies(), q, qdot, result.qddot, t, [&](int i, int first, const double* residual) {
    for (int j = 0; j < std::min(residual_directions, 2 * static_cast<int>(system.dof()) - first); j += 2) {
      result.d_q(i, (first + j) / 2) = residual[j];
      result.d_qdot(i, (first + j) / 2) = residual[j + 1];
    }
  });
  const Matrix<double, n> M = mass_matrix(system, q, qdot, t);
  result.d_q = solved_with_mass_matrix(system, M, result.d_q, t);
  result.d_qdot = solved_with_mass_matrix(system, M, result.d_qdot, t);
  return is_finite(result);
}

// The same of few coordinates, by the slopes of the equations (mechanics/equations/equation_slopes.hpp).
template <class E, int n, Inertia I>
[[gnu::noinline]] bool sloped_jacobian(const System<E, n, I>& system, const Vector<double, n>& q, const Vector<double, n>& qdot, double t,
                                       AccelerationJacobian<n>& result) {
  double M[n * (n + 1) / 2];
  SlopeRow<2 * n> rows[n];
  result.qddot = acceleration_of<E, n, I, double>(system, q, qdot, t);
  return slopes_written<n>(system.energies(), q, qdot, result.qddot, t, M, rows) && solved_in_place<n>(M, rows, singular_pivot<double>(n)) &&
         columns_written<n>(rows, result.d_q.data(), result.d_qdot.data());
}

// The same by the lines that a run keeps.
template <class E, int n, Inertia I>
bool jacobian_by_lines(const System<E, n, I>& system, const DerivedLines& lines, const Vector<double, n>& q, const Vector<double, n>& qdot, double t,
                       AccelerationJacobian<n>& result) {
  double M[n * (n + 1) / 2];
  SlopeRow<2 * n> rows[n];
  result.qddot = acceleration_of<E, n, I, double>(system, q, qdot, t);
  return lines.template write_slopes<n>(q.data(), qdot.data(), result.qddot.data(), t, M, rows) && solved_in_place<n>(M, rows, singular_pivot<double>(n)) &&
         columns_written<n>(rows, result.d_q.data(), result.d_qdot.data());
}

}  // namespace detail

/// q̈ and ∂q̈/∂q, ∂q̈/∂q̇ at a state, exact, by −M⁻¹ ∂(M q̈ − rhs) at fixed q̈.
///
/// No allocation for fixed n up to 8.
///
/// @throws as acceleration(), and NonFinite where q̈ is finite but a derivative of it is not
template <class E, int n, Inertia I>
AccelerationJacobian<n> acceleration_jacobian(const System<E, n, I>& system, const Vector<double, n>& q,
                                              const Vector<double, n>& qdot, double t = 0.0) {
  detail::require_sizes(system, q, qdot);
  const Eigen::Index size = system.dof();
  AccelerationJacobian<n> result{Vector<double, n>(size), Matrix<double, n>(size, size), Matrix<double, n>(size, size)};
  constexpr bool has_short_ways = I == Inertia::positive_definite && !detail::HasOwnEquations<E> && detail::graded_pays<n>;
  constexpr bool has_straight_line =
      has_short_ways && detail::straight_line_pays && n >= 1 && n <= detail::straight_line_jacobian_limit;
  if constexpr (has_straight_line) {
    if (detail::straight_line_jacobian<n>(system.energies(), q.data(), qdot.data(), t, result.qddot.data(), result.d_q.data(),
                                          result.d_qdot.data()))
      return result;
  }
  if constexpr (detail::HasClosedJacobian<E> && !has_straight_line && detail::straight_line_pays && I == Inertia::positive_definite) {
    if (system.energies().acceleration_in_closed_form(q.data(), qdot.data(), t, result.qddot.data()) &&
        system.energies().jacobian_in_closed_form(q.data(), qdot.data(), t, result.qddot.data(), result.d_q.data(), result.d_qdot.data()))
      return result;
  }
  bool good = false;
  if constexpr (has_short_ways && detail::has_slopes<n> && detail::may_keep_lines<E, n>) {
    const detail::DerivedLines* const lines = detail::lines_with_slopes_now<n>(system.kept_lines(), system.energies());
    if (lines && detail::jacobian_by_lines(system, *lines, q, qdot, t, result)) return result;
  }
  if constexpr (has_short_ways && !(has_straight_line && detail::always_straight<E, n>)) {
    if (size <= detail::graded_limit<n>)
      good = detail::recorded_jacobian<n>(system.energies(), q, qdot, t, detail::singular_pivot<double>(size), result);
    else if constexpr (n == Dynamic)
      good = detail::general_jacobian(system, q, qdot, t, result);
  } else if constexpr (I == Inertia::positive_definite && detail::HasOwnEquations<E> && detail::has_slopes<n>) {
    good = detail::sloped_jacobian(system, q, qdot, t, result);
  } else if constexpr (!has_short_ways) {
    good = detail::general_jacobian(system, q, qdot, t, result);
  }
  if (!good) detail::jacobian_by_duals(system, q, qdot, t, result);
  return result;
}

}  // namespace qdot
