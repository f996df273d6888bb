#pragma once
// SPDX-License-Identifier: MIT
//
// The loop behind simulate() (integrate/driver/driver.hpp), as a function: one for runs with and without events, and with and without an observer,
// which are compiled once in a program, or in the library (qdot::compiled).

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/driver/listed_event.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/steps/watch_budget.hpp"
#include "qdot/integrate/watch/driven_form.hpp"

namespace qdot::detail {

// run ← from (t₀, y₀) to t_end.
template <bool watches, bool is_observed>
void drive(Run<>& run, const DrivenForm& system, AnyStepper stepper, const Options& options, const Budget& budget, Onlooker onlooker,
           std::vector<ListedEvent> events, double t0, const Eigen::VectorXd& y0, double t_end);

/// A run that is taken in stretches, of which only the end is kept.
struct StretchedRun {
  virtual ~StretchedRun() = default;
  /// Goes from (t, y) to t_end; events that stopped the stretch before do so again only when they come again.
  virtual void stretch(double t, const Eigen::VectorXd& y, double t_end, std::uint64_t stopped_by) = 0;
  /// The events that have stopped the last stretch, bit by bit.
  virtual std::uint64_t stopped_by() const = 0;
  virtual const Statistics& statistics() const noexcept = 0;
};
template <bool watches>
std::unique_ptr<StretchedRun> stretched_run(Run<>& run, const DrivenForm& system, AnyStepper stepper, const Options& options, const Budget& budget,
                                            std::vector<ListedEvent> events);

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template void drive<false, false>(Run<>&, const DrivenForm&, AnyStepper, const Options&, const Budget&, Onlooker,
                                         std::vector<ListedEvent>, double, const Eigen::VectorXd&, double);
extern template void drive<false, true>(Run<>&, const DrivenForm&, AnyStepper, const Options&, const Budget&, Onlooker,
                                        std::vector<ListedEvent>, double, const Eigen::VectorXd&, double);
extern template void drive<true, false>(Run<>&, const DrivenForm&, AnyStepper, const Options&, const Budget&, Onlooker,
                                        std::vector<ListedEvent>, double, const Eigen::VectorXd&, double);
extern template void drive<true, true>(Run<>&, const DrivenForm&, AnyStepper, const Options&, const Budget&, Onlooker,
                                       std::vector<ListedEvent>, double, const Eigen::VectorXd&, double);
extern template std::unique_ptr<StretchedRun> stretched_run<false>(Run<>&, const DrivenForm&, AnyStepper, const Options&, const Budget&,
                                                                   std::vector<ListedEvent>);
extern template std::unique_ptr<StretchedRun> stretched_run<true>(Run<>&, const DrivenForm&, AnyStepper, const Options&, const Budget&,
                                                                  std::vector<ListedEvent>);
}  // namespace qdot::detail
#else
#include "qdot/integrate/driver/drive.ipp"
#endif
