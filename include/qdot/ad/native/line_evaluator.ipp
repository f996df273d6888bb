#pragma once
// SPDX-License-Identifier: MIT
//
// Lines as machine code: what LineEvaluator (ad/native/line_evaluator.hpp) does once a table has been carried out often.
//
// The table is translated (ad/native/emitter.hpp) and the code put into executable pages (ad/native/executable_pages.hpp). There is none where the system
// refuses such pages, on other processors than x86-64 and AArch64, and where a table is longer than longest_native_lines. There is none either where the
// environment has QDOT_NATIVE=0, and where a first trial shows that the two would differ. That happens with a compiler that fuses products and sums
// though it is told not to.
//
// Programs that link qdot::compiled do not read this file: the library has it.

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "qdot/ad/native/arm64_code.hpp"
#include "qdot/ad/native/emitter.hpp"
#include "qdot/ad/native/executable_pages.hpp"
#include "qdot/ad/native/line_evaluator.hpp"
#include "qdot/ad/native/straight_lines.hpp"
#include "qdot/ad/native/x86_code.hpp"

namespace qdot::formula {

/// The code of this processor.
#if defined(__aarch64__)
using NativeCode = Arm64Code;
#else
using NativeCode = X86Code;
#endif
using NativeVectors = NativeCode::Vectors;  ///< of which the first are there on each

/// Machine code for one table of lines, with what it reads and calls.
class NativeLines : public MachineCode {
 public:
  /// @param read  which of the numbers are read from outside after an evaluation, not zero
  [[gnu::cold]] NativeLines(const LineTable& table, std::span<const char> read, NativeVectors vectors)
      : NativeLines(Emitter<NativeCode>(table, read.size(), read, vectors), vectors) {}

  bool exists() const { return entry_ != nullptr; }

 private:
  NativeLines(Emitter<NativeCode>&& emitter, NativeVectors vectors)
      : numbers_(emitter.take_constants()), circular_(emitter.take_circular()), calls_(emitter.take_calls()), pages_(addressed(emitter)) {
    entry_ = std::bit_cast<Entry>(pages_.entry());
    constants_ = numbers_.data();
    lanes_ = static_cast<std::size_t>(doubles_of(vectors));
  }

  // The code with the addresses of what calls are to do.
  std::vector<std::uint8_t> addressed(const Emitter<NativeCode>& emitter) const {
    std::vector<std::uint8_t> code = emitter.code();
    for (const auto& site : emitter.call_sites()) {
      const void* const what = site.circular ? static_cast<const void*>(circular_.data() + site.first) : calls_.data() + site.first;
      NativeCode::reset(code, site.at, std::bit_cast<std::uintptr_t>(what));
    }
    return code;
  }

  std::vector<double> numbers_;
  std::vector<CircularPlaces> circular_;
  std::vector<Line> calls_;
  ExecutablePages pages_;
};

/// The best instructions of this processor, for single numbers.
inline NativeVectors best_vectors() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") != 0) return X86Vectors::avx2;
  if (__builtin_cpu_supports("avx") != 0) return X86Vectors::avx;
#endif
  return {};
}
/// Those for lanes; of single doubles where there are none.
inline NativeVectors best_lane_vectors() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") != 0) return X86Vectors::avx512_in_eights;
  if (__builtin_cpu_supports("avx2") != 0) return X86Vectors::avx_in_fours;
#endif
  return {};
}

// One line whose result tells whether product and difference were rounded apart: 0.1 · 10 − 1 is 0, and 5.6e-17 with one rounding. Its numbers are the last.
inline constexpr double of_trial[] = {0.1, 10.0, 1.0, 7.0};
[[gnu::cold]] inline LineTable trial_of_rounding() {
  LineTable table;
  Line line{Line::Operation::product_difference, Function::none, 3, 0, 1};
  line.d = 2;
  table.lines = {line, Line{}};
  return table;
}
inline bool have_same_bits(double x, double y) { return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y); }

template <class>
[[gnu::cold]] bool native_lines_are_possible() {
#if defined(__linux__) && (defined(__x86_64__) || defined(__aarch64__))
  static const bool possible = [] {
    const char* const wish = std::getenv("QDOT_NATIVE");
    if (wish != nullptr && std::string_view(wish) == "0") return false;
    const LineTable table = trial_of_rounding();
    const char read[] = {0, 0, 0, 1};
    double interpreted[4], native[4];
    std::copy_n(of_trial, 4, interpreted), std::copy_n(of_trial, 4, native);
    carry_out(table, interpreted);
    const NativeLines code(table, read, best_vectors());
    if (!code.exists()) return false;
    code(native);
    return have_same_bits(interpreted[3], native[3]);
  }();
  return possible;
#else
  return false;
#endif
}

template <class>
[[gnu::cold]] bool native_lanes_are_possible() {
  static const bool possible = [] {
    if (!native_lines_are_possible() || doubles_of(best_lane_vectors()) <= 1) return false;
    const LineTable table = trial_of_rounding();
    double interpreted[4];
    LaneNumber lanes[4] = {};
    std::copy_n(of_trial, 4, interpreted);
    for (std::size_t k = 0; k < 3; ++k) lanes[k] = interpreted[k];
    carry_out(table, interpreted), carry_out(table, lanes);
    return have_same_bits(interpreted[3], lanes[3].lanes()[0]);
  }();
  return possible;
}

template <bool in_lanes>
[[gnu::cold, gnu::noinline]] void LineEvaluator::translate() const {
  if constexpr (in_lanes) {
    if (!native_lanes_are_possible()) return;
  } else {
    if (!native_lines_are_possible()) return;
  }
  auto made = std::make_unique<const NativeLines>(table_, state_->read, in_lanes ? best_lane_vectors() : best_vectors());
  if (made->exists()) (in_lanes ? state_->in_lanes : state_->alone).take(std::move(made));
}
template <class Number>
[[gnu::cold]] void LineEvaluator::mark_read_by(const LineEvaluator& other) {
  const StraightLines straight(other.table_, other.state_->read.size(), longest_native_lines);
  if (straight.lines().empty()) state_->read.assign(state_->read.size(), 1);
  for (const Line& line : straight.lines()) for_each_operand(line, [&](std::uint32_t number) { mark(number); });
}

}  // namespace qdot::formula
