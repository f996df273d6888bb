// SPDX-License-Identifier: MIT
//
// Orbits whose symmetries give them multipliers of 1: which are named and taken out, and what is left.
#include "qdot/analysis/periodic_orbit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"

using namespace qdot;

namespace {

// Runs with rtol = 1e-13 over a period keep eleven digits of M, and multipliers on the circle are no worse conditioned.
constexpr double error = 1e-10;

using Numbers = std::vector<std::complex<double>>;
using Names = std::vector<std::string>;

Numbers others(const Orbit& orbit) {
  Numbers values;
  for (const Multiplier& m : orbit.multipliers)
    if (!m.trivial) values.push_back(m.value);
  return values;
}

// The largest distance of an expected multiplier from the nearest one that was found, beside its size.
double missed(const Numbers& expected, const Numbers& found) {
  double most = 0.0;
  for (const auto& each : expected) {
    double least = 1e300;
    for (const auto& other : found) least = std::min(least, std::abs(each - other) / std::abs(each));
    most = std::max(most, least);
  }
  return most;
}

// Particles that attract each other, in a plane or in space; coordinates particle by particle.
template <int dimension>
struct Attracted {
  std::array<double, 3> m{1.0, 1.0, 1.0};

  auto T(const auto& v) const {
    auto sum = 0.0 * v[0];
    for (int i = 0; i < 3; ++i)
      for (int c = 0; c < dimension; ++c) sum += 0.5 * m[static_cast<std::size_t>(i)] * v[dimension * i + c] * v[dimension * i + c];
    return sum;
  }
  auto V(const auto& q) const {
    using std::sqrt;
    auto sum = 0.0 * q[0];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < i; ++j) {
        auto r2 = 0.0 * q[0];
        for (int c = 0; c < dimension; ++c) r2 += (q[dimension * i + c] - q[dimension * j + c]) * (q[dimension * i + c] - q[dimension * j + c]);
        sum -= m[static_cast<std::size_t>(i)] * m[static_cast<std::size_t>(j)] / sqrt(r2);
      }
    return sum;
  }
};
auto in_plane(const std::array<double, 3>& m) { return mechanical_system<6>(Attracted<2>{m}).with_names({"x1", "y1", "x2", "y2", "x3", "y3"}); }
const Names of_plane{"time and energy", "translation of x1, x2, x3 and its momentum", "translation of y1, y2, y3 and its momentum",
                     "rotation of (x1, y1), (x2, y2), (x3, y3) and its angular momentum"};

// Chenciner's and Montgomery's eight, in eight digits. By Taylor series of order 34 with variational equations in 30 digits (mpmath), from these digits and
// closed by Newton's method: T |h|^(3/2), which no scale changes, and the angles of multipliers exp(±2πi ν). ν are those of C. Simó (2002), in more digits.
constexpr double eight_scaled = 9.237681250724549696, nu_slow = 0.00842272470813138, nu_fast = 0.298092529004750122;
const State<6> eight{0.0,
                     {0.97000436, -0.24308753, -0.97000436, 0.24308753, 0.0, 0.0},
                     {0.93240737 / 2, 0.86473146 / 2, 0.93240737 / 2, 0.86473146 / 2, -0.93240737, -0.86473146}};
constexpr double eight_period = 6.32591398;
std::complex<double> turned(double turns) { return std::polar(1.0, 2 * std::numbers::pi * turns); }

// Lagrange's triangle of side 1: it turns with ω² = m1 + m2 + m3 about the centre of mass.
struct Triangle {
  std::array<double, 3> m;
  double omega = std::sqrt(m[0] + m[1] + m[2]), period = 2 * std::numbers::pi / omega;

  State<6> start() const {
    State<6> s{0.0, {0.0, 0.0, 1.0, 0.0, 0.5, 0.5 * std::sqrt(3.0)}, {}};
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    for (int i = 0; i < 3; ++i) centre += m[static_cast<std::size_t>(i)] * s.q.segment<2>(2 * i) / (omega * omega);
    for (int i = 0; i < 3; ++i) {
      s.q.segment<2>(2 * i) -= centre;
      s.qdot[2 * i] = -omega * s.q[2 * i + 1];
      s.qdot[2 * i + 1] = omega * s.q[2 * i];
    }
    return s;
  }
  // Gascheau (1843), Routh (1875): λ⁴ + ω² λ² + 27/4 (m1 m2 + m2 m3 + m3 m1)/M² ω⁴ = 0 for the exponents in the frame that turns, which after a
  // period lies as before.
  Numbers multipliers() const {
    const double products = (m[0] * m[1] + m[1] * m[2] + m[2] * m[0]) / std::pow(omega, 4.0);
    const std::complex<double> root = std::sqrt(std::complex<double>(1.0 - 27.0 * products));
    Numbers values;
    for (const auto& square : {0.5 * (-1.0 + root), 0.5 * (-1.0 - root)})
      for (const double sign : {1.0, -1.0}) values.push_back(std::exp(2 * std::numbers::pi * sign * std::sqrt(square)));
    return values;
  }
};

// A particle in a plane or in space, in the field V(r²).
struct Kepler {
  auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  auto V(const auto& q) const {
    using std::sqrt;
    return -1.0 / sqrt(q.squaredNorm());
  }
};
struct Quartic {
  auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  auto V(const auto& q) const { return 0.25 * q.squaredNorm() * q.squaredNorm(); }
};
struct HenonHeiles {
  auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  auto V(const auto& q) const { return 0.5 * q.squaredNorm() + q[0] * q[0] * q[1] - q[1] * q[1] * q[1] / 3.0; }
};
// In a uniform magnetic field: ẍ = 2ẏ, ÿ = −2ẋ.
struct Cyclotron {
  auto T(const auto& q, const auto& v) const { return 0.5 * v.squaredNorm() + (q[0] * v[1] - q[1] * v[0]); }
  auto V(const auto& q) const { return 0.0 * q[0]; }
};
// Two masses whose distance r is Mathieu's: r̈ = −(a − 2 cos 2t) r.
struct DrivenPair {
  double a;
  auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  auto V(const auto& q, const auto& t) const {
    using std::cos;
    return 0.25 * (a - 2.0 * cos(2.0 * t)) * (q[0] - q[1]) * (q[0] - q[1]);
  }
};
// Equal masses in a row, with springs between them.
struct Row {
  auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  auto V(const auto& q) const {
    auto sum = 0.0 * q[0];
    for (int i = 1; i < q.size(); ++i) sum += 0.5 * (q[i] - q[i - 1]) * (q[i] - q[i - 1]);
    return sum;
  }
};
struct Free {
  auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  auto V(const auto& q) const { return 0.0 * q[0]; }
};
struct Wall {
  double side;
  auto operator()(const auto& q) const { return 1.0 - side * q[0]; }
};
struct Sphere {
  auto operator()(const auto& q) const { return q.squaredNorm() - 1.0; }
};
struct Weight {
  auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  auto V(const auto& q) const { return q[2]; }
};

}  // namespace

TEST_CASE("eight multipliers of the figure eight are 1 by its symmetries, and the other four are those of Simo: it is stable to first order") {
  const auto orbit = periodic_orbit_near(in_plane({1.0, 1.0, 1.0}), eight, eight_period, hold_energy());
  INFO(orbit.message);
  REQUIRE(orbit.found());
  CHECK_THAT(orbit.period * std::pow(-orbit.energy, 1.5), WithinAbs(eight_scaled, error));
  CHECK(orbit.symmetries == of_plane);
  CHECK(orbit.multipliers.size() == 12);
  CHECK(std::count_if(orbit.multipliers.begin(), orbit.multipliers.end(), [](const Multiplier& m) { return m.trivial && m.value == 1.0; }) == 8);
  CHECK(others(orbit).size() == 4);
  CHECK(missed({turned(nu_slow), turned(-nu_slow), turned(nu_fast), turned(-nu_fast)}, others(orbit)) < error);
  CHECK(orbit.stability == OrbitStability::stable_to_first_order);
}

// Out of the plane there are a translation and its momentum, two rotations and two angular momenta: six more, and no others.
TEST_CASE("in space fourteen multipliers of the figure eight are 1 by its symmetries, and the other four are those of the plane") {
  State<9> start{0.0, Eigen::Matrix<double, 9, 1>::Zero(), Eigen::Matrix<double, 9, 1>::Zero()};
  for (int i = 0; i < 3; ++i) {
    start.q.segment<2>(3 * i) = eight.q.segment<2>(2 * i);
    start.qdot.segment<2>(3 * i) = eight.qdot.segment<2>(2 * i);
  }
  const auto bodies = mechanical_system<9>(Attracted<3>{}).with_names({"x1", "y1", "z1", "x2", "y2", "z2", "x3", "y3", "z3"});
  const auto orbit = periodic_orbit_near(bodies, start, eight_period, hold_energy());
  INFO(orbit.message);
  REQUIRE(orbit.found());
  CHECK(orbit.symmetries == Names{"time and energy", "translation of x1, x2, x3 and its momentum", "translation of y1, y2, y3 and its momentum",
                                  "translation of z1, z2, z3 and its momentum", "rotation of (x1, y1), (x2, y2), (x3, y3) and its angular momentum",
                                  "rotation of (x1, z1), (x2, z2), (x3, z3) and its angular momentum",
                                  "rotation of (y1, z1), (y2, z2), (y3, z3) and its angular momentum"});
  CHECK(orbit.multipliers.size() == 18);
  CHECK(others(orbit).size() == 4);
  CHECK(missed({turned(nu_slow), turned(-nu_slow), turned(nu_fast), turned(-nu_fast)}, others(orbit)) < error);
  CHECK(orbit.stability == OrbitStability::stable_to_first_order);
}

// The triangle turns about its centre, so that its rotation is its motion and its angular momentum goes with the energy: these are one pair.
// The ellipses beside it, with the same energy and period, give two more multipliers of 1, and no symmetry does.
TEST_CASE("Lagrange's triangle has the multipliers of Gascheau's equation") {
  struct Masses {
    std::array<double, 3> m;
    OrbitStability stability;
  };
  for (const Masses& masses : {Masses{{1.0, 1.0, 1.0}, OrbitStability::unstable}, Masses{{3.0, 2.0, 1.0}, OrbitStability::unstable},
                               Masses{{1.0, 0.01, 0.002}, OrbitStability::not_decided}}) {
    const Triangle triangle{masses.m};
    const auto orbit = periodic_orbit_near(in_plane(masses.m), triangle.start(), triangle.period, hold_period());
    INFO(orbit.message << ", m3 = " << masses.m[2]);
    REQUIRE(orbit.found());
    CHECK(orbit.symmetries == Names(of_plane.begin(), of_plane.begin() + 3));
    const Numbers found = others(orbit);
    CHECK(found.size() == 6);
    Numbers expected = triangle.multipliers();
    double largest = 0.0;
    for (const auto& each : expected) largest = std::max(largest, std::abs(each));
    expected.push_back(1.0);
    CHECK(missed(expected, found) < error * largest * largest);  // a small one is known to the rounding of a large one
    CHECK(orbit.stability == masses.stability);
  }
}

TEST_CASE("Kepler's ellipse has no multipliers but those of time and rotation") {
  const auto planet = mechanical_system<2>(Kepler{}).with_names({"x", "y"});
  const auto orbit = periodic_orbit_near(planet, State<2>{0.0, {0.4, 0.0}, {0.0, 2.0}}, 6.3, hold_energy());
  INFO(orbit.message);
  REQUIRE(orbit.found());
  CHECK_THAT(orbit.period, WithinAbs(2 * std::numbers::pi, error));
  CHECK(orbit.symmetries == Names{"time and energy", "rotation of (x, y) and its angular momentum"});
  CHECK(orbit.multipliers.size() == 4);
  CHECK(others(orbit).empty());
  CHECK(orbit.stability == OrbitStability::stable_to_first_order);
}

TEST_CASE("an orbit without symmetries keeps the multipliers that belong to its energy alone") {
  // On x = 0 it is a cubic oscillator. M has the trace 2 + μ + 1/μ.
  const auto star = mechanical_system<2>(HenonHeiles{});
  for (const double size : {0.4, 1e-3}) {
    const auto orbit = periodic_orbit_near(star, State<2>{0.0, {0.0, size}, {0.0, 0.0}}, 6.5, hold_coordinate(1));
    INFO(orbit.message);
    REQUIRE(orbit.found());
    CHECK(orbit.symmetries == Names{"time and energy"});
    const Numbers found = others(orbit);
    REQUIRE(found.size() == 2);
    CHECK(std::abs(found[0] * found[1] - 1.0) < error);
    CHECK_THAT((found[0] + found[1]).real(), WithinAbs(orbit.monodromy.trace() - 2.0, error));
  }
}

// Angular momenta change under the rotations about the other axes, unless they are zero: two rotations and their momenta give two multipliers, not four.
// A circle of radius 1 in the field V = r⁴/4 turns with ω = 1, and beside it the distance swings with √(V″ + 3V′/r) = √6.
TEST_CASE("rotations that change each other's angular momenta give as many multipliers of 1 as there are momenta") {
  const auto particle = mechanical_system<3>(Quartic{}).with_names({"x", "y", "z"});
  const auto orbit = periodic_orbit_near(particle, State<3>{0.0, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}}, 6.28, hold_energy());
  INFO(orbit.message);
  REQUIRE(orbit.found());
  CHECK(orbit.symmetries == Names{"time and energy", "rotation of (x, z) and its angular momentum", "rotation of (y, z) and its angular momentum"});
  CHECK(orbit.multipliers.size() == 6);
  CHECK(others(orbit).size() == 2);
  CHECK(missed({turned(std::sqrt(6.0)), turned(-std::sqrt(6.0))}, others(orbit)) < error);
  CHECK(orbit.stability == OrbitStability::stable_to_first_order);
}

// Each centre has its circles of the period π. The two momenta with their gauge terms are the place of the centre, and change under each other's translation.
TEST_CASE("in a uniform magnetic field translations keep momenta with a gauge term") {
  const auto charge = mechanical_system<2>(Cyclotron{}).with_names({"x", "y"});
  const auto orbit = periodic_orbit_near(charge, State<2>{0.0, {3.0, 1.0}, {0.0, 0.7}}, 3.1, hold_energy());
  INFO(orbit.message);
  REQUIRE(orbit.found());
  CHECK_THAT(orbit.period, WithinAbs(std::numbers::pi, error));
  CHECK(orbit.symmetries == Names{"time and energy", "translation of x and its momentum", "translation of y and its momentum"});
  CHECK(others(orbit).empty());
  CHECK(orbit.stability == OrbitStability::stable_to_first_order);
}

TEST_CASE("where a drive takes time and energy away, a translation keeps its multipliers") {
  constexpr double trace = -1.554649354176467812;  // of Mathieu's equation at a = 2, q = 1 (periodic_orbit.test.cpp)
  const auto orbit = periodic_orbit_near(mechanical_system<2>(DrivenPair{2.0}), State<2>{0.0, {0.0, 0.0}, {0.0, 0.0}}, std::numbers::pi, driven());
  INFO(orbit.message);
  REQUIRE(orbit.found());
  CHECK(orbit.symmetries == Names{"translation of q0, q1 and its momentum"});
  CHECK(orbit.multipliers.size() == 4);
  const Numbers found = others(orbit);
  REQUIRE(found.size() == 2);
  CHECK_THAT((found[0] + found[1]).real(), WithinAbs(trace, error));
  CHECK(orbit.stability == OrbitStability::stable_to_first_order);
}

// Beside the first mode of a row of n masses with free ends, at 2 sin(π/2n), the others have the frequencies 2 sin(kπ/2n).
TEST_CASE("with more than twelve coordinates translations are found") {
  constexpr int n = 13;
  const auto frequency = [](int k) { return 2.0 * std::sin(k * std::numbers::pi / (2 * n)); };
  State<n> start{0.0, {}, Eigen::Matrix<double, n, 1>::Zero()};
  for (int i = 0; i < n; ++i) start.q[i] = std::cos((i + 0.5) * std::numbers::pi / n);
  const auto orbit = periodic_orbit_near(mechanical_system<n>(Row{}), start, 2 * std::numbers::pi / frequency(1), hold_energy());
  INFO(orbit.message);
  REQUIRE(orbit.found());
  Names expected{"time and energy", "translation of q0"};
  for (int i = 1; i < n; ++i) expected[1] += ", q" + std::to_string(i);
  expected[1] += " and its momentum";
  CHECK(orbit.symmetries == expected);
  Numbers multipliers;
  for (int k = 2; k < n; ++k)
    for (const double sign : {1.0, -1.0}) multipliers.push_back(turned(sign * frequency(k) / frequency(1)));
  CHECK(others(orbit).size() == multipliers.size());
  CHECK(missed(multipliers, others(orbit)) < error);
  CHECK(orbit.stability == OrbitStability::stable_to_first_order);
}

// Without the walls the particle would be free, and could turn about any point.
TEST_CASE("a symmetry that impacts break is none of the orbit's") {
  const auto between = scene(mechanical_system<2>(Free{}).with_names({"x", "y"}), contact("right", Wall{1.0}, restitution(1.0)),
                             contact("left", Wall{-1.0}, restitution(1.0)));
  const auto orbit = periodic_orbit_near(between, State<2>{0.0, {0.3, 0.2}, {1.0, 0.0}}, 3.9, hold_energy());
  INFO(orbit.message);
  REQUIRE(orbit.found());
  CHECK_THAT(orbit.period, WithinAbs(4.0, error));
  CHECK(orbit.symmetries == Names{"time and energy", "translation of y and its momentum"});
  CHECK(others(orbit).empty());
}

// A spherical pendulum on its cone: with z = −cos θ it turns with ω² = 1/cos θ, and beside it θ swings with ω √(1 + 3 cos²θ).
TEST_CASE("on constraints, too, a rotation is a symmetry") {
  constexpr double height = 0.6;
  const double radius = std::sqrt(1.0 - height * height), omega = 1.0 / std::sqrt(height);
  const auto pendulum = scene(mechanical_system<3>(Weight{}).with_names({"x", "y", "z"}), holonomic("sphere", Sphere{}));
  const State<3> start{0.0, {radius, 0.0, -height}, {0.0, omega * radius, 0.0}};
  const auto orbit = periodic_orbit_near(pendulum, start, 2 * std::numbers::pi / omega, hold_period());
  INFO(orbit.message);
  REQUIRE(orbit.found());
  CHECK(orbit.multipliers.size() == 4);
  CHECK(orbit.symmetries == Names{"time and energy"});  // of which the rotation is a part on a circle
  const double turns = std::sqrt(1.0 + 3.0 * height * height);
  CHECK(missed({turned(turns), turned(-turns)}, others(orbit)) < error);

  const auto plane_swing = periodic_orbit_near(pendulum, State<3>{0.0, {radius, 0.0, -height}, {0.0, 0.0, 0.0}}, 6.5, hold_energy());
  INFO(plane_swing.message);
  REQUIRE(plane_swing.found());
  CHECK(plane_swing.symmetries == Names{"time and energy", "rotation of (x, y) and its angular momentum"});
  CHECK(others(plane_swing).empty());
}
