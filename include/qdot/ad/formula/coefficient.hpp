#pragma once
// SPDX-License-Identifier: MIT
//
// Numbers that the compiler computes with and does not know.
//
// Masses and lengths have values when an object is made, but equations can be derived before, as one does on paper: with letters. A
// Coefficient is such a number. What it consists of is written into a book,
//
//     c₀ = m,   c₁ = l,   c₂ = c₀ c₁,   c₃ = ½ c₂, …
//
// and when there is an object, one walk through the book gives all values.
//
// Deriving asks questions: are these two equal, is their difference zero? They are answered by a *shadow*, a number that stands for all
// values that a letter may have: letters get scattered numbers (shadow_of), what is computed from them gets what comes out, and equal
// shadows mean equal formulas. Literals are their own shadows. Two kinds of results get a scattered number of their own: powers, which the
// compiler can't compute, and sums in which one summand would be lost beside the other, like 6·10²⁴ + m.

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "qdot/ad/formula/graph.hpp"
#include "qdot/ad/formula/shadow.hpp"

namespace qdot::formula {

/// One line of a book: a parameter, a literal, or what is computed from earlier lines.
struct CoefficientStep {
  enum class Kind : std::uint8_t { parameter, literal, sum, difference, product, quotient, power };
  Kind kind = Kind::literal;
  int a = 0, b = 0;     // lines; of a parameter its number
  double number = 0.0;  // the literal, or the exponent
};

class CoefficientBook;

struct Coefficient {
  double shadow = 0.0;
  int line = -1;  // −1: a literal
  CoefficientBook* book = nullptr;

  constexpr Coefficient() = default;
  constexpr Coefficient(double literal) : shadow(literal) {}
  constexpr Coefficient(double shadow_, int line_, CoefficientBook* book_) : shadow(shadow_), line(line_), book(book_) {}

  constexpr bool is_literal() const { return line < 0; }
  constexpr bool is(double literal) const { return line < 0 && shadow == literal; }
  friend constexpr Coefficient operator+(const Coefficient& x, const Coefficient& y);
  friend constexpr Coefficient operator-(const Coefficient& x, const Coefficient& y);
  friend constexpr Coefficient operator*(const Coefficient& x, const Coefficient& y);
  friend constexpr Coefficient operator/(const Coefficient& x, const Coefficient& y);
  constexpr Coefficient operator-() const;
  constexpr Coefficient& operator+=(const Coefficient& y) { return *this = *this + y; }
};

/// Whether both are the same formula; sums may have been added up in another order.
constexpr bool are_alike(double x, double y) { return x == y; }
constexpr bool are_alike(const Coefficient& x, const Coefficient& y) {
  const double difference = x.shadow - y.shadow, size = x.shadow < 0.0 ? -x.shadow : x.shadow;
  return (difference < 0.0 ? -difference : difference) <= 1e-14 * size;
}

/// What all coefficients of a derivation consist of. Lines with equal shadows are one.
class CoefficientBook {
 public:
  constexpr const std::vector<CoefficientStep>& steps() const { return steps_; }
  constexpr double shadow_of_line(int line) const { return shadows_[static_cast<std::size_t>(line)]; }
  /// A line of another book, the lines before which are here already.
  constexpr void copy(const CoefficientStep& step, double shadow) { line_of(step, shadow); }

  constexpr Coefficient parameter(int number, double shadow) { return line_of({.kind = CoefficientStep::Kind::parameter, .a = number}, shadow); }
  constexpr Coefficient computed(CoefficientStep::Kind kind, const Coefficient& x, const Coefficient& y, double shadow) {
    if (shadow == 0.0) return 0.0;
    if (kind == CoefficientStep::Kind::sum && are_alike(x, Coefficient(-y.shadow))) return 0.0;
    if (kind == CoefficientStep::Kind::difference && are_alike(x, y)) return 0.0;
    if ((kind == CoefficientStep::Kind::sum || kind == CoefficientStep::Kind::difference) && loses_one(x.shadow, y.shadow)) {
      const bool swapped = kind == CoefficientStep::Kind::sum && x.shadow < y.shadow;
      shadow = mixed(kind, swapped ? y.shadow : x.shadow, swapped ? x.shadow : y.shadow);
    }
    const int a = written(x), b = written(y);
    return line_of({.kind = kind, .a = a, .b = b}, shadow);
  }
  constexpr Coefficient power(const Coefficient& x, double exponent) {
    const int a = written(x);
    return line_of({.kind = CoefficientStep::Kind::power, .a = a, .number = exponent}, mixed(CoefficientStep::Kind::power, x.shadow, exponent));
  }

 private:
  // Whether a sum's shadow would say little of the smaller summand.
  static constexpr bool loses_one(double x, double y) {
    const double a = x < 0.0 ? -x : x, b = y < 0.0 ? -y : y;
    return a != 0.0 && b != 0.0 && (a < 1e-6 * b || b < 1e-6 * a);
  }
  static constexpr double mixed(CoefficientStep::Kind kind, double x, double y) {
    const std::uint64_t of_x = std::bit_cast<std::uint64_t>(scattered(std::bit_cast<std::uint64_t>(x)));
    const std::uint64_t of_y = std::bit_cast<std::uint64_t>(scattered(std::bit_cast<std::uint64_t>(y)));
    return scattered(of_x * 3 + of_y * 5 + static_cast<std::uint64_t>(kind));
  }
  constexpr int written(const Coefficient& x) {
    return x.line >= 0 ? x.line : line_of({.kind = CoefficientStep::Kind::literal, .number = x.shadow}, x.shadow).line;
  }
  constexpr Coefficient line_of(const CoefficientStep& step, double shadow) {
    if (2 * (steps_.size() + 1) > places_.size()) {
      places_.assign(places_.empty() ? 64 : 2 * places_.size(), -1);
      for (std::size_t i = 0; i < steps_.size(); ++i) places_[place_of(shadows_[i])] = static_cast<int>(i);
    }
    const std::size_t place = place_of(shadow);
    if (places_[place] < 0) {
      places_[place] = static_cast<int>(steps_.size());
      steps_.push_back(step);
      shadows_.push_back(shadow);
    }
    return {shadow, places_[place], this};
  }
  constexpr std::size_t place_of(double shadow) const {
    const std::uint64_t h = (std::bit_cast<std::uint64_t>(shadow) >> 7) * 0x9E3779B97F4A7C15u;
    std::size_t place = static_cast<std::size_t>(h >> 33) & (places_.size() - 1);
    while (places_[place] >= 0 && shadows_[static_cast<std::size_t>(places_[place])] != shadow) place = (place + 1) & (places_.size() - 1);
    return place;
  }

  std::vector<CoefficientStep> steps_;
  std::vector<double> shadows_;
  std::vector<int> places_;
};

constexpr Coefficient operator+(const Coefficient& x, const Coefficient& y) {
  if (x.is_literal() && y.is_literal()) return x.shadow + y.shadow;
  if (x.is(0.0)) return y;
  if (y.is(0.0)) return x;
  return (x.book != nullptr ? x.book : y.book)->computed(CoefficientStep::Kind::sum, x, y, x.shadow + y.shadow);
}
constexpr Coefficient operator-(const Coefficient& x, const Coefficient& y) {
  if (x.is_literal() && y.is_literal()) return x.shadow - y.shadow;
  if (y.is(0.0)) return x;
  return (x.book != nullptr ? x.book : y.book)->computed(CoefficientStep::Kind::difference, x, y, x.shadow - y.shadow);
}
constexpr Coefficient operator*(const Coefficient& x, const Coefficient& y) {
  if (x.is_literal() && y.is_literal()) return x.shadow * y.shadow;
  if (x.is(1.0)) return y;
  if (y.is(1.0)) return x;
  return (x.book != nullptr ? x.book : y.book)->computed(CoefficientStep::Kind::product, x, y, x.shadow * y.shadow);
}
constexpr Coefficient operator/(const Coefficient& x, const Coefficient& y) {
  if (x.is_literal() && y.is_literal()) return x.shadow / y.shadow;
  if (y.is(1.0)) return x;
  return (x.book != nullptr ? x.book : y.book)->computed(CoefficientStep::Kind::quotient, x, y, x.shadow / y.shadow);
}
constexpr Coefficient Coefficient::operator-() const { return 0.0 - *this; }

// As a graph asks for them; see ad/formula/graph.hpp.
constexpr double decisive(const Coefficient& x) { return x.shadow; }
constexpr double actual(const Coefficient& x) { return x.shadow; }
constexpr Coefficient power_of(const Coefficient& x, double exponent) {
  if (x.is(1.0)) return 1.0;
  if (exponent == -1.0) return 1.0 / x;
  if (exponent == 2.0) return x * x;
  if (!x.is_literal()) return x.book->power(x, exponent);
  if (!(exponent >= -64.0 && exponent <= 64.0 && exponent == static_cast<double>(static_cast<int>(exponent)))) return power_of(x.shadow, exponent);
  double product = 1.0;
  for (int k = static_cast<int>(exponent < 0.0 ? -exponent : exponent); k > 0; --k) product *= x.shadow;
  return exponent < 0.0 ? 1.0 / product : product;
}

// Letters have powers; of literals some are known while compiling. Functions of either stay functions.
#ifdef __clang__
inline constexpr bool knows_roots_while_compiling = false;
#else
inline constexpr bool knows_roots_while_compiling = true;
#endif
constexpr bool can_be_raised(const Coefficient& x, double exponent) {
  if (!x.is_literal()) return true;
  const bool is_small_and_whole = exponent >= -64.0 && exponent <= 64.0 && exponent == static_cast<double>(static_cast<int>(exponent));
  return is_small_and_whole ? exponent > 0.0 || x.shadow != 0.0 : knows_roots_while_compiling && x.shadow > 0.0;
}
constexpr bool has_known_value(const Coefficient&) { return false; }
inline Coefficient value_of(Function, const Coefficient&, const Coefficient&) { return {}; }  // never asked for

/// How large the numbers were that were added up to each line: where a value is far below, it is what rounding has left.
inline void write_magnitudes(const CoefficientStep* steps, int count, const double* values, double* magnitudes) {
  for (int i = 0; i < count; ++i) {
    const CoefficientStep& s = steps[i];
    switch (s.kind) {
      case CoefficientStep::Kind::sum:
      case CoefficientStep::Kind::difference: magnitudes[i] = magnitudes[s.a] + magnitudes[s.b]; break;
      case CoefficientStep::Kind::product: magnitudes[i] = magnitudes[s.a] * magnitudes[s.b]; break;
      case CoefficientStep::Kind::quotient: magnitudes[i] = magnitudes[s.a] / std::abs(values[s.b]); break;
      default: magnitudes[i] = std::abs(values[i]);
    }
  }
}

/// The values of all lines.
inline void write_coefficients(const CoefficientStep* steps, int count, const double* parameters, double* values) {
  for (int i = 0; i < count; ++i) {
    const CoefficientStep& s = steps[i];
    switch (s.kind) {
      case CoefficientStep::Kind::parameter: values[i] = parameters[s.a]; break;
      case CoefficientStep::Kind::literal: values[i] = s.number; break;
      case CoefficientStep::Kind::sum: values[i] = values[s.a] + values[s.b]; break;
      case CoefficientStep::Kind::difference: values[i] = values[s.a] - values[s.b]; break;
      case CoefficientStep::Kind::product: values[i] = values[s.a] * values[s.b]; break;
      case CoefficientStep::Kind::quotient: values[i] = values[s.a] / values[s.b]; break;
      case CoefficientStep::Kind::power: values[i] = std::pow(values[s.a], s.number); break;
    }
  }
}

}  // namespace qdot::formula
