// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench scenes`: a rigid body in space about its centre of mass, by where it is and by T = ½ Ω·I Ω in the library's words for
// rotations. Two of them on a ball joint.
#include "bench/measured_scenes.hpp"
#include "bench/scenes.hpp"

namespace qdot::bench {

namespace {

template <class... Case>
std::vector<SceneRow> rows_of_both() {
  std::vector<SceneRow> rows = rows_of_cases<Case...>();
  for (SceneRow& row : rows_in_a_run<Case...>()) rows.push_back(std::move(row));
  return rows;
}

}  // namespace

std::vector<SceneRow> body_scene_rows() {
  return rows_of_both<EulerAnglesBody<false>, EulerAnglesBody<true>, RotationVectorBody<false>, RotationVectorBody<true>, QuaternionBody<false>,
                      QuaternionBody<true>, UnitQuaternionBody<false>, UnitQuaternionBody<true>, PlacedEulerAnglesBody<false>, PlacedEulerAnglesBody<true>,
                      PlacedRotationVectorBody<false>, PlacedRotationVectorBody<true>, JoinedBodies>();
}

}  // namespace qdot::bench
