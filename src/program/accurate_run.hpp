#pragma once
// SPDX-License-Identifier: MIT
//
// A run that is asked for an accuracy instead of tolerances.

#include <memory>

#include "program/simulation.hpp"

namespace qdot::program {

/// Runs the model at ever tighter tolerances until the motion as a whole is accurate enough.
///
/// The error of a run is estimated by the next one, whose tolerances are ten times tighter: the largest difference of a
/// component at a sample, relative where the component is larger than 1. The tighter of the two is returned, and
/// request.rtol and atol are those that it took. Costs two runs, and one more for every tenfold that is missing.
///
/// Ends as Outcome::accuracy_not_reached where double has not enough digits for it (chaotic motion over a long time).
Result simulated_to_accuracy(const std::shared_ptr<const Model>& model, Request& request, double accuracy,
                             const Watcher& watcher);

}  // namespace qdot::program
