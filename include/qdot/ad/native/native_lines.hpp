#pragma once
// SPDX-License-Identifier: MIT
//
// Lines as machine code, from some evaluations on.
//
// LineEvaluator carries a table of lines out on numbers. The first evaluations are the interpreter's (ad/formula/lines.hpp). What is evaluated
// more often is worth being translated (ad/native/emitter.hpp): that takes as long as some hundred evaluations, and an evaluation takes
// half of the time then. Results have the same bits.
//
// The interpreter goes on by itself where the system refuses executable pages, on other processors than x86-64 and AArch64, where a table is longer than
// longest_native_lines, where the environment has QDOT_NATIVE=0, and where a first trial shows that the two would differ (a compiler that fuses
// products and sums though it is told not to).

#include <atomic>
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
#include "qdot/ad/native/x86_code.hpp"

namespace qdot::formula {

/// The code of this processor.
#if defined(__aarch64__)
using NativeCode = Arm64Code;
#else
using NativeCode = X86Code;
#endif
using NativeVectors = NativeCode::Vectors;  ///< of which the first are there on each

/// Machine code for one table of lines.
class NativeLines {
 public:
  /// @param read  which of the numbers are read from outside after an evaluation, not zero
  [[gnu::cold]] NativeLines(const LineTable& table, std::span<const char> read, NativeVectors vectors)
      : NativeLines(Emitter<NativeCode>(table, read.size(), read, vectors), vectors) {}

  bool exists() const { return entry_ != nullptr; }
#if defined(__clang__)
  [[clang::no_sanitize("function")]]  // which knows functions that it has compiled
#endif
  void operator()(double* x) const { entry_(x, constants_.data()); }
  /// Of code in fours or eights.
  void operator()(LaneNumber* x) const {
    for (std::size_t lane = 0; lane < lanes_stored; lane += lanes_) (*this)(x->lanes() + lane);
  }

 private:
  using Entry = void (*)(double*, const double*);

  NativeLines(Emitter<NativeCode>&& emitter, NativeVectors vectors)
      : lanes_(static_cast<std::size_t>(doubles_of(vectors))),
        constants_(emitter.take_constants()),
        circular_(emitter.take_circular()),
        calls_(emitter.take_calls()),
        pages_(addressed(emitter)),
        entry_(std::bit_cast<Entry>(pages_.entry())) {}

  // The code with the addresses of what calls are to do.
  std::vector<std::uint8_t> addressed(const Emitter<NativeCode>& emitter) const {
    std::vector<std::uint8_t> code = emitter.code();
    for (const auto& site : emitter.call_sites()) {
      const void* const what = site.circular ? static_cast<const void*>(circular_.data() + site.first) : calls_.data() + site.first;
      NativeCode::reset(code, site.at, std::bit_cast<std::uintptr_t>(what));
    }
    return code;
  }

  std::size_t lanes_;
  std::vector<double> constants_;
  std::vector<CircularPlaces> circular_;
  std::vector<Line> calls_;
  ExecutablePages pages_;
  Entry entry_;
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

/// Whether machine code may take the place of the interpreter in this process.
[[gnu::cold]] inline bool native_lines_are_possible() {
#if defined(__linux__) && (defined(__x86_64__) || defined(__aarch64__))
  static const bool possible = [] {
    const char* const wish = std::getenv("QDOT_NATIVE");
    if (wish != nullptr && std::string_view(wish) == "0") return false;
    LineTable table;  // 0.1 · 10 − 1 is 0, and 5.6e-17 with one rounding
    Line line{Line::Operation::product_difference, Function::none, 3, 0, 1};
    line.d = 2;
    table.lines = {line, Line{}};
    const char read[] = {0, 0, 0, 1};
    double interpreted[] = {0.1, 10.0, 1.0, 7.0}, native[] = {0.1, 10.0, 1.0, 7.0};
    carry_out(table, interpreted);
    const NativeLines code(table, read, best_vectors());
    if (!code.exists()) return false;
    code(native);
    LaneNumber lanes[4] = {};
    for (std::size_t k = 0; k < 3; ++k) lanes[k] = interpreted[k];
    carry_out(table, lanes);
    const auto bits = [](double x) { return std::bit_cast<std::uint64_t>(x); };
    return bits(interpreted[3]) == bits(native[3]) && bits(interpreted[3]) == bits(lanes[3].lanes()[0]);
  }();
  return possible;
#else
  return false;
#endif
}

/// A table of lines that is carried out many times, by several threads if need be.
class LineEvaluator {
 public:
  static constexpr long begin_after = MachineCodeBegins().alone;

  /// Takes a table before the first evaluation.
  ///
  /// @param count  how many numbers an evaluation has
  [[gnu::cold]] void set(LineTable table, std::size_t count, MachineCodeBegins begins = {}) {
    table_ = std::move(table);
    state_->read.assign(count, 0);
    begin(begins);
  }
  /// When there is to be machine code, counted from here.
  [[gnu::cold]] void begin(MachineCodeBegins begins) {
    state_->alone.begin_after(begins.alone), state_->in_lanes.begin_after(begins.in_lanes);
  }
  /// Says which numbers are read after an evaluation; −1 for none. Before the first evaluation.
  [[gnu::cold]] void add_read(std::span<const int> numbers) {
    for (const int number : numbers)
      if (number >= 0) mark(static_cast<std::uint32_t>(number));
  }
  /// Likewise, that another table reads them.
  [[gnu::cold]] void add_read(const LineEvaluator& other) {
    const StraightLines straight(other.table_, other.state_->read.size(), longest_native_lines);
    if (straight.lines().empty()) state_->read.assign(state_->read.size(), 1);
    for (const Line& line : straight.lines()) for_each_operand(line, [&](std::uint32_t number) { mark(number); });
  }

  const LineTable& table() const { return table_; }
  /// How many numbers an evaluation has.
  std::size_t count() const { return state_->read.size(); }

  void operator()(double* x) const {
    if (const NativeLines* const code = state_->alone.native()) return (*code)(x);
    carry_out(table_, x);
    if (state_->alone.is_due()) translate<>(state_->alone, best_vectors());
  }
  /// In eight lanes.
  void operator()(LaneNumber* x) const {
    if (const NativeLines* const code = state_->in_lanes.native()) return (*code)(x);
    carry_out(table_, x);
    if (state_->in_lanes.is_due()) translate<>(state_->in_lanes, best_lane_vectors());
  }

  /// Whether there is machine code.
  bool is_native() const { return state_->alone.native() != nullptr; }
  /// Whether evaluations are by machine code by now. Asking counts as an evaluation, for those that have another way until then.
  bool is_native_by_now() const {
    if (state_->alone.native()) return true;
    if (state_->alone.is_due()) translate<>(state_->alone, best_vectors());
    return false;
  }

 private:
  // Machine code, once there is some.
  class Code {
   public:
    void begin_after(long evaluations) { left_.store(evaluations, std::memory_order_relaxed); }
    const NativeLines* native() const { return made_.load(std::memory_order_acquire); }
    // Once true, of one thread, after some evaluations.
    bool is_due() { return left_.load(std::memory_order_relaxed) > 0 && left_.fetch_sub(1, std::memory_order_relaxed) == 1; }
    void take(std::unique_ptr<const NativeLines> code) {
      owned_ = std::move(code);
      made_.store(owned_.get(), std::memory_order_release);
    }

   private:
    std::atomic<long> left_{0};
    std::unique_ptr<const NativeLines> owned_;
    std::atomic<const NativeLines*> made_{nullptr};
  };
  struct State {
    std::vector<char> read;
    Code alone, in_lanes;
  };

  void mark(std::uint32_t number) {
    if (number < state_->read.size()) state_->read[number] = 1;
  }

  template <class Number = double>
  void translate(Code& code, NativeVectors vectors) const;

  LineTable table_;
  std::unique_ptr<State> state_ = std::make_unique<State>();
};

template <class Number>
[[gnu::cold, gnu::noinline]] void LineEvaluator::translate(Code& code, NativeVectors vectors) const {
  if (!native_lines_are_possible() || (&code == &state_->in_lanes && doubles_of(vectors) == 1)) return;
  auto made = std::make_unique<const NativeLines>(table_, state_->read, vectors);
  if (made->exists()) code.take(std::move(made));
}

#ifdef QDOT_COMPILED
extern template void LineEvaluator::translate<double>(Code&, NativeVectors) const;
#endif

}  // namespace qdot::formula
