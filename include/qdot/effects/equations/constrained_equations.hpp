#pragma once
// SPDX-License-Identifier: MIT
//
// Accelerations and multipliers of small scenes, in the code that one would write by hand.
//
//     M q̈ = r + Q + Jᵀλ ,    J q̈ = γ
//
// M and r come down the ladder of mechanics/mass_and_rhs.hpp, to the object `ConstrainedTo` below. The rows of J and γ come from one
// evaluation of the constraints on numbers that know how they move (ad/places/position_jet.hpp):
//
//     φ(q, t) on positions that move with q̇         J = ∂φ/∂q ,    γ = −(φ̈ where q̈ = 0)
//     a(q, q̇, t) with q̇ as the variables            J = ∂a/∂q̇ ,    γ = −(ȧ where q̈ = 0)
//
// Then, with M = L D Lᵀ in place and B = L⁻¹Jᵀ, z = L⁻¹(r + Q),
//
//     (Bᵀ D⁻¹ B) λ = γ − Bᵀ D⁻¹ z ,     q̈ = L⁻ᵀ D⁻¹ (z + B λ) ;
//
// of one constraint with fewer divisions (one_constraint.hpp).
//
// Where M may be singular by itself, as that of a body by a quaternion of unit length is, constraints lend it inertia: with ϱ Jᵀ(J q̈ − γ) = 0 added,
//
//     (M + ϱ JᵀJ) q̈ = r + Q + ϱ Jᵀγ + Jᵀλ
//
// has the same q̈ and λ for every ϱ.
//
// Masks say which entries of M and B may be other than zero. They are carried beside the numbers and steer no branches, so that in straight-line
// code a constraint between two of eight coordinates costs what its two columns cost.
//
// A pivot of M or of the Schur complement that is too small, and a number that is not finite, leave everything to effects/rows/constrained_solve.hpp,
// which finds redundant rows and names what is wrong. So do scenes of more than eight coordinates; those of a number known at run time have
// sparse factors first (effects/rows/sparse_solve.hpp).

#include <cstddef>
#include <tuple>

#include "qdot/ad/places/position_jet.hpp"
#include "qdot/ad/unroll.hpp"
#include "qdot/effects/equations/effect_forces.hpp"
#include "qdot/effects/equations/one_constraint.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/mechanics/mass_and_rhs.hpp"

namespace qdot::detail {

// Which scenes go this way.
template <class Sc>
inline constexpr bool has_constrained_equations =
    straight_line_pays && Sc::has_constraints && Sc::dof_at_compile_time >= 1 && Sc::dof_at_compile_time <= straight_line_limit &&
    Sc::constraints_at_compile_time >= 1 && Sc::constraints_at_compile_time <= Sc::dof_at_compile_time;

#if defined(__clang__) && defined(__OPTIMIZE__)  // ad/forward/functor_result.hpp says why
#pragma clang attribute push(__attribute__((always_inline)), apply_to = function)
#endif

// Rows of J and γ; of a constraint that is not active there are zeros, and `asks` says so.
template <class Sc>
struct JetRows {
  static constexpr int n = Sc::dof_at_compile_time, m = Sc::constraints_at_compile_time;
  using S = PositionJet<n>;

  double J[m][n], gamma[m];
  ComponentMask mask[m];
  bool asks[m];

  template <class Phases>
  [[gnu::flatten]] JetRows(const Sc& scene, const double* q, const double* qdot, double t, const Phases& z) {
    take<0, 0, 0>(scene.effects(), q, qdot, t, z);
  }

 private:
  template <std::size_t k, int first, int state, class Effects, class Phases>
  [[gnu::flatten]] void take(const Effects& effects, const double* q, const double* qdot, double t, const Phases& z) {
    if constexpr (k < std::tuple_size_v<Effects>) {
      using E = std::tuple_element_t<k, Effects>;
      const E& e = std::get<k>(effects);
      constexpr int rows = constraint_rows_of<E, n>();
      if constexpr (SwitchingEffect<E, n>) {
        if (e.is_active(z[state])) {
          evaluate<first>(e, q, qdot, t);
        } else {
          unroll<rows>([&](auto row) __attribute__((always_inline)) {
            unroll<n>([&](auto i) __attribute__((always_inline)) { J[first + row][i] = 0.0; });
            gamma[first + row] = 0.0;
            mask[first + row] = 0;
            asks[first + row] = false;
          });
        }
      } else if constexpr (ConstraintEffect<E, n>) {
        evaluate<first>(e, q, qdot, t);
      }
      take<k + 1, first + rows, state + states_of<E>()>(effects, q, qdot, t, z);
    }
  }

  // Not always_inline, for the reason that mechanics/equations/straight_line.hpp tells of euler_lagrange_of(); and neither is what leads here from there
  // (the constructor, solved(), packed()): else GCC may prepare this after them and leave it a function of its own, whose masks are no constants.
  template <int first, class E>
  [[gnu::flatten]] void evaluate(const E& e, const double* q, const double* qdot, double t) {
    constexpr int rows = constraint_rows_of<E, n>();
    const S time = S::time(t);
    Vector<S, n> x, v;
    if constexpr (HolonomicEffect<E, n>) {
      unroll<n>([&](auto i) __attribute__((always_inline)) { x[i] = S::template coordinate<i>(q[i], qdot[i]); });
      const auto phi = e.phi(x, time);
      unroll<rows>([&](auto row) __attribute__((always_inline)) {
        const S whole = row_of(phi, row).whole();
        write<first + row>(whole);
        gamma[first + row] = whole.has_bend ? -whole.bend : 0.0;
      });
    } else {
      unroll<n>([&](auto i) __attribute__((always_inline)) {
        x[i] = S(q[i]);
        x[i].rate = qdot[i];
        x[i].has_rate = 1;
        v[i] = S::template coordinate<i>(qdot[i], 0.0);
        v[i].has_rate = 0;
      });
      const auto a = e.velocity_constraint(x, v, time);
      unroll<rows>([&](auto row) __attribute__((always_inline)) {
        const S whole = row_of(a, row).whole();
        write<first + row>(whole);
        gamma[first + row] = whole.has_rate ? -whole.rate : 0.0;
      });
    }
  }

  template <int row>
  [[gnu::always_inline]] void write(const S& from) {
    unroll<n>([&](auto i) __attribute__((always_inline)) { J[row][i] = from.template J<i>(); });
    mask[row] = from.mask;
    asks[row] = true;
  }
};

#if defined(__clang__) && defined(__OPTIMIZE__)
#pragma clang attribute pop
#endif

// M ← M + ϱ JᵀJ and r ← r + ϱ Jᵀγ, with a ϱ that makes both parts alike; false where there is none.
template <int n, int m>
[[gnu::always_inline]] inline bool with_inertia_of_constraints(double* M, ComponentMask& present, const double (&J)[m][n], const ComponentMask (&mask)[m],
                                                               double* r, const double* gamma) {
  double inertia = 0.0, size = 0.0;
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    inertia += M[triangle_index(i, i)];
    unroll<m>([&](auto k) __attribute__((always_inline)) { size += product_if(has(mask[k], i), J[k][i], J[k][i]); });
  });
  const double rho = inertia / size;
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    unroll<m>([&](auto k) __attribute__((always_inline)) {
      const Present there = has(mask[k], i);
      const double weight = product_if(there, rho, J[k][i]);
      r[i] = sum_of(1U, r[i], there, product_if(there, gamma[k], weight));
      unroll<i + 1>([&](auto j) __attribute__((always_inline)) {
        constexpr int ij = triangle_index(i, j);
        const Present both = there & has(mask[k], j);
        M[ij] = sum_of(has_entry<ij>(present), M[ij], both, product_if(both, weight, J[k][j]));
        present |= bit(both, ij);
      });
    });
  });
  return rho > 0.0;
}

// r ← q̈ and γ ← λ; false on a pivot of M or of the Schur complement that is too small. M and J are overwritten; `present`
// and `mask` say which of their entries may be other than zero. Where constraints may rest, only those of which `asks` is true take part.
// `fraction`: what the rows before it leave of each pivot of the Schur complement but the first.
template <int n, int m, bool may_rest>
[[gnu::always_inline]] inline bool solved_with_constraints(double* M, ComponentMask present, double (&J)[m][n], ComponentMask (&mask)[m],
                                                           const bool* asks, double dependent, double* r, double* gamma, double* fraction) {
  if constexpr (n == 2 && m == 1) {
    if (!may_rest || asks[0]) return solved_with_one_of_two(M, present, J[0], mask[0], r, gamma[0], massless_pivot);
    return solved_in_place<2>(M, r, massless_pivot, present);
  }
  double inverse[n];
  if (!factored_in_place<n>(M, inverse, massless_pivot, present)) return false;
  ComponentMask some = 0;  // entries of r that may be other than zero
  unroll<n>([&](auto i) __attribute__((always_inline)) { some |= bit(may_differ_from_zero(r[i]), i); });
  forward_in_place<n>(M, r, present, some);
  if constexpr (m == 1 && n > 1) {
    forward_in_place<n>(M, J[0], present, mask[0]);
    solve_with_multiplier<n>(M, inverse, J[0], mask[0], may_rest && !asks[0], r, some, gamma[0]);
    backward_in_place<n>(M, r, present);
    return true;
  }
  double schur[m * (m + 1) / 2];
  MaybeZero scaled[m][n];
  unroll<m>([&](auto k) __attribute__((always_inline)) {
    forward_in_place<n>(M, J[k], present, mask[k]);
    MaybeZero left{gamma[k], 1};
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      scaled[k][i] = MaybeZero{J[k][i], has(mask[k], i)} * MaybeZero{inverse[i], 1};
      left = left - MaybeZero{r[i], has(some, i)} * scaled[k][i];
    });
    gamma[k] = left.number;
  });
  unroll<m>([&](auto k) __attribute__((always_inline)) {
    unroll<k + 1>([&](auto l) __attribute__((always_inline)) {
      MaybeZero sum{0.0, 0};
      unroll<n>([&](auto i) __attribute__((always_inline)) { sum = sum + scaled[k][i] * MaybeZero{J[l][i], has(mask[l], i)}; });
      schur[triangle_index(k, l)] = sum.number;
    });
    if constexpr (may_rest) {
      if (!asks[k]) schur[triangle_index(k, k)] = 1.0;
    }
  });
  if (!solved_in_place<m>(schur, gamma, dependent, ~ComponentMask(0), fraction)) return false;
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    MaybeZero sum{r[i], has(some, i)};
    unroll<m>([&](auto k) __attribute__((always_inline)) { sum = sum + MaybeZero{gamma[k], 1} * MaybeZero{J[k][i], has(mask[k], i)}; });
    r[i] = sum.number * inverse[i];
  });
  backward_in_place<n>(M, r, present);
  return true;
}

// A use of M and r: q̈ and λ of a scene with constraints.
template <class Sc>
struct ConstrainedTo {
  static constexpr int n = Sc::dof_at_compile_time, m = Sc::constraints_at_compile_time;
  static constexpr bool shared = true;

  const Sc& scene;
  const EffectStates<Sc>& z;
  double dependent;  // pivots of the Schur complement below this fraction of their diagonal entry are left to the general way
  ConstrainedSolution<n, m>& out;

  [[gnu::flatten]] bool packed(const AtState& at, double* M, double* r, ComponentMask present) const {
    return solved(at, M, r, present);
  }
  [[gnu::noinline, gnu::flatten]] bool full(const AtState& at, double* M, double* r) const { return solved(at, M, r, ~ComponentMask(0)); }

 private:
  [[gnu::flatten]] bool solved(const AtState& at, double* M, double* r, ComponentMask present) const {
    JetRows<Sc> row(scene, at.q, at.qdot, at.t, z);
    if constexpr (Sc::has_forces) {
      const Vector<double, n> Q = forces_at<ForceSum::plain>(scene, z, at);
      unroll<n>([&](auto i) __attribute__((always_inline)) { r[i] += Q[i]; });
    }
    if constexpr (Sc::SystemType::inertia == Inertia::indefinite) {
      if (!with_inertia_of_constraints<n, m>(M, present, row.J, row.mask, r, row.gamma)) return false;
    }
    double fraction[m];
    if (!solved_with_constraints<n, m, Sc::has_phases>(M, present, row.J, row.mask, row.asks, dependent, r, row.gamma, fraction)) return false;
    double sum = -at.t;  // the only one of the arguments that a derivative may not hold though the value does
    unroll<n>([&](auto i) __attribute__((always_inline)) { sum += r[i]; });
    write_in_pairs<n>(out.qddot.data(), r);
    out.rank = 0;
    out.smallest_pivot = 1.0;
    unroll<m>([&](auto k) __attribute__((always_inline)) {
      sum += out.lambda[k] = row.gamma[k];
      if (!row.asks[k]) return;
      ++out.rank;
      if constexpr (k > 0) {  // the first is 1, as nothing was taken from it
        if (fraction[k] < out.smallest_pivot) out.smallest_pivot = fraction[k];
      }
    });
    return is_finite(sum);
  }
};

}  // namespace qdot::detail
