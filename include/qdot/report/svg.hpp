#pragma once
// SPDX-License-Identifier: MIT
//
// Line plots as SVG text.
//
//     title
//     y label                      — curve   — curve         the label stands above the axis, beside the legend,
//     ×10⁻¹³                                                 so that the curves keep the width
//      2 ┤    ╭─╮
//      1 ┤ ╭──╯ ╰───
//      0 ┼────┬────┬────
//        0    1    2          t [s]
//
// Curves with far more points than pixels are thinned so that nothing visible is lost. Within each quarter of a pixel
// the first, lowest, highest and last point stay; of dots (Series::dots) one in each tenth of a pixel, of marks one in
// each pixel. Colours are CSS variables (theme.hpp), so one file serves light and dark.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "qdot/report/number.hpp"
#include "qdot/report/plot.hpp"
#include "qdot/report/theme.hpp"

namespace qdot::report {

/// Text with the characters that XML and HTML reserve replaced by entities.
inline std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&': result += "&amp;"; break;
      case '<': result += "&lt;"; break;
      case '>': result += "&gt;"; break;
      case '"': result += "&quot;"; break;
      default: result += c;
    }
  }
  return result;
}

namespace detail {

// Text that may stand between quotes in JSON inside a <script>: no quotes, no "<", no control characters.
inline std::string plain_json_text(const std::string& text) {
  std::string result;
  for (const char c : text)
    if (c != '"' && c != '\\' && c != '<' && static_cast<unsigned char>(c) >= 0x20) result += c;
  return result;
}

inline std::string px(double x) { return fixed_text(x, 2); }

/// Approximate width in px of text at the plots' font size; combining marks take none.
inline double text_width(const std::string& text) {
  double glyphs = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if ((byte & 0xC0U) == 0x80U) continue;
    if (byte == 0xCC || byte == 0xCD) continue;
    ++glyphs;
  }
  return 7.3 * glyphs;
}

inline std::string text_element(double x, double y, const std::string& anchor, const std::string& text, const std::string& css_class = "") {
  return "<text x=\"" + px(x) + "\" y=\"" + px(y) + "\"" + (anchor.empty() ? "" : " text-anchor=\"" + anchor + "\"") +
         (css_class.empty() ? "" : " class=\"" + css_class + "\"") + ">" + escaped(text) + "</text>\n";
}

/// The hyphen before a number becomes a minus sign.
inline std::string with_minus(const std::string& number) { return number.starts_with('-') ? "−" + number.substr(1) : number; }

/// Maps values of one axis onto pixels.
class AxisMap {
 public:
  AxisMap(const Axis& axis, std::pair<double, double> range, double from_px, double to_px)
      : axis_(axis), lo_(position(range.first)), hi_(position(range.second)), from_(from_px), to_(to_px) {}

  double operator()(double value) const { return from_ + (position(value) - lo_) / (hi_ - lo_) * (to_ - from_); }

 private:
  double position(double value) const { return axis_.scale == Scale::logarithmic ? std::log10(value) : value; }

  const Axis& axis_;
  double lo_, hi_, from_, to_;
};

/// The rectangle between the axes, in px.
struct Edges {
  double left, right, top, bottom;
};

/// The left edge that leaves room for the labels of the y axis.
inline double left_edge(const Ticks& y_ticks) {
  double left = 0;
  for (const Tick& tick : y_ticks.ticks) left = std::max(left, text_width(tick.label));
  return left + 24;
}

/// Where the parts of a plot stand, and what its axes say.
struct PlotLayout {
  std::pair<double, double> x_range, y_range;
  Edges edges;
  double label_line;  // of the y axis
  Ticks x_ticks, y_ticks;
  std::string legend;  // SVG text
};

/// The beginning of a plot's element; the tag is left open.
inline std::string opening_tag(double width, double height, const std::string& name) {
  return "<svg class=\"plot\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + px(width) + " " + px(height) + "\" width=\"" + px(width) +
         "\" height=\"" + px(height) + "\" role=\"img\" aria-label=\"" + escaped(name) + "\"";
}

/// Grid lines and labels at the ticks.
inline std::string ticks_svg(const PlotLayout& layout, const AxisMap& x, const AxisMap& y) {
  const auto& [left, right, top, bottom] = layout.edges;
  std::string grid, labels;
  for (const Tick& tick : layout.x_ticks.ticks) grid += "M" + px(x(tick.value)) + " " + px(top) + "V" + px(bottom);
  for (const Tick& tick : layout.y_ticks.ticks) grid += "M" + px(left) + " " + px(y(tick.value)) + "H" + px(right);
  for (const Tick& tick : layout.x_ticks.ticks) labels += text_element(x(tick.value), bottom + 18, "middle", with_minus(tick.label));
  for (const Tick& tick : layout.y_ticks.ticks) labels += text_element(left - 8, y(tick.value) + 4.5, "end", with_minus(tick.label));
  return "<path class=\"grid\" d=\"" + grid + "\"/>\n" + labels;
}

/// The beginning of a nested viewport, which clips what leaves it.
inline std::string viewport_tag(double x, double y, double width, double height) {
  return "<svg x=\"" + px(x) + "\" y=\"" + px(y) + "\" width=\"" + px(width) + "\" height=\"" + px(height) + "\" viewBox=\"" + px(x) + " " + px(y) +
         " " + px(width) + " " + px(height) + "\">\n";
}

/// The lines of both axes.
inline std::string frame_path(const Edges& edges) {
  return "<path class=\"frame\" d=\"M" + px(edges.left) + " " + px(edges.top) + "V" + px(edges.bottom) + "H" + px(edges.right) + "\"/>\n";
}

struct Pixel {
  double x, y;
};

/// Drops what cannot be seen: of the points within a quarter of a pixel keep first, lowest, highest and last.
inline std::vector<Pixel> thinned(const std::vector<Pixel>& run) {
  std::vector<Pixel> kept;
  for (std::size_t i = 0; i < run.size();) {
    std::size_t end = i + 1, low = i, high = i;
    while (end < run.size() && std::abs(run[end].x - run[i].x) < 0.25) {
      if (run[end].y < run[low].y) low = end;
      if (run[end].y > run[high].y) high = end;
      ++end;
    }
    std::vector<std::size_t> chosen = {i, std::min(low, high), std::max(low, high), end - 1};
    chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
    for (const std::size_t k : chosen) kept.push_back(run[k]);
    i = end;
  }
  return kept;
}

inline std::string path_data(const Series& series, const Axis& x_axis, const Axis& y_axis, const AxisMap& x, const AxisMap& y, bool thin) {
  std::string data;
  std::vector<Pixel> run;
  const auto flush = [&] {
    const std::vector<Pixel> points = thin ? thinned(run) : run;
    for (std::size_t i = 0; i < points.size(); ++i) data += (i == 0 ? "M" : "L") + px(points[i].x) + " " + px(points[i].y);
    run.clear();
  };
  for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
    if (can_show(x_axis, series.x[i]) && can_show(y_axis, series.y[i])) {
      run.push_back({x(series.x[i]), y(series.y[i])});
    } else {
      flush();
    }
  }
  flush();
  return data;
}

inline std::string dashes(const Series& series) { return series.dashed ? ";stroke-dasharray:5 4.5" : ""; }

/// Lines of no length, whose round ends are dots; a dot upon another one is left out.
inline std::string dots_data(const Series& series, const Axis& x_axis, const Axis& y_axis, const AxisMap& x, const AxisMap& y) {
  std::vector<std::string> dots;
  for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i)
    if (can_show(x_axis, series.x[i]) && can_show(y_axis, series.y[i]))
      dots.push_back("M" + fixed_text(x(series.x[i]), 1) + " " + fixed_text(y(series.y[i]), 1) + "h0");
  std::sort(dots.begin(), dots.end());
  dots.erase(std::unique(dots.begin(), dots.end()), dots.end());
  std::string data;
  for (const std::string& dot : dots) data += dot;
  return data;
}

struct LegendEntry {
  double x, y;
  std::size_t series;
};

/// Places the legend in rows that end at the right edge; returns the entries and the number of rows.
inline std::pair<std::vector<LegendEntry>, int> legend(const Plot& plot, double left, double right) {
  std::vector<std::vector<std::pair<std::size_t, double>>> rows(1);  // series, offset from the row's start
  std::vector<double> widths(1, 0.0);
  double room = right - left - text_width(plot.y.label) - 24;
  const std::size_t count = plot.series.size();
  const bool all = count <= 12;  // of a long chain the first and the last tell the colours
  for (std::size_t i = 0; i < count; ++i) {
    if (plot.series[i].label.empty() || !(all || i == 0 || i + 1 == count || i == count / 2)) continue;
    const double width = 22 + text_width(plot.series[i].label) + 14;
    if (widths.back() + width > room && widths.back() > 0) {
      rows.emplace_back();
      widths.push_back(0.0);
      room = right - left;
    }
    rows.back().emplace_back(i, widths.back());
    widths.back() += width;
  }
  std::vector<LegendEntry> entries;
  for (std::size_t r = 0; r < rows.size(); ++r)
    for (const auto& [series, offset] : rows[r]) entries.push_back({right - widths[r] + 14 + offset, 18 * static_cast<double>(r), series});
  return {entries, static_cast<int>(rows.size())};
}

inline std::string legend_svg(const Plot& plot, const std::vector<LegendEntry>& entries, double label_line) {
  std::string svg;
  for (const LegendEntry& entry : entries) {
    const std::string colour = series_colour(entry.series, plot.series.size());
    const double line = label_line + entry.y;
    const Series& series = plot.series[entry.series];
    svg += series.dots && series.markers
               ? "<circle cx=\"" + px(entry.x + 8) + "\" cy=\"" + px(line - 4.5) + "\" r=\"4\" style=\"fill:" + colour + "\"/>"
               : "<path class=\"curve\" style=\"stroke:" + colour + ";stroke-width:2.5" + dashes(series) + "\" d=\"M" + px(entry.x) + " " +
                     px(line - 4.5) + "h16\"/>";
    svg += text_element(entry.x + 22, line, "", series.label);
  }
  return svg;
}

inline Ticks ticks(const Axis& axis, std::pair<double, double> range, double length_px, double px_per_tick) {
  const int wanted = std::max(2, static_cast<int>(length_px / px_per_tick));
  return axis.scale == Scale::logarithmic ? logarithmic_ticks(range.first, range.second, wanted)
                                          : linear_ticks(range.first, range.second, wanted);
}

/// Widens the range of one axis until a unit is equally long on both.
inline void equalize(std::pair<double, double>& x, std::pair<double, double>& y, double width_px, double height_px) {
  const double unit = std::max((x.second - x.first) / width_px, (y.second - y.first) / height_px);
  const double dx = 0.5 * (unit * width_px - (x.second - x.first));
  const double dy = 0.5 * (unit * height_px - (y.second - y.first));
  x = {x.first - dx, x.second + dx};
  y = {y.first - dy, y.second + dy};
}

/// The marks of a plot as lines from top to bottom, to be drawn behind the curves, and their names, in front of them. A name is drawn
/// where it is new, below others if it must, and again wherever it fits in front of the next mark. Each of the first few hundred lines
/// shows its own name to a pointer. What happens more than forty times is a rug: one path of short lines at the bottom, with its name and
/// how often.
inline std::pair<std::string, std::string> drawn_marks(const Plot& plot, const AxisMap& x, double left, double right, double top, double bottom) {
  constexpr std::size_t most_told = 200, most_rows = 3;
  constexpr std::ptrdiff_t most_lines = 40;
  const auto times = [&](const std::string& name) {
    return std::count_if(plot.marks.begin(), plot.marks.end(), [&](const Mark& m) { return m.name == name && can_show(plot.x, m.x); });
  };
  std::vector<std::string> seen;
  std::vector<std::pair<std::string, std::string>> rugs;  // name, path
  std::vector<std::pair<double, std::size_t>> shown;      // px, number of the mark
  double last = -1e9;
  for (std::size_t k = 0; k < plot.marks.size(); ++k) {
    const Mark& mark = plot.marks[k];
    if (!can_show(plot.x, mark.x)) continue;
    const double at = x(mark.x);
    if (at < left - 0.5 || at > right + 0.5) continue;
    auto rug = std::find_if(rugs.begin(), rugs.end(), [&](const auto& each) { return each.first == mark.name; });
    const bool known = rug != rugs.end() || std::find(seen.begin(), seen.end(), mark.name) != seen.end();
    if (!known && times(mark.name) > most_lines) rug = rugs.insert(rugs.end(), {mark.name, ""});
    if (!known && rug == rugs.end()) seen.push_back(mark.name);
    if (rug != rugs.end()) {
      if (const std::string line = "M" + px(std::round(at)) + " " + px(bottom - 7) + "v7"; !rug->second.ends_with(line)) rug->second += line;
      continue;
    }
    if (known && at - last < 1) continue;
    shown.push_back({at, k});
    last = at;
  }
  std::string lines, names;
  for (std::size_t i = 0; i < rugs.size(); ++i) {
    const std::string often = rugs[i].first + ", " + std::to_string(times(rugs[i].first)) + "×";
    lines += "<path class=\"mark\" d=\"" + rugs[i].second + "\"><title>" + escaped(often) + "</title></path>";
    names += text_element(right - 4, bottom - 11 - 13 * static_cast<double>(i), "end", often, "name");
  }
  std::vector<std::string> known;
  std::array<double, most_rows> named_to{};
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const auto& [at, k] = shown[i];
    const Mark& mark = plot.marks[k];
    lines += "<path class=\"mark\" d=\"M" + px(at) + " " + px(top) + "V" + px(bottom) + "\">";
    if (i < most_told) lines += "<title>" + escaped(mark.name + ", " + rounded_text(mark.x, 6)) + "</title>";
    lines += "</path>";
    const double width = text_width(mark.name) * 11 / 12.5, next = i + 1 < shown.size() ? shown[i + 1].first : right;
    const bool is_new = std::find(known.begin(), known.end(), mark.name) == known.end(), to_the_left = at + 4 + width > right;
    const double from = to_the_left ? at - 4 - width : at + 4;
    if (!is_new && (to_the_left || from + width > next)) continue;
    for (std::size_t row = 0; row < (is_new ? most_rows : 1); ++row) {
      if (from < named_to[row] + 4) continue;
      names += text_element(to_the_left ? at - 4 : from, top + 11 + 13 * static_cast<double>(row), to_the_left ? "end" : "", mark.name, "name");
      named_to[row] = to_the_left ? at : from + width;
      known.push_back(mark.name);
      break;
    }
  }
  return {lines, names};
}

inline PlotLayout layout_of(const Plot& plot) {
  std::vector<const std::vector<double>*> xs, ys;
  for (const Series& s : plot.series) {
    xs.push_back(&s.x);
    ys.push_back(&s.y);
  }
  auto x_range = shown_range(plot.x, xs, plot.time_axis ? 0.0 : 0.04);
  auto y_range = shown_range(plot.y, ys, 0.06);
  const double right = plot.width - 18, bottom = plot.height - 40;
  const double head = plot.title.empty() ? 8 : 32, label_line = head + 13;
  const auto [entries, legend_rows] = legend(plot, 12, right);
  const double top = head + 18 * std::max(legend_rows, 1) + 14;
  Ticks y_ticks = ticks(plot.y, y_range, bottom - top, 36);
  const double left = left_edge(y_ticks);
  if (plot.equal_units) {
    require_linear_axes(plot);
    equalize(x_range, y_range, right - left, bottom - top);
    y_ticks = ticks(plot.y, y_range, bottom - top, 36);
  }
  const Ticks x_ticks = ticks(plot.x, x_range, right - left, plot.x.scale == Scale::linear ? 84 : 60);
  return {x_range, y_range, {left, right, top, bottom}, label_line, x_ticks, y_ticks, legend_svg(plot, entries, label_line)};
}

/// The label of an axis, with the power of ten that its ticks have in common.
inline std::string label_with_power(const Axis& axis, const Ticks& ticks) {
  return ticks.exponent == 0 ? axis.label : axis.label + "  ×10" + superscript(ticks.exponent);
}

/// One curve of a plot: its line, small dots or a line with markers.
inline std::string curve_svg(const Plot& plot, std::size_t i, const AxisMap& x, const AxisMap& y) {
  const Series& series = plot.series[i];
  const std::string colour = series_colour(i, plot.series.size());
  if (series.dots && !series.markers)
    return "<path class=\"curve\" style=\"stroke:" + colour + ";stroke-width:2.4\" d=\"" + dots_data(series, plot.x, plot.y, x, y) + "\"/>\n";
  std::string svg;
  if (!series.dots)
    svg += "<path class=\"curve\" style=\"stroke:" + colour + dashes(series) + "\" d=\"" +
           path_data(series, plot.x, plot.y, x, y, !series.markers && !plot.equal_units) + "\"/>\n";
  if (!series.markers) return svg;
  for (std::size_t k = 0; k < std::min(series.x.size(), series.y.size()); ++k) {
    if (!can_show(plot.x, series.x[k]) || !can_show(plot.y, series.y[k])) continue;
    svg += "<circle cx=\"" + px(x(series.x[k])) + "\" cy=\"" + px(y(series.y[k])) + "\" r=\"" + (series.dots ? "4.5" : "3.2") + "\" style=\"fill:" +
           colour + "\"/>";
  }
  return svg;
}

}  // namespace detail

/// The plot as an <svg> element for a page that carries `theme_css` and `plot_css`.
inline std::string svg_element(const Plot& plot, const std::string& style = "") {
  using namespace detail;
  const PlotLayout layout = layout_of(plot);
  const auto& [left, right, top, bottom] = layout.edges;
  const AxisMap x(plot.x, layout.x_range, left, right), y(plot.y, layout.y_range, bottom, top);

  std::string svg = opening_tag(plot.width, plot.height, plot.title.empty() ? plot.y.label : plot.title);
  if (plot.time_axis)
    svg += " data-time=\"" + px(left) + " " + px(right) + " " + px(top) + " " + px(bottom) + " " +
           exact_text(layout.x_range.first) + " " + exact_text(layout.x_range.second) + "\"";
  svg += ">\n" + style;
  if (!plot.title.empty()) svg += text_element(12, 22, "", plot.title, "title");
  svg += text_element(12, layout.label_line, "", label_with_power(plot.y, layout.y_ticks), "label") + layout.legend;
  svg += ticks_svg(layout, x, y);
  svg += text_element(0.5 * (left + right), plot.height - 6, "middle", label_with_power(plot.x, layout.x_ticks), "label");

  // Curves may leave a range that the caller chose.
  const auto [mark_lines, mark_names] = drawn_marks(plot, x, left, right, top, bottom);
  svg += viewport_tag(left, top - 2, right - left, bottom - top + 4) + mark_lines;
  for (std::size_t i = 0; i < plot.series.size(); ++i) svg += curve_svg(plot, i, x, y);
  return svg + mark_names + "</svg>\n" + frame_path(layout.edges) + "</svg>\n";
}

/// The plot as an SVG file of its own: white or dark paper as the reader prefers.
inline std::string svg(const Plot& plot) {
  const std::string style = "<style>\n" + theme_css(".plot") + plot_css() +
                            "</style>\n<rect width=\"100%\" height=\"100%\" rx=\"6\" style=\"fill:var(--card)\"/>\n";
  return svg_element(plot, style);
}

}  // namespace qdot::report
