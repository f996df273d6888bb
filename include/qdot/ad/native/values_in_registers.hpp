#pragma once
// SPDX-License-Identifier: MIT
//
// Which register or place in memory has a value, while code is written.
//
// Values stay in registers as long as there is room. What gives way is the value whose next use is furthest away. Values that are read from outside
// are stored when they are computed, others only where they give way. They go to places of numbers that are not read and not needed at the time;
// these are few, and stay in the cache.

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "qdot/ad/formula/lane_lines.hpp"
#include "qdot/ad/native/machine_operand.hpp"
#include "qdot/ad/native/straight_lines.hpp"

namespace qdot::formula {

/// The values of some lines and where they are. Code that it writes loads and stores them.
template <class Code>
class ValuesInRegisters {
 protected:
  static constexpr std::uint32_t none = StraightLines::never;
  static constexpr int most_registers = 32;

  /// @param read  numbers that are read from outside, not zero
  [[gnu::cold]] ValuesInRegisters(StraightLines straight, std::span<const char> read, typename Code::Vectors vectors)
      : straight_(std::move(straight)),
        code_(vectors),
        vectors_(vectors),
        read_(read),
        place_(read.size(), -1),
        in_memory_(read.size(), 1),
        memory_(read.size()) {
    holds_.fill(none);
    std::iota(memory_.begin(), memory_.end(), 0u);
    const std::vector<Line>& lines = straight_.lines();
    for (auto line = lines.rbegin(); line != lines.rend(); ++line)
      for_each_result(*line, [&](std::uint32_t v) {
        in_memory_[v] = 0;
        if (!read_[v]) free_.push_back(v);
      });
  }

  bool is_of_lanes() const { return doubles_of(vectors_) > 1; }
  // How many doubles a number takes in memory.
  std::uint32_t stride() const { return is_of_lanes() ? static_cast<std::uint32_t>(lanes_stored) : 1; }
  MachineOperand memory(std::uint32_t v) const { return MachineOperand::in_memory(x_, static_cast<std::int32_t>(sizeof(double) * stride() * memory_[v])); }

  // A register for a new value, pinned as long as the line lasts: an empty one, or that whose value is used last.
  [[gnu::cold, gnu::noinline]] int fresh() {
    const unsigned all = static_cast<unsigned>((1ull << code_.registers()) - 1), empty = all & ~held_ & ~pinned_;
    const int r = empty != 0 ? std::countr_zero(empty) : used_last(all & ~pinned_);
    if (const std::uint32_t v = holds_[index(r)]; v != none) {
      if (!in_memory_[v] && next_use_[index(r)] != none) store(v);
      forget(v);
    }
    pin(r);
    return r;
  }
  // Of some registers that hold values, the first whose value is not used any more, or that whose value is used last.
  int used_last(unsigned some) {
    int best = 0;
    std::uint64_t furthest = 0;
    for (; some != 0; some &= some - 1) {
      const int r = std::countr_zero(some);
      std::uint32_t& use = next_use_[index(r)];
      if (use < at_) use = straight_.next_use(holds_[index(r)], at_);
      if (use == none) return r;
      if (use < furthest || (use == furthest && furthest != 0)) continue;
      best = r;
      furthest = use;
    }
    return best;
  }
  [[gnu::cold, gnu::noinline]] int in_register(std::uint32_t v) {
    if (place_[v] < 0) {
      const int r = fresh();
      code_.load(r, memory(v));
      hold(v, r);
    }
    pin(place_[v]);
    return place_[v];
  }
  // A register, or memory where a value is not needed again.
  [[gnu::cold, gnu::noinline]] MachineOperand operand(std::uint32_t v) {
    if (place_[v] < 0 && !is_used_later(v)) return memory(v);
    return MachineOperand::in_register(in_register(v));
  }
  [[gnu::cold, gnu::noinline]] void store(std::uint32_t v) {
    take_memory(v);
    code_.store(place_[v], memory(v));
  }
  // A value that is not read from outside lies where none is needed at the time.
  void take_memory(std::uint32_t v) {
    in_memory_[v] = 1;
    if (read_[v]) return;
    memory_[v] = free_.back();
    free_.pop_back();
  }
  void release(std::uint32_t v) {
    if (place_[v] >= 0) forget(v);
    if (!in_memory_[v] || read_[v] || !straight_.is_computed(v)) return;
    in_memory_[v] = 0;
    free_.push_back(memory_[v]);
  }
  void hold(std::uint32_t v, int r) {
    holds_[index(r)] = v;
    next_use_[index(r)] = 0;  // not looked for yet
    held_ |= 1u << r;
    place_[v] = r;
  }
  void forget(std::uint32_t v) {
    holds_[index(place_[v])] = none;
    held_ &= ~(1u << place_[v]);
    place_[v] = -1;
  }
  // The line's result is in register r.
  [[gnu::cold, gnu::noinline]] void finish(const Line& l, int r) {
    release_operands(l);
    keep(l.to, r);
  }
  // What is not needed after the line.
  void release_operands(const Line& l) {
    for_each_operand(l, [&](std::uint32_t v) {
      if (!is_used_later(v)) release(v);
    });
  }
  void keep(std::uint32_t v, int r) {
    hold(v, r);
    if (read_[v]) store(v);
    if (!is_used_later(v)) forget(v);
  }
  bool is_used_later(std::uint32_t v) { return straight_.next_use(v, at_ + 1) != none; }
  void pin(int r) { pinned_ |= 1u << r; }
  static std::size_t index(int r) { return static_cast<std::size_t>(r); }

  StraightLines straight_;
  Code code_;
  typename Code::Vectors vectors_;
  std::span<const char> read_;
  std::vector<int> place_;       // the register that holds a value; −1 for none
  std::vector<char> in_memory_;  // whether x has the value
  std::vector<std::uint32_t> memory_, free_;  // where in x a value lies when it does; places that hold none
  std::array<std::uint32_t, most_registers> holds_{}, next_use_{};
  typename Code::Base x_ = Code::arguments[0];
  unsigned held_ = 0, pinned_ = 0;  // registers with values, and those that must not give way
  std::uint32_t at_ = 0;  // the line
};

}  // namespace qdot::formula
