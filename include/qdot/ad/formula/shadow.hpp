#pragma once
// SPDX-License-Identifier: MIT
//
// Numbers that stand for letters.
//
// Whoever derives a formula asks of a letter m: is it zero, is it one, is m l − l m zero? Of a letter nobody knows the value, but a number that
// has nothing to do with any other answers these questions as the letter would: its sums and products are zero or equal where those of the
// letters are, and by chance nowhere else. Parameter k gets the number shadow_of(k).

#include <cstdint>

namespace qdot::formula {

/// A number from ½ to 1½ that has nothing to do with those of other bits (the last mixing steps of the generator SplitMix64).
constexpr double scattered(std::uint64_t bits) {
  std::uint64_t z = (bits + 1) * 0x9E3779B97F4A7C15u;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return 0.5 + static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

/// The shadow of parameter k. Not an evenly spread sequence, such as multiples of the golden ratio: there sums of parameters k and
/// k + 3 would be those of k + 1 and k + 2.
constexpr double shadow_of(int k) { return scattered(static_cast<std::uint64_t>(k)); }

}  // namespace qdot::formula
