#pragma once
// SPDX-License-Identifier: MIT
//
// Deprecated: this header is integrate/time_point.hpp now.

#include "qdot/integrate/time_point.hpp"
