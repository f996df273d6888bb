#pragma once
// SPDX-License-Identifier: MIT
//
// Diagnosis: why a run stands still, asked only when it has ended.
//
// The step can shrink to nothing for four reasons, and each has another cure. Some dozens of evaluations tell them apart, about the
// last good state (t, y), with f₀ = f(t, y) and along the line y + s f₀:
//
//     event chatter    more than one in twenty of the last steps ended at events that changed the state.
//     discontinuous    f differs between s = −r and s = +r, and halving to the side with the larger difference ends between two
//                      neighbouring doubles with the difference still there. A pole has made it larger.
//     singular         a component changes by its own size in a time that is nothing beside the run's, and nothing in ∂f/∂y is much
//                      faster: the motion runs to infinity, or into a root of zero. Or M has become nearly singular.
//     stiff            h ρ is about one, where ρ, the largest |λ| of ∂f/∂y, is much faster than the motion: stability holds the step.
//
// None of these is a proof, so the message gives the numbers with the word. Where f became NaN, the first such place on the line is
// searched for, and what is not finite there is named. What the model throws meanwhile is caught: the run has its outcome already.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "qdot/ad/vector.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/watch/driven_form.hpp"

namespace qdot::detail {

// The trouble with what has been recorded or read of functors, and is something else by now.
inline Failure other_formula() {
  return {Outcome::model_changed, "between events and stop times functors must depend on nothing but their arguments, but T, V or an effect has "
                                  "become another formula, or the same with another constant"};
}

// A form, asked after the run.
struct Probe {
  const DrivenForm& form;

  // f ← f(t, y); false where it is not finite.
  [[gnu::cold]] bool operator()(double t, const Eigen::VectorXd& y, Eigen::VectorXd& f) const {
    try {
      form.derivative(t, y, f);
      return all_finite(f.data(), f.size());
    } catch (...) {
      return false;
    }
  }
  std::string name(Eigen::Index i) const { return form.component_name(i); }
  std::string named(Eigen::Index i, double value) const { return sentence({name(i), " = ", value}); }
  // What is not finite: T, V, …; empty if unknown.
  [[gnu::cold]] std::string blame(double t, const Eigen::VectorXd& y) const {
    try {
      return form.what_is_not_finite(t, y);
    } catch (...) {
      return {};
    }
  }
};

// Where a run stands still.
struct Standstill {
  double t = 0.0;
  const Eigen::VectorXd& y;
  Eigen::VectorXd tolerance;  // of each component
  double direction = 1.0;     // of time
  double h = 0.0;             // |h| of the last steps
  double progress = 0.0, rest = 0.0;  // |t − t₀|, |t_end − t|
  long steps = 0, restarts = 0;  // of late
  double mass_rcond = 1.0;
};

inline bool same(const Eigen::VectorXd& u, const Eigen::VectorXd& v) {
  return std::equal(u.data(), u.data() + u.size(), v.data());
}

inline double length(const Eigen::VectorXd& u) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < u.size(); ++i) sum += u[i] * u[i];
  return std::sqrt(sum);
}

// A change of f between neighbours on the line, or a pole.
[[gnu::cold]] inline std::string found_jump(const Probe& f, const Standstill& at, const Eigen::VectorXd& f0, double reach) {
  Eigen::VectorXd ya(at.y), yb(at.y), ym(at.y), fa(at.y), fb(at.y), fm(at.y);
  const auto go = [&](double s, Eigen::VectorXd& y, Eigen::VectorXd& value) {
    for (Eigen::Index i = 0; i < y.size(); ++i) y[i] = at.y[i] + s * f0[i];
    return f(at.t + s, y, value);
  };
  Eigen::Index worst = 0;
  const auto apart = [&](const Eigen::VectorXd& u, const Eigen::VectorXd& v) {
    double most = 0.0;
    for (Eigen::Index i = 0; i < u.size(); ++i)
      if (const double d = std::abs(u[i] - v[i]) / at.tolerance[i]; d > most) most = d, worst = i;
    return most;
  };
  double a = -reach, b = reach;
  if (!go(a, ya, fa) || !go(b, yb, fb)) return {};
  const double total = apart(fa, fb);
  if (!(std::abs(fa[worst] - fb[worst]) > 1e-3 * (std::abs(fa[worst]) + std::abs(fb[worst])))) return {};
  for (int k = 0; k < 100; ++k) {
    const double m = 0.5 * (a + b);
    if (m == a || m == b || !go(m, ym, fm)) break;
    if ((at.t + m == at.t + a && same(ym, ya)) || (at.t + m == at.t + b && same(ym, yb))) break;
    if (apart(fa, fm) > apart(fm, fb)) {
      b = m, yb = ym, fb = fm;
    } else {
      a = m, ya = ym, fa = fm;
    }
  }
  const double left = apart(fa, fb);
  if (!(left > 0.1 * total)) return {};
  if (left > 10 * total) return sentence({"singular: the derivative of ", f.name(worst), " has a pole near t = ", at.t + a});
  return sentence({"discontinuous: the derivative of ", f.name(worst), " jumps from ", fa[worst], " to ", fb[worst], " near t = ", at.t + a,
                   ", ", f.named(worst, ya[worst]), "; give the time of the jump in stop_times, or its place as an event"});
}

// The largest |λ| of ∂f/∂y, roughly; 0 when it cannot be had.
[[gnu::cold]] inline double fastest_rate(const Probe& f, const Standstill& at, const Eigen::VectorXd& f0) {
  constexpr int powers = 20, counted = 8;
  double size = 0.0;
  for (Eigen::Index i = 0; i < at.y.size(); ++i) size = std::max(size, 1e-7 * (std::abs(at.y[i]) + at.tolerance[i]));
  Eigen::VectorXd d(at.y), moved(at.y), value(at.y);
  for (Eigen::Index i = 0; i < d.size(); ++i) d[i] = (i % 2 == 0 ? 1.0 : -1.0) / static_cast<double>(i + 1);
  double logarithm = 0.0;
  for (int k = 0; k < powers; ++k) {
    const double scale = size / length(d);
    for (Eigen::Index i = 0; i < d.size(); ++i) moved[i] = at.y[i] + scale * d[i];
    if (!f(at.t, moved, value)) return 0.0;
    for (Eigen::Index i = 0; i < d.size(); ++i) d[i] = value[i] - f0[i];
    const double growth = length(d) / size;
    if (!(growth > 0.0)) return 0.0;
    if (k >= powers - counted) logarithm += std::log(growth);
  }
  return std::exp(logarithm / counted);
}

/// Why the steps are so small, in words; empty when nothing speaks for any of the reasons.
///
/// @param collapsed  the step has shrunk to nothing; otherwise a pole is not looked for, and a jump only where steps are tiny
[[gnu::cold]] inline std::string diagnosis_of(const Probe& f, const Standstill& at, bool collapsed) {
  constexpr double often = 0.05;  // part of the steps that ended at events
  if (at.restarts >= 20 && static_cast<double>(at.restarts) > often * static_cast<double>(at.steps))
    return sentence({"event chatter: ", at.restarts, " of the last ", at.steps,
                     " steps ended at an event that changed the state; let the event leave its surface behind, or give the system a "
                     "phase in which it rests there, as contact() has"});
  Eigen::VectorXd f0(at.y);
  if (!f(at.t, at.y, f0)) return {};
  if (collapsed || at.h < 1e-6 * at.progress)
    if (std::string jump = found_jump(f, at, f0, std::max(1e-9 * std::max(at.progress, std::abs(at.t)), 4 * at.h)); !jump.empty())
      return jump;
  if (at.mass_rcond < 1e-8)
    return sentence({"singular: rcond(M) has come down to ", at.mass_rcond, "; choose coordinates that do not degenerate here"});
  double own = 0.0;  // rate of the motion itself
  Eigen::Index quickest = 0;
  for (Eigen::Index i = 0; i < at.y.size(); ++i)
    if (const double rate = std::abs(f0[i]) / std::max(std::abs(at.y[i]), at.tolerance[i]); rate > own) own = rate, quickest = i;
  const double rho = fastest_rate(f, at, f0);
  if (at.h * rho > 0.3 && rho > 20 * own)
    return sentence({"stiff: the fastest rate of the system is |lambda| = ", rho, " and h |lambda| = ", at.h * rho,
                     ", but the motion itself changes at ", own, "; take CvodeBdf or Automatic"});
  if (collapsed && own * at.progress > 1e4 && at.h < 1e-7 * at.progress)
    return sentence({"singular: ", f.named(quickest, at.y[quickest]), " changes by its own size within ", 1 / own,
                     ", so the solution runs to infinity or into a root of zero; end the run before t = ", at.t});
  return {};
}

/// Where f is first not finite ahead of the last good state, and what is to blame; empty when it is finite as far as `reach`.
[[gnu::cold]] inline std::string first_non_finite(const Probe& f, const Standstill& at, double reach) {
  Eigen::VectorXd f0(at.y), y(at.y), value(at.y);
  if (!f(at.t, at.y, f0)) return {};
  const auto good_at = [&](double s) {
    for (Eigen::Index i = 0; i < y.size(); ++i) y[i] = at.y[i] + s * at.direction * f0[i];
    return f(at.t + s * at.direction, y, value);
  };
  double good = 0.0, bad = std::max(4 * std::numeric_limits<double>::epsilon() * std::abs(at.t), 1e-15 * reach);
  while (bad <= reach && good_at(bad)) good = std::exchange(bad, 4 * bad);
  if (bad > reach) return {};
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (good + bad);
    if (middle == good || middle == bad) break;
    (good_at(middle) ? good : bad) = middle;
  }
  good_at(bad);
  const double t = at.t + bad * at.direction;
  std::string text = sentence({"first at t = ", t, " with "});
  constexpr Eigen::Index most = 8;
  for (Eigen::Index i = 0; i < std::min(y.size(), most); ++i) text = sentence({text, i > 0 ? ", " : "", f.name(i), " = ", y[i]});
  if (y.size() > most) text = sentence({text, ", ..."});
  if (const std::string blamed = f.blame(t, y); !blamed.empty()) return sentence({text, ", where ", blamed});
  for (Eigen::Index i = 0; i < value.size(); ++i)
    if (!std::isfinite(value[i])) return sentence({text, ", where the derivative of ", f.name(i), " is ", value[i]});
  return text;
}

/// What to add to the message of an end that the user did not ask for; often nothing.
template <class Number = double>
[[gnu::cold]] std::string explanation(const Probe& f, Outcome outcome, const Standstill& at) {
  if (outcome == Outcome::non_finite) {
    const std::string where = first_non_finite(f, at, at.h > 0.0 ? 100 * at.h : at.rest);
    return sentence({where.empty() ? "" : "; ", where});
  }
  const bool collapsed =
      outcome == Outcome::step_too_small || outcome == Outcome::error_test_failure || outcome == Outcome::corrector_failure;
  if (!collapsed && outcome != Outcome::step_limit) return {};
  const std::string why = diagnosis_of(f, at, collapsed);
  return sentence({why.empty() ? "" : "; diagnosis: ", why});
}

#ifdef QDOT_COMPILED
extern template std::string explanation<double>(const Probe&, Outcome, const Standstill&);
#endif

}  // namespace qdot::detail
