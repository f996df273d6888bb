// SPDX-License-Identifier: MIT
//
// An importer of FMI 3.0: loads the library of hopper.cpp as any simulator would, drives it by both interfaces, and compares with closed forms. Then it makes
// mistakes.
#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "fmi/fmi3.hpp"

namespace {

int failures = 0;

void check(bool holds, const char* law) {
  if (holds) return;
  ++failures;
  std::printf("does not hold: %s\n", law);
}

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double tolerance = 1e-8;  // ten times that of the steps

bool near(double a, double b) { return std::abs(a - b) <= tolerance * (1 + std::abs(b)); }

void* library = nullptr;

template <class Function>
Function* found(const char* name) {
  void* symbol = dlsym(library, name);
  if (symbol == nullptr) std::printf("the library has no %s\n", name), std::exit(1);
  return reinterpret_cast<Function*>(symbol);
}

std::string description;

// The value reference of a variable, as its description has it.
fmi3ValueReference reference(const std::string& name) {
  const std::size_t at = description.find("name=\"" + name + "\" valueReference=\"");
  if (at == std::string::npos) std::printf("there is no variable %s\n", name.c_str()), std::exit(1);
  return static_cast<fmi3ValueReference>(std::stoul(description.substr(description.find("Reference=\"", at) + 11)));
}

std::string token() {
  const std::size_t at = description.find("instantiationToken=\"") + 20;
  return description.substr(at, description.find('"', at) - at);
}

std::string said;
void hear(fmi3InstanceEnvironment, fmi3Status, fmi3String category, fmi3String message) { said += std::string(category) + " " + message + "\n"; }
bool heard(const char* words) { return said.find(words) != std::string::npos; }

auto* const never = static_cast<fmi3IntermediateUpdateCallback>(nullptr);

struct Answer {
  bool event = false, terminate = false, early = false;
  double t = nan;
};

// An instance with the calls that the tests make.
struct Plant {
  fmi3Instance instance = nullptr;

  static Plant co_simulation(bool events, bool early, const std::string& with = token()) {
    return {found<decltype(fmi3InstantiateCoSimulation)>("fmi3InstantiateCoSimulation")("hopper", with.c_str(), nullptr, false, true, events, early,
                                                                                        nullptr, 0, nullptr, hear, never)};
  }
  static Plant model_exchange() {
    return {found<decltype(fmi3InstantiateModelExchange)>("fmi3InstantiateModelExchange")("hopper", token().c_str(), nullptr, false, true, nullptr, hear)};
  }
  void free() const { found<decltype(fmi3FreeInstance)>("fmi3FreeInstance")(instance); }

  fmi3Status call(const char* name) const { return found<fmi3Status(fmi3Instance)>(name)(instance); }
  fmi3Status set(const std::string& name, double value) const {
    const fmi3ValueReference r = reference(name);
    return found<decltype(fmi3SetFloat64)>("fmi3SetFloat64")(instance, &r, 1, &value, 1);
  }
  double get(const std::string& name) const {
    const fmi3ValueReference r = reference(name);
    double value = nan;
    return found<decltype(fmi3GetFloat64)>("fmi3GetFloat64")(instance, &r, 1, &value, 1) == fmi3OK ? value : nan;
  }
  fmi3Status enter(double stop = 10.0) const {
    return found<decltype(fmi3EnterInitializationMode)>("fmi3EnterInitializationMode")(instance, true, 1e-10, 0.0, true, stop);
  }
  fmi3Status begin(double stop) const { return enter(stop) == fmi3OK ? call("fmi3ExitInitializationMode") : fmi3Error; }
  fmi3Status step(double from, double length, Answer& a) const {
    return found<decltype(fmi3DoStep)>("fmi3DoStep")(instance, from, length, false, &a.event, &a.terminate, &a.early, &a.t);
  }
  fmi3Status step(double from, double length) const {
    Answer unused;
    return step(from, length, unused);
  }
  fmi3Status update(bool& changed) const {
    bool more, terminate, nominals, next;
    double time;
    return found<decltype(fmi3UpdateDiscreteStates)>("fmi3UpdateDiscreteStates")(instance, &more, &terminate, &nominals, &changed, &next, &time);
  }
  fmi3FMUState saved() const {
    fmi3FMUState state = nullptr;
    found<decltype(fmi3GetFMUState)>("fmi3GetFMUState")(instance, &state);
    return state;
  }
  fmi3Status restore(fmi3FMUState state) const { return found<decltype(fmi3SetFMUState)>("fmi3SetFMUState")(instance, state); }
  void forget(fmi3FMUState state) const { found<decltype(fmi3FreeFMUState)>("fmi3FreeFMUState")(instance, &state); }
  std::vector<fmi3Byte> bytes(fmi3FMUState state) const {
    std::size_t size = 0;
    found<decltype(fmi3SerializedFMUStateSize)>("fmi3SerializedFMUStateSize")(instance, state, &size);
    std::vector<fmi3Byte> all(size);
    found<decltype(fmi3SerializeFMUState)>("fmi3SerializeFMUState")(instance, state, all.data(), size);
    return all;
  }
  fmi3Status read(const std::vector<fmi3Byte>& all, fmi3FMUState& state) const {
    return found<decltype(fmi3DeserializeFMUState)>("fmi3DeserializeFMUState")(instance, all.data(), all.size(), &state);
  }
  fmi3Status derivative(const char* function, const std::vector<fmi3ValueReference>& unknowns, const std::vector<fmi3ValueReference>& knowns,
                        const std::vector<double>& seed, std::vector<double>& out) const {
    return found<decltype(fmi3GetDirectionalDerivative)>(function)(instance, unknowns.data(), unknowns.size(), knowns.data(), knowns.size(), seed.data(),
                                                                   seed.size(), out.data(), out.size());
  }
  fmi3Status states(const std::array<double, 4>& y) const {
    return found<decltype(fmi3SetContinuousStates)>("fmi3SetContinuousStates")(instance, y.data(), y.size());
  }
  std::array<double, 4> states() const {
    std::array<double, 4> y{};
    found<decltype(fmi3GetContinuousStates)>("fmi3GetContinuousStates")(instance, y.data(), y.size());
    return y;
  }
  std::array<double, 4> rates(double t, const std::array<double, 4>& y) const {
    std::array<double, 4> ydot{nan, nan, nan, nan};
    found<decltype(fmi3SetTime)>("fmi3SetTime")(instance, t);
    states(y);
    found<decltype(fmi3GetContinuousStateDerivatives)>("fmi3GetContinuousStateDerivatives")(instance, ydot.data(), ydot.size());
    return ydot;
  }
  double indicator() const {
    double g = nan;
    found<decltype(fmi3GetEventIndicators)>("fmi3GetEventIndicators")(instance, &g, 1);
    return g;
  }
};

// The ball: dropped from 1.25 m, mass 2, pushed up by 4 N, so that it falls with 8 m/s²; half of the velocity is left by an impact.
constexpr double fall = 8.0, height = 1.25, left = 0.5;
const double first = std::sqrt(2 * height / fall);
double ball(double t) {
  const double v = left * fall * first, s = t - first;
  return t <= first ? height - 0.5 * fall * t * t : v * s - 0.5 * fall * s * s;  // up to the second impact
}

Plant pushed(Plant plant) {
  plant.enter();
  plant.set("push", 4.0);
  plant.call("fmi3ExitInitializationMode");
  return plant;
}

void co_simulation() {
  const Plant through = pushed(Plant::co_simulation(false, false));
  check(through.step(0.0, 0.9) == fmi3OK && near(through.get("h"), ball(0.9)), "a step leads through an impact");
  check(near(through.get("der(hdot)"), -fall) && through.get("time") == 0.9 && through.get("floor.phase") == 0.0, "outputs are those of the time reached");
  check(near(through.get("kinetic_energy"), std::pow(through.get("hdot"), 2) + std::pow(through.get("xdot"), 2)), "the energy is that of the state");
  check(heard("floor"), "events are logged");
  const double x = through.get("x");

  const Plant early = pushed(Plant::co_simulation(false, true));
  Answer a;
  check(early.step(0.0, 0.9, a) == fmi3OK && a.early && !a.event && near(a.t, first) && near(early.get("hdot"), left * fall * first),
        "a step ends early at an impact");
  check(early.step(a.t, 0.9 - a.t, a) == fmi3OK && !a.early && a.t == 0.9 && near(early.get("h"), ball(0.9)) && near(early.get("x"), x),
        "and goes on behind it");

  const Plant moded = pushed(Plant::co_simulation(true, true));
  bool changed = false;
  check(moded.step(0.0, 0.1) == fmi3Error, "a step before step mode is an error");
  check(moded.call("fmi3Reset") == fmi3OK, "Reset leads on after an error");
  pushed(moded);
  check(moded.update(changed) == fmi3OK && !changed && moded.call("fmi3EnterStepMode") == fmi3OK, "event mode comes first where it is used");
  check(moded.step(0.0, 0.9, a) == fmi3OK && a.event && near(moded.get("hdot"), -fall * first), "an event that the importer handles is still to come");
  check(moded.call("fmi3EnterEventMode") == fmi3OK && moded.update(changed) == fmi3OK && changed && near(moded.get("hdot"), left * fall * first),
        "its consequences come in event mode");
  check(moded.call("fmi3EnterStepMode") == fmi3OK && moded.step(a.t, 0.9 - a.t) == fmi3OK && near(moded.get("h"), ball(0.9)),
        "and then the motion goes on");

  // Rest: infinitely many impacts are over at first (1 + e)/(1 − e).
  const Plant rest = pushed(Plant::co_simulation(false, false));
  check(rest.step(0.0, 3.0) == fmi3OK && rest.get("floor.phase") == 1.0 && rest.get("h") == 0.0 && near(rest.get("floor.guard"), 2 * fall),
        "it comes to rest, and the floor carries it");
  check(rest.set("push", 44.0) == fmi3OK && rest.step(3.0, 1.0) == fmi3OK && near(rest.get("h"), 0.5 * 12.0), "an input lifts it off again");
  for (const Plant& plant : {through, early, moded, rest}) plant.free();
}

// The classical method of order 4, exact for the ball.
std::array<double, 4> integrated(const Plant& plant, std::array<double, 4> y, double from, double to, int steps) {
  const double h = (to - from) / steps;
  const auto moved = [](std::array<double, 4> at, const std::array<double, 4>& k, double by) {
    for (std::size_t i = 0; i < 4; ++i) at[i] += by * k[i];
    return at;
  };
  for (int s = 0; s < steps; ++s) {
    const double t = from + s * h;
    const auto k1 = plant.rates(t, y), k2 = plant.rates(t + h / 2, moved(y, k1, h / 2)), k3 = plant.rates(t + h / 2, moved(y, k2, h / 2)),
               k4 = plant.rates(t + h, moved(y, k3, h));
    for (std::size_t i = 0; i < 4; ++i) y[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  }
  return y;
}

void model_exchange() {
  const Plant plant = pushed(Plant::model_exchange());
  bool changed = false, more = true, terminate = true;
  std::size_t count = 0;
  found<decltype(fmi3GetNumberOfContinuousStates)>("fmi3GetNumberOfContinuousStates")(plant.instance, &count);
  check(count == 4, "phases and inputs are no continuous states");
  check(plant.update(changed) == fmi3OK && !changed && plant.call("fmi3EnterContinuousTimeMode") == fmi3OK, "event mode comes first");
  auto y = integrated(plant, plant.states(), 0.0, first, 400);
  check(near(y[0], 0.0) && near(y[2], -fall * first), "an importer's integrator finds the motion");
  y[0] = -1e-12;  // where it noticed that the indicator has fallen through zero
  plant.states(y);
  check(plant.indicator() < 0, "the indicator of a contact is its gap");
  found<decltype(fmi3CompletedIntegratorStep)>("fmi3CompletedIntegratorStep")(plant.instance, true, &more, &terminate);
  check(!more && !terminate, "there is nothing to move back while no contact is closed");
  check(plant.call("fmi3EnterEventMode") == fmi3OK && plant.update(changed) == fmi3OK && changed && near(plant.get("hdot"), left * fall * first),
        "the blow comes in event mode");
  plant.call("fmi3EnterContinuousTimeMode");
  y = integrated(plant, plant.states(), first, 0.9, 400);
  check(near(y[0], ball(0.9)), "and then the motion goes on");

  const Plant other = pushed(Plant::co_simulation(false, false));
  other.step(0.0, 0.9);
  check(near(y[1], other.get("x")) && near(y[3], other.get("xdot")), "both interfaces have one motion");

  // m ẍ = −k x³ − c ẋ,  m ḧ = −m g + u.
  constexpr double m = 2.0, k = 3.0, c = 0.25, x = 0.7;
  check(near(plant.rates(1.0, {1.0, x, -2.0, 0.4})[3], (-k * x * x * x - c * 0.4) / m), "rates are those of the equations of motion");
  const std::vector<fmi3ValueReference> unknowns = {reference("der(xdot)"), reference("der(hdot)"), reference("der(x)"), reference("x")};
  const std::vector<fmi3ValueReference> knowns = {reference("x"), reference("xdot"), reference("push")};
  std::vector<double> s(4), a(3);
  check(plant.derivative("fmi3GetDirectionalDerivative", unknowns, knowns, {1.0, 10.0, 100.0}, s) == fmi3OK, "directional derivatives are known");
  const double xx = -3 * k * x * x / m, xv = -c / m;
  check(std::abs(s[0] - (xx + 10 * xv)) < 1e-13 && std::abs(s[1] - 100 / m) < 1e-13 && s[2] == 10.0 && s[3] == 1.0, "directional derivatives are exact");
  check(plant.derivative("fmi3GetAdjointDerivative", unknowns, knowns, {1.0, 10.0, 100.0, 1000.0}, a) == fmi3OK && std::abs(a[0] - (xx + 1000)) < 1e-12 &&
            std::abs(a[1] - (xv + 100)) < 1e-12 && std::abs(a[2] - 10 / m) < 1e-13,
        "and so are adjoint ones");
  check(plant.derivative("fmi3GetDirectionalDerivative", unknowns, knowns, {1.0, nan, 0.0}, s) == fmi3Discard, "seeds that are not finite are refused");
  check(plant.states({1.0, nan, 0.0, 0.0}) == fmi3Discard && heard("states must be finite") && near(plant.states()[1], x),
        "states that are not finite are refused, and nothing is changed");
  check(plant.states({1.0, 1e200, 0.0, 0.0}) == fmi3OK && std::isnan(plant.get("der(xdot)")) && plant.states({1.0, 0.0, 0.0, 0.0}) == fmi3OK,
        "a rate that is not finite is no success");
  check(plant.derivative("fmi3GetDirectionalDerivative", {reference("kinetic_energy")}, knowns, {1, 1, 1}, a = {nan}) == fmi3Error &&
            heard("derivatives of states"),
        "what is not known is refused by name");
  plant.free();
  other.free();
}

void whole_state() {
  const Plant plant = pushed(Plant::co_simulation(false, false));
  plant.step(0.0, 0.4);
  const fmi3FMUState state = plant.saved();
  plant.step(0.4, 0.7);
  const double h = plant.get("h"), x = plant.get("x");
  plant.restore(state);
  check(plant.get("time") == 0.4 && plant.step(0.4, 0.7) == fmi3OK && plant.get("h") == h && plant.get("x") == x,
        "a restored state goes on with the same bits");

  std::vector<fmi3Byte> bytes = plant.bytes(state);
  const Plant other = Plant::co_simulation(false, false);
  fmi3FMUState copy = nullptr;
  check(other.read(bytes, copy) == fmi3OK && other.restore(copy) == fmi3OK && other.step(0.4, 0.7) == fmi3OK && other.get("h") == h && other.get("x") == x,
        "serialized, a state goes on in another instance with the same bits");
  bool refused = true;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] ^= 4;
    fmi3FMUState none = nullptr;
    refused = refused && other.read(bytes, none) == fmi3Discard && none == nullptr;
    bytes[i] ^= 4;
  }
  check(refused && heard("its checksum is wrong"), "a state in which one bit is another is refused");
  fmi3FMUState none = nullptr;
  check(other.read({bytes.begin(), bytes.end() - 8}, none) == fmi3Discard && other.read({}, none) == fmi3Discard && none == nullptr,
        "a state that was cut short is refused");
  const Plant exchange = pushed(Plant::model_exchange());
  check(exchange.read(bytes, none) == fmi3Discard && heard("the other interface"), "a state of the other interface is refused");
  check(other.get("h") == h && other.step(1.1, 0.1) == fmi3OK, "refused states change nothing");
  plant.forget(state);
  other.forget(copy);
  for (const Plant& p : {plant, other, exchange}) p.free();
}

void mistakes() {
  check(Plant::co_simulation(false, false, "{another}").instance == nullptr && heard("instantiation token"), "another library's token is refused");
  check(found<decltype(fmi3InstantiateModelExchange)>("fmi3InstantiateModelExchange")(" ", token().c_str(), nullptr, false, true, nullptr, hear) ==
                nullptr &&
            heard("not blank"),
        "an instance has a name");

  const Plant plant = Plant::co_simulation(false, false);
  check(plant.set("m", nan) == fmi3Discard && heard("'m' was given nan") && plant.get("m") == 2.0, "a parameter that is no number is refused");
  check(plant.set("m", 0.0) == fmi3Discard && heard("'m' must be positive") && plant.set("e", 2.0) == fmi3Discard && plant.get("e") == left,
        "values out of range are refused");
  check(plant.set("m", 4.0) == fmi3OK && plant.get("m") == 4.0 && plant.set("h", 3.0) == fmi3OK && plant.get("h") == 3.0,
        "parameters and starts can be set before");
  const fmi3ValueReference on = reference("drag.on");
  bool off = false;
  check(found<decltype(fmi3SetBoolean)>("fmi3SetBoolean")(plant.instance, &on, 1, &off, 1) == fmi3OK && plant.begin(2.0) == fmi3OK &&
            plant.set("push", 4.0) == fmi3OK,
        "effects can be switched");
  check(plant.get("x") == 1.0 && near(plant.get("der(hdot)"), -9.0) && plant.step(0.0, 0.5) == fmi3OK && near(plant.get("h"), 3.0 - 4.5 * 0.25),
        "what was set is what moves");
  const double energy = 0.5 * 4.0 * std::pow(plant.get("xdot"), 2) + 0.75 * std::pow(plant.get("x"), 4);
  check(near(energy, 0.75), "without drag the bead keeps its energy");

  check(plant.set("push", nan) == fmi3Discard && plant.get("push") == 4.0, "an input that is no number is refused");
  check(plant.set("push", 1e308) == fmi3OK && plant.step(0.5, 1.0) == fmi3Discard && heard("came as far as") && plant.get("time") == 0.5 &&
            plant.set("push", 4.0) == fmi3OK && plant.step(0.5, 0.1) == fmi3OK,
        "a step that cannot be completed changes nothing, and another may be tried");

  // Errors end the instance; a state from before or a reset lead on.
  const fmi3FMUState good = plant.saved();
  const auto is_error = [&](fmi3Status status, const char* words) {
    const bool right = status == fmi3Error && heard(words) && plant.step(0.6, 0.1) == fmi3Error;
    said.clear();
    return plant.restore(good) == fmi3OK && right;
  };
  said.clear();
  check(is_error(plant.step(0.6, -0.1), "must go forward"), "a step backwards is an error");
  check(is_error(plant.step(0.3, 0.1), "must begin where the last one ended, t = 0.6"), "a step from elsewhere is an error");
  check(is_error(plant.step(0.6, nan), "finite"), "a step of no length is an error");
  check(is_error(plant.step(0.6, 2.0), "beyond the stop time"), "a step beyond the end is an error");
  check(is_error(plant.set("m", 1.0), "before the end of initialization"), "parameters cannot be set later");
  check(is_error(plant.set("der(h)", 1.0), "cannot be set"), "outputs cannot be set");
  check(is_error(plant.call("fmi3EnterContinuousTimeMode"), "one of Model Exchange"), "the other interface's functions are errors");
  check(is_error(plant.call("fmi3EnterEventMode"), "eventModeUsed"), "there is no event mode for who does not use it");
  check(is_error(plant.call("fmi3EnterConfigurationMode"), "structural parameters"), "what is lacking is refused by name");
  const fmi3ValueReference nowhere = 1000;
  double value = 7.0;
  check(is_error(found<decltype(fmi3GetFloat64)>("fmi3GetFloat64")(plant.instance, &nowhere, 1, &value, 1), "is 1000") && value == 7.0,
        "value references are checked");
  check(is_error(found<decltype(fmi3GetFloat64)>("fmi3GetFloat64")(plant.instance, &on, 1, &value, 1), "'drag.on' is of type Boolean"),
        "types are checked");
  check(is_error(found<decltype(fmi3GetFloat64)>("fmi3GetFloat64")(plant.instance, nullptr, 1, &value, 1), "null pointer"), "null pointers are errors");
  check(is_error(plant.restore(nullptr), "null pointer"), "no state is an error");
  check(found<decltype(fmi3Terminate)>("fmi3Terminate")(nullptr) == fmi3Error, "no instance is an error");
  check(plant.step(0.6, 0.1) == fmi3OK && plant.call("fmi3Terminate") == fmi3OK && plant.get("time") == 0.7 && plant.step(0.7, 0.1) == fmi3Error,
        "what has ended can be looked at, and no more");
  plant.forget(good);
  plant.free();
}

// Calls in any order, with values that nobody means.
void anything() {
  std::mt19937 random(1);
  const auto below = [&](unsigned n) { return static_cast<unsigned>(random() % n); };
  const std::array<double, 8> odd = {0.0, -1.0, nan, std::numeric_limits<double>::infinity(), 1e300, -1e300, 1e-300, 0.5};
  const auto any = [&] { return below(3) > 0 ? 0.01 * below(300) - 1.0 : odd[below(odd.size())]; };
  const std::array<const char*, 8> names = {"push", "h", "xdot", "m", "e", "der(hdot)", "floor.guard", "kinetic_energy"};
  const std::array<const char*, 7> modes = {"fmi3ExitInitializationMode",  "fmi3EnterEventMode", "fmi3EnterStepMode",         "fmi3Terminate",
                                            "fmi3EnterContinuousTimeMode", "fmi3Reset",          "fmi3EnterConfigurationMode"};
  bool finite = true, bounded = true;
  for (int run = 0; run < 200; ++run) {
    const bool steps = below(2) == 0;
    const Plant plant = pushed(steps ? Plant::co_simulation(below(2) == 0, below(2) == 0) : Plant::model_exchange());
    bool changed;
    plant.update(changed);
    plant.call(steps ? "fmi3EnterStepMode" : "fmi3EnterContinuousTimeMode");
    fmi3FMUState good = plant.saved();
    for (int k = 0; k < 20; ++k) {
      fmi3Status status = fmi3OK;
      switch (below(6)) {
        case 0:
          status = plant.set(names[below(names.size())], any());
          break;
        case 1:
          status = plant.states({any(), any(), any(), any()});
          break;
        case 2:
          status = plant.call(modes[below(modes.size())]);
          break;
        case 3:
          status = plant.update(changed);
          break;
        default:
          status = plant.step(plant.get("time"), below(5) > 0 ? 0.3 : std::min(any(), 3.0));
          break;
      }
      bounded = bounded && status >= fmi3OK && status <= fmi3Error;
      for (const char* name : names) {
        const fmi3ValueReference r = reference(name);
        double value = 0.0;
        if (found<decltype(fmi3GetFloat64)>("fmi3GetFloat64")(plant.instance, &r, 1, &value, 1) == fmi3OK) finite = finite && std::isfinite(value);
      }
      if (status == fmi3Error) plant.restore(good);
    }
    plant.forget(good);
    plant.free();
  }
  check(bounded, "every call has one of the named statuses");
  check(finite, "no value that is not finite is handed out as a success");
  said.clear();
}

void many() {
  const auto motion = [](double push) {
    const Plant plant = Plant::co_simulation(false, false);
    plant.enter();
    plant.set("push", push);
    plant.call("fmi3ExitInitializationMode");
    return plant;
  };
  const auto go = [](const Plant& plant) {
    for (int i = 0; i < 20; ++i) plant.step(0.1 * i, 0.1);
  };
  const Plant a = motion(0.0), b = motion(4.0), c = motion(4.0), alone = motion(4.0);
  for (int i = 0; i < 20; ++i) a.step(0.1 * i, 0.1), b.step(0.1 * i, 0.1);
  go(alone);
  check(b.get("h") == alone.get("h") && b.get("x") == alone.get("x"), "instances know nothing of each other");

  const Plant d = motion(4.0);
  for (const Plant& p : {c, d})
    found<decltype(fmi3SetDebugLogging)>("fmi3SetDebugLogging")(p.instance, false, 0, nullptr);  // what is heard is one string for all
  said.clear();
  std::thread other([&] { go(c); });
  go(d);
  other.join();
  check(c.get("h") == alone.get("h") && d.get("h") == alone.get("h") && c.get("x") == d.get("x"), "two in two threads go the same way");
  check(said.empty(), "nothing is said where logging is off");
  for (const Plant& p : {a, b, c, d, alone}) p.free();
}

}  // namespace

int main() {
  library = dlopen(HOPPER, RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return std::printf("%s\n", dlerror()), 1;
  std::ifstream file(DESCRIPTION);
  description.assign(std::istreambuf_iterator<char>(file), {});
  check(found<decltype(fmi3GetVersion)>("fmi3GetVersion")() == std::string("3.0"), "it is FMI 3.0");
  co_simulation();
  model_exchange();
  whole_state();
  mistakes();
  anything();
  many();
  if (failures > 0) std::printf("all that was said:\n%s", said.c_str());
  return failures == 0 ? 0 : 1;
}
