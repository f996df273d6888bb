#pragma once
// SPDX-License-Identifier: MIT
//
// What a scene's constraints demand, row by row.
//
//     φ(q, t) = 0       ⇒  J q̇ + ∂φ/∂t = 0      ⇒  J q̈ = γ ,   J = ∂φ/∂q
//     a(q, q̇, t) = 0                             ⇒  J q̈ = γ ,   J = ∂a/∂q̇
//
// γ is minus what is left of the second (first) time derivative when q̈ = 0. J̇q̇ needs no derivation by hand: φ is evaluated at
//
//     q + q̇ ε₁ + q̇ ε₂ + 0 ε₁ε₂ ,    t + ε₁ + ε₂ ,
//
// whose ε₁ε₂ part is d²φ/dt² at q̈ = 0; one evaluation for all rows. With q̈ in place of 0 the same evaluation gives the full φ̈, which
// the exact Jacobian of a constrained system needs. Constraints that switch (contact, stick) have their rows at all times, so that
// sizes never change; where one is not active its row is zero and asks for nothing. Which are active is read off the effects' states z.

#include <cstddef>
#include <string>
#include <type_traits>
#include <vector>

#include "qdot/ad/derivatives.hpp"
#include "qdot/effects/fit.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/mechanics/velocity.hpp"

namespace qdot {

/// The rows of a scene's constraints at a state, holonomic and nonholonomic in the order of the effects.
template <class S, int n, int m>
struct ConstraintRows {
  Matrix<S, m, n> J;      ///< m×n
  Vector<S, m> gamma;     ///< J q̈ = gamma
  Vector<S, m> velocity;  ///< J q̇ + ∂φ/∂t, or a: zero on a motion
};

namespace detail {

// Stands for z where no constraint switches, and is never asked; clang wants an answer all the same.
struct NoPhases {
  double operator[](Eigen::Index) const noexcept { return 0.0; }
};

// Visits each constraint effect, and says whether it is active in the phases z.
template <class Sc, class Phases, class Visit>
void for_each_constraint(const Sc& scene, const Phases& z, Visit&& visit) {
  constexpr int n = Sc::dof_at_compile_time;
  static_assert(!Sc::has_phases || !std::is_same_v<Phases, NoPhases>,
                "qdot: some constraints of this scene hold in some phases only: pass the effects' own states z, as "
                "settled_states(scene, state) gives them");
  Eigen::Index first = 0;
  for_each(scene.effects(), [&](const auto& e) {
    using E = std::remove_cvref_t<decltype(e)>;
    if constexpr (SwitchingEffect<E, n>) {
      visit(e, e.is_active(z[first]));
    } else if constexpr (ConstraintEffect<E, n>) {
      visit(e, true);
    }
    first += states_of<E>();
  });
  (void)z;
}

// True when no row asks for anything, so that the motion is free.
template <class Sc, class Phases>
bool is_free(const Sc& scene, const Phases& z) {
  bool free = true;
  if constexpr (Sc::has_lasting_constraints) {
    free = false;
  } else {
    for_each_constraint(scene, z, [&](const auto&, bool active) { free = free && !active; });
  }
  return free;
}

// φ or a along a motion: value and derivative with respect to time, at given accelerations.
template <int n, class Effect, class S>
auto velocity_rows(const Effect& e, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) {
  if constexpr (HolonomicEffect<Effect, n>) {
    return as_rows(velocity_of([&](const auto& x, const auto& s) { return as_rows(e.phi(x, s)); }, q, qdot, t));
  } else {
    return as_rows(e.velocity_constraint(q, qdot, t));
  }
}

struct RateOfRows {};   // tags of the perturbations of constraints
struct SlopeOfRows {};

// x + ε ẋ, and ẋ of such a vector.
template <class D, class X>
[[gnu::always_inline]] inline auto with_rates(const X& x, const auto& rates) {
  Vector<D, X::RowsAtCompileTime> both(x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    both[i].value = x[i];
    both[i].tangent[0] = rates[i];
  }
  return both;
}
template <class Both>
[[gnu::always_inline]] inline auto rates_in(const Both& both) {
  Vector<typename Both::Scalar::Scalar, Both::RowsAtCompileTime> rates(both.size());
  for (Eigen::Index i = 0; i < both.size(); ++i) rates[i] = both[i].tangent[0];
  return rates;
}

// Time derivative of the velocity rows at given accelerations.
template <int n, class Effect, class S>
auto acceleration_rows(const Effect& e, const Vector<S, n>& q, const Vector<S, n>& qdot, const Vector<S, n>& qddot,
                       const S& t) {
  using D = Dual<S, 1, RateOfRows>;
  return rates_in(velocity_rows<n>(e, with_rates<D>(q, qdot), with_rates<D>(qdot, qddot), D::variable(t, 0)));
}

// J of one effect, with as many rows as the scene has counted.
template <int n, class Effect, class S>
auto jacobian_rows(const Effect& e, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t, Eigen::Index counted) {
  if constexpr (HolonomicEffect<Effect, n>) {
    return jacobian(marked<SlopeOfRows>([&](const auto& x) {
      using D = typename std::remove_cvref_t<decltype(x)>::Scalar;
      const auto rows = as_rows(e.phi(x, D(t)));
      require_rows(e, rows, counted, t);
      return rows;
    }), q);
  } else {
    return jacobian(marked<SlopeOfRows>([&](const auto& v) {
      using D = typename std::remove_cvref_t<decltype(v)>::Scalar;
      const auto rows = as_rows(e.velocity_constraint(converted<D>(q), v, D(t)));
      require_rows(e, rows, counted, t);
      return rows;
    }), qdot);
  }
}

// How many rows the k-th constraint effect, of type E, has.
template <class E, class Sc>
Eigen::Index rows_of_constraint(const Sc& scene, [[maybe_unused]] std::size_t k) {
  if constexpr (Sc::constraints_at_compile_time == Dynamic) {
    return scene.row_counts().each[k];
  } else {
    return constraint_rows_of<E, Sc::dof_at_compile_time>();
  }
}

// One column of rows for all constraint effects, from `rows_of(effect)`; zero for those that are not active.
template <class S, class Sc, class Phases, class RowsOf>
auto stacked_rows(const Sc& scene, [[maybe_unused]] const S& t, const Phases& z, RowsOf&& rows_of) {
  constexpr int n = Sc::dof_at_compile_time;
  constexpr int m = Sc::constraints_at_compile_time;
  if constexpr (m == Dynamic) {
    Vector<S, Dynamic> all(scene.row_counts().total);
    Eigen::Index first = 0;
    std::size_t k = 0;
    for_each_constraint(scene, z, [&](const auto& e, bool active) {
      const auto part = rows_of(e);
      const Eigen::Index rows = scene.row_counts().each[k++];
      require_rows(e, part, rows, t);
      for (Eigen::Index i = 0; i < rows; ++i) all[first + i] = active ? part[i] : S(0);
      first += rows;
    });
    return all;
  } else {
    Vector<S, m> all = zeros<Vector<S, m>>(m);
    Eigen::Index first = 0;
    for_each_constraint(scene, z, [&](const auto& e, bool active) {
      constexpr int rows = constraint_rows_of<std::remove_cvref_t<decltype(e)>, n>();
      if (active) {
        const auto part = rows_of(e);
        static_assert(std::remove_cvref_t<decltype(part)>::RowsAtCompileTime == rows,
                      "qdot: a constraint must return the same number of rows for every scalar");
        for (Eigen::Index i = 0; i < rows; ++i) all[first + i] = part[i];
      }
      first += rows;
    });
    return all;
  }
}

}  // namespace detail

/// φ(q, t) of all holonomic constraints, in order; zero rows stand for nonholonomic ones.
template <class Sys, class... Effects, class S, int n, class Phases = detail::NoPhases>
auto constraint_residual(const Scene<Sys, Effects...>& scene, const Vector<S, n>& q, const S& t, const Phases& z = {}) {
  return detail::stacked_rows<S>(scene, t, z, [&](const auto& e) {
    using E = std::remove_cvref_t<decltype(e)>;
    if constexpr (HolonomicEffect<E, n>) {
      return detail::as_rows(e.phi(q, t));
    } else {
      auto rows = detail::velocity_rows<n>(e, q, q, t);
      rows.setZero();
      return rows;
    }
  });
}

/// J q̇ + ∂φ/∂t of holonomic and a of nonholonomic constraints, in order.
template <class Sys, class... Effects, class S, int n, class Phases = detail::NoPhases>
auto constraint_velocity(const Scene<Sys, Effects...>& scene, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t,
                         const Phases& z = {}) {
  return detail::stacked_rows<S>(scene, t, z, [&](const auto& e) { return detail::velocity_rows<n>(e, q, qdot, t); });
}

/// φ̈ of holonomic and ȧ of nonholonomic constraints at given accelerations, in order.
template <class Sys, class... Effects, class S, int n, class Phases = detail::NoPhases>
auto constraint_acceleration(const Scene<Sys, Effects...>& scene, const Vector<S, n>& q, const Vector<S, n>& qdot,
                             const Vector<S, n>& qddot, const S& t, const Phases& z = {}) {
  return detail::stacked_rows<S>(scene, t, z, [&](const auto& e) { return detail::acceleration_rows<n>(e, q, qdot, qddot, t); });
}

/// J, m×n: ∂φ/∂q of holonomic and ∂a/∂q̇ of nonholonomic constraints, in order.
template <class Sys, class... Effects, class S, int n, class Phases = detail::NoPhases>
auto constraint_jacobian(const Scene<Sys, Effects...>& scene, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t,
                         const Phases& z = {}) {
  constexpr int m = Scene<Sys, Effects...>::constraints_at_compile_time;
  Matrix<S, m, n> J;
  if constexpr (m == Dynamic) {
    J.resize(scene.row_counts().total, q.size());
  } else {
    J.resize(m, q.size());
  }
  Eigen::Index first = 0;
  std::size_t k = 0;
  detail::for_each_constraint(scene, z, [&](const auto& e, bool active) {
    using E = std::remove_cvref_t<decltype(e)>;
    const Eigen::Index counted = detail::rows_of_constraint<E>(scene, k++);
    if constexpr (m != Dynamic) {
      if (!active) {
        constexpr int rows = detail::constraint_rows_of<E, n>();
        J.template middleRows<rows>(first).setZero();
        first += rows;
        return;
      }
    }
    const auto part = detail::jacobian_rows<n>(e, q, qdot, t, counted);
    for (Eigen::Index j = 0; j < part.cols(); ++j)
      for (Eigen::Index i = 0; i < part.rows(); ++i) J(first + i, j) = active ? part(i, j) : S(0);
    first += part.rows();
  });
  return J;
}

/// J, γ and the velocity rows at a state.
template <class Sys, class... Effects, class S, int n, class Phases = detail::NoPhases>
auto constraint_rows(const Scene<Sys, Effects...>& scene, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t,
                     const Phases& z = {}) {
  constexpr int m = Scene<Sys, Effects...>::constraints_at_compile_time;
  const Vector<S, n> free = detail::zeros<Vector<S, n>>(q.size());
  return ConstraintRows<S, n, m>{constraint_jacobian(scene, q, qdot, t, z), -constraint_acceleration(scene, q, qdot, free, t, z),
                                 constraint_velocity(scene, q, qdot, t, z)};
}

namespace detail {

template <class = void>
[[gnu::cold]] void add_names(std::vector<std::string>& names, const std::string& name, Eigen::Index rows) {
  for (Eigen::Index i = 0; i < rows; ++i) names.push_back(rows == 1 ? name : sentence({name, "[", i, "]"}));
}
#ifdef QDOT_COMPILED
extern template void add_names<void>(std::vector<std::string>&, const std::string&, Eigen::Index);
#endif

}  // namespace detail

/// Name of each row: the constraint's, numbered where it has several rows.
template <class Sys, class... Effects>
std::vector<std::string> constraint_names(const Scene<Sys, Effects...>& scene) {
  std::vector<std::string> names;
  std::size_t k = 0;
  detail::for_each(scene.effects(), [&](const auto& e) {
    using E = std::remove_cvref_t<decltype(e)>;
    if constexpr (ConstraintEffect<E, Sys::dof_at_compile_time>)
      detail::add_names(names, detail::constraint_name(e), detail::rows_of_constraint<E>(scene, k++));
  });
  return names;
}

}  // namespace qdot
