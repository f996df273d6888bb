#pragma once
// SPDX-License-Identifier: MIT
//
// The published hard cases: problems on which solvers are known to lose digits, each with a reference that is better than
// double precision (computed with 34 digits, or a closed form).
//
// A case is one file here: T, V, constraints and forces as any user writes them, the published data, the reference, and the
// methods that apply. It returns a row for each method:
//
//     digits reached    −log10 of the largest error at the end, each entry beside its scale: the largest reference value of
//                       its half (positions, velocities), or what the case says
//     digits good       what the comparison is good for: the reference's own digits, or, where that is less, what is left
//                       of double precision after the motion has amplified the rounding of the start,
//                       −log10(ε·gain), ε = 2.2e-16. The gain, too, is relative and stands in the case.
//     best published    what others reached, or printed
//
// A row claims to come within one digit of what is good. A method that cannot is shown all the same where people would take it for the
// problem; its row says what stops it (`limit`) and claims nothing. Nothing here knows of `qdot bench hard` (src/bench/hard.cpp), which prints
// the rows and writes docs/lab/hard-cases.md.

#include <optional>
#include <string>
#include <vector>

namespace qdot::hard {

/// One problem solved by one method.
struct Row {
  std::string problem;  // "Pleiades", "double pendulum A, t = 5"
  std::string method;   // "dop853, 1e-14"
  double digits_reached = 0;
  double digits_good = 0;
  std::string best_published{};
  long evaluations = 0;
  double seconds = 0;
  std::optional<double> constraint_residual_max{};  // largest |φ| (velocity constraints: |a|) after steps, where there are any
  std::optional<double> energy_drift_max{};         // largest |h − h(0) − work| over all steps, in units of the energy
  std::string outcome{};
  std::string limit{};  // why the method stops before the good digits; empty: the row claims them

  double short_by() const { return digits_good - digits_reached; }
};

/// A published problem.
struct Case {
  std::string name;   // snake_case
  std::string title;  // heading of the page
  std::string about;  // what it is, what makes it hard, where the numbers come from
  std::vector<Row> (*rows)();
};

Case arenstorf();
Case pleiades();
Case kepler();
Case henon_heiles();
Case double_pendulum();
Case outer_solar_system();
Case rigid_body();
Case bouncing_ball();
Case chaplygin_sleigh();
Case rolling_disk();
Case projected_pendulum();
Case long_pendulum();
Case car_axis();
Case n_four_bar();
Case bricard();
Case flyball_governor();
Case andrews();
Case flexible_crank();
Case ggl_slider_crank();

/// All cases, easiest first.
std::vector<Case> all_cases();

}  // namespace qdot::hard
