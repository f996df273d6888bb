#pragma once
// SPDX-License-Identifier: MIT
//
// What simulate() and a simulator hand to runs whose types of observers, events and methods are hidden: a request, the numbers of the start, and the method.

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/driver/drive.hpp"
#include "qdot/integrate/driver/listed_event.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/steps/watch_budget.hpp"
#include "qdot/integrate/watch/any_form.hpp"
#include "qdot/integrate/watch/driven_form.hpp"

namespace qdot::detail {

/// drive() of a run with or without events, and with or without an observer.
using Drives = void (*)(Run<>& run, const DrivenForm& system, AnyStepper stepper, const Options& options, const Budget& budget, Onlooker onlooker,
                        std::vector<ListedEvent> events, double t0, const Eigen::VectorXd& y0, double t_end);

/// What simulate() was given beside the system, the start and the method.
struct RunRequest {
  double t0, t_end;
  const Options& options;
  Drives drive;
  Onlooker onlooker{};
  std::span<const ListedEvent> events{};
};

/// Numbers of a start: of q and q̇, or all of y in the place of q.
struct StartNumbers {
  bool is_y;
  const double* q;
  Eigen::Index size;
  const double* qdot = nullptr;
  Eigen::Index qdot_size = 0;
};
template <int n, class Start>
StartNumbers numbers_of(const Start& start) {
  if constexpr (requires { start.y; }) {
    return {true, start.y.data(), start.y.size()};
  } else {
    constexpr int given = decltype(start.q)::SizeAtCompileTime;
    static_assert(given == Dynamic || given == n,
                  "qdot: the start is a State of another number of coordinates than the system has: take State<n> with the n of mechanical_system<n>");
    static_assert(decltype(start.q)::InnerStrideAtCompileTime == 1 && decltype(start.qdot)::InnerStrideAtCompileTime == 1,
                  "qdot: q and qdot of a start must have their numbers one after the other: take State<n>");
    return {false, start.q.data(), start.q.size(), start.qdot.data(), start.qdot.size()};
  }
}

/// A method that asks for rates alone: its steppers for so many components.
struct MethodOfRates {
  AnyStepper (*stepper)(std::unique_ptr<Rates> rates, std::string name, const Options& options);
  std::string_view name;
};

/// A method that asks for more: its stepper for a system.
struct MethodOfForm {
  const void* settings;
  AnyStepper (*stepper)(const void* settings, std::shared_ptr<const AnyForm> form, const Options& options);
};

/// What a simulator was given beside the system, the start and the method; it owns the events.
struct EngineRequest {
  const Options& options;
  std::unique_ptr<StretchedRun> (*stretched_run)(Run<>& run, const DrivenForm& system, AnyStepper stepper, const Options& options, const Budget& budget,
                                                 std::vector<ListedEvent> events);
  std::shared_ptr<const void> events{};
  std::vector<ListedEvent> listed{};
};

}  // namespace qdot::detail
