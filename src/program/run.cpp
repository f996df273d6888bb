// SPDX-License-Identifier: MIT
//
// qdot run SCENE: everything is checked before the first step, then the run, then its outputs.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "program/accurate_run.hpp"
#include "program/arguments.hpp"
#include "program/catalogue.hpp"
#include "program/commands.hpp"
#include "program/comparison.hpp"
#include "program/json.hpp"
#include "program/methods.hpp"
#include "program/output.hpp"
#include "program/progress.hpp"
#include "program/simulation.hpp"
#include "qdot/report/file.hpp"
#include "qdot/report/number.hpp"

namespace qdot::program {

namespace {

using report::exact_text;

constexpr double start_on_constraints = 1e-12;  // what rounding moves is not worth a line

double tolerance(const char* option, const std::string& text) {
  const double value = finite_number(option, text);
  if (value <= 0) throw UsageError(std::string(option) + ": must be positive, given " + text);
  return value;
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

// Fewer rows of a table, or frames, where each has many numbers.
int rows_that_fit(int wanted, int least, Eigen::Index components) {
  constexpr Eigen::Index most_numbers = 5'000'000;
  return static_cast<int>(std::min<Eigen::Index>(wanted, std::max<Eigen::Index>(least, most_numbers / components)));
}

Request request_of(RunnableScene& scene, const RunOptions& options) {
  Request request;
  request.start = start_with(scene, configured(scene, options.set));
  choose_effects(scene, options);
  choose_way(scene, options);
  const std::shared_ptr<const Model> model = model_of(scene);
  request.t_end = options.t_end ? finite_number("--t-end", *options.t_end) : scene.t_end();
  if (!(request.t_end > request.start.t)) {
    throw UsageError("--t-end: must be after the start, t = " + exact_text(request.start.t) + ", given " + *options.t_end);
  }
  if (options.method) request.method = *options.method;
  const MethodInfo& method = method_named(request.method);
  if (const std::string why = misfit(*model, method.name, request.start); !why.empty()) {
    throw UsageError("--method: must fit " + scene.name() + ", but " + method.name + " " + why + " (what fits: auto, " +
                     listed(fitting_methods(*model, request.start)) + ")");
  }
  if (options.step) {
    if (!method.fixed_step()) {
      throw UsageError("--step: must stand with a method of fixed step (gauss8, blanes_moan_6, …), given with " + method.name +
                       ", which chooses its steps by --rtol and --atol");
    }
    request.step = tolerance("--step", *options.step);
  }
  if (options.accuracy && (options.rtol || options.atol)) {
    throw UsageError("--accuracy: must stand without --rtol and --atol, which it chooses, given together with one");
  }
  if (options.accuracy && options.step) {
    throw UsageError("--accuracy: must stand without --step, which it chooses, given together with it");
  }
  if (options.forces) {
    request.forces = true;
    const auto refuse = [](const std::string& why) { throw UsageError("--forces: must stand " + why); };
    if (!options.out) refuse("with --out PATH, whose page shows them");
    if (scene.positions(request.start.q, request.start.t).empty())
      refuse("with a scene that has a view, but " + scene.name() + " has plots only; give it .positions");
    const Eigen::VectorXd y = model->packed(request.start);
    if (!model->is_constrained() && model->applied_forces(request.start.t, y).size() == 0)
      refuse("with constraints or effects, but " + scene.name() +
             " has T and V alone, whose forces have no arrows; --with EFFECT gives it one, qdot list " + scene.name() + " has their names");
  }
  if (options.rtol) request.rtol = tolerance("--rtol", *options.rtol);
  if (options.atol) request.atol = tolerance("--atol", *options.atol);
  request.atol_is_given = options.atol.has_value();
  request.by_is_given = options.by.has_value();
  request.samples = rows_that_fit(request.samples, 2, model->size());
  if (options.samples) request.samples = static_cast<int>(whole_number("--samples", *options.samples, 2, 10'000'000));
  return request;
}

void print_summary(const RunnableScene& scene, const Request& request, const Result& result,
                   const std::vector<std::string>& files) {
  const auto coordinates = scene.coordinates();
  const auto n = static_cast<Eigen::Index>(coordinates.size());
  const auto with_unit = [](const std::string& text, const std::string& unit) { return unit.empty() ? text : text + " " + unit; };
  std::printf("%s: %s\n", scene.name().c_str(), result.message.c_str());
  constexpr Eigen::Index most = 8;
  for (Eigen::Index i = 0; i < std::min(n, most); ++i) {
    const std::string& name = coordinates[static_cast<std::size_t>(i)].name;
    std::printf("  %-10s % .12g   %-13s % .12g\n", name.c_str(), result.end.y[i], (name + "dot").c_str(), result.end.y[n + i]);
  }
  if (n > most) std::printf("  … and %ld more coordinates (all of them with --json or --out)\n", static_cast<long>(n - most));
  constexpr std::size_t most_events = 10, most_reactions = 8;
  for (std::size_t i = 0; i < std::min(result.events.size(), most_events); ++i)
    std::printf("  t = %-14.10g %s\n", result.events[i].t, result.events[i].name.c_str());
  if (result.events.size() > most_events) std::printf("  … and %zu more events (all of them with --json)\n", result.events.size() - most_events);
  for (std::size_t i = 0; i < std::min(result.reactions.size(), most_reactions); ++i)
    std::printf("  lambda of %s  %.12g\n", result.reactions[i].name.c_str(), result.reactions[i].lambda);
  if (result.reactions.size() > most_reactions)
    std::printf("  … and %zu more multipliers (all of them with --json)\n", result.reactions.size() - most_reactions);
  if (result.start_moved && std::max(result.start_moved->moved_q, result.start_moved->moved_qdot) > start_on_constraints) {
    std::printf("  the start was moved onto the constraints: coordinates by at most %s, velocities by at most %s\n",
                report::rounded_text(result.start_moved->moved_q, 3).c_str(),
                report::rounded_text(result.start_moved->moved_qdot, 3).c_str());
  }
  if (result.start_moved) {
    std::printf("  constraints met to %s, their rates to %s\n", report::rounded_text(result.statistics.constraint_residual, 2).c_str(),
                report::rounded_text(result.statistics.constraint_velocity, 2).c_str());
  }
  const std::string unit = scene.energy_unit();
  const bool by_jacobi = jacobi_differs(result);
  std::printf("  energy     %s, largest change %s%s\n", with_unit(report::rounded_text(result.energy.initial, 12), unit).c_str(),
              with_unit(report::rounded_text(result.energy.largest, 3), unit).c_str(),
              by_jacobi ? "; T is not quadratic in the velocities, and Jacobi's h takes the place of T + V" : "");
  if (result.balance.work != 0 || result.balance.impacts != 0) {
    std::printf("  work of all that is in neither T nor V %s, change in impacts %s, unaccounted for %s\n",
                with_unit(report::rounded_text(result.balance.work, 6), unit).c_str(),
                with_unit(report::rounded_text(result.balance.impacts, 6), unit).c_str(),
                with_unit(report::rounded_text(result.balance.residual, 3), unit).c_str());
  }
  if (by_jacobi) {
    std::printf("  Jacobi's h %s, largest change %s\n",
                with_unit(report::rounded_text(result.jacobi.initial, 12), unit).c_str(),
                with_unit(report::rounded_text(result.jacobi.largest, 3), unit).c_str());
  }
  if (request.by_is_given) std::printf("  evaluated by %s\n", result.statistics.evaluated_by.c_str());
  if (!result.statistics.method_reason.empty()) std::printf("  chose %s\n", result.statistics.method_reason.c_str());
  const std::string setting = result.step ? "step " + report::rounded_text(*result.step, 4)
                                          : "rtol " + exact_text(request.rtol) + ", atol " + exact_text(request.atol);
  std::printf("  %s, %s: %ld steps, %ld rejected, %ld evaluations, %ld Jacobians, %.3g ms\n",
              request.method.c_str(), setting.c_str(),
              result.statistics.steps, result.statistics.rejected(), result.statistics.evaluations,
              result.statistics.jacobians, 1e3 * result.statistics.wall_seconds);
  if (result.accuracy) std::printf("%s\n", accuracy_text(*result.accuracy).c_str());
  for (const std::string& file : files) std::printf("  wrote %s\n", file.c_str());
}

void print_differences(const ComparedRun& first, const ComparedRun& other) {
  std::printf("%s: apart by", other.label.c_str());
  constexpr std::size_t most = 8;
  const std::vector<Difference> all = largest_differences(first, other);
  for (std::size_t i = 0; i < std::min(most, all.size()); ++i)
    std::printf("%s %s in %s at t = %s", i > 0 ? "," : "", report::rounded_text(all[i].size, 3).c_str(), all[i].coordinate.c_str(),
                report::rounded_text(all[i].t, 4).c_str());
  std::printf("%s\n", all.size() > most ? ", …" : "");
}

}  // namespace

int run(const RunOptions& options) {
  std::vector<ComparedRun> runs;
  std::vector<std::optional<double>> accuracies;
  const auto prepare = [&](const std::string& label, const RunOptions& of_run) {
    std::unique_ptr<RunnableScene> scene = make_scene(of_run.scene);
    Request request = request_of(*scene, of_run);
    accuracies.push_back(of_run.accuracy ? std::optional(tolerance("--accuracy", *of_run.accuracy)) : std::nullopt);
    runs.push_back({label, std::move(scene), std::move(request), {}});
  };
  prepare("as asked for", options);
  for (const std::string& settings : options.compare) prepare(settings, with_settings(options, settings));

  std::vector<std::string> files;
  if (options.out) {
    files = output_paths(*options.out);
    for (std::string& path : further_paths(*options.out, runs.size())) files.push_back(std::move(path));
    require_files(*options.out, files);
    for (ComparedRun& run : runs)
      run.request.most_frames = rows_that_fit(frame_count(*run.scene, run.request.start, run.request.t_end), 0, 2 * run.request.start.q.size());
  }
  for (std::size_t k = 0; k < runs.size(); ++k) {
    ComparedRun& run = runs[k];
    try {
      ProgressBar progress(run.request.start.t, run.request.t_end, !options.quiet);
      const Watcher watcher = [&](double t) { progress.reached(t); };
      run.result = accuracies[k] ? simulated_to_accuracy(run.scene->model(), run.request, *accuracies[k], watcher)
                                 : simulated(run.scene->model(), run.request, watcher);
    } catch (const InvalidValue& error) {  // a tolerance finer than double has digits
      throw UsageError(error.what());
    }
  }

  if (options.out) write_outputs(*options.out, runs);
  const auto any_failed = std::find_if(runs.begin(), runs.end(), [](const ComparedRun& run) { return failed(run.result.outcome); });
  if (options.json) {
    std::string text;
    for (const ComparedRun& run : runs) text += (text.empty() ? "" : ",\n") + run_json(*run.scene, run.request, run.result, files);
    std::printf(runs.size() == 1 ? "%s\n" : "{\"runs\": [%s]}\n", text.c_str());
  } else {
    for (const ComparedRun& run : runs) {
      if (runs.size() > 1) std::printf("%s: ", run.label.c_str());
      print_summary(*run.scene, run.request, run.result, &run == &runs.back() ? files : std::vector<std::string>());
    }
    for (std::size_t k = 1; k < runs.size(); ++k) print_differences(runs.front(), runs[k]);
  }
  if (any_failed == runs.end()) return 0;
  if (options.json) std::fprintf(stderr, "qdot run: %s\n", any_failed->result.message.c_str());
  return 1;
}

}  // namespace qdot::program
