#pragma once
// SPDX-License-Identifier: MIT
//
// A cart of 1 kg with a pole of 0.5 kg and 0.6 m, driven by a motor with a current of its own, with friction, wind and a spring to the wall:
// many effects at once, all of them formulas.
#include <cmath>

#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/scene_form.hpp"

namespace test {

inline const auto pole_tip = [](const auto& q) {
  using std::cos, std::sin;
  return qdot::vector(q[0] + 0.6 * sin(q[1]), 0.6 * cos(q[1]));
};

/// The cart with its effects, and more of them.
template <class... More>
auto driven_cart(const More&... more) {
  using namespace qdot;
  using Eigen::Vector2d;
  return scene(mechanical_system<2>(
                   [](const auto& q, const auto& v) {
                     using std::cos;
                     return 0.75 * v[0] * v[0] + 0.5 * 0.5 * 0.36 * v[1] * v[1] + 0.3 * v[0] * v[1] * cos(q[1]);
                   },
                   [](const auto& q) {
                     using std::cos;
                     return 0.5 * 9.81 * 0.6 * cos(q[1]);
                   }),
               controller([](const auto&, const auto&, const auto& z, const auto& t) { return qdot::vector(2.0 * z[0], 0.0 * t); },
                          [](const auto&, const auto& v, const auto& z, const auto& t) {
                            using std::sin;
                            return qdot::vector((6.0 * sin(t) - z[0] - 2.0 * v[0]) / 0.05);
                          },
                          Vector<double, 1>(0.0)),
               rayleigh([](const auto&, const auto& v) { return 0.05 * v[1] * v[1] + 0.1 * v[0] * v[0]; }), quadratic_drag(pole_tip, 0.1),
               force_at_point(pole_tip, Vector2d(0.4, 0.0)), spring_damper(pole_tip, Vector2d(2.0, 0.0), 3.0, 1.0, 0.2), more...);
}

}  // namespace test
