#pragma once
// SPDX-License-Identifier: MIT
//
// Deprecated: this header is integrate/ensemble_mpi.hpp now.

#include "qdot/integrate/ensemble_mpi.hpp"
