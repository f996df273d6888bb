#pragma once
// SPDX-License-Identifier: MIT
//
// How q̈ of small systems changes along given displacements of the state and the parameters, as straight-line code.
//
// As for the states (straight_line_jacobian.hpp) a motion satisfies X L = rhs − M a = 0 at its accelerations a, and along any direction
//
//     δq̈ = M⁻¹ δ(X L)      at fixed a = q̈ .
//
// Here lane j of the dual numbers inside, two to a pair, is a direction: parameter j for j < m, along which the state may be displaced as well, and
// for the others displacements of the state alone. That is a column of the variational equations (analysis/variations/variations.hpp) for
// each lane in one pass, whose cost goes by the number of columns and not by that of coordinates and parameters; where the state stays as
// it is, it is ∂q̈/∂p. L comes from energies that are made of such parameters; M and q̈ from those of plain ones.

#include "qdot/mechanics/equations/straight_line_jacobian.hpp"

namespace qdot::detail {

// Most parameters for this way in one pass.
inline constexpr int straight_line_parameters_limit = 16;
// Most directions along which the state is displaced, too: eight doubles are as many registers as there are left.
inline constexpr int straight_line_columns_limit = 8;

template <int n, int lanes>
using DirectionResidual = LagrangeResidual<n, PairedDual<(lanes + 1) / 2>>;

// The parameters as scalars of Lagrange's equations; lane j is parameter j.
template <int n, int m, int lanes, class P>
[[gnu::always_inline]] inline Vector<DirectionResidual<n, lanes>, m> paired_parameters(const P& p) {
  using N = PairedDual<(lanes + 1) / 2>;
  Vector<DirectionResidual<n, lanes>, m> seeds;
  unroll<m>([&](auto j) __attribute__((always_inline)) {
    seeds[j] = DirectionResidual<n, lanes>(N::template variable<j / 2>(p[j], j % 2 == 0 ? 1.0 : 0.0, j % 2 == 0 ? 0.0 : 1.0));
  });
  return seeds;
}

// A state that stays as it is.
struct StateHeld {
  template <class N, int i>
  [[gnu::always_inline]] N q(double at) const {
    return N(at);
  }
  template <class N, int i>
  [[gnu::always_inline]] N qdot(double at) const {
    return N(at);
  }
};

// A state that is displaced: of coordinate i, `stride` numbers from dq + i·stride on, and of its velocity from dqdot + i·stride on.
template <int stride>
struct StateDisplaced {
  const double *dq, *dqdot;

  template <class N, int i>
  [[gnu::always_inline]] N q(double at) const {
    return displaced<N>(at, dq + i * stride);
  }
  template <class N, int i>
  [[gnu::always_inline]] N qdot(double at) const {
    return displaced<N>(at, dqdot + i * stride);
  }

 private:
  template <class N>
  [[gnu::always_inline]] static N displaced(double at, const double* along) {
    N number(at);
    unroll<stride / 2>([&](auto k) __attribute__((always_inline)) {
      number.template pair<k>() = Pair{along[2 * k], along[2 * k + 1]};
      number.mask |= bit(1, k);
    });
    return number;
  }
};

// A use of M and r: q̈ and δq̈, lane by lane. made(paired parameters) are energies with the signatures of plain ones.
template <int n, int m, int lanes, class Made, class P, class Displaced>
struct DirectionsTo {
  const Made& made;
  const P& p;
  const Displaced& state;
  double *qddot, *along;

  // Not always_inline: lagrangian_of() would then be prepared too late (straight_line.hpp).
  [[gnu::flatten]] bool packed(const AtState& at, double* M, double* r, ComponentMask present) const {
    using N = PairedDual<(lanes + 1) / 2>;
    using S = DirectionResidual<n, lanes>;
    double factor[n * (n + 1) / 2];
    unroll<n*(n + 1) / 2>([&](auto k) __attribute__((always_inline)) { factor[k] = M[k]; });
    if (!solved_in_place<n>(factor, r, singular_pivot<double>(n), present)) return false;
    Vector<S, n> x, v;
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      const N velocity = state.template qdot<N, i>(at.qdot[i]);
      x[i] = S::template coordinate<i>(state.template q<N, i>(at.q[i]), velocity);
      v[i] = S::template velocity<i>(velocity);
      v[i].rate = N(r[i]);
      v[i].has_rate = 1;
    });
    const S residual = lagrangian_of<n>(made(paired_parameters<n, m, lanes>(p)), x, v, S::time(N(at.t)));
    if (residual.g_mask & of_rotation) return false;
    N columns[n];
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      columns[i] = residual.template x<i>();
      columns[i].value = 0.0;
    });
    solved_in_place<n>(M, columns, 0.0, present);
    double sum = -0.0;
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      qddot[i] = r[i];
      sum += r[i];
      unroll<lanes>([&](auto j) __attribute__((always_inline)) {
        const double slope = columns[i].template pair<j / 2>()[j % 2];
        along[i + n * j] = slope;
        sum += slope;
      });
    });
    return is_finite(sum);
  }
};

// q̈ and δq̈ along so many lanes, a column of n each; false where another way must be gone.
template <int n, int m, int lanes, class E, class Made, class P, class Displaced>
[[gnu::flatten, gnu::noinline]] bool straight_line_directions(const E& e, const Made& made, const P& p, const Displaced& state, const double* q,
                                                              const double* qdot, double t, double* qddot, double* along) {
  return straight_line_equations<n>(e, AtState{q, qdot, t}, DirectionsTo<n, m, lanes, Made, P, Displaced>{made, p, state, qddot, along});
}

}  // namespace qdot::detail
