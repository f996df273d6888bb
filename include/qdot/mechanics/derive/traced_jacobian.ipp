#pragma once
// SPDX-License-Identifier: MIT
//
// The lines of a Jacobian, and what is solved between them: the work of TracedJacobian (mechanics/derive/traced_jacobian.hpp).
//
// With constraints, or many coordinates, there are two tables: M, r, J and γ come first, and with their solution, q̈ and λ, the right sides of the columns.
//
// Programs that link qdot::compiled do not read this file: the library has it.

#include <algorithm>
#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/mechanics/derive/traced_jacobian.hpp"

namespace qdot::detail {

template <int n_at_compile_time>
[[gnu::cold]] TracedJacobian<n_at_compile_time>::TracedJacobian(TracedEquations<double> equations, const LimitsOfPivots& limits)
    : lines_(std::move(equations)), limits_(limits), factors_(lines_.equations().n(), lines_.equations().rows()),
      a_(numbers_of<decltype(a_)>(lines_.equations().n())), upper_(numbers_of<decltype(upper_)>(a_.size())),
      lambda_(lines_.equations().rows()), lower_(lambda_.size()), own_ydot_(columns()) {
  TracedEquations<double>& e = lines_.equations();
  if (factors_.m == 0) limits_ = {.singular = singular_pivot<double>(static_cast<Eigen::Index>(factors_.n)), .dependent = 0.0};
  const TracedEquations<double>::Slopes slopes = e.slopes();
  states_ = slopes.states;
  if (factors_.m == 0 && factors_.n <= most_solved) {
    write_in_lines(slopes);
    if (is_known_) return;
    lines_ = TracedLines<>(TracedEquations<double>(e));  // with nothing written yet
  }
  write_in_columns(slopes);
}

// Writes two tables, that of M, r, J and γ, and that of the right sides, four columns at a time.
template <int n_at_compile_time>
[[gnu::cold]] void TracedJacobian<n_at_compile_time>::write_in_columns(const TracedEquations<double>::Slopes& slopes) {
  TracedEquations<double>& e = lines_.equations();
  const int zero = e.graph().constant(0.0), size = static_cast<int>(factors_.n);
  std::vector<int> mass = in_rows(e.mass, 0, size, zero), J = in_rows(e.J, 0, size, zero), blocks;
  for (int first = 0; first < static_cast<int>(columns()); first += 4) {
    std::vector<int> block = in_rows(slopes.motion, first, 4, zero);
    append(block, in_rows(slopes.constraints, first, 4, zero));
    if (std::count(block.begin(), block.end(), zero) == std::ssize(block)) {
      append(empty_columns_, {first, first + 1, first + 2, first + 3});
    } else {
      first_columns_.push_back(first);
      append(blocks, block);
    }
  }
  std::vector<int> outputs = e.right, rates = e.zdot;
  rates.resize(e.states(), zero);  // phases alone have none
  for (const std::vector<int>& more : {rates, mass, J, e.gamma, lines_.required()}) append(outputs, more);
  equations_ = lines_.written(outputs);
  outputs = blocks;
  append(outputs, slopes.states.nodes());
  further_ = lines_.written(outputs);
  right_ = lines_.numbers(e.right);
  zdot_ = lines_.numbers(rates);
  gamma_ = lines_.numbers(e.gamma);
  mass_ = lines_.numbers(mass);
  J_ = lines_.numbers(J);
  blocks_ = lines_.numbers(blocks);
  for (SparseEntries::Entry& entry : states_.entries) entry.what = lines_.numbers({entry.what})[0];
  is_known_ = further_->table().lines.size() <= most_lines;
}

// inputs of lines ← y and t.
template <class Size>
[[gnu::always_inline]] inline void write_inputs(Size n, std::size_t states, double t, const double* y, double* inputs) {
  each(n, [&](auto i) __attribute__((always_inline)) {
    inputs[i] = y[i];
    inputs[n + i] = y[n + i];
  });
  inputs[2 * n] = t;
  for (std::size_t k = 0; k < states; ++k) inputs[2 * n + 1 + k] = y[2 * n + k];
}

// ydot ← q̇, q̈ and ż, of which q̈ becomes an input of further lines too; a sum that is zero if all are finite.
template <class Size, class Accelerations>
[[gnu::always_inline]] inline double write_rates(Size n, const double* y, const Accelerations& a, const TracedLines<>& lines, const std::vector<int>& zdot,
                                                 double* ydot, double* accelerations) {
  double zero = 0.0;
  each(n, [&](auto i) __attribute__((always_inline)) {
    ydot[i] = y[n + i];
    ydot[n + i] = accelerations[i] = a[i];
    zero += a[i] - a[i];
  });
  for (std::size_t k = 0; k < zdot.size(); ++k) {
    ydot[2 * n + k] = lines[zdot[k]];
    zero += ydot[2 * n + k] - ydot[2 * n + k];
  }
  return zero;
}

// Column j of the Jacobian: slopes of q̇ are 0 or 1, those of q̈ are given, and the rows of states are zero for now.
template <class Size, class Acceleration>
[[gnu::always_inline]] inline void write_column(Size n, std::size_t states, int j, Eigen::Ref<Eigen::MatrixXd>& out, const Acceleration& acceleration) {
  double* const column = out.data() + j * out.outerStride();
  each(n, [&](auto i) __attribute__((always_inline)) {
    column[i] = static_cast<std::size_t>(j) == n + i ? 1.0 : 0.0;
    column[n + i] = acceleration(i);
  });
  for (std::size_t k = 0; k < states; ++k) column[2 * n + k] = 0.0;
}

// Writes the slopes of states that are not zero; a sum that is zero if all of them are finite.
inline double write_slopes_of_states(const TracedLines<>& lines, const SparseEntries& states, std::size_t first_row, Eigen::Ref<Eigen::MatrixXd>& out) {
  double zero = 0.0;
  for (std::size_t k = 0; k < states.rows(); ++k)
    for (const auto& entry : states.row(k)) {
      const double slope = lines[entry.what];
      out(static_cast<Eigen::Index>(first_row + k), entry.column) = slope;
      zero += slope - slope;
    }
  return zero;
}

template <int n_at_compile_time>
bool TracedJacobian<n_at_compile_time>::write_by_columns(double t, const double* y, double* ydot, Eigen::Ref<Eigen::MatrixXd> out) {
  const auto n = factors_.n;
  const std::size_t m = factors_.m;
  const std::size_t states = zdot_.size();
  double* const inputs = lines_.inputs();
  write_inputs(n, states, t, y, inputs);
  lines_.carry_out(*equations_);
  if (!lines_.hold_requirements()) return false;
  each(n, [&](auto i) __attribute__((always_inline)) {
    each(n, [&](auto j) __attribute__((always_inline)) { factors_.M[i * n + j] = at(mass_, i * n + j); });
    a_[i] = at(right_, i);
  });
  for (std::size_t k = 0; k < m * n; ++k) factors_.J[k] = at(J_, k);
  for (std::size_t k = 0; k < m; ++k) lambda_[k] = at(gamma_, k);
  const double rho = limits_.may_be_singular ? lent_inertia() : 0.0;
  lend(rho, a_, lambda_);
  if (!factors_.compute(limits_.singular, limits_.dependent)) return false;
  factors_.solve(a_.data(), lambda_.data());
  const double zero = write_rates(n, y, a_, lines_, zdot_, ydot ? ydot : own_ydot_.data(), inputs + 2 * n + 1 + states);
  std::copy_n(lambda_.data(), m, lines_.multipliers());
  lines_.carry_out(*further_);
  const auto write = [&](int j, const auto& acceleration) __attribute__((always_inline)) {
    if (j < static_cast<int>(own_ydot_.size())) write_column(n, states, j, out, acceleration);
  };
  for (const int j : empty_columns_) write(j, [](auto) { return 0.0; });
  const int* places = blocks_.data();
  FourColumns::Two not_finite{};
  std::conditional_t<n_at_compile_time == Dynamic, decltype(upper_)&, decltype(upper_)> upper = upper_;
  for (const int first : first_columns_) {
    each(n, [&](auto i) __attribute__((always_inline)) { read(upper[i], places + 4 * i); });
    places += 4 * n;
    for (Four& row : lower_) {
      read(row, places);
      places += 4;
    }
    lend(rho, upper, lower_);
    factors_.solve(upper.data(), lower_.data());
    write(first, [&](auto i) { return upper[i].first[0]; });
    write(first + 1, [&](auto i) { return upper[i].first[1]; });
    write(first + 2, [&](auto i) { return upper[i].second[0]; });
    write(first + 3, [&](auto i) { return upper[i].second[1]; });
    each(n, [&](auto i) __attribute__((always_inline)) { not_finite += (upper[i].first - upper[i].first) + (upper[i].second - upper[i].second); });
  }
  return zero + write_slopes_of_states(lines_, states_, 2 * n, out) + not_finite[0] + not_finite[1] == 0.0;
}

// Writes one table for all.
template <int n_at_compile_time>
void TracedJacobian<n_at_compile_time>::write_in_lines(const TracedEquations<double>::Slopes& slopes) {
  TracedEquations<double>& e = lines_.equations();
  const int zero = e.graph().constant(0.0), none = -1;
  const std::vector<int> mass = lower_triangle(e.mass);
  std::vector<int> columns, rates = e.zdot;
  rates.resize(e.states(), zero);
  const std::vector<int> rows = in_rows(slopes.motion, 0, static_cast<int>(this->columns()), none);
  for (std::size_t j = 0; j < this->columns(); ++j)
    for (std::size_t i = 0; i < factors_.n; ++i) columns.push_back(rows[i * this->columns() + j]);
  std::vector<int> others = rates;
  append(others, {zero});
  append(others, states_.nodes());
  append(others, lines_.required());
  solved_ = lines_.solved(mass, e.right, columns, others, limits_.singular, most_numbers);
  if (!is_solved()) return;
  zdot_ = lines_.numbers(rates);
  for (int& number : solved_.columns)
    if (number == none) number = lines_.numbers({zero})[0];
  for (SparseEntries::Entry& entry : states_.entries) entry.what = lines_.numbers({entry.what})[0];
  is_known_ = true;
}

// to[i] ← f(i). Numbers whose count is known are written in pairs: a load of a pair waits for two separate stores.
template <std::size_t count, class F>
[[gnu::always_inline]] inline void write_each(std::integral_constant<std::size_t, count>, double* to, const F& f) {
  double numbers[count];
  unroll<static_cast<int>(count)>([&](auto i) __attribute__((always_inline)) { numbers[i] = f(i); });
  write_in_pairs<static_cast<int>(count)>(to, numbers);
}
template <class F>
[[gnu::always_inline]] inline void write_each(std::size_t count, double* to, const F& f) {
  for (std::size_t i = 0; i < count; ++i) to[i] = f(i);
}

template <int n_at_compile_time>
bool TracedJacobian<n_at_compile_time>::write_by_lines(double t, const double* y, double* ydot, double* out, Eigen::Index stride) const {
  const auto n = factors_.n;
  const std::size_t states = zdot_.size(), count = own_ydot_.size();
  double x[most_numbers];
  write_inputs(n, states, t, y, x);
  std::copy_n(parameters_.data(), parameters_.size(), x + 3 * n + 1 + states);
  if (!solved_.evaluate(x, limits_)) return false;
  double sum = 0.0, other = 0.0;  // which is finite if all numbers are
  each(n, [&](auto i) __attribute__((always_inline)) { sum += x[solved_.x[i]]; });
  for (std::size_t k = 0; k < states; ++k) other += x[zdot_[k]];
  if (ydot != nullptr) {
    each(n, [&](auto i) __attribute__((always_inline)) {
      ydot[i] = y[n + i];
      ydot[n + i] = x[solved_.x[i]];
    });
    for (std::size_t k = 0; k < states; ++k) ydot[2 * n + k] = x[zdot_[k]];
  }
  const int* number = solved_.columns.data();
  double* column = out;
  for (std::size_t j = 0; j < count; ++j, column += stride) {
    const auto slope = [&](auto i) __attribute__((always_inline)) { return x[number[i]]; };
    each(n, [&](auto i) __attribute__((always_inline)) {
      column[i] = 0.0;
      (i % 2 == 0 ? sum : other) += slope(i);
    });
    write_each(n, column + n, slope);
    number += n;
    for (std::size_t k = 0; k < states; ++k) column[2 * n + k] = 0.0;
  }
  each(n, [&](auto i) __attribute__((always_inline)) { out[static_cast<Eigen::Index>(n + i) * stride + static_cast<Eigen::Index>(i)] = 1.0; });
  for (std::size_t k = 0; k < states_.rows(); ++k)
    for (const auto& entry : states_.row(k)) sum += out[entry.column * stride + static_cast<Eigen::Index>(2 * n + k)] = x[entry.what];
  return is_finite(sum + other);
}

// Some columns of entries, row by row, with what is not there.
template <int n_at_compile_time>
[[gnu::cold]] std::vector<int> TracedJacobian<n_at_compile_time>::in_rows(const SparseEntries& entries, int first, int count, int zero) {
  std::vector<int> all;
  for (std::size_t i = 0; i < entries.rows(); ++i) {
    std::vector<int> row(static_cast<std::size_t>(count), zero);
    for (const auto& [column, node] : entries.row(i))
      if (column >= first && column < first + count) row[static_cast<std::size_t>(column - first)] = node;
    append(all, row);
  }
  return all;
}

// M ← M + ϱ JᵀJ with a ϱ that makes both parts alike; ϱ.
template <int n_at_compile_time>
double TracedJacobian<n_at_compile_time>::lent_inertia() {
  const std::size_t n = factors_.n;
  own_J_ = factors_.J;
  double inertia = 0.0, size = 0.0;
  for (std::size_t i = 0; i < n; ++i) inertia += factors_.M[i * n + i];
  for (const double w : own_J_) size += w * w;
  const double rho = inertia / size;
  for (const double* row = own_J_.data(); row != own_J_.data() + own_J_.size(); row += static_cast<std::ptrdiff_t>(n))
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j <= i; ++j) factors_.M[i * n + j] += rho * row[i] * row[j];
  return rho;
}

}  // namespace qdot::detail
