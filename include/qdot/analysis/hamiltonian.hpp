#pragma once
// SPDX-License-Identifier: MIT
//
// Momenta in place of velocities
// ==============================
//
//     H(q, p, t) = p·q̇ − L(q, q̇, t) ,        with q̇ from  p = ∂L/∂q̇ ,
//     q̇ = ∂H/∂p ,      ṗ = −∂H/∂q ,           and of any f(q, p, t):   ḟ = {f, H} + ∂f/∂t ,
//     {f, g} = ∂f/∂q·∂g/∂p − ∂f/∂p·∂g/∂q      Poisson's bracket.
//
// Nothing of this is differentiated twice. H is stationary in q̇ where p = ∂L/∂q̇, so its slopes are those at fixed q̇:
// ∂H/∂p = q̇, and ∂H/∂q = −∂L/∂q. What is left is q̇ from p. Where T is quadratic in q̇, ∂T/∂q̇ = p is linear. One step
// of Newton's method with M solves it, a second takes away rounding. Other T, as with a speed of light, take more
// steps, and shorter ones. H may be asked for derivatives, too. One step from the solution with plain numbers, carried
// out in duals, makes q̇ right to first order; each further step adds an order, whatever M it uses.

#include <type_traits>

#include <Eigen/Core>

#include "qdot/ad/forward/functor_result.hpp"
#include "qdot/ad/derivatives.hpp"
#include "qdot/ad/dual.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/energy.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/mass_matrix.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot {

namespace detail {

struct SlopeInPhaseSpace {};  // the tag of perturbations of q and p

// How often a scalar can be differentiated by its ε.
template <class S>
inline constexpr int order_of_dual = 0;
template <class S, int n, class Tag>
inline constexpr int order_of_dual<Dual<S, n, Tag>> = 1 + order_of_dual<S>;

template <int n, class X>
Vector<double, n> plain_vector(const X& x) {
  Vector<double, n> plain(x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) plain[i] = static_cast<double>(innermost_value(x[i]));
  return plain;
}

// f(q, p, t), or f(q, p).
template <class S, int n, class F>
S in_phase_space(const F& f, const Vector<S, n>& q, const Vector<S, n>& p, const S& t) {
  if constexpr (detail::is_callable<const F&, const Vector<S, n>&, const Vector<S, n>&, const S&>) {
    return S(f(q, p, t));
  } else {
    static_assert(detail::is_callable<const F&, const Vector<S, n>&, const Vector<S, n>&>,
                  "qdot: a function of phase space must be callable as f(q, p) or f(q, p, t) for every scalar: take `const auto&`");
    return S(f(q, p));
  }
}

template <int n>
struct VelocityAndMass {
  Vector<double, n> qdot;
  Matrix<double, n> M;
};

// Newton's method for ∂T/∂q̇ = p from q̇ = 0, with plain numbers.
template <class Sys, int n>
VelocityAndMass<n> velocity_and_mass(const Sys& system, const Vector<double, n>& q, const Vector<double, n>& p, double t) {
  Vector<double, n> v = Vector<double, n>::Zero(q.size()), missing = p - conjugate_momenta(system, q, v, t);
  Matrix<double, n> M;
  constexpr int most = 50;
  for (int iteration = 0;; ++iteration) {
    M = mass_matrix(system, q, v, t);
    const Vector<double, n> step = solved_with_mass_matrix(system, M, missing, t);
    if (step.cwiseAbs().maxCoeff() <= 1e-12 * v.cwiseAbs().maxCoeff()) {
      v += step;
      break;
    }
    const double before = missing.cwiseAbs().maxCoeff();
    double part = 1.0;  // of the step; less where T has no value so far away, or is too curved
    for (;; part *= 0.5) {
      const Vector<double, n> next = v + part * step;
      missing = p - conjugate_momenta(system, q, next, t);
      if (missing.allFinite() && missing.cwiseAbs().maxCoeff() <= (1.0 - 0.25 * part) * before) {
        v = next;
        break;
      }
      if (part < 1e-9) break;
    }
    if (part < 1e-9 || iteration == most)
      throw_invalid_value({"there must be a velocity with the given momenta, but the search for it ended at ", system.velocity_name(0), " = ", {v[0], 6},
                                   ", where one of the momenta is ", {before, 6}, " off; ask whether T, which is not quadratic in the velocities, has such momenta"});
  }
  return {v, M};
}

}  // namespace detail

/// q̇ with the momenta p at q, n; duals carry derivatives through.
///
/// Two evaluations of M and p, of a T that is not quadratic in q̇ a few more.
///
/// @throws MassMatrixError  where M has no inverse
/// @throws InvalidValue     when no q̇ with these momenta is found
template <class E, int n, Inertia inertia, class Q, class P>
auto velocities_of_momenta(const System<E, n, inertia>& system, const Eigen::MatrixBase<Q>& q, const Eigen::MatrixBase<P>& p,
                           typename Q::Scalar t = typename Q::Scalar(0)) {
  using S = typename Q::Scalar;
  static_assert(std::is_same_v<S, typename P::Scalar>, "qdot: q and p must be vectors of the same scalar");
  detail::require_sizes(system, q, p);
  const Vector<double, n> q0 = detail::plain_vector<n>(q), p0 = detail::plain_vector<n>(p);
  const double t0 = static_cast<double>(innermost_value(t));
  const detail::VelocityAndMass<n> plain = detail::velocity_and_mass(system, q0, p0, t0);
  if constexpr (detail::order_of_dual<S> == 0) {
    return plain.qdot;
  } else {
    const Matrix<double, n> unit = Matrix<double, n>::Identity(q.size(), q.size());
    const Matrix<double, n> W = detail::solved_with_mass_matrix(system, plain.M, unit, t0);
    const Vector<S, n> at = q;
    Vector<S, n> qdot(q.size());
    for (Eigen::Index i = 0; i < q.size(); ++i) qdot[i] = S(plain.qdot[i]);
    for (int order = 0; order < detail::order_of_dual<S>; ++order) {
      const Vector<S, n> missing = p - conjugate_momenta(system, at, qdot, t);
      for (Eigen::Index i = 0; i < q.size(); ++i)
        for (Eigen::Index j = 0; j < q.size(); ++j) qdot[i] += W(i, j) * missing[j];
    }
    return qdot;
  }
}

/// H(q, p, t) = p·q̇ − L; duals carry derivatives through.
///
/// @throws as velocities_of_momenta()
template <class E, int n, Inertia inertia, class Q, class P>
auto hamiltonian(const System<E, n, inertia>& system, const Eigen::MatrixBase<Q>& q, const Eigen::MatrixBase<P>& p,
                 typename Q::Scalar t = typename Q::Scalar(0)) {
  using S = typename Q::Scalar;
  const Vector<S, n> qdot = velocities_of_momenta(system, q, p, t);
  return S(p.dot(qdot) - lagrangian(system, q, qdot, t));
}

/// q̇ and ṗ.
template <int n>
struct PhaseVelocity {
  Vector<double, n> qdot;  ///< ∂H/∂p
  Vector<double, n> pdot;  ///< −∂H/∂q
};

/// Hamilton's equations at (q, p, t), exact: q̇ from p, and ṗ = ∂L/∂q there.
///
/// @throws as velocities_of_momenta()
template <class E, int n, Inertia inertia, class Q, class P>
PhaseVelocity<n> phase_velocity(const System<E, n, inertia>& system, const Eigen::MatrixBase<Q>& q, const Eigen::MatrixBase<P>& p, double t = 0.0) {
  const Vector<double, n> qdot = velocities_of_momenta(system, q, p, t);
  return {qdot, lagrangian_gradient(system, q, qdot, t)};
}

/// H of a system as a function of (q, p, t), for brackets; made by hamiltonian_of().
template <class Sys>
struct Hamiltonian {
  Sys system;  ///< whose H it is

  /// H(q, p, t).
  template <class S>
  S operator()(const Vector<S, Sys::dof_at_compile_time>& q, const Vector<S, Sys::dof_at_compile_time>& p, const S& t) const {
    return hamiltonian(system, q, p, t);
  }
};

/// H of a system as a function: poisson_bracket(f, hamiltonian_of(system), q, p) is ḟ.
template <class E, int n, Inertia inertia>
Hamiltonian<System<E, n, inertia>> hamiltonian_of(const System<E, n, inertia>& system) {
  return {system};
}

/// H, as a function, of a scene whose effects are terms in T and V.
template <class Sys, class... Effects>
auto hamiltonian_of(const Scene<Sys, Effects...>& scene) {
  using Sc = Scene<Sys, Effects...>;
  static_assert(!Sc::has_forces && !Sc::has_constraints,
                "qdot: forces and constraints have no Hamiltonian: take hamiltonian_of(scene.system()), which is that of T and V alone, and add what they do to p");
  return hamiltonian_of(scene.system());
}

/// Poisson's bracket {f, g} = ∂f/∂q·∂g/∂p − ∂f/∂p·∂g/∂q at (q, p, t), exact.
///
/// One evaluation of f and of g on 2n directions, where n is known at compile time. q and p may hold duals: brackets nest.
///
/// @param f, g  generic functions f(q, p) or f(q, p, t) that return a scalar
template <class F, class G, class Q, class P>
auto poisson_bracket(const F& f, const G& g, const Eigen::MatrixBase<Q>& q, const Eigen::MatrixBase<P>& p,
                     typename Q::Scalar t = typename Q::Scalar(0)) {
  using S = typename Q::Scalar;
  constexpr int n = Q::RowsAtCompileTime;
  static_assert(std::is_same_v<S, typename P::Scalar> && n == P::RowsAtCompileTime, "qdot: q and p must be vectors of the same scalar and length");
  const Eigen::Index k = q.size();
  if (p.size() != k) throw DimensionError("p", static_cast<long>(k), static_cast<long>(p.size()), "pass one momentum for each coordinate");
  Vector<S, n == Dynamic ? Dynamic : 2 * n> x(2 * k);
  x << q, p;
  const auto slopes = [&](const auto& function) {
    return gradient(detail::marked<detail::SlopeInPhaseSpace>([&](const auto& y) {
      using D = typename std::remove_cvref_t<decltype(y)>::Scalar;
      const Vector<D, n> place = y.head(k), momenta = y.tail(k);
      return detail::in_phase_space<D, n>(function, place, momenta, D(t));
    }), x);
  };
  const auto df = slopes(f), dg = slopes(g);
  S bracket(0);
  for (Eigen::Index i = 0; i < k; ++i) bracket += df[i] * dg[k + i] - df[k + i] * dg[i];
  return bracket;
}

}  // namespace qdot
