#pragma once
// SPDX-License-Identifier: MIT
//
// Newton's method for orbits that close
// =====================================
//
//     φ_T(x; p) − x − advance = 0         the motion closes; an angle may have gone round
//     ẋ(x)·δx = 0                         the start does not slide along the orbit          (autonomous)
//     h(x; p) − E = 0                     of the family of orbits, that of this energy      (if held)
//     τ·(X − X₀) = 0                      a step along a branch of orbits                   (branch.hpp)
//     ⎡ Φ − 1   φ̇   ∂φ/∂p ⎤ ⎡ δx ⎤
//     ⎢ ẋᵀ      0    0     ⎥ ⎢ δT ⎥ = −residual         a step in the start x, the period T and a parameter p, or some of them
//     ⎣ ∇h      0    ∂h/∂p ⎦ ⎣ δp ⎦
// These are more equations than unknowns where energy is conserved, and agree all the same, for ∇h (Φ − 1) = 0. A step
// is the shortest one that takes most of the residual away. What the equations leave open stays where it is, and is
// named. All is measured in extents of the orbit. A step that does not shorten the residual is halved.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "qdot/analysis/orbit.hpp"
#include "qdot/analysis/orbits/multipliers.hpp"
#include "qdot/analysis/orbits/shooting.hpp"
#include "qdot/analysis/orbits/symmetries.hpp"
#include "qdot/analysis/linear/shortest_step.hpp"
#include "qdot/analysis/variations/slope.hpp"
#include "qdot/error.hpp"

namespace qdot::detail {

// X = [x; T; p], and a run from there; rows of residual and slopes are in units of `scale`.
struct ClosingPoint {
  Eigen::VectorXd X;
  Shot shot;
  Eigen::VectorXd closing;   // x(t₀ + T) − x − advance
  Eigen::VectorXd residual;  // rows; the first of them close
  Eigen::MatrixXd slopes;    // of the rows in X/scale
  double size = std::numeric_limits<double>::infinity();
};

template <class = void>  // compiled only where it is made
struct BasicClosingEquations {
  const char* who;
  const Shooting* of;
  Eigen::VectorXd scale{};           // of X
  std::vector<Eigen::Index> free{};  // entries of X that are sought
  bool driven = false;
  bool phase_is_free = true;       // along the orbit, so that a step must not follow it
  std::optional<double> energy{};  // that is held
  Eigen::VectorXd advance{};
  Eigen::VectorXd along{}, from{};  // τ in units of scale, and X₀; or empty
  std::vector<AffineSymmetry> symmetries{};

  Eigen::Index states() const { return of->size(); }

  // Components are measured by their extents, those that hardly move by the largest.
  void measure(const Eigen::VectorXd& x, const Eigen::VectorXd& extent) {
    constexpr double negligible = 1e-9;
    const double most = std::max(extent.maxCoeff(), x.cwiseAbs().maxCoeff());
    for (Eigen::Index i = 0; i < x.size(); ++i) scale[i] = extent[i] > negligible * most ? extent[i] : most > 0.0 ? most : 1.0;
  }
  static double period(const Eigen::VectorXd& X) { return X[X.size() - 2]; }
  static double parameter(const Eigen::VectorXd& X) { return X[X.size() - 1]; }
  Eigen::VectorXd x(const Eigen::VectorXd& X) const { return X.head(states()); }
  Eigen::VectorXd rate(const Eigen::VectorXd& X) const { return of->rate(x(X), parameter(X)); }
  double energy_at(const Eigen::VectorXd& X) const { return of->energy(of->settled(x(X), parameter(X)), parameter(X)); }

  // ∂h/∂X in units of scale, on the constraints.
  Eigen::VectorXd energy_slope(const Eigen::VectorXd& X) const {
    Eigen::VectorXd slope = Eigen::VectorXd::Zero(X.size());
    for (Eigen::Index i = 0; i < X.size(); ++i) {
      if (i == states() || (i > states() && !of->has_parameter())) continue;
      const auto along_it = slope_at_zero([&](double s) {
        Eigen::VectorXd nearby = X;
        nearby[i] += s * scale[i];
        return Eigen::VectorXd(Eigen::VectorXd::Constant(1, energy_at(nearby)));
      }, 1.0);
      if (along_it) slope[i] = (*along_it)[0];
    }
    return slope;
  }

  ClosingPoint at(const Eigen::VectorXd& X) const { return rows_of(X, of->shot(x(X), period(X), parameter(X), 1.0)); }

  ClosingPoint rows_of(const Eigen::VectorXd& X, Shot shot) const {
    const Eigen::Index N = states();
    ClosingPoint point;
    point.X = X;
    point.shot = std::move(shot);
    if (point.shot.outcome != Outcome::completed) return point;
    point.closing = point.shot.x - X.head(N) - advance;
    const Eigen::Index rows = N + (phase_is_free ? 1 : 0) + (energy ? 1 : 0) + (along.size() > 0 ? 1 : 0);
    point.residual = Eigen::VectorXd::Zero(rows);
    point.slopes = Eigen::MatrixXd::Zero(rows, N + 2);
    const Eigen::VectorXd of_x = scale.head(N);
    point.residual.head(N) = point.closing.cwiseQuotient(of_x);
    point.slopes.topLeftCorner(N, N) = in_units_of(of_x, point.shot.Phi - Eigen::MatrixXd::Identity(N, N));
    point.slopes.col(N).head(N) = scale[N] * point.shot.xdot.cwiseQuotient(of_x);
    if (of->has_parameter()) point.slopes.col(N + 1).head(N) = scale[N + 1] * point.shot.by_parameter.cwiseQuotient(of_x);
    Eigen::Index row = N;
    if (phase_is_free) {
      const Eigen::VectorXd f = rate(X).cwiseQuotient(of_x);
      point.slopes.row(row++).head(N) = f / (f.norm() > 0.0 ? f.norm() : 1.0);
    }
    if (energy) {
      const Eigen::VectorXd slope = energy_slope(X);
      const double length = slope.norm() > 0.0 ? slope.norm() : 1.0;
      point.residual[row] = (energy_at(X) - *energy) / length;
      point.slopes.row(row) = slope.transpose() / length;
      ++row;
    }
    if (along.size() > 0) {
      point.residual[row] = along.dot((X - from).cwiseQuotient(scale));
      point.slopes.row(row) = along;
    }
    point.size = 0.0;
    for (Eigen::Index i = 0; i < rows; ++i) point.size = std::isnan(point.residual[i]) ? point.residual[i] : std::max(point.size, std::abs(point.residual[i]));
    return point;
  }
};

using ClosingEquations = BasicClosingEquations<>;

// The shortest step in X/scale that takes away most of the residual, and orthonormal directions that change nothing.
template <class = void>  // compiled only where it is called
ShortestStep closing_step(const ClosingEquations& equations, const ClosingPoint& point) {
  constexpr double negligible = 1e-9;  // Φ is known to some 1e-12
  const ShortestStep part = shortest_step(point.slopes(Eigen::indexing::all, equations.free), -point.residual, negligible);
  ShortestStep all{Eigen::VectorXd::Zero(point.X.size()), Eigen::MatrixXd::Zero(point.X.size(), part.open.cols())};
  all.x(equations.free) = part.x;
  all.open(equations.free, Eigen::indexing::all) = part.open;
  return all;
}

struct ClosingSearch {
  int max_iterations;
  double tolerance;
  double least_fraction = 1e-3;  // of a step of Newton's method
};

struct ClosingEnd {
  OrbitOutcome outcome = OrbitOutcome::not_closed;
  ClosingPoint point;
  std::vector<OrbitIteration> history;
  std::string message;                       // of a run that failed
  Outcome run_outcome = Outcome::completed;  // of it
};

// How small a motion is beside what was expected of it: zero at rest.
template <class = void>  // compiled only where it is called
double liveliness(const ClosingEquations& equations, const Eigen::VectorXd& X) {
  if (equations.driven) return 1.0;
  return equations.rate(X).cwiseQuotient(equations.scale.head(equations.states())).cwiseAbs().maxCoeff() * equations.period(X);
}

// What a part of a step led to: the first part that makes the residual shorter, or the last one that was tried.
struct PartOfStep {
  ClosingPoint next{};
  double fraction = 1.0;
  bool shorter = false;
  Outcome run_outcome = Outcome::completed;
  std::string trouble{};  // of a run that failed
};
template <class = void>  // compiled only where it is called
PartOfStep part_of_step(const ClosingEquations& equations, const ClosingSearch& search, const ClosingPoint& here, const Eigen::VectorXd& step,
                        double least_period) {
  constexpr double longest_step = 0.5;
  const bool close = here.size <= search.tolerance;
  PartOfStep part;
  double fraction = std::min(1.0, longest_step / std::max(step.norm(), 1e-300));
  for (; fraction >= search.least_fraction && !part.shorter; fraction *= 0.5) {
    Eigen::VectorXd X = here.X + fraction * step.cwiseProduct(equations.scale);
    if (!(equations.period(X) > least_period)) continue;
    try {
      X.head(equations.states()) = equations.of->settled(equations.x(X), equations.parameter(X));
      part.next = equations.at(X);
      part.run_outcome = part.next.shot.outcome;
      part.trouble = part.next.shot.message;
    } catch (const Error& error) {
      part.next.size = std::numeric_limits<double>::infinity();
      part.run_outcome = Outcome::solver_error;
      part.trouble = error.what();
    }
    part.shorter = part.next.size <= (close ? 0.9 : 1.0 - 0.25 * fraction) * here.size;
    part.fraction = fraction;
    if (close) break;  // one more step, as a polish
  }
  return part;
}

template <class = void>  // compiled only where it is called
ClosingEnd closed(const ClosingEquations& equations, const Eigen::VectorXd& X0, const ClosingSearch& search) {
  constexpr double at_rest = 1e-6;
  ClosingEnd end;
  end.point = equations.at(X0);
  const auto failed = [&](const Outcome outcome, std::string message) {
    end.outcome = OrbitOutcome::run_failed;
    end.run_outcome = outcome;
    end.message = std::move(message);
    return end;
  };
  if (end.point.shot.outcome != Outcome::completed) return failed(end.point.shot.outcome, end.point.shot.message);
  const double least_period = 0.05 * equations.period(X0);
  for (int iteration = 0;; ++iteration) {
    ClosingPoint& here = end.point;
    OrbitIteration entry{here.size, 0.0, 1.0, equations.period(here.X)};
    if (liveliness(equations, here.X) <= at_rest) {
      end.history.push_back(entry);
      end.outcome = OrbitOutcome::equilibrium;
      return end;
    }
    const bool close = here.size <= search.tolerance;
    if (close) end.outcome = OrbitOutcome::found;
    if (iteration == search.max_iterations || here.size == 0.0 || !std::isfinite(here.size)) {
      end.history.push_back(entry);
      return end;
    }
    const Eigen::VectorXd step = closing_step(equations, here).x;
    entry.step = step.norm();
    PartOfStep part = part_of_step(equations, search, here, step, least_period);
    entry.fraction = part.fraction;
    if (!part.shorter) entry.step = entry.fraction = 0.0;
    end.history.push_back(entry);
    if (!part.shorter && !close && part.run_outcome != Outcome::completed) return failed(part.run_outcome, part.trouble);
    if (part.shorter) here = std::move(part.next);
    if (close) {
      if (part.shorter) end.history.push_back({here.size, 0.0, 1.0, equations.period(here.X)});
      return end;
    }
    if (!part.shorter) return end;
  }
}

// Whether h keeps still beside the orbit, too: where a cycle appears or vanishes, it does so on the cycle itself and to first order.
template <class = void>  // compiled only where it is called
bool energy_lasts(const ClosingEquations& equations, const Eigen::VectorXd& X) {
  constexpr double beside = 0.1, negligible = 1e-7;
  for (const double side : {beside, -beside}) {
    Eigen::VectorXd nearby = X;
    for (Eigen::Index i = 0; i < equations.states(); ++i) nearby[i] += (i % 2 == 0 ? side : 0.7 * beside) * equations.scale[i];
    try {
      nearby.head(equations.states()) = equations.of->settled(equations.x(nearby), ClosingEquations::parameter(nearby));
      const Eigen::Index N = equations.states();
      const Eigen::VectorXd changes = equations.energy_slope(nearby).head(N).cwiseProduct(equations.rate(nearby)).cwiseQuotient(equations.scale.head(N));
      if (std::abs(changes.sum()) > negligible * changes.cwiseAbs().maxCoeff()) return false;
    } catch (const Error&) {  // no model there: nothing to say
    }
  }
  return true;
}

// Unit vectors normal to what constraints allow, in units of scale; none without constraints.
template <class = void>  // compiled only where it is called
std::vector<Eigen::VectorXd> forbidden_directions(const ClosingEquations& equations, const Eigen::VectorXd& X) {
  std::vector<Eigen::VectorXd> forbidden;
  if (!equations.of->projects()) return forbidden;
  const Eigen::Index N = equations.states();
  Eigen::MatrixXd transposed = Eigen::MatrixXd::Identity(N, N);  // of the slope of the projection
  for (Eigen::Index j = 0; j < N; ++j) {
    const auto slope = slope_at_zero([&](double s) {
      Eigen::VectorXd nearby = equations.x(X);
      nearby[j] += s * equations.scale[j];
      return equations.of->settled(nearby, ClosingEquations::parameter(X));
    }, 1.0);
    for (Eigen::Index i = 0; slope && i < N; ++i) transposed(j, i) = (*slope)[i] / equations.scale[i];
  }
  const ShortestStep normal = shortest_step(transposed, Eigen::VectorXd::Zero(N), 1e-6);
  for (Eigen::Index k = 0; k < normal.open.cols(); ++k) forbidden.push_back(normal.open.col(k));
  return forbidden;
}

// What is taken out of M: what constraints forbid, ẋ, ∇h and the symmetries, as far as M keeps them.
template <class = void>  // compiled only where it is called
TrivialDirections trivial_directions(const ClosingEquations& equations, const ClosingPoint& point) {
  constexpr double conserved = 1e-6;
  TrivialDirections result{forbidden_directions(equations, point.X)};
  const Eigen::Index N = equations.states();
  const Eigen::VectorXd scale = equations.scale.head(N);
  const Eigen::MatrixXd M = in_units_of(scale, point.shot.Phi);
  const auto stays = [](const Eigen::VectorXd& v, const Eigen::VectorXd& after) { return v.norm() > 0.0 && (after - v).norm() <= conserved * v.norm(); };
  std::vector<KeptPair> pairs;
  if (!equations.driven) {
    pairs.push_back({equations.rate(point.X).cwiseQuotient(scale), {}, "time"});
    const Eigen::VectorXd slope = equations.energy_slope(point.X).head(N);
    result.conserves_energy = stays(slope, M.transpose() * slope) && energy_lasts(equations, point.X);
    if (result.conserves_energy) pairs[0] = {pairs[0].tangent, slope, "time and energy"};
  }
  const Eigen::VectorXd x = equations.x(point.X);
  const Eigen::MatrixXd slopes = integral_slopes({*equations.of, x, scale, ClosingEquations::parameter(point.X)}, equations.symmetries);
  for (std::size_t k = 0; k < equations.symmetries.size(); ++k) {
    const AffineSymmetry& symmetry = equations.symmetries[k];
    const Eigen::VectorXd tangent = symmetry.tangent(x).cwiseQuotient(scale), slope = slopes.col(static_cast<Eigen::Index>(k));
    if (symmetry.moves(x) && stays(tangent, M * tangent) && stays(slope, M.transpose() * slope)) pairs.push_back({tangent, slope, symmetry.name});
  }
  result.take(pairs);
  return result;
}

// What the search found or missed, in full.
template <class = void>  // compiled only where it is called
Orbit orbit_of(const ClosingEquations& equations, const ClosingEnd& end) {
  const Eigen::Index N = equations.states();
  const ClosingPoint& point = end.point;
  Orbit orbit;
  orbit.outcome = end.outcome;
  orbit.run_outcome = end.run_outcome;
  orbit.t = equations.of->time();
  orbit.x = equations.x(point.X);
  orbit.period = equations.period(point.X);
  orbit.parameter = equations.parameter(point.X);
  orbit.energy = equations.of->energy(orbit.x, orbit.parameter);
  orbit.history = end.history;
  if (point.closing.size() > 0) {
    orbit.residual = point.closing;
    orbit.extent = point.shot.extent;
    orbit.monodromy = point.shot.Phi;
    Eigen::Index worst = 0;
    point.residual.head(N).cwiseAbs().maxCoeff(&worst);
    orbit.worst = equations.of->name(worst);
    const std::string off = sentence({"after a period of ", {orbit.period, 8}, " it is off by ", {point.closing[worst], 3}, " in ", orbit.worst});
    if (end.outcome == OrbitOutcome::found) orbit.message = sentence({"found: ", off});
    if (end.outcome == OrbitOutcome::not_closed)
      orbit.message = sentence({equations.who, ": the motion must close, but where the search ended, ", off,
                                "; start closer, or ask whether what is held leaves a periodic orbit"});
  }
  if (end.outcome == OrbitOutcome::equilibrium)
    orbit.message = sentence({equations.who, ": a periodic orbit must move, but where the search ended, everything is at rest (", equations.of->name(0), " = ",
                              {orbit.x[0], 6}, "), which has no period; start farther from the equilibrium, or hold the energy of the orbit"});
  if (end.outcome == OrbitOutcome::run_failed)
    orbit.message = sentence({equations.who, ": a run must last for the period of ", {orbit.period, 8}, ", but it ended early, ", end.message});
  if (end.outcome != OrbitOutcome::found) return orbit;

  const TrivialDirections trivial = trivial_directions(equations, point);
  orbit.conserves_energy = trivial.conserves_energy;
  orbit.symmetries = trivial.symmetries;
  constexpr double coarser = 10.0;  // the error of this run is all but the difference
  const Shot again = equations.of->shot(orbit.x, orbit.period, orbit.parameter, coarser);
  const Eigen::MatrixXd B = without_trivial(orbit.monodromy, equations.scale, trivial.taken);
  const Eigen::MatrixXd coarse = again.outcome == Outcome::completed ? without_trivial(again.Phi, equations.scale, trivial.taken) : Eigen::MatrixXd(2.0 * B);
  orbit.multipliers = multipliers_of(B, coarse, trivial.ones);
  orbit.stability = stability_of(orbit.multipliers);
  const Eigen::MatrixXd open = closing_step(equations, point).open;
  for (Eigen::Index k = 0; k < open.cols(); ++k) {
    Eigen::Index largest = 0;
    open.col(k).cwiseAbs().maxCoeff(&largest);
    orbit.undetermined.push_back(largest < N ? equations.of->name(largest) : largest == N ? "the period" : "the parameter");
  }
  return orbit;
}

}  // namespace qdot::detail
