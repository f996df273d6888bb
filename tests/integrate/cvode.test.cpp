// SPDX-License-Identifier: MIT
#include "qdot/integrate/cvode.hpp"

#include <cmath>
#include <thread>
#include <utility>
#include <vector>

#include "catch2_bridge.hpp"
#include "first_order_systems.hpp"
#include "qdot/integrate/simulate.hpp"

using qdot::Corrector;
using qdot::CvodeAdams;
using qdot::CvodeBdf;
using qdot::CvodeStepper;
using qdot::FirstOrderState;
using qdot::Options;
using qdot::simulate;

namespace {

const FirstOrderState oscillator_start{0.0, test::vector({1.0, 0.0})};

// Global error allowed at a tolerance: a multistep code adds up its local errors, here over some hundred steps.
constexpr double accumulated = 300;

template <class Method>
double oscillator_error(const Method& method, double rtol, double t_end) {
  const auto run = simulate(test::oscillator(), oscillator_start, t_end, method, {.rtol = rtol, .atol = rtol});
  REQUIRE(run.completed());
  return (run.y - test::vector({std::cos(t_end), -std::sin(t_end)})).norm();
}

}  // namespace

TEST_CASE("the error follows the tolerance for both families and both correctors, forward and backward") {
  for (const double t_end : {10.0, -10.0})
    for (const double rtol : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
      REQUIRE(oscillator_error(CvodeBdf{}, rtol, t_end) < accumulated * rtol);
      REQUIRE(oscillator_error(CvodeAdams{}, rtol, t_end) < accumulated * rtol);
      REQUIRE(oscillator_error(CvodeAdams{.corrector = Corrector::fixed_point}, rtol, t_end) < accumulated * rtol);
    }
}

TEST_CASE("a decaying exponential keeps its relative accuracy") {
  const auto run = simulate(test::decay(2.0), FirstOrderState{0.0, test::vector({3.0})}, 5.0, CvodeBdf{},
                            {.rtol = 1e-10, .atol = 1e-16});
  REQUIRE_THAT(run.y[0], WithinRel(3.0 * std::exp(-10.0), accumulated * 1e-10));
}

TEST_CASE("a run forth and back returns to its start") {
  const FirstOrderState start{0.0, test::vector({1.0, 0.0})};
  const auto forth = simulate(test::pendulum(), start, 10.0, CvodeAdams{}, {.rtol = 1e-11, .atol = 1e-11});
  const auto back =
      simulate(test::pendulum(), FirstOrderState{10.0, forth.y}, 0.0, CvodeAdams{}, {.rtol = 1e-11, .atol = 1e-11});
  REQUIRE(back.t == 0.0);
  REQUIRE((back.y - start.y).norm() < 10 * accumulated * 1e-11);  // errors of a pendulum also grow with t
}

TEST_CASE("the pendulum is where quadruple precision puts it at t = 10") {
  // θ₀ = 1 at rest, g = 9.81, l = 1; reference: Taylor series in quadruple precision.
  constexpr double theta = -0.46325276873178667, thetadot = 2.6365495135496304;
  const FirstOrderState start{0.0, test::vector({1.0, 0.0})};
  const Options options{.rtol = 1e-12, .atol = 1e-12};
  const auto bdf = simulate(test::pendulum(), start, 10.0, CvodeBdf{}, options);
  const auto adams = simulate(test::pendulum(), start, 10.0, CvodeAdams{}, options);
  // Errors of a pendulum grow with t, and BDF adds up three times as many steps; measured 1.8e-9 and 5e-11.
  REQUIRE((bdf.y - test::vector({theta, thetadot})).norm() < 1e-8);
  REQUIRE((adams.y - test::vector({theta, thetadot})).norm() < 3e-10);
}

TEST_CASE("stiff van der Pol reaches its published end state in few steps") {
  // Test Set for IVP Solvers, VDPOL, ε = 1e-6, from (2, 0) at t = 2.
  const auto run = simulate(test::van_der_pol(1e-6), FirstOrderState{0.0, test::vector({2.0, 0.0})}, 2.0, CvodeBdf{},
                            {.rtol = 1e-9, .atol = 1e-9});
  REQUIRE(run.completed());
  REQUIRE_THAT(run.y[0], WithinRel(1.706167732170483, 1e-6));
  REQUIRE_THAT(run.y[1], WithinRel(-0.8928097010247975, 1e-6));
  REQUIRE(run.statistics.steps < 5000);  // an explicit method would need about 1e6
  REQUIRE(run.statistics.jacobians < run.statistics.steps / 4);
}

TEST_CASE("Robertson's kinetics reach their published end state eleven decades later") {
  // Test Set for IVP Solvers, ROBER, t = 1e11.
  const auto run = simulate(test::robertson(), FirstOrderState{0.0, test::vector({1.0, 0.0, 0.0})}, 1e11, CvodeBdf{},
                            {.rtol = 1e-10, .atol = {1e-18, 1e-22, 1e-14}});
  REQUIRE(run.completed());
  REQUIRE_THAT(run.y[0], WithinRel(0.2083340149701255e-7, 1e-5));
  REQUIRE_THAT(run.y[1], WithinRel(0.8333360770334713e-13, 1e-5));
  REQUIRE_THAT(run.y[2], WithinRel(0.9999999791665050, 1e-9));
  REQUIRE(run.trajectory.dof() == 0);  // three components are no coordinates and velocities
}

TEST_CASE("dense output between the steps is as accurate as the steps") {
  for (const double rtol : {1e-6, 1e-9, 1e-12}) {
    for (const double t_end : {20.0, -20.0}) {
      const auto error_of = [&](const auto& method) {
        const auto run = simulate(test::oscillator(), oscillator_start, t_end, method, {.rtol = rtol, .atol = rtol});
        double at_steps = 0, between = 0;
        for (const double t : run.trajectory.times())
          at_steps = std::max(at_steps, std::abs(run.trajectory.y(t)[0] - std::cos(t)));
        for (int i = 0; i <= 10000; ++i) {
          const double t = t_end * i / 10000;
          between = std::max(between, std::abs(run.trajectory.y(t)[0] - std::cos(t)));
        }
        REQUIRE(between < 3 * at_steps + 10 * rtol);
      };
      error_of(CvodeBdf{});
      error_of(CvodeAdams{});
    }
  }
}

TEST_CASE("the trajectory has the accepted states at the accepted times and is continuous") {
  std::vector<std::pair<double, Eigen::VectorXd>> accepted;
  const auto run = simulate(test::pendulum(), FirstOrderState{0.0, test::vector({2.0, 0.0})}, 10.0, CvodeAdams{}, {},
                            [&](const qdot::StepView& step) { accepted.emplace_back(step.t(), step.y()); });
  constexpr double rounding = 1e-13;  // y is of size 10, and t of a step and of CVODE differ by rounding at t_end
  for (const auto& [t, y] : accepted) {
    REQUIRE((run.trajectory.y(t) - y).norm() < rounding);
    if (t < 10.0) REQUIRE((run.trajectory.y(std::nextafter(t, 11.0)) - y).norm() < rounding);
  }
}

TEST_CASE("f is never evaluated behind the end of a leg") {
  double latest = -1;
  const test::FirstOrder watched{
      {"y"},
      [&](double t, const test::In&, test::OutVector d) { latest = std::max(latest, t), d[0] = t; },
      [](double, const test::In&, test::OutMatrix J) { J(0, 0) = 0; }};
  simulate(watched, FirstOrderState{0.0, test::vector({0.0})}, 0.3, CvodeBdf{});
  REQUIRE(latest < 0.3);
}

TEST_CASE("statistics count what the model saw") {
  const test::FirstOrder system = test::van_der_pol(1e-3);
  const auto run = simulate(system, FirstOrderState{0.0, test::vector({2.0, 0.0})}, 2.0, CvodeBdf{});
  const qdot::Statistics& s = run.statistics;
  REQUIRE(s.method == "cvode_bdf");
  const long looks = system.evaluations() - s.evaluations;  // of the watchdog come on top (integrate/watch/any_watch.ipp)
  REQUIRE(looks >= 0);
  REQUIRE(static_cast<double>(looks) < 0.03 * static_cast<double>(s.evaluations));
  REQUIRE(s.steps == static_cast<long>(run.trajectory.steps()));
  REQUIRE(s.rejected() == s.rejected_by_error_test + s.rejected_by_corrector);
  REQUIRE(s.rejected() > 0);
  REQUIRE(s.jacobians > 0);
  REQUIRE(s.linear_setups >= s.jacobians);
  REQUIRE(s.smallest_step > 0);
  REQUIRE(s.smallest_step <= s.first_step);
  REQUIRE(s.highest_order == 5);
  REQUIRE(s.limited_by[0] + s.limited_by[1] == s.steps);
  REQUIRE(s.limiting_component() == 1);  // the velocity jumps, the position follows
}

TEST_CASE("settings of the method and of the run are obeyed") {
  const auto run = [](const auto& method, const Options& options) {
    return simulate(test::oscillator(), oscillator_start, 1.0, method, options).statistics;
  };
  REQUIRE(run(CvodeBdf{.max_order = 2}, {}).highest_order == 2);
  REQUIRE(run(CvodeAdams{.max_order = 7}, {.rtol = 1e-12}).highest_order == 7);
  REQUIRE(run(CvodeBdf{}, {.initial_step = 1e-5}).first_step == Approx(1e-5));
  REQUIRE(run(CvodeBdf{}, {.rtol = 1e-3, .max_step = 1e-3}).steps >= 1000);
  REQUIRE(run(CvodeAdams{.corrector = Corrector::fixed_point}, {}).jacobians == 0);
  REQUIRE_THROWS_AS(run(CvodeBdf{.max_order = 6}, {}), qdot::InvalidValue);
  REQUIRE_THROWS_AS(run(CvodeAdams{.max_order = 13}, {}), qdot::InvalidValue);
}

TEST_CASE("a largest step below the floor of the smallest one is no error") {
  const FirstOrderState late{1e9, test::vector({1.0, 0.0})};  // 16 ε t = 3.6e-6
  const double t_end = 1e9 + 1e-4;
  const auto run = simulate(test::oscillator(), late, t_end, CvodeBdf{}, {.max_step = 1e-6});
  REQUIRE(run.completed());
  REQUIRE_THAT(run.y[0], WithinAbs(std::cos(t_end - 1e9), 1e-8));  // t has a grid of 1.2e-7 here, a tenth of the steps
}

TEST_CASE("a t_end that t can hardly feel is reached, also after a stop time") {
  for (const double t0 : {0.0, 1.0, -1e6}) {
    double t_end = t0;
    for (int i = 0; i < 5; ++i) t_end = std::nextafter(t_end, 1e9);
    const auto run = simulate(test::oscillator(), FirstOrderState{t0, oscillator_start.y}, t_end, CvodeBdf{});
    REQUIRE(run.completed());
    REQUIRE(run.t == t_end);
    REQUIRE_THAT(run.y[1], WithinAbs(-(t_end - t0), 1e-24));
    const double stop = std::nextafter(t0 + 1.0, -1e9);
    const auto twice = simulate(test::oscillator(), FirstOrderState{t0, oscillator_start.y}, t0 + 1.0, CvodeBdf{},
                                {.stop_times = {stop}});
    REQUIRE(twice.completed());
    REQUIRE(twice.t == t0 + 1.0);
  }
}

TEST_CASE("two runs give the same bits, and so do runs in several threads at once") {
  const auto once = [] {
    return simulate(test::van_der_pol(1e-3), FirstOrderState{0.0, test::vector({2.0, 0.0})}, 2.0, CvodeBdf{});
  };
  const auto first = once();
  std::vector<Eigen::VectorXd> ends(4);
  std::vector<std::thread> threads;
  for (auto& end : ends) threads.emplace_back([&end, &once] { end = once().y; });
  for (auto& thread : threads) thread.join();
  REQUIRE(once().y == first.y);
  for (const auto& end : ends) REQUIRE(end == first.y);
}

TEST_CASE("a stepper starts afresh with the same bits, in the other direction, and after having been moved") {
  const Options options{.rtol = 1e-8};
  const auto run_to = [](CvodeStepper& stepper, double t_end) {
    while (stepper.t() != t_end) REQUIRE(stepper.step(t_end));
    return Eigen::VectorXd(stepper.y());
  };
  CvodeStepper stepper = CvodeAdams{}.stepper(test::pendulum(), options);
  const Eigen::VectorXd start = test::vector({1.0, 0.0});
  stepper.reset(0.0, start);
  const Eigen::VectorXd end = run_to(stepper, 3.0);

  stepper.reset(0.0, start);
  REQUIRE(stepper.t() == 0.0);
  REQUIRE(run_to(stepper, 3.0) == end);

  stepper.reset(3.0, end);
  REQUIRE((run_to(stepper, 0.0) - start).norm() < 1e-5);

  stepper.reset(0.0, start);
  for (int i = 0; i < 20; ++i) REQUIRE(stepper.step(3.0));
  CvodeStepper moved = std::move(stepper);
  std::vector<CvodeStepper> shelf;
  shelf.push_back(std::move(moved));
  REQUIRE(run_to(shelf.back(), 3.0) == end);
}

TEST_CASE("a stepper refuses to turn round without a reset") {
  CvodeStepper stepper = CvodeBdf{}.stepper(test::oscillator(), {});
  stepper.reset(0.0, oscillator_start.y);
  REQUIRE(stepper.step(1.0));
  REQUIRE_THROWS_AS(stepper.step(-1.0), qdot::InvalidValue);
  REQUIRE_THROWS_AS(stepper.step(stepper.t()), qdot::InvalidValue);
  REQUIRE(stepper.step(1.0));
}

TEST_CASE("a stepper's polynomial right after a reset is its state") {
  CvodeStepper stepper = CvodeBdf{}.stepper(test::oscillator(), {});
  stepper.reset(2.0, oscillator_start.y);
  REQUIRE(stepper.polynomial().degree == 0);
  REQUIRE(stepper.polynomial().coefficient(0) == oscillator_start.y);
}
