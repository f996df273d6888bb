// SPDX-License-Identifier: MIT
#include "program/output.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <utility>

#include "program/comparison.hpp"
#include "qdot/report/csv.hpp"
#include "qdot/report/equation_text.hpp"
#include "qdot/report/equations.hpp"
#include "qdot/report/file.hpp"
#include "qdot/report/motion_plots.hpp"
#include "qdot/report/run_report.hpp"
#include "qdot/report/still.hpp"
#include "qdot/report/symbol.hpp"

namespace qdot::program {

namespace {

using report::readable_text;
using report::symbol;

using report::with_unit;

std::string rate_unit(const std::string& unit, const std::string& time_unit) {
  return time_unit.empty() ? unit : (unit.empty() ? "1" : unit) + "/" + time_unit;
}

std::vector<double> column(const Result& result, const std::function<double(const Sample&)>& value) {
  std::vector<double> values;
  values.reserve(result.samples.size());
  for (const Sample& sample : result.samples) values.push_back(value(sample));
  return values;
}

std::vector<report::Mark> marks(const Result& result) {
  std::vector<report::Mark> marks;
  for (const RecordedEvent& e : result.events) marks.push_back({e.t, e.name});
  return marks;
}

report::Plot drift_plot(const RunnableScene& scene, const Result& result, bool jacobi) {
  report::Plot plot{.x = {report::with_unit_symbol("t", scene.time_unit())},
                    .y = {report::with_unit_symbol(jacobi ? "h − h(0), h = q̇·p − L" : "E − E(0), E = T + V", scene.energy_unit())},
                    .time_axis = true,
                    .marks = marks(result)};
  plot.series.push_back({"", result.step_times, jacobi ? result.jacobi_change : result.energy_change});
  return plot;
}

report::Facts parameter_facts(const RunnableScene& scene, const Request& request) {
  report::Facts facts{"Parameters and start", {}};
  for (const ParameterInfo& p : scene.parameters()) {
    facts.rows.push_back({symbol(p.name), with_unit(report::rounded_text(p.value, 8), p.unit), p.meaning});
  }
  for (const EffectInfo& e : scene.effects()) {
    if (e.on) facts.rows.push_back({"with " + e.name, with_unit(report::rounded_text(e.value, 8), e.unit), e.meaning});
  }
  const auto coordinates = scene.coordinates();
  constexpr std::size_t most = 4;  // of a long chain the first few say enough
  for (std::size_t i = 0; i < std::min(most, coordinates.size()); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const auto& [name, unit] = coordinates[i];
    facts.rows.push_back({symbol(name) + "(0), " + symbol(name + "dot") + "(0)",
                          with_unit(report::rounded_text(request.start.q[k]), unit) + ", " +
                              with_unit(report::rounded_text(request.start.qdot[k]), rate_unit(unit, scene.time_unit()))});
  }
  return facts;
}

report::Facts run_facts(const RunnableScene& scene, const Request& request, const Result& result) {
  const Statistics& cost = result.statistics;
  const std::string energy_unit = scene.energy_unit();
  report::Facts facts{"Run", {}};
  facts.rows.push_back({"outcome", std::string(name(result.outcome))});
  facts.rows.push_back({"end", with_unit("t = " + report::rounded_text(result.end.t, 10), scene.time_unit())});
  const std::string method = result.statistics.method_reason.empty() ? request.method : "auto: " + result.statistics.method;
  facts.rows.push_back({"method", method + (result.step ? ", step " + readable_text(*result.step)
                                                        : ", rtol " + readable_text(request.rtol) + ", atol " + readable_text(request.atol))});
  facts.rows.push_back({"steps", std::to_string(cost.steps) + " accepted, " + std::to_string(cost.rejected()) + " rejected"});
  facts.rows.push_back({"evaluations", std::to_string(cost.evaluations) + ", and " + std::to_string(cost.jacobians) + " Jacobians"});
  if (result.start_moved) {
    facts.rows.push_back({"largest |φ|, |φ̇|", readable_text(cost.constraint_residual, 2) + ", " + readable_text(cost.constraint_velocity, 2)});
  }
  facts.rows.push_back({"wall time", with_unit(readable_text(1e3 * cost.wall_seconds, 3), "ms")});
  facts.rows.push_back({"E(0)", with_unit(report::rounded_text(result.energy.initial, 8), energy_unit)});
  facts.rows.push_back({"largest |E − E(0)|", with_unit(readable_text(result.energy.largest, 3), energy_unit)});
  if (jacobi_differs(result)) {
    facts.rows.push_back({"largest |h − h(0)|", with_unit(readable_text(result.jacobi.largest, 3), energy_unit)});
  }
  return facts;
}

/// Lagrange's equations as markup; nothing where they are no formulas, or more than one wants to read.
std::string formulas(const RunnableScene& scene) {
  constexpr std::size_t readable = 4;  // coordinates
  const report::EquationSource source = scene.equation_source();
  if (source.coordinates.size() > readable) return {};
  const auto effects = scene.effects();
  const bool with = std::any_of(effects.begin(), effects.end(), [](const EffectInfo& e) { return e.on; });
  try {
    return std::string("<h2>Lagrange’s equations") + (with ? ", without the effects</h2>\n" : "</h2>\n") + report::mathml_text(report::equations_of(source));
  } catch (const Error&) {  // not one formula
    return {};
  }
}

}  // namespace

bool jacobi_differs(const Result& result) {
  double scale = 0;
  double difference = 0;
  for (const Sample& s : result.samples) {
    scale = std::max({scale, std::abs(s.energies.kinetic), std::abs(s.energies.potential)});
    difference = std::max(difference, std::abs(s.energies.jacobi - s.energies.total()));
  }
  return difference > 1e-9 * scale;
}

std::vector<std::string> output_paths(const std::string& path) {
  return {path + ".csv", path + ".npz", path + ".html", path + ".svg"};
}

int frame_count(const RunnableScene& scene, const State<Dynamic>& start, double t_end) {
  return report::detail::frame_count(scene.positions(start.q, start.t).size(), t_end - start.t);
}

report::Table table(const RunnableScene& scene, const Result& result) {
  const auto coordinates = scene.coordinates();
  const auto n = static_cast<Eigen::Index>(coordinates.size());
  report::Table t;
  t.columns.push_back({"t", scene.time_unit(), column(result, [](const Sample& s) { return s.t; })});
  for (Eigen::Index i = 0; i < 2 * n; ++i) {
    const auto& c = coordinates[static_cast<std::size_t>(i % n)];
    t.columns.push_back({i < n ? c.name : c.name + "dot", i < n ? c.unit : rate_unit(c.unit, scene.time_unit()),
                         column(result, [i](const Sample& s) { return s.y[i]; })});
  }
  const std::string unit = scene.energy_unit();
  t.columns.push_back({"kinetic_energy", unit, column(result, [](const Sample& s) { return s.energies.kinetic; })});
  t.columns.push_back({"potential_energy", unit, column(result, [](const Sample& s) { return s.energies.potential; })});
  t.columns.push_back({"energy", unit, column(result, [](const Sample& s) { return s.energies.total(); })});
  t.columns.push_back({"jacobi_energy", unit, column(result, [](const Sample& s) { return s.energies.jacobi; })});
  return t;
}

std::vector<report::Array> arrays(const Result& result, Eigen::Index dof) {
  const std::size_t rows = result.samples.size();
  const auto n = static_cast<std::size_t>(dof);
  report::Array q{"q", {rows, n}, {}};
  report::Array qdot{"qdot", {rows, n}, {}};
  for (const Sample& s : result.samples) {
    q.values.insert(q.values.end(), s.y.data(), s.y.data() + n);
    qdot.values.insert(qdot.values.end(), s.y.data() + n, s.y.data() + 2 * n);
  }
  return {{"t", {rows}, column(result, [](const Sample& s) { return s.t; })},
          q,
          qdot,
          {"kinetic_energy", {rows}, column(result, [](const Sample& s) { return s.energies.kinetic; })},
          {"potential_energy", {rows}, column(result, [](const Sample& s) { return s.energies.potential; })},
          {"energy", {rows}, column(result, [](const Sample& s) { return s.energies.total(); })},
          {"jacobi_energy", {rows}, column(result, [](const Sample& s) { return s.energies.jacobi; })}};
}

// Arrows of forces at the points of an animation's frames; rows that say how long the longest is.
static void add_forces(report::Facts& facts, report::Animation& animation, const RunnableScene& scene, const Result& result) {
  if (animation.frames.empty()) return;
  const auto model = scene.model();
  const report::View view{.drawing = animation.drawing, .points = [&](const Eigen::VectorXd& q, double t) { return scene.positions(q, t); }};
  std::vector<int> points(animation.frames.front().size());
  std::iota(points.begin(), points.end(), 0);
  const auto y = [&](double t) {
    return std::lower_bound(result.frames.begin(), result.frames.end(), t, [](const Sample& frame, double at) { return frame.t < at; })->y;
  };
  const auto add = [&](const char* of, const auto& force, int colour) {
    if (force(result.frames.front().t, result.frames.front().y).size() == 0) return;
    constexpr double longest = 0.25;  // of the picture
    const double largest = report::detail::add_arrows(animation, view, model->dof(), y, points, force, longest, colour);
    facts.rows.push_back({"longest arrow", report::rounded_text(largest, 4), std::string("of ") + of});
  };
  add("constraint forces", [&](double t, const Eigen::VectorXd& at) { return model->constraint_forces(t, at); }, 1);
  add("applied forces", [&](double t, const Eigen::VectorXd& at) { return model->applied_forces(t, at); }, 2);
}

report::Page page(const RunnableScene& scene, const Request& request, const Result& result, bool by_size) {
  report::Page page{.title = scene.title(), .lead = scene.summary()};
  if (!scene.positions(request.start.q, request.start.t).empty()) {  // otherwise there are plots only
    report::Animation animation{.drawing = scene.drawing(), .time_unit = scene.time_unit()};
    for (const Sample& frame : result.frames) {
      animation.times.push_back(frame.t);
      animation.frames.push_back(scene.positions(frame.y.head(request.start.q.size()), frame.t));
    }
    page.animation = std::move(animation);
  }
  page.tables = {parameter_facts(scene, request), run_facts(scene, request, result)};
  if (request.forces && page.animation) add_forces(page.tables.back(), *page.animation, scene, result);
  if (!result.events.empty()) page.tables.push_back(report::detail::mark_facts(marks(result), scene.time_unit()));
  page.formulas = formulas(scene);
  page.plots = report::motion_plots(table(scene, result), scene.coordinates().size(), marks(result), by_size);
  page.plots.push_back(drift_plot(scene, result, false));
  if (jacobi_differs(result)) page.plots.push_back(drift_plot(scene, result, true));
  page.footer = "Made by qdot " QDOT_VERSION ". Energy changes are shown at the accepted steps" +
                std::string(result.outcome == Outcome::completed ? "." : "; the run ended early: " + result.message);
  return page;
}

std::vector<std::string> further_paths(const std::string& path, std::size_t runs) {
  std::vector<std::string> paths;
  for (std::size_t k = 2; k <= runs; ++k)
    for (const char* end : {".csv", ".npz"}) paths.push_back(path + "_" + std::to_string(k) + end);
  return paths;
}

void write_outputs(const std::string& path, const std::vector<ComparedRun>& runs) {
  const ComparedRun& first = runs.front();
  const report::Page shown = runs.size() > 1 ? comparison_page(runs) : page(*first.scene, first.request, first.result);
  report::Plot plot = shown.plots.front();
  plot.title = shown.title;
  const std::string picture = !shown.animation || shown.animation->frames.empty() ? report::svg(plot)
                                                                                  : report::still_svg(*shown.animation, first.result.end.t, plot);
  const std::vector<std::string> paths = output_paths(path), further = further_paths(path, runs.size());
  std::vector<report::File> files;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const ComparedRun& run = runs[k];
    files.push_back({k == 0 ? paths[0] : further[2 * k - 2], report::csv(table(*run.scene, run.result))});
    files.push_back({k == 0 ? paths[1] : further[2 * k - 1], report::npz(arrays(run.result, run.request.start.q.size()))});
  }
  files.push_back({paths[2], report::html(shown)});
  files.push_back({paths[3], picture});
  report::write_files(files);
}

}  // namespace qdot::program
