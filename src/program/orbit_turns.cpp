// SPDX-License-Identifier: MIT
#include "program/orbit_turns.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace qdot::program {

namespace {

/// How often values that repeat themselves rise and fall, where less than a thousandth of their extent counts for nothing.
int swings_of(const std::vector<double>& values) {
  constexpr double visible = 1e-3, rounding = 1e-7;
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  const double extent = *most - *least;
  if (!(extent > rounding * std::max(std::abs(*most), std::abs(*least)))) return 0;
  const auto first = static_cast<std::size_t>(least - values.begin());
  int swings = 0;
  bool rises = true;
  double turned = *least;  // the extreme value since the direction last changed
  for (std::size_t k = 1; k <= values.size(); ++k) {
    const double value = values[(first + k) % values.size()];
    if (rises ? value > turned : value < turned) {
      turned = value;
    } else if (std::abs(value - turned) > visible * extent) {
      swings += rises ? 1 : 0;
      rises = !rises;
      turned = value;
    }
  }
  return swings;
}

std::string times_text(int count) { return count == 1 ? "once" : count == 2 ? "twice" : std::to_string(count) + " times"; }

}  // namespace

std::vector<Turns> turns_of(const std::vector<Eigen::VectorXd>& points, const Eigen::VectorXd& advance) {
  std::vector<Turns> turns;
  for (Eigen::Index i = 0; i < advance.size(); ++i) {
    Turns each;
    each.rounds = static_cast<int>(std::lround(std::abs(advance[i]) / (2.0 * std::numbers::pi)));
    if (each.rounds == 0 && points.size() > 1) {
      std::vector<double> values;
      for (std::size_t k = 0; k + 1 < points.size(); ++k) values.push_back(points[k][i]);  // the last point is the first again
      each.swings = swings_of(values);
    }
    turns.push_back(each);
  }
  return turns;
}

std::string turns_text(const Turns& turns) {
  if (turns.rounds > 0) return "goes round " + times_text(turns.rounds);
  return turns.swings > 0 ? "swings " + times_text(turns.swings) : "rests";
}

int points_for(const std::vector<Turns>& turns) {
  constexpr int for_each = 64, least = 400, most = 100 * for_each;
  int largest = 1;
  for (const Turns& each : turns) largest = std::max({largest, each.swings, each.rounds});
  return std::clamp(for_each * std::min(largest, most / for_each), least, most);
}

}  // namespace qdot::program
