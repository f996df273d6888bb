// SPDX-License-Identifier: MIT
#include "fmi/instance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include "program/first_order_model.hpp"
#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulator.hpp"
#include "qdot/integrate/watch/any_watch.hpp"
#include "qdot/report/number.hpp"

namespace qdot::fmi {

namespace {

using program::Model;
using program::RunnableScene;
using report::rounded_text;

std::string number(double x) { return rounded_text(x, 10); }

/// A model of any kind as the simulator sees it, which may be told to end at each change of a phase.
struct PlantModel : program::SwitchingModel {
  std::shared_ptr<const bool> stops;

  void driven() const = delete;  // which knows nothing of the endings below
  std::unique_ptr<qdot::detail::AnyWatch> watch(const Options& options) const { return model->watch(options); }

  std::string ending(Eigen::Index k) const { return *stops || !model->ending(k).empty() ? mark + std::to_string(k) : std::string(); }
  static constexpr char mark = '\1';  // no name that a user gives begins so
};

/// Dop853, compiled for the scene where it can be.
struct PlantMethod {
  AnyStepper stepper(const PlantModel& system, const Options& options) const {
    if (auto own = system.model->own_stepper("dop853", 0, options)) return std::move(*own);
    if (system.model->is_constrained()) return any_stepper(Dop853{}, static_cast<const program::ConstrainedModel&>(system), options);
    return any_stepper(Dop853{}, static_cast<const program::FirstOrderModel&>(system), options);
  }
};

// A million of the method's own steps between two communication points is more than anyone waits for.
Options options_for(double tolerance) {
  return {.rtol = tolerance, .atol = AbsoluteTolerance::at_most(tolerance), .max_steps = 1'000'000, .keep_trajectory = false};
}

void require_value(const Variable& v, double value) {
  if (v.role == Role::effect_on) return;
  if (!std::isfinite(value))
    discard("a variable must be given a finite number, but '" + v.name + "' was given " + report::exact_text(value) + "; it keeps what it had");
  if (!v.range.holds(value)) discard("'" + v.name + "' must be " + v.range.text() + ", but was given " + number(value) + "; it keeps what it had");
}

}  // namespace

struct Instance::Behind {
  std::unique_ptr<RunnableScene> scene;
  std::shared_ptr<const Model> model;
  State<Dynamic> start;
  std::shared_ptr<bool> stops = std::make_shared<bool>(false);
  std::optional<Simulator> plant;
  std::uint64_t plant_number = 0;
};

Instance::Instance(const Variables& variables, Interface interface, bool event_mode_used, bool early_return_allowed)
    : variables_(variables), interface_(interface), event_mode_used_(event_mode_used), early_return_allowed_(early_return_allowed) {
  reset();
}

Instance::~Instance() = default;

void Instance::reset() {
  now_ = Snapshot();
  now_.t = variables_.start_time;
  now_.set.assign(variables_.all.size(), std::numeric_limits<double>::quiet_NaN());
  behind_.reset();
  is_ready_ = false;
  standing_ = 0;
  moved();
}

const Variable& Instance::variable(fmi3ValueReference reference) const {
  if (reference >= variables_.all.size())
    forbid("a value reference must be one of the " + std::to_string(variables_.all.size()) + " of modelDescription.xml, counted from 0, but is " +
           std::to_string(reference));
  return variables_.all[reference];
}

double Instance::setting(std::size_t reference, const Snapshot& at) const {
  return std::isnan(at.set[reference]) ? variables_.all[reference].start : at.set[reference];
}

// --- From settings to a state ----------------------------------------------------------------------------------------

std::unique_ptr<Instance::Behind> Instance::behind(const Snapshot& at) const {
  auto made = std::make_unique<Behind>();
  made->scene = chosen_scene(choice());
  for (std::size_t i = 0; i < variables_.all.size(); ++i) {
    const Variable& v = variables_.all[i];
    if (std::isnan(at.set[i])) continue;
    if (v.role == Role::parameter) made->scene->set_parameter(v.of, at.set[i]);
    if (v.role == Role::effect_on) made->scene->set_effect(v.of, at.set[i] != 0, std::nullopt);
    if (v.role == Role::effect_value) {
      bool on = true;
      for (const program::EffectInfo& e : made->scene->effects())
        if (e.name == v.of) on = e.on;
      made->scene->set_effect(v.of, on, at.set[i]);
    }
  }
  made->model = made->scene->model();
  made->start = made->scene->start();
  if (made->model->size() != variables_.size || static_cast<std::size_t>(made->model->guard_count()) != variables_.guards.size())
    discard("the parameters change how many states there are, " + std::to_string(variables_.size) + " in modelDescription.xml but " +
            std::to_string(made->model->size()) + " for these; choose them by qdot_add_fmu(… SET NAME=VALUE)");
  return made;
}

Eigen::VectorXd Instance::start(const Behind& made, const Snapshot& at) {
  State<Dynamic> state = made.start;
  state.t = at.t;
  Eigen::VectorXd y = made.model->packed(state);
  for (const auto* references : {&variables_.states, &variables_.inputs})
    for (const std::size_t r : *references)
      if (!std::isnan(at.set[r])) y[variables_.all[r].place] = at.set[r];
  if (made.model->is_constrained()) {
    const ProjectionReport report = made.model->project(at.t, y);
    constexpr double rounding = 1e-6;
    if (std::max(report.moved_q, report.moved_qdot) > rounding)
      news_.emplace_back("logStatusWarning", "the start was moved onto the constraints: coordinates by at most " + number(report.moved_q) +
                                                 ", velocities by at most " + number(report.moved_qdot));
  }
  if (made.model->guard_count() > 0) {
    const std::vector<bool> none(static_cast<std::size_t>(made.model->guard_count()), false);
    const Eigen::VectorXd tolerance = (at.tolerance * (y.cwiseAbs().array() + 1.0)).matrix();
    for (const std::string& what : made.model->switched(at.t, y, none, tolerance)) news_.emplace_back("logEvents", "t = " + number(at.t) + ": " + what);
  }
  return y;
}

void Instance::make_plant(Behind& made, const Snapshot& at) const {
  PlantModel model{{{{made.model}}}, made.stops};
  made.plant.emplace(model, FirstOrderState{at.t, at.y}, PlantMethod{}, options_for(at.tolerance));
  made.plant_number = made.plant->save().simulator;
}

// Before there is a run, y follows from what was set.
void Instance::ready() {
  if (is_ready_) return;
  auto made = behind(now_);
  Eigen::VectorXd y = start(*made, now_);
  behind_ = std::move(made);
  now_.y = std::move(y);
  moved();
  is_ready_ = true;
}

void Instance::enter_initialization(const double* tolerance, double start_time, const double* stop_time) {
  if (!std::isfinite(start_time)) forbid("the start time must be finite, but is " + number(start_time));
  if (tolerance != nullptr && !(*tolerance >= 2.3e-15 && *tolerance < 1))
    forbid("the tolerance must lie between 2.3e-15 (double has no more digits) and 1, but is " + number(*tolerance));
  if (stop_time != nullptr && !(*stop_time > start_time))
    forbid("the stop time must come after the start, t = " + number(start_time) + ", but is " + number(*stop_time));
  now_.t = start_time;
  if (tolerance != nullptr) now_.tolerance = *tolerance;
  if (stop_time != nullptr) now_.stop_time = *stop_time;
  now_.mode = Mode::initialization;
  is_ready_ = false;
}

void Instance::exit_initialization() {
  ready();
  rates();
  if (interface_ == Interface::co_simulation) make_plant(*behind_, now_);
  now_.mode = interface_ == Interface::model_exchange || event_mode_used_ ? Mode::event : Mode::step;
}

// --- Values ----------------------------------------------------------------------------------------------------------

const Eigen::VectorXd& Instance::rates() {
  if (rates_known_) return rates_;
  rates_.resize(now_.y.size());
  behind_->model->derivative(now_.t, now_.y, rates_);
  for (const std::size_t r : variables_.rates)
    if (const double rate = rates_[variables_.all[r].place]; !std::isfinite(rate))
      discard("a rate must be finite, but " + variables_.all[r].name + " is " + number(rate) + " at t = " + number(now_.t) +
              "; look for a division by zero, or go back");
  rates_known_ = true;
  return rates_;
}

Eigen::VectorXd Instance::guards() const {
  Eigen::VectorXd g(behind_->model->guard_count());
  if (g.size() > 0) behind_->model->guards(now_.t, now_.y, g);
  for (Eigen::Index k = 0; k < g.size(); ++k)
    if (!std::isfinite(g[k]))
      discard("an event indicator must be finite, but " + variables_.all[variables_.guards[static_cast<std::size_t>(k)]].name + " is " + number(g[k]) +
              " at t = " + number(now_.t));
  return g;
}

double Instance::value(std::size_t reference) {
  const Variable& v = variable(static_cast<fmi3ValueReference>(reference));
  switch (v.role) {
    case Role::time:
      return now_.t;
    case Role::parameter:
    case Role::count:
    case Role::effect_value:
    case Role::effect_on:
      return setting(reference, now_);
    default:
      break;
  }
  ready();
  switch (v.role) {
    case Role::rate:
      return rates()[v.place];
    case Role::guard:
      return guards()[v.place];
    case Role::kinetic_energy:
    case Role::potential_energy: {
      const program::Energies energies = behind_->model->energies(now_.t, now_.y);
      const double energy = v.role == Role::kinetic_energy ? energies.kinetic : energies.potential;
      if (!std::isfinite(energy)) discard("an energy must be finite, but " + v.name + " is " + number(energy) + " at t = " + number(now_.t));
      return energy;
    }
    default:
      return now_.y[v.place];
  }
}

void Instance::set(std::span<const fmi3ValueReference> references, std::span<const double> values) {
  const bool before = now_.mode == Mode::instantiated || now_.mode == Mode::initialization;
  for (std::size_t i = 0; i < references.size(); ++i) {
    const Variable& v = variable(references[i]);
    const bool once = v.role == Role::parameter || v.role == Role::effect_value || v.role == Role::effect_on || v.role == Role::state;
    if (!once && v.role != Role::input) forbid("'" + v.name + "' cannot be set: only parameters, starts of states and inputs can");
    if (once && !before) forbid("'" + v.name + "' can be set before the end of initialization only; fmi3Reset leads back there");
    require_value(v, values[i]);
  }
  for (std::size_t i = 0; i < references.size(); ++i) {
    now_.set[references[i]] = values[i];
    if (before)
      is_ready_ = false;
    else
      now_.y[variables_.all[references[i]].place] = values[i];
  }
  moved();
}

void Instance::set_time(double t) {
  if (!std::isfinite(t)) forbid("the time must be finite, but is " + number(t));
  now_.t = t;
  moved();
}

void Instance::set_states(std::span<const double> states) {
  for (std::size_t i = 0; i < states.size(); ++i)
    if (!std::isfinite(states[i]))
      discard("states must be finite, but " + variables_.all[variables_.states[i]].name + " was given " + number(states[i]) + "; all keep what they had");
  for (std::size_t i = 0; i < states.size(); ++i) now_.y[variables_.all[variables_.states[i]].place] = states[i];
  moved();
}

Eigen::MatrixXd Instance::derivatives(std::span<const fmi3ValueReference> unknowns, std::span<const fmi3ValueReference> knowns) {
  ready();
  std::vector<Eigen::Index> columns;
  for (const fmi3ValueReference r : knowns) {
    const Variable& v = variable(r);
    if (v.role != Role::state && v.role != Role::input) forbid("derivatives are known with respect to states and inputs, but '" + v.name + "' is neither");
    if (now_.mode == Mode::initialization && v.follows_others)
      forbid("while initializing, derivatives with respect to '" + v.name +
             "' are not known, since constraints or parameters decide its start; ask after fmi3ExitInitializationMode");
    columns.push_back(v.place);
  }
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(unknowns.size()), static_cast<Eigen::Index>(knowns.size()));
  for (Eigen::Index i = 0; i < out.rows(); ++i) {
    const Variable& v = variable(unknowns[static_cast<std::size_t>(i)]);
    if (v.role != Role::state && v.role != Role::rate) forbid("derivatives of states and of their rates are known, but '" + v.name + "' is neither");
    if (v.role == Role::rate && !jacobian_known_) {
      jacobian_.resize(now_.y.size(), now_.y.size());
      behind_->model->jacobian(now_.t, now_.y, jacobian_);
      jacobian_known_ = true;
    }
    for (Eigen::Index j = 0; j < out.cols(); ++j) {
      const Eigen::Index column = columns[static_cast<std::size_t>(j)];
      out(i, j) = v.role == Role::rate ? jacobian_(v.place, column) : v.place == column ? 1.0 : 0.0;
      if (!std::isfinite(out(i, j)))
        discard("a derivative must be finite, but that of " + v.name + " is " + number(out(i, j)) + " at t = " + number(now_.t));
    }
  }
  return out;
}

// --- Events ----------------------------------------------------------------------------------------------------------

Eigen::VectorXd Instance::tolerances() const { return (now_.tolerance * (now_.y.cwiseAbs().array() + 1.0)).matrix(); }

void Instance::settle(const std::vector<bool>& fired) {
  Eigen::VectorXd y = now_.y;
  std::vector<std::string> happened;
  if (behind_->model->guard_count() > 0) happened = behind_->model->switched(now_.t, y, fired, tolerances());
  if (behind_->model->is_constrained()) behind_->model->project(now_.t, y);
  now_.y = y;
  now_.fired.clear();
  moved();
  for (const std::string& what : happened) news_.emplace_back("logEvents", "t = " + number(now_.t) + ": " + what);
}

Instance::Update Instance::update() {
  const Eigen::VectorXd before = now_.y;
  std::vector<bool> fired = now_.fired;
  const Eigen::Index count = behind_->model->guard_count();
  if (fired.empty() && count > 0) {
    const Eigen::VectorXd g = guards();
    Eigen::VectorXd bands(count);
    behind_->model->guard_bands(now_.t, now_.y, tolerances(), bands);
    for (Eigen::Index k = 0; k < count; ++k) fired.push_back(interface_ == Interface::model_exchange && g[k] <= bands[k]);
  }
  Update done;
  for (Eigen::Index k = 0; k < count; ++k) {
    const std::string ending = behind_->model->ending(k);
    if (!fired[static_cast<std::size_t>(k)] || ending.empty()) continue;
    news_.emplace_back("logEvents", "t = " + number(now_.t) + ": " + ending);
    done.terminate = true;
  }
  if (done.terminate) return done;
  settle(fired);
  for (const std::size_t r : variables_.states)
    done.states_changed = done.states_changed || now_.y[variables_.all[r].place] != before[variables_.all[r].place];
  return done;
}

bool Instance::has_drifted() {
  if (!behind_->model->is_constrained()) return false;
  Eigen::VectorXd y = now_.y;
  behind_->model->project(now_.t, y);
  const double limit = std::max(1e-6, 10 * now_.tolerance);
  return ((y - now_.y).array().abs() > limit * (1.0 + now_.y.array().abs())).any();
}

// --- Steps -----------------------------------------------------------------------------------------------------------

Instance::Step Instance::step(double from, double length) {
  if (!std::isfinite(from) || !std::isfinite(length))
    forbid("a step must begin at a finite time and have a finite length, but begins at " + number(from) + " with " + number(length));
  if (!(length > 0)) forbid("a step must go forward, but its length is " + number(length) + "; go back by fmi3SetFMUState");
  const double rounding = 1e-9 * std::max({1.0, std::abs(now_.t), length});
  if (std::abs(from - now_.t) > rounding)
    forbid("a step must begin where the last one ended, t = " + report::exact_text(now_.t) + ", but begins at " + report::exact_text(from));
  const double to = from + length;
  if (to > now_.stop_time + rounding) forbid("a step must not lead beyond the stop time, t = " + number(now_.stop_time) + ", but leads to " + number(to));
  const Snapshot before = now_;
  const auto back = [&] {
    now_ = before;
    moved();
  };
  Step done;
  try {
    if (!now_.fired.empty()) settle(now_.fired);
    if (to <= now_.t) return done.t = now_.t, done;
    constexpr int patience = 20;
    *behind_->stops = early_return_allowed_ && standing_ < patience;
    Simulator& plant = *behind_->plant;
    plant.restore({now_.t, now_.y, 0, behind_->plant_number});
    const Advance advance = plant.advance_to(to);
    if (!advance && advance.outcome != Outcome::stopped_by_event && advance.outcome != Outcome::stopped_by_model)
      discard("the step from t = " + number(now_.t) + " to " + number(to) + " came as far as t = " + number(advance.t) + ": " + plant.message());
    now_.t = plant.t();
    now_.y = plant.y();
    moved();
    const bool ended = advance.outcome == Outcome::stopped_by_event;
    std::vector<bool> fired(static_cast<std::size_t>(behind_->model->guard_count()), false);
    for (const RecordedEvent& event : plant.events()) {
      if (event.name.empty() || event.name[0] != PlantModel::mark) {
        news_.emplace_back("logEvents", "t = " + number(event.t) + ": " + event.name);
        continue;
      }
      const std::size_t k = std::stoul(event.name.substr(1));
      fired.at(k) = true;
      if (const std::string ending = behind_->model->ending(static_cast<Eigen::Index>(k)); !ending.empty()) {
        news_.emplace_back("logEvents", "t = " + number(event.t) + ": " + ending);
        done.terminate = true;
      }
    }
    if (advance.outcome == Outcome::stopped_by_model) {
      news_.emplace_back("logEvents", "t = " + number(now_.t) + ": " + plant.message());
      done.terminate = true;
    }
    if (ended && !done.terminate) {
      now_.fired = std::move(fired);
      done.event_handling_needed = event_mode_used_;
      if (!event_mode_used_) settle(std::vector<bool>(now_.fired));
    }
    done.t = now_.t;
    done.early = early_return_allowed_ && now_.t < to;
    standing_ = ended && now_.t == before.t ? standing_ + 1 : 0;
    return done;
  } catch (...) {
    back();
    throw;
  }
}

// --- The whole state -------------------------------------------------------------------------------------------------

// Whether the scene behind two snapshots is the same: its parameters and effects, not its inputs and starts.
bool Instance::has_scene_of(const Snapshot& other) const {
  if (behind_ == nullptr || now_.tolerance != other.tolerance) return false;
  for (std::size_t i = 0; i < variables_.all.size(); ++i) {
    const Role role = variables_.all[i].role;
    if (role != Role::parameter && role != Role::effect_value && role != Role::effect_on) continue;
    if (now_.set[i] != other.set[i] && !(std::isnan(now_.set[i]) && std::isnan(other.set[i]))) return false;
  }
  return true;
}

void Instance::restore(const Snapshot& snapshot) {
  const bool same = is_ready_ && has_scene_of(snapshot);
  std::unique_ptr<Behind> made;
  const bool runs = snapshot.mode != Mode::instantiated && snapshot.mode != Mode::initialization && snapshot.y.size() > 0;
  if (runs) {
    if (!same) made = behind(snapshot);
    if (interface_ == Interface::co_simulation && !(same && behind_->plant)) make_plant(made ? *made : *behind_, snapshot);
  }
  now_ = snapshot;
  if (made) behind_ = std::move(made);
  is_ready_ = runs;
  standing_ = 0;
  moved();
}

namespace {

constexpr std::uint64_t format = 0x33696d66746f6471u;  // "qdotfmi3" in this machine's byte order

}  // namespace

std::vector<fmi3Byte> serialized(const Snapshot& s, std::uint64_t owner) {
  std::vector<double> numbers = {static_cast<double>(s.mode), s.t, s.stop_time, s.tolerance};
  numbers.insert(numbers.end(), s.set.begin(), s.set.end());
  numbers.insert(numbers.end(), s.y.data(), s.y.data() + s.y.size());
  for (const bool fired : s.fired) numbers.push_back(fired ? 1.0 : 0.0);
  std::array<std::uint64_t, 6> header = {format, owner, s.set.size(), static_cast<std::uint64_t>(s.y.size()), s.fired.size(), 0};
  std::vector<fmi3Byte> bytes(sizeof header + numbers.size() * sizeof(double));
  std::memcpy(bytes.data(), header.data(), sizeof header);
  std::memcpy(bytes.data() + sizeof header, numbers.data(), numbers.size() * sizeof(double));
  header.back() = qdot::detail::checksum(qdot::detail::empty_checksum, bytes.data(), bytes.size());
  std::memcpy(bytes.data(), header.data(), sizeof header);
  return bytes;
}

Snapshot deserialized(std::span<const fmi3Byte> bytes, std::uint64_t owner, const Variables& variables) {
  const auto refuse = [](const char* why) {
    discard(std::string("a serialized state must be what fmi3SerializeFMUState wrote, but ") + why + "; nothing was changed, take another copy");
  };
  std::array<std::uint64_t, 6> header;
  if (bytes.size() < sizeof header) refuse("it is cut short");
  std::memcpy(header.data(), bytes.data(), sizeof header);
  if (header[0] != format) refuse("it does not begin like one");
  std::vector<fmi3Byte> copy(bytes.begin(), bytes.end());
  std::memset(copy.data() + 5 * sizeof(std::uint64_t), 0, sizeof(std::uint64_t));
  if (qdot::detail::checksum(qdot::detail::empty_checksum, copy.data(), copy.size()) != header[5]) refuse("its checksum is wrong");
  if (header[1] != owner) refuse("it belongs to another library, or to the other interface");
  const bool fits = header[2] == variables.all.size() && (header[3] == 0 || header[3] == static_cast<std::uint64_t>(variables.size)) &&
                    (header[4] == 0 || header[4] == variables.guards.size()) &&
                    bytes.size() == sizeof header + (4 + header[2] + header[3] + header[4]) * sizeof(double);
  if (!fits) refuse("it has another length");
  std::vector<double> numbers((bytes.size() - sizeof header) / sizeof(double));
  std::memcpy(numbers.data(), bytes.data() + sizeof header, numbers.size() * sizeof(double));
  const double* at = numbers.data();
  Snapshot s;
  s.mode = static_cast<Mode>(static_cast<int>(*at++));
  s.t = *at++;
  s.stop_time = *at++;
  s.tolerance = *at++;
  s.set.assign(at, at + header[2]);
  at += header[2];
  s.y = Eigen::Map<const Eigen::VectorXd>(at, static_cast<Eigen::Index>(header[3]));
  at += header[3];
  for (std::size_t i = 0; i < header[4]; ++i) s.fired.push_back(*at++ != 0.0);
  return s;
}

}  // namespace qdot::fmi
