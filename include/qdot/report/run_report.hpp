#pragma once
// SPDX-License-Identifier: MIT
//
// A page of any run, in one line:
//
//     write_report("swing.html", scene, simulate(scene, start, 10.0, Dop853{}, {}, events(floor)));
//
// It has plots of coordinates, velocities, states of controllers and energies, the events as marks in them, and what the run
// cost. With a View (points and what is drawn on them, animation.hpp) it has a moving picture, and arrows of forces on request.
//
// Forces of constraints and effects are generalized ones, Q; a picture wants them at points r₁(q), r₂(q), …. Forces F₁, F₂, …
// there do the same work on every displacement δq if
//
//     Σᵢ (∂rᵢ/∂q)ᵀ Fᵢ = Q ,
//
// and of all that do, the arrows show the smallest: the torque τ on an arm of length l becomes τ/l across its end. What moves
// no such point has no arrow. ∂r/∂q is taken by differences, which is good for a picture and nothing else.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "qdot/analysis/linear/shortest_step.hpp"
#include "qdot/effects/input.hpp"
#include "qdot/effects/scene_at_state.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/mechanics/energy.hpp"
#include "qdot/mechanics/equations/ordinary_size.hpp"
#include "qdot/report/animation.hpp"
#include "qdot/report/file.hpp"
#include "qdot/report/html.hpp"
#include "qdot/report/motion_plots.hpp"
#include "qdot/report/motion_table.hpp"
#include "qdot/report/number.hpp"
#include "qdot/version.hpp"

namespace qdot::report {

/// What is seen of a motion: where its points are, always equally many, and what is drawn on them.
struct View {
  Drawing drawing{};                                                               ///< shapes on the points, by their numbers
  std::function<std::vector<Point>(const Eigen::VectorXd& q, double t)> points{};  ///< the points at a place of the motion; none for no picture
};

/// What a report says beside the run itself; all of it may be left out.
struct ReportOptions {
  std::string title = "A motion";     ///< of the page
  std::string lead{};                 ///< a sentence below it
  std::vector<std::string> units{};   ///< of the coordinates, one for each: "rad", "m"
  std::string time_unit{};            ///< "s"
  std::string energy_unit{};          ///< "J"
  View view{};                        ///< the moving picture
  std::vector<int> reactions_at{};    ///< points of the view that bear arrows of the constraints' forces Jᵀλ
  std::vector<int> forces_at{};       ///< points that bear arrows of the effects' forces ΣQ; those of V and of L are not among them
  double longest_arrow = 0.25;        ///< as a part of the picture
  int rows = 1001;                    ///< of the plots' curves
};

namespace detail {

// All of a run that a page shows, without the system's type.
struct ReportedRun {
  Table table;  // with energies
  std::size_t dof = 0;
  std::string outcome, message;
  bool completed = false;
  const std::vector<RecordedEvent>& events;
  const Statistics& statistics;
  std::function<Eigen::VectorXd(double t)> y;
  std::function<Eigen::VectorXd(double t, const Eigen::VectorXd& y)> reactions{}, forces{};  // empty where the system has none
};

// The columns of effects' states ← the effects' names, where they have some: readers know these better than z₀. Of what switches the phase alone is kept.
template <class Sc>
void name_states(Table& table, const Sc& scene) {
  std::vector<Column> columns;
  std::size_t read = 0;
  const auto take = [&](std::size_t last) { for (; read < last; ++read) columns.push_back(std::move(table.columns[read])); };
  qdot::detail::for_each_place(scene, [&]<class E>([[maybe_unused]] const E& effect, Eigen::Index place) {
    constexpr int states = qdot::detail::states_of<E>();
    constexpr bool switches = SwitchingEffect<E, Sc::dof_at_compile_time>;
    const std::size_t first = 1 + static_cast<std::size_t>(place);
    if constexpr (requires { std::string(effect.name); })
      for (std::size_t i = 0; i < states; ++i)
        table.columns[first + i].name = switches ? "phase of " + effect.name : states == 1 ? effect.name : effect.name + "[" + std::to_string(i) + "]";
    take(first + (switches ? 1 : states));
    read = first + states;
  });
  take(table.columns.size());
  table.columns = std::move(columns);
}

inline Facts run_facts(const ReportedRun& run, const ReportOptions& options) {
  const Statistics& cost = run.statistics;
  const std::vector<double>& E = run.table.column("energy").values;
  double largest = 0;
  for (const double e : E) largest = std::max(largest, std::abs(e - E.front()));
  Facts facts{"Run", {{"outcome", run.outcome},
                      {"end", "t = " + with_unit(rounded_text(run.table.columns[0].values.back(), 10), options.time_unit)},
                      {"method", cost.method},
                      {"steps", std::to_string(cost.steps) + " accepted, " + std::to_string(cost.rejected()) + " rejected"},
                      {"evaluations", std::to_string(cost.evaluations) + ", and " + std::to_string(cost.jacobians) + " Jacobians"}}};
  if (cost.projections > 0)
    facts.rows.push_back(
        {"largest |φ|, |φ̇|", readable_text(cost.constraint_residual, 2) + ", " + readable_text(cost.constraint_velocity, 2)});
  facts.rows.push_back({"wall time", readable_text(1e3 * cost.wall_seconds, 3) + " ms"});
  facts.rows.push_back({"E(0)", with_unit(rounded_text(E.front(), 8), options.energy_unit)});
  facts.rows.push_back({"largest |E − E(0)|", with_unit(readable_text(largest, 3), options.energy_unit)});
  return facts;
}

// Adds arrows of the forces at some points to the frames, all to one scale; the largest force is returned.
template <class = void>  // compiled only where it is called
double add_arrows(Animation& animation, const View& view, Eigen::Index dof, const std::function<Eigen::VectorXd(double)>& y_at, const std::vector<int>& at,
                  const std::function<Eigen::VectorXd(double, const Eigen::VectorXd&)>& force, double longest, int colour) {
  std::vector<std::vector<Point>> forces;
  constexpr double beyond = std::numeric_limits<double>::max();
  Eigen::Array3d low = Eigen::Array3d::Constant(beyond), high = -low;  // of all points
  double largest = 0;
  for (std::size_t k = 0; k < animation.times.size(); ++k) {
    const double t = animation.times[k];
    const Eigen::VectorXd y = y_at(t);
    Eigen::VectorXd q = y.head(dof);
    Eigen::MatrixXd A(dof, 3 * static_cast<Eigen::Index>(at.size()));
    for (Eigen::Index j = 0; j < dof; ++j) {
      const double h = 1e-5 * qdot::detail::reach_of(std::abs(q[j])), here = q[j];
      q[j] = here + h;
      const std::vector<Point> ahead = view.points(q, t);
      q[j] = here - h;
      const std::vector<Point> behind = view.points(q, t);
      q[j] = here;
      for (std::size_t i = 0; i < at.size(); ++i) {
        const auto p = static_cast<std::size_t>(at[i]);
        const auto column = 3 * static_cast<Eigen::Index>(i);
        A(j, column) = (ahead[p].x - behind[p].x) / (2 * h);
        A(j, column + 1) = (ahead[p].y - behind[p].y) / (2 * h);
        A(j, column + 2) = view.drawing.camera ? (ahead[p].z - behind[p].z) / (2 * h) : 0.0;
      }
    }
    constexpr double no_motion = 1e-8;  // of differences, beside the largest slope
    const Eigen::VectorXd F = qdot::detail::shortest_step(A, force(t, y), no_motion).x;
    std::vector<Point> each;
    for (std::size_t i = 0; i < at.size(); ++i) {
      const auto column = 3 * static_cast<Eigen::Index>(i);
      each.push_back({F[column], F[column + 1], F[column + 2]});
      largest = std::max(largest, std::hypot(each.back().x, each.back().y, each.back().z));
    }
    forces.push_back(std::move(each));
    for (const Point& p : animation.frames[k]) {
      const Eigen::Array3d place(p.x, p.y, view.drawing.camera ? p.z : 0.0);
      low = low.min(place), high = high.max(place);
    }
  }
  const double extent = (high - low).maxCoeff();
  const double scale = largest > 0 ? longest * (extent > 0 ? extent : 1.0) / largest : 0.0;
  const int before = static_cast<int>(animation.frames.front().size());
  for (std::size_t k = 0; k < forces.size(); ++k) {
    for (std::size_t i = 0; i < at.size(); ++i) {
      const Point from = animation.frames[k][static_cast<std::size_t>(at[i])];
      animation.frames[k].push_back({from.x + scale * forces[k][i].x, from.y + scale * forces[k][i].y, from.z + scale * forces[k][i].z});
    }
  }
  for (std::size_t i = 0; i < at.size(); ++i) animation.drawing.shapes.push_back(arrow(at[i], before + static_cast<int>(i), colour));
  return largest;
}

inline void require_points(const char* what, const std::vector<int>& numbers, std::size_t count) {
  for (const int i : numbers) {
    if (i < 0 || static_cast<std::size_t>(i) >= count)
      throw InvalidValue(std::string(what) + " must name points of the view by their numbers, 0 to " +
                         std::to_string(static_cast<long>(count) - 1) + ", but one names " + std::to_string(i));
  }
}

template <class = void>  // compiled only where it is called
Animation moving_picture(const ReportedRun& run, const ReportOptions& options, Facts& facts) {
  const double from = run.table.columns[0].values.front(), to = run.table.columns[0].values.back();
  const auto dof = static_cast<Eigen::Index>(run.dof);
  Animation animation{.drawing = options.view.drawing, .time_unit = options.time_unit};
  const std::size_t count = options.view.points(run.y(from).head(dof), from).size();
  for (const Shape& shape : animation.drawing.shapes) require_points("shapes", shape.points, count);
  require_points("arrows", options.reactions_at, count);
  require_points("arrows", options.forces_at, count);
  if (!(to > from)) return animation;
  const int frames = frame_count(count, to - from);
  for (int k = 0; k < frames; ++k) {
    const double t = k + 1 == frames ? to : from + (to - from) * k / (frames - 1);
    animation.times.push_back(t);
    animation.frames.push_back(options.view.points(run.y(t).head(dof), t));
    const auto& points = animation.frames.back();
    if (points.size() != count || std::any_of(points.begin(), points.end(),
                                              [](Point p) { return !std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z); }))
      throw InvalidValue("a view must give equally many points at all times (" + std::to_string(count) +
                         " at the start), and finite ones; at t = " + rounded_text(t, 8) + " it does not");
  }
  const auto arrows = [&](const char* of, const std::vector<int>& at, const auto& force, int colour) {
    if (at.empty()) return;
    if (!force)
      throw InvalidValue("arrows of " + std::string(of) +
                         " were asked for, but the system has none; give the scene that the run is of, or leave them out");
    facts.rows.push_back({"longest arrow",
                          rounded_text(add_arrows(animation, options.view, dof, run.y, at, force, options.longest_arrow, colour), 4),
                          std::string("of ") + of});
  };
  arrows("constraint forces", options.reactions_at, run.reactions, 1);
  arrows("applied forces", options.forces_at, run.forces, 2);
  return animation;
}

template <class = void>  // compiled only where it is called
Page page_of(ReportedRun run, const ReportOptions& options) {
  Table& table = run.table;
  if (!options.units.empty() && options.units.size() != run.dof)
    throw DimensionError("the list of the coordinates' units", static_cast<long>(run.dof), static_cast<long>(options.units.size()),
                         "give one for each, or none");
  table.columns[0].unit = options.time_unit;
  for (std::size_t i = 0; i < options.units.size(); ++i) {
    const std::string& unit = options.units[i];
    table.columns[1 + i].unit = unit;
    table.columns[1 + run.dof + i].unit = options.time_unit.empty() ? unit : (unit.empty() ? "1" : unit) + "/" + options.time_unit;
  }
  Page page{.title = options.title, .lead = options.lead};
  Facts facts = run_facts(run, options);
  if (options.view.points) {
    page.animation = moving_picture(run, options, facts);
  } else if (!options.reactions_at.empty() || !options.forces_at.empty()) {
    throw InvalidValue("arrows of forces are drawn at points of a view, but no view was given; say where its points are");
  }
  page.tables.push_back(std::move(facts));
  std::vector<Mark> marks;
  for (const RecordedEvent& e : run.events) marks.push_back({e.t, e.name});
  if (!marks.empty()) page.tables.push_back(mark_facts(marks, options.time_unit));
  page.plots = motion_plots(table, run.dof, marks);
  Plot drift = plot_against_time(table, marks);
  drift.y.label = with_unit_symbol("E − E(0), E = T + V", options.energy_unit);
  drift.series.push_back({"", table.columns[0].values, table.column("energy").values});
  for (double& e : drift.series[0].y) e -= table.column("energy").values.front();
  page.plots.push_back(std::move(drift));
  page.footer = "Made by qdot " + std::to_string(version_major) + "." + std::to_string(version_minor) + "." + std::to_string(version_patch) +
                (run.completed ? "." : "; the run ended early: " + run.message);
  return page;
}

}  // namespace detail

/// A page of a run: plots with its events, its energies and cost, and the view where one is given; to be changed at will before html() writes it.
///
/// @param system  the system or the scene that the run is of
/// @throws InvalidValue    a run that kept no trajectory; points of shapes or arrows that the view does not have; arrows of forces that there are none of
/// @throws DimensionError  a system of another size; units that are not as many as the coordinates
template <class System, int n>
Page run_page(const System& system, const Run<n>& run, const ReportOptions& options = {}) {
  const auto form = first_order_form(system);
  detail::ReportedRun reported{.table = motion_table(system, run, options.rows), .dof = static_cast<std::size_t>(run.trajectory.dof()),
                               .outcome = std::string(name(run.outcome)),
                               .message = run.message, .completed = run.completed(), .events = run.events, .statistics = run.statistics,
                               .y = [&](double t) { return Eigen::VectorXd(run.trajectory.y(t)); }};
  Column T{"kinetic_energy", options.energy_unit, {}}, V{"potential_energy", options.energy_unit, {}}, E{"energy", options.energy_unit, {}};
  const auto& bare = system.system();
  for (const double t : reported.table.columns[0].values) {
    const auto s = form.state(t, run.trajectory.y(t));
    T.values.push_back(kinetic_energy(bare, s.q, s.qdot, t));
    V.values.push_back(potential_energy(bare, s.q, t));
    E.values.push_back(T.values.back() + V.values.back());
  }
  if constexpr (requires { system.initial_states(); }) {
    detail::name_states(reported.table, system);
    using Coords = Coordinates<std::remove_cvref_t<decltype(bare)>>;
    const auto split = [&](const Eigen::VectorXd& y, auto&& f) {
      const Eigen::Index dof = system.dof();
      return Eigen::VectorXd(f(Coords(y.head(dof)), Coords(y.segment(dof, dof)), decltype(system.initial_states())(y.tail(y.size() - 2 * dof))));
    };
    if constexpr (System::has_constraints)
      reported.reactions = [=, &system](double t, const Eigen::VectorXd& y) {
        return split(y, [&](const auto& q, const auto& qdot, const auto& z) { return reactions(system, q, qdot, t, z); });
      };
    if constexpr (System::has_forces)
      reported.forces = [=, &system](double t, const Eigen::VectorXd& y) {
        return split(y, [&](const auto& q, const auto& qdot, const auto& z) { return effect_forces(system, q, qdot, z, t); });
      };
  }
  for (Column* column : {&T, &V, &E}) reported.table.columns.push_back(std::move(*column));
  return detail::page_of(std::move(reported), options);
}

/// Writes the page of a run as one HTML file that loads nothing from a network.
///
/// @param path  of the file, in a directory that exists
/// @throws UnwritableFile  naming the path and the system's reason
/// @throws as run_page()
template <class System, int n>
void write_report(const std::string& path, const System& system, const Run<n>& run, const ReportOptions& options = {}) {
  write_files({{path, html(run_page(system, run, options))}});
}

}  // namespace qdot::report
