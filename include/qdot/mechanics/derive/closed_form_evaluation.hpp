#pragma once
// SPDX-License-Identifier: MIT
//
// q̈ by formulas that the compiler has derived.
//
// Each line of a closed form (mechanics/derive/closed_form.hpp) becomes one line of code. What letters stand for, masses and lengths and what is
// computed from them alone, is computed when an object is made, and read from its table.
//
// Applied forces Q are added to r. A pivot that is not positive, a number that is not finite and a state at which T or V has no value are left
// to the general way, which names what is wrong.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <type_traits>

#include "qdot/ad/lagrange/euler_lagrange_math.hpp"
#include "qdot/ad/unroll.hpp"
#include "qdot/mechanics/derive/closed_form.hpp"
#include "qdot/mechanics/equations/block_solve.hpp"
#include "qdot/mechanics/equations/straight_line.hpp"

namespace qdot::detail {

// The coefficients of an object.
template <class Form, std::size_t count_T, std::size_t count_V, std::size_t count>
void write_values(const std::array<double, count_T>& T, const std::array<double, count_V>& V, std::array<double, count>& c) {
  std::array<double, count_T + count_V> parameters;
  std::copy(T.begin(), T.end(), parameters.begin());
  std::copy(V.begin(), V.end(), parameters.begin() + count_T);
  formula::write_coefficients(Form::form.coefficient, Form::coefficients, parameters.data(), c.data());
}

/// The same; false when a pivot is zero or negative, or all that rounding has left of larger numbers: no way for this object.
template <class Form, std::size_t count_T, std::size_t count_V, std::size_t count>
bool coefficients_written(const std::array<double, count_T>& T, const std::array<double, count_V>& V, std::array<double, count>& c) {
  write_values<Form>(T, V, c);
  std::array<double, count> magnitude{};
  formula::write_magnitudes(Form::form.coefficient, Form::coefficients, c.data(), magnitude.data());
  for (int k = 0; k < Form::extent.eliminated; ++k) {
    const auto& step = Form::form.eliminated[k];
    const CoefficientUse& factor = step.pivot_factor;
    if (step.has_constant_pivot && !((factor.line < 0 ? factor.literal : c[static_cast<std::size_t>(factor.line)]) > 0.0)) return false;
    if (factor.line < 0) continue;
    const auto line = static_cast<std::size_t>(factor.line);
    if (!(std::abs(c[line]) > singular_pivot<double>(Form::extent.eliminated + Form::extent.kept) * magnitude[line])) return false;
  }
  return true;
}

// √(a² + b²); with care where a square may leave the range of double.
template <class Number>
[[gnu::always_inline]] inline Number root_of_squares(const Number& a, const Number& b) {
  using std::hypot, std::sqrt;
  if constexpr (std::is_same_v<Number, double>) {
    const double square = a * a + b * b;
    if (square > 0x1p-900 && square < 0x1p1000) [[likely]] return sqrt(square);
  }
  return hypot(a, b);
}

// f(a, b) with the C library's sine and cosine, which the compiler may merge.
template <formula::Function f, class Number>
[[gnu::always_inline]] inline Number function_value(const Number& a, const Number& b) {
  using formula::Function;
  if constexpr (f == Function::sin && std::is_same_v<Number, double>) return shared_sine(a);
  else if constexpr (f == Function::cos && std::is_same_v<Number, double>) return shared_cosine(a);
  else if constexpr (f == Function::hypot) return root_of_squares(a, b);
  else return formula::applied<f>(a, b);
}

// xᵉ; a root and a division where that is all it takes.
template <int twice, class Number>
[[gnu::always_inline]] inline Number half_power(const Number& x) {
  using std::sqrt;
  if constexpr (twice < 0) {
    return 1.0 / half_power<-twice>(x);
  } else if constexpr (twice == 1) {
    return sqrt(x);
  } else if constexpr (twice == 2) {
    return x;
  } else if constexpr (twice % 4 == 0) {
    const Number half = half_power<twice / 2>(x);
    return half * half;
  } else {
    return x * half_power<twice - 2>(x);
  }
}

// Lines of `Form::form` from `first` to before `end` into x. Inputs are q, q̇, t, and a where a form has accelerations.
template <int n, class Form, int first, int end, class Number>
[[gnu::always_inline]] inline void write_lines(const double* c, const Number* q, const Number* qdot, const Number& t, const Number* a, Number* x) {
  constexpr const auto& form = Form::form;
  const auto times = [c](auto i, auto which, const Number& of) __attribute__((always_inline)) -> Number {
    constexpr CoefficientUse u = form.line[i].*which();
    if constexpr (u.is(1.0)) return of;
    else if constexpr (u.is(-1.0)) return -of;
    else if constexpr (u.line < 0) return u.literal * of;
    else return c[u.line] * of;
  };
  const auto offset = [c](auto i) __attribute__((always_inline)) -> double {
    constexpr CoefficientUse u = form.line[i].c;
    if constexpr (u.line < 0) return u.literal;
    else return c[u.line];
  };
  constexpr std::integral_constant<CoefficientUse ClosedFormLine::*, &ClosedFormLine::ca> A;
  constexpr std::integral_constant<CoefficientUse ClosedFormLine::*, &ClosedFormLine::cb> B;
  unroll<end - first>([&](auto after) __attribute__((always_inline)) {
    constexpr std::integral_constant<int, first + after> i;
    constexpr ClosedFormLine w = form.line[i];
    if constexpr (w.kind == formula::Kind::constant) {
      x[i] = Number(offset(i));
    } else if constexpr (w.kind == formula::Kind::variable) {
      if constexpr (w.a < n) x[i] = q[w.a];
      else if constexpr (w.a < 2 * n) x[i] = qdot[w.a - n];
      else if constexpr (w.a == 2 * n) x[i] = t;
      else x[i] = a[w.a - 2 * n - 1];
    } else if constexpr (w.kind == formula::Kind::product) {
      x[i] = x[w.a] * x[w.b];
    } else if constexpr (w.kind == formula::Kind::quotient) {
      x[i] = x[w.a] / x[w.b];
    } else if constexpr (w.kind == formula::Kind::power) {
      constexpr double twice = 2.0 * w.c.literal;
      if constexpr (w.c.line < 0 && twice >= -16.0 && twice <= 16.0 && twice == static_cast<double>(static_cast<int>(twice))) {
        x[i] = half_power<static_cast<int>(twice)>(x[w.a]);
      } else {
        using std::pow;
        x[i] = pow(x[w.a], offset(i));
      }
    } else if constexpr (w.kind == formula::Kind::function) {
      x[i] = function_value<w.function>(x[w.a], x[w.b < 0 ? w.a : w.b]);
    } else if constexpr (w.b < 0) {
      if constexpr (w.c.is(0.0)) x[i] = times(i, A, x[w.a]);
      else x[i] = times(i, A, x[w.a]) + offset(i);
    } else {
      Number sum;
      if constexpr (w.ca == w.cb && !w.ca.is(1.0)) sum = times(i, A, x[w.a] + x[w.b]);
      else if constexpr (w.cb.is(-1.0)) sum = times(i, A, x[w.a]) - x[w.b];
      else if constexpr (w.ca.is(-1.0)) sum = times(i, B, x[w.b]) - x[w.a];
      else sum = times(i, A, x[w.a]) + times(i, B, x[w.b]);
      if constexpr (w.c.is(0.0)) x[i] = sum;
      else x[i] = sum + offset(i);
    }
  });
}

// Whether T and V have a value where these lines are.
template <class Form, int count, class Number>
[[gnu::always_inline]] inline auto have_values(const Number* x) {
  decltype(x[0] > x[0]) good = true;
  unroll<count>([&](auto i) __attribute__((always_inline)) {
    constexpr formula::Domain domain = Form::form.line[i].domain;
    if constexpr (domain == formula::Domain::positive) good &= x[i] > 0.0;
    else if constexpr (domain == formula::Domain::nonnegative) good &= x[i] >= 0.0;
    else if constexpr (domain == formula::Domain::nonzero) good &= x[i] != 0.0;
  });
  return good;
}

// Single numbers that are read in pairs cost a spherical pendulum 3 of its 14 ns. Clang leaves that to the source; g++ is better left to itself.
#ifdef __clang__
inline constexpr bool writes_pairs = true;
#else
inline constexpr bool writes_pairs = false;
#endif
template <int n, class Number>
[[gnu::always_inline]] inline void write_vector(Number* to, const Number* from) {
  if constexpr (writes_pairs && std::is_same_v<Number, double>) {
    write_in_pairs<n>(to, from);
  } else {
    unroll<n>([&](auto k) __attribute__((always_inline)) { to[k] = from[k]; });
  }
}

/// q̈ of the form `Form::form` into `qddot`; what is false then is not an acceleration.
///
/// @param c  the coefficients, Form::form.size.coefficients numbers
/// @param forces  NoForces, or what writes n applied generalized forces: forces(q, qdot, Q), compiled together with the lines
template <int n, class Form, class Forces, class Number>
[[gnu::flatten]] inline auto closed_form_of_acceleration(const double* c, const Number* q, const Number* qdot, const Number& t, const Forces& forces,
                                                         Number* qddot) {
  constexpr bool forced = !std::is_same_v<Forces, NoForces>;
  constexpr const auto& form = Form::form;
  constexpr int kept = form.size.kept;
  using Truth = decltype(q[0] > q[0]);
  Truth good = true;
  Number out[n];
  Number x[form.size.lines + 1];
  // Copies, so that the compiler sees that lines and forces read the same numbers.
  Number at[forced ? n : 1], velocity[forced ? n : 1], applied[n];
  if constexpr (forced) {
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      at[i] = q[i];
      velocity[i] = qdot[i];
    });
    write_lines<n, Form, 0, form.size.lines>(c, at, velocity, t, at, x);
    forces(at, velocity, applied);
  } else {
    write_lines<n, Form, 0, form.size.lines>(c, q, qdot, t, q, x);
  }
  good &= have_values<Form, form.size.lines>(x);
  // Applied forces go through the elimination as r does.
  if constexpr (forced) {
    unroll<form.size.eliminated>([&](auto k) __attribute__((always_inline)) {
      constexpr auto step = form.eliminated[k];
      unroll<step.last - step.first>([&](auto i) __attribute__((always_inline)) {
        applied[form.coordinate[step.first + i]] -= x[form.factor[step.first + i]] * applied[step.coordinate];
      });
    });
  }
  Number right[kept + 1];
  unroll<kept>([&](auto i) __attribute__((always_inline)) {
    if constexpr (forced) right[i] = x[form.right[i]] + applied[form.kept[i]];
    else right[i] = x[form.right[i]];
  });
  unroll<kept>([&](auto i) __attribute__((always_inline)) {
    constexpr int mass = form.mass[triangle_index(i, i)], before = form.diagonal[i];
    if constexpr (mass >= 0 && before >= 0) good &= x[mass] > singular_pivot<double>(n) * x[before];
  });
  if constexpr (kept == 1 && form.mass[0] < 0) {
    good = false;
    out[form.kept[0]] = 0.0;
  } else if constexpr (kept == 1) {
    const Number& pivot = x[form.mass[0]];
    good &= pivot > 0.0;
    out[form.kept[0]] = right[0] / pivot;
  } else if constexpr (kept > 12 && std::is_same_v<Number, double>) {
    constexpr int blocks = (kept + 3) / 4;
    double M[16 * blocks * blocks], r[4 * blocks];
    unroll<kept>([&](auto i) __attribute__((always_inline)) {
      r[i] = right[i];
      unroll<i + 1>([&](auto j) __attribute__((always_inline)) {
        constexpr int node = form.mass[triangle_index(i, j)];
        M[4 * blocks * i + j] = node < 0 ? 0.0 : x[node < 0 ? 0 : node];
      });
    });
    good &= solved_by_blocks<blocks>(kept, M, r, singular_pivot<double>(n));
    for (int i = 0; i < kept; ++i) out[form.kept[i]] = r[i];
  } else if constexpr (kept > 1) {
    constexpr ComponentMask present = [] {
      ComponentMask mask = 0;
      for (int k = 0; k < kept * (kept + 1) / 2 && k < 64; ++k)
        if (Form::form.mass[k] >= 0) mask |= ComponentMask(1) << k;
      return mask;
    }();
    Number M[kept * (kept + 1) / 2], r[kept];
    unroll<kept>([&](auto i) __attribute__((always_inline)) { r[i] = right[i]; });
    unroll<kept*(kept + 1) / 2>([&](auto k) __attribute__((always_inline)) {
      constexpr int node = form.mass[k];
      if constexpr (node < 0) M[k] = 0.0;
      else M[k] = x[node];
    });
    good &= solved_in_place<kept>(M, r, singular_pivot<double>(n), present);
    unroll<kept>([&](auto i) __attribute__((always_inline)) { out[form.kept[i]] = r[i]; });
  }
  unroll<form.size.eliminated>([&](auto done) __attribute__((always_inline)) {
    constexpr auto step = form.eliminated[form.size.eliminated - 1 - done];
    if constexpr (!step.has_constant_pivot) good &= x[step.pivot] > 0.0;
    Number a = x[step.acceleration];
    if constexpr (forced) a += applied[step.coordinate] / x[step.pivot];
    unroll<step.last - step.first>([&](auto i) __attribute__((always_inline)) { a -= x[form.factor[step.first + i]] * out[form.coordinate[step.first + i]]; });
    out[step.coordinate] = a;
  });
  Number sum = out[0];
  unroll<n - 1>([&](auto i) __attribute__((always_inline)) { sum += out[i + 1]; });
  good &= is_finite(sum);
  write_vector<n>(qddot, out);
  return good;
}

/// q̈ of an object into `out`; false where this is not the way.
template <int n, class E, class Forces = NoForces>
inline bool closed_form_acceleration(const E& e, const double* q, const double* qdot, double t, double* out, const Forces& forces = {}) {
  return e.has_closed_form() && closed_form_of_acceleration<n, typename E::ClosedForm>(e.closed_form_coefficients(), q, qdot, t, forces, out);
}

}  // namespace qdot::detail
