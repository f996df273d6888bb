#pragma once
// SPDX-License-Identifier: MIT
//
// What the library says against a call, for tests of its words.

#include <string>

#include "qdot/error.hpp"

namespace qdot {

/// The message of the error that a call ends with; empty where it ends with none.
std::string error_message(const auto& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace qdot
