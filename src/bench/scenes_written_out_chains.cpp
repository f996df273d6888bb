// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench scenes`: chains with damping and a guided tip, whose plain `for` is written out while compiling.
#include "bench/measured_scenes.hpp"
#include "bench/scenes.hpp"

namespace qdot::bench {

namespace {

template <int n>
void add_rows(std::vector<SceneRow>& rows) {
  using Way = WrittenOutEnergies;
  for (const SceneRow& row : rows_of_cases<DampedChain<Way, n>, GuidedChain<Way, n>, DampedGuidedChain<Way, n>>()) rows.push_back(row);
}

}  // namespace

std::vector<SceneRow> written_out_chain_scene_rows() {
  std::vector<SceneRow> rows;
  add_rows<2>(rows);
  add_rows<4>(rows);
  add_rows<8>(rows);
  rows.push_back(row_beside<OneJointDamped<WrittenOutEnergies, 8>>(by_scene<BareChain<WrittenOutEnergies, 8>>, "its bare q̈"));
  return rows;
}

}  // namespace qdot::bench
