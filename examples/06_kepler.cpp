// SPDX-License-Identifier: MIT
//
// A planet on an ellipse with eccentricity 0.6: does it come back, and what does it keep?

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <qdot/integrate/cvode.hpp>
#include <qdot/integrate/simulate.hpp>
#include <qdot/qdot.hpp>

int main() {
  const auto kepler = qdot::mechanical_system<2>([](const auto& qdot) { return 0.5 * qdot.squaredNorm(); },
                                                 [](const auto& q) {
                                                   using std::sqrt;
                                                   return -1.0 / sqrt(q.squaredNorm());
                                                 })
                          .with_names({"x", "y"});

  const double e = 0.6, period = 2.0 * std::numbers::pi;
  const qdot::State<2> start{0.0, {1.0 - e, 0.0}, {0.0, std::sqrt((1.0 + e) / (1.0 - e))}};
  std::printf("semi-major axis 1, eccentricity %.1f, energy %.6f\n\n", e, energy(kepler, start));

  std::printf("rtol     back after one period within  energy drift below\n");
  for (const double rtol : {1e-6, 1e-9, 1e-12}) {
    const auto run = simulate(kepler, start, period, qdot::CvodeAdams{}, {.rtol = rtol, .atol = rtol});
    if (!run.completed()) {
      std::fprintf(stderr, "%s\n", run.message.c_str());
      return 1;
    }
    double drift = 0.0;
    for (const auto& state : run.trajectory.sampled(200)) drift = std::max(drift, std::abs(energy(kepler, state) + 0.5));
    const double error = (run.state().q - start.q).norm();
    std::printf("1e%-3.0f    %-28s  %s\n", std::log10(rtol), error < 1e4 * rtol ? "1e4 rtol" : "MORE",
                drift < 1e3 * rtol ? "1e3 rtol" : "MORE");
  }

  // Perihelion to aphelion: the Runge-Lenz vector keeps pointing to the perihelion, with length e.
  const auto run = simulate(kepler, start, period, qdot::CvodeAdams{}, {.rtol = 1e-12, .atol = 1e-12});
  std::printf("\n  t        x         y      angular momentum   Runge-Lenz vector\n");
  for (const auto& state : run.trajectory.sampled(5)) {
    const double p = state.q[0] * state.qdot[1] - state.q[1] * state.qdot[0];
    const qdot::Vector<double, 2> lenz = p * qdot::Vector<double, 2>(state.qdot[1], -state.qdot[0]) - state.q / state.q.norm();
    // adding 0.0 turns −0 into 0
    std::printf("%.4f  %8.5f  %8.5f       %.6f       (%.6f, %.6f)\n", state.t, std::round(state.q[0] * 1e5) / 1e5 + 0.0,
                std::round(state.q[1] * 1e5) / 1e5 + 0.0, p, lenz[0], std::round(lenz[1] * 1e6) / 1e6 + 0.0);
  }
}
