#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of drive.hpp: a run, and a run in stretches, behind virtual functions, which is what a simulator keeps of the driver. A program that links
// qdot::compiled has them from there.

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "qdot/integrate/driver/drive.hpp"
#include "qdot/integrate/driver/driver.hpp"

namespace qdot::detail {

template <bool watches, bool is_observed>
void drive(Run<>& run, const DrivenForm& system, AnyStepper stepper, const Options& options, const Budget& budget, Onlooker onlooker,
           std::vector<ListedEvent> events, double t0, const Eigen::VectorXd& y0, double t_end) {
  Driver<watches, is_observed>(run, system, std::move(stepper), options, budget, onlooker, std::move(events)).run(t0, y0, t_end);
}

template <bool watches>
struct StretchedRunOf final : StretchedRun {
  Driver<watches, false> driver;

  StretchedRunOf(Run<>& run, const DrivenForm& system, AnyStepper stepper, const Options& options, const Budget& budget, std::vector<ListedEvent> events)
      : driver(run, system, std::move(stepper), options, budget, Onlooker{}, std::move(events)) {}
  void stretch(double t, const Eigen::VectorXd& y, double t_end, std::uint64_t stopped_by) override { driver.stretch(t, y, t_end, stopped_by); }
  std::uint64_t stopped_by() const override { return driver.stopped_by(); }
  const Statistics& statistics() const noexcept override { return driver.statistics(); }
};
template <bool watches>
std::unique_ptr<StretchedRun> stretched_run(Run<>& run, const DrivenForm& system, AnyStepper stepper, const Options& options, const Budget& budget,
                                            std::vector<ListedEvent> events) {
  return std::make_unique<StretchedRunOf<watches>>(run, system, std::move(stepper), options, budget, std::move(events));
}

}  // namespace qdot::detail
