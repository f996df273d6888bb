#pragma once
// SPDX-License-Identifier: MIT
//
// The projection by lines that a form keeps in a long run. effects/rows/kept_projection.ipp makes it.

#include <memory>
#include <span>

#include "qdot/effects/projection_report.hpp"
#include "qdot/mechanics/derive/kept_equations.hpp"

namespace qdot::detail {

/// Back onto the constraints after a step. Several threads may ask at once.
struct AnyProjection {
  virtual ~AnyProjection() = default;
  /// Projects y = [q; q̇; z]. False, with y unchanged, far from the constraints, in other phases and near dependent rows: effects/projection.hpp takes these.
  virtual bool project(double t, double* y, std::span<const double> phases, ProjectionReport& report) const = 0;
};
/// That of a form with constraints in some phases; null where functors cannot be recorded, or constraints are not linear in velocities.
template <class = void>
std::unique_ptr<AnyProjection> projection_by_lines(const RecordableForm& form, std::span<const double> phases);

/// To derive and to translate its lines takes as long as a hundred projections.
using KeptProjection = KeptOfLongRun<AnyProjection, 100>;

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template std::unique_ptr<AnyProjection> projection_by_lines<void>(const RecordableForm&, std::span<const double>);
}  // namespace qdot::detail
#else
#include "qdot/effects/rows/kept_projection.ipp"
#endif
