// SPDX-License-Identifier: MIT
#include "qdot/integrate/simulate.hpp"

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "catch2_bridge.hpp"
#include "first_order_systems.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/mechanics/kinematic_system.hpp"

using qdot::Control;
using qdot::CvodeBdf;
using qdot::FirstOrderState;
using qdot::Options;
using qdot::Outcome;
using qdot::simulate;
using qdot::State;
using qdot::StepView;

namespace {

// Euler's method with fixed steps: the smallest possible stepper, to show that the driver needs no more.
template <class F>
class EulerStepper {
 public:
  EulerStepper(F system, double h)
      : system_(std::move(system)), h_(h), y_(system_.size()), coefficients_(system_.size(), 2) {
    statistics_.method = "euler";
  }
  void reset(double t, const Eigen::VectorXd& y) {
    t_ = t_previous_ = t;
    y_ = y;
  }
  bool step(double t_limit) {
    t_previous_ = t_;
    const double h = std::min(h_, std::abs(t_limit - t_)) * (t_limit > t_ ? 1 : -1);
    coefficients_.col(0) = y_;
    system_.derivative(t_, y_, coefficients_.col(1));
    coefficients_.col(1) *= h;
    scale_ = h;
    y_ += coefficients_.col(1);
    t_ = std::abs(t_limit - t_) <= h_ ? t_limit : t_ + h;
    ++statistics_.steps;
    ++statistics_.evaluations;
    return true;
  }
  const qdot::Failure& failure() const { return failure_; }
  double t() const { return t_; }
  double t_previous() const { return t_previous_; }
  const Eigen::VectorXd& y() const { return y_; }
  qdot::PolynomialView polynomial() { return {t_previous_, scale_, coefficients_.data(), y_.size(), 1}; }
  void interpolate(double t, Eigen::Ref<Eigen::VectorXd> out) { polynomial().evaluate(t, out); }
  int order() const { return 1; }
  const qdot::Statistics& statistics() const { return statistics_; }

 private:
  F system_;
  double h_, t_ = 0, t_previous_ = 0, scale_ = 1;
  Eigen::VectorXd y_;
  Eigen::MatrixXd coefficients_;
  qdot::Statistics statistics_;
  qdot::Failure failure_;
};

struct Euler {
  double h;
  template <qdot::FirstOrderSystem F>
  EulerStepper<F> stepper(const F& system, const Options&) const {
    return {system, h};
  }
};

const FirstOrderState start{0.0, test::vector({1.0, 0.0})};  // of the oscillator: (cos t, −sin t)

// At rtol 1e-9 and atol 1e-12 the oscillator's global error at t = 10 was 2e-8; ten times that is allowed.
constexpr double oscillator_error = 2e-7;

}  // namespace

TEST_CASE("the driver lands on t_end exactly, forward and backward") {
  for (const double t_end : {10.0, -10.0, 0.1, 1e-3}) {
    const auto run = simulate(test::oscillator(), start, t_end, CvodeBdf{});
    REQUIRE(run.completed());
    REQUIRE(run.t == t_end);
    REQUIRE(run.trajectory.back_time() == t_end);
    REQUIRE_THAT(run.y[0], WithinAbs(std::cos(t_end), oscillator_error));
    REQUIRE_THAT(run.y[1], WithinAbs(-std::sin(t_end), oscillator_error));
    REQUIRE(run.message == "reached t = " + qdot::detail::text_of(t_end) + " after " +
                               std::to_string(run.statistics.steps) + " steps");
  }
}

TEST_CASE("a run of no length returns its start and spends one evaluation") {
  const auto run = simulate(test::oscillator(), start, 0.0, CvodeBdf{}, {.output_times = {0.0}});
  REQUIRE(run.completed());
  REQUIRE(run.t == 0.0);
  REQUIRE(run.y == start.y);
  REQUIRE(run.trajectory.at(0.0).q[0] == 1.0);
  REQUIRE(run.samples.t == std::vector<double>{0.0});
  REQUIRE(run.statistics.steps == 0);
}

TEST_CASE("a start may be coordinates and velocities, or the whole vector") {
  const State<qdot::Dynamic> wrong{0.0, {1, 0}, {0, 0}};
  const State<1> right{0.0, {1.0}, {0.0}};
  REQUIRE(simulate(test::oscillator(), right, 1.0, CvodeBdf{}).y ==
          simulate(test::oscillator(), start, 1.0, CvodeBdf{}).y);
  REQUIRE_THROWS_AS(simulate(test::oscillator(), wrong, 1.0, CvodeBdf{}), qdot::DimensionError);
  REQUIRE(simulate(test::oscillator(), right, 1.0, CvodeBdf{}).state().q[0] == Approx(std::cos(1.0)));
}

TEST_CASE("a state is made of lists, of vectors, and of both") {
  const Eigen::VectorXd three = Eigen::Vector3d(1.0, 2.0, 3.0);
  const qdot::Vector<double, 1> one(1.0);
  CHECK(State<1>{0.5, {1.0}, {2.0}}.q[0] == 1.0);
  CHECK(State<1>{0.5, one, {2.0}}.qdot[0] == 2.0);
  CHECK(State<1>{.t = 0.5, .q = {1.0}, .qdot = 2.0 * one}.qdot[0] == 2.0);
  CHECK(State<1>{0.5, {3}, one}.q[0] == 3.0);
  CHECK(State<3>{0.5, three.head(3), 2.0 * three.tail(3)}.qdot == Eigen::Vector3d(2.0, 4.0, 6.0));
  CHECK(State<5>{0.5, {1, 2, 3, 4, 5}, {0, 0, 0, 0, 0}}.q[4] == 5.0);
  const State<qdot::Dynamic> two{0.5, {3, 1}, {4.0, 2.0}};  // Eigen alone would take 3 rows and 1 column
  CHECK(two.q == Eigen::Vector2d(3.0, 1.0));
  CHECK(two.qdot == Eigen::Vector2d(4.0, 2.0));
  CHECK(two.t == 0.5);
}

TEST_CASE("observers and events may follow the method at once, and one event needs no list") {
  using qdot::event;
  const auto down = event("down", [](const auto& q) { return q[0]; }).falling();
  const auto passed = [&](const auto&... further) { return simulate(test::oscillator(), start, 7.0, CvodeBdf{}, further...).events.size(); };
  CHECK(passed(down) == 1);
  CHECK(passed(qdot::events(down, event("up", [](const auto& q) { return q[0]; }).rising())) == 2);
  CHECK(passed(Options{.rtol = 1e-6}, down) == 1);
  CHECK(passed(Options{.rtol = 1e-6}, [](const StepView&) {}, down) == 1);
  int seen = 0;
  const auto watch = [&seen](const StepView&) { ++seen; };
  CHECK(passed(watch, down) == 1);
  const int each = seen;
  CHECK(passed(down, watch) == 1);
  CHECK(passed(Options{}, down, watch) == 1);
  CHECK(passed(Options{}, qdot::events(down), watch) == 1);
  CHECK(each > 0);
  CHECK(seen == 4 * each);
  int steps = 0;
  CHECK(simulate(test::oscillator(), start, 1.0, CvodeBdf{}, [&](const StepView&) { ++steps; }).statistics.steps == steps);
}

TEST_CASE("bad input is an exception before the first step") {
  const auto message = [](const FirstOrderState& from, double t_end, const Options& options) -> std::string {
    try {
      simulate(test::oscillator(), from, t_end, CvodeBdf{}, options);
    } catch (const qdot::Error& error) {
      return error.what();
    }
    return "";
  };
  REQUIRE(message({0.0, test::vector({1.0})}, 1.0, {}) ==
          "y must have 2 entries, but has 1; pass one entry for each component of the system");
  REQUIRE(message({0.0, test::vector({1.0, test::nan})}, 1.0, {}) ==
          "xdot must be finite at the start, but is nan; give it a number");
  REQUIRE(message({test::nan, start.y}, 1.0, {}) == "t must be finite, but is nan; start at a time that is a number");
  REQUIRE(message(start, test::infinity, {}) == "t_end must be finite, but is inf; choose a time to end at");
  REQUIRE(
      message(start, 1.0, {.output_times = {2.0}}) ==
      "every output time must lie between the start t = 0 and t_end = 1, but one is 2; remove it or extend the run");
  REQUIRE(message(start, 1.0, {.rtol = -1}).find("rtol must lie") == 0);
}

TEST_CASE("a force that grows as t moves a unit mass by t^3 / 6, though the time is a default argument") {
  const auto system = qdot::mechanical_system<1>([](const auto& qdot) { return 0.5 * qdot[0] * qdot[0]; },
                                                 []<class Q>(const Q& q, typename Q::Scalar t = typename Q::Scalar(0.0)) { return -t * q[0]; });
  const auto run = simulate(system, qdot::State<1>{0.0, qdot::Vector<double, 1>(0.0), qdot::Vector<double, 1>(0.0)}, 1.0, qdot::CvodeBdf{});
  REQUIRE(run.completed());
  CHECK_THAT(run.y[0], WithinAbs(1.0 / 6.0, 1e-6));  // a hundred tolerances
}

TEST_CASE("an energy that reads an entry which q does not have ends before the first step") {
  const auto free = [](const auto& qdot) { return 0.5 * qdot.squaredNorm(); };
  const auto complaint = "T and V may read entries 0 to 1 of q and qdot, but one of them reads entry 2; count from 0, and give mechanical_system the number "
                         "of coordinates that T and V are made for";
  const auto run = [](const auto& system) { return simulate(system, qdot::State<2>{0.0, {1.0, 2.0}, {0.0, 0.0}}, 1.0, CvodeBdf{}); };
  const auto third = [](const auto& q) { return 9.81 * q[2]; };
  const auto far = qdot::force_at_point([](const auto& q) { return q; }, Eigen::Vector2d(0.0, 1.0));
  const auto spring = qdot::spring_damper([](const auto& q) { return q; }, Eigen::Vector2d(0.0, 0.0), 1.0, 1.0);
  CHECK_THROWS_WITH(run(qdot::mechanical_system<2>(free, third)), complaint);
  CHECK_THROWS_WITH(run(qdot::mechanical_system<2>([](const auto& q, const auto& v) { return 0.5 * (v[0] * v[0] + v[2] * v[2]) + 0.0 * q[0]; })), complaint);
  CHECK_THROWS_WITH(run(scene(qdot::mechanical_system<2>(free, third), far, spring)), complaint);
  CHECK_THROWS_WITH(run(qdot::kinematic_system<2>([](const auto& q, auto& bodies) { bodies.point_mass(1.0, qdot::vector(q[0], q[2])); })), complaint);
  CHECK_THROWS_WITH(simulate(qdot::mechanical_system(2, free, third), qdot::State<qdot::Dynamic>{0.0, {1.0, 2.0}, {0.0, 0.0}}, 1.0, CvodeBdf{}), complaint);
}

TEST_CASE("stop times are landed on exactly, in the order of the run") {
  for (const double sign : {1.0, -1.0}) {
    std::vector<double> seen;
    const auto watch = [&seen](const StepView& step) { seen.push_back(step.t()); };
    const Options options{.stop_times = {sign * 0.7, sign * 0.1, 5.0 * sign, 0.0, -sign, sign * 0.1, sign * 1.0}};
    const auto run = simulate(test::oscillator(), start, sign * 1.0, CvodeBdf{}, options, watch);
    REQUIRE(run.completed());
    for (const double t : {sign * 0.1, sign * 0.7, sign * 1.0}) REQUIRE(std::count(seen.begin(), seen.end(), t) == 1);
    for (std::size_t i = 1; i < seen.size(); ++i) REQUIRE((seen[i] - seen[i - 1]) * sign > 0);
    REQUIRE(run.statistics.restarts == 2);
    REQUIRE_THAT(run.y[0], WithinAbs(std::cos(1.0), oscillator_error));
  }
}

TEST_CASE("a switch at a stop time is met from its own side, whichever side the model counts it to") {
  // ẍ = ±1 with a switch at t = 1. From rest, x(2) = 1/2 + 1 − 1/2 = 1, and back again. A method that felt the other
  // side at t = 1 would be wrong by its last step there, which is long because the formulas are exact for parabolas.
  for (const bool late : {false, true}) {
    const test::FirstOrder switched{
        {"x", "xdot"},
        [late](double t, const test::In& y, test::OutVector d) { d << y[1], (late ? t <= 1.0 : t < 1.0) ? 1.0 : -1.0; },
        [](double, const test::In&, test::OutMatrix J) { J << 0, 1, 0, 0; }};
    const Options options{.stop_times = {1.0}};
    const auto there = simulate(switched, FirstOrderState{0.0, test::vector({0.0, 0.0})}, 2.0, CvodeBdf{}, options);
    const auto back = simulate(switched, FirstOrderState{2.0, there.y}, 0.0, CvodeBdf{}, options);
    constexpr double error_of_exact_formulas = 2e-9;  // the first steps, of order one, at rtol 1e-9
    REQUIRE_THAT(there.y[0], WithinAbs(1.0, error_of_exact_formulas));
    REQUIRE_THAT(there.y[1], WithinAbs(0.0, error_of_exact_formulas));
    REQUIRE_THAT(back.y[0], WithinAbs(0.0, 2 * error_of_exact_formulas));
    const auto blind = simulate(switched, FirstOrderState{0.0, test::vector({0.0, 0.0})}, 2.0, CvodeBdf{});
    REQUIRE(there.statistics.rejected_by_error_test < blind.statistics.rejected_by_error_test);
  }
}

TEST_CASE("output times are filled from dense output without changing the steps") {
  std::vector<double> times;
  for (int i = 0; i <= 100; ++i) times.push_back(0.1 * i);
  times.back() = 10.0;
  const auto plain = simulate(test::oscillator(), start, 10.0, CvodeBdf{});
  const auto sampled = simulate(test::oscillator(), start, 10.0, CvodeBdf{}, {.output_times = times});
  REQUIRE(sampled.y == plain.y);
  REQUIRE(sampled.statistics.evaluations == plain.statistics.evaluations);
  REQUIRE(sampled.samples.t == times);
  REQUIRE(sampled.samples.y.cols() == 101);
  for (Eigen::Index i = 0; i <= 100; ++i)
    REQUIRE_THAT(sampled.samples.y(0, i), WithinAbs(std::cos(times[static_cast<std::size_t>(i)]), oscillator_error));
  REQUIRE(sampled.samples.y.col(100) == sampled.y);
}

TEST_CASE("a run that ends early keeps the samples it has reached") {
  const auto run = simulate(test::oscillator(), start, 10.0, CvodeBdf{}, {.output_times = {1.0, 2.0, 9.0}},
                            [](const StepView& step) { return step.t() < 5.0; });
  REQUIRE(run.outcome == Outcome::stopped_by_observer);
  REQUIRE(run.samples.t == std::vector<double>{1.0, 2.0});
  REQUIRE(run.samples.y.cols() == 2);
}

TEST_CASE("an observer may return nothing, false, or Control::stop") {
  int calls = 0;
  REQUIRE(simulate(test::oscillator(), start, 1.0, CvodeBdf{}, {}, [&](const StepView&) { ++calls; }).completed());
  REQUIRE(calls > 10);
  for (const Control answer : {Control::proceed, Control::stop}) {
    const auto by_bool = simulate(test::oscillator(), start, 1.0, CvodeBdf{}, {},
                                  [&](const StepView&) { return answer == Control::proceed; });
    const auto by_control =
        simulate(test::oscillator(), start, 1.0, CvodeBdf{}, {}, [&](const StepView&) { return answer; });
    const Outcome expected = answer == Control::proceed ? Outcome::completed : Outcome::stopped_by_observer;
    REQUIRE(by_bool.outcome == expected);
    REQUIRE(by_control.outcome == expected);
    if (answer == Control::stop) REQUIRE(by_control.statistics.steps == 1);
  }
}

TEST_CASE("an observer sees the step's state and its dense output") {
  simulate(test::oscillator(), start, 3.0, CvodeBdf{}, {}, [](const StepView& step) {
    const double middle = 0.5 * (step.t_previous() + step.t());
    REQUIRE(step.t() > step.t_previous());
    REQUIRE_THAT(step.q()[0], WithinAbs(std::cos(step.t()), oscillator_error));
    REQUIRE_THAT(step.qdot()[0], WithinAbs(-std::sin(step.t()), oscillator_error));
    REQUIRE_THAT(step.y_at(middle)[0], WithinAbs(std::cos(middle), oscillator_error));
  });
}

TEST_CASE("an exception of the observer reaches the caller unchanged") {
  const auto observer = [](const StepView& step) {
    if (step.t() > 0.5) throw std::out_of_range("enough");
  };
  REQUIRE_THROWS_AS(simulate(test::oscillator(), start, 1.0, CvodeBdf{}, {}, observer), std::out_of_range);
}

TEST_CASE("every budget ends the run with its own outcome and keeps what was reached") {
  const auto steps = simulate(test::oscillator(), start, 10.0, CvodeBdf{}, {.max_steps = 20});
  REQUIRE(steps.outcome == Outcome::step_limit);
  REQUIRE(steps.statistics.steps == 20);
  REQUIRE(steps.trajectory.steps() == 20);
  REQUIRE(steps.trajectory.back_time() == steps.t);
  REQUIRE(steps.message ==
          "step_limit at t = " + qdot::detail::text_of(steps.t) +
              " after 20 steps: max_steps = 20 were taken; raise max_steps, relax the tolerances, or ask "
              "why the steps are so small.");
  const auto evaluations = simulate(test::oscillator(), start, 10.0, CvodeBdf{}, {.max_evaluations = 50});
  REQUIRE(evaluations.outcome == Outcome::evaluation_limit);
  REQUIRE(evaluations.statistics.evaluations >= 50);
  REQUIRE(evaluations.statistics.evaluations < 70);
  const auto seconds = simulate(test::oscillator(), start, 1e9, CvodeBdf{}, {.max_wall_seconds = 1e-3});
  REQUIRE(seconds.outcome == Outcome::time_limit);
  REQUIRE(seconds.statistics.wall_seconds >= 1e-3);
}

TEST_CASE("a budget that suffices exactly completes the run") {
  const long needed = simulate(test::oscillator(), start, 1.0, CvodeBdf{}).statistics.steps;
  REQUIRE(simulate(test::oscillator(), start, 1.0, CvodeBdf{}, {.max_steps = needed}).completed());
}

TEST_CASE("a component beyond state_norm_limit ends the run and is named") {
  const auto run = simulate(test::blow_up(), FirstOrderState{0.0, test::vector({1.0})}, 2.0, CvodeBdf{},
                            {.state_norm_limit = 1000.0});
  REQUIRE(run.outcome == Outcome::state_limit);
  REQUIRE(run.y[0] > 1000.0);
  REQUIRE(run.t < 1.0);
  REQUIRE(run.message.find("y = ") != std::string::npos);
  REQUIRE(run.message.find("exceeds state_norm_limit = 1000") != std::string::npos);
}

TEST_CASE("without a trajectory the run is the same and keeps only its start") {
  const auto with = simulate(test::oscillator(), start, 10.0, CvodeBdf{});
  const auto without = simulate(test::oscillator(), start, 10.0, CvodeBdf{}, {.keep_trajectory = false});
  REQUIRE(without.y == with.y);
  REQUIRE(without.statistics.steps == with.statistics.steps);
  REQUIRE(without.trajectory.steps() == 0);
}

TEST_CASE("the driver runs any method that models Stepper") {
  const auto coarse = simulate(test::oscillator(), start, 1.0, Euler{1e-3});
  const auto fine = simulate(test::oscillator(), start, 1.0, Euler{5e-4});
  REQUIRE(coarse.completed());
  REQUIRE(coarse.t == 1.0);
  const double ratio = (coarse.y[0] - std::cos(1.0)) / (fine.y[0] - std::cos(1.0));
  REQUIRE_THAT(ratio, WithinAbs(2.0, 0.01));  // a method of first order
  REQUIRE_THAT(coarse.trajectory.at(0.5).q[0], WithinAbs(std::cos(0.5), 1e-3));
}
