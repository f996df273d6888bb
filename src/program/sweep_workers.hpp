#pragma once
// SPDX-License-Identifier: MIT
//
// The workers of a sweep that is kept in a directory: threads of this process, or processes of it with threads.
//
// A process that a motion brings down, or that is killed, leaves its chunk to the others. With threads alone the whole run ends, and what it had
// recorded is there.

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "program/sweep_directory.hpp"

namespace qdot::program {

using MotionRow = std::function<Row(std::size_t)>;       // what comes of motion i, from several threads at once
using RecordedCount = std::function<void(std::size_t)>;  // called with the number of motions that are recorded

struct SweepWorkers {
  int processes = 0;  // beside this one, which waits for them; 0: this one itself
  std::size_t threads = 1;
  SweepShare share = {};
};

/// Does what is missing of a sweep, as far as it is this process's share and not in the hands of others.
///
/// @param motion    what it throws is no result, and ends the work
/// @param reached   called by one thread at a time; may be empty
/// @return          how processes came to their ends that ended before their work
/// @throws          what motion throws, or the directory; what was recorded stays
std::vector<std::string> work_on(SweepDirectory& directory, const MotionRow& motion, const SweepWorkers& workers, const RecordedCount& reached);

}  // namespace qdot::program
