#pragma once
// SPDX-License-Identifier: MIT
//
// Names of coordinates as people write them: "theta1" becomes θ₁, "phidot" becomes φ̇. Units likewise: "m/s^2" becomes m/s².

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "qdot/report/number.hpp"

namespace qdot::report {

/// A coordinate's identifier in mathematical writing; text that is no such identifier comes back unchanged.
///
/// Greek letters by name, a trailing number as a subscript, a "dot" behind or in front of it as a dot above.
inline std::string symbol(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 21> greek = {{
      {"alpha", "α"}, {"beta", "β"}, {"gamma", "γ"}, {"delta", "δ"}, {"theta", "θ"}, {"lambda", "λ"},
      {"mu", "μ"}, {"phi", "φ"}, {"psi", "ψ"}, {"omega", "ω"}, {"rho", "ρ"}, {"xi", "ξ"}, {"eta", "η"},
      {"epsilon", "ε"}, {"zeta", "ζ"}, {"kappa", "κ"}, {"nu", "ν"}, {"sigma", "σ"}, {"tau", "τ"}, {"chi", "χ"}, {"Omega", "Ω"},
  }};
  static constexpr std::array<std::string_view, 10> subscript = {"₀", "₁", "₂", "₃", "₄", "₅", "₆", "₇", "₈", "₉"};

  std::string_view stem = name;
  const auto loses_dot = [&stem] {
    const bool ends_in_dot = stem.size() > 3 && stem.substr(stem.size() - 3) == "dot";
    if (ends_in_dot) stem.remove_suffix(3);
    return ends_in_dot;
  };
  bool dotted = loses_dot();
  std::string_view number = stem;
  while (!stem.empty() && std::isdigit(static_cast<unsigned char>(stem.back())) != 0) stem.remove_suffix(1);
  number.remove_prefix(stem.size());
  if (!dotted) dotted = loses_dot();

  std::string_view letter = stem;
  for (const auto& [spelled, sign] : greek) {
    if (stem == spelled) letter = sign;
  }
  const bool single_letter = letter != stem || stem.size() == 1;
  if (!single_letter) return std::string(name);

  std::string text(letter);
  if (dotted) text += "\u0307";
  for (const char digit : number) text += subscript[static_cast<std::size_t>(digit - '0')];
  return text;
}

/// A unit with its powers raised, "m/s^2" as m/s²; files for machines keep the plain spelling.
inline std::string unit_symbol(std::string unit) {
  for (const auto& [plain, sign] : {std::pair<std::string_view, std::string_view>{"^2", "²"}, {"^3", "³"}}) {
    for (std::size_t at = unit.find(plain); at != std::string::npos; at = unit.find(plain)) unit.replace(at, 2, sign);
  }
  return unit;
}

/// The numbers of a text as people write them: "-1.5" with a minus sign, "2e-11" as 2×10⁻¹¹.
inline std::string with_readable_numbers(std::string_view text) {
  const auto is_digit = [&](std::size_t i) { return i < text.size() && std::isdigit(static_cast<unsigned char>(text[i])) != 0; };
  const auto is_word = [&](std::size_t i) { return std::isalnum(static_cast<unsigned char>(text[i])) != 0 || text[i] == '_'; };
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    const bool begins = i == 0 || std::string_view(" =(,:[|").find(text[i - 1]) != std::string_view::npos || text.substr(0, i).ends_with("±");
    if (text[i] == '-' && begins && is_digit(i + 1)) {
      result += "−";
      ++i;
    } else if (is_digit(i) && (i == 0 || !is_word(i - 1))) {
      while (is_digit(i) || (i < text.size() && text[i] == '.' && is_digit(i + 1))) result += text[i++];
      std::size_t power = i + 1 < text.size() && text[i] == 'e' ? i + 1 : text.size();
      power += power < text.size() && (text[power] == '-' || text[power] == '+') ? 1 : 0;
      if (!is_digit(power)) continue;
      result += "×10";
      if (text[power - 1] == '-') result += "⁻";
      while (is_digit(power) && text[power] == '0' && is_digit(power + 1)) ++power;
      for (i = power; is_digit(i); ++i) result += superscript(text[i] - '0');
    } else {
      result += text[i++];
    }
  }
  return result;
}

/// A text with all identifiers and numbers in it in mathematical writing: "theta1 at the start" as θ₁ at the start, "l [m/s^2]" as l [m/s²].
inline std::string in_symbols(std::string_view text) {
  const auto is_word = [&](std::size_t i) { return i < text.size() && (std::isalnum(static_cast<unsigned char>(text[i])) != 0 || text[i] == '_'); };
  std::string result;
  bool in_unit = false;
  for (std::size_t i = 0; i < text.size();) {
    std::size_t end = i;
    while (is_word(end)) ++end;
    in_unit = (in_unit || text[i] == '[') && text[i] != ']';
    const std::string_view word = text.substr(i, std::max<std::size_t>(1, end - i));
    result += end > i && !in_unit ? symbol(word) : std::string(word);
    i += word.size();
  }
  return unit_symbol(with_readable_numbers(result));
}

/// A number beside its unit, "9.81 m/s²"; the bare number where there is none.
inline std::string with_unit(const std::string& number, const std::string& unit) { return unit.empty() ? number : number + " " + unit_symbol(unit); }

/// A quantity with its unit in brackets, as axes have it: "t [s]"; the bare quantity where there is none.
inline std::string with_unit_symbol(const std::string& quantity, const std::string& unit) {
  return unit.empty() ? quantity : quantity + " [" + unit_symbol(unit) + "]";
}

}  // namespace qdot::report
