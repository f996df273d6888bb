#pragma once
// SPDX-License-Identifier: MIT
//
// The colours of plots and pages, once for light and once for dark.
//
// Eight series colours that stay apart for the common forms of colour blindness (after Okabe and Ito, "Color Universal Design",
// 2008). They are darkened or lightened until they read well as thin lines on their paper. More than eight curves are drawn along
// one hue circle, because then their order matters more than their names.

#include <array>
#include <cstddef>
#include <string>

#include "qdot/report/number.hpp"

namespace qdot::report {

/// How many colours curves have, one after the other.
inline constexpr std::size_t series_colours = 8;

/// Colours as CSS has them.
struct Theme {
  const char* paper;                               ///< of the page
  const char* card;                                ///< of what lies on it
  const char* ink;                                 ///< of words and lines
  const char* muted;                               ///< of remarks
  const char* rule;                                ///< of thin lines
  std::array<const char*, series_colours> series;  ///< of curves
};

/// For daylight.
inline constexpr Theme light_theme = {
    "#fbfaf8", "#ffffff", "#1d2430", "#646d7a", "#e3e2de",
    {"#0a66b0", "#cf4a12", "#0b7a58", "#8f45a8", "#a97800", "#c2376f", "#4d6a80", "#7b5a34"}};

/// For the night.
inline constexpr Theme dark_theme = {
    "#14171c", "#1b1f26", "#e6e8ec", "#98a1ae", "#30363f",
    {"#62b0f2", "#ff8a5c", "#45c49a", "#c794e0", "#e0b341", "#f07fae", "#9db8cc", "#c9a77a"}};

namespace detail {

inline std::string variables(const Theme& theme) {
  std::string css = std::string("--paper:") + theme.paper + ";--card:" + theme.card + ";--ink:" + theme.ink +
                    ";--muted:" + theme.muted + ";--rule:" + theme.rule + ";";
  for (std::size_t i = 0; i < series_colours; ++i) {
    css += "--s" + std::to_string(i) + ":" + theme.series[i] + ";";
  }
  return css;
}

}  // namespace detail

/// CSS that defines --paper, --ink, … --s7 on a selector, and again for readers who prefer dark.
inline std::string theme_css(const std::string& selector) {
  return selector + "{" + detail::variables(light_theme) + "color-scheme:light dark}\n" +
         "@media (prefers-color-scheme:dark){" + selector + "{" + detail::variables(dark_theme) + "}}\n";
}

/// CSS for the inside of plots; needs the variables of `theme_css`.
inline std::string plot_css() {
  return ".plot text{font:12.5px system-ui,-apple-system,'Segoe UI',Roboto,'DejaVu Sans',sans-serif;fill:var(--muted);"
         "font-variant-numeric:tabular-nums}\n"
         ".plot .title{fill:var(--ink);font-weight:600;font-size:14px}.plot .label{fill:var(--ink)}\n"
         ".plot .grid{stroke:var(--rule);stroke-width:1;fill:none}.plot .frame{stroke:var(--muted);fill:none}\n"
         ".plot .curve{fill:none;stroke-width:1.7;stroke-linejoin:round;stroke-linecap:round}\n"
         ".plot .mark{stroke:var(--muted);stroke-width:1;stroke-dasharray:2 3;fill:none}.plot .name{font-size:11px;paint-order:stroke;stroke:var(--card);stroke-width:3px}\n"
         ".plot .cursor{stroke:var(--ink);stroke-width:1;opacity:.55}\n";
}

/// The CSS colour of curve number i out of `count`.
inline std::string series_colour(std::size_t i, std::size_t count) {
  if (count <= series_colours) return "var(--s" + std::to_string(i) + ")";
  const double hue = 210 + 270 * static_cast<double>(i) / static_cast<double>(count - 1);
  return "hsl(" + fixed_text(hue, 1) + ",62%,52%)";
}

}  // namespace qdot::report
