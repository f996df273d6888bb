// SPDX-License-Identifier: MIT
//
// The same user, in one unit.
#include "cvode.cpp"

#include "cvode_second_unit.cpp"
