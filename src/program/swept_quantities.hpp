#pragma once
// SPDX-License-Identifier: MIT
//
// What a sweep keeps of a motion: NAME at the end, max(NAME), min(NAME), t(NAME=VALUE), t(|NAME|=VALUE), t(event NAME), energy, energy_drift_max, steps, t,
// lyapunov and gali. These are the greatest exponent, and the generalized alignment index of two deviations, to below 1e-8.
//
// Extremes and passages are looked for on the dense output: at eight places in each step, and a passage between two of them to rounding.

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "program/simulation.hpp"

namespace qdot::program {

struct Quantity {
  enum class Kind { at_end, greatest, least, passage, event, energy, energy_drift, steps, time, lyapunov, gali };
  std::string text = {};  // as it was typed
  std::string unit = {};
  Kind kind = Kind::at_end;
  Eigen::Index component = 0;
  bool absolute = false;
  double value = 0.0;
  std::string event = {};
};

/// @throws UsageError
std::vector<Quantity> quantities_of(const std::vector<std::string>& records, const RunnableScene& scene, const Model& model);

/// Looks at one motion.
class QuantityWatch {
 public:
  QuantityWatch(const std::vector<Quantity>& quantities, std::shared_ptr<const Model> model);

  bool wants_steps() const { return wants_steps_; }

  /// False when nothing is left to wait for.
  bool see(const StepView& step);

  /// All of them; NaN for what did not happen. Exponents and indices of alignment are asked of a motion of their own.
  std::vector<double> values(const Request& request, const BareResult& run) const;

 private:
  double off(const Quantity& quantity, const Eigen::Ref<const Eigen::VectorXd>& y) const;

  const std::vector<Quantity>& quantities_;
  std::shared_ptr<const Model> model_;
  bool wants_steps_ = false, only_passages_ = true, begun_ = false;
  double energy_ = 0.0;
  std::vector<double> found_, before_;
};

}  // namespace qdot::program
