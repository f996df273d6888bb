// SPDX-License-Identifier: MIT
//
// qdot modes SCENE: the equilibrium (or, with --steady, the steady motion) near the start, its stability, and its
// modes.
#include <cstdio>

#include "program/arguments.hpp"
#include "program/commands.hpp"
#include "program/json.hpp"
#include "program/steady_points.hpp"

namespace qdot::program {

int modes(const ModesOptions& options) {
  const SteadyRequest request = steady_request(options);
  std::vector<SteadyPoint> points;
  try {
    points.push_back(steady_point(request, request.start.q));
  } catch (const Error& error) {
    throw UsageError("SCENE: must " + std::string(options.steady ? "move steadily" : "rest") +
                     " near its start, for modes of it; " + error.what());
  }
  write_steady_points(request, points);
  if (options.json) {
    std::printf("%s\n", steady_states_json(*request.scene, points, SteadyList::the_only_one).c_str());
    return 0;
  }
  std::printf("%s: %s, %s\n", request.scene->name().c_str(), options.steady ? "steady motion" : "equilibrium",
              description(points[0].modes.stability));
  const auto coordinates = request.scene->coordinates();
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    std::printf("  %-10s % .12g %s\n", coordinates[i].name.c_str(), points[0].linear.q[k], coordinates[i].unit.c_str());
  }
  for (const Reaction& r : points[0].reactions) std::printf("  lambda of %s  %.12g\n", r.name.c_str(), r.lambda);
  print_modes(request, points[0]);
  return 0;
}

}  // namespace qdot::program
