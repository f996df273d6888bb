#pragma once
// SPDX-License-Identifier: MIT
//
// Equations of a body whose turning has inertia in nothing but its own angular velocity: Euler's, and not those of its coordinates.
//
// Where the coordinates of a known rotation are in M by Ω = W ṗ alone, M of them is Wᵀ I W, and nobody needs it. With Ω̇ for their accelerations
//
//     I Ω̇ = X_Ω + W⁻ᵀ (r + Q)_p ,      p̈ = W⁻¹ Ω̇      (+ μ p for four of a quaternion, whose length L says nothing of) .
//
// Ω stands in the places of the rotation's coordinates, the fourth, μ, in that of the last. X_Ω holds what Ω̇ is without accelerations
// (body_rates.hpp), so that p̈ is all of it. Near a pole, where W is nearly singular, the equations of the coordinates are asked, which
// name what is wrong.

#include "qdot/ad/unroll.hpp"
#include "qdot/mechanics/equations/body_rates.hpp"

namespace qdot::detail {

// W is left alone where the square of its smallest singular value is below this.
inline constexpr double regular_turning = 1e-6;

template <int n>
struct FreeTurn {
  static constexpr int pairs = n * (n + 1) / 2;
  static constexpr int index(int i, int j) { return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i; }

  BodyFrame<n> frame;
  double M[pairs], r[n];
  ComponentMask present, forces;  // which entries of M and r may be other than zero
  Present has_length_inertia;     // whether L determines μ
  bool is_free;                   // whether M leaves the turning alone

  [[gnu::always_inline]] ComponentMask own() const { return frame.place[0] | frame.place[1] | frame.place[2] | frame.place[3]; }

  // From what other terms have of M and of r, and from I and X_Ω.
  [[gnu::always_inline]] void set(const BodyFrame<n>& of, const double* mass, ComponentMask mass_present, const double* force, ComponentMask force_present,
                                  const double (&moments)[6], ComponentMask I_present, const double (&X)[3]) {
    frame = of;
    present = forces = 0;
    Present coupled = 0, inner = 0;
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      r[i] = 0.0;
      unroll<3>([&](auto a) __attribute__((always_inline)) {
        r[i] = has(frame.place[a], i) ? X[a] : r[i];
        forces |= bit(has(frame.place[a], i), i);
      });
      unroll<i + 1>([&](auto j) __attribute__((always_inline)) {
        constexpr int k = index(i, j);
        const Present there = has(mass_present, k);
        coupled |= there & (has(own(), i) ^ has(own(), j));
        inner |= there & has(own(), i) & has(own(), j);
        const Present other = there & (1U ^ has(own(), i));
        M[k] = other ? mass[k] : 0.0;
        present |= bit(other, k);
        unroll<3>([&](auto a) __attribute__((always_inline)) {
          unroll<3>([&](auto b) __attribute__((always_inline)) {
            const Present here = has(frame.place[a], i) & has(frame.place[b], j) & has(I_present, index(a, b));
            M[k] = here ? moments[index(a, b)] : M[k];
            present |= bit(here, k);
          });
        });
      });
    });
    add(force, force_present);
    has_length_inertia = inner & (frame.place[3] != 0 ? 1U : 0U);
    double length_inertia = 1.0;  // without one μ is decided elsewhere
    bool along_length = true;
    if (has_length_inertia) along_length = inertia_of_length(mass, mass_present, length_inertia);
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      M[index(i, i)] = has(frame.place[3], i) ? length_inertia : M[index(i, i)];
      present |= bit(has(frame.place[3], i), index(i, i));
    });
    is_free = own() != 0 && !(coupled | (inner & (1U ^ has_length_inertia))) && along_length;
  }

  // r += Q, a covector in the coordinates of which `mask` entries may be other than zero.
  [[gnu::always_inline]] void add(const double* Q, ComponentMask mask = ~ComponentMask(0)) {
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      const Present other = has(mask & ~own(), i);
      r[i] = sum_of(has(forces, i), r[i], other, Q[i]);
      forces |= bit(other, i);
      unroll<4>([&](auto a) __attribute__((always_inline)) {
        double sum = 0.0;
        Present any = 0;
        unroll<n>([&](auto j) __attribute__((always_inline)) {
          const Present both = has(frame.place[a], i) & has(own() & mask, j) & may_differ_from_zero(way<a>(j));
          sum = sum_of(any, sum, both, product_if(both, way<a>(j), Q[j]));
          any |= both;
        });
        r[i] = sum_of(has(forces, i), r[i], any, a < 3 ? frame.scale * sum : sum);
        forces |= bit(any, i);
      });
    });
  }

  // A torque along the axes of a body, if it is this one, and false if not.
  [[gnu::always_inline]] bool add_torque(const BodyFrame<n>& of, const double (&torque)[3]) {
    if (!frame.known_to_be(of)) return false;
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      unroll<3>([&](auto a) __attribute__((always_inline)) { r[i] = has(frame.place[a], i) ? r[i] + torque[a] : r[i]; });
    });
    return true;
  }

  // q̈ from what stands for it, without the motion along μ.
  [[gnu::always_inline]] void back(const double* y, double* qddot) const {
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      double sum = has(own(), i) ? 0.0 : y[i];
      Present any = 1U ^ has(own(), i);
      unroll<3>([&](auto a) __attribute__((always_inline)) {
        unroll<n>([&](auto j) __attribute__((always_inline)) {
          const Present both = has(own(), i) & has(frame.place[a], j) & may_differ_from_zero(way<a>(i));
          sum = sum_of(any, sum, both, product_if(both, way<a>(i), y[j]));
          any |= both;
        });
      });
      qddot[i] = has(own(), i) ? frame.scale * sum : sum;
    });
  }
  // q̈ += μ p
  [[gnu::always_inline]] void add_along(double mu, double* qddot) const {
    unroll<n>([&](auto i) __attribute__((always_inline)) { qddot[i] = sum_of(1U, qddot[i], has(own(), i), product_if(has(own(), i), mu, frame.along[i])); });
  }
  // The entry of y or r that stands for μ.
  [[gnu::always_inline]] double of_length(const double* y) const {
    double mu = 0.0;
    unroll<n>([&](auto i) __attribute__((always_inline)) { mu = has(frame.place[3], i) ? y[i] : mu; });
    return mu;
  }

 private:
  template <int a>
  [[gnu::always_inline]] double way(int i) const {
    if constexpr (a < 3) return frame.inverse[i][a];
    else return frame.along[i];
  }

  // Whether the rest of M is κ p pᵀ to rounding, and if so pᵀ M p.
  [[gnu::always_inline]] bool inertia_of_length(const double* mass, ComponentMask mass_present, double& inertia) const {
    double trace = 0.0, square = 0.0, rest = 0.0;
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      const Present there = has(own(), i) & has(mass_present, index(i, i));
      trace = sum_of(1U, trace, there, mass[index(i, i)]);
      square = sum_of(1U, square, has(own(), i), product_if(has(own(), i), frame.along[i], frame.along[i]));
    });
    const double kappa = trace / square;
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      unroll<i + 1>([&](auto j) __attribute__((always_inline)) {
        constexpr int k = index(i, j);
        const Present both = has(own(), i) & has(own(), j);
        const double left = both ? (has(mass_present, k) ? mass[k] : 0.0) - kappa * frame.along[i] * frame.along[j] : 0.0;
        rest = sum_of(1U, rest, both, product_if(both, left, left));
      });
    });
    constexpr double rounding = 16.0 * 2.3e-16;
    inertia = trace * square;
    return rest <= rounding * rounding * trace * trace;
  }
};

}  // namespace qdot::detail
