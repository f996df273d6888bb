// SPDX-License-Identifier: MIT
//
// qdot equilibria SCENE --along NAME=FROM:TO: the equilibrium near the start as a curve, where it changes its stability or meets others, and those.
#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <iterator>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "program/along.hpp"
#include "program/arguments.hpp"
#include "program/commands.hpp"
#include "program/components.hpp"
#include "program/json.hpp"
#include "program/steady_points.hpp"
#include "qdot/report/csv.hpp"
#include "qdot/report/file.hpp"
#include "qdot/report/html.hpp"
#include "qdot/report/number.hpp"
#include "qdot/report/svg.hpp"
#include "qdot/report/table.hpp"

namespace qdot::program {

namespace {

using report::rounded_text;

// In the order of the numbers that the table has for them.
constexpr const char* kinds[] = {"start", "regular", "fold", "branch", "hopf", "end"};
constexpr const char* words_of_kinds[] = {"start", "regular", "fold", "branch point", "Hopf point", "end"};

// What holds between two neighbours; at a special point itself rounding decides.
Stability between(const PointOfBranch& a, const PointOfBranch& b) {
  if (!b.is_special()) return b.stability;
  if (!a.is_special()) return a.stability;
  return a.growing + b.growing > 0 ? Stability::unstable : b.stability;
}

// "unstable", or at a special point "asymptotically stable, then unstable".
std::string stability_text(const PointsOfBranch& branch, std::size_t i) {
  const auto& points = branch.points;
  const std::string before = i > 0 ? description(between(points[i - 1], points[i])) : "";
  const std::string after = i + 1 < points.size() ? description(between(points[i], points[i + 1])) : "";
  if (!points[i].is_special()) return description(points[i].stability);
  if (before.empty() || after.empty() || before == after) return before.empty() ? after : before;
  return before + ", then " + after;
}


std::size_t special_count(const std::vector<PointsOfBranch>& branches) {
  std::size_t count = 0;
  for (const PointsOfBranch& branch : branches)
    for (std::size_t i = 0; i < branch.points.size(); ++i) count += branch.points[i].is_special() && (i > 0 || !branch.from) ? 1 : 0;
  return count;
}

std::string summary(const ModelsAlong& models, double from, double to, const std::vector<PointsOfBranch>& branches) {
  const std::size_t count = special_count(branches);
  return "equilibria along " + models.name() + " from " + rounded_text(from, 6) + " to " + rounded_text(to, 6) +
         (models.unit().empty() ? "" : " " + models.unit()) + ": " + std::to_string(branches.size()) +
         (branches.size() == 1 ? " branch, " : " branches, ") + std::to_string(count) + (count == 1 ? " special point" : " special points");
}

std::string beginning(const std::vector<PointsOfBranch>& branches, std::size_t i, const std::string& name) {
  const auto& from = branches[i].from;
  if (!from) return "from the start";
  return "from branch " + std::to_string(from->first + 1) + " at " + name + " = " + number_text(branches[from->first].points[from->second].p);
}

void print(const ModelsAlong& models, const Components& components, const std::vector<PointsOfBranch>& branches) {
  constexpr Eigen::Index most = 6;
  for (std::size_t b = 0; b < branches.size(); ++b) {
    const PointsOfBranch& branch = branches[b];
    std::printf("\n%zu: %s; %s\n", b + 1, beginning(branches, b, models.name()).c_str(), branch.message.c_str());
    if (branch.points.empty()) continue;
    const Eigen::Index shown = std::min(components.dof, most);
    std::printf("  %-8s %-16s", "", models.label().c_str());
    for (Eigen::Index i = 0; i < shown; ++i) std::printf(" %-16s", components.label(i).c_str());
    std::printf(" %sstability\n", shown < components.dof ? "…  " : "");
    for (std::size_t k = 0; k < branch.points.size(); ++k) {
      const PointOfBranch& point = branch.points[k];
      if (point.kind == "regular" && k + 1 < branch.points.size()) continue;  // the last one, where it was lost
      std::printf("  %-8s %-16s", point.kind.c_str(), number_text(point.p).c_str());
      for (Eigen::Index i = 0; i < shown; ++i) std::printf(" %-16s", number_text(point.q[i]).c_str());
      std::printf(" %s%s\n", shown < components.dof ? "…  " : "", stability_text(branch, k).c_str());
    }
  }
}

// Coordinate i over the parameter: a line for each kind of stability, dots at special points.
report::Plot diagram(const ModelsAlong& models, const Components& components, const std::vector<PointsOfBranch>& branches, Eigen::Index i) {
  report::Plot plot{.title = "Equilibria along " + models.name(), .x = {.label = models.label()}, .y = {.label = components.label(i)}, .height = 420};
  constexpr double gap = std::numeric_limits<double>::quiet_NaN();
  for (const Stability stability : {Stability::asymptotically_stable, Stability::stable_in_linear_approximation, Stability::drifting, Stability::unstable}) {
    report::Series series{.label = description(stability), .x = {}, .y = {}};
    series.dashed = stability == Stability::unstable || stability == Stability::drifting;
    for (const PointsOfBranch& branch : branches)
      for (std::size_t k = 0; k + 1 < branch.points.size(); ++k) {
        const PointOfBranch &a = branch.points[k], &b = branch.points[k + 1];
        if (between(a, b) != stability) continue;
        if (series.x.empty() || series.x.back() != a.p || series.y.back() != a.q[i]) {
          series.x.insert(series.x.end(), {gap, a.p});
          series.y.insert(series.y.end(), {gap, a.q[i]});
        }
        series.x.push_back(b.p);
        series.y.push_back(b.q[i]);
      }
    if (!series.x.empty()) plot.series.push_back(std::move(series));
  }
  for (const std::size_t kind : {2U, 3U, 4U}) {
    report::Series series{.label = words_of_kinds[kind], .x = {}, .y = {}, .markers = true, .dots = true};
    for (const PointsOfBranch& branch : branches)
      for (const PointOfBranch& point : branch.points) {
        if (point.kind != kinds[kind]) continue;
        series.x.push_back(point.p);
        series.y.push_back(point.q[i]);
      }
    if (!series.x.empty()) plot.series.push_back(std::move(series));
  }
  return plot;
}

// The coordinate that goes farthest; the first of those that go equally far.
Eigen::Index liveliest(const Components& components, const std::vector<PointsOfBranch>& branches) {
  Eigen::Index best = 0;
  double farthest = 0.0;
  for (Eigen::Index i = 0; i < components.dof; ++i) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const PointsOfBranch& branch : branches)
      for (const PointOfBranch& point : branch.points) {
        low = std::min(low, point.q[i]);
        high = std::max(high, point.q[i]);
      }
    if (high - low > farthest * (1.0 + 1e-6)) {
      farthest = high - low;
      best = i;
    }
  }
  return best;
}

void write(const std::vector<std::string>& paths, const SteadyRequest& request, const ModelsAlong& models, const Components& components,
           const std::vector<PointsOfBranch>& branches, const std::vector<Eigen::Index>& shown, const std::string& summary) {
  if (paths.empty()) return;
  const std::string rate = request.scene->time_unit().empty() ? "" : "1/" + request.scene->time_unit();
  report::Table table;
  table.columns = {{"branch", "", {}}, {"kind", "", {}}, {models.name(), models.unit(), {}}};
  for (Eigen::Index i = 0; i < components.dof; ++i)
    table.columns.push_back({components.names[static_cast<std::size_t>(i)], components.units[static_cast<std::size_t>(i)], {}});
  table.columns.push_back({"growing", "", {}});
  table.columns.push_back({"largest_re", rate, {}});
  report::Page page{.title = request.scene->title(), .lead = request.scene->summary()};
  for (std::size_t b = 0; b < branches.size(); ++b) {
    report::Facts facts{.heading = "Branch " + std::to_string(b + 1) + ", " + beginning(branches, b, models.name()), .rows = {}};
    for (std::size_t k = 0; k < branches[b].points.size(); ++k) {
      const PointOfBranch& point = branches[b].points[k];
      std::vector<double> row = {static_cast<double>(b + 1),
                                 static_cast<double>(std::find(std::begin(kinds), std::end(kinds), point.kind) - std::begin(kinds)),
                                 point.p};
      for (const double q : point.q) row.push_back(q);
      row.push_back(point.growing);
      row.push_back(point.exponents.size() > 0 ? point.exponents.real().maxCoeff() : 0.0);
      for (std::size_t i = 0; i < row.size(); ++i) table.columns[i].values.push_back(row[i]);
      if (point.kind != "regular")
        facts.rows.push_back({point.kind, models.name() + " = " + number_text(point.p), stability_text(branches[b], k)});
    }
    facts.rows.push_back({"", branches[b].message});
    page.tables.push_back(std::move(facts));
  }
  for (const Eigen::Index i : shown) page.plots.push_back(diagram(models, components, branches, i));
  page.footer = summary + ". Kinds in the table: 0 start, 1 regular, 2 fold, 3 branch point, 4 Hopf point, 5 end.";
  report::write_files({{paths[0], report::csv(table)},
                       {paths[1], report::html(report::in_symbols(std::move(page)))},
                       {paths[2], report::svg(report::in_symbols(diagram(models, components, branches, shown.front())))}});
}

}  // namespace

int equilibria_along(const EquilibriaOptions& options) {
  const SteadyRequest request = steady_request(options);
  const Along range = along("--along", *options.along);
  const ModelsAlong models("--along", range.name, request);
  const Components components(request);
  const double from = range.from.value_or(models.value());
  if (from == range.to) throw UsageError("--along " + range.name + ": must go to another value than it begins with, " + rounded_text(from));
  std::vector<Eigen::Index> shown;
  if (options.show) shown = components.places("--show", *options.show, request.scene->name());
  for (const Eigen::Index i : shown)
    if (i >= components.dof) throw UsageError("--show: must name coordinates where things rest, given " + *options.show);
  const std::vector<std::string> paths = writable_files(options.out, {".csv", ".html", ".svg"});
  std::vector<PointsOfBranch> branches;
  try {
    branches = branches_along(request, models, from, range.to);
  } catch (const Error& error) {
    throw UsageError("--along " + range.name + ": there must be " + (request.steady ? "a steady motion" : "an equilibrium") +
                     " to begin with; " + error.what());
  }
  if (shown.empty()) {
    shown.push_back(liveliest(components, branches));
    constexpr std::size_t most = 6;
    for (Eigen::Index i = 0; i < components.dof && shown.size() < most; ++i)
      if (i != shown.front()) shown.push_back(i);
  }
  const std::string head = summary(models, from, range.to, branches);
  write(paths, request, models, components, branches, shown, head);
  if (options.json) {
    std::printf("%s\n", branches_json(*request.scene, models.name(), from, range.to, branches).c_str());
  } else {
    std::printf("%s: %s\n", request.scene->name().c_str(), head.c_str());
    print(models, components, branches);
  }
  const bool all = std::all_of(branches.begin(), branches.end(), [](const PointsOfBranch& branch) { return branch.message.starts_with("reached"); });
  return all ? 0 : 1;
}

}  // namespace qdot::program
