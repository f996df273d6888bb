#pragma once
// SPDX-License-Identifier: MIT
//
// Dual numbers: exact derivatives from ordinary code.
//
//     x = a + b₁ε₁ + … + b_N ε_N ,   ε_i ε_j = 0 :        f(a + Σ b_i ε_i) = f(a) + f′(a) Σ b_i ε_i        (Taylor's series)
//     x y = a c + (a d + c b) ε ,    x / y = a/c + (b − (a/c) d)/c ε ,    sin x = sin a + (cos a) b ε      (y = c + d ε)
//
// So a program that is fed x_i = a_i + ε_i returns f in the value and ∂f/∂a_i, exact to rounding, in the tangent. This
// is forward-mode differentiation. The scalar inside may be any that computes; in a dual of duals the inner one
// differentiates the outer tangent, which makes second derivatives. The ε of an inner derivative must never meet the ε
// of an outer one as if they were the same (*perturbation confusion*). So an inner derivative is taken over the outer
// scalar, Dual<Dual<double>>. gradient(), jacobian() … mark their duals with a Tag of their own, so that two unrelated
// perturbations do not compile when mixed by mistake.
//
// Everything is a value: without expression templates there are no dangling temporaries, and `auto` is always safe.
// Comparisons look at values only, so a program takes the branch that it takes for plain numbers.

#include <array>
#include <cstddef>
#include <limits>
#include <type_traits>

#include "qdot/error.hpp"

namespace qdot {

template <class S, int N, class Tag = void>
struct Dual;

namespace detail {

template <class T>
struct is_dual : std::false_type {};
template <class S, int N, class Tag>
struct is_dual<Dual<S, N, Tag>> : std::true_type {};

template <class S>
struct innermost {
  using type = S;
};
template <class S, int N, class Tag>
struct innermost<Dual<S, N, Tag>> : innermost<S> {};

// What may stand beside a Dual<S> as a constant without being an S: a plain number, or an inner dual.
template <class Number, class S, class D>
concept ConstantBeside =
    !std::is_same_v<Number, S> && !std::is_same_v<Number, D> &&
    (std::is_arithmetic_v<Number> || is_dual<Number>::value ||
     std::is_same_v<Number, typename innermost<S>::type>) && std::is_convertible_v<Number, S>;

// The comparisons of numbers that are compared by their values, whatever they know besides.
template <class Self>
struct ComparedByValue {
  friend bool operator==(const Self& x, const Self& y) { return x.value == y.value; }
  friend bool operator!=(const Self& x, const Self& y) { return x.value != y.value; }
  friend bool operator<(const Self& x, const Self& y) { return x.value < y.value; }
  friend bool operator<=(const Self& x, const Self& y) { return x.value <= y.value; }
  friend bool operator>(const Self& x, const Self& y) { return x.value > y.value; }
  friend bool operator>=(const Self& x, const Self& y) { return x.value >= y.value; }
};

}  // namespace detail

/// True for qdot's dual numbers of any scalar, size and tag.
template <class T>
concept DualNumber = detail::is_dual<std::remove_cvref_t<T>>::value;

/// A number with N first derivatives.
///
/// Size (N + 1) scalars, no allocation. Arithmetic costs N + 1 to 2N + 2 operations of S.
///
/// @tparam S    scalar inside: a floating-point type or another dual
/// @tparam N    number of directions, at least 1
/// @tparam Tag  which derivative these directions belong to; void for the library's own
template <class S, int N, class Tag>
struct Dual {
  static_assert(N >= 1, "qdot::Dual: N, the number of derivative directions, must be at least 1");

  using Scalar = S;                     ///< the scalar inside
  static constexpr int directions = N;  ///< how many derivatives it carries

  S value{};                                             ///< a
  std::array<S, static_cast<std::size_t>(N)> tangent{};  ///< b₁ … b_N

  constexpr Dual() = default;

  /// A constant: all derivatives zero. Implicit, so that 0.5 * m * x works for every scalar.
  constexpr Dual(const S& constant) : value(constant) {}

  /// A constant given as any number that the inner scalar can be made from (1, 2.0, an inner dual).
  template <detail::ConstantBeside<S, Dual> Number>
  constexpr Dual(const Number& constant) : value(static_cast<S>(constant)) {}

  /// The independent variable number `direction` (0-based): derivative 1 along it, 0 along the others.
  static constexpr Dual variable(const S& at, int direction) {
    Dual x(at);
    x.tangent[static_cast<std::size_t>(direction)] = S(1);
    return x;
  }

  constexpr Dual& operator+=(const Dual& y) {
    for (std::size_t i = 0; i < N; ++i) tangent[i] += y.tangent[i];
    value += y.value;
    return *this;
  }
  constexpr Dual& operator-=(const Dual& y) {
    for (std::size_t i = 0; i < N; ++i) tangent[i] -= y.tangent[i];
    value -= y.value;
    return *this;
  }
  constexpr Dual& operator*=(const Dual& y) { return *this = *this * y; }
  constexpr Dual& operator/=(const Dual& y) { return *this = *this / y; }

  constexpr Dual& operator+=(const S& y) {
    value += y;
    return *this;
  }
  constexpr Dual& operator-=(const S& y) {
    value -= y;
    return *this;
  }
  constexpr Dual& operator*=(const S& y) { return *this = *this * y; }
  constexpr Dual& operator/=(const S& y) { return *this = *this / y; }

  friend constexpr Dual operator+(const Dual& x) { return x; }
  friend constexpr Dual operator-(const Dual& x) {
    Dual r;
    r.value = -x.value;
    for (std::size_t i = 0; i < N; ++i) r.tangent[i] = -x.tangent[i];
    return r;
  }

  friend constexpr Dual operator+(const Dual& x, const Dual& y) {
    Dual r(x);
    return r += y;
  }
  friend constexpr Dual operator-(const Dual& x, const Dual& y) {
    Dual r(x);
    return r -= y;
  }
  // (x y)′ = x y′ + y x′
  friend constexpr Dual operator*(const Dual& x, const Dual& y) {
    Dual r;
    r.value = x.value * y.value;
    for (std::size_t i = 0; i < N; ++i) r.tangent[i] = x.value * y.tangent[i] + y.value * x.tangent[i];
    return r;
  }
  // (x/y)′ = (x′ − (x/y) y′)/y
  friend constexpr Dual operator/(const Dual& x, const Dual& y) {
    Dual r;
    r.value = x.value / y.value;
    for (std::size_t i = 0; i < N; ++i) r.tangent[i] = (x.tangent[i] - r.value * y.tangent[i]) / y.value;
    return r;
  }

  // With a constant of the inner scalar: no product rule, half the work.
  friend constexpr Dual operator+(const Dual& x, const S& y) {
    Dual r(x);
    return r += y;
  }
  friend constexpr Dual operator+(const S& x, const Dual& y) {
    Dual r(y);
    return r += x;
  }
  friend constexpr Dual operator-(const Dual& x, const S& y) {
    Dual r(x);
    return r -= y;
  }
  friend constexpr Dual operator-(const S& x, const Dual& y) {
    Dual r(-y);
    return r += x;
  }
  friend constexpr Dual operator*(const Dual& x, const S& y) {
    Dual r;
    r.value = x.value * y;
    for (std::size_t i = 0; i < N; ++i) r.tangent[i] = x.tangent[i] * y;
    return r;
  }
  friend constexpr Dual operator*(const S& x, const Dual& y) { return y * x; }
  friend constexpr Dual operator/(const Dual& x, const S& y) {
    Dual r;
    r.value = x.value / y;
    for (std::size_t i = 0; i < N; ++i) r.tangent[i] = x.tangent[i] / y;
    return r;
  }
  friend constexpr Dual operator/(const S& x, const Dual& y) {
    Dual r;
    r.value = x / y.value;
    for (std::size_t i = 0; i < N; ++i) r.tangent[i] = -(r.value * y.tangent[i]) / y.value;
    return r;
  }

  // With any other constant, converted to the inner scalar first.
  template <detail::ConstantBeside<S, Dual> Number>
  friend constexpr Dual operator+(const Dual& x, const Number& y) { return x + static_cast<S>(y); }
  template <detail::ConstantBeside<S, Dual> Number>
  friend constexpr Dual operator+(const Number& x, const Dual& y) { return static_cast<S>(x) + y; }
  template <detail::ConstantBeside<S, Dual> Number>
  friend constexpr Dual operator-(const Dual& x, const Number& y) { return x - static_cast<S>(y); }
  template <detail::ConstantBeside<S, Dual> Number>
  friend constexpr Dual operator-(const Number& x, const Dual& y) { return static_cast<S>(x) - y; }
  template <detail::ConstantBeside<S, Dual> Number>
  friend constexpr Dual operator*(const Dual& x, const Number& y) { return x * static_cast<S>(y); }
  template <detail::ConstantBeside<S, Dual> Number>
  friend constexpr Dual operator*(const Number& x, const Dual& y) { return static_cast<S>(x) * y; }
  template <detail::ConstantBeside<S, Dual> Number>
  friend constexpr Dual operator/(const Dual& x, const Number& y) { return x / static_cast<S>(y); }
  template <detail::ConstantBeside<S, Dual> Number>
  friend constexpr Dual operator/(const Number& x, const Dual& y) { return static_cast<S>(x) / y; }

  // Comparisons are of values.
  friend constexpr bool operator==(const Dual& x, const Dual& y) { return x.value == y.value; }
  friend constexpr bool operator!=(const Dual& x, const Dual& y) { return x.value != y.value; }
  friend constexpr bool operator<(const Dual& x, const Dual& y) { return x.value < y.value; }
  friend constexpr bool operator<=(const Dual& x, const Dual& y) { return x.value <= y.value; }
  friend constexpr bool operator>(const Dual& x, const Dual& y) { return x.value > y.value; }
  friend constexpr bool operator>=(const Dual& x, const Dual& y) { return x.value >= y.value; }
};

/// The plain number at the bottom of a nest of duals: x itself when it is no dual.
template <class S>
constexpr const S& innermost_value(const S& x) {
  return x;
}
template <class S, int N, class Tag>
constexpr decltype(auto) innermost_value(const Dual<S, N, Tag>& x) {
  return innermost_value(x.value);
}

}  // namespace qdot

/// Limits of a dual are those of its scalar, as constants.
template <class S, int N, class Tag>
struct std::numeric_limits<qdot::Dual<S, N, Tag>> : std::numeric_limits<S> {
  using Base = std::numeric_limits<S>;
  using D = qdot::Dual<S, N, Tag>;
  static constexpr D min() noexcept { return D(Base::min()); }
  static constexpr D max() noexcept { return D(Base::max()); }
  static constexpr D lowest() noexcept { return D(Base::lowest()); }
  static constexpr D epsilon() noexcept { return D(Base::epsilon()); }
  static constexpr D round_error() noexcept { return D(Base::round_error()); }
  static constexpr D infinity() noexcept { return D(Base::infinity()); }
  static constexpr D quiet_NaN() noexcept { return D(Base::quiet_NaN()); }
  static constexpr D signaling_NaN() noexcept { return D(Base::signaling_NaN()); }
  static constexpr D denorm_min() noexcept { return D(Base::denorm_min()); }
};
