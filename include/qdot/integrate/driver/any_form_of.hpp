#pragma once
// SPDX-License-Identifier: MIT
//
// AnyForm (integrate/watch/any_form.hpp) of a form, and runs of small systems by methods that ask for it.

#include <memory>
#include <utility>

#include "qdot/integrate/driver/engine.hpp"
#include "qdot/integrate/driver/run_of_form.hpp"
#include "qdot/integrate/driver/run_request.hpp"
#include "qdot/integrate/watch/any_form.hpp"
#include "qdot/integrate/steps/taylor_equations.hpp"
#include "qdot/integrate/watch/driven_form_of.hpp"

namespace qdot::detail {

template <class Form>
class AnyFormOf final : public AnyForm {
 public:
  explicit AnyFormOf(const Form& form) : form_(form) {}

  std::unique_ptr<Rates> rates() const override { return rates_of(form_); }
  std::unique_ptr<MethodForm> method_form() const override { return std::make_unique<MethodFormOf<MethodForm, Form>>(form_); }
  std::shared_ptr<const MotionSource> motion_source() const override { return std::make_shared<MotionSourceOf<Form>>(form_); }

 private:
  Form form_;
};

template <class Form>
auto stepper_by(const MethodOfForm& method) {
  return [&method](const Form& form, const Options& options) { return method.stepper(method.settings, std::make_shared<AnyFormOf<Form>>(form), options); };
}

template <int n, bool timed>
Run<n> RunOfEnergies<n, timed>::by(const MethodOfForm& method, AnyEnergies<n, timed> energies, const SystemParts& parts, const StartNumbers& start,
                                   const RunRequest& request) {
  return run_by(method, std::move(energies), parts, start, request);
}

template <int n, bool timed>
std::unique_ptr<Engine> RunOfEnergies<n, timed>::engine(const MethodOfForm& method, AnyEnergies<n, timed> energies, const SystemParts& parts, double t0,
                                                        const StartNumbers& start, const EngineRequest& request) {
  return engine_by(method, std::move(energies), parts, t0, start, request);
}

}  // namespace qdot::detail
