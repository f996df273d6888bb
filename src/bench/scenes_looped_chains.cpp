// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench scenes`: chains with damping and a guided tip, whose energies are summed with a plain `for`, in a run.
#include <vector>

#include "bench/measured_scenes.hpp"

namespace qdot::bench {

std::vector<SceneRow> looped_chain_scene_rows() {
  return rows_in_a_run<DampedChain<LoopedEnergies, 2>, GuidedChain<LoopedEnergies, 2>, DampedGuidedChain<LoopedEnergies, 2>, DampedChain<LoopedEnergies, 4>,
                       GuidedChain<LoopedEnergies, 4>, DampedGuidedChain<LoopedEnergies, 4>, DampedChain<LoopedEnergies, 8>, GuidedChain<LoopedEnergies, 8>,
                       DampedGuidedChain<LoopedEnergies, 8>>();
}

}  // namespace qdot::bench
