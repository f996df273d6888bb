#pragma once
// SPDX-License-Identifier: MIT
//
// Power series through a graph that the compiler knows: the orders of ad/series/sweep.hpp as straight-line code.
//
// The work is the same, number by number. What is gone is reading what to do, and waiting for memory: an order of a small
// system is a chain of a dozen nodes, each of which waits for the one before, and there a coefficient that stays in a register is
// ready five cycles sooner than one that was stored and read again.
//
// In particular the terms of an interior that hold the order before, j = 1 and j = k − 1, are made of registers. The others, which no
// longer are on their way to memory, are read in rows as ever.

#include <cstddef>

#include "qdot/ad/series/plan.hpp"
#include "qdot/ad/unroll.hpp"

namespace qdot::taylor {

/// Orders 2, 3, … of a sweep that has completed order 1.
///
/// @tparam Planned  has a static constexpr SweepPlan `plan`, which is that of the sweep
template <class Planned>
class PlannedSweep {
  static constexpr const SweepPlan& plan = Planned::plan;

 public:
  [[gnu::always_inline]] explicit PlannedSweep(Sweep& sweep) : sweep_(sweep) {
    unroll<plan.slot_count>([&](auto i) __attribute__((always_inline)) { latest_[i] = sweep_.latest_[i]; });
    unroll<plan.plain.size>([&](auto i) __attribute__((always_inline)) { newest_[i] = left(i, 1) * right(i, 1); });
    unroll<plan.weighted.size>([&](auto i) __attribute__((always_inline)) {
      constexpr int lane = plan.plain.size + i;
      newest_[lane] = left(lane, 1) * right(lane, 1);
    });
    unroll<plan.squares.size>([&](auto i) __attribute__((always_inline)) { newest_[plan.width + i] = square(i, 1) * square(i, 1); });
  }

  /// As Sweep::latest and Sweep::set.
  [[gnu::always_inline]] double& latest(int slot) { return latest_[slot]; }

  /// As Sweep::advance.
  [[gnu::always_inline]] void advance(int k) {
    make_interiors(k);
    make_ends<true>();
  }

  /// As Sweep::complete.
  [[gnu::always_inline]] void complete(int k) {
    make_ends<false>();
    file(k);
  }

 private:
  static constexpr std::size_t index(int i) { return static_cast<std::size_t>(i); }

  [[gnu::always_inline]] void make_interiors(int k) {
    // Some registers at a time, and two terms of each sum, so that few additions wait for others.
    constexpr int lanes = plan.plain.size + plan.weighted.size, one = register_lanes, at_once = 4;
    constexpr int registers = (lanes + one - 1) / one;
    constexpr std::ptrdiff_t width = plan.width;
    unroll<(registers + at_once - 1) / at_once>([&](auto block) __attribute__((always_inline)) {
      constexpr int first = block * at_once, count = registers - first < at_once ? registers - first : at_once;
      Lanes even[count] = {}, odd[count] = {};
      const double* l = sweep_.left_.data() + 2 * width + first * one;         // order 2
      const double* r = sweep_.right_.data() + (k - 2) * width + first * one;  // order k − 2
      const auto add = [&](Lanes* sums) __attribute__((always_inline)) {
        unroll<count>([&](auto i) __attribute__((always_inline)) {
          Lanes x, y;
          read(x, l + one * i);
          read(y, r + one * i);
          sums[i] += x * y;
        });
        l += width;
        r -= width;
      };
      int left_over = k - 3;
      for (; left_over > 1; left_over -= 2) {
        add(even);
        add(odd);
      }
      if (left_over > 0) add(even);
      unroll<count>([&](auto i) __attribute__((always_inline)) { write(interior_ + one * (first + i), even[i] + odd[i]); });
    });
    const double inverse_k = 1.0 / k;
    unroll<plan.plain.size>([&](auto i) __attribute__((always_inline)) { interior_[i] += newest_[i]; });
    unroll<plan.weighted.size>([&](auto i) __attribute__((always_inline)) {
      constexpr int lane = plan.plain.size + i;
      interior_[lane] = inverse_k * (interior_[lane] + newest_[lane]);
    });
    unroll<plan.squares.size>([&](auto i) __attribute__((always_inline)) {
      double half = 0.0;
      for (int j = 2; 2 * j < k; ++j) half += square(i, j) * square(i, k - j);
      half += half;
      if (k > 2 && k % 2 == 0) half += square(i, k / 2) * square(i, k / 2);
      interior_[plan.width + i] = half + newest_[plan.width + i];
    });
    unroll<plan.quotients.size>([&](auto i) __attribute__((always_inline)) {
      constexpr SweepPlan::Interior of = plan.quotients.entry[i];
      interior_[of.lane] *= -sweep_.inverse_[index(of.slot)];
    });
    unroll<plan.powers.size>([&](auto i) __attribute__((always_inline)) {
      constexpr SweepPlan::Interior of = plan.powers.entry[i];
      const double c = sweep_.powers_[index(i)].c;
      interior_[of.lane] = sweep_.inverse_[index(of.slot)] * ((c + 1.0) * interior_[of.other] - interior_[of.lane]);
    });
    unroll<plan.second_arguments.size>([&](auto i) __attribute__((always_inline)) {
      constexpr SweepPlan::Interior of = plan.second_arguments.entry[i];
      interior_[of.lane] += interior_[of.other];
    });
  }

  template <bool early>
  [[gnu::always_inline]] void make_ends() {
    constexpr const auto& ends = early ? plan.early : plan.late;
    const double* const factors = sweep_.factors_.data();
    unroll<ends.size>([&](auto i) __attribute__((always_inline)) {
      constexpr SweepPlan::End end = ends.entry[i];
      double w = 0.0;
      if constexpr (end.lane < plan.width + plan.square_width) w = interior_[end.lane];
      unroll<end.count>([&](auto j) __attribute__((always_inline)) {
        w += factors[end.first + j] * latest_[plan.terms.entry[end.first + j]];
      });
      latest_[end.slot] = w;
    });
  }

  // Writes coefficients k to the rows, and makes the terms of order k + 1 that hold them.
  [[gnu::always_inline]] void file(int k) {
    unroll<plan.plain.size>([&](auto i) __attribute__((always_inline)) {
      const double l = latest_[plan.plain.entry[i].left], r = latest_[plan.plain.entry[i].right];
      newest_[i] = left(i, 1) * r + l * right(i, 1);
      left(i, k) = l;
      right(i, k) = r;
    });
    unroll<plan.weighted.size>([&](auto i) __attribute__((always_inline)) {
      constexpr int lane = plan.plain.size + i;
      const double l = k * latest_[plan.weighted.entry[i].left], r = latest_[plan.weighted.entry[i].right];
      newest_[lane] = left(lane, 1) * r + l * right(lane, 1);
      left(lane, k) = l;
      right(lane, k) = r;
    });
    unroll<plan.squares.size>([&](auto i) __attribute__((always_inline)) {
      const double x = latest_[plan.squares.entry[i]];
      newest_[plan.width + i] = 2.0 * square(i, 1) * x;
      square(i, k) = x;
    });
  }

  // Coefficient k in the rows of the lanes.
  [[gnu::always_inline]] double& left(int lane, int k) { return sweep_.left_[index(k) * index(plan.width) + index(lane)]; }
  [[gnu::always_inline]] double& right(int lane, int k) { return sweep_.right_[index(k) * index(plan.width) + index(lane)]; }
  [[gnu::always_inline]] double& square(int lane, int k) { return sweep_.square_[index(k) * index(plan.square_width) + index(lane)]; }

  Sweep& sweep_;
  double latest_[plan.slot_count];
  double interior_[plan.width + plan.square_width + register_lanes];
  double newest_[plan.width + plan.square_width + 1];  // the terms of an interior that hold the order before
};

}  // namespace qdot::taylor
