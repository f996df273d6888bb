// SPDX-License-Identifier: MIT
#include "qdot/report/plot.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "catch2_bridge.hpp"
#include "qdot/report/svg.hpp"

using namespace qdot::report;

namespace {

std::vector<std::string> labels(const Ticks& ticks) {
  std::vector<std::string> result;
  for (const Tick& tick : ticks.ticks) result.push_back(tick.label);
  return result;
}

int count(const std::string& text, const std::string& part) {
  int n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

Plot line_plot(std::vector<double> x, std::vector<double> y) {
  Plot plot;
  plot.x.label = "t [s]";
  plot.y.label = "x [m]";
  plot.series.push_back({"x", std::move(x), std::move(y)});
  return plot;
}

}  // namespace

TEST_CASE("linear ticks stand at 1, 2 or 5 times a power of ten") {
  CHECK(labels(linear_ticks(0, 10, 5)) == std::vector<std::string>{"0", "2", "4", "6", "8", "10"});
  CHECK(labels(linear_ticks(-0.3, 0.3, 3)) == std::vector<std::string>{"-0.2", "0", "0.2"});
  CHECK(labels(linear_ticks(0, 1, 2)) == std::vector<std::string>{"0", "0.5", "1"});
}

TEST_CASE("a linear axis takes the power of ten out of very small and very large numbers") {
  const Ticks small = linear_ticks(0, 4e-13, 4);
  CHECK(small.exponent == -13);
  CHECK(labels(small) == std::vector<std::string>{"0", "1", "2", "3", "4"});
  CHECK(linear_ticks(0, 3e5, 3).exponent == 5);
  CHECK(linear_ticks(0, 250, 5).exponent == 0);
}

TEST_CASE("logarithmic ticks are powers of ten, thinned over many decades and joined by 2 and 5 over few") {
  CHECK(labels(logarithmic_ticks(1e-12, 1e-3, 3)) == std::vector<std::string>{"10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³"});
  CHECK(labels(logarithmic_ticks(1, 20, 5)) == std::vector<std::string>{"1", "2", "5", "10", "20"});
}

TEST_CASE("the shown range ignores what the axis cannot show") {
  const std::vector<double> data = {1.0, std::nan(""), -5.0, 100.0};
  const Axis logarithmic{"", Scale::logarithmic};
  CHECK(shown_range(logarithmic, {&data}, 0.0) == std::pair<double, double>{1.0, 100.0});
  CHECK(shown_range(Axis{}, {&data}, 0.0) == std::pair<double, double>{-5.0, 100.0});
}

TEST_CASE("a curve that is constant to rounding is not magnified") {
  const std::vector<double> data = {9.81, 9.81 + 1e-15, 9.81 - 1e-15};
  const auto [lo, hi] = shown_range(Axis{}, {&data}, 0.0);
  CHECK(hi - lo > 1.0);
}

TEST_CASE("an SVG has a path for every curve, and text that XML can read") {
  Plot plot = line_plot({0, 1, 2}, {0, 1, 0});
  plot.title = "a < b & \"c\"";
  const std::string text = svg(plot);
  CHECK(text.find("a &lt; b &amp; &quot;c&quot;") != std::string::npos);
  CHECK(text.find("a < b") == std::string::npos);
  CHECK(count(text, "<svg") == count(text, "</svg>"));
  CHECK(text.find("t [s]") != std::string::npos);
  CHECK(text.find("x [m]") != std::string::npos);
  CHECK(text.find("nan") == std::string::npos);
}

TEST_CASE("a value that is not finite interrupts its curve") {
  const std::string whole = svg(line_plot({0, 1, 2, 3}, {0, 1, 2, 3}));
  const std::string broken = svg(line_plot({0, 1, 2, 3, 4}, {0, 1, std::nan(""), 2, 3}));
  const auto moves = [](const std::string& text) {
    const std::size_t at = text.find("stroke:var(--s0)\" d=\"M");
    return count(text.substr(at, text.find("/>", at) - at), "M");
  };
  CHECK(moves(whole) == 1);
  CHECK(moves(broken) == 2);
  CHECK(broken.find("nan") == std::string::npos);
}

TEST_CASE("a curve with far more points than pixels is thinned without losing its extremes") {
  std::vector<double> x, y;
  constexpr int points = 100000;
  for (int i = 0; i <= points; ++i) {
    x.push_back(i * 1e-4);
    y.push_back(i == 31234 ? 5.0 : std::sin(x.back()));
  }
  const std::string text = svg(line_plot(x, y));
  constexpr std::size_t bytes_of_a_page = 300000;
  CHECK(text.size() < bytes_of_a_page);
  std::vector<detail::Pixel> pixels;
  for (std::size_t i = 0; i < x.size(); ++i) pixels.push_back({70 * x[i], y[i]});
  const auto higher = [](const detail::Pixel& a, const detail::Pixel& b) { return a.y < b.y; };
  const std::vector<detail::Pixel> kept = detail::thinned(pixels);
  CHECK(kept.size() < 4 * 4 * 700 + 4);  // four points for each quarter of 700 pixels
  CHECK(std::max_element(kept.begin(), kept.end(), higher)->y == 5.0);
  CHECK(std::min_element(kept.begin(), kept.end(), higher)->y == std::min_element(pixels.begin(), pixels.end(), higher)->y);
  CHECK(kept.back().x == pixels.back().x);
}

TEST_CASE("a dashed curve is dashed in the legend, too, and large dots have no line between them") {
  Plot plot;
  plot.series = {{.label = "above", .x = {0, 1}, .y = {0, 1}, .dashed = true}, {.label = "meet", .x = {0, 1}, .y = {1, 0}, .markers = true, .dots = true}};
  const std::string text = svg_element(plot);
  CHECK(count(text, "stroke-dasharray") == 2);
  CHECK(count(text, "<circle") == 3);
  CHECK(count(text, "class=\"curve\"") == 2);
}

TEST_CASE("dots are lines of no length, without a line between them, and one for all that fall together") {
  Plot plot = line_plot({0, 1, 1, 2}, {0, 1, 1, std::nan("")});
  plot.series[0].dots = true;
  const std::string text = svg_element(plot);
  CHECK(count(text, "h0") == 2);
  CHECK(count(text, "<circle") == 0);
  CHECK(text.find("NaN") == std::string::npos);
  CHECK(text.find("nan") == std::string::npos);
}

TEST_CASE("a plot without data is drawn with empty axes") {
  const std::string text = svg(Plot{});
  CHECK(text.find("nan") == std::string::npos);
  CHECK(text.find("inf") == std::string::npos);
}

TEST_CASE("a mark is a line at its x, with its name where that is new or fits") {
  Plot plot = line_plot({0, 10}, {0, 1});
  plot.time_axis = true;
  plot.width = 600;
  plot.marks = {{5.0, "bounce"}, {5.001, "bounce"}, {5.01, "a < b"}, {7.5, "bounce"}, {11.0, "beyond"}, {std::nan(""), "never"}};
  const std::string text = svg(plot);
  CHECK(count(text, "class=\"mark\"") == 3);  // two bounces within one pixel are one line
  CHECK(count(text, ">bounce</text>") == 2);
  CHECK(count(text, ">a &lt; b</text>") == 1);
  CHECK(text.find("<title>bounce, 7.5</title>") != std::string::npos);
  CHECK(text.find("beyond") == std::string::npos);
  CHECK(text.find("never") == std::string::npos);
  const auto at = [&](const std::string& what, const std::string& before) {  // px behind the last `before` in front of `what`
    return std::stod(text.substr(text.rfind(before, text.find(what)) + before.size()));
  };
  const double left = std::stod(text.substr(text.find("data-time=\"") + 11)), right = 600 - 18;
  CHECK(at("<title>bounce, 5<", "d=\"M") == Approx(0.5 * (left + right)).margin(0.01));
  CHECK(at("<title>bounce, 7.5", "d=\"M") == Approx(left + 0.75 * (right - left)).margin(0.01));
}

TEST_CASE("a crowd of marks is a rug at the bottom, one path with its name and number, and leaves the lines of others alone") {
  Plot plot = line_plot({0, 10}, {0, 1});
  plot.time_axis = true;
  for (int i = 0; i < 100000; ++i) plot.marks.push_back({1e-4 * i, "tick"});
  const std::string text = svg(plot);
  CHECK(count(text, "class=\"mark\"") == 1);
  CHECK(count(text, ">tick, 100000×</text>") == 1);
  const std::size_t at = text.find("class=\"mark\"");
  CHECK(count(text.substr(at, text.find('>', at) - at), "v7") < 720);  // one in each pixel

  Plot controlled = line_plot({0, 8}, {0, 1});  // at 100 Hz
  for (int i = 0; i < 800; ++i) controlled.marks.push_back({0.01 * i, "sample"});
  controlled.marks.push_back({7.995, "hit"});
  const std::string drawn = svg(controlled);
  CHECK(count(drawn, "class=\"mark\"") == 2);
  CHECK(count(drawn, ">hit</text>") == 1);
  CHECK(count(drawn, ">sample, 800×</text>") == 1);
}

TEST_CASE("equal units on a logarithmic axis are refused") {
  Plot plot = line_plot({1, 10}, {0, 1});
  plot.equal_units = true;
  CHECK_NOTHROW(svg(plot));
  plot.x.scale = Scale::logarithmic;
  CHECK_THROWS_AS(svg(plot), qdot::InvalidValue);
}
