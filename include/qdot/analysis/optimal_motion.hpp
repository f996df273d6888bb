#pragma once
// SPDX-License-Identifier: MIT
//
// Deprecated: this header is analysis/trajectory_optimization.hpp now.

#include "qdot/analysis/trajectory_optimization.hpp"
