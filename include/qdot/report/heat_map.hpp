#pragma once
// SPDX-License-Identifier: MIT
//
// A quantity over a plane, as colours: markup for a page (html.hpp) that draws itself on a canvas.
//
// Cells are in rows from the bottom to the top, as many as there are values. The wheel zooms at the pointer, dragging shifts, and a double click shows
// all. The value under the pointer is shown below. Colours go from dark blue over green to yellow, evenly in lightness (after the map "viridis" of
// Smith and van der Walt, 2015, in nine steps with straight lines between). A cell without a value is hatched, and its text gives the reason.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/report/number.hpp"
#include "qdot/report/svg.hpp"
#include "qdot/report/symbol.hpp"

namespace qdot::report {

/// One value for each pair of an x and a y.
struct HeatMap {
  std::string title{};                 ///< above it
  std::string x_label{}, y_label{};    ///< with units
  std::vector<double> x{}, y{};        ///< of the centres of columns and rows
  std::vector<double> values{};        ///< row by row from the first y; what is not finite has no colour
  std::vector<std::string> remarks{};  ///< of cells without a value, by cell; empty for none
};

namespace detail {

inline constexpr const char* heat_map_script = R"js(
for (const figure of document.querySelectorAll('.heatmap')) {
  const d = JSON.parse(figure.querySelector('script').textContent), canvas = figure.querySelector('canvas'), pen = canvas.getContext('2d');
  const said = figure.querySelector('output'), nx = d.x.length, ny = d.y.length, grid = document.createElement('canvas');
  const scale = [[68,1,84],[72,40,120],[62,74,137],[49,104,142],[38,130,142],[31,158,137],[53,183,121],[109,205,89],[253,231,37]];
  const colour = u => { const k = Math.min(7, Math.floor(8 * u)), f = 8 * u - k; return scale[k].map((c, i) => Math.round(c + f * (scale[k + 1][i] - c))); };
  grid.width = nx; grid.height = ny;
  const pixels = grid.getContext('2d').createImageData(nx, ny);
  for (let j = 0; j < ny; ++j) for (let i = 0; i < nx; ++i) {
    const v = d.values[j * nx + i], at = 4 * ((ny - 1 - j) * nx + i);
    const c = v === null ? ((i + j) % 2 ? [128, 128, 128] : [160, 160, 160]) : colour(d.high > d.low ? (v - d.low) / (d.high - d.low) : 0.5);
    pixels.data.set([...c, 255], at);
  }
  grid.getContext('2d').putImageData(pixels, 0, 0);
  let view = [0, 0, nx, ny], drag = null;
  const style = getComputedStyle(document.documentElement), left = 88, bottom = 42, right = 12, top = 8;
  const text = x => Number(x.toPrecision(4)).toString().replace(/^-/, '\u2212');
  // Round numbers between the centres in view, and how far along it they are; of few cells or of uneven ones the centres of some.
  const ticks = (values, first, count) => {
    const n = values.length, low = Math.max(0, Math.ceil(first - 0.5)), high = Math.min(n - 1, Math.floor(first + count - 0.5));
    const even = f => values.every((v, i) => i < 2 || Math.abs(f(v) + f(values[i - 2]) - 2 * f(values[i - 1])) <= 1e-6 * Math.abs(f(values[n - 1]) - f(values[0])));
    const straight = even(v => v), f = straight ? v => v : Math.log10;
    if (high - low < 6 || !(straight || (values.every(v => v > 0) && even(f)))) {
      const marks = Math.min(5, high - low + 1);
      return Array.from({ length: marks }, (_, k) => low + Math.round(k * (high - low) / Math.max(1, marks - 1))).map(i => [values[i], (i + 0.5 - first) / count]);
    }
    const [least, most] = [values[low], values[high]].sort((a, b) => a - b), marks = [];
    const place = v => (low + (high - low) * (f(v) - f(values[low])) / (f(values[high]) - f(values[low])) + 0.5 - first) / count;
    if (!straight && most / least >= 50) {
      for (let k = Math.ceil(Math.log10(least) - 1e-9); Math.pow(10, k) <= most * (1 + 1e-9); ++k) marks.push(Number('1e' + k));
    } else {
      const rough = (most - least) / 5, power = Math.pow(10, Math.floor(Math.log10(rough))), r = rough / power, step = power * (r < 1.42 ? 1 : r < 3.17 ? 2 : r < 7.08 ? 5 : 10);
      for (let k = Math.ceil(least / step - 1e-9); k * step <= most + 1e-9 * step; ++k) marks.push(k * step);
    }
    return marks.map(v => [v, place(v)]);
  };
  const columns = d.x, rows = d.y.slice().reverse();
  const draw = () => {
    const ratio = window.devicePixelRatio || 1, w = canvas.clientWidth, h = canvas.clientHeight;
    canvas.width = w * ratio; canvas.height = h * ratio; pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.imageSmoothingEnabled = false;
    pen.clearRect(0, 0, w, h);
    pen.drawImage(grid, view[0], view[1], view[2], view[3], left, top, w - left - right, h - top - bottom);
    pen.fillStyle = style.getPropertyValue('--muted'); pen.font = "12.5px system-ui,'DejaVu Sans',sans-serif";
    pen.textAlign = 'center';
    for (const [v, at] of ticks(columns, view[0], view[2])) pen.fillText(text(v), left + (w - left - right) * at, h - bottom + 16);
    pen.fillText(d.x_label, left + (w - left - right) / 2, h - 6);
    pen.textAlign = 'right';
    for (const [v, at] of ticks(rows, view[1], view[3])) pen.fillText(text(v), left - 6, top + (h - top - bottom) * at + 4);
    pen.save(); pen.translate(12, top +
                              (h - top - bottom) / 2); pen.rotate(-Math.PI / 2); pen.textAlign = 'center'; pen.fillText(d.y_label, 0, 0); pen.restore();
  };
  const cell = e => {
    const r = canvas.getBoundingClientRect(), u = (e.clientX - r.left - left) / (r.width - left - right),
        v = (e.clientY - r.top - top) / (r.height - top - bottom);
    return [u, v, view[0] + u * view[2], view[1] + v * view[3]];
  };
  const keep = () => { view[2] = Math.min(nx, Math.max(4, view[2])); view[3] = Math.min(ny, Math.max(4, view[3]));
    view[0] = Math.min(nx - view[2], Math.max(0, view[0])); view[1] = Math.min(ny - view[3], Math.max(0, view[1])); draw(); };
  canvas.addEventListener('pointermove', e => {
    const [u, v, x, y] = cell(e);
    if (drag) { view[0] += drag[2] - x; view[1] += drag[3] - y; keep(); return; }
    const i = Math.floor(x), j = ny - 1 - Math.floor(y);
    if (u < 0 || u > 1 || v < 0 || v > 1 || i >= nx || j < 0) { said.textContent = '\u00a0'; return; }
    const value = d.values[j * nx + i];
    said.textContent = d.x_name + ' = ' + d.x[i] + ', ' + d.y_name + ' = ' + d.y[j] + ': ' + (value === null ? d.remarks[j * nx + i] || 'no value' : value);
  });
  canvas.addEventListener('pointerdown', e => { drag = cell(e); canvas.setPointerCapture(e.pointerId); });
  canvas.addEventListener('pointerup', () => { drag = null; });
  canvas.addEventListener('wheel', e => {
    e.preventDefault();
    const [u, v, x, y] = cell(e), f = e.deltaY > 0 ? 1.25 : 0.8;
    view[2] = Math.min(nx, view[2] * f); view[3] = Math.min(ny, view[3] * f); view[0] = x - u * view[2]; view[1] = y - v * view[3]; keep();
  }, { passive: false });
  canvas.addEventListener('dblclick', () => { view = [0, 0, nx, ny]; draw(); });
  const bar = figure.querySelector('.scale'); bar.style.background = 'linear-gradient(to right,' + scale.map(c => 'rgb(' + c + ')').join() + ')';
  new ResizeObserver(draw).observe(canvas);
}
)js";

inline std::string json_number(double x) { return std::isfinite(x) ? rounded_text(x, 7) : "null"; }

inline std::string json_numbers(const std::vector<double>& values) {
  std::string text = "[";
  for (const double x : values) text += (text.size() > 1 ? "," : "") + json_number(x);
  return text + "]";
}

inline std::string json_string(const std::string& text) { return "\"" + plain_json_text(text) + "\""; }

}  // namespace detail

/// The map as markup; heat_map_script() has to stand behind the last of a page.
///
/// @throws DimensionError  unless there is one value for each cell
inline std::string heat_map(const HeatMap& map) {
  if (map.values.size() != map.x.size() * map.y.size())
    throw DimensionError("the values of a heat map", static_cast<long>(map.x.size() * map.y.size()), static_cast<long>(map.values.size()),
                         "give one for each cell");
  double low = INFINITY, high = -INFINITY;
  for (const double v : map.values)
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  std::string remarks = "{";
  for (std::size_t i = 0; i < map.remarks.size(); ++i)
    if (!map.remarks[i].empty() && !std::isfinite(map.values[i]))
      remarks += (remarks.size() > 1 ? ",\"" : "\"") + std::to_string(i) + "\":" + detail::json_string(map.remarks[i]);
  const auto name_of = [](const std::string& label) { return label.substr(0, label.find(" [")); };
  const bool any = low <= high;
  return "<figure class=\"heatmap\" style=\"margin:0\"><h2>" + escaped(map.title) +
         "</h2><canvas style=\"position:static;height:min(70vh,640px);touch-action:none;cursor:crosshair\"></canvas>"
         "<div style=\"display:flex;align-items:center;gap:12px;font-size:13px;color:var(--muted)\"><span>" +
         escaped(any ? with_readable_numbers(rounded_text(low, 4)) : "") +
         "</span><span class=\"scale\" style=\"flex:0 0 200px;height:12px;border-radius:3px\"></span><span>" +
         escaped(any ? with_readable_numbers(rounded_text(high, 4)) : "no values") +
         "</span><output style=\"margin-left:auto;font-variant-numeric:tabular-nums\">&nbsp;</output></div>\n<script type=\"application/json\">{\"x\":" +
         detail::json_numbers(map.x) + ",\"y\":" + detail::json_numbers(map.y) + ",\"x_label\":" + detail::json_string(map.x_label) +
         ",\"y_label\":" + detail::json_string(map.y_label) + ",\"x_name\":" + detail::json_string(name_of(map.x_label)) +
         ",\"y_name\":" + detail::json_string(name_of(map.y_label)) + ",\"low\":" + detail::json_number(any ? low : 0.0) +
         ",\"high\":" + detail::json_number(any ? high : 1.0) + ",\n\"values\":" + detail::json_numbers(map.values) +
         ",\n\"remarks\":" + remarks + "}}</script></figure>";
}

/// What draws the maps of a page; once, behind the last of them.
inline std::string heat_map_script() { return std::string("<script>") + detail::heat_map_script + "</script>"; }

}  // namespace qdot::report
