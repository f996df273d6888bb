#pragma once
// SPDX-License-Identifier: MIT
//
// The impulses of impact.hpp. A program that links qdot::compiled has them from there.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "qdot/effects/impact.hpp"
#include "qdot/effects/rows/bounded_minimum.hpp"

namespace qdot::detail {

// The shortest x ≥ lower with A x + b ≥ 0 and (x − lower)ᵀ(A x + b) = 0, for a symmetric positive semidefinite A.
//
// @throws NoImpulse  when there is none
template <class = void>  // compiled only where it is called
Eigen::VectorXd complementary(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, const Eigen::VectorXd& lower) {
  const Eigen::Index k = b.size();
  const Eigen::VectorXd q = A * lower + b;
  Eigen::VectorXd length(k);
  for (Eigen::Index i = 0; i < k; ++i) length[i] = A(i, i) > 0 ? std::sqrt(A(i, i)) : 1.0;
  BoundedMinimum p;
  p.A = A;
  p.b = q;
  for (Eigen::Index i = 0; i < k; ++i) {
    p.b[i] /= length[i];
    for (Eigen::Index j = 0; j < k; ++j) p.A(i, j) /= length[i] * length[j];
  }
  p.relative = 1e-13;
  p.size = Eigen::VectorXd::Constant(k, p.b.cwiseAbs().maxCoeff());
  p.lower = Eigen::VectorXd::Zero(k);
  p.upper = Eigen::VectorXd::Constant(k, std::numeric_limits<double>::infinity());
  for (Eigen::Index i = 0; i < k; ++i)
    if (!(A(i, i) > 0)) {
      if (p.b[i] < -p.relative * p.size[i]) throw NoImpulse{i};
      p.upper[i] = 0.0;
    }
  if (!solve(p)) throw NoImpulse{0};
  if (p.contradicting >= 0) throw NoImpulse{p.contradicting};
  std::vector<Eigen::Index> pressed;
  for (Eigen::Index i = 0; i < k; ++i)
    if (p.upper[i] > 0 && std::abs(p.w[i]) <= p.least(i)) pressed.push_back(i);
  if (Eigen::VectorXd x = p.x(pressed); shorten(x, null_space(part_of(p.A, pressed)), p.lower(pressed), p.upper(pressed))) p.x(pressed) = x;
  Eigen::VectorXd result = lower;
  for (Eigen::Index i = 0; i < k; ++i) result[i] += p.x[i] / length[i];
  return result;
}

// The impulses of one blow on contacts that all approach, u < 0.
template <class = void>
Eigen::VectorXd blow(const Eigen::MatrixXd& A, const Eigen::VectorXd& u, const std::vector<ImpactLaw>& laws) {
  const Eigen::Index k = u.size();
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(k);
  Eigen::VectorXd lower = none, target = u, compression = none;
  if (std::any_of(laws.begin(), laws.end(), [](const ImpactLaw& law) { return law.poisson; }))
    compression = complementary(A, u, none);
  for (Eigen::Index i = 0; i < k; ++i) {
    const ImpactLaw& law = laws[static_cast<std::size_t>(i)];
    if (law.poisson) {
      lower[i] = (1 + law.e) * compression[i];
    } else {
      target[i] = (1 + law.e) * u[i];
    }
  }
  Eigen::VectorXd impulse = complementary(A, target, lower);
  // ΔT along the way from compression to the end is a parabola that begins at or below zero.
  const auto gain = [&](const Eigen::VectorXd& L) { return L.dot(u) + 0.5 * L.dot(A * L); };
  if (!compression.isZero(0.0) && gain(impulse) > 0) {
    double low = 0.0, high = 1.0;
    const Eigen::VectorXd expansion = impulse - compression;
    for (int i = 0; i < 60; ++i) (gain(compression + 0.5 * (low + high) * expansion) > 0 ? high : low) = 0.5 * (low + high);
    impulse = compression + low * expansion;
  }
  return impulse;
}

template <class>
Eigen::VectorXd impulses(const Eigen::MatrixXd& A, Eigen::VectorXd& u, const std::vector<ImpactLaw>& laws,
                         const Eigen::VectorXd& still) {
  constexpr int most_blows = 100;
  const Eigen::Index k = u.size();
  Eigen::VectorXd total = Eigen::VectorXd::Zero(k);
  for (int round = 0; round < most_blows; ++round) {
    std::vector<Eigen::Index> struck;
    for (Eigen::Index i = 0; i < k; ++i)
      if (u[i] < -still[i]) struck.push_back(i);
    if (struck.empty()) return total;
    std::vector<ImpactLaw> their_laws;
    for (const Eigen::Index i : struck) their_laws.push_back(laws[static_cast<std::size_t>(i)]);
    Eigen::VectorXd impulse;
    try {
      impulse = blow(A(struck, struck), u(struck), their_laws);
    } catch (const NoImpulse& of) {
      throw NoImpulse{struck[static_cast<std::size_t>(of.contact)]};
    }
    total(struck) += impulse;
    u += A(Eigen::indexing::all, struck) * impulse;
  }
  const Eigen::VectorXd rest = complementary(A, u, Eigen::VectorXd::Zero(k));
  u += A * rest;
  return total + rest;
}

}  // namespace qdot::detail
