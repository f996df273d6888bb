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
#include <iterator>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "program/arguments.hpp"
#include "program/commands.hpp"
#include "program/json.hpp"
#include "program/steady_points.hpp"
#include "qdot/integrate/accurate/motion.hpp"
#include "qdot/mechanics/equations/ordinary_size.hpp"

namespace qdot::program {

namespace {

constexpr int tried_starts = 64;
constexpr int bases[] = {2, 3, 5, 7, 11, 13, 17, 19};  // of Halton's sequence
constexpr auto most_searched = static_cast<Eigen::Index>(std::size(bases));
constexpr std::size_t family_if_all_differ = 12;  // of the first searches

/// The i-th number of van der Corput's sequence in a base, from −½ to ½.
double halton(int i, int base) {
  double x = 0.0, digit = 1.0;
  for (; i > 0; i /= base) x += (digit /= base) * (i % base);
  return x - 0.5;
}

double wrapped(double angle) { return angle - 2.0 * std::numbers::pi * std::round(angle / (2.0 * std::numbers::pi)); }

/// Where searches begin, and beside what two places are one.
struct SearchedPlaces {
  Eigen::VectorXd start;
  std::vector<bool> is_angle, is_cyclic;
  Eigen::VectorXd reaches;  // of a search: lengths of ordinary size count as 1, small ones by themselves

  Eigen::Index size() const { return start.size(); }
  int count() const { return size() <= most_searched ? tried_starts : 1; }

  /// The k-th of them; the first is the start.
  Eigen::VectorXd place(int k) const {
    Eigen::VectorXd q = start;
    for (Eigen::Index i = 0; k > 0 && i < size(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (is_cyclic[at]) continue;
      q[i] += halton(k, bases[i]) * (is_angle[at] ? 2.0 * std::numbers::pi : 4.0 * reaches[i]);
    }
    return q;
  }

  bool are_one(const Eigen::VectorXd& found, const Eigen::VectorXd& known) const {
    for (Eigen::Index i = 0; i < size(); ++i) {
      const bool angle = is_angle[static_cast<std::size_t>(i)];
      const double apart = found[i] - known[i];
      if (std::abs(angle ? wrapped(apart) : apart) > 1e-6 * (angle ? 1.0 : std::max(reaches[i], std::abs(known[i])))) return false;
    }
    return true;
  }
};

SearchedPlaces searched_places(const SteadyRequest& request) {
  SearchedPlaces places{.start = request.start.q, .is_angle = {}, .is_cyclic = {}, .reaches = request.start.q.cwiseAbs()};
  for (const auto& c : request.scene->coordinates()) places.is_angle.push_back(c.unit == "rad");
  places.is_cyclic.assign(places.is_angle.size(), false);
  try {
    places.is_cyclic = cyclic_coordinates(request);
  } catch (const Error&) {  // at a start where the coordinates fail, all of them are searched
  }
  detail::lend_sizes(places.reaches, 0, 0.0);
  for (double& reach : places.reaches) reach = detail::reach_of(reach);
  return places;
}

struct EquilibriaFound {
  std::vector<SteadyPoint> points;
  std::size_t arrived = 0;  // searches
  bool family = false;      // each search ended at another one, and the rest was left
};

/// @throws UsageError  where no search ends at an equilibrium
EquilibriaFound equilibria_from(const SteadyRequest& request, const SearchedPlaces& places) {
  EquilibriaFound all;
  std::string first_error;
  for (int k = 0; k < places.count() && !all.family; ++k) {
    SteadyPoint found;
    try {
      found = steady_point(request, places.place(k));
    } catch (const Error& error) {
      if (k == 0) first_error = error.what();
      continue;
    }
    const bool known = std::any_of(all.points.begin(), all.points.end(),
                                   [&](const SteadyPoint& point) { return places.are_one(found.linear.q, point.linear.q); });
    if (!known) all.points.push_back(std::move(found));
    ++all.arrived;
    all.family = all.arrived == family_if_all_differ && all.points.size() == all.arrived;
  }
  if (all.points.empty())
    throw UsageError("SCENE: must rest somewhere, but none of the searches ended at an equilibrium; from its start, " + first_error);
  return all;
}

void print_equilibria(const SteadyRequest& request, const SearchedPlaces& places, const EquilibriaFound& found) {
  const auto coordinates = request.scene->coordinates();
  const std::vector<SteadyPoint>& points = found.points;
  std::printf("%s: %zu %s found\n", request.scene->name().c_str(), points.size(), points.size() == 1 ? "equilibrium" : "equilibria");
  if (found.family)
    std::printf("  each of the first %zu searches ended at another one: they form a family, and the search was left\n", found.arrived);
  for (std::size_t p = 0; p < points.size(); ++p) {
    std::printf("\n%zu: %s\n", p + 1, description(points[p].modes.stability));
    for (std::size_t i = 0; i < coordinates.size(); ++i) {
      const double q = points[p].linear.q[static_cast<Eigen::Index>(i)];
      std::printf("  %-10s % .12g %s\n", coordinates[i].name.c_str(), places.is_angle[i] ? wrapped(q) : q, coordinates[i].unit.c_str());
    }
    print_modes(request, points[p]);
  }
}

}  // namespace

int equilibria(const EquilibriaOptions& options) {
  if (options.along) return equilibria_along(options);
  if (options.show) throw UsageError("--show: must stand with --along, given without");
  const SteadyRequest request = steady_request(options);
  const SearchedPlaces places = searched_places(request);
  const EquilibriaFound found = equilibria_from(request, places);
  write_steady_points(request, found.points);
  if (options.json) {
    const SteadyList list = found.family ? SteadyList::some_of_a_family : SteadyList::all_found;
    std::printf("%s\n", steady_states_json(*request.scene, found.points, list).c_str());
  } else {
    print_equilibria(request, places, found);
  }
  return 0;
}

}  // namespace qdot::program
