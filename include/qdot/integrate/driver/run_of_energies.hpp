#pragma once
// SPDX-License-Identifier: MIT
//
// A run of a system of few coordinates, whose T and V are behind virtual functions (mechanics/derive/any_energies.hpp).
//
// What a run does depends on the number of coordinates, not on T and V. So it is compiled once for each number: in the library (qdot::compiled), or in a
// program for all its systems.

#include <memory>

#include "qdot/integrate/driver/run_request.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/mechanics/derive/any_energies.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot::detail {

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
#include "qdot/integrate/driver/run_of_energies.ipp"
#endif
