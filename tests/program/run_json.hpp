#pragma once
// SPDX-License-Identifier: MIT
//
// What `qdot run … --json` says of a run.

#include <nlohmann/json.hpp>
#include <string>

#include "catch2_bridge.hpp"
#include "command.hpp"

namespace program_test {

/// The one object on standard output of `qdot run ARGUMENTS --json`, which must end with this status; throws if there is anything else.
inline nlohmann::json run_json(const std::string& arguments, int status = 0) {
  const Ended ended = qdot("run " + arguments + " --json");
  INFO(ended.err);
  REQUIRE(ended.status == status);
  return nlohmann::json::parse(ended.out);
}

}  // namespace program_test
