#pragma once
// SPDX-License-Identifier: MIT
//
// Formulas as people write them, and three ways to write them down.
//
// An expression is a tree whose nodes a typesetter knows: a name, a sum, a power, a function of something. Another node is a product over
// another with a rational number in front. It is not simplified here; the code that makes it has done that (report/equations/layout.hpp).
//
//     plain      ½ m₁ l₁² θ̇₁²  −  m g cos θ
//     LaTeX      \frac{1}{2} m_1 l_1^2 \dot{\theta}_1^2 − m g \cos \theta
//     MathML     the same as elements that a browser sets by itself, without a script
//
// One function walks the tree; a notation only says how each of the pieces looks.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "qdot/report/number.hpp"

namespace qdot::report {

/// A formula. Numbers other than exponents are coefficients of products.
struct Expression {
  enum class Kind { symbol, sum, product, power, function };
  Kind kind = Kind::product;
  std::string name = {};                 // of a symbol or a function
  int dots = 0;                          // above a symbol: time derivatives
  bool is_constant = false;              // of a symbol: a parameter
  double number = 1.0;                   // coefficient of a product; exponent of a power
  std::vector<Expression> parts = {};    // summands, factors, the base, arguments; of a symbol its index
  std::vector<Expression> divisors = {}; // of a product

  bool is_number() const { return kind == Kind::product && parts.empty() && divisors.empty(); }
};

inline Expression number_expression(double x) { return {.number = x}; }
inline Expression symbol_expression(std::string name, int dots = 0) { return {.kind = Expression::Kind::symbol, .name = std::move(name), .dots = dots}; }

/// How many names and numbers one reads.
inline int size_of(const Expression& e) {
  int size = e.kind == Expression::Kind::sum ? 0 : e.kind == Expression::Kind::product ? (std::abs(e.number) != 1.0 ? 1 : 0) : 1;
  for (const Expression& part : e.parts) size += size_of(part);
  for (const Expression& divisor : e.divisors) size += size_of(divisor);
  return size;
}

/// x as p/q with q of at most 1000; q = 1 where it is none, and p is x.
struct Fraction {
  double p, q;
};
inline Fraction fraction_of(double x) {
  for (int q = 1; q <= 1000; ++q) {
    const double p = std::round(x * q);
    if (std::abs(p) <= 1e4 && p != 0.0 && std::abs(x * q - p) <= 4e-16 * std::abs(p)) {
      // Halves to twelfths are read as fractions; 981/100 is 9.81.
      if (q <= 12 || (q % 3 == 0 && q <= 144)) return {p, static_cast<double>(q)};
      break;
    }
  }
  return {x, 1.0};
}

/// A name taken apart: theta1 is the letter theta and the index 1.
struct SpelledName {
  std::string letter, index;
};
inline SpelledName spelled(std::string_view name) {
  std::size_t end = name.size();
  while (end > 1 && name[end - 1] >= '0' && name[end - 1] <= '9') --end;
  std::string letter(name.substr(0, end)), index(name.substr(end));
  const std::size_t line = letter.find('_');
  if (line != std::string::npos && line > 0) {
    index = letter.substr(line + 1) + index;
    letter = letter.substr(0, line);
  }
  return {letter, index};
}

/// How pieces of a formula look.
class Notation {
 public:
  virtual ~Notation() = default;
  virtual std::string symbol(const std::string& name, int dots) const = 0;
  virtual std::string indexed(const std::string& symbol, const std::string& index) const = 0;
  virtual std::string number(double x) const = 0;                                               // not negative
  virtual std::string fraction(const std::string& above, const std::string& below) const = 0;  // both as products
  virtual std::string number_fraction(double p, double q) const { return fraction(number(p), number(q)); }
  virtual std::string power(const std::string& base, const std::string& exponent) const = 0;
  virtual std::string exponent(double e) const = 0;
  virtual std::string function(const std::string& name, const std::string& exponent, const std::string& argument) const = 0;
  virtual std::string root(const std::string& x) const = 0;
  virtual std::string brackets(const std::string& x) const = 0;
  virtual std::string joined(const std::vector<std::string>& factors) const {
    std::string text;
    for (const std::string& factor : factors) text += (text.empty() ? "" : space()) + factor;
    return text;
  }
  virtual std::string space() const { return " "; }  // between factors
  virtual std::string sign(bool minus, bool leading) const = 0;
  virtual std::string comma() const { return ", "; }
  virtual bool has_stacked_fractions() const { return true; }  // whose parts need no brackets
};

namespace detail {

/// Writes expressions in a notation.
class ExpressionWriter {
 public:
  explicit ExpressionWriter(const Notation& notation) : n_(notation) {}

  std::string text(const Expression& e) const { return is_negative(e) ? n_.sign(true, true) + unsigned_text(e) : unsigned_text(e); }

 private:
  using Kind = Expression::Kind;

  static bool is_negative(const Expression& e) { return e.kind == Kind::product && e.number < 0.0; }

  std::string unsigned_text(const Expression& e) const {
    switch (e.kind) {
      case Kind::symbol: return e.parts.empty() ? n_.symbol(e.name, e.dots) : n_.indexed(n_.symbol(e.name, e.dots), text(e.parts[0]));
      case Kind::sum: {
        std::string text;
        for (std::size_t i = 0; i < e.parts.size(); ++i) {
          const bool minus = is_negative(e.parts[i]);
          if (i > 0 || minus) text += n_.sign(minus, i == 0);
          text += unsigned_text(e.parts[i]);
        }
        return text;
      }
      case Kind::power: return power(e);
      case Kind::function: return function(e, "");
      case Kind::product: return product(e);
    }
    return {};
  }

  // What multiplies others.
  std::string factor(const Expression& e) const {
    if (e.kind == Kind::sum || is_negative(e)) return n_.brackets(text(e));
    return unsigned_text(e);
  }
  std::string product(const Expression& e) const {
    const Fraction f = fraction_of(std::abs(e.number));
    if (e.divisors.empty()) {
      if (e.parts.size() == 1 && f.p == 1.0 && f.q == 1.0) return factor(e.parts[0]);
      return n_.joined(with_number(f, e.parts));
    }
    // (g/l) θ̇ sin θ, where there are parameters only below.
    const auto first = std::find_if(e.parts.begin(), e.parts.end(), [](const Expression& x) { return !is_parameter(x); });
    if ((first == e.parts.begin() && f.p == 1.0) || !std::all_of(e.divisors.begin(), e.divisors.end(), is_parameter) ||
        !std::any_of(first, e.parts.end(), is_function))
      return fraction(f, e.parts, e.divisors);
    const std::string quotient = fraction(f, {e.parts.begin(), first}, e.divisors);
    std::vector<std::string> factors{n_.has_stacked_fractions() ? quotient : n_.brackets(quotient)};
    for (auto x = first; x != e.parts.end(); ++x) factors.push_back(factor(*x));
    return n_.joined(factors);
  }
  static bool is_parameter(const Expression& e) { return e.kind == Kind::symbol ? e.is_constant : e.kind == Kind::power && is_parameter(e.parts[0]); }
  static bool is_function(const Expression& e) { return e.kind == Kind::function || (e.kind == Kind::power && e.parts[0].kind == Kind::function); }
  std::string fraction(Fraction f, const std::vector<Expression>& parts, const std::vector<Expression>& divisors) const {
    const std::vector<std::string> below = with_number({f.q, 1.0}, divisors), above = with_number({f.p, 1.0}, parts);
    if (n_.has_stacked_fractions())
      return n_.fraction(f.p == 1.0 ? bare(above, parts) : n_.joined(above), f.q == 1.0 ? bare(below, divisors) : n_.joined(below));
    const std::string divisor = n_.joined(below);
    return n_.fraction(n_.joined(above), below.size() == 1 ? divisor : n_.brackets(divisor));
  }
  // A sum alone above or below a line needs no brackets.
  std::string bare(const std::vector<std::string>& factors, const std::vector<Expression>& from) const {
    return from.size() == 1 && from[0].kind == Kind::sum ? text(from[0]) : n_.joined(factors);
  }
  std::vector<std::string> with_number(Fraction f, const std::vector<Expression>& parts) const {
    std::vector<std::string> factors;
    if (f.q != 1.0) factors.push_back(n_.number_fraction(f.p, f.q));
    if (f.q == 1.0 && (f.p != 1.0 || parts.empty())) factors.push_back(n_.number(f.p));
    for (const Expression& part : parts) factors.push_back(factor(part));
    return factors;
  }
  std::string power(const Expression& e) const {
    const Expression& base = e.parts[0];
    if (e.number == 0.5) return n_.root(text(base));
    const std::string exponent = n_.exponent(e.number);
    if (base.kind == Kind::function && e.number > 0.0) return function(base, exponent);
    return n_.power(base.kind == Kind::symbol ? unsigned_text(base) : n_.brackets(text(base)), exponent);
  }
  std::string function(const Expression& e, const std::string& exponent) const {
    std::string arguments;
    for (const Expression& argument : e.parts) arguments += (arguments.empty() ? "" : n_.comma()) + text(argument);
    const Expression& x = e.parts[0];
    const bool is_bare = e.parts.size() == 1 && (x.kind == Kind::symbol || (x.kind == Kind::product && x.number > 0.0 && x.divisors.empty() && all_symbols(x)));
    return n_.function(e.name, exponent, is_bare ? arguments : n_.brackets(arguments));
  }
  static bool all_symbols(const Expression& x) {
    for (const Expression& part : x.parts)
      if (part.kind != Kind::symbol) return false;
    return true;
  }

  const Notation& n_;
};

}  // namespace detail

/// An expression in a notation.
inline std::string text_of(const Expression& e, const Notation& notation) { return detail::ExpressionWriter(notation).text(e); }

}  // namespace qdot::report
