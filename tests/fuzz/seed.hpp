#pragma once
// SPDX-License-Identifier: MIT
//
// The seed of random tests: the same in every run, unless QDOT_SEED gives another. Tests print it where they fail.

#include <cstdint>
#include <cstdlib>
#include <string>

namespace fuzz {

inline std::uint64_t seed() {
  const char* given = std::getenv("QDOT_SEED");
  return given != nullptr ? std::strtoull(given, nullptr, 10) : 20250101;
}

inline std::string seed_text() { return "QDOT_SEED=" + std::to_string(seed()); }

}  // namespace fuzz
