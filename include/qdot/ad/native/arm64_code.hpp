#pragma once
// SPDX-License-Identifier: MIT
//
// The instructions of AArch64 that lines of a formula need.
//
// Each has four bytes. Arithmetic is on registers, d = a ∘ b; a number in memory comes to the register v31 first, which holds nothing else:
//
//     fmul d2, d0, d1       0001 1110 011 m m m m m 000010 n n n n n d d d d d
//     ldr d31, [x0, #64]    1111 1101 01 i…i (12, in eights) n n n n n t t t t t
//
// The lower halves of v8 to v15 belong to the caller and are not used. Distances of 32 kB and more are added to the base in x10 before. Instructions and
// their encodings: Arm, Architecture Reference Manual for A-profile, chapter C6 and C7.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "qdot/ad/native/machine_operand.hpp"

namespace qdot::formula {

/// What the instructions compute with.
enum class Arm64Vectors { scalar };
/// Doubles by one instruction.
constexpr int doubles_of(Arm64Vectors) { return 1; }

/// Machine code that grows by one instruction at a time.
class Arm64Code {
 public:
  using Vectors = Arm64Vectors;
  enum Base { x0 = 0, x1 = 1, x2 = 2, x9 = 9, x10 = 10, x19 = 19, x20 = 20 };
  static constexpr Base arguments[] = {x0, x1, x2}, kept[] = {x19, x20}, called = x9;
  static constexpr bool has_circular = false;

  explicit Arm64Code(Arm64Vectors) {}

  /// How many registers for doubles there are, v0 to v7 and v16 to v30.
  int registers() const { return 23; }
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }

  /// d = a ∘ b. Of a root, a does not matter.
  [[gnu::cold, gnu::noinline]] void arithmetic(Arithmetic operation, int d, int a, const MachineOperand& b) {
    if (b.number < 0) move(load_double, scratch, b);
    const std::uint32_t m = b.number < 0 ? scratch : vector(b.number);
    if (operation == Arithmetic::root) return put(0x1E61C000u | m << 5 | vector(d));
    constexpr std::uint32_t words[] = {0, 0x1E602800, 0x1E600800, 0x1E603800, 0x1E601800};
    put(words[static_cast<int>(operation)] | m << 16 | vector(a) << 5 | vector(d));
  }
  [[gnu::cold, gnu::noinline]] void load(int d, const MachineOperand& memory) { move(load_double, vector(d), memory); }
  [[gnu::cold, gnu::noinline]] void store(int s, const MachineOperand& memory) { move(store_double, vector(s), memory); }
  [[gnu::cold, gnu::noinline]] void copy(int d, int s) { put(0x1E604000u | vector(s) << 5 | vector(d)); }

  /// Registers for addresses and whole numbers.
  [[gnu::cold, gnu::noinline]] void copy(Base to, Base from) { put(0xAA0003E0u | static_cast<std::uint32_t>(from) << 16 | static_cast<std::uint32_t>(to)); }
  [[gnu::cold, gnu::noinline]] void set(Base to, std::uint64_t value) {
    for (std::uint32_t part = 0; part < 4; ++part) put(part_of(part, value) | static_cast<std::uint32_t>(to));
  }
  /// The value of the instructions that set() wrote at this place.
  static void reset(std::vector<std::uint8_t>& code, std::size_t at, std::uint64_t value) {
    for (std::uint32_t part = 0; part < 4; ++part) {
      const std::uint32_t word = part_of(part, value) | (code[at + 4 * part] & 31u);
      for (std::size_t i = 0; i < 4; ++i) code[at + 4 * part + i] = static_cast<std::uint8_t>(word >> (8 * i));
    }
  }
  [[gnu::cold, gnu::noinline]] void call(Base function) { put(0xD63F0000u | static_cast<std::uint32_t>(function) << 5); }
  void leave_vectors() {}

  /// Where indirect calls may arrive.
  void begin() { put(0xD503245Fu); }
  /// Keeps x19, x20 and where to return.
  void enter() {
    put(0xA9BE7BFDu);  // stp x29, x30, [sp, #-32]!
    put(0xA90153F3u);  // stp x19, x20, [sp, #16]
  }
  void leave() {
    put(0xA94153F3u);  // ldp x19, x20, [sp, #16]
    put(0xA8C27BFDu);  // ldp x29, x30, [sp], #32
  }
  void end() { put(0xD65F03C0u); }

 private:
  static constexpr std::uint32_t scratch = 31, load_double = 0xFD400000, store_double = 0xFD000000;

  static constexpr std::uint32_t vector(int number) { return static_cast<std::uint32_t>(number < 8 ? number : number + 8); }
  // movz, then movk, of sixteen bits.
  static constexpr std::uint32_t part_of(std::uint32_t part, std::uint64_t value) {
    return (part == 0 ? 0xD2800000u : 0xF2800000u) | part << 21 | static_cast<std::uint32_t>(value >> (16 * part) & 0xFFFF) << 5;
  }
  [[gnu::cold, gnu::noinline]] void move(std::uint32_t what, std::uint32_t register_number, const MachineOperand& memory) {
    auto base = static_cast<std::uint32_t>(memory.base), distance = static_cast<std::uint32_t>(memory.distance);
    if (distance >= 1u << 15) {
      put(0x91400000u | (distance >> 12) << 10 | base << 5 | static_cast<std::uint32_t>(x10));
      base = x10;
      distance &= 4095;
    }
    put(what | distance / 8 << 10 | base << 5 | register_number);
  }
  [[gnu::cold, gnu::noinline]] void put(std::uint32_t word) {
    for (int i = 0; i < 4; ++i) bytes_.push_back(static_cast<std::uint8_t>(word >> (8 * i)));
  }

  std::vector<std::uint8_t> bytes_;
};

}  // namespace qdot::formula
