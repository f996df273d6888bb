// SPDX-License-Identifier: MIT
#include "qdot/analysis/orbit_family.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "analysis/repeating.hpp"
#include "catch2_bridge.hpp"

using namespace qdot;
using repeating::over_floor;

namespace {

enum class Turns { c, a, nothing };
struct Family {
  repeating::Particle particle;
  repeating::Feed feed;
  Turns turns;
  State<1> start;
  auto operator()(const Vector<double, 1>& p) const {
    Family with = *this;
    if (turns == Turns::c) with.feed.c = p[0];
    if (turns == Turns::a) with.particle.a = p[0];
    return problem(over_floor(with.particle, with.feed), start);
  }
};

// Ten digits, for the sanitizers' sake; special points are good to seven.
FamilyOptions ten_digits(double first_step, double longest_step) {
  FamilyOptions options;
  options.orbit.tolerance = 1e-8;
  options.orbit.integration = {.rtol = 1e-11, .atol = 1e-12};
  options.first_step = first_step;
  options.longest_step = longest_step;
  return options;
}

std::vector<FamilyOrbit> special(const OrbitFamily<1>& family) {
  std::vector<FamilyOrbit> result;
  for (const FamilyOrbit& orbit : family.orbits)
    if (orbit.kind != OrbitKind::start && orbit.kind != OrbitKind::regular && orbit.kind != OrbitKind::end) result.push_back(orbit);
  return result;
}

// 4 K(sin(A/2)) by the arithmetic-geometric mean.
double period_of_pendulum(double amplitude) {
  double a = 1.0, b = std::cos(0.5 * amplitude);
  while (std::abs(a - b) > 1e-15) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return 2 * std::numbers::pi / a;
}

}  // namespace

TEST_CASE("the periods of a pendulum's family are those of the elliptic integral") {
  constexpr double error = 1e-8, amplitude = 2.0;
  const auto pendulum = over_floor({.pull = 1.0});
  const auto family = continue_orbits(pendulum, State<1>{0.0, {0.6}, {0.0}}, 6.4, in_energy(-std::cos(amplitude)), ten_digits(0.3, 0.5));
  INFO(family.message);
  REQUIRE(family.outcome == FamilyOutcome::reached);
  REQUIRE(family.orbits.size() > 3);
  for (const FamilyOrbit& orbit : family.orbits) {
    CHECK(orbit.found());
    CHECK_THAT(orbit.period, WithinAbs(period_of_pendulum(std::acos(-orbit.energy)), error));
  }
  CHECK_THAT(family.orbits.back().energy, WithinAbs(-std::cos(amplitude), 1e-7));
  CHECK(family.orbits.front().kind == OrbitKind::start);
  CHECK(family.orbits.back().kind == OrbitKind::end);
  CHECK(family.start(0).q[0] > 0.5);
}

TEST_CASE("Mathieu's equation doubles its period and branches where the characteristic values are") {
  // b₁, a₁, b₂ of q = 1: eigenvalues of the tridiagonal matrices of the Fourier coefficients, in 25 digits.
  constexpr double b1 = -0.11024881699209517, a1 = 1.8591080725143635, b2 = 3.9170247729984712, error = 1e-7;
  const Family family{{.s = 1.0}, {}, Turns::a, {0.0, {0.0}, {0.0}}};
  const auto orbits = continue_orbits(family, -0.3, std::numbers::pi, in_parameter(4.2), driven(), ten_digits(0.1, 0.1));
  INFO(orbits.message);
  REQUIRE(orbits.outcome == FamilyOutcome::reached);
  const auto points = special(orbits);
  REQUIRE(points.size() == 3);
  CHECK(points[0].kind == OrbitKind::period_doubling);
  CHECK_THAT(points[0].value, WithinAbs(b1, error));
  CHECK(points[1].kind == OrbitKind::period_doubling);
  CHECK_THAT(points[1].value, WithinAbs(a1, error));
  CHECK(points[2].kind == OrbitKind::branch);
  CHECK_THAT(points[2].value, WithinAbs(b2, error));
}

TEST_CASE("a family of cycles turns back at its fold") {
  constexpr double error = 1e-7;
  const double r = std::sqrt(1.0 + std::sqrt(0.1));  // the larger circle at c = −0.9
  const Family family{{.a = 1.0}, {.b = 1.0}, Turns::c, {0.0, {r}, {0.0}}};
  const auto orbits = continue_orbits(family, -0.9, 6.28, in_parameter(-1.9), hold_nothing(), ten_digits(0.2, 0.4));
  INFO(orbits.message);
  REQUIRE(orbits.outcome == FamilyOutcome::returned);
  const auto points = special(orbits);
  REQUIRE(points.size() == 1);
  CHECK(points[0].kind == OrbitKind::fold);
  CHECK_THAT(points[0].value, WithinAbs(-1.0, error));
  CHECK_THAT(points[0].x.norm(), WithinAbs(1.0, std::sqrt(error)));  // c is level there
  CHECK_FALSE(points[0].conserves_energy);                           // which its neighbours do, to first order
  CHECK(points[0].stability == OrbitStability::not_decided);
  bool behind = false;
  for (const FamilyOrbit& orbit : orbits.orbits) {
    behind = behind || orbit.kind == OrbitKind::fold;
    const double r2 = orbit.x.squaredNorm();
    CHECK_THAT(orbit.value + 2 * r2 - r2 * r2, WithinAbs(0.0, error));
    CHECK_THAT(orbit.period, WithinAbs(2 * std::numbers::pi, error));
    if (orbit.kind == OrbitKind::fold) continue;
    // The multiplier along the radius is exp of the mean divergence, 2π r² (2 − 2r²).
    const double expected = std::exp(2 * std::numbers::pi * r2 * (2 - 2 * r2));
    REQUIRE(orbit.multipliers.size() == 2);
    const Multiplier& other = orbit.multipliers[orbit.multipliers[0].trivial ? 1 : 0];
    CHECK(std::abs(other.value - expected) <= error * std::max(1.0, expected));
    CHECK(orbit.stability == (behind ? OrbitStability::unstable : OrbitStability::asymptotically_stable));
  }
  CHECK_THAT(orbits.orbits.back().value, WithinAbs(-0.9, error));
}

TEST_CASE("multipliers leave the circle to a torus where damping changes its sign") {
  // det M = exp(π c), and |trace M| < 2
  const Family family{{.a = 2.0, .s = 1.0}, {}, Turns::c, {0.0, {0.0}, {0.0}}};
  const auto orbits = continue_orbits(family, -0.11, std::numbers::pi, in_parameter(0.1), driven(), ten_digits(0.3, 0.4));
  INFO(orbits.message);
  REQUIRE(orbits.outcome == FamilyOutcome::reached);
  const auto points = special(orbits);
  REQUIRE(points.size() == 1);
  CHECK(points[0].kind == OrbitKind::torus);
  CHECK_THAT(points[0].value, WithinAbs(0.0, 1e-6));
  CHECK(orbits.orbits.front().stability == OrbitStability::asymptotically_stable);
  CHECK(orbits.orbits.back().stability == OrbitStability::unstable);
}

TEST_CASE("what is no family of orbits is named") {
  const Family family{{.a = 1.0}, {.c = -0.5, .b = 1.0}, Turns::nothing, {0.0, {1.3}, {0.0}}};
  CHECK_THROWS_WITH(continue_orbits(family, -0.3, -1.0, in_parameter(0.2), hold_nothing()),
                    "continue_orbits: the period must be positive and finite, but is -1; give a guess of it");
  const auto alone = continue_orbits(family, -0.3, 6.3, in_energy(2.0), hold_nothing(), ten_digits(0.1, 0.1));
  INFO(alone.message);
  CHECK(alone.outcome == FamilyOutcome::no_family);

  const auto pendulum = over_floor({.pull = 1.0});
  CHECK_THROWS_AS(continue_orbits(pendulum, State<1>{0.0, {0.4}, {0.0}}, 6.3, in_parameter(1.0)), InvalidValue);
  const auto rest = continue_orbits(pendulum, State<1>{0.0, {0.0}, {0.0}}, 6.3, in_energy(0.0));
  CHECK(rest.outcome == FamilyOutcome::no_family);
  REQUIRE(rest.orbits.size() == 1);
  CHECK(rest.orbits[0].outcome == OrbitOutcome::equilibrium);
}
