#pragma once
// SPDX-License-Identifier: MIT
//
// Forces within bounds: λ ≥ 0 of contacts, |λ| ≤ F_s of friction.
//
//     minimize ½ λᵀA λ + bᵀλ ,    l ≤ λ ≤ u ,    A = J M⁻¹ Jᵀ
//
// With w = A λ + b, the accelerations of the rows, its solution has w = 0 where λ is between its bounds, w ≥ 0 at l and w ≤ 0 at u: a contact
// opens or is closed, friction slides or sticks. w is unique. Where rows depend on each other, λ is not:
//
//     bounded_minimum   some λ, by free rows that are added and removed one by one, always independent ones (Lawson and Hanson)
//     shortest          of all λ with that w and within the bounds the one of least norm
//     margins           how far inside the bounds λ can be, for each set of rows that share their forces
//
// All rows are scaled to A_ii = 1 first. It is asked at events, and where active rows depend on each other.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "qdot/effects/rows/dependent_rows.hpp"
#include "qdot/mechanics/equations/cholesky.hpp"

namespace qdot::detail {

// Squared sine of the angle below which a row depends on others: that of default_rank_cutoff.
inline constexpr double dependent_pivot = 1e-10;

// The problem, and its solution: λ, w, and a row that no finite λ satisfies, or −1.
struct BoundedMinimum {
  Eigen::MatrixXd A;                 // positive semidefinite, of diagonal 1
  Eigen::VectorXd b, lower, upper;   // 0 lies within the bounds
  Eigen::VectorXd size;              // of the terms in b
  double relative = 1e-9;            // part of size that counts as zero
  bool exact = false;                // whether rows are known to rounding, and not as those of constraints to default_rank_cutoff
  Eigen::VectorXd x, w;
  Eigen::Index contradicting = -1;

  double least(Eigen::Index i) const {  // |w_i| that counts as zero
    double terms = 0.0;
    for (Eigen::Index j = 0; j < x.size(); ++j) terms += std::abs(A(i, j) * x[j]);
    return relative * size[i] + 1e-13 * terms;
  }
  bool between(Eigen::Index i) const { return x[i] > lower[i] && x[i] < upper[i]; }
};

// The symmetric part of A that belongs to some rows.
template <class = void>
Eigen::MatrixXd part_of(const Eigen::MatrixXd& A, const std::vector<Eigen::Index>& rows) {
  const auto k = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd part(k, k);
  for (Eigen::Index j = 0; j < k; ++j)
    for (Eigen::Index i = 0; i < k; ++i) part(i, j) = A(rows[static_cast<std::size_t>(i)], rows[static_cast<std::size_t>(j)]);
  return part;
}

// Fills in x, w and contradicting; false where it does not arrive.
template <class = void>  // compiled only where it is called
[[gnu::cold]] bool solve(BoundedMinimum& p) {
  const Eigen::Index k = p.b.size();
  std::vector<Eigen::Index> free;
  std::vector<bool> is_free(static_cast<std::size_t>(k)), barred(is_free), blocked(is_free);
  const auto at = [](Eigen::Index i) { return static_cast<std::size_t>(i); };
  const auto update = [&] {
    p.w = p.b;
    for (Eigen::Index j = 0; j < k; ++j) add(p.w.data(), p.x[j], p.A.data() + j * k, k);
  };
  p.x = Eigen::VectorXd::Zero(k);
  p.contradicting = -1;
  update();
  Cholesky<double, Eigen::Dynamic> factor;
  const long patience = 50 * k + 200;
  for (long pivot = 0; pivot < 2 * patience; ++pivot) {
    Eigen::Index enters = -1;
    double worst = 0.0;
    for (Eigen::Index i = 0; i < k; ++i) {
      if (is_free[at(i)] || barred[at(i)] || !(p.w[i] < 0 ? p.x[i] < p.upper[i] : p.x[i] > p.lower[i])) continue;
      const double excess = std::abs(p.w[i]) - p.least(i);
      if (excess <= 0 || (pivot < patience ? excess <= worst : enters >= 0)) continue;  // the least index after too long a time
      worst = excess;
      enters = i;
    }
    if (enters < 0) return std::find(blocked.begin(), blocked.end(), true) == blocked.end();
    free.push_back(enters);
    is_free[at(enters)] = true;
    bool moved = false;
    for (;;) {
      const auto count = static_cast<Eigen::Index>(free.size());
      if (count == 0) break;
      Eigen::VectorXd way(count);
      bool bends = factor.compute(part_of(p.A, free)) && factor.smallest_pivot() > (p.exact ? 1e-13 : dependent_pivot);
      if (bends) {
        for (Eigen::Index i = 0; i < count; ++i) way[i] = -p.w[free[at(i)]];
        way = factor.solve(way);
      } else {  // then the last one, which entered, depends on the others: the way along which the accelerations stay
        const std::vector<Eigen::Index> others(free.begin(), free.end() - 1);
        if (count > 1 && !factor.compute(part_of(p.A, others))) return false;
        Eigen::VectorXd by(count - 1);
        for (Eigen::Index i = 0; i + 1 < count; ++i) by[i] = p.A(free[at(i)], enters);
        if (count > 1) by = factor.solve(by);
        double slope = p.w[enters], left = p.A(enters, enters), terms = p.size[enters];
        for (Eigen::Index i = 0; i + 1 < count; ++i) {
          slope -= by[i] * p.w[free[at(i)]];
          left -= by[i] * p.A(free[at(i)], enters);
          terms += std::abs(by[i]) * p.size[free[at(i)]];
        }
        // A row that is nearly a sum of the others may differ from it by the sine of their angle.
        if (std::abs(slope) <= (p.exact ? 1e-12 : 10 * std::sqrt(std::max(left, 1e-15))) * terms) {
          free.pop_back();
          is_free[at(enters)] = false;
          barred[at(enters)] = true;
          break;
        }
        for (Eigen::Index i = 0; i + 1 < count; ++i) way[i] = slope > 0 ? by[i] : -by[i];
        way[count - 1] = slope > 0 ? -1.0 : 1.0;
      }
      double step = bends ? 1.0 : std::numeric_limits<double>::infinity();
      Eigen::Index leaves = -1;
      for (Eigen::Index i = 0; i < count; ++i) {
        if (way[i] == 0.0) continue;
        const Eigen::Index row = free[at(i)];
        const double reach = std::max(0.0, ((way[i] > 0 ? p.upper[row] : p.lower[row]) - p.x[row]) / way[i]);
        if (reach < step) step = reach, leaves = i;
      }
      constexpr double endless = 1e9;  // forces of this size are those of a way that only rounding ends
      if (!bends && !(step < endless * (p.b.cwiseAbs().maxCoeff() + p.x.cwiseAbs().maxCoeff()))) return p.contradicting = enters, true;
      for (Eigen::Index i = 0; i < count; ++i) p.x[free[at(i)]] += step * way[i];
      moved = moved || step > 0;
      if (leaves >= 0) {
        const Eigen::Index row = free[at(leaves)];
        p.x[row] = way[leaves] > 0 ? p.upper[row] : p.lower[row];
        is_free[at(row)] = false;
        free.erase(free.begin() + leaves);
        if (row == enters && !moved) barred[at(row)] = blocked[at(row)] = true;
      }
      update();
      if (leaves < 0) break;
    }
    if (moved) barred.assign(barred.size(), false), blocked.assign(blocked.size(), false);
  }
  return false;
}

// Orthonormal columns that A turns into zero.
template <class = void>
[[gnu::cold]] Eigen::MatrixXd null_space(const Eigen::MatrixXd& A) {
  const Eigen::Index k = A.rows();
  const OrthogonalColumns range = orthogonal_columns(A, dependent_pivot, true);
  Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(k, k);
  for (Eigen::Index r = 0; r < range.rank; ++r)
    for (Eigen::Index j = 0; j < k; ++j) add(rest.data() + j * k, -range.Q(j, r), range.Q.data() + r * k, k);
  Eigen::MatrixXd N = range.rank < k ? Eigen::MatrixXd(orthogonal_columns(rest, 1e-3, true).Q.leftCols(k - range.rank)) : Eigen::MatrixXd(k, 0);
  return N;
}

// The point nearest to zero with rows N_r · y ≥ h_r, and a multiplier of each row; rows of N may have any length.
struct NearestPoint {
  Eigen::VectorXd y, multiplier;
  bool exists = true;
};
template <class = void>
[[gnu::cold]] NearestPoint nearest_point(const Eigen::MatrixXd& N, const Eigen::VectorXd& h) {
  const Eigen::Index rows = N.rows(), count = N.cols();
  BoundedMinimum dual;
  Eigen::VectorXd length(rows);
  for (Eigen::Index r = 0; r < rows; ++r) length[r] = std::max(N.row(r).norm(), 1e-300);
  dual.A.resize(rows, rows);
  dual.b.resize(rows);
  dual.lower = Eigen::VectorXd::Zero(rows);
  dual.upper = Eigen::VectorXd::Constant(rows, std::numeric_limits<double>::infinity());
  dual.relative = 1e-14;
  dual.exact = true;
  dual.size = Eigen::VectorXd::Constant(rows, h.cwiseAbs().maxCoeff());
  for (Eigen::Index r = 0; r < rows; ++r) {
    dual.b[r] = -h[r] / length[r];
    for (Eigen::Index s = 0; s < rows; ++s) dual.A(r, s) = N.row(r).dot(N.row(s)) / (length[r] * length[s]);
  }
  const bool exists = solve(dual) && dual.contradicting < 0;
  NearestPoint nearest{Eigen::VectorXd::Zero(count), dual.x, exists};
  for (Eigen::Index r = 0; r < rows; ++r) {
    nearest.multiplier[r] /= length[r];
    nearest.y += nearest.multiplier[r] * N.row(r).transpose();
  }
  return nearest;
}

// x ← the shortest x + N y within the bounds; false where there is none.
template <class = void>
[[gnu::cold]] bool shorten(Eigen::VectorXd& x, const Eigen::MatrixXd& N, const Eigen::VectorXd& lower, const Eigen::VectorXd& upper) {
  const Eigen::Index k = x.size();
  const Eigen::VectorXd whole = N.transpose() * x;
  for (Eigen::Index j = 0; j < N.cols(); ++j) add(x.data(), -whole[j], N.data() + j * k, k);
  std::vector<double> missing;
  std::vector<Eigen::Index> row;
  std::vector<double> sign;
  bool within = true;
  for (Eigen::Index i = 0; i < k; ++i)
    for (const double s : {1.0, -1.0}) {
      const double bound = s > 0 ? lower[i] : upper[i];
      if (!std::isfinite(bound) || N.row(i).norm() < 1e-9) continue;
      row.push_back(i);
      sign.push_back(s);
      missing.push_back(s * (bound - x[i]));
      within = within && missing.back() <= 0;
    }
  if (within || N.cols() == 0) return within;
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(row.size()), N.cols());
  Eigen::VectorXd h(rows.rows());
  for (Eigen::Index r = 0; r < rows.rows(); ++r) {
    rows.row(r) = sign[static_cast<std::size_t>(r)] * N.row(row[static_cast<std::size_t>(r)]);
    h[r] = missing[static_cast<std::size_t>(r)];
  }
  const NearestPoint nearest = nearest_point(rows, h);
  if (!nearest.exists) return false;
  for (Eigen::Index j = 0; j < N.cols(); ++j) add(x.data(), nearest.y[j], N.data() + j * k, k);
  for (Eigen::Index i = 0; i < k; ++i) x[i] = std::clamp(x[i], lower[i], upper[i]);
  return true;
}

// Of rows that share their forces: the largest μ with l + μ ς ≤ x + N y ≤ u − μ ς for some y, at most `most`, and which bounds stop it: −1 the
// lower, 1 the upper, 0 none. A linear programme, as a sequence of nearest points, which ends at its solution.
struct Margin {
  double mu = 0.0;
  std::vector<int> stops;
};
template <class = void>
[[gnu::cold]] Margin margin(const Eigen::VectorXd& x, const Eigen::MatrixXd& N, const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                            const Eigen::VectorXd& unit, double most) {
  const Eigen::Index k = x.size(), d = N.cols();
  Margin result{most, std::vector<int>(static_cast<std::size_t>(k), 0)};
  std::vector<Eigen::Index> row;
  std::vector<double> sign;
  double size = most;
  for (Eigen::Index i = 0; i < k; ++i)
    for (const double s : {1.0, -1.0}) {
      const double bound = s > 0 ? lower[i] : upper[i];
      if (!std::isfinite(bound)) continue;
      row.push_back(i);
      sign.push_back(s);
      size = std::max({size, std::abs(bound), std::abs(x[i])});
      if (unit[i] > 0) result.mu = std::min(result.mu, s * (x[i] - bound) / unit[i]);
    }
  if (row.empty()) return result;
  const auto rows = static_cast<Eigen::Index>(row.size());
  Eigen::MatrixXd normals(rows + 1, d + 1);  // of (y, μ); the last row is μ ≤ most
  Eigen::VectorXd at_zero(rows + 1), here = Eigen::VectorXd::Zero(d + 1), h(rows + 1);
  for (Eigen::Index r = 0; r < rows; ++r) {
    const Eigen::Index i = row[static_cast<std::size_t>(r)];
    const double s = sign[static_cast<std::size_t>(r)];
    for (Eigen::Index j = 0; j < d; ++j) normals(r, j) = s * N(i, j);
    normals(r, d) = -unit[i];
    at_zero[r] = s * (x[i] - (s > 0 ? lower[i] : upper[i]));
  }
  normals.row(rows).setZero();
  normals(rows, d) = -1.0;
  at_zero[rows] = most;
  here[d] = result.mu;
  Eigen::VectorXd multiplier;
  for (int step = 0; step < 100; ++step) {
    Eigen::VectorXd ahead = here;
    ahead[d] += 10 * size;
    h = -(at_zero + normals * ahead);
    const NearestPoint nearest = nearest_point(normals, h);
    const Eigen::VectorXd there = ahead + nearest.y;
    multiplier = nearest.multiplier;
    const double gain = there[d] - here[d];
    here = there;
    if (!(gain > 1e-12 * size)) break;
  }
  result.mu = here[d];
  for (std::size_t r = 0; r < row.size(); ++r)
    if (multiplier[static_cast<Eigen::Index>(r)] > 1e-6 * multiplier.maxCoeff()) result.stops[static_cast<std::size_t>(row[r])] = sign[r] > 0 ? -1 : 1;
  return result;
}

}  // namespace qdot::detail
