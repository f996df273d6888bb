#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of rows_by_duals.hpp. A program that links qdot::compiled has those of up to eight coordinates from there.

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <vector>

#include "qdot/effects/equations/rows_by_duals.hpp"

namespace qdot::detail {

inline std::size_t part(Eigen::Index i) { return static_cast<std::size_t>(i); }

// A state as numbers, or with accelerations the motion through it.
template <class Number>
struct NumbersOfMotion {
  std::vector<Number> q, qdot;
  Number t;

  NumbersOfMotion(const Eigen::VectorXd& x, const Eigen::VectorXd& v, double time, const Eigen::VectorXd* a = nullptr)
      : q(x.data(), x.data() + x.size()), qdot(v.data(), v.data() + v.size()), t(time) {
    if (a == nullptr) return;
    t.value.value.tangent[0] = t.value.tangent[0].value = 1.0;
    for (std::size_t i = 0; i < q.size(); ++i) {
      q[i].value.value.tangent[0] = q[i].value.tangent[0].value = v.data()[i];
      q[i].value.tangent[0].tangent[0] = qdot[i].value.value.tangent[0] = a->data()[i];
    }
  }
};

template <int n>
Eigen::MatrixXd RowsByDuals<n>::jacobian(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& z) const {
  MatrixXd J = zeros<MatrixXd>(rows(), q.size());
  std::vector<Number> found(part(rows()));
  for (const bool of_positions : {true, false}) {
    if (!has_rows(of_positions)) continue;
    NumbersOfMotion<Number> m(q, qdot, t);
    for (Eigen::Index first = 0; first < q.size(); first += Number::directions) {
      const Eigen::Index end = std::min<Eigen::Index>(q.size(), first + Number::directions);
      std::vector<Number>& seeds = of_positions ? m.q : m.qdot;
      for (Eigen::Index j = first; j < end; ++j) seeds[part(j)].tangent[part(j - first)].value.value = 1.0;
      write_rows(m.q.data(), m.qdot.data(), m.t, z, found.data());
      for (Eigen::Index j = first; j < end; ++j) {
        seeds[part(j)].tangent[part(j - first)].value.value = 0.0;
        for (Eigen::Index i = 0; i < rows(); ++i)
          if (is_of_positions(i) == of_positions) J(i, j) = found[part(i)].tangent[part(j - first)].value.value;
      }
    }
  }
  return J;
}

template <int n>
Eigen::VectorXd RowsByDuals<n>::residual(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& z) const {
  const std::vector<Slope> x(q.data(), q.data() + q.size());
  std::vector<Slope> found(part(rows()));
  write_rows(x.data(), x.data(), Slope(t), z, found.data());
  Eigen::VectorXd phi(rows());
  for (Eigen::Index i = 0; i < rows(); ++i) phi[i] = is_of_positions(i) ? found[part(i)].value : 0.0;
  return phi;
}

template <int n>
Eigen::VectorXd RowsByDuals<n>::velocity(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& z) const {
  std::vector<Slope> x(q.data(), q.data() + q.size()), found(part(rows()));
  const std::vector<Slope> v(qdot.data(), qdot.data() + qdot.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[i].tangent[0] = qdot.data()[i];
  write_rows(x.data(), v.data(), Slope::variable(t, 0), z, found.data());
  Eigen::VectorXd rates(rows());
  for (Eigen::Index i = 0; i < rows(); ++i) {
    const Slope& row = found[part(i)];
    rates[i] = is_of_positions(i) ? row.tangent[0] : row.value;
  }
  return rates;
}

template <int n>
Eigen::VectorXd RowsByDuals<n>::row_accelerations(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& a,
                                                  const Eigen::VectorXd& z) const {
  const NumbersOfMotion<Number> m(q, qdot, t, &a);
  std::vector<Number> found(part(rows()));
  write_rows(m.q.data(), m.qdot.data(), m.t, z, found.data());
  Eigen::VectorXd rates(rows());
  for (Eigen::Index i = 0; i < rows(); ++i) {
    const Number& row = found[part(i)];
    rates[i] = is_of_positions(i) ? row.value.tangent[0].tangent[0] : row.value.value.tangent[0];
  }
  return rates;
}

template <int n>
void RowsByDuals<n>::write_slopes_of_accelerations(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& a,
                                                   const Eigen::VectorXd& z, Eigen::MatrixXd& dc) const {
  const Eigen::Index k = q.size();
  NumbersOfMotion<Number> m(q, qdot, t, &a);
  std::vector<Number> found(part(rows()));
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
    write_rows(m.q.data(), m.qdot.data(), m.t, z, found.data());
    for (Eigen::Index j = first; j < end; ++j) {
      const std::size_t d = part(j - first);
      seed(j, d, 0.0);
      for (Eigen::Index i = 0; i < rows(); ++i)
        dc(i, j) = -(is_of_positions(i) ? found[part(i)].tangent[d].tangent[0].tangent[0] : found[part(i)].tangent[d].value.tangent[0]);
    }
  }
}

template <int n>
void RowsByDuals<n>::add_slopes_of_reactions(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& lambda,
                                             const Eigen::VectorXd& z, Eigen::MatrixXd& dr) const {
  const Eigen::Index k = q.size();
  std::vector<Number> found(part(rows()));
  for (const bool of_positions : {true, false}) {
    if (!has_rows(of_positions)) continue;
    NumbersOfMotion<Number> m(q, qdot, t);
    std::vector<Number>& seeds = of_positions ? m.q : m.qdot;
    for (Eigen::Index j = 0; j < (of_positions ? k : 2 * k); ++j) {
      double& along = (j < k ? m.q[part(j)] : m.qdot[part(j - k)]).value.value.tangent[0];
      along = 1.0;
      for (Eigen::Index first = 0; first < k; first += Number::directions) {
        const Eigen::Index end = std::min<Eigen::Index>(k, first + Number::directions);
        for (Eigen::Index i = first; i < end; ++i) seeds[part(i)].tangent[part(i - first)].value.value = 1.0;
        write_rows(m.q.data(), m.qdot.data(), m.t, z, found.data());
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
