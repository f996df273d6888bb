// SPDX-License-Identifier: MIT
#include "hard/hard_case.hpp"

namespace qdot::hard {

std::vector<Case> all_cases() {
  return {pleiades(),  henon_heiles(), bouncing_ball(),    chaplygin_sleigh(), projected_pendulum(),
          car_axis(),  bricard(),      flyball_governor(), andrews()};
}

}  // namespace qdot::hard
