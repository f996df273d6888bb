// SPDX-License-Identifier: MIT
//
// The kinematic door, written out: against equations derived by hand, and against T and V of the same bodies by nested duals.
#include "../catch2_bridge.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "bench/hand_derived.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/mechanics/written_out_kinematics.hpp"
#include "systems/chain_by_loops.hpp"
#include "systems/solution_by_pivots.hpp"

using namespace qdot;

namespace {

// Rounding of both ways, times the condition of M.
constexpr double rounded = 1e-12;
constexpr double free_fall = 9.81;

// Largest relative difference of the derived q̈ from `other(q, qdot, t)` over random states.
template <int n, class E, class Other>
double difference(const System<E, n>& system, const Other& other, double low = -2.0, double high = 2.0) {
  REQUIRE(system.energies().has_closed_form());
  std::mt19937 random(5);
  std::uniform_real_distribution<double> position(low, high), velocity(-2.0, 2.0);
  double worst = 0.0;
  for (int sample = 0; sample < 20; ++sample) {
    Vector<double, n> q, v, a;
    for (int i = 0; i < n; ++i) {
      q[i] = position(random);
      v[i] = velocity(random);
    }
    const double t = position(random);
    const Vector<double, n> expected = other(q, v, t);
    if (!system.energies().acceleration_in_closed_form(q.data(), v.data(), t, a.data())) return HUGE_VAL;
    worst = std::max({worst, (a - expected).norm() / (1.0 + expected.norm()), (acceleration(system, q, v, t) - expected).norm() / (1.0 + expected.norm())});
  }
  return worst;
}

template <int n, class Hand>
auto by_hand(const Hand& hand) {
  return [hand](const Vector<double, n>& q, const Vector<double, n>& v, double) {
    Vector<double, n> a;
    hand(q.data(), v.data(), a.data());
    return a;
  };
}

// M q̈ = rhs of the kinematic door as it is.
template <class System>
auto by_duals(const System& system) {
  return [system](const auto& q, const auto& v, double t) {
    return solution_by_pivots(mass_matrix(system, q, v, t), rhs(system, q, v, t));
  };
}

struct Links {
  double m = 1.0, l = 1.0;
  template <class Q>
  constexpr void operator()(const Q& q, auto& bodies) const {
    using std::cos, std::sin;
    typename Q::Scalar x(0.0), y(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      x += l * sin(q[k]);
      y -= l * cos(q[k]);
      bodies.point_mass(m, vector(x, y));
    }
  }
};

TEST_CASE("a chain of masses placed by a loop accelerates as derived by hand") {
  CHECK(difference(written_out_kinematic_system<1>(Links{}, gravity_along<1>(-free_fall)), by_hand<1>(bench::short_chain_by_hand<1>)) < rounded);
  CHECK(difference(written_out_kinematic_system<3>(Links{}, gravity_along<1>(-free_fall)), by_hand<3>(bench::short_chain_by_hand<3>)) < rounded);
  CHECK(difference(written_out_kinematic_system<3>(Links{}, uniform_gravity(0.0, -free_fall)), by_hand<3>(bench::short_chain_by_hand<3>)) < rounded);
  CHECK(difference(written_out_kinematic_system<12>(Links{}, gravity_along<1>(-free_fall)),
                   [](const auto& q, const auto& v, double) { return Vector<double, 12>(chain_by_loops(q, v)); }) < 10 * rounded);
}

TEST_CASE("masses, lengths and the field are the object's") {
  const Links links{.m = 0.3, .l = 0.7};
  const auto written = written_out_kinematic_system<2>(links, uniform_gravity(1.1, -0.4));
  CHECK(difference(written, by_duals(kinematic_system<2>(links, uniform_gravity(1.1, -0.4)))) < rounded);
}

TEST_CASE("gravity along an axis is uniform gravity") {
  const Vector<double, 2> q{0.4, 1.1}, v{0.2, -0.3};
  CHECK(acceleration(kinematic_system<2>(Links{}, gravity_along<1>(-free_fall)), q, v) ==
        acceleration(kinematic_system<2>(Links{}, uniform_gravity(0.0, -free_fall)), q, v));
}

TEST_CASE("a rod with a sliding ring, placed while compiling, accelerates as derived by hand") {
  const double M = 2.0, L = 1.5, m = 0.3;
  const auto place = [=](const auto& q, auto& bodies) {
    using std::cos, std::sin;
    const auto along = vector(cos(q[1]), sin(q[1]));
    bodies.planar_body(M, M * L * L / 12.0, 0.5 * L * along, q[1]);
    bodies.point_mass(m, q[0] * along);
  };
  const auto system = written_out_kinematic_system<2>(place, gravity_along<1>(-free_fall));
  REQUIRE(system.energies().has_closed_form());
  double worst = 0.0;
  for (const double phi : {0.3, 0.7, 1.2}) {
    const Vector<double, 2> q{0.2 + phi, phi}, v{0.4, -1.0};
    Vector<double, 2> a, expected;
    bench::RodAndRingByHand{}(q.data(), v.data(), expected.data());
    REQUIRE(system.energies().acceleration_in_closed_form(q.data(), v.data(), 0.0, a.data()));
    worst = std::max(worst, (a - expected).norm());
  }
  CHECK(worst < 10 * rounded);
}

TEST_CASE("a pivot that is moved, a mass in space, a kinetic term and a potential of its own are in the derived equations") {
  const auto place = [](const auto& q, const auto& t, auto& bodies) {
    using std::cos, std::sin, std::sqrt, std::exp;
    const auto pivot = 0.3 * sin(2.0 * t);
    bodies.point_mass(0.8, vector(pivot + sin(q[0]) * cos(q[1]), exp(-0.2 * q[1]) * q[0], sqrt(1.5 + q[2] * q[2])));
    bodies.point_mass(0.4, vector(q[2], q[0] / (2.0 + q[1]), t * q[2]));
  };
  const auto V = [](const auto& q, const auto& t) { return 0.5 * (q[0] - 0.1 * t) * (q[0] - 0.1 * t) + q[1] * q[2]; };
  const auto extra = [](const auto& q, const auto& qdot) {
    return 0.5 * (qdot[0] * qdot[0] + 1.5 * qdot[1] * qdot[1] + qdot[2] * qdot[2]) + 0.7 * q[0] * qdot[1];
  };
  CHECK(difference(written_out_kinematic_system<3>(place, V, extra), by_duals(kinematic_system<3>(place, V, extra)), 0.1, 0.9) < rounded);
}

TEST_CASE("a written-out chain moves as the chain does, forces and all") {
  const auto torque = [](const auto& q, const auto&, const auto& t) {
    using std::sin;
    return vector(0.3 * sin(t), -0.1 * q[1]);
  };
  const State<2> start{.t = 0.0, .q = {0.5, -0.3}, .qdot = {0.0, 0.0}};
  const Options tight{.rtol = 1e-11, .atol = 1e-11};
  const auto end = [&](const auto& system) {
    const auto run = simulate(scene(system, generalized_force(torque)), start, 2.0, Dop853{}, tight);
    REQUIRE(run.completed());
    return run.state().q;
  };
  const Vector<double, 2> expected = end(kinematic_system<2>(Links{}, gravity_along<1>(-free_fall)));
  CHECK((end(written_out_kinematic_system<2>(Links{}, gravity_along<1>(-free_fall))) - expected).norm() < 1e-9);  // a hundred tolerances
}

}  // namespace
