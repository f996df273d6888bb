#pragma once
// SPDX-License-Identifier: MIT
//
// The ways from T and V to M and r, where one wants to choose.
//
// By default the library takes the fastest evaluation that T and V allow. Formulas are recorded once and carried out line by line, at first by
// an interpreter and soon by machine code (mechanics/derive/kept_rates.hpp). All give the same numbers up to rounding. Each can be asked for,
// to compare them, or to find out which one is at fault:
//
//     acceleration(system, q, qdot, t, By::duals)                  one evaluation
//     simulate(system, start, t_end, Dop853{}, {.by = By::duals})   a run
//     const auto plain = system.by(By::duals);                      all that is asked of this copy
//
// Dual numbers are the definition: ∂L/∂q, ∂L/∂q̇ and M by forward-mode dual numbers (ad/dual.hpp), and Eigen solves. They take every functor, are ten to a
// hundred times as slow, and are what the others are tested against. Where T or V cannot be recorded, lines and machine code give way to duals, which
// Statistics::evaluated_by says.

namespace qdot {

/// How M, r and their derivatives are evaluated. `Taylor` cannot use duals and throws InvalidValue; methods of momenta ask for first derivatives only, by dual
/// numbers.
enum class By {
  fastest,      ///< as T and V allow it (the default)
  duals,        ///< forward-mode dual numbers, and Eigen's solution
  lines,        ///< recorded formulas, interpreted
  machine_code  ///< recorded formulas, by machine code from the second evaluation on; interpreted where the system has no executable memory
};

}  // namespace qdot
