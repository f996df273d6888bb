#pragma once
// SPDX-License-Identifier: MIT
//
// Multipliers of an orbit, the trivial ones taken out.
//
// M keeps the tangents z of symmetries, M z = z, and the slopes ∇I of what is conserved, ∇I M = ∇I; ẋ and ∇h are a pair of them. Let the columns of b be
// orthonormal and span all ∇I, those of a the z with ∇I z = 0 for all I, and U be normal to both. In the basis [a, U, b] M is a block triangle:
//
//     ⎡ 1  *     * ⎤
//     ⎢ 0  UᵀMU  * ⎥        UᵀMU has the multipliers that are not trivial
//     ⎣ 0  0     1 ⎦
//
// Where integrals are in involution, as total momenta are, a has all z. Where they are not, as the components of an angular momentum L ≠ 0, some z changes
// another integral; it is no part of a, and its multiplier 1 is that of b. On constraints M is that of the tangent space: what they forbid is taken out,
// too. All in units of the extents of the orbit, so that metres and radians do not decide what is normal.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "qdot/analysis/linear/exponents.hpp"
#include "qdot/analysis/linear/shortest_step.hpp"
#include "qdot/analysis/orbit.hpp"

namespace qdot::detail {

// ∂x/∂x with x in units of `scale`, which may have more entries.
template <class = void>  // compiled only where it is called
Eigen::MatrixXd in_units_of(const Eigen::VectorXd& scale, const Eigen::MatrixXd& M) {
  const auto of_x = scale.head(M.rows());
  return of_x.cwiseInverse().asDiagonal() * M * of_x.asDiagonal();
}

// UᵀMU in units of `scale`; `taken` is orthonormal: what is forbidden, b, a.
template <class = void>  // compiled only where it is called
Eigen::MatrixXd without_trivial(const Eigen::MatrixXd& M, const Eigen::VectorXd& scale, const std::vector<Eigen::VectorXd>& taken) {
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(taken.size()), M.rows());
  for (Eigen::Index i = 0; i < rows.rows(); ++i) rows.row(i) = taken[static_cast<std::size_t>(i)];
  const Eigen::MatrixXd U = shortest_step(rows, Eigen::VectorXd::Zero(rows.rows()), 0.5).open;  // all singular values are 1 or 0
  const Eigen::MatrixXd right = in_units_of(scale, M).lazyProduct(U);
  return U.transpose().lazyProduct(right);
}

// A tangent and a slope that M keeps, in units of the extents.
struct KeptPair {
  Eigen::VectorXd tangent, slope;  // the slope is empty where nothing is conserved
  std::string name;
};

// What is taken out of M, orthonormal in units of `scale`: what constraints forbid, then b and a.
template <class = void>  // compiled only where it is made
struct BasicTrivialDirections {
  std::vector<Eigen::VectorXd> taken{};
  std::size_t ones = 0;  // the last of them, with the multiplier 1
  bool conserves_energy = false;
  std::vector<std::string> symmetries{};  // that give them

  // Takes out b and a of these pairs; one that lies in the span of those before it is not named.
  void take(const std::vector<KeptPair>& pairs) {
    const std::size_t first = taken.size();
    std::vector<Eigen::VectorXd> z;
    for (const KeptPair& pair : pairs) {
      const bool moves = extend(z, pair.tangent), conserves = pair.slope.size() > 0 && extend(taken, pair.slope);
      if (moves || conserves) symmetries.push_back(pair.name);
    }
    const std::size_t behind = taken.size();
    Eigen::MatrixXd changes(static_cast<Eigen::Index>(behind - first), static_cast<Eigen::Index>(z.size()));
    for (Eigen::Index i = 0; i < changes.rows(); ++i)
      for (Eigen::Index j = 0; j < changes.cols(); ++j) {
        const double change = taken[first + static_cast<std::size_t>(i)].dot(z[static_cast<std::size_t>(j)]);
        changes(i, j) = std::abs(change) > negligible ? change : 0.0;
      }
    const Eigen::MatrixXd still = shortest_step(changes, Eigen::VectorXd::Zero(changes.rows()), negligible).open;
    for (Eigen::Index k = 0; k < still.cols(); ++k) {
      Eigen::VectorXd a = Eigen::VectorXd::Zero(z[0].size());
      for (std::size_t j = 0; j < z.size(); ++j) a += still(static_cast<Eigen::Index>(j), k) * z[j];
      extend(taken, a);
    }
    ones = taken.size() - first;
  }

 private:
  static constexpr double negligible = 1e-6;

  // Adds to an orthonormal basis what a vector has beside it, unless that is negligible.
  static bool extend(std::vector<Eigen::VectorXd>& basis, Eigen::VectorXd v) {
    v /= v.norm();
    for (int pass = 0; pass < 2; ++pass)
      for (const Eigen::VectorXd& each : basis) v -= each.dot(v) * each;
    if (!(v.norm() > negligible)) return false;
    basis.push_back(v / v.norm());
    return true;
  }
};

using TrivialDirections = BasicTrivialDirections<>;

// Multipliers of B, whose entries are as wrong as their difference from those of `coarser`.
template <class = void>  // compiled only where it is called
std::vector<Multiplier> multipliers_of(const Eigen::MatrixXd& B, const Eigen::MatrixXd& coarser, std::size_t trivial) {
  const Exponents all = exponents_of(B);
  const double wrong = in_units_of(all.scale, B - coarser).norm();
  std::vector<Multiplier> multipliers(trivial, Multiplier{1.0, 0.0, true});
  for (Eigen::Index i = 0; i < B.rows(); ++i) {
    const double condition = all.radius[i] / (32.0 * std::numeric_limits<double>::epsilon() * all.size);
    const double moved = std::min(condition * wrong, std::sqrt(wrong * all.size));  // a double one moves by the root
    multipliers.push_back({all.lambda[i], all.radius[i] + (std::isfinite(moved) ? moved : 0.0), false});
  }
  std::sort(multipliers.begin(), multipliers.end(), [](const Multiplier& a, const Multiplier& b) {
    const double larger = std::abs(a.value), smaller = std::abs(b.value);
    return larger != smaller ? larger > smaller : a.value.imag() > b.value.imag();
  });
  return multipliers;
}

template <class = void>  // compiled only where it is called
OrbitStability stability_of(const std::vector<Multiplier>& multipliers) {
  bool on_circle = false, doubtful = false, others = false;
  for (const Multiplier& m : multipliers) {
    if (m.trivial) continue;
    others = true;
    const double size = std::abs(m.value);
    if (size > 1.0 + m.radius) return OrbitStability::unstable;
    if (size < 1.0 - m.radius) continue;
    on_circle = true;
    doubtful = doubtful || std::abs(m.value - 1.0) <= m.radius || std::abs(m.value + 1.0) <= m.radius;
    for (const Multiplier& other : multipliers)
      doubtful = doubtful || (&other != &m && !other.trivial && std::abs(m.value - other.value) <= m.radius + other.radius);
  }
  if (doubtful) return OrbitStability::not_decided;
  return on_circle || !others ? OrbitStability::stable_to_first_order : OrbitStability::asymptotically_stable;
}

}  // namespace qdot::detail
