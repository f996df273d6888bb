// SPDX-License-Identifier: MIT
//
// The only file of the program that includes CVODE: all scenes are stepped through the interface `Model`, whose virtual
// calls cost nothing beside a step.
#include "program/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

namespace qdot::program {

namespace {

/// A model as the steppers want it: a value with the members of FirstOrderSystem.
struct FirstOrderModel {
  static constexpr int size_at_compile_time = Dynamic;
  std::shared_ptr<const Model> model;

  Eigen::Index dof() const { return model->dof(); }
  Eigen::Index size() const { return model->size(); }
  void derivative(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) const {
    model->derivative(t, y, ydot);
  }
  void jacobian(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::MatrixXd> J) const {
    model->jacobian(t, y, J);
  }
  std::string component_name(Eigen::Index i) const { return model->component_name(i); }
};

/// The same for a model with constraints, which the steppers then keep.
struct ConstrainedModel : FirstOrderModel {
  ProjectionReport project(double t, Eigen::Ref<Eigen::VectorXd> y) const { return model->project(t, y); }
};

/// The same for a model whose constraints switch on and off at events.
struct SwitchingModel : ConstrainedModel {
  Eigen::Index guard_count() const { return model->guard_count(); }
  void guards(double t, const Eigen::VectorXd& y, Eigen::Ref<Eigen::VectorXd> g) const { model->guards(t, y, g); }
  void guard_bands(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& tolerance, Eigen::Ref<Eigen::VectorXd> out) const {
    model->guard_bands(t, y, tolerance, out);
  }
  std::string ending(Eigen::Index k) const { return model->ending(k); }
  std::vector<std::string> switched(double t, Eigen::VectorXd& y, const std::vector<bool>& fired, const Eigen::VectorXd& tolerance) const {
    return model->switched(t, y, fired, tolerance);
  }
};

std::vector<double> equal_times(double from, double to, int count) {
  std::vector<double> times;
  for (int i = 0; i < count; ++i) times.push_back(i + 1 == count ? to : from + (to - from) * i / (count - 1));
  return times;
}

/// Keeps a record of every accepted step, or of every 2nd, 4th, … when there are many.
class StepRecord {
 public:
  explicit StepRecord(Result& result) : result_(result) {}

  void see(double t, double energy_change, double jacobi_change) {
    if (count_++ % every_ != 0) return;
    result_.step_times.push_back(t);
    result_.energy_change.push_back(energy_change);
    result_.jacobi_change.push_back(jacobi_change);
    if (result_.step_times.size() < 20000) return;
    every_ *= 2;
    for (std::vector<double>* values : {&result_.step_times, &result_.energy_change, &result_.jacobi_change}) {
      for (std::size_t i = 0; 2 * i < values->size(); ++i) (*values)[i] = (*values)[2 * i];
      values->resize((values->size() + 1) / 2);
    }
  }

 private:
  Result& result_;
  long count_ = 0;
  long every_ = 1;
};

template <class Method, class System>
void run_with(const Method& method, const System& system, const Request& request, const Watcher& watcher,
              Result& result) {
  const Model& model = *system.model;
  const FirstOrderState start{request.start.t, result.end.y};
  const std::vector<double> sample_times = equal_times(start.t, request.t_end, request.samples);
  std::vector<double> frame_times;
  if (request.most_frames > 1) frame_times = equal_times(start.t, request.t_end, request.most_frames);

  Options options{.rtol = request.rtol, .atol = request.atol, .keep_trajectory = false};
  std::merge(sample_times.begin(), sample_times.end(), frame_times.begin(), frame_times.end(),
             std::back_inserter(options.output_times));
  if (request.atol_each.size() > 0) options.atol = request.atol_each;

  result.sizes = start.y.cwiseAbs();
  StepRecord record(result);
  record.see(start.t, 0, 0);
  EnergyMeter meter([&](double t, const Eigen::Ref<const Eigen::VectorXd>& y) { return model.energies(t, y).jacobi; },
                    [&](double t, const Eigen::Ref<const Eigen::VectorXd>& y) { return model.energy_rate(t, y); });
  const auto observer = [&](const StepView& step) {
    meter(step);
    result.sizes = result.sizes.cwiseMax(step.y().cwiseAbs());
    const Energies energies = model.energies(step.t(), step.y());
    result.energy.see(energies.total());
    result.jacobi.see(energies.jacobi);
    record.see(step.t(), energies.total() - result.energy.initial, energies.jacobi - result.jacobi.initial);
    if (watcher) watcher(step.t());
  };

  const auto run = simulate(system, start, request.t_end, method, options, observer);
  result.outcome = run.outcome;
  result.message = run.message;
  result.statistics = run.statistics;
  result.events = run.events;
  result.balance = meter.balance();
  result.end = {run.t, run.y, model.energies(run.t, run.y)};

  std::size_t next_frame = 0;
  std::size_t next_sample = 0;
  for (std::size_t i = 0; i < run.samples.t.size(); ++i) {
    const double t = run.samples.t[i];
    const Eigen::VectorXd y = run.samples.y.col(static_cast<Eigen::Index>(i));
    if (next_sample < sample_times.size() && sample_times[next_sample] == t) {
      if (result.samples.empty() || result.samples.back().t != t) result.samples.push_back({t, y, model.energies(t, y)});
      ++next_sample;
    } else if (next_frame < frame_times.size() && frame_times[next_frame] == t) {
      result.frames.push_back({t, y, {}});
      ++next_frame;
    }
  }
}

template <class System>
void run_named(const std::string& method, const System& system, const Request& request, const Watcher& watcher, Result& result) {
  if (method == "bdf") {
    run_with(CvodeBdf{}, system, request, watcher, result);
  } else if (method == "dop853") {
    run_with(Dop853{}, system, request, watcher, result);
  } else if constexpr (!ProjectableSystem<System>) {  // request_of() sees to it
    run_with(CvodeAdams{}, system, request, watcher, result);
  }
}

template <class Method, class System>
BareResult bare(const Method& method, const System& system, const FirstOrderState& start, const Request& request) {
  Options options{.rtol = request.rtol, .atol = request.atol, .keep_trajectory = false};
  if (request.samples > 1) options.output_times = equal_times(start.t, request.t_end, request.samples);
  auto run = simulate(system, start, request.t_end, method, options);
  return {run.outcome, run.message, run.t, run.y, std::move(run.samples.t), std::move(run.samples.y), run.statistics};
}

template <class System>
BareResult bare_named(const System& system, const FirstOrderState& start, const Request& request) {
  if (request.method == "bdf") return bare(CvodeBdf{}, system, start, request);
  if constexpr (!ProjectableSystem<System>) {
    if (request.method == "adams") return bare(CvodeAdams{}, system, start, request);
  }
  return bare(Dop853{}, system, start, request);
}

/// The run could not begin: the equations of motion have no value at the start.
void fail_at_start(Result& result, Outcome outcome, const Error& error) {
  result.outcome = outcome;
  result.message = std::string(name(outcome)) + " at the start: " + error.what();
}

}  // namespace

void Drift::see(double value) {
  final = value;
  const double change = std::abs(value - initial);
  if (!(change <= largest)) largest = change;  // NaN, once seen, stays
}

std::vector<std::string> method_names() { return {"adams", "bdf", "dop853"}; }

bool keeps_constraints(const std::string& method) { return method != "adams"; }

bool has_fixed_step(const std::string&) { return false; }

std::string misfit(const Model& model, const std::string& method) {
  return model.constrained() && !keeps_constraints(method) ? "cannot keep constraints" : "";
}

std::vector<std::string> fitting_methods(const Model& model) {
  std::vector<std::string> names = method_names();
  std::erase_if(names, [&](const std::string& name) { return !misfit(model, name).empty(); });
  return names;
}

BareResult bare_run(const std::shared_ptr<const Model>& model, const Request& request) {
  FirstOrderState start{request.start.t, model->packed(request.start)};
  if (model->constrained()) model->project(start.t, start.y);
  if (model->guard_count() > 0) return bare_named(SwitchingModel{{{model}}}, start, request);
  if (model->constrained()) return bare_named(ConstrainedModel{{model}}, start, request);
  return bare_named(FirstOrderModel{model}, start, request);
}

Result simulated(const std::shared_ptr<const Model>& model, const Request& request, const Watcher& watcher) {
  Result result;
  Eigen::VectorXd y = model->packed(request.start);
  if (model->constrained()) {
    try {
      result.start_moved = model->project(request.start.t, y);
    } catch (const ConstraintError& error) {
      result.end = {request.start.t, y, {}};
      fail_at_start(result, Outcome::constraint_failure, error);
      result.samples.push_back(result.end);
      return result;
    }
  }
  result.end = {request.start.t, y, model->energies(request.start.t, y)};
  result.energy.initial = result.energy.final = result.end.energies.total();
  result.jacobi.initial = result.jacobi.final = result.end.energies.jacobi;
  try {
    if (model->guard_count() > 0) {
      run_named(request.method, SwitchingModel{{{model}}}, request, watcher, result);
    } else if (model->constrained()) {
      run_named(request.method, ConstrainedModel{{model}}, request, watcher, result);
    } else {
      run_named(request.method, FirstOrderModel{model}, request, watcher, result);
    }
    result.reactions = model->reactions(result.end.t, result.end.y);
  } catch (const NonFinite& error) {
    fail_at_start(result, Outcome::non_finite, error);
  } catch (const MassMatrixError& error) {
    fail_at_start(result, Outcome::singular_mass_matrix, error);
  } catch (const ConstraintError& error) {
    fail_at_start(result, Outcome::constraint_failure, error);
  } catch (const RecoverableError& error) {
    fail_at_start(result, Outcome::refused_by_model, error);
  }
  if (result.samples.empty() || result.samples.back().t != result.end.t) result.samples.push_back(result.end);
  return result;
}

}  // namespace qdot::program
