#pragma once
// SPDX-License-Identifier: MIT
//
// Random formulas as a user's functors, with the signatures that the library tells apart.

#include <array>
#include <cstddef>
#include <type_traits>

#include "formula.hpp"
#include "oracle.hpp"
#include "qdot/ad/vector.hpp"
#include "qdot/mechanics/velocity.hpp"

namespace fuzz {

template <class Q>
using ScalarOf = typename std::remove_cvref_t<Q>::Scalar;

// ── interpreted: one type for all formulas ─────────────────────────────────────────────────────

struct TOfVelocity {
  Term f;
  auto operator()(const auto& v) const { return f.of<ScalarOf<decltype(v)>>(v, v, 0.0); }
};
struct TOfState {
  Term f;
  auto operator()(const auto& q, const auto& v) const { return f.of<ScalarOf<decltype(q)>>(q, v, 0.0); }
};
struct TOfStateAndTime {
  Term f;
  auto operator()(const auto& q, const auto& v, const auto& t) const { return f.of<ScalarOf<decltype(q)>>(q, v, t); }
};
struct OfPosition {
  Term f;
  auto operator()(const auto& q) const { return f.of<ScalarOf<decltype(q)>>(q, q, 0.0); }
};
struct OfPositionAndTime {
  Term f;
  auto operator()(const auto& q, const auto& t) const { return f.of<ScalarOf<decltype(q)>>(q, q, t); }
};

// ── written: a type for each formula ───────────────────────────────────────────────────────────

enum class Style { nested, unrolled, looped };
enum class Arguments { velocity, state, state_and_time };  // of T; V has the time where T has it

constexpr Inputs inputs_of(int n, Arguments arguments) { return {n, arguments != Arguments::velocity, false, arguments == Arguments::state_and_time}; }

/// T and V that a seed has made, their constants in the object.
template <std::uint64_t seed, int n, Arguments arguments, Style style>
struct Written {
  static constexpr Formula formula_T = random_kinetic_energy(2 * seed, inputs_of(n, arguments), n < 3 ? 2 : 1);
  static constexpr Formula formula_V = random_formula(2 * seed + 1, {n, true, false, arguments == Arguments::state_and_time}, 3);
  std::array<double, formula_T.constants + 1> constants_T = defaults<formula_T.constants + 1>(0.37);
  std::array<double, formula_V.constants + 1> constants_V = defaults<formula_V.constants + 1>(0.53);

  constexpr auto T(const auto& v) const requires(arguments == Arguments::velocity) { return value<formula_T>(constants_T.data(), v, v, 0.0); }
  constexpr auto T(const auto& q, const auto& v) const requires(arguments == Arguments::state) { return value<formula_T>(constants_T.data(), q, v, 0.0); }
  constexpr auto T(const auto& q, const auto& v, const auto& t) const requires(arguments == Arguments::state_and_time) {
    return value<formula_T>(constants_T.data(), q, v, t);
  }
  constexpr auto V(const auto& q) const requires(arguments != Arguments::state_and_time) { return value<formula_V>(constants_V.data(), q, q, 0.0); }
  constexpr auto V(const auto& q, const auto& t) const requires(arguments == Arguments::state_and_time) {
    return value<formula_V>(constants_V.data(), q, q, t);
  }

 private:
  template <int count>
  static constexpr std::array<double, count> defaults(double step) {
    std::array<double, count> c{};
    for (int i = 0; i < count; ++i) c[static_cast<std::size_t>(i)] = 0.3 + step * ((i * 7) % 5);
    return c;
  }
  template <const Formula& f>
  [[gnu::always_inline]] static constexpr auto value(const double* constants, const auto& q, const auto& v, const auto& t) {
    using S = ScalarOf<decltype(q)>;
    const auto input = [&](int i) __attribute__((always_inline)) -> S {
      if (i < n) return q[i];
      if (i < 2 * n) return v[i - n];
      return S(t);
    };
    if constexpr (style == Style::nested) return S(nested<f, f.count - 1>(constants, input));
    else if constexpr (style == Style::unrolled) return unrolled<f, S>(constants, input);
    else return looped<S>(f, constants, input);
  }
};

/// Two masses in the plane and a turning body: places that a seed has made.
template <std::uint64_t seed, int n, bool moved, Style style>
struct WrittenPlaces {
  static constexpr std::size_t count = 5;
  static constexpr Inputs inputs{n, true, false, moved};
  template <std::size_t k>
  static constexpr Formula formula = random_formula(10 * seed + k, inputs, k < 4 ? 2 : 1, Grammar::without_sides);
  std::array<Constants, count> constants = defaults();
  double m1 = 0.7, m2 = 1.3, m3 = 0.9, inertia = 0.4;

  constexpr void operator()(const auto& q, auto& bodies) const requires(!moved) { place(q, 0.0, bodies); }
  constexpr void operator()(const auto& q, const auto& t, auto& bodies) const requires(moved) { place(q, t, bodies); }

 private:
  static constexpr std::array<Constants, count> defaults() {
    std::array<Constants, count> c{};
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t i = 0; i < most_constants; ++i) c[k][i] = 0.3 + 0.17 * static_cast<double>((3 * i + k) % 5);
    return c;
  }
  template <std::size_t k>
  [[gnu::always_inline]] constexpr auto at(const auto& q, const auto& t) const {
    using S = ScalarOf<decltype(q)>;
    const auto input = [&](int i) __attribute__((always_inline)) -> S {
      if (i < n) return q[i];
      return S(t);
    };
    if constexpr (style == Style::nested) return S(nested<formula<k>, formula<k>.count - 1>(constants[k].data(), input));
    else if constexpr (style == Style::unrolled) return unrolled<formula<k>, S>(constants[k].data(), input);
    else return looped<S>(formula<k>, constants[k].data(), input);
  }
  [[gnu::always_inline]] constexpr void place(const auto& q, const auto& t, auto& bodies) const {
    bodies.point_mass(m1, qdot::vector(at<0>(q, t), at<1>(q, t)));
    bodies.point_mass(m2, qdot::vector(at<2>(q, t), at<3>(q, t)));
    bodies.planar_body(m3, inertia, qdot::vector(at<1>(q, t), at<2>(q, t)), at<4>(q, t));
  }
};

}  // namespace fuzz
