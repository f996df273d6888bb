#pragma once
// SPDX-License-Identifier: MIT
//
// Steady states as a curve in (q, z, p)
// =====================================
//
// The equations of a steady state, R(q, z; p) = 0 (linear/rest_search.hpp), leave one direction open when p may change as well:
// the tangent τ of the curve, ∂R τ = 0. A point of the curve near a guess X₀ is found by Newton's method from
//
//     R(X) = 0 ,     τ·(X − X₀) = 0 ,
//
// which goes round folds, where p turns back. Rows are scaled to the length that they have at the start, unknowns by their sizes, and p by the
// range that is followed. Scenes with p outside of that range are not asked for. Constraints give more rows than unknowns, which agree all the
// same; a step is the one of least squares. Coordinates of which nothing depends keep their values.
//
// Along the curve det [∂R; τ] changes its sign where another curve crosses it. With more rows than unknowns ∂R is taken in an
// orthonormal basis of its columns, which is carried along so that it does not flip.

#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/QR>

#include "qdot/analysis/linear/flow.hpp"
#include "qdot/analysis/linear/rest_search.hpp"
#include "qdot/analysis/linear/shortest_step.hpp"
#include "qdot/analysis/variations/slope.hpp"
#include "qdot/error.hpp"

namespace qdot::detail {

using FlowAt = std::function<std::shared_ptr<const Flow>(double p)>;

// The flow of a scene that it owns.
template <class Sc>
std::shared_ptr<const Flow> owned_flow(const Sc& scene) {
  static_assert(!Sc::has_phases,
                "qdot: branches of equilibria need constraints that last: put a holonomic constraint in place of a contact that is closed, and "
                "leave it out where it is open; where friction sticks, equilibria fill a region and have no branches");
  struct SceneAndFlow {
    explicit SceneAndFlow(const Sc& given) : scene(given), flow(scene) {}
    Sc scene;
    FlowOf<Sc> flow;
  };
  const auto both = std::make_shared<const SceneAndFlow>(scene);
  return {both, static_cast<const Flow*>(&both->flow)};
}

// A point of the curve in units of `scale`, X = [q; z; p].
struct CurvePoint {
  Eigen::VectorXd X, tangent;
  Eigen::MatrixXd slopes;    // ∂R, columns of what is sought
  Eigen::MatrixXd image;     // an orthonormal basis of its columns
  double orientation = 1.0;  // of that basis
  double crossing = 0.0;     // det [∂R; τ]
};

template <class = void>  // compiled only where it is made
class SteadyCurve {
 public:
  // @param lowest, highest  of p; no scene is asked for outside
  SteadyCurve(FlowAt flow_at, double t, Eigen::VectorXd qdot, const Eigen::VectorXd& X, double lowest, double highest)
      : flow_at_(std::move(flow_at)), t_(t), lowest_(lowest), highest_(highest), qdot_(std::move(qdot)) {
    scale_ = X.cwiseAbs().cwiseMax(1.0);
    scale_[X.size() - 1] = highest - lowest;
    for (Eigen::Index j = 0; j + 1 < X.size(); ++j) scale_[j] = natural_size(X, j);
    const Eigen::VectorXd start = X.cwiseQuotient(scale_);
    // Cyclic is what nothing depends on here, and beside this. Rows keep their scale, so that one that vanishes is seen to.
    Eigen::VectorXd most = Eigen::VectorXd::Zero(X.size()), longest;
    for (const double beside : {0.0, 0.01, -0.017}) {
      Eigen::VectorXd at = start;
      for (Eigen::Index i = 0; i < at.size(); ++i) at[i] += beside * (1.0 + 0.3 * static_cast<double>(i % 3));
      const Eigen::MatrixXd A = equations(at).second;
      if (longest.size() == 0) longest = Eigen::VectorXd::Zero(A.rows());
      for (Eigen::Index i = 0; i < at.size(); ++i) most[i] = std::max(most[i], A.col(i).cwiseAbs().maxCoeff());
      for (Eigen::Index i = 0; i < A.rows(); ++i) longest[i] = std::max(longest[i], A.row(i).norm());
    }
    most /= std::max(longest.maxCoeff(), std::numeric_limits<double>::min());
    row_scale_.resize(longest.size());
    for (Eigen::Index i = 0; i < longest.size(); ++i)
      row_scale_[i] = 1.0 / std::max({longest[i], 1e-10 * longest.maxCoeff(), std::numeric_limits<double>::min()});
    for (Eigen::Index i = 0; i < X.size(); ++i)
      if (i + 1 == X.size() || most[i] > 1e-10) free_.push_back(i);
  }

  Eigen::Index parameter() const { return static_cast<Eigen::Index>(free_.size()) - 1; }  // its place in a tangent
  double p(const Eigen::VectorXd& X) const { return std::min(std::max(X[X.size() - 1] * scale_[X.size() - 1], lowest_), highest_); }
  double scaled_parameter(double value) const { return value / scale_[scale_.size() - 1]; }
  Eigen::VectorXd values(const Eigen::VectorXd& X) const { return X.cwiseProduct(scale_); }
  Eigen::VectorXd scaled(const Eigen::VectorXd& values) const { return values.cwiseQuotient(scale_); }
  Eigen::VectorXd y(const Eigen::VectorXd& X) const {
    const Eigen::VectorXd x = values(X);
    const Eigen::Index n = qdot_.size();
    Eigen::VectorXd all(x.size() - 1 + n);
    all << x.head(n), qdot_, x.segment(n, x.size() - 1 - n);
    return all;
  }
  std::shared_ptr<const Flow> flow(const Eigen::VectorXd& X) const { return flow_at_(p(X)); }

  // Refuses what depends on the time, or on a coordinate that turns, at this p.
  void require_steady_at(const char* who, const Eigen::VectorXd& X) const {
    const Eigen::VectorXd state = y(X);
    const auto here = flow(X);
    require_steady(*here, {who, 0, 0.0}, t_, state, SteadyEquations::at(*here, t_, state, true), row_scale_);
  }

  Eigen::VectorXd moved(const Eigen::VectorXd& X, const Eigen::VectorXd& direction, double s) const {
    Eigen::VectorXd next = X;
    next(free_) += s * direction;
    return next;
  }

  Eigen::VectorXd difference(const Eigen::VectorXd& X, const Eigen::VectorXd& from) const { return (X - from)(free_); }

  // The point on the plane through X0 normal to a direction; nothing where Newton's method does not get there.
  std::optional<Eigen::VectorXd> on_plane(const Eigen::VectorXd& X0, const Eigen::VectorXd& normal) const {
    constexpr int most_steps = 12;
    constexpr double short_step = 1e-11, small_residual = 1e-8;
    Eigen::VectorXd X = X0;
    double before = std::numeric_limits<double>::infinity();
    for (int step = 0; step < most_steps; ++step) {
      const auto [residual, A] = equations(X);
      Eigen::VectorXd right(residual.size() + 1);
      right << -residual, -normal.dot((X - X0)(free_));
      const Eigen::VectorXd change = shortest_step(bordered(A(Eigen::indexing::all, free_), normal), right, 1e-12).x;
      const double length = change.norm();
      if (!std::isfinite(length)) return std::nullopt;
      X = moved(X, change, 1.0);
      if (length <= short_step * (1.0 + X.norm())) {
        if (right.cwiseAbs().maxCoeff() > small_residual) return std::nullopt;
        return X;
      }
      if (step > 1 && length > 0.5 * before) {  // no longer quadratic: rounding, or nothing near
        if (length > 1e-8 * (1.0 + X.norm())) return std::nullopt;
        return X;
      }
      before = length;
    }
    return std::nullopt;
  }

  // What belongs to a point, in the direction of `along`; `before` is its neighbour.
  CurvePoint point(const Eigen::VectorXd& X, const Eigen::VectorXd& along, const CurvePoint* before) const {
    const auto [residual, A] = equations(X);
    const Eigen::Index columns = static_cast<Eigen::Index>(free_.size());
    CurvePoint here;
    here.X = X;
    here.slopes = A(Eigen::indexing::all, free_);
    here.tangent = shortest_step(bordered(here.slopes, along), Eigen::VectorXd::Unit(residual.size() + 1, residual.size()), 1e-9).x.normalized();
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factors(here.slopes);
    here.image = Eigen::MatrixXd(factors.householderQ()).leftCols(columns - 1);
    if (before != nullptr)
      here.orientation = before->orientation * (determinant(Eigen::MatrixXd(before->image.transpose() * here.image)) < 0.0 ? -1.0 : 1.0);
    here.crossing = here.orientation * determinant(bordered(here.image.transpose() * here.slopes, here.tangent));
    return here;
  }

  // Orthonormal columns v with ∂R v = 0 and τ·v = 0: tangents of other curves that cross this one here, as exactly as the place is known.
  static Eigen::MatrixXd crossing_directions(const CurvePoint& here) {
    Eigen::MatrixXd open(here.tangent.size(), 0);
    for (const double negligible : {1e-6, 1e-4, 1e-2})
      if (open.cols() == 0) open = shortest_step(bordered(here.slopes, here.tangent), Eigen::VectorXd::Zero(here.slopes.rows() + 1), negligible).open;
    return open;
  }

 private:
  static Eigen::MatrixXd bordered(const Eigen::MatrixXd& slopes, const Eigen::VectorXd& row) {
    Eigen::MatrixXd A(slopes.rows() + 1, slopes.cols());
    A << slopes, row.transpose();
    return A;
  }
  static double determinant(const Eigen::MatrixXd& square) { return Eigen::FullPivLU<Eigen::MatrixXd>(square).determinant(); }

  // The size of an unknown in which slopes change: 1, or its own where that is larger, times a power of 10. It is divided by 10 as long as
  // a hundredth of it changes a row by a quarter. It is multiplied by 10 as long as all of it changes rows by less than a tenth. A
  // molecule has lengths of 1e-10.
  double natural_size(const Eigen::VectorXd& X, Eigen::Index j) const {
    constexpr double smallest = 1e-15, largest = 1e15, at_most = 0.25, at_least = 0.1;
    Eigen::VectorXd length;
    std::vector<Eigen::MatrixXd> at;  // at the start, as p has it there and beside
    for (const double beside : {0.0, 0.01, -0.017}) {
      Eigen::VectorXd start = X.cwiseQuotient(scale_);
      start[start.size() - 1] += beside;
      at.push_back(equations(start).second);
      if (length.size() == 0) length = Eigen::VectorXd::Zero(at[0].rows());
      for (Eigen::Index i = 0; i < length.size(); ++i) length[i] = std::max(length[i], at.back().row(i).norm());
    }
    // The change of a row when the unknown moves by a distance, in parts of its length.
    const auto change = [&](double distance) {
      double most = 0.0;
      for (const double side : {1.0, -1.0}) {
        Eigen::VectorXd start = X;
        start[j] += side * distance;
        try {
          const Eigen::MatrixXd all = equations(start.cwiseQuotient(scale_)).second - at[0], moved = all.leftCols(X.size() - 1);
          for (Eigen::Index i = 0; i < length.size(); ++i)
            if (length[i] > 0.0) most = std::max(most, moved.row(i).allFinite() ? moved.row(i).norm() / length[i] : largest);
        } catch (const std::exception&) {  // no model there
          most = std::max(most, at_least);
        }
      }
      return most;
    };
    double size = scale_[j];
    while (size > smallest && change(0.01 * size) > at_most) size *= 0.1;
    if (size < scale_[j]) return std::max(size, std::abs(X[j]));
    while (size < largest && change(size) < at_least) size *= 10.0;
    return size < largest ? size : scale_[j];
  }

  // Scaled rows, and their slopes in units of scale.
  std::pair<Eigen::VectorXd, Eigen::MatrixXd> equations(const Eigen::VectorXd& X) const {
    const Eigen::VectorXd state = y(X);
    const double value = p(X), beyond = X[X.size() - 1] * scale_[X.size() - 1] - value;  // an iterate may be; then the tangent goes on
    SteadyEquations here = SteadyEquations::at(*flow_at_(value), t_, state, true);
    const Eigen::Index rows = here.residual.size(), unknowns = here.slopes.cols();
    const auto residual_beside = [&](double s) {
      if (value + s < lowest_ || value + s > highest_) throw InvalidValue("outside of the range");  // then the slope is taken on one side
      return SteadyEquations::at(*flow_at_(value + s), t_, state, false).residual;
    };
    const auto slope = slope_at_zero(residual_beside, std::min(std::max(std::abs(value), 0.01 * scale_[unknowns]), scale_[unknowns]));
    if (!slope)
      throw_invalid_value({"the equations of a family must have a derivative with respect to its parameter, but at ", {value, 8},
                           " they have none; let the scene depend smoothly on it"});
    Eigen::MatrixXd A(rows, unknowns + 1);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const double scale = row_scale_.size() > 0 ? row_scale_[i] : 1.0;
      for (Eigen::Index j = 0; j < unknowns; ++j) A(i, j) = here.slopes(i, j) * scale_[j] * scale;
      A(i, unknowns) = (*slope)[i] * scale_[unknowns] * scale;
      here.residual[i] = (here.residual[i] + (*slope)[i] * beyond) * scale;
    }
    return {here.residual, A};
  }

  FlowAt flow_at_;
  double t_, lowest_, highest_;
  Eigen::VectorXd qdot_, scale_, row_scale_;
  std::vector<Eigen::Index> free_;  // entries of X that are not cyclic
};

}  // namespace qdot::detail
