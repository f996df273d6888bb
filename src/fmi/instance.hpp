#pragma once
// SPDX-License-Identifier: MIT
//
// One instance of a scene that an importer simulates by FMI 3.0 (fmi3.hpp).
//
// All that its future depends on is a Snapshot: the mode, t, y, and the values that the importer has set. A state in FMI's sense is a copy of it, and
// serialized it is its numbers behind a header with a checksum. What is behind y (the scene with its parameters, its equations, the simulator) is made of
// the snapshot anew where a parameter changes.
//
//     set parameters, starts and inputs → initialize: y = [q; q̇; z] of the scene, moved onto the constraints, phases chosen
//
//     Model Exchange    the importer asks for ẏ(t, y) and ∂ẏ/∂y, both exact, and for guards; where one falls through zero, update() takes the blow or
//                       changes the phase
//     Co-Simulation     a Simulator with Dop853 goes from one communication point to the next, through all events; where the importer can handle it, it stops
//                       at each: step() returns there early
//
// Nothing is shared between instances. Refusals leave everything as it was. A value that is not physical, a state that has no derivative and a step that cannot
// be completed are Refusal{fmi3Discard}, and one may go on with others. A call that FMI does not allow is Refusal{fmi3Error}. The
// functions of fmi3.cpp make statuses and log messages of them.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fmi/fmi3.hpp"
#include "fmi/variables.hpp"

namespace qdot::fmi {

/// Relative and absolute, where the importer gives none.
inline constexpr double default_tolerance = 1e-9;

struct LogCategory {
  const char* name;
  const char* description;
};
inline constexpr std::array<LogCategory, 4> log_categories = {{{"logStatusError", "a call that was not allowed, or a fault"},
                                                               {"logStatusDiscard", "what was refused with nothing changed"},
                                                               {"logStatusWarning", "what was done but may not be what was meant"},
                                                               {"logEvents", "impacts, contacts, friction: what happened and when"}}};

/// Why a call was not answered.
struct Refusal {
  fmi3Status status;
  std::string message;
};

/// A value, a state or a step that has no answer: one may go on with others.
[[noreturn]] inline void discard(const std::string& message) { throw Refusal{fmi3Discard, message}; }

/// A call that FMI does not allow.
[[noreturn]] inline void forbid(const std::string& message) { throw Refusal{fmi3Error, message}; }

enum class Mode { instantiated, initialization, event, continuous_time, step, terminated };

/// Where an instance is.
struct Snapshot {
  Mode mode = Mode::instantiated;
  double t = 0.0, stop_time = std::numeric_limits<double>::infinity(), tolerance = default_tolerance;
  std::vector<double> set;  // by value reference; NaN for what the importer has not set
  Eigen::VectorXd y;        // nothing before it has been asked for
  std::vector<bool> fired;  // guards that stopped the last step, whose consequences are still to come
};

class Instance {
 public:
  enum class Interface { model_exchange, co_simulation };

  /// @throws InvalidValue  the scene contradicts itself
  Instance(const Variables& variables, Interface interface, bool event_mode_used, bool early_return_allowed);
  ~Instance();

  /// What happened since the last call of it, for the log: category and words.
  std::vector<std::pair<const char*, std::string>> news() { return std::exchange(news_, {}); }

  Interface interface() const { return interface_; }
  bool has_event_mode() const { return event_mode_used_; }
  Mode mode() const { return now_.mode; }
  const Variables& variables() const { return variables_; }
  void end() { now_.mode = Mode::terminated; }

  void enter_initialization(const double* tolerance, double start_time, const double* stop_time);
  void exit_initialization();
  void enter(Mode mode) { now_.mode = mode; }
  void reset();

  /// The value of a variable, whatever its type.
  double value(std::size_t reference);

  /// Sets all or none.
  void set(std::span<const fmi3ValueReference> references, std::span<const double> values);

  struct Update {
    bool terminate = false, states_changed = false;
  };
  /// Takes the consequences of guards that have fallen through zero.
  Update update();

  // Model Exchange.
  void set_time(double t);
  void set_states(std::span<const double> states);
  /// Whether the state has drifted off the constraints so far that it had better be moved back.
  bool has_drifted();

  /// ∂unknown/∂known of each pair, a row for each unknown; exact.
  Eigen::MatrixXd derivatives(std::span<const fmi3ValueReference> unknowns, std::span<const fmi3ValueReference> knowns);

  // Co-Simulation.
  struct Step {
    bool event_handling_needed = false, terminate = false, early = false;
    double t = 0.0;
  };
  Step step(double from, double length);

  Snapshot snapshot() const { return now_; }
  void restore(const Snapshot& snapshot);

 private:
  struct Behind;  // the scene, its equations, the simulator

  const Variable& variable(fmi3ValueReference reference) const;
  double setting(std::size_t reference, const Snapshot& at) const;
  std::unique_ptr<Behind> behind(const Snapshot& at) const;
  Eigen::VectorXd start(const Behind& behind, const Snapshot& at);
  void make_plant(Behind& behind, const Snapshot& at) const;
  bool has_scene_of(const Snapshot& other) const;
  void ready();
  void moved() { rates_known_ = jacobian_known_ = false; }
  const Eigen::VectorXd& rates();
  Eigen::VectorXd guards() const;
  Eigen::VectorXd tolerances() const;
  void settle(const std::vector<bool>& fired);

  const Variables& variables_;
  Interface interface_;
  bool event_mode_used_, early_return_allowed_;
  Snapshot now_;
  std::unique_ptr<Behind> behind_;
  bool is_ready_ = false;
  int standing_ = 0;  // steps one after the other that ended where they began
  bool rates_known_ = false, jacobian_known_ = false;
  Eigen::VectorXd rates_;
  Eigen::MatrixXd jacobian_;
  std::vector<std::pair<const char*, std::string>> news_;
};

/// The bytes of a snapshot; `owner` is a number for the library and the interface.
std::vector<fmi3Byte> serialized(const Snapshot& snapshot, std::uint64_t owner);

/// @throws Refusal  bytes that were cut short, changed, or belong to another library or interface
Snapshot deserialized(std::span<const fmi3Byte> bytes, std::uint64_t owner, const Variables& variables);

}  // namespace qdot::fmi
