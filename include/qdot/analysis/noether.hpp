#pragma once
// SPDX-License-Identifier: MIT
//
// Noether's theorem
// =================
//
//     q → q'(s, q, t) ,   q'(0, q, t) = q ,      ξ = ∂q'/∂s  at s = 0 ,      ξ̇ = (∂ξ/∂q) q̇ + ∂ξ/∂t
//     ∂L/∂q·ξ + ∂L/∂q̇·ξ̇ = dF/dt        then        I = p·ξ − F        is conserved,
//
// for with ṗ = ∂L/∂q the left side is d/dt (p·ξ). F(q, t) is the *gauge term*, which Lagrange's equations do not feel.
// Translations give momenta, rotations angular momenta. A moving frame, x' = x + s t with F = m x, gives p t − m x: where
// the centre of mass was at t = 0. ξ and ξ̇ come from duals, so what is left of the equation is rounding or a violation.
//
// It must hold for all q and q̇, and is evaluated at given states, or at scattered ones. A symmetry that holds on the
// motion only is none of these families: that of the Laplace–Runge–Lenz vector moves velocities. In a scene İ gains ξ·Q,
// which is added to the violation, and ξ·Jᵀλ, so Jξ must be zero: given states lie on the constraints, and scattered ones
// do not.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "qdot/ad/forward/functor_result.hpp"
#include "qdot/ad/dual.hpp"
#include "qdot/analysis/linear/flow.hpp"
#include "qdot/analysis/symmetry/vanishing.hpp"
#include "qdot/effects/equations/effect_forces.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/energy.hpp"
#include "qdot/mechanics/system.hpp"
#include "qdot/mechanics/velocity.hpp"

namespace qdot {

/// No gauge term: L itself is the same.
struct NoGauge {
  /// Zero.
  template <class Q, class S>
  S operator()(const Q&, const S&) const {
    return S(0.0);
  }
};

/// How far L is from being invariant under a family of transformations.
template <int n>
struct SymmetryViolation {
  double rate = 0.0;  ///< ∂L/∂q·ξ + ∂L/∂q̇·ξ̇ + ξ·Q − Ḟ where it is largest beside its terms: dI/dt there   [of I, per unit of time]
  double size = 0.0;  ///< of the terms that it is the sum of
  State<n> where;     ///< the state of these two
  int states = 0;     ///< how many states were looked at

  /// Whether nothing but rounding is left.
  bool is_symmetry() const { return states > 0 && std::abs(rate) <= 1e-10 * size; }
};

namespace detail {

struct SlopeOfFamily {};  // the tag of perturbations of s

template <class S, int n, class Family>
auto transformed(const Family& family, const S& s, const Vector<S, n>& q, const S& t) {
  if constexpr (detail::is_callable<const Family&, const S&, const Vector<S, n>&, const S&>) {
    return Vector<S, n>(family(s, q, t));
  } else {
    static_assert(detail::is_callable<const Family&, const S&, const Vector<S, n>&>,
                  "qdot: a family of transformations must be callable as q'(s, q, t) or q'(s, q) for every scalar, s being one of them: take `const auto&`");
    return Vector<S, n>(family(s, q));
  }
}

// ξ at (q, t).
template <class S, int n, class Family>
Vector<S, n> generator(const Family& family, const Vector<S, n>& q, const S& t) {
  return derivative(marked<SlopeOfFamily>([&](const auto& s) {
    using D = std::remove_cvref_t<decltype(s)>;
    return transformed<D, n>(family, s, Vector<D, n>(q.template cast<D>()), D(t));
  }), S(0.0));
}

template <class Gauge, class S, int n>
S gauge_term(const Gauge& F, const Vector<S, n>& q, const S& t) {
  if constexpr (detail::is_callable<const Gauge&, const Vector<S, n>&, const S&>) {
    return S(F(q, t));
  } else {
    return S(F(q));
  }
}

// ξ·Q, and |Jξ| beside |J||ξ|, of a scene's effects; zeros for a system.
struct ShareOfEffects {
  double power = 0.0, power_size = 0.0, across = 0.0;
};
template <class E, int n, Inertia inertia>
ShareOfEffects share_of_effects(const System<E, n, inertia>&, const Vector<double, n>&, const Vector<double, n>&, const Vector<double, n>&, double, int) {
  return {};
}
template <class Sys, class... Effects>
ShareOfEffects share_of_effects(const Scene<Sys, Effects...>& scene, [[maybe_unused]] const Vector<double, Sys::dof_at_compile_time>& q,
                                [[maybe_unused]] const Vector<double, Sys::dof_at_compile_time>& qdot,
                                [[maybe_unused]] const Vector<double, Sys::dof_at_compile_time>& xi, [[maybe_unused]] double t, [[maybe_unused]] int sample) {
  using Sc = Scene<Sys, Effects...>;
  static_assert(!Sc::has_phases, "qdot: noether_integral needs effects that last: leave contacts and dry friction out, whose forces change with their phases");
  ShareOfEffects share;
  if constexpr (Sc::has_forces || Sc::has_constraints) {
    const Eigen::Index k = scene.dof();
    EffectStates<Sc> z = scene.initial_states();
    const std::vector<double> other = scattered_point(static_cast<std::size_t>(z.size()), sample);
    for (Eigen::Index i = 0; i < z.size(); ++i) z[i] += other[static_cast<std::size_t>(i)];
    if constexpr (Sc::has_forces) {
      const Eigen::VectorXd power = xi.cwiseProduct(effect_forces(scene, q, qdot, z, t));
      share.power = power.sum();
      share.power_size = power.cwiseAbs().sum();
    }
    if constexpr (Sc::has_constraints) {
      Eigen::VectorXd y(2 * k + z.size());
      y << q, qdot, z;
      const ConstraintsAt rows = constraints_at(scene, t, y);
      for (Eigen::Index row = 0; row < rows.phi.size(); ++row) {
        const Eigen::VectorXd terms = rows.slopes.row(row).tail(k).transpose().cwiseProduct(xi);
        if (const double size = terms.cwiseAbs().sum(); size > 0.0) share.across = std::max(share.across, std::abs(terms.sum()) / size);
      }
    }
  }
  return share;
}

template <int n>
std::vector<State<n>> scattered_states(Eigen::Index dof) {
  std::vector<State<n>> states;
  for (int sample = 0; sample < scattered_points; ++sample) {
    const std::vector<double> x = scattered_point(static_cast<std::size_t>(2 * dof + 1), sample);
    using Q = Vector<double, n>;
    states.push_back({x.back(), Eigen::Map<const Q>(x.data(), dof), Eigen::Map<const Q>(x.data() + dof, dof)});
  }
  return states;
}

}  // namespace detail

/// How far L is from being invariant, the worst of the states given or of sixteen scattered ones; nothing is thrown for a violation.
///
/// States at which L has no finite value are not counted.
///
/// @param family  q'(s, q, t) or q'(s, q), a vector of the scalar that s and q have, with q'(0, q, t) = q
/// @param gauge   F(q, t) or F(q) with δL = dF/dt
/// @throws InvalidValue  when q' at s = 0 is not q, when the family moves nothing, or when no state could be looked at
template <class Model, class Family, class Gauge = NoGauge, int n = Model::dof_at_compile_time>
SymmetryViolation<n> symmetry_violation(const Model& model, const Family& family, const Gauge& gauge = {}, const std::vector<State<n>>& states = {}) {
  const auto& system = model.system();
  const Eigen::Index k = system.dof();
  SymmetryViolation<n> worst;
  double share_of_worst = -1.0;
  bool moves = false;
  int sample = 0;
  for (const State<n>& state : states.empty() ? detail::scattered_states<n>(k) : states) {
    detail::require_sizes(system, state.q, state.qdot);
    const Vector<double, n> q = state.q, v = state.qdot;
    const Vector<double, n> same = detail::transformed<double, n>(family, 0.0, q, state.t);
    const double most = q.cwiseAbs().maxCoeff(), length = most > 0.0 ? std::min(most, 1.0) : 1.0;
    for (Eigen::Index i = 0; i < k; ++i)
      if (std::abs(same[i] - q[i]) > 1e-12 * (length + std::abs(q[i])))
        detail::throw_invalid_value({"noether_integral: the transformation must leave everything as it is at s = 0, but there it takes ",
                                     system.coordinate_name(i), " = ", {q[i], 6}, " to ", {same[i], 6}, "; let s = 0 be the identity"});
    const auto xi = value_and_velocity_of([&](const auto& x, const auto& time) {
      using S = std::remove_cvref_t<decltype(time)>;
      return detail::generator<S, n>(family, x, time);
    }, q, v, state.t);
    const auto F = value_and_velocity_of([&](const auto& x, const auto& time) { return detail::gauge_term(gauge, x, time); }, q, v, state.t);
    const Vector<double, n> slope = lagrangian_gradient(system, q, v, state.t), p = conjugate_momenta(system, q, v, state.t);
    const detail::ShareOfEffects effects = detail::share_of_effects(model, q, v, Vector<double, n>(xi.value), state.t, sample++);
    double rate = effects.power - F.rate, size = effects.power_size + std::abs(F.rate);
    for (Eigen::Index i = 0; i < k; ++i) {
      moves = moves || xi.value[i] != 0.0;
      rate += slope[i] * xi.value[i] + p[i] * xi.rate[i];
      size += std::abs(slope[i] * xi.value[i]) + std::abs(p[i] * xi.rate[i]);
    }
    if (!std::isfinite(rate) || !std::isfinite(size)) continue;
    if (effects.across > 1e-10)
      detail::throw_invalid_value({"noether_integral: a transformation must keep to the constraints, but at ", system.coordinate_name(0), " = ", {q[0], 6},
                                   " it leaves one: |J xi| is ", {effects.across, 3},
                                   " of its terms; transform along the constraints, and give states that satisfy them where they are symmetric only there"});
    ++worst.states;
    const double share = size > 0.0 ? std::abs(rate) / size : 0.0;
    if (share <= 1.01 * share_of_worst) continue;  // the first of those that are about as bad
    share_of_worst = share;
    worst.rate = rate;
    worst.size = size;
    worst.where = state;
  }
  if (worst.states == 0)
    throw InvalidValue("noether_integral: L must have a finite value at some state, but it has none at those that were tried; give states of the motion");
  if (!moves) throw InvalidValue("noether_integral: the transformation must move something, but dq'/ds is zero at all states; let q' depend on s");
  return worst;
}

/// I = p·ξ − F of a system and a symmetry; made by noether_integral().
template <class Sys, class Family, class Gauge = NoGauge>
class NoetherIntegral {
  static constexpr int n = Sys::dof_at_compile_time;

 public:
  NoetherIntegral(Sys system, Family family, Gauge gauge, SymmetryViolation<n> violation)
      : system_(std::move(system)), family_(std::move(family)), gauge_(std::move(gauge)), violation_(std::move(violation)) {}

  /// I at a state.
  double operator()(const State<n>& state) const {
    const Vector<double, n> p = conjugate_momenta(system_, state);
    return p.dot(displacement(state)) - detail::gauge_term(gauge_, Vector<double, n>(state.q), state.t);
  }

  /// ξ = ∂q'/∂s at a state, n.
  Vector<double, n> displacement(const State<n>& state) const { return detail::generator<double, n>(family_, Vector<double, n>(state.q), state.t); }

  /// What the test of the symmetry has found: rounding.
  const SymmetryViolation<n>& violation() const noexcept { return violation_; }

 private:
  Sys system_;
  Family family_;
  Gauge gauge_;
  SymmetryViolation<n> violation_;
};

/// Noether's integral of a one-parameter family of transformations under which L is invariant.
///
/// L, and in a scene forces and constraints, are tested at the states given, or at sixteen scattered ones.
///
/// @param model   a system, or a scene whose effects last
/// @param family  q'(s, q, t) or q'(s, q), with q'(0, q, t) = q
/// @param gauge   F(q, t) or F(q) where L changes by dF/dt
/// @throws InvalidValue  as symmetry_violation(); and when it is no symmetry, with the violation and the state where it is worst
template <class Model, class Family, class Gauge = NoGauge, int n = Model::dof_at_compile_time>
auto noether_integral(const Model& model, Family family, Gauge gauge = {}, const std::vector<State<n>>& states = {}) {
  const auto& system = model.system();
  SymmetryViolation<n> violation = symmetry_violation<Model, Family, Gauge, n>(model, family, gauge, states);
  if (!violation.is_symmetry()) {
    std::string where;
    for (Eigen::Index i = 0; i < system.dof(); ++i)
      where += detail::sentence({i > 0 ? ", " : "", system.coordinate_name(i), " = ", {violation.where.q[i], 6}, ", ", system.velocity_name(i), " = ",
                                 {violation.where.qdot[i], 6}});
    detail::throw_invalid_value({"noether_integral: the motion must not change under the transformation, but p.dq'/ds - F changes at the rate ",
                                 {violation.rate, 6}, ", a sum of terms of size ", {violation.size, 6}, ", at ", where,
                                 "; choose a symmetry, or give the gauge term F(q, t) whose rate this is"});
  }
  return NoetherIntegral<std::remove_cvref_t<decltype(system)>, Family, Gauge>(system, std::move(family), std::move(gauge), std::move(violation));
}

}  // namespace qdot
