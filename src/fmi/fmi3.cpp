// SPDX-License-Identifier: MIT
//
// The C functions of FMI 3.0 (fmi3.hpp) on instances (instance.hpp): here it is checked which of them may be called when, and with what. Those that are not
// offered are in lacking.cpp.
#include "fmi/fmi3.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "fmi/answer.hpp"

namespace {

using namespace qdot::fmi;

fmi3Instance instantiated(Interface interface, fmi3String name, fmi3String token, bool logging_on, bool event_mode_used, bool early_return_allowed,
                          std::size_t intermediate_count, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) noexcept {
  const auto refuse = [&](const std::string& message) -> fmi3Instance {
    if (log != nullptr) log(environment, fmi3Error, log_categories[0].name, message.c_str());
    return nullptr;
  };
  try {
    try {
      if (name == nullptr || std::string(name).find_first_not_of(" \t\r\n") == std::string::npos)
        return refuse("an instance must have a name that is not blank");
      const Library& shared = library();
      if (token == nullptr || token != shared.description.token)
        return refuse("the instantiation token must be " + shared.description.token + ", but is " + (token == nullptr ? "missing" : token) +
                      ": modelDescription.xml belongs to another library");
      if (intermediate_count > 0) return refuse("intermediate variables were asked for, but steps are not interrupted for them; take shorter steps");
      return new Handle{Instance(shared.variables, interface, event_mode_used, early_return_allowed), name, environment, log,
                        std::vector<bool>(log_categories.size(), logging_on)};
    } catch (const std::exception& error) {
      return refuse(error.what());
    }
  } catch (...) {
    return nullptr;
  }
}

}  // namespace

extern "C" {

// --- Instances and their modes ---------------------------------------------------------------------------------------

const char* fmi3GetVersion() { return "3.0"; }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t category_count, const fmi3String categories[]) {
  return answer(instance, "fmi3SetDebugLogging", [&](Handle& handle) {
    std::vector<bool> logged = handle.logged;
    if (category_count == 0) logged.assign(logged.size(), on);
    for (const fmi3String category : list(categories, category_count, "the categories")) {
      require_pointer(category, "a category");
      const std::size_t place = log_category(category);
      if (place == logged.size()) forbid(std::string("a log category must be one of modelDescription.xml, but '") + category + "' is not");
      logged[place] = on;
    }
    handle.logged = logged;
  });
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String, fmi3Boolean, fmi3Boolean logging_on,
                                          fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
  return instantiated(Interface::model_exchange, name, token, logging_on, true, false, 0, environment, log);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String, fmi3Boolean, fmi3Boolean logging_on, fmi3Boolean event_mode_used,
                                         fmi3Boolean early_return_allowed, const fmi3ValueReference*, size_t intermediate_count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback) {
  return instantiated(Interface::co_simulation, name, token, logging_on, event_mode_used, early_return_allowed, intermediate_count, environment, log);
}

void fmi3FreeInstance(fmi3Instance instance) { delete static_cast<Handle*>(instance); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean tolerance_defined, fmi3Float64 tolerance, fmi3Float64 start_time,
                                       fmi3Boolean stop_time_defined, fmi3Float64 stop_time) {
  return answer(instance, "fmi3EnterInitializationMode", [&](Handle& handle) {
    require_mode(handle, {Mode::instantiated});
    handle.instance.enter_initialization(tolerance_defined ? &tolerance : nullptr, start_time, stop_time_defined ? &stop_time : nullptr);
  });
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
  return answer(instance, "fmi3ExitInitializationMode", [&](Handle& handle) {
    require_mode(handle, {Mode::initialization});
    handle.instance.exit_initialization();
  });
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
  return answer(instance, "fmi3EnterEventMode", [&](Handle& handle) {
    require_mode(handle, {Mode::continuous_time, Mode::step});
    if (!handle.instance.has_event_mode()) forbid("the instance was made without event mode (eventModeUsed)");
    handle.instance.enter(Mode::event);
  });
}

fmi3Status fmi3Terminate(fmi3Instance instance) {
  return answer(instance, "fmi3Terminate", [&](Handle& handle) {
    require_mode(handle, {Mode::event, Mode::continuous_time, Mode::step});
    handle.instance.end();
  });
}

fmi3Status fmi3Reset(fmi3Instance instance) {
  return answer(instance, "fmi3Reset", [&](Handle& handle) { handle.instance.reset(); });
}

}  // extern "C"

// --- Values of variables ---------------------------------------------------------------------------------------------

namespace {

const char* name_of(Type type) { return type == Type::float64 ? "Float64" : type == Type::int32 ? "Int32" : "Boolean"; }

void require_types(const Handle& handle, std::span<const fmi3ValueReference> references, Type type) {
  const auto& all = handle.instance.variables().all;
  for (const fmi3ValueReference r : references)
    if (r < all.size() && all[r].type() != type) forbid("'" + all[r].name + "' is of type " + name_of(all[r].type()) + ", not " + name_of(type));
}

template <class T>
fmi3Status get(fmi3Instance instance, const char* function, Type type, const fmi3ValueReference* references, std::size_t count, T* values,
               std::size_t value_count) noexcept {
  return answer(instance, function, [&](Handle& handle) {
    require_count("values, as many as references,", count, value_count);
    const auto places = list(references, count, "the references");
    const auto out = list(values, count, "the values");
    require_types(handle, places, type);
    std::vector<T> found;
    for (const fmi3ValueReference r : places) found.push_back(static_cast<T>(handle.instance.value(r)));
    std::copy(found.begin(), found.end(), out.begin());
  });
}

template <class T>
fmi3Status set(fmi3Instance instance, const char* function, Type type, const fmi3ValueReference* references, std::size_t count, const T* values,
               std::size_t value_count) noexcept {
  return answer(instance, function, [&](Handle& handle) {
    require_mode(handle, {Mode::instantiated, Mode::initialization, Mode::event, Mode::continuous_time, Mode::step});
    require_count("values, as many as references,", count, value_count);
    const auto places = list(references, count, "the references");
    const auto given = list(values, count, "the values");
    require_types(handle, places, type);
    handle.instance.set(places, std::vector<double>(given.begin(), given.end()));
  });
}

}  // namespace

extern "C" {

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Float64 values[], size_t value_count) {
  return get(instance, "fmi3GetFloat64", Type::float64, references, count, values, value_count);
}
fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Int32 values[], size_t value_count) {
  return get(instance, "fmi3GetInt32", Type::int32, references, count, values, value_count);
}
fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference references[], size_t count, fmi3Boolean values[], size_t value_count) {
  return get(instance, "fmi3GetBoolean", Type::boolean, references, count, values, value_count);
}
fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Float64 values[], size_t value_count) {
  return set(instance, "fmi3SetFloat64", Type::float64, references, count, values, value_count);
}
fmi3Status fmi3SetInt32(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Int32 values[], size_t value_count) {
  return set(instance, "fmi3SetInt32", Type::int32, references, count, values, value_count);
}
fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Boolean values[], size_t value_count) {
  return set(instance, "fmi3SetBoolean", Type::boolean, references, count, values, value_count);
}

// --- The whole state, and derivatives --------------------------------------------------------------------------------

}  // extern "C"

namespace {

/// What stands behind fmi3FMUState; it belongs to no instance.
struct SavedState {
  Interface interface;
  Snapshot snapshot;
};

const SavedState& saved(const Handle& handle, fmi3FMUState state) {
  require_pointer(state, "the state");
  const SavedState& found = *static_cast<const SavedState*>(state);
  if (found.interface != handle.instance.interface())
    forbid("a state must be of the instance's own interface, but one is of Model Exchange and the other of Co-Simulation");
  return found;
}

// Writes anew into a state that is there, or makes one.
void store(fmi3FMUState* state, SavedState value) {
  if (*state != nullptr)
    *static_cast<SavedState*>(*state) = std::move(value);
  else
    *state = new SavedState(std::move(value));
}

std::span<const double> finite(std::span<const double> seeds) {
  for (const double seed : seeds)
    if (!std::isfinite(seed)) discard("seeds must be finite, but one is " + std::to_string(seed));
  return seeds;
}

Eigen::MatrixXd derivatives(Handle& handle, const fmi3ValueReference* unknowns, std::size_t unknown_count, const fmi3ValueReference* knowns,
                            std::size_t known_count) {
  require_mode(handle, initialized);
  return handle.instance.derivatives(list(unknowns, unknown_count, "the unknowns"), list(knowns, known_count, "the knowns"));
}

void write_product(const Eigen::MatrixXd& J, std::span<const double> in, std::span<double> out) {
  for (Eigen::Index i = 0; i < J.rows(); ++i) {
    double sum = 0.0;
    for (Eigen::Index j = 0; j < J.cols(); ++j) sum += J(i, j) * in[static_cast<std::size_t>(j)];
    out[static_cast<std::size_t>(i)] = sum;
  }
}

}  // namespace

extern "C" {

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState* state) {
  return answer(instance, "fmi3GetFMUState", [&](Handle& handle) {
    require_pointer(state, "where the state goes");
    store(state, {handle.instance.interface(), handle.instance.snapshot()});
  });
}
fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
  return answer(instance, "fmi3SetFMUState", [&](Handle& handle) { handle.instance.restore(saved(handle, state).snapshot); });
}
fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState* state) {
  return answer(instance, "fmi3FreeFMUState", [&](Handle&) {
    if (state == nullptr) return;
    delete static_cast<SavedState*>(*state);
    *state = nullptr;
  });
}
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t* size) {
  return answer(instance, "fmi3SerializedFMUStateSize", [&](Handle& handle) {
    require_pointer(size, "where the size goes");
    *size = serialized(saved(handle, state).snapshot, library().owner(handle.instance.interface())).size();
  });
}
fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
  return answer(instance, "fmi3SerializeFMUState", [&](Handle& handle) {
    const std::vector<fmi3Byte> all = serialized(saved(handle, state).snapshot, library().owner(handle.instance.interface()));
    require_count("bytes, as fmi3SerializedFMUStateSize says,", all.size(), size);
    require_pointer(bytes, "where the bytes go");
    std::copy(all.begin(), all.end(), bytes);
  });
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState* state) {
  return answer(instance, "fmi3DeserializeFMUState", [&](Handle& handle) {
    require_pointer(state, "where the state goes");
    const Interface interface = handle.instance.interface();
    store(state, {interface, deserialized(list(bytes, size, "the bytes"), library().owner(interface), handle.instance.variables())});
  });
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t unknown_count,
                                        const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seed[], size_t seed_count,
                                        fmi3Float64 sensitivity[], size_t sensitivity_count) {
  return answer(instance, "fmi3GetDirectionalDerivative", [&](Handle& handle) {
    require_count("seeds, as many as knowns,", known_count, seed_count);
    require_count("sensitivities, as many as unknowns,", unknown_count, sensitivity_count);
    const auto in = finite(list(seed, seed_count, "the seeds"));
    const auto out = list(sensitivity, sensitivity_count, "the sensitivities");
    write_product(derivatives(handle, unknowns, unknown_count, knowns, known_count), in, out);
  });
}
fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t unknown_count, const fmi3ValueReference knowns[],
                                    size_t known_count, const fmi3Float64 seed[], size_t seed_count, fmi3Float64 sensitivity[], size_t sensitivity_count) {
  return answer(instance, "fmi3GetAdjointDerivative", [&](Handle& handle) {
    require_count("seeds, as many as unknowns,", unknown_count, seed_count);
    require_count("sensitivities, as many as knowns,", known_count, sensitivity_count);
    const auto in = finite(list(seed, seed_count, "the seeds"));
    const auto out = list(sensitivity, sensitivity_count, "the sensitivities");
    write_product(derivatives(handle, unknowns, unknown_count, knowns, known_count).transpose(), in, out);
  });
}

// --- Events, and clocks, of which there are none ---------------------------------------------------------------------

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean* need_update, fmi3Boolean* terminate, fmi3Boolean* nominals_changed,
                                    fmi3Boolean* values_changed, fmi3Boolean* next_time_defined, fmi3Float64* next_time) {
  return answer(instance, "fmi3UpdateDiscreteStates", [&](Handle& handle) {
    require_mode(handle, {Mode::event});
    for (const void* pointer : std::initializer_list<const void*>{need_update, terminate, nominals_changed, values_changed, next_time_defined, next_time})
      require_pointer(pointer, "where an answer goes");
    const Instance::Update update = handle.instance.update();
    *need_update = *nominals_changed = *next_time_defined = false;
    *next_time = 0.0;
    *terminate = update.terminate;
    *values_changed = update.states_changed;
  });
}

// --- Model Exchange --------------------------------------------------------------------------------------------------

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance) {
  return answer(instance, "fmi3EnterContinuousTimeMode", [&](Handle& handle) {
    require_interface(handle, Interface::model_exchange);
    require_mode(handle, {Mode::event});
    handle.instance.enter(Mode::continuous_time);
  });
}
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean, fmi3Boolean* enter_event_mode, fmi3Boolean* terminate) {
  return answer(instance, "fmi3CompletedIntegratorStep", [&](Handle& handle) {
    require_interface(handle, Interface::model_exchange);
    require_mode(handle, {Mode::continuous_time});
    require_pointer(enter_event_mode, "where an answer goes");
    require_pointer(terminate, "where an answer goes");
    *enter_event_mode = handle.instance.has_drifted();
    *terminate = false;
  });
}
fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time) {
  return answer(instance, "fmi3SetTime", [&](Handle& handle) {
    require_interface(handle, Interface::model_exchange);
    require_mode(handle, {Mode::event, Mode::continuous_time});
    handle.instance.set_time(time);
  });
}
fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 states[], size_t count) {
  return answer(instance, "fmi3SetContinuousStates", [&](Handle& handle) {
    require_interface(handle, Interface::model_exchange);
    require_mode(handle, {Mode::continuous_time});
    require_count("states", handle.instance.variables().states.size(), count);
    handle.instance.set_states(list(states, count, "the states"));
  });
}

}  // extern "C"

namespace {

// The values of some variables, one after the other.
void write_values(Handle& handle, const std::vector<std::size_t>& references, const char* what, double* values, std::size_t count) {
  require_interface(handle, Interface::model_exchange);
  require_mode(handle, initialized);
  require_count(what, references.size(), count);
  const auto out = list(values, count, what);
  std::vector<double> found;
  for (const std::size_t r : references) found.push_back(handle.instance.value(r));
  std::copy(found.begin(), found.end(), out.begin());
}

}  // namespace

extern "C" {

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 states[], size_t count) {
  return answer(instance, "fmi3GetContinuousStates",
                [&](Handle& handle) { write_values(handle, handle.instance.variables().states, "states", states, count); });
}
fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t count) {
  return answer(instance, "fmi3GetContinuousStateDerivatives",
                [&](Handle& handle) { write_values(handle, handle.instance.variables().rates, "derivatives", derivatives, count); });
}
fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 indicators[], size_t count) {
  return answer(instance, "fmi3GetEventIndicators",
                [&](Handle& handle) { write_values(handle, handle.instance.variables().guards, "event indicators", indicators, count); });
}
fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t count) {
  return answer(instance, "fmi3GetNominalsOfContinuousStates", [&](Handle& handle) {
    require_interface(handle, Interface::model_exchange);
    require_mode(handle, initialized);
    require_count("nominal values", handle.instance.variables().states.size(), count);
    std::ranges::fill(list(nominals, count, "nominal values"), 1.0);
  });
}
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t* count) {
  return answer(instance, "fmi3GetNumberOfEventIndicators", [&](Handle& handle) {
    require_interface(handle, Interface::model_exchange);
    require_pointer(count, "where the number goes");
    *count = handle.instance.variables().guards.size();
  });
}
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t* count) {
  return answer(instance, "fmi3GetNumberOfContinuousStates", [&](Handle& handle) {
    require_interface(handle, Interface::model_exchange);
    require_pointer(count, "where the number goes");
    *count = handle.instance.variables().states.size();
  });
}

// --- Co-Simulation ---------------------------------------------------------------------------------------------------

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
  return answer(instance, "fmi3EnterStepMode", [&](Handle& handle) {
    require_interface(handle, Interface::co_simulation);
    require_mode(handle, {Mode::event});
    handle.instance.enter(Mode::step);
  });
}
fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference references[], size_t count, const fmi3Int32 orders[],
                                    fmi3Float64 values[], size_t value_count) {
  return answer(instance, "fmi3GetOutputDerivatives", [&](Handle& handle) {
    require_interface(handle, Interface::co_simulation);
    require_mode(handle, {Mode::event, Mode::step, Mode::terminated});
    require_count("values, as many as references,", count, value_count);
    const auto places = list(references, count, "the references");
    const auto order = list(orders, count, "the orders");
    const auto out = list(values, count, "the values");
    const Variables& variables = handle.instance.variables();
    std::vector<double> found;
    for (std::size_t i = 0; i < count; ++i) {
      const auto state = std::find(variables.states.begin(), variables.states.end(), places[i]);
      if (state == variables.states.end())
        forbid("derivatives by time are known of outputs, but value reference " + std::to_string(places[i]) + " is none");
      if (order[i] != 1) forbid("derivatives by time are known of order 1, but order " + std::to_string(order[i]) + " was asked for");
      found.push_back(handle.instance.value(variables.rates[static_cast<std::size_t>(state - variables.states.begin())]));
    }
    std::copy(found.begin(), found.end(), out.begin());
  });
}
fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 from, fmi3Float64 length, fmi3Boolean, fmi3Boolean* event_handling_needed, fmi3Boolean* terminate,
                      fmi3Boolean* early_return, fmi3Float64* last_successful_time) {
  return answer(instance, "fmi3DoStep", [&](Handle& handle) {
    require_interface(handle, Interface::co_simulation);
    require_mode(handle, {Mode::step});
    for (const void* pointer : std::initializer_list<const void*>{event_handling_needed, terminate, early_return, last_successful_time})
      require_pointer(pointer, "where an answer goes");
    const Instance::Step step = handle.instance.step(from, length);
    *event_handling_needed = step.event_handling_needed;
    *terminate = step.terminate;
    *early_return = step.early;
    *last_successful_time = step.t;
  });
}

}  // extern "C"
