// SPDX-License-Identifier: MIT
//
// A hanging chain of n links, n known at run time. Its small swings have ω² l/g at the zeros of the Laguerre polynomial
// L_n, and here they come from M and ∂²V/∂q².

#include <cmath>
#include <cstdio>

#include <qdot/analysis/modes.hpp>
#include <qdot/qdot.hpp>

struct Chain {
  double m = 1.0, l = 1.0, g = 9.81;

  template <class S>
  S T(const qdot::Vector<S, qdot::Dynamic>& q, const qdot::Vector<S, qdot::Dynamic>& qdot) const {
    using std::cos, std::sin;
    S vx(0.0), vy(0.0), sum(0.0);  // each bob moves with the one above it, and turns about it
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      vx += l * cos(q[k]) * qdot[k];
      vy += l * sin(q[k]) * qdot[k];
      sum += 0.5 * m * (vx * vx + vy * vy);
    }
    return sum;
  }

  template <class S>
  S V(const qdot::Vector<S, qdot::Dynamic>& q) const {
    using std::cos;
    S y(0.0), sum(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      y -= l * cos(q[k]);
      sum += m * g * y;
    }
    return sum;
  }
};

// L_n(x) by its recurrence (k+1) L_{k+1} = (2k+1−x) L_k − k L_{k−1}.
double laguerre(int n, double x) {
  double before = 1.0, here = 1.0 - x;
  for (int k = 1; k < n; ++k) {
    const double next = ((2 * k + 1 - x) * here - k * before) / (k + 1);
    before = here;
    here = next;
  }
  return here;
}

int main() {
  const Chain chain;
  double worst = 0.0;
  std::printf("n   omega^2 l/g\n");
  for (int n = 1; n <= 8; ++n) {
    const auto system = qdot::mechanical_system(n, chain);
    const auto modes = qdot::normal_modes(system, Eigen::VectorXd::Zero(n));
    std::printf("%d ", n);
    for (const double omega2 : modes.squared_frequencies) {
      const double x = omega2 * chain.l / chain.g;
      std::printf(" %10.7f", x);
      // The distance to the zero is L_n(x)/L_n'(x), and x L_n' = n (L_n − L_{n−1}).
      const double slope = n * (laguerre(n, x) - (n == 1 ? 1.0 : laguerre(n - 1, x))) / x;
      worst = std::max(worst, std::abs(laguerre(n, x) / slope) / x);
    }
    std::printf("\n");
  }
  std::printf("these are the zeros of the Laguerre polynomials L_n: %s\n", worst < 1e-12 ? "to 12 digits" : "NO");
}
