#pragma once
// SPDX-License-Identifier: MIT
//
// What the programs motion_*.cxx share: the search for the cheapest setting, and the equations derived by hand.

#include <cstdio>
#include <string>

#include "bench/hand_derived.hpp"
#include "bench/motion_problems.hpp"

namespace qdot::bench {

/// For every error that is asked for: the loosest tolerance that reaches it, timed. `run(tolerance, timed)` returns {error, microseconds}.
template <class Run>
void print_cheapest(const MotionProblem& problem, const std::string& method, const Run& run) {
  std::size_t next = 0;
  for (const double tolerance : decades(1e-3, 2.4e-15, 4)) {
    const double error = run(tolerance, false).first;
    for (; next < problem.errors.size() && error <= problem.errors[next]; ++next) {
      const double microseconds = run(tolerance, true).second;
      std::printf("%s;%.0e;%s;%.1e;%.1e;%.2f\n", problem.name.c_str(), problem.errors[next], method.c_str(), tolerance, error, microseconds);
      std::fflush(stdout);
    }
    if (next == problem.errors.size()) return;
  }
}

/// ẏ by hand as a function object with a size known to the compiler.
template <int n>
struct ChainRates {
  void operator()(const double* y, double* rates) const {
    for (int i = 0; i < n; ++i) rates[i] = y[n + i];
    chain_by_hand<n>(y, y + n, rates + n);
  }
};
template <class Hand>
struct PlaneRates {
  Hand hand{};
  void operator()(const double* y, double* rates) const {
    rates[0] = y[2];
    rates[1] = y[3];
    hand(y, y + 2, rates + 2);
  }
};

/// Calls measure<size>(problem, rates) for each problem.
template <class Measure>
void for_each_problem(const std::string& wanted, const Measure& measure) {
  for (const MotionProblem& problem : motion_problems(wanted)) {
    if (problem.name.starts_with("kepler")) {
      measure.template operator()<4>(problem, PlaneRates<KeplerByHand>{});
    } else if (problem.name.starts_with("double")) {
      measure.template operator()<4>(problem, PlaneRates<DoublePendulumByHand>{});
    } else {
      switch (problem.n) {
        case 1: measure.template operator()<2>(problem, ChainRates<1>{}); break;
        case 2: measure.template operator()<4>(problem, ChainRates<2>{}); break;
        case 3: measure.template operator()<6>(problem, ChainRates<3>{}); break;
        case 4: measure.template operator()<8>(problem, ChainRates<4>{}); break;
        case 6: measure.template operator()<12>(problem, ChainRates<6>{}); break;
        case 8: measure.template operator()<16>(problem, ChainRates<8>{}); break;
        case 12: measure.template operator()<24>(problem, ChainRates<12>{}); break;
        case 16: measure.template operator()<32>(problem, ChainRates<16>{}); break;
        default: break;
      }
    }
  }
}

}  // namespace qdot::bench
