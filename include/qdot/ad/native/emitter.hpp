#pragma once
// SPDX-License-Identifier: MIT
//
// From lines to machine code.
//
// Every line becomes one to five instructions that do exactly what the interpreter does (carry_out in ad/formula/lines.hpp), in the same order and
// without fused products, so both have the same bits. Factors that are 1 or −1 cost nothing, since 1·x is x and x + (−1)·y is x − y exactly.
//
//     x₁₀ = x₃ x₅ − x₈        vmulsd xmm2, xmm0, xmm1      x₃ and x₅ were in registers
//                             vsubsd xmm2, xmm2, [rdi+64]  x₈ is read from memory, for it is not used again
//
// The code is a function of x, the numbers, and of the constants. Values stay in registers as long as there is room. What gives way is
// the value whose next use is furthest away. Values that are read from outside are stored when they are computed, others only where they give way,
// to places of numbers that are not read and not needed at the time: few, which stay in the cache. Sines of one level, powers and other functions are
// calls of C++ functions, which change all registers, so values that are used afterwards are stored before.
//
// With AVX2 or AVX-512 the same lines become code for the lanes of a LaneNumber, four or eight at a time (ad/formula/lane_lines.hpp).

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "qdot/ad/formula/circular_lines.hpp"
#include "qdot/ad/native/called_functions.hpp"
#include "qdot/ad/native/machine_operand.hpp"
#include "qdot/ad/native/straight_lines.hpp"

namespace qdot::formula {

/// Most lines that become machine code. Longer code leaves the processor's cache, and the interpreter is as fast.
inline constexpr std::size_t longest_native_lines = 4000;

/// Writes the code for some lines, for a processor whose instructions are those of Code.
template <class Code>
class Emitter {
  using Operation = Line::Operation;

 public:

  /// @param count  how many numbers there are
  /// @param read   numbers that are read from outside, not zero
  [[gnu::cold]] Emitter(const LineTable& table, std::size_t count, std::span<const char> read, typename Code::Vectors vectors)
      : straight_(table, count, longest_native_lines), code_(vectors), vectors_(vectors), read_(read), place_(count, -1), in_memory_(count, 1), memory_(count) {
    holds_.fill(none);
    std::iota(memory_.begin(), memory_.end(), 0u);
    const std::vector<Line>& lines = straight_.lines();
    if (lines.empty()) return;
    for (auto line = lines.rbegin(); line != lines.rend(); ++line)
      for_each_result(*line, [&](std::uint32_t v) {
        in_memory_[v] = 0;
        if (!read_[v]) free_.push_back(v);
      });
    const bool calls = std::any_of(lines.begin(), lines.end(), is_call);
    code_.begin();
    if (calls) {
      code_.enter();
      code_.copy(x_ = Code::kept[0], Code::arguments[0]);
      code_.copy(pool_ = Code::kept[1], Code::arguments[1]);
    }
    for (std::uint32_t k = 0; k < lines.size();) {
      at_ = k;
      std::uint32_t end = k + 1;
      if (is_call(lines[k])) {
        while (end < lines.size() && is_call(lines[end]) && (is_circular(lines[k]) ? is_beside(lines[end], lines[k]) : !is_circular(lines[end]))) ++end;
        call(k, end);
      } else {
        pinned_ = 0;
        line(lines[k]);
      }
      k = end;
    }
    code_.leave_vectors();
    if (calls) code_.leave();
    code_.end();
  }

  /// Nothing where the table is too long, or damaged.
  const std::vector<std::uint8_t>& code() const { return code_.bytes(); }
  /// Constants, which the code reads.
  std::vector<double> take_constants() { return std::move(constants_); }
  /// Sines, and other lines that are calls, which the code hands on.
  std::vector<CircularPlaces> take_circular() { return std::move(circular_); }
  std::vector<Line> take_calls() { return std::move(calls_); }
  /// Where in the code the address of which of them belongs.
  struct CallSite {
    std::size_t at;
    bool circular;
    std::size_t first;
  };
  const std::vector<CallSite>& call_sites() const { return call_sites_; }

 private:
  static constexpr std::uint32_t none = StraightLines::never;
  static constexpr int most_registers = 32;

  static bool is_call(const Line& l) {
    if (l.operation == Operation::power) return !is_few_halves(l.c);
    return l.operation == Operation::sine_and_cosine || l.operation == Operation::function;
  }
  static bool is_circular(const Line& l) { return l.operation == Operation::sine_and_cosine; }
  // As in raised().
  static bool is_few_halves(double c) {
    const double halves = std::abs(2.0 * c);
    return halves <= 9.0 && halves == std::floor(halves);
  }
  bool is_of_lanes() const { return doubles_of(vectors_) > 1; }
  // How many doubles a number takes in memory.
  std::uint32_t stride() const { return is_of_lanes() ? static_cast<std::uint32_t>(lanes_stored) : 1; }
  MachineOperand memory(std::uint32_t v) const { return MachineOperand::in_memory(x_, static_cast<std::int32_t>(sizeof(double) * stride() * memory_[v])); }
  [[gnu::cold, gnu::noinline]] MachineOperand constant(double c) {
    const auto same = [c](double other) { return std::bit_cast<std::uint64_t>(other) == std::bit_cast<std::uint64_t>(c); };
    const auto found = std::find_if(constants_.begin(), constants_.end(), same);
    const auto index = static_cast<std::size_t>(found - constants_.begin());
    if (found == constants_.end()) constants_.insert(constants_.end(), static_cast<std::size_t>(doubles_of(vectors_)), c);  // one for each lane
    return MachineOperand::in_memory(pool_, static_cast<std::int32_t>(sizeof(double) * index));
  }

  // --- Registers -------------------------------------------------------------------------------------------------------

  // A register for a new value, pinned as long as the line lasts: an empty one, or that whose value is used last.
  [[gnu::cold, gnu::noinline]] int fresh() {
    constexpr std::uint64_t is_empty = 2ull << 32, is_dead = 1ull << 32;
    int best = 0;
    std::uint64_t furthest = 0;
    for (int r = 0; r < code_.registers(); ++r) {
      if (is_pinned(r)) continue;
      const std::uint32_t v = holds_[index(r)], use = v == none ? none : straight_.next_use(v, at_);
      const std::uint64_t distance = v == none ? is_empty : use == none ? is_dead : use;
      if (distance < furthest || (distance == furthest && furthest != 0)) continue;
      best = r;
      furthest = distance;
    }
    if (const std::uint32_t v = holds_[index(best)]; v != none) {
      if (!in_memory_[v] && furthest != is_dead) store(v);
      forget(v);
    }
    pin(best);
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
    if (place_[v] < 0 && straight_.next_use(v, at_ + 1) == none) return memory(v);
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
    place_[v] = r;
  }
  void forget(std::uint32_t v) {
    holds_[index(place_[v])] = none;
    place_[v] = -1;
  }
  // The line's result is in register r.
  [[gnu::cold, gnu::noinline]] void finish(const Line& l, int r) {
    for_each_operand(l, [&](std::uint32_t v) {
      if (straight_.next_use(v, at_ + 1) == none) release(v);
    });
    hold(l.to, r);
    if (read_[l.to]) store(l.to);
    if (straight_.next_use(l.to, at_ + 1) == none) forget(l.to);
  }
  void pin(int r) { pinned_ |= 1u << r; }
  bool is_pinned(int r) const { return (pinned_ >> r & 1u) != 0; }
  static std::size_t index(int r) { return static_cast<std::size_t>(r); }

  // --- Lines -----------------------------------------------------------------------------------------------------------

  [[gnu::cold, gnu::noinline]] void call(std::uint32_t first, std::uint32_t last) {
    for (int r = 0; r < code_.registers(); ++r) {
      const std::uint32_t v = holds_[index(r)];
      if (v == none) continue;
      if (!in_memory_[v] && straight_.next_use(v, at_) != none) store(v);
      forget(v);
    }
    code_.copy(Code::arguments[0], x_);
    const bool circular = is_circular(straight_.lines()[first]);
    call_sites_.push_back({code_.bytes().size(), circular, circular ? circular_.size() : calls_.size()});
    code_.set(Code::arguments[1], 0);  // an address that is known when all calls are there
    code_.set(Code::arguments[2], last - first);
    code_.set(Code::called, circular ? circular_function() : call_function());
    code_.leave_vectors();
    code_.call(Code::called);
    for (std::uint32_t k = first; k < last; ++k) {
      Line l = straight_.lines()[k];
      for_each_result(l, [&](std::uint32_t v) { take_memory(v); });
      l.to = memory_[l.to], l.a = memory_[l.a];
      if (l.operation != Operation::power) l.b = memory_[l.b];
      if (circular) circular_.push_back({stride() * l.a, stride() * l.to, stride() * l.b});
      else calls_.push_back(l);
    }
    for (std::uint32_t k = first; k < last; ++k) {
      const auto release_unused = [&](std::uint32_t v) {
        if (straight_.next_use(v, last) == none) release(v);
      };
      for_each_operand(straight_.lines()[k], release_unused);
      for_each_result(straight_.lines()[k], release_unused);
    }
  }

  std::uintptr_t circular_function() const {
    return std::bit_cast<std::uintptr_t>(is_of_lanes() ? circular_of_lanes(doubles_of(vectors_)) : fastest_circular());
  }
  std::uintptr_t call_function() const {
    if (!is_of_lanes()) return std::bit_cast<std::uintptr_t>(&carry_out_calls);
    return std::bit_cast<std::uintptr_t>(doubles_of(vectors_) == 4 ? &carry_out_lane_calls<4> : &carry_out_lane_calls<8>);
  }

  // A value in a register, which is the line's own or holds an operand.
  struct Value {
    int r;
    bool is_own;
  };
  [[gnu::cold, gnu::noinline]] Value scaled(std::uint32_t a, double c) {
    if (c == 1.0) return {in_register(a), false};
    if (place_[a] < 0) {
      const MachineOperand b = operand(a);
      const int t = fresh();
      code_.load(t, constant(c));
      code_.arithmetic(Arithmetic::product, t, t, b);
      return {t, true};
    }
    const int r = in_register(a), t = fresh();
    code_.arithmetic(Arithmetic::product, t, r, constant(c));
    return {t, true};
  }
  // x ∘ y in a register of the line's own.
  [[gnu::cold, gnu::noinline]] int combined(Arithmetic operation, const Value& x, const MachineOperand& y) {
    const int t = x.is_own ? x.r : fresh();
    code_.arithmetic(operation, t, x.r, y);
    return t;
  }
  // x + c y.
  [[gnu::cold, gnu::noinline]] int sum(const Value& x, double c, std::uint32_t y) {
    if (c == 1.0) return combined(Arithmetic::sum, x, operand(y));
    if (c == -1.0) return combined(Arithmetic::difference, x, operand(y));
    const Value u = scaled(y, c);
    const int t = combined(Arithmetic::sum, x, MachineOperand::in_register(u.r));
    return t;
  }
  // x + c; −0 adds nothing.
  [[gnu::cold, gnu::noinline]] int with_constant(const Value& x, double c) {
    if (std::bit_cast<std::uint64_t>(c) != std::bit_cast<std::uint64_t>(-0.0)) return combined(Arithmetic::sum, x, constant(c));
    if (x.is_own) return x.r;
    const int t = fresh();
    code_.copy(t, x.r);
    return t;
  }
  // A new register with a b.
  [[gnu::cold, gnu::noinline]] int product(std::uint32_t a, std::uint32_t b) {
    if (place_[a] < 0 && place_[b] >= 0) std::swap(a, b);
    const int r = in_register(a);
    const MachineOperand other = a == b ? MachineOperand::in_register(r) : operand(b);
    const int t = fresh();
    code_.arithmetic(Arithmetic::product, t, r, other);
    return t;
  }
  // 1 / t.
  [[gnu::cold, gnu::noinline]] int inverse(const MachineOperand& t) {
    const int u = fresh();
    code_.load(u, constant(1.0));
    code_.arithmetic(Arithmetic::quotient, u, u, t);
    return u;
  }
  [[gnu::cold, gnu::noinline]] int root(std::uint32_t a) {
    const MachineOperand b = operand(a);
    const int t = fresh();
    code_.arithmetic(Arithmetic::root, t, t, b);
    return t;
  }
  [[gnu::cold, gnu::noinline]] int power(const Line& l) {  // few halves
    int left = static_cast<int>(std::abs(2.0 * l.c));
    const int x = in_register(l.a);
    const int t = fresh();
    if (left % 2 != 0) code_.arithmetic(Arithmetic::root, t, t, MachineOperand::in_register(x));
    else if (left == 0) code_.load(t, constant(1.0));
    else code_.copy(t, x), left -= 2;
    for (; left > 1; left -= 2) code_.arithmetic(Arithmetic::product, t, t, MachineOperand::in_register(x));
    return l.c < 0.0 ? inverse(MachineOperand::in_register(t)) : t;
  }
  [[gnu::cold, gnu::noinline]] int binary(Arithmetic operation, std::uint32_t a, std::uint32_t b) {
    if (operation == Arithmetic::sum && place_[a] < 0 && place_[b] >= 0) std::swap(a, b);
    const int r = in_register(a);
    const MachineOperand other = a == b ? MachineOperand::in_register(r) : operand(b);
    const int t = fresh();
    code_.arithmetic(operation, t, r, other);
    return t;
  }

  [[gnu::cold, gnu::noinline]] void line(const Line& l) {
    switch (l.operation) {
      case Operation::end:
      case Operation::run:
      case Operation::sine_and_cosine:
      case Operation::function: return;
      case Operation::constant: {
        const int t = fresh();
        code_.load(t, constant(l.c));
        return finish(l, t);
      }
      case Operation::scaled: return finish(l, with_constant(scaled(l.a, l.ca), l.c));
      case Operation::combination: {
        const Value a = scaled(l.a, l.ca);
        return finish(l, with_constant({sum(a, l.cb, l.b), true}, l.c));
      }
      case Operation::sum: return finish(l, binary(Arithmetic::sum, l.a, l.b));
      case Operation::difference: return finish(l, binary(Arithmetic::difference, l.a, l.b));
      case Operation::product: return finish(l, product(l.a, l.b));
      case Operation::square: return finish(l, product(l.a, l.a));
      case Operation::quotient: return finish(l, binary(Arithmetic::quotient, l.a, l.b));
      case Operation::inverse: return finish(l, inverse(operand(l.a)));
      case Operation::root: return finish(l, root(l.a));
      case Operation::inverse_root: return finish(l, inverse(MachineOperand::in_register(root(l.a))));
      case Operation::power: return finish(l, power(l));
      case Operation::less_product: {
        const int d = in_register(l.d), t = product(l.a, l.b), u = fresh();
        code_.arithmetic(Arithmetic::difference, u, d, MachineOperand::in_register(t));
        return finish(l, u);
      }
      default: return sum_with_products(l);
    }
  }

  [[gnu::cold, gnu::noinline]] void sum_with_products(const Line& l) {
    const bool combines = l.operation == Operation::product_combination || l.operation == Operation::products_combination;
    const bool is_difference = l.operation == Operation::product_difference || l.operation == Operation::products_difference;
    const bool two = l.operation >= Operation::products_sum;
    const double cb = combines ? l.cb : is_difference ? -1.0 : 1.0;
    int t = product(l.a, l.b);
    if (combines && l.ca != 1.0) code_.arithmetic(Arithmetic::product, t, t, constant(l.ca));
    if (two) {
      const int u = product(l.d, l.e);
      if (cb != -1.0 && cb != 1.0) code_.arithmetic(Arithmetic::product, u, u, constant(cb));
      code_.arithmetic(cb == -1.0 ? Arithmetic::difference : Arithmetic::sum, t, t, MachineOperand::in_register(u));
    } else {
      t = sum({t, true}, cb, l.d);
    }
    finish(l, t);
  }

 private:
  StraightLines straight_;
  Code code_;
  typename Code::Vectors vectors_;
  std::span<const char> read_;
  std::vector<int> place_;       // the register that holds a value; −1 for none
  std::vector<char> in_memory_;  // whether x has the value
  std::vector<std::uint32_t> memory_, free_;  // where in x a value lies when it does; places that hold none
  std::array<std::uint32_t, most_registers> holds_{};
  std::vector<double> constants_;
  std::vector<CircularPlaces> circular_;
  std::vector<Line> calls_;
  std::vector<CallSite> call_sites_;
  typename Code::Base x_ = Code::arguments[0], pool_ = Code::arguments[1];
  unsigned pinned_ = 0;
  std::uint32_t at_ = 0;
};

}  // namespace qdot::formula
