// SPDX-License-Identifier: MIT
//
// A constraint that returns the difference of two points, of which one is gone by then; and all others that return vectors.
// message: qdot: a functor must return a number, or a vector or matrix that holds its numbers
// message: functor_returns_expression.cpp:26
// message: functor_returns_expression.cpp:29
// message: functor_returns_expression.cpp:30
// message: functor_returns_expression.cpp:31
// message: functor_returns_expression.cpp:32
// message: functor_returns_expression.cpp:33
// message: functor_returns_expression.cpp:34
// message: functor_returns_expression.cpp:35
// message: functor_returns_expression.cpp:36
// message: functor_returns_expression.cpp:37
#include <qdot/effects/constraints.hpp>
#include <qdot/effects/scene_form.hpp>

int main() {
  const auto body = qdot::mechanical_system<3>([](const auto& qdot) { return 0.5 * qdot.dot(qdot); });
  const Eigen::Vector3d q(0.1, 0.2, 0.3), v(0.3, 0.4, 0.5), target(0.0, 1.0, 0.0);
  const auto tip = [=](const auto& x) {
    using std::cos, std::sin;
    const auto point = qdot::vector(x[0] - sin(x[2]), x[1] + cos(x[2]), x[2]);
    return point - target;
  };
  int sum = scene(body, qdot::holonomic("rod", tip)).dof() == 3 ? 0 : 1;
  const auto moves = [&](const auto& effect) { return acceleration(scene(body, effect), q, v)[0] > 0.0 ? 1 : 0; };
  const auto unit = [](const auto& t) { return qdot::vector(t, t, t); };
  sum += moves(qdot::nonholonomic("skate", [=](const auto& x, const auto& u) { return 2.0 * u + 0.0 * x; }));
  sum += moves(qdot::generalized_force([=](const auto& x, const auto& u) { return x + u; }));
  sum += moves(qdot::force_at_point([=](const auto& x) { return 2.0 * x; }, target));
  sum += moves(qdot::force_at_point([](const auto& x) { return x; }, [=](const auto& t) { return -unit(t); }));
  sum += moves(qdot::torque_on_body([](const auto& x) { return qdot::euler_rotation_313(x[0], x[1], x[2]).transpose(); }, target));
  sum += moves(qdot::torque_on_body([](const auto& x) { return qdot::rotation_z(x[0]); }, [=](const auto& t) { return unit(t) / 2.0; }));
  sum += moves(qdot::non_inertial_frame(1.0, [](const auto& x) { return x; }, [=](const auto& t) { return 2.0 * unit(t); }, unit));
  sum += qdot::velocity_of([=](const auto& x) { return x + target; }, q, v)[0] > 0.0;
  return sum + (qdot::jacobian([=](const auto& x) { return x + x; }, q)(0, 0) > 0.0);
}
