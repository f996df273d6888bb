#pragma once
// SPDX-License-Identifier: MIT
//
// The loop behind simulate() (integrate/driver/driver.hpp), as a function: one for runs with and without events, and with and without an observer,
// which are compiled once in a program, or in the library (qdot::compiled).

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "qdot/integrate/driver/driver.hpp"

namespace qdot::detail {

// run ← from (t₀, y₀) to t_end.
template <bool watches, bool is_observed>
void drive(Run<>& run, const DrivenForm& system, AnyStepper stepper, const Options& options, const Budget& budget, Onlooker onlooker,
           std::vector<ListedEvent> events, double t0, const Eigen::VectorXd& y0, double t_end) {
  Driver<watches, is_observed>(run, system, std::move(stepper), options, budget, onlooker, std::move(events)).run(t0, y0, t_end);
}

#ifdef QDOT_COMPILED
extern template void drive<false, false>(Run<>&, const DrivenForm&, AnyStepper, const Options&, const Budget&, Onlooker,
                                         std::vector<ListedEvent>, double, const Eigen::VectorXd&, double);
extern template void drive<false, true>(Run<>&, const DrivenForm&, AnyStepper, const Options&, const Budget&, Onlooker,
                                        std::vector<ListedEvent>, double, const Eigen::VectorXd&, double);
extern template void drive<true, false>(Run<>&, const DrivenForm&, AnyStepper, const Options&, const Budget&, Onlooker,
                                        std::vector<ListedEvent>, double, const Eigen::VectorXd&, double);
extern template void drive<true, true>(Run<>&, const DrivenForm&, AnyStepper, const Options&, const Budget&, Onlooker,
                                       std::vector<ListedEvent>, double, const Eigen::VectorXd&, double);
#endif

}  // namespace qdot::detail
