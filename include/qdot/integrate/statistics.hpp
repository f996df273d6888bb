#pragma once
// SPDX-License-Identifier: MIT
//
// Statistics: what a run did, in numbers that are the same on every machine, and its wall time.
//
// Two of them answer most questions about a slow run. `rejected` beside `steps`: many failed error
// tests mean that the solution changes faster than its past suggests (jumps, impacts); many failed
// correctors mean stiffness that the Jacobian does not explain. And `limited_by`: an adaptive
// method chooses h so that the weighted local errors
//
//     eᵢ / (rtol |yᵢ| + atolᵢ)
//
// pass a test, and the component with the largest of them is the one that made the step so small.
// These components are counted over all steps: the largest count names the coordinate whose tolerance costs the time.

#include <algorithm>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace qdot {

/// Cost of a run, and which components caused it. Times in the units of t, except wall_seconds.
struct Statistics {
  std::string method;               ///< e.g. "cvode_bdf"; all that took part, in their order, where a method chose among others
  std::string method_reason = {};   ///< why these; empty where the user chose
  std::string evaluated_by = {};    ///< by which of the ways to M and r the last state was evaluated, and why (mechanics/by.hpp); empty where there is no T
  long steps = 0;                   ///< accepted steps
  long rejected_by_error_test = 0;  ///< attempts whose local error was too large
  long rejected_by_corrector = 0;   ///< attempts whose implicit equations did not converge
  long evaluations = 0;             ///< right-hand sides
  long jacobians = 0;               ///< ∂f/∂y, each about as dear as size() right-hand sides
  long linear_setups = 0;           ///< factorizations
  long restarts = 0;                ///< fresh starts after t₀, at stop times and jumps
  long projections = 0;             ///< states put back onto constraints
  double constraint_residual = 0.0; ///< largest |φ| after a projection
  double constraint_velocity = 0.0; ///< largest |φ̇| or |a| after a projection
  double mass_rcond = 1.0;          ///< least rcond(M) that was seen (integrate/watch/any_watch.ipp); 1 where it was not computed
  double mass_rcond_time = 0.0;     ///< when
  double constraint_rcond = 1.0;    ///< least rcond of J M⁻¹ Jᵀ that was seen; below 1e-10 constraints depend on each other
  double constraint_rcond_time = 0.0;  ///< when
  double energy_drift = 0.0;        ///< largest |h − h(t₀)| that was seen, where T and V conserve h; restarts begin anew
  double energy_allowed = 0.0;      ///< what the tolerances allowed for it; 0 where it was not computed
  double time_resolution = 0.0;     ///< what time brings within less may have been missed (integrate/watch/time_watch.hpp); 0: formulas, all looked at
  long unresolved_events =
      0;  ///< steps in which an event's function could not be followed, or touched zero (integrate/driver/event_finder.hpp): some may be missed
  double unresolved_event_time = 0.0;  ///< when that happened first
  double wall_seconds = 0.0;        ///< of the whole run, by a monotonic clock
  double first_step = 0.0;          ///< |h| of the first accepted step
  double last_step = 0.0;           ///< |h| of the last accepted step
  double smallest_step = std::numeric_limits<double>::infinity();  ///< least |h| of all but cut-off steps
  int last_order = 0;                                              ///< of the last accepted step
  int highest_order = 0;                                           ///< of all accepted steps
  std::vector<long> limited_by;  ///< per component: in how many steps its weighted local error was the largest

  /// All attempts that were thrown away.
  long rejected() const noexcept { return rejected_by_error_test + rejected_by_corrector; }

  /// Index of the component that limited the most steps; −1 if none did.
  std::ptrdiff_t limiting_component() const noexcept {
    const auto most = std::max_element(limited_by.begin(), limited_by.end());
    return most == limited_by.end() || *most == 0 ? -1 : most - limited_by.begin();
  }
};

}  // namespace qdot
