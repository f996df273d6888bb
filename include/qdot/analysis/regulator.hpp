#pragma once
// SPDX-License-Identifier: MIT
//
// Deprecated: this header is analysis/lqr.hpp now.

#include "qdot/analysis/lqr.hpp"
