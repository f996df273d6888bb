#pragma once
// SPDX-License-Identifier: MIT
//
// One run of one scene, as data: what was asked, and everything that the outputs need to know of it.

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "program/runnable_scene.hpp"
#include "qdot/integrate/accurate/search.hpp"
#include "qdot/integrate/energy_balance.hpp"
#include "qdot/integrate/event.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/statistics.hpp"

namespace qdot::program {

struct Request {
  State<Dynamic> start;
  double t_end = 0;
  std::string method = "auto";
  double rtol = 1e-10;
  double atol = 1e-10;
  Eigen::VectorXd atol_each = {};  // one for each component of y, in place of atol; empty for none
  std::optional<double> step;  // of a method with a fixed step; where there is none, a short pilot run and rtol choose it
  int samples = 500;           // rows of the table, both ends included
  int most_frames = 0;         // of the animation; 0 for none
  bool forces = false;         // whether the animation shows them as arrows
  bool by_is_given = false;
  bool atol_is_given = false;  // by the user; else the run may lower it (integrate/driver/natural_tolerances.hpp)
};

inline AbsoluteTolerance atol_of(const Request& request) {
  return request.atol_is_given ? AbsoluteTolerance(request.atol) : AbsoluteTolerance::at_most(request.atol);
}

/// A state with its energies.
struct Sample {
  double t = 0;
  Eigen::VectorXd y;
  Energies energies;
};

/// How far a conserved quantity strays from its first value, over all accepted steps.
struct Drift {
  double initial = 0;
  double final = 0;
  double largest = 0;  // max |E − E(0)|
  void see(double value);
};

/// What came of it; complete up to the last good state, whatever the outcome.
struct Result {
  Outcome outcome = Outcome::completed;
  std::string message;
  Sample end;
  std::vector<Sample> samples;
  std::vector<Sample> frames;  // energies left empty
  Eigen::VectorXd sizes;       // max |yᵢ| over all accepted steps
  Drift energy;                // T + V
  Drift jacobi;                // q̇·p − L
  std::vector<double> step_times;     // of (a thinned selection of) the accepted steps
  std::vector<double> energy_change;  // E − E(0) there
  std::vector<double> jacobi_change;
  EnergyBalance balance;              // of Jacobi's energy function
  std::vector<RecordedEvent> events;
  Statistics statistics;
  std::optional<double> step;                   // of a method with a fixed one: at most so long
  std::optional<ProjectionReport> start_moved;  // how far a start off the constraints was moved
  std::vector<Reaction> reactions;              // at the end
  std::optional<AccuracyReport> accuracy;  // of the whole motion, where one was asked for
};

/// Names of the methods that `simulated` knows.
std::vector<std::string> method_names();

/// Whether a method makes steps of one length, request.step, and no use of tolerances.
bool has_fixed_step(const std::string& method);

/// Why a method cannot run a model, as a sentence without its subject, "cannot keep constraints"; "" where it can, as far as no functor is run.
std::string misfit(const Model& model, const std::string& method);
/// Why it cannot run a model from a start; a method that needs formulas runs the functors there.
std::string misfit(const Model& model, const std::string& method, const State<Dynamic>& start);
/// Why T, V and the effects of a model are not one formula everywhere, as a sentence without its subject; "" where they are.
std::string formula_misfit(const Model& model);

/// The step of a method with a fixed one, for a request that names none.
///
/// @throws Error  as bare_run()
double chosen_step(const std::shared_ptr<const Model>& model, const Request& request, int order);

/// The methods that can run a model from a start, those that choose among others left out.
std::vector<std::string> fitting_methods(const Model& model, const State<Dynamic>& start);

/// The motion and its cost, and nothing else.
struct BareResult {
  Outcome outcome = Outcome::completed;
  std::string message;
  double t = 0;
  Eigen::VectorXd y;          // the last good state
  std::vector<double> times;  // of the samples, as far as the run came
  Eigen::MatrixXd samples;    // a column for each
  std::vector<RecordedEvent> events;
  Statistics statistics;
};

/// Runs the model without looking at energies or steps, for what compares or times methods.
///
/// @param request  samples = 0 leaves out the table, and with it the dense output; most_frames is not looked at
/// @throws InvalidValue  options outside their range; the method does not fit the model
/// @throws NonFinite, MassMatrixError, ConstraintError  the model has no value at its start
BareResult bare_run(const std::shared_ptr<const Model>& model, const Request& request);

/// A run with an observer, which is shown every accepted step and may return false to end the run.
BareResult followed_run(const std::shared_ptr<const Model>& model, const Request& request, const std::function<bool(const StepView&)>& observer);

/// Called after accepted steps with the time reached.
using Watcher = std::function<void(double t)>;

/// Runs the model. A model that cannot be evaluated at its start is an outcome here, not an exception.
///
/// @throws InvalidValue  options outside their range
Result simulated(const std::shared_ptr<const Model>& model, const Request& request, const Watcher& watcher);

}  // namespace qdot::program
