// SPDX-License-Identifier: MIT
#include "catch2_bridge.hpp"

#include <cmath>
#include <random>
#include <vector>

#include "qdot/ad/derivatives.hpp"
#include "qdot/mechanics/rigid_body.hpp"

using namespace qdot;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// Relative to energies of order 10.
constexpr double rounding = 1e-12;

Vector3d random_vector(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const double x = uniform(random), y = uniform(random), z = uniform(random);
  return {x, y, z};
}

std::vector<PointMass> random_points(std::mt19937& random, int count) {
  std::uniform_real_distribution<double> mass(0.1, 2.0);
  std::vector<PointMass> points;
  for (int i = 0; i < count; ++i) {
    const double m = mass(random);
    points.push_back({m, random_vector(random)});
  }
  return points;
}

// Σ ½ m |v_A + ω × AP|², the definition.
double kinetic_energy_of_points(const std::vector<PointMass>& points, const Vector3d& A, const Vector3d& v_A, const Vector3d& omega) {
  double T = 0.0;
  for (const PointMass& point : points) T += 0.5 * point.mass * (v_A + omega.cross(point.position - A)).squaredNorm();
  return T;
}

// A tumbling, travelling body in six coordinates: the reference point and the Euler angles 3-1-3.
const auto position = [](const auto& q) { return q.template head<3>().eval(); };
const auto rotation = [](const auto& q) { return euler_rotation_313(q[3], q[4], q[5]); };

}  // namespace

TEST_CASE("about A, about G and over the points, the kinetic energy is the same") {
  std::mt19937 random(5);
  for (int sample = 0; sample < 200; ++sample) {
    const auto points = random_points(random, 6);
    const Vector3d A = 2.0 * random_vector(random), v_A = 3.0 * random_vector(random), omega = 3.0 * random_vector(random);
    const double M = total_mass(points);
    const Vector3d G = centre_of_mass(points), AG = G - A;
    const Vector3d v_G = v_A + omega.cross(AG);
    const double about_A = kinetic_energy_about_point(M, AG, inertia_of_points(points, A), v_A, omega);
    const double about_G = kinetic_energy_about_centre(M, inertia_of_points(points, G), v_G, omega);
    const double definition = kinetic_energy_of_points(points, A, v_A, omega);
    CHECK_THAT(about_A, WithinAbs(definition, rounding * (1.0 + definition)));
    CHECK_THAT(about_G, WithinAbs(definition, rounding * (1.0 + definition)));
  }
}

TEST_CASE("the worked body has T = 37.375; the two usual mistakes give 25.875 and 14.375") {
  const std::vector<PointMass> points = {{1.0, {1.0, 0.0, 0.0}}, {2.0, {0.0, 2.0, 0.0}}, {3.0, {0.0, 0.0, 1.0}}};
  const Vector3d A = Vector3d::Zero(), v_A(1.0, -1.0, 2.0), omega(0.5, 1.0, -1.0);
  const double M = total_mass(points);
  const Vector3d AG = centre_of_mass(points);
  const Matrix3d I_A = inertia_of_points(points, A);
  CHECK_THAT(kinetic_energy_about_point(M, AG, I_A, v_A, omega), WithinAbs(37.375, rounding));
  CHECK_THAT(kinetic_energy_of_points(points, A, v_A, omega), WithinAbs(37.375, rounding));
  const Vector3d v_G = v_A + omega.cross(AG);
  CHECK_THAT(0.5 * M * v_G.squaredNorm(), WithinAbs(34.1875, rounding));
  CHECK_THAT(kinetic_energy_about_centre(M, inertia_at_centre(I_A, M, AG), v_G, omega), WithinAbs(37.375, rounding));
  // the middle term forgotten, and with AG × ω in place of ω × AG
  CHECK_THAT(kinetic_energy_about_point(M, Vector3d::Zero().eval(), I_A, v_A, omega), WithinAbs(25.875, rounding));
  CHECK_THAT(kinetic_energy_about_point(M, (-AG).eval(), I_A, v_A, omega), WithinAbs(14.375, rounding));
}

TEST_CASE("a rod on a pivot has ½ I_O φ̇² whichever of its points is taken as A") {
  const double M = 2.0, L = 1.5, phi = 0.4, phidot = 1.7;
  const double I_G = inertia::thin_rod(M, L)(2, 2), I_O = inertia::thin_rod_about_end(M, L)(2, 2);
  const Vector<double, 2> along(std::cos(phi), std::sin(phi)), across(-std::sin(phi), std::cos(phi));
  for (const double a : {0.0, 0.3, 0.75, 1.5, -2.0}) {
    const Vector<double, 2> AG = (0.5 * L - a) * along, v_A = a * phidot * across;
    const double I_A = I_G + M * (0.5 * L - a) * (0.5 * L - a);
    CHECK_THAT(planar_kinetic_energy(M, AG, I_A, v_A, phidot), WithinAbs(0.5 * I_O * phidot * phidot, rounding));
  }
}

TEST_CASE("the planar formula is the spatial one with ω along z") {
  const Vector<double, 2> AG(0.3, -0.7), v_A(1.1, 0.4);
  const Matrix3d I_A = Vector3d(2.0, 2.5, 1.9).asDiagonal();
  const double spatial = kinetic_energy_about_point(1.3, Vector3d(0.3, -0.7, 0.0), I_A, Vector3d(1.1, 0.4, 0.0), Vector3d(0.0, 0.0, -2.2));
  CHECK_THAT(planar_kinetic_energy(1.3, AG, 1.9, v_A, -2.2), WithinAbs(spatial, rounding));
}

TEST_CASE("from R(q) and r_A(q) alone, T is that of the moving points") {
  std::mt19937 random(6);
  for (int sample = 0; sample < 50; ++sample) {
    const auto points = random_points(random, 5);
    Vector<double, 6> q, qdot;
    q << random_vector(random), 3.0 * random_vector(random);
    qdot << random_vector(random), 3.0 * random_vector(random);
    double definition = 0.0;
    for (const PointMass& point : points) {
      const auto path = [&](const auto& x) { return (position(x) + rotation(x) * point.position).eval(); };
      definition += 0.5 * point.mass * velocity_of(path, q, qdot).squaredNorm();
    }
    const RigidBody body = body_of_points(points);
    CHECK_THAT(kinetic_energy_of_body(body, rotation, position, q, qdot), WithinAbs(definition, rounding * (1.0 + definition)));
    // the same body seen from another of its points
    const Vector3d AB = random_vector(random);
    const auto shifted = [&](const auto& x) { return (position(x) + rotation(x) * AB).eval(); };
    CHECK_THAT(kinetic_energy_of_body(seen_from(body, AB), rotation, shifted, q, qdot), WithinAbs(definition, rounding * (1.0 + definition)));
  }
}

TEST_CASE("T of a symmetric top comes out as in the books, with its mass matrix") {
  const double A = 1.0, C = 0.6;
  const RigidBody top = body_about_centre(1.0, Vector3d(A, A, C).asDiagonal());
  const auto fixed = [](const auto& q) { return (0.0 * q).eval(); };
  const auto turn = [](const auto& q) { return euler_rotation_313(q[0], q[1], q[2]); };
  const Vector3d q(0.4, 0.5, -0.9), qdot(0.7, -0.2, 3.0);
  const double s = std::sin(q[1]), c = std::cos(q[1]), spin = qdot[2] + qdot[0] * c;
  const double book = 0.5 * A * (qdot[1] * qdot[1] + s * s * qdot[0] * qdot[0]) + 0.5 * C * spin * spin;
  CHECK_THAT(kinetic_energy_of_body(top, turn, fixed, q, qdot), WithinAbs(book, rounding));
  Matrix3d M;
  M << A * s * s + C * c * c, 0.0, C * c, 0.0, A, 0.0, C * c, 0.0, C;
  const auto T = [&](const auto& w) { return kinetic_energy_of_body(top, turn, fixed, q, w); };
  CHECK((hessian(T, qdot) - M).cwiseAbs().maxCoeff() < rounding);
}

TEST_CASE("parts that are fixed to each other add up to the cloud of all their points") {
  std::mt19937 random(7);
  const auto first = random_points(random, 4), second = random_points(random, 5);
  const Matrix3d R = euler_rotation_313(0.4, 1.1, 2.0);
  const Vector3d at(0.3, -1.2, 0.8);
  std::vector<PointMass> all = first;
  for (const PointMass& point : second) all.push_back({point.mass, at + R * point.position});
  const RigidBody expected = body_of_points(all);
  const RigidBody body = compound({body_of_points(first), mounted(body_of_points(second), at, R)});
  CHECK_THAT(body.mass, WithinAbs(expected.mass, rounding));
  CHECK((body.centre - expected.centre).norm() < rounding);
  CHECK((body.inertia - expected.inertia).cwiseAbs().maxCoeff() < rounding);
}

TEST_CASE("a pendulum of two rods and a disk has the moment of inertia of the textbook sum") {
  // rod 1 from the pivot along x, rod 2 across its end, disk at the end
  const RigidBody rod = body_about_centre(2.0, inertia::thin_rod(2.0, 1.5));
  const RigidBody disk = body_about_centre(3.0, inertia::disk(3.0, 0.2));
  const RigidBody pendulum = compound({mounted(rod, Vector3d(0.75, 0.0, 0.0)),
                                       mounted(rod, Vector3d(1.5, 0.0, 0.0), rotation_z(std::acos(0.0))),
                                       mounted(disk, Vector3d(1.5, 0.0, 0.0))});
  const double expected = 2.0 * 1.5 * 1.5 / 3.0 + (2.0 * 1.5 * 1.5 / 12.0 + 2.0 * 2.25) + (0.5 * 3.0 * 0.04 + 3.0 * 2.25);
  CHECK_THAT(pendulum.inertia(2, 2), WithinAbs(expected, rounding));
  CHECK_THAT(pendulum.centre[0], WithinAbs((2.0 * 0.75 + 2.0 * 1.5 + 3.0 * 1.5) / 7.0, rounding));
}

TEST_CASE("a body without mass or with an impossible tensor is refused") {
  CHECK_THROWS_WITH(body_about_centre(0.0, Matrix3d::Identity()),
                    "rigid body: the mass must be finite and positive, but it is 0; leave a massless body out of T");
  CHECK_THROWS_AS(body_about_centre(1.0, Vector3d(1.0, 1.0, 5.0).asDiagonal()), InvalidValue);
  CHECK_THROWS_AS(compound({}), InvalidValue);
}
