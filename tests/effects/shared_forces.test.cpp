// SPDX-License-Identifier: MIT
//
// Contacts and frictions whose rows depend on each other: the motion is that of statics and of Gauss's principle, whatever their order.
#include "qdot/effects/equations/shared_forces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <tuple>

#include "../catch2_bridge.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/scene_form.hpp"

using qdot::contact;
using qdot::scene;
using qdot::State;

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double g = 9.81;
constexpr double rounding = 1e-12;  // of some ten sums

// A plate of mass m and moments of inertia m L²/3, with height and slopes as coordinates, under a force and moments; six legs below it.
struct Plate {
  double m = 1.0, L = 1.0;
  Vector3d load = Vector3d(0, 0, 0);  // −∂V/∂q
  std::array<Vector2d, 6> legs{};
};

auto plate_on_legs(const Plate& p) {
  const auto system = qdot::mechanical_system<3>(
      [p](const auto& v) { return 0.5 * p.m * (v[0] * v[0] + p.L * p.L / 3.0 * (v[1] * v[1] + v[2] * v[2])); },
      [p](const auto& q) { return -(p.load[0] * q[0] + p.load[1] * q[1] + p.load[2] * q[2]); });
  const auto leg = [&p](const char* name, std::size_t k) {
    return contact(name, [at = p.legs[k]](const auto& q) { return q[0] + at[0] * q[1] + at[1] * q[2]; });
  };
  return scene(system, leg("a", 0), leg("b", 1), leg("c", 2), leg("d", 3), leg("e", 4), leg("f", 5));
}

// What is wrong with the phases that a plate at rest takes, by Newton's law and the conditions of one-sided contact, each of which is written out here.
std::string what_is_wrong(const Plate& p, Vector3d& a) {
  const auto s = plate_on_legs(p);
  const State<3> rest{0.0, Vector3d(0, 0, 0), Vector3d(0, 0, 0)};
  const auto z = settled_states(s, rest);
  const auto solution = constrained_acceleration(s, rest.q, rest.qdot, 0.0, z);
  a = solution.qddot;
  Vector3d force = p.load;
  const double weight = std::abs(p.load[0]), size = weight / p.m;
  constexpr double told_apart = 1e-7;  // accelerations are told from zero by 1e-9 of those without contacts, rows by 1e-5
  for (std::size_t k = 0; k < 6; ++k) {
    const double lambda = solution.lambda[static_cast<Eigen::Index>(k)], gap = a[0] + p.legs[k][0] * a[1] + p.legs[k][1] * a[2];
    force += lambda * Vector3d(1, p.legs[k][0], p.legs[k][1]);
    if (lambda < -rounding * weight) return "a leg pulls";
    if (gap < -told_apart * size) return "a leg sinks in";
    if (lambda > told_apart * weight && gap > told_apart * size) return "an open leg presses";
  }
  const Vector3d miss = force - p.m * Vector3d(a[0], p.L * p.L / 3.0 * a[1], p.L * p.L / 3.0 * a[2]);
  if (std::max({std::abs(miss[0]), std::abs(miss[1]) / p.L, std::abs(miss[2]) / p.L}) > 1e-9 * weight) return "Newton's law does not hold";
  return "";
}

}  // namespace

TEST_CASE("a table on four legs, two of them doubled, rests with its load at any place of its top, in any order and unit") {
  const std::array<Vector2d, 6> corners{Vector2d(-1, -1), Vector2d(1, -1), Vector2d(1, 1), Vector2d(-1, 1), Vector2d(1, 1), Vector2d(-1, -1)};
  for (const double unit : {1.0, 1e-9, 1e9})
    for (int i = 0; i <= 20; i += unit == 1.0 ? 1 : 5)
      for (int j = 0; j <= 20; j += unit == 1.0 ? 1 : 5) {
        const double m = unit, L = unit, x = L * (-1 + 0.1 * i), y = L * (-1 + 0.1 * j);
        Plate table{m, L, -m * g * Vector3d(3, 2 * x, 2 * y), {}};
        for (std::size_t k = 0; k < 6; ++k) table.legs[k] = L * corners[(k * (i % 2 == 0 ? 1 : 5) + static_cast<std::size_t>(j)) % 6];
        Vector3d a;
        CAPTURE(unit, x, y);
        CHECK(what_is_wrong(table, a).empty());
        CHECK(std::abs(a[0]) < rounding * g);
        CHECK(std::max(std::abs(a[1]), std::abs(a[2])) * L < rounding * g);
      }
}

TEST_CASE("a plate on legs at random places moves as Newton's law and one-sided contact say, whatever the order of its legs") {
  std::mt19937 random(20261127);
  std::uniform_real_distribution<double> from(-1.0, 1.0);
  for (int trial = 0; trial < 200; ++trial) {
    const double m = std::pow(10.0, 9 * from(random)), L = std::pow(10.0, 9 * from(random));
    Plate plate{m, L, {}, {}};
    plate.load = m * g * Vector3d(trial % 10 == 0 ? 1.0 : -1.0, 1.5 * L * from(random), 1.5 * L * from(random));
    for (Vector2d& leg : plate.legs) leg = L * Vector2d(from(random), from(random));
    if (trial % 3 == 0) plate.legs[5] = plate.legs[0];                                // twice the same leg
    if (trial % 4 == 0) plate.legs[4] = 0.5 * (plate.legs[0] + plate.legs[1]);        // on a line
    if (trial % 5 == 0) for (Vector2d& leg : plate.legs) leg[1] = 0.3 * leg[0];  // all on one line
    Vector3d a, turned;
    CAPTURE(trial, m, L);
    CHECK(what_is_wrong(plate, a).empty());
    std::shuffle(plate.legs.begin(), plate.legs.end(), random);
    CHECK(what_is_wrong(plate, turned).empty());
    const Vector3d difference = a - turned;
    constexpr double told_apart = 1e-7;
    CHECK(std::max({std::abs(difference[0]), std::abs(difference[1]) * L, std::abs(difference[2]) * L}) < told_apart * g);
  }
}

TEST_CASE("redundant supports bear the shortest forces that press") {
  // A beam on supports at −1, 0, 1; its own weight 1 and a load 2 at x. With rows scaled to their lengths in the metric of M, 1 + 3 x² (squared), the
  // shortest split solves λ = (μ + ν x)/(1 + 3 x²). At x = 0: λ = μ (1/4, 1, 1/4), Σ = 3; at x = 1 that would pull on the left: (0, 1, 2).
  Plate beam;
  beam.legs = {Vector2d(0, 0), Vector2d(1, 0), Vector2d(-1, 0), Vector2d(9, 9), Vector2d(9, 9), Vector2d(9, 9)};
  beam.load = Vector3d(-3, 0, 0);
  const auto lambda_of = [](const Plate& p) {
    const auto s = plate_on_legs(p);
    const State<3> rest{0.0, Vector3d(0, 0, 0), Vector3d(0, 0, 0)};
    return constrained_acceleration(s, rest.q, rest.qdot, 0.0, settled_states(s, rest)).lambda;
  };
  CHECK((lambda_of(beam).head(3) - Vector3d(2, 0.5, 0.5)).norm() < rounding);
  beam.load = Vector3d(-3, -2, 0);
  CHECK((lambda_of(beam).head(3) - Vector3d(1, 2, 0)).norm() < rounding);
}

TEST_CASE("contacts that close against each other are refused by name") {
  // Two walls press a rigid ball between them.
  const auto ball = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.0 * q[0]; });
  const auto walls = [&](double speed, double push) {
    return scene(ball, contact("left", [=](const auto& q, const auto& t) { return q[0] - speed * t - push * t * t; }),
                 contact("right", [=](const auto& q, const auto& t) { return -q[0] - speed * t - push * t * t; }));
  };
  const State<1> between{0.0, qdot::Vector<double, 1>(0.0), qdot::Vector<double, 1>(0.0)};
  for (const auto& [speed, push, says] : {std::tuple(1.0, 0.0, "no finite impulse"), std::tuple(0.0, 1.0, "no finite force")}) {
    std::string message;
    try {
      (void)settled_states(walls(speed, push), between);
    } catch (const qdot::ConstraintError& error) {
      message = error.what();
    }
    CHECK(message.find(says) != std::string::npos);
    CHECK((message.find("'left'") != std::string::npos || message.find("'right'") != std::string::npos));
  }
  CHECK_NOTHROW(settled_states(walls(0.0, 0.0), between));
}
