// SPDX-License-Identifier: MIT
//
// How a run with CVODE fails: with a name, at the right time, soon, in words, and in silence.

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <string_view>

#include "catch2_bridge.hpp"
#include "first_order_systems.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/simulate.hpp"

using qdot::CvodeAdams;
using qdot::CvodeBdf;
using qdot::FirstOrderState;
using qdot::Outcome;
using qdot::simulate;

namespace {

const FirstOrderState start{0.0, test::vector({1.0, 0.0})};  // of the pendulum

struct UserError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// What is written to stdout and stderr, by C or C++, while `act` runs.
template <class Act>
std::string printed_by(const Act& act) {
  std::fflush(nullptr);
  std::FILE* file = std::tmpfile();
  const int out = dup(1), err = dup(2);
  dup2(fileno(file), 1);
  dup2(fileno(file), 2);
  act();
  std::fflush(nullptr);
  dup2(out, 1);
  dup2(err, 2);
  close(out);
  close(err);
  std::rewind(file);
  std::string text;
  for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file)) text += static_cast<char>(c);
  std::fclose(file);
  return text;
}

}  // namespace

TEST_CASE("a right-hand side that turns to NaN ends the run in hundreds of evaluations") {
  for (const double t0 : {0.0, 1e6}) {
    const auto system = test::pendulum_until(t0 + 1.0, [](test::OutVector d) { d[1] = test::nan; });
    const auto run = simulate(system, FirstOrderState{t0, start.y}, t0 + 10.0, CvodeBdf{}, {.rtol = 1e-8});
    REQUIRE(run.outcome == Outcome::non_finite);
    REQUIRE(system.evaluations() < 1000);
    REQUIRE(run.t <= t0 + 1.0);
    REQUIRE(run.t > t0 + 1.0 - 1e-8);
    REQUIRE(run.trajectory.back_time() == run.t);
    REQUIRE(contains(run.message, "the derivative of thetadot is nan at t = "));
    REQUIRE(contains(run.message, "CV_REPTD_RHSFUNC_ERR (-10)"));
    REQUIRE(contains(run.message, "non_finite at t = "));
  }
}

TEST_CASE("infinity is as bad as NaN, and Adams fails like BDF") {
  const auto system = test::pendulum_until(1.0, [](test::OutVector d) { d[0] = test::infinity; });
  const auto run = simulate(system, start, 10.0, CvodeAdams{}, {.rtol = 1e-8});
  REQUIRE(run.outcome == Outcome::non_finite);
  REQUIRE(contains(run.message, "the derivative of theta is inf"));
  REQUIRE(system.evaluations() < 1000);
}

TEST_CASE("a Jacobian with NaN is named by row and column") {
  const test::FirstOrder system{
      {"x", "xdot"},
      [](double, const test::In& y, test::OutVector d) { d << y[1], -y[0]; },
      [](double t, const test::In&, test::OutMatrix J) { J << 0, 1, t > 0.5 ? test::nan : -1, 0; }};
  const auto run = simulate(system, start, 10.0, CvodeBdf{});
  REQUIRE(run.outcome == Outcome::non_finite);
  REQUIRE(contains(run.message, "the change of xdot's derivative with x is nan"));
  REQUIRE(system.evaluations() < 2000);
}

TEST_CASE("what cannot be evaluated at the start is an exception with its own words") {
  const auto broken = test::pendulum_until(-1.0, [](test::OutVector d) { d[1] = test::nan; });
  std::string message;
  try {
    simulate(broken, start, 1.0, CvodeBdf{});
  } catch (const qdot::NonFinite& error) {
    message = error.what();
    REQUIRE(error.t() == 0.0);
    REQUIRE(error.component() == "the derivative of thetadot");
  }
  REQUIRE(message == "the derivative of thetadot is nan at t = 0");
}

TEST_CASE("a model that fails just after its start ends at once with the start") {
  const auto system = test::pendulum_until(0.0, [](test::OutVector d) { d[1] = test::nan; });
  const auto run = simulate(system, start, 1.0, CvodeBdf{});
  REQUIRE(run.outcome == Outcome::non_finite);
  REQUIRE(run.t == 0.0);
  REQUIRE(run.y == start.y);
  REQUIRE(run.trajectory.at(0.0).q[0] == 1.0);
  REQUIRE(system.evaluations() < 1000);
}

TEST_CASE("a pole of the solution ends the run near the pole with a named outcome") {
  const auto system = test::blow_up();
  const auto run = simulate(system, FirstOrderState{0.0, test::vector({1.0})}, 2.0, CvodeBdf{}, {.rtol = 1e-8});
  REQUIRE(run.outcome == Outcome::step_too_small);
  REQUIRE(system.evaluations() < 5000);
  REQUIRE_THAT(run.t, WithinAbs(1.0, 1e-6));  // the pole of the computed solution is off by its error
  REQUIRE(contains(run.message, "y = "));
  REQUIRE(contains(run.message, "the solution may run to infinity here"));
  const auto adams =
      simulate(test::blow_up(), FirstOrderState{0.0, test::vector({1.0})}, 2.0, CvodeAdams{}, {.rtol = 1e-8});
  REQUIRE(qdot::failed(adams.outcome));
  REQUIRE(adams.statistics.evaluations < 5000);
}

TEST_CASE("an exception of the user's own reaches the caller unchanged, and the stepper can be used again") {
  const auto system = test::pendulum_until(1.0, [](test::OutVector) { throw UserError("spring broke"); });
  REQUIRE_THROWS_AS(simulate(system, start, 10.0, CvodeBdf{}), UserError);
  auto stepper = CvodeBdf{}.stepper(system, {});
  for (int repetition = 0; repetition < 3; ++repetition) {
    stepper.reset(0.0, start.y);
    const auto run = [&] {
      while (stepper.t() != 10.0) stepper.step(10.0);
    };
    REQUIRE_THROWS_AS(run(), UserError);
    REQUIRE(stepper.t() <= 1.0);
    REQUIRE(stepper.t() > 0.5);
  }
  stepper.reset(0.0, start.y);
  while (stepper.t() != 0.5) REQUIRE(stepper.step(0.5));
}

TEST_CASE("an exception that is no std::exception passes too") {
  const auto system = test::pendulum_until(1.0, [](test::OutVector) { throw 42; });
  REQUIRE_THROWS_AS(simulate(system, start, 10.0, CvodeBdf{}), int);
}

TEST_CASE("an exception of the Jacobian passes as well") {
  const test::FirstOrder system{{"x", "xdot"},
                                [](double, const test::In& y, test::OutVector d) { d << y[1], -y[0]; },
                                [](double, const test::In&, test::OutMatrix) { throw UserError("no derivative"); }};
  REQUIRE_THROWS_AS(simulate(system, start, 10.0, CvodeBdf{}), UserError);
}

TEST_CASE("a model that refuses a point only for large steps gets its smaller step") {
  // √(1.2 − t) − … has no value behind t = 1.2; the run ends before it, but trial steps may reach beyond.
  const test::FirstOrder system{{"y"},
                                [](double, const test::In& y, test::OutVector d) {
                                  if (y[0] < 0) throw qdot::RecoverableError("y is negative");
                                  d[0] = -std::sqrt(y[0]);
                                },
                                [](double, const test::In& y, test::OutMatrix J) { J(0, 0) = -0.5 / std::sqrt(y[0]); }};
  // ẏ = −√y from 1 is (1 − t/2)², zero at t = 2.
  const auto run =
      simulate(system, FirstOrderState{0.0, test::vector({1.0})}, 1.999, CvodeBdf{}, {.initial_step = 1.9});
  REQUIRE(run.completed());
  REQUIRE_THAT(run.y[0], WithinAbs(0.0005 * 0.0005, 1e-8));
  REQUIRE(run.statistics.rejected() > 0);
  const auto beyond = simulate(system, FirstOrderState{0.0, test::vector({1.0})}, 3.0, CvodeBdf{});
  REQUIRE(beyond.outcome == Outcome::refused_by_model);
  REQUIRE(contains(beyond.message, "y is negative"));
  REQUIRE_THAT(beyond.t, WithinAbs(2.0, 1e-2));
}

TEST_CASE("a mass matrix that becomes singular is an outcome of its own") {
  const auto system = test::pendulum_until(
      1.0, [](test::OutVector) { throw qdot::SingularMassMatrix("M is singular along theta", 1.0, {1.0}, 0.0); });
  const auto run = simulate(system, start, 10.0, CvodeBdf{});
  REQUIRE(run.outcome == Outcome::singular_mass_matrix);
  REQUIRE(contains(run.message, "M is singular along theta"));
}

TEST_CASE("a model may end the run in good order") {
  const auto system = test::pendulum_until(1.0, [](test::OutVector) { throw qdot::StopRequest("the door is open"); });
  const auto run = simulate(system, start, 10.0, CvodeBdf{});
  REQUIRE(run.outcome == Outcome::stopped_by_model);
  REQUIRE(!qdot::failed(run.outcome));
  REQUIRE(run.t <= 1.0);
  REQUIRE(run.trajectory.steps() > 10);
  REQUIRE(contains(run.message, "the door is open"));
}

TEST_CASE("a jump of the right-hand side is passed when it is moderate, and quickly") {
  const test::FirstOrder system{
      {"x", "xdot"},
      [](double t, const test::In& y, test::OutVector d) { d << y[1], t < M_PI / 3 ? 1.0 : -1e3; },
      [](double, const test::In&, test::OutMatrix J) { J << 0, 1, 0, 0; }};
  const auto run = simulate(system, start, 2.0, CvodeBdf{});
  REQUIRE(run.completed());
  REQUIRE(run.statistics.evaluations < 5000);
}

TEST_CASE("a run that chatters about a jump ends instead of creeping on for ever") {
  const test::FirstOrder system{{"y"},
                                [](double, const test::In& y, test::OutVector d) { d[0] = y[0] > 0 ? -1.0 : 1.0; },
                                [](double, const test::In&, test::OutMatrix J) { J(0, 0) = 0; }};
  const auto run = simulate(system, FirstOrderState{0.0, test::vector({1.0})}, 10.0, CvodeBdf{});
  REQUIRE(run.outcome == Outcome::step_too_small);
  REQUIRE_THAT(run.t, WithinAbs(1.0, 1e-6));
  REQUIRE(system.evaluations() < 50'000);
  REQUIRE(contains(run.message, "the last 10000 steps advanced t by no more than"));
}

TEST_CASE("what fails at a stop time keeps the trajectory up to it") {
  const auto system = test::pendulum_until(1.0, [](test::OutVector d) { d[1] = test::nan; });
  const auto run = simulate(system, start, 10.0, CvodeBdf{}, {.stop_times = {1.0}});
  REQUIRE(run.outcome == Outcome::non_finite);
  REQUIRE(run.t == 1.0);
  REQUIRE(run.trajectory.back_time() == 1.0);
}

TEST_CASE("a failed stepper keeps its last good state and starts again after a reset") {
  const auto system = test::pendulum_until(1.0, [](test::OutVector d) { d[1] = test::nan; });
  auto stepper = CvodeBdf{}.stepper(system, {});
  stepper.reset(0.0, start.y);
  Eigen::VectorXd last = start.y;
  double t = 0.0;
  while (stepper.step(10.0)) last = stepper.y(), t = stepper.t();
  REQUIRE(stepper.t() == t);
  REQUIRE(stepper.y() == last);
  REQUIRE(stepper.failure().outcome == Outcome::non_finite);
  stepper.reset(0.0, start.y);
  while (stepper.t() != 0.9) REQUIRE(stepper.step(0.9));
}

TEST_CASE("the library prints nothing, however a run ends") {
  const std::string text = printed_by([] {
    for (const auto& method : {CvodeBdf{}}) {
      simulate(test::blow_up(), FirstOrderState{0.0, test::vector({1.0})}, 2.0, method);
      simulate(test::pendulum_until(1.0, [](test::OutVector d) { d[1] = test::nan; }), start, 10.0, method);
      try {
        simulate(test::pendulum_until(1.0, [](test::OutVector) { throw UserError("x"); }), start, 10.0, method);
      } catch (const UserError&) {
      }
    }
    simulate(test::blow_up(), FirstOrderState{0.0, test::vector({1.0})}, 2.0, CvodeAdams{});
  });
  REQUIRE(text.empty());
}

TEST_CASE("whoever wants to read SUNDIALS' own messages gets them, and may throw in vain") {
  int messages = 0;
  const CvodeBdf listening{.on_message = [&](std::string_view text) {
    ++messages;
    REQUIRE(!text.empty());
    throw UserError("nobody hears this");
  }};
  const auto run = simulate(test::blow_up(), FirstOrderState{0.0, test::vector({1.0})}, 2.0, listening);
  REQUIRE(run.outcome == Outcome::step_too_small);
  REQUIRE(messages > 0);
}

TEST_CASE("a thousand failed runs can follow each other") {
  const auto system = test::pendulum_until(0.01, [](test::OutVector d) { d[1] = test::nan; });
  for (int i = 0; i < 1000; ++i) REQUIRE(simulate(system, start, 1.0, CvodeBdf{}).outcome == Outcome::non_finite);
}
