#pragma once
// SPDX-License-Identifier: MIT
//
// How far the library is from what `qdot bench scenes` calls hand-derived.

#include <algorithm>
#include <random>

#include "bench/measured_scenes.hpp"
#include "bench/scenes.hpp"

namespace qdot {

/// The largest difference of q̈ and λ over random states, relative to their size.
template <class Case>
double difference_by_hand() {
  constexpr int n = Case::n, all = Case::n + Case::constraints;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> position(Case::lowest, Case::highest), velocity(-2.0, 2.0);
  double worst = 0.0;
  for (int sample = 0; sample < 20; ++sample) {
    Vector<double, n> q, v;
    for (int i = 0; i < n; ++i) {
      q[i] = position(random);
      v[i] = velocity(random);
    }
    Vector<double, all> a, b;
    bench::by_hand_of_scene<typename Case::Hand>(q.data(), v.data(), a.data());
    bench::by_scene<Case>(q.data(), v.data(), b.data());
    worst = std::max(worst, (a - b).norm() / (1.0 + a.norm()));
  }
  return worst;
}

}  // namespace qdot
