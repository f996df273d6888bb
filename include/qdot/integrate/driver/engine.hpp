#pragma once
// SPDX-License-Identifier: MIT
//
// What a simulator (integrate/simulator.hpp) asks of a system with a method, and how a first-order form answers.

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "qdot/effects/input.hpp"
#include "qdot/effects/interpolated_input.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/driver/drive.hpp"
#include "qdot/integrate/driver/run_of_energies.hpp"
#include "qdot/integrate/driver/run_of_form.hpp"
#include "qdot/integrate/driver/run_request.hpp"
#include "qdot/integrate/watch/driven_form_of.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot::detail {

/// A motion that is advanced in stretches.
struct Engine {
  double t = 0.0;
  Eigen::VectorXd y;
  std::uint64_t stopped_by = 0;  // events that ended the last stretch, bit by bit
  Eigen::Index dof = 0;
  std::vector<std::string> components, input_names;
  std::vector<Eigen::Index> input_places;
  std::vector<Eigen::Index> input_strides;  // from u to s, u_end and t_end where an input is interpolated, else 0

  virtual ~Engine() = default;
  virtual Outcome stretch(double t_end) = 0;  // may throw what the user's functors throw
  virtual const std::string& message() const = 0;
  virtual const std::vector<RecordedEvent>& events() const = 0;
  virtual const Statistics& statistics() const = 0;
};

template <int n, bool watches, class... Events>
EngineRequest engine_request(const Options& options, const EventList<Events...>& events) {
  const auto own = std::make_shared<const EventList<Events...>>(events);
  return {options, stretched_run<watches>, own, kept(listed_events<n>(*own))};
}

template <class Form>
class EngineOf final : public Engine {
 public:
  /// @param make_stepper  (form, options) → AnyStepper
  template <class MakeStepper>
  EngineOf(Form form, const MakeStepper& make_stepper, double t0, const Eigen::VectorXd& y0, const EngineRequest& request)
      : form_(std::move(form)), options_(checked(request.options, form_.size())), events_(request.events), driven_(driven_form(form_)),
        driver_(request.stretched_run(run_, driven_, make_stepper(std::as_const(form_), unlimited(options_)), options_, Budget(options_), request.listed)) {
    t = t0;
    y = y0;
    dof = qdot::detail::dof(form_);
    for (Eigen::Index i = 0; i < form_.size(); ++i) components.push_back(form_.component_name(i));
    if constexpr (requires { form_.scene().effects(); })
      for_each_place(form_.scene(), [&]<class E>(const E& effect, Eigen::Index place) {
        if constexpr (requires { E::is_input; }) {
          for (int i = 0; i < states_of<E>(); ++i) add_input(input_name(effect, i), place + i, 0);
        } else if constexpr (requires { E::interpolated_inputs; }) {
          for (int i = 0; i < E::interpolated_inputs; ++i) add_input(input_name(effect.input, i), place + i, E::interpolated_inputs);
        }
      });
    driver_->stretch(t, y, t, 0);  // what is wrong with the start is said here
    if (!run_.completed()) throw InvalidValue("a simulator cannot begin here: " + message());
    arrive();
  }

  Outcome stretch(double t_end) override {
    try {
      driver_->stretch(t, y, t_end, stopped_by);
    } catch (...) {  // the user's own: what was reached before it is good
      arrive();
      throw;
    }
    arrive();
    return run_.outcome;
  }
  const std::string& message() const override { return run_.message; }
  const std::vector<RecordedEvent>& events() const override { return run_.events; }
  const Statistics& statistics() const override { return driver_->statistics(); }

 private:
  void add_input(const std::string& name, Eigen::Index place, Eigen::Index stride) {
    input_places.push_back(place);
    input_strides.push_back(stride);
    input_names.push_back(components[static_cast<std::size_t>(place)] = name);
    if (stride == 0) return;
    const char* const more[] = {" slope", " end", " end time"};
    for (int k = 1; k <= 3; ++k) components[static_cast<std::size_t>(place + k * stride)] = name + more[k - 1];
  }
  void arrive() {
    t = run_.t;
    y = run_.y;
    stopped_by = driver_->stopped_by();
  }
  static Options checked(Options options, Eigen::Index size) {
    require_valid(options, size);
    if (!options.stop_times.empty() || !options.output_times.empty())
      throw InvalidValue("a simulator keeps no samples and has no times of its own to land on; leave output_times and stop_times out and advance to them");
    options.keep_trajectory = false;
    return options;
  }
  // A stepper counts what it spends over its life, a simulator in each advance.
  static Options unlimited(Options options) {
    options.max_evaluations = std::numeric_limits<long>::max();
    options.max_wall_seconds = std::numeric_limits<double>::infinity();
    return options;
  }

  Form form_;
  Options options_;
  std::shared_ptr<const void> events_;  // kept for those that are listed
  decltype(driven_form(std::declval<const Form&>())) driven_;
  Run<> run_;
  std::unique_ptr<StretchedRun> driver_;
};

// The engine by a method of either kind.
template <class Method, int n, bool timed>
std::unique_ptr<Engine> engine_by(const Method& method, AnyEnergies<n, timed> energies, const SystemParts& parts, double t0, const StartNumbers& start,
                                  const EngineRequest& request) {
  using Form = FirstOrderForm<System<AnyEnergies<n, timed>, n>>;
  return std::make_unique<EngineOf<Form>>(form_by(System<AnyEnergies<n, timed>, n>(std::move(energies), parts), request.options.by),
                                          stepper_by<Form>(method), t0, packed_numbers(start, n), request);
}
template <int n, bool timed>
std::unique_ptr<Engine> RunOfEnergies<n, timed>::engine(const MethodOfRates& method, AnyEnergies<n, timed> energies, const SystemParts& parts, double t0,
                                                        const StartNumbers& start, const EngineRequest& request) {
  return engine_by(method, std::move(energies), parts, t0, start, request);
}

}  // namespace qdot::detail
