#pragma once
// SPDX-License-Identifier: MIT
//
// Columns of the variational equations by the equations of motion that the compiler has derived.
//
// Written-out energies (mechanics/written_out.hpp) have q̈ as a list of lines, each of which is one operation. On numbers that have a derivative along each
// column of Φ the same lines are q̈ and all δq̈,
//
//     q̈(q + ε δq, q̇ + ε δq̇, t) = q̈ + ε δq̈ ,
//
// in one pass: a sine and its cosine once. One column adds a tenth to q̈ of a double pendulum, and its four columns by the start add half.
// The other way, ∂q̈/∂(q, q̇) by T and V and then its product with each column, costs two passes, whose energies are not simplified, and
// 2n² products for a column.

#include <Eigen/Core>
#include <cmath>

#include "qdot/ad/lagrange/euler_lagrange_math.hpp"
#include "qdot/ad/lagrange/paired_dual.hpp"
#include "qdot/mechanics/derive/closed_form_evaluation.hpp"
#include "qdot/mechanics/equations/straight_line.hpp"
#include "qdot/mechanics/equations/straight_line_parameters.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot::detail {

// Most columns in one pass, for which there are registers, and most coordinates.
inline constexpr int closed_form_columns_limit = 6, closed_form_columns_coordinates = 4;

template <class System>
inline constexpr bool has_closed_form_columns = false;
template <class E, int n, Inertia inertia>
inline constexpr bool has_closed_form_columns<System<E, n, inertia>> =
    n >= 1 && n <= closed_form_columns_coordinates && HasClosedForm<E> && straight_line_pays && inertia == Inertia::positive_definite;

// The functions of <cmath> for these numbers: f(x) by f and f′ of numbers with one derivative, and f(x, y) by those of numbers with two.
template <int p, class Is>
inline constexpr bool follows_duals<PairedDual<p, Is>> = true;
template <int p, class Is, class F>
[[gnu::always_inline]] inline PairedDual<p, Is> through(const PairedDual<p, Is>& x, const F& f) {
  const Dual<double, 1> y = f(Dual<double, 1>::variable(x.value, 0));
  return x.through(y.value, y.tangent[0]);
}
template <int p, class Is, class F>
[[gnu::always_inline]] inline PairedDual<p, Is> through(const PairedDual<p, Is>& x, const PairedDual<p, Is>& y, const F& f) {
  const Dual<double, 2> z = f(Dual<double, 2>::variable(x.value, 0), Dual<double, 2>::variable(y.value, 1));
  return x.through(z.value, z.tangent[0]) + y.through(0.0, z.tangent[1]);
}
template <int p, class Is> PairedDual<p, Is> sin(const PairedDual<p, Is>& x) { return x.through(shared_sine(x.value), shared_cosine(x.value)); }
template <int p, class Is> PairedDual<p, Is> cos(const PairedDual<p, Is>& x) { return x.through(shared_cosine(x.value), -shared_sine(x.value)); }
template <int p, class Is> PairedDual<p, Is> sqrt(const PairedDual<p, Is>& x) {
  const double root = std::sqrt(x.value);
  return x.through(root, 0.5 / root);
}

// ẏ and the rates of `columns` columns behind it, at most `lanes`; false where another way must be gone.
template <int n, int lanes, class E>
[[gnu::flatten, gnu::noinline]] bool closed_form_lanes(const E& energies, double t, const double* y, double* ydot, Eigen::Index columns) {
  using D = PairedDual<(lanes + 1) / 2>;
  constexpr int size = 2 * n, width = (lanes + 1) / 2 * 2;
  double along[size * width] = {};
  for (Eigen::Index c = 0; c < columns; ++c)
    for (int i = 0; i < size; ++i) along[i * width + c] = y[size * (c + 1) + i];
  const StateDisplaced<width> displaced{along, along + n * width};
  D state[size], qddot[n];
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    state[i] = displaced.template q<D, i>(y[i]);
    state[n + i] = displaced.template qdot<D, i>(y[n + i]);
  });
  if (!energies.accelerations_in_closed_form(state, state + n, D(t), qddot)) return false;
  double sum = 0.0, out[n * width];
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    ydot[i] = y[n + i];
    ydot[n + i] = qddot[i].value;
    unroll<width / 2>([&](auto k) __attribute__((always_inline)) {
      const Pair pair = qddot[i].template pair<k>();
      out[i * width + 2 * k] = pair[0];
      out[i * width + 2 * k + 1] = pair[1];
      sum += pair[0] + pair[1];
    });
  });
  for (Eigen::Index c = 0; c < columns; ++c)
    for (int i = 0; i < n; ++i) {
      ydot[size * (c + 1) + i] = y[size * (c + 1) + n + i];
      ydot[size * (c + 1) + n + i] = out[i * width + c];
    }
  return is_finite(sum);
}

template <class E, int n, Inertia inertia>
bool closed_form_columns_written(const System<E, n, inertia>& system, double t, const double* y, double* ydot, Eigen::Index columns) {
  const E& energies = system.energies();
  if (!energies.has_closed_form()) return false;
  if (columns == 1) return closed_form_lanes<n, 1>(energies, t, y, ydot, columns);
  if constexpr (2 * n <= closed_form_columns_limit) {
    if (columns <= 2 * n) return closed_form_lanes<n, 2 * n>(energies, t, y, ydot, columns);
  }
  return false;
}

}  // namespace qdot::detail
