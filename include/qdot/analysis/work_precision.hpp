#pragma once
// SPDX-License-Identifier: MIT
//
// What accuracy costs: error against time, over methods and their tolerances, as in a work-precision diagram.
//
//     const auto study = work_precision(system, start, 10.0, {}, by_tolerance("dop853", Dop853{}), by_tolerance("taylor", Taylor{}),
//                                       by_step("gauss6", [](double h) { return Gauss{.step = h, .stages = 3}; }));
//     study.cheapest(1e-9)->method        the method, at study.cheapest(1e-9)->setting, that is done first with nine digits
//
// A tolerance is a wish about one step. The error at the end depends on the method and on the motion, by factors between 1e-3 and
// 1e6. So neither the cost nor the accuracy of a method follows from its tolerance. Here every method runs with a row of
// tolerances (or steps, where they are fixed), and each run is compared with a reference (reference.hpp). The result is the table
// from which a method is chosen: the error that is needed, and the cheapest way there. What is measured, and how, stands in
// work_precision_study.hpp.

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "qdot/analysis/work_precision_study.hpp"
#include "qdot/analysis/reference.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/mechanics/energy.hpp"

namespace qdot {

/// A method with its name, to be measured at a row of tolerances.
template <class Method>
auto by_tolerance(std::string name, Method method) {
  return std::pair(std::pair(std::move(name), false), [method = std::move(method)](double) { return method; });
}

/// A function from the length of a step to a method, to be measured at a row of steps.
template <class MakeMethod>
auto by_step(std::string name, MakeMethod make) {
  return std::pair(std::pair(std::move(name), true), std::move(make));
}

namespace detail {

template <class System, class Start, class Named>
Contender contender(const System& system, const Start& start, double t_end, const WorkPrecisionOptions& limits, const EnergyFunctions& energies,
                    const Named& named) {
  using Form = std::remove_cvref_t<decltype(first_order_form(system))>;
  const auto form = std::make_shared<const Form>(first_order_form(system));
  const Eigen::VectorXd y0 = packed(*form, start);
  const auto& [name, fixed_step] = named.first;
  const auto make = named.second;
  const auto options_for = [fixed = fixed_step, longest = limits.longest_run](double setting) {
    Options options{.keep_trajectory = false};
    if (!fixed) options.rtol = setting;
    if (!fixed) options.atol = setting;
    options.max_wall_seconds = 4 * longest;
    return options;
  };
  const auto counts_of = [](const Statistics& s) { return RunCounts{s.steps, s.rejected(), s.evaluations, s.jacobians}; };
  Contender result;
  result.name = name;
  result.fixed_step = fixed_step;
  result.observed = [=, outputs = limits.outputs, h = energies.jacobi](double setting) {
    Options options = options_for(setting);
    options.output_times = output_times(start.t, t_end, outputs);
    ObservedRun seen;
    const double initial = h ? h(start.t, y0) : 0.0;
    long step = 0, every = 1;
    const auto observer = [&](const StepView& view) {
      if (!h || step++ % every != 0) return;
      seen.energy_times.push_back(view.t());
      seen.energy_change.push_back(h(view.t(), view.y()) - initial);
      if (seen.energy_times.size() % 2000 == 0) every *= 2;
    };
    const auto run = simulate(*form, FirstOrderState{start.t, y0}, t_end, make(setting), options, observer);
    seen.outcome = run.outcome;
    seen.message = run.message;
    seen.t = run.t;
    seen.states = run.samples.y;
    static_cast<RunCounts&>(seen) = counts_of(run.statistics);
    if constexpr (ProjectableSystem<Form>) seen.constraint_residual = run.statistics.constraint_residual;
    return seen;
  };
  result.ready_to_run = [=](double setting) -> std::function<RunCounts()> {
    if constexpr (ProjectableSystem<Form> || SwitchingSystem<Form>) {  // the driver projects and switches
      return [=] { return counts_of(simulate(*form, FirstOrderState{start.t, y0}, t_end, make(setting), options_for(setting)).statistics); };
    } else {
      const auto method = make(setting);
      using S = decltype(method.stepper(*form, options_for(setting)));
      const auto stepper = std::make_shared<S>(method.stepper(*form, options_for(setting)));
      return [=] {
        const RunCounts before = counts_of(stepper->statistics());
        stepper->reset(start.t, y0);
        while (stepper->t() != t_end && stepper->step(t_end)) {
        }
        const RunCounts after = counts_of(stepper->statistics());
        return RunCounts{after.steps - before.steps, after.rejected - before.rejected, after.evaluations - before.evaluations,
                         after.jacobians - before.jacobians};
      };
    }
  };
  return result;
}

}  // namespace detail

/// Computes a reference of the motion and runs the methods against it.
///
/// @param system   a mechanical system, or a scene without constraints
/// @param start    State{t, q, qdot}
/// @param methods  by_tolerance(name, method) and by_step(name, step → method), as many as there are to compare
/// @throws as reference_motion() and simulate()
template <class System, class Start, class... Methods>
WorkPrecision work_precision(const System& system, const Start& start, double t_end, const WorkPrecisionOptions& options,
                             const Methods&... methods) {
  if (options.outputs < 1)
    throw InvalidValue("the number of outputs must be at least 1, but is " + std::to_string(options.outputs));
  EnergyFunctions energies;
  if constexpr (detail::is_system<System>::value) {
    const auto form = first_order_form(system);
    energies.jacobi = [form](double t, const Eigen::VectorXd& y) { return jacobi_energy(form.system(), form.state(t, y)); };
    energies.kinetic = [form](double t, const Eigen::VectorXd& y) {
      const auto state = form.state(t, y);
      return kinetic_energy(form.system(), state.q, state.qdot, t);
    };
  }
  return work_precision(reference_motion(system, start, output_times(start.t, t_end, options.outputs), options.reference), start.t,
                        {detail::contender(system, start, t_end, options, energies, methods)...}, energies, options);
}

// Old names, accepted until 0.4.

/// work_precision() by its old name.
template <class System, class Start, class... Methods>
[[deprecated("qdot: say work_precision()")]]
WorkPrecision accuracy_study(const System& system, const Start& start, double t_end, const WorkPrecisionOptions& options,
                             const Methods&... methods) {
  return work_precision(system, start, t_end, options, methods...);
}

}  // namespace qdot
