#pragma once
// SPDX-License-Identifier: MIT
//
// Functions that machine code calls: lines that are no arithmetic, by the operations of the interpreter (ad/formula/lines.hpp).

#include <cstddef>

#include "qdot/ad/formula/lane_lines.hpp"
#include "qdot/ad/formula/lines.hpp"

namespace qdot::formula {

/// Carries out lines on numbers; does not throw.
inline void carry_out_calls(double* x, const Line* lines, std::size_t count) noexcept {
  for (const Line* l = lines; l != lines + count; ++l)
    x[l->to] = l->operation == Line::Operation::power ? raised(x[l->a], l->c) : value_of(l->function, x[l->a], x[l->b]);
}
/// Likewise in some lanes of each number.
template <std::size_t lanes>
void carry_out_lane_calls(double* x, const Line* lines, std::size_t count) noexcept {
  for (const Line* l = lines; l != lines + count; ++l) {
    double *const to = x + lanes_stored * l->to, *const a = x + lanes_stored * l->a, *const b = x + lanes_stored * l->b;
    for (std::size_t k = 0; k < lanes; ++k) to[k] = l->operation == Line::Operation::power ? raised(a[k], l->c) : value_of(l->function, a[k], b[k]);
  }
}

}  // namespace qdot::formula
