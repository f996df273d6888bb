#pragma once
// SPDX-License-Identifier: MIT
//
// Lagrange's equations derived when a program runs, and carried out line by line.
//
// T and V of an object are recorded (mechanics/derive/recorded_energies.hpp) and differentiated as they are written
// (mechanics/derive/derivation.ipp). What comes out is a table of lines (ad/formula/lines.hpp), first those of M and r, then those
// of ∂(r − M a)/∂(q, q̇).
//
// Such lines hand M and r on by the `use` protocol of mechanics/mass_and_rhs.hpp.

#include <cstddef>
#include <utility>
#include <vector>

#include "qdot/ad/native/line_evaluator.hpp"
#include "qdot/mechanics/derive/recorded_energies.hpp"
#include "qdot/mechanics/equations/block_solve.hpp"
#include "qdot/mechanics/equations/small_solve.hpp"

namespace qdot::detail {

// Where M and r are asked for.
struct AtState {
  const double *q, *qdot;
  double t;
  int size = 0;  // number of coordinates, where it is known at run time only
};

/// The equations of one object, or its M alone. Inputs are q, q̇, t and accelerations, 3n + 1 numbers, and parameters; lines come after them. −1 is zero.
struct DerivedLines {
  static constexpr int lane_limit = 16;  // most coordinates for whose lanes there are lines to q̈
  // Numbers of an evaluation: a vector of them lies on the stack.
  static constexpr std::size_t most(std::size_t n) { return n <= 16 ? 4000 : 12000; }

  int dof = 0;
  formula::LineEvaluator equations;               // M and r
  formula::LineEvaluator before_slopes, further;  // the same lines, with all that the slopes read; and the slopes
  std::vector<int> mass, right, slopes;   // lower triangle of M, row by row; derivatives of each row along q and then q̇
  struct Checked {
    int number;
    formula::Domain domain;
  };
  std::vector<Checked> checked;  // outside of which T or V has no value
  struct Sided {
    int number;
    formula::Side side;
  };
  std::vector<Sided> sides;  // beyond which T or V has another branch

  // q̈, for lanes of up to 16 coordinates.
  struct Solution {
    formula::LineEvaluator lines;
    std::vector<int> accelerations;
    std::vector<std::pair<int, int>> pivots;
  };
  Solution solution;
  formula::MachineCodeBegins begins{};

  bool exist() const { return !mass.empty(); }
  bool have_slopes() const { return !slopes.empty(); }
  bool are_native() const { return equations.is_native(); }

  /// M and r, handed to `use`; false where T or V has no value, and where `use` returns false. Lines of M alone leave r as it is.
  template <int n, class Use>
  bool with_mass_and_rhs(const double* q, const double* qdot, double t, const Use& use) const {
    constexpr bool few = n >= 1 && n <= unrolled_limit;
    const int size = n == Dynamic ? dof : n;
    double x[most(n == Dynamic ? block_limit<n> : n)];
    write_inputs(size, q, qdot, t, x);
    equations(x);
    if (!have_values(x)) return false;
    double r[block_stride<n>];
    for (std::size_t i = 0; i < right.size(); ++i) r[i] = x[right[i]];
    if constexpr (few) {
      double M[n * (n + 1) / 2];
      write_mass(x, M);
      return use.full(AtState{q, qdot, t}, M, r);
    } else {
      double M[block_stride<n> * block_stride<n>];
      const int* entry = mass.data();
      for (int i = 0; i < size; ++i)
        for (int j = 0; j <= i; ++j, ++entry) M[block_stride<n> * i + j] = *entry < 0 ? 0.0 : x[*entry];
      return use.template rows<blocks_of<n>>(AtState{q, qdot, t, size}, size, M, r);
    }
  }

  /// M, and the derivatives of r − M a at accelerations a, which come from (M, r): `put_accelerations` leaves them in r's place;
  /// false where it returns false.
  template <int n, class Row, class F>
  bool write_slopes(const double* q, const double* qdot, double t, double* M, Row* rows, const F& put_accelerations) const {
    double x[most(n)];
    write_inputs(n, q, qdot, t, x);
    before_slopes(x);
    if (!have_values(x)) return false;
    write_mass(x, M);
    double* const a = x + 2 * n + 1;
    for (int i = 0; i < n; ++i) a[i] = x[right[static_cast<std::size_t>(i)]];
    if (!put_accelerations(static_cast<const double*>(M), a)) return false;
    further(x);
    const int* slope = slopes.data();
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < 2 * n; ++j, ++slope) rows[i][j] = *slope < 0 ? 0.0 : x[*slope];
    return true;
  }

 private:
  static void write_inputs(int n, const double* q, const double* qdot, double t, double* x) {
    for (int i = 0; i < n; ++i) {
      x[i] = q[i];
      x[n + i] = qdot[i];
    }
    x[2 * n] = t;
  }
  void write_mass(const double* x, double* M) const {
    for (const int entry : mass) *M++ = entry < 0 ? 0.0 : x[entry];
  }
  bool have_values(const double* x) const {
    bool good = true;
    for (const Checked& c : checked) good &= formula::is_in(c.domain, x[c.number]);
    for (const Sided& s : sides) good &= s.side.has(x[s.number]);
    return good;
  }
};

/// Variables for q, q̇ and t, with nothing recorded yet.
[[gnu::cold]] inline RecordedMotion motion_variables(int size) {
  RecordedMotion m;
  m.q = new_variables(m.recording, 0, size);
  m.qdot = new_variables(m.recording, size, size);
  m.t = formula::variable_in(m.recording, 2 * size);
  return m;
}

}  // namespace qdot::detail
