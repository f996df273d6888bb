#pragma once
// SPDX-License-Identifier: MIT
//
// Kinematic systems: the positions of masses are given, and T = Σ ½ m ṙ·ṙ + ½ Ω·I Ω follows; no velocity is written.
//
//     const auto pendulum = kinematic_system<1>(
//         [=](const auto& q, auto& bodies) { bodies.point_mass(m, vector(l * sin(q[0]), -l * cos(q[0]))); }, uniform_gravity(0.0, -9.81));
//
// The functor is called with q, or with q and t where something is moved by force, and places bodies:
//
//     bodies.point_mass(m, r)               r of 1, 2 or 3 entries
//     bodies.planar_body(m, I, r, angle)    r: centre of mass; I: about it
//     bodies.rigid_body(m, I, r, R)         r: centre of mass; I: 3×3 about it, along the body's axes; R: rotation matrix
//     bodies.rigid_body(body, r, R)         r: reference point of a RigidBody (rigid_body.hpp)
//
// R may be made of Euler angles, quaternions or anything else (rotation.hpp). The result is a system like any other:
// energy and momenta, effects, steppers, exact Jacobians.

#include <array>
#include <type_traits>
#include <utility>

#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/places/bodies.hpp"

namespace qdot {

/// The potential energy −Σ m g·r of the bodies of a kinematic_system().
struct UniformGravity {
  std::array<double, 3> field;  ///< g, the acceleration of free fall
};

/// Bodies fall with acceleration (gx, gy, gz); planar systems leave gz out.
constexpr UniformGravity uniform_gravity(double gx, double gy, double gz = 0.0) { return {{gx, gy, gz}}; }

/// Gravity along one of the axes; the compiler knows that the others are level.
template <int axis>
struct GravityAlong {
  double g;  ///< the acceleration of free fall, negative where bodies fall against the axis
};

/// Bodies fall with acceleration g along x (0), y (1) or z (2).
template <int axis>
constexpr GravityAlong<axis> gravity_along(double g) {
  static_assert(axis >= 0 && axis <= 2, "qdot: gravity_along takes the number of an axis, 0 for x, 1 for y, 2 for z");
  return {g};
}

namespace detail {

struct NoKineticTerm {};

template <class Potential>
inline constexpr bool is_gravity = std::is_same_v<Potential, UniformGravity>;
template <int axis>
inline constexpr bool is_gravity<GravityAlong<axis>> = true;

constexpr std::array<double, 3> field_of(const UniformGravity& gravity) { return gravity.field; }
template <int axis>
constexpr std::array<double, 3> field_of(const GravityAlong<axis>& gravity) {
  std::array<double, 3> field{};
  field[axis] = gravity.g;
  return field;
}

template <class Place, int n>
concept PlacesAtRest = requires(const Place& place, const Vector<double, n>& q, WeightSum<double>& bodies) { place(q, bodies); };
template <class Place, int n>
concept PlacesInTime =
    requires(const Place& place, const Vector<double, n>& q, double t, WeightSum<double>& bodies) { place(q, t, bodies); };
template <class Place, int n>
concept PlacesWithTimeLast =
    requires(const Place& place, const Vector<double, n>& q, double t, WeightSum<double>& bodies) { place(q, bodies, t); };

#if defined(__clang__) && defined(__OPTIMIZE__)  // ad/forward/functor_result.hpp says why
#pragma clang attribute push(__attribute__((always_inline)), apply_to = function)
#endif

template <int n, class Place, class Potential, class Extra>
class KinematicEnergies {
  static constexpr bool placed_in_time = PlacesInTime<Place, n>;
  static constexpr bool heavy = is_gravity<Potential>;
  static constexpr bool has_extra = !std::is_same_v<Extra, NoKineticTerm>;
  using ExtraEnergies = KineticAndPotential<Extra, NoPotential>;
  using OwnPotential = KineticAndPotential<NoKineticTerm, std::conditional_t<heavy, NoPotential, Potential>>;

  static consteval bool time_in_T() {
    if constexpr (has_extra) {
      return placed_in_time || kinetic_signature<ExtraEnergies, n>() == KineticSignature::state_and_time;
    } else {
      return placed_in_time;
    }
  }
  static consteval bool time_in_V() {
    return (heavy && placed_in_time) || potential_signature<OwnPotential, n>() == PotentialSignature::position_and_time;
  }

 public:
  constexpr KinematicEnergies(Place place, Potential potential, Extra extra)
      : place_(std::move(place)), potential_(std::move(potential)), extra_{std::move(extra), NoPotential{}} {}

  template <class S>
    requires(!time_in_T())
  S T(const Vector<S, n>& q, const Vector<S, n>& qdot) const {
    return kinetic_energy(q, qdot, S(0.0));
  }
  template <class S>
    requires(time_in_T())
  S T(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    return kinetic_energy(q, qdot, t);
  }
  template <class S>
    requires(!time_in_V())
  S V(const Vector<S, n>& q) const {
    return potential_energy(q, S(0.0));
  }
  template <class S>
    requires(time_in_V())
  S V(const Vector<S, n>& q, const S& t) const {
    return potential_energy(q, t);
  }

  // One call of the functors, for what they read of q (mechanics/equations/entries.hpp).
  template <class Q>
  void read_entries(const Q& q, const Q&, double t) const {
    WeightSum<double> bodies = weights<double>();
    place(q, t, bodies);
    if constexpr (!heavy) (void)own_potential(q, t);
  }

 private:
  template <class Positions, class Time, class Bodies>
  constexpr void place(const Positions& q, const Time& t, Bodies& bodies) const {
    if constexpr (placed_in_time) {
      called(place_, q, t, bodies);
    } else {
      called(place_, q, bodies);
    }
  }
  template <class Positions, class Time>
  constexpr auto own_potential(const Positions& q, const Time& t) const {
    if constexpr (potential_signature<OwnPotential, n>() == PotentialSignature::position) {
      return called(potential_, q);
    } else {
      return called(potential_, q, t);
    }
  }

  // V of no body yet.
  template <class S>
  WeightSum<S> weights() const {
    if constexpr (heavy) {
      const std::array<double, 3> g = field_of(potential_);
      return {{g[0], g[1], g[2]}};
    } else {
      return {{0.0, 0.0, 0.0}};
    }
  }

  template <class S>
  S kinetic_energy(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    const auto placed = [&](const auto& follow, const auto&... at) {
      KineticSum<S, std::remove_cvref_t<decltype(follow)>> bodies{follow};
      called(place_, at..., bodies);
      return bodies.T;
    };
    const auto of_bodies = [&] {
      if constexpr (placed_in_time) return with_moving<S>(q, qdot, placed, t);
      else return with_moving<S>(q, qdot, placed);
    };
    if constexpr (has_extra) return of_bodies() + kinetic<n>(extra_, q, qdot, t);
    else return of_bodies();
  }
  template <class S>
  S potential_energy(const Vector<S, n>& q, const S& t) const {
    if constexpr (heavy) {
      WeightSum<S> bodies = weights<S>();
      place(q, t, bodies);
      return bodies.V;
    } else {
      return own_potential(q, t);
    }
  }

  Place place_;
  Potential potential_;
  ExtraEnergies extra_;
};

#if defined(__clang__) && defined(__OPTIMIZE__)
#pragma clang attribute pop
#endif

// The English of mistakes in what kinematic_system() is given.
template <int n, class Place, class Potential, class Extra>
consteval bool require_kinematics() {
  static_assert(PlacesAtRest<Place, n> || PlacesInTime<Place, n>,
                "qdot: the functor that places the bodies must be callable as place(q, bodies) or place(q, t, bodies): "
                "take `const auto& q, auto& bodies` and call bodies.point_mass(m, r), bodies.planar_body(m, I, r, angle) or "
                "bodies.rigid_body(body, r, R)");
  if constexpr (PlacesAtRest<Place, n>)  // to ask the third of others would compile their bodies with a time among them
    static_assert(!PlacesInTime<Place, n> && !PlacesWithTimeLast<Place, n>,
                  "qdot: the functor that places the bodies can be called as place(q, bodies) and with a third argument, and nothing tells which "
                  "is meant: take `const auto& q, auto& bodies`, or `const auto& q, const auto& t, auto& bodies` where it depends on time");
  if constexpr (PlacesInTime<Place, n> && !PlacesAtRest<Place, n>)
    static_assert(
        requires(const Place& place, const Vector<Dual<double, 1>, n>& q, const Dual<double, 1>& t, WeightSum<Dual<double, 1>>& bodies) {
          place(q, t, bodies);
        },
        "qdot: the functor that places the bodies takes the time as a double, but the time carries derivatives as q does: take "
        "`const auto& q, const auto& t, auto& bodies`");
  if constexpr (!is_gravity<Potential>) static_assert(require_potential_energy<KineticAndPotential<NoKineticTerm, Potential>, n>());
  if constexpr (!std::is_same_v<Extra, NoKineticTerm>) static_assert(require_kinetic_energy<KineticAndPotential<Extra, NoPotential>, n>());
  return true;
}

template <int n, class Place, class Potential, class Extra>
auto kinematic_system_of(Place place, Potential potential, Extra extra, Eigen::Index dof) {
  static_assert(require_kinematics<n, Place, Potential, Extra>());
  if constexpr (PlacesAtRest<Place, n> || PlacesInTime<Place, n>) {
    return checked_system<n>(KinematicEnergies<n, Place, Potential, Extra>(std::move(place), std::move(potential), std::move(extra)), dof);
  }
}

}  // namespace detail

/// The system with n coordinates whose masses are where `place` puts them, in the potential V.
///
/// @param place    place(q, bodies) or place(q, t, bodies), generic; see the head of this file
/// @param V        V(q), V(q, t), uniform_gravity(gx, gy, gz) or gravity_along<axis>(g)
/// @return         a System: T of the bodies, V as given
template <int n, class Place, class Potential = NoPotential>
auto kinematic_system(Place place, Potential V = {}) {
  return detail::kinematic_system_of<n>(std::move(place), std::move(V), detail::NoKineticTerm{}, n);
}

/// The system of placed bodies with a further kinetic term T_extra(qdot), (q, qdot) or (q, qdot, t): a flywheel, a motor behind its gear,
/// a vector potential.
template <int n, class Place, class Potential, class Extra>
auto kinematic_system(Place place, Potential V, Extra T_extra) {
  return detail::kinematic_system_of<n>(std::move(place), std::move(V), std::move(T_extra), n);
}

/// The system of placed bodies whose number of coordinates is known only at run time; q is a dynamic vector.
///
/// @throws InvalidValue  when n < 1
template <class Place, class Potential = NoPotential>
auto kinematic_system(Eigen::Index n, Place place, Potential V = {}) {
  return detail::kinematic_system_of<Dynamic>(std::move(place), std::move(V), detail::NoKineticTerm{}, n);
}

}  // namespace qdot
