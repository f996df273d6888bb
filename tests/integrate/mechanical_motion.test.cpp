// SPDX-License-Identifier: MIT
//
// From T and V to motion: mechanical systems through the driver and CVODE.

#include <cmath>
#include <string>

#include "catch2_bridge.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/mechanics/energy.hpp"

using qdot::CvodeAdams;
using qdot::CvodeBdf;
using qdot::Options;
using qdot::Outcome;
using qdot::simulate;
using qdot::State;

namespace {

// A rod of mass M and length L turns about its end; a ring of mass m slides on it. q = (r, φ), φ from the horizontal.
auto rod_and_ring() {
  return qdot::mechanical_system<2>(
             [](const auto& q, const auto& qdot) {
               constexpr double M = 2.0, L = 1.5, m = 0.3, I_O = M * L * L / 3;
               const auto r_phidot = q[0] * qdot[1];
               return 0.5 * I_O * qdot[1] * qdot[1] + 0.5 * m * (qdot[0] * qdot[0] + r_phidot * r_phidot);
             },
             [](const auto& q) {
               using std::sin;
               constexpr double M = 2.0, L = 1.5, m = 0.3, g = 9.81;
               return m * g * q[0] * sin(q[1]) + M * g * (L / 2) * sin(q[1]);
             })
      .with_names({"r", "phi"});
}

const State<2> start{0.0, {0.4, 0.2}, {0.1, 1.0}};

}  // namespace

TEMPLATE_TEST_CASE("the rod and the sliding ring move as in quadruple precision", "", CvodeBdf, CvodeAdams) {
  const auto run = simulate(rod_and_ring(), start, 1.0, TestType{}, {.rtol = 1e-12, .atol = 1e-12});
  REQUIRE(run.completed());
  constexpr double error = 2e-9;  // BDF at 1e-12 was off by 2e-10
  const State<2> half = run.trajectory.at(0.5);
  REQUIRE_THAT(half.q[0], WithinAbs(0.33694879608495, error));
  REQUIRE_THAT(half.q[1], WithinAbs(-0.55754350895470, error));
  REQUIRE_THAT(half.qdot[0], WithinAbs(0.66116092170779, error));
  REQUIRE_THAT(half.qdot[1], WithinAbs(-3.98451683987792, error));
  const State<2> end = run.state();
  REQUIRE_THAT(end.q[0], WithinAbs(3.2329996316785996, error));
  REQUIRE_THAT(end.q[1], WithinAbs(-2.3493856325149203, error));
  REQUIRE_THAT(end.qdot[0], WithinAbs(11.033246474122167, 10 * error));
  REQUIRE_THAT(end.qdot[1], WithinAbs(-1.12282143766159, 10 * error));
}

TEST_CASE("the energy of a conservative system stays what it was, at every step and between") {
  const auto system = rod_and_ring();
  const auto run = simulate(system, start, 1.0, CvodeAdams{}, {.rtol = 1e-12, .atol = 1e-12});
  for (const State<2>& s : run.trajectory.sampled(101))
    REQUIRE_THAT(qdot::energy(system, s.q, s.qdot), WithinAbs(3.93279273886127, 1e-9));
}

TEST_CASE("a system whose size is known at run time moves like the one known at compile time") {
  const auto fixed = rod_and_ring();
  const auto dynamic = qdot::mechanical_system(2, fixed.energies());
  const State<qdot::Dynamic> from{start.t, start.q, start.qdot};
  const auto a = simulate(fixed, start, 1.0, CvodeBdf{});
  const auto b = simulate(dynamic, from, 1.0, CvodeBdf{});
  REQUIRE((a.y - b.y).norm() < 1e-6);  // rounding in M, times what rtol 1e-9 makes of it
  REQUIRE(b.trajectory.back().q.size() == 2);
}

TEST_CASE("messages name the user's coordinates") {
  const auto system = rod_and_ring();
  std::string message;
  try {
    simulate(system, State<2>{0.0, {0.4, std::nan("")}, {0.1, 1.0}}, 1.0, CvodeBdf{});
  } catch (const qdot::InvalidValue& error) {
    message = error.what();
  }
  REQUIRE(message == "phi must be finite at the start, but is nan; give it a number");
  REQUIRE_THROWS_AS(simulate(system, State<2>{}, 1.0, CvodeBdf{}, Options{.atol = {1e-9, 1e-9, 1e-9}}),
                    qdot::DimensionError);
}

TEST_CASE("a mass matrix that stops being positive on the way ends the run with the trajectory up to there") {
  // A mass that leaks away, m = 1 − t, hanging at rest on its spring.
  const auto leaking = qdot::mechanical_system<1>([](const auto&, const auto& qdot,
                                                     const auto& t) { return 0.5 * (1.0 - t) * qdot[0] * qdot[0]; },
                                                  [](const auto& q) { return 0.5 * q[0] * q[0]; })
                           .with_names({"x"});
  const State<1> rest{0.0, Eigen::Matrix<double, 1, 1>(0.0), Eigen::Matrix<double, 1, 1>(0.0)};
  const auto run = simulate(leaking, rest, 2.0, CvodeBdf{});
  REQUIRE(run.outcome == Outcome::singular_mass_matrix);
  REQUIRE(run.t <= 1.0);
  REQUIRE(run.t > 0.9);
  REQUIRE(run.trajectory.back_time() == run.t);
  REQUIRE(run.message.find(" x") != std::string::npos);
  REQUIRE(run.statistics.evaluations < 1000);
}
