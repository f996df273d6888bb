#pragma once
// SPDX-License-Identifier: MIT
//
// Which process does which chunk, where several work on one sweep.
//
// --shard K/N is a fixed share, every N-th chunk from the K-th on, and nothing else. It is for machines that have no file system in common, whose records
// are brought together later. With --shard auto, the process is one of several that work on the same directory. It begins with its share, and then does
// what is left of the others'. Its number is read from the environment, where MPI or Slurm has put it; without one there it is an error, and not a guess. A
// sweep that is not shared is refused where the environment has such a number. Otherwise each of the processes would do all of it, and they would write the
// same files at the same time.

#include <cstddef>
#include <string>

namespace qdot::program {

/// Which chunks a process takes: first, first + of, first + 2 of, … and then the others; or only these.
struct SweepShare {
  std::size_t first = 0, of = 1;
  bool only = false;
};

/// The share that --shard asks for, K/N or auto.
///
/// @throws UsageError
SweepShare sweep_share(const std::string& text);

/// The variable by which MPI or Slurm says that it has started several processes, "OMPI_COMM_WORLD_SIZE is 4"; empty where it has not.
std::string said_of_others();

}  // namespace qdot::program
