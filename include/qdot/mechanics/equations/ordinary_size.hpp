#pragma once
// SPDX-License-Identifier: MIT
//
// Beside what a number of unknown unit is small.
//
// Where an algorithm needs a length and has only a coordinate, 1 is right for angles and for metres of a pendulum, and wrong for a molecule, whose
// whole motion is 1e-10. So a coordinate of ordinary size, or of none, counts as at least 1, and a small one as what it is.

#include <algorithm>

namespace qdot::detail {

inline constexpr double ordinary_size = 1e-3;

/// What changes of a number of this size are compared with; size ≥ 0.
inline double reach_of(double size) { return size > 0.0 && size < ordinary_size ? size : std::max(1.0, size); }

}  // namespace qdot::detail
