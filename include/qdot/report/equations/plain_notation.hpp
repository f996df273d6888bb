#pragma once
// SPDX-License-Identifier: MIT
//
// Formulas on a terminal: ½ m₁ l₁² θ̇₁² − m g cos θ. Fractions have a stroke, what is below it is bracketed.

#include <cmath>
#include <string>

#include "qdot/report/equations/expression.hpp"
#include "qdot/report/number.hpp"
#include "qdot/report/symbol.hpp"

namespace qdot::report {

class PlainNotation final : public Notation {
 public:
  std::string symbol(const std::string& name, int dots) const override {
    const auto [letter, index] = spelled(name);
    const bool is_word = letter.size() > 1 && report::symbol(letter) == letter;
    std::string stem = is_word ? name : report::symbol(letter);
    if (dots == 1) stem += "\u0307";
    if (dots == 2) stem += "\u0308";
    return index.empty() || is_word ? stem : stem + subscript(index);
  }
  std::string indexed(const std::string& symbol, const std::string& index) const override { return symbol + "_" + index; }
  std::string number(double x) const override { return exact_text(x); }
  std::string fraction(const std::string& above, const std::string& below) const override { return above + "/" + below; }
  std::string number_fraction(double p, double q) const override {
    struct Glyph {
      int p, q;
      const char* text;
    };
    static constexpr Glyph glyphs[] = {{1, 2, "½"}, {1, 3, "⅓"}, {2, 3, "⅔"}, {1, 4, "¼"}, {3, 4, "¾"}, {1, 5, "⅕"},
                                       {2, 5, "⅖"}, {1, 6, "⅙"}, {5, 6, "⅚"}, {1, 8, "⅛"}, {3, 8, "⅜"}};
    for (const Glyph& g : glyphs)
      if (p == g.p && q == g.q) return g.text;
    return number(p) + "/" + number(q);
  }
  std::string power(const std::string& base, const std::string& exponent) const override { return base + exponent; }
  std::string exponent(double e) const override {
    if (e == std::round(e) && std::abs(e) < 1000) return superscript(static_cast<int>(e));
    const Fraction f = fraction_of(std::abs(e));
    const std::string text = f.q == 1.0 ? number(f.p) : number(f.p) + "/" + number(f.q);
    return e < 0.0 ? "^(−" + text + ")" : "^(" + text + ")";
  }
  std::string function(const std::string& name, const std::string& exponent, const std::string& argument) const override {
    return name + exponent + (argument.starts_with("(") ? "" : " ") + argument;
  }
  std::string root(const std::string& x) const override { return x.find_first_of(" /^") == std::string::npos ? "√" + x : "√(" + x + ")"; }
  std::string brackets(const std::string& x) const override { return "(" + x + ")"; }
  std::string sign(bool minus, bool leading) const override { return leading ? (minus ? "−" : "") : minus ? " − " : " + "; }
  bool has_stacked_fractions() const override { return false; }

 private:
  static std::string subscript(const std::string& index) {
    static constexpr const char* digits[] = {"₀", "₁", "₂", "₃", "₄", "₅", "₆", "₇", "₈", "₉"};
    std::string text;
    for (const char c : index) {
      if (c < '0' || c > '9') return "_" + index;
      text += digits[c - '0'];
    }
    return text;
  }
};

}  // namespace qdot::report
