#pragma once
// SPDX-License-Identifier: MIT
//
// The same model through a door of the library and by the oracle: q̈, M, rhs, momenta, energies, ∂q̈/∂(q, q̇), ensembles.
//
// What is demanded at a state: numbers within what rounding allows; an error where T or V has no finite value, or M is not positive definite;
// and everywhere that nothing is returned that is not finite.

#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "oracle.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"
#include "qdot/mechanics/energy.hpp"
#include "qdot/mechanics/accelerations.hpp"
#include "qdot/mechanics/kinematic_system.hpp"
#include "qdot/mechanics/system.hpp"

namespace fuzz {

/// What a hunt has seen.
struct Report {
  std::string where;                  // seed, case, kind: what a finding begins with
  std::vector<std::string> findings;
  long compared = 0, refused = 0, undecided = 0;  // answers that were compared, that had to be errors, that double can't tell

  std::string model;                  // in words
  void finding(const std::string& text) { findings.push_back(where + ": " + text + "\n    " + model); }
};

inline std::string text(double x) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.17g", x);
  return buffer;
}

/// Tolerances that were used and what was off, for those who calibrate them.
inline double worst_ratio = 0.0;

/// Compares numbers with what is known of them.
inline bool agree(Report& report, const std::string& what, const Known& known, const std::vector<double>& got, const std::string& state) {
  ++report.compared;
  for (std::size_t i = 0; i < known.exact.size(); ++i) {
    const double off = static_cast<double>(magnitude(quad(got[i]) - known.exact[i]));
    if (known.tolerance > 0) worst_ratio = std::max(worst_ratio, off / known.tolerance);
    if (off <= known.tolerance) continue;
    report.finding(what + "[" + std::to_string(i) + "] is " + text(got[i]) + ", exact " + text(static_cast<double>(known.exact[i])) +
                   ", allowed to be off by " + text(known.tolerance) + " at " + state);
    return false;
  }
  return true;
}

template <class Derived>
std::vector<double> entries(const Eigen::MatrixBase<Derived>& M) {
  std::vector<double> all;
  for (Eigen::Index i = 0; i < M.rows(); ++i)
    for (Eigen::Index j = 0; j < M.cols(); ++j) all.push_back(M(i, j));
  return all;
}
inline bool all_finite(const std::vector<double>& x) {
  return std::all_of(x.begin(), x.end(), [](double y) { return std::isfinite(y); });
}

/// One quantity by the library: compared, or an error, as the verdict demands.
template <class Ask>
void ask(Report& report, const std::string& what, Verdict::Demand demand, const Known& known, const std::string& state, const Ask& quantity) {
  std::vector<double> got;
  try {
    got = quantity();
  } catch (const qdot::Error& error) {
    if (demand == Verdict::numbers) report.finding(what + " throws '" + error.what() + "' at " + state);
    else ++report.refused;
    return;
  } catch (const std::exception& error) {
    return report.finding(what + " throws what is no error of qdot's, '" + error.what() + "', at " + state);
  }
  if (demand == Verdict::an_error) return report.finding(what + " is returned where T or V is not finite or M not positive definite, at " + state);
  if (!all_finite(got)) return report.finding(what + " holds what is not finite, at " + state);
  if (demand == Verdict::numbers || demand == Verdict::numbers_or_an_error) agree(report, what, known, got, state);
  else ++report.undecided;
}

struct Start {
  std::vector<double> q, qdot;
  double t = 0.0;

  Instant instant() const { return {Quads(q.begin(), q.end()), Quads(qdot.begin(), qdot.end()), t}; }
  std::string in_words() const {
    std::string words = "q =";
    for (const double x : q) words += " " + text(x);
    words += ", qdot =";
    for (const double x : qdot) words += " " + text(x);
    return words + ", t = " + text(t);
  }
};

/// A state: of order one, with zeros, equal entries, tiny or larger ones now and then.
inline Start random_start(Dice& dice, int n) {
  Start s;
  const int special = dice.below(8);
  const auto entry = [&](double largest, const std::vector<double>& before) {
    if (special == 0) return 0.0;
    const int own = dice.below(14);
    if (own == 0) return 0.0;
    if (own == 1 && !before.empty()) return before.back();
    if (own == 2) return dice.between(-1e-8, 1e-8);
    if (own == 3) return dice.between(-20.0, 20.0);
    if (own == 4) return dice.one_in(2) ? 1.0 : -1.0;
    return dice.between(-largest, largest);
  };
  for (int i = 0; i < n; ++i) s.q.push_back(entry(2.0, s.q));
  for (int i = 0; i < n; ++i) s.qdot.push_back(special == 1 ? 0.0 : entry(2.0, s.qdot));
  s.t = dice.one_in(4) ? 0.0 : dice.between(-3.0, 3.0);
  return s;
}

/// Everything that one door says at one state; `ensembles` where the door takes packs of all functions.
template <bool ensembles = true, class System>
void check_door(Report& report, const std::string& door, const System& system, const Model& model, const Verdict& verdict, const Start& start) {
  using namespace qdot;
  constexpr int n = System::dof_at_compile_time;
  const auto size = static_cast<Eigen::Index>(model.n);
  const Vector<double, n> q = Eigen::Map<const Vector<double, n>>(start.q.data(), size);
  const Vector<double, n> qdot = Eigen::Map<const Vector<double, n>>(start.qdot.data(), size);
  const double t = start.t;
  const std::string at = start.in_words() + " (" + door + ")";
  const Verdict::Demand demand = verdict.demand, value = demand == Verdict::numbers ? demand : Verdict::nothing;
  ask(report, "q̈", demand, verdict.qddot, at, [&] { return entries(acceleration(system, q, qdot, t)); });
  ask(report, "q̈ by duals", demand, verdict.qddot, at, [&] { return entries(acceleration(system, q, qdot, t, By::duals)); });
  ask(report, "q̈ by lines", demand, verdict.qddot, at, [&] { return entries(acceleration(system, q, qdot, t, By::lines)); });
  ask(report, "q̈ by machine code", demand, verdict.qddot, at, [&] { return entries(acceleration(system, q, qdot, t, By::machine_code)); });
  if (demand == Verdict::numbers) {
    ask(report, "M", value, verdict.M, at, [&] { return entries(mass_matrix(system, q, qdot, t)); });
    ask(report, "rhs", value, verdict.rhs, at, [&] { return entries(rhs(system, q, qdot, t)); });
    ask(report, "p", value, verdict.momenta, at, [&] { return entries(conjugate_momenta(system, q, qdot, t)); });
    ask(report, "T, V", value, verdict.energies, at, [&] {
      return std::vector<double>{kinetic_energy(system, q, qdot, t), potential_energy(system, q, t)};
    });
  }
  // Three members and two: whole packs and what is left over.
  constexpr int members = 5;
  if constexpr (ensembles && n != Dynamic) {
    const Matrix<double, n, members> Q = q.replicate(1, members), W = qdot.replicate(1, members);
    ask(report, "q̈ of an ensemble", demand, verdict.qddot, at, [&] {
      const auto all = accelerations(system, Q, W, t);
      if (!all.failures.empty()) std::rethrow_exception(all.failures.front().error);
      for (Eigen::Index k = 1; k < members; ++k)
        if (!all.qddot.col(k).isApprox(all.qddot.col(0), 1e-9) && all.qddot.allFinite())
          report.finding("members 0 and " + std::to_string(k) + " of an ensemble differ at " + at);
      return entries(all.qddot.col(4));
    });
  }
  if (demand == Verdict::an_error) {
    ask(report, "∂q̈/∂(q, q̇)", demand, {}, at, [&] { return entries(acceleration_jacobian(system, q, qdot, t).d_q); });
    return;
  }
  const auto J = [&] {
    const auto jacobian = acceleration_jacobian(system, q, qdot, t);
    std::vector<double> all;
    for (Eigen::Index j = 0; j < 2 * size; ++j)
      for (Eigen::Index i = 0; i < size; ++i) all.push_back(j < size ? jacobian.d_q(i, j) : jacobian.d_qdot(i, j - size));
    return all;
  };
  Known slopes;
  if (demand == Verdict::numbers) {
    circumstances.clear();
    // Over 1e-16, which leaves 17 digits; where it is not the same over a tenth, the derivative is none. The two together have no error of h².
    slopes.exact = detail::flat(acceleration_slopes(model, start.instant(), quad(1e-16)));
    Quads change = detail::flat(acceleration_slopes(model, start.instant(), quad(1e-17)));
    for (std::size_t i = 0; i < change.size(); ++i) change[i] -= slopes.exact[i];
    if (!(detail::largest(change) <= 1e-10 * detail::largest(slopes.exact))) circumstances.at_kink = true;
    for (std::size_t i = 0; i < change.size(); ++i) slopes.exact[i] += change[i] * 100 / 99;
    // What rounding was seen to do, a thousandfold, and 1e-11 for the way through duals and the solution of a linear system.
    for (int sample = 0; sample < 3; ++sample) {
      circumstances.rounding = 0x1p-52;
      Quads off = detail::flat(acceleration_slopes(model, start.instant(), quad(1e-17)));
      circumstances.rounding = 0.0;
      circumstances.dice.next();
      for (std::size_t i = 0; i < off.size(); ++i) off[i] -= slopes.exact[i];
      slopes.tolerance = std::max(slopes.tolerance, 1e-290 + 1e3 * detail::largest(off) +
                                                        1e-11 * (detail::largest(slopes.exact) + detail::largest(verdict.qddot.exact)));
    }
  }
  const bool can_tell = demand == Verdict::numbers && detail::all_finite(slopes.exact) && !circumstances.at_kink && !circumstances.out_of_range &&
                        slopes.tolerance < 1e-3 * (1e-300 + detail::largest(slopes.exact));
  const Verdict::Demand of_slopes = !can_tell ? Verdict::nothing : verdict.stands_on_a_root ? Verdict::numbers_or_an_error : Verdict::numbers;
  ask(report, "∂q̈/∂(q, q̇)", of_slopes, slopes, at, J);
}

}  // namespace fuzz
