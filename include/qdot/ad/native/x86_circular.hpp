#pragma once
// SPDX-License-Identifier: MIT
//
// Sines and cosines as instructions of x86-64 with AVX2.
//
// One angle r + t takes the two halves of a register, two angles take four quarters: the sine is in the first of two and the cosine in the second. Their
// polynomials have the same degree, so one scheme computes both, with the coefficients side by side,
//
//     s = r + (t − z/2 t + z r (S₁ + z S₂ + …))                  z = r²
//     c = (1 − z/2) + (e − r t + z z (C₁ + z C₂ + …))            e = (1 − (1 − z/2)) − z/2 ,
//
// in the order of qdot::detail::find_circular (ad/pack_math.hpp), whose bits these are. In odd quadrants both change places. That takes half of the
// operations of find_circular, which has sines and cosines in different registers, and nothing goes through memory.
//
// Angles beyond its range and NaN are rare. Then the registers are stored, the C++ function is called (ad/formula/circular_lines.hpp), and
// the registers are loaded again.

#include <bit>
#include <cstddef>
#include <cstdint>

#include "qdot/ad/native/x86_code.hpp"
#include "qdot/ad/pack_math.hpp"

namespace qdot::formula {

/// Numbers of the instructions, for a sine and a cosine, twice.
struct CircularTable {
  enum Row { of_turn, shift, first_part, second_part, third_part, coefficients, half = coefficients + 6, one, sign, magnitude, range, next_quadrant, rows };
  alignas(32) double row[rows][4];
};
inline constexpr CircularTable circular_table = [] {
  constexpr double sign = -0.0, all_but_sign = __builtin_bit_cast(double, 0x7fffffffffffffffULL), next = __builtin_bit_cast(double, 1ULL);
  constexpr double pairs[CircularTable::rows][2] = {
      {0x1.45f306dc9c883p-1, 0x1.45f306dc9c883p-1},
      {qdot::detail::whole_number_shift, qdot::detail::whole_number_shift},
      {0x1.921fb544p+0, 0x1.921fb544p+0},
      {0x1.0b4611a6p-34, 0x1.0b4611a6p-34},
      {0x1.3198a2e037073p-69, 0x1.3198a2e037073p-69},
      {-1.66666666666666324348e-01, 4.16666666666666019037e-02},
      {8.33333333332248946124e-03, -1.38888888888741095749e-03},
      {-1.98412698298579493134e-04, 2.48015872894767294178e-05},
      {2.75573137070700676789e-06, -2.75573143513906633035e-07},
      {-2.50507602534068634195e-08, 2.08757232129817482790e-09},
      {1.58969099521155010221e-10, -1.13596475577881948265e-11},
      {0.5, 0.5},
      {1.0, 1.0},
      {sign, sign},
      {all_but_sign, all_but_sign},
      {qdot::detail::circular_range, qdot::detail::circular_range},
      {0.0, next}};
  CircularTable table{};
  for (int i = 0; i < CircularTable::rows; ++i)
    for (int k = 0; k < 4; ++k) table.row[i][k] = pairs[i][k % 2];
  return table;
}();

/// Writes the instructions for one angle or two.
class X86Circular {
 public:
  static constexpr int temporaries = 8;
  static constexpr X86Code::Base table = X86Code::rax;  ///< which has this address
  static std::uintptr_t table_address() { return std::bit_cast<std::uintptr_t>(&circular_table.row[middle]); }

  /// @param two  angles, not one
  /// @param t    registers that are free; the angles are not in them
  X86Circular(X86Code& code, bool two, const int (&t)[temporaries]) : code_(code), two_(two), t_(t) {}

  /// Writes all; sine and cosine are in both halves of the register sines(), of two angles in its four quarters.
  ///
  /// @return  the end of a jump where an angle is outside of the range; then angles() has them, each twice
  [[gnu::cold, gnu::noinline]] std::size_t write(const MachineOperand& first, const MachineOperand& second) {
    using enum Packed;
    const int x = t_[0], quadrant = t_[1], k = t_[2], a = t_[3], m = t_[4], r = t_[5], o = t_[6], b = t_[7];
    broadcast_angle(x, first);
    if (two_) {
      broadcast_angle(k, second);
      packed(blend, x, x, k, 0b1100);
    }
    packed(both_bits, a, x, row(CircularTable::magnitude));
    packed(compare, a, a, row(CircularTable::range), not_less_or_equal);
    packed(test_signs, a, -1, a);
    const std::size_t outside = code_.jump_if_not_zero();
    packed(product, quadrant, x, row(CircularTable::of_turn));
    packed(sum, quadrant, quadrant, row(CircularTable::shift));
    packed(difference, k, quadrant, row(CircularTable::shift));
    packed(product, a, k, row(CircularTable::first_part));
    packed(difference, x, x, a);  // above
    packed(product, a, k, row(CircularTable::second_part));
    packed(difference, r, x, a);
    packed(difference, x, x, r);
    packed(difference, x, x, a);
    packed(product, k, k, row(CircularTable::third_part));
    packed(difference, x, x, k);
    const int tail = x, z = k, e = b;
    packed(product, z, r, r);
    packed(product, a, z, row(CircularTable::half));
    packed(load, e, -1, row(CircularTable::one));
    packed(difference, o, e, a);  // one less
    packed(difference, e, e, o);
    packed(difference, e, e, a);
    packed(blend, e, e, tail, sines_in_halves);
    packed(blend, a, r, a, sines_in_halves);
    packed(product, a, a, tail);
    packed(difference, e, e, a);
    packed(blend, o, o, r, sines_in_halves);
    packed(blend, r, z, r, sines_in_halves);
    packed(product, r, r, z);
    const int factor = r, w = x;
    packed(product, w, z, z);
    packed(product, m, z, row(CircularTable::coefficients + 1));
    packed(sum, m, m, row(CircularTable::coefficients));
    packed(product, a, z, row(CircularTable::coefficients + 3));
    packed(sum, a, a, row(CircularTable::coefficients + 2));
    packed(product, z, z, row(CircularTable::coefficients + 5));
    packed(sum, z, z, row(CircularTable::coefficients + 4));
    packed(product, a, a, w);
    packed(sum, m, m, a);
    packed(product, w, w, w);
    packed(product, z, z, w);
    packed(sum, m, m, z);
    packed(product, m, m, factor);
    packed(sum, m, m, e);
    packed(sum, m, m, o);
    packed(whole_sum, quadrant, quadrant, row(CircularTable::next_quadrant));
    packed(whole_sum, a, quadrant, quadrant);
    packed(chosen, m, m, a);
    code_.packed(shift, two_, left, quadrant, MachineOperand::in_register(quadrant), 62);
    packed(both_bits, quadrant, quadrant, row(CircularTable::sign));
    packed(different_bits, m, m, quadrant);
    return outside;
  }
  int sines() const { return t_[4]; }
  int angles() const { return t_[0]; }
  /// Brings the cosine of an angle to a register from that of its sine, and what is in the upper quarters.
  void take_cosine(int to, int from) { code_.packed(Packed::upper, false, to, from, MachineOperand::in_register(from)); }
  void take_second(int to, int from) { code_.packed(Packed::second_half, true, from, -1, MachineOperand::in_register(to), 1); }

 private:
  static constexpr int middle = 8;  // so that most distances are short
  static constexpr int not_less_or_equal = 0x16, left = 6, sines_in_halves = 0b0101;

  static MachineOperand row(int i) { return MachineOperand::in_memory(table, 32 * (i - middle)); }
  void packed(Packed operation, int d, int a, const MachineOperand& b, int detail = -1) { code_.packed(operation, two_, d, a, b, detail); }
  void packed(Packed operation, int d, int a, int b, int detail = -1) { packed(operation, d, a, MachineOperand::in_register(b), detail); }
  void broadcast_angle(int to, const MachineOperand& angle) { packed(two_ ? Packed::broadcast : Packed::doubled, to, -1, angle); }

  X86Code& code_;
  bool two_;
  const int (&t_)[temporaries];
};

/// Writes what is called where an angle is outside, with places in rax and their number in rdx: a C++ function on all registers as numbers, and one more.
///
/// @param is_aligned  whether the stack is, in the code that calls
/// @return            where it is in the code
[[gnu::cold, gnu::noinline]] inline std::size_t write_circular_aside(X86Code& code, bool is_aligned, std::uintptr_t function) {
  using Base = X86Code::Base;
  const std::size_t at = code.bytes().size();
  const int count = code.registers(), size = 8 * (count + (is_aligned ? 1 : 2));  // with two pushes and where to return
  const auto number = [](int i) { return MachineOperand::in_memory(Base::rdi, 8 * i); };
  code.push(Base::rdi);
  code.push(Base::rsi);
  code.take_stack(Base::rdi, size);
  for (int i = 0; i < count; ++i) code.store(i, number(i));
  code.clear_upper_halves();
  code.copy(Base::rsi, Base::rax);
  code.set(Base::rax, function);
  code.call(Base::rax);
  code.copy(Base::rdi, Base::rsp);
  for (int i = 0; i < count; ++i) code.load(i, number(i));
  code.give_stack(size);
  code.pop(Base::rsi);
  code.pop(Base::rdi);
  code.set(X86Circular::table, X86Circular::table_address());
  code.end();
  return at;
}

}  // namespace qdot::formula
