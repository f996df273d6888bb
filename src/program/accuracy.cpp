// SPDX-License-Identifier: MIT
//
// qdot accuracy SCENE: what accuracy costs in time, with every method that fits.
//
// The reference is the scene's own T and V in long double, extrapolated. Where the equations hold in double only
// (constraints), it is the tightest run of one method, and what another method makes of the same motion is its uncertainty.
#include "program/accuracy.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "program/arguments.hpp"
#include "program/catalogue.hpp"
#include "program/commands.hpp"
#include "program/simulation.hpp"
#include "qdot/report/file.hpp"
#include "qdot/report/number.hpp"

namespace qdot::program {

namespace {

using Shared = std::shared_ptr<const Model>;

RunCounts counts_of(const Statistics& s) { return {s.steps, s.rejected(), s.evaluations, s.jacobians}; }

/// Samples of a run after its start, a column each; empty where it did not come to the end.
Eigen::MatrixXd states_of(const Result& result, int outputs) {
  if (result.outcome != Outcome::completed || result.samples.size() != static_cast<std::size_t>(outputs) + 1) return {};
  Eigen::MatrixXd states(result.end.y.size(), outputs);
  for (int k = 0; k < outputs; ++k) states.col(k) = result.samples[static_cast<std::size_t>(k) + 1].y;
  return states;
}

Contender contender(const Shared& model, const Request& request, const std::string& method) {
  const bool fixed = has_fixed_step(method);
  const auto asked = [request, method, fixed](double setting) {
    Request one = request;
    one.method = method;
    if (fixed) {
      one.step = setting;
    } else {
      one.rtol = one.atol = setting;
    }
    return one;
  };
  Contender c;
  c.name = method;
  c.fixed_step = fixed;
  c.observed = [=](double setting) {
    const Request one = asked(setting);
    Result result = simulated(model, one, {});
    ObservedRun run{counts_of(result.statistics), result.outcome, result.message, result.end.t, states_of(result, one.samples - 1)};
    if (model->is_constrained()) run.constraint_residual = result.statistics.constraint_residual;
    run.energy_times = std::move(result.step_times);
    run.energy_change = std::move(result.jacobi_change);
    return run;
  };
  c.ready_to_run = [=](double setting) -> std::function<RunCounts()> {
    Request one = asked(setting);
    one.samples = 0;
    return [=] { return counts_of(bare_run(model, one).statistics); };
  };
  return c;
}

/// The tightest run of `method` that completes, or nothing.
Eigen::MatrixXd tightest(const Shared& model, const Request& request, const std::string& method) {
  for (const double tolerance : {1e-14, 1e-13, 1e-12, 1e-11}) {
    Request one = request;
    one.method = method;
    one.rtol = one.atol = tolerance;
    const Eigen::MatrixXd states = states_of(simulated(model, one, {}), request.samples - 1);
    if (states.size() > 0) return states;
  }
  return {};
}

/// A reference in double: one method, judged by the other that comes closest to it.
ReferenceMotion agreed_reference(const Shared& model, const Request& request, const std::vector<double>& times) {
  ReferenceMotion reference;
  reference.t = times;
  std::string first;
  Eigen::MatrixXd states;
  std::vector<std::string> methods = fitting_methods(*model, request.start);
  std::stable_partition(methods.begin(), methods.end(), [](const std::string& name) { return name == "dop853"; });
  std::erase_if(methods, has_fixed_step);
  double closest = std::numeric_limits<double>::infinity();
  for (const std::string& method : methods) {
    const Eigen::MatrixXd other = tightest(model, request, method);
    if (other.size() == 0) continue;
    if (first.empty()) {
      first = method;
      states = other;
      reference.scale = model->packed(request.start).cwiseAbs().cwiseMax(states.cwiseAbs().rowwise().maxCoeff());
      const double largest = std::max(reference.scale.maxCoeff(), std::numeric_limits<double>::min());
      for (double& s : reference.scale)
        if (!(s > qdot::detail::negligible_error * largest)) s = largest;
      continue;
    }
    const double difference = ((other - states).array().colwise() / reference.scale.array()).abs().maxCoeff();
    if (!(difference < closest)) continue;
    closest = difference;
    reference.made_by = "double precision, " + first + " at its tightest tolerance, judged by " + method;
  }
  if (!std::isfinite(closest)) throw NoReference("no two methods complete this motion, so that there is nothing to measure errors against");
  reference.y = states.cast<long double>();
  reference.uncertainty = closest;
  reference.rate = Eigen::VectorXd::Zero(states.rows());
  Eigen::VectorXd ydot(states.rows());
  for (Eigen::Index k = 0; k < states.cols(); ++k) {
    model->derivative(times[static_cast<std::size_t>(k)], states.col(k), ydot);
    reference.rate = reference.rate.cwiseMax(ydot.cwiseAbs());
  }
  return reference;
}

ReferenceMotion reference_of(const Shared& model, const Request& request, const std::vector<double>& times) {
  const Eigen::VectorXd y0 = model->packed(request.start);
  LongVector y = y0.cast<long double>(), ydot = y;
  try {
    if (model->long_derivative(request.start.t, y, ydot)) {
      const auto f = [&](const long double& t, const LongVector& at, LongVector& out) { model->long_derivative(t, at, out); };
      return qdot::detail::extrapolated_reference<long double>(f, request.start.t, y0, times, {.max_seconds = 20});
    }
  } catch (const NoReference&) {  // too long, or too stiff: double must do
  }
  return agreed_reference(model, request, times);
}

std::string machine() {
  std::string processor = "unknown processor";
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (!line.starts_with("model name") || line.find(": ") == std::string::npos) continue;
    processor = line.substr(line.find(": ") + 2);
    break;
  }
#if defined(__clang__)
  return processor + ", clang " + std::to_string(__clang_major__);
#elif defined(__GNUC__)
  return processor + ", g++ " + std::to_string(__GNUC__);
#else
  return processor;
#endif
}

std::vector<std::string> chosen_methods(const Model& model, const State<Dynamic>& start, const std::vector<std::string>& wanted) {
  if (wanted.empty()) return fitting_methods(model, start);
  const std::vector<std::string> valid = fitting_methods(model, start);
  for (const std::string& method : wanted) {
    if (std::find(valid.begin(), valid.end(), method) == valid.end()) throw unknown_name("--method", "a method that fits this scene", method, valid);
  }
  return wanted;
}

/// A line on a terminal that says what is being measured.
class Status {
 public:
  explicit Status(bool wanted) : shown_(wanted && isatty(STDERR_FILENO) != 0) {}
  Status(const Status&) = delete;
  Status& operator=(const Status&) = delete;
  ~Status() { show(""); }

  void show(const std::string& text) const {
    if (shown_) std::fprintf(stderr, "\r\033[K%s", text.c_str());
  }

 private:
  bool shown_;
};

/// The motion that is asked for; sets parameters, effects and the way of evaluation in the scene.
Request request_of(RunnableScene& scene, const AccuracyOptions& options) {
  Request request;
  request.start = start_with(scene, configured(scene, options.set));
  choose_effects(scene, options);
  choose_way(scene, options);
  request.t_end = options.t_end ? finite_number("--t-end", *options.t_end) : scene.t_end();
  if (!(request.t_end > request.start.t)) {
    throw UsageError("--t-end: must be after the start, t = " + report::exact_text(request.start.t) + ", given " + *options.t_end);
  }
  return request;
}

WorkPrecisionOptions limits_of(const AccuracyOptions& options) {
  WorkPrecisionOptions limits;
  if (options.quick) {
    limits.tolerances = {1e-4, 1e-7, 1e-10, 1e-13};
    limits.seconds_per_cell = 0.005;
    limits.longest_run = 0.2;
  }
  if (options.samples) limits.outputs = static_cast<int>(whole_number("--samples", *options.samples, 1, 100'000));
  return limits;
}

/// Moves the start onto the constraints: every run is to begin where the reference begins.
void project_start(const Model& model, State<Dynamic>& start) {
  Eigen::VectorXd y = model.packed(start);
  model.project(start.t, y);
  start.q = y.head(model.dof());
  start.qdot = y.segment(model.dof(), model.dof());
}

WorkPrecision study_of(const Shared& model, const Request& request, const WorkPrecisionOptions& limits, const AccuracyOptions& options) {
  std::vector<Contender> contenders;
  for (const std::string& method : chosen_methods(*model, request.start, options.methods)) contenders.push_back(contender(model, request, method));
  const Status status(!options.quiet && !options.json);
  status.show("computing the reference");
  const EnergyFunctions energies{[&](double t, const Eigen::VectorXd& y) { return model->energies(t, y).jacobi; },
                                 [&](double t, const Eigen::VectorXd& y) { return model->energies(t, y).kinetic; }};
  const auto progress = [&](const std::string& method, double setting) { status.show(method + " at " + report::rounded_text(setting, 3)); };
  return work_precision(reference_of(model, request, output_times(request.start.t, request.t_end, limits.outputs)), request.start.t, contenders, energies,
                        limits, progress);
}

/// Writes the files of --out, and prints what was found.
void write_study(const SceneStudy& found, const std::vector<std::string>& files, bool json) {
  if (!files.empty()) report::write_files({{files[0], accuracy_csv(found)}, {files[1], accuracy_html(found)}, {files[2], accuracy_svg(found)}});
  if (json) {
    std::printf("%s\n", accuracy_json(found, files).c_str());
  } else {
    std::printf("%s", accuracy_text(found).c_str());
    for (const std::string& file : files) std::printf("  wrote %s\n", file.c_str());
  }
}

}  // namespace

int accuracy(const AccuracyOptions& options) {
  const std::unique_ptr<RunnableScene> scene = make_scene(options.scene);
  Request request = request_of(*scene, options);
  const WorkPrecisionOptions limits = limits_of(options);
  request.samples = limits.outputs + 1;
  std::vector<std::string> files;
  if (options.out) {
    files = accuracy_paths(*options.out);
    require_files(*options.out, files);
  }
  Shared model;
  try {
    model = scene->model();
  } catch (const InvalidValue& error) {  // a parameter that an effect does not take
    throw UsageError(std::string("--set: ") + error.what());
  }
  if (model->is_constrained()) project_start(*model, request.start);
  const SceneStudy found{*scene, request.start, request.t_end, study_of(model, request, limits, options), machine(), options.quick};
  write_study(found, files, options.json);
  const bool some = std::any_of(found.study.measurements.begin(), found.study.measurements.end(), [](const Measurement& m) { return m.completed(); });
  return some ? 0 : 1;
}

}  // namespace qdot::program
