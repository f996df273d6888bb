// SPDX-License-Identifier: MIT
//
// With -ffinite-math-only a NaN passes for a number, and nothing that qdot promises about one holds.
// flags: -ffinite-math-only
// message: make NaN pass for a number
#include <qdot/ad/dual_math.hpp>

int main() {}
