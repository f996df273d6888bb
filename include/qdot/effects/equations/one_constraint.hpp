#pragma once
// SPDX-License-Identifier: MIT
//
// One constraint: λ and one of the accelerations by a single division.
//
// A division takes longer than everything else in a small system, and two that wait for each other twice as long. Elimination has them wait: for
// the last pivot of M, then for J M⁻¹ Jᵀ. With M = L D Lᵀ, B = L⁻¹Jᵀ and z = L⁻¹ r let d, b and ζ be the last entries of D, B and z, and A
// and g what the others leave of J M⁻¹ Jᵀ and γ. Then the last of the equations D x = z + B λ, where x = Lᵀ q̈, and the one for λ are two
// of two,
//
//     d x − b λ = ζ ,
//     b x + A λ = g ,        (A d + b²) x = A ζ + b g ,    (A d + b²) λ = d g − b ζ .
//
// Nothing is lost by it: A, d and b² have one sign.
//
// Of two coordinates all three equations are solved at once. A constraint J = (u, v) leaves the direction e = (−v, u) free, and with w = det M · M⁻¹ Jᵀ
//
//     τ q̈ = e (e·r) + γ w ,    τ λ = γ det M − w·r ,    τ = J w = eᵀM e .
//
// A material point, M = m·1, needs no determinant: λ = (m γ − J r)/J Jᵀ, m q̈ = r + Jᵀλ, and with 1/(m J Jᵀ) one division.

#include <limits>

#include "qdot/mechanics/equations/small_solve.hpp"

namespace qdot::detail {

// A number and whether it may be other than zero. Where the compiler knows that it may not, nothing is computed of it.
struct MaybeZero {
  double number;
  Present there;

  [[gnu::always_inline]] friend MaybeZero operator*(const MaybeZero& a, const MaybeZero& b) {
    const Present both = a.there & b.there;
    return {product_if(both, a.number, b.number), both};
  }
  [[gnu::always_inline]] friend MaybeZero operator+(const MaybeZero& a, const MaybeZero& b) {
    return {sum_of(a.there, a.number, b.there, b.number), a.there | b.there};
  }
  [[gnu::always_inline]] friend MaybeZero operator-(const MaybeZero& a, const MaybeZero& b) {
    return {difference_of(a.there, a.number, b.there, b.number), a.there | b.there};
  }
};

// r ← q̈ and γ ← λ of a material point m in a plane; false where m is negative, or m J Jᵀ beyond the range of double though m and J Jᵀ are not. They are
// not finite where m or J is zero.
[[gnu::always_inline]] inline bool solve_material_point(const MaybeZero& m, const MaybeZero& u, const MaybeZero& v, const MaybeZero& r0, const MaybeZero& r1,
                                                        const MaybeZero& g, double* r, double& gamma) {
  const double size = (u * u + v * v).number, i = 1.0 / (m.number * size), per_m = size * i;
  const MaybeZero lambda{(m * g - (u * r0 + v * r1)).number * (m.number * i), 1};
  r[0] = (r0 + u * lambda).number * per_m;
  r[1] = (r1 + v * lambda).number * per_m;
  gamma = lambda.number;
  return i >= std::numeric_limits<double>::min();
}

// r ← q̈ and γ ← λ of two coordinates; false where a pivot of M is below `threshold` of its diagonal entry. They are not finite where J is zero.
[[gnu::always_inline]] inline bool solved_with_one_of_two(const double* M, ComponentMask present, const double* J, ComponentMask mask, double* r, double& gamma,
                                                          double threshold) {
  const MaybeZero a{M[0], 1}, b{M[1], has_entry<1>(present)}, d{M[2], 1}, u{J[0], has(mask, 0)}, v{J[1], has(mask, 1)};
  const MaybeZero r0{r[0], may_differ_from_zero(r[0])}, r1{r[1], may_differ_from_zero(r[1])}, g{gamma, may_differ_from_zero(gamma)};
  if (!b.there && known_equal(a.number, d.number)) {
    return solve_material_point(a, u, v, r0, r1, g, r, gamma);
  }
  const MaybeZero whole = a * d, determinant = whole - b * b;
  const MaybeZero w0 = d * u - b * v, w1 = a * v - b * u, along = u * r1 - v * r0;
  const double i = 1.0 / (u * w0 + v * w1).number;
  r[0] = (w0 * g - v * along).number * i;
  r[1] = (w1 * g + u * along).number * i;
  gamma = (determinant * g - (w0 * r0 + w1 * r1)).number * i;
  if (!b.there) return (a.number > 0.0) & (d.number > 0.0);
  return (a.number > 0.0) & (determinant.number > threshold * whole.number + smallest_determinant);
}

// z ← x and γ ← λ for D x = z + B λ and B·x = γ, where D is the diagonal of a packed triangle and `inverse` 1/D. `some` and `mask`: which entries of z
// and B may be other than zero. A constraint that rests has B = 0 and γ = 0, and keeps λ = 0.
template <int n>
[[gnu::always_inline]] inline void solve_with_multiplier(const double* D, const double* inverse, const double* B, ComponentMask mask, bool rests, double* z,
                                                         ComponentMask some, double& gamma) {
  constexpr int last = n - 1;
  MaybeZero A{0.0, 0}, g{gamma, may_differ_from_zero(gamma)};
  unroll<last>([&](auto i) __attribute__((always_inline)) {
    const MaybeZero entry{B[i], has(mask, i)}, scaled = entry * MaybeZero{inverse[i], 1};
    A = A + entry * scaled;
    g = g - MaybeZero{z[i], has(some, i)} * scaled;
  });
  if (rests) A = {1.0, 1};
  const MaybeZero d{D[triangle_index(last, last)], 1}, b{B[last], has(mask, last)}, zeta{z[last], has(some, last)};
  const double i = 1.0 / (A * d + b * b).number;
  gamma = (d * g - b * zeta).number * i;
  z[last] = (A * zeta + b * g).number * i;
  unroll<last>([&](auto k) __attribute__((always_inline)) {
    z[k] = (MaybeZero{z[k], has(some, k)} + MaybeZero{B[k], has(mask, k)} * MaybeZero{gamma, 1}).number * inverse[k];
  });
}

}  // namespace qdot::detail
