// SPDX-License-Identifier: MIT
//
// Many motions side by side in the lanes of a processor, and in its threads, against one after the other.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "bench/bench.hpp"
#include "bench/many_problems.hpp"
#include "qdot/integrate/many_in_lanes.hpp"

namespace qdot::bench {

namespace {

template <class Work>
void shorten(double& best, const Work& work) {
  const auto began = std::chrono::steady_clock::now();
  work();
  best = std::min(best, std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - began).count() / static_cast<double>(motions));
}

template <class ModelOf, class All, class StartOf>
void add_rows(std::vector<Row>& rows, const std::string& name, const ModelOf& model_of, const All& all, const StartOf& start_of) {
  const Options options{.rtol = 1e-9, .atol = 1e-12, .keep_trajectory = false};
  double alone = std::numeric_limits<double>::infinity(), lanes = alone, threads = alone;
  double apart = 0.0;
  std::vector<double> ends(motions);
  for (int repeat = 0; repeat < 5; ++repeat) {
    shorten(alone, [&] {
      for (std::size_t i = 0; i < motions; ++i) ends[i] = simulate(model_of(i), start_of(i), duration, Dop853{}, options).y[0];
    });
    shorten(lanes, [&] {
      const auto many = ensemble(all, motions, start_of, duration, Dop853{}, options, {.threads = 1});
      for (std::size_t i = 0; i < motions; ++i) apart = std::max(apart, many[i].value ? std::abs(many[i].value->state.q[0] - ends[i]) : 1.0);
    });
    shorten(threads, [&] { ensemble(all, motions, start_of, duration, Dop853{}, options); });
  }
  const std::string differ = apart < 1e-6 ? "" : ", AND THE ENDS DIFFER";
  rows.push_back({name + ", in lanes" + differ, lanes, alone, "one by one", "us"});
  rows.push_back({name + ", in lanes and threads", threads, lanes, "in lanes", "us"});
}

Findings measured() {
  Findings found;
  for_each_of_many([&](const std::string& name, const auto& system, const auto& start_of) {
    add_rows(found.rows, name, [&](std::size_t) -> const auto& { return system; }, system, start_of);
  });
  for_each_scene_of_many([&](const std::string& name, const auto& model_of, const auto& all, const auto& start_of) {
    add_rows(found.rows, name, model_of, all, start_of);
  });
  found.note = "us for one of 512 motions of 5 s at rtol 1e-9 by Dop853, the least of 5 repeats in which all ways alternate; compiled for registers of " +
               std::to_string(detail::register_lanes) + " doubles, " + std::to_string(std::thread::hardware_concurrency()) + " threads";
  return found;
}

}  // namespace

Benchmark benchmark() {
  return {"many", "time of many motions side by side against one after the other", measured};
}

}  // namespace qdot::bench
