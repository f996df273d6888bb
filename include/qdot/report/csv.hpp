#pragma once
// SPDX-License-Identifier: MIT
//
// Comma-separated values (RFC 4180): one line of headings, "theta [rad]", then one line per row.
//
// Every number is the shortest text that reads back to the same double, so a CSV file loses nothing. Read it with
// pandas.read_csv("x.csv"), numpy.genfromtxt("x.csv", delimiter=",", names=True), or any spreadsheet.

#include <cstddef>
#include <string>

#include "qdot/report/number.hpp"
#include "qdot/report/table.hpp"

namespace qdot::report {

namespace detail {

/// A field as RFC 4180 wants it: quoted where it contains a comma, a quote or a line break.
inline std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

}  // namespace detail

/// The table as CSV text: a line of headings with units, then one line per row; lines end with "\n".
///
/// @throws DimensionError  when the columns differ in length
inline std::string csv(const Table& table) {
  rectangular(table);
  std::string text;
  for (std::size_t j = 0; j < table.columns.size(); ++j) {
    text += (j == 0 ? "" : ",") + detail::csv_field(table.columns[j].heading());
  }
  text += '\n';
  for (std::size_t i = 0; i < table.rows(); ++i) {
    for (std::size_t j = 0; j < table.columns.size(); ++j) {
      if (j != 0) text += ',';
      text += exact_text(table.columns[j].values[i]);
    }
    text += '\n';
  }
  return text;
}

}  // namespace qdot::report
