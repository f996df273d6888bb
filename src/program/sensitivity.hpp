#pragma once
// SPDX-License-Identifier: MIT
//
// How a motion depends on its start and on the numbers that a scene is made of, as a table.

#include <string>
#include <vector>

#include <Eigen/Core>

namespace qdot::program {

/// Something that a motion depends on.
struct DependsOn {
  std::string name, unit;  // "theta at the start", "l"
  double value = 0.0;
};

struct SensitivityTable {
  std::string outcome, message, method;
  double t = 0.0;
  std::vector<std::string> of, units;  // components of the state
  std::vector<DependsOn> to;
  Eigen::VectorXd values;      // of the components at t
  Eigen::MatrixXd derivative;  // a row for each component, a column for each of `to`
  Eigen::MatrixXd error;       // of its entries, estimated
};

}  // namespace qdot::program
