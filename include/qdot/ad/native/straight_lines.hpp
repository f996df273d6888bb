#pragma once
// SPDX-License-Identifier: MIT
//
// A table of lines without runs, and what registers need to know of it.
//
// Native code has no loops: each line of a run (ad/formula/lines.hpp) becomes a line of its own. Values that are computed have numbers; the others are
// inputs. For each value its uses are known, in order, so that a register can be taken from the value whose next use is furthest away. That
// costs the fewest loads (L. A. Belady, IBM Systems Journal 5 (1966), 78).

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "qdot/ad/formula/lines.hpp"

namespace qdot::formula {

/// Calls f with each number that a line reads.
template <class F>
void for_each_operand(const Line& l, const F& f) {
  using Operation = Line::Operation;
  switch (l.operation) {
    case Operation::end:
    case Operation::constant:
    case Operation::run: return;
    case Operation::scaled:
    case Operation::square:
    case Operation::inverse:
    case Operation::root:
    case Operation::inverse_root:
    case Operation::power:
    case Operation::sine_and_cosine: return f(l.a);
    case Operation::combination:
    case Operation::sum:
    case Operation::difference:
    case Operation::product:
    case Operation::quotient:
    case Operation::function: return f(l.a), f(l.b);
    case Operation::product_sum:
    case Operation::product_difference:
    case Operation::less_product:
    case Operation::product_combination: return f(l.a), f(l.b), f(l.d);
    case Operation::products_sum:
    case Operation::products_difference:
    case Operation::products_combination: return f(l.a), f(l.b), f(l.d), f(l.e);
  }
}

/// Calls f with each number that a line computes.
template <class F>
void for_each_result(const Line& l, const F& f) {
  if (l.operation == Line::Operation::end || l.operation == Line::Operation::run) return;
  f(l.to);
  if (l.operation == Line::Operation::sine_and_cosine) f(l.b);
}

/// The lines of a table in order, runs taken apart.
class StraightLines {
 public:
  static constexpr std::uint32_t never = std::numeric_limits<std::uint32_t>::max();

  /// @param count    how many numbers there are
  /// @param longest  lines, beyond which there is nothing
  [[gnu::cold]] StraightLines(const LineTable& table, std::size_t count, std::size_t longest) {
    if (!append(table, longest) || !is_in_order(count)) lines_.clear();
    else find_uses(count);
  }

  /// Nothing where the table is too long, or damaged: a number outside, or one that is computed twice, or after its use.
  const std::vector<Line>& lines() const { return lines_; }

  /// Whether a line computes a value; others are inputs.
  bool is_computed(std::uint32_t value) const { return computed_[value] != 0; }
  /// The first use of a value at or after a line; `never` where there is none. Lines are asked for in order.
  std::uint32_t next_use(std::uint32_t value, std::uint32_t line) {
    std::uint32_t& at = next_[value];
    while (at < begin_[value + 1] && uses_[at] < line) ++at;
    return at < begin_[value + 1] ? uses_[at] : never;
  }

 private:
  [[gnu::cold]] bool append(const LineTable& table, std::size_t longest) {
    for (const Line& line : table.lines) {
      if (line.operation == Line::Operation::end) break;
      if (line.operation != Line::Operation::run) lines_.push_back(line);
      else if (line.a >= table.runs.size() || !append(table, table.runs[line.a], longest)) return false;
      if (lines_.size() > longest) return false;
    }
    return true;
  }
  [[gnu::cold]] bool append(const LineTable& table, const RunOfLines& run, std::size_t longest) {
    const bool four = has_products(run.first.operation);
    const std::size_t width = four ? 4 : 2, count = run.count;
    if (count > longest) return false;
    if (run.places >= 0 && static_cast<std::size_t>(run.places) + width * count > table.places.size()) return false;
    if (run.factors >= 0 && static_cast<std::size_t>(run.factors) + 3 * count > table.factors.size()) return false;
    for (std::size_t k = 0; k < count; ++k) {
      Line line = run.first;
      const auto k32 = static_cast<std::uint32_t>(k);
      const bool pair = line.operation == Line::Operation::sine_and_cosine;  // b is where the cosine goes
      line.to += k32;
      if (pair) line.b += k32;
      if (run.places >= 0) {
        const std::uint32_t* const at = table.places.data() + run.places + width * k;
        line.a = at[0];
        if (!pair) line.b = at[1];
        if (four) line.d = at[2], line.e = at[3];
      } else {
        line.a += k32 * static_cast<std::uint32_t>(run.step_a);
        if (!pair) line.b += k32 * static_cast<std::uint32_t>(run.step_b);
        line.d += k32 * static_cast<std::uint32_t>(run.step_d);
        line.e += k32 * static_cast<std::uint32_t>(run.step_e);
      }
      if (run.factors >= 0) {
        const double* const factor = table.factors.data() + run.factors + 3 * k;
        line.ca = factor[0], line.cb = factor[1], line.c = factor[2];
      }
      lines_.push_back(line);
    }
    return true;
  }

  [[gnu::cold]] bool is_in_order(std::size_t count) {
    enum : char { input_or_none, read, computed };
    std::vector<char> state(count, input_or_none);
    bool good = true;
    for (const Line& line : lines_) {
      for_each_operand(line, [&](std::uint32_t v) {
        good = good && v < count;
        if (good && state[v] == input_or_none) state[v] = read;
      });
      for_each_result(line, [&](std::uint32_t v) {
        good = good && v < count && state[v] == input_or_none;
        if (good) state[v] = computed;
      });
      if (!good) return false;
    }
    computed_.resize(count);
    for (std::size_t v = 0; v < count; ++v) computed_[v] = state[v] == computed;
    return true;
  }

  [[gnu::cold]] void find_uses(std::size_t count) {
    begin_.assign(count + 1, 0);
    const auto each_use = [&](const auto& f) {
      for (std::uint32_t k = 0; k < lines_.size(); ++k) for_each_operand(lines_[k], [&](std::uint32_t v) { f(k, v); });
    };
    each_use([&](std::uint32_t, std::uint32_t v) { ++begin_[v + 1]; });
    for (std::size_t v = 0; v < count; ++v) begin_[v + 1] += begin_[v];
    next_.assign(begin_.begin(), begin_.end() - 1);
    uses_.resize(begin_[count]);
    each_use([&](std::uint32_t k, std::uint32_t v) { uses_[next_[v]++] = k; });
    next_.assign(begin_.begin(), begin_.end() - 1);
  }

  std::vector<Line> lines_;
  std::vector<char> computed_;
  std::vector<std::uint32_t> uses_, begin_, next_;  // lines that use value v: uses_[begin_[v]] to uses_[begin_[v + 1] − 1]
};

}  // namespace qdot::formula
