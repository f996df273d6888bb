#pragma once
// SPDX-License-Identifier: MIT
//
// Deprecated: this header is analysis/work_precision_study.hpp now.

#include "qdot/analysis/work_precision_study.hpp"
