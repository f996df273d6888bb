#pragma once
// SPDX-License-Identifier: MIT
//
// Newton's method for states that do not change: rest, and motions in which cyclic coordinates turn at given rates.
//
//     q̈ (q, q̇, z) = 0 ,   ż (q, q̇, z) = 0 ,   φ(q) = 0 ,   J q̇ = 0 ,   (a = 0)        for q and z at given q̇.
//
// On constraints these are more equations than unknowns, and agree all the same: at rest J q̈ = 0 whatever q is. Each row of
// their Jacobian is scaled to length 1, so that residuals are distances in the unknowns. A step is the shortest one that
// takes most of the residual away: what nothing depends on keeps its value. A step that does not shorten the next is halved.
//
// No length is natural, so row i is met where the last step takes no more than `tolerance` of the size of its terms,
//
//     Eᵢ = Σⱼ |Sᵢⱼ| (|xⱼ| + the way that xⱼ has come) .
//
// On constraints accelerations are what is left of forces that cancel, M⁻¹ (|Jᵀ| |λ|): what is within their rounding is
// zero, and a row weighs less, the smaller Eᵢ is beside them. Where steps get no shorter, one of 1e-12 is enough.

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/QR>

#include "qdot/analysis/equilibrium.hpp"
#include "qdot/analysis/linear/flow.hpp"
#include "qdot/error.hpp"

namespace qdot::detail {

// The equations of a steady state at y, and their slopes in x = [q; z]; a row's name is found by its number.
struct SteadyEquations {
  Eigen::VectorXd residual;
  Eigen::MatrixXd slopes;
  Eigen::VectorXd cancelling;  // the sizes of the terms of each row, where they are known, else zero
  Eigen::VectorXd rounding;    // of these

  template <class F>
  static SteadyEquations at(const F& flow, double t, const Eigen::VectorXd& y, bool with_slopes) {
    const Eigen::Index n = flow.dof(), states = flow.size() - 2 * n;
    const ConstraintsAt rows = flow.constraints(t, y);
    const Eigen::Index m = rows.phi.size();
    SteadyEquations equations;
    equations.residual.resize(n + states + 2 * m);
    equations.residual << flow.rates(t, y).tail(n + states), rows.phi, rows.velocity;
    equations.cancelling = Eigen::VectorXd::Zero(equations.residual.size());
    if (m > 0) equations.cancelling.head(n) = flow.cancelling(t, y);
    equations.rounding = 64 * std::numeric_limits<double>::epsilon() * std::sqrt(static_cast<double>(n)) * equations.cancelling;
    for (Eigen::Index i = 0; i < n; ++i)
      if (std::abs(equations.residual[i]) <= equations.rounding[i]) equations.residual[i] = 0.0;
    if (!with_slopes) return equations;
    const Eigen::MatrixXd slopes = flow.slopes(t, y);
    equations.slopes = Eigen::MatrixXd::Zero(n + states + 2 * m, n + states);
    equations.slopes.topLeftCorner(n + states, n) = slopes.bottomLeftCorner(n + states, n);
    equations.slopes.topRightCorner(n + states, states) = slopes.bottomRightCorner(n + states, states);
    for (const Eigen::Index i : flow.inputs())
      equations.slopes.col(i - n).setZero();  // which keep the values that they were given
    for (Eigen::Index k = 0; k < m; ++k) {
      if (rows.holonomic[static_cast<std::size_t>(k)])
        equations.slopes.row(n + states + k).head(n) = rows.slopes.row(k).tail(n);
      equations.slopes.row(n + states + m + k).head(n) = rows.slopes.row(k).head(n);
    }
    return equations;
  }

  // What row i is about, for messages.
  template <class F>
  static std::string name(const F& flow, Eigen::Index i) {
    const Eigen::Index rates = flow.size() - flow.dof();
    if (i < rates) return flow.acceleration_name(i);
    const auto names = flow.constraint_names();
    const auto k = static_cast<std::size_t>(i - rates), m = names.size();
    return k < m ? "constraint '" + names[k] + "'" : "the velocity in constraint '" + names[k - m] + "'";
  }
};

// How a search begins and ends: the name of the caller is for messages.
struct SteadySearch {
  const char* who;
  int max_iterations;
  double tolerance;
};

template <class F>
[[noreturn, gnu::cold]] void report_no_steady_state(const F& flow, const SteadySearch& search, const Eigen::VectorXd& y,
                                                    const Eigen::VectorXd& residual, const Eigen::VectorXd& scaled) {
  Eigen::Index worst = 0;
  scaled.cwiseAbs().maxCoeff(&worst);
  const Eigen::Index n = flow.dof();
  std::string where = "(";
  for (Eigen::Index i = 0; i < n; ++i) where += sentence({i > 0 ? ", " : "", flow.name(i), " = ", {y[i], 6}});
  throw_invalid_value({search.who,
                       ": all accelerations must vanish somewhere near the start, but where the search ended, at ",
                       where,
                       "), ",
                       SteadyEquations::name(flow, worst),
                       " is ",
                       {residual[worst], 6},
                       "; start closer, or ask whether this scene can ",
                       y.segment(n, n).isZero(0.0) ? "rest at all" : "move like this at all"});
}

// Refuses what is no steady state because it mentions the time, or because a coordinate that turns is not cyclic.
template <class F>
void require_steady(const F& flow, const SteadySearch& search, double t, const Eigen::VectorXd& y,
                    const SteadyEquations& here, const Eigen::VectorXd& scale) {
  const Eigen::VectorXd terms = scale.cwiseProduct(here.slopes.cwiseAbs() * flow.unknowns(y).cwiseAbs());
  const Eigen::VectorXd now = SteadyEquations::at(flow, t, y, false).residual;
  for (const double later : {1.0, 3.7}) {
    const auto there = elsewhere_in_time(t, later, [&](double at) { return SteadyEquations::at(flow, at, y, false).residual; });
    if (!there) continue;
    const Eigen::VectorXd change = *there - now;
    Eigen::Index i = 0;
    if (((change.array().abs() - here.rounding.array()) * scale.array() - 1e-7 * terms.array()).maxCoeff(&i) > 0.0)
      throw_invalid_value({search.who,
                           ": nothing may depend on the time, but ",
                           SteadyEquations::name(flow, i),
                           " changes by ",
                           {change[i], 6},
                           " within a time of ",
                           later,
                           "; fix the time in what takes it, or choose coordinates that move along"});
  }
  const Eigen::Index n = flow.dof();
  for (Eigen::Index j = 0; j < n; ++j) {
    if (y[n + j] == 0.0) continue;
    Eigen::Index i = 0;
    if ((here.slopes.col(j).array() * scale.array()).abs().maxCoeff(&i) > 1e-7)
      throw_invalid_value({search.who,
                           ": a coordinate that turns must be cyclic, but ",
                           SteadyEquations::name(flow, i),
                           " changes with ",
                           flow.name(j),
                           " by ",
                           {here.slopes(i, j), 6},
                           " per unit; give ",
                           flow.name(j),
                           " the rate 0, or choose coordinates in which the motion looks the same at all times"});
  }
}

// What residuals and slopes are multiplied by, row by row. Slopes get the length 1; forces that cancel weigh by what else is in their row, beside the row
// that has most of it.
//
// @param extent  of the unknowns [q; z], the first n of which are q
template <class = void>  // compiled only where it is called
Eigen::VectorXd scale_of_rows(const SteadyEquations& here, Eigen::Index n, const Eigen::VectorXd& extent) {
  const Eigen::Index unknowns = extent.size();
  const auto longest = [&](Eigen::Index begin, Eigen::Index count) {
    return count > 0 ? here.slopes.middleRows(begin, count).rowwise().norm().maxCoeff() : 0.0;
  };
  const double stiffest = longest(0, n), fastest = longest(n, unknowns - n);
  Eigen::VectorXd scale(here.residual.size());
  for (Eigen::Index i = 0; i < scale.size(); ++i) {
    const double length = std::max(here.slopes.row(i).norm(), 1e-10 * (i < n ? stiffest : i < unknowns ? fastest : 0.0));
    scale[i] = length > 0.0 ? 1.0 / length : 1.0;
  }
  Eigen::VectorXd share = Eigen::VectorXd::Zero(scale.size());
  for (Eigen::Index i = 0; i < n; ++i)
    if (here.cancelling[i] > 0.0) share[i] = here.slopes.row(i).cwiseAbs().dot(extent) / here.cancelling[i];
  for (Eigen::Index i = 0; i < n; ++i)
    if (here.cancelling[i] > 0.0) scale[i] *= share[i] > 0.0 ? std::pow(share[i] / share.maxCoeff(), 2) : 0.0;
  return scale;
}

// Whether a residual is more than what is left of rounding.
//
// @param scaled   the residual in units of its rows
// @param terms    sizes of its terms, in the same units
// @param largest  residual where the search began
template <class = void>  // compiled only where it is called
bool residual_remains(const SteadyEquations& here, const Eigen::VectorXd& scaled, const Eigen::VectorXd& terms, double largest) {
  for (Eigen::Index i = 0; i < scaled.size(); ++i)
    if (terms[i] > 0.0 ? std::abs(scaled[i]) > 1e-9 * terms[i] : std::abs(here.residual[i]) > 1e-13 * largest) return true;
  return false;
}

// The part of a step after which the next one is shorter, found by halving; small where there is none.
//
// @param length      of the step
// @param extent      of the unknowns, as a length
// @param next_length  part ↦ length of the step from there, NaN where there is none
template <class Length>
double shortening_part(double length, double extent, const Length& next_length) {
  double part = 1.0;
  while (!(next_length(part) <= (1.0 - 0.25 * part) * length)) {
    part *= 0.5;
    if (length * part < 1e-9 * extent || part < 1e-7) break;
  }
  return part;
}

template <class AnyFlow>
void require_finite_start(const AnyFlow& flow, const SteadySearch& search, const Eigen::VectorXd& y) {
  for (Eigen::Index i = 0; i < y.size(); ++i)
    if (!std::isfinite(y[i])) throw_invalid_value({search.who, ": the start must be finite, but ", flow.name(i), " is not; give every entry a number"});
}

// The steady state near y = [q; q̇; z] with its q̇.
template <class F>
Eigen::VectorXd steady_state_near(const F& flow, const SteadySearch& search, double t, Eigen::VectorXd y) {
  const Eigen::Index n = flow.dof(), states = flow.size() - 2 * n;
  require_finite_start(flow, search, y);
  const std::vector<Eigen::Index> held = flow.phases();
  const auto moved = [&](const Eigen::VectorXd& step, double fraction) {
    Eigen::VectorXd next = y;
    next.head(n) += fraction * step.head(n);
    next.tail(states) += fraction * step.tail(states);
    for (const Eigen::Index i : held) next[i] = y[i];
    return next;
  };
  Eigen::VectorXd scale, way = Eigen::VectorXd::Zero(n + states);
  Progress progress;
  double largest = 0.0;
  SteadyEquations here;
  for (int iteration = 0;; ++iteration) {
    here = SteadyEquations::at(flow, t, y, true);
    const Eigen::VectorXd unknowns = flow.unknowns(y), extent = unknowns.cwiseAbs() + way;
    scale = scale_of_rows(here, n, extent);
    const Eigen::VectorXd scaled = scale.cwiseProduct(here.residual);
    const Eigen::MatrixXd sizes = (scale.asDiagonal() * here.slopes).cwiseAbs();
    const Eigen::VectorXd terms = sizes * extent;
    if (iteration == 0) largest = here.residual.head(n + states).cwiseAbs().maxCoeff();
    if (iteration == search.max_iterations || !scaled.allFinite())
      report_no_steady_state(flow, search, y, here.residual, scaled);
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> factors;
    factors.setThreshold(1e-13);
    factors.compute(scale.asDiagonal() * here.slopes);
    const Eigen::VectorXd step = -factors.solve(scaled);
    const bool is_met = (sizes * step.cwiseAbs() - search.tolerance * terms - scale.cwiseProduct(here.rounding)).maxCoeff() <= 0.0;
    const bool is_rounding =
        progress.stands_still(step.norm()) && (step.array().abs() / unknowns.array().abs().max(1.0)).maxCoeff() <= search.tolerance;
    if (is_met || is_rounding) {
      // A short step is not enough: where nothing can rest, none takes the residual away. What is left of rounding is
      // harmless.
      const Eigen::VectorXd left = scaled + (scale.asDiagonal() * here.slopes) * step;
      if (residual_remains(here, scaled, terms, largest) && left.norm() > 1e-8 * scaled.norm())
        report_no_steady_state(flow, search, y, here.residual, scaled);
      y = moved(step, 1.0);
      break;
    }
    const double fraction = shortening_part(step.norm(), extent.norm(), [&](double part) {
      const Eigen::VectorXd next = scale.cwiseProduct(SteadyEquations::at(flow, t, moved(step, part), false).residual);
      return next.allFinite() ? factors.solve(next).norm() : std::numeric_limits<double>::quiet_NaN();
    });
    way += fraction * step.cwiseAbs();
    if (fraction < 1e-6) report_no_steady_state(flow, search, y, here.residual, scaled);
    y = moved(step, fraction);
  }
  require_steady(flow, search, t, y, here, scale);
  return y;
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template Eigen::VectorXd steady_state_near<Flow>(const Flow&, const SteadySearch&, double, Eigen::VectorXd);
#endif

}  // namespace qdot::detail
