#pragma once
// SPDX-License-Identifier: MIT
//
// The instructions of x86-64 that lines of a formula need, as bytes.
//
// Each is an operation on doubles: d = a ∘ b, where b is a register or a number in memory. With AVX an instruction names all three,
//
//     VEX   C5 | R̄ v̄v̄v̄v̄ L pp | opcode | ModRM                  where b is a register below 8 or in memory at a register below 8
//           C4 | R̄X̄B̄ mmmmm | W v̄v̄v̄v̄ L pp | opcode | ModRM      otherwise
//
// and without it d = d ∘ b, with a copied to d before. v is a, R and B are the fourth bits of d and b, pp = 3 means scalar doubles. A place in
// memory is a register and a distance: 8 bits where it fits, otherwise 32. Instructions and their encodings: Intel, Software Developer's
// Manual, volume 2.

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <vector>

namespace qdot::formula {

/// A register, or a number in memory: the register that holds its base, and a distance in bytes.
struct X86Operand {
  int number = -1;  ///< of the vector register; −1 where it is memory
  int base = 0;     ///< 0 to 7, and not 4, which has another form
  std::int32_t distance = 0;

  static constexpr X86Operand in_register(int number) { return {number, 0, 0}; }
  static constexpr X86Operand in_memory(int base, std::int32_t distance) { return {-1, base, distance}; }
};

/// Machine code that grows by one instruction at a time.
class X86Code {
 public:
  enum Base { rax = 0, rcx = 1, rdx = 2, rbx = 3, rbp = 5, rsi = 6, rdi = 7 };
  enum class Arithmetic : std::uint8_t { root = 0x51, sum = 0x58, product = 0x59, difference = 0x5C, quotient = 0x5E };

  explicit X86Code(bool has_avx) : has_avx_(has_avx) {}

  const std::vector<std::uint8_t>& bytes() const { return bytes_; }

  /// d = a ∘ b. Without AVX, b must not be d unless a is d as well. Of a root, a does not matter.
  [[gnu::cold, gnu::noinline]] void arithmetic(Arithmetic operation, int d, int a, const X86Operand& b) {
    if (operation == Arithmetic::root) a = d;
    if (!has_avx_ && a != d) copy(d, a);
    vector(0xF2, static_cast<int>(operation), d, a, b);
  }
  [[gnu::cold, gnu::noinline]] void load(int d, const X86Operand& memory) { vector(0xF2, 0x10, d, 0, memory); }
  [[gnu::cold, gnu::noinline]] void store(int s, const X86Operand& memory) { vector(0xF2, 0x11, s, 0, memory); }
  [[gnu::cold, gnu::noinline]] void copy(int d, int s) { vector(0x66, 0x28, d, 0, X86Operand::in_register(s)); }

  /// Registers for addresses and whole numbers.
  [[gnu::cold, gnu::noinline]] void copy(Base to, Base from) { put({0x48, 0x89, 0xC0 | (from << 3) | to}); }
  [[gnu::cold, gnu::noinline]] void set(Base to, std::uint64_t value) {
    put({0x48, 0xB8 | to});
    for (int i = 0; i < 8; ++i) bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  [[gnu::cold, gnu::noinline]] void call(Base function) { put({0xFF, 0xD0 | function}); }

  /// Where indirect calls may arrive.
  void begin() { put({0xF3, 0x0F, 0x1E, 0xFA}); }
  /// Keeps rbx and rbp of the caller, and aligns the stack for calls.
  void enter() { put({0x53, 0x55, 0x48, 0x83, 0xEC, 0x08}); }
  void leave() { put({0x48, 0x83, 0xC4, 0x08, 0x5D, 0x5B}); }
  void end() { put({0xC3}); }

 private:
  [[gnu::cold, gnu::noinline]] void put(std::initializer_list<int> some) {
    for (const int byte : some) bytes_.push_back(static_cast<std::uint8_t>(byte));
  }
  [[gnu::cold, gnu::noinline]] void put_distance(std::int32_t distance) {
    for (int i = 0; i < 4; ++i) bytes_.push_back(static_cast<std::uint8_t>(static_cast<std::uint32_t>(distance) >> (8 * i)));
  }
  [[gnu::cold, gnu::noinline]] void put_place(int d, const X86Operand& b) {
    const int low = (d & 7) << 3;
    if (b.number >= 0) return put({0xC0 | low | (b.number & 7)});
    const bool is_short = b.distance >= -128 && b.distance <= 127;
    put({(is_short ? 0x40 : 0x80) | low | b.base});
    if (is_short) put({b.distance & 0xFF});
    else put_distance(b.distance);
  }

  // An instruction of map 0F whose prefix is F2 or 66.
  [[gnu::cold, gnu::noinline]] void vector(int prefix, int opcode, int d, int a, const X86Operand& b) {
    const bool d_is_high = d >= 8, b_is_high = b.number >= 8;
    if (has_avx_) {
      const bool takes_two = opcode != 0x28 && !((opcode == 0x10 || opcode == 0x11));
      const int v = takes_two ? ~a & 15 : 15, pp = prefix == 0xF2 ? 3 : 1;
      if (b_is_high) put({0xC4, (d_is_high ? 0 : 0x80) | 0x40 | 0x01, (v << 3) | pp});
      else put({0xC5, (d_is_high ? 0 : 0x80) | (v << 3) | pp});
    } else {
      put({prefix});
      if (d_is_high || b_is_high) put({0x40 | (d_is_high ? 4 : 0) | (b_is_high ? 1 : 0)});
      put({0x0F});
    }
    put({opcode});
    put_place(d, b);
  }

  std::vector<std::uint8_t> bytes_;
  bool has_avx_;
};

}  // namespace qdot::formula
