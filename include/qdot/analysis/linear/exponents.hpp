#pragma once
// SPDX-License-Identifier: MIT
//
// Eigenvalues of a real matrix, and how far each is known.
//
// A is balanced by a diagonal matrix of powers of 2 (Osborne; Parlett and Reinsch, Numer. Math. 13, 1969), which
// changes no digit. From the Schur form A = U T Uᴴ the vectors x to the right and y to the left of each eigenvalue
// follow by substitution. It moves by ‖E‖ ‖x‖‖y‖/|y·x| when A changes by E, and rounding changes A by some ε‖A‖. A
// double eigenvalue with one vector has y·x = 0, and moves by √(ε‖A‖ …): there the bound is cut.
//
// One decomposition does for all that is asked here and by the regulator, since each of Eigen's costs the compiler many
// seconds.

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "qdot/ad/vector.hpp"
#include "qdot/error.hpp"

namespace qdot::detail {

using ComplexNumber = std::complex<double>;

struct Exponents {
  Eigen::VectorXcd lambda;
  Eigen::MatrixXcd vectors;  // of A as given, in columns
  Eigen::VectorXd radius;    // λ is known to that
  Eigen::MatrixXd balanced;  // D⁻¹ A D
  Eigen::VectorXd scale;     // D
  double size = 0.0;         // of `balanced`

  bool on_axis(Eigen::Index i) const { return std::abs(lambda[i].real()) <= radius[i]; }
  bool grows(Eigen::Index i) const { return lambda[i].real() > radius[i]; }
};

// d with D⁻¹ A D balanced, D = diag d; A is overwritten by that.
template <class Matrix>
Eigen::VectorXd balanced_in_place(Matrix& A) {
  const Eigen::Index n = A.rows();
  Eigen::VectorXd d = Eigen::VectorXd::Ones(n);
  for (bool changed = true; changed;) {
    changed = false;
    for (Eigen::Index i = 0; i < n; ++i) {
      double row = 0.0, column = 0.0;
      for (Eigen::Index j = 0; j < n; ++j) {
        if (j == i) continue;
        row += A(i, j) * A(i, j);
        column += A(j, i) * A(j, i);
      }
      if (!(row > 0.0 && column > 0.0)) continue;
      const double f = std::exp2(std::round(0.25 * std::log2(row / column)));
      if (f == 1.0 || row / (f * f) + column * f * f > 0.9 * (row + column)) continue;
      for (Eigen::Index j = 0; j < n; ++j) {
        A(j, i) *= f;
        A(i, j) /= f;
      }
      d[i] *= f;
      changed = true;
    }
  }
  return d;
}

// A = U T Uᴴ.
template <class Matrix>
struct SchurForm {
  Matrix T, U;

  explicit SchurForm(const Matrix& A) {
    const Eigen::ComplexSchur<Matrix> schur(A);
    if (!succeeded(schur))
      throw InvalidValue(
          "the exponents of a matrix must be finite, but the QR iteration found none; look for entries that are NaN or "
          "huge");
    T = schur.matrixT();
    U = schur.matrixU();
  }
};

// Vectors of the k-th eigenvalue of an upper triangle, to the right (upwards from k) or to the left (downwards); equal
// eigenvalues are parted by rounding.
template <class Matrix>
Eigen::VectorXcd vector_of_triangle(const Matrix& T, Eigen::Index k, bool right, double smallest) {
  const Eigen::Index n = T.rows();
  Eigen::VectorXcd x = Eigen::VectorXcd::Zero(n);
  x[k] = 1.0;
  for (Eigen::Index step = 1; right ? step <= k : k + step < n; ++step) {
    const Eigen::Index i = right ? k - step : k + step;
    ComplexNumber sum = 0.0;
    for (Eigen::Index j = std::min(i, k); j <= std::max(i, k); ++j)
      if (j != i) sum += (right ? T(i, j) : std::conj(T(j, i))) * x[j];
    ComplexNumber gap = right ? T(i, i) - T(k, k) : std::conj(T(i, i) - T(k, k));
    if (std::abs(gap) < smallest) gap = smallest;
    x[i] = -sum / gap;
  }
  return x / x.cwiseAbs().maxCoeff();
}

template <class Matrix>
Exponents exponents_of(const Matrix& A) {
  const Eigen::Index n = A.rows();
  Exponents result;
  result.balanced = A;
  result.scale = balanced_in_place(result.balanced);
  result.lambda.resize(n);
  result.radius.resize(n);
  if (n == 0) return result;
  result.size = result.balanced.norm();
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  const SchurForm<Eigen::MatrixXcd> schur(Eigen::MatrixXcd(result.balanced.template cast<ComplexNumber>()));
  Eigen::MatrixXcd vectors(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double smallest = std::max(epsilon * result.size, std::numeric_limits<double>::min());
    const Eigen::VectorXcd x = vector_of_triangle(schur.T, i, true, smallest),
                           y = vector_of_triangle(schur.T, i, false, smallest);
    const double condition = x.norm() * y.norm() / std::abs(x[i] * y[i]);  // they share entry i alone
    const double bound = 32.0 * epsilon * result.size * condition;
    result.radius[i] = bound <= 1e-7 * result.size ? bound : 1e-7 * result.size;  // NaN included
    ComplexNumber& lambda = result.lambda[i];
    lambda = schur.T(i, i);
    if (std::abs(lambda.real()) <= result.radius[i]) lambda = {0.0, lambda.imag()};
    if (std::abs(lambda.imag()) <= result.radius[i]) lambda = lambda.real();
    vectors.col(i) = x;
  }
  result.vectors = result.scale.asDiagonal() * (schur.U * vectors);
  // Exponents of a real matrix come in pairs: each below the real axis is made the mirror image of the nearest one
  // above it.
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!(result.lambda[i].imag() < 0.0)) continue;
    Eigen::Index mirror = -1;
    for (Eigen::Index j = 0; j < n; ++j)
      if (result.lambda[j].imag() > 0.0 &&
          (mirror < 0 || std::abs(result.lambda[i] - std::conj(result.lambda[j])) <
                             std::abs(result.lambda[i] - std::conj(result.lambda[mirror]))))
        mirror = j;
    if (mirror >= 0 && std::abs(result.lambda[i] - std::conj(result.lambda[mirror])) <=
                           2.0 * (result.radius[i] + result.radius[mirror]))
      result.lambda[i] = std::conj(result.lambda[mirror]);
  }
  return result;
}

// Whether some exponent on the axis has fewer vectors than its multiplicity.
template <class E>
bool any_drifts(const E& all) {
  const Eigen::Index n = all.lambda.size();
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!all.on_axis(i)) continue;
    ComplexNumber mean = 0.0;
    Eigen::Index count = 0;
    for (Eigen::Index j = 0; j < n; ++j) {
      if (!all.on_axis(j) || std::abs(all.lambda[i] - all.lambda[j]) > 2.0 * (all.radius[i] + all.radius[j])) continue;
      mean += all.lambda[j];
      ++count;
    }
    if (count < 2) continue;
    Eigen::MatrixXcd shifted = all.balanced.template cast<ComplexNumber>();
    for (Eigen::Index j = 0; j < n; ++j) shifted(j, j) -= mean / static_cast<double>(count);
    Eigen::FullPivLU<Eigen::MatrixXcd> factors(shifted);
    factors.setThreshold(1e-11);
    if (factors.dimensionOfKernel() < count) return true;
  }
  return false;
}

template <class Vector>
Vector sorted_exponents(Vector lambda) {
  std::sort(lambda.data(), lambda.data() + lambda.size(), [](const ComplexNumber& a, const ComplexNumber& b) {
    return a.imag() != b.imag() ? a.imag() < b.imag() : a.real() < b.real();
  });
  return lambda;
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template Exponents exponents_of<Eigen::MatrixXd>(const Eigen::MatrixXd&);
extern template bool any_drifts<Exponents>(const Exponents&);
#endif

}  // namespace qdot::detail
