#pragma once
// SPDX-License-Identifier: MIT
//
// Random scenes in motion, by four methods, against the reference.
//
// A run that says `completed` must be where the reference is, as far as its tolerance and the gain of the motion allow. A named
// failure is a finding too, where the reference has gone through without trouble: these motions are smooth and of order one.

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "doors.hpp"
#include "functors.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/effects/scene_motion.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/cvode_automatic.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/taylor.hpp"
#include "reference.hpp"

namespace fuzz {

/// A formula with its constants, which an event may change and each run begins with anew.
struct Living {
  Formula formula;
  Constants constants{}, at_start{};
  int n = 1;

  Term term(int coordinates) {
    n = coordinates;
    return {&formula, constants.data(), n};
  }
  void restore() { constants = at_start; }
};
inline Living living(const Formula& f, Dice& dice) {
  const Constants c = random_constants(f, dice, true);
  return {f, c, c};
}
/// A force of order one: c times something bounded.
inline Formula random_force(std::uint64_t seed, Inputs inputs, int depth = 2) {
  Grower g{Dice{seed}, Grammar::smooth};
  g.times_constant(g.bounded(depth, inputs));
  return g.f;
}

/// What is asked of all methods.
struct Asked {
  Start start;
  std::vector<double> z = {};
  double t_end = 1.0;
  double rtol = 1e-9;
  std::vector<double> stop_times = {};
  double blur = 0.0;  // of time: what events at large t may be off by
};

/// Largest error that is no finding, in units of rtol times gain: a thousand steps, each within its tolerance, and BDF's.
inline constexpr double allowed_units = 3e3;

template <class Sc, class Events, class Method>
void run_by(Report& report, const char* name, const Method& method, const Sc& scene, const Asked& asked, const Events& events, const Reference& reference,
            const std::function<void()>& prepare, double slack = 1.0) {
  using namespace qdot;
  constexpr int n = Sc::dof_at_compile_time;
  const auto size = static_cast<Eigen::Index>(asked.start.q.size());
  const State<n> start{asked.start.t, Eigen::Map<const Vector<double, n>>(asked.start.q.data(), size),
                       Eigen::Map<const Vector<double, n>>(asked.start.qdot.data(), size)};
  const std::string at = asked.start.in_words() + " to " + text(asked.t_end) + " by " + name;
  Options options{.rtol = asked.rtol, .atol = asked.rtol * 1e-3};
  options.max_wall_seconds = 60.0;
  options.stop_times = asked.stop_times;
  prepare();
  try {
    const auto run = simulate(scene, start, asked.t_end, method, options, events);
    if (!run.completed()) return report.finding("a run ends as " + std::string(qdot::name(run.outcome)) + ", '" + run.message + "', at " + at);
    const double size_of_y = detail::largest(reference.largest);
    const double unit = asked.rtol * (1e-3 + size_of_y) * reference.gain;
    Known known{reference.y, slack * allowed_units * unit + asked.blur * (1 + size_of_y) * reference.gain};
    agree(report, "y at the end", known, std::vector<double>(run.y.data(), run.y.data() + static_cast<Eigen::Index>(reference.y.size())), at);
  } catch (const std::exception& error) {
    if (std::string(error.what()).find("use Dop853") != std::string::npos) return void(++report.refused);  // by Taylor: not analytic at the start
    report.finding("a run throws '" + std::string(error.what()) + "' at " + at);
  }
}

/// By Dop853, Taylor, CvodeBdf and Automatic.
template <class Sc, class Events>
void by_four_methods(Report& report, const Sc& scene, const Asked& asked, const Events& events, const Reference& reference,
                     const std::function<void()>& prepare) {
  run_by(report, "Dop853", qdot::Dop853{}, scene, asked, events, reference, prepare);
  run_by(report, "Taylor", qdot::Taylor{}, scene, asked, events, reference, prepare);
  run_by(report, "CvodeBdf", qdot::CvodeBdf{}, scene, asked, events, reference, prepare, 10.0);
  run_by(report, "Automatic", qdot::Automatic{}, scene, asked, events, reference, prepare, 10.0);
}

inline constexpr double gain_limit = 1e4;  // beyond it double can't tell

/// Of order one, at rest now and then.
inline Start tame_start(Dice& dice, int n) {
  Start s;
  const int special = dice.below(6);
  for (int i = 0; i < n; ++i) s.q.push_back(special == 0 ? 0.0 : dice.between(-1.5, 1.5));
  for (int i = 0; i < n; ++i) s.qdot.push_back(special <= 1 ? 0.0 : dice.between(-1.5, 1.5));
  s.t = dice.one_in(3) ? 0.0 : dice.between(-2.0, 2.0);
  return s;
}
inline Quads packed(const Asked& asked) {
  Quads y(asked.start.q.begin(), asked.start.q.end());
  y.insert(y.end(), asked.start.qdot.begin(), asked.start.qdot.end());
  y.insert(y.end(), asked.z.begin(), asked.z.end());
  return y;
}

/// One event that kicks a velocity and gives a formula other constants: at a time, or where a coordinate passes a level.
struct Kick {
  bool by_time = true;
  double time = 0.0, level = 0.0, kick = 0.0;
  int watched = 0, kicked = 0;
  Living* changed = nullptr;
  Constants to{};
  bool* done = nullptr;

  std::string in_words() const {
    return "\n    at " + (by_time ? "t = " + text(time) : "q" + std::to_string(watched) + " = " + text(level)) + " v" +
           std::to_string(kicked) + " += " + text(kick) + " and " +
           fuzz::in_words(changed->formula, to.data(), static_cast<int>(changed->n));
  }
  void change() const {
    *done = true;
    if (changed != nullptr) changed->constants = to;
  }
  auto event() const {
    return qdot::event("kick", [*this](const auto& q, const auto&, const auto& t) {
             using S = ScalarOf<decltype(q)>;
             return by_time ? S(t - time) : S(q[watched] - level);
           })
        .action([*this]<int n>(qdot::State<n>& s) {
          if (*done) return;
          change();
          s.qdot[kicked] += kick;
        });
  }
  Happening happening(int n) const {
    Happening h{.g = [*this](quad, const Quads& y) { return y[static_cast<std::size_t>(watched)] - level; },
                .action = [*this, n](Quads& y) {
                  change();
                  y[static_cast<std::size_t>(n + kicked)] += kick;
                }};
    if (by_time) h.at = time;
    return h;
  }
};

/// A kick somewhere on the way of a motion.
inline Kick random_kick(Dice& dice, const Asked& asked, bool* done, std::vector<Living*> living, bool velocity_too = true) {
  Kick k;
  const int n = static_cast<int>(asked.start.q.size());
  k.by_time = dice.one_in(2);
  k.time = asked.start.t + dice.between(0.2, 0.8) * (asked.t_end - asked.start.t);
  k.watched = dice.below(n);
  k.level = asked.start.q[static_cast<std::size_t>(k.watched)] + dice.between(-0.5, 0.5);
  k.kicked = dice.below(n);
  k.kick = velocity_too && dice.one_in(2) ? dice.between(-1.0, 1.0) : 0.0;
  k.changed = living[static_cast<std::size_t>(dice.below(static_cast<int>(living.size())))];
  k.to = random_constants(k.changed->formula, dice, true);
  k.done = done;
  return k;
}

/// A vector of forces that interpret formulas.
template <int n>
struct Forces {
  std::vector<Term> each;
  auto operator()(const auto& q, const auto& v, const auto& t) const {
    using S = ScalarOf<decltype(q)>;
    qdot::Vector<S, n> Q(q.size());
    for (Eigen::Index i = 0; i < q.size(); ++i) Q[i] = each[static_cast<std::size_t>(i)].template of<S>(q, v, t);
    return Q;
  }
};
/// A point in the plane.
struct PointOf {
  Term x, y;
  auto operator()(const auto& q, const auto& t) const {
    using S = ScalarOf<decltype(q)>;
    return qdot::Vector<S, 2>(x.of<S>(q, q, t), y.of<S>(q, q, t));
  }
};

inline quad value_of(const Term& f, const Quads& q, const Quads& v, quad t) {
  return f.of<Hyper>(Hypers(q.begin(), q.end()), Hypers(v.begin(), v.end()), Hyper(t)).v;
}

/// The reference, if it is one to compare with.
inline bool worth_comparing(Report& report, const Reference& r) {
  if (r.arrived && r.gain < gain_limit) return true;
  ++report.undecided;
  return false;
}

/// q̈ and reactions of a scene at its start.
template <class Sc>
void check_scene(Report& report, const Sc& scene, const Model& model, const Asked& asked) {
  constexpr int n = Sc::dof_at_compile_time;
  const auto size = static_cast<Eigen::Index>(model.n);
  const qdot::Vector<double, n> q = Eigen::Map<const qdot::Vector<double, n>>(asked.start.q.data(), size),
                                v = Eigen::Map<const qdot::Vector<double, n>>(asked.start.qdot.data(), size);
  Instant at = asked.start.instant();
  at.z.assign(asked.z.begin(), asked.z.end());
  const Verdict verdict = verdict_on(model, at);
  if (verdict.demand != Verdict::numbers) {
    ++report.undecided;
    return;
  }
  const std::string words = asked.start.in_words() + " (scene)";
  qdot::EffectStates<Sc> z;
  for (std::size_t i = 0; i < asked.z.size(); ++i) z[static_cast<Eigen::Index>(i)] = asked.z[i];
  ask(report, "q̈", verdict.demand, verdict.qddot, words, [&] { return entries(acceleration(scene, q, v, asked.start.t, z)); });
  if constexpr (Sc::has_constraints)
    ask(report, "Jᵀλ", verdict.demand, verdict.reactions, words, [&] { return entries(reactions(scene, q, v, asked.start.t, z)); });
}

/// Viscous damping and forces of formulas whose constants an event changes, or those of T or V.
template <int n>
void captured_constants(Report& report, Dice dice) {
  const Inputs q{n}, everything{n, true, true, true};
  Living T = living(random_kinetic_energy(dice.next(), q, 1, Grammar::smooth), dice), V = living(random_potential(dice.next(), q, 2), dice);
  std::vector<Living> Q;
  for (int i = 0; i < n; ++i) Q.push_back(living(random_force(dice.next(), everything), dice));
  qdot::Vector<double, n> c;
  for (int i = 0; i < n; ++i) c[i] = dice.one_in(3) ? 0.0 : dice.between(0.0, 0.5);
  Asked asked{.start = tame_start(dice, n)};
  asked.t_end = asked.start.t + dice.between(1.0, 5.0);
  if (dice.one_in(3)) asked.stop_times = {asked.start.t + 0.5 * (asked.t_end - asked.start.t)};
  bool done = false;
  std::vector<Living*> all{&T, &V};
  for (Living& each : Q) all.insert(all.end(), 2, &each);
  const Kick kick = random_kick(dice, asked, &done, all);
  const auto prepare = [&] {
    done = false;
    for (Living* each : all) each->restore();
  };
  Forces<n> forces;
  for (Living& each : Q) forces.each.push_back(each.term(n));
  report.model = "T = " + in_words(T.formula, T.at_start.data(), n) + "\n    V = " + in_words(V.formula, V.at_start.data(), n);
  for (const Living& each : Q) report.model += "\n    Q = " + in_words(each.formula, each.at_start.data(), n);
  const Model model{.n = n, .T = {T.term(n)}, .V = {V.term(n)}, .force = [&](const Quads& x, const Quads& v, const Quads&, quad t) {
                      Quads force(n);
                      for (std::size_t i = 0; i < n; ++i) force[i] = value_of(forces.each[i], x, v, t) - quad(c[static_cast<Eigen::Index>(i)]) * v[i];
                      return force;
                    }};
  report.model += kick.in_words();
  const Happening happening = kick.happening(n);
  const Reference r = reference_motion(model, asked.start.t, packed(asked), asked.t_end, &happening, {}, prepare, dice);
  if (!worth_comparing(report, r)) return;
  const auto sc = qdot::scene(qdot::mechanical_system<n>(TOfState{T.term(n)}, OfPosition{V.term(n)}), qdot::generalized_force(forces),
                              qdot::viscous_damping(c));
  check_scene(report, sc, model, asked);
  by_four_methods(report, sc, asked, qdot::events(kick.event()), r, prepare);
}

}  // namespace fuzz
