#pragma once
// SPDX-License-Identifier: MIT
//
// A linearization between the ticks of a clock, and its regulator
// ===============================================================
//
//     x_{k+1} = A_d x_k + B_d u_k ,      [ A_d  B_d ]       [ A  B ]
//                                        [  0    1  ] = exp [ 0  0 ] h      (Van Loan, IEEE Trans. Autom. Control 23, 1978)
//
// A digital controller reads x at t_k = k h and holds u until t_{k+1}; this solves ẋ = drift + A x + B u exactly for
// any h. The balanced matrix is halved until Taylor's series of degree 16 is exact to rounding, and the result squared
// as often.
//
//     Σ (xᵀQ x + uᵀR u) = min ,      u = −K x ,      K = (R + BᵀP B)⁻¹ BᵀP A ,      P = AᵀP A − AᵀP B K + Q
//
// with Riccati's discrete equation for P. A first K that stabilizes comes from Q + ‖Q‖ by doubling (Anderson, Int. J.
// Control 28, 1978). Newton's method goes on from there (Hewer, IEEE Trans. Autom. Control 16, 1971).

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <type_traits>

#include <Eigen/Core>

#include "qdot/analysis/linearization.hpp"
#include "qdot/analysis/lqr.hpp"
#include "qdot/error.hpp"

namespace qdot {

/// x_{k+1} = drift + A x_k + B u_k, y = C x + D u: a linearization at the ticks of a clock, with u held between them.
struct SampledLinearization {
  double dt = 0.0;                 ///< time between ticks
  Eigen::MatrixXd A, B, C, D;      ///< N×N, N×inputs, outputs×N, outputs×inputs
  Eigen::VectorXd drift;           ///< what x does by itself from a tick to the next, N
  Linearization linear;            ///< what was sampled, with the names of x and u
};

/// The feedback u = −K x at ticks and what it does.
struct SampledLqr {
  Eigen::MatrixXd K;             ///< inputs×N
  Eigen::MatrixXd P;             ///< N×N, symmetric: xᵀP x is the cost of bringing x to rest
  Eigen::VectorXcd multipliers;  ///< eigenvalues of A − B K, all inside the unit circle, sorted by imaginary, then by real part
  double residual = 0.0;         ///< of Riccati's equation, relative to its largest term
};

namespace detail {

// exp X of a square matrix.
template <class Matrix>
Matrix matrix_exponential(Matrix X) {
  constexpr int degree = 16;
  const Eigen::Index n = X.rows();
  const Eigen::VectorXd scale = balanced_in_place(X);
  const double size = X.size() > 0 ? X.cwiseAbs().rowwise().sum().maxCoeff() : 0.0;
  const int halvings = size > 0.25 ? static_cast<int>(std::ceil(std::log2(size / 0.25))) : 0;
  X *= std::exp2(-halvings);
  Matrix sum = Matrix::Identity(n, n);  // by Horner
  for (int k = degree; k >= 1; --k) sum = Matrix::Identity(n, n) + Matrix(X * sum) / static_cast<double>(k);
  for (int k = 0; k < halvings; ++k) sum = Matrix(sum * sum);
  return scale.asDiagonal() * sum * scale.cwiseInverse().asDiagonal();
}

// Σ (Mᵀ)ᵏ W Mᵏ, of an M whose powers vanish; not finite where they do not.
template <class Matrix>
Matrix sum_of_powers(Matrix M, Matrix W) {
  constexpr int most_doublings = 60;
  for (int k = 0; k < most_doublings; ++k) {
    const Matrix further = M.transpose() * W * M;
    W += further;
    if (!(further.norm() > 1e-17 * W.norm())) break;
    M = Matrix(M * M);
  }
  return W;
}

template <class Matrix, class Name>
SampledLqr sampled_lqr_of(const Matrix& A, const Matrix& B, const Matrix& Q, const Matrix& R, const Name& name) {
  require_costs(A, B, Q, R);
  require_stabilizable(A, B, name, true);
  constexpr int most_steps = 60;
  const Eigen::Index n = A.rows();
  const Matrix one = Matrix::Identity(n, n), At = A.transpose(), Bt = B.transpose(), spread = B * real_solution(R, Bt);
  const auto gain = [&](const Matrix& P) { return real_solution(Matrix(R + Bt * P * B), Matrix(Bt * P * A)); };

  const double some = Q.norm() > 0.0 ? Q.norm() : spread.norm() > 0.0 ? 1.0 / spread.norm() : 1.0;
  Matrix M = A, G = spread, H = Q + some * one;
  for (int k = 0; k < most_steps; ++k) {
    const Matrix through = one + G * H, part = real_solution(through, M), other = real_solution(through, G);
    const Matrix further = M.transpose() * H * part;
    G += M * other * M.transpose();
    M = Matrix(M * part);
    H += further;
    if (!(further.norm() > 1e-12 * H.norm())) break;
  }
  SampledLqr result;
  result.P = 0.5 * (H + H.transpose());
  result.K = gain(result.P);
  for (int k = 0; k < most_steps; ++k) {
    const Matrix P = sum_of_powers(Matrix(A - B * result.K), Matrix(Q + result.K.transpose() * R * result.K));
    const double change = (P - result.P).norm(), size = P.norm();
    if (!std::isfinite(change)) break;
    result.P = 0.5 * (P + P.transpose());
    result.K = gain(result.P);
    if (change <= 1e-14 * size) break;
  }
  const Matrix all = At * result.P * A, taken = At * result.P * B * result.K;
  result.residual = (all - taken + Q - result.P).norm() / std::max({all.norm(), taken.norm(), Q.norm(), 1e-300});
  const Exponents closed = exponents_of(Matrix(A - B * result.K));
  result.multipliers = sorted_exponents(closed.lambda);
  const double slowest = closed.lambda.cwiseAbs().maxCoeff();
  if (!(slowest < 1.0 - 1e-9))
    throw_invalid_value({"lqr: every mode that lasts must show in Q, but the optimal loop would leave a multiplier of ", {slowest, 12},
                         ", at the unit circle; give its coordinate a cost in Q"});
  if (!(result.residual <= 1e-8))
    throw_invalid_value({"lqr: Riccati's equation must be solved to 1e-8, but its residual is ", {result.residual, 6},
                         "; scale x, u, Q and R so that they are of like size, or take longer ticks"});
  return result;
}

}  // namespace detail

/// The linearization at the ticks of a clock, with the inputs held between them: exact for any dt.
///
/// O(N³ log(‖A‖ dt)).
///
/// @param dt  time between ticks, positive
/// @throws InvalidValue  when dt is not positive and finite, A depends on the time, or what grows between two ticks leaves the range of numbers
template <class L>
  requires std::is_same_v<L, Linearization>
SampledLinearization sampled(const L& linear, double dt) {
  if (!(dt > 0.0 && std::isfinite(dt)))
    detail::throw_invalid_value({"sampled: the time between ticks must be positive and finite, but is ", dt, "; give the period of the clock"});
  if (!linear.autonomous)
    throw InvalidValue("sampled: A must be the same at all times, but it changes with t; fix the time, or sample each moment's A by a run with sensitivities");
  const Eigen::Index N = linear.A.rows(), inputs = linear.B.cols();
  Eigen::MatrixXd X = Eigen::MatrixXd::Zero(N + inputs + 1, N + inputs + 1);
  X.topRows(N) << linear.A * dt, linear.B * dt, linear.drift * dt;
  const Eigen::MatrixXd E = detail::matrix_exponential(X);
  if (!E.allFinite())
    detail::throw_invalid_value({"sampled: what grows between two ticks must stay finite, but exp(A dt) is not with dt = ", dt, "; take shorter ticks"});
  return {dt, E.topLeftCorner(N, N), E.block(0, N, N, inputs), linear.C, linear.D, E.topRightCorner(N, 1), linear};
}

/// The linear-quadratic regulator of x_{k+1} = A x_k + B u_k.
///
/// O(N³), some twenty solutions of N equations.
///
/// @param A, B  N×N and N×inputs, of a map from tick to tick
/// @param Q     cost of deviations, N×N, symmetric, no negative eigenvalue
/// @param R     cost of inputs, symmetric, positive definite
/// @throws InvalidValue    when R is not positive definite, Q has a negative eigenvalue, a mode that lasts is not reached by an input, one on the unit circle
///                         does not show in Q, or the solution has fewer than eight digits
/// @throws DimensionError  when sizes disagree
template <class MatrixXd = Eigen::MatrixXd>  // compiled only where it is called
SampledLqr sampled_lqr(const std::type_identity_t<MatrixXd>& A, const std::type_identity_t<MatrixXd>& B, const std::type_identity_t<MatrixXd>& Q,
                       const std::type_identity_t<MatrixXd>& R) {
  return detail::sampled_lqr_of(A, B, Q, R, [](Eigen::Index i) { return "x" + std::to_string(i); });
}

/// The sampled regulator of a linearization at an equilibrium or a steady motion: u_k − u₀ = −K x_k.
///
/// @throws as above; and InvalidValue when the state does not stay
template <class L, class MatrixXd = Eigen::MatrixXd>
  requires std::is_same_v<L, SampledLinearization>
SampledLqr lqr(const L& at_ticks, const std::type_identity_t<MatrixXd>& Q, const std::type_identity_t<MatrixXd>& R) {
  detail::require_staying(at_ticks.linear, "lqr");
  return detail::sampled_lqr_of(at_ticks.A, at_ticks.B, Q, R, [&](Eigen::Index i) { return at_ticks.linear.states[static_cast<std::size_t>(i)]; });
}

// Old names, accepted until 0.4.

using SampledRegulator [[deprecated("qdot: say SampledLqr")]] = SampledLqr;

/// sampled_lqr() by its old name.
template <class MatrixXd = Eigen::MatrixXd>  // compiled only where it is called
[[deprecated("qdot: say sampled_lqr()")]]
SampledLqr sampled_regulator(const std::type_identity_t<MatrixXd>& A, const std::type_identity_t<MatrixXd>& B, const std::type_identity_t<MatrixXd>& Q,
                             const std::type_identity_t<MatrixXd>& R) {
  return sampled_lqr(A, B, Q, R);
}
/// lqr() by its old name.
template <class L, class MatrixXd = Eigen::MatrixXd>
  requires std::is_same_v<L, SampledLinearization>
[[deprecated("qdot: say lqr()")]]
SampledLqr regulator(const L& at_ticks, const std::type_identity_t<MatrixXd>& Q, const std::type_identity_t<MatrixXd>& R) {
  return lqr(at_ticks, Q, R);
}

}  // namespace qdot
