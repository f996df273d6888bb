#pragma once
// SPDX-License-Identifier: MIT
//
// The command line: what was typed, turned into a command's options.

#include "program/commands.hpp"

namespace qdot::program {

/// Runs the command that the arguments name, on the scenes that are linked in (catalogue.hpp), and turns every error into one line on
/// stderr and an exit status. Where only one scene is linked in, its name may be left away.
///
/// @param bench  `qdot bench`; there is no such command without it
int command_line(int argc, char** argv, int (*bench)(const BenchOptions&) = nullptr);

}  // namespace qdot::program
