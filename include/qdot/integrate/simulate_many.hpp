#pragma once
// SPDX-License-Identifier: MIT
//
// Deprecated: this header is integrate/ensemble.hpp now.

#include "qdot/integrate/ensemble.hpp"
