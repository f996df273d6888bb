// SPDX-License-Identifier: MIT
#include "program/arguments.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <numbers>
#include <string_view>
#include <system_error>

#include "qdot/report/file.hpp"

namespace qdot::program {

namespace {

/// Edits between two names: insert, delete or replace a letter, or swap two neighbours (Damerau 1964).
std::size_t edits(const std::string& a, const std::string& b) {
  const std::size_t columns = b.size() + 1;
  std::vector<std::size_t> d((a.size() + 1) * columns);
  const auto at = [&](std::size_t i, std::size_t j) -> std::size_t& { return d[i * columns + j]; };
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        at(i, j) = i + j;
        continue;
      }
      at(i, j) = std::min({at(i - 1, j) + 1, at(i, j - 1) + 1, at(i - 1, j - 1) + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        at(i, j) = std::min(at(i, j), at(i - 2, j - 2) + 1);
      }
    }
  }
  return d.back();
}

std::string joined(const std::vector<std::string>& names) {
  constexpr std::size_t shown = 24;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), shown); ++i) text += (i == 0 ? "" : ", ") + names[i];
  return names.size() > shown ? text + ", …" : text;
}

/// The text with line breaks and control characters made visible, so that a message stays on one line.
std::string one_line(const std::string& text) {
  std::string result;
  for (const char c : text) result += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
  return result;
}

/// What is left to read of a number's text.
struct Unread {
  std::string_view text;

  bool take(std::string_view word) {
    if (!text.starts_with(word)) return false;
    text.remove_prefix(word.size());
    return true;
  }

  /// A decimal number without a sign.
  std::optional<double> decimal() {
    if (text.empty() || (text.front() != '.' && std::isdigit(static_cast<unsigned char>(text.front())) == 0)) return {};
    double value = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc()) return {};
    text.remove_prefix(static_cast<std::size_t>(stop - text.data()));
    return value;
  }

  /// pi, or a decimal number with nothing, pi or deg behind it.
  std::optional<double> factor() {
    if (take("pi")) return std::numbers::pi;
    const std::optional<double> value = decimal();
    if (!value) return {};
    if (take("pi")) return *value * std::numbers::pi;
    return take("deg") ? *value / 180.0 * std::numbers::pi : *value;  // in this order 90deg is pi/2 to the last bit
  }
};

/// What a text denotes, factors with * and / between them; nothing where it is something else.
std::optional<double> number_in(std::string_view text) {
  Unread unread{text};
  const bool negative = unread.take("-");
  if (!negative) unread.take("+");
  std::optional<double> value = unread.factor();
  while (value && !unread.text.empty()) {
    const bool divided = unread.take("/");
    if (!divided && !unread.take("*")) return {};
    const std::optional<double> next = unread.factor();
    if (!next) return {};
    *value = divided ? *value / *next : *value * *next;
  }
  return value && negative ? -*value : value;
}

}  // namespace

std::string nearest_name(const std::string& wanted, const std::vector<std::string>& candidates) {
  std::string nearest;
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  for (const std::string& candidate : candidates) {
    // A name that continues what was typed ("double" for double_pendulum) beats one that is as short by chance, and so does one in other letters' case.
    const auto same = [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b)); };
    const bool in_other_case = std::equal(wanted.begin(), wanted.end(), candidate.begin(), candidate.end(), same);
    const std::size_t count = in_other_case ? 0 : !wanted.empty() && candidate.starts_with(wanted) ? 1 : edits(wanted, candidate);
    if (count < fewest) {
      fewest = count;
      nearest = candidate;
    }
  }
  return nearest;
}

UsageError unknown_name(const std::string& argument, const std::string& what, const std::string& given,
                        const std::vector<std::string>& valid) {
  const std::string nearest = nearest_name(given, valid);
  const bool alike = edits(given, nearest) < std::max(given.size(), nearest.size());  // otherwise they have nothing in common
  return UsageError(argument + ": must be " + what + ", given \"" + one_line(given) + "\"; " +
                    (alike ? "the nearest is \"" + nearest + "\" (of " : "there are (") + joined(valid) + ")");
}

double finite_number(const std::string& argument, const std::string& text) {
  const std::optional<double> value = number_in(text);
  if (!value || !std::isfinite(*value))
    throw UsageError(argument + ": must be a finite number, given \"" + one_line(text) + "\"; type one such as 0.5, 1e-3, pi/2, -3*pi/4 or 90deg");
  return *value;
}

double positive_number(const std::string& argument, const std::string& text) {
  const double x = finite_number(argument, text);
  if (!(x > 0.0)) throw UsageError(argument + ": must be positive, given " + text);
  return x;
}

long whole_number(const std::string& argument, const std::string& text, long least, long most) {
  long value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (stop != text.data() + text.size() || error != std::errc() || text.empty() || value < least || value > most) {
    throw UsageError(argument + ": must be a whole number from " + std::to_string(least) + " to " + std::to_string(most) +
                     ", given \"" + one_line(text) + "\"");
  }
  return value;
}

Assignment assignment(const std::string& argument, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw UsageError(argument + ": must have the form NAME=VALUE, given \"" + one_line(text) + "\"");
  }
  const std::string name = text.substr(0, equals);
  return {name, finite_number(argument + " " + one_line(name), text.substr(equals + 1))};
}

void make_directory_of(const std::string& out) {
  std::error_code refused;  // writing the file gives the reason
  const std::filesystem::path directory = std::filesystem::path(out).parent_path();
  if (!directory.empty()) std::filesystem::create_directories(directory, refused);
}

void require_files(const std::string& out, const std::vector<std::string>& files) {
  if (out.empty() || out.back() == '/') {
    throw UsageError("--out: must be a path whose last part is a file's name, given \"" + out + "\"");
  }
  make_directory_of(out);
  try {
    report::require_writable(files);
  } catch (const report::UnwritableFile& error) {
    throw UsageError(std::string("--out: ") + error.what());
  }
}

std::vector<std::string> writable_files(const std::optional<std::string>& out, const std::vector<std::string>& endings) {
  std::vector<std::string> files;
  if (!out) return files;
  for (const std::string& ending : endings) files.push_back(*out + ending);
  require_files(*out, files);
  return files;
}

}  // namespace qdot::program
