#pragma once
// SPDX-License-Identifier: MIT
//
// Small motions about an equilibrium: normal modes and stability
// ==============================================================
//
//     M ẍ + G ẋ + K x = 0        L to second order in the departure x from (q₀, 0), by dual numbers exactly:
//
//     M = ∂²L/∂q̇² ,    K = −∂²L/∂q² (= ∂²V/∂q²)        symmetric: mass and stiffness
//     G = N − Nᵀ ,     N = ∂²L/∂q̇∂q                    antisymmetric: gyroscopic terms, of turning frames and magnetic fields
//
// G is zero wherever T is quadratic in q̇. Then the solutions are n normal modes x = a cos(ωt + α), (K − ω² M) a = 0,
// each an oscillator of its own: aᵢᵀ M aₖ = 0 and aᵢᵀ K aₖ = 0. ω² < 0 grows exponentially, so the equilibrium is
// unstable; along ω² = 0 nothing pulls back. With G, x = a e^{λt} has 2n exponents in pairs ±λ, from (λ² M + λ G + K)
// a = 0. A positive real part is instability; all of them on the imaginary axis is necessary for stability, and not
// sufficient.

#include <algorithm>
#include <cmath>
#include <sstream>
#include <type_traits>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "qdot/analysis/equilibrium.hpp"
#include "qdot/analysis/linear/exponents.hpp"
#include "qdot/analysis/linear/kinks.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/mechanics/mass_matrix.hpp"

namespace qdot {

/// The linear equations M ẍ + G ẋ + K x = 0 about an equilibrium.
template <int n>
struct SmallMotion {
  Matrix<double, n> M;  ///< mass matrix, symmetric
  Matrix<double, n> G;  ///< gyroscopic matrix, antisymmetric; zero for T quadratic in q̇
  Matrix<double, n> K;  ///< stiffness, symmetric
};

namespace detail {

// A system, or that of a scene whose effects are all in its energies.
template <class Model>
const auto& conservative_system(const Model& model) {
  if constexpr (requires { Model::has_forces; })
    static_assert(!Model::has_forces && !Model::has_constraints && !Model::has_states,
                  "qdot: M, G and K alone describe small motions of systems and of scenes that add potentials or terms of L to them; with forces, dampers, controllers or "
                  "constraints ask damped_modes(linearization(scene, equilibrium_near(scene, q))), from analysis/damped_modes.hpp");
  return model.system();
}

// Force i must be nothing beside its terms Σ |K_ij| |q_j|. Where the equilibrium is at zero these are nothing themselves: then K must be the same there,
// stiffness(q) ↦ K, and the force nothing for a displacement of 1.
template <class VectorXd = Eigen::VectorXd, class Stiffness>
void require_equilibrium(const std::type_identity_t<VectorXd>& q, const std::type_identity_t<VectorXd>& slope, const Eigen::MatrixXd& K,
                         const Stiffness& stiffness) {
  constexpr double nothing = 1e-7;
  const VectorXd step = newton_step(K, slope), terms = K.cwiseAbs() * q.cwiseAbs();
  bool balanced = slope.allFinite() && K.allFinite(), at_zero = false;
  for (Eigen::Index i = 0; i < q.size() && balanced; ++i) {
    if (std::abs(slope[i]) <= nothing * terms[i]) continue;
    at_zero = true;
    balanced = std::abs(slope[i]) <= nothing * K.cwiseAbs().maxCoeff();
    for (Eigen::Index j = 0; j < q.size(); ++j)
      if (std::abs(K(i, j) * step[j]) > nothing * terms[i]) balanced = balanced && std::abs(q[j] + step[j]) <= 0.5 * std::abs(step[j]);
  }
  if (balanced && at_zero) {
    const Eigen::MatrixXd there = stiffness(VectorXd(q + step));
    for (Eigen::Index i = 0; i < q.size(); ++i) balanced = balanced && (there - K).row(i).norm() <= nothing * K.row(i).norm();
    balanced = balanced && (K * step + slope).norm() <= 1e-3 * slope.norm();
  }
  if (balanced) return;
  std::ostringstream text;
  text << "small_motion: q must be an equilibrium, but at q = (" << q.transpose() << ") the force dL/dq at rest is ("
       << -slope.transpose() << "); take q from equilibrium_near()";
  throw InvalidValue(text.str());
}

}  // namespace detail

/// M, G and K at an equilibrium of an autonomous system.
///
/// @param model  a system, or a scene whose effects are potentials and terms of L; with forces or constraints see analysis/damped_modes.hpp
/// @param q      the equilibrium, n; equilibrium_near() finds one
/// @throws       InvalidValue when a force at rest is larger than 1e-7 of its terms Σ |K_ij| |q_j|, so that q is none; or
///     when q is on a kink of V or T
template <class Model, class Q, int n = Model::dof_at_compile_time>
SmallMotion<n> small_motion(const Model& model, const Eigen::MatrixBase<Q>& q) {
  const auto& system = detail::conservative_system(model);
  const Vector<double, n> at = q;
  detail::require_sizes(system, at, at);
  const auto U = detail::energy_at_rest(system);
  const Vector<double, n> rest = Vector<double, n>::Zero(at.size());
  const auto momenta_at_rest = [&system](const auto& x) {
    using Position = std::decay_t<decltype(x)>;
    return conjugate_momenta(system, x, Position::Zero(x.size()).eval());
  };
  const Matrix<double, n> N = jacobian(detail::marked<detail::SlopeAtRest>(momenta_at_rest), at);
  const Vector<double, n> slope = gradient(U, at);
  const SmallMotion<n> motion{mass_matrix(system, at, rest), N - N.transpose(), detail::stiffness_at("small_motion", system, U, at, slope)};
  const auto stiffness = [&](const Eigen::VectorXd& x) -> Eigen::MatrixXd { return detail::hessian_or_limit(U, Vector<double, n>(x)); };
  detail::require_equilibrium(at, slope, motion.K, stiffness);
  Eigen::VectorXd y(2 * at.size());
  y << at, rest;
  detail::require_no_kink("small_motion", first_order_form(system), at.size(), 0.0, y);
  return motion;
}

/// Normal modes: K a = ω² M a.
template <int n>
struct NormalModes {
  Vector<double, n> squared_frequencies;  ///< ω², ascending; negative where the equilibrium is unstable
  Matrix<double, n> shapes;               ///< columns a, with shapesᵀ M shapes = E and shapesᵀ K shapes = diag ω²

  /// Angular frequencies ω, ascending.
  ///
  /// @throws InvalidValue when some ω² is negative: that mode grows instead of oscillating
  Vector<double, n> frequencies() const {
    if (squared_frequencies.size() > 0 && squared_frequencies[0] < 0.0)
      detail::throw_invalid_value({"normal modes: frequencies need omega^2 >= 0, but the lowest is ", {squared_frequencies[0], 6},
                                   "; the equilibrium is unstable, look at squared_frequencies"});
    return squared_frequencies.cwiseSqrt();
  }
};

namespace detail {

// Of run-time size, so that every number of coordinates shares one instantiation.
template <class MatrixXd = Eigen::MatrixXd>  // compiled only where it is called
NormalModes<Dynamic> solved_modes(const std::type_identity_t<MatrixXd>& K, const std::type_identity_t<MatrixXd>& M) {
  if (!detail::succeeded(Eigen::LLT<MatrixXd>(M))) {
    throw InvalidValue("normal_modes: the mass matrix must be positive definite at the equilibrium, but it is not; "
                       "choose coordinates that are regular there");
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(K, M);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

template <class MatrixXd = Eigen::MatrixXd>  // compiled only where it is called
Eigen::VectorXcd solved_exponents(const std::type_identity_t<MatrixXd>& K, const std::type_identity_t<MatrixXd>& G, const std::type_identity_t<MatrixXd>& M) {
  const Eigen::Index size = M.rows();
  const Eigen::PartialPivLU<MatrixXd> factor(M);
  MatrixXd first_order = MatrixXd::Zero(2 * size, 2 * size);
  first_order.topRightCorner(size, size).setIdentity();
  first_order.bottomLeftCorner(size, size) = -factor.solve(K);
  first_order.bottomRightCorner(size, size) = -factor.solve(G);
  return sorted_exponents(exponents_of(first_order).lambda);
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template NormalModes<Dynamic> solved_modes<Eigen::MatrixXd>(const Eigen::MatrixXd&, const Eigen::MatrixXd&);
extern template Eigen::VectorXcd solved_exponents<Eigen::MatrixXd>(const Eigen::MatrixXd&, const Eigen::MatrixXd&, const Eigen::MatrixXd&);
#endif

}  // namespace detail

/// The normal modes about an equilibrium of an autonomous system without gyroscopic terms.
///
/// @throws InvalidValue when q is no equilibrium, or G ≠ 0 (then ask for characteristic_exponents)
/// @throws InvalidValue when M is not positive definite there
template <class Model, class Q, int n = Model::dof_at_compile_time>
NormalModes<n> normal_modes(const Model& model, const Eigen::MatrixBase<Q>& q) {
  const SmallMotion<n> motion = small_motion(model, q);
  const double gyroscopic = motion.G.cwiseAbs().maxCoeff();
  const double scale = std::sqrt(motion.M.cwiseAbs().maxCoeff() * motion.K.cwiseAbs().maxCoeff());
  if (gyroscopic > 1e-9 * scale)
    detail::throw_invalid_value({"normal_modes: T must not couple q and qdot linearly, but the gyroscopic matrix has an entry ", {gyroscopic, 6},
                                 "; use characteristic_exponents()"});
  const NormalModes<Dynamic> modes = detail::solved_modes(motion.K, motion.M);
  return {modes.squared_frequencies, modes.shapes};
}

/// The 2n characteristic exponents λ with (λ² M + λ G + K) a = 0, sorted by imaginary, then by real part.
///
/// @throws InvalidValue when q is no equilibrium
template <class Model, class Q>
Eigen::VectorXcd characteristic_exponents(const Model& model, const Eigen::MatrixBase<Q>& q) {
  const auto motion = small_motion(model, q);
  return detail::solved_exponents(motion.K, motion.G, motion.M);
}

}  // namespace qdot
