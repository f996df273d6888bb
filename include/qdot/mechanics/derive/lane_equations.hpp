#pragma once
// SPDX-License-Identifier: MIT
//
// q̈ of many motions at once, by the lines of their system.
//
// Lines do not care for which motion a number stands (ad/formula/lane_lines.hpp). Each lane has its own q, q̇, t and, where systems of a family differ,
// its own parameters, which are inputs of the lines like the state. The lines go on to q̈ (mechanics/derive/solution_lines.hpp). What they have no
// branches for is looked at afterwards in each lane: pivots, the domains of functions, the sides of a branch, and whether q̈ is finite. A lane that fails
// is left to the caller.

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "qdot/ad/pack.hpp"
#include "qdot/mechanics/derive/kept_lines.hpp"
#include "qdot/mechanics/equations/solve.hpp"

namespace qdot::detail {

/// Most coordinates that go in lanes.
inline constexpr int lane_limit = DerivedLines::lane_limit;

/// Whether a system may have lines for lanes, as far as types tell.
template <class Sys>
inline constexpr bool may_have_lane_lines = [] {
  using E = typename Sys::EnergiesType;
  constexpr int n = Sys::dof_at_compile_time;
  return Sys::inertia == Inertia::positive_definite && n >= 1 && n <= lane_limit && RecordableEnergies<E, n>;
}();

/// Those lines, of functors that branch on the branch of a state; null where there are none.
template <class Sys>
const DerivedLines* lane_lines_at(const Sys& system, const AtState& at, Derivations::Held& held) {
  constexpr int n = Sys::dof_at_compile_time;
  if (!system.kept_lines()->shared()) return nullptr;
  KeptDerivation* const it = derivations_of(*system.kept_lines()->shared()).template at<n>(system.energies(), at, held);
  return it ? it->lines_for_lanes() : nullptr;
}

/// Whether lanes are faster than one motion after the other: by machine code, or by the interpreter for few coordinates.
inline bool lanes_pay(const DerivedLines& lines) {
  const formula::LineEvaluator& solution = lines.solution.lines;
  const bool are_native = formula::native_lanes_are_possible();
  return are_native ? solution.count() <= formula::longest_native_lines : lines.right.size() <= 4;
}
/// How many numbers their evaluation has, after those of the state and of parameters.
inline std::size_t lane_numbers(const DerivedLines& lines) { return lines.solution.lines.count(); }

/// Evaluates q̈ in the lanes of packs P, which have eight.
template <int n, class P>
class LaneEquations {
  static_assert(P::size == static_cast<int>(formula::lanes_stored));

 public:
  /// @param lines  of a system; must live as long as this object
  /// @param x      as many numbers as lane_numbers() says, which must live as long
  LaneEquations(const DerivedLines& lines, formula::LaneNumber* x) : lines_(&lines), x_(x) {}

  /// Parameter j of one lane.
  void set_parameter(int j, int lane, double value) { x_[3 * n + 1 + j].lanes()[lane] = value; }

  /// q̈ in all lanes, and in which of them it is one.
  typename P::Mask operator()(const P* q, const P* qdot, const P& t, P* qddot) {
    put_state(q, qdot, t);
    const DerivedLines::Solution& s = lines_->solution;
    s.lines(x_);
    typename P::Mask good = have_values();
    for (const auto& [pivot, whole] : s.pivots) good &= number(pivot) > singular_pivot<double>(n) * number(whole);
    const double* from[n];
    for (std::size_t i = 0; i < n; ++i) from[i] = x_[s.accelerations[i]].lanes();
    copy_(reinterpret_cast<double*>(qddot), from, n);
    P zero = 0.0;
    for (int i = 0; i < n; ++i) zero += qddot[i] - qddot[i];
    return good & (zero == P(0.0));
  }

 private:
  void put_state(const P* q, const P* qdot, const P& t) {
    const double* from[2 * n + 1];
    const auto doubles = [](const P& number) { return reinterpret_cast<const double*>(&number); };
    for (int i = 0; i < n; ++i) {
      from[i] = doubles(q[i]);
      from[n + i] = doubles(qdot[i]);
    }
    from[2 * n] = doubles(t);
    copy_(x_[0].lanes(), from, 2 * n + 1);
  }
  P number(int k) const {
    P value;
    std::memcpy(&value, &x_[k], sizeof value);
    return value;
  }
  // A lane is out where its number is zero. Of masks that are put together in the loop g++ 12 makes an internal error (-O3, two lanes to a register).
  typename P::Mask have_values() const {
    double in[formula::lanes_stored];
    std::fill_n(in, formula::lanes_stored, 1.0);
    const auto require = [&](int number, const auto& holds) {
      const double* const lanes = x_[number].lanes();
      for (std::size_t lane = 0; lane < formula::lanes_stored; ++lane)
        if (!holds(lanes[lane])) in[lane] = 0.0;
    };
    for (const DerivedLines::Checked& c : lines_->checked) require(c.number, [&](double x) { return formula::is_in(c.domain, x); });
    for (const DerivedLines::Sided& s : lines_->sides) require(s.number, [&](double x) { return s.side.has(x); });
    return P::of([&](int lane) { return in[lane]; }) > 0.5;
  }

  const DerivedLines* lines_;
  decltype(formula::fastest_copy_of_lanes()) copy_ = formula::fastest_copy_of_lanes();
  formula::LaneNumber* x_;
};

}  // namespace qdot::detail
