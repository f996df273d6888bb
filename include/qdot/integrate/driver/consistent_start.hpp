#pragma once
// SPDX-License-Identifier: MIT
//
// A run begins on its constraints. A start may be off them by rounding, not by more: that would be another problem than the one
// that was given, and the user has to see it. consistent_state() of effects/projection.hpp finds a start that fits.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "qdot/error.hpp"
#include "qdot/integrate/options.hpp"

namespace qdot::detail {

// y0 ← the nearest state on the constraints; `projected` is room to work in.
//
// @throws InvalidValue  when that is farther away than rounding
template <class Form>
void require_consistent(const Form& system, double t0, Eigen::VectorXd& y0, Eigen::VectorXd& projected) {
  projected = y0;
  system.project(t0, projected);
  const auto size_of = [&](Eigen::Index begin, Eigen::Index count) {  // 1 and more, unless all of a kind are small
    const double most = count > 0 ? y0.segment(begin, count).cwiseAbs().maxCoeff() : 0.0;
    return most > 0.0 && most < 1e-3 ? most : 1.0;
  };
  const Eigen::Index n = std::min<Eigen::Index>(system.dof(), y0.size() / 2);
  const double place = size_of(0, n), speed = size_of(n, n);
  double moved = 0.0;
  Eigen::Index worst = 0;
  for (Eigen::Index i = 0; i < y0.size(); ++i)
    if (const double part = std::abs(projected[i] - y0[i]) / ((i < n ? place : i < 2 * n ? speed : 1.0) + std::abs(y0[i])); part > moved) {
      moved = part;
      worst = i;
    }
  constexpr double rounding = 1e-6;  // what hand-typed initial values with seven digits are good for
  if (moved > rounding)
    throw InvalidValue(sentence({"a start must satisfy the constraints, but ", system.component_name(worst), " = ", y0[worst], " would have to be ",
                                 projected[worst], "; take consistent_state(scene, start).state"}));
  y0 = projected;
}

}  // namespace qdot::detail
