// SPDX-License-Identifier: MIT
#include "qdot/analysis/boundary_value_problem.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include "catch2_bridge.hpp"
#include "error_message.hpp"
#include "qdot/analysis/action.hpp"

using qdot::action;
using qdot::BoundaryValueOutcome;
using qdot::error_message;
using qdot::boundary_value_problem;
using qdot::scene;
using qdot::vector;

namespace {

const double pi = std::numbers::pi;
constexpr double settled = 1e-9;  // runs of rtol 1e-11 over some units of time

// ½ k q² − pull cos q.
struct Line {
  double k = 0.0, pull = 0.0;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const {
    using std::cos;
    return 0.5 * k * q[0] * q[0] - pull * cos(q[0]);
  }
};
auto line(Line of) { return qdot::mechanical_system<1>(of); }

// A plane with a spring and weight, or a sphere in (θ, φ).
struct Surface {
  double k = 0.0, g = 0.0;
  bool round = false;
  auto T(const auto& q, const auto& v) const {
    using std::sin;
    auto r = 0.0 * q[0] + 1.0;
    if (round) r = sin(q[0]);
    return 0.5 * (v[0] * v[0] + r * r * v[1] * v[1]);
  }
  auto V(const auto& q) const { return 0.5 * k * (q[0] * q[0] + q[1] * q[1]) + g * q[1]; }
};
auto surface(Surface of) { return qdot::mechanical_system<2>(of); }

struct Free {
  double m = 3.0;
  auto T(const auto& v) const { return 0.5 * m * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }
  auto V(const auto& q) const { return 0.0 * q[0]; }
};

using V1 = qdot::Vector<double, 1>;
using V2 = qdot::Vector<double, 2>;

}  // namespace

// G. J. Sussman, J. Wisdom, Structure and Interpretation of Classical Mechanics, section 1.4: 435, and 436.2912142857 with η = (t − t_a)(t −
// t_b)(sin t, cos t, t²).
TEST_CASE("the action of a straight path and of a varied one are those of the book") {
  const auto system = qdot::mechanical_system<3>(Free{});
  const auto varied = [](double eps) {
    return [eps](const auto& t) {
      using std::sin, std::cos;
      const auto eta = eps * t * (t - 10.0);
      return vector(4.0 * t + 7.0 + eta * sin(t), 3.0 * t + 5.0 + eta * cos(t), 2.0 * t + 1.0 + eta * t * t);
    };
  };
  const auto straight = action(system, varied(0.0), 0.0, 10.0);
  CHECK(std::abs(straight.S - 435.0) < 1e-12 * 435);
  CHECK(straight.error < 1e-11);
  const auto beside = action(system, varied(0.001), 0.0, 10.0);
  CHECK(std::abs(beside.S - 436.291214285714) < 1e-11);  // as many digits as are given
  CHECK(beside.error < 1e-9);
  // q = |t − 1|³ᐟ² has q̇² = 9/4 |t − 1|, a kink: 3 · 9/8 · (½ + ½ · 4).
  const auto bent = action(system, [](const auto& t) {
    using std::pow, std::abs;
    return vector(pow(abs(t - 1.0), 1.5), 0.0 * t, 0.0 * t);
  }, 0.0, 3.0);
  CHECK(std::abs(bent.S - 8.4375) <= std::max(bent.error, 1e-12));
  CHECK(bent.error < 1e-8);

  CHECK(error_message([&] { return action(system, varied(0.0), 1.0, 1.0); }) ==
        "action: the end must be later than the start, but they are t = 1 and 1; give them in order");
  CHECK_THROWS_AS(action(system, [](const auto& t) { return vector(t, t); }, 0.0, 1.0), qdot::DimensionError);
  const auto nowhere = [](const auto& t) { return vector(1.0 / (t - t), t, t); };
  CHECK(error_message([&] { return action(system, nowhere, 0.0, 1.0); }).find("L must be finite all along the path") !=
        std::string::npos);
}

TEST_CASE("a throw between two places is the parabola, whose action is the closed form") {
  const double g = 9.81, T = 1.5;
  const auto found = boundary_value_problem(scene(surface({.g = g})), V2(0.0, 0.0), 0.0, V2(10.0, 2.0), T);
  INFO(found.message);
  REQUIRE(found.found());
  CHECK(std::abs(found.start.qdot[0] - 10.0 / T) < settled);
  CHECK(std::abs(found.start.qdot[1] - (2.0 / T + 0.5 * g * T)) < settled);
  CHECK(found.residual.norm() < settled);
  // ½ d²/T − ½ g T (y_a + y_b) − g² T³/24
  CHECK(std::abs(found.S - (0.5 * 104.0 / T - 0.5 * g * T * 2.0 - g * g * T * T * T / 24)) < settled);
  CHECK(found.conjugate_points.empty());
  CHECK(std::abs(found.at(0.75).q[1] - (0.75 * found.start.qdot[1] - 0.5 * g * 0.75 * 0.75)) < settled);
}

TEST_CASE("an oscillator has a conjugate point each half period, in every direction") {
  const double w = 2.0, T = 5.0, a = 0.3, b = -0.8;
  const auto found = boundary_value_problem(line({.k = w * w}), V1(a), 1.0, V1(b), 1.0 + T);
  INFO(found.message);
  REQUIRE(found.found());
  CHECK(std::abs(found.S - 0.5 * w / std::sin(w * T) * ((a * a + b * b) * std::cos(w * T) - 2.0 * a * b)) < settled);
  REQUIRE(found.conjugate_points.size() == 3);
  CHECK(found.index == 3);
  for (std::size_t k = 0; k < 3; ++k) CHECK(std::abs(found.conjugate_points[k].t - (1.0 + pi / w * static_cast<double>(k + 1))) < settled);

  const auto plane = boundary_value_problem(surface({.k = w * w}), V2(a, 0.2), 0.0, V2(b, 0.1), 4.0);
  REQUIRE(plane.found());
  REQUIRE(plane.conjugate_points.size() == 2);
  CHECK(plane.index == 4);
  for (std::size_t k = 0; k < 2; ++k) {
    CHECK(plane.conjugate_points[k].multiplicity == 2);
    CHECK(std::abs(plane.conjugate_points[k].t - pi / w * static_cast<double>(k + 1)) < 1e-8);  // det X has a double zero there
  }
}

// From θ = 0 to θ = 0 in half of the period of 1.3 rad (that is 7.019250311844546): rest, and a swing to either side with θ̇
// = 2 sin 0.65.
TEST_CASE("a pendulum goes between two places in several ways, of which rest is not the least") {
  const double T = 0.5 * 7.019250311844546549770542;
  const auto pendulum = line({.pull = 1.0});
  for (const double side : {1.0, -1.0}) {
    const auto swing = boundary_value_problem(pendulum, V1(0.0), 0.0, V1(0.0), T, [&](const auto& t) {
      using std::sin;
      return vector(side * 1.2 * sin(pi / T * t));
    });
    INFO(swing.message);
    REQUIRE(swing.found());
    CHECK(std::abs(swing.start.qdot[0] - side * 2.0 * std::sin(0.65)) < settled);
    CHECK(swing.index == 0);  // periods grow with the amplitude: neighbours do not meet before
    CHECK(swing.S < T);
  }
  const auto rest = boundary_value_problem(pendulum, V1(0.0), 0.0, V1(0.0), T);
  REQUIRE(rest.found());
  CHECK(std::abs(rest.S - T) < settled);
  CHECK(rest.index == 1);
  CHECK(std::abs(rest.conjugate_points.front().t - pi) < settled);
}

// A great circle through θ = π/2, φ = 0 that rises by β: cos θ = sin β sin s, tan φ = cos β tan s.
TEST_CASE("neighbouring great circles meet at the antipode") {
  const double beta = 0.5, s = 4.0, T = 2.0, phi = std::atan2(std::cos(beta) * std::sin(s), std::cos(s)) + 2 * pi;
  const auto guess = [&](const auto& t) {
    using std::sin;
    return vector(0.5 * pi - 0.45 * sin(2.0 * t), phi / T * t);
  };
  const V2 end(std::acos(std::sin(beta) * std::sin(s)), phi);
  const auto found = boundary_value_problem(surface({.round = true}), V2(0.5 * pi, 0.0), 0.0, end, T, guess);
  INFO(found.message);
  REQUIRE(found.found());
  CHECK(std::abs(found.start.qdot[0] + 2.0 * std::sin(beta)) < settled);
  CHECK(std::abs(found.start.qdot[1] - 2.0 * std::cos(beta)) < settled);
  CHECK(std::abs(found.S - 0.5 * 4.0 * T) < settled);
  REQUIRE(found.conjugate_points.size() == 1);
  CHECK(found.conjugate_points.front().multiplicity == 1);
  CHECK(std::abs(found.conjugate_points.front().t - 0.5 * pi) < settled);

  const auto over_the_pole = boundary_value_problem(surface({.round = true}), V2(0.5, 0.0), 0.0, V2(-0.5, 0.0), 1.0);
  CHECK(over_the_pole.outcome == BoundaryValueOutcome::run_failed);
  CHECK(over_the_pole.message.find("give a path that keeps away from there") != std::string::npos);
}

// k = −9: neighbours part by e¹² on the way; q = cosh 3(t − 2) / cosh 6.
TEST_CASE("a motion is found between places although its neighbours part quickly") {
  const auto found = boundary_value_problem(line({.k = -9.0}), V1(1.0), 0.0, V1(1.0), 4.0);
  INFO(found.message);
  REQUIRE(found.found());
  CHECK(std::abs(found.start.qdot[0] + 3.0 * std::tanh(6.0)) < settled);
  CHECK(std::abs(found.residual[0]) < 1e-5);  // e¹² times the tolerance
  CHECK(found.index == 0);
}

TEST_CASE("ends that are conjugate, and a search that ends early, are outcomes with a name") {
  const auto oscillator = line({.k = 1.0});
  const auto nowhere = boundary_value_problem(oscillator, V1(0.0), 0.0, V1(1.0), pi);
  CHECK(nowhere.outcome == BoundaryValueOutcome::conjugate_ends);
  CHECK(nowhere.message.find("neighbours that leave the start with different velocities meet at t = 3.1415927") != std::string::npos);
  INFO(nowhere.message);
  CHECK(nowhere.message.find("where the search ended, it is off by ") != std::string::npos);
  CHECK(std::abs(nowhere.residual[0] + 1.0) < settled);
  const auto one_of_many = boundary_value_problem(oscillator, V1(0.0), 0.0, V1(0.0), pi);
  CHECK(one_of_many.outcome == BoundaryValueOutcome::conjugate_ends);
  CHECK(std::abs(one_of_many.residual[0]) < settled);

  const auto early = boundary_value_problem(line({.pull = 1.0}), V1(0.0), 0.0, V1(2.5), 3.0, qdot::BoundaryValueOptions{.most_iterations = 1});
  CHECK(early.outcome == BoundaryValueOutcome::not_found);
  CHECK(early.message.find("the legs must meet, but where the search ended, it is off by") != std::string::npos);
  CHECK(error_message([&] { return boundary_value_problem(oscillator, V1(0.0), 2.0, V1(1.0), 1.0); }) ==
        "boundary_value_problem: the end must be later than the start, but they are t = 2 and 1; give them in order");
  CHECK(error_message([&] { return boundary_value_problem(oscillator, V1(0.0), 0.0, V1(NAN), 1.0); })
            .find("both ends must be finite, but q0 goes from 0 to nan") != std::string::npos);
}
