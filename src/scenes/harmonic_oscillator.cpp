// SPDX-License-Identifier: MIT
#include "scenes/harmonic_oscillator.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_harmonic_oscillator() { return runnable(scenes::harmonic_oscillator()); }

}  // namespace qdot::program
