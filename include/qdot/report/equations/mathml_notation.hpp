#pragma once
// SPDX-License-Identifier: MIT
//
// Formulas in MathML, of the elements that all browsers set today (MathML Core). No script, no font.

#include <string>

#include "qdot/report/equations/expression.hpp"
#include "qdot/report/number.hpp"
#include "qdot/report/svg.hpp"
#include "qdot/report/symbol.hpp"

namespace qdot::report {

class MathmlNotation final : public Notation {
 public:
  std::string symbol(const std::string& name, int dots) const override {
    const auto [letter, index] = spelled(name);
    std::string stem = "<mi>" + escaped(report::symbol(letter)) + "</mi>";
    if (dots > 0) stem = "<mover accent=\"true\">" + stem + "<mo stretchy=\"false\">" + (dots == 1 ? "˙" : "¨") + "</mo></mover>";
    if (index.empty()) return stem;
    const bool digits = index.find_first_not_of("0123456789") == std::string::npos;
    return "<msub>" + stem + (digits ? "<mn>" + index + "</mn>" : "<mi>" + escaped(index) + "</mi>") + "</msub>";
  }
  std::string indexed(const std::string& symbol, const std::string& index) const override { return "<msub>" + row(symbol) + row(index) + "</msub>"; }
  std::string number(double x) const override {
    const std::string text = exact_text(x);
    const auto e = text.find('e');
    if (e == std::string::npos) return "<mn>" + text + "</mn>";
    return "<mn>" + text.substr(0, e) + "</mn><mo>·</mo><msup><mn>10</mn><mn>" + std::to_string(std::stoi(text.substr(e + 1))) + "</mn></msup>";
  }
  std::string fraction(const std::string& above, const std::string& below) const override { return "<mfrac>" + row(above) + row(below) + "</mfrac>"; }
  std::string power(const std::string& base, const std::string& exponent) const override {
    if (base.starts_with("<msub>")) return "<msubsup>" + base.substr(6, base.size() - 13) + row(exponent) + "</msubsup>";
    return "<msup>" + row(base) + row(exponent) + "</msup>";
  }
  std::string exponent(double e) const override {
    const Fraction f = fraction_of(e < 0.0 ? -e : e);
    return (e < 0.0 ? "<mo>−</mo>" : "") + number(f.p) + (f.q == 1.0 ? "" : "<mo>/</mo>" + number(f.q));
  }
  std::string function(const std::string& name, const std::string& exponent, const std::string& argument) const override {
    const std::string word = "<mi>" + name + "</mi>";
    return (exponent.empty() ? word : power(word, exponent)) + "<mo>\u2061</mo>" +
           (argument.starts_with("<mrow><mo") ? "" : "<mspace width=\"0.17em\"/>") + row(argument);
  }
  std::string root(const std::string& x) const override { return "<msqrt>" + x + "</msqrt>"; }
  std::string brackets(const std::string& x) const override {
    const std::string bracket = x.find("<mfrac>") == std::string::npos ? "<mo stretchy=\"false\">" : "<mo>";
    return "<mrow>" + bracket + "(</mo>" + x + bracket + ")</mo></mrow>";
  }
  std::string space() const override { return "<mspace width=\"0.17em\"/>"; }
  std::string sign(bool minus, bool leading) const override { return std::string(leading ? "<mo form=\"prefix\">" : "<mo>") + (minus ? "−" : "+") + "</mo>"; }
  std::string comma() const override { return "<mo>,</mo>"; }

 private:
  static std::string row(const std::string& x) { return "<mrow>" + x + "</mrow>"; }
};

}  // namespace qdot::report
