#pragma once
// SPDX-License-Identifier: MIT
//
// Cases whose answers are known without a reference run: one motion in other units, forces that switch by place and time, plates on many supports.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "doors.hpp"
#include "four_methods.hpp"
#include "qdot/analysis/sensitivity.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/scene_at_state.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/cvode_automatic.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/taylor.hpp"
#include "qdot/mechanics/energy.hpp"

namespace fuzz {

/// Two coordinates on hardening springs with a coupling, in units of mass, length and time.
struct Units {
  double mass, length, time;
};
struct InUnits {
  Units u;
  double m, k, c, d;
  auto T(const auto& v) const { return 0.5 * u.mass * (v[0] * v[0] + m * (v[1] * v[1])); }
  auto V(const auto& q) const {
    using std::cos;
    const auto x = q[0] / u.length, y = q[1] / u.length;
    return u.mass * u.length * u.length / (u.time * u.time) * (0.5 * (x * x) + 0.5 * k * (y * y) + 0.25 * c * (x * x * x * x) - d * cos(x - y));
  }
};

/// y = [q/L; q̇ T/L] is the same function of t/T in all units.
inline void in_other_units(Report& report, Dice dice) {
  constexpr Units all[] = {{1e-26, 1e-10, 1e-13}, {1e30, 1e11, 3e7}, {1e-3, 1e-6, 1e-3}, {1e3, 1e4, 1e2}, {1e-15, 1e-9, 1e-9}, {1.0, 1e-12, 1.0}};
  const Units u = all[dice.below(6)];
  InUnits of{{1.0, 1.0, 1.0}, dice.between(0.3, 3.0), dice.between(0.2, 4.0), dice.between(0.0, 2.0), dice.between(0.0, 2.0)};
  const auto value = [&] { return dice.one_in(3) ? 0.0 : dice.between(-2.0, 2.0); };
  const double t_end = dice.between(1.0, 20.0), x[] = {value(), value(), value(), value()};
  report.model = "m " + text(of.m) + ", k " + text(of.k) + ", c " + text(of.c) + ", d " + text(of.d) + " from " + text(x[0]) + ", " + text(x[1]) +
                 ", " + text(x[2]) + ", " + text(x[3]) + " to " + text(t_end) + " in units of " + text(u.mass) + " kg, " + text(u.length) + " m, " + text(u.time) + " s";
  const auto run_in = [&](const Units& units, const auto& method, const qdot::Options& options) {
    of.u = units;
    const double speed = units.length / units.time;
    const qdot::State<2> start{0.0, {units.length * x[0], units.length * x[1]}, {speed * x[2], speed * x[3]}};
    auto run = qdot::simulate(qdot::mechanical_system<2>(of), start, units.time * t_end, method, options);
    for (int i = 0; i < 4; ++i) run.y[i] /= i < 2 ? units.length : speed;
    return run;
  };
  const auto exact = run_in({1.0, 1.0, 1.0}, qdot::Dop853{}, {.rtol = 1e-13});
  by_four_methods(report, [&](const char* name, const auto& method) {
    const auto ordinary = run_in({1.0, 1.0, 1.0}, method, {}), scaled = run_in(u, method, {});
    ++report.compared;
    const double usual = (ordinary.y - exact.y).norm(), off = (scaled.y - exact.y).norm(), size = 1.0 + exact.y.norm();
    if (scaled.completed() != ordinary.completed()) return report.finding(scaled.message + ", in units of one " + ordinary.message + " by " + name);
    if (!(off <= 100 * std::max(usual, 1e-8 * size))) report.finding("off by " + text(off) + ", in units of one by " + text(usual) + " by " + name);
  });
}

/// q̈ = a_j in the j-th of four stretches of q (V continuous), and b more from t₁ to t₂: all written with branches.
struct Switched {
  std::array<double, 3> at{};
  std::array<double, 4> a{};
  double b = 0.0, t_1 = 0.0, t_2 = 0.0;

  auto T(const auto& v) const { return 0.5 * (v[0] * v[0]); }
  template <class S>
  S V(const qdot::Vector<S, 1>& q, const S& t) const {
    S potential = -a[0] * q[0];
    for (std::size_t j = 0; j < 3; ++j)
      if (q[0] > at[j]) potential -= (a[j + 1] - a[j]) * (q[0] - at[j]);
    if (t > t_1 && t < t_2) potential -= b * q[0];
    return potential;
  }

  /// The end of parabola after parabola; false where a switch is nearly missed, or passed slowly.
  bool end(double q, double v, double t_end, double& q_end, double& v_end) const {
    double t = 0.0;
    for (int stretches = 0; t < t_end; ++stretches) {
      if (stretches == 100) return false;
      std::size_t j = 0;
      while (j < 3 && (q > at[j] || (q == at[j] && v > 0.0))) ++j;
      const bool pushes = t >= t_1 && t < t_2;
      const double f = a[j] + (pushes ? b : 0.0), next = t < t_1 ? t_1 : pushes ? t_2 : t_end;
      double h = std::min(next, t_end) - t;
      double place = std::numeric_limits<double>::quiet_NaN();
      for (const std::size_t side : {j, j - 1}) {  // at[j] above, at[j − 1] below
        if (side >= 3) continue;
        const double way = at[side] - q, inside = v * v + 2 * f * way;
        if (f != 0.0 && std::abs(inside) < 0.01 && way != 0.0) return false;  // turns near the switch, or passes it slowly
        if (inside < 0.0) continue;
        const double root = std::sqrt(inside);
        for (const double at_switch : {f == 0.0 ? way / v : (-v - root) / f, f == 0.0 ? way / v : (-v + root) / f})
          if (at_switch > 1e-9 && at_switch < h) h = at_switch, place = at[side];
      }
      if (std::isfinite(place) && std::abs(t + h - next) < 1e-4) return false;  // two switches at once
      q = std::isfinite(place) ? place : q + h * (v + 0.5 * f * h);
      v += f * h;
      t = std::isfinite(place) ? t + h : std::min(next, t_end);
    }
    for (const double each : at)
      if (std::abs(q - each) < 1e-4) return false;
    q_end = q, v_end = v;
    return true;
  }
};

inline void switched(Report& report, Dice dice) {
  Switched s;
  for (double& each : s.at) each = dice.between(-2.0, 2.0);
  std::sort(s.at.begin(), s.at.end());
  const bool by_time_alone = dice.one_in(2);
  for (double& each : s.a) each = by_time_alone && &each != &s.a[0] ? s.a[0] : dice.one_in(4) ? 0.0 : dice.between(-3.0, 3.0);
  const double t_end = dice.between(1.0, 6.0), lasts = std::exp(dice.between(std::log(1e-6), 0.0));
  s.t_1 = dice.between(0.1, t_end - 0.5), s.t_2 = std::min(s.t_1 + lasts, t_end - 0.1), s.b = dice.between(-1.0, 1.0) / (s.t_2 - s.t_1);
  const double q = dice.between(-2.5, 2.5), v = dice.one_in(3) ? 0.0 : dice.between(-3.0, 3.0);
  report.model = "q̈ = " + text(s.a[0]) + ", " + text(s.a[1]) + ", " + text(s.a[2]) + ", " + text(s.a[3]) + " about " + text(s.at[0]) + ", " + text(s.at[1]) +
                 ", " + text(s.at[2]) + "; " + text(s.b) + " from " + text(s.t_1) + " to " + text(s.t_2) + "; from " + text(q) + ", " + text(v) + " to " +
                 text(t_end);
  double q_end = 0.0, v_end = 0.0;
  if (!s.end(q, v, t_end, q_end, v_end)) return void(++report.undecided);
  const auto system = qdot::mechanical_system<1>(s);
  const qdot::State<1> start{0.0, qdot::Vector<double, 1>(q), qdot::Vector<double, 1>(v)};
  const auto compare = [&](const char* name, const auto& run, double q_right, double v_right, double allowed) {
    ++report.compared;
    if (!run.completed()) return report.finding(run.message + " by " + name);
    const double off = std::max(std::abs(run.y[0] - q_right), std::abs(run.y[1] - v_right));
    if (!(off <= allowed)) report.finding(text(run.y[0]) + ", " + text(run.y[1]) + " for " + text(q_right) + ", " + text(v_right) + " by " + name);
  };
  constexpr double switches = 2e-6;  // of errors of 1e-9 at each of some switches, which the motion stretches
  try {
    compare("Dop853", qdot::simulate(system, start, t_end, qdot::Dop853{}), q_end, v_end, switches);
    compare("CvodeBdf", qdot::simulate(system, start, t_end, qdot::CvodeBdf{}), q_end, v_end, 10 * switches);
    compare("Automatic", qdot::simulate(system, start, t_end, qdot::Automatic{}), q_end, v_end, 10 * switches);
    const qdot::State<1> end{t_end, qdot::Vector<double, 1>(q_end), qdot::Vector<double, 1>(v_end)};
    compare("Dop853 backward", qdot::simulate(system, end, 0.0, qdot::Dop853{}), q, v, 10 * switches);
    const auto by_start = qdot::sensitivities(system, start, t_end, qdot::Dop853{}, {.rtol = 1e-11});
    if (!by_start.completed()) return report.finding(by_start.message + " by sensitivities");
    constexpr double beside = 1e-5;
    for (int column = 0; column < 2; ++column) {
      double above[2], below[2];
      const double dq = column == 0 ? beside : 0.0, dv = beside - dq;
      const bool neighbours = s.end(q + dq, v + dv, t_end, above[0], above[1]) && s.end(q - dq, v - dv, t_end, below[0], below[1]);
      double above_2[2], below_2[2];
      if (!neighbours || !s.end(q + 2 * dq, v + 2 * dv, t_end, above_2[0], above_2[1]) || !s.end(q - 2 * dq, v - 2 * dv, t_end, below_2[0], below_2[1]))
        return void(++report.undecided);
      ++report.compared;
      for (int row = 0; row < 2; ++row) {
        const double slope = (above[row] - below[row]) / (2 * beside), wider = (above_2[row] - below_2[row]) / (4 * beside), got = by_start.Phi(row, column);
        if (!(std::abs(got - slope) <= 1e-5 * (1.0 + by_start.Phi.norm()) + std::abs(slope - wider)))
          report.finding("Phi(" + std::to_string(row) + ", " + std::to_string(column) + ") = " + text(got) + " for " + text(slope));
      }
    }
  } catch (const std::exception& error) {
    report.finding("a run throws '" + std::string(error.what()) + "'");
  }
}

/// A plate (z, α, β) on five legs at random places with a load somewhere: Gauss' principle of least constraint says what is right. The reactions do
/// no work on the accelerations, and no admissible motion takes work from them.
inline void supported(Report& report, Dice dice) {
  constexpr int legs = 5;
  std::array<double, legs> x{}, y{};
  const bool on_grid = dice.one_in(2);  // legs in line, and loads above one
  const auto place = [&] { return on_grid ? static_cast<double>(dice.below(5) - 2) : dice.between(-2.0, 2.0); };
  for (std::size_t i = 0; i < legs; ++i) x[i] = place(), y[i] = place();
  const double X = place(), Y = place(), W = dice.between(0.0, 100.0), m = dice.between(0.1, 10.0), I = dice.between(0.1, 10.0);
  report.model = "a plate of " + text(m) + " kg and " + text(I) + " kg m², " + text(W) + " N at (" + text(X) + ", " + text(Y) + "), on legs at";
  for (std::size_t i = 0; i < legs; ++i) report.model += " (" + text(x[i]) + ", " + text(y[i]) + ")";
  const auto leg = [&](std::size_t i) {
    return qdot::contact("leg " + std::to_string(i), [a = x[i], b = y[i]](const auto& q) { return q[0] + a * q[1] + b * q[2]; }, qdot::restitution(0.0));
  };
  const auto plate = qdot::mechanical_system<3>([m, I](const auto& v) { return 0.5 * (m * (v[0] * v[0]) + I * (v[1] * v[1] + v[2] * v[2])); },
                                                [=](const auto& q) { return 9.81 * m * q[0] + W * (q[0] + X * q[1] + Y * q[2]); });
  const auto whole = scene(plate, leg(0), leg(1), leg(2), leg(3), leg(4));
  const qdot::State<3> rest{0.0, qdot::Vector<double, 3>::Zero(), qdot::Vector<double, 3>::Zero()};
  try {
    const Eigen::Vector3d a = acceleration(whole, rest), R = reactions(whole, rest), M(m, I, I);
    ++report.compared;
    const double load = 9.81 * m + W * (1.0 + std::abs(X) + std::abs(Y)), least = 1e-9 * load;
    const auto along = [&](std::size_t i, const Eigen::Vector3d& b) { return b[0] + x[i] * b[1] + y[i] * b[2]; };
    if (!(std::abs(R.dot(a)) <= least * (1.0 + a.norm()))) report.finding("reactions work: " + text(R.dot(a)));
    const Eigen::Vector3d missing = M.cwiseProduct(a) - R + Eigen::Vector3d(9.81 * m + W, W * X, W * Y);
    if (!(missing.norm() <= least)) report.finding("M q̈ − Q and the reactions differ by " + text(missing.norm()));
    for (std::size_t i = 0; i < legs; ++i)
      if (!(along(i, a) >= -1e-8 * (1.0 + a.norm()))) report.finding("leg " + std::to_string(i) + " goes into the floor with " + text(along(i, a)));
    for (int k = 0; k < 50; ++k) {
      Eigen::Vector3d b(0.0, dice.between(-1.0, 1.0), dice.between(-1.0, 1.0));
      double lowest = along(0, b);
      for (std::size_t i = 1; i < legs; ++i) lowest = std::min(lowest, along(i, b));
      b[0] = -lowest;
      if (!(R.dot(b) >= -least)) report.finding("the reactions pull: " + text(R.dot(b)));
    }
    const auto run = qdot::simulate(whole, rest, 0.05, qdot::Dop853{});
    if (!run.completed()) report.finding(run.message);
    for (std::size_t i = 0; i < legs; ++i)
      if (along(i, run.y.head(3)) < -1e-9) report.finding("leg " + std::to_string(i) + " is under the floor by " + text(along(i, run.y.head(3))));
    if (a.norm() <= least && !(run.y.head(3).norm() <= 1e-9)) report.finding("what rests has moved by " + text(run.y.head(3).norm()));
  } catch (const std::exception& error) {
    report.finding("throws '" + std::string(error.what()) + "'");
  }
}

}  // namespace fuzz
