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
// in the order of qdot::detail::find_circular (ad/pack_math.hpp), whose bits these are. In odd quadrants both change places. Three angles or four take
// the quarters of one register, with sines and cosines in different ones; so do the lanes of one angle. Results go to registers of their own, and nothing
// goes through memory.
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
  enum Row {
    of_turn, shift, first_part, second_part, third_part, coefficients, half = coefficients + 6, one, sign, magnitude, range, next_of_second,
    next, of_sines, of_cosines = of_sines + 6, rows = of_cosines + 6
  };
  alignas(32) double row[rows][4];
};
inline constexpr CircularTable circular_table = [] {
  using T = CircularTable;
  constexpr double S[] = {-1.66666666666666324348e-01, 8.33333333332248946124e-03,  -1.98412698298579493134e-04,
                          2.75573137070700676789e-06,  -2.50507602534068634195e-08, 1.58969099521155010221e-10};
  constexpr double C[] = {4.16666666666666019037e-02,  -1.38888888888741095749e-03, 2.48015872894767294178e-05,
                          -2.75573143513906633035e-07, 2.08757232129817482790e-09,  -1.13596475577881948265e-11};
  T table{};
  const auto set = [&](int row, double of_sine, double of_cosine) {
    for (int k = 0; k < 4; ++k) table.row[row][k] = k % 2 == 0 ? of_sine : of_cosine;
  };
  const auto set_alike = [&](int row, double number) { set(row, number, number); };
  set_alike(T::of_turn, 0x1.45f306dc9c883p-1);
  set_alike(T::shift, qdot::detail::whole_number_shift);
  set_alike(T::first_part, 0x1.921fb544p+0);
  set_alike(T::second_part, 0x1.0b4611a6p-34);
  set_alike(T::third_part, 0x1.3198a2e037073p-69);
  set_alike(T::half, 0.5);
  set_alike(T::one, 1.0);
  set_alike(T::sign, -0.0);
  set_alike(T::magnitude, __builtin_bit_cast(double, 0x7fffffffffffffffULL));
  set_alike(T::range, qdot::detail::circular_range);
  set(T::next_of_second, 0.0, __builtin_bit_cast(double, 1ULL));
  set_alike(T::next, __builtin_bit_cast(double, 1ULL));
  for (int i = 0; i < 6; ++i) set(T::coefficients + i, S[i], C[i]), set_alike(T::of_sines + i, S[i]), set_alike(T::of_cosines + i, C[i]);
  return table;
}();

/// Writes the instructions for some angles beside each other, at most four.
class X86Circular {
 public:
  static constexpr int most = 4, most_temporaries = 12;
  static constexpr X86Code::Base table = X86Code::rax;  ///< which has this address
  static std::uintptr_t table_address() { return std::bit_cast<std::uintptr_t>(&circular_table.row[middle]); }

  X86Circular(X86Code& code, std::uint32_t count) : code_(code), count_(count) {}

  /// How many registers it needs.
  int temporaries() const { return is_apart() ? 12 : 8; }
  /// Where sine and cosine of an angle are at the end, and the angle outside of the range after split_angles(): numbers of registers among these.
  int sine(std::uint32_t k) const { return is_apart() ? 11 - static_cast<int>(k) : k == 0 ? 4 : 0; }
  int cosine(std::uint32_t k) const { return is_apart() ? k == 0 ? 0 : 8 - static_cast<int>(k) : k == 0 ? 1 : 2; }
  int angle(std::uint32_t k) const { return is_in_lanes() ? 1 : k == 0 ? 0 : is_apart() ? static_cast<int>(k) : 3; }

  /// Writes all.
  ///
  /// @param t  registers that are free; the angles are not in them
  /// @return   the end of a jump where an angle is outside of the range
  [[gnu::cold, gnu::noinline]] std::size_t write(const MachineOperand (&angles)[most], const int (&t)[most_temporaries]) {
    const int x = t[0], k = t[2], a = t[3];
    if (!is_in_lanes()) broadcast_angle(x, angles[0]);
    else if (angles[0].number >= 0) code_.copy(x, angles[0].number);
    else code_.load(x, angles[0]);
    for (std::uint32_t i = 1; i < count_; ++i) {
      broadcast_angle(k, angles[i]);
      packed(Packed::blend, x, x, k, is_apart() ? 0b1111 << i & 0b1111 : 0b1100);
    }
    packed(Packed::both_bits, a, x, row(CircularTable::magnitude));
    packed(Packed::compare, a, a, row(CircularTable::range), not_less_or_equal);
    packed(Packed::test_signs, a, -1, a);
    const std::size_t outside = code_.jump_if_not_zero();
    reduce(t);
    if (is_apart()) write_apart(t);
    else write_in_halves(t);
    return outside;
  }
  /// Brings sine and cosine of an angle to their registers, if they are asked for; the first angle's before the second's and so on.
  [[gnu::cold, gnu::noinline]] void take(std::uint32_t k, const int (&t)[most_temporaries], bool has_sine, bool has_cosine) {
    if (is_apart()) {
      if (has_sine || k == 2) take_quarter(k, t[sine(k)], t[sine(k & 2u)], t[sine(0)]);
      if (has_cosine || k == 2) take_quarter(k, t[cosine(k)], t[cosine(k & 2u)], t[cosine(0)]);
    } else {
      if (k == 1) take_quarter(2, t[sine(1)], -1, t[sine(0)]);
      if (has_cosine) take_quarter(1, t[cosine(k)], t[sine(k)], -1);
    }
  }
  /// Outside of the range, the angles to registers of their own.
  [[gnu::cold, gnu::noinline]] void split_angles(const int (&t)[most_temporaries]) {
    if (is_in_lanes()) return code_.copy(t[angle(0)], t[0]);
    if (is_apart())
      for (std::uint32_t k : {1u, 2u, 3u}) {
        if (k < count_) take_quarter(k, t[angle(k)], t[angle(k & 2u)], t[angle(0)]);
      }
    else if (count_ == 2) take_quarter(2, t[angle(1)], -1, t[angle(0)]);
  }

 private:
  static constexpr int middle = 8;  // so that most distances are short
  static constexpr int not_less_or_equal = 0x16, left = 6, sines_in_halves = 0b0101;

  // Whether sines and cosines are in different registers.
  bool is_apart() const { return count_ > 2 || is_in_lanes(); }
  bool is_in_lanes() const { return code_.doubles() > 1; }
  static MachineOperand row(int i) { return MachineOperand::in_memory(table, 32 * (i - middle)); }
  bool is_of_four() const { return count_ > 1 || is_in_lanes(); }
  void packed(Packed operation, int d, int a, const MachineOperand& b, int detail = -1) { code_.packed(operation, is_of_four(), d, a, b, detail); }
  void packed(Packed operation, int d, int a, int b, int detail = -1) { packed(operation, d, a, MachineOperand::in_register(b), detail); }
  void shift_left(int to, int from, int by) { packed(Packed::shift, left, to, from, by); }
  void broadcast_angle(int to, const MachineOperand& angle) { packed(count_ > 1 ? Packed::broadcast : Packed::doubled, to, -1, angle); }
  // Brings a quarter of a register to the first of another; of odd quarters, from the register that has the one before.
  void take_quarter(std::uint32_t k, int to, int even, int whole) {
    if (k == 2) code_.packed(Packed::second_half, true, whole, -1, MachineOperand::in_register(to), 1);
    else if (k % 2 == 1) code_.packed(Packed::upper, false, to, even, MachineOperand::in_register(even));
  }

  // The angle x becomes r + tail, the tail where x was; and k the quadrant.
  [[gnu::cold, gnu::noinline]] void reduce(const int (&t)[most_temporaries]) {
    using enum Packed;
    const int x = t[0], quadrant = t[1], k = t[2], a = t[3], r = t[5];
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
  }
  // to = (c₀ + z c₁ + w (c₂ + z c₃)) + w² (c₄ + z c₅); z may be u.
  [[gnu::cold, gnu::noinline]] void polynomial(int first, int z, int w, int ww, int to, int s, int u) {
    using enum Packed;
    packed(product, to, z, row(first + 1));
    packed(sum, to, to, row(first));
    packed(product, s, z, row(first + 3));
    packed(sum, s, s, row(first + 2));
    packed(product, u, z, row(first + 5));
    packed(sum, u, u, row(first + 4));
    packed(product, s, s, w);
    packed(sum, to, to, s);
    packed(product, ww, w, w);
    packed(product, u, u, ww);
    packed(sum, to, to, u);
  }
  // e = (1 − o) − z/2 with o = 1 − z/2, and z/2.
  [[gnu::cold, gnu::noinline]] void one_less_half(int z, int half, int e, int o) {
    using enum Packed;
    packed(product, half, z, row(CircularTable::half));
    packed(load, e, -1, row(CircularTable::one));
    packed(difference, o, e, half);
    packed(difference, e, e, o);
    packed(difference, e, e, half);
  }

  // One angle or two, with its cosine beside its sine.
  [[gnu::cold, gnu::noinline]] void write_in_halves(const int (&t)[most_temporaries]) {
    using enum Packed;
    const int tail = t[0], quadrant = t[1], z = t[2], a = t[3], m = t[4], r = t[5], o = t[6], e = t[7];
    packed(product, z, r, r);
    one_less_half(z, a, e, o);
    packed(blend, e, e, tail, sines_in_halves);
    packed(blend, a, r, a, sines_in_halves);
    packed(product, a, a, tail);
    packed(difference, e, e, a);
    packed(blend, o, o, r, sines_in_halves);
    packed(blend, r, z, r, sines_in_halves);
    packed(product, r, r, z);
    const int factor = r, w = tail;
    packed(product, w, z, z);
    polynomial(CircularTable::coefficients, z, w, w, m, a, z);
    packed(product, m, m, factor);
    packed(sum, m, m, e);
    packed(sum, m, m, o);
    packed(whole_sum, quadrant, quadrant, row(CircularTable::next_of_second));
    packed(whole_sum, a, quadrant, quadrant);
    packed(chosen, m, m, a);
    shift_left(quadrant, quadrant, 62);
    packed(both_bits, quadrant, quadrant, row(CircularTable::sign));
    packed(different_bits, m, m, quadrant);
  }

  // Three angles or four, or an angle in lanes.
  [[gnu::cold, gnu::noinline]] void write_apart(const int (&t)[most_temporaries]) {
    using enum Packed;
    const int tail = t[0], quadrant = t[1], z = t[2], a = t[3], s = t[4], r = t[5], o = t[6], e = t[7], w = t[8], u = t[9], ww = t[10], b = t[11];
    packed(product, z, r, r);
    one_less_half(z, a, e, o);
    packed(product, b, r, tail);
    packed(difference, e, e, b);
    packed(product, a, a, tail);
    packed(difference, tail, tail, a);
    packed(product, w, z, z);
    polynomial(CircularTable::of_sines, z, w, ww, b, a, u);
    packed(product, a, z, r);
    packed(product, b, b, a);
    packed(sum, b, b, tail);
    packed(sum, b, b, r);
    polynomial(CircularTable::of_cosines, z, w, ww, s, a, u);
    packed(product, s, s, w);
    packed(sum, s, s, e);
    packed(sum, s, s, o);
    const int cosine = tail;
    shift_left(a, quadrant, 63);  // odd quadrants have the highest bit
    if (code_.doubles() == 8) packed(mask, a, a, a);
    packed(select, cosine, s, b, a << 4);
    packed(select, b, b, s, a << 4);
    shift_left(a, quadrant, 62);
    packed(both_bits, a, a, row(CircularTable::sign));
    packed(different_bits, b, b, a);
    packed(whole_sum, quadrant, quadrant, row(CircularTable::next));
    shift_left(quadrant, quadrant, 62);
    packed(both_bits, quadrant, quadrant, row(CircularTable::sign));
    packed(different_bits, cosine, cosine, quadrant);
  }

  X86Code& code_;
  std::uint32_t count_;
};

/// Writes what is called where an angle is outside, with places in rax and their number in rdx: a C++ function on all registers as numbers, and one more.
///
/// @param is_aligned  whether the stack is, in the code that calls
/// @return            where it is in the code
[[gnu::cold, gnu::noinline]] inline std::size_t write_circular_aside(X86Code& code, bool is_aligned, std::uintptr_t function) {
  using Base = X86Code::Base;
  const std::size_t at = code.bytes().size();
  const int count = code.registers(), width = 8 * code.doubles(), least = width * (count + 1);
  const int size = least % 16 == (is_aligned ? 8 : 0) ? least : least + 8;  // with two pushes and where to return
  const auto number = [width](int i) { return MachineOperand::in_memory(Base::rdi, width * i); };
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
