// SPDX-License-Identifier: MIT
#include "qdot/analysis/equilibrium_branch.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include "catch2_bridge.hpp"
#include "error_message.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/forces.hpp"
#include "systems/three_bodies.hpp"

using qdot::BranchKind;
using qdot::equilibrium_branches;
using qdot::mechanical_system;
using qdot::Stability;

namespace {

// Special points are located by bisection, of equations that are known to rounding.
constexpr double located = 1e-10;
// Regular points: Newton's method to rounding.
constexpr double rounding = 1e-10;

using V1 = Eigen::Matrix<double, 1, 1>;

// One coordinate, for the compiler's sake one type for both: a valley, where q² = p at rest, and a bead on a hoop, R = 1.
struct Bead {
  double g = 9.81, Omega = 0.0;
  double valley = 0.0, p = 0.0, slope = 0.0;
  auto T(const auto& q, const auto& v) const {
    using std::sin;
    const auto s = sin(q[0]);
    return 0.5 * (v[0] * v[0] + Omega * Omega * s * s);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -g * cos(q[0]) + valley * (q[0] * q[0] * q[0] / 3.0 - p * q[0]) + 0.5 * slope * q[0] * q[0];
  }
};
auto valley(double p) { return mechanical_system<1>(Bead{.g = 0.0, .valley = 1.0, .p = p}); }

// Two links of unit length and stiffness on a hinge, masses 2 and 1 at their ends, pressed by a force P on the tip. It follows the second link
// or keeps its direction. Small motions: 2 s⁴ + 7 c s³ + (7 + c² − 2P) s² + 2 c s + 1 = 0 where it follows.
struct Column {
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return 1.5 * v[0] * v[0] + 0.5 * v[1] * v[1] + v[0] * v[1] * cos(q[0] - q[1]);
  }
  auto V(const auto& q) const { return 0.5 * q[0] * q[0] + 0.5 * (q[1] - q[0]) * (q[1] - q[0]); }
};
struct Push {
  double P, c;
  bool follows;
  double shake = 0.0;
  auto operator()(const auto& q, const auto& v, const auto& t) const {
    using std::sin;
    auto Q = q;
    const auto damping = c * (v[1] - v[0]);
    Q[0] = P * sin(follows ? q[0] - q[1] : q[0]) - c * v[0] + damping + shake * sin(t);
    Q[1] = (follows ? 0.0 : P) * sin(q[1]) - damping;
    return Q;
  }
};
auto column(double P, double c, bool follows) { return scene(mechanical_system<2>(Column{}), qdot::generalized_force(Push{P, c, follows})); }

// The bead in the plane that turns with the hoop, R = 1, g = 9.
struct PlaneBead {
  double Omega;
  auto T(const auto& q, const auto& v) const { return 0.5 * (v[0] * v[0] + v[1] * v[1] + Omega * Omega * q[0] * q[0]); }
  auto V(const auto& q) const { return 9.0 * q[1]; }
};
struct Pitchfork {
  double p, length, aside = 0.0;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const {
    const auto x = q[0] / length;
    return 0.5 * p * x * x + 0.25 * x * x * x * x + aside * x;
  }
};
struct Hoop {
  auto operator()(const auto& q) const { return q[0] * q[0] + q[1] * q[1] - 1.0; }
};

}  // namespace

TEST_CASE("two equilibria meet in a fold, and the curve comes back on the other side") {
  const auto found = equilibrium_branches(valley, V1(1.0), 1.0, -1.0);
  REQUIRE(found.size() == 1);
  const auto folds = found[0].all(BranchKind::fold);
  REQUIRE(folds.size() == 1);
  CHECK(std::abs(folds[0].p) < located);
  for (const auto& point : found[0].points) CHECK(std::abs(point.q[0] * point.q[0] - point.p) < rounding);
  CHECK(found[0].points.front().stability == Stability::stable_in_linear_approximation);
  CHECK(found[0].points.back().stability == Stability::unstable);
  CHECK(found[0].points.back().kind == BranchKind::end);
  CHECK_THAT(found[0].points.back().p, WithinAbs(1.0, rounding));
  CHECK_THAT(found[0].points.back().q[0], WithinAbs(-1.0, rounding));
}

TEST_CASE("on a turning hoop the lowest place branches at Omega^2 = g/R into two, cos theta = g/(Omega^2 R), with frequency Omega sin theta") {
  const double g = Bead{}.g;
  const auto found = equilibrium_branches([](double Omega) { return mechanical_system<1>(Bead{.Omega = Omega}); }, V1(0.0), 1.0, 6.0);
  REQUIRE(found.size() == 3);
  const auto crossings = found[0].all(BranchKind::branch);
  REQUIRE(crossings.size() == 1);
  CHECK_THAT(crossings[0].p, WithinAbs(std::sqrt(g), located));
  CHECK(found[0].points.back().growing == 1);
  for (std::size_t k : {1u, 2u}) {
    CHECK(found[k].message == "reached the end of the range");
    REQUIRE(found[k].points.size() > 5);
    for (std::size_t i = 1; i < found[k].points.size(); ++i) {
      const auto& point = found[k].points[i];
      CHECK_THAT(std::cos(point.q[0]), WithinAbs(g / (point.p * point.p), rounding));
      CHECK(point.stability == Stability::stable_in_linear_approximation);
    }
    const auto& end = found[k].points.back();
    CHECK_THAT(end.exponents[1].imag(), WithinAbs(6.0 * std::abs(std::sin(end.q[0])), rounding));
  }
  CHECK(found[1].points.back().q[0] * found[2].points.back().q[0] < 0.0);
  const auto alone = equilibrium_branches([](double Omega) { return mechanical_system<1>(Bead{.Omega = Omega}); }, V1(0.0), 1.0, 6.0, {.most_branches = 1});
  CHECK(alone.back().message == "reached the end of the range; 2 branches that cross were not followed: as many as were allowed");
}

TEST_CASE("where two curves cross at an angle the other one is followed, too: q = 0 and q = -p") {
  const auto found = equilibrium_branches([](double p) { return mechanical_system<1>(Bead{.g = 0.0, .valley = 1.0, .slope = p}); }, V1(0.0), 1.0, -1.0);
  REQUIRE(found.size() == 3);
  REQUIRE(found[0].all(BranchKind::branch).size() == 1);
  CHECK(std::abs(found[0].all(BranchKind::branch)[0].p) < located);
  for (std::size_t k : {1u, 2u}) {
    CHECK(found[k].message == "reached the end of the range");
    for (const auto& point : found[k].points) CHECK_THAT(point.q[0], WithinAbs(-point.p, rounding));
  }
}

TEST_CASE("a pitchfork is met from its side branches as from its trunk, in whatever lengths: three curves from x = 0 at p = 0") {
  for (const double length : {1.0, 1e-10, 1e6})
    for (const double from : {-1.0, -0.73, -0.31, -0.05}) {
      const double side = length * (from > -0.5 ? -1.0 : 1.0);
      const auto family = [&](double p) { return mechanical_system<1>(Pitchfork{p, length}); };
      const auto found = equilibrium_branches(family, V1(side * std::sqrt(-from)), from, 1.0);
      REQUIRE(found.size() == 3);
      REQUIRE(found[0].all(BranchKind::branch).size() == 1);
      CHECK(std::abs(found[0].all(BranchKind::branch)[0].p) < located);
      CHECK(std::abs(found[0].all(BranchKind::branch)[0].q[0]) < located * length);
      CHECK(found[0].all(BranchKind::fold).empty());
      CHECK(std::abs(found[0].points.back().q[0] + side * std::sqrt(-from)) < rounding * length);
      double ends = 0.0;
      for (std::size_t k : {1u, 2u}) {
        CHECK(found[k].message == "reached the end of the range");
        for (const auto& point : found[k].points) CHECK(std::abs(point.q[0]) < rounding * length);
        ends += found[k].points.back().p;
      }
      CHECK_THAT(ends, WithinAbs(from + 1.0, rounding));
    }
}

TEST_CASE("an imperfect pitchfork has a fold at p = -3 (e/2)^(2/3) and no crossing, and its trunk is followed in large lengths") {
  for (const double aside : {1e-3, 1e-6}) {
    const auto found = equilibrium_branches([&](double p) { return mechanical_system<1>(Pitchfork{p, 1.0, aside}); }, V1(1.0), -1.0, 1.0);
    REQUIRE(found.size() == 1);
    const auto folds = found[0].all(BranchKind::fold);
    REQUIRE(folds.size() == 1);
    CHECK_THAT(folds[0].p, WithinAbs(-3.0 * std::pow(aside / 2.0, 2.0 / 3.0), located));
    CHECK_THAT(found[0].points.back().q[0], WithinAbs(aside, 2.0 * aside * aside));  // the root near e of x^3 - x + e
    CHECK(found[0].message == "reached the end of the range");
  }
  const auto large = equilibrium_branches([](double p) { return mechanical_system<1>(Pitchfork{p, 1e6}); }, V1(0.0), -1.0, 1.0);
  REQUIRE(large.size() == 3);
  for (std::size_t k : {1u, 2u}) {
    CHECK(large[k].points.size() < 100);
    CHECK_THAT(std::abs(large[k].points.back().q[0]), WithinAbs(1e6, 1e6 * rounding));
  }
}

TEST_CASE("no member outside of the range is asked for, not for a difference either") {
  double lowest = 1.0, highest = 1.0;
  const auto family = [&](double Omega) {
    lowest = std::min(lowest, Omega);
    highest = std::max(highest, Omega);
    return mechanical_system<1>(Bead{.Omega = Omega});
  };
  const double at_4 = std::acos(Bead{}.g / 16.0);
  for (const auto& [q, from, to, curves] : {std::tuple(0.0, 0.0, 4.0, 3u), std::tuple(0.0, 2.0, 0.0, 1u), std::tuple(at_4, 4.0, 0.0, 3u)}) {
    lowest = highest = from;
    const auto found = equilibrium_branches(family, V1(q), from, to);
    CHECK(found.size() == curves);
    CHECK(lowest == std::min(from, to));
    CHECK(highest == std::max(from, to));
    for (const auto& branch : found) CHECK(branch.message == "reached the end of the range");
  }
}

TEST_CASE("where the family ends, what was found stays, and its error is told") {
  const auto family = [](double p) {
    if (p < 0.2) throw qdot::InvalidValue("p must be at least 0.2");
    return valley(p);
  };
  const auto found = equilibrium_branches(family, V1(1.0), 1.0, -1.0);
  REQUIRE(found.size() == 1);
  CHECK(found[0].points.size() > 5);
  CHECK(found[0].message.find("; p must be at least 0.2") != std::string::npos);
}

TEST_CASE("what depends on the time at other values of the parameter only is no equilibrium there") {
  const auto family = [](double P) { return scene(mechanical_system<2>(Column{}), qdot::generalized_force(Push{P, 0.0, true, P - 0.1})); };
  const auto found = equilibrium_branches(family, Eigen::Vector2d(0.0, 0.0), 0.1, 0.5);
  CHECK(found[0].points.size() == 1);
  CHECK(found[0].message.starts_with("lost behind p = 0.1: equilibrium_branches: nothing may depend on the time, but the acceleration of q0 changes by"));
}

TEST_CASE("a curve of equilibria on a constraint branches where it does in coordinates without one") {
  const auto found = equilibrium_branches([](double Omega) { return scene(mechanical_system<2>(PlaneBead{Omega}), qdot::holonomic("hoop", Hoop{})); },
                                          Eigen::Vector2d(0.0, -1.0), 1.0, 5.0);
  REQUIRE(found.size() == 3);
  REQUIRE(found[0].all(BranchKind::branch).size() == 1);
  CHECK_THAT(found[0].all(BranchKind::branch)[0].p, WithinAbs(3.0, located));
  CHECK_THAT(found[1].points.back().q[1], WithinAbs(-9.0 / 25.0, rounding));
}

TEST_CASE("Ziegler's column flutters at 7/2 - sqrt 2, with equal damping at 41/28 + c^2/2, and Euler's buckles at (3 -+ sqrt 5)/2") {
  const auto first = [](BranchKind kind, double c, bool follows) {
    const auto found = equilibrium_branches([=](double P) { return column(P, c, follows); }, Eigen::Vector2d(0.0, 0.0), 0.1, 2.9, {.most_branches = 1});
    const auto points = found[0].all(kind);
    return points;
  };
  REQUIRE(first(BranchKind::hopf, 0.0, true).size() == 1);
  CHECK_THAT(first(BranchKind::hopf, 0.0, true)[0].p, WithinAbs(3.5 - std::sqrt(2.0), located));
  const auto damped = first(BranchKind::hopf, 0.1, true);
  REQUIRE(!damped.empty());
  CHECK_THAT(damped[0].p, WithinAbs(41.0 / 28.0 + 0.005, located));
  const auto buckled = first(BranchKind::branch, 0.0, false);
  REQUIRE(buckled.size() == 2);
  CHECK_THAT(buckled[0].p, WithinAbs((3.0 - std::sqrt(5.0)) / 2.0, located));
  CHECK_THAT(buckled[1].p, WithinAbs((3.0 + std::sqrt(5.0)) / 2.0, located));
}

TEST_CASE("L4 is stable up to Routh's mass ratio") {
  const auto found = equilibrium_branches([](double mu) { return mechanical_system<2>(qdot::systems::ThreeBodies{mu}); },
                                          Eigen::Vector2d(0.49, std::sqrt(0.75)), 0.01, 0.06);
  REQUIRE(found[0].all(BranchKind::hopf).size() == 1);
  CHECK_THAT(found[0].all(BranchKind::hopf)[0].p, WithinAbs(0.03852089650455139708, located));
  for (const auto& point : found[0].points) CHECK_THAT(point.q[0], WithinAbs(0.5 - point.p, rounding));
}

TEST_CASE("what cannot be followed is refused with the reason") {
  CHECK(qdot::error_message([&] {
          equilibrium_branches(valley, V1(1.0), 1.0, 1.0);
        }).find("must be finite and not empty, but goes from 1 to 1") != std::string::npos);
  CHECK(qdot::error_message([&] {
          equilibrium_branches(valley, V1(1.0), 1.0, 0.0, {.longest_step = 0.0});
        }).find("the longest step must lie between 0 and 1") != std::string::npos);
  CHECK(qdot::error_message([&] { equilibrium_branches(valley, Eigen::Vector2d(1.0, 0.0), 1.0, 0.0); }).starts_with("q must have 1 entry, but has 2"));
  CHECK(qdot::error_message([&] {
          equilibrium_branches(valley, V1(1.0), -1.0, 1.0);
        }).find("all accelerations must vanish somewhere near the start") != std::string::npos);
  const auto kinked = [](double p) { return valley(std::sqrt(p - 0.5) + 0.5); };  // from 0.5 on, where slopes are taken on one side
  CHECK(qdot::error_message([&] {
          equilibrium_branches(kinked, V1(1.0), 0.5, 1.0);
        }).find("must have a derivative with respect to its parameter, but at 0.5") != std::string::npos);
}
