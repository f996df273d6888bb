#pragma once
// SPDX-License-Identifier: MIT
//
// The projection by lines that is kept with the lines of q̈ (mechanics/derive/kept_rates.hpp). effects/rows/kept_projection.ipp makes it.

#include <memory>
#include <span>

#include "qdot/effects/projection_report.hpp"
#include "qdot/mechanics/derive/kept_rates.hpp"

namespace qdot::detail {

/// Back onto the constraints after a step. Several threads may ask at once.
struct AnyProjection : AnyRates::Attached {
  /// Projects y = [q; q̇; z]. False, with y unchanged, far from the constraints, in other phases and near dependent rows: effects/projection.hpp takes these.
  virtual bool project(double t, double* y, std::span<const double> phases, ProjectionReport& report) const = 0;
};
/// The projection of the functors whose lines of q̈ these are. Without constraints, and with constraints that are not linear in velocities, its project()
/// returns false.
template <class = void>
std::unique_ptr<const AnyProjection> projection_by_lines(const AnyRates& rates);

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template std::unique_ptr<const AnyProjection> projection_by_lines<void>(const AnyRates&);
}  // namespace qdot::detail
#else
#include "qdot/effects/rows/kept_projection.ipp"
#endif
