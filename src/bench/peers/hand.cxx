// SPDX-License-Identifier: MIT
//
// The baseline: the closed form, as fast as we can write it.
#include "bench/hand_derived.hpp"
#include "bench/peers/peer.hpp"

extern "C" ChainAcceleration acceleration_of_chain(int n) {
  using namespace qdot::bench;
  switch (n) {
    case 1: return short_chain_by_hand<1>;
    case 2: return short_chain_by_hand<2>;
    case 4: return short_chain_by_hand<4>;
    case 8: return short_chain_by_hand<8>;
    case 16: return chain_by_hand<16>;
    default: return nullptr;
  }
}
