// SPDX-License-Identifier: MIT
//
// Functors of effects whose time is a double, and a force that can be read in two ways.
// message: qdot: the functor of an effect takes the time as a double
// message: qdot: the force at a point can be called as F(t) and as F(position, velocity), and nothing tells which is meant
// message: qdot: the functors of a controller must be callable as f(q, qdot, z, t) for every scalar
// message: qdot: what depends on time must be callable as f(t) for every scalar
#include <qdot/effects/constraints.hpp>
#include <qdot/effects/scene_form.hpp>

int main() {
  const auto free = qdot::mechanical_system<2>([](const auto& qdot) { return 0.5 * qdot.dot(qdot); });
  const Eigen::Vector2d q(0.1, 0.2), v(0.3, 0.4);
  const auto moves = [&](const auto& effect) { return acceleration(scene(free, effect), q, v)[0] > 0.0 ? 1 : 0; };
  const int moved = moves(qdot::holonomic("guide", [](const auto& x, double t = 0.0) { return x[0] - t; })) +
                    moves(qdot::force_at_point([](const auto& x) { return x; }, [](const auto&...) { return Eigen::Vector2d(0.0, 1.0); })) +
                    moves(qdot::prescribed<0>("drive", [](double t) { return t; }));
  const auto controller = qdot::controller([](const auto& x, const auto&, const auto&, double) { return x; },
                                           [](const auto&, const auto&, const auto& z, const auto&) { return z; }, qdot::Vector<double, 1>(0.0));
  Eigen::MatrixXd J(5, 5);
  first_order_form(scene(free, controller)).jacobian(0.0, Eigen::VectorXd::Zero(5), J);
  return moved;
}
