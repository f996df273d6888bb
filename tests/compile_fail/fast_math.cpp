// SPDX-License-Identifier: MIT
//
// With -ffast-math a NaN passes for a number, and nothing that qdot promises about one holds.
// flags: -ffast-math -Wfatal-errors
// message: make NaN pass for a number
#include <qdot/qdot.hpp>

int main() {}
