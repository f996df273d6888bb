// SPDX-License-Identifier: MIT
#include "qdot/analysis/lyapunov.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "catch2_bridge.hpp"
#include "error_message.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/dissipation.hpp"
#include "scenes/double_pendulum.hpp"

using qdot::Dop853;
using qdot::lyapunov_spectrum;
using qdot::Outcome;
using qdot::State;

namespace {

const qdot::Options fine{.rtol = 1e-12, .atol = 1e-13};
// Of exponents that are reached exponentially: deviations of size one to rounding and the tolerance, for 90 units of time.
constexpr double settled = 1e-10;

// A hill of unit mass, V = −½ k q²: λ = ±√k at its top.
struct Hill {
  double k = 4.0;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const { return -0.5 * k * q[0] * q[0]; }
};
const auto top = qdot::mechanical_system<1>(Hill{});
const State<1> at_rest{0.0, {0.0}, {0.0}};

}  // namespace

TEST_CASE("the exponents at the top of a hill are its rates of growth and decay, and the run may be long or backward") {
  for (const double t_end : {100.0, 500.0, -100.0}) {
    CAPTURE(t_end);
    const auto found = lyapunov_spectrum(top, at_rest, t_end, Dop853{}, fine);
    REQUIRE(found.completed());
    CHECK(std::abs(found.lambda[0] - 2.0) < settled);
    CHECK(std::abs(found.lambda[1] + 2.0) < settled);
    CHECK(found.standard_error.maxCoeff() < settled);
    CHECK(found.t == t_end);
  }
}

TEST_CASE("an interval in which directions part too far is halved") {
  const auto found = lyapunov_spectrum(top, at_rest, 100.0, Dop853{}, fine, {.interval = 30.0});
  CHECK(std::abs(found.lambda[0] - 2.0) < settled);
  CHECK(std::abs(found.lambda[1] + 2.0) < settled);
}

TEST_CASE("an interval longer than the run, and a time to settle that is no number beside the start, are counted from where they are met") {
  const auto once = lyapunov_spectrum(top, at_rest, 20.0, Dop853{}, fine, {.interval = 1e9});
  REQUIRE(once.lambda.size() == 2);
  CHECK(std::abs(once.lambda[0] - 2.0) < 1e-3);  // settled as far as exp(-8)
  constexpr double t0 = 1.7e9;
  const auto late = lyapunov_spectrum(top, State<1>{t0, {0.0}, {0.0}}, t0 + 40.0, Dop853{}, fine, {.settle = 10.1234567891});
  REQUIRE(late.completed());
  CHECK(std::abs(late.lambda[0] - 2.0) < 1e-8);  // a time of 40 is known to 1e-8 there
}

TEST_CASE("with a damper the exponents solve s^2 + c s - k = 0") {
  constexpr double c = 3.0, k = 4.0;  // s = 1 and −4
  const auto found = lyapunov_spectrum(scene(top, qdot::viscous_damping(qdot::Vector<double, 1>(c))), at_rest, 60.0, Dop853{}, fine);
  REQUIRE(found.lambda.size() == 2);
  CHECK(std::abs(found.lambda[0] - (-c + std::sqrt(c * c + 4 * k)) / 2) < settled);
  CHECK(std::abs(found.lambda[1] - (-c - std::sqrt(c * c + 4 * k)) / 2) < settled);
}

// A mass point on a circle of radius l, standing on its top: ±√(g/l) along the circle, and nothing across it.
TEST_CASE("on a constraint there are exponents along it and none across") {
  constexpr double l = 0.25;  // and g = 9
  const auto point = qdot::mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }, [](const auto& q) { return 9.0 * q[1]; });
  const auto rod = qdot::holonomic("rod", [](const auto& q) { return q[0] * q[0] + q[1] * q[1] - 0.0625; });
  const auto found = lyapunov_spectrum(scene(point, rod), State<2>{0.0, {0.0, l}, {0.0, 0.0}}, 30.0, Dop853{}, fine, {.interval = 0.25});
  REQUIRE(found.lambda.size() == 2);
  CHECK(std::abs(found.lambda[0] - 6.0) < settled);
  CHECK(std::abs(found.lambda[1] + 6.0) < settled);
}

TEST_CASE("what events do to deviations counts") {
  // A free particle whose velocity is doubled once in each unit of time.
  const auto doubling = qdot::event("doubling", [](const auto&, const auto&, const auto& t) {
                          using std::cos;
                          return cos(std::numbers::pi * t);
                        }).then([](State<1>& s) { s.qdot *= 2.0; });
  const auto found = lyapunov_spectrum(qdot::mechanical_system<1>(Hill{0.0}), at_rest, 80.0, Dop853{}, fine, {.settle = 40.0}, qdot::events(doubling));
  REQUIRE(found.completed());
  CHECK(std::abs(found.lambda[0] - std::log(2.0)) < settled);
  CHECK(std::abs(found.lambda[1]) < settled);
}

// T, V of one's own computation in extended precision: the largest singular value of the tangent at t = 10, nine digits.
TEST_CASE("the double pendulum stretches a deviation as a computation in extended precision says") {
  const auto system = qdot::mechanical_system<2>(qdot::scenes::DoublePendulum{});
  const State<2> released{0.0, {1.7, 1.7}, {0.0, 0.0}};
  const auto s = qdot::sensitivities(system, released, 10.0, Dop853{}, {.rtol = 1e-13, .atol = 1e-14});
  const auto axes = qdot::stretching(s.Phi);
  CHECK(std::abs(axes.sigma[0] - 103590.440) < 5e-4);
  CHECK((s.Phi * axes.start.col(0) - axes.sigma[0] * axes.end.col(0)).norm() < 1e-10 * axes.sigma[0]);

  // In pieces and undivided the product of all lengths is the same, det Φ = det M(0) / det M(t) by Liouville.
  const auto spectrum = lyapunov_spectrum(system, released, 10.0, Dop853{}, {.rtol = 1e-13, .atol = 1e-14}, {.settle = 0.0});
  const auto det = [&](const Eigen::VectorXd& y) { return qdot::mass_matrix(system, Eigen::Vector2d(y.head(2)), Eigen::Vector2d(y.tail(2))).determinant(); };
  Eigen::VectorXd y0(4);
  y0 << released.q, released.qdot;
  CHECK(std::abs(10.0 * spectrum.lambda.sum() - std::log(det(y0) / det(spectrum.y))) < 1e-9);
  CHECK((spectrum.y - s.y).norm() < 1e-7);  // rounding of new starts, 1e-13, stretched by σ₁
  // Energy is conserved and flows: two exponents go to zero, and the others are a pair.
  const auto late = lyapunov_spectrum(system, released, 100.0, Dop853{}, {.rtol = 1e-9, .atol = 1e-9});
  CHECK(late.lambda[0] > 0.6);
  CHECK(std::abs(late.lambda.sum()) < 0.02);  // ln(det M(0) / det M(t)) / 90
  CHECK(std::abs(late.lambda[1]) + std::abs(late.lambda[2]) < 0.35);  // ln t / t, and some
}

TEST_CASE("what cannot be asked of a spectrum is refused, and a run that fails keeps what was counted") {
  CHECK(qdot::error_message([] {
          lyapunov_spectrum(top, at_rest, 10.0, Dop853{}, fine, {.interval = 0.0});
        }).starts_with("the interval between orthonormalizations must be positive, but is 0;"));
  CHECK(qdot::error_message([] {
          lyapunov_spectrum(top, at_rest, 10.0, Dop853{}, fine, {.settle = 10.0});
        }).starts_with("the time to settle must lie within the run, but is 10 of 10;"));
  CHECK(qdot::error_message([] { lyapunov_spectrum(top, at_rest, std::numeric_limits<double>::quiet_NaN(), Dop853{}, fine); }) ==
        "the end of the run must be finite and not its start, but it is nan from 0; give it a time");
  CHECK(qdot::error_message([] { lyapunov_spectrum(top, State<1>{1.7e9, {0.0}, {0.0}}, 1.7e9 + 1.0, Dop853{}, fine, {.interval = 1e-8}); })
            .starts_with("the interval between orthonormalizations must be longer than the times resolve, but 1e-08 is below 3.02e-06;"));
  CHECK(qdot::error_message([] {
          lyapunov_spectrum(top, at_rest, 10.0, Dop853{}, fine, {.directions = 3});
        }).find("but 3 were asked for") != std::string::npos);
  CHECK(qdot::error_message([] {
          qdot::stretching(Eigen::MatrixXd::Constant(2, 2, std::numeric_limits<double>::quiet_NaN()));
        }).find("must be finite") != std::string::npos);
  const auto away = lyapunov_spectrum(top, State<1>{0.0, {1e-3}, {0.0}}, 100.0, Dop853{},
                                      {.rtol = 1e-12, .atol = 1e-12, .state_norm_limit = 1e9}, {.settle = 2.0});
  CHECK(away.outcome == Outcome::state_limit);
  CHECK(away.t > 10.0);
  CHECK(std::abs(away.lambda[0] - 2.0) < 1e-3);  // settled as far as e^(−8)
}
