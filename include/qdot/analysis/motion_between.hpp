#pragma once
// SPDX-License-Identifier: MIT
//
// Deprecated: this header is analysis/boundary_value_problem.hpp now.

#include "qdot/analysis/boundary_value_problem.hpp"
