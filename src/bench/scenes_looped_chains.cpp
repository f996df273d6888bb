// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench scenes`: chains with damping and a guided tip, whose energies are summed with a plain `for`.
#include "bench/measured_scenes.hpp"

namespace qdot::bench {

std::vector<SceneRow> looped_chain_scene_rows() { return rows_of_chains<LoopedEnergies, 2, 4, 8>(); }

}  // namespace qdot::bench
