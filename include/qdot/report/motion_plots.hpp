#pragma once
// SPDX-License-Identifier: MIT
//
// From the table of a motion to the plots that one looks at first.
//
// The table has the time in its first column, then n coordinates and n velocities, and behind them what else there is: states of controllers,
// and perhaps kinetic_energy, potential_energy and energy. Quantities of one unit share a plot, for one can compare them, unless one would be flat
// beside another; a single coordinate is shown in its phase plane, too. What never changes behind the velocities, the phase of a contact that never
// closes, is left out. Events are marks, the same in every plot against time.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/report/plot.hpp"
#include "qdot/report/symbol.hpp"
#include "qdot/report/table.hpp"

namespace qdot::report {

namespace detail {

// "θ₁, θ₂, θ₃" or "θ₁ … θ₂₀"
inline std::string listed(const std::vector<std::string>& symbols) {
  if (symbols.size() > 4) return symbols.front() + " … " + symbols.back();
  std::string text;
  for (const std::string& s : symbols) text += (text.empty() ? "" : ", ") + s;
  return text;
}

inline Plot plot_against_time(const Table& table, const std::vector<Mark>& events) {
  return {.x = {with_unit_symbol(symbol(table.columns[0].name), table.columns[0].unit)}, .time_axis = true, .marks = events};
}

inline constexpr std::size_t most_series = 100, some_series = 12;

// Of columns of one unit those that can be read in one plot: a curve that moves would be flat beside one that goes 15 times as far. Four groups at most.
inline std::vector<std::vector<std::size_t>> groups_of_size(const Table& table, const std::vector<std::size_t>& columns) {
  constexpr double flat = 15.0, rests = 1e-9;
  constexpr std::size_t most_groups = 4;
  struct Group {
    std::vector<std::size_t> columns;
    double low, high, least;  // of all values; and the extent of the one that moves least
  };
  std::vector<Group> groups;
  double largest = 0.0;
  for (const std::size_t k : columns)
    for (const double v : table.columns[k].values) largest = std::isfinite(v) ? std::max(largest, std::abs(v)) : largest;
  for (const std::size_t k : columns) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const double v : table.columns[k].values)
      if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
    if (low > high) low = high = 0.0;
    const Group alone{{k}, low, high, high - low > rests * largest ? high - low : std::numeric_limits<double>::infinity()};
    const auto fits = [&](const Group& g) {
      const double all = std::max(g.high, high) - std::min(g.low, low);
      return all <= flat * std::min(g.least, alone.least) || !std::isfinite(std::min(g.least, alone.least));
    };
    const auto found = std::find_if(groups.begin(), groups.end(), fits);
    if (found == groups.end() && groups.size() < most_groups) {
      groups.push_back(alone);
      continue;
    }
    Group& into = found == groups.end() ? groups.back() : *found;
    into.columns.push_back(k);
    into = {std::move(into.columns), std::min(into.low, low), std::max(into.high, high), std::min(into.least, alone.least)};
  }
  std::vector<std::vector<std::size_t>> found;
  for (Group& group : groups) found.push_back(std::move(group.columns));
  return found;
}

// Columns first to last − 1, a plot for each unit and size among them; of very many some, evenly spread, in one.
inline void add_plots_by_unit(std::vector<Plot>& plots, const Table& table, std::size_t first, std::size_t last, const std::vector<Mark>& events,
                              bool by_size) {
  std::vector<std::string> units;
  for (std::size_t k = first; k < last; ++k) {
    if (std::find(units.begin(), units.end(), table.columns[k].unit) == units.end()) units.push_back(table.columns[k].unit);
  }
  for (const std::string& unit : units) {
    std::vector<std::size_t> all;
    for (std::size_t k = first; k < last; ++k)
      if (table.columns[k].unit == unit) all.push_back(k);
    if (all.size() > most_series) {
      for (std::size_t i = 0; i < some_series; ++i) all[i] = all[(all.size() - 1) * i / (some_series - 1)];
      all.resize(some_series);
    }
    const bool together = !by_size || all.size() >= some_series;
    for (const auto& shown : together ? std::vector<std::vector<std::size_t>>(1, all) : groups_of_size(table, all)) {
      Plot plot = plot_against_time(table, events);
      std::vector<std::string> symbols;
      for (const std::size_t k : shown) {
        symbols.push_back(symbol(table.columns[k].name));
        plot.series.push_back({symbols.back(), table.columns[0].values, table.columns[k].values});
      }
      plot.y.label = with_unit_symbol(listed(symbols), unit);
      if (plot.series.size() == 1) plot.series[0].label.clear();
      plots.push_back(std::move(plot));
    }
  }
}

}  // namespace detail

/// Plots of a motion: coordinates, velocities, the phase plane of a single coordinate, what else the table has, and its energies in one plot.
///
/// @param table    time, `dof` coordinates, `dof` velocities, and further columns
/// @param events   marks of the plots against time, in the order of time
/// @param by_size  whether curves that would be flat beside others have plots of their own
/// @throws InvalidValue  a table with fewer than 1 + 2 dof columns
inline std::vector<Plot> motion_plots(const Table& table, std::size_t dof, const std::vector<Mark>& events = {}, bool by_size = true) {
  if (table.columns.size() < 1 + 2 * dof)
    throw InvalidValue("plots of a motion with " + std::to_string(dof) + " coordinates need a table of the time, the coordinates and the velocities, " +
                       std::to_string(1 + 2 * dof) + " columns, but this one has " + std::to_string(table.columns.size()));
  std::vector<Plot> plots;
  const auto& columns = table.columns;
  detail::add_plots_by_unit(plots, table, 1, 1 + dof, events, by_size);
  detail::add_plots_by_unit(plots, table, 1 + dof, 1 + 2 * dof, events, by_size);
  if (dof == 1) {
    plots.push_back({.x = {with_unit_symbol(symbol(columns[1].name), columns[1].unit)}, .y = {with_unit_symbol(symbol(columns[2].name), columns[2].unit)}});
    plots.back().series.push_back({"", columns[1].values, columns[2].values});
  }
  const auto energies = std::find_if(columns.begin(), columns.end(), [](const Column& c) { return c.name == "kinetic_energy"; });
  const auto others = static_cast<std::size_t>(energies - columns.begin());
  const auto rests = [](const Column& c) { return std::all_of(c.values.begin(), c.values.end(), [&](double v) { return v == c.values.front(); }); };
  if (!std::all_of(columns.begin() + static_cast<std::ptrdiff_t>(1 + 2 * dof), energies, rests))
    detail::add_plots_by_unit(plots, table, 1 + 2 * dof, others, events, by_size);
  if (energies == columns.end()) return plots;
  Plot plot = detail::plot_against_time(table, events);
  plot.y.label = with_unit_symbol("energy", energies->unit);
  for (const auto& [name, label] : {std::pair<const char*, const char*>{"kinetic_energy", "T"}, {"potential_energy", "V"}, {"energy", "T + V"}})
    plot.series.push_back({label, columns[0].values, table.column(name).values});
  plots.push_back(std::move(plot));
  return plots;
}

}  // namespace qdot::report
