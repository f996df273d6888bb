#pragma once
// SPDX-License-Identifier: MIT
//
// The ends of a sweep as two tables of lines.
//
//     early     what interiors of quotients, powers and functions are, then coefficients k where late variables have none
//     late      coefficients k of what depends on late variables, and copies of the rates for the next order
//
// Where there is a recurrence, the early table begins with the variables and ends with the solution for the late ones, M₀ v_k = τ/k · F_{k−1} − p_k, by
// the factors of M₀; entries of L that are zero for all states are left out.
//
// In the early table a late variable is zero, and what is zero is left out. So a node that depends on late variables has two numbers, one of each table;
// other nodes have one.
//
// Included by ad/series/sweep.hpp.

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "qdot/ad/native/straight_lines.hpp"
#include "qdot/ad/series/sweep.hpp"

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

// v and mu from the right sides of M v − Wᵀ mu = v, W v = mu.
[[gnu::cold]] inline Sweep::Solution Sweep::solution(LineList& lines, std::vector<Number> v, std::vector<Number> mu) const {
  const std::size_t n = v.size(), m = mu.size();
  const auto place = [](std::size_t i, std::size_t j) { return i * (i + 1) / 2 + j; };
  // Entries of L, of B and of L' that are not zero for all states: those of M and W, and what elimination fills in.
  const auto fill_in = [&](std::vector<char>& there, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i)
      for (std::size_t j = 0; j <= i; ++j)
        for (std::size_t k = 0; k < j; ++k)
          if (there[place(i, k)] && there[place(j, k)]) there[place(i, j)] = 1;
  };
  std::vector<char> in_L(triangle(n)), in_B(m * n), in_S(triangle(m));
  for (std::size_t i = 0; i < in_L.size(); ++i) in_L[i] = recurrence_.mass[i] >= 0;
  fill_in(in_L, n);
  for (std::size_t r = 0; r < m; ++r)
    for (std::size_t i = 0; i < n; ++i) {
      in_B[r * n + i] = recurrence_.jacobian[r * n + i] >= 0;
      for (std::size_t j = 0; j < i; ++j)
        if (in_L[place(i, j)] && in_B[r * n + j]) in_B[r * n + i] = 1;
    }
  for (std::size_t r = 0; r < m; ++r)
    for (std::size_t l = 0; l <= r; ++l)
      for (std::size_t i = 0; i < n; ++i)
        if (in_B[r * n + i] && in_B[l * n + i]) in_S[place(r, l)] = 1;
  fill_in(in_S, m);

  const auto forward = [&](std::vector<Number>& x, const std::vector<char>& there, Number factors) {
    for (std::size_t i = 0; i < x.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (there[place(i, j)]) x[i] = lines.less_product(factors + static_cast<Number>(place(i, j)), x[j], x[i]);
  };
  const auto backward = [&](std::vector<Number>& x, const std::vector<char>& there, Number factors) {
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = lines.product(factors + static_cast<Number>(place(i, i)), x[i]);
    for (std::size_t i = x.size(); i-- > 0;)
      for (std::size_t j = 0; j < i; ++j)
        if (there[place(i, j)]) x[j] = lines.less_product(factors + static_cast<Number>(place(i, j)), x[i], x[j]);
  };
  const Number scaled_B = row_factors_, B = scaled_B + static_cast<Number>(m * n), S = B + static_cast<Number>(m * n);
  forward(v, in_L, mass_factors_);
  for (std::size_t r = 0; r < m; ++r)
    for (std::size_t i = 0; i < n; ++i)
      if (in_B[r * n + i]) mu[r] = lines.less_product(scaled_B + static_cast<Number>(r * n + i), v[i], mu[r]);
  forward(mu, in_S, S);
  backward(mu, in_S, S);
  for (std::size_t r = 0; r < m; ++r)
    for (std::size_t i = 0; i < n; ++i)
      if (in_B[r * n + i]) v[i] = lines.product_sum(B + static_cast<Number>(r * n + i), mu[r], v[i]);
  backward(v, in_L, mass_factors_);
  return {std::move(v), std::move(mu)};
}

// @param is_late, is_read  of slots: depends on late variables, is asked for by the caller
[[gnu::cold]] inline void Sweep::write_ends(const std::vector<End>& ends, const std::vector<char>& is_late, const std::vector<char>& is_read, Number next) {
  next = after_inputs(is_late, next);
  std::vector<char> is_constant(values_.size(), 0);  // whose coefficients are zero
  for (const int slot : constants_) is_constant[index(slot)] = 1;

  LineList early(next, 3 * ends.size());
  for (std::size_t i = 0; i < recurrence_.variables.size(); ++i) {
    const std::size_t slot = index(recurrence_.variables[i]);
    number_[0][slot] = number_[1][slot] = early.product(rate_number, first_rate_ + static_cast<Number>(i));
  }
  if (recurrence_.time >= 0) time_ = number_[1][index(recurrence_.time)];
  const std::vector<Number> interior = finished_interiors(early);
  for (const End& end : ends) {
    if (!end.early) continue;
    number_[0][index(end.slot)] = end_sum(early, end, terms_in(number_[0], end, is_constant), interior);
    if (!is_late[index(end.slot)]) number_[1][index(end.slot)] = number_[0][index(end.slot)];
  }
  if (!recurrence_.momenta.empty()) solve_for_late(early, interior);
  LineList late(next, 3 * ends.size());
  for (const End& end : ends)
    if (end.late) number_[1][index(end.slot)] = end_sum(late, end, terms_in(number_[1], end, is_constant), interior);
  for (std::size_t i = 0; i < rates_.size(); ++i) late.copy(number_[1][index(rates_[i])], first_rate_ + static_cast<Number>(i));

  x_.assign(next, 0.0);
  set_rows();
  set_tables({early.finished(), late.finished()}, is_read);
}

// Numbers what the early table reads and does not write, from `next` on; returns the number after them.
[[gnu::cold]] inline Sweep::Number Sweep::after_inputs(const std::vector<char>& is_late, Number next) {
  mass_factors_ = next;
  next += static_cast<Number>(recurrence_.mass.size());
  row_factors_ = next;
  next += static_cast<Number>(2 * recurrence_.jacobian.size() + triangle(recurrence_.rows.size()));
  first_rate_ = next;  // which the late table writes
  next += static_cast<Number>(rates_.size());
  interiors_ = next;
  next += static_cast<Number>(rounded_to_row(plain_.size() + weighted_.size()) + rounded_to_row(squares_.size()));
  for (auto& number : number_) number.assign(values_.size(), zero);
  for (const auto* list : {&variables_, &constants_})
    for (const int slot : *list) {
      number_[1][index(slot)] = next++;
      if (!is_late[index(slot)]) number_[0][index(slot)] = number_[1][index(slot)];
    }
  return next;
}

// Numbers of the interiors, of each lane.
[[gnu::cold]] inline std::vector<Sweep::Number> Sweep::finished_interiors(LineList& early) const {
  std::vector<Number> interior(rounded_to_row(plain_.size() + weighted_.size()) + rounded_to_row(squares_.size()));
  for (std::size_t lane = 0; lane < interior.size(); ++lane) interior[lane] = static_cast<Number>(interiors_ + lane);
  for (std::size_t i = 0; i < weighted_.size(); ++i) {
    Number& sum = interior[plain_.size() + i];
    sum = early.product(sum, inverse_order_number);
  }
  for (const Interior& s : quotients_) interior[index(s.lane)] = early.less_product(static_cast<Number>(s.factor), interior[index(s.lane)], zero);
  for (const Interior& s : powers_) {
    const Number both = early.combination(s.c + 1.0, interior[index(s.other)], -1.0, interior[index(s.lane)]);
    interior[index(s.lane)] = early.product(static_cast<Number>(s.factor + 1), both);
  }
  for (const Interior& s : second_arguments_) interior[index(s.lane)] = early.sum(interior[index(s.lane)], interior[index(s.other)]);
  return interior;
}

// The terms of an end that are not zero, where coefficients have these numbers.
[[gnu::cold]] inline std::vector<Sweep::EndTerm> Sweep::terms_in(const std::vector<Number>& number, const End& end,
                                                                 const std::vector<char>& is_constant) const {
  const auto is_zero = [&](int slot) { return number[index(slot)] == zero || is_constant[index(slot)] != 0; };
  std::vector<EndTerm> terms;
  for (int i = 0; i < end.terms; ++i)
    if (const int slot = terms_[index(end.first + i)]; !is_zero(slot)) terms.push_back({i, number[index(slot)]});
  return terms;
}

// Writes the lines of an end; returns the number of the coefficient that they make.
[[gnu::cold]] inline Sweep::Number Sweep::end_sum(LineList& lines, const End& end, const std::vector<EndTerm>& terms,
                                                  const std::vector<Number>& interior) const {
  if (end.lane >= 0) {
    Number sum = interior[index(end.lane)];
    for (const auto& [i, coefficient] : terms) sum = lines.product_sum(static_cast<Number>(end.factor + i), coefficient, sum);
    return sum;
  }
  if (terms.empty()) return zero;
  const auto factor = [&](std::size_t i) { return factors_[index(end.first + terms[i].first)]; };
  if (terms.size() == 1) return lines.scaled(factor(0), terms[0].second);
  Number sum = lines.combination(factor(0), terms[0].second, factor(1), terms[1].second);
  for (std::size_t i = 2; i < terms.size(); ++i) sum = lines.combination(1.0, sum, factor(i), terms[i].second);
  return sum;
}

// The lines of a recurrence that give the late variables' coefficients, and the multipliers.
[[gnu::cold]] inline void Sweep::solve_for_late(LineList& early, const std::vector<Number>& interior) {
  std::vector<Number> right, rows;
  for (std::size_t i = 0; i < recurrence_.momenta.size(); ++i)
    right.push_back(early.product(rate_number, first_rate_ + static_cast<Number>(recurrence_.rates.size() + i)));
  for (const Reaction& of : reactions_) right[of.column] = early.product_sum(rate_number, interior[index(of.lane)], right[of.column]);
  for (std::size_t i = 0; i < right.size(); ++i)
    if (const Number p = number_[0][index(recurrence_.momenta[i])]; p != zero) right[i] = early.difference(right[i], p);
  for (const int slot : recurrence_.rows) rows.push_back(early.scaled(-1.0, number_[0][index(slot)]));
  const Solution found = solution(early, std::move(right), std::move(rows));
  for (std::size_t i = 0; i < found.late.size(); ++i) number_[1][index(recurrence_.late[i])] = found.late[i];
  for (std::size_t r = 0; r < found.multipliers.size(); ++r)
    number_[1][first_multiplier_ + r] = early.quotient(found.multipliers[r], rate_number);
}

// Where the factors of the interiors stand.
[[gnu::cold]] inline void Sweep::set_rows() {
  std::vector<Number> left, right, squared;
  for (const auto* list : {&plain_, &weighted_})
    for (const Lane& lane : *list) {
      left.push_back(number_[1][index(lane.left)]);
      right.push_back(number_[1][index(lane.right)]);
    }
  for (const int slot : squares_) squared.push_back(number_[1][index(slot)]);
  rows_.first_weighted = plain_.size();
  rows_.left.set(std::move(left), highest_);
  rows_.right.set(std::move(right), highest_);
  rows_.squares.set(std::move(squared), highest_);
}

// Each table knows what of it is read: by the rows, by the caller and by the other table.
[[gnu::cold]] inline void Sweep::set_tables(std::array<formula::LineTable, 2> tables, const std::vector<char>& is_read) {
  std::vector<int> read;
  for (const auto* list : {&rows_.left.places, &rows_.right.places, &rows_.squares.places}) read.insert(read.end(), list->begin(), list->end());
  for (std::size_t slot = 0; slot < values_.size(); ++slot)
    if (slot >= first_multiplier_ || is_read[slot] != 0)
      for (const auto& number : number_) read.push_back(static_cast<int>(number[slot]));
  std::array<std::vector<int>, 2> by_other;
  for (std::size_t i = 0; i < 2; ++i)
    for (const Line& line : tables[i].lines) for_each_operand(line, [&](Number number) { by_other[1 - i].push_back(static_cast<int>(number)); });
  for (std::size_t i = 0; i < 2; ++i) {
    ends_[i].set(std::move(tables[i]), x_.size());
    ends_[i].add_read(by_other[i]);
    ends_[i].add_read(read);
  }
}

}  // namespace qdot::taylor
