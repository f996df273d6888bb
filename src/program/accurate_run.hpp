#pragma once
// SPDX-License-Identifier: MIT
//
// A run that is asked for an accuracy instead of tolerances: what qdot/integrate/simulate_to_accuracy.hpp does, for a model.

#include <memory>
#include <string>

#include "program/simulation.hpp"
#include "qdot/integrate/accurate/search.hpp"

namespace qdot::program {

/// Runs the model so accurately that the error of the motion at its samples is at most `accuracy`.
///
/// The error is relative: each component beside its own largest value. Returned is the last of a few runs, with
/// result.accuracy; request.rtol and atol_each are those that it took. Ends as Outcome::accuracy_not_reached where double
/// has not enough digits for it (chaotic motion over a long time).
///
/// @throws InvalidValue  accuracy not between 0 and 1
Result simulated_to_accuracy(const std::shared_ptr<const Model>& model, Request& request, double accuracy,
                             const Watcher& watcher);

/// Two lines on it: "estimated error of the motion 3.1e-10 …" and what more digits would cost.
std::string accuracy_text(const AccuracyReport& report);

}  // namespace qdot::program
