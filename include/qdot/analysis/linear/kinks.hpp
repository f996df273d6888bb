#pragma once
// SPDX-License-Identifier: MIT
//
// Where T, V or a force has a kink, the equations have two slopes, one on each side, and a linearization has none.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/integrate/steps/neighbouring_branches.hpp"

namespace qdot::detail {

// At a state where a functor compares equal numbers and its branches have other slopes.
//
// @throws InvalidValue  there
template <class Form>
void require_no_kink([[maybe_unused]] const char* who, [[maybe_unused]] const Form& form, [[maybe_unused]] Eigen::Index dof, [[maybe_unused]] double t,
                     [[maybe_unused]] const Eigen::VectorXd& y) {
  if constexpr (has_branches_recorded<Form>) {
    const RunFunctors run = [&](RecordedBranch& branch) { run_functors(branch, form); };
    const auto here = recorded_branch(dof, t, y, run);
    const auto& guards = here->branches.met;
    std::vector<double> at;
    number_variables(dof, t, y, at);
    for (std::size_t k = 0; k < guards.size(); ++k) {
      std::vector<int> nodes = here->motion.recording.graph.gradient(guards[k].node, here->variables());
      nodes.push_back(guards[k].node);
      const std::vector<double> values = here->values(nodes, at);
      double size = 0.0;
      for (Eigen::Index i = 0; i < y.size(); ++i) size += std::abs(values[static_cast<std::size_t>(i)] * y[i]);
      if (!(std::abs(values.back() - guards[k].level) <= 16 * std::numeric_limits<double>::epsilon() * size)) continue;
      if (!differ(*here, *neighbour(*here, k, dof, t, y, run), at, 1)) continue;
      std::string place;
      for (Eigen::Index i = 0; i < std::min<Eigen::Index>(y.size(), 4); ++i)
        place += sentence({i > 0 ? ", " : "", form.component_name(i), " = ", {y[i], 6}});
      throw_invalid_value({who, ": the equations must have slopes at the state, but at ", place, " ", guards[k].what,
                           " is a tie, and on its two sides the slopes differ; take a state beside it, or a smooth function"});
    }
  }
}

}  // namespace qdot::detail
