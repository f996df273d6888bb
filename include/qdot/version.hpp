#pragma once
// SPDX-License-Identifier: MIT
//
// Which qdot this is. While the first number is 0 a new second one may change the interface; CHANGELOG.md says what. A program that needs to know:
//
//     static_assert(qdot::version_minor >= 3, "…");
//
// find_package(qdot 0.3) asks the same of an installation. CMake reads the numbers here; there is no other place for them.

namespace qdot {

/// 0 while the interface may change.
inline constexpr int version_major = 0;
/// Rises where the interface changes, as long as the first is 0.
inline constexpr int version_minor = 3;
/// Rises with what changes no interface.
inline constexpr int version_patch = 0;

}  // namespace qdot
