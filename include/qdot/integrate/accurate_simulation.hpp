#pragma once
// SPDX-License-Identifier: MIT
//
// Deprecated: this header is integrate/simulate_to_accuracy.hpp now.

#include "qdot/integrate/simulate_to_accuracy.hpp"
