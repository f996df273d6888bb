#pragma once
// SPDX-License-Identifier: MIT
//
// Formulas in LaTeX: \frac{1}{2} m_{1} \dot{\theta}_{1}^{2}. amsmath has all that is used.

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "qdot/report/equations/expression.hpp"
#include "qdot/report/number.hpp"

namespace qdot::report {

class LatexNotation final : public Notation {
 public:
  std::string symbol(const std::string& name, int dots) const override {
    static constexpr std::array<std::string_view, 22> greek = {"alpha", "beta",  "gamma", "delta", "epsilon", "zeta", "eta", "theta", "kappa", "lambda", "mu",
                                                               "nu",    "xi",    "pi",    "rho",   "sigma",   "tau",  "phi", "chi",   "psi",   "omega",  "Omega"};
    const auto [letter, index] = spelled(name);
    const bool is_greek = std::find(greek.begin(), greek.end(), letter) != greek.end();
    std::string stem = is_greek ? "\\" + letter : letter.size() == 1 ? letter : "\\mathit{" + escaped(letter) + "}";
    if (dots == 1) stem = "\\dot{" + stem + "}";
    if (dots == 2) stem = "\\ddot{" + stem + "}";
    return index.empty() ? stem : stem + "_{" + escaped(index) + "}";
  }
  std::string indexed(const std::string& symbol, const std::string& index) const override { return symbol + "_{" + index + "}"; }
  std::string number(double x) const override {
    const std::string text = exact_text(x);
    const auto e = text.find('e');
    return e == std::string::npos ? text : text.substr(0, e) + " \\cdot 10^{" + std::to_string(std::stoi(text.substr(e + 1))) + "}";
  }
  std::string fraction(const std::string& above, const std::string& below) const override { return "\\frac{" + above + "}{" + below + "}"; }
  std::string power(const std::string& base, const std::string& exponent) const override { return base + "^{" + exponent + "}"; }
  std::string exponent(double e) const override {
    const Fraction f = fraction_of(e < 0.0 ? -e : e);
    return (e < 0.0 ? "-" : "") + number(f.p) + (f.q == 1.0 ? "" : "/" + number(f.q));
  }
  std::string function(const std::string& name, const std::string& exponent, const std::string& argument) const override {
    static constexpr std::array<std::string_view, 9> known = {"sin", "cos", "tan", "exp", "sinh", "cosh", "tanh", "log", "ln"};
    const bool is_known = std::find(known.begin(), known.end(), name) != known.end();
    return (is_known ? "\\" + name : "\\operatorname{" + name + "}") + (exponent.empty() ? "" : "^{" + exponent + "}") + " " + argument;
  }
  std::string root(const std::string& x) const override { return "\\sqrt{" + x + "}"; }
  std::string brackets(const std::string& x) const override { return "\\left(" + x + "\\right)"; }
  std::string sign(bool minus, bool leading) const override { return leading ? (minus ? "-" : "") : minus ? " - " : " + "; }

 private:
  static std::string escaped(const std::string& word) {
    std::string text;
    for (const char c : word) text += c == '_' ? std::string("\\_") : std::string(1, c);
    return text;
  }
};

}  // namespace qdot::report
