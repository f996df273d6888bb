#pragma once
// SPDX-License-Identifier: MIT
//
// Contacts, stops and ropes: constraints that can only push (or only pull).
//
//     contact("floor", gap, restitution(0.8))     φ(q, t) ≥ 0, with an impact where φ reaches zero
//     rope("rope", point, anchor, length)         length − |r(q) − anchor| ≥ 0, which tension λ ≥ 0 keeps
//     boundary("end of the rod", gap)             φ(q, t) ≥ 0 as long as the model holds; the run ends there
//
// Apart, such a constraint is not there. Closed, it is the holonomic constraint φ = 0 with the force Jᵀλ. Between the phases:
//
//     apart → closed    φ falls to zero: an impact (impact.hpp). If the next hop would be lower than a hundred times the method's
//                       tolerance, the contact has come to rest, provided that something presses it (φ̈ < 0 if it were apart).
//     closed → apart    λ falls to zero, because then the force would have to pull.
//
// So a bouncing ball comes to rest and does not fall through the floor; its remaining hops, e times lower each, are left out. Backward
// in time an impact has no answer: the run ends and names it. Friction does not depend on λ: dry_friction.hpp takes a given force.

#include <cmath>
#include <string>
#include <type_traits>
#include <utility>

#include "qdot/effects/impact.hpp"

namespace qdot {

#if defined(__clang__) && defined(__OPTIMIZE__)  // ad/forward/functor_result.hpp says why
#pragma clang attribute push(__attribute__((always_inline)), apply_to = function)
#endif

/// Phases of a contact, as they stand in z.
enum class ContactPhase {
  apart = 0,     ///< φ > 0: no force
  closed = 1,    ///< φ = 0, kept by a force
  undecided = 2  ///< at the start, until the state has been looked at
};

/// What a contact's events are called.
struct ContactEvents {
  std::string hits, rests, opens;  ///< at an impact, where it comes to rest, and where it opens again
};

/// φ(q, t) ≥ 0.
template <class Gap>
struct Contact {
  std::string name;       ///< for messages
  Gap gap;                ///< φ, of q or (q, t)
  ImpactLaw law;          ///< what an impact does
  ContactEvents events;   ///< what its events are called
  bool ends_run = false;  ///< whether the run ends where the gap closes

  template <int n>
  static constexpr bool takes_time = detail::functor_takes_time<n, Gap, 1>();

  template <class S, int n>
  S phi(const Vector<S, n>& q, const S& t) const {
    const auto distance = detail::of_position(gap, q, t);
    static_assert(std::is_convertible_v<decltype(distance), S>, "qdot: the gap of a contact must be one number; give each condition a contact of its own");
    return S(distance);
  }
  bool is_active(double phase) const { return phase == static_cast<double>(ContactPhase::closed); }
  Vector<double, 1> initial_state() const { return Vector<double, 1>(static_cast<double>(ContactPhase::undecided)); }
};

/// A contact with gap φ(q) or φ(q, t), positive where it is open.
///
/// Its events: "floor" for an impact, "floor rests", "floor opens".
///
/// @param gap  a distance, so that λ is a force; any function that is zero at contact and has a gradient there will do
template <class Gap>
Contact<Gap> contact(std::string name, Gap gap, ImpactLaw law = {}) {
  return {name, std::move(gap), law, {name, detail::sentence({name, " rests"}), detail::sentence({name, " opens"})}};
}

/// The edge of what the model describes: the run ends, stopped_by_event, where φ(q) or φ(q, t) ≥ 0 falls to zero.
template <class Gap>
Contact<Gap> boundary(std::string name, Gap gap) {
  return {name, std::move(gap), {}, {name, name, name}, true};
}

/// The room that a rope of given length leaves between a point and its anchor.
template <class P, class A>
struct RopeSlack {
  P point;        ///< one end, of q or (q, t), or fixed
  A anchor;       ///< the other
  double length;  ///< of the rope

  template <int n>
  static constexpr bool takes_time = detail::functor_takes_time<n, P, 1>() || detail::functor_takes_time<n, A, 1>();

  /// Length − |point − anchor|.
  template <class S, int n>
  S operator()(const Vector<S, n>& q, const S& t) const {
    return length - detail::distance_of(point, anchor, q, t);
  }
};

/// A rope of given length between two points; λ is its tension.
///
/// Its events: "rope taut" when it jerks, "rope holds", "rope slack". With e = 0 the jerk takes the radial velocity away.
///
/// @param point, anchor  positions as functors of q or (q, t), or fixed points as plain vectors
/// @throws InvalidValue  unless length > 0
template <class P, class A>
Contact<RopeSlack<P, A>> rope(std::string name, P point, A anchor, double length, ImpactLaw law = {}) {
  if (!(length > 0) || !std::isfinite(length))
    detail::throw_invalid_value({"the length of a rope must be positive, but that of '", name, "' is ", std::to_string(length),
                                 "; give it a length"});
  const ContactEvents events{detail::sentence({name, " taut"}), detail::sentence({name, " holds"}), detail::sentence({name, " slack"})};
  return {name, {std::move(point), std::move(anchor), length}, law, events};
}

#if defined(__clang__) && defined(__OPTIMIZE__)
#pragma clang attribute pop
#endif

}  // namespace qdot
