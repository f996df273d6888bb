// SPDX-License-Identifier: MIT
#include "qdot/analysis/lyapunov.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "catch2_bridge.hpp"
#include "error_message.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/input.hpp"
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
                        }).action([](State<1>& s) { s.qdot *= 2.0; });
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
  const auto axes = qdot::finite_time_lyapunov(s.Phi);
  CHECK(std::abs(axes.sigma[0] - 103590.440) < 5e-4);
  CHECK((s.Phi * axes.start.col(0) - axes.sigma[0] * axes.end.col(0)).norm() < 1e-10 * axes.sigma[0]);
  CHECK_THAT(axes.exponents(10.0)[0], WithinAbs(1.15482003, 1e-8));  // ln(103590.440)/10

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
          qdot::finite_time_lyapunov(Eigen::MatrixXd::Constant(2, 2, std::numeric_limits<double>::quiet_NaN()));
        }).find("must be finite") != std::string::npos);
  const auto away = lyapunov_spectrum(top, State<1>{0.0, {1e-3}, {0.0}}, 100.0, Dop853{},
                                      {.rtol = 1e-12, .atol = 1e-12, .state_norm_limit = 1e9}, {.settle = 2.0});
  CHECK(away.outcome == Outcome::state_limit);
  CHECK(away.t > 10.0);
  CHECK(std::abs(away.lambda[0] - 2.0) < 1e-3);  // settled as far as e^(−8)
}

namespace {

using One = qdot::Vector<double, 1>;

// ż = q/2 − z, Q = z: with q̈ = −2.75 q − 4 q̇ + z the roots of (s² + 4 s + 2.75)(s + 1) − 1/2 are −1/2, −3/2 and −3.
struct Lag {
  One initial_state() const { return One(0.3); }
  template <class S, int n>
  qdot::Vector<S, n> force(const qdot::Vector<S, n>& q, const qdot::Vector<S, n>&, const qdot::Vector<S, 1>& z, const S&) const {
    qdot::Vector<S, n> Q = qdot::Vector<S, n>::Zero(q.size());
    Q[0] = z[0];
    return Q;
  }
  template <class S, int n>
  qdot::Vector<S, 1> state_rate(const qdot::Vector<S, n>& q, const qdot::Vector<S, n>&, const qdot::Vector<S, 1>& z, const S&) const {
    return qdot::Vector<S, 1>(S(0.5 * q[0] - z[0]));
  }
};

const auto drive = qdot::generalized_force([](const auto& q, const auto&, const auto& t) {
  using std::cos;
  return std::remove_cvref_t<decltype(q)>(0.0 * q[0] + 2.0 * cos(1.3 * t));
});
const auto two = [](double k) {  // a block without a spring, and an oscillator
  return qdot::mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); },
                                    [k](const auto& q) { return 0.5 * k * q[1] * q[1] + 0.0 * q[0]; });
};

}  // namespace

TEST_CASE("the exponents of a linear plant with a controller are the real parts of the roots, whatever drives it, is held or stays open") {
  const auto plant = scene(qdot::mechanical_system<1>(Hill{-2.75}), qdot::viscous_damping(One(4.0)), Lag{}, drive, qdot::input("held", 0, 0.2),
                           qdot::contact("far", [](const auto& q) { return 10.0 - q[0]; }));
  const auto found = lyapunov_spectrum(plant, State<1>{0.0, {1.0}, {0.0}}, 40.0, Dop853{}, fine, {.settle = 20.0});
  REQUIRE(found.completed());
  REQUIRE(found.lambda.size() == 3);
  CHECK(std::abs(found.lambda[0] + 0.5) < 1e-8);  // settled as far as exp(−20)
  CHECK(std::abs(found.lambda[1] + 1.5) < 1e-8);
  CHECK(std::abs(found.lambda[2] + 3.0) < 1e-8);
}

// Volume shrinks by c dt along the motion and by e² in each blow.
TEST_CASE("the exponents of an oscillator that strikes a wall add up to -c + N ln(e^2)/t") {
  constexpr double c = 0.2, e = 0.8, t_end = 60.0;
  const auto striker = scene(qdot::mechanical_system<1>(Hill{-4.0}), qdot::viscous_damping(One(c)), drive,
                             qdot::contact("wall", [](const auto& q) { return q[0] + 0.5; }, qdot::restitution(e)));
  const auto run = simulate(striker, State<1>{0.0, {1.0}, {0.0}}, t_end, Dop853{}, fine);
  const auto found = lyapunov_spectrum(striker, State<1>{0.0, {1.0}, {0.0}}, t_end, Dop853{}, fine, {.settle = 0.0});
  REQUIRE(found.completed());
  REQUIRE(found.lambda.size() == 2);
  const auto blows = static_cast<double>(run.events.size());
  CHECK(blows > 10);
  CHECK(std::abs(found.lambda.sum() - (-c + blows * std::log(e * e) / t_end)) < 1e-8);
}

TEST_CASE("a ball that bounces without loss for ever, and blows that fall on the ends of intervals, have exponents that cancel") {
  const auto ball = scene(qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 8.0 * q[0]; }),
                          qdot::contact("floor", [](const auto& q) { return q[0]; }, qdot::restitution(1.0)));
  // Blows at 1/2, 3/2, …, and with half of the interval at its ends.
  for (const double interval : {1.0, 0.5}) {
    const auto found = lyapunov_spectrum(ball, State<1>{0.0, {1.0}, {0.0}}, 30.0, Dop853{}, fine, {.interval = interval, .settle = 0.0});
    REQUIRE(found.completed());
    REQUIRE(found.lambda.size() == 2);
    CHECK(std::abs(found.lambda.sum()) < settled);
    CHECK(found.lambda[0] > 0.0);
    CHECK(found.lambda[0] < std::log(1.0 + 30.0 * 8.0) / 30.0);  // a shear: both go to zero like ln t / t
  }
}

TEST_CASE("what lies on a floor or sticks has exponents along it, and what comes to rest says how many are left") {
  const auto lies = scene(qdot::mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); },
                                                     [](const auto& q) { return 9.81 * q[1]; }),
                          qdot::contact("floor", [](const auto& q) { return q[1]; }));
  const auto along = lyapunov_spectrum(lies, State<2>{0.0, {0.0, 0.0}, {1.0, 0.0}}, 50.0, Dop853{}, fine);
  REQUIRE(along.lambda.size() == 2);
  CHECK(std::abs(along.lambda.sum()) < settled);
  CHECK(along.lambda[0] < 0.1);  // δx = δv t
  const auto falls = lyapunov_spectrum(lies, State<2>{0.0, {0.0, 0.3}, {1.0, 0.0}}, 5.0, Dop853{}, fine);
  CHECK(falls.outcome == Outcome::not_differentiable);
  CHECK(falls.message.find("ask for fewer directions, of which there are left 2") != std::string::npos);

  const auto block = scene(two(2.0), qdot::dry_friction("pad", 0, 1.0), qdot::viscous_damping(qdot::Vector<double, 2>(0.0, 3.0)));
  const auto stuck = lyapunov_spectrum(block, State<2>{0.0, {0.2, 1.0}, {0.0, 0.0}}, 50.0, Dop853{}, fine, {.settle = 25.0});
  REQUIRE(stuck.lambda.size() == 3);
  for (int i = 0; i < 3; ++i) CHECK(std::abs(stuck.lambda[i] + i) < settled);  // 0 of the place, −1 and −2 of the oscillator
  const auto stops = lyapunov_spectrum(block, State<2>{0.0, {0.2, 1.0}, {1.5, 0.0}}, 20.0, Dop853{}, fine);
  CHECK(stops.outcome == Outcome::not_differentiable);
  CHECK(stops.message.find("of which there are left 3") != std::string::npos);
  const auto left = lyapunov_spectrum(block, State<2>{0.0, {0.2, 1.0}, {1.5, 0.0}}, 50.0, Dop853{}, fine, {.settle = 25.0, .directions = 3});
  REQUIRE(left.lambda.size() == 3);
  for (int i = 0; i < 3; ++i) CHECK(std::abs(left.lambda[i] + i) < settled);

  const auto pressed = scene(qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 9.81 * q[0]; }),
                             qdot::contact("floor", [](const auto& q) { return q[0]; }));
  CHECK(qdot::error_message([&] { lyapunov_spectrum(pressed, at_rest, 5.0, Dop853{}, fine); })
            .starts_with("something must be free to deviate, but the constraints and phases at t = 0 determine all of the motion"));
}
