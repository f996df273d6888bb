// SPDX-License-Identifier: MIT
//
// A page of a run: plots with events as marks, a moving picture, and arrows of the forces in it. A bob on a rod, in Cartesian coordinates,
// let go beside its pivot; a wind blows past it, and a wall on the left throws it back.

#include <cstdio>
#include <string>
#include <vector>

#include <qdot/effects/constraints.hpp>
#include <qdot/effects/forces.hpp>
#include <qdot/integrate/event.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulate.hpp>
#include <qdot/report/run_report.hpp>

using namespace qdot;

int main(int count, char** arguments) {
  const std::string path = count > 1 ? arguments[1] : "29_report.html";
  const double m = 1.0, l = 1.0, g = 9.81, wind = 2.0;
  const auto bob = mechanical_system<2>([=](const auto&, const auto& v) { return 0.5 * m * v.squaredNorm(); },
                                        [=](const auto& q) { return m * g * q[1]; })
                       .with_names({"x", "y"});
  const auto rod = holonomic("rod", [=](const auto& q) { return 0.5 * (q.squaredNorm() - l * l); });
  const auto air = generalized_force([=](const auto&, const auto& v) { return vector(0.1 * (wind - v[0]), -0.1 * v[1]); });
  const auto swing = scene(bob, rod, air);
  const State<2> start{0.0, {1.0, 0.0}, {0.0, 0.0}};
  const auto wall = event("wall", [](const auto& q) { return q[0] + 0.6; }).falling().action([](State<2>& s) { s.qdot *= -0.7; });
  const auto run = simulate(swing, start, 6.0, Dop853{}, {}, events(wall, event("lowest", [](const auto& q) { return q[0]; })));

  const report::ReportOptions options{
      .title = "A bob in the wind", .units = {"m", "m"}, .time_unit = "s", .energy_unit = "J",
      .view = {.drawing = {.shapes = {report::trail(1, 0, 1.0), report::line({0, 1}), report::pivot(0), report::disk(1)},
                           .backdrop = {{{-0.6, -1.1}, {-0.6, 0.2}}}},
               .points = [](const auto& q, double) { return std::vector<report::Point>{{0, 0}, {q[0], q[1]}}; }},
      .reactions_at = {1}, .forces_at = {1}};
  report::write_report(path, swing, run, options);

  const report::Page page = report::run_page(swing, run, options);  // the same as data, to be read or changed
  for (const report::Fact& fact : page.tables[1].rows) std::printf("%-8s %s\n", fact.name.c_str(), fact.value.c_str());
  for (const report::Fact& fact : page.tables[0].rows)
    if (fact.name == "longest arrow") std::printf("%s %s: %s\n", fact.name.c_str(), fact.remark.c_str(), fact.value.c_str());
  std::printf("%zu plots, %zu frames of a moving picture\n", page.plots.size(), page.animation->frames.size());
}
