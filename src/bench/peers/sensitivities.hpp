#pragma once
// SPDX-License-Identifier: MIT
//
// What the programs sensitivities_*.cxx share: the double pendulum of unit masses and lengths, released from 1.7 rad, whose Phi at t = 3 is asked for.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>

namespace qdot::bench {

// By variational equations in long double (heyoka, tolerances 1e-18 to 1e-20), row by row.
inline constexpr double expected_Phi[16] = {
    0.42512535360011335, 0.32234325900511527, -0.11480303301727812, -0.32188377823700566,
    0.35375523822508861, -0.12147143371945361, 0.03465925719707716, 0.61006975762812077,
    3.55481773398585877, 2.52890401856926854, 0.87795461024674466, -0.09322081715396367,
    2.95323559692079771, -0.59978990735865972, 0.20286440439106009, 1.95089499890557590};
inline constexpr double released_from = 1.7, asked_at = 3.0;

/// A line "method;tolerance;microseconds;error of Phi;microseconds of the run without" for each tolerance. `derived(tol, Phi)` and `plain(tol)` run.
void print_lines(const char* method, const auto& derived, const auto& plain) {
  const auto least = [](const auto& work) {
    double best = std::numeric_limits<double>::infinity();
    for (int repeat = 0; repeat < 60; ++repeat) {
      const auto began = std::chrono::steady_clock::now();
      work();
      best = std::min(best, std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - began).count());
    }
    return best;
  };
  for (double tolerance = 1e-4; tolerance > 5e-15; tolerance *= 0.1) {
    double Phi[16], error = 0.0;
    const double with = least([&] { derived(tolerance, Phi); }), without = least([&] { plain(tolerance); });
    for (int i = 0; i < 16; ++i) error = std::max(error, std::abs(Phi[i] - expected_Phi[i]));
    std::printf("%s;%.0e;%.2f;%.2e;%.2f\n", method, tolerance, with, error, without);
  }
}

}  // namespace qdot::bench
