// SPDX-License-Identifier: MIT
#include "scenes/cartpole.hpp"

#include "program/effect_variants.hpp"
#include "qdot/effects/dissipation.hpp"

namespace qdot::program {

namespace {

using scenes::Cartpole, scenes::optional_effect, scenes::Range;

// A direct-current motor on the cart's axle: F = k i,  L di/dt = U − R i − k ẋ.
constexpr double k = 2.0;   // N/A = V s/m
constexpr double R = 1.0;   // Ohm
constexpr double L = 0.05;  // H

auto motor(const Cartpole&, double U) {
  return controller(
      [](const auto& q, const auto&, const auto& z, const auto&) {
        using S = typename std::decay_t<decltype(q)>::Scalar;
        return Vector<S, 2>(k * z[0], S(0.0));
      },
      [U](const auto& q, const auto& qdot, const auto& z, const auto&) {
        using S = typename std::decay_t<decltype(q)>::Scalar;
        return Vector<S, 1>((U - R * z[0] - k * qdot[0]) / L);
      },
      Vector<double, 1>(0.0));
}

}  // namespace

std::unique_ptr<RunnableScene> make_cartpole() {
  return runnable(
      scenes::cartpole(), optional_effect<Cartpole>("motor", 12.0, "V", Range::any, "voltage of a motor that drives the cart", motor),
      optional_effect<Cartpole>("track_friction", 1.0, "N", Range::non_negative,
                                "force against the cart's motion, fading below 1 mm/s",
                                [](const Cartpole&, double F) { return regularized_friction(0, F, 1e-3); }),
      optional_effect<Cartpole>("joint_damping", 0.1, "N m s", Range::non_negative, "torque per angular velocity in the joint",
                                [](const Cartpole&, double c) { return viscous_damping(Vector<double, 2>(0.0, c)); }));
}

}  // namespace qdot::program
