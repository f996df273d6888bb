// SPDX-License-Identifier: MIT
//
// qdot equilibria SCENE: those that Newton's method finds from the scene's start and from 63 other places, with the
// stability of each.
//
// The places are a Halton sequence over a full turn of each angle and a few lengths of each other coordinate; what
// nothing depends on keeps its value.
// So the list is the same at every call; it may miss what has a small neighbourhood. Where each search ends at another
// equilibrium (a sleigh rests
// anywhere), a dozen stand for all.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "program/arguments.hpp"
#include "program/commands.hpp"
#include "program/json.hpp"
#include "program/steady_points.hpp"
#include "qdot/integrate/accurate/motion.hpp"
#include "qdot/mechanics/equations/ordinary_size.hpp"

namespace qdot::program {

namespace {

constexpr int tried_starts = 64;
constexpr std::size_t family_if_all_differ = 12;  // of the first searches

/// The i-th number of van der Corput's sequence in a base, from −½ to ½.
double halton(int i, int base) {
  double x = 0.0, digit = 1.0;
  for (; i > 0; i /= base) x += (digit /= base) * (i % base);
  return x - 0.5;
}

double wrapped(double angle) { return angle - 2.0 * std::numbers::pi * std::round(angle / (2.0 * std::numbers::pi)); }

}  // namespace

int equilibria(const EquilibriaOptions& options) {
  if (options.along) return equilibria_along(options);
  if (options.show) throw UsageError("--show: must stand with --along, given without");
  const SteadyRequest request = steady_request(options);
  const auto coordinates = request.scene->coordinates();
  const auto n = static_cast<Eigen::Index>(coordinates.size());
  const auto is_angle = [&](Eigen::Index i) { return coordinates[static_cast<std::size_t>(i)].unit == "rad"; };
  constexpr int bases[] = {2, 3, 5, 7, 11, 13, 17, 19};
  constexpr auto most_searched = static_cast<Eigen::Index>(std::size(bases));
  std::vector<SteadyPoint> points;
  std::string last_error;
  std::size_t arrived = 0;  // searches
  bool family = false;
  std::vector<bool> cyclic(static_cast<std::size_t>(n), false);
  try {
    cyclic = cyclic_coordinates(request);
  } catch (const Error&) {  // at a start where the coordinates fail, all of them are searched
  }
  // How far a search begins from the start, and beside what two places are one: lengths of ordinary size count as 1, small ones by themselves.
  Eigen::VectorXd reaches = request.start.q.cwiseAbs();
  detail::lend_sizes(reaches, 0, 0.0);
  for (double& reach : reaches) reach = detail::reach_of(reach);
  for (int k = 0; k < (n <= most_searched ? tried_starts : 1); ++k) {
    Eigen::VectorXd q = request.start.q;
    for (Eigen::Index i = 0; k > 0 && i < n; ++i) {
      if (cyclic[static_cast<std::size_t>(i)]) continue;
      q[i] += halton(k, bases[i]) * (is_angle(i) ? 2.0 * std::numbers::pi : 4.0 * reaches[i]);
    }
    SteadyPoint found;
    try {
      found = steady_point(request, q);
    } catch (const Error& error) {
      if (k == 0) last_error = error.what();
      continue;
    }
    const bool known = std::any_of(points.begin(), points.end(), [&](const SteadyPoint& point) {
      for (Eigen::Index i = 0; i < n; ++i) {
        const double apart = found.linear.q[i] - point.linear.q[i];
        if (std::abs(is_angle(i) ? wrapped(apart) : apart) > 1e-6 * (is_angle(i) ? 1.0 : std::max(reaches[i], std::abs(point.linear.q[i]))))
          return false;
      }
      return true;
    });
    if (!known) points.push_back(std::move(found));
    ++arrived;
    family = arrived == family_if_all_differ && points.size() == arrived;
    if (family) break;
  }
  if (points.empty())
    throw UsageError("SCENE: must rest somewhere, but none of the searches ended at an equilibrium; from its start, " +
                     last_error);
  write_steady_points(request, points);
  if (options.json) {
    std::printf("%s\n", steady_states_json(*request.scene, points,
                                           family ? SteadyList::some_of_a_family : SteadyList::all_found)
                            .c_str());
    return 0;
  }
  std::printf("%s: %zu %s found\n", request.scene->name().c_str(), points.size(),
              points.size() == 1 ? "equilibrium" : "equilibria");
  if (family)
    std::printf("  each of the first %zu searches ended at another one: they form a family, and the search was left\n",
                arrived);
  for (std::size_t p = 0; p < points.size(); ++p) {
    std::printf("\n%zu: %s\n", p + 1, description(points[p].modes.stability));
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto& c = coordinates[static_cast<std::size_t>(i)];
      std::printf("  %-10s % .12g %s\n", c.name.c_str(),
                  is_angle(i) ? wrapped(points[p].linear.q[i]) : points[p].linear.q[i], c.unit.c_str());
    }
    print_modes(request, points[p]);
  }
  return 0;
}

}  // namespace qdot::program
