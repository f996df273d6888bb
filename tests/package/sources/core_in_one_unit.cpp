// SPDX-License-Identifier: MIT
//
// The same user, in one unit.
#include "core.cpp"

#include "core_second_unit.cpp"
