#pragma once
// SPDX-License-Identifier: MIT
//
// The angular velocity of a body along its own axes, Ω, with how it depends on q̇ and what there is of Ω̇ without accelerations,
//
//     Ω = J q̇ + … ,     Ω̇ = J q̈ + bend ,
//
// from a rotation matrix on positions (ad/places/position_jet.hpp). Where the matrix remembers what it was made from (known_rotation.hpp), by the
// closed form; else by [Ω×] = RᵀṘ.

#include "qdot/ad/places/position_jet.hpp"
#include "qdot/ad/unroll.hpp"
#include "qdot/mechanics/equations/known_rotation.hpp"
#include "qdot/mechanics/rotation.hpp"

namespace qdot::detail {

// Whether the compiler does not know a number to be zero.
[[gnu::always_inline]] inline Present may_differ_from_zero(double x) { return __builtin_constant_p(x) && x == 0.0 ? 0U : 1U; }

// Row a of I times w, without what the compiler knows to be zero.
template <class Tensor>
[[gnu::always_inline]] inline double entry_times_vector(const Tensor& inertia, int a, const double (&w)[3]) {
  double sum = 0.0;
  Present any = 0;
  unroll<3>([&](auto k) __attribute__((always_inline)) {
    const Present there = may_differ_from_zero(inertia.coeff(a, k));
    sum = sum_of(any, sum, there, product_if(there, inertia.coeff(a, k), w[k]));
    any |= there;
  });
  return sum;
}

// The same matrix of constants, by the same words and the same operations: of doubles Clang contracts sums of products, and has other sines.
template <class Real, int i, int j, int k>
[[gnu::always_inline]] inline auto rotation_of(EulerTurn<i, j, k>, const Real (&p)[3]) { return euler_rotation<i, j, k>(p[0], p[1], p[2]); }
template <class Real>
[[gnu::always_inline]] inline auto rotation_of(QuaternionTurn, const Real (&p)[4]) { return rotation_from_quaternion(Vector<Real, 4>(p[0], p[1], p[2], p[3])); }
template <class Real>
[[gnu::always_inline]] inline auto rotation_of(VectorTurn, const Real (&u)[3]) { return rotation_from_vector(Vector<Real, 3>(u[0], u[1], u[2])); }

// Whether the compiler sees that R's entries are those that it was made with, and that nobody has written to them.
template <class Turn, int n>
[[gnu::always_inline]] inline Present is_as_made(const KnownRotation<Turn, PositionJet<n>>& R) {
  PositionJet<n> at[Turn::coordinates];
  unroll<Turn::coordinates>([&](auto c) __attribute__((always_inline)) { at[c] = R.from[c].value; });
  const auto made = rotation_of(Turn(), at);
  Present same = 1;
  unroll<9>([&](auto k) __attribute__((always_inline)) { same &= known_equal(R.coeff(k % 3, k / 3).value, made.coeff(k % 3, k / 3).value); });
  return same;
}

// Rᵀ f of a torque or force along the axes of space.
template <class Turn, int n>
[[gnu::always_inline]] inline void turn_into_body(const KnownRotation<Turn, PositionJet<n>>& R, double (&f)[3]) {
  double at[Turn::coordinates];
  unroll<Turn::coordinates>([&](auto c) __attribute__((always_inline)) { at[c] = R.from[c].value; });
  Turn::turn_into_body(at, f);
}

// What leads from q̇ to Ω and back.
template <int n>
struct BodyFrame {
  double J[3][n];
  ComponentMask moves[3];  // which of J's entries may be other than zero
  // Of known rotations by coordinates of their own: q̇ = scale inverse Ω (+ along μ, where they are four).
  double inverse[n][3], scale, along[n], regular;
  ComponentMask place[4];  // the bit of the coordinate that each is; 0: no known rotation, or another function of coordinates

  BodyFrame() = default;
  [[gnu::always_inline]] BodyFrame(const BodyFrame& o) { choose(1, o, 0, o); }
  [[gnu::always_inline]] BodyFrame& operator=(const BodyFrame& o) { return choose(1, o, 0, o), *this; }

  [[gnu::always_inline]] Present moves_with(int a, int i) const { return has(moves[a], i); }
  // Whether the compiler sees that both are the same.
  [[gnu::always_inline]] Present known_to_be(const BodyFrame& o) const {
    Present same = 1;
    unroll<3>([&](auto k) __attribute__((always_inline)) {
      same &= static_cast<Present>(moves[k] == o.moves[k]);
      unroll<n>([&](auto i) __attribute__((always_inline)) { same &= moves_with(k, i) & o.moves_with(k, i) ? known_equal(J[k][i], o.J[k][i]) : 1U; });
    });
    return same;
  }
  // This frame where `chosen`, or the other one; number by number, as the compiler sees through no choice between two of them.
  [[gnu::always_inline]] void choose(Present chosen, const BodyFrame& a, Present otherwise, const BodyFrame& b) {
    const auto one = [&](auto& to, const auto& x, const auto& y) __attribute__((always_inline)) { to = chosen ? x : otherwise ? y : 0; };
    one(regular, a.regular, b.regular);
    one(scale, a.scale, b.scale);
    unroll<4>([&](auto c) __attribute__((always_inline)) { one(place[c], a.place[c], b.place[c]); });
    unroll<3>([&](auto k) __attribute__((always_inline)) { one(moves[k], a.moves[k], b.moves[k]); });
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      one(along[i], a.along[i], b.along[i]);
      unroll<3>([&](auto k) __attribute__((always_inline)) {
        one(J[k][i], a.J[k][i], b.J[k][i]);
        one(inverse[i][k], a.inverse[i][k], b.inverse[i][k]);
      });
    });
  }
};

template <int n>
struct BodyRates {
  using S = PositionJet<n>;
  double omega[3], bend[3];
  BodyFrame<n> frame;

  template <class Turn>
  [[gnu::always_inline]] explicit BodyRates(const KnownRotation<Turn, S>& R) {
    double at[Turn::coordinates], rate[Turn::coordinates];
    unroll<Turn::coordinates>([&](auto c) __attribute__((always_inline)) { at[c] = R.from[c].value; });
    unroll<Turn::coordinates>([&](auto c) __attribute__((always_inline)) { rate[c] = R.from[c].has_rate ? R.from[c].whole().rate : 0.0; });
    const auto turning = Turn::at(at, rate);
    unroll<3>([&](auto a) __attribute__((always_inline)) {
      omega[a] = turning.omega[a];
      bend[a] = turning.bend[a];
      frame.moves[a] = 0;
      unroll<n>([&](auto i) __attribute__((always_inline)) { frame.J[a][i] = 0.0; });
      unroll<Turn::coordinates>([&](auto c) __attribute__((always_inline)) {
        if constexpr (Turn::moves(a, c)) {
          const S p = R.from[c].whole();
          bend[a] = sum_of(1U, bend[a], p.has_bend, product_if(p.has_bend, turning.W[a][c], p.bend));
          unroll<n>([&](auto i) __attribute__((always_inline)) {
            const Present there = has(p.mask, i);
            frame.J[a][i] = sum_of(frame.moves_with(a, i), frame.J[a][i], there, product_if(there, turning.W[a][c], p.template J<i>()));
            frame.moves[a] |= bit(there, i);
          });
        }
      });
    });
    // Which coordinate each is, and the way back.
    frame.regular = turning.regular;
    frame.scale = Turn::scale;
    frame.place[3] = 0;
    ComponentMask all = 0;
    Present own = 1;
    unroll<Turn::coordinates>([&](auto c) __attribute__((always_inline)) {
      const S p = R.from[c].whole();
      Present is_one = (1U ^ p.has_bend) & static_cast<Present>((p.mask & (p.mask - 1)) == 0) & static_cast<Present>((all & p.mask) == 0);
      unroll<n>([&](auto i) __attribute__((always_inline)) { is_one &= has(p.mask, i) ? known_equal(p.template J<i>(), 1.0) : 1U; });
      own &= is_one;
      all |= p.mask;
      frame.place[c] = p.mask;
    });
    unroll<4>([&](auto c) __attribute__((always_inline)) { frame.place[c] = own ? frame.place[c] : 0; });
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      frame.along[i] = 0.0;
      unroll<3>([&](auto a) __attribute__((always_inline)) { frame.inverse[i][a] = 0.0; });
      unroll<Turn::coordinates>([&](auto c) __attribute__((always_inline)) {
        const Present here = has(frame.place[c], i);
        frame.along[i] = here ? at[c] : frame.along[i];
        unroll<3>([&](auto a) __attribute__((always_inline)) { frame.inverse[i][a] = here ? turning.inverse[c][a] : frame.inverse[i][a]; });
      });
    });
  }

  template <class Rotation>
  [[gnu::always_inline]] explicit BodyRates(const Rotation& R) {
    unroll<4>([&](auto c) __attribute__((always_inline)) { frame.place[c] = 0; });
    unroll<3>([&](auto a) __attribute__((always_inline)) {
      constexpr int i = (a + 2) % 3, j = (a + 1) % 3;  // Ω_a = (RᵀṘ)_ij
      omega[a] = bend[a] = 0.0;
      frame.moves[a] = 0;
      unroll<n>([&](auto c) __attribute__((always_inline)) { frame.J[a][c] = 0.0; });
      unroll<3>([&](auto k) __attribute__((always_inline)) {
        const S left = S(R.coeff(k, i)).whole(), right = S(R.coeff(k, j)).whole();
        const Present both = left.has_rate & right.has_rate;
        omega[a] = sum_of(1U, omega[a], right.has_rate, product_if(right.has_rate, left.value, right.rate));
        bend[a] = sum_of(1U, bend[a], right.has_bend | both,
                         sum_of(right.has_bend, product_if(right.has_bend, left.value, right.bend), both, product_if(both, left.rate, right.rate)));
        unroll<n>([&](auto c) __attribute__((always_inline)) {
          const Present there = has(right.mask, c);
          frame.J[a][c] = sum_of(frame.moves_with(a, c), frame.J[a][c], there, product_if(there, left.value, right.template J<c>()));
          frame.moves[a] |= bit(there, c);
        });
      });
    });
  }
};

}  // namespace qdot::detail
