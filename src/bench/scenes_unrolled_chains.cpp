// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench scenes`: chains with damping and a guided tip, whose energies are summed with qdot::unroll; eight links of
// them would take the compiler longer than all other rows.
#include "bench/measured_scenes.hpp"

namespace qdot::bench {

std::vector<SceneRow> unrolled_chain_scene_rows() { return rows_of_chains<UnrolledEnergies, 2, 4>(); }

}  // namespace qdot::bench
