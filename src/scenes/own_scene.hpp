#pragma once
// SPDX-License-Identifier: MIT
//
// A scene of your own in one file: T, V, and what you care to say about them.
//
//     #include <scenes/own_scene.hpp>
//     using namespace qdot::scenes;
//
//     struct Swing {
//       double l = 1.0;
//       constexpr auto T(const auto& qdot) const { return 0.5 * l * l * qdot[0] * qdot[0]; }
//       constexpr auto V(const auto& q) const { using std::cos; return -9.81 * l * cos(q[0]); }
//     };
//
//     OwnScene qdot_scene() { return runnable(Scene<Swing, 1>{}); }
//
// `qdot run swing.cpp` compiles and runs it; `qdot_add_scene(swing swing.cpp)` makes a program of it in a CMake project. What Scene has
// beside T and V is in scene.hpp; effects that a run may switch on follow it in runnable(…), those that are always there come
// before it in runnable_with(…).

#include <cmath>
#include <memory>
#include <tuple>
#include <vector>

#include "program/effect_variants.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/forces.hpp"
#include "scenes/scene.hpp"

namespace qdot::scenes {

using OwnScene = std::unique_ptr<program::RunnableScene>;

using program::runnable, program::runnable_with;
using report::box, report::disk, report::ellipse, report::in_space, report::line, report::pivot, report::spring, report::trail;

}  // namespace qdot::scenes

/// What a file with a scene defines: the function that makes it.
qdot::scenes::OwnScene qdot_scene();
