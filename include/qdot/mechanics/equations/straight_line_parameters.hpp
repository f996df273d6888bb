#pragma once
// SPDX-License-Identifier: MIT
//
// ∂q̈/∂p of small systems as straight-line code.
//
// As for the states (straight_line_jacobian.hpp) a motion satisfies X L = rhs − M a = 0 at its accelerations a, and
//
//     ∂q̈/∂p = M⁻¹ ∂(X L)/∂p      at fixed q, q̇, a = q̈ .
//
// Here coordinates and velocities are constants of the dual numbers inside, and parameters are their variables, two to a pair. L comes from energies
// that are made of such parameters; M and q̈ from those of plain ones.

#include <utility>

#include "qdot/mechanics/equations/straight_line_jacobian.hpp"

namespace qdot::detail {

// Most parameters for this way in one pass.
inline constexpr int straight_line_parameters_limit = 16;

template <int n, int m>
using ParameterResidual = LagrangeResidual<n, PairedDual<(m + 1) / 2>>;

// The parameters as scalars of Lagrange's equations.
template <int n, int m, class P>
[[gnu::always_inline]] inline Vector<ParameterResidual<n, m>, m> paired_parameters(const P& p) {
  using N = PairedDual<(m + 1) / 2>;
  Vector<ParameterResidual<n, m>, m> seeds;
  unroll<m>([&](auto j) __attribute__((always_inline)) {
    seeds[j] = ParameterResidual<n, m>(N::template variable<j / 2>(p[j], j % 2 == 0 ? 1.0 : 0.0, j % 2 == 0 ? 0.0 : 1.0));
  });
  return seeds;
}

// A use of M and r: q̈ and ∂q̈/∂p, by columns. made(paired parameters) are energies with the signatures of plain ones.
template <int n, int m, class Made, class P>
struct ParametersTo {
  const Made& made;
  const P& p;
  double *qddot, *d_p;

  [[gnu::always_inline]] bool packed(const AtState& at, double* M, double* r, ComponentMask present) const {
    using N = PairedDual<(m + 1) / 2>;
    using S = ParameterResidual<n, m>;
    double factor[n * (n + 1) / 2];
    unroll<n*(n + 1) / 2>([&](auto k) __attribute__((always_inline)) { factor[k] = M[k]; });
    if (!solved_in_place<n>(factor, r, singular_pivot<double>(n), present)) return false;
    Vector<S, n> x, v;
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      x[i] = S::template coordinate<i>(N(at.q[i]), N(at.qdot[i]));
      v[i] = S::template velocity<i>(N(at.qdot[i]));
      v[i].rate = N(r[i]);
      v[i].has_rate = 1;
    });
    const S residual = lagrangian_of<n>(made(paired_parameters<n, m>(p)), x, v, S::time(N(at.t)));
    if (residual.g_mask & of_rotation) return false;
    N columns[n];
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      columns[i] = residual.template x<i>();
      columns[i].value = 0.0;
    });
    solved_in_place<n>(M, columns, 0.0, present);
    double sum = 0.0;
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      qddot[i] = r[i];
      sum += r[i];
      unroll<m>([&](auto j) __attribute__((always_inline)) {
        const double slope = columns[i].template pair<j / 2>()[j % 2];
        d_p[i + n * j] = slope;
        sum += slope;
      });
    });
    return sum - sum == 0.0;
  }
};

// q̈ and ∂q̈/∂p; false where another way must be gone.
template <int n, int m, class E, class Made, class P>
[[gnu::flatten, gnu::noinline]] bool straight_line_parameters(const E& e, const Made& made, const P& p, const double* q, const double* qdot, double t,
                                                              double* qddot, double* d_p) {
  return straight_line_equations<n>(e, AtState{q, qdot, t}, ParametersTo<n, m, Made, P>{made, p, qddot, d_p});
}

}  // namespace qdot::detail
