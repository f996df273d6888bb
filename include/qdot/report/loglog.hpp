#pragma once
// SPDX-License-Identifier: MIT
//
// Measurements over decades: marked curves on two logarithmic axes, as SVG text.
//
//     error
//     10⁻³ ┤ ●10⁻³                 — ● dop853   — ▲ taylor
//     10⁻⁶ ┤   ╲●10⁻⁶  ╳           a cross: a run that failed, at what it had cost by then
//     10⁻⁹ ┤─ ─ ─ ─╲● ─ ─ ─ ─      a level, with its name: the rounding floor
//          └──┬────┬────┬──
//           10⁻⁴  10⁻³  10⁻²  s
//
// A method has a colour and a shape, so that curves can be told apart without colours. Labels at markers stand where there
// is room, and are left out where there is none. A run without an error to show stands as a cross on the upper edge.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "qdot/report/number.hpp"
#include "qdot/report/plot.hpp"
#include "qdot/report/svg.hpp"
#include "qdot/report/theme.hpp"

namespace qdot::report {

/// One measurement. A failed one has no y that counts.
struct Marker {
  double x = 0;         ///< where
  double y = 0;         ///< where
  std::string label{};  ///< what it says when pointed at
  bool failed = false;  ///< whether the measurement failed
};

/// The measurements of one method, in their order.
struct MarkedCurve {
  std::string name;            ///< in the legend
  std::size_t style = 0;       ///< colour and shape
  std::vector<Marker> points;  ///< in their order
  bool marked = true;          ///< false: a line alone
};

/// A horizontal line with its name.
struct Level {
  double y = 0;       ///< where
  std::string label;  ///< what it says
};

/// A straight line y ∝ x^slope through a point, with its name.
struct SlopeGuide {
  double slope = 1;   ///< of the line
  double x = 1;       ///< a point of it
  double y = 1;       ///< a point of it
  std::string label;  ///< what it says
};

/// Measurements over decades, with their axes.
struct LogLogPlot {
  std::string title{};                ///< above it
  std::string x_label{};              ///< with its unit
  std::string y_label{};              ///< with its unit
  std::vector<MarkedCurve> curves{};  ///< of all methods
  std::vector<Level> levels{};        ///< horizontal lines
  std::vector<SlopeGuide> slopes{};   ///< straight lines to compare with
  double width = 720;                 ///< px
  double height = 430;                ///< px
  double least_y = 0;                 ///< smaller values are drawn here: an error of exactly zero has no logarithm
  bool with_legend = true;            ///< whether curves are named beside it
};

namespace detail {

/// Colour and shape of a method; 64 combinations before one comes again.
inline std::string marker_colour(std::size_t style) { return "var(--s" + std::to_string(style % series_colours) + ")"; }

/// Style of a method's line: the second eight colours are dashed.
inline std::string line_style(std::size_t style) {
  return "stroke:" + marker_colour(style) + (style / series_colours % 2 == 1 ? ";stroke-dasharray:7 4" : "");
}

/// One of eight shapes at a point: dot, square, triangle up, diamond, triangle down, pentagon, plus, star.
inline std::string marker_svg(std::size_t style, double x, double y, double r) {
  const std::string colour = marker_colour(style);
  const std::size_t shape = (style + style / series_colours) % 8;
  const auto polygon = [&](int corners, double first_degrees, double size, double inner) {
    std::string points;
    for (int k = 0; k < corners; ++k) {
      const double angle = (first_degrees + 360.0 * k / corners) * 3.14159265358979 / 180;
      const double length = k % 2 == 1 ? size * inner : size;
      points += (k == 0 ? "" : " ") + px(x + length * std::cos(angle)) + "," + px(y - length * std::sin(angle));
    }
    return "<polygon class=\"mark\" points=\"" + points + "\" style=\"fill:" + colour + "\"/>";
  };
  switch (shape) {
    case 0: return "<circle class=\"mark\" cx=\"" + px(x) + "\" cy=\"" + px(y) + "\" r=\"" + px(r) + "\" style=\"fill:" + colour + "\"/>";
    case 1: return polygon(4, 45, 1.3 * r, 1.0);
    case 2: return polygon(3, 90, 1.45 * r, 1.0);
    case 3: return polygon(4, 90, 1.4 * r, 1.0);
    case 4: return polygon(3, 270, 1.45 * r, 1.0);
    case 5: return polygon(5, 90, 1.25 * r, 1.0);
    case 6: return polygon(8, 90, 1.6 * r, 0.38);
    default: return polygon(10, 90, 1.6 * r, 0.45);
  }
}

inline std::string cross_svg(std::size_t style, double x, double y, double r) {
  return "<path class=\"curve\" style=\"stroke:" + marker_colour(style) + ";stroke-width:2.2\" d=\"M" + px(x - r) + " " + px(y - r) + "L" +
         px(x + r) + " " + px(y + r) + "M" + px(x - r) + " " + px(y + r) + "L" + px(x + r) + " " + px(y - r) + "\"/>";
}

// What is already on the picture, so that a label does not cover it.
class Occupied {
 public:
  void add(double x0, double y0, double x1, double y1) { boxes_.push_back({x0, y0, x1, y1}); }
  bool is_free(double x0, double y0, double x1, double y1) const {
    return std::none_of(boxes_.begin(), boxes_.end(), [&](const std::array<double, 4>& b) {
      return x0 < b[2] && b[0] < x1 && y0 < b[3] && b[1] < y1;
    });
  }

 private:
  std::vector<std::array<double, 4>> boxes_;
};

// Ticks at powers of ten, thinned where there are many; where less than two would be left, at their doubles and fives too.
inline Ticks power_ticks(std::pair<double, double> range, double length_px, double px_per_tick) {
  const int first = static_cast<int>(std::ceil(std::log10(range.first) - 1e-9));
  const int last = static_cast<int>(std::floor(std::log10(range.second) + 1e-9));
  const int every = std::max(1, static_cast<int>(std::ceil((last - first) * px_per_tick / length_px)));
  Ticks result;
  for (int k = first - 1; k <= last; ++k)
    for (const int digit : {1, 2, 5}) {
      if (digit == 1 ? k % every != 0 : last > first) continue;
      const double value = digit * std::pow(10.0, k);
      if (value < range.first * (1 - 1e-9) || value > range.second * (1 + 1e-9)) continue;
      result.ticks.push_back({value, (digit == 1 ? "" : std::to_string(digit) + "·") + "10" + superscript(k)});
    }
  return result;
}

// Room for the letters of a label.
inline double label_width(const std::string& text) { return 0.9 * text_width(text); }

}  // namespace detail

/// Names with their colours and shapes, in rows from the left; returns the SVG text and its height.
inline std::pair<std::string, double> marker_legend(const std::vector<MarkedCurve>& curves, double left, double right, double top) {
  std::string svg;
  double x = left, y = top + 13;
  for (const MarkedCurve& curve : curves) {
    if (curve.name.empty()) continue;
    const double width = 30 + detail::text_width(curve.name) + 16;
    if (x + width > right && x > left) {
      x = left;
      y += 20;
    }
    svg += "<path class=\"curve\" style=\"" + detail::line_style(curve.style) + "\" d=\"M" + detail::px(x) + " " +
           detail::px(y - 4.5) + "h24\"/>" + (curve.marked ? detail::marker_svg(curve.style, x + 12, y - 4.5, 4.2) : std::string()) +
           detail::text_element(x + 30, y, "", curve.name);
    x += width;
  }
  return {svg, y + 7 - top};
}

namespace detail {

// An error as it is drawn.
inline double shown_y(const LogLogPlot& plot, double y) { return plot.least_y > 0 ? std::max(y, plot.least_y) : y; }

// Ranges of x and y.
inline std::pair<std::pair<double, double>, std::pair<double, double>> shown_ranges(const LogLogPlot& plot, const Axis& axis) {
  std::vector<double> xs, ys;
  bool failures = false;
  for (const MarkedCurve& curve : plot.curves)
    for (const Marker& p : curve.points) {
      xs.push_back(p.x);
      if (!p.failed) ys.push_back(shown_y(plot, p.y));
      failures = failures || p.failed;
    }
  for (const Level& level : plot.levels) ys.push_back(0.1 * level.y);  // room for its name
  const auto x_range = shown_range(axis, {&xs}, 0.05);
  auto y_range = shown_range(axis, {&ys}, 0.04);
  if (failures) y_range.second *= std::pow(y_range.second / y_range.first, 0.05);
  return {x_range, y_range};
}

inline PlotLayout layout_of(const LogLogPlot& plot, const Axis& axis) {
  const auto [x_range, y_range] = shown_ranges(plot, axis);
  const double right = plot.width - 18;
  const double head = plot.title.empty() ? 6 : 30;
  const auto [legend_svg, legend_height] = plot.with_legend ? marker_legend(plot.curves, 12, right, head) : std::pair(std::string(), 0.0);
  const double label_line = head + legend_height + 15;
  const double top = label_line + 10, bottom = plot.height - 40;
  const Ticks y_ticks = power_ticks(y_range, bottom - top, 30);
  const double left = left_edge(y_ticks);
  return {x_range, y_range, {left, right, top, bottom}, label_line, power_ticks(x_range, right - left, 60), y_ticks, legend_svg};
}

// Draws a picture part by part. Labels are kept for the end: they stand in front of all else, and where nothing else is.
class LogLogDrawing {
 public:
  explicit LogLogDrawing(const LogLogPlot& plot)
      : plot_(plot), layout_(layout_of(plot, axis_)), edges_(layout_.edges),
        x_(axis_, layout_.x_range, edges_.left, edges_.right), y_(axis_, layout_.y_range, edges_.bottom, edges_.top) {}

  std::string element(const std::string& style) {
    const auto& [left, right, top, bottom] = edges_;
    std::string svg = axes(style);
    for (const Level& level : plot_.levels)
      if (level.y > 0) svg += level_line(level);
    svg += viewport_tag(left, top - 6, right - left + 6, bottom - top + 12);
    for (const SlopeGuide& guide : plot_.slopes) svg += slope_line(guide);
    for (const MarkedCurve& curve : plot_.curves) svg += curve_with_marks(curve);
    svg += "</svg>\n";
    for (const MarkedCurve& curve : plot_.curves)
      for (const Marker& p : curve.points)
        if (!p.failed && !p.label.empty() && p.x > 0 && can_show(axis_, shown_y(plot_, p.y))) add_marker_label(p, curve.style);
    return svg + labels_ + frame_path(edges_) + "</svg>\n";
  }

 private:
  std::string axes(const std::string& style) const {
    std::string svg = opening_tag(plot_.width, plot_.height, plot_.title.empty() ? plot_.y_label : plot_.title) + ">\n" + style;
    if (!plot_.title.empty()) svg += text_element(12, 20, "", plot_.title, "title");
    svg += layout_.legend + text_element(12, layout_.label_line, "", plot_.y_label, "label") + ticks_svg(layout_, x_, y_);
    return svg + text_element(0.5 * (edges_.left + edges_.right), plot_.height - 6, "middle", plot_.x_label, "label");
  }

  std::string level_line(const Level& level) {
    const double at = y_(level.y), width = text_width(level.label), left = edges_.left;
    const bool below = &level == &plot_.levels.back() && plot_.levels.size() > 1 && at + 18 < edges_.bottom;  // each on its own side
    const double line = below ? at + 14 : at - 5;
    labels_ += text_element(left + 6, line, "", level.label);
    occupied_.add(left + 6, line - 11, left + 6 + width, line + 2);
    return "<path class=\"guide\" d=\"M" + px(left) + " " + px(at) + "H" + px(edges_.right) + "\"/>";
  }

  std::string slope_line(const SlopeGuide& guide) {
    const auto at = [&](double value) { return guide.y * std::pow(value / guide.x, guide.slope); };
    const double from = guide.x, to = layout_.x_range.second, highest = layout_.y_range.second;
    double where = to * std::pow(layout_.x_range.first / to, 0.04);
    if (at(where) > highest) where = guide.x * std::pow(0.6 * highest / guide.y, 1 / guide.slope);
    const double width = text_width(guide.label);
    labels_ += text_element(x_(where), y_(at(where)) - 7, "end", guide.label);
    occupied_.add(x_(where) - width, y_(at(where)) - 19, x_(where), y_(at(where)) - 5);
    return "<path class=\"guide\" d=\"M" + px(x_(from)) + " " + px(y_(at(from))) + "L" + px(x_(to)) + " " + px(y_(at(to))) + "\"/>";
  }

  std::string curve_with_marks(const MarkedCurve& curve) {
    std::string path, marks;
    bool open = false;
    for (const Marker& p : curve.points) {
      if (!(p.x > 0) || !std::isfinite(p.x)) continue;
      if (p.failed) {
        const double at = x_(p.x), top = edges_.top;
        marks += cross_svg(curve.style, at, top + 6, 4.5);
        occupied_.add(at - 5, top, at + 5, top + 12);
        continue;
      }
      if (!can_show(axis_, shown_y(plot_, p.y))) {
        open = false;
        continue;
      }
      const double at_x = x_(p.x), at_y = y_(shown_y(plot_, p.y));
      path += (open ? "L" : "M") + px(at_x) + " " + px(at_y);
      open = true;
      if (!curve.marked) continue;
      marks += marker_svg(curve.style, at_x, at_y, 3.6);
      occupied_.add(at_x - 4, at_y - 4, at_x + 4, at_y + 4);
    }
    return "<path class=\"curve\" style=\"" + line_style(curve.style) + "\" d=\"" + path + "\"/>" + marks + "\n";
  }

  // Of four places beside a marker its label takes the first that is free; none where none is.
  void add_marker_label(const Marker& p, std::size_t style) {
    const double at_x = x_(p.x), at_y = y_(shown_y(plot_, p.y)), width = label_width(p.label);
    const std::array<std::pair<double, double>, 4> places = {
        std::pair{at_x + 6, at_y - 3}, {at_x - 6 - width, at_y + 12}, {at_x + 7, at_y + 5}, {at_x - 7 - width, at_y + 2}};
    for (const auto& [px_x, px_y] : places) {
      if (px_x < edges_.left || px_x + width > edges_.right || px_y - 10 < edges_.top || px_y > edges_.bottom) continue;
      if (!occupied_.is_free(px_x, px_y - 10, px_x + width, px_y + 2)) continue;
      labels_ += "<text class=\"small\" x=\"" + px(px_x) + "\" y=\"" + px(px_y) + "\" style=\"fill:" + marker_colour(style) + "\">" +
                 escaped(p.label) + "</text>\n";
      occupied_.add(px_x - 1, px_y - 11, px_x + width + 1, px_y + 3);
      return;
    }
  }

  const LogLogPlot& plot_;
  const Axis axis_{.label = {}, .scale = Scale::logarithmic, .range = {}};
  PlotLayout layout_;
  Edges edges_;
  AxisMap x_, y_;
  Occupied occupied_;
  std::string labels_;
};

}  // namespace detail

/// The picture as an <svg> element for a page that carries `theme_css` and `plot_css`.
inline std::string svg_element(const LogLogPlot& plot, const std::string& style = "") { return detail::LogLogDrawing(plot).element(style); }

/// CSS beside `plot_css` for what these pictures have more.
inline std::string loglog_css() {
  return ".plot .guide{stroke:var(--muted);stroke-width:1.2;stroke-dasharray:6 4;fill:none}\n"
         ".plot .mark{stroke:var(--card);stroke-width:.8}\n.plot .small{font-size:10.5px;paint-order:stroke;stroke:var(--card);"
         "stroke-width:3px;stroke-linejoin:round}\n";
}

/// The picture as an SVG file of its own: white or dark paper as the reader prefers.
inline std::string svg(const LogLogPlot& plot) {
  return svg_element(plot, "<style>\n" + theme_css(".plot") + plot_css() + loglog_css() +
                               "</style>\n<rect width=\"100%\" height=\"100%\" rx=\"6\" style=\"fill:var(--card)\"/>\n");
}

}  // namespace qdot::report
