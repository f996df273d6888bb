#pragma once
// SPDX-License-Identifier: MIT
//
// Deprecated: this header is analysis/generalized_alignment_index.hpp now.

#include "qdot/analysis/generalized_alignment_index.hpp"
