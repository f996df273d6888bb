// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench scenes`: chains with damping and a guided tip, whose masses are given by their positions.
#include "bench/measured_scenes.hpp"

namespace qdot::bench {

std::vector<SceneRow> placed_chain_scene_rows() { return rows_of_chains<PlacedMasses, 2, 4, 8>(); }

}  // namespace qdot::bench
