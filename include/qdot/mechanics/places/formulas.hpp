#pragma once
// SPDX-License-Identifier: MIT
//
// The kinematic door while compiling: T and V of bodies as formulas.
//
// A functor that places bodies (kinematic_system.hpp) and is constexpr can be run by the compiler on traced numbers that move, r and ṙ
// (ad/formula/trace.hpp). The listeners of this file write down T = Σ ½ m ṙ·ṙ + ½ I α̇² and V = −Σ m g·r, as a list of operations like that of
// a T and a V that somebody wrote.

#include <array>

#include "qdot/ad/formula/trace.hpp"
#include "qdot/mechanics/velocity.hpp"

namespace qdot::detail {

using MovingFormula = AlongMotion<trace::Traced>;

template <class... Arguments>
inline constexpr bool is_no_body_of_formulas = false;

// T of all bodies.
struct FormulaOfT {
  trace::Traced T{0.0};

  template <int axes>
  constexpr void point_mass(double m, const trace::FormulaVector<MovingFormula, axes>& r) {
    T += 0.5 * m * squared_speed(r);
  }
  template <int axes>
  constexpr void planar_body(double m, double inertia, const trace::FormulaVector<MovingFormula, axes>& r, const MovingFormula& angle) {
    T += 0.5 * m * squared_speed(r);
    T += 0.5 * inertia * (angle.tangent[0] * angle.tangent[0]);
  }
  // A body at rest has no kinetic energy.
  template <int axes>
  constexpr void point_mass(double, const trace::FormulaVector<trace::Traced, axes>&) {}
  template <class... Arguments>
  constexpr void rigid_body(const Arguments&...) {
    static_assert(is_no_body_of_formulas<Arguments...>,
                  "qdot: written_out_kinematic_system takes point masses and planar bodies; with rigid bodies in space use kinematic_system");
  }

 private:
  template <int axes>
  static constexpr trace::Traced squared_speed(const trace::FormulaVector<MovingFormula, axes>& r) {
    trace::Traced sum = r[0].tangent[0] * r[0].tangent[0];
    for (int i = 1; i < axes; ++i) sum += r[i].tangent[0] * r[i].tangent[0];
    return sum;
  }
};

// V of all bodies in a uniform field.
struct FormulaOfWeight {
  std::array<double, 3> field;
  trace::Traced V{0.0};

  template <int axes>
  constexpr void point_mass(double m, const trace::FormulaVector<trace::Traced, axes>& r) {
    for (int i = 0; i < axes; ++i) V -= (m * field[static_cast<std::size_t>(i)]) * r[i];
  }
  template <int axes>
  constexpr void planar_body(double m, double, const trace::FormulaVector<trace::Traced, axes>& r, const trace::Traced&) {
    point_mass(m, r);
  }
  template <class... Arguments>
  constexpr void rigid_body(const Arguments&...) {}
};

}  // namespace qdot::detail
