// SPDX-License-Identifier: MIT
//
// qdot lyapunov SCENE: how fast motions part that begin close to the start, as exponents with their standard errors and how they came about.
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "program/arguments.hpp"
#include "program/commands.hpp"
#include "program/exponents.hpp"
#include "program/progress.hpp"
#include "program/varied_motion.hpp"
#include "qdot/report/csv.hpp"
#include "qdot/report/file.hpp"
#include "qdot/report/html.hpp"
#include "qdot/report/number.hpp"
#include "qdot/report/table.hpp"

namespace qdot::program {

namespace {

using Json = nlohmann::ordered_json;

struct LyapunovRequest : ChosenScene {
  Request run = {};
  qdot::LyapunovOptions measured = {};
  std::vector<std::string> paths = {};
  std::string rate = {};  // unit of an exponent
};

LyapunovRequest request_of(const LyapunovCommandOptions& options) {
  LyapunovRequest request{chosen_scene(options)};
  if (const std::string why = lacks_exponents(*request.model); !why.empty())
    throw UsageError("SCENE: " + why + ", but " + request.scene->name() + " has (try --without, or lyapunov_spectrum() of the library, which takes them)");
  const double t0 = request.start.t, usual = request.scene->t_end() - t0;
  request.run.t_end = options.t_end ? finite_number("--t-end", *options.t_end) : t0 + 50.0 * usual;
  if (request.run.t_end == t0) throw UsageError("--t-end: must differ from the time of the start, given " + *options.t_end);
  const double duration = std::abs(request.run.t_end - t0);
  request.measured.interval = options.interval ? positive_number("--interval", *options.interval) : std::min(0.1 * usual, 0.01 * duration);
  if (options.settle) {
    request.measured.settle = finite_number("--settle", *options.settle);
    if (!(*request.measured.settle >= 0.0 && *request.measured.settle < duration))
      throw UsageError("--settle: must lie from 0 to the duration of the run, " + report::exact_text(duration) + ", given " + *options.settle);
  }
  request.run.rtol = options.rtol ? positive_number("--rtol", *options.rtol) : 1e-9;
  request.run.atol = request.run.rtol;
  request.run.start = request.start;
  request.paths = writable_files(options.out, {".csv", ".html"});
  request.rate = request.scene->time_unit().empty() ? "" : "1/" + request.scene->time_unit();
  return request;
}

void write(const LyapunovRequest& request, const LyapunovSpectrum& found) {
  if (request.paths.empty()) return;
  report::Table table;
  table.columns = {{"t", request.scene->time_unit(), found.times}};
  report::Plot plot{.title = "Exponents, from when they are counted to t"};
  plot.x.label = request.scene->time_unit().empty() ? "t" : "t [" + request.scene->time_unit() + "]";
  plot.y.label = request.rate.empty() ? "λ" : "λ [" + request.rate + "]";
  report::Facts facts{.heading = "At the end", .rows = {}};
  for (Eigen::Index i = 0; i < found.lambda.size(); ++i) {
    const std::string number = std::to_string(i + 1);
    std::vector<double> values;
    for (const Eigen::VectorXd& running : found.running) values.push_back(running[i]);
    table.columns.push_back({"lambda_" + number, request.rate, values});
    plot.series.push_back({.label = "λ" + number, .x = found.times, .y = std::move(values)});
    facts.rows.push_back({"λ" + number, report::rounded_text(found.lambda[i], 6) + " ± " +
                                            report::rounded_text(found.standard_error[i], 2) + " " + request.rate});
  }
  report::Page page{.title = request.scene->title(), .lead = request.scene->summary()};
  page.tables.push_back(std::move(facts));
  page.plots.push_back(std::move(plot));
  report::write_files({{request.paths[0], report::csv(table)}, {request.paths[1], report::html(report::in_symbols(std::move(page)))}});
}

std::string json_of(const LyapunovRequest& request, const LyapunovSpectrum& found) {
  const auto list = [](const Eigen::VectorXd& x) {
    Json numbers = Json::array();
    for (const double value : x) numbers.push_back(std::isfinite(value) ? Json(value) : Json(nullptr));
    return numbers;
  };
  Json json;
  json["scene"] = request.scene->name();
  json["outcome"] = name(found.outcome);
  json["message"] = found.message;
  json["t"] = found.t;
  json["lambda"] = list(found.lambda);
  json["standard_error"] = list(found.standard_error);
  json["intervals"] = found.times.size();
  return json.dump(2);
}

}  // namespace

int lyapunov(const LyapunovCommandOptions& options) {
  const LyapunovRequest request = request_of(options);
  LyapunovSpectrum found;
  {
    ProgressBar progress(request.start.t, request.run.t_end, !options.quiet);
    found = exponents_of(request.model, request.run, request.measured, [&](double t) { progress.reached(t); });
  }
  write(request, found);
  if (options.json) {
    std::printf("%s\n", json_of(request, found).c_str());
  } else {
    std::printf("%s: %s\n", request.scene->name().c_str(), found.message.c_str());
    std::printf("  %-10s %-14s %s\n", "", request.rate.empty() ? "lambda" : ("lambda [" + request.rate + "]").c_str(), "standard error");
    for (Eigen::Index i = 0; i < found.lambda.size(); ++i)
      std::printf("  lambda_%-3ld %-14s %s\n", static_cast<long>(i + 1), report::rounded_text(found.lambda[i], 6).c_str(),
                  report::rounded_text(found.standard_error[i], 2).c_str());
  }
  return found.completed() ? 0 : 1;
}

}  // namespace qdot::program
