#pragma once
// SPDX-License-Identifier: MIT
//
// The linear-quadratic regulator
// ==============================
//
//     ∫ (xᵀQ x + uᵀR u) dt = min ,      u = −K x ,   K = R⁻¹BᵀP ,      AᵀP + P A − P B R⁻¹Bᵀ P + Q = 0 ,   P ≥ 0
//
// Of all controls u(t) that bring ẋ = A x + B u to rest, the cheapest is this constant feedback. P solves Riccati's
// equation, and is read off the invariant subspace of
//     H = [  A   −B R⁻¹Bᵀ ]
//         [ −Q   −Aᵀ      ]
// that belongs to its N exponents with negative real part, those of the closed loop A − B K. With an ordered Schur form
// H = U T Uᴴ and U's left half [U₁; U₂], P = U₂ U₁⁻¹ (Laub, IEEE Trans. Autom. Control 24, 1979).
//
// P exists if every mode that does not decay by itself can be reached by some input, and shows in Q unless it grows. A
// mode for which that does not hold is refused by name.

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <string>
#include <type_traits>

#include <Eigen/Core>
#include <Eigen/Jacobi>
#include <Eigen/LU>

#include "qdot/analysis/damped_modes.hpp"
#include "qdot/analysis/linear/exponents.hpp"
#include "qdot/error.hpp"

namespace qdot {

/// The feedback u = −K x and what it does.
struct Lqr {
  Eigen::MatrixXd K;           ///< inputs×N
  Eigen::MatrixXd P;           ///< N×N, symmetric: xᵀP x is the cost of bringing x to rest
  Eigen::VectorXcd exponents;  ///< closed-loop poles, the exponents of A − B K, sorted by imaginary, then by real part
  double residual = 0.0;       ///< of Riccati's equation, relative to its largest term
};

namespace detail {

template <class Matrix>
void require_shape(const char* name, const Matrix& matrix, Eigen::Index rows, Eigen::Index columns) {
  if (matrix.rows() != rows || matrix.cols() != columns)
    throw DimensionError(sentence({"lqr: ", name, ", ", rows, " by ", columns, ","}),
                         static_cast<long>(rows * columns), static_cast<long>(matrix.size()),
                         sentence({"it is ", matrix.rows(), " by ", matrix.cols()}));
  if (!matrix.allFinite())
    throw_invalid_value(
        {"lqr: ", name, " must be finite, but it has NaN or infinity in it; give every entry a number"});
}

// Lowest eigenvalue of a weight that must be symmetric.
template <class Matrix>
double lowest_weight(const char* name, const Matrix& weight) {
  const double off = (weight - weight.transpose()).cwiseAbs().maxCoeff();
  if (off > 1e-12 * weight.norm())
    throw_invalid_value({"lqr: ",
                         name,
                         " must be symmetric, but it differs from its transpose by ",
                         {off, 6},
                         "; give half the sum of both"});
  return exponents_of(weight).lambda.real().minCoeff();
}

template <class Matrix>
Matrix real_solution(const Matrix& A, const Matrix& B) {
  const Eigen::MatrixXcd X = Eigen::FullPivLU<Eigen::MatrixXcd>(Eigen::MatrixXcd(A.template cast<ComplexNumber>()))
                                 .solve(Eigen::MatrixXcd(B.template cast<ComplexNumber>()));
  return X.real();
}

// Hautus' test: every mode that does not decay is reached by an input. Of a map x ↦ A x those last whose multipliers do not lie inside the circle.
template <class Matrix, class Name>
void require_stabilizable(const Matrix& A, const Matrix& B, const Name& name, bool of_map = false) {
  const Exponents all = exponents_of(A);
  const Eigen::Index n = A.rows(), inputs = B.cols();
  Matrix in_scale = all.scale.cwiseInverse().asDiagonal() * B;
  if (const double reach = in_scale.cwiseAbs().maxCoeff(); reach > 0.0) in_scale *= std::max(all.size, 1e-300) / reach;
  for (Eigen::Index k = 0; k < n; ++k) {
    const ComplexNumber lambda = all.lambda[k];
    if ((of_map ? std::abs(lambda) - 1.0 : lambda.real()) < -all.radius[k]) continue;
    Eigen::MatrixXcd both(n + inputs, n);  // [A − λ, B]ᴴ
    both << all.balanced.transpose().template cast<ComplexNumber>(), in_scale.transpose().template cast<ComplexNumber>();
    both.diagonal().array() -= std::conj(lambda);
    Eigen::FullPivLU<Eigen::MatrixXcd> factors(both);
    factors.setThreshold(1e-10);
    if (factors.rank() == n) continue;
    const Eigen::MatrixXcd unreached = factors.kernel();
    Eigen::Index most = 0;
    unreached.col(0).cwiseAbs().maxCoeff(&most);
    throw_invalid_value(
        {"lqr: every mode that does not decay by itself must be reached by an input, but that with the ",
         of_map ? "multiplier " : "exponent ",
         {lambda.real(), 6},
         lambda.imag() < 0.0 ? " - " : " + ",
         {std::abs(lambda.imag()), 6},
         "i is not, most of it in ",
         name(most),
         "; add an input that moves it, or take it out of the model"});
  }
}

// Brings the eigenvalues with negative real part to the front of a Schur form U T Uᴴ, one exchange of neighbours after
// the other.
template <class Matrix>
Eigen::Index stable_first(Matrix& T, Matrix& U) {
  Eigen::Index stable = 0;
  for (Eigen::Index i = 0; i < T.rows(); ++i) {
    if (!(T(i, i).real() < 0.0)) continue;
    for (Eigen::Index k = i; k > stable; --k) {
      Eigen::JacobiRotation<ComplexNumber> rotation;
      rotation.makeGivens(T(k - 1, k), T(k, k) - T(k - 1, k - 1));
      T.applyOnTheLeft(k - 1, k, rotation.adjoint());
      T.applyOnTheRight(k - 1, k, rotation);
      U.applyOnTheRight(k - 1, k, rotation);
      T(k, k - 1) = 0.0;
    }
    ++stable;
  }
  return stable;
}

template <class Matrix>
void require_costs(const Matrix& A, const Matrix& B, const Matrix& Q, const Matrix& R) {
  const Eigen::Index n = A.rows();
  require_shape("A", A, n, n);
  require_shape("B", B, n, B.cols());
  require_shape("Q", Q, n, n);
  require_shape("R", R, B.cols(), B.cols());
  if (n == 0 || B.cols() == 0)
    throw InvalidValue(
        "lqr: there must be a state and an input, but one of them is missing; give the linearization an input");
  const double lowest_Q = lowest_weight("Q", Q), lowest_R = lowest_weight("R", R);
  if (!(lowest_R > 1e-14 * R.norm()))
    throw_invalid_value({"lqr: R must be positive definite, but its lowest eigenvalue is ",
                         {lowest_R, 6},
                         "; give every input a cost"});
  if (!(lowest_Q >= -1e-12 * Q.norm()))
    throw_invalid_value({"lqr: Q must not be negative, but its lowest eigenvalue is ",
                         {lowest_Q, 6},
                         "; give no deviation a negative cost"});
}

template <class Matrix, class Name>
Lqr lqr_of(const Matrix& A, const Matrix& B, const Matrix& Q, const Matrix& R, const Name& name) {
  const Eigen::Index n = A.rows();
  require_costs(A, B, Q, R);
  require_stabilizable(A, B, name);

  const Matrix Bt = B.transpose(), At = A.transpose(), RinvBt = real_solution(R, Bt), spread = B * RinvBt;
  // One number makes both blocks beside the diagonal alike: (x, μ) → (x, sμ).
  const double above = spread.norm(), below = Q.norm();
  const double s = below > 0.0 && above > 0.0 ? std::exp2(std::round(0.5 * std::log2(below / above))) : 1.0;
  Matrix H(2 * n, 2 * n);
  H << A, -s * spread, -Q / s, -At;
  SchurForm<Eigen::MatrixXcd> schur(H.template cast<ComplexNumber>());
  const double size = H.norm(), nearest = std::min(size, schur.T.diagonal().real().cwiseAbs().minCoeff());
  Lqr result;
  if (stable_first(schur.T, schur.U) == n && nearest > 1e-9 * size) {
    const Eigen::MatrixXcd U1t = schur.U.topLeftCorner(n, n).transpose(), U2t = schur.U.bottomLeftCorner(n, n).transpose();
    const Matrix Pt = Eigen::FullPivLU<Eigen::MatrixXcd>(U1t).solve(U2t).real();
    result.P = 0.5 * s * (Pt + Pt.transpose());
    result.K = RinvBt * result.P;
    const Matrix feedback = B * result.K, quadratic = result.P * feedback, linear = result.P * A, other = At * result.P;
    result.residual = (linear + other - quadratic + Q).norm() / std::max({2.0 * linear.norm(), quadratic.norm(), Q.norm(), 1e-300});
    result.exponents = sorted_exponents(exponents_of(Matrix(A - feedback)).lambda);
    const double slowest = std::max(-size, result.exponents.real().maxCoeff());
    if (result.residual <= 1e-8 && slowest < 0.0) return result;
    throw_invalid_value({"lqr: Riccati's equation must be solved to 1e-8, but its residual is ",
                         {result.residual, 6},
                         " and the slowest closed-loop exponent ",
                         {slowest, 6},
                         "; scale x, u, Q and R so that they are of like size"});
  }
  throw_invalid_value({"lqr: every mode that lasts must show in Q, but the optimal loop would leave an exponent ",
                       {nearest, 6},
                       " from the imaginary axis; give its coordinate a cost in Q"});
}

}  // namespace detail

/// The linear-quadratic regulator of ẋ = A x + B u.
///
/// O(N³).
///
/// @param A, B  N×N and N×inputs
/// @param Q     cost of deviations, N×N, symmetric, no negative eigenvalue
/// @param R     cost of inputs, symmetric, positive definite
/// @throws InvalidValue    when R is not positive definite, Q has a negative eigenvalue, a mode that lasts is not reached by an input or not seen by Q, or the
///                         solution has fewer than eight digits
/// @throws DimensionError  when sizes disagree
template <class MatrixXd = Eigen::MatrixXd>  // compiled only where it is called
Lqr lqr(const std::type_identity_t<MatrixXd>& A, const std::type_identity_t<MatrixXd>& B,
        const std::type_identity_t<MatrixXd>& Q, const std::type_identity_t<MatrixXd>& R) {
  return detail::lqr_of(A, B, Q, R, [](Eigen::Index i) { return "x" + std::to_string(i); });
}

/// The regulator of a linearization at an equilibrium or a steady motion: u − u₀ = −K x.
///
/// @throws as above; and InvalidValue when the state does not stay
template <class L, class MatrixXd = Eigen::MatrixXd>
  requires std::is_same_v<L, Linearization>
Lqr lqr(const L& linear, const std::type_identity_t<MatrixXd>& Q, const std::type_identity_t<MatrixXd>& R) {
  detail::require_staying(linear, "lqr");
  return detail::lqr_of(linear.A, linear.B, Q, R,
                        [&](Eigen::Index i) { return linear.states[static_cast<std::size_t>(i)]; });
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template Lqr lqr<Eigen::MatrixXd>(const Eigen::MatrixXd&, const Eigen::MatrixXd&, const Eigen::MatrixXd&, const Eigen::MatrixXd&);
extern template Lqr lqr<Linearization, Eigen::MatrixXd>(const Linearization&, const Eigen::MatrixXd&, const Eigen::MatrixXd&);
#endif

// Old names, accepted until 0.4.

using Regulator [[deprecated("qdot: say Lqr")]] = Lqr;

/// lqr() by its old name.
template <class MatrixXd = Eigen::MatrixXd>  // compiled only where it is called
[[deprecated("qdot: say lqr()")]]
Lqr regulator(const std::type_identity_t<MatrixXd>& A, const std::type_identity_t<MatrixXd>& B,
              const std::type_identity_t<MatrixXd>& Q, const std::type_identity_t<MatrixXd>& R) {
  return lqr(A, B, Q, R);
}
template <class L, class MatrixXd = Eigen::MatrixXd>
  requires std::is_same_v<L, Linearization>
[[deprecated("qdot: say lqr()")]]
Lqr regulator(const L& linear, const std::type_identity_t<MatrixXd>& Q, const std::type_identity_t<MatrixXd>& R) {
  return lqr(linear, Q, R);
}

}  // namespace qdot
