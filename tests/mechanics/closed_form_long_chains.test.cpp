// SPDX-License-Identifier: MIT
//
// Equations of many coordinates that the compiler has derived, against those derived by hand.
#include "catch2_bridge.hpp"

#include <cmath>

#include "bench/chain_energies.hpp"
#include "bench/hand_derived.hpp"
#include "qdot/mechanics/written_out.hpp"

using namespace qdot;

namespace {

// Rounding of both, times the condition of M, which grows with the square of the length.
constexpr double rounded_long_chain = 1e-11;

template <int n>
double difference_from_hand() {
  const auto written = written_out<n>(bench::LoopedChain{});
  Vector<double, n> q, v, a, b;
  for (int i = 0; i < n; ++i) {
    q[i] = std::sin(3.0 * i + 1.0);
    v[i] = std::cos(5.0 * i);
  }
  bench::chain_by_hand<n>(q.data(), v.data(), a.data());
  if (!detail::closed_form_acceleration<n>(written, q.data(), v.data(), 0.0, b.data())) return 1.0;
  return (a - b).norm() / a.norm();
}

}  // namespace

TEST_CASE("derived equations of motion are those that one derives by hand: more coordinates than are multiplied out") {
  CHECK(difference_from_hand<12>() < rounded_long_chain);
  CHECK(difference_from_hand<16>() < rounded_long_chain);
}
