#pragma once
// SPDX-License-Identifier: MIT
//
// What a projection onto the constraints did (projection.hpp): plain numbers, for code that only reads them.

#include <cstddef>
#include <limits>

namespace qdot {

namespace detail::projection_limits {

inline constexpr double roundings_of_a_row = 64;           // up to which rounding explains a residual φ
inline constexpr double roundings_of_a_coordinate = 1000;  // by which such a residual may move a coordinate
inline constexpr double small_part = 1e-3;                 // of the length of a row of J: below it all coordinates of the row are small
inline constexpr double rounding_of_zero = 1e-22;          // of that length
inline constexpr double at_rounding = 8 * std::numeric_limits<double>::epsilon();  // a change of coordinates, beside 1 + |q|
inline constexpr double may_stand_still = 1e-10;           // a change that may be rounding, if it does not shrink

}  // namespace detail::projection_limits

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
