#pragma once
// SPDX-License-Identifier: MIT
//
// A run of any model with its derivatives, compiled once for all scenes.
//
// The variational equations of the library (analysis/variations/equations.hpp) on the Model that commands see. ∂f/∂y is exact. ∂f/∂p is differenced between
// seven models, with order six and from values that are exact to rounding, to some twelve digits. Impacts, friction and constraints are those of the
// library. Taylor and Gauss take the graphs of these models in place of f (analysis/variations/recorder.hpp).

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "program/runnable_scene.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"

namespace qdot::program {

/// What a motion is differentiated by: q and q̇ at the start, 2n columns, if wanted; then the parameters.
struct VariedModel {
  std::shared_ptr<const Model> model;
  bool with_start = true;
  std::vector<double> parameters = {};
  std::function<std::shared_ptr<const Model>(Eigen::Index j, double value)> with_parameter = {};  // the model with another value of parameter j
  // [q; q̇; z] as it was given, which the constraints may still move, and with another value of parameter j; none for y0 itself, whatever the parameters are.
  std::function<Eigen::VectorXd(Eigen::Index j, double value)> given = {};
};

/// What takes the steps.
struct VariedMethod {
  std::string name = "dop853";
  double step = 0.0;  // of gauss2 … gauss8
};

struct VariedMotion {
  Outcome outcome = Outcome::completed;
  std::string message;
  double t = 0.0;
  Eigen::VectorXd y, ydot;                  // the last good state
  Eigen::MatrixXd Phi;                      // ∂y/∂(start, parameters) there
  std::vector<double> times;                // Options::output_times
  std::vector<Eigen::VectorXd> samples;     // [y; columns of Φ] at them
};

/// The motion from y at t0 and its derivatives.
///
/// @throws Error  as sensitivities() of the library; InvalidValue for a method that does not fit
VariedMotion varied_motion(const VariedModel& of, double t0, const Eigen::VectorXd& y0, double t_end, Options options, const VariedMethod& method = {});

/// Why a method cannot run a model with its derivatives, as a sentence without its subject; "" where it can.
std::string variation_misfit(const Model& model, const std::string& method);

/// The methods that can.
std::vector<std::string> varying_methods(const Model& model);

/// y with the phases of contacts and friction that its q and q̇ have, and on the constraints.
Eigen::VectorXd settled(const Model& model, double t, Eigen::VectorXd y);

}  // namespace qdot::program
