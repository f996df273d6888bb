#pragma once
// SPDX-License-Identifier: MIT
//
// A sweep that is known to the compiler.
//
// A sweep (ad/series/sweep.hpp) reads at each order what to do next: which numbers to add to which. If the compiler makes the graph and
// the sweep itself, all of that is constants of the program, and an order of the series is code without loops and without
// anything to read but numbers.
//
// What the compiler cannot know are the parameters: masses, lengths. A graph looks at its coefficients, though: 0·x is gone, 1·x is x,
// and equal nodes are one. So each parameter gets a *shadow*, a number as good as any, which decides such questions alike for all values
// that the parameter may have, and beside it goes the value that is computed with:
//
//     Parameter = (shadow, value),      (s₁, v₁) + (s₂, v₂) = (s₁ + s₂, v₁ + v₂), …
//
// Literals are their own shadows, so that what is zero in every object is gone. Shadows come from a sequence that no sum or product of a
// formula hits by chance (ad/formula/shadow.hpp); if one did, the object's own sweep would not be the one that was planned, and that is
// compared when it is made (==), not assumed.

#include <vector>

#include "qdot/ad/series/sweep.hpp"

namespace qdot::taylor {

/// A coefficient whose value the compiler does not know, but which it computes with.
struct Parameter {
  double shadow = 0.0;
  double value = 0.0;

  constexpr Parameter() = default;
  constexpr Parameter(double literal) : shadow(literal), value(literal) {}
  constexpr Parameter(double shadow_, double value_) : shadow(shadow_), value(value_) {}

  friend constexpr Parameter operator+(const Parameter& x, const Parameter& y) { return {x.shadow + y.shadow, x.value + y.value}; }
  friend constexpr Parameter operator-(const Parameter& x, const Parameter& y) { return {x.shadow - y.shadow, x.value - y.value}; }
  friend constexpr Parameter operator*(const Parameter& x, const Parameter& y) { return {x.shadow * y.shadow, x.value * y.value}; }
  friend constexpr Parameter operator/(const Parameter& x, const Parameter& y) { return {x.shadow / y.shadow, x.value / y.value}; }
  constexpr Parameter& operator+=(const Parameter& y) { return *this = *this + y; }
};

constexpr double decisive(const Parameter& x) { return x.shadow; }
constexpr double actual(const Parameter& x) { return x.value; }
constexpr Parameter power_of(const Parameter& x, double exponent) {
  return {power_of(x.shadow, exponent), power_of(x.value, exponent)};
}
inline Parameter value_of(Function f, const Parameter& x, const Parameter& y) {
  return {value_of(f, x.shadow, y.shadow), value_of(f, x.value, y.value)};
}

/// A list of bounded length that may be a constant of the program.
template <class Entry, int capacity>
struct PlanList {
  int size = 0;  // as long as the list would be, even if it does not fit
  Entry entry[capacity] = {};

  constexpr void add(const Entry& x) {
    if (size < capacity) entry[size] = x;
    ++size;
  }
  constexpr bool fits() const { return size <= capacity; }
  friend constexpr bool operator==(const PlanList& x, const PlanList& y) {
    for (int i = 0; i < x.size && i < capacity; ++i)
      if (!(x.entry[i] == y.entry[i])) return false;
    return x.size == y.size;
  }
};

/// What a sweep does at each order, without the numbers that it does it with.
struct SweepPlan {
  struct End {  // latest[slot] = interior[lane] + Σ factors[first + j] latest[terms[first + j]], j < count
    int slot = 0, lane = 0, first = 0, count = 0;
    friend constexpr bool operator==(const End&, const End&) = default;
  };
  struct Lane {
    int left = 0, right = 0;
    friend constexpr bool operator==(const Lane&, const Lane&) = default;
  };
  struct Interior {
    int slot = 0, lane = 0, other = 0;
    friend constexpr bool operator==(const Interior&, const Interior&) = default;
  };

  PlanList<End, 160> early, late;
  PlanList<int, 400> terms;
  PlanList<Lane, 80> plain, weighted;
  PlanList<int, 40> squares;
  PlanList<Interior, 40> quotients, powers, second_arguments;
  int slot_count = 0;                     // of nodes with series
  int width = 0, square_width = 0;   // of rows

  SweepPlan() = default;
  constexpr explicit SweepPlan(const Sweep& s)
      : slot_count(s.series_count_), width(static_cast<int>(s.width_)), square_width(static_cast<int>(s.square_width_)) {
    const auto take_ends = [&s](const std::vector<Sweep::Ends>& groups, auto& list) {
      for (const Sweep::Ends& group : groups)
        for (int i = group.first; i < group.last; ++i) {
          const Sweep::End& end = s.ends_[Sweep::index(i)];
          list.add({end.slot, end.lane, end.first, group.terms});
        }
    };
    const auto take_interiors = [](const std::vector<Sweep::Interior>& from, auto& list) {
      for (const Sweep::Interior& i : from) list.add({i.slot, i.lane, i.other});
    };
    take_ends(s.early_, early);
    take_ends(s.late_, late);
    for (const int slot : s.terms_) terms.add(slot);
    for (const Sweep::Lane& lane : s.plain_) plain.add({lane.left, lane.right});
    for (const Sweep::Lane& lane : s.weighted_) weighted.add({lane.left, lane.right});
    for (const int slot : s.squares_) squares.add(slot);
    take_interiors(s.quotients_, quotients);
    take_interiors(s.powers_, powers);
    take_interiors(s.second_arguments_, second_arguments);
  }

  /// Whether all of it found room; what is longer than that is not worth writing out.
  constexpr bool fits() const {
    return early.fits() && late.fits() && terms.fits() && plain.fits() && weighted.fits() && squares.fits() && quotients.fits() &&
           powers.fits() && second_arguments.fits();
  }

  friend constexpr bool operator==(const SweepPlan&, const SweepPlan&) = default;
};

}  // namespace qdot::taylor
