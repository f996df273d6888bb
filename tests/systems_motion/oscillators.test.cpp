// SPDX-License-Identifier: MIT
#include "motion.hpp"
#include "scenes/bead_on_hoop.hpp"
#include "scenes/duffing.hpp"
#include "scenes/morse.hpp"
#include "scenes/projectile.hpp"

using namespace qdot;
using motion::run;
using std::numbers::pi;

namespace {

// Global error of a few hundred steps at rtol 1e-13.
constexpr double accurate = 1e-10;
using V1 = Vector<double, 1>;

}  // namespace

TEST_CASE("a thrown point follows the parabola") {
  const auto system = mechanical_system<3>(scenes::Projectile{});
  const State<3> start{0.0, {1.0, 2.0, 3.0}, {10.0, 4.0, 14.0}};
  const auto flight = run(system, start, 2.8);
  for (const double t : {0.3, 1.1, 2.8}) {
    const Eigen::Vector3d parabola = start.q + t * start.qdot - Eigen::Vector3d(0.0, 0.0, 0.5 * 9.81 * t * t);
    CHECK((flight.trajectory.at(t).q - parabola).norm() < 1e-12);
  }
}

TEST_CASE("Duffing's oscillator returns after 4 K / sqrt(1 + beta A^2) and reaches its reference states") {
  const auto system = mechanical_system<1>(scenes::Duffing{.m = 1.0, .alpha = 1.0, .beta = 1.0});
  const double period = 4.0 * motion::elliptic_K(0.25) / std::sqrt(2.0);
  CHECK_THAT(period, WithinAbs(4.76802202910246, 1e-13));
  const State<1> end = run(system, State<1>{0.0, V1(1.0), V1(0.0)}, period).state();
  CHECK_THAT(end.q[0], WithinAbs(1.0, accurate));
  CHECK_THAT(end.qdot[0], WithinAbs(0.0, accurate));
  const auto kicked = run(system, State<1>{0.0, V1(0.0), V1(1.0)}, 10.0);
  CHECK_THAT(kicked.trajectory.at(1.0).q[0], WithinAbs(0.8043583575404616, accurate));
  CHECK_THAT(kicked.state().q[0], WithinAbs(-0.12300031309744051, accurate));
}

TEST_CASE("a purely quartic potential has its period and its state, started where all its derivatives vanish") {
  using std::pow;
  const auto system = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                           [](const auto& q) { return 0.25 * pow(q[0], 4); });
  const double period = std::pow(std::tgamma(0.25), 2) / std::sqrt(pi);
  CHECK_THAT(period, WithinAbs(7.41629870920549, 1e-13));
  CHECK_THAT(run(system, State<1>{0.0, V1(1.0), V1(0.0)}, period).state().qdot[0], WithinAbs(0.0, accurate));
  CHECK_THAT(run(system, State<1>{0.0, V1(0.0), V1(1.0)}, 10.0).state().q[0], WithinAbs(-0.6399287095352512, accurate));
}

TEST_CASE("Morse's molecule at half its dissociation energy swings in 2 pi") {
  const auto system = mechanical_system<1>(scenes::Morse{.m = 1.0, .D = 1.0, .a = 1.0});
  const State<1> end = run(system, State<1>{0.0, V1(0.0), V1(1.0)}, 2.0 * pi).state();  // ½ v² = ½ D
  CHECK_THAT(end.q[0], WithinAbs(0.0, accurate));
  CHECK_THAT(end.qdot[0], WithinAbs(1.0, accurate));
}

TEST_CASE("the oscillator of Mathews and Lakshmanan is a cosine although its mass depends on where it is") {
  const double lambda = 0.5;
  const auto system = mechanical_system<1>(
      [=](const auto& q, const auto& v) { return 0.5 * v[0] * v[0] / (1.0 + lambda * q[0] * q[0]); },
      [=](const auto& q) { return 0.5 * q[0] * q[0] / (1.0 + lambda * q[0] * q[0]); });
  CHECK_THAT(run(system, State<1>{0.0, V1(2.0), V1(0.0)}, 5.0).state().q[0], WithinAbs(-1.93540662584544, accurate));
}

TEST_CASE("a kinetic energy of fourth order in the velocity has the period of the quadrature") {
  const auto system = mechanical_system<1>(
      [](const auto& v) {
        const auto square = v[0] * v[0];
        return 0.5 * square + 0.25 * square * square;
      },
      [](const auto& q) { return 0.5 * q[0] * q[0]; });
  const State<1> start{0.0, V1(1.0), V1(0.0)};
  const State<1> end = run(system, start, 7.55021823835396).state();
  CHECK_THAT(end.qdot[0], WithinAbs(0.0, accurate));
  CHECK_THAT(jacobi_energy(system, end), WithinAbs(0.5, accurate));
}

TEST_CASE("on the turning hoop Jacobi's energy stays while T + V does not") {
  const auto system = mechanical_system<1>(scenes::BeadOnHoop{});
  const State<1> start{0.0, V1(0.3), V1(0.0)};
  const auto swing = run(system, start, 10.0);
  double jacobi_drift = 0.0, energy_change = 0.0;
  for (const State<1>& state : swing.trajectory.sampled(50)) {
    jacobi_drift = std::max(jacobi_drift, std::abs(jacobi_energy(system, state) - jacobi_energy(system, start)));
    energy_change = std::max(energy_change, std::abs(energy(system, state) - energy(system, start)));
  }
  CHECK(jacobi_drift < 1e-9);
  CHECK(energy_change > 1.0);
}
