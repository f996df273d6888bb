#pragma once
// SPDX-License-Identifier: MIT
//
// A run for tests of motion: CVODE at tolerances where what is left is rounding and a few hundred steps' worth of it.

#include <cmath>
#include <numbers>

#include "catch2_bridge.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/mechanics/energy.hpp"

namespace qdot::motion {

inline const Options sharp{.rtol = 1e-13, .atol = 1e-14};

template <class System, int n>
auto run(const System& system, const State<n>& start, double t_end) {
  auto result = simulate(system, start, t_end, CvodeAdams{}, sharp);
  INFO(result.message);
  REQUIRE(result.completed());
  return result;
}

// The complete elliptic integral K of the parameter m, by the arithmetic-geometric mean.
inline double elliptic_K(double m) {
  double a = 1.0, b = std::sqrt(1.0 - m);
  while (std::abs(a - b) > 1e-15 * a) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return std::numbers::pi / (2.0 * a);
}

// The time at which component i of the trajectory is zero between a and b, by bisection on the dense output.
template <int n>
double zero_of(const Trajectory<n>& trajectory, Eigen::Index i, double a, double b) {
  const double sign = trajectory.y(a)[i] < 0.0 ? -1.0 : 1.0;
  for (int k = 0; k < 100; ++k) {
    const double middle = 0.5 * (a + b);
    (trajectory.y(middle)[i] * sign > 0.0 ? a : b) = middle;
  }
  return 0.5 * (a + b);
}

}  // namespace qdot::motion
