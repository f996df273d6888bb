#pragma once
// SPDX-License-Identifier: MIT
//
// Σ Q of a scene's effects. Potentials of effects are a part of V (effects/equations/energy_terms.hpp).

#include <cmath>
#include <cstddef>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "qdot/ad/derivatives.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/error.hpp"

namespace qdot {

namespace detail {

#if defined(__clang__) && defined(__OPTIMIZE__)  // ad/forward/functor_result.hpp says why
#pragma clang attribute push(__attribute__((always_inline)), apply_to = function)
#endif

// sum += Q; of hashes entry by entry, which the compiler sees through.
template <class S, int n, class Force>
[[gnu::always_inline]] inline void add_entries(Vector<S, n>& sum, const Force& Q) {
  if constexpr (is_hash<S>) for_each_entry<n>(sum.size(), [&](int i) __attribute__((always_inline)) { sum.data()[i] = sum.data()[i] + Q[i]; });
  else sum += Q;
}

// Effects are asked what their `Roles` say: their own types, or those of the same effects with plain numbers for recorded parameters.
template <class... Roles, class Effects, class S, int n>
Vector<S, n> sum_over(const Effects& effects, const Vector<S, n>& q, const Vector<S, n>& qdot, const Vector<S, total<states_of<Roles>()...>()>& z, const S& t) {
  Vector<S, n> sum = zeros<Vector<S, n>>(q.size());
  Eigen::Index first = 0;
  const auto add = [&]<class E>(const auto& e, std::type_identity<E>) {
    if constexpr (StateEffect<E>) {
      constexpr int k = states_of<E>();
      if constexpr (!UnilateralEffect<E, n>) {
        static_assert(require_numbers<decltype(e.force(q, qdot, Vector<S, k>(), t))>());
        add_entries(sum, e.force(q, qdot, vector_at<k>(z.data() + first, k), t));
      }
      first += k;
    } else if constexpr (ForceEffect<E, n>) {
      static_assert(require_numbers<decltype(e.force(q, qdot, t))>());
      add_entries(sum, e.force(q, qdot, t));
    }
  };
  [&]<std::size_t... k>(std::index_sequence<k...>) {
    (add(std::get<k>(effects), std::type_identity<Roles>()), ...);
  }(std::index_sequence_for<Roles...>());
  return sum;
}
#if defined(__clang__) && defined(__OPTIMIZE__)
#pragma clang attribute pop
#endif

}  // namespace detail

/// Sum of the generalized forces of the effects at a state, n; z holds the effects' own states.
template <class Sys, class... Effects, class S, int n>
Vector<S, n> effect_forces(const Scene<Sys, Effects...>& scene, const Vector<S, n>& q, const Vector<S, n>& qdot,
                           const Vector<S, Scene<Sys, Effects...>::states_at_compile_time>& z, const S& t) {
  return detail::sum_over<Effects...>(scene.effects(), q, qdot, z, t);
}

namespace detail {

template <class = void>
[[noreturn, gnu::cold]] void throw_force_not_finite(int number, std::size_t count, const std::string& name, const std::string& coordinate, double t) {
  std::string which = sentence({"effect ", number, " of ", count});
  if (!name.empty()) which += sentence({" ('", name, "')"});
  throw NonFinite(sentence({"the force of ", which}), t,
                  sentence({"the force of an effect must be finite, but that of ", which, " on ", coordinate, " is not at t = ", std::to_string(t),
                            "; look there for a division by zero, or a root or logarithm outside its domain"}));
}
#ifdef QDOT_COMPILED
extern template void throw_force_not_finite<void>(int, std::size_t, const std::string&, const std::string&, double);
#endif

// Names the effect whose force is not finite, if there is one.
template <class Sc>
[[gnu::noinline]] void require_finite_forces(const Sc& scene, const Vector<double, Sc::dof_at_compile_time>& q,
                                             const Vector<double, Sc::dof_at_compile_time>& qdot, double t,
                                             const EffectStates<Sc>& z) {
  constexpr int n = Sc::dof_at_compile_time;
  if (!all_finite(q) || !all_finite(qdot)) return;  // then it is the state's fault
  Eigen::Index first = 0;
  int number = 0;
  for_each(scene.effects(), [&](const auto& e) {
    using E = std::remove_cvref_t<decltype(e)>;
    ++number;
    if constexpr (ForceEffect<E, n> || (StateEffect<E> && !UnilateralEffect<E, n>)) {
      const Vector<double, n> Q = [&]() -> Vector<double, n> {
        if constexpr (StateEffect<E>) {
          return e.force(q, qdot, vector_at<states_of<E>()>(z.data() + first, states_of<E>()), t);
        } else {
          return e.force(q, qdot, t);
        }
      }();
      for (Eigen::Index i = 0; i < Q.size(); ++i) {
        if (std::isfinite(Q[i])) continue;
        std::string name;
        if constexpr (requires { e.name; }) name = e.name;
        throw_force_not_finite(number, std::tuple_size_v<std::remove_cvref_t<decltype(scene.effects())>>, name, scene.coordinate_name(i), t);
      }
    }
    first += states_of<E>();
  });
}

}  // namespace detail
}  // namespace qdot
