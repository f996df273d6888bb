#pragma once
// SPDX-License-Identifier: MIT
//
// Symmetries of a system, which give its orbits multipliers of 1
// ==============================================================
//
// Let the field ξ(q) = A q + b move every motion to a motion. Then, by Noether's theorem, I = p·ξ − g·q is conserved, and this holds at all states:
//
//     ṗ·(A q + b) + p·A q̇ − g·q̇ = 0 .
//
// Shifts of cyclic coordinates, translations and rotations of particles are such fields; a uniform magnetic field needs the gauge term g·q. The condition
// is linear in A, b and g: they are the kernel of a matrix with a row for each of enough scattered states. ṗ is the rate of the momenta on the motion, with
// all forces and constraints. With more than 12 coordinates A has too many entries, and b and g alone are sought.
//
// On an orbit a symmetry gives a tangent z = [ξ; A q̇] with M z = z, and a slope ∇I with ∇I M = ∇I. What becomes of them is in multipliers.hpp.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "qdot/analysis/linear/echelon.hpp"
#include "qdot/analysis/linear/shortest_step.hpp"
#include "qdot/analysis/orbits/shooting.hpp"
#include "qdot/analysis/symmetry/vanishing.hpp"
#include "qdot/analysis/variations/slope.hpp"
#include "qdot/error.hpp"

namespace qdot::detail {

template <class = void>  // compiled only where it is made
struct BasicAffineSymmetry {
  Eigen::MatrixXd A;     // n×n
  Eigen::VectorXd b, g;  // n
  std::string name{};

  Eigen::VectorXd tangent(const Eigen::VectorXd& x) const {
    const Eigen::Index n = b.size();
    Eigen::VectorXd z(2 * n);
    z << A.lazyProduct(x.head(n)) + b, A.lazyProduct(x.tail(n));
    return z;
  }
  // Whether it moves a state, by more than the rounding of its terms.
  bool moves(const Eigen::VectorXd& x) const {
    constexpr double rounding = 1e-9;
    const Eigen::Index n = b.size();
    const Eigen::MatrixXd sizes = A.cwiseAbs();
    const Eigen::VectorXd z = tangent(x), q = x.head(n).cwiseAbs(), v = x.tail(n).cwiseAbs();
    return z.head(n).norm() > rounding * (sizes.lazyProduct(q) + b.cwiseAbs()).norm() || z.tail(n).norm() > rounding * (sizes.lazyProduct(v)).norm();
  }
  double integral(const Eigen::VectorXd& x, const Eigen::VectorXd& p) const { return p.dot(tangent(x).head(p.size())) - g.dot(x.head(p.size())); }
};

using AffineSymmetry = BasicAffineSymmetry<>;

// States about x, half of `scale` to each side, at times within a window.
struct Neighbourhood {
  const Shooting& of;
  Eigen::VectorXd x, scale;
  double parameter = 0.0, window = 0.0;
};

// A state of it, with momenta and their rates.
struct StateWithMomenta {
  Eigen::VectorXd x, xdot, p, pdot;
};

// Nothing where there is no model.
template <class = void>  // compiled only where it is called
std::optional<StateWithMomenta> scattered_state(const Neighbourhood& within, int sample) {
  const Eigen::Index N = within.x.size();
  const std::vector<double> places = scattered_point(static_cast<std::size_t>(N) + 1, 8 * sample);  // between 1/4 and 5/4
  StateWithMomenta s{within.x, {}, {}, {}};
  for (Eigen::Index i = 0; i < N; ++i) s.x[i] += (places[static_cast<std::size_t>(i)] - 0.75) * within.scale[i];
  const double later = (places.back() - 0.25) * within.window;
  try {
    s.x = within.of.settled(s.x, within.parameter);
    s.xdot = within.of.rate(s.x, within.parameter, later);
    const double speed = s.xdot.cwiseQuotient(within.scale).cwiseAbs().maxCoeff();
    if (!(speed > 0.0 && std::isfinite(speed))) return {};
    const auto momenta = [&](double t) { return within.of.momenta(s.x + t * s.xdot, within.parameter, later + t); };
    std::optional<Eigen::VectorXd> pdot = slope_at_zero(momenta, 1.0 / speed);
    if (!pdot) return {};
    s.p = momenta(0.0);
    s.pdot = std::move(*pdot);
  } catch (const Error&) {
    return {};
  }
  if (s.p.allFinite() && s.pdot.allFinite()) return s;
  return {};
}

// "(x1, y1), (x2, y2)", where A turns pairs of coordinates and does nothing else.
template <class = void>  // compiled only where it is called
std::string turned_pairs(const Eigen::MatrixXd& A, const Shooting& of) {
  std::string pairs;
  const Eigen::Index n = A.rows();
  std::vector<Eigen::Index> other(static_cast<std::size_t>(n), -1);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      if (A(i, j) == 0.0) continue;
      if (i == j || other[static_cast<std::size_t>(i)] >= 0 || !(A(i, j) * A(j, i) < 0.0)) return "";
      other[static_cast<std::size_t>(i)] = j;
      if (i < j) pairs += sentence({pairs.empty() ? "(" : ", (", of.name(i), ", ", of.name(j), ")"});
    }
  return pairs;
}

// "translation of x1, 2 x2 and its momentum"
template <class = void>  // compiled only where it is called
std::string name_of_symmetry(const AffineSymmetry& symmetry, const Shooting& of) {
  const bool shifts = symmetry.A.isZero(0.0);
  const std::string pairs = shifts ? "" : turned_pairs(symmetry.A, of);
  if (!pairs.empty()) return sentence({"rotation of ", pairs, " and its angular momentum"});
  std::string moved;
  for (Eigen::Index i = 0; i < symmetry.b.size(); ++i) {
    if (symmetry.b[i] == 0.0 && symmetry.A.row(i).isZero(0.0)) continue;
    if (!moved.empty()) moved += ", ";
    if (shifts && symmetry.b[i] != 1.0) moved += symmetry.b[i] == -1.0 ? "-" : sentence({{symmetry.b[i], 6}, " "});
    moved += of.name(i);
  }
  return sentence({shifts ? "translation of " : "linear symmetry of ", moved, shifts ? " and its momentum" : " and its integral"});
}

// The condition's rows at states, for Â, b̂, ĝ with A_ij = Â_ij/(P_i s_j), ξ(x) = b = b̂/P and g = ĝ/s: all of them rates. No Â unless there is room.
template <class = void>  // compiled only where it is called
Eigen::MatrixXd symmetry_conditions(const Neighbourhood& within, const std::vector<StateWithMomenta>& states, const Eigen::VectorXd& P, bool turns) {
  const Eigen::Index n = P.size(), entries = turns ? n * n : 0;
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(states.size()), entries + 2 * n);
  for (Eigen::Index k = 0; k < rows.rows(); ++k) {
    const StateWithMomenta& s = states[static_cast<std::size_t>(k)];
    for (Eigen::Index i = 0; i < n; ++i) {
      rows(k, entries + i) = s.pdot[i] / P[i];
      rows(k, entries + n + i) = -s.xdot[i] / within.scale[i];
      for (Eigen::Index j = 0; turns && j < n; ++j)
        rows(k, i * n + j) = (s.pdot[i] * (s.x[j] - within.x[j]) + s.p[i] * s.xdot[j]) / (P[i] * within.scale[j]);
    }
    const double largest = rows.row(k).cwiseAbs().maxCoeff();
    if (largest > 0.0) rows.row(k) /= largest;
  }
  return rows;
}

// The field of a row of the kernel, with the coefficient that begins it 1 and others rounded to twelfths.
template <class = void>  // compiled only where it is called
AffineSymmetry symmetry_of_row(const Neighbourhood& within, const Eigen::VectorXd& P, const Eigen::VectorXd& row) {
  constexpr double negligible = 1e-7;
  const Eigen::Index n = P.size(), entries = row.size() - 2 * n;
  const double largest = row.cwiseAbs().maxCoeff();
  double first = 0.0;
  const auto entry = [&](Eigen::Index k, double unit) {
    if (std::abs(row[k]) <= negligible * largest) return 0.0;
    const double value = row[k] / unit;
    if (first == 0.0) first = value;
    const double twelfths = std::round(12.0 * (value / first)) / 12.0;
    return twelfths != 0.0 && std::abs(value / first - twelfths) <= negligible ? twelfths : value / first;
  };
  AffineSymmetry symmetry{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n)};
  for (Eigen::Index k = 0; k < entries; ++k) symmetry.A(k / n, k % n) = entry(k, P[k / n] * within.scale[k % n]);
  for (Eigen::Index i = 0; i < n; ++i) symmetry.b[i] = entry(entries + i, P[i]);
  for (Eigen::Index i = 0; i < n; ++i) symmetry.g[i] = entry(entries + n + i, within.scale[i]);
  symmetry.name = name_of_symmetry(symmetry, within.of);
  return symmetry;
}

// Symmetries of the equations in a neighbourhood, the simple ones first; none where too few of its states have a model.
template <class = void>  // compiled only where it is called
std::vector<AffineSymmetry> symmetries_in(const Neighbourhood& within) {
  constexpr Eigen::Index most_that_turn = 12;
  constexpr double negligible = 1e-10, begins = 1e-8;  // momenta are differenced to some 1e-12
  const Eigen::Index n = within.x.size() / 2, entries = n <= most_that_turn ? n * n : 0;
  const auto enough = static_cast<std::size_t>(entries + 3 * n + 8);
  std::vector<StateWithMomenta> states;
  Eigen::VectorXd P = Eigen::VectorXd::Zero(n);
  for (int sample = 1; states.size() < enough && sample <= static_cast<int>(2 * enough); ++sample) {
    std::optional<StateWithMomenta> s = scattered_state(within, sample);
    if (!s) continue;
    P = P.cwiseMax(s->p.cwiseAbs());
    states.push_back(std::move(*s));
  }
  if (states.size() < enough) return {};
  for (Eigen::Index i = 0; i < n; ++i) P[i] = P[i] > 0.0 ? P[i] : 1.0;
  const Eigen::MatrixXd rows = symmetry_conditions(within, states, P, entries > 0);
  Eigen::MatrixXd kernel = shortest_step(rows, Eigen::VectorXd::Zero(rows.rows()), negligible).open.transpose();
  for (Eigen::Index k = 0; k < kernel.rows(); ++k)  // b is the field at q = 0 from here on
    for (Eigen::Index m = 0; m < entries; ++m) kernel(k, entries + m / n) -= kernel(k, m) * within.x[m % n] / within.scale[m % n];
  reduce_rows(kernel, begins);
  std::vector<AffineSymmetry> found;
  for (Eigen::Index k = 0; k < kernel.rows(); ++k) {
    const Eigen::VectorXd row = kernel.row(k);
    if (row.head(entries + n).cwiseAbs().maxCoeff() > begins * row.cwiseAbs().maxCoeff()) found.push_back(symmetry_of_row(within, P, row));
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const AffineSymmetry& a, const AffineSymmetry& c) { return (a.A.array() != 0.0).count() < (c.A.array() != 0.0).count(); });
  return found;
}

// ∂I/∂x of each symmetry in units of `scale`, a column each; along constraints.
template <class = void>  // compiled only where it is called
Eigen::MatrixXd integral_slopes(const Neighbourhood& at, const std::vector<AffineSymmetry>& symmetries) {
  const Eigen::Index N = at.x.size(), count = static_cast<Eigen::Index>(symmetries.size());
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(N, count);
  for (Eigen::Index i = 0; count > 0 && i < N; ++i) {
    const std::optional<Eigen::VectorXd> slope = slope_at_zero([&](double s) {
      Eigen::VectorXd nearby = at.x;
      nearby[i] += s * at.scale[i];
      nearby = at.of.settled(nearby, at.parameter);
      const Eigen::VectorXd p = at.of.momenta(nearby, at.parameter, 0.0);
      Eigen::VectorXd integrals(count);
      for (Eigen::Index k = 0; k < count; ++k) integrals[k] = symmetries[static_cast<std::size_t>(k)].integral(nearby, p);
      return integrals;
    }, 1.0);
    if (slope) slopes.row(i) = *slope;
  }
  return slopes;
}

}  // namespace qdot::detail
