#pragma once
// SPDX-License-Identifier: MIT
//
// Packs: several numbers that go through the same program at once.
//
//     ┌────┬────┬────┬────┬────┬────┬────┬────┐
//     │ q₀ │ q₁ │ q₂ │ q₃ │ q₄ │ q₅ │ q₆ │ q₇ │    x + y, x * y, sin(x), … : in every *lane*
//     └────┴────┴────┴────┴────┴────┴────┴────┘
// A processor computes with two, four or eight doubles by one instruction. A Pack<8> is a scalar to a functor, like a
// double or a dual, and holds the numbers of eight members of an ensemble. A pack wider than a register is two packs of
// half its width, so the same program runs wherever it is compiled. Without -march=native or -mavx2 -mfma, x86-64 has
// two lanes to a register.
//
// All lanes take the same branch. So a comparison of packs is no bool but a PackMask, a truth per lane, and `if`
// refuses it in English. Where plain code branches, select(x < y, a, b) chooses lane by lane, and does the same for
// plain numbers. Functions of events in lanes (integrate/lanes/lane_events.hpp) are given a kind that `if` takes while
// all lanes answer alike. Otherwise LanesPart is thrown, and each lane is asked by itself.

#include <concepts>
#include <limits>
#include <type_traits>
#include <utility>

#include <Eigen/Core>

#include "qdot/error.hpp"

namespace qdot {

namespace detail {

// Doubles in one register.
#if defined(__AVX512F__)
inline constexpr int register_lanes = 8;
#elif defined(__AVX__)
inline constexpr int register_lanes = 4;
#else
inline constexpr int register_lanes = 2;
#endif

template <class T, int lanes>
using Register [[gnu::vector_size(static_cast<int>(sizeof(T)) * lanes)]] = T;

using Bits = long long;

// Added to the width of packs whose masks may be asked in `if`.
inline constexpr int may_branch = 1 << 10;

// Lanes of which some would take a branch and others not.
struct LanesPart {};
// The truth of all lanes.
template <class Mask>
bool common_truth(const Mask& mask) {
  if (mask.all()) return true;
  if (mask.any()) throw LanesPart();
  return false;
}

}  // namespace detail

/// `lanes` doubles, computed with at once; a power of two, at least 2.
///
/// @tparam width  doubles in one register: a part of the type, so that files compiled with different options do not mix
template <int lanes, int width = detail::register_lanes>
struct Pack;

/// A truth for each lane of a Pack.
template <int lanes, int width = detail::register_lanes>
struct PackMask;

namespace detail {

// P(f(x, y, …)) register by register.
template <class P, class F, class... X>
[[gnu::always_inline]] inline P by_register(const F& f, const X&... x) {
  if constexpr (P::is_register) {
    return P(f(x.lanes_of_register...));
  } else {
    return P(by_register<typename P::Half>(f, x.low...), by_register<typename P::Half>(f, x.high...));
  }
}

// The same bits as another type of register.
template <class To, class From>
[[gnu::always_inline]] inline To as_bits(const From& x) {
  To r;
  static_assert(sizeof(To) == sizeof(From));
  __builtin_memcpy(&r, &x, sizeof r);
  return r;
}

template <class Mask, class P>
struct PackOperators {
  [[gnu::always_inline]] friend P operator+(const P& x) { return x; }
  [[gnu::always_inline]] friend P operator-(const P& x) { return by_register<P>([](const auto& a) { return -a; }, x); }
  [[gnu::always_inline]] friend P operator+(const P& x, const P& y) {
    return by_register<P>([](const auto& a, const auto& b) { return a + b; }, x, y);
  }
  [[gnu::always_inline]] friend P operator-(const P& x, const P& y) {
    return by_register<P>([](const auto& a, const auto& b) { return a - b; }, x, y);
  }
  [[gnu::always_inline]] friend P operator*(const P& x, const P& y) {
    return by_register<P>([](const auto& a, const auto& b) { return a * b; }, x, y);
  }
  [[gnu::always_inline]] friend P operator/(const P& x, const P& y) {
    return by_register<P>([](const auto& a, const auto& b) { return a / b; }, x, y);
  }
  [[gnu::always_inline]] friend P& operator+=(P& x, const P& y) { return x = x + y; }
  [[gnu::always_inline]] friend P& operator-=(P& x, const P& y) { return x = x - y; }
  [[gnu::always_inline]] friend P& operator*=(P& x, const P& y) { return x = x * y; }
  [[gnu::always_inline]] friend P& operator/=(P& x, const P& y) { return x = x / y; }

  [[gnu::always_inline]] friend Mask operator==(const P& x, const P& y) {
    return by_register<Mask>([](const auto& a, const auto& b) { return a == b; }, x, y);
  }
  [[gnu::always_inline]] friend Mask operator!=(const P& x, const P& y) {
    return by_register<Mask>([](const auto& a, const auto& b) { return a != b; }, x, y);
  }
  [[gnu::always_inline]] friend Mask operator<(const P& x, const P& y) {
    return by_register<Mask>([](const auto& a, const auto& b) { return a < b; }, x, y);
  }
  [[gnu::always_inline]] friend Mask operator<=(const P& x, const P& y) {
    return by_register<Mask>([](const auto& a, const auto& b) { return a <= b; }, x, y);
  }
  [[gnu::always_inline]] friend Mask operator>(const P& x, const P& y) { return y < x; }
  [[gnu::always_inline]] friend Mask operator>=(const P& x, const P& y) { return y <= x; }
};

template <class M>
struct MaskOperators {
  [[gnu::always_inline]] friend M operator&(const M& x, const M& y) {
    return by_register<M>([](const auto& a, const auto& b) { return a & b; }, x, y);
  }
  [[gnu::always_inline]] friend M operator|(const M& x, const M& y) {
    return by_register<M>([](const auto& a, const auto& b) { return a | b; }, x, y);
  }
  [[gnu::always_inline]] friend M operator==(const M& x, const M& y) {
    return by_register<M>([](const auto& a, const auto& b) { return ~(a ^ b); }, x, y);
  }
  [[gnu::always_inline]] friend M operator!(const M& x) { return by_register<M>([](const auto& a) { return ~a; }, x); }
  [[gnu::always_inline]] friend M& operator&=(M& x, const M& y) { return x = x & y; }
  [[gnu::always_inline]] friend M& operator|=(M& x, const M& y) { return x = x | y; }
};

template <class>
inline constexpr bool a_branch_on_lanes = false;

template <int lanes, class F, int... i>
[[gnu::always_inline]] inline Register<double, lanes> gathered(const F& f, int first, std::integer_sequence<int, i...>) {
  return Register<double, lanes>{f(first + i)...};
}

}  // namespace detail

template <int lanes, int width>
struct Pack : detail::PackOperators<PackMask<lanes, width>, Pack<lanes, width>> {
  static_assert(lanes >= 2 && (lanes & (lanes - 1)) == 0, "qdot: a pack has 2, 4, 8, … lanes");
  using Mask = PackMask<lanes, width>;        ///< what comparisons of packs give
  using Half = Pack<lanes / 2, width>;        ///< a pack of half as many lanes
  static constexpr int size = lanes;          ///< how many lanes
  static constexpr bool is_register = false;  ///< whether it is one register, or two halves

  Half low, high;  ///< the two halves

  Pack() = default;
  /// The same number in every lane.
  template <class Number>
    requires std::is_arithmetic_v<Number>
  [[gnu::always_inline]] Pack(Number x) : low(x), high(x) {}
  [[gnu::always_inline]] Pack(const Half& first, const Half& second) : low(first), high(second) {}

  /// f(0), f(1), …, lane by lane.
  template <class F>
  [[gnu::always_inline]] static Pack of(const F& f, int first = 0) {
    return Pack(Half::of(f, first), Half::of(f, first + lanes / 2));
  }
  /// `lanes` numbers from memory, at any alignment.
  [[gnu::always_inline]] static Pack load(const double* from) { return Pack(Half::load(from), Half::load(from + lanes / 2)); }
  /// Writes all lanes to memory, at any alignment.
  [[gnu::always_inline]] void store(double* to) const {
    low.store(to);
    high.store(to + lanes / 2);
  }
  /// The number in a lane.
  [[gnu::always_inline]] double operator[](int lane) const { return lane < lanes / 2 ? low[lane] : high[lane - lanes / 2]; }
};

template <int lanes, int width>
  requires(lanes <= width % detail::may_branch)
struct Pack<lanes, width> : detail::PackOperators<PackMask<lanes, width>, Pack<lanes, width>> {
  static_assert(lanes >= 2 && (lanes & (lanes - 1)) == 0, "qdot: a pack has 2, 4, 8, … lanes");
  using Mask = PackMask<lanes, width>;
  static constexpr int size = lanes;
  static constexpr bool is_register = true;

  detail::Register<double, lanes> lanes_of_register;  ///< the register

  Pack() = default;
  template <class Number>
    requires std::is_arithmetic_v<Number>
  [[gnu::always_inline]] Pack(Number x) : lanes_of_register(detail::Register<double, lanes>{} + static_cast<double>(x)) {}
  [[gnu::always_inline]] explicit Pack(const detail::Register<double, lanes>& x) : lanes_of_register(x) {}

  template <class F>
  [[gnu::always_inline]] static Pack of(const F& f, int first = 0) {
    return Pack(detail::gathered<lanes>(f, first, std::make_integer_sequence<int, lanes>{}));
  }
  [[gnu::always_inline]] static Pack load(const double* from) {
    Pack r;
    __builtin_memcpy(&r.lanes_of_register, from, sizeof r.lanes_of_register);
    return r;
  }
  [[gnu::always_inline]] void store(double* to) const { __builtin_memcpy(to, &lanes_of_register, sizeof lanes_of_register); }
  [[gnu::always_inline]] double operator[](int lane) const { return lanes_of_register[lane]; }
};

template <int lanes, int width>
struct PackMask : detail::MaskOperators<PackMask<lanes, width>> {
  using Half = PackMask<lanes / 2, width>;    ///< a mask of half as many lanes
  static constexpr bool is_register = false;  ///< whether it is one register, or two halves

  Half low, high;  ///< the two halves

  PackMask() = default;
  [[gnu::always_inline]] PackMask(bool truth) : low(truth), high(truth) {}
  [[gnu::always_inline]] PackMask(const Half& first, const Half& second) : low(first), high(second) {}

  /// The truth in a lane.
  [[gnu::always_inline]] bool operator[](int lane) const { return lane < lanes / 2 ? low[lane] : high[lane - lanes / 2]; }
  /// Whether it is true in at least one lane.
  [[gnu::always_inline]] bool any() const { return (low | high).any(); }
  /// Whether it is true in every lane.
  [[gnu::always_inline]] bool all() const { return (low & high).all(); }

  /// Does not compile: lanes cannot branch apart; write select(x < y, a, b).
  template <class Truth>
    requires(std::is_same_v<Truth, bool> && width < detail::may_branch)
  explicit operator Truth() const {
    static_assert(detail::a_branch_on_lanes<Truth>,
                  "qdot: lanes of a pack cannot branch apart: a functor that runs on packs must not compare its numbers in `if`, "
                  "`?:`, `&&` or `||`; write select(x < y, a, b), which chooses lane by lane and works for every scalar");
    return false;
  }
  /// What all lanes say.
  ///
  /// @throws LanesPart  they differ
  operator bool() const
    requires(width >= detail::may_branch)
  {
    return detail::common_truth(*this);
  }
};

template <int lanes, int width>
  requires(lanes <= width % detail::may_branch)
struct PackMask<lanes, width> : detail::MaskOperators<PackMask<lanes, width>> {
  static constexpr bool is_register = true;

  detail::Register<detail::Bits, lanes> lanes_of_register;  ///< all bits set, or none

  PackMask() = default;
  [[gnu::always_inline]] PackMask(bool truth) : lanes_of_register(detail::Register<detail::Bits, lanes>{} - (truth ? 1LL : 0LL)) {}
  // What a comparison of registers gives: integers as wide as the numbers, of a type that compilers differ about.
  template <class Compared>
    requires(sizeof(Compared) == lanes * sizeof(detail::Bits) && !std::is_arithmetic_v<Compared>)
  [[gnu::always_inline]] explicit PackMask(const Compared& x)
      : lanes_of_register(detail::as_bits<detail::Register<detail::Bits, lanes>>(x)) {}

  [[gnu::always_inline]] bool operator[](int lane) const { return lanes_of_register[lane] != 0; }
  [[gnu::always_inline]] bool any() const {
    if constexpr (lanes == 2) {
      return (lanes_of_register[0] | lanes_of_register[1]) != 0;
    } else {
      return halves().any();
    }
  }
  [[gnu::always_inline]] bool all() const { return !(!*this).any(); }

  template <class Truth>
    requires(std::is_same_v<Truth, bool> && width < detail::may_branch)
  explicit operator Truth() const {
    return static_cast<bool>(PackMask<2 * width, width>(*this, *this));
  }
  operator bool() const
    requires(width >= detail::may_branch)
  {
    return detail::common_truth(*this);
  }

 private:
  // Both halves, one or the other.
  [[gnu::always_inline]] PackMask<lanes / 2, width> halves() const {
    detail::Register<detail::Bits, lanes / 2> first, second;
    __builtin_memcpy(&first, &lanes_of_register, sizeof first);
    __builtin_memcpy(&second, reinterpret_cast<const char*>(&lanes_of_register) + sizeof first, sizeof second);
    return PackMask<lanes / 2, width>(first | second);
  }
};

/// a in the lanes where the condition holds, b in the others.
template <int lanes, int width>
[[gnu::always_inline]] inline Pack<lanes, width> select(const PackMask<lanes, width>& condition,
                                                        const std::type_identity_t<Pack<lanes, width>>& a,
                                                        const std::type_identity_t<Pack<lanes, width>>& b) {
  return detail::by_register<Pack<lanes, width>>(
      [](const auto& m, const auto& x, const auto& y) {
        using M = std::remove_cvref_t<decltype(m)>;
        using X = std::remove_cvref_t<decltype(x)>;
        return detail::as_bits<X>(M((m & detail::as_bits<M>(x)) | (~m & detail::as_bits<M>(y))));
      },
      condition, a, b);
}

/// Of numbers that are no packs: a if the condition holds, otherwise b.
template <std::convertible_to<bool> Condition, class A, class B>
  requires(!requires { Condition::is_register; })
[[gnu::always_inline]] inline std::common_type_t<A, B> select(const Condition& condition, const A& a, const B& b) {
  return condition ? std::common_type_t<A, B>(a) : std::common_type_t<A, B>(b);
}

}  // namespace qdot

template <int lanes, int width>
struct std::numeric_limits<qdot::Pack<lanes, width>> : std::numeric_limits<double> {};

template <int lanes, int width>
struct Eigen::NumTraits<qdot::Pack<lanes, width>> : Eigen::NumTraits<double> {
  using Real = qdot::Pack<lanes, width>;
  using NonInteger = Real;
  using Nested = Real;
  enum { IsInteger = 0, IsSigned = 1, IsComplex = 0, RequireInitialization = 0, ReadCost = 1, AddCost = 1, MulCost = 1 };
};

template <int lanes, int width, class Number, class Operation>
  requires std::is_arithmetic_v<Number>
struct Eigen::ScalarBinaryOpTraits<qdot::Pack<lanes, width>, Number, Operation> {
  using ReturnType = qdot::Pack<lanes, width>;
};
template <int lanes, int width, class Number, class Operation>
  requires std::is_arithmetic_v<Number>
struct Eigen::ScalarBinaryOpTraits<Number, qdot::Pack<lanes, width>, Operation> {
  using ReturnType = qdot::Pack<lanes, width>;
};
