#pragma once
// SPDX-License-Identifier: MIT
//
// An input that goes linearly from value to value.
//
// A digital controller holds its output from one instant to the next, and an input() does. A measured signal, or the output of another
// simulator, is often known at some times only. Linear interpolation between these is better: held values lag by half an interval,
// linear ones err by its square.
//
//     u̇ = s ,  ṡ = 0          while t < t_end ,        u = u_end ,  s = 0     from then on
//
// The slope s, the end and its time are states of the effect beside u. So a copied, saved or restored state of a scene has all of the ramp.
// The equations are smooth from one end to the next: Simulator::ramp_input (integrate/simulator.hpp) lands on t_end and gives u its value
// there, exactly. An input that is only held needs none of it and pays for none of it.
//
// Of each input four numbers stand in z, block by block: [u; s; u_end; t_end].

#include <utility>

#include "qdot/effects/input.hpp"

namespace qdot {

/// Generalized forces of inputs that are held or go linearly to where they are sent.
template <int count, class F>
struct InterpolatedInput {
  static constexpr int interpolated_inputs = count;  ///< by which a simulator finds them in a scene
  Input<count, F> input;                             ///< their names, force and first values

  template <int>
  static constexpr bool takes_time = false;

  Vector<double, 4 * count> initial_state() const {
    Vector<double, 4 * count> z = Vector<double, 4 * count>::Zero();
    z.template head<count>() = input.u;
    z.template segment<count>(2 * count) = input.u;
    return z;
  }
  template <int n>
  void require_fit(const Vector<double, n>& q) const {
    input.require_fit(q);
  }
  template <class S, int n>
  Vector<S, n> force(const Vector<S, n>& q, const Vector<S, n>& qdot, const Vector<S, 4 * count>& z, const S& t) const {
    return input.force(q, qdot, Vector<S, count>(z.template head<count>()), t);
  }
  template <class S, int n>
  Vector<S, 4 * count> state_rate(const Vector<S, n>&, const Vector<S, n>&, const Vector<S, 4 * count>& z, const S&) const {
    Vector<S, 4 * count> rate = Vector<S, 4 * count>::Zero();
    rate.template head<count>() = z.template segment<count>(count);
    return rate;
  }
};

/// The same input, which a simulator may also send to a value over a time: interpolated(input("motor", 0)).
template <int count, class F>
InterpolatedInput<count, F> interpolated(Input<count, F> input) {
  return {std::move(input)};
}

}  // namespace qdot
