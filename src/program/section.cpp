// SPDX-License-Identifier: MIT
//
// qdot section SCENE: where motions from one start or several pass a plane, or are once in each period, as points.
#include "qdot/analysis/section.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "program/arguments.hpp"
#include "program/commands.hpp"
#include "program/components.hpp"
#include "program/first_order_model.hpp"
#include "program/progress.hpp"
#include "program/swept_values.hpp"
#include "qdot/report/csv.hpp"
#include "qdot/report/file.hpp"
#include "qdot/report/html.hpp"
#include "qdot/report/number.hpp"
#include "qdot/report/svg.hpp"
#include "qdot/report/table.hpp"

namespace qdot::program {

namespace {

using Json = nlohmann::ordered_json;

// x_i = value, where x_i is an angle in each turn, or the phase of the time.
struct Surface {
  std::optional<Eigen::Index> place = {};
  bool angle = false;
  double value = 0.0, t0 = 0.0, period = 1.0;
  Eigen::Index dof = 0;

  double operator()(const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, double t) const {
    if (!place) return std::sin(2.0 * std::numbers::pi * (t - t0) / period);
    const double off = (*place < dof ? q[*place] : qdot[*place - dof]) - value;
    return angle ? std::sin(0.5 * off) : off;
  }
};

struct Motion {
  std::string label;
  State<Dynamic> start;
  PoincareSection<Dynamic> section = {};
};

struct SectionRequest : ChosenScene {
  explicit SectionRequest(ChosenScene chosen) : ChosenScene(std::move(chosen)), components(*this) {}
  Components components;
  Surface surface = {};
  std::string surface_text = {};
  Direction direction = Direction::rising;
  std::vector<Eigen::Index> angles = {};  // of which whole turns are left out
  Eigen::Index x = 0, y = 0;  // what is drawn
  long count = 200;
  double t_end = 0.0;
  Options options = {};
  std::vector<Motion> motions = {};
  std::vector<std::string> left_out = {};  // starts that cannot have the energy
  std::vector<std::string> paths = {};
};

// The velocity at `place` with which the state has the energy h, on the side of the one that it has; nothing where there is none.
std::optional<double> velocity_of_energy(const Model& model, State<Dynamic> state, Eigen::Index place, double h) {
  const double given = state.qdot[place], d = given != 0.0 ? std::abs(given) : 1.0;
  const auto over = [&](double v) {
    state.qdot[place] = v;
    return model.energies(state.t, model.packed(state)).jacobi - h;
  };
  // h is a polynomial of degree two in each velocity.
  const double middle = over(0.0), above = over(d), below = over(-d);
  const double a = (above + below - 2.0 * middle) / (2.0 * d * d), b = (above - below) / (2.0 * d);
  const double root = b * b - 4.0 * a * middle;
  if (!(a > 0.0) || !(root >= 0.0)) return {};
  double v = (-b + (given < 0.0 ? -1.0 : 1.0) * std::sqrt(root)) / (2.0 * a);
  for (int k = 0; k < 2 && 2.0 * a * v + b != 0.0; ++k) v -= over(v) / (2.0 * a * v + b);
  if (!(std::abs(over(v)) <= 1e-9 * (std::abs(h) + std::abs(middle) + a * v * v))) return {};
  return v;
}

void choose_starts(SectionRequest& request, const SectionCommandOptions& options) {
  const std::string scene = request.scene->name();
  const Model& model = *request.model;
  if (options.over.empty()) {
    if (options.keep_energy) throw UsageError("--keep-energy: must stand with --over, given without; one start has the energy that it has");
    request.motions.push_back({"", request.start});
    return;
  }
  if (model.is_constrained())
    throw UsageError("--over: must be left out where there are constraints, which its starts would not fulfil, given for " + scene);
  const SweptValues values = swept_values(options.over, std::nullopt, std::nullopt);
  constexpr std::size_t most = 10'000;
  if (values.count() > most) throw UsageError("--over: must make at most 10000 starts, given " + std::to_string(values.count()));
  std::vector<Eigen::Index> places;
  for (const SweptAxis& axis : values.axes()) places.push_back(request.components.place("--over", axis.name, scene));
  std::optional<Eigen::Index> solved;
  const Eigen::Index dof = model.dof();
  if (options.keep_energy) {
    solved = request.components.place("--keep-energy", *options.keep_energy, scene);
    if (*solved < dof) throw UsageError("--keep-energy: must be a velocity, given " + *options.keep_energy);
    if (std::find(places.begin(), places.end(), *solved) != places.end())
      throw UsageError("--keep-energy: must be a velocity that --over leaves alone, given " + *options.keep_energy);
  }
  const double h = model.energies(request.start.t, model.packed(request.start)).jacobi;
  for (std::size_t i = 0; i < values.count(); ++i) {
    Motion motion{"", request.start};
    const std::vector<double> chosen = values.of(i);
    for (std::size_t k = 0; k < places.size(); ++k) {
      (places[k] < dof ? motion.start.q[places[k]] : motion.start.qdot[places[k] - dof]) = chosen[k];
      motion.label += (k > 0 ? ", " : "") + request.components.names[static_cast<std::size_t>(places[k])] + " = " + report::rounded_text(chosen[k], 4);
    }
    if (solved) {
      const auto v = velocity_of_energy(model, motion.start, *solved - dof, h);
      if (!v) {
        request.left_out.push_back(motion.label);
        continue;
      }
      motion.start.qdot[*solved - dof] = *v;
    }
    request.motions.push_back(std::move(motion));
  }
  if (request.motions.empty())
    throw UsageError("--over: must have a start with the energy of the first, " + report::rounded_text(h, 6) +
                     ", given none; choose smaller values, or --set a faster start");
}

SectionRequest request_of(const SectionCommandOptions& options) {
  SectionRequest request(chosen_scene(options));
  const std::string scene = request.scene->name();
  const Eigen::Index dof = request.model->dof();
  if (options.plane.has_value() == options.every.has_value())
    throw UsageError(std::string("--plane: must be given, NAME=VALUE with a coordinate or velocity, or --every T in its place, given ") +
                     (options.plane ? "both" : "neither"));
  request.surface = {.t0 = request.start.t, .dof = dof};
  if (options.plane) {
    const Assignment plane = assignment("--plane", *options.plane);
    request.surface.place = request.components.place("--plane", plane.name, scene);
    request.surface.value = plane.value;
    request.surface_text = request.components.names[static_cast<std::size_t>(*request.surface.place)] + " = " + report::rounded_text(plane.value, 6);
  } else {
    if (options.direction) throw UsageError("--direction: must stand with --plane, given with --every");
    request.surface.period = positive_number("--every", *options.every);
    const std::string unit = request.scene->time_unit();
    request.surface_text = "every " + report::rounded_text(request.surface.period, 6) + (unit.empty() ? "" : " " + unit);
  }
  const std::string direction = options.direction.value_or("rising");
  if (direction == "rising") request.direction = Direction::rising;
  else if (direction == "falling") request.direction = Direction::falling;
  else if (direction == "either") request.direction = Direction::either;
  else throw unknown_name("--direction", "a direction", direction, {"rising", "falling", "either"});
  if (options.plane) request.surface_text += ", " + direction;

  for (const std::string& angle : options.angles) {
    const Eigen::Index place = request.components.place("--angle", angle, scene);
    if (place >= dof) throw UsageError("--angle: must be a coordinate, given " + angle);
    request.angles.push_back(place);
    if (request.surface.place && *request.surface.place == place) {
      request.surface.angle = true;
      request.surface_text += ", in each turn";
    }
  }

  // The first coordinate that the plane leaves open, and its velocity.
  if (options.show) {
    const std::size_t comma = options.show->find(',');
    if (comma == std::string::npos) throw UsageError("--show: must have the form NAME,NAME, given \"" + *options.show + "\"");
    request.x = request.components.place("--show", options.show->substr(0, comma), scene);
    request.y = request.components.place("--show", options.show->substr(comma + 1), scene);
  } else {
    const bool first_is_taken = request.surface.place && *request.surface.place % dof == 0;
    request.x = first_is_taken && dof > 1 ? 1 : 0;
    request.y = request.x + dof;
  }
  if (options.count) request.count = whole_number("--count", *options.count, 1, 10'000'000);
  const double t0 = request.start.t, usual = request.scene->t_end() - t0;
  request.t_end = options.t_end   ? finite_number("--t-end", *options.t_end)
                  : options.every ? t0 + request.surface.period * (static_cast<double>(request.count) + 0.5)
                                  : t0 + usual * static_cast<double>(request.count);
  if (request.t_end == t0) throw UsageError("--t-end: must differ from the time of the start, given " + *options.t_end);
  request.options.rtol = options.rtol ? positive_number("--rtol", *options.rtol) : 1e-10;
  request.options.atol = AbsoluteTolerance::at_most(request.options.rtol);
  choose_starts(request, options);
  request.paths = writable_files(options.out, {".csv", ".html", ".svg"});
  return request;
}

std::size_t points_of(const SectionRequest& request) {
  std::size_t points = 0;
  for (const Motion& motion : request.motions) points += motion.section.size();
  return points;
}

std::string summary_of(const SectionRequest& request) {
  const std::size_t starts = request.motions.size(), points = points_of(request);
  return std::to_string(points) + (points == 1 ? " point" : " points") + " of " + std::to_string(starts) + (starts == 1 ? " motion" : " motions") +
         (request.surface.place ? " at " : " ") + request.surface_text;
}

void write(const SectionRequest& request) {
  if (request.paths.empty()) return;
  report::Table table;
  table.columns = {{"start", "", {}}, {"t", request.scene->time_unit(), {}}};
  for (std::size_t i = 0; i < request.components.names.size(); ++i) table.columns.push_back({request.components.names[i], request.components.units[i], {}});
  report::Plot plot{.title = summary_of(request), .height = 640};
  plot.x.label = request.components.label(request.x);
  plot.y.label = request.components.label(request.y);
  const double energy = request.model->energies(request.start.t, request.model->packed(request.start)).jacobi;
  const std::string unit = request.scene->energy_unit();
  report::Facts facts{.heading = "Section", .rows = {{"surface", request.surface_text},
                                                     {"points", std::to_string(points_of(request))},
                                                     {"motions", std::to_string(request.motions.size())},
                                                     {"energy", report::rounded_text(energy, 6) + (unit.empty() ? "" : " " + unit), "of the first start"}}};
  constexpr std::size_t most_rows = 30;
  for (std::size_t i = 0; i < request.motions.size(); ++i) {
    const Motion& motion = request.motions[i];
    const auto& section = motion.section;
    report::Series series{.label = motion.label, .x = {}, .y = {}, .dots = true};
    for (std::size_t k = 0; k < section.size(); ++k) {
      const auto y = section.y.col(static_cast<Eigen::Index>(k));
      table.columns[0].values.push_back(static_cast<double>(i));
      table.columns[1].values.push_back(section.t[k]);
      for (Eigen::Index j = 0; j < y.size(); ++j) table.columns[static_cast<std::size_t>(j) + 2].values.push_back(y[j]);
      series.x.push_back(y[request.x]);
      series.y.push_back(y[request.y]);
    }
    plot.series.push_back(std::move(series));
    if (!section.complete() && facts.rows.size() < most_rows)
      facts.rows.push_back({motion.label.empty() ? "from the start" : motion.label,
                            std::to_string(section.size()) + " points, " + std::string(name(section.outcome)) +
                                " at t = " + report::rounded_text(section.t_reached, 6)});
  }
  report::Page page{.title = request.scene->title(), .lead = request.scene->summary()};
  const std::string picture = report::svg(report::in_symbols(plot));
  plot.height = 780;
  page.plots.push_back(std::move(plot));
  page.tables.push_back(std::move(facts));
  report::write_files({{request.paths[0], report::csv(table)}, {request.paths[1], report::html(report::in_symbols(std::move(page)))},
                       {request.paths[2], picture}});
}

std::string json_of(const SectionRequest& request) {
  const auto list = [](const auto& x) {
    Json numbers = Json::array();
    for (const double value : x) numbers.push_back(value);
    return numbers;
  };
  Json json;
  json["scene"] = request.scene->name();
  json["surface"] = request.surface_text;
  json["components"] = request.components.names;
  json["left_out"] = request.left_out;
  json["motions"] = Json::array();
  for (const Motion& motion : request.motions) {
    const auto& section = motion.section;
    Json one;
    one["q"] = list(motion.start.q);
    one["qdot"] = list(motion.start.qdot);
    one["outcome"] = name(section.outcome);
    one["run_outcome"] = name(section.run_outcome);
    one["message"] = section.message;
    one["t"] = section.t;
    one["y"] = Json::array();
    for (Eigen::Index k = 0; k < section.y.cols(); ++k) one["y"].push_back(list(section.y.col(k)));
    json["motions"].push_back(std::move(one));
  }
  return json.dump(2);
}

void print(const SectionRequest& request) {
  std::printf("%s: %s\n", request.scene->name().c_str(), summary_of(request).c_str());
  for (const Motion& motion : request.motions)
    std::printf("  %s%s%s\n", motion.label.c_str(), motion.label.empty() ? "" : ": ", motion.section.message.c_str());
  for (const std::string& label : request.left_out) std::printf("  %s: left out, for there is no such start with the energy of the first\n", label.c_str());
  constexpr std::size_t most_rows = 20;
  if (request.motions.size() > 1 || points_of(request) > most_rows) return;
  const auto& section = request.motions.front().section;
  std::printf("  %-14s", "t");
  for (const std::string& name : request.components.names) std::printf(" %-14s", name.c_str());
  for (std::size_t k = 0; k < section.size(); ++k) {
    std::printf("\n  %-14s", report::rounded_text(section.t[k], 8).c_str());
    for (const double y : section.y.col(static_cast<Eigen::Index>(k))) std::printf(" %-14s", report::rounded_text(y, 8).c_str());
  }
  std::printf("\n");
}

}  // namespace

int section(const SectionCommandOptions& options) {
  SectionRequest request = request_of(options);
  const SwitchingModel form{{{request.model}}};  // which any model is, be there nothing to switch or to keep
  bool all = true;
  {
    const auto starts = static_cast<double>(request.motions.size());
    ProgressBar progress(0.0, starts, !options.quiet);
    double done = 0.0;
    for (Motion& motion : request.motions) {
      const auto g = [&](const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, double t) {
        progress.reached(done + std::min(1.0, (t - request.start.t) / (request.t_end - request.start.t)));
        return request.surface(q, qdot, t);
      };
      auto surface = event(request.surface_text, g);
      surface.direction = request.surface.angle ? Direction::either : request.direction;
      const auto counts = [&](const Eigen::VectorXd&, const Eigen::VectorXd& qdot) {
        if (!request.surface.angle || request.direction == Direction::either) return true;
        const bool rises = (qdot[*request.surface.place] > 0.0) == (request.t_end > request.start.t);
        return rises == (request.direction == Direction::rising);
      };
      const FirstOrderState start{motion.start.t, request.model->packed(motion.start)};
      motion.section = poincare_section(form, start, surface, request.count, request.t_end, Dop853{}, request.options, EventList<>{}, counts);
      for (const Eigen::Index angle : request.angles)
        for (double& x : motion.section.y.row(angle)) x = std::remainder(x, 2.0 * std::numbers::pi);
      all = all && motion.section.complete();
      done += 1.0;
    }
  }
  write(request);
  if (options.json) std::printf("%s\n", json_of(request).c_str());
  else print(request);
  return all ? 0 : 1;
}

}  // namespace qdot::program
