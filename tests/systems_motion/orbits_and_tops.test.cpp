// SPDX-License-Identifier: MIT
#include "motion.hpp"
#include "qdot/mechanics/rigid_body.hpp"
#include "scenes/charged_particle.hpp"
#include "scenes/heavy_top.hpp"
#include "scenes/kepler.hpp"
#include "scenes/spherical_pendulum.hpp"

using namespace qdot;
using Eigen::Vector2d;
using Eigen::Vector3d;
using motion::run;
using std::numbers::pi;

namespace {

// Global error of a few hundred steps at rtol 1e-13.
constexpr double accurate = 1e-10;
// Where a close passage amplifies it, or the zero of an interpolated velocity is asked for.
constexpr double grown = 1e-8;
// Of Adams' method over an eccentric turn: 0.5e-10 to 2e-10, as rounding and tolerances a few per cent off let its steps fall.
constexpr double turned = 5e-10;

State<2> perihelion(double e) { return {0.0, {1.0 - e, 0.0}, {0.0, std::sqrt((1.0 + e) / (1.0 - e))}}; }

// The angle from one least distance to the next in V(r), in polar coordinates.
template <class Potential>
double perihelion_to_perihelion(const Potential& V, double r, double phidot, double t_low, double t_high) {
  const auto system = mechanical_system<2>(
      [](const auto& q, const auto& v) { return 0.5 * (v[0] * v[0] + q[0] * q[0] * v[1] * v[1]); }, V);
  const auto orbit = run(system, State<2>{0.0, {r, 0.0}, {0.0, phidot}}, t_high);
  const double t = motion::zero_of(orbit.trajectory, 2, t_low, t_high);
  return orbit.trajectory.at(t).q[1];
}

}  // namespace

TEST_CASE("Kepler's ellipse closes after its period, with energy, momentum and the Runge-Lenz vector") {
  const auto system = mechanical_system<2>(scenes::Kepler{});
  for (const double e : {0.0, 0.3, 0.6, 0.9}) {
    const State<2> start = perihelion(e);
    const State<2> end = run(system, start, 2.0 * pi).state();
    CHECK((end.q - start.q).norm() < grown);
    CHECK_THAT(energy(system, end), WithinAbs(-0.5, accurate));
    const double momentum = end.q[0] * end.qdot[1] - end.q[1] * end.qdot[0];
    CHECK_THAT(momentum, WithinAbs(std::sqrt(1.0 - e * e), accurate));
    const Vector2d lenz = momentum * Vector2d(end.qdot[1], -end.qdot[0]) - end.q / end.q.norm();
    CHECK_THAT(lenz.norm(), WithinAbs(e, accurate));
  }
  const State<2> end = run(system, perihelion(0.6), 2.0 * pi).state();
  CHECK((end.q - Vector2d(0.4, 0.0)).norm() < turned);
}

TEST_CASE("an inverse-square addition makes the perihelion turn by the closed form") {
  const double h = 0.05, l = 0.8, r = 0.4;
  const auto V = [=](const auto& q) { return -1.0 / q[0] + h / (q[0] * q[0]); };
  CHECK_THAT(2.0 * pi / std::sqrt(1.0 + 2.0 * h / (l * l)), WithinAbs(5.84324364599589, 1e-13));
  // radial period 2π (−2E)^{-3/2} with E = ½ ℓ²/r² − 1/r + h/r²
  const double E = 0.5 * l * l / (r * r) - 1.0 / r + h / (r * r);
  const double period = 2.0 * pi * std::pow(-2.0 * E, -1.5);
  CHECK_THAT(perihelion_to_perihelion(V, r, l / (r * r), 0.7 * period, 1.2 * period), WithinAbs(5.84324364599589, grown));
}

TEST_CASE("an inverse-cube addition advances the perihelion by the quadrature's amount") {
  const double beta = 1e-3, r = 0.7, l = std::sqrt(0.91);
  const auto V = [=](const auto& q) { return -1.0 / q[0] - beta / (q[0] * q[0] * q[0]); };
  const double angle = perihelion_to_perihelion(V, r, l / (r * r), 4.5, 7.5);
  CHECK_THAT(angle - 2.0 * pi, WithinAbs(0.0229739096667, grown));
}

TEST_CASE("a charge in a magnetic field circles, and drifts across a constant electric one") {
  const auto field = [](double E) { return mechanical_system<2>(scenes::ChargedParticle{.m = 1.0, .e = 1.0, .B = 2.0, .E = E, .omega = 0.0}); };
  const State<2> start{0.0, {0.3, -0.2}, {0.7, 0.4}};
  const State<2> circle = run(field(0.0), start, pi).state();
  CHECK((circle.q - start.q).norm() < accurate);
  const State<2> drift = run(field(0.3), State<2>{0.0, {0.0, 0.0}, {0.0, 0.0}}, 5.0 * pi).state();
  CHECK_THAT(drift.q[1], WithinAbs(-2.35619449019234, accurate));
}

TEST_CASE("the conical pendulum turns at Omega^2 = g/(l cos theta) and stays at its angle") {
  const auto system = mechanical_system<2>(scenes::SphericalPendulum{});
  const auto swing = run(system, State<2>{0.0, {0.7, 0.0}, {0.0, 3.58136501043758}}, 5.0);
  for (const State<2>& state : swing.trajectory.sampled(20)) {
    CHECK_THAT(state.q[0], WithinAbs(0.7, accurate));
    CHECK_THAT(state.q[1], WithinAbs(3.58136501043758 * state.t, accurate));
  }
}

TEST_CASE("a free symmetric top precesses at L/I1 and spins at (I1 - I3) omega3/I1, from R(q) alone") {
  const double I1 = 1.0, I3 = 0.6, spin = 3.0, theta = 0.5;
  const RigidBody body = body_about_centre(1.0, Vector3d(I1, I1, I3).asDiagonal());
  const auto system = mechanical_system<3>([=](const auto& q, const auto& v) {
    const auto rotation = [](const auto& x) { return euler_rotation_313(x[0], x[1], x[2]); };
    const auto fixed = [](const auto& x) { return (0.0 * x).eval(); };
    return kinetic_energy_of_body(body, rotation, fixed, q, v);
  });
  const double precession = I3 * spin / (I1 * std::cos(theta)), own = (I1 - I3) * spin / I1;
  CHECK_THAT(precession, WithinAbs(2.051089069184188, 1e-14));
  const State<3> end = run(system, State<3>{0.0, {0.0, theta, 0.0}, {precession, 0.0, own}}, 4.0).state();
  CHECK((end.q - Vector3d(4.0 * precession, theta, 4.0 * own)).norm() < accurate);
}

TEST_CASE("a free asymmetric body keeps its angular momentum in space") {
  const Eigen::Matrix3d I = Vector3d(1.0, 2.0, 3.0).asDiagonal();
  const RigidBody body = body_about_centre(1.0, I);
  const auto rotation = [](const auto& x) { return euler_rotation_313(x[0], x[1], x[2]); };
  const auto system = mechanical_system<3>([=](const auto& q, const auto& v) {
    const auto fixed = [](const auto& x) { return (0.0 * x).eval(); };
    return kinetic_energy_of_body(body, rotation, fixed, q, v);
  });
  const auto momentum = [&](const State<3>& state) {
    return Vector3d(rotation(state.q) * (I * body_angular_velocity_of(rotation, state.q, state.qdot)));
  };
  const State<3> start{0.0, {0.2, 1.2, -0.4}, {0.7, 0.3, 1.1}};
  const auto tumble = run(system, start, 3.0);
  for (const State<3>& state : tumble.trajectory.sampled(20)) CHECK((momentum(state) - momentum(start)).norm() < grown);
  CHECK_THAT(energy(system, tumble.state()), WithinAbs(energy(system, start), accurate));
}

TEST_CASE("the heavy top precesses steadily at both roots of I1 Omega^2 cos theta - I3 omega3 Omega + mgl = 0") {
  const auto system = mechanical_system<3>(scenes::HeavyTop{.I1 = 1.0, .I3 = 0.7, .m = 1.0, .g = 10.0, .l = 0.2});
  for (const double Omega : {0.378226544589152, 6.40689201667982}) {
    const double psidot = 8.0 - Omega * std::cos(0.6);
    const State<3> end = run(system, State<3>{0.0, {0.6, 0.0, 0.0}, {0.0, Omega, psidot}}, 5.0).state();
    CHECK_THAT(end.q[0], WithinAbs(0.6, accurate));
    CHECK_THAT(end.q[1], WithinAbs(5.0 * Omega, grown));
    if (Omega < 1.0) CHECK_THAT(end.q[1], WithinAbs(1.89113272294576, accurate));
  }
}

TEST_CASE("a top let go at rest falls to the published angle, in the published time, and climbs back to its cusp") {
  const auto system = mechanical_system<3>(scenes::HeavyTop{.I1 = 1.0, .I3 = 0.7, .m = 1.0, .g = 10.0, .l = 0.2});
  const auto nutation = run(system, State<3>{0.0, {0.6, 0.0, 0.0}, {0.0, 0.0, 8.0}}, 2.0 * 0.62751961588484);
  CHECK_THAT(nutation.trajectory.at(0.62751961588484).q[0], WithinAbs(0.685273609932827, accurate));
  CHECK_THAT(nutation.state().q[0], WithinAbs(0.6, accurate));
  CHECK_THAT(nutation.state().q[1], WithinAbs(0.4728853017453, accurate));
}
