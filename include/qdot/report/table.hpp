#pragma once
// SPDX-License-Identifier: MIT
//
// What the report layer is given: columns of numbers with names and units, nothing else.
//
// Nothing in report/ knows about mechanics. A run is turned into a `Table` once, by the code that ran it, and every writer (CSV,
// NPZ, plots, page) uses the table. So a writer can be tested as text, without a simulation.

#include <cstddef>
#include <string>
#include <vector>

#include "qdot/error.hpp"

namespace qdot::report {

/// One named quantity with its unit, one value per row; an empty unit means dimensionless.
struct Column {
  std::string name;            ///< of the quantity
  std::string unit;            ///< empty for none
  std::vector<double> values;  ///< a number for each row

  /// Name and unit as a heading: "theta [rad]", or the bare name where there is no unit.
  std::string heading() const { return unit.empty() ? name : name + " [" + unit + "]"; }
};

/// Columns of equal length.
struct Table {
  std::vector<Column> columns;  ///< from left to right

  /// Length of the columns.
  std::size_t rows() const { return columns.empty() ? 0 : columns.front().values.size(); }

  /// The column of that name.
  ///
  /// @throws InvalidValue  when there is none
  const Column& column(const std::string& name) const {
    for (const Column& c : columns) {
      if (c.name == name) return c;
    }
    throw InvalidValue("a table is read by the names of its columns; it has no column \"" + name + "\"");
  }
};

/// The table itself, once it is known that its columns are equally long.
///
/// @throws DimensionError  naming the first column whose length differs from that of the first
inline const Table& rectangular(const Table& table) {
  for (const Column& c : table.columns) {
    if (c.values.size() != table.rows()) {
      throw DimensionError("column \"" + c.name + "\"", static_cast<long>(table.rows()),
                           static_cast<long>(c.values.size()), "all columns of a table have equal length");
    }
  }
  return table;
}

}  // namespace qdot::report
