#pragma once
// SPDX-License-Identifier: MIT
//
// One self-contained page: an animation with its player, tables of facts, formulas, and plots.
//
// The page needs nothing but a browser: style, script, numbers and plots are inside the file, and no address is contacted.
// Coordinates of the animation are rounded to 1e-4 of the picture's size, which no eye can see; the exact numbers are in the
// CSV and NPZ files beside it.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/report/animation.hpp"
#include "qdot/report/html_player.hpp"
#include "qdot/report/number.hpp"
#include "qdot/report/plot.hpp"
#include "qdot/report/svg.hpp"
#include "qdot/report/symbol.hpp"
#include "qdot/report/theme.hpp"

namespace qdot::report {

/// One line of a table of facts: "m1", "1.5 kg", "mass of the inner bob".
struct Fact {
  std::string name;      ///< "m1"
  std::string value;     ///< "1.5 kg"
  std::string remark{};  ///< what it is
};

/// A table of facts with a heading.
struct Facts {
  std::string heading;     ///< above it
  std::vector<Fact> rows;  ///< from top to bottom
};

/// What a page shows, from top to bottom.
struct Page {
  std::string title{};                   ///< above all
  std::string lead{};                    ///< one or two sentences
  std::optional<Animation> animation{};  ///< if there is one
  std::vector<Facts> tables{};           ///< beside it
  std::string formulas{};                ///< markup, as of report/equation_text.hpp
  std::vector<std::string> figures{};    ///< markup of the whole width, as of report/heat_map.hpp
  std::vector<Plot> plots{};             ///< two in a row
  std::string footer{};                  ///< a last line
};

namespace detail {

inline std::string facts_table(const Facts& facts) {
  std::string html = "<section class=\"card\"><h2>" + escaped(facts.heading) + "</h2><table>\n";
  for (const Fact& fact : facts.rows) {
    html += "<tr><td>" + escaped(fact.name) + (fact.remark.empty() ? "" : " <small>" + escaped(fact.remark) + "</small>") +
            "</td><td class=\"value\">" + escaped(with_readable_numbers(fact.value)) + "</td></tr>\n";
  }
  return html + "</table></section>\n";
}

/// Time units that pass per second of watching: 1 where that takes between 2 and 40 s, otherwise so that it takes 12 s.
inline double playing_rate(double duration) { return duration >= 2 && duration <= 40 ? 1.0 : duration / 12; }

/// How many frames an animation should have: a hundred a second of watching, at least 300, fewer for many points; none without points.
inline int frame_count(std::size_t points, double duration) {
  if (points == 0) return 0;
  const double wanted = 100 * duration / playing_rate(duration);
  return static_cast<int>(std::max(300.0, std::min(wanted, 30000 / static_cast<double>(points)))) + 1;
}

/// What happened, by name: how often, and when first and last.
inline Facts mark_facts(const std::vector<Mark>& marks, const std::string& time_unit) {
  constexpr std::size_t most_rows = 12;
  std::vector<std::pair<std::string, std::vector<double>>> by_name;
  for (const Mark& mark : marks) {
    auto known = std::find_if(by_name.begin(), by_name.end(), [&](const auto& entry) { return entry.first == mark.name; });
    if (known == by_name.end()) known = by_name.insert(known, {mark.name, {}});
    known->second.push_back(mark.x);
  }
  Facts facts{"Events", {}};
  for (const auto& [name, times] : by_name) {
    if (facts.rows.size() == most_rows) {
      facts.rows.push_back({"…", std::to_string(by_name.size() - most_rows) + " more names"});
      break;
    }
    const std::string first = "t = " + rounded_text(times.front(), 6), unit = time_unit.empty() ? "" : " " + time_unit;
    facts.rows.push_back({name, times.size() == 1
                                    ? first + unit
                                    : std::to_string(times.size()) + "×, " + first + " to " + rounded_text(times.back(), 6) + unit});
  }
  return facts;
}

inline double picture_size(const Animation& animation) {
  double size = 0;
  for (const auto& frame : animation.frames) {
    for (const Point& p : frame) size = std::max({size, std::abs(p.x), std::abs(p.y), animation.drawing.camera ? std::abs(p.z) : 0.0});
  }
  return size > 0 ? size : 1.0;
}

inline std::string animation_json(const Animation& animation) {
  static constexpr std::array<std::string_view, 8> kinds = {"line", "spring", "disk", "trail", "pivot", "box", "ellipse", "arrow"};
  const int decimals = std::clamp(static_cast<int>(std::ceil(4 - std::log10(picture_size(animation)))), 0, 300);
  const std::optional<Camera>& camera = animation.drawing.camera;
  const auto joined = [](const auto& items, const auto& text_of) {
    std::string text = "[";
    for (const auto& item : items) {
      if (text.size() > 1) text += ',';
      text += text_of(item);
    }
    text += ']';
    return text;
  };
  const auto frame_json = [&](const std::vector<Point>& frame) {
    return joined(frame, [&](const Point& p) {
      return fixed_text(p.x, decimals) + "," + fixed_text(p.y, decimals) + (camera ? "," + fixed_text(p.z, decimals) : "");
    });
  };
  const auto shape_json = [&](const Shape& shape) {
    return "{\"kind\":\"" + std::string(kinds[static_cast<std::size_t>(shape.kind)]) + "\",\"points\":" +
           joined(shape.points, [](int i) { return std::to_string(i); }) + ",\"size\":" + exact_text(shape.size) +
           ",\"size2\":" + exact_text(shape.size2) + ",\"colour\":" + std::to_string(shape.colour) + "}";
  };
  const auto line_json = [&](const std::vector<Point>& points) {
    return joined(points, [&](const Point& p) {
      return joined(camera ? std::vector{p.x, p.y, p.z} : std::vector{p.x, p.y}, [](double x) { return rounded_text(x); });
    });
  };
  const double duration = animation.times.back() - animation.times.front();
  return "{\"unit\":\"" + plain_json_text(animation.time_unit) + "\",\"rate\":" + exact_text(playing_rate(duration)) +
         (camera ? ",\n\"camera\":[" + rounded_text(camera->side) + "," + rounded_text(camera->above) + "]" : "") +
         ",\n\"shapes\":" + joined(animation.drawing.shapes, shape_json) +
         ",\n\"backdrop\":" + joined(animation.drawing.backdrop, line_json) +
         ",\n\"times\":" + joined(animation.times, [](double t) { return rounded_text(t, 8); }) +
         ",\n\"frames\":" + joined(animation.frames, frame_json) + "}";
}

/// Whether there is something to play: two frames or more, equally long, all finite.
inline bool playable(const std::optional<Animation>& animation) {
  if (!animation || animation->times.size() < 2 || animation->times.size() != animation->frames.size()) return false;
  if (!(animation->times.back() > animation->times.front())) return false;
  return std::all_of(animation->frames.begin(), animation->frames.end(), [&](const std::vector<Point>& frame) {
    return frame.size() == animation->frames.front().size() &&
           std::all_of(frame.begin(), frame.end(), [](Point p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); });
  });
}

inline std::string stage_html() {
  return "<section class=\"card stage\"><div class=\"screen\"><canvas id=\"stage\"></canvas></div>\n<div class=\"bar\"><button id=\"play\" type=\"button\">"
         "</button><input id=\"scrub\" type=\"range\" min=\"0\" max=\"1\" step=\"any\" value=\"0\" aria-label=\"Time\">"
         "<output id=\"clock\"></output><select id=\"speed\" aria-label=\"Speed\"><option value=\"0.1\">0.1×</option>"
         "<option value=\"0.25\">0.25×</option><option value=\"0.5\">0.5×</option><option value=\"1\" selected>1×</option>"
         "<option value=\"2\">2×</option><option value=\"4\">4×</option></select></div></section>\n";
}

}  // namespace detail

/// A plot with the names and numbers of its title, its labels and its legend in mathematical writing.
inline Plot in_symbols(Plot plot) {
  for (std::string* text : {&plot.title, &plot.x.label, &plot.y.label}) *text = in_symbols(*text);
  for (Series& series : plot.series) series.label = in_symbols(series.label);
  return plot;
}

/// A page likewise, with its tables of facts; its lead and its figures stay as they are.
inline Page in_symbols(Page page) {
  for (Facts& facts : page.tables) {
    facts.heading = in_symbols(facts.heading);
    for (Fact& fact : facts.rows)
      for (std::string* text : {&fact.name, &fact.value, &fact.remark}) *text = in_symbols(*text);
  }
  for (Plot& plot : page.plots) plot = in_symbols(std::move(plot));
  page.footer = in_symbols(page.footer);
  return page;
}

/// The page as one HTML file that loads nothing from a network.
///
/// The animation is left out where there is nothing to play: fewer than two frames, or a point that is not finite.
inline std::string html(const Page& page) {
  const bool moving = detail::playable(page.animation);
  std::string text = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
                     "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n<title>" +
                     escaped(page.title) + "</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>" + theme_css(":root") +
                     plot_css() + detail::page_css + "</style></head>\n<body><main>\n<h1>" + escaped(page.title) +
                     "</h1>\n<p class=\"lead\">" + escaped(page.lead) + "</p>\n<div class=\"grid\">\n";
  if (moving) {
    text += detail::stage_html() + "<div class=\"facts\">\n";
    for (const Facts& facts : page.tables) text += detail::facts_table(facts);
    text += "</div>\n";
  } else {
    for (const Facts& facts : page.tables) text += "<div class=\"half\">" + detail::facts_table(facts) + "</div>\n";
  }
  if (!page.formulas.empty()) text += "<section class=\"card wide formulas\">" + page.formulas + "</section>\n";
  for (const std::string& figure : page.figures) text += "<section class=\"card wide\">" + figure + "</section>\n";
  for (std::size_t i = 0; i < page.plots.size(); ++i) {
    const bool alone = i + 1 == page.plots.size() && i % 2 == 0;  // the last of an odd number takes the whole width
    text += std::string("<section class=\"card ") + (alone ? "wide" : "half") + "\">";
    Plot plot = page.plots[i];
    if (!alone) plot.width = 580;
    if (alone) plot.width = 1140;
    text += svg_element(plot) + "</section>\n";
  }
  text += "</div>\n<footer>" + escaped(page.footer) + "</footer>\n</main>\n";
  if (moving) {
    text += "<script type=\"application/json\" id=\"animation\">\n" + detail::animation_json(*page.animation) +
            "</script>\n<script>" + detail::player_script + "</script>\n";
  }
  return text + "</body></html>\n";
}

}  // namespace qdot::report
