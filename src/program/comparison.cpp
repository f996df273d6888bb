// SPDX-License-Identifier: MIT
#include "program/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "program/arguments.hpp"
#include "program/output.hpp"
#include "qdot/report/number.hpp"

namespace qdot::program {

namespace {

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(' '), last = text.find_last_not_of(' ');
  return first == std::string::npos ? std::string() : text.substr(first, last - first + 1);
}

// Lays the curves of another page over those of the same quantity, each with its run's name.
void lay_over(report::Page& page, const report::Page& other, const std::string& label) {
  for (const report::Plot& plot : other.plots) {
    const auto same = std::find_if(page.plots.begin(), page.plots.end(),
                                   [&](const report::Plot& p) { return p.y.label == plot.y.label && p.x.label == plot.x.label; });
    if (same == page.plots.end()) continue;
    for (const report::Series& series : plot.series) {
      same->series.push_back(series);
      same->series.back().label = series.label.empty() ? label : series.label + ", " + label;
    }
    for (const report::Mark& mark : plot.marks) same->marks.push_back({mark.x, mark.name + ", " + label});
    std::stable_sort(same->marks.begin(), same->marks.end(), [](const report::Mark& a, const report::Mark& b) { return a.x < b.x; });
  }
}

// A line for each run beside the first.
report::Facts beside(const std::vector<ComparedRun>& runs) {
  report::Facts facts{"Beside it", {}};
  for (std::size_t k = 1; k < runs.size(); ++k) {
    const Result& result = runs[k].result;
    const std::string unit = runs[k].scene->energy_unit();
    facts.rows.push_back({runs[k].label, std::string(name(result.outcome)) + ", t = " + report::rounded_text(result.end.t, 6)});
    facts.rows.push_back({"", std::to_string(result.statistics.steps) + " steps by " + result.statistics.method});
    facts.rows.push_back({"", "|E − E(0)| up to " + report::readable_text(result.energy.largest, 3) + (unit.empty() ? "" : " " + unit)});
  }
  return facts;
}

// Adds the points and shapes of another animation, in a colour of its own. One that ends earlier stays where it ended.
void lay_over(report::Animation& animation, const report::Animation& other, int colour) {
  if (animation.frames.empty() || other.frames.empty()) return;
  const int before = static_cast<int>(animation.frames.front().size());
  const bool longer = other.frames.size() > animation.frames.size();
  if (longer) {
    animation.times = other.times;
    animation.frames.resize(other.frames.size(), animation.frames.back());
  }
  for (std::size_t i = 0; i < animation.frames.size(); ++i) {
    const auto& points = other.frames[std::min(i, other.frames.size() - 1)];
    animation.frames[i].insert(animation.frames[i].end(), points.begin(), points.end());
  }
  for (report::Shape shape : other.drawing.shapes) {
    for (int& point : shape.points) point += before;
    shape.colour = colour;
    animation.drawing.shapes.push_back(std::move(shape));
  }
}

// How far the coordinates of the others are from those of the first, largest of all coordinates.
report::Plot apart(const std::vector<ComparedRun>& runs) {
  const ComparedRun& first = runs.front();
  const std::string unit = first.scene->time_unit();
  report::Plot plot{.x = {"t" + (unit.empty() ? "" : " [" + unit + "]")},
                    .y = {"largest |Δq|, each in its unit", report::Scale::logarithmic},
                    .time_axis = true};
  for (std::size_t k = 1; k < runs.size(); ++k) {
    report::Series series;
    series.label = runs[k].label;
    const auto& a = first.result.samples;
    const auto& b = runs[k].result.samples;
    const auto n = static_cast<Eigen::Index>(first.scene->coordinates().size());
    for (std::size_t i = 0; i < std::min(a.size(), b.size()) && a[i].t == b[i].t; ++i) {
      series.x.push_back(a[i].t);
      series.y.push_back((a[i].y.head(n) - b[i].y.head(n)).cwiseAbs().maxCoeff());
    }
    plot.series.push_back(std::move(series));
  }
  return plot;
}

}  // namespace

RunOptions with_settings(RunOptions options, const std::string& settings) {
  const auto given = [&](const std::string& text) { return "must have the form NAME=VALUE,… (parameters, initial values, method, step, rtol, atol, accuracy), "
                                                           "with EFFECT[=VALUE] or without EFFECT, given \"" + text + "\""; };
  for (std::size_t from = 0; from <= settings.size();) {
    const std::size_t comma = std::min(settings.find(',', from), settings.size());
    const std::string setting = trimmed(settings.substr(from, comma - from));
    from = comma + 1;
    if (setting.starts_with("with ")) {
      options.with.push_back(trimmed(setting.substr(5)));
      continue;
    }
    if (setting.starts_with("without ")) {
      options.without.push_back(trimmed(setting.substr(8)));
      continue;
    }
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0) throw UsageError("--compare: " + given(setting));
    const std::string name = setting.substr(0, equals), value = setting.substr(equals + 1);
    if (name == "method") {
      options.method = value;
    } else if (name == "step") {
      options.step = value;
    } else if (name == "rtol") {
      options.rtol = value;
    } else if (name == "atol") {
      options.atol = value;
    } else if (name == "accuracy") {
      options.accuracy = value;
      options.rtol.reset();
      options.atol.reset();
    } else {
      options.set.push_back(setting);
    }
  }
  return options;
}

std::vector<Difference> largest_differences(const ComparedRun& first, const ComparedRun& other) {
  std::vector<Difference> differences;
  const auto& a = first.result.samples;
  const auto& b = other.result.samples;
  const auto coordinates = first.scene->coordinates();
  for (std::size_t k = 0; k < coordinates.size(); ++k) {
    Difference largest{coordinates[k].name};
    for (std::size_t i = 0; i < std::min(a.size(), b.size()) && a[i].t == b[i].t; ++i) {
      const auto j = static_cast<Eigen::Index>(k);
      const double size = std::abs(a[i].y[j] - b[i].y[j]);
      if (size > largest.size) largest = {coordinates[k].name, size, a[i].t};
    }
    differences.push_back(largest);
  }
  return differences;
}

report::Page comparison_page(const std::vector<ComparedRun>& runs) {
  const ComparedRun& first = runs.front();
  report::Page shown = page(*first.scene, first.request, first.result, false);
  for (report::Plot& plot : shown.plots) {
    for (report::Series& series : plot.series) series.label = series.label.empty() ? first.label : series.label + ", " + first.label;
    for (report::Mark& mark : plot.marks) mark.name += ", " + first.label;
  }
  for (std::size_t k = 1; k < runs.size(); ++k) {
    const report::Page other = page(*runs[k].scene, runs[k].request, runs[k].result, false);
    lay_over(shown, other, runs[k].label);
    if (shown.animation && other.animation) lay_over(*shown.animation, *other.animation, static_cast<int>(k));
  }
  shown.tables.push_back(beside(runs));
  shown.plots.insert(shown.plots.begin() + 1, apart(runs));
  return shown;
}

}  // namespace qdot::program
