// SPDX-License-Identifier: MIT
#include "hard/hard_case.hpp"

namespace qdot::hard {

std::vector<Case> all_cases() {
  return {pleiades(),         arenstorf(),        kepler(),        henon_heiles(),     double_pendulum(),
          outer_solar_system(), rigid_body(),     bouncing_ball(), chaplygin_sleigh(), rolling_disk(),
          projected_pendulum(), long_pendulum(),  car_axis(),      n_four_bar(),       bricard(),
          flyball_governor(), andrews(),          flexible_crank(), ggl_slider_crank()};
}

}  // namespace qdot::hard
