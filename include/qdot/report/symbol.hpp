#pragma once
// SPDX-License-Identifier: MIT
//
// Names of coordinates as people write them: "theta1" becomes θ₁, "phidot" becomes φ̇.

#include <array>
#include <cctype>
#include <string>
#include <string_view>
#include <utility>

namespace qdot::report {

/// A coordinate's identifier in mathematical writing; text that is no such identifier comes back unchanged.
///
/// Greek letters by name, a trailing number as a subscript, a trailing "dot" as a dot above.
inline std::string symbol(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 21> greek = {{
      {"alpha", "α"}, {"beta", "β"}, {"gamma", "γ"}, {"delta", "δ"}, {"theta", "θ"}, {"lambda", "λ"},
      {"mu", "μ"}, {"phi", "φ"}, {"psi", "ψ"}, {"omega", "ω"}, {"rho", "ρ"}, {"xi", "ξ"}, {"eta", "η"},
      {"epsilon", "ε"}, {"zeta", "ζ"}, {"kappa", "κ"}, {"nu", "ν"}, {"sigma", "σ"}, {"tau", "τ"}, {"chi", "χ"}, {"Omega", "Ω"},
  }};
  static constexpr std::array<std::string_view, 10> subscript = {"₀", "₁", "₂", "₃", "₄", "₅", "₆", "₇", "₈", "₉"};

  std::string_view stem = name;
  const bool dotted = stem.size() > 3 && stem.substr(stem.size() - 3) == "dot";
  if (dotted) stem.remove_suffix(3);
  std::string_view number = stem;
  while (!stem.empty() && std::isdigit(static_cast<unsigned char>(stem.back())) != 0) stem.remove_suffix(1);
  number.remove_prefix(stem.size());

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

}  // namespace qdot::report
