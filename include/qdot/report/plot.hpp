#pragma once
// SPDX-License-Identifier: MIT
//
// A line plot as plain data, and the ticks that its axes get.
//
// Ticks stand at 1, 2 or 5 times a power of ten, as on ruled paper. Where numbers would be long (energy drifts of 1e-13),
// the axis takes a common factor 10ᵏ out and writes it once. A logarithmic axis has its ticks at powers of ten, thinned
// when there are many decades and joined by 2 and 5 when there are fewer than two.

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/report/number.hpp"

namespace qdot::report {

/// One curve; points with a coordinate that is not finite interrupt it.
struct Series {
  std::string label;      ///< in the legend
  std::vector<double> x;  ///< of the points
  std::vector<double> y;  ///< of the points
  bool markers = false;   ///< a dot on every point, for measurements rather than trajectories
  bool dots = false;      ///< small dots and no line, for the points of a section; with markers large ones
  bool dashed = false;    ///< a broken line, as what is unstable has it
};

/// How numbers lie along an axis.
enum class Scale {
  linear,      ///< equal distances for equal differences
  logarithmic  ///< equal distances for equal factors
};

/// One axis of a plot.
struct Axis {
  std::string label{};                               ///< with its unit: "t [s]"
  Scale scale = Scale::linear;                       ///< linear or logarithmic
  std::optional<std::pair<double, double>> range{};  ///< from the data where it is not given
};

/// A value of x that deserves a vertical line with a name: an event.
struct Mark {
  double x = 0;      ///< where
  std::string name;  ///< what happened there
};

/// Curves with their axes.
struct Plot {
  std::string title{};           ///< above it
  Axis x{};                      ///< the axes
  Axis y{};                      ///< the axes
  std::vector<Series> series{};  ///< one over the other
  double width = 720;            ///< px
  double height = 270;           ///< px
  bool equal_units = false;      ///< one unit is equally long on both axes, which are linear (orbits, trails)
  bool time_axis = false;        ///< x is the time of the animation: a page moves a cursor along it
  std::vector<Mark> marks{};     ///< vertical lines behind the curves, in the order of x
};

/// @throws InvalidValue  an axis is logarithmic: units of it have no length
inline void require_linear_axes(const Plot& plot) {
  if (plot.x.scale != Scale::linear || plot.y.scale != Scale::linear)
    throw InvalidValue("a plot with equal_units must have two linear axes, but one is logarithmic; leave one or the other");
}

/// A mark of an axis.
struct Tick {
  double value = 0;   ///< where
  std::string label;  ///< what it says
};

/// The marks of an axis.
struct Ticks {
  std::vector<Tick> ticks;  ///< in order
  int exponent = 0;         ///< labels are to be read as label × 10^exponent
};

/// Ticks of a linear axis from lo to hi, about `wanted` of them.
inline Ticks linear_ticks(double lo, double hi, int wanted) {
  const double rough = (hi - lo) / wanted;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double ratio = rough / power;
  const double step = power * (ratio < 1.42 ? 1 : ratio < 3.17 ? 2 : ratio < 7.08 ? 5 : 10);  // nearest in the logarithm

  Ticks result;
  const double largest = std::max(std::abs(lo), std::abs(hi));
  const int magnitude = static_cast<int>(std::floor(std::log10(largest) + 1e-9));
  if (magnitude >= 5 || magnitude <= -3) result.exponent = magnitude;
  const double unit = std::pow(10.0, result.exponent);
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step / unit) - 1e-9)), 0, 15);

  const auto first = static_cast<long long>(std::ceil(lo / step - 1e-9));
  const auto last = static_cast<long long>(std::floor(hi / step + 1e-9));
  for (long long k = first; k <= last; ++k) {
    const double value = static_cast<double>(k) * step;
    result.ticks.push_back({value, fixed_text(value / unit, decimals)});
  }
  return result;
}

/// Ticks of a logarithmic axis from lo to hi (both positive), at most about `wanted` of them.
inline Ticks logarithmic_ticks(double lo, double hi, int wanted) {
  Ticks result;
  const int first = static_cast<int>(std::floor(std::log10(lo) + 1e-9));
  const int last = static_cast<int>(std::ceil(std::log10(hi) - 1e-9));
  const int every = std::max(1, static_cast<int>(std::ceil(static_cast<double>(last - first) / wanted)));
  const bool few_decades = hi / lo < 150;
  for (int k = first; k <= last; ++k) {
    for (const int digit : {1, 2, 5}) {
      if (digit != 1 && !few_decades) continue;
      if (digit == 1 && (k % every) != 0) continue;
      const double value = digit * std::pow(10.0, k);
      if (value < lo * (1 - 1e-9) || value > hi * (1 + 1e-9)) continue;
      const std::string plain = rounded_text(value, 3);
      const bool short_number = few_decades && k >= -3 && k < 4;
      result.ticks.push_back(
          {value, short_number ? plain : (digit == 1 ? "" : std::to_string(digit) + "·") + "10" + superscript(k)});
    }
  }
  return result;
}

/// Whether an axis can show this value.
inline bool can_show(const Axis& axis, double value) {
  return std::isfinite(value) && (axis.scale == Scale::linear || value > 0);
}

/// The range that an axis shows: the one asked for, or that of its data with a little air.
///
/// @param data  all the values along this axis
/// @param air   fraction of the range (in decades on a logarithmic axis) to leave free at both ends
inline std::pair<double, double> shown_range(const Axis& axis, const std::vector<const std::vector<double>*>& data,
                                             double air) {
  if (axis.range) return *axis.range;
  double lo = std::numeric_limits<double>::infinity();
  double hi = -lo;
  for (const std::vector<double>* values : data) {
    for (const double v : *values) {
      if (!can_show(axis, v)) continue;
      lo = std::min(lo, v);
      hi = std::max(hi, v);
    }
  }
  if (axis.scale == Scale::logarithmic) {
    if (lo > hi) return {1.0, 10.0};
    if (hi / lo < 1.5) return {lo / 3, hi * 3};
    const double factor = std::pow(hi / lo, air);
    return {lo / factor, hi * factor};
  }
  if (lo > hi) return {0.0, 1.0};
  // A curve that is constant to rounding is drawn as a line through the middle, not as magnified noise.
  const double least = std::max(std::abs(lo), std::abs(hi)) * 1e-12;
  if (hi - lo <= least) {
    const double half = hi == 0 && lo == 0 ? 1.0 : 0.5 * std::abs(hi);
    return {lo - half, hi + half};
  }
  return {lo - air * (hi - lo), hi + air * (hi - lo)};
}

}  // namespace qdot::report
