// SPDX-License-Identifier: MIT
//
// A planet for two hundred turns. A method that is merely accurate lets the energy go, a little with each turn; a symplectic one makes a larger error
// that does not grow. Here: the largest error of the energy in the first ten and in the last ten turns.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <qdot/integrate/gauss.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulate.hpp>
#include <qdot/integrate/symplectic.hpp>

using namespace qdot;

int main() {
  const auto kepler = mechanical_system<2>([](const auto& qdot) { return 0.5 * qdot.squaredNorm(); },
                                           [](const auto& q) {
                                             using std::sqrt;
                                             return -1.0 / sqrt(q.squaredNorm());
                                           });
  const double e = 0.3, turn = 2.0 * std::numbers::pi, E = -0.5;
  const State<2> start{0.0, {1.0 - e, 0.0}, {0.0, std::sqrt((1.0 + e) / (1.0 - e))}};

  const auto report = [&](const char* method, const auto& with, const Options& options) {
    double first = 0.0, last = 0.0;
    const auto watch = [&](const StepView& step) {  // all steps are looked at, and none is kept
      const double error = std::abs(energy(kepler, State<2>{step.t(), step.q(), step.qdot()}) / E - 1.0);
      if (step.t() < 10.0 * turn) first = std::max(first, error);
      if (step.t() > 190.0 * turn) last = std::max(last, error);
    };
    Options lean = options;
    lean.keep_trajectory = false;
    const auto run = simulate(kepler, start, 200.0 * turn, with, lean, watch);
    if (!run.completed()) return std::printf("%s\n", run.message.c_str()), void();
    std::printf("%-24s %.0e     %.0e     %s\n", method, first, last, last < 1.5 * first ? "stays" : "grows with the time");
  };
  std::printf("method                   first     last      energy\n");
  report("dop853, rtol 1e-8", Dop853{}, {.rtol = 1e-8, .atol = 1e-10});
  report("verlet, h = 0.04", Splitting{.step = 0.04, .scheme = SplittingScheme::verlet}, {});
  report("blanes_moan_6, h = 0.1", Splitting{.step = 0.1, .scheme = SplittingScheme::blanes_moan_6}, {});
  report("gauss, order 6, h = 0.1", Gauss{.step = 0.1, .stages = 3}, {});
}
