// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "../catch2_bridge.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/symplectic.hpp"

namespace {

using namespace qdot;

constexpr double pi = 3.14159265358979323846;

const auto kepler = mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); },
                                         [](const auto& q) {
                                           using std::sqrt;
                                           return -1.0 / sqrt(q[0] * q[0] + q[1] * q[1]);
                                         });
const State<2> perihelion{0.0, {0.4, 0.0}, {0.0, 2.0}};  // e = 0.6, period 2π, H = −1/2, angular momentum 0.8

double angular_momentum(const State<2>& s) { return s.q[0] * s.qdot[1] - s.q[1] * s.qdot[0]; }

TEST_CASE("McLachlan and Atela's method reproduces the published energy errors of a Kepler orbit") {
  // SUNDIALS 7.5.0, example ark_kepler (MCLACHLAN_4_4), its output files: H(50) − H(0) for fixed steps.
  const double published[3][2] = {{0.1, -5.3723049984188975e-06}, {0.05, -2.77646171387147e-07}, {0.025, -1.725032383603775e-08}};
  constexpr double six_digits = 1e-6;
  for (const auto& [h, energy_error] : published) {
    const auto run = simulate(kepler, perihelion, 50.0, Splitting{.step = h, .scheme = SplittingScheme::mclachlan_atela_4});
    CHECK(run.completed());
    CHECK(run.t == 50.0);
    CHECK(run.statistics.steps == std::lround(50 / h));
    CHECK_THAT(energy(kepler, run.state()) - energy(kepler, perihelion), WithinRel(energy_error, six_digits));
    CHECK_THAT(angular_momentum(run.state()), WithinAbs(0.8, 1e-14));
  }
}

struct Known {
  SplittingScheme scheme;
  double order;
  double h;  // coarse step at which the error is the leading term, well above rounding
};
const Known schemes[] = {{SplittingScheme::verlet, 2, 0.02},           {SplittingScheme::yoshida_4, 4, 0.02},
                         {SplittingScheme::mclachlan_atela_4, 4, 0.04}, {SplittingScheme::blanes_moan_4, 4, 0.06},
                         {SplittingScheme::kahan_li_6, 6, 0.06},       {SplittingScheme::blanes_moan_6, 6, 0.15},
                         {SplittingScheme::kahan_li_8, 8, 0.12}};

TEST_CASE("kicks and drifts each add up to one step") {
  for (const Known& known : schemes) {
    double kicks = 0.0, drifts = 0.0;
    for (const double b : detail::splitting(known.scheme).kicks) kicks += b;
    for (const double a : detail::splitting(known.scheme).drifts) drifts += a;
    CHECK_THAT(kicks, WithinAbs(1.0, 4e-15));  // 15 digits were published for some
    CHECK_THAT(drifts, WithinAbs(1.0, 4e-15));
    CHECK(detail::splitting(known.scheme).order == static_cast<int>(known.order));
  }
}

TEST_CASE("every recipe converges with its order, forward and backward in time") {
  // A pendulum beside a stiffer one, coupled and driven: no symmetry hides an order.
  const auto driven = mechanical_system<2>([](const auto& v) { return 0.5 * v[0] * v[0] + v[1] * v[1] + 0.5 * v[0] * v[1]; },
                                           [](const auto& q, const auto& t) {
                                             using std::cos, std::sin;
                                             return -cos(q[0]) + 0.3 * q[0] * q[1] * q[1] + 2.0 * q[1] * q[1] + 0.2 * q[0] * sin(t);
                                           });
  const State<2> start{0.3, {1.0, 0.5}, {0.2, -0.4}};
  for (const double t_end : {2.3, -1.7}) {
    const auto exact = simulate(driven, start, t_end, Dop853{}, {.rtol = 1e-14, .atol = 1e-15});
    for (const Known& known : schemes) {
      const auto error = [&](double h) {
        return (simulate(driven, start, t_end, Splitting{.step = h, .scheme = known.scheme}).y - exact.y).norm();
      };
      const double h = 2 * known.h;
      const double order = std::log2(error(h) / error(h / 2));
      INFO(detail::splitting(known.scheme).name << " to t = " << t_end << ", errors " << error(h) << ", " << error(h / 2));
      CHECK(order > known.order - 0.8);
      CHECK(order < known.order + 1.6);
    }
  }
}

// A thousand are in tests/optimized/million_periods.test.cpp.
TEST_CASE("the energy error of a Kepler orbit does not grow over a hundred periods") {
  for (const Known& known : schemes) {
    double early = 0.0, late = 0.0;
    const double t_end = 100 * 2 * pi;
    const double scale = std::min(known.h, 0.06);
    simulate(kepler, perihelion, t_end, Splitting{.step = scale, .scheme = known.scheme}, {.keep_trajectory = false},
             [&](const StepView& step) {
               const double error = std::abs(energy(kepler, State<2>{0.0, step.q(), step.qdot()}) + 0.5);
               if (step.t() < 0.1 * t_end) early = std::max(early, error);
               if (step.t() > 0.9 * t_end) late = std::max(late, error);
             });
    INFO(detail::splitting(known.scheme).name << " early " << early << ", late " << late);
    CHECK(late < 1.5 * early);
    CHECK(early < 0.05);
  }
}

TEST_CASE("a palindrome run forth and back returns to rounding") {
  const Splitting method{.step = 0.05, .scheme = SplittingScheme::blanes_moan_6};
  const auto forth = simulate(kepler, perihelion, 20.0, method);
  const auto back = simulate(kepler, forth.state(), 0.0, method);
  CHECK((back.y - Eigen::Vector4d(0.4, 0.0, 0.0, 2.0)).norm() < 1e-13);
}

TEST_CASE("the compensated sum keeps what a plain one loses") {
  double sum = 1.0, lost = 0.0;
  for (int i = 0; i < 1000000; ++i) detail::add_compensated(sum, lost, 1e-17);
  CHECK_THAT(sum + lost, WithinAbs(1.0 + 1e-11, 1e-26));
}

TEST_CASE("dense output meets the steps and follows the motion between them") {
  const auto run = simulate(kepler, perihelion, 5.0, Splitting{.step = 0.01});
  const auto exact = simulate(kepler, perihelion, 5.0, Dop853{}, {.rtol = 1e-13, .atol = 1e-14});
  for (const double t : {0.004, 0.01, 1.2345, 4.999}) CHECK((run.trajectory.y(t) - exact.trajectory.y(t)).norm() < 1e-8);
}

TEST_CASE("what a splitting method cannot do is said") {
  const auto relativistic = mechanical_system<1>([](const auto& v) {
    using std::sqrt;
    return 1.0 - sqrt(1.0 - v[0] * v[0] / 9.0);
  });
  const State<1> start{0.0, Vector<double, 1>(0.0), Vector<double, 1>(0.5)};
  CHECK_THROWS_WITH(simulate(relativistic, start, 1.0, Splitting{}),
                    "a splitting method needs a kinetic energy that is quadratic in qdot, but its mass matrix differs between "
                    "qdot = 0 and qdot = 1; use Gauss");
  CHECK_THROWS_WITH(simulate(kepler, perihelion, 1.0, Splitting{.step = -0.1}),
                    "step must be positive and finite, but is -0.1; a fixed-step method needs one: try a thirtieth of the "
                    "shortest period");
  const auto fall = simulate(kepler, State<2>{0.0, {0.4, 0.0}, {0.0, 0.0}}, 1.0, Splitting{.step = 0.4, .scheme = SplittingScheme::verlet});
  CHECK((fall.completed() || fall.outcome == Outcome::non_finite));
}

}  // namespace
