#pragma once
// SPDX-License-Identifier: MIT
//
// How fast motions of a scene part, for the commands that ask: lyapunov and sweep.

#include <functional>
#include <memory>
#include <string>

#include "program/runnable_scene.hpp"
#include "program/simulation.hpp"
#include "qdot/analysis/generalized_alignment_index.hpp"
#include "qdot/analysis/lyapunov.hpp"

namespace qdot::program {

/// Why a model's motions have no derivatives here; empty where they have.
std::string lacks_exponents(const Model& model);

/// Of the motion from request.start to request.t_end by Dop853, with request's tolerances.
///
/// @param reached  called with the time at the beginning of each piece
LyapunovSpectrum exponents_of(const std::shared_ptr<const Model>& model, const Request& request, const LyapunovOptions& options,
                              const std::function<void(double)>& reached = [](double) {});

/// Likewise; it ends early where there is chaos.
GeneralizedAlignmentIndex gali_of(const std::shared_ptr<const Model>& model, const Request& request);

}  // namespace qdot::program
