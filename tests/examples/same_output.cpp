// SPDX-License-Identifier: MIT
//
// same_output PROGRAM EXPECTED: runs an example and compares what it prints with the text beside it, word by word. Words
// that are numbers may differ in their last digits, which belong to the compiler: by 1e-4 of their size or by 1e-6.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>

namespace {

bool same_word(const std::string& a, const std::string& b) {
  if (a == b) return true;
  char* end_a = nullptr;
  char* end_b = nullptr;
  const double x = std::strtod(a.c_str(), &end_a);
  const double y = std::strtod(b.c_str(), &end_b);
  if (end_a == a.c_str() || end_b == b.c_str() || std::string(end_a) != end_b) return false; // "3.14," keeps its comma
  return std::abs(x - y) <= 1e-6 + 1e-4 * std::max(std::abs(x), std::abs(y));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  FILE* pipe = popen(argv[1], "r");
  if (pipe == nullptr) return 2;
  std::string printed;
  std::array<char, 4096> buffer;
  for (std::size_t count = 0; (count = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) printed.append(buffer.data(), count);
  if (pclose(pipe) != 0) {
    std::cerr << printed << argv[1] << " failed\n";
    return 1;
  }

  std::ifstream expected_file(argv[2]);
  std::istringstream printed_lines(printed);
  std::string expected;
  std::string actual;
  for (int line = 1;; ++line) {
    const bool more_expected = static_cast<bool>(std::getline(expected_file, expected));
    const bool more_actual = static_cast<bool>(std::getline(printed_lines, actual));
    if (!more_expected && !more_actual) return 0;
    std::istringstream expected_words(more_expected ? expected : "(no more lines)");
    std::istringstream actual_words(more_actual ? actual : "(no more lines)");
    std::string a;
    std::string b;
    while (true) {
      const bool has_a = static_cast<bool>(expected_words >> a);
      const bool has_b = static_cast<bool>(actual_words >> b);
      if (!has_a && !has_b) break;
      if (has_a != has_b || !same_word(a, b)) {
        std::cerr << argv[2] << ", line " << line << "\n  expected: " << expected << "\n  printed:  " << actual << '\n';
        return 1;
      }
    }
  }
}
