#pragma once
// SPDX-License-Identifier: MIT
//
// A branch of periodic orbits, one after the other
// ================================================
//
// The equations of search.hpp without one of them have a curve X(s) of solutions, and their null vector τ is its
// tangent. From a point of it, X + ds τ is a prediction. Newton's method with the row τ·(X − prediction) = 0 goes back
// to the curve at a right angle, so a curve that turns back is followed, too (pseudo-arclength, Keller 1977). Steps are
// in extents of the orbit, taken anew at each point. Where one of these functions changes its sign between two points,
// regula falsi (Illinois) on s locates a special point:
//
//     fold               d(what the branch is followed in)/ds
//     period doubling    det(B + 1)      B the monodromy matrix without its trivial multipliers; some μ passes −1
//     branch point       det(B − 1)      some μ passes 1, and it is no fold, where one does so, too
//     torus              the number of complex μ outside the circle

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "qdot/analysis/orbit.hpp"
#include "qdot/analysis/orbits/multipliers.hpp"
#include "qdot/analysis/orbits/search.hpp"
#include "qdot/error.hpp"

namespace qdot::detail {

// A point of a branch: X, τ, and the functions that vanish at special points.
struct PointOfFamily {
  ClosingEquations equations;  // with the units that hold here
  ClosingPoint point;
  std::vector<OrbitIteration> history;
  Eigen::VectorXd tangent;  // of length 1, in units of scale
  Eigen::Index open = 1;    // dimension of the curve
  double quantity = 0.0, slope = 0.0;
  double at_minus_one = 1.0, at_one = 1.0;
  int outside = 0;
};

// The tangent at a point, in units that hold elsewhere.
template <class = void>  // compiled only where it is called
Eigen::VectorXd tangent_in_units_of(const ClosingEquations& there, const PointOfFamily& point) {
  return point.tangent.cwiseProduct(point.equations.scale).cwiseQuotient(there.scale);
}

// What a branch is followed in.
template <class = void>  // compiled only where it is made
struct BasicBranchQuantity {
  enum class What { energy, period, parameter };
  What what;

  double value(const ClosingEquations& equations, const Eigen::VectorXd& X) const {
    if (what == What::energy) return equations.energy_at(X);
    return what == What::period ? ClosingEquations::period(X) : ClosingEquations::parameter(X);
  }
  // d/ds along a tangent in units of scale.
  double slope(const ClosingEquations& equations, const Eigen::VectorXd& X, const Eigen::VectorXd& tangent) const {
    const Eigen::Index N = equations.states();
    if (what == What::energy) return equations.energy_slope(X).dot(tangent);
    return what == What::period ? tangent[N] * equations.scale[N] : tangent[N + 1] * equations.scale[N + 1];
  }
  const char* name() const { return what == What::energy ? "the energy" : what == What::period ? "the period" : "the parameter"; }
};

using BranchQuantity = BasicBranchQuantity<>;

// The point of the branch where an orbit was found; `before` orients its tangent.
template <class = void>  // compiled only where it is called
PointOfFamily point_of_family(ClosingEquations equations, const ClosingEnd& end, const BranchQuantity& quantity, const PointOfFamily* before) {
  equations.along.resize(0);
  const Eigen::Index N = equations.states();
  if (end.point.shot.extent.size() == N) equations.measure(equations.x(end.point.X), end.point.shot.extent);
  equations.scale[N] = ClosingEquations::period(end.point.X);
  PointOfFamily result{equations, end.point, end.history, {}};
  const Eigen::VectorXd& X = end.point.X;
  ClosingPoint here = equations.rows_of(end.point.X, end.point.shot);
  const ShortestStep step = closing_step(equations, here);
  result.open = step.open.cols();
  result.quantity = quantity.value(equations, X);
  if (result.open != 1) return result;
  result.tangent = step.open.col(0);
  if (before != nullptr && result.tangent.dot(tangent_in_units_of(equations, *before)) < 0.0) result.tangent = -result.tangent;
  result.slope = quantity.slope(equations, X, result.tangent);
  const Eigen::MatrixXd B = without_trivial(here.shot.Phi, equations.scale, trivial_directions(equations, here).taken);
  const Exponents all = exponents_of(B);
  std::complex<double> minus = 1.0, plus = 1.0;
  constexpr double doubt = 1e-7;
  for (Eigen::Index i = 0; i < B.rows(); ++i) {
    minus *= all.lambda[i] + 1.0;
    plus *= all.lambda[i] - 1.0;
    if (std::abs(all.lambda[i]) > 1.0 + std::max(doubt, all.radius[i]) && all.lambda[i].imag() != 0.0) ++result.outside;
  }
  result.at_minus_one = minus.real();
  result.at_one = plus.real();
  return result;
}

// The orbit at a distance along the tangent at `from`, by Newton's method across it; predicted from a point near it that lies so much nearer or farther.
template <class = void>  // compiled only where it is called
ClosingEnd stepped(const PointOfFamily& from, const PointOfFamily& nearby, double distance, const ClosingSearch& search) {
  ClosingEquations equations = from.equations;
  equations.along = from.tangent;
  const double along = from.tangent.dot(tangent_in_units_of(equations, nearby));
  Eigen::VectorXd X = nearby.point.X + distance / along * nearby.tangent.cwiseProduct(nearby.equations.scale);
  equations.from = X;
  ClosingEnd end;
  try {
    X.head(equations.states()) = equations.of->settled(equations.x(X), ClosingEquations::parameter(X));
    if (ClosingEquations::period(X) > 0.0) end = closed(equations, X, search);
  } catch (const Error& error) {
    end.outcome = OrbitOutcome::run_failed;
    end.message = error.what();
  }
  return end;
}

template <class = void>  // compiled only where it is called
ClosingEnd stepped(const PointOfFamily& from, double distance, const ClosingSearch& search) { return stepped(from, from, distance, search); }

using BranchTest = std::function<double(const PointOfFamily&)>;

// Where a function of the branch changes its sign between `from` and a distance from there, to a part of that distance. Each point is predicted from the
// nearer end of what is left: next to a crossing a prediction from afar ends on the other branch.
template <class = void>  // compiled only where it is called
PointOfFamily located(const PointOfFamily& from, const PointOfFamily& to, double distance, const BranchTest& test, const BranchQuantity& quantity,
                      const ClosingSearch& search, double tolerance) {
  constexpr int most_steps = 60;
  double low = 0.0, high = distance, f_low = test(from), f_high = test(to);
  PointOfFamily best = std::abs(f_low) < std::abs(f_high) ? from : to, lower = from, upper = to;
  int side = 0;
  double previous = -1.0;
  for (int k = 0; k < most_steps && high - low > tolerance * distance; ++k) {
    double s = (low * f_high - high * f_low) / (f_high - f_low);
    if (!(s > low && s < high)) s = 0.5 * (low + high);
    const ClosingEnd end = s - low <= high - s ? stepped(from, lower, s - low, search) : stepped(from, upper, s - high, search);
    if (end.outcome != OrbitOutcome::found) break;
    PointOfFamily middle = point_of_family(from.equations, end, quantity, &from);
    if (middle.open != 1) return middle;  // on it, as far as can be told
    const double f = test(middle);
    best = std::move(middle);
    if (f == 0.0) break;
    if ((f < 0.0) == (f_low < 0.0)) {
      low = s;
      f_low = f;
      lower = best;
      if (side < 0) f_high *= 0.5;
      side = -1;
    } else {
      high = s;
      f_high = f;
      upper = best;
      if (side > 0) f_low *= 0.5;
      side = 1;
    }
    if (std::abs(s - previous) <= tolerance * distance) break;
    previous = s;
  }
  return best;
}

}  // namespace qdot::detail
