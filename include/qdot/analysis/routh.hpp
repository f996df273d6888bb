#pragma once
// SPDX-License-Identifier: MIT
//
// Routh's reduction: cyclic coordinates left out
// ==============================================
//
//     R(q, q̇, t) = L − β·ẋ ,       with ẋ from  β = ∂L/∂ẋ, which is conserved, for x does not occur in L.
//
// The other coordinates q obey Lagrange's equations of R. It adds forces that only the rotation of the x explains, such
// as the barrier that keeps a pendulum in space away from the vertical. For T quadratic in the velocities, ẋ = u + w
// and
//     ∂T/∂ẋ = A(q,t) ẋ + C(q,t) q̇ + b(q,t) ,           u = −A⁻¹ C q̇ ,      w = A⁻¹ (β − b) ,
//     R = T_R − V_R ,      T_R = T(q, q̇, ẋ = u) − β·u ,      V_R = V + ½ (β − b)·A⁻¹(β − b)  (the *effective potential*).
// No term of T_R cancels one of V_R, so both are as exact as T and V. They make a system like any other: its equilibria
// are the steady motions of the full one. Where C is not zero, T_R has terms linear in q̇, M is the Schur complement of
// A, and jacobi_energy() is conserved. x is an integral over the motion; the scene of a reduction carries it as states
// of its own, integrated to the same tolerances.

#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "qdot/ad/derivatives.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/energy.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot {

namespace detail {

struct SlopeOfIgnored {};  // the tag of perturbations of ẋ

// The coordinates that are left, in their order.
template <int n, int... ignored>
constexpr auto kept_coordinates() {
  std::array<int, static_cast<std::size_t>(n) - sizeof...(ignored)> kept{};
  std::size_t next = 0;
  for (int i = 0; i < n; ++i)
    if (((i != ignored) && ...)) kept[next++] = i;
  return kept;
}
template <int n, int... ignored>
constexpr bool are_different_coordinates() {
  constexpr std::array<int, sizeof...(ignored)> all{ignored...};
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i] < 0 || all[i] >= n) return false;
    for (std::size_t j = 0; j < i; ++j)
      if (all[i] == all[j]) return false;
  }
  return true;
}

// x of A x = b for a symmetric positive A, in numbers of any kind: no comparison, no root.
template <class S, int k>
Vector<S, k> solved_symmetric(Matrix<S, k> A, Vector<S, k> b) {
  for (int i = 0; i < k; ++i)
    for (int j = i + 1; j < k; ++j) {
      const S factor = S(A(j, i) / A(i, i));
      for (int l = i; l < k; ++l) A(j, l) = S(A(j, l) - factor * A(i, l));
      b[j] = S(b[j] - factor * b[i]);
    }
  for (int i = k; i-- > 0;) {
    for (int l = i + 1; l < k; ++l) b[i] = S(b[i] - A(i, l) * b[l]);
    b[i] = S(b[i] / A(i, i));
  }
  return b;
}

}  // namespace detail

/// T_R and V_R of a reduction: energies of the coordinates that are left.
///
/// What they call is not inlined: straight-line code of derivatives of derivatives would take the compiler minutes.
template <class E, int n, int... ignored>
class RouthEnergies {
  static constexpr int k = static_cast<int>(sizeof...(ignored)), m = n - k;
  static constexpr std::array<int, sizeof...(ignored)> left_out{ignored...};
  static constexpr auto kept = detail::kept_coordinates<n, ignored...>();
  static constexpr bool time_in_T = detail::kinetic_signature<E, n>() == KineticSignature::state_and_time;
  static constexpr bool time_in_V = time_in_T || detail::potential_signature<E, n>() == PotentialSignature::position_and_time;

 public:
  RouthEnergies(E energies, const Vector<double, k>& x, const Vector<double, k>& beta)
      : energies_(std::move(energies)), x_(x), beta_(beta) {}

  /// T_R: what velocities have a part in.
  template <class S>
    requires(!time_in_T)
  S T(const Vector<S, m>& q, const Vector<S, m>& qdot) const {
    return kinetic(q, qdot, S(0.0));
  }
  template <class S>
    requires(time_in_T)
  S T(const Vector<S, m>& q, const Vector<S, m>& qdot, const S& t) const {
    return kinetic(q, qdot, t);
  }
  /// V_R, the effective potential.
  template <class S>
    requires(!time_in_V)
  S V(const Vector<S, m>& q) const {
    return effective_potential(q, S(0.0));
  }
  template <class S>
    requires(time_in_V)
  S V(const Vector<S, m>& q, const S& t) const {
    return effective_potential(q, t);
  }

  /// ẋ = u + w, k entries.
  template <class S>
  Vector<S, k> ignored_velocities(const Vector<S, m>& q, const Vector<S, m>& qdot, const S& t) const {
    const Vector<S, n> place = full(q, x_);
    const Vector<S, k> zero = Vector<S, k>::Zero();
    Vector<S, k> missing = ignored_momenta(place, qdot, zero, t);
    for (int i = 0; i < k; ++i) missing[i] = S(S(beta_[i]) - missing[i]);
    return detail::solved_symmetric<S, k>(inertia(place, t), missing);
  }

  /// All coordinates, or all velocities, from those that are left and those that are not.
  template <class S, class X>
  static Vector<S, n> full(const Vector<S, m>& q, const X& x) {
    Vector<S, n> all;
    for (std::size_t i = 0; i < kept.size(); ++i) all[kept[i]] = q[static_cast<Eigen::Index>(i)];
    for (std::size_t i = 0; i < left_out.size(); ++i) all[left_out[i]] = S(x[static_cast<Eigen::Index>(i)]);
    return all;
  }

 private:
  // ∂T/∂ẋ at the velocities q̇ and ẋ.
  template <class S>
  [[gnu::noinline]] Vector<S, k> ignored_momenta(const Vector<S, n>& place, const Vector<S, m>& qdot, const Vector<S, k>& xdot, const S& t) const {
    return gradient(detail::marked<detail::SlopeOfIgnored>([&](const auto& v) {
      using D = typename std::remove_cvref_t<decltype(v)>::Scalar;
      Vector<D, n> at, velocity;
      for (int i = 0; i < n; ++i) at[i] = D(place[i]);
      for (std::size_t i = 0; i < kept.size(); ++i) velocity[kept[i]] = D(qdot[static_cast<Eigen::Index>(i)]);
      for (std::size_t i = 0; i < left_out.size(); ++i) velocity[left_out[i]] = v[static_cast<Eigen::Index>(i)];
      return detail::kinetic<n>(energies_, at, velocity, D(t));
    }), xdot);
  }
  template <class S>
  Vector<S, k> momenta_at_rest(const Vector<S, n>& place, const S& t) const {  // b
    return ignored_momenta(place, Vector<S, m>(Vector<S, m>::Zero()), Vector<S, k>(Vector<S, k>::Zero()), t);
  }
  template <class S>
  [[gnu::noinline]] Matrix<S, k> inertia(const Vector<S, n>& place, const S& t) const {  // A
    const Vector<S, k> b = momenta_at_rest(place, t);
    const Vector<S, m> rest = Vector<S, m>::Zero();
    Matrix<S, k> A;
    for (int j = 0; j < k; ++j) {
      Vector<S, k> unit = Vector<S, k>::Zero();
      unit[j] = S(1.0);
      const Vector<S, k> p = ignored_momenta(place, rest, unit, t);
      for (int i = 0; i < k; ++i) A(i, j) = S(p[i] - b[i]);
    }
    return A;
  }

  template <class S>
  [[gnu::noinline]] S kinetic(const Vector<S, m>& q, const Vector<S, m>& qdot, const S& t) const {
    const Vector<S, n> place = full(q, x_);
    const Vector<S, k> b = momenta_at_rest(place, t);
    Vector<S, k> u = ignored_momenta(place, qdot, Vector<S, k>(Vector<S, k>::Zero()), t);
    for (int i = 0; i < k; ++i) u[i] = S(b[i] - u[i]);
    u = detail::solved_symmetric<S, k>(inertia(place, t), u);
    S T = detail::kinetic<n>(energies_, place, full(qdot, u), t);
    for (int i = 0; i < k; ++i) T = S(T - beta_[i] * u[i]);
    return T;
  }
  template <class S>
  [[gnu::noinline]] S effective_potential(const Vector<S, m>& q, const S& t) const {
    const Vector<S, n> place = full(q, x_);
    Vector<S, k> missing = momenta_at_rest(place, t);
    for (int i = 0; i < k; ++i) missing[i] = S(S(beta_[i]) - missing[i]);
    const Vector<S, k> w = detail::solved_symmetric<S, k>(inertia(place, t), missing);
    S V = detail::potential<n>(energies_, place, t);
    for (int i = 0; i < k; ++i) V = S(V + 0.5 * missing[i] * w[i]);
    return V;
  }

  E energies_;
  Vector<double, k> x_, beta_;
};

/// The effect that carries ignored coordinates along as its states: no force, ż = ẋ.
template <class Energies, int m, int k>
struct IgnoredCoordinates {
  Energies energies;     ///< T_R and V_R, which know ẋ
  Vector<double, k> x0;  ///< x at the start, k

  Vector<double, k> initial_state() const { return x0; }
  template <class S>
  Vector<S, m> force(const Vector<S, m>&, const Vector<S, m>&, const Vector<S, k>&, const S&) const {
    return Vector<S, m>::Zero();
  }
  template <class S>
  Vector<S, k> state_rate(const Vector<S, m>& q, const Vector<S, m>& qdot, const Vector<S, k>&, const S& t) const {
    return energies.ignored_velocities(q, qdot, t);
  }
};

/// A system without its cyclic coordinates, made by routh_reduction().
template <class E, int n, Inertia inertia, int... ignored>
struct RouthReduction {
  static constexpr int k = static_cast<int>(sizeof...(ignored)), m = n - k;  ///< how many coordinates are ignored, and left
  using Energies = RouthEnergies<E, n, ignored...>;                          ///< T_R and V_R

  System<Energies, m, inertia> system;  ///< T_R and V_R of the coordinates that are left; its V is the effective potential
  State<m> start;                       ///< of these
  Vector<double, k> momenta;            ///< β, in the order in which the coordinates were named
  Vector<double, k> ignored_start;      ///< x at the start

  /// ẋ at a state of the reduced system, k.
  Vector<double, k> ignored_velocities(const State<m>& state) const {
    return system.energies().ignored_velocities(Vector<double, m>(state.q), Vector<double, m>(state.qdot), state.t);
  }

  /// The reduced system with x as states of an effect: y = [q; q̇; x] of its runs.
  auto scene() const { return qdot::scene(system, IgnoredCoordinates<Energies, m, k>{system.energies(), ignored_start}); }

  /// The state of the full system at y = [q; q̇; x], which a run of scene() has at t: run.trajectory.y(t).
  ///
  /// @throws DimensionError  unless y has 2(n − k) + k entries
  State<n> full_state(double t, const Eigen::VectorXd& y) const {
    if (y.size() != 2 * m + k)
      throw DimensionError("y of a reduced motion", 2 * m + k, static_cast<long>(y.size()), "take it from a run of the reduction's scene()");
    const Vector<double, m> q = y.template head<m>(), qdot = y.template segment<m>(m);
    const Vector<double, k> x = y.template tail<k>(), xdot = system.energies().ignored_velocities(q, qdot, t);
    return {t, Energies::full(q, x), Energies::full(qdot, xdot)};
  }
};

namespace detail {

// Refuses coordinates on which L depends at the start or at one of a few states about it; where L has no value is not asked.
template <class Sys, class State>
void require_cyclic(const Sys& system, const State& start, const int* ignored, int k) {
  constexpr int n = Sys::dof_at_compile_time;
  for (int sample = 0; sample < 6; ++sample) {
    Vector<double, n> q = start.q, v = start.qdot;
    for (int i = 0; i < n && sample > 0; ++i) {
      q[i] += 0.3 * std::sin(1.0 + 2.7 * sample + 1.3 * i);
      v[i] += std::cos(2.0 + 1.9 * sample + 2.3 * i);
    }
    const double size = std::abs(double(kinetic_energy(system, q, v, start.t))) + std::abs(double(potential_energy(system, q, start.t)));
    const Vector<double, n> slope = qdot::lagrangian_gradient(system, q, v, start.t);
    for (int i = 0; i < k; ++i) {
      const double g = slope[ignored[i]];
      if (!(std::abs(g) > 1e-11 * (size + slope.cwiseAbs().maxCoeff())) || !std::isfinite(size)) continue;
      throw_invalid_value({"routh_reduction: L must not depend on a coordinate that is to be ignored, but dL/d", system.coordinate_name(ignored[i]),
                           " is ", {g, 6}, " at ", system.coordinate_name(ignored[i]), " = ", {q[ignored[i]], 6}, sample == 0 ? ", the start" : ", near the start",
                           "; keep this coordinate, or choose one that L depends on only through its velocity"});
    }
  }
}

}  // namespace detail

/// The system without the coordinates `ignored`, which must be cyclic, with the momenta that these have at `start`.
///
/// An evaluation costs about k + 3 evaluations of T with k directions more. T must be quadratic in the velocities.
///
/// @tparam ignored  numbers of the cyclic coordinates, as in routh_reduction<1, 2>(top, start); one coordinate at least must be left
/// @param start     a state of the full system
/// @throws InvalidValue  when L depends on one of them, with the size of ∂L/∂q_k; when T is not quadratic in the velocities
template <int... ignored, class E, int n, Inertia inertia>
RouthReduction<E, n, inertia, ignored...> routh_reduction(const System<E, n, inertia>& system, const State<n>& start) {
  static_assert(n != Dynamic, "qdot: routh_reduction needs a number of coordinates known at compile time: mechanical_system<n>(…)");
  static_assert(sizeof...(ignored) >= 1 && static_cast<int>(sizeof...(ignored)) < n,
                "qdot: routh_reduction ignores at least one coordinate, as in routh_reduction<1>(system, start), and leaves at least one");
  static_assert(detail::are_different_coordinates<n, ignored...>(), "qdot: routh_reduction ignores coordinates of the system, counted from 0, each named once");
  constexpr int k = static_cast<int>(sizeof...(ignored)), m = n - k;
  constexpr std::array<int, sizeof...(ignored)> left_out{ignored...};
  constexpr auto kept = detail::kept_coordinates<n, ignored...>();
  detail::require_sizes(system, start.q, start.qdot);
  detail::require_cyclic(system, start, left_out.data(), k);
  const Vector<double, n> p = conjugate_momenta(system, start);
  Vector<double, k> beta, x, xdot;
  for (int i = 0; i < k; ++i) {
    const int at = left_out[static_cast<std::size_t>(i)];
    beta[i] = p[at];
    x[i] = start.q[at];
    xdot[i] = start.qdot[at];
  }
  State<m> reduced;
  reduced.t = start.t;
  reduced.q.resize(m);
  reduced.qdot.resize(m);
  std::vector<std::string> names;
  for (int i = 0; i < m; ++i) {
    const int at = kept[static_cast<std::size_t>(i)];
    reduced.q[i] = start.q[at];
    reduced.qdot[i] = start.qdot[at];
    names.push_back(system.coordinate_name(at));
  }
  using Reduction = RouthReduction<E, n, inertia, ignored...>;
  typename Reduction::Energies energies(system.energies(), x, beta);
  Reduction reduction{System<typename Reduction::Energies, m, inertia>(std::move(energies), m).with_names(names), reduced, beta, x};
  const Vector<double, k> found = reduction.ignored_velocities(reduced);
  for (int i = 0; i < k; ++i)
    if (!(std::abs(found[i] - xdot[i]) <= 1e-9 * (xdot.cwiseAbs().maxCoeff() + start.qdot.cwiseAbs().maxCoeff())))
      detail::throw_invalid_value({"routh_reduction: T must be quadratic in the velocities and have inertia along the ignored coordinates, but the ",
                                   "momentum of ", system.coordinate_name(left_out[static_cast<std::size_t>(i)]), " gives the velocity ", {found[i], 6},
                                   " where it is ", {xdot[i], 6}, "; keep this coordinate"});
  return reduction;
}

/// The reduction of a scene whose effects are terms in T and V. Forces and constraints are given to the scene of the reduced
/// system.
template <int... ignored, class Sys, class... Effects>
auto routh_reduction(const Scene<Sys, Effects...>& scene, const State<Sys::dof_at_compile_time>& start) {
  using Sc = Scene<Sys, Effects...>;
  static_assert(!Sc::has_forces && !Sc::has_constraints,
                "qdot: routh_reduction takes T and V only: reduce the bare system, and give forces and constraints that act on the coordinates that are left to "
                "scene(reduction.system, …); what acts on an ignored coordinate takes its momentum away");
  return routh_reduction<ignored...>(scene.system(), start);
}

}  // namespace qdot
