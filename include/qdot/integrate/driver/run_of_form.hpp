#pragma once
// SPDX-License-Identifier: MIT
//
// A run of a first-order form: what simulate() does once types of observers and events are hidden.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "qdot/error.hpp"
#include "qdot/integrate/driver/run_request.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/watch/driven_form_of.hpp"
#include "qdot/mechanics/derive/any_energies.hpp"
#include "qdot/mechanics/equations/entries.hpp"
#include "qdot/mechanics/first_order_form.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot::detail {

/// The run of a form; make_stepper(form, options) makes a stepper of a copy of it.
///
/// @throws as simulate()
template <class Form, class MakeStepper>
Run<> run_of_form(const Form& form, const MakeStepper& make_stepper, const Eigen::VectorXd& start, const RunRequest& request) {
  require_valid(request.options, form.size());
  require_option(std::isfinite(request.t_end), "t_end", "must be finite", request.t_end, "choose a time to end at");
  const double* const y0 = start.data();
  if constexpr (requires { require_existing_entries(form.system(), y0, request.t0); }) {
    require_existing_entries(form.system(), y0, request.t0);
  } else if constexpr (requires { require_existing_entries(form.scene().system(), y0, request.t0); }) {
    require_existing_entries(form.scene().system(), y0, request.t0);
  }
  const Budget budget(request.options);  // begins before the stepper's own, which is made here
  const auto& driven = driven_form(form);
  Run<> run;
  request.drive(run, driven, make_stepper(form, request.options), request.options, budget, request.onlooker,
                kept(request.events), request.t0, start, request.t_end);
  return run;
}

// (form, options) → AnyStepper.
template <class Form>
auto stepper_by(const MethodOfRates& method) {
  return [&method](const Form& form, const Options& options) { return method.stepper(rates_of(form), std::string(method.name), options); };
}

// y of a start of n coordinates.
//
// @throws DimensionError  it has more numbers, or fewer
template <class = void>
Eigen::VectorXd packed_numbers(const StartNumbers& start, Eigen::Index n) {
  if (start.is_y) {
    require_components(start.size, 2 * n);
    return Eigen::Map<const Eigen::VectorXd>(start.q, start.size);
  }
  for (const auto& [what, size] : {std::pair("q", start.size), {"qdot", start.qdot_size}})
    if (size != n)
      throw DimensionError(what, static_cast<long>(n), static_cast<long>(size), "pass one entry for each coordinate of the system");
  Eigen::VectorXd y(2 * n);
  std::copy_n(start.qdot, n, std::copy_n(start.q, n, y.data()));
  return y;
}

// The run by a method of either kind.
template <class Method, int n, bool timed>
Run<n> run_by(const Method& method, AnyEnergies<n, timed> energies, const SystemParts& parts, const StartNumbers& start, const RunRequest& request) {
  using Sys = System<AnyEnergies<n, timed>, n>;
  return run_of<n>(run_of_form(form_by(Sys(std::move(energies), parts), request.options.by), stepper_by<FirstOrderForm<Sys>>(method),
                               packed_numbers(start, n), request));
}

}  // namespace qdot::detail
