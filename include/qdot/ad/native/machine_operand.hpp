#pragma once
// SPDX-License-Identifier: MIT
//
// What instructions of any processor compute with: a register or a number in memory.

#include <cstdint>

namespace qdot::formula {

/// A register, or a number in memory: the register that holds its base, and a distance in bytes.
struct MachineOperand {
  int number = -1;  ///< of the vector register; −1 where it is memory
  int base = 0;     ///< one of the code's own registers for addresses
  std::int32_t distance = 0;

  static constexpr MachineOperand in_register(int number) { return {number, 0, 0}; }
  static constexpr MachineOperand in_memory(int base, std::int32_t distance) { return {-1, base, distance}; }
};

/// Operations on doubles.
enum class Arithmetic : std::uint8_t { root, sum, product, difference, quotient };

}  // namespace qdot::formula
