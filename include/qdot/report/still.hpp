#pragma once
// SPDX-License-Identifier: MIT
//
// One moment of an animation as SVG: the shapes where they are then, over the paths that their points have drawn.
//
// For documents that cannot play a page. In a still, trails last for the whole motion up to that moment.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/report/animation.hpp"
#include "qdot/report/svg.hpp"
#include "qdot/report/theme.hpp"

namespace qdot::report {

namespace detail {

/// Fits the plane of an animation into a rectangle of the picture, with equal units on both axes.
class PictureMap {
 public:
  PictureMap(const Animation& animation, double width, double height) {
    double lo_x = std::numeric_limits<double>::infinity(), hi_x = -lo_x, lo_y = lo_x, hi_y = -lo_x;
    const auto see = [&](const Point& p) {
      lo_x = std::min(lo_x, p.x), hi_x = std::max(hi_x, p.x), lo_y = std::min(lo_y, p.y), hi_y = std::max(hi_y, p.y);
    };
    for (const auto& frame : animation.frames) std::for_each(frame.begin(), frame.end(), see);
    for (const auto& points : animation.drawing.backdrop) std::for_each(points.begin(), points.end(), see);
    constexpr double margin = 24;
    const double least = 1e-3 * std::max({hi_x - lo_x, hi_y - lo_y, 1e-300});
    zoom_ = std::min((width - 2 * margin) / std::max(hi_x - lo_x, least), (height - 2 * margin) / std::max(hi_y - lo_y, least));
    shift_x_ = 0.5 * width - 0.5 * zoom_ * (lo_x + hi_x);
    shift_y_ = 0.5 * height + 0.5 * zoom_ * (lo_y + hi_y);
  }
  double x(const Point& p) const { return shift_x_ + zoom_ * p.x; }
  double y(const Point& p) const { return shift_y_ - zoom_ * p.y; }
  double length(double l) const { return zoom_ * l; }

 private:
  double zoom_ = 1, shift_x_ = 0, shift_y_ = 0;
};

inline std::string still_path(const std::vector<Pixel>& points, const std::string& style) {
  std::string data;
  for (const Pixel& p : points) data += (data.empty() ? "M" : "L") + px(p.x) + " " + px(p.y);
  return "<path d=\"" + data + "\" style=\"fill:none;stroke-linejoin:round;stroke-linecap:round;" + style + "\"/>\n";
}

inline std::vector<Pixel> coil(Pixel a, Pixel b) {
  const double length = std::max(std::hypot(b.x - a.x, b.y - a.y), 1e-9);
  const double ux = (b.x - a.x) / length, uy = (b.y - a.y) / length, lead = std::min(12.0, 0.12 * length);
  std::vector<Pixel> points = {a, {a.x + ux * lead, a.y + uy * lead}};
  constexpr int corners = 18;
  constexpr double amplitude = 7;
  for (int i = 0; i < corners; ++i) {
    const double s = lead + (length - 2 * lead) * (i + 0.5) / corners, side = (i % 2 == 0 ? 1 : -1) * amplitude;
    points.push_back({a.x + ux * s - uy * side, a.y + uy * s + ux * side});
  }
  points.push_back({b.x - ux * lead, b.y - uy * lead});
  points.push_back(b);
  return points;
}

inline std::string still_shape(const Shape& shape, const Animation& animation, std::size_t now, const PictureMap& map) {
  const std::vector<Point>& frame = animation.frames[now];
  const auto at = [&](std::size_t i) {
    const Point& p = frame[static_cast<std::size_t>(shape.points[i])];
    return Pixel{map.x(p), map.y(p)};
  };
  const auto colour = [&](const char* otherwise) {
    return shape.colour < 0 ? std::string(otherwise) : "var(--s" + std::to_string(shape.colour % 8) + ")";
  };
  const Pixel p = at(0);
  const std::string centre = "cx=\"" + px(p.x) + "\" cy=\"" + px(p.y) + "\"";
  std::vector<Pixel> points;
  switch (shape.kind) {
    case Shape::Kind::line:
      for (std::size_t i = 0; i < shape.points.size(); ++i) points.push_back(at(i));
      return still_path(points, "stroke-width:2.4;stroke:" + colour("var(--ink)"));
    case Shape::Kind::spring:
      return still_path(coil(p, at(1)), "stroke-width:1.6;stroke:var(--muted)");
    case Shape::Kind::disk:
      return "<circle " + centre + " r=\"" + px(shape.size) + "\" style=\"stroke:var(--card);stroke-width:2;fill:" +
             colour("var(--muted)") + "\"/>\n";
    case Shape::Kind::trail:
      for (std::size_t i = 0; i <= now; ++i) {
        const Point& past = animation.frames[i][static_cast<std::size_t>(shape.points[0])];
        points.push_back({map.x(past), map.y(past)});
      }
      return still_path(points, "stroke-width:1.3;opacity:.55;stroke:" + colour("var(--muted)"));
    case Shape::Kind::pivot:
      return "<circle " + centre + " r=\"4\" style=\"fill:var(--card);stroke:var(--ink);stroke-width:2\"/>\n";
    case Shape::Kind::box: {
      const double w = map.length(shape.size), h = map.length(shape.size2);
      return "<rect x=\"" + px(p.x - w / 2) + "\" y=\"" + px(p.y - h / 2) + "\" width=\"" + px(w) + "\" height=\"" + px(h) +
             "\" style=\"stroke:var(--ink);stroke-width:1.6;fill:" + colour("var(--rule)") + "\"/>\n";
    }
    case Shape::Kind::ellipse:
      for (int k = 0; k <= 72; ++k) {
        const double c = std::cos(k * 0.08726646259971647), s = std::sin(k * 0.08726646259971647);
        points.push_back({p.x + c * (at(1).x - p.x) + s * (at(2).x - p.x), p.y + c * (at(1).y - p.y) + s * (at(2).y - p.y)});
      }
      return still_path(points, "stroke-width:1.6;stroke:" + colour("var(--muted)"));
    case Shape::Kind::arrow: {
      const Pixel tip = at(1);
      const double length = std::hypot(tip.x - p.x, tip.y - p.y), head = std::min(9.0, length);
      if (length < 1) return "";
      const double ux = (tip.x - p.x) / length * head, uy = (tip.y - p.y) / length * head;
      return still_path({p, {tip.x - 0.8 * ux, tip.y - 0.8 * uy}}, "stroke-width:2.2;stroke:" + colour("var(--muted)")) + "<path d=\"M" + px(tip.x) + " " +
             px(tip.y) + "L" + px(tip.x - ux - 0.45 * uy) + " " + px(tip.y - uy + 0.45 * ux) + "L" + px(tip.x - ux + 0.45 * uy) + " " +
             px(tip.y - uy - 0.45 * ux) +
             "z\" style=\"fill:" + colour("var(--muted)") + "\"/>\n";
    }
  }
  return "";
}

}  // namespace detail

/// The animation at the last frame that is not after t, beside a plot; an SVG file of its own.
///
/// @throws InvalidValue  when the animation has no frames
inline std::string still_svg(const Animation& given, double t, Plot plot) {
  using namespace detail;
  const Animation animation = as_seen(given);
  if (animation.frames.empty()) throw InvalidValue("a still shows a frame of an animation; this one has none");
  std::size_t now = 0;
  while (now + 1 < animation.frames.size() && animation.times[now + 1] <= t) ++now;
  constexpr double side = 380, width = 1000;
  plot.width = width - side;
  plot.height = side;
  std::string text = "<svg class=\"plot\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + px(width) + " " + px(side) +
                     "\" width=\"" + px(width) + "\" height=\"" + px(side) + "\" role=\"img\" aria-label=\"" +
                     escaped(plot.title) + "\">\n<style>\n" + theme_css("svg") + plot_css() +
                     "</style>\n<rect width=\"100%\" height=\"100%\" rx=\"6\" style=\"fill:var(--card)\"/>\n";
  const PictureMap map(animation, side, side);
  for (const auto& line : animation.drawing.backdrop) {
    std::vector<Pixel> points;
    for (const Point& p : line) points.push_back({map.x(p), map.y(p)});
    text += still_path(points, "stroke-width:1.5;opacity:.55;stroke:var(--muted)");
  }
  for (const Shape& shape : animation.drawing.shapes) text += still_shape(shape, animation, now, map);
  return text + "<g transform=\"translate(" + px(side) + " 0)\">\n" + svg_element(plot) + "</g>\n</svg>\n";
}

}  // namespace qdot::report
