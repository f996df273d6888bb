// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench scenes`: a rigid body in space about its centre of mass, T = ½ Ω·I Ω by the library's words for rotations.
#include "bench/measured_scenes.hpp"
#include "bench/scenes.hpp"

namespace qdot::bench {

std::vector<SceneRow> body_scene_rows() {
  return rows_of_cases<EulerAnglesBody<false>, EulerAnglesBody<true>, RotationVectorBody<false>, RotationVectorBody<true>>();
}

}  // namespace qdot::bench
