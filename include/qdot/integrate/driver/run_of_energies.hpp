#pragma once
// SPDX-License-Identifier: MIT
//
// A run of a system of few coordinates, whose T and V are behind virtual functions (mechanics/derive/any_energies.hpp).
//
// What a run does depends on the number of coordinates, not on T and V. So it is compiled once for each number: in the library (qdot::compiled), or in a
// program for all its systems.

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/driver/drive.hpp"
#include "qdot/integrate/driver/listed_event.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/watch/any_form.hpp"
#include "qdot/integrate/steps/watch_budget.hpp"
#include "qdot/integrate/watch/driven_form.hpp"
#include "qdot/mechanics/derive/any_energies.hpp"
#include "qdot/mechanics/system.hpp"

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
  AnyStepper (*stepper)(std::unique_ptr<Rates> rates, std::unique_ptr<Rates> projected, std::string name, const Options& options);
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
struct Engine;  // integrate/driver/engine.hpp

/// Runs of systems with n coordinates.
///
/// @tparam timed  T or V takes the time
template <int n, bool timed>
struct RunOfEnergies {
  static Run<n> by(const MethodOfRates& method, AnyEnergies<n, timed> energies, const SystemParts& parts, const StartNumbers& start,
                   const RunRequest& request);
  static std::unique_ptr<Engine> engine(const MethodOfRates& method, AnyEnergies<n, timed> energies, const SystemParts& parts, double t0,
                                        const StartNumbers& start, const EngineRequest& request);
  /// Defined in integrate/driver/any_form_of.hpp, which methods include that need it.
  static Run<n> by(const MethodOfForm& method, AnyEnergies<n, timed> energies, const SystemParts& parts, const StartNumbers& start,
                   const RunRequest& request);
  static std::unique_ptr<Engine> engine(const MethodOfForm& method, AnyEnergies<n, timed> energies, const SystemParts& parts, double t0,
                                        const StartNumbers& start, const EngineRequest& request);
};

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template struct RunOfEnergies<1, false>;
extern template struct RunOfEnergies<1, true>;
extern template struct RunOfEnergies<2, false>;
extern template struct RunOfEnergies<2, true>;
extern template struct RunOfEnergies<3, false>;
extern template struct RunOfEnergies<3, true>;
extern template struct RunOfEnergies<4, false>;
extern template struct RunOfEnergies<4, true>;
extern template struct RunOfEnergies<5, false>;
extern template struct RunOfEnergies<5, true>;
extern template struct RunOfEnergies<6, false>;
extern template struct RunOfEnergies<6, true>;
extern template struct RunOfEnergies<7, false>;
extern template struct RunOfEnergies<7, true>;
extern template struct RunOfEnergies<8, false>;
extern template struct RunOfEnergies<8, true>;
}  // namespace qdot::detail
#else
#include "qdot/integrate/driver/run_of_form.hpp"
#endif
