// SPDX-License-Identifier: MIT
#include "qdot/report/html.hpp"

#include <cmath>
#include <string>

#include "catch2_bridge.hpp"

using namespace qdot::report;

namespace {

Page page_with_animation() {
  Page page{.title = "Pendulum <1>", .lead = "A bob."};
  page.animation = Animation{.drawing = {.shapes = {line({0, 1}), disk(1)}},
                             .times = {0.0, 0.5, 1.0},
                             .frames = {{{0, 0}, {0, -1}}, {{0, 0}, {0.25, -0.9682458366}}, {{0, 0}, {0.5, -0.8660254038}}}};
  page.tables = {{"Run", {{"steps", "12", ""}}}};
  return page;
}

}  // namespace

TEST_CASE("a page contacts nobody") {
  const std::string text = html(page_with_animation());
  for (const char* outside : {"src=", "href=\"http", "url(", "@import", "fetch(", "XMLHttpRequest"}) {
    INFO(outside);
    CHECK(text.find(outside) == std::string::npos);
  }
}

TEST_CASE("a page contains its frames, its facts, and its title as text") {
  const std::string text = html(page_with_animation());
  CHECK(text.find("<h1>Pendulum &lt;1&gt;</h1>") != std::string::npos);
  CHECK(text.find("[0,0,0.25,-0.9682]") != std::string::npos);
  CHECK(text.find("<td class=\"value\">12</td>") != std::string::npos);
  CHECK(text.find("id=\"scrub\"") != std::string::npos);
}

TEST_CASE("a picture in space has three numbers for each point, and a camera") {
  Page page = page_with_animation();
  CHECK(html(page).find("\"camera\"") == std::string::npos);
  page.animation->drawing.camera = Camera{.side = 40, .above = 10};
  page.animation->frames[1][1].z = 0.5;
  page.animation->drawing.backdrop = {{{-1, 0, 0}, {1, 0, 2}}};
  const std::string text = html(page);
  CHECK(text.find("\"camera\":[40,10]") != std::string::npos);
  CHECK(text.find("[0,0,0,0.25,-0.9682,0.5]") != std::string::npos);
  CHECK(text.find("\"backdrop\":[[[-1,0,0],[1,0,2]]]") != std::string::npos);
}

TEST_CASE("a page without anything to play has no player") {
  Page page = page_with_animation();
  SECTION("no animation") { page.animation.reset(); }
  SECTION("a single frame") {
    page.animation->times.resize(1);
    page.animation->frames.resize(1);
  }
  SECTION("a point that is not finite") { page.animation->frames[1][1].x = std::nan(""); }
  SECTION("frames of different length") { page.animation->frames[2].pop_back(); }
  CHECK(html(page).find("<script") == std::string::npos);
}

TEST_CASE("an animation plays in real time when that takes between 2 and 40 seconds, else in 12") {
  CHECK(detail::playing_rate(10) == 1.0);
  CHECK(detail::playing_rate(1.2) == Approx(0.1));
  CHECK(detail::playing_rate(120) == Approx(10.0));
}

TEST_CASE("text in the script's data cannot end the script") {
  Page page = page_with_animation();
  page.animation->time_unit = "</script>\"\\";
  const std::string text = html(page);
  CHECK(text.find("\"unit\":\"/script>\"") != std::string::npos);
}

TEST_CASE("formulas stand above the plots, and need no script") {
  Page page{.title = "Pendulum", .formulas = "<h2>Equations</h2><math><mi>L</mi></math>"};
  page.plots = {Plot{.x = {"t"}, .y = {"q"}}};
  page.plots[0].series.push_back({"", {0.0, 1.0}, {0.0, 1.0}});
  const std::string text = html(page);
  const auto formulas = text.find("<math><mi>L</mi></math>");
  REQUIRE(formulas != std::string::npos);
  CHECK(formulas < text.find("<svg"));
  CHECK(text.find("<script") == std::string::npos);
}

TEST_CASE("a table of facts has minus signs, and a page in symbols has them and Greek letters everywhere") {
  const Page page{.tables = {{"Start", {{"theta", "-1.5 rad"}}}},
                  .plots = {{.title = "theta along mu", .x = {"mu [1/s^2]"}, .series = {{.label = "thetadot"}}}}};
  CHECK(html(page).find("<td>theta</td><td class=\"value\">−1.5 rad</td>") != std::string::npos);
  const std::string text = html(in_symbols(page));
  CHECK(text.find("<td>θ</td><td class=\"value\">−1.5 rad</td>") != std::string::npos);
  for (const char* part : {">θ along μ<", ">μ [1/s²]<", ">θ\u0307<"}) CHECK(text.find(part) != std::string::npos);
}
