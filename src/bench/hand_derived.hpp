#pragma once
// SPDX-License-Identifier: MIT
//
// q̈ as an expert derives and writes it, one function per system: every angle's sine and cosine once, every closed form
// simplified, L D Lᵀ written out. These are the baselines of `qdot bench eom`, so they are as fast as we can make them.

#include <cmath>

#include "qdot/ad/unroll.hpp"
#include "qdot/mechanics/equations/block_solve.hpp"
#include "qdot/mechanics/equations/small_solve.hpp"

namespace qdot::bench {

// Clang takes sin and cos for functions with a side effect (errno) and never merges two of the same argument.
#if defined(__clang__) && defined(__GLIBC__)
extern "C" [[gnu::const]] double shared_sine(double) __asm__("sin");
extern "C" [[gnu::const]] double shared_cosine(double) __asm__("cos");
#else
[[gnu::always_inline]] inline double shared_sine(double x) { return std::sin(x); }
[[gnu::always_inline]] inline double shared_cosine(double x) { return std::cos(x); }
#endif

// M = L D Lᵀ in place: L below the diagonal, and 1/D in `inverse`.
template <int n>
[[gnu::always_inline]] inline void factor(double* M, double* inverse) {
  using detail::triangle_index;
  double diagonal[n];
  unroll<n>([&](auto k) __attribute__((always_inline)) { diagonal[k] = M[triangle_index(k, k)]; });
  unroll<n>([&](auto k) __attribute__((always_inline)) {
    detail::inverted_pivots<n, k>(M, diagonal, inverse, 0.0);
    double l[n];
    unroll<n - 1 - k>([&](auto below) __attribute__((always_inline)) {
      constexpr int i = k + 1 + below;
      l[i] = M[triangle_index(i, k)] * inverse[k];
      unroll<below + 1>([&](auto column) __attribute__((always_inline)) {
        constexpr int j = k + 1 + column;
        M[triangle_index(i, j)] -= l[i] * M[triangle_index(j, k)];
      });
    });
    unroll<n - 1 - k>([&](auto below) __attribute__((always_inline)) { M[triangle_index(k + 1 + below, k)] = l[k + 1 + below]; });
  });
}
// b ← L⁻¹ b, and b ← L⁻ᵀ b.
template <int n>
[[gnu::always_inline]] inline void go_forward(const double* L, double* b) {
  unroll<n>([&](auto k) __attribute__((always_inline)) {
    unroll<n - 1 - k>([&](auto below) __attribute__((always_inline)) { b[k + 1 + below] -= b[k] * L[detail::triangle_index(k + 1 + below, k)]; });
  });
}
template <int n>
[[gnu::always_inline]] inline void go_back(const double* L, double* b) {
  unroll<n>([&](auto done) __attribute__((always_inline)) {
    constexpr int k = n - 1 - done;
    unroll<n - 1 - k>([&](auto below) __attribute__((always_inline)) { b[k] -= b[k + 1 + below] * L[detail::triangle_index(k + 1 + below, k)]; });
  });
}

/// Planar chain of a few links, unit masses and lengths, absolute angles from the downward vertical, every loop written out:
/// M_ij = (n − max(i,j)) cos(θ_i − θ_j), r_i = −(n − i) g sin θ_i − Σ_j (n − max(i,j)) sin(θ_i − θ_j) θ̇_j².
template <int n>
struct ShortChain {
  double s[n], c[n], w[n], r[n], M[n * (n + 1) / 2];  // sines, cosines, θ̇², r, the lower triangle of M

  [[gnu::always_inline]] ShortChain(const double* q, const double* v) {
    constexpr double g = 9.81;
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      s[i] = shared_sine(q[i]);
      c[i] = shared_cosine(q[i]);
      w[i] = v[i] * v[i];
      r[i] = -(n - i) * g * s[i];
    });
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      M[detail::triangle_index(i, i)] = n - i;
      unroll<i>([&](auto j) __attribute__((always_inline)) {
        M[detail::triangle_index(i, j)] = (n - i) * (c[i] * c[j] + s[i] * s[j]);
        const double x = (n - i) * (s[i] * c[j] - c[i] * s[j]);
        r[i] -= x * w[j];
        r[j] += x * w[i];
      });
    });
  }
};

template <int n>
void short_chain_by_hand(const double* q, const double* v, double* a) {
  ShortChain<n> chain(q, v);
  detail::solved_in_place<n>(chain.M, chain.r, 0.0);
  unroll<n>([&](auto i) __attribute__((always_inline)) { a[i] = chain.r[i]; });
}

/// A chain of many links: the sums over j are running sums, and M is factored in blocks of four columns.
template <int n>
void long_chain_by_hand(const double* q, const double* v, double* a) {
  constexpr double g = 9.81;
  constexpr int blocks = (n + 3) / 4;
  double s[n], c[n], wc[n], ws[n], C[n], S[n], r[4 * blocks];
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    s[i] = shared_sine(q[i]);
    c[i] = shared_cosine(q[i]);
    wc[i] = v[i] * v[i] * c[i];
    ws[i] = v[i] * v[i] * s[i];
  });
  double pc = 0, ps = 0;  // of j ≤ i, with weight n − i
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    pc += wc[i];
    ps += ws[i];
    C[i] = (n - i) * pc;
    S[i] = (n - i) * ps;
  });
  pc = ps = 0;  // of j > i, with weight n − j
  unroll<n>([&](auto done) __attribute__((always_inline)) {
    constexpr int i = n - 1 - done;
    C[i] += pc;
    S[i] += ps;
    pc += (n - i) * wc[i];
    ps += (n - i) * ws[i];
    r[i] = c[i] * S[i] - s[i] * C[i] - (n - i) * g * s[i];
  });
  double M[16 * blocks * blocks];
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    M[4 * blocks * i + i] = n - i;
    const double ci = (n - i) * c[i], si = (n - i) * s[i];
    unroll<i>([&](auto j) __attribute__((always_inline)) { M[4 * blocks * i + j] = ci * c[j] + si * s[j]; });
  });
  detail::solved_by_blocks<blocks>(n, M, r, 0.0);
  for (int i = 0; i < n; ++i) a[i] = r[i];
}

/// The faster of both for this length.
template <int n>
[[gnu::noinline]] void chain_by_hand(const double* q, const double* v, double* a) {
  if constexpr (n <= 12) {
    short_chain_by_hand<n>(q, v, a);
  } else {
    long_chain_by_hand<n>(q, v, a);
  }
}

/// Rod on a pivot with a sliding ring: r̈ = r φ̇² − g sin φ, (M L²/3 + m r²) φ̈ = −2 m r ṙ φ̇ − (m r + ½ M L) g cos φ.
struct RodAndRingByHand {
  double M = 2.0, L = 1.5, m = 0.3, g = 9.81;
  void operator()(const double* q, const double* v, double* a) const {
    const double s = shared_sine(q[1]), c = shared_cosine(q[1]);
    a[0] = q[0] * v[1] * v[1] - g * s;
    a[1] = -(2.0 * m * q[0] * v[0] * v[1] + (m * q[0] + 0.5 * M * L) * g * c) / (M * L * L / 3.0 + m * q[0] * q[0]);
  }
};

/// Spherical pendulum (ϑ from the downward vertical, φ): ϑ̈ = sin ϑ cos ϑ φ̇² − (g/l) sin ϑ, φ̈ = −2 ϑ̇ φ̇ cot ϑ.
struct SphericalPendulumByHand {
  double l = 1.0, g = 9.81;
  void operator()(const double* q, const double* v, double* a) const {
    const double s = shared_sine(q[0]), c = shared_cosine(q[0]);
    a[0] = s * (c * v[1] * v[1] - g / l);
    a[1] = -2.0 * v[0] * v[1] * c / s;
  }
};

/// Kepler's problem in the plane: r̈ = −μ r / r³.
struct KeplerByHand {
  double mu = 1.0;
  void operator()(const double* q, const double*, double* a) const {
    const double r2 = q[0] * q[0] + q[1] * q[1];
    const double k = -mu / (r2 * std::sqrt(r2));
    a[0] = k * q[0];
    a[1] = k * q[1];
  }
};

/// Spring pendulum (r, φ): r̈ = r φ̇² + g cos φ − (k/m)(r − l), φ̈ = −(2 ṙ φ̇ + g sin φ)/r.
struct ElasticPendulumByHand {
  double m = 1.0, k = 29.43, l = 1.0, g = 9.81;
  void operator()(const double* q, const double* v, double* a) const {
    const double s = shared_sine(q[1]), c = shared_cosine(q[1]);
    a[0] = q[0] * v[1] * v[1] + g * c - k / m * (q[0] - l);
    a[1] = -(2.0 * v[0] * v[1] + g * s) / q[0];
  }
};

/// Symmetric heavy top in Euler's angles (ϑ, φ, ψ), ω = φ̇ cos ϑ + ψ̇:
/// A ϑ̈ = A φ̇² sin ϑ cos ϑ − C ω φ̇ sin ϑ + m g l sin ϑ,  A φ̈ sin ϑ = C ω ϑ̇ − 2 A ϑ̇ φ̇ cos ϑ,  ψ̈ = φ̇ ϑ̇ sin ϑ − φ̈ cos ϑ.
struct HeavyTopByHand {
  double A = 1.0, C = 0.7, mgl = 1.0 * 9.81 * 0.2;
  void operator()(const double* q, const double* v, double* a) const {
    const double s = shared_sine(q[0]), c = shared_cosine(q[0]);
    const double spin = C * (v[1] * c + v[2]);
    a[0] = s * (v[1] * (A * v[1] * c - spin) + mgl) / A;
    a[1] = v[0] * (spin - 2.0 * A * v[1] * c) / (A * s);
    a[2] = v[0] * v[1] * s - a[1] * c;
  }
};

/// Double pendulum, angles from the downward vertical; the 2×2 system solved by Cramer's rule.
struct DoublePendulumByHand {
  double m1 = 1.0, m2 = 1.0, l1 = 1.0, l2 = 1.0, g = 9.81;
  void operator()(const double* q, const double* v, double* a) const {
    const double s0 = shared_sine(q[0]), c0 = shared_cosine(q[0]);
    const double s1 = shared_sine(q[1]), c1 = shared_cosine(q[1]);
    const double c = c0 * c1 + s0 * s1, s = s0 * c1 - c0 * s1;
    const double m = m1 + m2;
    const double u = -m2 * l2 * v[1] * v[1] * s - m * g * s0;  // m l₁ θ̈₁ + m₂ l₂ c θ̈₂
    const double w = l1 * v[0] * v[0] * s - g * s1;            // l₁ c θ̈₁ + l₂ θ̈₂
    const double i = 1.0 / (m - m2 * c * c);
    a[0] = (u - m2 * c * w) * i / l1;
    a[1] = (m * w - c * u) * i / l2;
  }
};

}  // namespace qdot::bench
