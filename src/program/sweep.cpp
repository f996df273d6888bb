// SPDX-License-Identifier: MIT
//
// qdot sweep SCENE: many motions of one scene, over a grid or a random sample, and what was asked of each.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "program/arguments.hpp"
#include "program/catalogue.hpp"
#include "program/commands.hpp"
#include "program/methods.hpp"
#include "program/progress.hpp"
#include "program/simulation.hpp"
#include "program/swept_quantities.hpp"
#include "program/swept_values.hpp"
#include "qdot/integrate/simulate_many.hpp"
#include "qdot/report/csv.hpp"
#include "qdot/report/file.hpp"
#include "qdot/report/heat_map.hpp"
#include "qdot/report/html.hpp"
#include "qdot/report/npy.hpp"
#include "qdot/report/number.hpp"

namespace qdot::program {

namespace {

struct Sweep {
  ChosenScene nominal;
  std::function<std::unique_ptr<RunnableScene>()> make;
  SceneOptions base = {};
  SweptValues values;
  std::vector<Quantity> quantities = {};
  Request request = {};
  ManyOptions many = {};
  std::vector<std::string> paths = {};
};

/// What came of one motion.
struct Row {
  std::vector<double> values;
  Outcome outcome = Outcome::completed;
  std::string message = {};
};

double positive(const char* argument, const std::string& text) {
  const double x = finite_number(argument, text);
  if (!(x > 0.0)) throw UsageError(std::string(argument) + ": must be positive, given " + text);
  return x;
}

/// The scene's options with the values of motion i put in.
SceneOptions options_of(const Sweep& sweep, std::size_t i) {
  SceneOptions options = sweep.base;
  const std::vector<double> values = sweep.values.of(i);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const SweptAxis& axis = sweep.values.axes()[k];
    (axis.is_effect ? options.with : options.set).push_back(axis.name + "=" + report::exact_text(values[k]));
  }
  return options;
}

/// @throws UsageError  a value that the scene does not take
ChosenScene chosen_for(const Sweep& sweep, std::size_t i) {
  try {
    return chosen_scene(options_of(sweep, i), sweep.make());
  } catch (const UsageError& error) {  // of --set or --with, as which values are handed on
    const std::string message = error.what();
    throw UsageError("--over" + message.substr(std::min(message.find(':'), message.size())));
  }
}

Row motion(const Sweep& sweep, std::size_t i) {
  const ChosenScene chosen = chosen_for(sweep, i);
  Request request = sweep.request;
  request.start = chosen.start;
  QuantityWatch watch(sweep.quantities, *chosen.model);
  const BareResult run = watch.wants_steps() ? followed_run(chosen.model, request, [&](const StepView& step) { return watch.see(step); })
                                             : bare_run(chosen.model, request);
  const bool complete = run.outcome == Outcome::completed || run.outcome == Outcome::stopped_by_observer;
  return {watch.values(run), complete ? Outcome::completed : run.outcome, complete ? "" : run.message};
}

Sweep sweep_of(const SweepOptions& options) {
  const auto make = scene_maker(options.scene);
  Sweep sweep{.nominal = chosen_scene(options, make()), .make = make, .base = options, .values = swept_values(options.over, options.random, options.seed)};
  if (sweep.values.count() > 100'000'000) throw UsageError("--over: must not ask for more than 100000000 motions, given " + std::to_string(sweep.values.count()));
  const auto effects = sweep.nominal.scene->effects();
  for (SweptAxis& axis : sweep.values.axes())
    axis.is_effect = std::any_of(effects.begin(), effects.end(), [&](const EffectInfo& effect) { return effect.name == axis.name; });
  sweep.quantities = quantities_of(options.record, *sweep.nominal.scene);
  sweep.request.t_end = options.t_end ? finite_number("--t-end", *options.t_end) : sweep.nominal.scene->t_end();
  if (!(sweep.request.t_end > sweep.nominal.start.t))
    throw UsageError("--t-end: must be after the start, t = " + report::exact_text(sweep.nominal.start.t) + ", given " + report::exact_text(sweep.request.t_end));
  if (options.method) sweep.request.method = method_named(*options.method).name;
  if (const std::string why = misfit(*sweep.nominal.model, sweep.request.method); !why.empty())
    throw UsageError("--method: must fit " + options.scene + ", but " + sweep.request.method + " " + why);
  sweep.request.rtol = options.rtol ? positive("--rtol", *options.rtol) : 1e-8;
  sweep.request.atol = options.atol ? positive("--atol", *options.atol) : sweep.request.rtol;
  sweep.request.samples = 0;
  if (options.threads) sweep.many.threads = static_cast<int>(whole_number("--threads", *options.threads, 1, 1024));
  if (options.out) {
    sweep.paths = {*options.out + ".csv", *options.out + ".npz", *options.out + ".html"};
    require_files(*options.out, sweep.paths);
  }
  (void)chosen_for(sweep, 0);  // what is wrong with a name or the first value is said before anything is simulated; with a later one, in its cell
  return sweep;
}

std::string csv_of(const Sweep& sweep, const std::vector<Row>& rows) {
  std::string text;
  for (const SweptAxis& axis : sweep.values.axes()) text += axis.name + ",";
  for (const Quantity& quantity : sweep.quantities) text += quantity.text + ",";
  text += "outcome\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (const double x : sweep.values.of(i)) text += report::exact_text(x) + ",";
    for (const double x : rows[i].values) text += (std::isfinite(x) ? report::exact_text(x) : "") + ",";
    text += std::string(name(rows[i].outcome)) + "\n";
  }
  return text;
}

std::vector<double> column(const std::vector<Row>& rows, std::size_t k) {
  std::vector<double> values;
  for (const Row& row : rows) values.push_back(row.values[k]);
  return values;
}

std::string npz_of(const Sweep& sweep, const std::vector<Row>& rows) {
  std::vector<report::Array> arrays;
  std::vector<std::size_t> shape;
  for (std::size_t k = 0; k < sweep.values.axes().size(); ++k) {
    const SweptAxis& axis = sweep.values.axes()[k];
    std::vector<double> values = axis.values;
    if (sweep.values.is_random())
      for (std::size_t i = 0; i < rows.size(); ++i) values.push_back(sweep.values.of(i)[k]);
    arrays.push_back({axis.name, {values.size()}, values});
    shape.insert(shape.begin(), axis.values.size());  // the first axis runs fastest
  }
  if (sweep.values.is_random()) shape = {rows.size()};
  for (std::size_t k = 0; k < sweep.quantities.size(); ++k) arrays.push_back({sweep.quantities[k].text, shape, column(rows, k)});
  std::vector<double> outcomes;
  for (const Row& row : rows) outcomes.push_back(static_cast<double>(row.outcome));
  arrays.push_back({"outcome", shape, outcomes});
  return report::npz(arrays);
}

std::string labelled(const std::string& name, const std::string& unit) { return unit.empty() ? name : name + " [" + unit + "]"; }

std::string unit_of(const Sweep& sweep, const std::string& name) {
  for (const ParameterInfo& parameter : sweep.nominal.scene->parameters())
    if (parameter.name == name) return parameter.unit;
  for (const EffectInfo& effect : sweep.nominal.scene->effects())
    if (effect.name == name) return effect.unit;
  const auto coordinates = sweep.nominal.scene->coordinates();
  const std::string time = sweep.nominal.scene->time_unit();
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const std::string& unit = coordinates[i].unit;
    if (name == "q" + std::to_string(i)) return unit;
    if (name == "qdot" + std::to_string(i)) return time.empty() ? unit : (unit.empty() ? "1" : unit) + "/" + time;
  }
  return {};
}

/// Percentiles and a histogram of what is finite.
void describe(report::Page& page, const Quantity& quantity, std::vector<double> values) {
  std::erase_if(values, [](double x) { return !std::isfinite(x); });
  if (values.empty()) return;
  std::sort(values.begin(), values.end());
  double sum = 0.0, squares = 0.0;
  for (const double x : values) sum += x;
  const double count = static_cast<double>(values.size()), mean = sum / count;
  for (const double x : values) squares += (x - mean) * (x - mean);
  const auto at = [&](double share) { return report::rounded_text(values[static_cast<std::size_t>(share * (count - 1.0) + 0.5)], 6); };
  page.tables.push_back({.heading = labelled(quantity.text, quantity.unit),
                         .rows = {{"motions that have it", std::to_string(values.size())},
                                  {"mean", report::rounded_text(mean, 6)},
                                  {"standard deviation", report::rounded_text(values.size() > 1 ? std::sqrt(squares / (count - 1.0)) : 0.0, 4)},
                                  {"least, greatest", at(0.0) + ", " + at(1.0)},
                                  {"5 %, 50 %, 95 %", at(0.05) + ", " + at(0.5) + ", " + at(0.95)}}});
  const int bins = static_cast<int>(std::clamp(std::sqrt(count), 5.0, 60.0));
  const double low = values.front(), width = (values.back() - low) / bins;
  if (!(width > 0.0)) return;
  report::Plot plot{.title = "How often"};
  plot.x.label = labelled(quantity.text, quantity.unit);
  plot.y.label = "motions";
  report::Series series{.label = "", .x = {}, .y = {}};
  std::vector<double> counts(static_cast<std::size_t>(bins), 0.0);
  for (const double x : values) counts[static_cast<std::size_t>(std::min(static_cast<double>(bins - 1), (x - low) / width))] += 1.0;
  for (int b = 0; b < bins; ++b)
    for (const int side : {0, 1}) {
      series.x.push_back(low + width * (b + side));
      series.y.push_back(counts[static_cast<std::size_t>(b)]);
    }
  plot.series.push_back(std::move(series));
  page.plots.push_back(std::move(plot));
}

std::string html_of(const Sweep& sweep, const std::vector<Row>& rows, const std::string& summary) {
  const auto& axes = sweep.values.axes();
  report::Page page{.title = sweep.nominal.scene->title(), .lead = summary};
  for (std::size_t k = 0; k < sweep.quantities.size(); ++k) {
    const Quantity& quantity = sweep.quantities[k];
    const std::vector<double> values = column(rows, k);
    if (sweep.values.is_random()) {
      describe(page, quantity, values);
    } else if (axes.size() == 2) {
      report::HeatMap map{.title = labelled(quantity.text, quantity.unit), .x_label = labelled(axes[0].name, unit_of(sweep, axes[0].name)),
                          .y_label = labelled(axes[1].name, unit_of(sweep, axes[1].name)), .x = axes[0].values, .y = axes[1].values, .values = values};
      for (const Row& row : rows) map.remarks.push_back(row.message.empty() ? "not within the time" : row.message);
      page.figures.push_back(report::heat_map(map));
    } else if (axes.size() == 1) {
      report::Plot plot{.title = ""};
      plot.x.label = labelled(axes[0].name, unit_of(sweep, axes[0].name));
      if (axes[0].logarithmic) plot.x.scale = report::Scale::logarithmic;
      plot.y.label = labelled(quantity.text, quantity.unit);
      plot.series.push_back({.label = "", .x = axes[0].values, .y = values, .markers = axes[0].values.size() <= 60});
      page.plots.push_back(std::move(plot));
    }
  }
  if (!page.figures.empty()) page.figures.back() += report::heat_map_script();
  return report::html(page);
}

std::string json_of(const Sweep& sweep, const std::vector<Row>& rows) {
  using Json = nlohmann::ordered_json;
  Json json;
  json["scene"] = sweep.nominal.scene->name();
  json["motions"] = rows.size();
  json["completed"] = std::count_if(rows.begin(), rows.end(), [](const Row& row) { return row.outcome == Outcome::completed; });
  for (const SweptAxis& axis : sweep.values.axes()) json["over"].push_back(axis.name);
  for (const Quantity& quantity : sweep.quantities) json["record"].push_back(quantity.text);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Json row = Json::array();
    for (const double x : sweep.values.of(i)) row.push_back(x);
    for (const double x : rows[i].values) row.push_back(std::isfinite(x) ? Json(x) : Json(nullptr));
    row.push_back(name(rows[i].outcome));
    json["rows"].push_back(std::move(row));
  }
  return json.dump();
}

}  // namespace

int sweep(const SweepOptions& options) {
  const Sweep sweep = sweep_of(options);
  const std::size_t count = sweep.values.count();
  std::vector<Row> rows;
  rows.reserve(count);
  const auto began = std::chrono::steady_clock::now();
  {
    ProgressBar progress(0.0, static_cast<double>(count), !options.quiet);
    simulate_many(count, [&](std::size_t i) { return motion(sweep, i); }, 0,
                  [&](int&, std::size_t i, Kept<Row>&& kept) {
                    if (kept.completed()) rows.push_back(std::move(*kept.value));
                    else rows.push_back({std::vector<double>(sweep.quantities.size(), std::numeric_limits<double>::quiet_NaN()), Outcome::refused_by_model, kept.message()});
                    progress.reached(static_cast<double>(i + 1));
                  },
                  sweep.many);
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  const auto failed = static_cast<std::size_t>(std::count_if(rows.begin(), rows.end(), [](const Row& row) { return row.outcome != Outcome::completed; }));
  std::string over;
  for (const SweptAxis& axis : sweep.values.axes()) over += (over.empty() ? "" : ", ") + axis.name;
  const std::string summary = std::to_string(count) + " motions over " + over + " to t = " + report::rounded_text(sweep.request.t_end, 6) +
                              (failed == 0 ? "" : ", " + std::to_string(failed) + " of them failed");
  if (options.out)
    report::write_files({{sweep.paths[0], csv_of(sweep, rows)}, {sweep.paths[1], npz_of(sweep, rows)}, {sweep.paths[2], html_of(sweep, rows, summary + ".")}});
  if (options.json) {
    std::printf("%s\n", json_of(sweep, rows).c_str());
  } else {
    std::printf("%s: %s, in %s s\n", options.scene.c_str(), summary.c_str(), report::rounded_text(seconds, 3).c_str());
    for (std::size_t k = 0; k < sweep.quantities.size(); ++k) {
      double low = HUGE_VAL, high = -HUGE_VAL;
      std::size_t known = 0;
      for (const Row& row : rows)
        if (std::isfinite(row.values[k])) low = std::min(low, row.values[k]), high = std::max(high, row.values[k]), ++known;
      if (known == 0) std::printf("  %-20s no motion has it\n", sweep.quantities[k].text.c_str());
      else std::printf("  %-20s %s … %s%s\n", sweep.quantities[k].text.c_str(), report::rounded_text(low, 6).c_str(), report::rounded_text(high, 6).c_str(),
                       known == count ? "" : (", " + std::to_string(count - known) + " motions without").c_str());
    }
    std::set<std::string> said;  // each outcome once, with the first message
    for (const Row& row : rows)
      if (row.outcome != Outcome::completed && said.insert(std::string(name(row.outcome))).second) std::printf("  first %s: %s\n", std::string(name(row.outcome)).c_str(), row.message.c_str());
    for (const std::string& path : sweep.paths) std::printf("  wrote %s\n", path.c_str());
  }
  return failed == 0 ? 0 : 1;
}

}  // namespace qdot::program
