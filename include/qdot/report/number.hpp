#pragma once
// SPDX-License-Identifier: MIT
//
// Numbers as text, in two strengths.
//
// `exact_text` is for machines: the shortest decimal that reads back to the same double (std::to_chars, which
// needs at most 17 digits and no locale). `rounded_text` is for people and for pictures: few digits, no trailing zeros.
// Neither depends on the global locale, so a German desktop writes the same files as a server.

#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

#include "qdot/error.hpp"

namespace qdot::report {

namespace detail {

// What std::to_chars writes, at most so many characters; NaN without its sign.
template <std::size_t most, class... Format>
std::string characters(double x, const Format&... format) {
  std::array<char, most> buffer{};
  return {buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), std::isnan(x) ? std::abs(x) : x, format...).ptr};
}

}  // namespace detail

/// The shortest decimal text that reads back to exactly x; "nan", "inf", "-inf" where x is not finite.
inline std::string exact_text(double x) { return detail::characters<32>(x); }

/// x with a given number of decimals, without trailing zeros and without "-0".
inline std::string fixed_text(double x, int decimals) {
  std::string text = detail::characters<400>(x, std::chars_format::fixed, decimals);  // the largest double has 309 digits before the point
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

/// x to a number of significant digits, the shorter of plain and exponent notation: "0.00125", "1.3e-09".
inline std::string rounded_text(double x, int digits = 6) {
  return detail::characters<64>(x, std::chars_format::general, digits);
}

/// An integer exponent in Unicode superscripts: "⁻¹²".
inline std::string superscript(int exponent) {
  static constexpr std::array<std::string_view, 10> digits = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text;
  for (const char c : std::to_string(exponent)) {
    text += c == '-' ? std::string_view("⁻") : digits[static_cast<std::size_t>(c - '0')];
  }
  return text;
}

/// x for people: "1.25", "3.4×10⁻¹³", "10⁻⁹".
inline std::string readable_text(double x, int digits = 4) {
  std::string text = rounded_text(x, digits);
  const auto e = text.find('e');
  if (e == std::string::npos) return text;
  const std::string power = "10" + superscript(std::stoi(text.substr(e + 1)));
  return e == 1 && text[0] == '1' ? power : text.substr(0, e) + "×" + power;
}

}  // namespace qdot::report
