#pragma once
// SPDX-License-Identifier: MIT
//
// Lines that are carried out many times.
//
// LineEvaluator carries a table of lines out on numbers. The first evaluations are the interpreter's (ad/formula/lines.hpp). What is evaluated
// more often is worth being translated to machine code (ad/native/line_evaluator.ipp): that takes as long as some hundred evaluations, and an evaluation
// takes half of the time then. Results have the same bits. Where there is no machine code, the interpreter goes on by itself.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "qdot/ad/formula/lane_lines.hpp"
#include "qdot/ad/formula/lines.hpp"

namespace qdot::formula {

/// Machine code that has been made.
class MachineCode {
 public:
  MachineCode() = default;
  MachineCode(const MachineCode&) = delete;
  MachineCode& operator=(const MachineCode&) = delete;
  virtual ~MachineCode() = default;

#if defined(__clang__)
  [[clang::no_sanitize("function")]]  // which knows functions that it has compiled
#endif
  void operator()(double* x) const { entry_(x, constants_); }
  /// Of code in fours or eights.
  void operator()(LaneNumber* x) const {
    for (std::size_t lane = 0; lane < lanes_stored; lane += lanes_) (*this)(x->lanes() + lane);
  }

 protected:
  using Entry = void (*)(double*, const double*);
  Entry entry_ = nullptr;
  const double* constants_ = nullptr;
  std::size_t lanes_ = 1;
};

/// Whether machine code may take the place of the interpreter in this process; and whether it takes several lanes at a time.
template <class = void>
bool native_lines_are_possible();
template <class = void>
bool native_lanes_are_possible();

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
  [[gnu::cold]] void add_read(const LineEvaluator& other) { mark_read_by<>(other); }

  const LineTable& table() const { return table_; }
  /// How many numbers an evaluation has.
  std::size_t count() const { return state_->read.size(); }

  void operator()(double* x) const {
    if (const MachineCode* const code = state_->alone.native()) return (*code)(x);
    carry_out(table_, x);
    if (state_->alone.is_due()) translate<false>();
  }
  /// In eight lanes.
  void operator()(LaneNumber* x) const {
    if (const MachineCode* const code = state_->in_lanes.native()) return (*code)(x);
    carry_out(table_, x);
    if (state_->in_lanes.is_due()) translate<true>();
  }

  /// Whether there is machine code.
  bool is_native() const { return state_->alone.native() != nullptr; }

 private:
  // Machine code, once there is some.
  class Code {
   public:
    void begin_after(long evaluations) { left_.store(evaluations, std::memory_order_relaxed); }
    const MachineCode* native() const { return made_.load(std::memory_order_acquire); }
    // Once true, of one thread, after some evaluations.
    bool is_due() { return left_.load(std::memory_order_relaxed) > 0 && left_.fetch_sub(1, std::memory_order_relaxed) == 1; }
    void take(std::unique_ptr<const MachineCode> code) {
      owned_ = std::move(code);
      made_.store(owned_.get(), std::memory_order_release);
    }

   private:
    std::atomic<long> left_{0};
    std::unique_ptr<const MachineCode> owned_;
    std::atomic<const MachineCode*> made_{nullptr};
  };
  struct State {
    std::vector<char> read;
    Code alone, in_lanes;
  };

  void mark(std::uint32_t number) {
    if (number < state_->read.size()) state_->read[number] = 1;
  }

  template <bool in_lanes>
  void translate() const;
  template <class Number = double>
  void mark_read_by(const LineEvaluator& other);

  LineTable table_;
  std::unique_ptr<State> state_ = std::make_unique<State>();
};

}  // namespace qdot::formula

#ifdef QDOT_COMPILED
namespace qdot::formula {
extern template bool native_lines_are_possible<void>();
extern template bool native_lanes_are_possible<void>();
extern template void LineEvaluator::translate<false>() const;
extern template void LineEvaluator::translate<true>() const;
extern template void LineEvaluator::mark_read_by<double>(const LineEvaluator&);
}  // namespace qdot::formula
#else
#include "qdot/ad/native/line_evaluator.ipp"
#endif
