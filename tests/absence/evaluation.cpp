// SPDX-License-Identifier: MIT
//
// One evaluation of q̈, of the bare system or of a scene, as SUBJECT says. Compiled and compared, never run.
#include <type_traits>

#include "qdot/effects/choice.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/mechanics/kinematic_system.hpp"
#include "qdot/mechanics/system.hpp"

namespace {

struct CartAndPole {
  double M = 2.0, m = 1.0, l = 1.0, g = 9.81;
  auto T(const auto& q, const auto& qdot) const {
    using std::cos;
    return 0.5 * (M + m) * qdot[0] * qdot[0] + m * l * qdot[0] * qdot[1] * cos(q[1]) + 0.5 * m * l * l * qdot[1] * qdot[1];
  }
  auto V(const auto& q) const {
    using std::cos;
    return -m * g * l * cos(q[1]);
  }
};

inline auto cart() { return qdot::mechanical_system<2>(CartAndPole{}); }
inline auto positions() {
  return qdot::kinematic_system<2>(
      [](const auto& q, auto& bodies) {
        using std::cos, std::sin;
        bodies.point_mass(2.0, qdot::vector(q[0], 0.0 * q[0]));
        bodies.point_mass(1.0, qdot::vector(q[0] + sin(q[1]), -cos(q[1])));
      },
      qdot::gravity_along<1>(-9.81));
}
inline auto damping() { return qdot::viscous_damping(qdot::Vector<double, 2>(0.1, 0.2)); }
inline auto friction() { return qdot::regularized_friction(0, 1.0, 1e-3); }
inline auto track() { return qdot::prescribed("track", 0, [](const auto& t) { return 0.0 * t; }); }
inline auto field() {
  return qdot::velocity_potential([](const auto& q, const auto& qdot, const auto&) { return 0.1 * q[1] * qdot[0]; });
}

template <bool a, bool b, bool c, bool d>
auto chosen() {
  using qdot::optional;
  return scene(cart(), optional<a>(damping()), optional<b>(friction()), optional<c>(track()), optional<d>(field()));
}

// Off is absent, already as a type: alone, in pairs, and in the company of effects that are on.
static_assert(std::is_same_v<decltype(chosen<false, false, false, false>()), decltype(scene(cart()))>);
static_assert(std::is_same_v<decltype(chosen<true, false, false, false>()), decltype(scene(cart(), damping()))>);
static_assert(std::is_same_v<decltype(chosen<false, true, false, false>()), decltype(scene(cart(), friction()))>);
static_assert(std::is_same_v<decltype(chosen<false, false, false, true>()), decltype(scene(cart(), field()))>);
static_assert(std::is_same_v<decltype(chosen<true, true, false, false>()), decltype(scene(cart(), damping(), friction()))>);
static_assert(std::is_same_v<decltype(chosen<true, false, false, true>()), decltype(scene(cart(), damping(), field()))>);
static_assert(std::is_same_v<decltype(chosen<false, false, true, false>()), decltype(scene(cart(), track()))>);
static_assert(std::is_same_v<decltype(chosen<false, false, true, true>()), decltype(scene(cart(), track(), field()))>);

}  // namespace

using Subject = decltype(SUBJECT);

extern "C" void evaluated(const Subject& subject, const double* q, const double* qdot, double* qddot) {
  using V = qdot::Vector<double, 2>;
  Eigen::Map<V>{qddot} = acceleration(subject, V(q[0], q[1]), V(qdot[0], qdot[1]), 0.0);
}
