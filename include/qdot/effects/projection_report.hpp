#pragma once
// SPDX-License-Identifier: MIT
//
// What a projection onto the constraints did (projection.hpp): plain numbers, for those who only want to read them.

#include <cstddef>

namespace qdot {

/// What a projection did.
struct ProjectionReport {
  double moved_q = 0.0;            ///< largest change of a coordinate
  double moved_qdot = 0.0;         ///< largest change of a velocity
  double residual_before = 0.0;    ///< largest |φ|
  double residual = 0.0;           ///< the same afterwards
  double velocity_residual = 0.0;  ///< largest |J q̇ + ∂φ/∂t| or |a| afterwards
  int iterations = 0;              ///< of Newton's method
  std::ptrdiff_t rank = 0;         ///< of the constraints at the projected state
};

}  // namespace qdot
