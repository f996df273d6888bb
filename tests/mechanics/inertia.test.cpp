// SPDX-License-Identifier: MIT
#include "catch2_bridge.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "qdot/mechanics/inertia.hpp"
#include "qdot/mechanics/rotation.hpp"

using namespace qdot;

namespace {

// Sums over some thousand points, sizes of order 10.
constexpr double rounding = 1e-12;

double distance(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) { return (a - b).cwiseAbs().maxCoeff(); }

// Six-point Gauss rule on [−1, 1], exact for polynomials up to degree 11.
struct Node {
  double x, weight;
};
const std::vector<Node> gauss = {
    {-0.932469514203152028, 0.171324492379170345}, {-0.661209386466264514, 0.360761573048138608},
    {-0.238619186083196909, 0.467913934572691047}, {0.238619186083196909, 0.467913934572691047},
    {0.661209386466264514, 0.360761573048138608},  {0.932469514203152028, 0.171324492379170345}};
constexpr int turns = 24;  // equally spaced angles: exact for trigonometric polynomials up to order 23

// A body of revolution as points: z ∈ [z0, z1], ρ ∈ [inner(z), outer(z)], of mass M in all. The integrands of
// inertia are polynomials in ρ, so the points have exactly the inertia of the body where inner² and outer² are
// polynomials in z.
std::vector<PointMass> body_of_revolution(double M, double z0, double z1, const std::function<double(double)>& inner,
                                          const std::function<double(double)>& outer) {
  std::vector<PointMass> points;
  for (const Node& along : gauss) {
    const double z = 0.5 * (z0 + z1) + 0.5 * (z1 - z0) * along.x;
    const double a = inner(z), b = outer(z);
    for (const Node& across : gauss) {
      const double r = 0.5 * (a + b) + 0.5 * (b - a) * across.x;
      for (int k = 0; k < turns; ++k) {
        const double angle = 2.0 * std::numbers::pi * k / turns;
        points.push_back({along.weight * across.weight * (b - a) * r, {r * std::cos(angle), r * std::sin(angle), z}});
      }
    }
  }
  const double sum = total_mass(points);
  for (PointMass& point : points) point.mass *= M / sum;
  return points;
}

Eigen::Matrix3d inertia_about_own_centre(const std::vector<PointMass>& points) {
  return inertia_of_points(points, centre_of_mass(points));
}

const auto zero = [](double) { return 0.0; };

std::vector<PointMass> three_masses() {
  return {{1.0, {1.0, 0.0, 0.0}}, {2.0, {0.0, 2.0, 0.0}}, {3.0, {0.0, 0.0, 1.0}}};
}

}  // namespace

TEST_CASE("the worked cloud: masses 1, 2, 3 have I = diag(11, 4, 9), M = 6, M AG = (1, 4, 3)") {
  const auto points = three_masses();
  CHECK(inertia_of_points(points, Eigen::Vector3d::Zero()) == Eigen::Vector3d(11.0, 4.0, 9.0).asDiagonal().toDenseMatrix());
  CHECK(total_mass(points) == 6.0);
  CHECK((6.0 * centre_of_mass(points) - Eigen::Vector3d(1.0, 4.0, 3.0)).norm() < rounding);
}

TEST_CASE("products of inertia carry the minus sign") {
  const std::vector<PointMass> point = {{2.0, {3.0, 5.0, 7.0}}};
  const Eigen::Matrix3d I = inertia_of_points(point, Eigen::Vector3d::Zero());
  CHECK(I(0, 1) == -2.0 * 3.0 * 5.0);
  CHECK(I(0, 2) == -2.0 * 3.0 * 7.0);
  CHECK(I(1, 2) == -2.0 * 5.0 * 7.0);
  CHECK(I(0, 0) == 2.0 * (25.0 + 49.0));
}

TEST_CASE("cylinders, disks, rings and tubes have the inertia of their points") {
  for (const double inner : {0.0, 0.3, 0.8}) {
    const auto points = body_of_revolution(2.5, -0.7, 0.7, [&](double) { return inner; }, [](double) { return 0.8001; });
    CHECK(distance(inertia::hollow_cylinder(2.5, inner, 0.8001, 1.4), inertia_about_own_centre(points)) < rounding);
  }
  CHECK(distance(inertia::cylinder(3.0, 2.0, 0.0), inertia::disk(3.0, 2.0)) == 0.0);
  CHECK(distance(inertia::disk(3.0, 2.0), Eigen::Vector3d(3.0, 3.0, 6.0).asDiagonal()) < rounding);
  CHECK(distance(inertia::ring(3.0, 2.0), Eigen::Vector3d(6.0, 6.0, 12.0).asDiagonal()) < rounding);
}

TEST_CASE("the cone has the inertia of its points, about its centre of mass and about its apex") {
  const double M = 1.7, R = 0.6, h = 1.3;  // apex at the origin, opening upwards
  const auto points = body_of_revolution(M, 0.0, h, zero, [&](double z) { return R * z / h; });
  CHECK((centre_of_mass(points) - Eigen::Vector3d(0.0, 0.0, 0.75 * h)).norm() < rounding);
  CHECK(distance(inertia::cone(M, R, h), inertia_about_own_centre(points)) < rounding);
  CHECK(distance(inertia::cone_about_apex(M, R, h), inertia_of_points(points, Eigen::Vector3d::Zero())) < rounding);
  const double side = 3.0 * M * (R * R + 4.0 * h * h) / 20.0;
  CHECK(distance(inertia::cone_about_apex(M, R, h), Eigen::Vector3d(side, side, 0.3 * M * R * R).asDiagonal()) < rounding);
}

TEST_CASE("spheres, half balls and ellipsoids have the inertia of their points") {
  const double M = 4.2, R = 1.5;
  const auto ball = body_of_revolution(M, -R, R, zero, [&](double z) { return std::sqrt(R * R - z * z); });
  CHECK(distance(inertia::sphere(M, R), inertia_about_own_centre(ball)) < rounding);
  const auto half = body_of_revolution(M, 0.0, R, zero, [&](double z) { return std::sqrt(R * R - z * z); });
  CHECK((centre_of_mass(half) - Eigen::Vector3d(0.0, 0.0, 0.375 * R)).norm() < rounding);
  CHECK(distance(inertia::hemisphere(M, R), inertia_about_own_centre(half)) < rounding);
  auto stretched = ball;
  for (PointMass& point : stretched) point.position = point.position.cwiseProduct(Eigen::Vector3d(0.4, 2.0, 0.9)) / R;
  CHECK(distance(inertia::ellipsoid(M, 0.4, 2.0, 0.9), inertia_about_own_centre(stretched)) < rounding);
}

TEST_CASE("a thick shell is a ball less a smaller ball, and thins out to ⅔MR²") {
  const double density = 3.0, a = 0.7, R = 1.1;
  const auto ball_mass = [&](double r) { return density * 4.0 / 3.0 * std::numbers::pi * r * r * r; };
  const Eigen::Matrix3d expected = inertia::sphere(ball_mass(R), R) - inertia::sphere(ball_mass(a), a);
  CHECK(distance(inertia::hollow_sphere(ball_mass(R) - ball_mass(a), a, R), expected) < rounding);
  CHECK(distance(inertia::spherical_shell(3.0, 2.0), 8.0 * Eigen::Matrix3d::Identity()) < rounding);
  CHECK(distance(inertia::hollow_sphere(1.0, 0.0, 0.0), Eigen::Matrix3d::Zero()) == 0.0);
}

TEST_CASE("the torus has the inertia of its points") {
  const double M = 1.3, R = 2.0, a = 0.5;
  std::vector<PointMass> points;
  for (const Node& node : gauss) {
    const double s = 0.5 * a * (1.0 + node.x);
    for (int j = 0; j < turns; ++j) {
      const double u = 2.0 * std::numbers::pi * j / turns, rho = R + s * std::cos(u);
      for (int k = 0; k < turns; ++k) {
        const double w = 2.0 * std::numbers::pi * k / turns;
        points.push_back({node.weight * s * rho, {rho * std::cos(w), rho * std::sin(w), s * std::sin(u)}});
      }
    }
  }
  const double sum = total_mass(points);
  for (PointMass& point : points) point.mass *= M / sum;
  CHECK(distance(inertia::torus(M, R, a), inertia_about_own_centre(points)) < rounding);
}

TEST_CASE("the box has the inertia of its points, and a rod is a box without thickness") {
  const double M = 2.2, a = 0.4, b = 1.6, c = 0.9;
  std::vector<PointMass> points;
  for (const Node& x : gauss) {
    for (const Node& y : gauss) {
      for (const Node& z : gauss) {
        points.push_back({M * x.weight * y.weight * z.weight / 8.0, 0.5 * Eigen::Vector3d(a * x.x, b * y.x, c * z.x)});
      }
    }
  }
  CHECK(distance(inertia::box(M, a, b, c), inertia_about_own_centre(points)) < rounding);
  CHECK(distance(inertia::box(M, a, 0.0, 0.0), inertia::thin_rod(M, a)) == 0.0);
}

TEST_CASE("a rod has ML²/12 about its middle and ML²/3 about its end") {
  CHECK(inertia::thin_rod(3.0, 2.0)(2, 2) == 1.0);
  CHECK(inertia::thin_rod_about_end(3.0, 2.0)(2, 2) == 4.0);
  CHECK(inertia::thin_rod_about_end(3.0, 2.0)(0, 0) == 0.0);
}

TEST_CASE("parallel axes agree with the points about any point, and the way back is the way there") {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int sample = 0; sample < 50; ++sample) {
    std::vector<PointMass> points;
    for (int i = 0; i < 7; ++i) {
      points.push_back({1.1 + uniform(random), {uniform(random), uniform(random), uniform(random)}});
    }
    const double M = total_mass(points);
    const Eigen::Vector3d A(uniform(random), uniform(random), uniform(random)), G = centre_of_mass(points);
    const Eigen::Matrix3d I_G = inertia_of_points(points, G), I_A = inertia_of_points(points, A);
    CHECK(distance(inertia_away_from_centre(I_G, M, G - A), I_A) < rounding);
    CHECK(distance(inertia_at_centre(I_A, M, A - G), I_G) < rounding);
  }
}

TEST_CASE("the tensor of turned points is the turned tensor") {
  const Eigen::Matrix3d R = euler_rotation_313(0.3, 1.1, -0.8);
  auto points = three_masses();
  const Eigen::Matrix3d I = inertia_of_points(points, Eigen::Vector3d::Zero());
  for (PointMass& point : points) point.position = R * point.position;
  CHECK(distance(turned_inertia(R, I), inertia_of_points(points, Eigen::Vector3d::Zero())) < rounding);
}

TEST_CASE("principal moments and axes are found again after a turn") {
  const Eigen::Matrix3d R = euler_rotation_321(0.3, 1.1, -0.8);
  const PrincipalInertia principal = principal_inertia(turned_inertia(R, inertia::box(12.0, 1.0, 2.0, 3.0)));
  CHECK((principal.moments - Eigen::Vector3d(5.0, 10.0, 13.0)).norm() < rounding);
  CHECK_THAT(principal.axes.determinant(), WithinAbs(1.0, rounding));
  CHECK_THAT(std::abs(principal.axes.col(0).dot(R.col(2))), WithinAbs(1.0, rounding));  // least about the longest edge
}

TEST_CASE("an impossible tensor is refused with the rule and the values") {
  const Eigen::Matrix3d too_large = Eigen::Vector3d(1.0, 1.0, 3.0).asDiagonal();
  CHECK_THROWS_WITH(valid_inertia(too_large),
                    "inertia tensor: the largest principal moment must not exceed the sum of the other two, but I = "
                    "[1, 0, 0; 0, 1, 0; 0, 0, 3]; no positive masses give this tensor: check units, axes and the point it is about");
  Eigen::Matrix3d lopsided = Eigen::Matrix3d::Identity();
  lopsided(0, 1) = 0.5;
  CHECK_THROWS_AS(valid_inertia(lopsided), InvalidValue);
  CHECK_THROWS_AS(valid_inertia(-Eigen::Matrix3d::Identity()), InvalidValue);
  CHECK_THROWS_AS(valid_inertia(std::numeric_limits<double>::quiet_NaN() * Eigen::Matrix3d::Identity()), InvalidValue);
  CHECK(valid_inertia(inertia::thin_rod(1.0, 1.0)) == inertia::thin_rod(1.0, 1.0));  // the limiting case passes
  CHECK(valid_inertia(inertia::disk(1.0, 1.0)) == inertia::disk(1.0, 1.0));
}

TEST_CASE("impossible sizes are refused by name") {
  CHECK_THROWS_WITH(inertia::hollow_cylinder(1.0, 2.0, 1.0, 1.0),
                    "inertia::hollow_cylinder: the inner radius must not exceed the outer one, but inner = 2 and "
                    "outer = 1; the inner radius comes first");
  CHECK_THROWS_AS(inertia::sphere(-1.0, 1.0), InvalidValue);
  CHECK_THROWS_AS(inertia::box(1.0, 1.0, std::numeric_limits<double>::infinity(), 1.0), InvalidValue);
  CHECK_THROWS_AS(centre_of_mass(std::vector<PointMass>{}), InvalidValue);
}
