#pragma once
// SPDX-License-Identifier: MIT
//
// A scalar that keeps a hash of the formula by which it was made, and no value.
//
// Functors that are run on variables with certain hashes return the same hashes as long as they do the same operations with the same constants in the same
// order. Another captured number, sign or term gives another hash (64 bits). That is a cheaper question than recording the formula once more
// (ad/formula/recording.hpp): one multiplication for each operation, and no sine, whatever the state is. Operations are inlined always: of functors without
// loops the compiler carries out all but those with captured numbers.
//
// Derivatives are not taken. The derivative of a function follows from its formula, so a hash of the formula stands for it. The function is run on
// arguments that are marked, and its result is hashed.
//
// Comparisons are answered as they were when a branch was recorded, in their order, and what is compared goes into a hash of its own. Whatever a recording
// refuses, or a comparison that the branch does not know, throws NoFormula.

#include <Eigen/Core>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include "qdot/ad/formula/formula_number.hpp"

namespace qdot::formula {

/// Thrown where a functor does what no formula does.
struct NoFormula {};

/// The answers to comparisons, and what has been compared.
struct HashedComparisons {
  const std::vector<double>* answers = nullptr;
  std::size_t next = 0;
  std::uint64_t hash = 0;

  /// Whether all have been given.
  bool are_given() const { return next == (answers ? answers->size() : 0); }
};

// Of arguments that are constants. Comparisons of these throw, so nothing is ever written here.
inline constinit HashedComparisons nothing_compared{};

/// A number of a formula, known by its hash; of a constant its value.
class Hashed : public FormulaNumber<Hashed> {
 public:
  static constexpr bool is_recorded = true;  // goes the ways of a number that is being recorded
  static constexpr bool is_hash = true;      // ad/derivatives.hpp

  [[gnu::always_inline]] constexpr Hashed() = default;
  template <class Number>
    requires std::is_arithmetic_v<Number>
  [[gnu::always_inline]] constexpr Hashed(Number constant) : bits_(std::bit_cast<std::uint64_t>(static_cast<double>(constant))) {}
  /// Variable number i.
  [[gnu::always_inline]] constexpr Hashed(HashedComparisons& comparisons, int i)
      : comparisons_(&comparisons), bits_(mixed(0x5bd1, static_cast<std::uint64_t>(i), 1)) {}

  bool is_constant() const { return comparisons_ == nullptr; }

  [[gnu::always_inline]] friend Hashed operator-(const Hashed& x) { return x.comparisons_ ? -1.0 * x : Hashed(-x.constant()); }
  [[gnu::always_inline]] friend Hashed operator+(const Hashed& x, const Hashed& y) {
    return x.is_constant(y) ? Hashed(x.constant() + y.constant()) : of_two(1, x, y);
  }
  [[gnu::always_inline]] friend Hashed operator-(const Hashed& x, const Hashed& y) {
    return x.is_constant(y) ? Hashed(x.constant() - y.constant()) : of_two(2, x, y);
  }
  [[gnu::always_inline]] friend Hashed operator*(const Hashed& x, const Hashed& y) {
    return x.is_constant(y) ? Hashed(x.constant() * y.constant()) : of_two(3, x, y);
  }
  [[gnu::always_inline]] friend Hashed operator/(const Hashed& x, const Hashed& y) {
    return x.is_constant(y) ? Hashed(x.constant() / y.constant()) : of_two(4, x, y);
  }

  friend bool operator==(const Hashed& x, const Hashed& y) {
    if (x.is_constant(y)) return x.constant() == y.constant();
    return answer(x, y, 11) != 0.0;
  }
  friend bool operator!=(const Hashed& x, const Hashed& y) { return !(x == y); }
  friend bool operator<(const Hashed& x, const Hashed& y) { return below(x, y, false); }
  friend bool operator<=(const Hashed& x, const Hashed& y) { return below(x, y, true); }
  friend bool operator>(const Hashed& x, const Hashed& y) { return below(y, x, false); }
  friend bool operator>=(const Hashed& x, const Hashed& y) { return below(y, x, true); }

  [[gnu::always_inline]] static Hashed of(Function f, const Hashed& x) { return x.comparisons_ ? of_two(code(f), x, x) : Hashed(value_of(f, x.constant())); }
  [[gnu::always_inline]] static Hashed of(Function f, const Hashed& x, const Hashed& y) {
    return x.is_constant(y) ? Hashed(value_of(f, x.constant(), y.constant())) : of_two(code(f), x, y);
  }
  friend Hashed pow(const Hashed& x, double exponent) { return x.comparisons_ ? of_two(5, x, Hashed(exponent)) : Hashed(std::pow(x.constant(), exponent)); }
  friend Hashed pow(const Hashed& x, const Hashed& y) { return y.comparisons_ ? exp(y * log(x)) : pow(x, y.constant()); }
  friend Hashed sqrt(const Hashed& x) { return pow(x, 0.5); }
  friend Hashed exp2(const Hashed& x) { return exp(x * std::log(2.0)); }
  friend Hashed log2(const Hashed& x) { return log(x) / std::log(2.0); }
  friend Hashed log10(const Hashed& x) { return log(x) / std::log(10.0); }
  friend Hashed sech_squared(const Hashed& x) {
    const Hashed c = cosh(x);
    return 1.0 / (c * c);
  }
  friend double innermost_value(const Hashed& x) { return x.known(); }
  friend bool seen_to_be_one(const Hashed& x, const Hashed& y) { return x.comparisons_ == y.comparisons_ && x.bits_ == y.bits_; }

  /// An argument, number i, of a function of which a derivative is asked; with the rate at which it moves.
  [[gnu::always_inline]] static Hashed argument(const Hashed& x, int i) {
    return Hashed(x.comparisons_ ? x.comparisons_ : &nothing_compared, mixed(12, x.bits_, static_cast<std::uint64_t>(i)));
  }
  [[gnu::always_inline]] static Hashed moving(const Hashed& x, const Hashed& rate) {
    const Hashed moved = of_two(13, x, rate);
    return Hashed(moved.comparisons_ ? moved.comparisons_ : &nothing_compared, moved.bits_);
  }
  /// A derivative of such a function that has returned y, number k from 1 on; with k = 0 its value.
  [[gnu::always_inline]] static Hashed digest(const Hashed& y, int k) {
    if (!y.comparisons_) return k == 0 ? y : Hashed(0.0);
    return Hashed(y.comparisons_, mixed(14, y.bits_, static_cast<std::uint64_t>(k)));
  }
  /// Several numbers in one, of which something is digested.
  [[gnu::always_inline]] static Hashed joined(const Hashed& x, const Hashed& y) { return of_two(15, x, y); }
  /// The hash of a number and of the comparisons that led to it, never zero.
  [[gnu::always_inline]] static std::uint64_t with_comparisons(const Hashed& x, const HashedComparisons& comparisons) {
    return mixed(16, x.bits_, comparisons.hash) | 1;
  }

  friend Hashed abs(const Hashed& x) { return below(x, 0.0, false) ? -x : x; }
  friend Hashed fabs(const Hashed& x) { return abs(x); }
  friend Hashed floor(const Hashed& x) { return rounded_down(x); }
  friend Hashed ceil(const Hashed& x) { return -rounded_down(-x); }
  friend Hashed max(const Hashed& x, const Hashed& y) { return below(x, y, false) ? y : x; }
  friend Hashed min(const Hashed& x, const Hashed& y) { return below(y, x, false) ? y : x; }
  friend Hashed copysign(const Hashed& x, const Hashed& y) {
    if (x.is_constant(y)) return std::copysign(x.constant(), y.constant());
    return below(x, 0.0, false) == below(y, 0.0, false) ? x : -x;
  }
  friend bool isfinite(const Hashed& x) { return std::isfinite(x.known()); }
  friend bool isnan(const Hashed& x) { return std::isnan(x.known()); }
  friend bool isinf(const Hashed& x) { return std::isinf(x.known()); }
  friend bool signbit(const Hashed& x) { return x.comparisons_ ? below(x, 0.0, false) : std::signbit(x.constant()); }

 private:
  [[gnu::always_inline]] constexpr Hashed(HashedComparisons* comparisons, std::uint64_t bits) : comparisons_(comparisons), bits_(bits) {}

  // The halves of the product of 128 bits, one over the other.
  [[gnu::always_inline]] static constexpr std::uint64_t mixed(std::uint64_t operation, std::uint64_t a, std::uint64_t b) {
    __extension__ using Wide = unsigned __int128;
    const Wide product = static_cast<Wide>(a + operation * 0x9E3779B97F4A7C15U) * (b ^ 0xBF58476D1CE4E5B9U);
    return static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64);
  }
  constexpr double constant() const { return std::bit_cast<double>(bits_); }
  constexpr bool is_constant(const Hashed& beside) const { return comparisons_ == nullptr && beside.comparisons_ == nullptr; }
  static constexpr std::uint64_t code(Function f) { return 16 + static_cast<std::uint64_t>(f); }
  // Of two numbers that are not both constants.
  [[gnu::always_inline]] static Hashed of_two(std::uint64_t operation, const Hashed& x, const Hashed& y) {
    const std::uint64_t constants = (x.comparisons_ ? 0U : 256U) + (y.comparisons_ ? 0U : 512U);
    return Hashed(x.comparisons_ ? x.comparisons_ : y.comparisons_, mixed(operation + constants, x.bits_, y.bits_));
  }
  double known() const {
    if (comparisons_) throw NoFormula();
    return constant();
  }
  // The next answer, to a comparison of these.
  static double answer(const Hashed& x, const Hashed& y, std::uint64_t kind) {
    HashedComparisons& c = *(x.comparisons_ ? x.comparisons_ : y.comparisons_);
    if (c.answers == nullptr || c.next >= c.answers->size()) throw NoFormula();
    c.hash = mixed(kind, c.hash, of_two(6, x, y).bits_);
    return (*c.answers)[c.next++];
  }
  static bool below(const Hashed& x, const Hashed& y, bool or_equal) {
    if (x.is_constant(y)) return or_equal ? x.constant() <= y.constant() : x.constant() < y.constant();
    return answer(x, y, or_equal ? 7 : 8) != 0.0;
  }
  static Hashed rounded_down(const Hashed& x) {
    if (!x.comparisons_) return std::floor(x.constant());
    return answer(x, x, 9);
  }

  HashedComparisons* comparisons_ = nullptr;  // of a constant: none
  std::uint64_t bits_ = 0;
};

}  // namespace qdot::formula

template <>
struct std::numeric_limits<qdot::formula::Hashed> : std::numeric_limits<double> {};

template <>
struct Eigen::NumTraits<qdot::formula::Hashed> : Eigen::NumTraits<double> {
  using Real = qdot::formula::Hashed;
  using NonInteger = Real;
  using Nested = Real;
  enum { IsInteger = 0, IsSigned = 1, IsComplex = 0, RequireInitialization = 1, ReadCost = 2, AddCost = 5, MulCost = 5 };
};

template <class Operation>
struct Eigen::ScalarBinaryOpTraits<qdot::formula::Hashed, double, Operation> {
  using ReturnType = qdot::formula::Hashed;
};
template <class Operation>
struct Eigen::ScalarBinaryOpTraits<double, qdot::formula::Hashed, Operation> {
  using ReturnType = qdot::formula::Hashed;
};
