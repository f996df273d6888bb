#pragma once
// SPDX-License-Identifier: MIT
//
// The table of Gauss' method with s stages on 0 … 1: nodes cᵢ at the zeros of Legendre's polynomial P_s(2c − 1), weights bᵢ, and the integrals
// aᵢⱼ = ∫₀^{cᵢ} ℓⱼ of Lagrange's polynomials of the nodes. What is integrated has an expansion in Legendre's polynomials, too; the coefficient of the
// highest, Σ bᵢ P_{s−1}(cᵢ) f(cᵢ) times 2s − 1, says whether s nodes are enough for it.

#include <Eigen/Core>
#include <cmath>
#include <utility>

namespace qdot::detail {

struct GaussTable {
  Eigen::VectorXd b, c, highest;  // weights, nodes, P_{s−1} there
  Eigen::MatrixXd a;

  // Nodes by Newton's method on P_s; aᵢⱼ of Legendre's polynomials, so as to be right to rounding.
  explicit GaussTable(int s) : b(s), c(s), highest(s), a(s, s) {
    for (int i = 0; i < s; ++i) {
      double x = -std::cos(3.14159265358979323846 * (i + 0.75) / (s + 0.5)), slope = 1.0;
      const auto evaluate = [&] {
        const auto [p, before] = legendre(s, x);
        slope = s * (x * p - before) / (x * x - 1);
        highest[i] = before;
        return p;
      };
      for (int iteration = 0; iteration < 50; ++iteration) {
        const double change = evaluate() / slope;
        x -= change;
        if (std::abs(change) < 1e-17) break;
      }
      if (2 * i + 1 == s) x = 0.0;
      evaluate();
      c[i] = (1 + x) / 2;
      b[i] = 1 / ((1 - x * x) * slope * slope);
    }
    // ℓⱼ(c) = bⱼ Σ_{m<s} (2m + 1) P_m(cⱼ) P_m(c), and ∫₀^c P_m = (P_{m+1} − P_{m−1})/(2 (2m + 1)) in 2c − 1.
    for (int i = 0; i < s; ++i)
      for (int j = 0; j < s; ++j) {
        const double x = 2 * c[i] - 1, y = 2 * c[j] - 1;
        double sum = c[i];
        for (int m = 1; m < s; ++m) sum += legendre(m, y).first * (legendre(m + 1, x).first - legendre(m - 1, x).first) / 2;
        a(i, j) = b[j] * sum;
      }
  }

  // ℓⱼ(at), on 0 … 1 and beyond.
  double lagrange(Eigen::Index j, double at) const {
    double up = 1.0, down = 1.0;
    for (Eigen::Index m = 0; m < c.size(); ++m)
      if (m != j) up *= at - c[m], down *= c[j] - c[m];
    return up / down;
  }

 private:
  // P_degree(x), P_{degree−1}(x).
  static std::pair<double, double> legendre(int degree, double x) {
    double p = 1.0, before = 0.0;
    for (int k = 1; k <= degree; ++k) before = std::exchange(p, ((2 * k - 1) * x * p - (k - 1) * before) / k);
    return {p, before};
  }
};

}  // namespace qdot::detail
