#pragma once
// SPDX-License-Identifier: MIT
//
// What T is as a function of an angular velocity.
//
// A T that asks for the angular velocity Ω of a known rotation (known_rotation.hpp) and squares it would be multiplied out in the q̇ of the rotation,
// three rows of W with itself, while in Ω it has but moments of inertia. So Ω gets directions of its own beside those of q̇: a number of this kind is a scalar
// of Lagrange's equations (ad/lagrange/euler_lagrange.hpp) with n + 3 of them. On these
//
//     ∂Ω_a/∂Ω_b = 1 or 0 ,     D Ω = bend ,     X Ω_a = Ω × e   (X Ω = Ω × W in directions of q̇),
//
// since g and X are covectors, and the rules of sums, products and functions hold in whatever basis these are written. W makes them such of q̇ alone,
//
//     X ← X_q + Wᵀ X_Ω ,     H ← H_qq + Wᵀ H_Ωq + H_qΩ W + Wᵀ H_ΩΩ W ,
//
// in the end, or where somebody asks for a scalar of q̇.

#include <type_traits>

#include "qdot/ad/lagrange/euler_lagrange_math.hpp"
#include "qdot/mechanics/equations/body_rates.hpp"

namespace qdot::detail {

// Most coordinates for which it is done so: compile time.
inline constexpr int turning_energy_limit = 4;

// Rotation is the type of the functor that Ω is of: numbers of another one meet as scalars of q̇.
template <int n, class Rotation>
struct TurningEnergy : EulerLagrange<n + 3> {
  using Self = TurningEnergy;
  using Wide = EulerLagrange<n + 3>;
  using Narrow = EulerLagrange<n>;

  BodyFrame<n> body;
  Present turns;  // whether there is a body

  TurningEnergy() = default;
  template <class Constant>
    requires std::is_arithmetic_v<Constant>
  [[gnu::always_inline]] TurningEnergy(Constant constant) : Wide(constant), turns(0) {}
  [[gnu::always_inline]] TurningEnergy(const Narrow& x) : Wide(x.value), turns(0) {
    this->rate = x.rate;
    this->has_rate = x.has_rate;
    this->half = x.half;
    this->g_mask = x.g_mask;
    this->x_mask = x.x_mask;
    this->h_mask = x.h_mask;
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      this->template g<i>() = x.template g<i>();
      this->template x<i>() = x.template x<i>();
    });
    unroll<n*(n + 1) / 2>([&](auto k) __attribute__((always_inline)) { this->template h<k>() = x.template h<k>(); });
  }

  // Ω_a of a body.
  template <int a>
  [[gnu::always_inline]] static Self of(const BodyRates<n>& rates) {
    constexpr int b = (a + 1) % 3, c = (a + 2) % 3;
    Self r(rates.omega[a]);
    r.body = rates.frame;
    r.turns = 1;
    r.rate = rates.bend[a];
    r.has_rate = 1;
    r.template g<n + a>() = 1.0;
    r.g_mask = bit(1, n + a);
    r.template x<n + b>() = -rates.omega[c];
    r.template x<n + c>() = rates.omega[b];
    r.x_mask = bit(1, n + b) | bit(1, n + c);
    return r;
  }

  // The scalar of q̇.
  [[gnu::always_inline]] operator Narrow() const {
    const Wide f = Wide::whole();
    Narrow r(f.value);
    r.rate = f.rate;
    r.has_rate = f.has_rate;
    r.g_mask = f.g_mask & bit(1, 63);
    double turned[3][n];
    Present there[3][n];
    unroll<3>([&](auto a) __attribute__((always_inline)) {
      unroll<n>([&](auto j) __attribute__((always_inline)) {
        turned[a][j] = 0.0;
        there[a][j] = 0;
        unroll<3>([&](auto b) __attribute__((always_inline)) {
          constexpr int k = a > b ? index(n + a, n + b) : index(n + b, n + a);
          const Present both = has(f.h_mask, k) & body.moves_with(b, j);
          turned[a][j] = sum_of(there[a][j], turned[a][j], both, product_if(both, f.template h<k>(), body.J[b][j]));
          there[a][j] |= both;
        });
      });
    });
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      double g = f.template g<i>(), x = f.template x<i>();
      Present has_g = has(f.g_mask, i), has_x = has(f.x_mask, i);
      unroll<3>([&](auto a) __attribute__((always_inline)) {
        const Present slope = has(f.g_mask, n + a) & body.moves_with(a, i), force = has(f.x_mask, n + a) & body.moves_with(a, i);
        g = sum_of(has_g, g, slope, product_if(slope, f.template g<n + a>(), body.J[a][i]));
        x = sum_of(has_x, x, force, product_if(force, f.template x<n + a>(), body.J[a][i]));
        has_g |= slope;
        has_x |= force;
      });
      r.template g<i>() = g;
      r.template x<i>() = x;
      r.g_mask |= bit(has_g, i);
      r.x_mask |= bit(has_x, i);
      unroll<i + 1>([&](auto j) __attribute__((always_inline)) {
        constexpr int ij = index(i, j);
        double h = f.template h<ij>();
        Present any = has(f.h_mask, ij);
        unroll<3>([&](auto a) __attribute__((always_inline)) {
          constexpr int ai = index(n + a, i), aj = index(n + a, j);
          const Present first = has(f.h_mask, aj) & body.moves_with(a, i), second = has(f.h_mask, ai) & body.moves_with(a, j),
                        both = body.moves_with(a, i) & there[a][j];
          h = sum_of(any, h, first, product_if(first, f.template h<aj>(), body.J[a][i]));
          any |= first;
          h = sum_of(any, h, second, product_if(second, f.template h<ai>(), body.J[a][j]));
          any |= second;
          h = sum_of(any, h, both, product_if(both, turned[a][j], body.J[a][i]));
          any |= both;
        });
        r.template h<ij>() = h;
        r.h_mask |= bit(any, ij);
      });
    });
    return r;
  }

  [[gnu::always_inline]] Self whole() const { return Self(Wide::whole(), *this, *this); }
  [[gnu::always_inline]] Self chain(double f, double slope, double curvature) const { return Self(Wide::chain(f, slope, curvature), *this, *this); }

  [[gnu::always_inline]] friend Self operator+(const Self& a, const Self& b) { return Self(wide(a) + wide(b), a, b); }
  [[gnu::always_inline]] friend Self operator-(const Self& a, const Self& b) { return Self(wide(a) - wide(b), a, b); }
  [[gnu::always_inline]] friend Self operator*(const Self& a, const Self& b) {
#ifndef __clang__
    if (&a == &b) return Self(wide(a) * wide(a), a, a);
#endif
    return Self(wide(a) * wide(b), a, b);
  }
  [[gnu::always_inline]] friend Self operator/(const Self& a, const Self& b) { return Self(wide(a) / wide(b), a, b); }
  [[gnu::always_inline]] friend Self operator-(const Self& a) { return Self(-wide(a), a, a); }
  [[gnu::always_inline]] friend Self operator+(const Self& a) { return a; }
  // Beside scalars of q̇, which both could become the other.
  [[gnu::always_inline]] friend Self operator+(const Self& a, const Narrow& b) { return a + Self(b); }
  [[gnu::always_inline]] friend Self operator-(const Self& a, const Narrow& b) { return a - Self(b); }
  [[gnu::always_inline]] friend Self operator*(const Self& a, const Narrow& b) { return a * Self(b); }
  [[gnu::always_inline]] friend Self operator/(const Self& a, const Narrow& b) { return a / Self(b); }
  [[gnu::always_inline]] friend Self operator+(const Narrow& a, const Self& b) { return Self(a) + b; }
  [[gnu::always_inline]] friend Self operator-(const Narrow& a, const Self& b) { return Self(a) - b; }
  [[gnu::always_inline]] friend Self operator*(const Narrow& a, const Self& b) { return Self(a) * b; }
  [[gnu::always_inline]] friend Self operator/(const Narrow& a, const Self& b) { return Self(a) / b; }
  // Beside plain numbers.
  template <class Number>
    requires std::is_arithmetic_v<Number>
  [[gnu::always_inline]] friend Self operator+(const Self& a, Number b) { return Self(wide(a) + Wide(b), a, a); }
  template <class Number>
    requires std::is_arithmetic_v<Number>
  [[gnu::always_inline]] friend Self operator+(Number a, const Self& b) { return Self(Wide(a) + wide(b), b, b); }
  template <class Number>
    requires std::is_arithmetic_v<Number>
  [[gnu::always_inline]] friend Self operator-(const Self& a, Number b) { return Self(wide(a) - Wide(b), a, a); }
  template <class Number>
    requires std::is_arithmetic_v<Number>
  [[gnu::always_inline]] friend Self operator-(Number a, const Self& b) { return Self(Wide(a) - wide(b), b, b); }
  template <class Number>
    requires std::is_arithmetic_v<Number>
  [[gnu::always_inline]] friend Self operator*(const Self& a, Number b) { return Self(wide(a) * Wide(b), a, a); }
  template <class Number>
    requires std::is_arithmetic_v<Number>
  [[gnu::always_inline]] friend Self operator*(Number a, const Self& b) { return Self(Wide(a) * wide(b), b, b); }
  template <class Number>
    requires std::is_arithmetic_v<Number>
  [[gnu::always_inline]] friend Self operator/(const Self& a, Number b) { return Self(wide(a) / Wide(b), a, a); }
  template <class Number>
    requires std::is_arithmetic_v<Number>
  [[gnu::always_inline]] friend Self operator/(Number a, const Self& b) { return Self(Wide(a) / wide(b), b, b); }
  // Numbers of other rotations meet as scalars of q̇.
  template <class Other>
  [[gnu::always_inline]] friend Narrow operator+(const Self& a, const TurningEnergy<n, Other>& b) { return Narrow(a) + Narrow(b); }
  template <class Other>
  [[gnu::always_inline]] friend Narrow operator-(const Self& a, const TurningEnergy<n, Other>& b) { return Narrow(a) - Narrow(b); }
  template <class Other>
  [[gnu::always_inline]] friend Narrow operator*(const Self& a, const TurningEnergy<n, Other>& b) { return Narrow(a) * Narrow(b); }
  template <class Other>
  [[gnu::always_inline]] friend Narrow operator/(const Self& a, const TurningEnergy<n, Other>& b) { return Narrow(a) / Narrow(b); }
  template <class Number>
  [[gnu::always_inline]] Self& operator+=(const Number& o) { return *this = *this + o; }
  template <class Number>
  [[gnu::always_inline]] Self& operator-=(const Number& o) { return *this = *this - o; }
  template <class Number>
  [[gnu::always_inline]] Self& operator*=(const Number& o) { return *this = *this * o; }
  template <class Number>
  [[gnu::always_inline]] Self& operator/=(const Number& o) { return *this = *this / o; }

 private:
  static constexpr int index(int i, int j) { return i * (i + 1) / 2 + j; }
  [[gnu::always_inline]] static const Wide& wide(const Self& x) { return x; }

  // The result of an operation on two numbers of which each may have the body. Two bodies of one type, a functor that is called with other
  // coordinates or captures: a mask that the compiler must not know, and another way is taken.
  [[gnu::always_inline]] TurningEnergy(const Wide& result, const Self& a, const Self& b) : Wide(result), turns(a.turns | b.turns) {
    body.choose(a.turns, a.body, b.turns, b.body);
    if (&a != &b) this->g_mask |= unknown_if(a.turns & b.turns & (1U ^ a.body.known_to_be(b.body)));
  }
};

template <int n, class Rotation>
struct is_euler_lagrange<TurningEnergy<n, Rotation>> : std::true_type {};

template <class S>
inline constexpr bool is_turning_energy = false;
template <int n, class Rotation>
inline constexpr bool is_turning_energy<TurningEnergy<n, Rotation>> = true;

}  // namespace qdot::detail
