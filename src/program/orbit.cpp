// SPDX-License-Identifier: MIT
//
// qdot orbit SCENE: a periodic orbit that the start leads to, its multipliers and its stability; with --along the family that it belongs to.
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "program/arguments.hpp"
#include "program/commands.hpp"
#include "program/components.hpp"
#include "program/json.hpp"
#include "program/orbit_search.hpp"
#include "program/orbit_turns.hpp"
#include "qdot/report/csv.hpp"
#include "qdot/report/file.hpp"
#include "qdot/report/html.hpp"
#include "qdot/report/number.hpp"
#include "qdot/report/svg.hpp"
#include "qdot/report/symbol.hpp"
#include "qdot/report/table.hpp"

namespace qdot::program {

namespace {

using report::rounded_text;
using In = OrbitRequest::In;
using HeldWhat = OrbitRequest::Held;

struct OrbitTask : OrbitRequest {
  explicit OrbitTask(OrbitRequest request) : OrbitRequest(std::move(request)), components(*this) {}
  Components components;
  std::optional<Along> range = {};
  Eigen::Index x = 0, y = 0;  // what is drawn
  std::vector<std::string> paths = {};
  std::vector<Return> returns = {};

  std::string followed() const { return range->name; }
  std::string followed_unit() const { return in == In::energy ? scene->energy_unit() : in == In::period ? scene->time_unit() : models->unit(); }
  std::string followed_label() const { return followed() + (followed_unit().empty() ? "" : " [" + followed_unit() + "]"); }
};

using report::with_unit;

/// How an orbit moves, and where it is; empty where none was found.
struct OrbitMotion {
  std::vector<Turns> turns = {};
  Eigen::VectorXd beginning = {}, moved = {};
};

OrbitMotion motion_of(const OrbitTask& task, const Orbit& orbit) {
  constexpr int samples = 4000;
  if (!orbit.found()) return {};
  return {turns_of(points_of(task, orbit, samples), task.advance), beginning_of(task), moved_by(task, orbit)};
}

void choose_held(OrbitTask& task, const OrbitCommandOptions& options, const Returns& back) {
  const std::string scene = task.scene->name();
  if (back.driven) {
    if (!options.period)
      throw UsageError("--period: must be given where something depends on the time, as in " + scene +
                       ": the period of what does, or a multiple of it");
    if (options.hold) throw UsageError("--hold: must be left out where the period is that of a drive, given " + *options.hold);
    task.held = HeldWhat::drive;
    return;
  }
  if (options.period) {
    if (options.hold) throw UsageError("--hold: must be left out where --period holds the period, given " + *options.hold);
    task.held = HeldWhat::period;
    return;
  }
  task.held = back.conserves_energy ? HeldWhat::energy : HeldWhat::nothing;
  if (!options.hold) return;
  if (*options.hold == "nothing") {
    task.held = HeldWhat::nothing;
  } else if (*options.hold == "energy" || options.hold->starts_with("energy=")) {
    task.held = HeldWhat::energy;
    if (options.hold->size() > 6) task.energy = assignment("--hold", *options.hold).value;
  } else {
    task.held = HeldWhat::coordinate;
    task.coordinate = task.components.place("--hold", *options.hold, scene);
    if (task.coordinate >= task.components.dof) throw UsageError("--hold: must be nothing, energy, energy=E or a coordinate, given " + *options.hold);
  }
}

OrbitTask task_of(const OrbitCommandOptions& options) {
  OrbitTask task(OrbitRequest{chosen_scene(options)});
  const std::string scene = task.scene->name();
  for (const OwnState& state : task.model->own_states())
    if (state.kind == OwnState::state)
      throw UsageError("SCENE: must have no states but coordinates and velocities, for orbits, but an effect of " + scene +
                       " has one of its own, " + state.name);
  if (options.along) {
    task.range = along("--along", *options.along);
    task.in = task.range->name == "energy" ? In::energy : task.range->name == "period" ? In::period : In::parameter;
    task.to = task.range->to;
    if (task.in == In::parameter) {
      task.models.emplace("--along", task.range->name, task);
      task.from = task.range->from.value_or(task.models->value());
      if (task.from == task.to) throw UsageError("--along " + task.followed() + ": must go to another value than it begins with, " + rounded_text(task.from));
    }
  }
  if (options.period && options.period_guess) throw UsageError("--period-guess: must be left out where --period says what it is, given both");
  std::optional<double> period;
  if (options.period) period = positive_number("--period", *options.period);
  if (options.period_guess) period = positive_number("--period-guess", *options.period_guess);
  const auto model = task.models ? (*task.models)(task.from) : task.model;
  if (options.settle) task.start = state_after(task, *model, positive_number("--settle", *options.settle));
  const Returns back = returns_to_start(task, *model, period);
  choose_held(task, options, back);
  task.returns = back.each;
  if (task.range && task.in != In::parameter) {
    if (back.driven) throw UsageError("--along: must name a parameter where the period is that of a drive, given " + task.followed());
    if (task.range->from && task.in == In::energy) {
      if (options.hold || options.period) throw UsageError("--along energy: must begin with the energy that it has, energy=:TO, where something else is held");
      task.held = HeldWhat::energy;
      task.energy = task.range->from;
    }
    if (task.range->from && task.in == In::period) {
      if (options.hold || options.period) throw UsageError("--along period: must begin with the period that it has, period=:TO, where something else is held");
      task.held = HeldWhat::period;
      task.returns.erase(task.returns.begin(), task.returns.end() - 1);
      task.returns.back().period = positive_number("--along period", rounded_text(*task.range->from, 17));
    }
  }
  task.y = 1;  // the velocity of a single coordinate, or the second one
  if (options.show) {
    const auto shown = task.components.places("--show", *options.show, scene);
    if (shown.size() != 2) throw UsageError("--show: must have the form NAME,NAME, given \"" + *options.show + "\"");
    task.x = shown[0];
    task.y = shown[1];
  }
  task.paths = writable_files(options.out, {".csv", ".html", ".svg"});
  return task;
}

std::string multiplier_text(const std::complex<double>& z) {
  if (z.imag() == 0.0) return rounded_text(z.real(), 8);
  return rounded_text(z.real(), 8) + (z.imag() < 0.0 ? " - " : " + ") + rounded_text(std::abs(z.imag()), 8) + "i";
}

// The largest multiplier that is not trivial.
const Multiplier* largest(const Orbit& orbit) {
  for (const Multiplier& m : orbit.multipliers)
    if (!m.trivial) return &m;
  return nullptr;
}

/// "at the start, swings once; sought from 1 m"
std::string remark_of(const OrbitTask& task, const OrbitMotion& motion, std::size_t i) {
  constexpr double visible = 1e-3;
  std::string remark = "at the start";
  if (i < motion.turns.size()) remark += ", " + turns_text(motion.turns[i]);
  const auto k = static_cast<Eigen::Index>(i);
  if (k < motion.moved.size() && motion.moved[k] > visible)
    remark += "; sought from " + with_unit(rounded_text(motion.beginning[k], 6), task.components.units[i]);
  return remark;
}

/// What is said where an orbit is not near the start; else "".
std::string far_text(const OrbitTask& task, const OrbitMotion& motion) {
  constexpr double near = 0.1;
  if (motion.moved.size() == 0) return "";
  Eigen::Index i = 0;
  const double most = motion.moved.maxCoeff(&i);
  if (!(most > near)) return "";
  return "far from the start that was given, in " + task.components.names[static_cast<std::size_t>(i)] +
         " most; for another orbit give --period-guess, --hold or another start";
}

report::Facts facts_of(const OrbitTask& task, const Orbit& orbit, const OrbitMotion& motion) {
  report::Facts facts{.heading = orbit.found() ? std::string(description(orbit.stability)) : std::string(name(orbit.outcome)), .rows = {}};
  facts.rows.push_back({"period", with_unit(number_text(orbit.period), task.scene->time_unit())});
  facts.rows.push_back({"energy", with_unit(number_text(orbit.energy), task.scene->energy_unit()), orbit.conserves_energy ? "conserved" : ""});
  if (task.models) facts.rows.push_back({task.models->name(), with_unit(number_text(orbit.parameter), task.models->unit())});
  for (Eigen::Index i = 0; i < orbit.x.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    facts.rows.push_back({task.components.names[k], with_unit(number_text(orbit.x[i]), task.components.units[k]), remark_of(task, motion, k)});
  }
  for (const Multiplier& m : orbit.multipliers)
    facts.rows.push_back(
        {"multiplier", multiplier_text(m.value),
         m.trivial ? "trivial" : "|μ| = " + rounded_text(std::abs(m.value), 8) + ", known to " + rounded_text(m.radius, 2)});
  for (const std::string& symmetry : orbit.symmetries) facts.rows.push_back({"symmetry", symmetry});
  for (const std::string& open : orbit.undetermined) facts.rows.push_back({"left open", open});
  return facts;
}

report::Plot plane(const OrbitTask& task, const std::string& title) {
  report::Plot plot{.title = title, .height = 420};
  plot.x.label = task.components.label(task.x);
  plot.y.label = task.components.label(task.y);
  const auto n = static_cast<std::size_t>(task.components.dof), x = static_cast<std::size_t>(task.x), y = static_cast<std::size_t>(task.y);
  plot.equal_units = x < n && y < n && task.components.units[x] == task.components.units[y];
  return plot;
}

report::Series curve(const OrbitTask& task, const std::vector<Eigen::VectorXd>& points, std::string label) {
  report::Series series{.label = std::move(label), .x = {}, .y = {}};
  for (const Eigen::VectorXd& y : points) {
    series.x.push_back(y[task.x]);
    series.y.push_back(y[task.y]);
  }
  return series;
}

report::Plot circle_of(const Orbit& orbit) {
  report::Plot plot{.title = "Multipliers", .x = {.label = "Re μ"}, .y = {.label = "Im μ"}, .height = 420};
  plot.equal_units = true;
  report::Series circle{.label = "unit circle", .x = {}, .y = {}},
      trivial{.label = "trivial", .x = {}, .y = {}, .markers = true, .dots = true},
      others{.label = "others", .x = {}, .y = {}, .markers = true, .dots = true};
  for (int k = 0; k <= 120; ++k) {
    circle.x.push_back(std::cos(std::numbers::pi * k / 60.0));
    circle.y.push_back(std::sin(std::numbers::pi * k / 60.0));
  }
  for (const Multiplier& m : orbit.multipliers) {
    (m.trivial ? trivial : others).x.push_back(m.value.real());
    (m.trivial ? trivial : others).y.push_back(m.value.imag());
  }
  plot.series = {std::move(circle)};
  for (report::Series* each : {&others, &trivial})
    if (!each->x.empty()) plot.series.push_back(std::move(*each));
  return plot;
}

void write_orbit(const OrbitTask& task, const Orbit& orbit, const OrbitMotion& motion) {
  if (task.paths.empty() || !orbit.found()) return;
  const int samples = points_for(motion.turns);
  const std::vector<Eigen::VectorXd> points = points_of(task, orbit, samples);
  const Eigen::Index n = task.components.dof;
  report::Table table;
  table.columns = {{"t", task.scene->time_unit(), {}}};
  for (Eigen::Index i = 0; i < 2 * n; ++i)
    table.columns.push_back({task.components.names[static_cast<std::size_t>(i)], task.components.units[static_cast<std::size_t>(i)], {}});
  report::Animation animation{.drawing = task.scene->drawing(), .time_unit = task.scene->time_unit()};
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double t = orbit.t + orbit.period * static_cast<double>(k) / samples;
    table.columns[0].values.push_back(t);
    for (Eigen::Index i = 0; i < 2 * n; ++i) table.columns[static_cast<std::size_t>(i) + 1].values.push_back(points[k][i]);
    animation.times.push_back(t);
    animation.frames.push_back(task.scene->positions(points[k].head(n), t));
  }
  report::Page page{.title = task.scene->title(), .lead = task.scene->summary()};
  if (!animation.frames.front().empty()) page.animation = std::move(animation);
  page.tables.push_back(facts_of(task, orbit, motion));
  report::Plot picture = plane(task, "Periodic orbit, " + std::string(description(orbit.stability)));
  picture.series.push_back(curve(task, points, ""));
  page.plots = {picture, circle_of(orbit)};
  for (Eigen::Index i = 0; i < std::min<Eigen::Index>(n, 6); ++i) {
    const report::Column& column = table.columns[static_cast<std::size_t>(i) + 1];
    report::Plot plot{.title = column.name, .x = {.label = table.columns[0].heading()}, .y = {.label = column.heading()}};
    plot.series.push_back({.label = "", .x = table.columns[0].values, .y = column.values});
    page.plots.push_back(std::move(plot));
  }
  const std::string far = far_text(task, motion);
  page.footer = orbit.message + (far.empty() ? "" : "; " + far);
  report::write_files({{task.paths[0], report::csv(table)},
                       {task.paths[1], report::html(report::in_symbols(std::move(page)))},
                       {task.paths[2], report::svg(report::in_symbols(picture))}});
}

bool is_special(const std::string& kind) { return kind != "start" && kind != "regular" && kind != "end"; }
std::string words(std::string kind) {
  std::replace(kind.begin(), kind.end(), '_', ' ');
  return kind == "branch" ? "branch point" : kind;
}

// What a quantity does along the family: a line for each kind of stability, dots at special points.
template <class Quantity>
report::Plot along_family(const OrbitTask& task, const FamilyFound& family, const std::string& label, const Quantity& quantity) {
  report::Plot plot{.title = "Periodic orbits along " + task.followed(), .x = {.label = task.followed_label()}, .y = {.label = label}, .height = 420};
  constexpr double gap = std::numeric_limits<double>::quiet_NaN();
  const auto& orbits = family.orbits;
  const auto between = [&](std::size_t k) { return orbits[is_special(orbits[k + 1].kind) || (k + 2 == orbits.size() && k > 0) ? k : k + 1].orbit.stability; };
  for (const OrbitStability stability :
       {OrbitStability::asymptotically_stable, OrbitStability::stable_to_first_order, OrbitStability::not_decided, OrbitStability::unstable}) {
    report::Series series{.label = std::string(description(stability)), .x = {}, .y = {}};
    series.dashed = stability == OrbitStability::unstable;
    std::size_t last = orbits.size();
    for (std::size_t k = 0; k + 1 < orbits.size(); ++k) {
      if (between(k) != stability) continue;
      if (last != k) {
        series.x.insert(series.x.end(), {gap, orbits[k].value});
        series.y.insert(series.y.end(), {gap, quantity(k)});
      }
      series.x.push_back(orbits[k + 1].value);
      series.y.push_back(quantity(k + 1));
      last = k + 1;
    }
    if (!series.x.empty()) plot.series.push_back(std::move(series));
  }
  for (const char* kind : {"fold", "period_doubling", "branch", "torus"}) {
    report::Series series{.label = words(kind), .x = {}, .y = {}, .markers = true, .dots = true};
    for (std::size_t k = 0; k < orbits.size(); ++k) {
      if (orbits[k].kind != kind) continue;
      series.x.push_back(orbits[k].value);
      series.y.push_back(quantity(k));
    }
    if (!series.x.empty()) plot.series.push_back(std::move(series));
  }
  return plot;
}

void write_family(const OrbitTask& task, const FamilyFound& family) {
  if (task.paths.empty() || family.orbits.empty() || !family.orbits.front().orbit.found()) return;
  const std::string time = task.scene->time_unit();
  const std::vector<std::string> kinds_in_file = {"start", "regular", "fold", "period_doubling", "branch", "torus", "end"};
  report::Table table;
  table.columns = {{"kind", "", {}},      {task.followed(), task.followed_unit(), {}},
                   {"T", time, {}},       {"h", task.scene->energy_unit(), {}},
                   {"stability", "", {}}, {"largest_re", "", {}},
                   {"largest_im", "", {}}};
  for (Eigen::Index i = 0; i < 2 * task.components.dof; ++i)
    table.columns.push_back({task.components.names[static_cast<std::size_t>(i)], task.components.units[static_cast<std::size_t>(i)], {}});
  report::Facts facts{.heading = "Family", .rows = {}};
  for (const OrbitOfFamily& each : family.orbits) {
    const Orbit& orbit = each.orbit;
    const Multiplier* most = largest(orbit);
    std::vector<double> row = {static_cast<double>(std::find(kinds_in_file.begin(), kinds_in_file.end(),
                                                             each.kind) - kinds_in_file.begin()), each.value, orbit.period, orbit.energy,
                               static_cast<double>(orbit.stability), most ? most->value.real() : 1.0, most ? most->value.imag() : 0.0};
    for (const double x : orbit.x) row.push_back(x);
    for (std::size_t i = 0; i < row.size(); ++i) table.columns[i].values.push_back(row[i]);
    if (each.kind != "regular")
      facts.rows.push_back({words(each.kind), task.followed() + " = " + number_text(each.value),
                            "T = " + number_text(orbit.period) + ", " + std::string(description(orbit.stability))});
  }
  report::Page page{.title = task.scene->title(), .lead = task.scene->summary()};
  page.tables.push_back(std::move(facts));
  const std::string period_label = time.empty() ? "T" : "T [" + time + "]", energy_label = report::with_unit_symbol("h", task.scene->energy_unit());
  std::vector<report::Series> curves;
  std::vector<double> extents;
  const int samples = points_for(motion_of(task, family.orbits.front().orbit).turns);
  for (const OrbitOfFamily& each : family.orbits) {
    curves.push_back(curve(task, points_of(task, each.orbit, samples), task.followed() + " = " + rounded_text(each.value, 4)));
    const auto [least, most] = std::minmax_element(curves.back().x.begin(), curves.back().x.end());
    extents.push_back(*most - *least);
  }
  const auto orbit_of = [&](std::size_t k) -> const Orbit& { return family.orbits[k].orbit; };
  if (task.in == In::period) page.plots.push_back(along_family(task, family, energy_label, [&](std::size_t k) { return orbit_of(k).energy; }));
  else if (task.held != HeldWhat::drive) page.plots.push_back(along_family(task, family, period_label, [&](std::size_t k) { return orbit_of(k).period; }));
  page.plots.push_back(along_family(task, family, "extent of " + task.components.label(task.x), [&](std::size_t k) { return extents[k]; }));
  page.plots.push_back(along_family(task, family, "largest |μ|",
                                    [&](std::size_t k) { return largest(orbit_of(k)) ? std::abs(largest(orbit_of(k))->value) : 1.0; }));
  page.plots.back().y.scale = report::Scale::logarithmic;
  report::Plot orbits = plane(task, "Orbits of the family");
  constexpr std::size_t shown = 8;
  const std::size_t count = std::min(shown, family.orbits.size());
  for (std::size_t i = 0; i < count; ++i) {
    orbits.series.push_back(curves[count > 1 ? i * (curves.size() - 1) / (count - 1) : 0]);
  }
  page.plots.push_back(std::move(orbits));
  page.footer =
      family.message +
      ". In the table: kinds 0 start, 1 regular, 2 fold, 3 period doubling, 4 branch point, 5 torus, 6 end; stability 0 asymptotic, 1 to first order, 2 not decided, 3 unstable.";
  page = report::in_symbols(std::move(page));
  const std::string picture = report::svg(page.plots.front());
  report::write_files({{task.paths[0], report::csv(table)}, {task.paths[1], report::html(page)}, {task.paths[2], picture}});
}

void print_orbit(const OrbitTask& task, const Orbit& orbit, const OrbitMotion& motion) {
  std::printf("%s: %s%s\n", task.scene->name().c_str(), orbit.found() ? "periodic orbit, " : "no periodic orbit, ",
              orbit.found() ? std::string(description(orbit.stability)).c_str() : std::string(name(orbit.outcome)).c_str());
  for (const report::Fact& fact : facts_of(task, orbit, motion).rows)
    std::printf("  %-14s %-*s%s\n", fact.name.c_str(), fact.remark.empty() ? 0 : 26, fact.value.c_str(),
                fact.remark.empty() ? "" : (" " + fact.remark).c_str());
  if (const std::string far = far_text(task, motion); !far.empty()) std::printf("  %s\n", far.c_str());
  std::printf("  %s\n", orbit.message.c_str());
}

void print_family(const OrbitTask& task, const FamilyFound& family) {
  std::printf("%s: %s\n", task.scene->name().c_str(), family.message.c_str());
  const std::string time = task.scene->time_unit();
  std::printf("  %-16s %-18s %-16s %-16s %-12s %s\n", "", task.followed_label().c_str(), time.empty() ? "T" : ("T [" + time + "]").c_str(),
              "h", "largest |mu|", "stability");
  for (std::size_t k = 0; k < family.orbits.size(); ++k) {
    const OrbitOfFamily& each = family.orbits[k];
    if (each.kind == "regular" && k + 1 < family.orbits.size()) continue;
    const Multiplier* most = largest(each.orbit);
    std::printf("  %-16s %-18s %-16s %-16s %-12s %s\n", words(each.kind).c_str(), number_text(each.value).c_str(),
                number_text(each.orbit.period).c_str(), number_text(each.orbit.energy).c_str(),
                most ? rounded_text(std::abs(most->value), 6).c_str() : "1", std::string(description(each.orbit.stability)).c_str());
  }
}

}  // namespace

int orbit(const OrbitCommandOptions& options) {
  OrbitTask task = task_of(options);
  const Orbit first = orbit_near(task, task.returns);
  if (!task.range || !first.found()) {
    const OrbitMotion motion = motion_of(task, first);
    write_orbit(task, first, motion);
    if (options.json) std::printf("%s\n", orbit_json(*task.scene, task.components.names, first, motion.turns, motion.moved).c_str());
    else print_orbit(task, first, motion);
    return first.found() ? 0 : 1;
  }
  const FamilyFound family = family_from(task, first);
  write_family(task, family);
  if (options.json) std::printf("%s\n", family_json(*task.scene, task.components.names, task.followed(), family).c_str());
  else print_family(task, family);
  return family.reached ? 0 : 1;
}

}  // namespace qdot::program
