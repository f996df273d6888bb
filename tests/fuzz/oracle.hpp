#pragma once
// SPDX-License-Identifier: MIT
//
// Lagrange's equations by hyperdual numbers: M, rhs, q̈ and λ of a model in quadruple precision, and how far from them double may be.
//
//     Mᵢⱼ = ∂²T/∂q̇ᵢ∂q̇ⱼ ,      rhsᵢ = ∂L/∂qᵢ − (q̇·∂/∂q + ∂/∂t) ∂L/∂q̇ᵢ + Qᵢ
//     point masses:   M = Σ m JᵀJ,   rhs = −Σ m Jᵀ (q̇·∂/∂q + ∂/∂t)² r
//     constraints:    M q̈ − Jᵀλ = rhs,   J q̈ = −(what φ̈ is without q̈)

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include "hyperdual.hpp"

namespace fuzz {

using Quads = std::vector<quad>;
using Hypers = std::vector<Hyper>;

/// A function of q, q̇ and t.
using Function = std::function<Hyper(const Hypers& q, const Hypers& qdot, const Hyper& t)>;

/// Entry i of one of Eigen's vectors, or of one of the standard library's.
template <class Q>
decltype(auto) entry(const Q& q, int i) {
  if constexpr (requires { typename Q::Scalar; }) return q[i];
  else return q[static_cast<std::size_t>(i)];
}

/// A formula and its constants, which belong to somebody else and may change.
struct Term {
  const Formula* formula = nullptr;
  const double* constants = nullptr;
  int n = 0;

  template <class S, class Q, class Qdot, class Time>
  S of(const Q& q, const Qdot& qdot, const Time& t) const {
    return looped<S>(*formula, constants, [&](int i) -> S {
      if (i < n) return S(entry(q, i));
      if (i < 2 * n) return S(entry(qdot, i - n));
      return S(t);
    });
  }
  operator Function() const {
    return [*this](const Hypers& q, const Hypers& qdot, const Hyper& t) { return of<Hyper>(q, qdot, t); };
  }
};

/// A mass at a place; a turning body's angle is a place, and its moment of inertia the mass.
struct Mass {
  double m = 1.0;
  std::vector<Function> place;
};

/// A model as the oracle knows it.
struct Model {
  int n = 1;
  std::vector<Function> T = {}, V = {};  // sums
  std::vector<Mass> masses = {};
  std::vector<Function> rayleigh = {};   // Q = −∂R/∂q̇
  std::function<Quads(const Quads& q, const Quads& qdot, const Quads& z, quad t)> force = {};
  std::function<Quads(const Quads& q, const Quads& qdot, const Quads& z, quad t)> state_rate = {};  // ż of a controller
  std::vector<Function> holonomic = {}, nonholonomic = {};
};

struct Instant {
  Quads q, qdot;
  quad t = 0;
  Quads z = {};
};

/// f at an instant, with derivatives along two directions of (q, q̇, t).
inline Hyper along(const Function& f, const Instant& at, const Quads& a, const Quads& b) {
  const std::size_t n = at.q.size();
  Hypers q(n), qdot(n);
  for (std::size_t i = 0; i < n; ++i) {
    q[i] = Hyper(at.q[i], a[i], b[i]);
    qdot[i] = Hyper(at.qdot[i], a[n + i], b[n + i]);
  }
  return f(q, qdot, Hyper(at.t, a[2 * n], b[2 * n]));
}

struct Equations {
  std::vector<Quads> M, J;
  Quads rhs, gamma, momenta;
  quad T = 0, V = 0;
  quad constraint_velocity = 0;  // largest |φ̇|, |a|
};

inline Equations equations_of(const Model& model, const Instant& at) {
  const auto n = static_cast<std::size_t>(model.n);
  const Quads none(2 * n + 1, 0);
  Quads motion = none;
  for (std::size_t i = 0; i < n; ++i) motion[i] = at.qdot[i];
  motion[2 * n] = 1;
  const auto unit = [&](std::size_t k) {
    Quads e = none;
    e[k] = 1;
    return e;
  };
  Equations e;  // filled one by one: what an aggregate's braces made leaks from g++ 12 where a function throws
  e.M.assign(n, Quads(n, 0));
  e.rhs.assign(n, 0);
  e.momenta.assign(n, 0);
  for (const Function& T : model.T)
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        const quad m = along(T, at, unit(n + i), unit(n + j)).ab;
        e.M[i][j] += m;
        if (j < i) e.M[j][i] += m;
      }
      const Hyper mixed = along(T, at, unit(n + i), motion), slope = along(T, at, unit(i), none);
      e.momenta[i] += mixed.a;
      e.rhs[i] = rounded(e.rhs[i] + (slope.a - mixed.ab));
      if (i == 0) e.T += mixed.v;
    }
  for (const Function& V : model.V)
    for (std::size_t i = 0; i < n; ++i) {
      const Hyper slope = along(V, at, unit(i), none);
      e.rhs[i] = rounded(e.rhs[i] - slope.a);
      if (i == 0) e.V += slope.v;
    }
  for (const Mass& mass : model.masses)
    for (const Function& r : mass.place) {
      const Hyper bend = along(r, at, motion, motion);
      Quads J(n);
      for (std::size_t i = 0; i < n; ++i) J[i] = along(r, at, unit(i), none).a;
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < n; ++j) e.M[i][j] = rounded(e.M[i][j] + mass.m * rounded(J[i] * J[j]));
        e.rhs[i] = rounded(e.rhs[i] - rounded(mass.m * rounded(J[i] * bend.ab)));
        e.momenta[i] = rounded(e.momenta[i] + mass.m * J[i] * bend.a);
      }
      e.T += mass.m * bend.a * bend.a / 2;
    }
  for (const Function& R : model.rayleigh)
    for (std::size_t i = 0; i < n; ++i) e.rhs[i] -= along(R, at, unit(n + i), none).a;
  if (model.force) {
    const Quads Q = model.force(at.q, at.qdot, at.z, at.t);
    for (std::size_t i = 0; i < n; ++i) e.rhs[i] = rounded(e.rhs[i] + Q[i]);
  }
  const auto row = [&](const Function& f, bool of_velocities) {
    Quads J(n);
    for (std::size_t i = 0; i < n; ++i) J[i] = along(f, at, unit(of_velocities ? n + i : i), none).a;
    const Hyper bend = along(f, at, motion, motion);
    e.J.push_back(J);
    e.gamma.push_back(of_velocities ? -bend.a : -bend.ab);
    e.constraint_velocity = std::max(e.constraint_velocity, magnitude(of_velocities ? bend.v : bend.a));
  };
  for (const Function& f : model.holonomic) row(f, false);
  for (const Function& f : model.nonholonomic) row(f, true);
  return e;
}

/// x with A x = b, by Gauss' elimination with full pivots; `pivot` becomes the least one beside the greatest.
inline Quads solved(std::vector<Quads> A, Quads b, quad& least) {
  const std::size_t n = b.size();
  std::vector<std::size_t> column(n);
  for (std::size_t k = 0; k < n; ++k) column[k] = k;
  quad first = 0;
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t r = k, c = k;
    for (std::size_t i = k; i < n; ++i)
      for (std::size_t j = k; j < n; ++j)
        if (magnitude(A[i][j]) > magnitude(A[r][c])) r = i, c = j;
    std::swap(A[k], A[r]);
    std::swap(b[k], b[r]);
    std::swap(column[k], column[c]);
    for (Quads& row : A) std::swap(row[k], row[c]);
    if (k == 0) first = magnitude(A[0][0]);
    least = first > 0 ? magnitude(A[k][k]) / first : quad(0);
    if (least == 0) return Quads(n, 0);
    for (std::size_t i = k + 1; i < n; ++i) {
      const quad f = A[i][k] / A[k][k];
      for (std::size_t j = k; j < n; ++j) A[i][j] -= f * A[k][j];
      b[i] -= f * b[k];
    }
  }
  Quads x(n);
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) b[k] -= A[k][j] * b[j];
    b[k] /= A[k][k];
  }
  for (std::size_t k = 0; k < n; ++k) x[column[k]] = b[k];
  return x;
}

/// The least pivot of M by elimination, each beside its diagonal element: not positive where M is not positive definite.
inline quad least_pivot(std::vector<Quads> M) {
  const std::size_t n = M.size();
  Quads diagonal(n);
  for (std::size_t k = 0; k < n; ++k) diagonal[k] = M[k][k];
  quad least = 1;
  for (std::size_t k = 0; k < n; ++k) {
    if (!(diagonal[k] > 0)) return -1;
    least = std::min(least, M[k][k] / diagonal[k]);
    if (!(M[k][k] > 0)) return least;
    for (std::size_t i = k + 1; i < n; ++i) {
      const quad f = M[i][k] / M[k][k];
      for (std::size_t j = k; j < n; ++j) M[i][j] -= f * M[k][j];
    }
  }
  return least;
}

/// q̈ and, behind it, λ.
struct Motion {
  Quads qddot, lambda;
  quad least = 1;  // pivot
};
inline Motion motion_of(const Equations& e) {
  const std::size_t n = e.rhs.size(), m = e.J.size();
  std::vector<Quads> K(n + m, Quads(n + m, 0));
  Quads right = e.rhs;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) K[i][j] = e.M[i][j];
    for (std::size_t r = 0; r < m; ++r) {
      K[i][n + r] = -e.J[r][i];
      K[n + r][i] = e.J[r][i];
    }
  }
  right.insert(right.end(), e.gamma.begin(), e.gamma.end());
  Motion motion;
  const Quads x = solved(K, right, motion.least);
  motion.qddot.assign(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(n));
  motion.lambda.assign(x.begin() + static_cast<std::ptrdiff_t>(n), x.end());
  return motion;
}
inline Quads accelerations_of(const Model& model, const Instant& at) { return motion_of(equations_of(model, at)).qddot; }

/// A list of numbers and how far off double may be.
struct Known {
  Quads exact;
  double tolerance = 0.0;
};

/// What the library must say at an instant.
struct Verdict {
  enum Demand { numbers, an_error, numbers_or_an_error, nothing } demand = nothing;
  Equations equations;
  Known qddot, M, rhs, momenta, energies, reactions;
  bool stands_on_a_root = false;  // where the derivative may be a limit, which no rule of differentiation finds
};

namespace detail {

inline bool all_finite(const Quads& x) {
  return std::all_of(x.begin(), x.end(), [](quad y) { return is_finite(y); });
}
inline Quads flat(const std::vector<Quads>& M) {
  Quads all;
  for (const Quads& row : M) all.insert(all.end(), row.begin(), row.end());
  return all;
}
inline double largest(const Quads& x) {
  quad size = 0;
  for (const quad y : x) size = std::max(size, magnitude(y));
  return static_cast<double>(size);
}
inline Quads reactions(const Equations& e, const Quads& lambda) {
  Quads force(e.rhs.size(), 0);
  for (std::size_t r = 0; r < lambda.size(); ++r)
    for (std::size_t i = 0; i < force.size(); ++i) force[i] += e.J[r][i] * lambda[r];
  return force;
}

}  // namespace detail

/// Numbers where the model is regular, an error where T or V has no finite value and q̈ none either, or M is not positive definite,
/// nothing where double cannot tell.
inline Verdict verdict_on(const Model& model, const Instant& at) {
  constexpr int samples = 4;
  constexpr double allowance = 1e3, floor = 1e-12;  // times what rounding was seen to do; of the largest number
  constexpr double regular = 1e-10;
  Verdict verdict;
  circumstances.clear();
  circumstances.rounding = 0.0;
  Equations& e = verdict.equations;
  e = equations_of(model, at);
  verdict.stands_on_a_root = circumstances.infinite_slope;
  if (circumstances.at_kink || circumstances.out_of_range) return verdict;
  if (!is_finite(e.T) || !is_finite(e.V)) {
    // A part of V(q, t) that depends on the time alone does not enter q̈; a run looks at it, acceleration() does not.
    if (!detail::all_finite(e.rhs) || !detail::all_finite(detail::flat(e.M))) verdict.demand = Verdict::an_error;
    return verdict;
  }
  if (circumstances.outside_domain || !detail::all_finite(e.rhs) || !detail::all_finite(e.momenta) || !detail::all_finite(detail::flat(e.M)) ||
      !detail::all_finite(e.gamma) || !detail::all_finite(detail::flat(e.J)))
    return verdict;
  const quad pivot = least_pivot(e.M);
  if (pivot < quad(-regular)) {
    if (e.J.empty()) verdict.demand = Verdict::an_error;
    return verdict;
  }
  if (pivot < quad(regular)) return verdict;
  const Motion motion = motion_of(e);
  if (motion.least < quad(regular)) return verdict;
  const auto lists = [](const Equations& of, const Motion& m) {
    return std::vector<Quads>{m.qddot, detail::flat(of.M), of.rhs, of.momenta, Quads{of.T, of.V}, detail::reactions(of, m.lambda)};
  };
  const std::vector<Quads> exact = lists(e, motion);
  Known* const known[] = {&verdict.qddot, &verdict.M, &verdict.rhs, &verdict.momenta, &verdict.energies, &verdict.reactions};
  double worst = 0.0;
  for (std::size_t k = 0; k < exact.size(); ++k) *known[k] = {exact[k], 1e-290};
  // What is zero because the forces are in balance, is so to their rounding.
  if (!e.J.empty()) verdict.qddot.tolerance = verdict.reactions.tolerance = floor * (1 + detail::largest(e.rhs) + detail::largest(e.gamma));
  for (int sample = 0; sample < samples; ++sample) {
    circumstances.rounding = 0x1p-52;
    const Equations off = equations_of(model, at);
    circumstances.rounding = 0.0;
    const std::vector<Quads> seen = lists(off, motion_of(off));
    for (std::size_t k = 0; k < exact.size(); ++k) {
      const double size = detail::largest(exact[k]);
      Quads difference = seen[k];
      for (std::size_t i = 0; i < difference.size(); ++i) difference[i] -= exact[k][i];
      const double spread = detail::largest(difference);
      known[k]->tolerance = std::max(known[k]->tolerance, allowance * spread + floor * size);
      if (size > 0 && (k == 0 || k == 1)) worst = std::max(worst, spread / size);
    }
  }
  if (circumstances.at_kink || !(worst < 1e-7)) return verdict;
  verdict.demand = Verdict::numbers;
  return verdict;
}

/// ∂q̈/∂q and ∂q̈/∂q̇ by central differences over h, a column for each of q and then q̇. Roundings, if there are any, are the same on both
/// sides, so that those of the derivative are left.
inline std::vector<Quads> acceleration_slopes(const Model& model, const Instant& at, quad h) {
  const Dice dice = circumstances.dice;
  const auto n = static_cast<std::size_t>(model.n);
  std::vector<Quads> columns;
  for (std::size_t j = 0; j < 2 * n; ++j) {
    Instant up = at, down = at;
    (j < n ? up.q[j] : up.qdot[j - n]) += h;
    (j < n ? down.q[j] : down.qdot[j - n]) -= h;
    circumstances.dice = dice;
    Quads slope = accelerations_of(model, up);
    circumstances.dice = dice;
    const Quads low = accelerations_of(model, down);
    for (std::size_t i = 0; i < n; ++i) slope[i] = (slope[i] - low[i]) / (2 * h);
    columns.push_back(slope);
  }
  return columns;
}

}  // namespace fuzz
