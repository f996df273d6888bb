// SPDX-License-Identifier: MIT
#include "motion.hpp"
#include "scenes/cycloid.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/pendulum.hpp"
#include "scenes/rod_and_ring.hpp"

using namespace qdot;
using motion::run;
using std::numbers::pi;

namespace {

// Global error of a few hundred steps at rtol 1e-13.
constexpr double accurate = 1e-10;
// The same after the errors have grown: over many swings, or in an unstable motion.
constexpr double grown = 1e-8;

using V1 = Vector<double, 1>;
using Eigen::Vector2d;

}  // namespace

TEST_CASE("the pendulum's period is 4 sqrt(l/g) K(sin^2 theta0/2) at every amplitude") {
  const scenes::Pendulum pendulum{};
  const auto system = mechanical_system<1>(pendulum);
  const double published[][2] = {{0.1, 2.00732119117530}, {1.0, 2.13913760055869}, {pi / 2.0, 2.36784194757624},
                                 {2.5, 3.29593224651612}, {3.1, 6.71730714993764}};
  for (const auto& [amplitude, digits] : published) {
    const double half = std::sin(0.5 * amplitude);
    const double period = 4.0 * std::sqrt(pendulum.l / pendulum.g) * motion::elliptic_K(half * half);
    CHECK_THAT(period, WithinAbs(digits, 1e-13));
    // One period on, the bob passes its turning point θ̇ = 0 again; what is left of θ̇ is the error in time. Near the top the bob hardly accelerates there, and
    // the same error of the velocity is 1 / sin θ₀ times as much of time.
    const State<1> end = run(system, State<1>{0.0, V1(amplitude), V1(0.0)}, period).state();
    const double acceleration_there = -pendulum.g / pendulum.l * std::sin(amplitude);
    CHECK_THAT(end.qdot[0] / acceleration_there / period, WithinAbs(0.0, accurate / std::sin(amplitude)));
    CHECK_THAT(end.q[0], WithinAbs(amplitude, accurate));
  }
}

TEST_CASE("the pendulum is where the reference says after ten seconds, and back where it was when run backward") {
  const auto system = mechanical_system<1>(scenes::Pendulum{});
  const State<1> end = run(system, State<1>{0.0, V1(1.0), V1(0.0)}, 10.0).state();
  CHECK_THAT(end.q[0], WithinAbs(-0.46325276873178667, accurate));
  CHECK_THAT(end.qdot[0], WithinAbs(2.6365495135496304, accurate));
  const State<1> start = run(system, end, 0.0).state();
  CHECK_THAT(start.q[0], WithinAbs(1.0, accurate));
  CHECK_THAT(start.qdot[0], WithinAbs(0.0, accurate));
}

TEST_CASE("a pendulum that goes over the top turns once in its period") {
  const auto system = mechanical_system<1>(scenes::Pendulum{});
  const State<1> end = run(system, State<1>{0.0, V1(0.0), V1(8.0)}, 0.98200325731125).state();
  CHECK_THAT(end.q[0], WithinAbs(2.0 * pi, accurate));
}

TEST_CASE("on the separatrix theta = 4 atan(e^(omega t)) - pi") {
  const auto system = mechanical_system<1>(scenes::Pendulum{});
  const State<1> end = run(system, State<1>{0.0, V1(0.0), V1(6.26418390534633)}, 1.0).state();
  CHECK_THAT(end.q[0], WithinAbs(2.96719748848843, grown));
}

TEST_CASE("released at rest from the horizontal the pendulum does not stall") {
  const State<1> end = run(mechanical_system<1>(scenes::Pendulum{}), State<1>{0.0, V1(pi / 2.0), V1(0.0)}, 3.0).state();
  CHECK_THAT(end.q[0], WithinAbs(-0.17758369830429, accurate));
  CHECK_THAT(end.qdot[0], WithinAbs(-4.39447884271360, accurate));
}

TEST_CASE("the double pendulum reaches its reference states") {
  const auto system = mechanical_system<2>(scenes::DoublePendulum{});
  const State<2> start{0.0, {1.7, 1.7}, {0.0, 0.0}};
  const auto swing = run(system, start, 3.0);
  CHECK((swing.state().q - Vector2d(1.9234881444441958, 1.1485248782344042)).norm() < grown);
  CHECK((swing.state().qdot - Vector2d(1.1168305154489508, -0.3371732877010639)).norm() < grown);
  CHECK_THAT(energy(system, swing.state()), WithinAbs(energy(system, start), accurate));
  const State<2> late = run(system, State<2>{0.0, {0.5, 0.8}, {0.0, 0.0}}, 100.0).state();
  CHECK((late.q - Vector2d(-0.08656088388521, -0.29921408044417)).norm() < grown);
  CHECK((late.qdot - Vector2d(-0.97625401259079, -2.00210027377311)).norm() < grown);
}

TEST_CASE("the rod with the sliding ring reaches the quadruple-precision states") {
  const auto system = mechanical_system<2>(scenes::RodAndRing{.M = 2.0, .L = 1.5, .m = 0.3, .g = 9.81});
  const State<2> start{0.0, {0.4, 0.2}, {0.1, 1.0}};
  CHECK_THAT(energy(system, start), WithinAbs(3.93279273886127, 1e-13));
  const auto fall = run(system, start, 1.0);
  const State<2> half = fall.trajectory.at(0.5), end = fall.state();
  CHECK((half.q - Vector2d(0.33694879608495, -0.55754350895470)).norm() < accurate);
  CHECK((half.qdot - Vector2d(0.66116092170779, -3.98451683987792)).norm() < grown);  // the dense output's derivative part
  CHECK((end.q - Vector2d(3.2329996316785996, -2.3493856325149203)).norm() < accurate);
  CHECK((end.qdot - Vector2d(11.033246474122167, -1.12282143766159)).norm() < accurate);
  CHECK_THAT(energy(system, end), WithinAbs(3.93279273886127, accurate));
  // The ring reaches the end of the rod: r(t*) = L, by bisection on the dense output.
  double before = 0.5, after = 1.0;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (before + after);
    (fall.trajectory.at(middle).q[0] < 1.5 ? before : after) = middle;
  }
  CHECK_THAT(before, WithinAbs(0.81964017507556, accurate));
  CHECK_THAT(fall.trajectory.at(before).q[1], WithinAbs(-1.95561092528198, grown));
}

TEST_CASE("without gravity the rod and the ring keep their angular momentum") {
  const auto system = mechanical_system<2>(scenes::RodAndRing{.M = 2.0, .L = 1.5, .m = 0.3, .g = 0.0});
  const State<2> start{0.0, {0.4, 0.2}, {0.1, 1.0}};
  const State<2> end = run(system, start, 0.5).state();
  CHECK((end.q - Vector2d(0.50270133630812, 0.69649944203575)).norm() < accurate);
  CHECK_THAT(conjugate_momenta(system, end)[1], WithinAbs(1.548, accurate));
}

TEST_CASE("a ring on a rod that a motor turns follows the closed form") {
  // φ = ω t: L = ½ m (ṙ² + r² ω²) − m g r sin ωt
  const double m = 0.3, g = 9.81, omega = 3.0;
  const auto system = mechanical_system<1>(
      [=](const auto& q, const auto& v) { return 0.5 * m * (v[0] * v[0] + omega * omega * q[0] * q[0]); },
      [=](const auto& q, const auto& t) {
        using std::sin;
        return m * g * q[0] * sin(omega * t);
      });
  const State<1> end = run(system, State<1>{0.0, V1(0.4), V1(0.1)}, 1.0).state();
  CHECK_THAT(end.q[0], WithinAbs(-1.02183746846877, accurate));
}

TEST_CASE("on the cycloid every swing takes 4 pi sqrt(R/g)") {
  const auto system = mechanical_system<1>(scenes::Cycloid{.m = 1.0, .R = 0.5, .g = 9.81});
  for (const double amplitude : {0.1, 1.0, 2.5}) {
    const State<1> end = run(system, State<1>{0.0, V1(amplitude), V1(0.0)}, 2.83700670688578).state();
    CHECK_THAT(end.q[0], WithinAbs(amplitude, accurate));
    CHECK_THAT(end.qdot[0], WithinAbs(0.0, grown));
  }
}
