// SPDX-License-Identifier: MIT
#include "qdot/report/heat_map.hpp"

#include <string>

#include "catch2_bridge.hpp"
#include "error_message.hpp"

using namespace qdot;

TEST_CASE("a heat map shows its values row by row from the first y, and says why a cell has none") {
  const report::HeatMap map{.title = "t <of> flight", .x_label = "l [m]", .y_label = "q0", .x = {1, 2}, .y = {0.5, 1.5, 2.5},
                            .values = {1, 2, 3, NAN, 5, 6}, .remarks = {"", "", "", "step \"limit\"", "", ""}};
  const std::string text = report::heat_map(map);
  for (const char* part : {"t &lt;of&gt; flight", "\"x\":[1,2]", "\"y\":[0.5,1.5,2.5]", "\"values\":[1,2,3,null,5,6]",
                           "\"remarks\":{\"3\":\"step limit\"}", "\"low\":1", "\"high\":6",
                           "\"x_name\":\"l\"", "\"x_label\":\"l [m]\""})
    CHECK(text.find(part) != std::string::npos);
  CHECK(report::heat_map({.x = {1}, .y = {1}, .values = {NAN}}).find("no values") != std::string::npos);
  CHECK(error_message([] {
          report::heat_map({.x = {1, 2}, .y = {1}, .values = {1}});
        }).find("the values of a heat map must have 2 entries, but has 1") != std::string::npos);
}
