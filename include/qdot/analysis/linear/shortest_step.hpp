#pragma once
// SPDX-License-Identifier: MIT
//
// The shortest solution of linear equations in the sense of least squares, and what they leave open.
//
// Rotations of two columns at a time make the columns of A V normal to each other (Hestenes, 1958): A V = U Σ. Then
//
//     x = V Σ⁺ Uᵀ b ,       A v = 0 for each column v of V whose σ is negligible ,       (AᵀA)⁺ = V Σ⁺² Vᵀ .
//
// The singular values of so small a matrix come out to rounding, and plain loops cost the compiler nothing.

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>

namespace qdot::detail {

struct ShortestStep {
  Eigen::VectorXd x;
  Eigen::MatrixXd open;          // orthonormal columns
  Eigen::MatrixXd determined{};  // columns v/σ of the others
};

// @param negligible  singular values below that part of the largest count as zero
template <class = void>  // compiled only where it is called
ShortestStep shortest_step(Eigen::MatrixXd A, const Eigen::VectorXd& b, double negligible) {
  const Eigen::Index m = A.rows(), n = A.cols();
  Eigen::MatrixXd V = Eigen::MatrixXd::Identity(n, n);
  const auto turn = [](double* a, double* b2, Eigen::Index count, double c, double s) {
    for (Eigen::Index i = 0; i < count; ++i) {
      const double first = a[i];
      a[i] = c * first - s * b2[i];
      b2[i] = s * first + c * b2[i];
    }
  };
  const auto product = [m](const double* a, const double* b2) {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < m; ++i) sum += a[i] * b2[i];
    return sum;
  };
  constexpr int most_sweeps = 60;
  bool turned = true;
  for (int sweep = 0; turned && sweep < most_sweeps; ++sweep) {
    turned = false;
    for (Eigen::Index j = 0; j < n; ++j)
      for (Eigen::Index k = j + 1; k < n; ++k) {
        double *const a = A.data() + m * j, *const c = A.data() + m * k;
        const double aa = product(a, a), cc = product(c, c), ac = product(a, c);
        if (!(std::abs(ac) > std::numeric_limits<double>::epsilon() * std::sqrt(aa * cc))) continue;
        turned = true;
        const double zeta = (cc - aa) / (2.0 * ac);
        const double tangent = (zeta >= 0.0 ? 1.0 : -1.0) / (std::abs(zeta) + std::sqrt(1.0 + zeta * zeta));
        const double cosine = 1.0 / std::sqrt(1.0 + tangent * tangent), sine = cosine * tangent;
        turn(a, c, m, cosine, sine);
        turn(V.data() + n * j, V.data() + n * k, n, cosine, sine);
      }
  }
  Eigen::VectorXd square(n);
  double largest = 0.0;
  for (Eigen::Index j = 0; j < n; ++j) {
    square[j] = product(A.data() + m * j, A.data() + m * j);
    largest = std::max(largest, square[j]);
  }
  ShortestStep result{Eigen::VectorXd::Zero(n), Eigen::MatrixXd(n, n), Eigen::MatrixXd(n, n)};
  Eigen::Index open = 0;
  for (Eigen::Index j = 0; j < n; ++j) {
    if (!(square[j] > negligible * negligible * largest)) {
      for (Eigen::Index i = 0; i < n; ++i) result.open(i, open) = V(i, j);
      ++open;
      continue;
    }
    const double weight = product(A.data() + m * j, b.data()) / square[j];
    for (Eigen::Index i = 0; i < n; ++i) {
      result.x[i] += weight * V(i, j);
      result.determined(i, j - open) = V(i, j) / std::sqrt(square[j]);
    }
  }
  result.open.conservativeResize(n, open);
  result.determined.conservativeResize(n, n - open);
  return result;
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template ShortestStep shortest_step<void>(Eigen::MatrixXd, const Eigen::VectorXd&, double);
#endif

}  // namespace qdot::detail
