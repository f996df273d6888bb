#pragma once
// SPDX-License-Identifier: MIT
//
// A force that is left open: a motor, a hand, whatever a controller will have at its disposal.
//
//     M q̈ = rhs + Q(q, q̇, u)
//
// The inputs u are states of the effect with u̇ = 0: in a run they keep the values that they were given. Derivatives with respect
// to them come with those of all states, exact. A linearization (analysis/linearization.hpp) takes them out again and calls their
// columns B.

#include <string>
#include <type_traits>
#include <utility>

#include "qdot/effects/fit.hpp"
#include "qdot/effects/forces.hpp"

namespace qdot {

/// Generalized forces of `count` inputs.
template <int count, class F>
struct Input {
  static constexpr bool is_input = true;  ///< by which others find it in a scene
  std::string name;                       ///< for messages
  F Q;                                    ///< generalized force, of (q, q̇, u), n
  Vector<double, count> u;                ///< values until others are set

  template <int>
  static constexpr bool takes_time = false;

  Vector<double, count> initial_state() const { return u; }
  template <int n>
  void require_fit([[maybe_unused]] const Vector<double, n>& q) const {
    if constexpr (requires { Q.coordinate; })
      detail::require_coordinate(detail::sentence({"the input '", name, "'"}), Q.coordinate, q.size());
  }
  template <class S, int n>
  Vector<S, n> force(const Vector<S, n>& q, const Vector<S, n>& qdot, const Vector<S, count>& inputs, const S&) const {
    return detail::force_vector<S, n>(Q(q, qdot, inputs), q.size(), "the force of an input");
  }
  template <class S, int n>
  Vector<S, count> state_rate(const Vector<S, n>&, const Vector<S, n>&, const Vector<S, count>&, const S&) const {
    return detail::zeros<Vector<S, count>>(count);
  }
};

/// The generalized force Q(q, qdot, u) of `count` inputs; u is a vector of them.
///
/// @param u  their values   [whatever Q takes them for]
template <int count, class F>
Input<count, F> input(std::string name, F Q,
                      const std::type_identity_t<Vector<double, count>>& u = Vector<double, count>::Zero()) {
  return {std::move(name), std::move(Q), u};
}

namespace detail {

struct ForceOnCoordinate {
  Eigen::Index coordinate;

  template <class S, int n>
  Vector<S, n> operator()(const Vector<S, n>& q, const Vector<S, n>&, const Vector<S, 1>& u) const {
    Vector<S, n> Q = detail::zeros<Vector<S, n>>(q.size());
    Q[coordinate] = u[0];
    return Q;
  }
};

// visit(effect, place in y = [q; q̇; z] of its first state) for each effect of a scene.
template <class Sc, class Visit>
void for_each_place(const Sc& scene, const Visit& visit) {
  Eigen::Index place = 2 * scene.dof();
  for_each(scene.effects(), [&](const auto& effect) {
    visit(effect, place);
    place += states_of<std::remove_cvref_t<decltype(effect)>>();
  });
}

// visit(effect, place in y, i) for each input of a scene, the i-th of its effect.
template <class Sc, class Visit>
void for_each_input(const Sc& scene, [[maybe_unused]] const Visit& visit) {
  for_each_place(scene, [&]<class E>(const E& effect, Eigen::Index place) {
    if constexpr (requires { E::is_input; })
      for (int i = 0; i < states_of<E>(); ++i) visit(effect, place + i, i);
  });
}

// As a linearization and a simulator call the i-th input of an effect.
template <class E>
std::string input_name(const E& effect, int i) {
  return effect.u.size() == 1 ? effect.name : sentence({effect.name, "[", i, "]"});
}

}  // namespace detail

/// One input, the generalized force on one coordinate: a motor at a hinge, a push on a cart.
///
/// @throws InvalidValue  from scene(), when there is no such coordinate
inline Input<1, detail::ForceOnCoordinate> input(std::string name, Eigen::Index coordinate, double u = 0.0) {
  return {std::move(name), {coordinate}, Vector<double, 1>(u)};
}

}  // namespace qdot
