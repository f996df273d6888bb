// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench scenes`: chains with damping and a guided tip, whose energies are summed with a plain `for`: in a run, and derived when the
// object is made.
#include <vector>

#include "bench/measured_scenes.hpp"

namespace qdot::bench {

std::vector<SceneRow> looped_chain_scene_rows() {
  std::vector<SceneRow> rows = rows_of_chains<LoopsInARun, 2, 4, 8>();
  return rows;
}

}  // namespace qdot::bench
