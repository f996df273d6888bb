#pragma once
// SPDX-License-Identifier: MIT
//
// Deprecated: this header is mechanics/accelerations.hpp now.

#include "qdot/mechanics/accelerations.hpp"
