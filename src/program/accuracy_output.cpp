// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "program/accuracy.hpp"
#include "qdot/report/html.hpp"
#include "qdot/report/loglog.hpp"
#include "qdot/report/number.hpp"
#include "qdot/report/symbol.hpp"

namespace qdot::program {

namespace {

using Json = nlohmann::ordered_json;

using report::exact_text, report::rounded_text;
using report::LogLogPlot, report::MarkedCurve, report::Marker;

/// "1e-6" as people set it: 10⁻⁶, 2.5·10⁻⁷.
std::string power_text(double x, int digits) {
  if (!(x > 0) || !std::isfinite(x)) return rounded_text(x, digits);
  int exponent = static_cast<int>(std::floor(std::log10(x)));
  double mantissa = x / std::pow(10.0, exponent);
  if (mantissa + 0.5 * std::pow(10.0, 1 - digits) >= 10) {
    mantissa = 1;
    ++exponent;
  }
  const std::string front = rounded_text(mantissa, digits);
  return (front == "1" ? "" : front + "·") + "10" + report::superscript(exponent);
}

/// "3.1 ms"
std::string time_text(double seconds) {
  if (!std::isfinite(seconds)) return "";
  const auto [unit, factor] = seconds < 1e-3 ? std::pair("µs", 1e6) : seconds < 1 ? std::pair("ms", 1e3) : std::pair("s", 1.0);
  return rounded_text(seconds * factor, 3) + " " + unit;
}

/// Column of text, padded by what a terminal shows and not by bytes.
std::string padded(const std::string& text, std::size_t width) {
  std::size_t glyphs = 0;
  for (const char c : text) glyphs += (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;
  return glyphs < width ? std::string(width - glyphs, ' ') + text : text;
}

std::string setting_text(const Measurement& m) { return (m.fixed_step ? "h = " : "tol ") + rounded_text(m.setting, 3); }

/// An error as it may be claimed: not below what the reference can show.
std::string error_text(const WorkPrecision& study, double error) {
  if (!std::isfinite(error)) return "";
  if (error < study.visible_error()) return "<" + rounded_text(study.visible_error(), 2);
  return rounded_text(error, 2);
}

/// Methods in the order in which they were measured.
std::vector<std::string> methods_of(const WorkPrecision& study) {
  std::vector<std::string> names;
  for (const Measurement& m : study.measurements) {
    if (std::find(names.begin(), names.end(), m.method) == names.end()) names.push_back(m.method);
  }
  return names;
}

using Value = double Measurement::*;

double cost_of(const Measurement& m, bool in_time) { return in_time ? m.cpu_median : static_cast<double>(m.evaluations); }

/// One quantity over one cost, a curve for each method. Failed runs have no CPU time: that of as many evaluations is taken.
LogLogPlot panel(const SceneStudy& of, const std::string& label, Value value, bool in_time) {
  const WorkPrecision& study = of.study;
  LogLogPlot plot;
  plot.x_label = in_time ? "CPU time [s]" : "evaluations of the equations of motion";
  plot.y_label = label;
  plot.least_y = std::max(study.visible_error(), 1e-18);
  if (value == &Measurement::constraint_residual || value == &Measurement::energy_error) plot.least_y = 1e-17;
  const std::vector<std::string> methods = methods_of(study);
  for (std::size_t k = 0; k < methods.size(); ++k) {
    MarkedCurve curve{.name = methods[k], .style = k, .points = {}};
    double seconds_per_evaluation = std::numeric_limits<double>::quiet_NaN();
    long tolerances = 0;
    for (const Measurement& m : study.measurements) {
      if (m.method != methods[k]) continue;
      ++tolerances;
      if (m.completed() && m.evaluations > 0 && !std::isfinite(seconds_per_evaluation))
        seconds_per_evaluation = m.cpu_median / static_cast<double>(m.evaluations);
    }
    for (const Measurement& m : study.measurements) {
      if (m.method != methods[k]) continue;
      Marker marker{.x = cost_of(m, in_time), .y = m.*value};
      if (!m.completed()) {
        marker.failed = true;
        if (in_time) marker.x = seconds_per_evaluation * static_cast<double>(m.evaluations);
      } else if (!m.fixed_step && (tolerances <= 6 || std::lround(-std::log10(m.setting)) % 3 == 0)) {
        marker.label = "10" + report::superscript(static_cast<int>(std::lround(std::log10(m.setting))));
      } else if (m.fixed_step) {
        marker.label = "h " + rounded_text(m.setting, 2);
      }
      curve.points.push_back(std::move(marker));
    }
    // Of the many steps of a method with fixed steps the first and every fourth bear a label.
    for (std::size_t i = 0; i < curve.points.size(); ++i) {
      if (curve.points[i].label.starts_with("h ") && i % 4 != 0) curve.points[i].label.clear();
    }
    plot.curves.push_back(std::move(curve));
  }
  const bool is_error = value == &Measurement::end_error || value == &Measurement::largest_error;
  if (is_error && std::isfinite(study.reference.gain) && study.reference.rounding_floor() > study.visible_error()) {
    plot.levels.push_back({study.reference.rounding_floor(), "one rounding of the start, amplified"});
  }
  if (is_error) plot.levels.push_back({std::max(study.visible_error(), 1e-18), "ten times the uncertainty of the reference"});
  return plot;
}

std::string largest_label(const SceneStudy& of) { return "largest error at " + std::to_string(of.study.reference.t.size()) + " times"; }

/// Running maximum of |h − h(0)| against time for the most exact run of each method, at about twenty times a decade.
LogLogPlot drift_plot(const SceneStudy& of) {
  LogLogPlot plot;
  plot.x_label = "t" + (of.scene.time_unit().empty() ? std::string() : " [" + of.scene.time_unit() + "]");
  plot.y_label = "energy: largest |h − h₀| so far / largest T, most exact run of each method";
  double least_x = std::numeric_limits<double>::infinity();
  const std::vector<std::string> methods = methods_of(of.study);
  for (std::size_t k = 0; k < methods.size(); ++k) {
    const Measurement* best = nullptr;
    for (const Measurement& m : of.study.measurements) {
      if (m.method == methods[k] && m.completed() && (best == nullptr || m.largest_error < best->largest_error)) best = &m;
    }
    if (best == nullptr) continue;
    MarkedCurve curve{.name = methods[k], .style = k, .points = {}, .marked = false};
    double largest = 0, next = 0;
    for (std::size_t i = 0; i < best->energy_times.size(); ++i) {
      const double t = best->energy_times[i] - of.start.t;
      largest = std::max(largest, std::abs(best->energy_change[i]));
      if (!(t > 0) || t < next || t < 1e-3 * (of.t_end - of.start.t)) continue;
      next = t * 1.12;
      least_x = std::min(least_x, t);
      curve.points.push_back({t, std::max(largest, 1e-17)});
    }
    plot.curves.push_back(std::move(curve));
  }
  if (std::isfinite(least_x)) {
    plot.slopes = {{0.5, least_x, 2e-16, "√t"}, {1.0, least_x, 2e-16, "t"}};
  }
  return plot;
}

std::string cell(const std::string& text, bool number) {
  return std::string("<td") + (number ? " class=\"value\"" : "") + ">" + report::escaped(text) + "</td>";
}

std::string card(const std::string& kind, const std::string& inside) {
  return "<section class=\"card " + kind + "\">" + inside + "</section>\n";
}

std::string cheapest_html(const WorkPrecision& study) {
  std::string html = "<h2>The cheapest way to an accuracy</h2><table><tr><td>largest error below</td><td>method</td><td>set to</td>"
                     "<td class=\"value\">evaluations</td><td class=\"value\">CPU time</td></tr>\n";
  int k = 0;
  for (const Measurement* m : study.cheapest_by_decade()) {
    html += "<tr>" + cell(power_text(std::pow(10.0, -++k), 1), false) + cell(m->method, false) + cell(setting_text(*m), false) +
            cell(std::to_string(m->evaluations), true) + cell(time_text(m->cpu_median), true) + "</tr>\n";
  }
  return html + "</table>";
}

std::string facts_html(const SceneStudy& of) {
  const ReferenceMotion& reference = of.study.reference;
  report::Facts facts{"Measured against", {}};
  facts.rows.push_back({"reference", reference.made_by});
  facts.rows.push_back({"its uncertainty", rounded_text(reference.uncertainty, 2), "relative to the largest value of each component"});
  if (std::isfinite(reference.gain)) {
    facts.rows.push_back({"gain", rounded_text(reference.gain, 2), "by which the motion amplifies a relative error of its start"});
    facts.rows.push_back({"rounding floor", rounded_text(reference.rounding_floor(), 2), "gain × half a unit of double"});
  }
  facts.rows.push_back({"end", "t = " + rounded_text(of.t_end, 8) + " " + of.scene.time_unit()});
  facts.rows.push_back({"output times", std::to_string(reference.t.size())});
  for (const ParameterInfo& p : of.scene.parameters()) facts.rows.push_back({report::symbol(p.name), rounded_text(p.value, 8) + " " + p.unit, p.meaning});
  for (const EffectInfo& e : of.scene.effects())
    if (e.on) facts.rows.push_back({e.name, rounded_text(e.value, 8) + " " + e.unit, e.meaning});
  std::string html = report::detail::facts_table(facts);
  return html;
}

/// How the reference was made, how exact it is, and where it ends; n coordinates.
Json reference_json(const ReferenceMotion& reference, Eigen::Index n) {
  Json q = Json::array(), qdot = Json::array();
  const auto last = static_cast<Eigen::Index>(reference.t.size()) - 1;
  for (Eigen::Index i = 0; i < n; ++i) {
    q.push_back(static_cast<double>(reference.y(i, last)));
    qdot.push_back(static_cast<double>(reference.y(i + n, last)));
  }
  return {{"made_by", reference.made_by},
          {"uncertainty", reference.uncertainty},
          {"gain", reference.gain},
          {"rounding_floor", reference.rounding_floor()},
          {"evaluations", reference.evaluations},
          {"q", q},
          {"qdot", qdot}};
}

Json measurement_json(const Measurement& m) {
  return {{"method", m.method},
          {m.fixed_step ? "step" : "tolerance", m.setting},
          {"outcome", std::string(name(m.outcome))},
          {"t", m.t},
          {"end_error", m.end_error},
          {"largest_error", m.largest_error},
          {"energy_error", m.energy_error},
          {"constraint_residual", m.constraint_residual},
          {"steps", m.steps},
          {"rejected", m.rejected},
          {"evaluations", m.evaluations},
          {"jacobians", m.jacobians},
          {"cpu_median", m.cpu_median},
          {"cpu_minimum", m.cpu_minimum},
          {"runs", m.runs}};
}

/// The cheapest measurement below each power of ten.
Json cheapest_json(const WorkPrecision& study) {
  Json array = Json::array();
  int k = 0;
  for (const Measurement* m : study.cheapest_by_decade()) {
    array.push_back({{"error", std::pow(10.0, -++k)},
                     {"method", m->method},
                     {m->fixed_step ? "step" : "tolerance", m->setting},
                     {"largest_error", m->largest_error},
                     {"evaluations", m->evaluations},
                     {"cpu_median", m->cpu_median}});
  }
  return array;
}

/// What errors are measured against.
std::string reference_text(const SceneStudy& of) {
  const ReferenceMotion& reference = of.study.reference;
  std::string text = of.scene.name() + " to t = " + rounded_text(of.t_end, 8) + ": errors relative to each component's largest value\n";
  text += "  reference: " + reference.made_by + ", uncertain by " + rounded_text(reference.uncertainty, 2) + "\n";
  if (std::isfinite(reference.gain)) {
    text += "  the motion amplifies errors of its start by " + rounded_text(reference.gain, 2) + ": rounding floor about " +
            rounded_text(reference.rounding_floor(), 2) + "\n";
  }
  return text;
}

/// A table of runs, a row each.
std::string runs_text(const WorkPrecision& study, const std::vector<const Measurement*>& runs) {
  const bool constrained = std::any_of(study.measurements.begin(), study.measurements.end(),
                                       [](const Measurement& m) { return std::isfinite(m.constraint_residual); });
  std::string text = "  method          set to         largest error  end error  energy error" + std::string(constrained ? "  constraint" : "") +
                     "  evaluations    CPU median   (minimum)  runs\n";
  std::string before;
  for (const Measurement* run : runs) {
    const Measurement& m = *run;
    text += "  " + (m.method == before ? std::string(15, ' ') : m.method + std::string(m.method.size() < 15 ? 15 - m.method.size() : 1, ' '));
    before = m.method;
    const std::string setting = setting_text(m);
    text += " " + setting + std::string(setting.size() < 14 ? 14 - setting.size() : 0, ' ');
    if (!m.completed()) {
      text += "  " + std::string(name(m.outcome)) + " at t = " + rounded_text(m.t, 4) + " after " + std::to_string(m.evaluations) + " evaluations\n";
      continue;
    }
    text += padded(error_text(study, m.largest_error), 14) + padded(error_text(study, m.end_error), 11) +
            padded(rounded_text(m.energy_error, 2), 14) + (constrained ? padded(rounded_text(m.constraint_residual, 2), 12) : "") +
            padded(std::to_string(m.evaluations), 13) + padded(time_text(m.cpu_median), 14) + padded("(" + time_text(m.cpu_minimum) + ")", 12) +
            padded(std::to_string(m.runs), 6) + "\n";
  }
  return text;
}

/// The cheapest way to each accuracy, a table.
std::string cheapest_text(const WorkPrecision& study) {
  std::string text = "  largest error   cheapest method   set to         evaluations      CPU time\n";
  int k = 0;
  for (const Measurement* m : study.cheapest_by_decade()) {
    const std::string setting = setting_text(*m);
    ++k;
    text += "  below 1e-" + std::to_string(k) + std::string(k < 10 ? 7 : 6, ' ') + m->method +
            std::string(m->method.size() < 17 ? 17 - m->method.size() : 1, ' ') + " " + setting +
            std::string(setting.size() < 14 ? 14 - setting.size() : 0, ' ') + padded(std::to_string(m->evaluations), 12) +
            padded(time_text(m->cpu_median), 14) + "\n";
  }
  return text + "  further than that no method came, or the reference cannot tell; an evaluation of taylor is a whole power series\n";
}

}  // namespace

std::vector<std::string> accuracy_paths(const std::string& path) { return {path + ".csv", path + ".html", path + ".svg"}; }

std::string accuracy_text(const SceneStudy& of) {
  const WorkPrecision& study = of.study;
  std::vector<const Measurement*> all;
  for (const Measurement& m : study.measurements) all.push_back(&m);
  const std::string machine = "  measured on " + of.machine + "\n";
  if (!of.brief) return reference_text(of) + "\n" + runs_text(study, all) + "\n" + cheapest_text(study) + machine;
  const std::vector<const Measurement*> needed = study.cheapest_by_decade();
  const auto is_needed = [&](const Measurement* m) { return std::find(needed.begin(), needed.end(), m) != needed.end(); };
  std::vector<const Measurement*> shown;
  std::copy_if(all.begin(), all.end(), std::back_inserter(shown), is_needed);
  return reference_text(of) + "\n" + cheapest_text(study) + machine + "\n" + runs_text(study, shown) + "  these are " + std::to_string(shown.size()) + " of " +
         std::to_string(all.size()) + " runs; --out and --json have all of them, and without --quick they are printed\n";
}

std::string accuracy_json(const SceneStudy& of, const std::vector<std::string>& files) {
  const WorkPrecision& study = of.study;
  Json json;
  json["scene"] = of.scene.name();
  json["parameters"] = Json::object();
  for (const ParameterInfo& p : of.scene.parameters()) json["parameters"][p.name] = p.value;
  json["effects"] = Json::array();
  for (const EffectInfo& e : of.scene.effects())
    if (e.on) json["effects"].push_back({{"name", e.name}, {"value", e.value}});
  json["t_start"] = of.start.t;
  json["t_end"] = of.t_end;
  json["outputs"] = study.reference.t.size();
  json["reference"] = reference_json(study.reference, of.start.q.size());
  json["visible_error"] = study.visible_error();
  json["energy_scale"] = study.energy_scale;
  json["energy_conserved"] = study.energy_conserved;
  json["measurements"] = Json::array();
  for (const Measurement& m : study.measurements) json["measurements"].push_back(measurement_json(m));
  json["cheapest"] = cheapest_json(study);
  json["machine"] = of.machine;
  json["files"] = files;
  return json.dump(2);
}

std::string accuracy_csv(const SceneStudy& of) {
  std::string csv =
      "method,setting,setting_kind,outcome,t,end_error,largest_error,energy_error,constraint_residual,steps,rejected,evaluations,"
      "jacobians,cpu_median,cpu_minimum,runs,reference_uncertainty\n";
  for (const Measurement& m : of.study.measurements) {
    csv += m.method + "," + exact_text(m.setting) + (m.fixed_step ? ",step," : ",tolerance,") + std::string(name(m.outcome));
    for (const double x : {m.t, m.end_error, m.largest_error, m.energy_error, m.constraint_residual}) csv += "," + exact_text(x);
    for (const long x : {m.steps, m.rejected, m.evaluations, m.jacobians}) csv += "," + std::to_string(x);
    csv += "," + exact_text(m.cpu_median) + "," + exact_text(m.cpu_minimum) + "," + std::to_string(m.runs) + "," +
           exact_text(of.study.reference.uncertainty) + "\n";
  }
  return csv;
}

std::string accuracy_html(const SceneStudy& of) {
  const WorkPrecision& study = of.study;
  const std::string title = of.scene.title() + ": what accuracy costs";
  std::string body;
  const LogLogPlot first = panel(of, largest_label(of), &Measurement::largest_error, true);
  const auto [legend, height] = report::marker_legend(first.curves, 4, 1130, 0);
  body += card("wide", "<svg class=\"plot\" viewBox=\"0 0 1140 " + rounded_text(height, 6) + "\">" + legend + "</svg>");
  const auto add = [&](LogLogPlot plot) {
    plot.width = 580;
    plot.height = 420;
    plot.with_legend = false;
    body += card("half", svg_element(plot));
  };
  add(first);
  add(panel(of, largest_label(of), &Measurement::largest_error, false));
  add(panel(of, "error at the end", &Measurement::end_error, true));
  add(panel(of, study.energy_conserved ? "energy drift / largest T" : "error of the energy / largest T", &Measurement::energy_error, true));
  const bool constrained = std::any_of(study.measurements.begin(), study.measurements.end(),
                                       [](const Measurement& m) { return m.constraint_residual > 0; });
  if (constrained) add(panel(of, "constraint residual", &Measurement::constraint_residual, true));
  if (study.energy_conserved) add(drift_plot(of));
  body += "<div class=\"half\">" + card("", cheapest_html(study)) + "</div><div class=\"half\">" + facts_html(of) + "</div>\n";
  return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n<title>" +
         report::escaped(title) + "</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>" + report::theme_css(":root") + report::plot_css() +
         report::loglog_css() + report::detail::page_css + "</style></head>\n<body><main>\n<h1>" + report::escaped(title) +
         "</h1>\n<p class=\"lead\">Every mark is one run: a method at one tolerance, written beside it, or at one step h. Lower is more exact, "
         "further left is cheaper. A cross on the upper edge is a run that failed. "
         "An evaluation of taylor is a whole power series, one a step.</p>\n<div class=\"grid\">\n" +
         body + "</div>\n<footer>Made by qdot " QDOT_VERSION ". Errors are relative to the largest value of each component on the motion; CPU time is the "
         "median of repeated runs without output. " + report::escaped(of.machine) + ".</footer>\n</main></body></html>\n";
}

std::string accuracy_svg(const SceneStudy& of) {
  LogLogPlot plot = panel(of, largest_label(of), &Measurement::largest_error, true);
  plot.title = of.scene.title() + ": what accuracy costs";
  plot.width = 720;
  plot.height = 480;
  return svg(plot);
}

}  // namespace qdot::program
