// SPDX-License-Identifier: MIT
//
// The published hard cases as `qdot bench hard` reports them.
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "../catch2_bridge.hpp"
#include "command.hpp"

using nlohmann::json;

TEST_CASE("published hard cases reach the digits that their references are good for, and what cannot says why", "[long]") {
  const program_test::Directory directory;
  const auto bench = program_test::qdot("bench hard --json --page '" + directory.file("page.md") + "'");
  INFO(bench.err);
  REQUIRE(bench.status == 0);
  const json rows = json::parse(bench.out);
  REQUIRE(rows.is_array());
  REQUIRE(rows.size() > 60);
  std::map<std::string, int> methods;  // that claim to reach, of each problem
  long limits = 0;
  for (const json& row : rows) {
    INFO(row["case"].get<std::string>() << " by " << row["method"].get<std::string>());
    CHECK(row["outcome"].get<std::string>() == "completed");
    const double reached = row["digits_reached"], good = row["digits_good"];
    if (row["claim"].get<bool>()) {
      // One digit; and a fifth for what other compilers round otherwise.
      CHECK(reached >= good - 1.2);
      ++methods[row["case"]];
    } else {
      CHECK_FALSE(row["limit"].get<std::string>().empty());
      CHECK(reached < good - 1.0);  // else it could claim
      CHECK(reached >= good - 6.0);
      ++limits;
    }
  }
  CHECK(limits <= 5);
  for (const auto& [problem, count] : methods) {
    INFO(problem);
    // Tables of one method, by those who printed them.
    const bool one_by_nature = problem.starts_with("Kepler e = 0.6, energy error") ||
                               (problem.starts_with("CVODE pendulum") && problem != "CVODE pendulum, closed orbit");
    CHECK((one_by_nature || count >= 2));
  }
  const std::string page = program_test::content(directory.file("page.md"));
  CHECK(page.find("# Hard cases") == 0);
  CHECK(page.find("## Andrews' squeezing mechanism") != std::string::npos);
}

TEST_CASE("the program and its benchmarks know the same benchmarks", "[long]") {
  const auto handed_over = program_test::qdot("bench foo");
  const auto linked_in = program_test::ended(std::string(QDOT_PROGRAM) + "-bench", "foo");
  CHECK(handed_over.status == 2);
  CHECK(handed_over.err == linked_in.err);
}
