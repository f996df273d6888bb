#pragma once
// SPDX-License-Identifier: MIT
//
// What is remembered of an event's function from step to step.
//
// Noise. Zero to within the method's tolerance is no sign: a function of a velocity that sticks, or one that a constraint holds, has changes of sign that
// mean nothing. So a function that begins in this band, and whose event only records, has to leave it before anything in it is a root. The band is that
// of the present step: the velocity of a pendulum at rest is known to less than that of one that swings.
//
// What is remembered of a function from step to step is the side of zero on which it was last seen. Side 0 means
// "at zero": at the start of a run, or just after an event changed the state. Then its first sample off zero (by more than a band, in which g
// cannot be told from zero) gives it a side. If it is muted, that is no event. If it is not muted and goes the way that counts, there is an event
// where it left zero. This is the beginning of the interval, or behind the last sample that was exactly zero.
//
// A hop away from zero and back may be far shorter than the step. So a function at zero is watched from the first instant that t can
// tell. An event's own action may have turned (or stopped) g, which the rate dg/dt at the new state shows. Then g may leave zero to the
// side it came from and to no other. If it is first seen beyond, the hop was shorter than t can tell, and the events accumulate.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/integrate/event.hpp"

namespace qdot::detail {

[[noreturn, gnu::cold]] inline void refuse_backward(double t) {
  throw ConstraintError("a contact or friction", t, 0.0,
                        sentence({"a run backward in time must not meet an impact, or the beginning or end of contact or sticking, since many "
                                  "motions lead into the same one there, but at t = ", t, " this one does; run forward, or end the run before"}));
}

// Whether a switch without a name has changed the effects' own states alone: friction in a plane has another reference, and the motion goes on as it did.
// `states`: how many of y stand in front of those.
[[gnu::cold]] inline bool is_same_motion(const Eigen::VectorXd& before, const Eigen::VectorXd& after, Eigen::Index states, const Eigen::VectorXd& tolerance) {
  const Eigen::VectorXd change = after - before;
  return !change.tail(change.size() - states).isZero(0.0) && (change.head(states).cwiseAbs().array() <= 100 * tolerance.head(states).array()).all();
}

// Refuses a switch backward in time, where it has no answer, unless the motion stays the same.
template <class Form>
[[gnu::cold]] void require_same_motion(const Form& system, double t, const Eigen::VectorXd& y, const std::vector<bool>& fired,
                                       const Eigen::VectorXd& tolerance) {
  Eigen::VectorXd after = y;
  try {
    if (system.switched(t, after, fired, tolerance).empty() && is_same_motion(y, after, 2 * system.dof(), tolerance)) return;
  } catch (const Error&) {  // what is refused has no answer either
  }
  refuse_backward(t);
}

// One watched function.
struct Watch {
  Direction direction = Direction::either;
  bool barrier = false;  // g < 0 must not be passed
  int side = 0;          // of zero
  bool muted = false;    // at zero because of an event: leaving it is none
  bool stuck = false;    // a barrier that was passed without having been left
  bool passed = false;   // at zero, if it is, because of a root in the step, and not at the beginning of a motion
  int came_from = 0;     // that it was on before its last root
  int home = 0;          // the side to which it may leave zero; 0 if either
  bool lost = false;     // it left zero to the other
  bool judges = false;   // whether what is zero to within `noise` has no sign
  bool off = false;      // has left this band since it began
  bool is_kept = false;  // constraints hold the ends of steps alone: a function in the band at both is so between
  double noise = 0.0;    // of g, by the method's tolerance
  bool rough = false;    // could not be followed in this step
  bool is_formula = false, unproven = false;  // zeros are proved; but not in this step, for proofs fail
  int rough_panels = 0;  // in a row
  long panels = 0;       // in this step
  double panel = std::numeric_limits<double>::infinity();  // length of the last one
  double rounding = 0.0; // of g
  double value = 0.0;    // at the beginning of what is left of the step
  double level = 0.0;    // what counts as zero: rounding may leave a barrier's g a hair below it
  double band = 0.0;     // distance from level that cannot be told from zero
  std::optional<double> root;

  // Sets the value at the beginning of a step from scratch: at the start, and after the state has changed. A function
  // that is `at_zero` is muted until it leaves zero, unless this is the start of the run; there only if it had stopped the run before.
  // Rounding may have left a barrier that fired at g_before; that far below zero counts as zero. An unfired function that was off zero and
  // has been put there begins as at the start.
  void begin(double g, double zero_band, bool fired, double g_before, bool at_start) {
    band = zero_band + (fired ? 4 * std::abs(g_before - level) : 0.0);
    level = barrier ? std::clamp(g, -std::max(band, fired ? 2 * std::abs(g_before) : 0.0), 0.0) : 0.0;
    value = g;
    muted = (!at_start || fired) && (fired || std::abs(g_before - level) <= zero_band);
    passed = false;
    home = 0;
    const double distance = g - level;
    off = !judges || std::abs(distance) > noise;
    const bool at_zero = barrier ? distance <= band : distance == 0.0 || (fired && std::abs(distance) <= band);
    side = at_zero ? 0 : distance > 0 ? 1 : -1;
    stuck = false;
    root.reset();
  }

  // The motion has passed the root, where g is now.
  void pass(double g) {
    value = g;
    band = 0.0;
    muted = passed = true;
    side = g > level ? 1 : g < level ? -1 : 0;
    root.reset();
  }

  bool counts(int from_side) const {
    return direction == Direction::either || (direction == Direction::falling) == (from_side > 0);
  }
};

// The side on which a function, at zero after its own action, has to stay. It is where it came from, if the action turned its
// motion or stopped it; 0 if the motion may go on through zero. An action that turns what was moving away has come too late to be
// right.
inline int home_side(int side, const std::optional<int>& trend_before, const std::optional<int>& trend_after) {
  if (!trend_before || !trend_after) return 0;
  return side * *trend_before <= 0 ? (side * *trend_after >= 0 ? side : 0) : side * *trend_after < 0 ? side : 0;
}

}  // namespace qdot::detail
