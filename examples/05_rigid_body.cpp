// SPDX-License-Identifier: MIT
//
// Kinetic energy of a rigid body about its centre of mass and about any other of its points, and a tumbling box whose angular
// velocity follows from its rotation.

#include <cstdio>
#include <vector>

#include <qdot/mechanics/rigid_body.hpp>
#include <qdot/qdot.hpp>

using namespace qdot;
using Eigen::Matrix3d;
using Eigen::Vector3d;

int main() {
  // Three masses that are one rigid body; A is the origin.
  const std::vector<PointMass> points = {{1.0, {1, 0, 0}}, {2.0, {0, 2, 0}}, {3.0, {0, 0, 1}}};
  const double M = total_mass(points);
  const Vector3d A(0, 0, 0), AG = centre_of_mass(points) - A;
  const Matrix3d I_A = inertia_of_points(points, A);
  std::printf("I_A = diag(%g, %g, %g), M AG = (%g, %g, %g)\n\n", I_A(0, 0), I_A(1, 1), I_A(2, 2), M * AG[0], M * AG[1], M * AG[2]);

  const Vector3d v_A(1, -1, 2), omega(0.5, 1, -1);
  const double first = 0.5 * M * v_A.squaredNorm(), third = 0.5 * omega.dot(I_A * omega);
  const double T = kinetic_energy_about_point(M, AG, I_A, v_A, omega);
  std::printf("about A:  1/2 M vA.vA             %8.4f\n", first);
  std::printf("          M vA.(omega x AG)       %8.4f\n", T - first - third);
  std::printf("          1/2 omega.I_A omega     %8.4f\n", third);
  std::printf("          T                       %8.4f\n", T);

  const Vector3d v_G = v_A + skew(omega) * AG;
  std::printf("about G:  T (Koenig)              %8.4f\n", kinetic_energy_about_centre(M, inertia_at_centre(I_A, M, AG), v_G, omega));
  double sum = 0.0;
  for (const PointMass& point : points) sum += 0.5 * point.mass * (v_A + skew(omega) * (point.position - A)).squaredNorm();
  std::printf("points:   sum of 1/2 m v.v        %8.4f\n\n", sum);

  // A box held at one corner, in Euler angles 3-1-3: R(q) is all that is written.
  const RigidBody box = body_about_centre(2.0, inertia::box(2.0, 0.3, 0.2, 0.1));
  const RigidBody held = seen_from(box, Vector3d(-0.15, -0.10, -0.05));  // AB: from G to the corner
  const auto rotation = [](const auto& q) { return euler_rotation_313(q[0], q[1], q[2]); };
  const auto corner = [](const auto& q) { return (0.0 * q).eval(); };
  const auto T_box = [=](const auto& q, const auto& qdot) { return kinetic_energy_of_body(held, rotation, corner, q, qdot); };
  const auto V_box = [=](const auto& q) { return 2.0 * 9.81 * (rotation(q) * held.centre)[2]; };
  const auto system = mechanical_system<3>(T_box, V_box).with_names({"phi", "theta", "psi"});
  const Vector3d q(0.3, 1.1, -0.6), qdot(0.4, -0.2, 5.0);
  const Vector3d qddot = acceleration(system, q, qdot);
  const Vector3d Omega = body_angular_velocity_of(rotation, q, qdot);
  std::printf("box on its corner: body angular velocity (%.6f, %.6f, %.6f)\n", Omega[0], Omega[1], Omega[2]);
  std::printf("                   (phi'', theta'', psi'') = (%.6f, %.6f, %.6f)\n", qddot[0], qddot[1], qddot[2]);

  // Euler's equation about the corner, I dΩ/dt + Ω × I Ω = AG × weight in body axes; dΩ/dt by a dual number once more.
  const auto Omega_of = [&](const auto& y) {
    return body_angular_velocity_of(rotation, y.template head<3>(), y.template tail<3>());
  };
  Vector<double, 6> y, ydot;
  y << q, qdot;
  ydot << qdot, qddot;
  const Vector3d weight = rotation(q).transpose() * Vector3d(0, 0, -2.0 * 9.81);
  const Vector3d left = held.inertia * velocity_of(Omega_of, y, ydot) + skew(Omega) * (held.inertia * Omega);
  std::printf("Euler's equation holds to 1e-12: %s\n", (left - skew(held.centre) * weight).norm() < 1e-12 ? "yes" : "no");
}
