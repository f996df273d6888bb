#pragma once
// SPDX-License-Identifier: MIT
//
// From a run to a table in one line, and from there to whatever the writers of this folder make of tables:
//
//     const auto run = simulate(system, start, 10.0, Dop853{});
//     write_files({{"swing.csv", csv(motion_table(system, run, 1001))}});
//
// The columns are t, the coordinates, the velocities and the effects' own states, by the names that messages call them: q0, q1, …, qdot0, …,
// z0, …, or those that the system was given. Rows are at equal distances in time, on the dense output of the method, which is as accurate as
// its steps. At a jump a row has the state behind it. sample_table() has a row for each of Options::output_times instead.

#include <Eigen/Core>
#include <cstddef>
#include <string>

#include "qdot/error.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/mechanics/first_order_form.hpp"
#include "qdot/report/table.hpp"

namespace qdot::report {

namespace detail {

// A table without rows.
template <class System>
Table headings(const System& system, Eigen::Index size) {
  const auto& form = first_order_form(system);
  if (form.size() != size)
    throw DimensionError("the state of the run", static_cast<long>(form.size()), static_cast<long>(size), "give the system that the run is of");
  Table table;
  table.columns.push_back({"t", "", {}});
  for (Eigen::Index i = 0; i < size; ++i) table.columns.push_back({form.component_name(i), "", {}});
  return table;
}

template <class Y>
void add_row(Table& table, double t, const Y& y) {
  table.columns[0].values.push_back(t);
  for (std::size_t i = 1; i < table.columns.size(); ++i) table.columns[i].values.push_back(y[static_cast<Eigen::Index>(i - 1)]);
}

}  // namespace detail

/// The motion of a run, t and y = [q; q̇; z], at equal distances in time from its start to its last good state.
///
/// @param system  system or scene that the run is of; it has the names
/// @param rows    at least 2
/// @throws InvalidValue    fewer than two rows, or a run of some length that kept no trajectory (Options::keep_trajectory)
/// @throws DimensionError  a system of another size
template <class System, int n>
Table motion_table(const System& system, const Run<n>& run, int rows) {
  if (rows < 2) throw InvalidValue("a table of a motion must have at least 2 rows (both ends), but was asked for " + std::to_string(rows));
  const auto& motion = run.trajectory;
  const double t0 = motion.front_time(), t_end = motion.back_time();
  if (t_end != run.t)
    throw InvalidValue(
        "a table needs the trajectory of a run, but this one kept only its start; leave Options::keep_trajectory on, or give output_times and take sample_table()");
  Table table = detail::headings(system, run.y.size());
  for (int i = 0; i < rows; ++i) {
    const double t = i + 1 == rows ? t_end : t0 + (t_end - t0) * (static_cast<double>(i) / (rows - 1));
    detail::add_row(table, t, motion.y(t));
  }
  return table;
}

/// The motion of a run at its output times, as far as it came.
///
/// @throws InvalidValue    a run without output times
/// @throws DimensionError  a system of another size
template <class System, int n>
Table sample_table(const System& system, const Run<n>& run) {
  if (run.samples.t.empty()) throw InvalidValue("a table of samples needs Options::output_times, but this run has none; give them, or take motion_table()");
  Table table = detail::headings(system, run.y.size());
  for (std::size_t k = 0; k < run.samples.t.size(); ++k) detail::add_row(table, run.samples.t[k], run.samples.y.col(static_cast<Eigen::Index>(k)));
  return table;
}

}  // namespace qdot::report
