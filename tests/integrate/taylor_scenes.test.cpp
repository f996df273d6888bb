// SPDX-License-Identifier: MIT
//
// Power series of scenes: every effect that is a formula, and a clear word where one is not.
#include <algorithm>
#include <cmath>

#include "../catch2_bridge.hpp"
#include "driven_cart.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/taylor.hpp"

namespace {

using namespace qdot;
using Eigen::Vector2d;

const Options tight{.rtol = 1e-13, .atol = 1e-14, .keep_trajectory = false};

const auto oscillator = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.5 * q[0] * q[0]; });
const State<1> plucked{0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)};

TEST_CASE("a damped oscillator follows its closed form, forward and backward, with the order asked for") {
  constexpr double gamma = 0.1;
  const auto damped = scene(oscillator, viscous_damping(Vector<double, 1>(2 * gamma)));
  const auto exact = [](double t) {
    const double w = std::sqrt(1 - gamma * gamma);
    return Eigen::VectorXd(std::exp(-gamma * t) * Vector2d(std::cos(w * t) + gamma / w * std::sin(w * t), -std::sin(w * t) / w));
  };
  constexpr double rounding = 1e-12;  // of thirty steps, beside e in the growth backward
  for (const double t_end : {20.0, -20.0}) {
    const auto run = simulate(damped, plucked, t_end, Taylor{}, tight);
    REQUIRE(run.completed());
    CHECK((run.y - exact(t_end)).norm() < rounding * std::max(1.0, exact(t_end).norm()));
    const auto error = [&](double h) {  // of order 6 with steps of one length
      return (simulate(damped, plucked, t_end / 5, Taylor{.order = 6}, {.rtol = 0.9, .atol = 1e9, .initial_step = h, .max_step = h}).y -
              exact(t_end / 5))
          .norm();
    };
    const double order = std::log2(error(0.4) / error(0.2));
    INFO("order " << order);
    CHECK(order > 5.5);
    CHECK(order < 7.5);
  }
}

TEST_CASE("a forced oscillator at resonance grows as t/2 sin t") {
  const auto driven = scene(oscillator, generalized_force([](const auto&, const auto&, const auto& t) {
                              using std::cos;
                              return cos(t);
                            }));
  const auto run = simulate(driven, State<1>{0.0, Vector<double, 1>(0.0), Vector<double, 1>(0.0)}, 30.0, Taylor{}, tight);
  REQUIRE(run.completed());
  CHECK_THAT(run.y[0], WithinAbs(15.0 * std::sin(30.0), 1e-11));
}

TEST_CASE("a constant force at a point that tanh places has a series, and the energy of one") {
  // F = (1, ½) at (tanh q, q) does the work tanh q + q/2, so that ½ q̇² + ½ q² − tanh q − q/2 stays what it was.
  const auto point = [](const auto& q) {
    using std::tanh;
    return vector(tanh(q[0]), q[0]);
  };
  const auto s = scene(mechanical_system<1>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return 0.5 * q.squaredNorm(); }),
                       force_at_point(point, Eigen::Vector2d(1.0, 0.5)));
  const auto energy = [](double q, double v) { return 0.5 * v * v + 0.5 * q * q - std::tanh(q) - 0.5 * q; };
  const auto run = simulate(s, State<1>{0.0, Vector<double, 1>(-1.5), Vector<double, 1>(0.0)}, 10.0, Taylor{}, {.rtol = 1e-13, .atol = 1e-15});
  REQUIRE(run.completed());
  CHECK(std::abs(run.y[1]) > 0.1);                                                // it has moved on
  CHECK_THAT(energy(run.y[0], run.y[1]), WithinAbs(energy(-1.5, 0.0), 1e-11));  // ten time units at rtol = 1e-13
}

TEST_CASE("a charge in crossed fields drifts on its cycloid") {
  constexpr double E = 0.7, B = 1.3, t = 30.0;
  const auto charge = scene(mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return -E * q[0]; }),
                            velocity_potential([](const auto& q, const auto& v) { return -0.5 * B * (q[0] * v[1] - q[1] * v[0]); }));
  const auto run = simulate(charge, State<2>{0.0, {0, 0}, {0, 0}}, t, Taylor{}, tight);
  REQUIRE(run.completed());
  CHECK_THAT(run.y[0], WithinAbs(E / (B * B) * (1 - std::cos(B * t)), 1e-11));
  CHECK_THAT(run.y[1], WithinAbs(-E / B * (t - std::sin(B * t) / B), 1e-11));
}

TEST_CASE("states of a controller are part of the series, dense output included") {
  // ẍ = z₀, ż₀ = z₁, ż₁ = x: from (1, −1), (1, −1) all are ±exp(−t). A rate that is a variable, and in the order that shows it.
  const auto chase = scene(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.0 * q[0]; }),
                           controller([](const auto&, const auto&, const auto& z, const auto&) { return z[0]; },
                                      [](const auto& q, const auto&, const auto& z, const auto&) { return vector(z[1], q[0]); },
                                      Vector<double, 2>(1.0, -1.0)));
  const auto run = simulate(chase, State<1>{0.0, Vector<double, 1>(1.0), Vector<double, 1>(-1.0)}, 2.0, Taylor{}, {.rtol = 1e-13, .atol = 1e-14});
  REQUIRE(run.completed());
  for (const double t : {0.3, 1.1, 2.0}) {
    const Eigen::VectorXd y = run.trajectory.y(t);
    for (int i = 0; i < 4; ++i) CHECK_THAT(y[i], WithinAbs((i % 2 == 0 ? 1 : -1) * std::exp(-t), 1e-12));
  }
}

TEST_CASE("a force that is another coordinate is that coordinate's, order by order") {
  // V = −q₀ q₁: ∂L/∂q₀ is q₁ and the other way round. From (1, 1) at rest both are cosh t.
  const auto saddle = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return -q[0] * q[1]; });
  const auto run = simulate(saddle, State<2>{0.0, {1, 1}, {0, 0}}, 3.0, Taylor{}, tight);
  CHECK_THAT(run.y[0], WithinRel(std::cosh(3.0), 1e-12));
  CHECK_THAT(run.y[1], WithinRel(std::cosh(3.0), 1e-12));
}

TEST_CASE("a cart with every analytic effect moves as it does by Dop853") {
  const auto driven = test::driven_cart(
      regularized_friction(0, 0.3, 0.5),
      tension_between(test::pole_tip, Vector2d(-2.0, 0.0), [](const auto& length, const auto& rate) { return 0.1 * length * length + 0.05 * rate; }));
  const State<2> start{0.0, {0.0, 0.5}, {0.0, 0.1}};
  const Eigen::VectorXd exact = simulate(driven, start, 2.0, Dop853{}, {.rtol = 3e-14, .atol = 1e-14, .keep_trajectory = false}).y;
  const auto run = simulate(driven, start, 2.0, Taylor{}, tight);
  REQUIRE(run.completed());
  CHECK((run.y - exact).norm() < 1e-11);
  const auto forth = simulate(driven, start, 0.5, Taylor{}, tight);
  const auto back = simulate(driven, FirstOrderState{forth.t, forth.y}, 0.0, Taylor{}, tight);
  REQUIRE(back.completed());
  CHECK((back.y.head(2) - start.q).norm() < 1e-10);  // backward the motor's damping amplifies by exp(R/L · 0.5 s) = 2e4
}

TEST_CASE("where drag turns round and is not analytic, the test of each step notices, and the run is right to its tolerance") {
  const auto pendulum = scene(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) {
                                using std::cos;
                                return -cos(q[0]);
                              }),
                              quadratic_drag([](const auto& q) {
                                using std::cos, std::sin;
                                return vector(sin(q[0]), -cos(q[0]));
                              }, 0.2));
  const State<1> thrown{0.0, Vector<double, 1>(0.5), Vector<double, 1>(1.0)};
  const Eigen::VectorXd exact = simulate(pendulum, thrown, 20.0, Dop853{}, {.rtol = 1e-13, .atol = 1e-14, .keep_trajectory = false}).y;
  const auto run = simulate(pendulum, thrown, 20.0, Taylor{}, {.rtol = 1e-9, .atol = 1e-9, .keep_trajectory = false});
  INFO(run.message << ", " << run.statistics.steps << " steps, " << run.statistics.rejected_by_error_test << " rejected");
  CHECK(run.completed());
  CHECK((run.y - exact).norm() < 1e-7);
}

// Forces that compare, on a free particle: one type, so that it is compiled once.
enum class Law { friction, saturated, dead_zone, nested, three_at_once, stairs, clock, relay, shrinking, leaving, together, reversed, asked };
struct BranchingForce {
  Law law;
  template <class V, class Time>
  auto operator()(const V& q, const V& qdot, const Time& t) const {
    using S = typename V::Scalar;
    using std::abs, std::copysign, std::floor, std::isfinite, std::max, std::min;
    const S &x = q[0], &v = qdot[0];
    const auto force = [&]() -> S {
      switch (law) {
        case Law::friction: return S(-x + (v > 0.0 ? S(-0.3) : S(0.3)));
        case Law::saturated: return S(-max(S(min(x, S(1.0))), S(-1.0)));
        case Law::dead_zone: return S(-0.4 * v - 9.0 * (x > 0.2 ? S(x - 0.2) : x < -0.2 ? S(x + 0.2) : S(0.0)));
        case Law::nested: return x > 0.0 ? (v > 0.0 ? S(-x - 0.5) : S(-x - 0.2)) : (t < 7.5 ? S(-x) : S(-2.0 * x));
        case Law::three_at_once: return S(-x + (x > 0.0 && v > 0.0 && t < 9.0 ? S(0.4) : S(0.0)));
        case Law::stairs: return S(-floor(x + 0.5) - 0.05 * v);
        case Law::clock: return S(-x - 0.1 * v + (abs(x) < 0.2 && v > 0.0 ? S(1.0) : S(0.0)));
        case Law::relay: return x + v > 0.0 ? S(-1.0) : S(1.0);
        case Law::shrinking: return S((x < 0.0 ? S(1.0) : S(-1.0)) + (v > 0.0 ? S(-0.5) : S(0.5)));
        case Law::leaving: return x < 0.0 ? S(1.0) : S(2.0);
        case Law::together: return x > 0.0 ? (t > 1.0 ? S(1.0) : S(5.0)) : S(0.0);
        case Law::reversed: return S(-x - copysign(S(0.3), v));
        default: return isfinite(x) ? S(-x) : S(0.0);
      }
    };
    return qdot::vector(force());
  }
};
auto pushed(Law law) {
  static const auto free = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.0 * q[0]; });
  return scene(free, generalized_force(BranchingForce{law}));
}
State<1> moving(double t, double q, double v) { return {t, Vector<double, 1>(q), Vector<double, 1>(v)}; }

TEST_CASE("forces that branch are right to rounding behind their switches") {
  constexpr double rounded_in_a_run = 1e-14;  // after ten to forty steps
  struct Case {
    Law law;
    double q0, v0, t, q, v;  // closed forms in 25 digits
  };
  for (const Case& c : {
           Case{Law::friction, 2.0, 0.5, 5.0, -0.2152199592056561263706370, 1.150601252663926105914436},
           Case{Law::saturated, 3.0, 0.0, 20.0, 2.957712117396535280115952, -0.2908191279935510702859501},
           Case{Law::dead_zone, 1.0, 0.0, 6.0, 0.2554817414568629683275514, -0.5365134864899967499084266},
           Case{Law::nested, -1.0, 0.0, 15.0, -0.2950843722909043820848663, 0.1459530016642007981065445},
           Case{Law::three_at_once, -1.0, 0.1, 14.0, -0.8515170778304592219402999, 1.576943975716178983891511},
           Case{Law::stairs, 5.25, 0.0, 12.0, 3.172887162446868320863247, 2.165797467205666856490394},
           Case{Law::clock, -1.25, 0.0, 20.0, -0.4673759291991146973483234, 0.9210198874983776181239509},
           Case{Law::clock, -1.036027121108406085689021, 0.0, 6.282797692867881767437703, -1.036027121108406085689021, 0.0},  // a period
           Case{Law::leaving, 0.0, 0.0, 3.0, 9.0, 6.0},  // begins at rest on the switch
           Case{Law::together, -1.0, 1.0, 2.0, 1.5, 2.0},
           Case{Law::reversed, 2.0, -0.0, std::acos(-1.0), -1.4, 0.0},  // half a swing about 0.3
       }) {
    const auto run = simulate(pushed(c.law), moving(0.0, c.q0, c.v0), c.t, Taylor{}, tight);
    CAPTURE(static_cast<int>(c.law), run.message);
    CHECK(run.completed());
    CHECK_THAT(run.y[0], WithinAbs(c.q, rounded_in_a_run));
    CHECK_THAT(run.y[1], WithinAbs(c.v, rounded_in_a_run));
    CHECK(run.statistics.steps < 60);
  }
}

TEST_CASE("friction at rest, a relay that slides and switches without end are named where they begin") {
  struct Case {
    Law law;
    double q0, v0, at;  // closed forms
  };
  for (const Case& c : {Case{Law::friction, 2.0, 0.5, 9.638838644333200}, Case{Law::relay, 0.5, 0.25, 0.6861406616345071649626529},
                        Case{Law::shrinking, 1.0, 0.0, 6.309401076758503058036595}}) {
    const auto run = simulate(pushed(c.law), moving(0.0, c.q0, c.v0), 20.0, Taylor{}, tight);
    CAPTURE(static_cast<int>(c.law), run.message);
    CHECK(run.outcome == Outcome::zeno);
    CHECK_THAT(run.t, WithinAbs(c.at, 1e-12));
    CHECK(run.message.find("the comparison > in the force of an effect") != std::string::npos);
    CHECK(run.statistics.steps < 300);
  }
  // Backward from rest every past is possible.
  CHECK(simulate(pushed(Law::friction), moving(20.0, -0.25372045918796404, 0.0), 0.0, Taylor{}).outcome == Outcome::refused_by_model);
}

TEST_CASE("forces that ask for a plain value are refused in words") {
  CHECK_THROWS_WITH(simulate(pushed(Law::asked), plucked, 1.0, Taylor{}),
                    "a Taylor series needs functors that are formulas between their comparisons, but the force of an effect asks for the plain value of a number "
                    "(isfinite, isnan, isinf); use Dop853, which takes them as they are");
  const auto looked_up = scene(oscillator, generalized_force([](const auto& q, const auto&) {
                                 const double plain = static_cast<double>(innermost_value(q[0]));
                                 return -std::floor(plain) * q[0];
                               }));
  CHECK_THROWS_AS(simulate(looked_up, plucked, 1.0, Taylor{}), NotAnalytic);
}

}  // namespace
