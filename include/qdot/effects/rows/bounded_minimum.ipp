#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of bounded_minimum.hpp. A program that links qdot::compiled has them from there.

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "qdot/effects/rows/bounded_minimum.hpp"
#include "qdot/effects/rows/dependent_rows.hpp"
#include "qdot/mechanics/equations/cholesky.hpp"

namespace qdot::detail {

template <class>
Eigen::MatrixXd part_of(const Eigen::MatrixXd& A, const std::vector<Eigen::Index>& rows) {
  const auto k = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd part(k, k);
  for (Eigen::Index j = 0; j < k; ++j)
    for (Eigen::Index i = 0; i < k; ++i) part(i, j) = A(rows[static_cast<std::size_t>(i)], rows[static_cast<std::size_t>(j)]);
  return part;
}

// The rows whose forces are free, between their bounds.
template <class = void>  // compiled only where it is called
class FreeRows {
 public:
  explicit FreeRows(BoundedMinimum& p)
      : p_(p), size_(p.b.size()), is_free_(static_cast<std::size_t>(size_)), barred_(is_free_), blocked_(is_free_), patience_(50 * size_ + 200) {
    p.x = Eigen::VectorXd::Zero(size_);
    p.contradicting = -1;
    update();
  }

  // Frees rows one by one until none wants to be; false where it does not arrive.
  bool solve() {
    for (long pivot = 0; pivot < 2 * patience_; ++pivot) {
      const Eigen::Index enters = entering(pivot < patience_);
      if (enters < 0) return std::find(blocked_.begin(), blocked_.end(), true) == blocked_.end();
      free_.push_back(enters);
      is_free_[at(enters)] = true;
      bool moved = false;
      const Progress progress = move(enters, moved);
      if (progress != Progress::arrived) return progress == Progress::contradiction;
      if (moved) barred_.assign(barred_.size(), false), blocked_.assign(blocked_.size(), false);
    }
    return false;
  }

 private:
  enum class Progress { arrived, contradiction, failed };
  enum class Way { to_minimum, on_which_accelerations_stay, none, failed };
  static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

  void update() {
    p_.w = p_.b;
    for (Eigen::Index j = 0; j < size_; ++j) add(p_.w.data(), p_.x[j], p_.A.data() + j * size_, size_);
  }

  // The row that pulls most at its bound, or after too long a time the first one that pulls; −1 where none does.
  Eigen::Index entering(bool the_worst) const {
    Eigen::Index enters = -1;
    double worst = 0.0;
    for (Eigen::Index i = 0; i < size_; ++i) {
      if (is_free_[at(i)] || barred_[at(i)] || !(p_.w[i] < 0 ? p_.x[i] < p_.upper[i] : p_.x[i] > p_.lower[i])) continue;
      const double excess = std::abs(p_.w[i]) - p_.least(i);
      if (excess <= 0 || (the_worst ? excess <= worst : enters >= 0)) continue;
      worst = excess;
      enters = i;
    }
    return enters;
  }

  // Moves the free rows, of which `enters` is the last, to their minimum; those that meet a bound on the way leave.
  Progress move(Eigen::Index enters, bool& moved) {
    while (!free_.empty()) {
      Eigen::VectorXd way(static_cast<Eigen::Index>(free_.size()));
      const Way kind = way_of(enters, way);
      if (kind == Way::failed) return Progress::failed;
      if (kind == Way::none) {
        free_.pop_back();
        is_free_[at(enters)] = false;
        barred_[at(enters)] = true;
        break;
      }
      double step = kind == Way::to_minimum ? 1.0 : std::numeric_limits<double>::infinity();
      const Eigen::Index leaves = leaving(way, step);
      constexpr double endless = 1e9;  // forces of this size are those of a way that only rounding ends
      if (kind != Way::to_minimum && !(step < endless * (p_.b.cwiseAbs().maxCoeff() + p_.x.cwiseAbs().maxCoeff()))) {
        p_.contradicting = enters;
        return Progress::contradiction;
      }
      for (Eigen::Index i = 0; i < way.size(); ++i) p_.x[free_[at(i)]] += step * way[i];
      moved = moved || step > 0;
      if (leaves >= 0) {
        const Eigen::Index row = free_[at(leaves)];
        p_.x[row] = way[leaves] > 0 ? p_.upper[row] : p_.lower[row];
        is_free_[at(row)] = false;
        free_.erase(free_.begin() + leaves);
        if (row == enters && !moved) barred_[at(row)] = blocked_[at(row)] = true;
      }
      update();
      if (leaves < 0) break;
    }
    return Progress::arrived;
  }

  // The way of the free rows to their minimum. Where the last one, which entered, depends on the others: the way along which the accelerations stay.
  Way way_of(Eigen::Index enters, Eigen::VectorXd& way) {
    const Eigen::Index count = way.size();
    if (factor_.compute(part_of(p_.A, free_)) && factor_.smallest_pivot() > (p_.exact ? 1e-13 : dependent_pivot)) {
      for (Eigen::Index i = 0; i < count; ++i) way[i] = -p_.w[free_[at(i)]];
      way = factor_.solve(way);
      return Way::to_minimum;
    }
    const std::vector<Eigen::Index> others(free_.begin(), free_.end() - 1);
    if (count > 1 && !factor_.compute(part_of(p_.A, others))) return Way::failed;
    Eigen::VectorXd by(count - 1);
    for (Eigen::Index i = 0; i + 1 < count; ++i) by[i] = p_.A(free_[at(i)], enters);
    if (count > 1) by = factor_.solve(by);
    double slope = p_.w[enters], left = p_.A(enters, enters), terms = p_.size[enters];
    for (Eigen::Index i = 0; i + 1 < count; ++i) {
      slope -= by[i] * p_.w[free_[at(i)]];
      left -= by[i] * p_.A(free_[at(i)], enters);
      terms += std::abs(by[i]) * p_.size[free_[at(i)]];
    }
    // A row that is nearly a sum of the others may differ from it by the sine of their angle.
    if (std::abs(slope) <= (p_.exact ? 1e-12 : 10 * std::sqrt(std::max(left, 1e-15))) * terms) return Way::none;
    for (Eigen::Index i = 0; i + 1 < count; ++i) way[i] = slope > 0 ? by[i] : -by[i];
    way[count - 1] = slope > 0 ? -1.0 : 1.0;
    return Way::on_which_accelerations_stay;
  }

  // The free row that meets its bound first, within the step, which then ends there; −1 where none does.
  Eigen::Index leaving(const Eigen::VectorXd& way, double& step) const {
    Eigen::Index leaves = -1;
    for (Eigen::Index i = 0; i < way.size(); ++i) {
      if (way[i] == 0.0) continue;
      const Eigen::Index row = free_[at(i)];
      const double reach = std::max(0.0, ((way[i] > 0 ? p_.upper[row] : p_.lower[row]) - p_.x[row]) / way[i]);
      if (reach < step) step = reach, leaves = i;
    }
    return leaves;
  }

  BoundedMinimum& p_;
  Eigen::Index size_;
  std::vector<Eigen::Index> free_;
  std::vector<bool> is_free_, barred_, blocked_;
  long patience_;
  Cholesky<double, Eigen::Dynamic> factor_;
};

template <class>
bool solve(BoundedMinimum& p) {
  return FreeRows<>(p).solve();
}

template <class>
Eigen::MatrixXd null_space(const Eigen::MatrixXd& A) {
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
template <class = void>  // compiled only where it is called
NearestPoint nearest_point(const Eigen::MatrixXd& N, const Eigen::VectorXd& h) {
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

template <class>
bool shorten(Eigen::VectorXd& x, const Eigen::MatrixXd& N, const Eigen::VectorXd& lower, const Eigen::VectorXd& upper) {
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

template <class>
Margin margin(const Eigen::VectorXd& x, const Eigen::MatrixXd& N, const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
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
