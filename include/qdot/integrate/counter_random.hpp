#pragma once
// SPDX-License-Identifier: MIT
//
// Random numbers that belong to a number.
//
//     for motion i of a study with a seed:      CounterRandom random(seed, i);      l = 1 + 0.05 random.normal()
//
// A generator that is drawn from in turn gives each motion what the ones before have left. Then another order, another number of threads or another start
// in the middle changes all motions. Here the k-th number of motion i is a function of (seed, i, k) alone: ten rounds of multiplications that mix a
// counter (Philox 4×32-10). Reference: Salmon, Moraes, Dror and Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011. Any motion can be made again
// by itself, and a study goes on where it stopped.

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

namespace qdot {

/// Four words that belong to a counter and a key.
constexpr std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter, std::array<std::uint32_t, 2> key) noexcept {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t a = std::uint64_t{0xD2511F53u} * counter[0], b = std::uint64_t{0xCD9E8D57u} * counter[2];
    counter = {static_cast<std::uint32_t>(b >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(b),
               static_cast<std::uint32_t>(a >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(a)};
    key = {key[0] + 0x9E3779B9u, key[1] + 0xBB67AE85u};
  }
  return counter;
}

/// The random numbers of one motion; also a generator for the distributions of <random>, whose results are the standard library's own.
class CounterRandom {
 public:
  using result_type = std::uint64_t;  ///< 64 random bits

  /// @param seed   of the study
  /// @param index  of the motion in it
  constexpr CounterRandom(std::uint64_t seed, std::uint64_t index) noexcept : seed_(seed), index_(index) {}

  /// The least result.
  static constexpr result_type min() noexcept { return 0; }
  /// The largest.
  static constexpr result_type max() noexcept { return std::numeric_limits<result_type>::max(); }

  /// 64 random bits.
  constexpr result_type operator()() noexcept {
    const auto low = [](std::uint64_t x) { return static_cast<std::uint32_t>(x); };
    const auto high = [](std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32); };
    const auto words = philox({low(drawn_), high(drawn_), low(index_), high(index_)}, {low(seed_), high(seed_)});
    ++drawn_;
    return std::uint64_t{words[1]} << 32 | words[0];
  }

  /// Uniform in [0, 1), a multiple of 2⁻⁵³.
  constexpr double uniform() noexcept { return static_cast<double>((*this)() >> 11) * 0x1p-53; }

  /// Uniform in [from, to).
  constexpr double uniform(double from, double to) noexcept { return from + uniform() * (to - from); }

  /// Of mean 0 and standard deviation 1, by Box and Muller; two draws.
  double normal() noexcept {
    const double radius = std::sqrt(-2.0 * std::log1p(-uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }

 private:
  std::uint64_t seed_, index_, drawn_ = 0;
};

}  // namespace qdot
