#pragma once
// SPDX-License-Identifier: MIT
//
// The instructions of x86-64 that lines of a formula need, as bytes.
//
// Each is an operation on doubles: d = a ∘ b, where b is a register or a number in memory. With AVX an instruction names
// all three,
//
//     VEX   C5 | R̄ v̄v̄v̄v̄ L pp | opcode | ModRM                  where b is a register below 8 or in memory at a register below 8
//           C4 | R̄X̄B̄ mmmmm | W v̄v̄v̄v̄ L pp | opcode | ModRM      otherwise
//
// and without it d = d ∘ b, with a copied to d before. v is a, R and B are the fourth bits of d and b, pp = 3 means scalar
// doubles. A place in memory is a register and a distance: 8 bits where it fits, otherwise 32. On four doubles L = 1 and
// pp = 1. On eight, with AVX-512, there are 32 registers (fifth bits R', X, V'), and distances of 8 bits count in 64 bytes:
//
//     EVEX  62 | R̄X̄B̄R̄' 0 mmm | W v̄v̄v̄v̄ 1 pp | z L'L b V̄' aaa | opcode | ModRM
// (Intel, Software Developer's Manual, volume 2.)

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "qdot/ad/native/machine_operand.hpp"

namespace qdot::formula {

/// What the instructions compute with. With AVX2, sines and cosines of single numbers are instructions, too (ad/native/x86_circular.hpp).
enum class X86Vectors { sse2, avx, avx2, avx_in_fours, avx512_in_eights };
/// Doubles by one instruction.
constexpr int doubles_of(X86Vectors vectors) {
  return vectors == X86Vectors::avx_in_fours ? 4 : vectors == X86Vectors::avx512_in_eights ? 8 : 1;
}

/// Operations on two or four doubles at once, or on their bits: the map and the opcode of each.
enum class Packed {
  sum = 0x158, product = 0x159, difference = 0x15C, both_bits = 0x154, different_bits = 0x157, load = 0x110, doubled = 0x112, upper = 0x115,
  compare = 0x1C2, mask = 0x227, whole_sum = 0x1D4, shift = 0x173, test_signs = 0x20F, broadcast = 0x219, chosen = 0x20D, blend = 0x30D,
  select = 0x34B, second_half = 0x319
};

/// Machine code that grows by one instruction at a time.
class X86Code {
 public:
  using Vectors = X86Vectors;
  enum Base { rax = 0, rdx = 2, rbx = 3, rsp = 4, rbp = 5, rsi = 6, rdi = 7 };
  static constexpr Base arguments[] = {rdi, rsi, rdx}, kept[] = {rbx, rbp}, called = rax;
  static constexpr bool has_circular = true;  // instructions for sines

  explicit X86Code(X86Vectors vectors) : vectors_(vectors) {}

  int doubles() const { return doubles_of(vectors_); }
  /// How many registers for doubles there are.
  int registers() const { return vectors_ == X86Vectors::avx512_in_eights ? 32 : 16; }

  const std::vector<std::uint8_t>& bytes() const { return bytes_; }

  /// d = a ∘ b. Without AVX, b must not be d unless a is d as well. Of a root, a does not matter.
  [[gnu::cold, gnu::noinline]] void arithmetic(Arithmetic operation, int d, int a, const MachineOperand& b) {
    if (operation == Arithmetic::root) a = d;
    if (vectors_ == X86Vectors::sse2 && a != d) copy(d, a);
    vector(opcode_of(operation), d, a, b);
  }
  [[gnu::cold, gnu::noinline]] void load(int d, const MachineOperand& memory) { vector(move_from, d, 0, memory); }
  [[gnu::cold, gnu::noinline]] void store(int s, const MachineOperand& memory) { vector(move_to, s, 0, memory); }
  [[gnu::cold, gnu::noinline]] void copy(int d, int s) { vector(move_all, d, 0, MachineOperand::in_register(s)); }

  /// d = a ∘ b on two doubles or four, with AVX2, or on eight. Of an operation with one operand that is b, and a is −1; `detail` is its number, if it has one.
  [[gnu::cold, gnu::noinline]] void packed(Packed operation, bool four, int d, int a, const MachineOperand& b, int detail = -1) {
    if (doubles() == 8) return packed_in_eights(operation, d, a, b, detail);
    const int pp = operation == Packed::doubled ? 3 : 1;
    has_fours_ |= four;
    put_vex(static_cast<int>(operation) >> 8, d, a < 0 ? 15 : ~a & 15, (four ? 4 : 0) | pp, b);
    put({static_cast<int>(operation) & 0xFF});
    put_place(d, b);
    if (detail >= 0) put({detail});
  }
  /// Jumps and calls within the code, whose places are set by aim(); of those there are none yet, the end of the instruction is returned.
  std::size_t jump() { return put_near({0xE9}); }
  std::size_t jump_if_not_zero() { return put_near({0x0F, 0x85}); }
  std::size_t call_near() { return put_near({0xE8}); }
  void aim(std::size_t end_of_jump, std::size_t at) {
    const auto distance = static_cast<std::uint32_t>(at - end_of_jump);
    for (std::size_t i = 0; i < 4; ++i) bytes_[end_of_jump - 4 + i] = static_cast<std::uint8_t>(distance >> (8 * i));
  }
  /// The stack grows down by some bytes, whose place is `to`; and back.
  void take_stack(Base to, int size) { put({0x48, 0x81, 0xEC}), put_distance(size), copy(to, rsp); }
  void give_stack(int size) { put({0x48, 0x81, 0xC4}), put_distance(size); }
  void push(Base what) { put({0x50 | what}); }
  void pop(Base what) { put({0x58 | what}); }

  /// Registers for addresses and whole numbers.
  [[gnu::cold, gnu::noinline]] void copy(Base to, Base from) { put({0x48, 0x89, 0xC0 | (from << 3) | to}); }
  [[gnu::cold, gnu::noinline]] void set(Base to, std::uint64_t value) {
    put({0x48, 0xB8 | to});
    for (int i = 0; i < 8; ++i) bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  /// The value of an instruction that set() wrote at this place.
  static void reset(std::vector<std::uint8_t>& code, std::size_t at, std::uint64_t value) {
    for (std::size_t i = 0; i < 8; ++i) code[at + 2 + i] = static_cast<std::uint8_t>(value >> (8 * i));
  }
  [[gnu::cold, gnu::noinline]] void call(Base function) { put({0xFF, 0xD0 | function}); }

  /// Before other code, which may be without AVX and would wait for the upper parts of registers.
  void leave_vectors() {
    if (doubles_of(vectors_) > 1 || has_fours_) clear_upper_halves();
    has_fours_ = false;
  }
  void clear_upper_halves() { put({0xC5, 0xF8, 0x77}); }

  /// Where indirect calls may arrive.
  void begin() { put({0xF3, 0x0F, 0x1E, 0xFA}); }
  /// Keeps rbx and rbp of the caller, and aligns the stack for calls.
  void enter() { put({0x53, 0x55, 0x48, 0x83, 0xEC, 0x08}); }
  void leave() { put({0x48, 0x83, 0xC4, 0x08, 0x5D, 0x5B}); }
  void end() { put({0xC3}); }

 private:
  static constexpr int opcode_of(Arithmetic operation) {
    constexpr int opcodes[] = {0x51, 0x58, 0x59, 0x5C, 0x5E};
    return opcodes[static_cast<int>(operation)];
  }
  [[gnu::cold, gnu::noinline]] void put(std::initializer_list<int> some) {
    for (const int byte : some) bytes_.push_back(static_cast<std::uint8_t>(byte));
  }
  std::size_t put_near(std::initializer_list<int> opcode) {
    put(opcode);
    put_distance(0);
    return bytes_.size();
  }
  [[gnu::cold, gnu::noinline]] void put_distance(std::int32_t distance) {
    for (int i = 0; i < 4; ++i) bytes_.push_back(static_cast<std::uint8_t>(static_cast<std::uint32_t>(distance) >> (8 * i)));
  }
  [[gnu::cold, gnu::noinline]] void put_place(int d, const MachineOperand& b) { put_place(d, b, vectors_ == X86Vectors::avx512_in_eights ? 64 : 1); }
  [[gnu::cold, gnu::noinline]] void put_place(int d, const MachineOperand& b, int unit) {
    const int low = (d & 7) << 3;
    if (b.number >= 0) return put({0xC0 | low | (b.number & 7)});
    const std::int32_t distance = b.distance / unit;
    const bool is_short = distance * unit == b.distance && distance >= -128 && distance <= 127;
    put({(is_short ? 0x40 : 0x80) | low | b.base});
    if (is_short) put({distance & 0xFF});
    else put_distance(b.distance);
  }

  // An instruction of map 0F; pp is 3 of scalar doubles, 1 of several and of whole registers.
  [[gnu::cold, gnu::noinline]] void vector(int opcode, int d, int a, const MachineOperand& b) {
    const bool is_scalar = doubles_of(vectors_) == 1 && opcode != move_all;
    const bool takes_two = opcode != move_all && opcode != move_from && opcode != move_to && (is_scalar || opcode != opcode_of(Arithmetic::root));
    const int v = takes_two ? ~a & 31 : 31, pp = is_scalar ? 3 : 1;
    switch (vectors_) {
      case X86Vectors::sse2: put_prefix(is_scalar ? 0xF2 : 0x66, d, b); break;
      case X86Vectors::avx:
      case X86Vectors::avx2: put_vex(1, d, v & 15, pp, b); break;
      case X86Vectors::avx_in_fours: put_vex(1, d, v & 15, 4 | pp, b); break;
      case X86Vectors::avx512_in_eights: put_evex(1, d, v, pp, b, 0); break;
    }
    put({opcode});
    put_place(d, b);
  }
  void put_prefix(int prefix, int d, const MachineOperand& b) {
    put({prefix});
    if (d >= 8 || b.number >= 8) put({0x40 | (d >= 8 ? 4 : 0) | (b.number >= 8 ? 1 : 0)});
    put({0x0F});
  }
  void put_vex(int map, int d, int v, int length_and_pp, const MachineOperand& b) {
    const int high = d >= 8 ? 0 : 0x80;
    if (b.number >= 8 || map != 1) put({0xC4, high | 0x40 | (b.number >= 8 ? 0 : 0x20) | map, (v << 3) | length_and_pp});
    else put({0xC5, high | (v << 3) | length_and_pp});
  }
  void put_evex(int map, int d, int v, int pp, const MachineOperand& b, int more) {
    const int r = b.number >= 0 ? b.number : 0;
    put({0x62, (d & 8 ? 0 : 0x80) | (r & 16 ? 0 : 0x40) | (r & 8 ? 0 : 0x20) | (d & 16 ? 0 : 0x10) | map, 0x80 | ((v & 15) << 3) | 0x04 | pp,
         0x40 | (v & 16 ? 0x08 : 0) | more});
  }
  // Operations on eight doubles; an operand in memory is one number for all lanes. What is compared goes to the mask k1, by which
  // one of two is selected.
  [[gnu::cold, gnu::noinline]] void packed_in_eights(Packed operation, int d, int a, const MachineOperand& b, int detail) {
    constexpr int broadcast_one = 0x10, and_bits = 0x1DB, xor_bits = 0x1EF, blend_by_mask = 0x265;
    if (operation == Packed::test_signs) return put({0xC5, 0xF8, 0x98, 0xC9});
    const bool loads = operation == Packed::load, selects = operation == Packed::select;
    const int code = operation == Packed::both_bits        ? and_bits
                     : operation == Packed::different_bits ? xor_bits
                     : selects                             ? blend_by_mask
                                                           : static_cast<int>(loads ? Packed::broadcast : operation);
    if (operation == Packed::compare || operation == Packed::mask) d = 1;
    put_evex(code >> 8, d, a < 0 ? 31 : ~a & 31, 1, b, (b.number < 0 && !loads ? broadcast_one : 0) | (selects ? 1 : 0));
    put({code & 0xFF});
    put_place(d, b, 8);
    if (detail >= 0 && !selects) put({detail});
  }

  static constexpr int move_from = 0x10, move_to = 0x11, move_all = 0x28;
  std::vector<std::uint8_t> bytes_;
  X86Vectors vectors_;
  bool has_fours_ = false;  // whether upper halves of registers may hold something
};

}  // namespace qdot::formula
