#pragma once
// SPDX-License-Identifier: MIT
//
// Everything in <cmath> that mechanics meets, for dual numbers.

#include "qdot/ad/forward/algebraic.hpp"
#include "qdot/ad/forward/transcendental.hpp"
