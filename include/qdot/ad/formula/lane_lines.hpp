#pragma once
// SPDX-License-Identifier: MIT
//
// Lines carried out on eight motions at once.
//
// A number of the lines is then one of each motion, side by side in memory, and every line is carried out on all of them. So what finding the next
// line costs is paid once for eight motions, and machine code (ad/native/emitter.hpp) adds and multiplies four or eight of them by one instruction.
//
//     ┌────┬────┬────┬────┬────┬────┬────┬────┐
//     │ x₃ │ x₃ │ x₃ │ x₃ │ x₃ │ x₃ │ x₃ │ x₃ │   number 3 of motions 0 to 7, its *lanes*
//     └────┴────┴────┴────┴────┴────┴────┴────┘
//
// The operations in each lane are those of lines on single numbers, functions among them, so a motion has the same bits in a lane as alone.

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "qdot/ad/formula/lines.hpp"

namespace qdot::formula {

/// Lanes of a LaneNumber.
inline constexpr std::size_t lanes_stored = 8;

/// A number of each of eight motions.
struct LaneNumber {
  using Part = qdot::detail::Register<double, 2>;  // which every processor has
  static constexpr std::size_t parts = lanes_stored / 2;
  Part part[parts];

  /// c in all lanes.
  LaneNumber& operator=(double c) {
    for (Part& each : part) each = Part{c, c};
    return *this;
  }
  double* lanes() { return reinterpret_cast<double*>(part); }
  const double* lanes() const { return reinterpret_cast<const double*>(part); }

  // f of each part.
  template <class F, class... Numbers>
  [[gnu::always_inline]] static LaneNumber of(const F& f, const Numbers&... x) {
    LaneNumber r;
    for (std::size_t k = 0; k < parts; ++k) r.part[k] = f(x.part[k]...);
    return r;
  }
  [[gnu::always_inline]] friend LaneNumber operator+(const LaneNumber& x, const LaneNumber& y) {
    return of([](const Part& a, const Part& b) __attribute__((always_inline)) { return a + b; }, x, y);
  }
  [[gnu::always_inline]] friend LaneNumber operator-(const LaneNumber& x, const LaneNumber& y) {
    return of([](const Part& a, const Part& b) __attribute__((always_inline)) { return a - b; }, x, y);
  }
  [[gnu::always_inline]] friend LaneNumber operator*(const LaneNumber& x, const LaneNumber& y) {
    return of([](const Part& a, const Part& b) __attribute__((always_inline)) { return a * b; }, x, y);
  }
  [[gnu::always_inline]] friend LaneNumber operator/(const LaneNumber& x, const LaneNumber& y) {
    return of([](const Part& a, const Part& b) __attribute__((always_inline)) { return a / b; }, x, y);
  }
  [[gnu::always_inline]] friend LaneNumber operator+(const LaneNumber& x, double c) {
    return of([c](const Part& a) __attribute__((always_inline)) { return a + c; }, x);
  }
  [[gnu::always_inline]] friend LaneNumber operator*(double c, const LaneNumber& x) {
    return of([c](const Part& a) __attribute__((always_inline)) { return c * a; }, x);
  }
  [[gnu::always_inline]] friend LaneNumber operator/(double c, const LaneNumber& x) {
    return of([c](const Part& a) __attribute__((always_inline)) { return c / a; }, x);
  }
};

// f of each lane.
template <class F, class... Numbers>
LaneNumber in_each_lane(const F& f, const Numbers&... x) {
  LaneNumber r;
  for (std::size_t k = 0; k < lanes_stored; ++k) r.lanes()[k] = f(x.lanes()[k]...);
  return r;
}
inline LaneNumber sqrt(const LaneNumber& x) {
  return in_each_lane([](double a) { return std::sqrt(a); }, x);
}
inline LaneNumber raised(const LaneNumber& x, double c) {
  return in_each_lane([c](double a) { return raised(a, c); }, x);
}
inline LaneNumber value_of(Function f, const LaneNumber& x, const LaneNumber& y) {
  return in_each_lane([f](double a, double b) { return value_of(f, a, b); }, x, y);
}

// Sines and cosines of lines one behind the other, or of a run.
inline void write_circular(LaneNumber* x, std::uint32_t angle, std::uint32_t sine, std::uint32_t cosine) {
  constexpr auto stride = static_cast<std::uint32_t>(lanes_stored);
  const CircularPlaces places{stride * angle, stride * sine, stride * cosine};
  fastest_circular_of_eight()(x->lanes(), &places, 1);
}
inline const Line* carry_out_circular(const Line* line, LaneNumber* x) {
  write_circular(x, line->a, line->to, line->b);
  return line + 1;
}
inline void carry_out_circular(const LineTable& table, const RunOfLines& run, LaneNumber* x) {
  for (std::uint32_t k = 0; k < run.count; ++k)
    write_circular(x, run.places < 0 ? run.first.a + k * static_cast<std::uint32_t>(run.step_a) : table.places[static_cast<std::size_t>(run.places) + 2 * k],
                   run.first.to + k, run.first.b + k);
}

// Copies numbers, to[i] = *from[i], in as few instructions as there are. What is written in pieces and read as a whole soon afterwards waits until the
// pieces have reached the cache.
template <std::size_t width>
[[gnu::always_inline]] inline void copy_lanes(double* to, const double* const* from, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t at = 0; at < lanes_stored; at += width) {
      qdot::detail::Register<double, width> some;
      __builtin_memcpy(&some, from[i] + at, sizeof some);
      __builtin_memcpy(to + lanes_stored * i + at, &some, sizeof some);
    }
}
[[gnu::noinline]] inline void copy_lanes_by_any(double* to, const double* const* from, std::size_t count) noexcept { copy_lanes<2>(to, from, count); }
#if defined(__x86_64__)
[[gnu::noinline, gnu::target("avx2")]] inline void copy_lanes_by_avx2(double* to, const double* const* from, std::size_t count) noexcept {
  copy_lanes<4>(to, from, count);
  __builtin_ia32_vzeroupper();
}
[[gnu::noinline, gnu::target("avx512f")]] inline void copy_lanes_by_avx512(double* to, const double* const* from, std::size_t count) noexcept {
  copy_lanes<8>(to, from, count);
  __builtin_ia32_vzeroupper();
}
#endif
/// The fastest of them on this processor.
inline auto fastest_copy_of_lanes() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") != 0) return copy_lanes_by_avx512;
  if (__builtin_cpu_supports("avx2") != 0) return copy_lanes_by_avx2;
#endif
  return copy_lanes_by_any;
}

#ifdef QDOT_COMPILED
extern template void carry_out<LaneNumber>(const LineTable&, const RunOfLines&, LaneNumber*);
extern template void carry_out<LaneNumber>(const LineTable&, LaneNumber*);
#endif

}  // namespace qdot::formula
