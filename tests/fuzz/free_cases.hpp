#pragma once
// SPDX-License-Identifier: MIT
//
// Cases of bare systems in motion: clocks that begin anywhere, pushes in time, floors, events that are to be counted.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "four_methods.hpp"
#include "motions.hpp"
#include "qdot/integrate/simulate_to_accuracy.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/symplectic.hpp"

namespace fuzz {

/// T(q̇) and V(q) from t₀ = 0, ±1.7e9 or ±1e12, by splitting and Gauss too, and with accuracy as a request.
template <int n>
void anytime(Report& report, Dice dice) {
  Living T = living(random_kinetic_energy(dice.next(), Inputs{n, false}, 1, Grammar::smooth), dice),
         V = living(random_potential(dice.next(), Inputs{n}, 2), dice);
  constexpr double starts[] = {0.0, 0.0, 1.7e9, -1.7e9, 1e12, -1e12};
  Asked asked{.start = tame_start(dice, n)};
  asked.start.t = starts[dice.below(6)];
  asked.t_end = asked.start.t + dice.between(1.0, 6.0);
  if (dice.one_in(2)) {
    const double middle = 0.5 * (asked.start.t + asked.t_end);
    asked.stop_times = {middle, middle + 0.001};
  }
  const double ulp = std::nextafter(std::abs(asked.start.t) + 10, std::numeric_limits<double>::infinity()) - (std::abs(asked.start.t) + 10);
  bool done = false;
  const std::vector<Living*> all{&V};
  Kick kick = random_kick(dice, asked, &done, all);
  const auto prepare = [&] {
    done = false;
    T.restore(), V.restore();
  };
  report.model = "T = " + in_words(T.formula, T.at_start.data(), n) + "\n    V = " + in_words(V.formula, V.at_start.data(), n);
  const Model model{.n = n, .T = {T.term(n)}, .V = {V.term(n)}};
  const auto duration = quad(asked.t_end) - quad(asked.start.t);
  const auto system = qdot::mechanical_system<n>(TOfVelocity{T.term(n)}, OfPosition{V.term(n)});
  report.model += kick.in_words();
  Happening happening = kick.happening(n);
  happening.at -= quad(asked.start.t);
  asked.blur = 8 * ulp;
  const Reference kicked = reference_motion(model, 0, packed(asked), duration, &happening, {}, prepare, dice);
  if (worth_comparing(report, kicked)) by_four_methods(report, system, asked, qdot::events(kick.event()), kicked, prepare);

  asked.blur = 0.0;
  const Reference r = reference_motion(model, 0, packed(asked), duration, nullptr, {}, prepare, dice);
  if (!worth_comparing(report, r)) return;
  const double whole = asked.t_end - asked.start.t;
  run_by(report, "Splitting", qdot::Splitting{.step = whole / 2000}, system, asked, qdot::EventList<>{}, r, prepare, 100.0);
  run_by(report, "Gauss", qdot::Gauss{.step = whole / 200, .stages = 4}, system, asked, qdot::EventList<>{}, r, prepare, 100.0);
  const qdot::State<n> start{asked.start.t, Eigen::Map<const qdot::Vector<double, n>>(asked.start.q.data()),
                             Eigen::Map<const qdot::Vector<double, n>>(asked.start.qdot.data())};
  const auto accurately = [&](const char* name, const auto& method) {
    const double accuracy = std::pow(10.0, dice.between(-11.0, -4.0));
    const std::string at = asked.start.in_words() + " to " + text(asked.t_end) + " by " + name + " with accuracy " + text(accuracy);
    try {
      const auto result = qdot::simulate_to_accuracy(system, start, asked.t_end, method, accuracy);
      if (!result.reached())
        return accuracy * 1e10 < r.gain * 1e1 || std::abs(asked.start.t) > 1e6
                   ? void(++report.undecided)
                   : report.finding("not reached: " + result.run.message + " at " + at);
      ++report.compared;
      for (std::size_t i = 0; i < r.y.size(); ++i) {
        const double off = static_cast<double>(magnitude(quad(result.run.y[static_cast<Eigen::Index>(i)]) - r.y[i])) / static_cast<double>(r.largest[i]);
        if (off > 2 * accuracy)
          return report.finding("the accuracy reached is " + text(off) + " in y[" + std::to_string(i) + "], estimated " +
                                text(result.error_estimate) + ", at " + at);
      }
    } catch (const std::exception& error) {
      report.finding("simulate_to_accuracy throws '" + std::string(error.what()) + "' at " + at);
    }
  };
  accurately("Dop853", qdot::Dop853{});
  accurately("Taylor", qdot::Taylor{});
}

/// V(q, t) = ½ k q² − A q e^(−½((t − c)/w)²), at rest or moving.
struct Pushed {
  double k, A, c, w;
  template <class S>
  S V(const S& q, const S& t) const {
    using std::exp;
    const S x = (t - c) / w;
    return 0.5 * k * (q * q) - A * q * exp(-0.5 * (x * x));
  }
};
inline Hyper operator-(const Hyper& x, double y) { return x - Hyper(y); }
inline Hyper operator/(const Hyper& x, double y) { return x / Hyper(y); }
inline Hyper operator*(double y, const Hyper& x) { return Hyper(y) * x; }

inline void pushed(Report& report, Dice dice) {
  const double w = std::exp(dice.between(std::log(1e-3), std::log(1.0)));
  const Pushed push{dice.between(0.3, 2.0), dice.between(0.5, 2.0) / (w * 2.5), dice.between(5.0, 12.0), w};
  Asked asked{.start = {{dice.one_in(2) ? 0.0 : dice.between(-1.0, 1.0)}, {0.0}, 0.0}};
  asked.t_end = push.c + dice.between(1.0, 8.0);
  report.model = "V = 0.5 * " + text(push.k) + " * q0^2 - " + text(push.A) + " * q0 * exp(-0.5 ((t - " + text(push.c) + ") / " + text(w) + ")^2)";
  const Model model{.n = 1,
                    .T = {[](const Hypers&, const Hypers& v, const Hyper&) { return 0.5 * (v[0] * v[0]); }},
                    .V = {[=](const Hypers& q, const Hypers&, const Hyper& t) { return push.V<Hyper>(q[0], t); }}};
  const auto none = [] {};
  std::vector<quad> breaks;
  for (int k = -12; k <= 12; k += 3)
    if (push.c + k * w < asked.t_end && push.c + k * w > 0) breaks.push_back(push.c + k * w);
  const Reference r = reference_motion(model, 0, packed(asked), asked.t_end, nullptr, breaks, none, dice);
  if (!worth_comparing(report, r)) return;
  const auto system = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * (v[0] * v[0]); },
                                                 [=](const auto& q, const auto& t) { return push.V<ScalarOf<decltype(q)>>(q[0], t); });
  by_four_methods(report, system, asked, qdot::EventList<>{}, r, none);
}

/// A ball on a floor that a user's own event throws back: the closed form before its bounces accumulate, zeno behind.
inline void bouncing(Report& report, Dice dice) {
  const double e = std::vector<double>{0.3, 0.5, 0.7, 0.9, 1.0}[static_cast<std::size_t>(dice.below(5))], g = dice.between(1.0, 10.0),
               height = dice.between(0.2, 3.0),
               speed = dice.between(-1.0, 1.0), up = dice.one_in(2) ? 0.0 : dice.between(-1.0, 2.0);
  const double first = (up + std::sqrt(up * up + 2 * g * height)) / g, v = g * first - up;  // when it strikes, and how fast
  const double all = e < 1 ? first + 2 * v * e / (g * (1 - e)) : std::numeric_limits<double>::infinity();
  const bool beyond = e < 1 && dice.one_in(2);
  const double t_end = beyond ? all + dice.between(0.1, 5.0) : e < 1 ? first + dice.between(0.1, 0.9) * (all - first) : dice.between(1.0, 10.0);
  report.model = "a ball of m = 1, g = " + text(g) + " from " + text(height) + " with " + text(up) + ", restitution " + text(e) + ", to " + text(t_end);
  double t = first, leaves = v * e;
  while (t + 2 * leaves / g < t_end && leaves > 1e-9) t += 2 * leaves / g, leaves *= e;
  const double into = t_end - t, y = t_end < first ? height + up * t_end - 0.5 * g * t_end * t_end : leaves * into - 0.5 * g * into * into;
  const auto system = qdot::mechanical_system<2>([](const auto& w) { return 0.5 * (w[0] * w[0] + w[1] * w[1]); }, [g](const auto& q) { return g * q[1]; });
  const auto floor = qdot::event("floor", [](const auto& q) { return q[1]; }).falling().action([e](qdot::State<2>& s) { s.qdot[1] = -e * s.qdot[1]; });
  by_four_methods(report, [&](const char* name, const auto& method) {
    const auto run = qdot::simulate(system, qdot::State<2>{0.0, {0.0, height}, {speed, up}}, t_end, method, {}, qdot::events(floor));
    ++report.compared;
    if (run.y[1] < -1e-6)
      return report.finding(std::string("the ball is under the floor, y = ") + text(run.y[1]) + ", with " +
                            std::string(qdot::name(run.outcome)) + " by " + name);
    if (beyond && run.completed()) return report.finding(std::string("infinitely many bounces are completed by ") + name);
    if (beyond && run.outcome != qdot::Outcome::zeno)
      return report.finding("a run ends as " + std::string(qdot::name(run.outcome)) + " by " + name);
    if (!beyond && !run.completed()) return report.finding("a run ends as " + std::string(qdot::name(run.outcome)) + ", '" + run.message + "' by " + name);
    // A bounce's own error, and what the many before it have added to the time.
    if (!beyond && std::abs(run.y[1] - y) > 1e-5 * (1 + height)) return report.finding("y = " + text(run.y[1]) + ", exact " + text(y) + " by " + name);
    if (!beyond && std::abs(run.y[0] - speed * t_end) > 1e-8 * (1 + t_end))
      return report.finding("x = " + text(run.y[0]) + ", exact " + text(speed * t_end) + " by " + name);
  });
}

/// How often sin(ω t + φ) and sin(ω q + φ) pass zero along an oscillation q = A cos t.
inline void counted(Report& report, Dice dice) {
  const double omega = std::exp(dice.between(0.0, std::log(300.0))), phase = dice.between(0.1, 3.0), A = dice.between(0.5, 2.0),
               t_end = dice.between(5.0, 30.0);
  const bool by_time = dice.one_in(2);
  report.model = std::string("q = ") + text(A) + " cos t, zeros of sin(" + text(omega) + (by_time ? " t + " : " q + ") + text(phase) + ") to " + text(t_end);
  // Between the extrema of the argument it passes each multiple of π once.
  const auto argument = [&](double t) { return by_time ? omega * t + phase : omega * A * std::cos(t) + phase; };
  long exact = 0;
  double low = 0.0;
  bool doubtful = false;
  while (low < t_end) {
    const double high = std::min(t_end, std::numbers::pi * (std::floor(low / std::numbers::pi + 1e-9) + 1));
    const double a = argument(low) / std::numbers::pi, b = argument(high) / std::numbers::pi;
    exact += std::labs(static_cast<long>(std::floor(a)) - static_cast<long>(std::floor(b)));
    doubtful = doubtful || std::abs(b - std::round(b)) < 1e-3;  // grazing
    low = high;
  }
  if (doubtful) return void(++report.undecided);
  const auto system = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * (v[0] * v[0]); }, [](const auto& q) { return 0.5 * (q[0] * q[0]); });
  const auto zero = qdot::event("zero", [=](const auto& q, const auto&, const auto& t) {
    using std::sin;
    using S = ScalarOf<decltype(q)>;
    return by_time ? S(sin(omega * t + phase)) : S(sin(omega * q[0] + phase));
  });
  by_four_methods(report, [&](const char* name, const auto& method) {
    const auto run = qdot::simulate(system, qdot::State<1>{0.0, qdot::Vector<double, 1>(A), qdot::Vector<double, 1>(0.0)}, t_end, method,
                                    {}, qdot::events(zero));
    ++report.compared;
    if (run.completed() && static_cast<long>(run.events.size()) != exact)
      report.finding(std::to_string(run.events.size()) + " events of " + std::to_string(exact) + " by " + name);
  });
}

}  // namespace fuzz
