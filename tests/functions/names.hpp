// SPDX-License-Identifier: MIT
//
// What the lines of docs/reference/functions.md speak of.
#pragma once
#include <cmath>
#include <cstddef>
#include <type_traits>

#include <qdot/analysis/parameter_fit.hpp>
#include <qdot/qdot.hpp>

namespace of_the_page {

using namespace qdot;

template <class S>
struct EnergiesOf {
  S m = 1.0, g = 9.81;
  auto T(const auto& q, const auto& qdot) const {
    using std::cos;
    return 0.5 * m * (2.0 * qdot[0] * qdot[0] + qdot[1] * qdot[1] + 2.0 * qdot[0] * qdot[1] * cos(q[0] - q[1]));
  }
  auto V(const auto& q) const {
    using std::cos;
    return -m * g * (2.0 * cos(q[0]) + cos(q[1]));
  }
};
using Energies = EnergiesOf<double>;

inline const auto T = [](const auto& q, const auto& qdot) { return Energies{}.T(q, qdot); };
inline const auto V = [](const auto& q) { return Energies{}.V(q); };
inline const auto system = mechanical_system<2>(Energies{});
inline const auto free = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return 0.5 * q[1] * q[1]; });
inline const Vector<double, 2> q(0.1, 0.2), v(0.3, 0.4);
inline const State<2> start{.t = 0.0, .q = {0.1, 0.2}, .qdot = {0.0, 0.0}};
inline const auto phi = [](const auto& q) { return q[0] - q[1]; };
inline const auto phis = [](const auto& q) { return vector(q[0] - q[1]); };
inline const auto rod = holonomic("rod", phi);
inline const auto damping = viscous_damping(Vector<double, 2>(0.1, 0.1));
inline const auto motor = input("motor", 0);
inline const auto plant = scene(system, damping);
inline const auto of = [](const auto& p) { return EnergiesOf<std::remove_cvref_t<decltype(p[0])>>{p[0], p[1]}; };
inline const Vector<double, 2> p(1.0, 9.81);
inline const auto wall = event("wall", [](const auto& q) { return q[0]; });
inline const Options options{.rtol = 1e-9};
inline const Dop853 method;
inline const auto place_of_tip = [](const auto& q) { return vector(q[0] * q[1], q[1]); };
inline const auto place = [](const auto& q, auto& bodies) { bodies.point_mass(1.0, vector(q[0], q[1])); };
inline const auto rows_of = [](const auto& x) { return vector(x[0], x[1], x[2]); };
inline const Eigen::Vector3d q3(0.1, 0.2, 0.3), v3(1.0, 0.0, 0.0), omega3(0.0, 0.0, 1.0);
inline const Eigen::Matrix3d R3 = Eigen::Matrix3d::Identity();
inline const RigidBody body{1.0, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity()};
inline const Eigen::MatrixXd Q4 = Eigen::MatrixXd::Identity(4, 4), R1 = Eigen::MatrixXd::Identity(1, 1);
inline const Eigen::Matrix<double, 2, Eigen::Dynamic> Qs = Eigen::Matrix<double, 2, Eigen::Dynamic>::Zero(2, 8), Qdots = Qs;
inline const Experiment<2> film{.start = start, .times = {1.0}, .measured = Eigen::MatrixXd::Zero(2, 1)};

}  // namespace of_the_page
