// SPDX-License-Identifier: MIT
//
// No run goes on for ever, whatever the model does.

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "catch2_bridge.hpp"
#include "first_order_systems.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

using namespace qdot;

namespace {

const FirstOrderState one{0.0, test::vector({1.0})};

// What one attempt at a step may cost beyond the limit: Dop853 has twelve stages and three for its dense output.
constexpr long attempt = 16;

// A right-hand side without a solution: noise that no step size makes smooth.
test::FirstOrder noise(std::function<void()> each = [] {}) {
  const auto state = std::make_shared<unsigned>(1);
  return {{"y"},
          [state, each](double, const test::In&, test::OutVector d) {
            each();
            *state = *state * 1664525u + 1013904223u;
            d[0] = static_cast<double>(*state >> 8) - 8e6;
          },
          [](double, const test::In&, test::OutMatrix J) { J(0, 0) = 0; }};
}

}  // namespace

TEMPLATE_TEST_CASE("evaluations are limited inside a step too", "", Dop853, Dopri5, CvodeBdf, CvodeAdams) {
  for (const long limit : {20L, 75L, 500L}) {
    const auto system = noise();
    const auto run = simulate(system, one, 1e6, TestType{}, {.rtol = 1e-12, .max_evaluations = limit});
    REQUIRE(failed(run.outcome));
    CHECK(system.evaluations() <= limit + attempt + 100);  // a diagnosis, where the step collapsed before
    if (run.outcome == Outcome::evaluation_limit) {
      CHECK(system.evaluations() <= limit + attempt);
      CHECK(run.message.find("max_evaluations = " + std::to_string(limit) + " were spent") != std::string::npos);
    }
    CHECK(run.trajectory.back_time() == run.t);
  }
}

TEMPLATE_TEST_CASE("seconds are limited inside a step too", "", Dop853, CvodeBdf) {
  // At two milliseconds each, twenty milliseconds are spent after ten evaluations.
  const auto system = noise([] { std::this_thread::sleep_for(std::chrono::milliseconds(2)); });
  const auto run = simulate(system, one, 1e6, TestType{}, {.rtol = 1e-12, .max_wall_seconds = 0.02});
  CHECK(run.outcome == Outcome::time_limit);
  CHECK(system.evaluations() <= 10 + attempt);
}

TEST_CASE("without any limit of the user's a run without a solution ends by itself") {
  const auto system = noise();
  const auto run = simulate(system, FirstOrderState{1.0, one.y}, 1e6, Dop853{}, {.keep_trajectory = false});
  CHECK(failed(run.outcome));
  CHECK(system.evaluations() < 1'000'000);
}

TEST_CASE("an event whose function is noise does not hold a run for ever") {
  long calls = 0;
  const auto noisy = events(event("noise", [&calls](const auto&) { return ++calls % 2 == 0 ? 1.0 : -1.0; }));
  const auto run = simulate(test::oscillator(), FirstOrderState{0.0, test::vector({1.0, 0.0})}, 1.0, Dop853{}, {}, noisy);
  CHECK((run.completed() || run.outcome == Outcome::zeno));
  CHECK(calls < 5'000'000);
}
