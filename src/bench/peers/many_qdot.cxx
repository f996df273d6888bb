// SPDX-License-Identifier: MIT
//
// many_qdot problems: a line of JSON for each problem with its starts, and where they end. many_qdot: a line "problem;tolerance;microseconds;error" for
// each tolerance, of one motion out of 512; the error is the median of |q − q at 1e-13|.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "bench/many_problems.hpp"
#include "qdot/integrate/many_in_lanes.hpp"

using namespace qdot;

int main(int argc, char**) {
  bench::for_each_of_many([&](const char* name, const auto& system, const auto& start_of) {
    const auto ends_at = [&](double rtol) {
      return ensemble(system, bench::motions, start_of, bench::duration, Dop853{}, {.rtol = rtol, .atol = rtol * 1e-2, .keep_trajectory = false}, {.threads = 1});
    };
    const auto reference = ends_at(1e-13);
    if (argc > 1) {
      std::printf("{\"problem\": \"%s\", \"motions\": [", name);
      for (std::size_t i = 0; i < reference.size(); ++i) {
        const auto start = start_of(i);
        std::printf("%s[", i > 0 ? ", " : "");
        for (const double x : start.q) std::printf("%.17g, ", x);
        for (const double x : start.qdot) std::printf("%.17g, ", x);
        for (Eigen::Index k = 0; k < start.q.size(); ++k) std::printf("%s%.17g", k > 0 ? ", " : "", reference[i].value->state.q[k]);
        std::printf("]");
      }
      std::printf("]}\n");
      return;
    }
    for (const double rtol : {1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12}) {
      double best = 1e30;
      std::vector<double> errors;
      for (int repeat = 0; repeat < 5; ++repeat) {
        const auto began = std::chrono::steady_clock::now();
        const auto ends = ends_at(rtol);
        best = std::min(best, std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - began).count());
        errors.clear();
        for (std::size_t i = 0; i < ends.size(); ++i) errors.push_back((ends[i].value->state.q - reference[i].value->state.q).norm());
      }
      std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
      std::printf("%s;%g;%.3f;%.3g\n", name, rtol, best / bench::motions, errors[errors.size() / 2]);
    }
  });
}
