#pragma once
// SPDX-License-Identifier: MIT
//
// Applied forces.
//
// The generalized force of an applied force is read off its virtual work, δW = Q·δq:
//
//     a force F at a point r(q)              Q = (∂r/∂q)ᵀ F
//     a torque τ on a body with pose R(q)    Qᵢ = τ·ωᵢ ,   ωᵢ the angular velocity of q̇ = eᵢ
//
// Both are evaluations of the user's r(q) or R(q) on dual numbers; no Jacobian is written. Forces on points may depend on where the point is and how it
// moves, which is what drag, springs to the wall and magnets need.

#include <type_traits>
#include <utility>

#include <Eigen/Core>

#include "qdot/ad/derivatives.hpp"
#include "qdot/ad/forward/functor_result.hpp"
#include "qdot/effects/effect.hpp"
#include "qdot/effects/equations/functors.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/rotation.hpp"
#include "qdot/mechanics/velocity.hpp"

namespace qdot {

#if defined(__clang__) && defined(__OPTIMIZE__)  // ad/forward/functor_result.hpp says why
#pragma clang attribute push(__attribute__((always_inline)), apply_to = function)
#endif

/// A generalized force Q(q, q̇, t), given as it is.
template <class F>
struct GeneralizedForce {
  F Q;  ///< of (q, q̇) or (q, q̇, t), n

  template <int n>
  static constexpr bool takes_time = detail::functor_takes_time<n, F, 2>();

  template <class S, int n>
    requires detail::may_take<F, S>
  Vector<S, n> force(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    return detail::force_vector<S, n>(detail::of_state(Q, q, qdot, t), q.size(), "a generalized force");
  }
};

/// The generalized force Q(q, qdot, t) or Q(q, qdot): n entries   [energy per unit of q].
template <class F>
GeneralizedForce<F> generalized_force(F Q) {
  return {std::move(Q)};
}

/// A force F on the point r of the system.
template <class Position, class F>
struct ForceAtPoint {
  Position r;  ///< the point, of q or (q, t)
  F F_of;      ///< the force there

  /// The point as a vector of numbers.
  template <int n>
  using Point = decltype(detail::of_position(std::declval<const Position&>(), std::declval<const Vector<double, n>&>(), 0.0));
  template <int n>
  static constexpr bool takes_time = detail::functor_takes_time<n, Position, 1>() || detail::functor_takes_time<n, F, 0>() ||
                                     detail::functor_takes_time<Point<n>::RowsAtCompileTime, F, 2>();

  template <class S, int n>
    requires detail::may_take<F, S>
  Vector<S, n> force(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    const auto moving = value_and_velocity_of([&](const auto& x, const auto& s) { return detail::of_position(r, x, s); },
                                              q, qdot, t);
    using Spatial = std::remove_cvref_t<decltype(moving.value)>;
    const Spatial applied_force = detail::force_vector<S, Spatial::RowsAtCompileTime>(applied(moving.value, moving.rate, t),
                                                                                      moving.value.size(), "the force at a point");
    return gradient(detail::marked<detail::SlopeOfEffect>([&](const auto& x) {
      using D = typename std::remove_cvref_t<decltype(x)>::Scalar;
      const auto point = detail::of_position(r, x, D(t));
      D work(0);
      for (Eigen::Index i = 0; i < point.size(); ++i) work += applied_force[i] * point[i];
      return work;
    }), q);
  }

 private:
  template <class Spatial, class S>
  auto applied(const Spatial& position, const Spatial& velocity, const S& t) const {
    constexpr bool is_vector = requires { F::RowsAtCompileTime; };  // Eigen's vectors can be called too, with an index
    constexpr bool by_state = detail::is_callable<const F&, const Spatial&, const Spatial&, const S&> ||
                              detail::is_callable<const F&, const Spatial&, const Spatial&>;
    constexpr bool by_time = detail::is_callable<const F&, const S&>;
    static_assert(is_vector || by_state || by_time || detail::is_callable<const F&, const Spatial&, const Spatial&, double>,
                  "qdot: the force at a point must be a vector, or callable as F(t) or F(position, velocity, t)");
    static_assert(is_vector || !(by_state && by_time),
                  "qdot: the force at a point can be called as F(t) and as F(position, velocity), and nothing tells which is meant: leave one of "
                  "them, and name the arguments where there is a pack");
    if constexpr (is_vector || by_time) {
      return detail::of_time(F_of, t);
    } else {
      return detail::of_state(F_of, position, velocity, t);
    }
  }
};

/// The force F on the point r(q) or r(q, t).
///
/// @param r  position functor, returns a vector of 2 or 3 (or any number of) scalars
/// @param F  a constant vector, F(t), F(position, velocity, t) or F(position, velocity), of r's length
template <class Position, class F>
ForceAtPoint<Position, F> force_at_point(Position r, F force) {
  return {std::move(r), std::move(force)};
}

/// A torque on the body whose orientation is the rotation matrix R.
template <class Pose, class F>
struct TorqueOnBody {
  Pose R;    ///< attitude of the body, of q or (q, t), 3×3
  F torque;  ///< the torque

  template <int n>
  static constexpr bool takes_time = detail::functor_takes_time<n, Pose, 1>() || detail::functor_takes_time<n, F, 0>();

  template <class S, int n>
  Vector<S, n> force(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    const Vector<S, 3> tau = detail::of_time(torque, t).template cast<S>();
    // ω = Σ ωᵢ q̇ᵢ, so Qᵢ = ∂(τ·ω)/∂q̇ᵢ; linear in q̇. A known rotation has Ω in closed form, and τ·ω = Rᵀτ·Ω.
    return gradient(detail::marked<detail::SlopeOfEffect>([&](const auto& v) {
      using D = typename std::remove_cvref_t<decltype(v)>::Scalar;
      const Vector<D, n> at = detail::converted<D>(q);
      return detail::along_motion<D>(detail::at_time(R, D(t)), at, v, [&](const auto& rotation, const auto& follow) {
        if constexpr (detail::is_known_rotation<std::remove_cvref_t<decltype(rotation)>>) {
          if (rotation.is_as_made()) {
            D work(0.0);
            const auto omega = detail::known_angular_velocity<D>(rotation, follow);
            for (int a = 0; a < 3; ++a) {
              D along(0.0);
              for (int k = 0; k < 3; ++k) along = along + D(tau[k]) * follow(rotation.coeff(k, a)).value;
              work = work + along * omega[a];
            }
            return work;
          }
        }
        const auto omega = detail::angular_velocity_along<detail::Axes::of_space, D>(rotation, follow);
        return D(D(tau[0]) * omega[0] + D(tau[1]) * omega[1] + D(tau[2]) * omega[2]);
      });
    }), qdot);
  }
};

/// The torque (constant vector or function of t, in space axes) on the body with orientation R(q) or R(q, t).
template <class Pose, class F>
TorqueOnBody<Pose, F> torque_on_body(Pose R, F torque) {
  return {std::move(R), std::move(torque)};
}

/// A term in the Lagrangian: −U for a velocity-dependent potential U(q, q̇, t).
template <class F>
struct VelocityPotential {
  F U;  ///< of (q, q̇) or (q, q̇, t); L − U

  template <int n>
  static constexpr bool takes_time = detail::functor_takes_time<n, F, 2>();

  template <class S, int n>
  S lagrangian_term(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    return -detail::of_state(U, q, qdot, t);
  }
};

/// The velocity-dependent potential U(q, qdot, t) or U(q, qdot) of a charge in a field: L = T − V − U.
template <class F>
VelocityPotential<F> velocity_potential(F U) {
  return {std::move(U)};
}

/// The inertial forces on a mass point in a frame that turns and accelerates.
template <class Position, class Omega, class Acceleration>
struct NonInertialFrame {
  double m;           ///< mass of the point
  Position r;         ///< where it is in the frame
  Omega Omega_of;     ///< angular velocity of the frame, of t
  Acceleration a_of;  ///< acceleration of its origin, of t

  template <class S, int n>
  S lagrangian_term(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    const auto moving = value_and_velocity_of([&](const auto& x, const auto& s) { return detail::of_position(r, x, s); },
                                              q, qdot, t);
    const Vector<S, 3> position = moving.value;
    const Vector<S, 3> velocity = moving.rate;
    const Vector<S, 3> W = detail::of_time(Omega_of, t).template cast<S>();
    const Vector<S, 3> a = detail::of_time(a_of, t).template cast<S>();
    const Vector<S, 3> swept(W[1] * position[2] - W[2] * position[1], W[2] * position[0] - W[0] * position[2], W[0] * position[1] - W[1] * position[0]);
    return m * (velocity.dot(swept) + 0.5 * swept.dot(swept) - a.dot(position));
  }
};

/// What a mass m at r(q), given in coordinates of a moving frame, feels of the frame's motion.
///
/// T of the system is the one seen *in* the frame. Let v be the velocity in the frame, Ω its angular velocity and a the
/// acceleration of its origin, both in frame axes. Then L gains m v·(Ω × r) + ½ m (Ω × r)² − m a·r: Coriolis, centrifugal, Euler
/// and translational forces. Exact for every Ω(t), a(t).
///
/// @param Omega, a  functions of time that return vectors of 3 of its scalar
template <class Position, class Omega, class Acceleration>
NonInertialFrame<Position, Omega, Acceleration> non_inertial_frame(double m, Position r, Omega omega, Acceleration a) {
  return {m, std::move(r), std::move(omega), std::move(a)};
}

/// A controller or actuator with a state of its own.
template <class Force, class Rate, int states>
struct Controller {
  Force Q;                    ///< its force, of (q, q̇, z, t), n
  Rate zdot;                  ///< the rate of its states, of the same
  Vector<double, states> z0;  ///< its states at the start

  Vector<double, states> initial_state() const { return z0; }

  template <class S, int n>
    requires detail::may_take<Force, S>
  Vector<S, n> force(const Vector<S, n>& q, const Vector<S, n>& qdot, const Vector<S, states>& z, const S& t) const {
    return detail::force_vector<S, n>(of_own_state(Q, q, qdot, z, t), q.size(), "the force of a controller");
  }
  template <class S, int n>
    requires detail::may_take<Rate, S>
  Vector<S, states> state_rate(const Vector<S, n>& q, const Vector<S, n>& qdot, const Vector<S, states>& z, const S& t) const {
    return detail::force_vector<S, states>(of_own_state(zdot, q, qdot, z, t), states, "the rate of a controller's state");
  }

 private:
  template <class F, class Q_, class S>
  static auto of_own_state(const F& f, const Q_& q, const Q_& qdot, const Vector<S, states>& z, const S& t) {
    static_assert(detail::is_callable<const F&, const Q_&, const Q_&, const Vector<S, states>&, const S&>,
                  "qdot: the functors of a controller must be callable as f(q, qdot, z, t) for every scalar: take `const auto&`, the time too");
    return detail::result_of(f, q, qdot, z, t);
  }
};

/// A first-order system ż = zdot(q, qdot, z, t), z(t₀) = z0, that acts on the mechanics with Q(q, qdot, z, t).
///
/// The integral of a PID controller, the current of a motor, the pressure of an actuator. z follows q and q̇ in a run's y;
/// another run goes on with it from FirstOrderState{run.t, run.y}, while run.state() starts anew from z0.
template <class Force, class Rate, int states>
Controller<Force, Rate, states> controller(Force Q, Rate zdot, const Vector<double, states>& z0) {
  static_assert(states != Dynamic, "qdot: a controller's state must have a size known at compile time");
  return {std::move(Q), std::move(zdot), z0};
}

#if defined(__clang__) && defined(__OPTIMIZE__)
#pragma clang attribute pop
#endif

}  // namespace qdot
