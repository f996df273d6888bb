// SPDX-License-Identifier: MIT
//
// Nothing but the precompiled headers of the test programs, which this file makes CMake build once.
