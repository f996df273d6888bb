// SPDX-License-Identifier: MIT
//
// qdot sensitivity SCENE: ∂y(t)/∂(start, parameters), at the end as a table, with --out on the way as curves.
//
// The derivatives of the equations in the state are exact, those in parameters are differences of the equations (program/varied_motion.hpp); nothing is a
// difference of motions. A second run, with ten times the tolerance or, of Gauss, the error of a step, says how far the derivatives are known.
#include "program/sensitivity.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <utility>

#include "program/along.hpp"
#include "program/arguments.hpp"
#include "program/commands.hpp"
#include "program/components.hpp"
#include "program/json.hpp"
#include "program/methods.hpp"
#include "program/simulation.hpp"
#include "program/varied_motion.hpp"
#include "qdot/report/csv.hpp"
#include "qdot/report/file.hpp"
#include "qdot/report/html.hpp"
#include "qdot/report/number.hpp"
#include "qdot/report/svg.hpp"
#include "qdot/report/table.hpp"

namespace qdot::program {

namespace {

using report::rounded_text;

struct SensitivityTask : ChosenScene {
  explicit SensitivityTask(ChosenScene chosen) : ChosenScene(std::move(chosen)), components(*this) {}
  Components components;
  std::vector<Eigen::Index> of = {};       // places in y
  std::vector<Eigen::Index> columns = {};  // of Φ, what it is differentiated by
  std::vector<DependsOn> to = {};
  std::vector<ModelsAlong> parameters = {};
  double t_end = 0.0;
  long samples = 400;
  VariedMethod method = {};
  Options options = {};
  std::vector<std::string> paths = {};
};

std::string with_time(const SensitivityTask& task, double t) {
  return rounded_text(t, 8) + (task.scene->time_unit().empty() ? "" : " " + task.scene->time_unit());
}

std::vector<std::string> names_in(const std::string& text) {
  std::vector<std::string> names;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    names.push_back(text.substr(from, comma - from));
    from = comma + 1;
  }
  return names;
}

// Parameters, effects that are on, and entries of the start: those that were named, or all.
void choose_to(SensitivityTask& task, const std::optional<std::string>& text) {
  std::vector<std::string> numbers, valid;
  for (const ParameterInfo& p : task.scene->parameters())
    if (!p.whole) numbers.push_back(p.name);
  for (const EffectInfo& e : task.scene->effects())
    if (e.on) numbers.push_back(e.name);
  const Eigen::Index n = task.components.dof;
  std::vector<Eigen::Index> starts;
  std::vector<std::string> chosen;
  if (!text) {
    chosen = numbers;
    for (Eigen::Index i = 0; i < 2 * n; ++i) starts.push_back(i);
  } else {
    for (const std::string& name : names_in(*text)) {
      if (std::find(numbers.begin(), numbers.end(), name) != numbers.end()) {
        chosen.push_back(name);
      } else {
        try {
          starts.push_back(task.components.place("--to", name, task.scene->name()));
        } catch (const UsageError&) {
          valid = numbers;
          for (Eigen::Index i = 0; i < 2 * n; ++i) valid.push_back(task.components.names[static_cast<std::size_t>(i)]);
          throw unknown_name("--to", "a parameter, an effect that is on, or a coordinate or velocity of the start", name, valid);
        }
      }
    }
  }
  for (const Eigen::Index i : starts) {
    const auto k = static_cast<std::size_t>(i);
    task.columns.push_back(i);
    task.to.push_back({task.components.names[k] + " at the start", task.components.units[k], i < n ? task.start.q[i] : task.start.qdot[i - n]});
  }
  for (const std::string& name : chosen) {
    task.columns.push_back(2 * n + static_cast<Eigen::Index>(task.parameters.size()));
    task.parameters.emplace_back("--to", name, task);
    task.to.push_back({name, task.parameters.back().unit(), task.parameters.back().value()});
  }
}

SensitivityTask task_of(const SensitivityCommandOptions& options) {
  SensitivityTask task(chosen_scene(options));
  const double t0 = task.start.t;
  task.t_end = options.t_end ? finite_number("--t-end", *options.t_end) : task.scene->t_end();
  if (task.t_end == t0) throw UsageError("--t-end: must differ from the time of the start, given " + *options.t_end);
  if (options.of) task.of = task.components.places("--of", *options.of, task.scene->name());
  else
    for (Eigen::Index i = 0; i < 2 * task.components.dof; ++i) task.of.push_back(i);
  choose_to(task, options.to);
  if (options.samples) task.samples = whole_number("--samples", *options.samples, 2, 1'000'000);
  task.options.rtol = options.rtol ? positive_number("--rtol", *options.rtol) : 1e-11;
  task.options.atol = AbsoluteTolerance::at_most(task.options.rtol);
  if (options.method) task.method.name = *options.method;
  const MethodInfo& method = method_named(task.method.name);
  if (const std::string why = variation_misfit(*task.model, method.name); !why.empty()) {
    std::string fitting;
    for (const std::string& name : varying_methods(*task.model)) fitting += (fitting.empty() ? "" : ", ") + name;
    throw UsageError("--method: must fit " + task.scene->name() + " and take its derivatives along, but " + method.name + " " + why +
                     " (what fits: " + fitting + ")");
  }
  if (options.step && !method.fixed_step())
    throw UsageError("--step: must stand with a method of fixed step, gauss2 … gauss8, given with " + method.name + ", which chooses its steps by --rtol");
  if (method.fixed_step())
    task.method.step =
        options.step
            ? positive_number("--step", *options.step)
            : chosen_step(task.model, {.start = task.start, .t_end = task.t_end, .rtol = task.options.rtol, .atol_each = {}, .step = {}},
                          method.order);
  task.paths = writable_files(options.out, {".csv", ".html", ".svg"});
  return task;
}

VariedMotion motion_of(const SensitivityTask& task, double coarser, bool with_samples) {
  Options options = task.options;
  options.rtol *= coarser;
  options.atol = AbsoluteTolerance::at_most(options.rtol);
  const double t0 = task.start.t;
  for (long k = 0; with_samples && k <= task.samples; ++k)
    options.output_times.push_back(k == task.samples ? task.t_end : t0 + (task.t_end - t0) * static_cast<double>(k) / static_cast<double>(task.samples));
  VariedModel varied{task.model};
  for (const ModelsAlong& parameter : task.parameters) varied.parameters.push_back(parameter.value());
  varied.with_parameter = [&](Eigen::Index j, double value) { return task.parameters[static_cast<std::size_t>(j)](value); };
  varied.given = [&](Eigen::Index j, double value) {
    return task.model->packed(j < 0 ? task.start : task.parameters[static_cast<std::size_t>(j)].start(value));
  };
  VariedMethod method = task.method;
  if (method.step > 0.0) method.step *= std::pow(coarser, 1.0 / method_named(method.name).order);
  return varied_motion(varied, t0, settled(*task.model, t0, task.model->packed(task.start)), task.t_end, options, method);
}

SensitivityTable table_of(const SensitivityTask& task, const VariedMotion& motion, const VariedMotion& coarse) {
  SensitivityTable table{std::string(name(motion.outcome)), motion.message, task.method.name, motion.t, {}, {}, task.to, {}, {}, {}};
  const auto rows = static_cast<Eigen::Index>(task.of.size()), columns = static_cast<Eigen::Index>(task.columns.size());
  table.values.resize(rows);
  table.derivative.resize(rows, columns);
  table.error.resize(rows, columns);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Eigen::Index place = task.of[static_cast<std::size_t>(i)];
    table.of.push_back(task.components.names[static_cast<std::size_t>(place)]);
    table.units.push_back(task.components.units[static_cast<std::size_t>(place)]);
    table.values[i] = motion.y[place];
    for (Eigen::Index j = 0; j < columns; ++j) {
      const Eigen::Index column = task.columns[static_cast<std::size_t>(j)];
      table.derivative(i, j) = motion.Phi(place, column);
      table.error(i, j) = coarse.outcome == motion.outcome && coarse.t == motion.t
                              ? std::abs(motion.Phi(place, column) - coarse.Phi(place, column))
                              : std::nan("");
    }
  }
  return table;
}

// "rad/(m/s^2)".
std::string per(const std::string& unit, const std::string& by) {
  const auto whole = [](const std::string& text) { return text.find_first_of("/ ") == std::string::npos ? text : "(" + text + ")"; };
  if (by.empty() || unit == by) return by.empty() ? unit : "";
  return (unit.empty() ? "1" : whole(unit)) + "/" + whole(by);
}

// The columns of row i, the largest first.
std::vector<Eigen::Index> ordered(const SensitivityTable& table, Eigen::Index i) {
  std::vector<Eigen::Index> order;
  for (Eigen::Index j = 0; j < table.derivative.cols(); ++j) order.push_back(j);
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return std::abs(table.derivative(i, a)) > std::abs(table.derivative(i, b)); });
  return order;
}

// What one hundredth of it changes, to first order; nothing where it is zero.
std::string hundredth(const SensitivityTable& table, Eigen::Index i, Eigen::Index j) {
  const double value = table.to[static_cast<std::size_t>(j)].value, change = 0.01 * value * table.derivative(i, j);
  return value == 0.0 ? "" : rounded_text(change + 0.0, 3);  // no minus zero
}

void print(const SensitivityTask& task, const SensitivityTable& table) {
  std::printf("%s: %s at t = %s\n", task.scene->name().c_str(), table.outcome.c_str(), with_time(task, table.t).c_str());
  for (Eigen::Index i = 0; i < table.derivative.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    std::printf("\n%s = %s%s depends on\n", table.of[k].c_str(), rounded_text(table.values[i], 8).c_str(),
                table.units[k].empty() ? "" : (" " + table.units[k]).c_str());
    std::printf("  %-22s %-18s %-10s %-10s %s\n", "", "derivative", "known to", "for 1 %", "unit");
    for (const Eigen::Index j : ordered(table, i)) {
      const DependsOn& to = table.to[static_cast<std::size_t>(j)];
      const std::string unit = per(table.units[k], to.unit), one = hundredth(table, i, j);
      std::printf("  %-22s %-18s %-10s %-*s%s%s\n", to.name.c_str(), rounded_text(table.derivative(i, j), 10).c_str(),
                  std::isfinite(table.error(i, j)) ? rounded_text(table.error(i, j), 1).c_str() : "", unit.empty() ? 0 : 10, one.c_str(),
                  unit.empty() ? "" : " ", unit.c_str());
    }
  }
  if (table.outcome != "completed") std::printf("\n  %s\n", table.message.c_str());
}

void write(const SensitivityTask& task, const SensitivityTable& found, const VariedMotion& motion) {
  if (task.paths.empty()) return;
  const std::string time = task.scene->time_unit();
  const Eigen::Index size = motion.y.size();
  report::Table table;
  table.columns = {{"t", time, motion.times}};
  for (const Eigen::Index place : task.of) {
    report::Column column{task.components.names[static_cast<std::size_t>(place)], task.components.units[static_cast<std::size_t>(place)], {}};
    for (const Eigen::VectorXd& both : motion.samples) column.values.push_back(both[place]);
    table.columns.push_back(std::move(column));
  }
  report::Page page{.title = task.scene->title(), .lead = task.scene->summary()};
  for (std::size_t i = 0; i < task.of.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    report::Facts facts{.heading = found.of[i] + " at t = " + with_time(task, found.t) + " depends on", .rows = {}};
    report::Plot plot{.title = "What " + found.of[i] + " depends on",
                      .x = {.label = table.columns[0].heading()},
                      .y = {.label = "∂" + found.of[i] + "/∂…"},
                      .height = 380};
    constexpr std::size_t most = 12;
    for (const Eigen::Index j : ordered(found, row)) {
      const auto k = static_cast<std::size_t>(j);
      const std::string unit = per(found.units[i], found.to[k].unit);
      report::Column column{"d(" + found.of[i] + ")/d(" + found.to[k].name + ")", unit, {}};
      for (const Eigen::VectorXd& both : motion.samples) column.values.push_back(both[size * (task.columns[k] + 1) + task.of[i]]);
      facts.rows.push_back({found.to[k].name, rounded_text(found.derivative(row, j), 8) + (unit.empty() ? "" : " " + unit),
                            found.to[k].value == 0.0 ? "" : "1 % changes it by " + hundredth(found, row, j)});
      if (plot.series.size() < most) plot.series.push_back({.label = found.to[k].name, .x = motion.times, .y = column.values});
      table.columns.push_back(std::move(column));
    }
    page.tables.push_back(std::move(facts));
    page.plots.push_back(std::move(plot));
  }
  page.footer = found.message;
  const report::Page shown = report::in_symbols(std::move(page));
  report::write_files({{task.paths[0], report::csv(table)}, {task.paths[1], report::html(shown)}, {task.paths[2], report::svg(shown.plots.front())}});
}

}  // namespace

int sensitivity(const SensitivityCommandOptions& options) {
  const SensitivityTask task = task_of(options);
  const VariedMotion motion = motion_of(task, 1.0, !task.paths.empty());
  const SensitivityTable table = table_of(task, motion, motion_of(task, 10.0, false));
  write(task, table, motion);
  if (options.json) std::printf("%s\n", sensitivity_json(*task.scene, table).c_str());
  else print(task, table);
  return motion.outcome == Outcome::completed ? 0 : 1;
}

}  // namespace qdot::program
