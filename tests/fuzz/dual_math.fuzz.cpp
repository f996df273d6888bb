// SPDX-License-Identifier: MIT
//
// libFuzzer's turn at dual_math.hpp: any function at any two doubles.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "dual_math.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  double x = 0.0, y = 0.0;
  if (size < 1 + sizeof x + sizeof y) return 0;
  std::memcpy(&x, data + 1, sizeof x);
  std::memcpy(&y, data + 1 + sizeof x, sizeof y);
  const std::string wrong = fuzz::disagreement(fuzz::rules()[data[0] % fuzz::rules().size()], x, y);
  if (wrong.empty()) return 0;
  std::fputs(wrong.c_str(), stderr);
  std::abort();
}
