// SPDX-License-Identifier: MIT
#include "qdot/analysis/return_map.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include "catch2_bridge.hpp"
#include "error_message.hpp"
#include "star.hpp"

using qdot::Dop853;
using qdot::Outcome;
using qdot::return_map;
using qdot::SectionOutcome;
using qdot::State;
using stars::on_plane;
using stars::plane;

namespace {

const double pi = std::numbers::pi, w = std::sqrt(2.0);
const qdot::Options fine{.rtol = 1e-13, .atol = 1e-14};
constexpr double settled = 1e-11;  // of one return

const State<2> start{0.0, {0.0, 0.4}, {1.0, 0.3}};

double largest(const Eigen::MatrixXd& A) { return A.cwiseAbs().maxCoeff(); }

}  // namespace

// x = A sin t returns after 2π whatever A is; (y, ẏ/w) has turned by 2π w.
TEST_CASE("the derivative of the return map of two oscillators is a rotation") {
  const auto P = return_map(stars::oscillators, start, plane(), 100.0, Dop853{}, fine);
  INFO(P.message);
  REQUIRE(P.complete());
  CHECK(std::abs(P.t - 2 * pi) < settled);
  const double c = std::cos(2 * pi * w), s = std::sin(2 * pi * w);
  Eigen::MatrixXd rotation(2, 2), with_speed(3, 3);
  rotation << c, s / w, -w * s, c;
  with_speed << c, 0, s / w, 0, 1, 0, -w * s, 0, c;
  CHECK(largest(P.derivative_in({1, 3}) - rotation) < settled);
  CHECK(largest(P.derivative_in({1, 2, 3}) - with_speed) < settled);
  CHECK(largest(P.derivative.row(0)) < settled);  // the return is on x = 0
  Eigen::VectorXd time = Eigen::VectorXd::Zero(4);
  time[0] = -1.0;  // who begins ahead returns earlier, by δx/ẋ
  CHECK(largest(P.time - time) < settled);
  CHECK(largest(P.state().q - State<2>{0.0, {0.0, 0.4 * c + 0.3 / w * s}, {0.0, 0.0}}.q) < settled);
}

// A start off the surface, x = −0.5, ẋ = 1, y = 0.4, reaches x = 0 at the phase atan(0.5).
TEST_CASE("a start beside the surface has the derivative of its way there") {
  const auto P = return_map(stars::oscillators, State<2>{0.0, {-0.5, 0.4}, {1.0, 0.0}}, plane(), 100.0, Dop853{}, fine);
  REQUIRE(P.complete());
  const double t = std::atan(0.5), speed = std::sqrt(1.25), ydot = -0.4 * w * std::sin(w * t);
  CHECK(std::abs(P.t - t) < settled);
  CHECK(std::abs(P.time[0] + std::cos(t) / speed) < settled);
  CHECK(std::abs(P.time[2] + std::sin(t) / speed) < settled);
  CHECK(std::abs(P.derivative(1, 0) - ydot * P.time[0]) < settled);
  CHECK(std::abs(P.derivative(1, 1) - std::cos(w * t)) < settled);
}

// P R P = R with R = diag(1, −1), and P keeps areas, for y and ẏ are conjugate.
TEST_CASE("the return map of Hénon's and Heiles' star keeps areas and is undone by going back") {
  for (const double E : {1.0 / 12.0, 1.0 / 8.0}) {
    const auto P = return_map(stars::henon_heiles, on_plane(E, 0.1, 0.07), plane(), 100.0, Dop853{}, fine);
    REQUIRE(P.complete());
    const auto there = P.state();
    const auto back = return_map(stars::henon_heiles, State<2>{0.0, there.q, {there.qdot[0], -there.qdot[1]}}, plane(), 100.0, Dop853{}, fine);
    REQUIRE(back.complete());
    Eigen::MatrixXd R = Eigen::MatrixXd::Identity(2, 2);
    R(1, 1) = -1.0;
    const Eigen::MatrixXd D = P.derivative_in({1, 3});
    CHECK(std::abs(D(0, 0) * D(1, 1) - D(0, 1) * D(1, 0) - 1.0) < settled);
    CHECK(largest(D * R * back.derivative_in({1, 3}) - R) < 100 * settled);
    // Energy differs behind the return by what it differs in front of it.
    const auto energy_slope = [](const State<2>& s) {
      Eigen::VectorXd slope(4);
      slope << s.q[0] + 2 * s.q[0] * s.q[1], s.q[1] + s.q[0] * s.q[0] - s.q[1] * s.q[1], s.qdot[0], s.qdot[1];
      return slope;
    };
    CHECK(largest(P.energy_slope - energy_slope(on_plane(E, 0.1, 0.07))) < settled);
    CHECK(largest(P.derivative.transpose() * energy_slope(there) - energy_slope(on_plane(E, 0.1, 0.07))) < 100 * settled);
  }
}

TEST_CASE("at a stroboscope the derivative is that at a fixed time") {
  const auto P = return_map(stars::oscillators, start, qdot::event("flash", stars::Plane{.omega = 2.0}).rising(), 100.0, Dop853{}, fine);
  REQUIRE(P.complete());
  CHECK(largest(P.time) < 1e-14);
  CHECK(std::abs(P.derivative(0, 0) - std::cos(pi)) < settled);
  CHECK(std::abs(P.derivative(3, 1) + w * std::sin(w * pi)) < settled);
}

// x = sin t, whose top is 1.
TEST_CASE("a return that only grazes is there without a derivative, and one that fails to come is told") {
  constexpr double depth = 5e-9, tolerance = 1e-9;  // deep enough to be found, not to have slopes that the tolerance leaves alone
  const auto shallow = return_map(stars::oscillators, start, plane(1.0 - depth), 100.0, Dop853{}, {.rtol = tolerance, .atol = tolerance});
  INFO(shallow.message);
  CHECK(shallow.outcome == SectionOutcome::no_derivative);
  CHECK(shallow.run_outcome == Outcome::not_differentiable);
  CHECK(shallow.message.find("only grazes zero") != std::string::npos);
  CHECK(shallow.derivative.size() == 0);
  CHECK(std::abs(shallow.state().q[0] - 1.0) < 10 * depth);
  const auto missed = return_map(stars::oscillators, start, plane(1.5), 20.0, Dop853{}, fine);
  CHECK(missed.outcome == SectionOutcome::t_end_reached);
  CHECK(missed.derivative.size() == 0);
  CHECK(missed.y.size() == 0);
}

TEST_CASE("a map in entries that cannot be is refused in words") {
  const auto P = return_map(stars::oscillators, start, plane(), 100.0, Dop853{}, fine);
  const auto said = [&](const std::vector<Eigen::Index>& entries) { return qdot::error_message([&] { P.derivative_in(entries); }); };
  CHECK(said({1}) == "a map on the surface is one of 3 different entries of [q; qdot], or of 2 on the energy level, each from 0 to 3, but 1 were given; "
                     "i is q_i, and 2 + i its velocity");
  CHECK(said({1, 1}).starts_with("a map on the surface is one of 3 different entries"));
  CHECK(
      said({0, 1}) ==
      "the entries of a map must tell the points of its surface apart, but those left out, 2 and 3, do not follow from them there; choose others");
  CHECK(
      said({0, 1, 2}) ==
      "the entries of a map must tell the points of its surface apart, but those left out, 3, do not follow from them there; choose others");
  CHECK(qdot::error_message([] {
          qdot::ReturnMap<2>{}.derivative_in({1, 3});
        }) == "the derivative of a return map is not there; look at its outcome and message");
}
