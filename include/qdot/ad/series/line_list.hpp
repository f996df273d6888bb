#pragma once
// SPDX-License-Identifier: MIT
//
// A table of lines that is written line by line: the ends of a sweep (ad/series/sweep.ipp).

#include <cstddef>
#include <cstdint>
#include <utility>

#include "qdot/ad/formula/lines.hpp"
#include "qdot/ad/series/sweep_outputs.hpp"

namespace qdot::taylor {

/// Lines whose results are numbered as they are added.
class LineList {
 public:
  LineList(std::uint32_t& next, std::size_t expected) : next_(next) { table_.lines.reserve(expected); }

  std::uint32_t add(Line line) {
    line.to = next_++;
    table_.lines.push_back(line);
    return line.to;
  }
  std::uint32_t product(std::uint32_t a, std::uint32_t b) { return add({.operation = Line::Operation::product, .a = a, .b = b}); }
  std::uint32_t sum(std::uint32_t a, std::uint32_t b) { return add({.operation = Line::Operation::sum, .a = a, .b = b}); }
  /// ca·a + cb·b; −0 adds nothing.
  std::uint32_t combination(double ca, std::uint32_t a, double cb, std::uint32_t b) {
    if (ca == 1.0 && cb == 1.0) return sum(a, b);
    return add({.operation = Line::Operation::combination, .a = a, .b = b, .ca = ca, .cb = cb, .c = -0.0});
  }
  std::uint32_t scaled(double ca, std::uint32_t a) { return add({.operation = Line::Operation::scaled, .a = a, .ca = ca, .c = -0.0}); }
  std::uint32_t product_sum(std::uint32_t a, std::uint32_t b, std::uint32_t d) {
    return add({.operation = Line::Operation::product_sum, .a = a, .b = b, .d = d});
  }
  std::uint32_t difference(std::uint32_t a, std::uint32_t b) { return add({.operation = Line::Operation::difference, .a = a, .b = b}); }
  std::uint32_t quotient(std::uint32_t a, std::uint32_t b) { return add({.operation = Line::Operation::quotient, .a = a, .b = b}); }
  std::uint32_t less_product(std::uint32_t a, std::uint32_t b, std::uint32_t d) {
    return add({.operation = Line::Operation::less_product, .a = a, .b = b, .d = d});
  }
  void copy(std::uint32_t a, std::uint32_t to) {
    table_.lines.push_back({.operation = Line::Operation::scaled, .to = to, .a = a, .ca = 1.0, .c = -0.0});
  }
  formula::LineTable finished() {
    table_.lines.push_back({});
    return std::move(table_);
  }

 private:
  std::uint32_t& next_;
  formula::LineTable table_;
};

}  // namespace qdot::taylor
