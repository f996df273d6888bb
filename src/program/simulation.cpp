// SPDX-License-Identifier: MIT
//
// All scenes are stepped through the interface `Model`, whose virtual calls cost nothing beside a step, and all methods through AnyStepper.
#include "program/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <functional>
#include <memory>
#include <utility>

#include "program/first_order_model.hpp"
#include "program/methods.hpp"
#include "qdot/ad/formula/branches.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/cvode_automatic.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/steps/form_mechanics.hpp"
#include "qdot/integrate/steps/kept_branches.hpp"
#include "qdot/integrate/steps/recorded_motion.hpp"
#include "qdot/integrate/taylor.hpp"

namespace qdot::program {

std::shared_ptr<qdot::detail::RecordedMotion> Model::recorded_motion() const {
  qdot::formula::Recording recording;
  return recorded_on(recording);
}

/// The graph of a scene with effects, constraints among them, for Taylor.
static qdot::detail::RecordedMotion recorded_motion(const FirstOrderModel& system, qdot::formula::Recording recording = {}) {
  const auto recorded = system.model->recorded_on(recording);
  if (!recorded) throw NotAnalytic("the effects of this scene do not take the scalar that records a series; use dop853", "an effect");
  return std::move(*recorded);
}
static void run_again(qdot::detail::RecordedMotion& motion, const FirstOrderModel& system) { system.model->run_again(motion); }

}  // namespace qdot::program

namespace qdot::detail {

template <>
struct is_recordable<program::FirstOrderModel> : std::true_type {};
template <>
struct is_recordable<program::ConstrainedModel> : std::true_type {};
template <>
inline constexpr bool has_branches_recorded<program::FirstOrderModel> = true;
template <>
inline constexpr bool has_branches_recorded<program::ConstrainedModel> = true;

/// What a model tells of its mechanics, for Gauss and Taylor.
template <std::derived_from<program::FirstOrderModel> F>
struct Mechanics<F> {
  static constexpr int n = Dynamic, states = Dynamic, constraints = ProjectableSystem<F> ? Dynamic : 0;
  static constexpr Inertia inertia = Inertia::positive_definite;
  using Vec = Eigen::VectorXd;
  using States = Eigen::VectorXd;

  static Eigen::Index dof(const F& form) { return form.dof(); }
  static Vec momenta(const F& form, const Vec& q, const Vec& v, double t) { return form.model->momenta(t, q, v); }
  static Eigen::MatrixXd inverse_mass(const F& form, const Vec& q, const Vec& v, double t) { return form.model->inverse_mass(t, q, v); }
  static Vec force(const F& form, const Vec& q, const Vec& v, const States& z, double t) { return form.model->force(t, joined(q, v, z)); }
  static States zdot(const F& form, const Vec& q, const Vec& v, const States& z, double t) {
    return form.model->state_rates(t, joined(q, v, z));
  }
  static States zddot(const F& form, const Vec& q, const Vec& v, const Vec& a, const States& z, const States& w, double t) {
    return form.model->state_accelerations(t, joined(q, v, z), joined(v, a, w));
  }

 private:
  static Eigen::VectorXd joined(const Vec& q, const Vec& v, const States& z) {
    Eigen::VectorXd y(q.size() + v.size() + z.size());
    y << q, v, z;
    return y;
  }
};

}  // namespace qdot::detail

namespace qdot::program {
namespace {

/// A method chosen by its name, for a model.
struct NamedMethod {
  const MethodInfo& info;
  double step = 0;

  template <class System>
  AnyStepper stepper(const System& system, const Options& options) const {
    const Model& model = *system.model;
    switch (info.kind) {
      case MethodKind::automatic: return automatic(system, options);
      case MethodKind::stiff: return any_stepper(CvodeBdf{}, system, options);
      case MethodKind::multistep:
        if constexpr (!ProjectableSystem<System>) return any_stepper(CvodeAdams{}, system, options);
        break;
      default:
        if (auto own = model.own_stepper(info.name, step, options)) return std::move(*own);
    }
    if (info.name == "dop853") return any_stepper(Dop853{}, system, options);
    if (info.name == "dopri5") return any_stepper(Dopri5{}, system, options);
    if (info.kind == MethodKind::gauss) return any_stepper(Gauss{.step = step, .stages = info.order / 2}, system, options);
    if constexpr (!SwitchingSystem<System>)
      if (info.kind == MethodKind::series) return any_stepper(Taylor{}, system, options);
    throw InvalidValue(info.name + " does not fit: it " + misfit(model, info.name));
  }

 private:
  // As AutomaticWith<CvodeBdf>, with the steppers that only the scene can make.
  template <class System>
  AnyStepper automatic(const System& system, const Options& options) const {
    const std::shared_ptr<const Model> model = system.model;
    AutomaticChoice choice{
        .series = std::nullopt,
        .smooth = NamedMethod{method_named("dop853")}.stepper(system, options),
        .stiff = [system, options] { return any_stepper(CvodeBdf{}, system, options); },
        .jacobian = [model](double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::MatrixXd> J) { model->jacobian(t, y, J); },
        .derivative = [model](double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) { model->derivative(t, y, ydot); },
        .reason = SwitchingSystem<System> ? "equations that switch have no power series" : "there is more to the motion than formulas"};
    if (model->bare())
      qdot::detail::choose_first(choice, model->size(), options, "T and V", [&] { return model->own_stepper("taylor", 0, options); });
    if constexpr (!SwitchingSystem<System>)
      if (!model->bare())
        qdot::detail::choose_first(choice, model->size(), options, ProjectableSystem<System> ? "T, V, the forces and the constraints" : "T, V and the forces",
                                   [&] { return any_stepper(Taylor{}, system, options); });
    return AnyStepper(std::in_place, AutomaticStepper(std::move(choice), model->size()));
  }
};

/// The method that a request names.
NamedMethod method_of(const std::shared_ptr<const Model>& model, const Request& request) {
  const MethodInfo& info = method_named(request.method);
  if (const std::string why = misfit(*model, info.name, request.start); !why.empty()) throw InvalidValue(info.name + " " + why);
  if (!info.fixed_step()) return {info};
  return {info, request.step ? *request.step : chosen_step(model, request, info.order)};
}

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

/// What an EnergyMeter integrates; nothing of T and V alone that know no time.
struct PowerOf {
  const Model& model;

  double operator()(double t, const Eigen::Ref<const Eigen::VectorXd>& y) const { return model.energy_rate(t, y); }
  bool is_zero() const { return model.bare() && model.autonomous(); }
};

template <class Method, class System>
void run_with(const Method& method, const System& system, const Request& request, const Watcher& watcher,
              Result& result) {
  const Model& model = *system.model;
  const FirstOrderState start{request.start.t, result.end.y};
  const std::vector<double> sample_times = equal_times(start.t, request.t_end, request.samples);
  std::vector<double> frame_times;
  if (request.most_frames > 1) frame_times = equal_times(start.t, request.t_end, request.most_frames);

  Options options{.rtol = request.rtol, .atol = atol_of(request), .keep_trajectory = false};
  std::merge(sample_times.begin(), sample_times.end(), frame_times.begin(), frame_times.end(),
             std::back_inserter(options.output_times));
  if (request.atol_each.size() > 0) options.atol = request.atol_each;

  result.sizes = start.y.cwiseAbs();
  StepRecord record(result);
  record.see(start.t, 0, 0);
  EnergyMeter meter([&](double t, const Eigen::Ref<const Eigen::VectorXd>& y) { return model.energies(t, y).jacobi; }, PowerOf{model});
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

template <class Method, class System, class O>
BareResult bare(const Method& method, const System& system, const FirstOrderState& start, const Request& request, const O& observer) {
  Options options{.rtol = request.rtol, .atol = atol_of(request), .keep_trajectory = false};
  if (request.atol_each.size() > 0) options.atol = request.atol_each;
  if (request.samples > 1) options.output_times = equal_times(start.t, request.t_end, request.samples);
  auto run = simulate(system, start, request.t_end, method, options, observer);
  return {run.outcome, run.message, run.t, run.y, std::move(run.samples.t), std::move(run.samples.y), std::move(run.events), run.statistics};
}

/// Calls `go` with the model as the steppers want it.
template <class Go>
auto with_system(const std::shared_ptr<const Model>& model, const Go& go) {
  if (model->guard_count() > 0) return go(SwitchingModel{{{model}}});
  if (model->is_constrained()) return go(ConstrainedModel{{model}});
  return go(FirstOrderModel{model});
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

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const MethodInfo& method : methods()) names.push_back(method.name);
  return names;
}

// A pilot run of Dop853 at rtol 1e-6 tells how fast the motion is: its steps have the mean length h. An error of about (h/L)^8
// per step makes L = h/1e-6^(1/8) the time in which the motion changes. A method of order p reaches rtol with steps of L
// rtol^(1/p), as far as that needs no more than two million of them.
double chosen_step(const std::shared_ptr<const Model>& model, const Request& request, int order) {
  constexpr double pilot_rtol = 1e-6;
  constexpr double most_steps = 2e6;
  const double span = std::abs(request.t_end - request.start.t);
  Request pilot = request;
  pilot.method = "dop853";
  pilot.rtol = pilot.atol = pilot_rtol;
  pilot.atol_each = {};
  pilot.samples = 0;
  const BareResult run = bare_run(model, pilot);
  const double mean = std::abs(run.t - request.start.t) / static_cast<double>(std::max(1L, run.statistics.steps));
  const double wanted = mean * std::pow(pilot_rtol, -1.0 / 8) * std::pow(request.rtol, 1.0 / order);
  return std::max(std::min(wanted, span), span / most_steps);
}

bool has_fixed_step(const std::string& method) { return method_named(method).fixed_step(); }

std::string misfit(const Model& model, const std::string& method) {
  constexpr Eigen::Index most_dense = 2000;  // coordinates, for a matrix of which a step takes seconds
  const MethodKind kind = method_named(method).kind;
  if (model.is_constrained() && kind == MethodKind::multistep) return "cannot keep constraints";
  if (model.guard_count() > 0 && kind == MethodKind::series) return "takes no contacts or dry friction";
  if (kind == MethodKind::rattle && !model.fits_rattle()) return "needs T(qdot), V(q) and holonomic constraints, and no forces";
  if (kind == MethodKind::splitting && model.is_constrained()) return "takes T and V alone, and the scene has constraints";
  if (kind == MethodKind::splitting && !model.bare()) return "takes T and V alone, and the scene has effects";
  if (kind == MethodKind::splitting && !model.separable()) return "needs T(qdot), and the scene's T depends on the coordinates";
  if (kind == MethodKind::series || kind == MethodKind::gauss || kind == MethodKind::rattle) {
    if (const Eigen::Index n = model.dof(); n > most_dense) return "solves with dense matrices, and the scene has " + std::to_string(n) + " coordinates";
  }
  return {};
}

std::string formula_misfit(const Model& model) {
  try {
    return model.recorded_motion() ? "" : "needs effects that take every scalar";
  } catch (const NotAnalytic& error) {
    return "needs formulas without branches and kinks, and " + error.source() + " has one";
  }
}

std::string misfit(const Model& model, const std::string& method, const State<Dynamic>& start) {
  if (const std::string why = misfit(model, method); !why.empty() || method_named(method).kind != MethodKind::series) return why;
  if (formula_misfit(model).empty()) return {};
  const Eigen::VectorXd y = model.packed(start);
  qdot::formula::Branches branches;
  qdot::detail::number_variables(model.dof(), start.t, y, branches.variables);
  qdot::formula::Recording recording;
  recording.branches = &branches;
  try {
    const auto recorded = model.recorded_on(recording);
    if (!recorded) return "needs effects that take every scalar";
    qdot::detail::require_series(branches, *recorded);
  } catch (const NotAnalytic& error) {
    return "takes functors that branch, but no plain numbers of them and no constraints that do, and " + error.source() + " is like that";
  }
  return {};
}

std::vector<std::string> fitting_methods(const Model& model, const State<Dynamic>& start) {
  std::vector<std::string> names;
  for (const MethodInfo& method : methods())
    if (method.kind != MethodKind::automatic && misfit(model, method.name, start).empty()) names.push_back(method.name);
  return names;
}

template <class O>
static BareResult bare_run_with(const std::shared_ptr<const Model>& model, const Request& request, const O& observer) {
  FirstOrderState start{request.start.t, model->packed(request.start)};
  if (model->is_constrained()) model->project(start.t, start.y);
  const NamedMethod method = method_of(model, request);
  return with_system(model, [&](const auto& system) { return bare(method, system, start, request, observer); });
}

BareResult bare_run(const std::shared_ptr<const Model>& model, const Request& request) { return bare_run_with(model, request, NoObserver{}); }

BareResult followed_run(const std::shared_ptr<const Model>& model, const Request& request, const std::function<bool(const StepView&)>& observer) {
  return bare_run_with(model, request, observer);
}

Result simulated(const std::shared_ptr<const Model>& model, const Request& request, const Watcher& watcher) {
  Result result;
  Eigen::VectorXd y = model->packed(request.start);
  if (model->is_constrained()) {
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
    const NamedMethod method = method_of(model, request);
    if (method.info.fixed_step()) result.step = method.step;
    with_system(model, [&](const auto& system) { run_with(method, system, request, watcher, result); });
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
