#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of rows_by_duals.hpp. A program that links qdot::compiled has them from there.

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>

#include "qdot/effects/equations/rows_by_duals.hpp"
#include "qdot/effects/rows/columns.hpp"

namespace qdot::detail {

inline std::size_t part(Eigen::Index i) { return static_cast<std::size_t>(i); }

// Numbers for each coordinate, and for each row.
template <class Number, int n>
using OfCoordinates = SmallStore<Number, n == Dynamic ? 0 : static_cast<std::size_t>(n)>;
template <class Number>
using OfRows = SmallStore<Number, 4>;

template <class Number, int n>
OfCoordinates<Number, n> as_numbers(const double* x, Eigen::Index count) {
  OfCoordinates<Number, n> numbers;
  numbers.resize(part(count));
  for (Eigen::Index i = 0; i < count; ++i) numbers[part(i)] = Number(x[i]);
  return numbers;
}

// A state as numbers, or with accelerations the motion through it.
template <class Number, int n>
struct NumbersOfMotion {
  OfCoordinates<Number, n> q, qdot;
  Number t;

  NumbersOfMotion(const Column& x, const Column& v, double time, const Column* a = nullptr)
      : q(as_numbers<Number, n>(x.data(), x.size())), qdot(as_numbers<Number, n>(v.data(), v.size())), t(time) {
    if (a == nullptr) return;
    t.value.value.tangent[0] = t.value.tangent[0].value = 1.0;
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      Number& position = q[part(i)];
      position.value.value.tangent[0] = position.value.tangent[0].value = v[i];
      position.value.tangent[0].tangent[0] = qdot[part(i)].value.value.tangent[0] = (*a)[i];
    }
  }
};

template <class Number>
OfRows<Number> for_rows(Eigen::Index rows) {
  OfRows<Number> found;
  found.resize(part(rows));
  return found;
}

template <int n>
void RowsByDuals<n>::write_jacobian(double t, const double* q, const double* qdot, const double* z, double* J) const {
  Column along(dof(), 0.0), values(rows()), slopes(rows());
  for (const bool of_positions : {true, false}) {
    if (!has_rows(of_positions)) continue;
    const Along direction = of_positions ? Along{.q = along.data()} : Along{.qdot = along.data()};
    for (Eigen::Index j = 0; j < dof(); ++j) {
      along[j] = 1.0;
      write_rows(t, q, qdot, z, direction, values.data(), slopes.data());
      along[j] = 0.0;
      for (Eigen::Index i = 0; i < rows(); ++i)
        if (is_of_positions(i) == of_positions) J[i + j * rows()] = slopes[i];
    }
  }
}

template <int n>
void RowsByDuals<n>::write_residual(double t, const double* q, const double* z, double* phi) const {
  Column slopes(rows());
  write_rows(t, q, q, z, {}, phi, slopes.data());
  for (Eigen::Index i = 0; i < rows(); ++i)
    if (!is_of_positions(i)) phi[i] = 0.0;
}

template <int n>
void RowsByDuals<n>::write_velocity(double t, const double* q, const double* qdot, const double* z, double* velocity) const {
  Column values(rows());
  write_rows(t, q, qdot, z, {.q = qdot, .t = 1.0}, values.data(), velocity);
  for (Eigen::Index i = 0; i < rows(); ++i)
    if (!is_of_positions(i)) velocity[i] = values[i];
}

template <int n>
Column RowsByDuals<n>::row_accelerations(double t, const Column& q, const Column& qdot, const Column& a,
                                         const Column& z) const {
  const NumbersOfMotion<Number, n> m(q, qdot, t, &a);
  OfRows<Number> found = for_rows<Number>(rows());
  write_rows(m.q.data(), m.qdot.data(), m.t, z.data(), found.data());
  Column rates(rows());
  for (Eigen::Index i = 0; i < rows(); ++i) {
    const Number& row = found[part(i)];
    rates[i] = is_of_positions(i) ? row.value.tangent[0].tangent[0] : row.value.value.tangent[0];
  }
  return rates;
}

template <int n>
void RowsByDuals<n>::write_slopes_of_accelerations(double t, const Column& q, const Column& qdot, const Column& a,
                                                   const Column& z, Table& dc) const {
  const Eigen::Index k = q.size();
  NumbersOfMotion<Number, n> m(q, qdot, t, &a);
  OfRows<Number> found = for_rows<Number>(rows());
  const auto seed = [&](Eigen::Index j, std::size_t d, double one) {
    Number& x = m.q[part(j < k ? j : j - k)];
    if (j < k) {
      x.tangent[d].value.value = one;
    } else {
      x.tangent[d].value.tangent[0] = x.tangent[d].tangent[0].value = one;
      m.qdot[part(j - k)].tangent[d].value.value = one;
    }
  };
  for (Eigen::Index first = 0; first < 2 * k; first += Number::directions) {
    const Eigen::Index end = std::min<Eigen::Index>(2 * k, first + Number::directions);
    for (Eigen::Index j = first; j < end; ++j) seed(j, part(j - first), 1.0);
    write_rows(m.q.data(), m.qdot.data(), m.t, z.data(), found.data());
    for (Eigen::Index j = first; j < end; ++j) {
      const std::size_t d = part(j - first);
      seed(j, d, 0.0);
      for (Eigen::Index i = 0; i < rows(); ++i)
        dc(i, j) = -(is_of_positions(i) ? found[part(i)].tangent[d].tangent[0].tangent[0] : found[part(i)].tangent[d].value.tangent[0]);
    }
  }
}

template <int n>
void RowsByDuals<n>::add_slopes_of_reactions(double t, const Column& q, const Column& qdot, const Column& lambda,
                                             const Column& z, Table& dr) const {
  const Eigen::Index k = q.size();
  OfRows<Number> found = for_rows<Number>(rows());
  for (const bool of_positions : {true, false}) {
    if (!has_rows(of_positions)) continue;
    NumbersOfMotion<Number, n> m(q, qdot, t);
    OfCoordinates<Number, n>& seeds = of_positions ? m.q : m.qdot;
    for (Eigen::Index j = 0; j < (of_positions ? k : 2 * k); ++j) {
      double& along = (j < k ? m.q[part(j)] : m.qdot[part(j - k)]).value.value.tangent[0];
      along = 1.0;
      for (Eigen::Index first = 0; first < k; first += Number::directions) {
        const Eigen::Index end = std::min<Eigen::Index>(k, first + Number::directions);
        for (Eigen::Index i = first; i < end; ++i) seeds[part(i)].tangent[part(i - first)].value.value = 1.0;
        write_rows(m.q.data(), m.qdot.data(), m.t, z.data(), found.data());
        for (Eigen::Index i = first; i < end; ++i) {
          seeds[part(i)].tangent[part(i - first)].value.value = 0.0;
          for (Eigen::Index row = 0; row < rows(); ++row)
            if (is_of_positions(row) == of_positions) dr(i, j) += lambda[row] * found[part(row)].tangent[part(i - first)].value.tangent[0];
        }
      }
      along = 0.0;
    }
  }
}

}  // namespace qdot::detail
