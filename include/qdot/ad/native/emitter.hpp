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
// The code is a function of x, the numbers, and of the constants. Values stay in registers as long as there is room
// (ad/native/values_in_registers.hpp). Sines of one level are instructions, four angles at a time (ad/native/x86_circular.hpp). Without AVX2 they are
// calls of C++ functions, as powers and other functions are everywhere. These change all registers, so values that are used afterwards are stored before.
//
// With AVX2 or AVX-512 the same lines become code for the lanes of a LaneNumber, four or eight at a time (ad/formula/lane_lines.hpp).

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "qdot/ad/formula/circular_lines.hpp"
#include "qdot/ad/native/called_functions.hpp"
#include "qdot/ad/native/machine_operand.hpp"
#include "qdot/ad/native/straight_lines.hpp"
#include "qdot/ad/native/values_in_registers.hpp"
#include "qdot/ad/native/x86_circular.hpp"

namespace qdot::formula {

/// Writes the code for some lines, for a processor whose instructions are those of Code.
template <class Code>
class Emitter : ValuesInRegisters<Code> {
  using Operation = Line::Operation;
  using Values = ValuesInRegisters<Code>;
  using Values::at_, Values::code_, Values::holds_, Values::in_memory_, Values::memory_, Values::pinned_, Values::place_, Values::read_, Values::straight_;
  using Values::is_used_later, Values::keep, Values::memory, Values::release_operands;
  using Values::finish, Values::forget, Values::fresh, Values::hold, Values::in_register, Values::index, Values::is_of_lanes, Values::none, Values::operand;
  using Values::pin, Values::release, Values::store, Values::stride, Values::take_memory, Values::vectors_, Values::x_;

 public:
  /// @param count  how many numbers there are
  /// @param read   numbers that are read from outside, not zero
  [[gnu::cold]] Emitter(const LineTable& table, std::size_t count, std::span<const char> read, typename Code::Vectors vectors)
      : Values(StraightLines(table, count, longest_native_lines), read, vectors) {
    const std::vector<Line>& lines = straight_.lines();
    if (lines.empty()) return;
    const bool calls = std::any_of(lines.begin(), lines.end(), [this](const Line& l) { return is_call(l) && !is_inline(l); });
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
        if (is_inline(lines[k])) circular(k, end);
        else call(k, end);
      } else {
        pinned_ = 0;
        line(lines[k]);
      }
      k = end;
    }
    code_.leave_vectors();
    if (calls) code_.leave();
    code_.end();
    write_asides(calls);
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
  static bool is_call(const Line& l) {
    if (l.operation == Operation::power) return !is_few_halves(l.c);
    return l.operation == Operation::sine_and_cosine || l.operation == Operation::function;
  }
  static bool is_circular(const Line& l) { return l.operation == Operation::sine_and_cosine; }
  // Sines without a call.
  bool is_inline([[maybe_unused]] const Line& l) const {
    if constexpr (Code::has_circular) return is_circular(l) && (vectors_ == Code::Vectors::avx2 || is_of_lanes());
    return false;
  }
  // As in raised().
  static bool is_few_halves(double c) {
    const double halves = std::abs(2.0 * c);
    return halves <= 9.0 && halves == std::floor(halves);
  }
  [[gnu::cold, gnu::noinline]] MachineOperand constant(double c) {
    const auto same = [c](double other) { return std::bit_cast<std::uint64_t>(other) == std::bit_cast<std::uint64_t>(c); };
    const auto found = std::find_if(constants_.begin(), constants_.end(), same);
    const auto first = static_cast<std::size_t>(found - constants_.begin());
    if (found == constants_.end()) constants_.insert(constants_.end(), static_cast<std::size_t>(doubles_of(vectors_)), c);  // one for each lane
    return MachineOperand::in_memory(pool_, static_cast<std::int32_t>(sizeof(double) * first));
  }

  // --- Lines -----------------------------------------------------------------------------------------------------------

  // What is done where an angle is outside of the range: from a jump to what comes back.
  struct Aside {
    std::size_t jump = 0, back = 0, first = 0;
    std::uint32_t count = 0;
    int temporaries[X86Circular::most_temporaries] = {};
  };

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
    has_table_ = false;
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

  // Sines and cosines beside each other, without a call.
  [[gnu::cold, gnu::noinline]] void circular([[maybe_unused]] std::uint32_t first, [[maybe_unused]] std::uint32_t last) {
    if constexpr (Code::has_circular) {
      if (!has_table_) code_.set(X86Circular::table, X86Circular::table_address());
      has_table_ = true;
      for (std::uint32_t count = 0; first < last; first += count) {
        count = std::min<std::uint32_t>(last - first, is_of_lanes() ? 1 : X86Circular::most);
        write_circular(first, count);
      }
    }
  }
  [[gnu::cold, gnu::noinline]] void write_circular(std::uint32_t first, std::uint32_t count) {
    const Line* const lines = &straight_.lines()[first];
    at_ = first + count - 1;
    pinned_ = 0;
    MachineOperand angles[X86Circular::most];
    for (std::uint32_t k = 0; k < count; ++k)  // so that none gives way to another
      if (place_[lines[k].a] >= 0) pin(place_[lines[k].a]);
    for (std::uint32_t k = 0; k < count; ++k) angles[k] = operand(lines[k].a);
    X86Circular it(code_, count);
    Aside aside{.first = circular_.size(), .count = count};
    const int(&t)[X86Circular::most_temporaries] = aside.temporaries;
    for (int i = 0; i < it.temporaries(); ++i) aside.temporaries[i] = fresh();
    aside.jump = it.write(angles, t);
    for (std::uint32_t k = 0; k < count; ++k) release_operands(lines[k]);
    const auto is_needed = [this](std::uint32_t v) { return read_[v] != 0 || is_used_later(v); };
    for (std::uint32_t k = 0; k < count; ++k) {
      const bool has_sine = is_needed(lines[k].to), has_cosine = is_needed(lines[k].b);
      it.take(k, t, has_sine, has_cosine);
      const auto place = [&](bool needed, int i) { return static_cast<std::uint32_t>(code_.doubles() * (needed ? t[i] : code_.registers())); };
      circular_.push_back({place(true, it.angle(k)), place(has_sine, it.sine(k)), place(has_cosine, it.cosine(k))});
    }
    aside.back = code_.bytes().size();
    asides_.push_back(aside);
    for (std::uint32_t k = 0; k < count; ++k) {
      if (is_needed(lines[k].to)) keep(lines[k].to, t[it.sine(k)]);
      if (is_needed(lines[k].b)) keep(lines[k].b, t[it.cosine(k)]);
    }
  }
  // Where an angle is outside of the range.
  [[gnu::cold]] void write_asides([[maybe_unused]] bool is_aligned) {
    if constexpr (Code::has_circular) {
      if (asides_.empty()) return;
      const auto one_by_one = std::bit_cast<std::uintptr_t>(&write_circular_one_by_one);
      const std::size_t function = write_circular_aside(code_, is_aligned, is_of_lanes() ? circular_function() : one_by_one);
      for (const Aside& aside : asides_) {
        code_.aim(aside.jump, code_.bytes().size());
        X86Circular(code_, aside.count).split_angles(aside.temporaries);
        call_sites_.push_back({code_.bytes().size(), true, aside.first});
        code_.set(X86Circular::table, 0);
        code_.set(Code::arguments[2], aside.count);
        code_.aim(code_.call_near(), function);
        code_.aim(code_.jump(), aside.back);
      }
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
  std::vector<double> constants_;
  std::vector<CircularPlaces> circular_;
  std::vector<Line> calls_;
  std::vector<CallSite> call_sites_;
  std::vector<Aside> asides_;
  bool has_table_ = false;  // of sines, in its register
  typename Code::Base pool_ = Code::arguments[1];
};

}  // namespace qdot::formula
