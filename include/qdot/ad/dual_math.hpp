#pragma once
// SPDX-License-Identifier: MIT
//
// Everything in <cmath> that mechanics meets, for dual numbers.

#include "qdot/ad/dual_algebraic.hpp"
#include "qdot/ad/dual_transcendental.hpp"
