#pragma once
// SPDX-License-Identifier: MIT
//
// Derivatives at a place where they are finite but what they are made of is not.
//
// With r = |q|, the Hessian of r² is 2 everywhere, but at q = 0 it is the sum of 2 r′r′ᵀ and 2 r r″, and r″ is infinite there: 0 · ∞. A spring of rest
// length 0 is one. Where exact derivatives are not finite, they are taken at places beside, in eight directions, so near that
// only what is singular notices. If all agree, that is the derivative; if not, as of r itself, there is none.

#include <functional>

#include <Eigen/Core>

#include "qdot/ad/derivatives.hpp"

namespace qdot::detail {

// J ← its limit at y, of which the entries of q, and after as many of q̇, are moved; false where there is none.
//
// @param slopes_at  (place, J): writes J there; may throw
template <class = void>
[[gnu::cold]] bool slopes_in_the_limit(const Eigen::VectorXd& y, Eigen::Index dof, Eigen::MatrixXd& J,
                                       const std::function<void(const Eigen::VectorXd&, Eigen::MatrixXd&)>& slopes_at);

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

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template bool slopes_in_the_limit<void>(const Eigen::VectorXd&, Eigen::Index, Eigen::MatrixXd&,
                                               const std::function<void(const Eigen::VectorXd&, Eigen::MatrixXd&)>&);
}  // namespace qdot::detail
#else
#include "qdot/mechanics/equations/limit_of_slopes.ipp"
#endif
