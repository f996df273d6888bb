#pragma once
// SPDX-License-Identifier: MIT
//
// Times in the order of a run, which may go forward or backward: those that it lands on, and those at which it samples.

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "qdot/ad/formula/in_order.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/options.hpp"

namespace qdot::detail {

[[gnu::cold]] inline std::vector<double> sorted_along(std::vector<double> times, double t0, double t_end) {
  formula::put_in_order(times, [](double x, double y) { return x < y; });
  if (t_end < t0) std::reverse(times.begin(), times.end());
  return times;
}

// The stop times strictly between t0 and t_end, then t_end; nothing if t_end is t0.
[[gnu::cold]] inline std::vector<double> landing_points(const std::vector<double>& stop_times, double t0, double t_end) {
  std::vector<double> landings;
  if (t_end == t0) return landings;
  for (const double t : stop_times)
    if ((t - t0) * (t - t_end) < 0) landings.push_back(t);
  landings = sorted_along(std::move(landings), t0, t_end);
  landings.erase(std::unique(landings.begin(), landings.end()), landings.end());
  landings.push_back(t_end);
  return landings;
}

// The output times.
//
// @throws InvalidValue  when one lies outside the run
[[gnu::cold]] inline std::vector<double> output_points(const std::vector<double>& times, double t0, double t_end) {
  for (const double t : times)
    if (t < std::min(t0, t_end) || t > std::max(t0, t_end))
      throw_invalid_value({"every output time must lie between the start t = ", t0, " and t_end = ", t_end, ", but one is ", t,
                           "; remove it or extend the run"});
  return sorted_along(times, t0, t_end);
}

}  // namespace qdot::detail
