// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench scenes`: chains with damping and a guided tip, whose plain `for` is written out while compiling.
#include "bench/measured_scenes.hpp"

namespace qdot::bench {

std::vector<SceneRow> written_out_chain_scene_rows() { return rows_of_chains<WrittenOutEnergies, 2, 4, 8>(); }

}  // namespace qdot::bench
