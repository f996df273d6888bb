#pragma once
// SPDX-License-Identifier: MIT
//
// Coordinates that are cyclic only together.
//
// Two particles that attract each other may be shifted together: L depends on x₁ − x₂, and p₁ + p₂ is conserved where p₁ and p₂ are not.
// A shift in the direction d, the same everywhere, changes L by d·∂L/∂q, so d must be orthogonal to the slopes at all points. It is in the kernel of
// the matrix whose rows are the slopes at scattered points. That is where candidates come from; whether one is right is asked of the formulas
// themselves, with its coefficients rounded to simple fractions.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>

#include "qdot/analysis/linear/echelon.hpp"
#include "qdot/analysis/symmetry/vanishing.hpp"

namespace qdot::detail {

// Rows d with d·g = 0 to rounding at scattered points, for all the vectors g of nodes; in echelon form, so that each begins with a 1.
template <class MatrixXd = Eigen::MatrixXd>  // compiled only where it is called
MatrixXd common_shifts(const formula::Graph& graph, const std::vector<std::vector<int>>& vectors, std::size_t variables) {
  const auto n = static_cast<Eigen::Index>(vectors.front().size());
  int last = 0;
  for (const std::vector<int>& g : vectors) last = std::max(last, *std::max_element(g.begin(), g.end()));
  const int samples = static_cast<int>(2 * n) + 8;
  MatrixXd slopes = MatrixXd::Zero(samples * static_cast<Eigen::Index>(vectors.size()), n);
  Eigen::Index row = 0;
  for (int sample = 0; sample < samples; ++sample) {
    const std::vector<ValueAndMagnitude> all = values_of_graph(graph, last, scattered_point(variables, sample));
    for (const std::vector<int>& g : vectors) {
      double size = 0.0;
      bool is_finite = true;
      for (Eigen::Index i = 0; i < n; ++i) {
        const double value = all[static_cast<std::size_t>(g[static_cast<std::size_t>(i)])].value;
        is_finite = is_finite && std::isfinite(value);
        size = std::max(size, std::abs(value));
        slopes(row, i) = value;
      }
      if (is_finite && size > 0.0)
        slopes.row(row++) /= size;
      else
        slopes.row(row).setZero();
    }
  }
  Eigen::FullPivLU<MatrixXd> factors;
  factors.setThreshold(1e-10);
  factors.compute(slopes);
  if (factors.dimensionOfKernel() == 0) return MatrixXd(0, n);
  MatrixXd d = factors.kernel().transpose();
  reduce_rows(d, 1e-9);
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    const double twelfths = std::round(12.0 * d.data()[i]) / 12.0;
    if (std::abs(d.data()[i] - twelfths) < 1e-8) d.data()[i] = twelfths;
  }
  return d;
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template Eigen::MatrixXd common_shifts<Eigen::MatrixXd>(const formula::Graph&, const std::vector<std::vector<int>>&, std::size_t);
#endif

}  // namespace qdot::detail
