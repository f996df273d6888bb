// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench scenes`: chains with damping and a guided tip, whose energies are summed with qdot::unroll; eight links of
// them would take the compiler longer than all other rows.
#include "bench/measured_scenes.hpp"
#include "bench/scenes.hpp"

namespace qdot::bench {

namespace {

template <int n>
void add_rows(std::vector<SceneRow>& rows) {
  using Way = UnrolledEnergies;
  for (const SceneRow& row : rows_of_cases<DampedChain<Way, n>, GuidedChain<Way, n>, DampedGuidedChain<Way, n>>()) rows.push_back(row);
}

}  // namespace

std::vector<SceneRow> unrolled_chain_scene_rows() {
  std::vector<SceneRow> rows;
  add_rows<2>(rows);
  add_rows<4>(rows);
  return rows;
}

}  // namespace qdot::bench
