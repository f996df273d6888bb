#pragma once
// SPDX-License-Identifier: MIT
//
// Derivatives at a place where they are finite but what they are made of is not.
//
// With r = |q|, the Hessian of r² is 2 everywhere, but at q = 0 it is the sum of 2 r′r′ᵀ and 2 r r″, and r″ is infinite there: 0 · ∞. A spring of rest
// length 0 is one. Where exact derivatives are not finite, they are taken at places beside, in eight directions, so near that
// only what is singular notices. If all agree, that is the derivative; if not, as of r itself, there is none.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>

#include <Eigen/Core>

#include "qdot/ad/derivatives.hpp"
#include "qdot/error.hpp"

namespace qdot::detail {

// J ← its limit at y, of which the entries of q, and after as many of q̇, are moved; false where there is none.
//
// @param slopes_at  (place, J): writes J there; may throw
template <class = void>  // compiled only where it is called
[[gnu::cold, gnu::noinline]] bool slopes_in_the_limit(const Eigen::VectorXd& y, Eigen::Index dof, Eigen::MatrixXd& J,
                                                      const std::function<void(const Eigen::VectorXd&, Eigen::MatrixXd&)>& slopes_at) {
  constexpr double beside_zero = 1e-30, beside_others = 0x1p-40, agreement = 1e-6;
  Eigen::VectorXd distance(y.size());
  std::fill_n(distance.data(), distance.size(), 0.0);
  for (const Eigen::Index first : {Eigen::Index(0), dof}) {
    const Eigen::Index end = std::min(first + dof, y.size());
    double least = 0.0;  // of the entries that are not zero
    for (Eigen::Index i = first; i < end; ++i)
      if (y[i] != 0.0 && (least == 0.0 || std::abs(y[i]) < least)) least = std::abs(y[i]);
    for (Eigen::Index i = first; i < end; ++i)
      distance[i] = y[i] != 0.0 ? beside_others * std::abs(y[i]) : least > 0.0 ? beside_others * least : beside_zero;
  }
  std::array<Eigen::MatrixXd, 8> at;
  for (std::size_t k = 0; k < at.size(); ++k) {
    Eigen::VectorXd place = y;
    for (Eigen::Index i = 0; i < y.size(); ++i) {
      const bool opposite = (std::popcount(static_cast<std::uint64_t>(i) & (k / 2)) + static_cast<int>(k)) % 2 != 0;
      const double size = 0.5 + std::fmod(0.618 * static_cast<double>((i + 1)) * static_cast<double>(k / 2 + 1), 1.0);
      place[i] += (opposite ? -size : size) * distance[i];
    }
    try {
      slopes_at(place, at[k]);
    } catch (const Error&) {
      return false;
    }
  }
  J.resize(at[0].rows(), at[0].cols());
  std::fill_n(J.data(), J.size(), 0.0);
  for (Eigen::Index i = 0; i < J.rows(); ++i) {
    double largest = 0.0, apart = 0.0;
    for (Eigen::Index j = 0; j < J.cols(); ++j)
      for (const Eigen::MatrixXd& each : at) {
        if (!std::isfinite(each(i, j))) return false;
        J(i, j) += each(i, j) / static_cast<double>(at.size());
        largest = std::max(largest, std::abs(each(i, j)));
        apart = std::max(apart, std::abs(each(i, j) - at[0](i, j)));
      }
    if (apart > std::max(agreement * largest, beside_zero)) return false;
  }
  return true;
}

// The Hessian of f at x, or its limit; not finite where there is neither.
template <class F, int n>
Matrix<double, n> hessian_or_limit(const F& f, const Vector<double, n>& x) {
  Matrix<double, n> H = hessian(f, x);
  Eigen::MatrixXd limit;
  const auto at = [&f](const Eigen::VectorXd& place, Eigen::MatrixXd& J) { J = hessian(f, Vector<double, n>(place)); };
  if (!H.allFinite() && slopes_in_the_limit(x, x.size(), limit, at)) H = limit;
  return H;
}

}  // namespace qdot::detail
