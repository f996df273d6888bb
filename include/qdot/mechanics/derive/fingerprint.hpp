#pragma once
// SPDX-License-Identifier: MIT
//
// Whether functors are still those of which something was derived.
//
// They are run on hashes of their arguments (ad/formula/hashed.hpp), and return hashes of what they do. That costs a multiplication for an operation, or
// nothing where the compiler finds it out, so it can be asked before each evaluation.
//
// A position that moves is a function of marked coordinates. Its value and its rate are both hashes of what it returns.

#include <concepts>
#include <cstdint>
#include <vector>

#include "qdot/ad/formula/hashed.hpp"
#include "qdot/ad/unroll.hpp"
#include "qdot/mechanics/derive/recordable_form.hpp"
#include "qdot/mechanics/energy.hpp"
#include "qdot/mechanics/velocity.hpp"

namespace qdot::detail {

template <>
struct MovingPositions<formula::Hashed> {
  static constexpr bool known = true;
  using Position = formula::Hashed;

  [[gnu::always_inline]] void read(const Position& q, const Position& qdot, Position& to) const { to = Position::moving(q, qdot); }
  [[gnu::always_inline]] void read_time(const Position& t, Position& to) const { to = Position::moving(t, 1.0); }
  [[gnu::always_inline]] ValueAndRate<Position> both(const Position& x) const { return {Position::digest(x, 0), Position::digest(x, 1)}; }
};

// Variables of functors that are to be hashed.
template <int n>
struct HashedMotion {
  using S = formula::Hashed;
  formula::HashedComparisons comparisons;
  Vector<S, n> q, qdot;
  S t;

  [[gnu::always_inline]] HashedMotion(int size, const Answers* answers)
      : comparisons{answers}, q(size), qdot(size) {
    const int count = n == Dynamic ? size : n;  // known while compiling
    t = S(comparisons, 2 * count);
    const auto number = [&](int i) __attribute__((always_inline)) {
      q.data()[i] = S(comparisons, i);
      qdot.data()[i] = S(comparisons, count + i);
    };
    if constexpr (n == Dynamic) for (int i = 0; i < count; ++i) number(i);
    else unroll<n>(number);
  }
};

// Energies that make their fingerprint themselves.
template <class E>
concept HasFingerprint = requires(const E& e, const Answers* answers) { { e.fingerprint(1, answers) } -> std::same_as<Fingerprint>; };

/// The fingerprint of energies on a branch. Of functors without loops the compiler finds most of it out by itself.
template <int n, class E>
[[gnu::noinline, gnu::flatten]] Fingerprint fingerprint(const E& e, int size, const Answers* answers = nullptr) {
  HashedMotion<n> m(size, answers);
  try {
    const formula::Hashed T = kinetic<n>(e, m.q, m.qdot, m.t), V = potential<n>(e, m.q, m.t);
    if (m.comparisons.are_given()) return formula::Hashed::with_comparisons(formula::Hashed::joined(T, V), m.comparisons);
  } catch (...) {  // what functors throw they throw again, where they are asked for values
  }
  return 0;
}
template <int n, HasFingerprint E>
Fingerprint fingerprint(const E& e, int size, const Answers* answers = nullptr) {
  return e.fingerprint(size, answers);
}

}  // namespace qdot::detail
