// SPDX-License-Identifier: MIT
#include "qdot/report/run_report.hpp"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

#include "../catch2_bridge.hpp"
#include "../error_message.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/input.hpp"
#include "qdot/integrate/event.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

namespace {

using namespace qdot;
using namespace qdot::report;

// A mass m = 2 in the plane, hung on a rod of length 1, with a push F aside.
struct Bob {
  auto T(const auto& v) const { return 1.0 * v.squaredNorm(); }
  auto V(const auto& q) const { return 20.0 * q[1]; }
};
const auto rod = holonomic("rod", [](const auto& q) { return 0.5 * (q.squaredNorm() - 1.0); });
const auto push = generalized_force([](const auto& q, const auto&) {
  using S = std::remove_cvref_t<decltype(q[0])>;
  return vector(S(3.0), S(0.0));
});
const auto hung = scene(mechanical_system<2>(Bob{}), rod);
const auto pushed = scene(mechanical_system<2>(Bob{}), push);
const State<2> at_rest{0.0, {0.0, -1.0}, {0.0, 0.0}};

std::vector<Point> place(const Eigen::VectorXd& q, double) { return {{0, 0}, {q[0], q[1]}}; }
const Drawing drawing{.shapes = {line({0, 1}), disk(1)}};

std::string fact(const Page& page, const std::string& name) {
  for (const Facts& facts : page.tables)
    for (const Fact& f : facts.rows)
      if (f.name == name) return f.value;
  return "none of that name";
}

// Where the first arrow ends in the last frame.
Point tip(const Page& page) { return page.animation->frames.back().at(2); }

}  // namespace

TEST_CASE("the arrow of a rod's force on a mass that hangs on it is its weight, upwards") {
  const auto run = simulate(hung, at_rest, 1.0, Dop853{});
  const Page page = run_page(hung, run, {.view = {drawing, place}, .reactions_at = {1}});
  CHECK(fact(page, "longest arrow") == "20");
  CHECK_THAT(tip(page).x, WithinAbs(0.0, 1e-6));  // differences are good for so much
  CHECK_THAT(tip(page).y, WithinAbs(-1.0 + 0.25, 1e-6));  // a quarter of the picture
  CHECK(page.animation->drawing.shapes.back().points == std::vector<int>{1, 2});

  const auto upright = [](const Eigen::VectorXd& q, double) { return std::vector<Point>{{0, 0, 0}, {q[0], 0, q[1]}}; };  // in space up is z
  const Page space = run_page(hung, run, {.view = {in_space({line({0, 1}), disk(1)}), upright}, .reactions_at = {1}});
  CHECK(fact(space, "longest arrow") == "20");
  CHECK_THAT(tip(space).z, WithinAbs(-1.0 + 0.25, 1e-6));
}

TEST_CASE("the arrow at a point that stands for an angle is the torque over its lever, across it") {
  // The same mass, but the coordinates are (angle, a length that nothing shows): r = (0.5 sin q0, −0.5 cos q0), Q = (3, 0) gives 3/0.5 along x at q0 = 0.
  const auto run = simulate(pushed, State<2>{0.0, {0.0, 0.0}, {0.0, 0.0}}, 1e-6, Dop853{});
  const auto arm = [](const Eigen::VectorXd& q, double) { return std::vector<Point>{{0, 0}, {0.5 * std::sin(q[0]), -0.5 * std::cos(q[0])}}; };
  const Page page = run_page(pushed, run, {.view = {drawing, arm}, .forces_at = {1}});
  CHECK(fact(page, "longest arrow") == "6");
  CHECK_THAT(tip(page).x, WithinAbs(0.25 * 0.5, 1e-6));
  CHECK_THAT(tip(page).y, WithinAbs(-0.5, 1e-6));
}

TEST_CASE("a report has its events in every plot against time, and counts them") {
  const auto run = simulate(hung, at_rest, 1.0, Dop853{}, {}, events(every("tick", 0.25, 0.25), every("once", 2.0, 0.6)));
  const Page page = run_page(hung, run, {.units = {"m", "m"}, .time_unit = "s"});
  REQUIRE(page.plots.size() == 4);  // places, velocities, energies, their change
  for (const Plot& plot : page.plots) {
    REQUIRE(plot.marks.size() == 4);
    CHECK(plot.marks[2].name == "once");
    CHECK(plot.marks[2].x == 0.6);
  }
  CHECK(page.plots[1].y.label == "q\u0307₀, q\u0307₁ [m/s]");
  CHECK(fact(page, "tick") == "3×, t = 0.25 to 0.75 s");
  CHECK(fact(page, "once") == "t = 0.6 s");
  CHECK_FALSE(page.animation.has_value());
}

TEST_CASE("a report's energies are those of its states, and their change begins at zero") {
  const auto run = simulate(pushed, at_rest, 2.0, Dop853{}, {.rtol = 1e-11, .atol = 1e-12});
  const Page page = run_page(pushed, run, {.rows = 11});
  const Plot &energies = page.plots[2], &change = page.plots[3];
  CHECK(energies.series[1].y.front() == -20.0);
  CHECK(change.series[0].y.front() == 0.0);
  // F x of a constant force; x = ½ (F/m) t²
  CHECK_THAT(change.series[0].y.back(), WithinAbs(3.0 * 0.5 * 1.5 * 4.0, 1e-8));
}

TEST_CASE("a written report is a page by itself") {
  const auto run = simulate(hung, at_rest, 1.0, Dop853{});
  const std::string path = "run_report_test.html";
  write_report(path, hung, run, {.title = "A <hung> bob", .view = {drawing, place}});
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  std::remove(path.c_str());
  CHECK(text.str().find("<h1>A &lt;hung&gt; bob</h1>") != std::string::npos);
  CHECK(text.str().find("id=\"animation\"") != std::string::npos);
  CHECK(text.str().find("src=") == std::string::npos);
  CHECK_THROWS_AS(write_report("no such directory/x.html", hung, run), UnwritableFile);
}

TEST_CASE("a report that cannot be says what it needs") {
  const auto run = simulate(hung, at_rest, 1.0, Dop853{});
  const View view{drawing, place};
  CHECK(error_message([&] { run_page(hung, run, {.reactions_at = {1}}); }) ==
        "arrows of forces are drawn at points of a view, but no view was given; say where its points are");
  CHECK(error_message([&] { run_page(hung, run, {.view = view, .forces_at = {1}}); }) ==
        "arrows of applied forces were asked for, but the system has none; give the scene that the run is of, or leave them out");
  CHECK(error_message([&] { run_page(hung, run, {.view = view, .reactions_at = {2}}); }) ==
        "arrows must name points of the view by their numbers, 0 to 1, but one names 2");
  CHECK(error_message([&] { run_page(hung, run, {.view = {Drawing{.shapes = {disk(-1)}}, place}}); }) ==
        "shapes must name points of the view by their numbers, 0 to 1, but one names -1");
  const auto vanishing = [](const Eigen::VectorXd&, double t) { return std::vector<Point>(t < 0.5 ? 2 : 1); };
  CHECK(error_message([&] {
          run_page(hung, run, {.view = {drawing, vanishing}});
        }).find("a view must give equally many points at all times (2 at the start)") == 0);
  CHECK_THROWS_AS(run_page(hung, run, {.units = {"m"}}), DimensionError);
}

TEST_CASE("curves that would be flat beside another have plots of their own, and what rests joins one") {
  Table table{{{"t", "s", {0, 1}}, {"theta", "rad", {0.5, 0.8}}, {"phi", "rad", {0, 2}}, {"psi", "rad", {0, 2400}},
               {"chi", "rad", {0.6, 0.6}}, {"x", "m", {0, 1e-3}}}};
  const std::size_t dof = 5;
  for (std::size_t k = 1; k <= dof; ++k) table.columns.push_back({table.columns[k].name + "dot", "1/s", {0, 1}});
  const std::vector<Plot> plots = motion_plots(table, dof);
  REQUIRE(plots.size() == 4);
  CHECK(plots[0].y.label == "θ, φ, χ [rad]");
  CHECK(plots[1].y.label == "ψ [rad]");
  CHECK(plots[2].y.label == "x [m]");
  CHECK(plots[3].series.size() == dof);
  table.columns[3].values = {0, 1e-12};  // noise beside the others
  CHECK(motion_plots(table, dof)[0].series.size() == 4);
}

TEST_CASE("states of effects have the effects' names") {
  const auto floor = contact("floor", [](const auto& q) { return q[1] + 1.2; }, restitution(0.0));  // where it comes to rest
  const auto held = scene(mechanical_system<2>(Bob{}), floor, input("motor", 0, 1.0));
  const Page page = run_page(held, simulate(held, at_rest, 1.5, Dop853{}));
  CHECK(page.plots[2].y.label == "phase of floor, motor");
}
