// SPDX-License-Identifier: MIT
//
// qdot sweep SCENE: many motions of one scene, over a grid or a random sample, and what was asked of each. With --resume each motion is recorded when
// it is done (sweep_directory.hpp), by this process or by several, and what is written in the end is made of the records.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <new>
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
#include "program/scene_file.hpp"
#include "program/simulation.hpp"
#include "program/sweep_directory.hpp"
#include "program/sweep_share.hpp"
#include "program/sweep_workers.hpp"
#include "program/swept_quantities.hpp"
#include "program/swept_values.hpp"
#include "qdot/integrate/ensemble.hpp"
#include "qdot/report/csv.hpp"
#include "qdot/report/file.hpp"
#include "qdot/report/heat_map.hpp"
#include "qdot/report/html.hpp"
#include "qdot/report/npy.hpp"
#include "qdot/report/number.hpp"

namespace qdot::program {

namespace {

using Json = nlohmann::ordered_json;

struct Sweep {
  ChosenScene nominal;
  std::function<std::unique_ptr<RunnableScene>()> make;
  SceneOptions base = {};
  SweptValues values;
  std::vector<Quantity> quantities = {};
  Request request = {};
  EnsembleOptions many = {};
  std::vector<std::string> paths = {};
  bool is_recorded = false;
  SweepWorkers workers = {};
};

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
  QuantityWatch watch(sweep.quantities, chosen.model);
  const BareResult run = watch.wants_steps() ? followed_run(chosen.model, request, [&](const StepView& step) { return watch.see(step); })
                                             : bare_run(chosen.model, request);
  const bool complete = run.outcome == Outcome::completed || run.outcome == Outcome::stopped_by_observer;
  return {watch.values(request, run), complete ? Outcome::completed : run.outcome, complete ? "" : run.message};
}

/// The row of a motion, or of one that cannot begin; the reason is then its message.
Row row_of(const Sweep& sweep, Kept<Row>&& kept) {
  if (kept.completed()) return std::move(*kept.value);
  return {std::vector<double>(sweep.quantities.size(), std::numeric_limits<double>::quiet_NaN()), Outcome::refused_by_model, kept.message()};
}

/// Whether results are recorded, and which processes and threads do the sweep.
void choose_workers(Sweep& sweep, const SweepOptions& options) {
  sweep.is_recorded = options.resume || options.processes || options.shard;
  if (!sweep.is_recorded) {
    if (const std::string others = said_of_others(); !others.empty())
      throw UsageError("--shard: must be given where several processes are started together (" + others +
                       "), as each would do the whole sweep and write the same files; "
                       "give --out PATH --shard auto and they share it, or --shard 1/1 where each has a sweep and a PATH of its own");
    return;
  }
  const char* asked = options.resume ? "--resume" : options.processes ? "--processes" : "--shard";
  if (!options.out || options.out->empty() || options.out->back() == '/')
    throw UsageError(std::string(asked) + ": must stand with --out PATH, as records are kept in PATH.sweep, given " +
                     (options.out ? "\"" + *options.out + "\"" : "without"));
  if (options.processes) sweep.workers.processes = static_cast<int>(whole_number("--processes", *options.processes, 1, 1024));
  if (options.shard) sweep.workers.share = sweep_share(*options.shard);
  if (options.processes || options.shard) sweep.many.threads = std::max(1, sweep.many.threads);
  sweep.workers.threads = qdot::detail::threads_of(sweep.many);
  for (const std::string& path : sweep.paths)  // others may be writing them just now
    if (std::filesystem::is_directory(path))
      throw UsageError("--out: must be a path at which a file can be written, but " + path + " is a directory");
}

Sweep sweep_of(const SweepOptions& options) {
  const auto make = scene_maker(options.scene);
  Sweep sweep{.nominal = chosen_scene(options, make()), .make = make, .base = options, .values = swept_values(options.over, options.random, options.seed)};
  if (sweep.values.count() > 100'000'000)
    throw UsageError("--over: must not ask for more than 100000000 motions, given " + std::to_string(sweep.values.count()));
  const auto effects = sweep.nominal.scene->effects();
  for (SweptAxis& axis : sweep.values.axes())
    axis.is_effect = std::any_of(effects.begin(), effects.end(), [&](const EffectInfo& effect) { return effect.name == axis.name; });
  sweep.quantities = quantities_of(options.record, *sweep.nominal.scene, *sweep.nominal.model);
  sweep.request.t_end = options.t_end ? finite_number("--t-end", *options.t_end) : sweep.nominal.scene->t_end();
  if (!(sweep.request.t_end > sweep.nominal.start.t))
    throw UsageError("--t-end: must be after the start, t = " + report::exact_text(sweep.nominal.start.t) + ", given " +
                     report::exact_text(sweep.request.t_end));
  if (options.method) sweep.request.method = method_named(*options.method).name;
  if (const std::string why = misfit(*sweep.nominal.model, sweep.request.method, sweep.nominal.start); !why.empty())
    throw UsageError("--method: must fit " + options.scene + ", but " + sweep.request.method + " " + why);
  sweep.request.rtol = options.rtol ? positive_number("--rtol", *options.rtol) : 1e-8;
  sweep.request.atol = options.atol ? positive_number("--atol", *options.atol) : sweep.request.rtol;
  sweep.request.atol_is_given = options.atol.has_value();
  sweep.request.samples = 0;
  if (options.threads) sweep.many.threads = static_cast<int>(whole_number("--threads", *options.threads, 1, 1024));
  if (options.out) sweep.paths = {*options.out + ".csv", *options.out + ".npz", *options.out + ".html"};
  choose_workers(sweep, options);
  if (options.out && !sweep.is_recorded) require_files(*options.out, sweep.paths);
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
  for (const ComponentNames& entry : names_of_start(*sweep.nominal.scene))
    if (name == entry.name || name == entry.plain) return entry.unit;
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
  report::Series series{.label = "", .x = {low}, .y = {0.0}};
  std::vector<double> counts(static_cast<std::size_t>(bins), 0.0);
  for (const double x : values) counts[static_cast<std::size_t>(std::min(static_cast<double>(bins - 1), (x - low) / width))] += 1.0;
  for (int b = 0; b < bins; ++b)
    for (const int side : {0, 1}) {
      series.x.push_back(low + width * (b + side));
      series.y.push_back(counts[static_cast<std::size_t>(b)]);
    }
  series.x.push_back(series.x.back());
  series.y.push_back(0.0);
  plot.series.push_back(std::move(series));
  page.plots.push_back(std::move(plot));
}

/// "number 7, l=1.5, q0=0.1"
std::string numbered(const Sweep& sweep, std::size_t i) {
  std::string text = "number " + std::to_string(i);
  const std::vector<double> values = sweep.values.of(i);
  for (std::size_t k = 0; k < values.size(); ++k) text += ", " + sweep.values.axes()[k].name + "=" + report::exact_text(values[k]);
  return text;
}

/// How many motions failed in which way, and the first of each.
report::Facts outcomes_of(const Sweep& sweep, const std::vector<Row>& rows) {
  report::Facts facts{.heading = "Motions that failed", .rows = {}};
  std::map<std::string, std::size_t> count;
  for (const Row& row : rows)
    if (row.outcome != Outcome::completed) ++count[std::string(name(row.outcome))];
  for (const auto& [outcome, times] : count) {
    const auto first = std::find_if(rows.begin(), rows.end(),
                                    [&](const Row& row) { return row.outcome != Outcome::completed && name(row.outcome) == outcome; });
    facts.rows.push_back({outcome, std::to_string(times), "first " + numbered(sweep, static_cast<std::size_t>(first - rows.begin())) + ": " + first->message});
  }
  return facts;
}

/// What is shown of a motion that failed is why; what it had come to stands in the table and in the arrays.
std::string html_of(const Sweep& sweep, const std::vector<Row>& rows, const std::string& summary) {
  const auto& axes = sweep.values.axes();
  report::Page page{.title = sweep.nominal.scene->title(), .lead = report::in_symbols(summary)};
  for (std::size_t k = 0; k < sweep.quantities.size(); ++k) {
    const Quantity& quantity = sweep.quantities[k];
    std::vector<double> values = column(rows, k);
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (rows[i].outcome != Outcome::completed) values[i] = std::numeric_limits<double>::quiet_NaN();
    if (sweep.values.is_random()) {
      describe(page, quantity, values);
    } else if (axes.size() == 2) {
      const auto label = [&](const SweptAxis& axis) { return report::in_symbols(labelled(axis.name, unit_of(sweep, axis.name))); };
      report::HeatMap map{.title = report::in_symbols(labelled(quantity.text, quantity.unit)), .x_label = label(axes[0]), .y_label = label(axes[1]),
                          .x = axes[0].values, .y = axes[1].values, .values = values};
      for (const Row& row : rows)
        map.remarks.push_back(row.outcome == Outcome::completed ? "not within the time"
                                                                : std::string(name(row.outcome)) + ": " + row.message);
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
  page = report::in_symbols(std::move(page));
  if (report::Facts failed = outcomes_of(sweep, rows); !failed.rows.empty()) page.tables.push_back(std::move(failed));  // as one types what failed
  return report::html(page);
}

std::string json_of(const Sweep& sweep, const std::vector<Row>& rows) {
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

/// The motions one after another, kept in memory.
std::vector<Row> rows_at_once(const Sweep& sweep, bool quiet) {
  const std::size_t count = sweep.values.count();
  std::vector<Row> rows;
  rows.reserve(count);
  ProgressBar progress(0.0, static_cast<double>(count), !quiet);
  ensemble(count, [&](std::size_t i) { return motion(sweep, i); }, 0,
                [&](int&, std::size_t i, Kept<Row>&& kept) {
                  rows.push_back(row_of(sweep, std::move(kept)));
                  progress.reached(static_cast<double>(i + 1));
                },
                sweep.many);
  return rows;
}

/// All that the results depend on.
std::string manifest_of(const Sweep& sweep, const SweepOptions& options, std::size_t chunk) {
  nlohmann::ordered_json manifest;
  const auto numbers = [](std::vector<std::string> texts) {  // l=1.0 is l=1
    for (std::string& text : texts)
      if (const std::size_t begin = text.find('=') + 1; begin > 0)
        text = text.substr(0, begin) + report::exact_text(finite_number("--set", text.substr(begin)));
    return texts;
  };
  std::vector<std::string> record;
  for (const Quantity& quantity : sweep.quantities) record.push_back(quantity.text);
  manifest["qdot"] = QDOT_VERSION;
  manifest["format"] = 1;
  manifest["scene"] = sweep.nominal.scene->name();
  if (is_scene_file(options.scene)) {
    std::ifstream in(options.scene, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    manifest["scene file"] = qdot::detail::checksum(qdot::detail::empty_checksum, text.data(), text.size());
  }
  manifest["set"] = numbers(options.set);
  manifest["with"] = numbers(options.with);
  manifest["without"] = options.without;
  manifest["over"] = options.over;
  manifest["random"] = sweep.values.is_random() ? sweep.values.count() : 0;
  manifest["seed"] = sweep.values.is_random() ? options.seed.value_or("1") : "none";
  manifest["record"] = record;
  manifest["t_end"] = sweep.request.t_end;
  manifest["method"] = sweep.request.method;
  manifest["rtol"] = sweep.request.rtol;
  manifest["atol"] = sweep.request.atol;
  manifest["motions"] = sweep.values.count();
  manifest["chunk"] = chunk;
  return manifest.dump(1) + "\n";
}

std::string file_name(const Sweep& sweep) { return sweep.paths.front().substr(0, sweep.paths.front().size() - 4); }

SweepDirectory directory_of(const Sweep& sweep, const SweepOptions& options) {
  const std::size_t count = sweep.values.count(), chunk = std::clamp<std::size_t>(count / 4096, 1, 64);
  return {file_name(sweep) + ".sweep", manifest_of(sweep, options, chunk), count, chunk, sweep.quantities.size()};
}

/// Does what is missing; whether all is there then.
bool all_recorded(const Sweep& sweep, SweepDirectory& directory, const SweepOptions& options) {
  const std::size_t count = sweep.values.count();
  std::vector<std::string> early;
  {
    ProgressBar progress(0.0, static_cast<double>(count), !options.quiet);
    const auto row_at = [&](std::size_t i) {
      Kept<Row> kept;
      try {
        kept.value = motion(sweep, i);
      } catch (const std::bad_alloc&) {
        throw;  // which may come of what else is done on the machine, and not of the motion
      } catch (...) {
        kept.error = std::current_exception();
      }
      return row_of(sweep, std::move(kept));
    };
    const bool is_watched = !options.quiet && isatty(STDERR_FILENO) != 0;
    const RecordedCount reached = [&](std::size_t known) { progress.reached(static_cast<double>(known)); };
    early = work_on(directory, row_at, sweep.workers, is_watched ? reached : nullptr);
  }
  const std::size_t known = directory.known_now();
  for (const std::string& how : early) std::fprintf(stderr, "qdot sweep: a worker process ended early (%s)\n", how.c_str());
  if (known == count) return true;
  const std::string there = std::to_string(known) + " of " + std::to_string(count) + " motions are recorded in " + directory.path();
  if (!early.empty() || !sweep.workers.share.only)
    throw Error(there + "; the same command does the other " + std::to_string(count - known) + ", the first of which is " +
                numbered(sweep, directory.first_missing()));
  if (!options.json)
    std::printf("%s: the share %s is done; %s, and the others are not this share's\n", options.scene.c_str(), options.shard->c_str(), there.c_str());
  return false;
}

/// "1 motion", "2 motions"
std::string motions(std::size_t count) { return std::to_string(count) + (count == 1 ? " motion" : " motions"); }

/// Writes the files and says what came of it; the exit status.
int shown(const Sweep& sweep, const SweepOptions& options, const std::vector<Row>& rows, const std::string& how) {
  const std::size_t count = rows.size();
  const auto failed = static_cast<std::size_t>(std::count_if(rows.begin(), rows.end(), [](const Row& row) { return row.outcome != Outcome::completed; }));
  std::string over;
  for (const SweptAxis& axis : sweep.values.axes()) over += (over.empty() ? "" : ", ") + axis.name;
  const std::string summary = motions(count) + " over " + over + " to t = " + report::rounded_text(sweep.request.t_end, 6) +
                              (failed == 0 ? "" : ", " + std::to_string(failed) + " of them failed");
  if (options.out)
    report::write_files({{sweep.paths[0], csv_of(sweep, rows)}, {sweep.paths[1], npz_of(sweep, rows)}, {sweep.paths[2], html_of(sweep, rows, summary + ".")}});
  if (options.json) {
    std::printf("%s\n", json_of(sweep, rows).c_str());
  } else {
    std::printf("%s: %s, %s\n", options.scene.c_str(), summary.c_str(), how.c_str());
    for (std::size_t k = 0; k < sweep.quantities.size(); ++k) {
      double low = HUGE_VAL, high = -HUGE_VAL;
      std::size_t known = 0;
      for (const Row& row : rows)
        if (std::isfinite(row.values[k])) low = std::min(low, row.values[k]), high = std::max(high, row.values[k]), ++known;
      if (known == 0) std::printf("  %-20s no motion has it\n", sweep.quantities[k].text.c_str());
      else std::printf("  %-20s %s … %s%s\n", sweep.quantities[k].text.c_str(), report::rounded_text(low, 6).c_str(), report::rounded_text(high, 6).c_str(),
                       known == count ? "" : (", " + motions(count - known) + " without").c_str());
    }
    std::set<std::string> said;  // each outcome once, with the first message
    for (const Row& row : rows)
      if (row.outcome != Outcome::completed && said.insert(std::string(name(row.outcome))).second)
        std::printf("  first %s: %s\n", std::string(name(row.outcome)).c_str(), row.message.c_str());
    for (const std::string& path : sweep.paths) std::printf("  wrote %s\n", path.c_str());
  }
  return failed == 0 ? 0 : 1;
}

}  // namespace

int sweep(const SweepOptions& options) {
  const Sweep sweep = sweep_of(options);
  const auto began = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return "in " + report::rounded_text(std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count(), 3) + " s";
  };
  if (!sweep.is_recorded) {
    if (options.out && std::filesystem::is_directory(*options.out + ".sweep"))
      std::fprintf(stderr, "qdot sweep: %s.sweep keeps records of a sweep, which are left alone; --resume goes on with them\n", options.out->c_str());
    const std::vector<Row> rows = rows_at_once(sweep, options.quiet);
    return shown(sweep, options, rows, seconds());
  }
  SweepDirectory directory = directory_of(sweep, options);
  const std::size_t before = directory.known();
  if (!all_recorded(sweep, directory, options)) return 0;
  if (!directory.begin_merge()) {
    if (!options.json) std::printf("%s: done, and another process has written the results\n", options.scene.c_str());
    return 0;
  }
  std::vector<std::string> remarks;
  const std::vector<Row> rows = directory.rows(remarks);
  for (const std::string& remark : remarks) std::fprintf(stderr, "qdot sweep: %s\n", remark.c_str());
  try {
    const int status = shown(sweep, options, rows, seconds() + (before == 0 ? "" : ", " + std::to_string(before) + " of them recorded before"));
    directory.end_merge();
    return status;
  } catch (const report::UnwritableFile& error) {
    throw Error(std::string(error.what()) + "; all motions are recorded in " + directory.path() + ", and the same command writes the results");
  }
}

}  // namespace qdot::program
