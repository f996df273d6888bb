#pragma once
// SPDX-License-Identifier: MIT
//
// Many motions of one system, as `bench many` and the peers measure them: the starts, and what a problem is called.

#include <cmath>
#include <cstddef>
#include <tuple>
#include <type_traits>

#include "bench/chain_energies.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/counter_random.hpp"
#include "qdot/integrate/many_in_lanes.hpp"
#include "qdot/mechanics/system.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/kepler.hpp"

namespace qdot::bench {

inline constexpr std::size_t motions = 512;
inline constexpr double duration = 5.0;

// Angles of some tenths of a radian to one radian, or orbits that do not come near the centre.
template <int n>
State<n> start_of_many(std::size_t i, double lowest, double highest, double fastest) {
  CounterRandom random(1, i);
  State<n> start;
  start.t = 0.0;
  for (int j = 0; j < n; ++j) start.q[j] = random.uniform(lowest, highest);
  for (int j = 0; j < n; ++j) start.qdot[j] = random.uniform(-fastest, fastest);
  return start;
}

// visit(name, system, start_of) for each.
template <class Visit>
void for_each_of_many(const Visit& visit) {
  const auto swinging = [&](const char* name, const auto& system) {
    visit(name, system, [](std::size_t i) { return start_of_many<std::remove_cvref_t<decltype(system)>::dof_at_compile_time>(i, -1.0, 1.0, 1.0); });
  };
  swinging("double_pendulum", mechanical_system<2>(scenes::DoublePendulum{}));
  visit("kepler", mechanical_system<2>(scenes::Kepler{}), [](std::size_t i) { return start_of_many<2>(i, 0.8, 1.2, 0.5); });
  swinging("chain 2", mechanical_system<2>(UnrolledChain<2>{}));
  swinging("chain 3", mechanical_system<3>(UnrolledChain<3>{}));
  swinging("chain 4", mechanical_system<4>(UnrolledChain<4>{}));
}

// A pendulum whose pivot is shaken, and its damping, for parameters that are numbers of any kind.
template <class S = double>
struct ShakenPendulum {
  S length = 1.0, depth = 0.3;

  auto T(const auto& v) const { return 0.5 * length * length * v[0] * v[0]; }
  auto V(const auto& q, const auto& t) const {
    using std::cos;
    return -length * (9.81 + depth * cos(3.0 * t)) * cos(q[0]);
  }
};

// The outer bob of the double pendulum.
inline constexpr auto outer_bob = [](const auto& q) {
  using std::cos, std::sin;
  return vector(sin(q[0]) + sin(q[1]), -cos(q[0]) - cos(q[1]));
};

// visit(name, model_of, all, start_of) for scenes and systems with t: model_of(i) is that of motion i, `all` what ensemble() takes.
template <class Visit>
void for_each_scene_of_many(const Visit& visit) {
  const auto swinging = [&]<int n>(const char* name, const auto& model, std::integral_constant<int, n>) {
    visit(name, [&](std::size_t) { return model; }, model, [](std::size_t i) { return start_of_many<n>(i, -1.0, 1.0, 1.0); });
  };
  constexpr std::integral_constant<int, 2> two;
  const auto pendulum = mechanical_system<2>(scenes::DoublePendulum{});
  swinging("double_pendulum, damped", scene(pendulum, viscous_damping(Eigen::Vector2d(0.1, 0.2))), two);
  swinging("double_pendulum, spring and damper", scene(pendulum, spring_damper(Eigen::Vector2d(1.0, 0.5), outer_bob, 5.0, 0.5, 0.1)), two);
  swinging("double_pendulum, drag", scene(pendulum, quadratic_drag(outer_bob, 0.1)), two);
  const auto push = [](const auto& t) {
    using std::sin;
    return vector(sin(2.0 * t), 0.0 * t);
  };
  swinging("double_pendulum, pushed", scene(pendulum, force_at_point(outer_bob, push)), two);
  swinging("chain 4, damped", scene(mechanical_system<4>(UnrolledChain<4>{}), viscous_damping(Eigen::Vector4d(0.1, 0.1, 0.1, 0.1))),
           std::integral_constant<int, 4>());
  swinging("shaken pendulum", mechanical_system<1>(ShakenPendulum<>{}), std::integral_constant<int, 1>());

  const auto energies_of = [](const auto& p) { return ShakenPendulum<std::remove_cvref_t<decltype(p[0])>>{p[0], p[1]}; };
  const auto effects_of = [](const auto& p) { return std::tuple(viscous_damping(p.template tail<1>().eval())); };
  const auto parameters_of = [](std::size_t i) {
    CounterRandom random(2, i);
    return Vector<double, 3>(random.uniform(0.5, 2.0), random.uniform(0.0, 2.0), random.uniform(0.0, 0.2));
  };
  visit("shaken pendulums of other length and damping",
        [&](std::size_t i) {
          const auto p = parameters_of(i);
          return scene(mechanical_system<1>(energies_of(p)), std::get<0>(effects_of(p)));
        },
        family<1>(energies_of, effects_of, parameters_of), [](std::size_t i) { return start_of_many<1>(i, -1.0, 1.0, 1.0); });
}

}  // namespace qdot::bench
