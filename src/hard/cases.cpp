// SPDX-License-Identifier: MIT
#include "hard/hard_case.hpp"

namespace qdot::hard {

std::vector<Case> all_cases() { return {pleiades(), henon_heiles(), projected_pendulum(), car_axis(), bricard()}; }

}  // namespace qdot::hard
