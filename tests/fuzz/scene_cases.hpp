#pragma once
// SPDX-License-Identifier: MIT
//
// Cases of scenes: springs and drag, constraints, drives and controllers, each with an event on its way.

#include <cstddef>
#include <string>
#include <vector>

#include "motions.hpp"

namespace fuzz {

/// A point's place, Jacobian and velocity in quadruple precision.
struct PointMotion {
  Quads Jx, Jy;
  quad x, y, vx, vy;
};
inline PointMotion motion_of_point(const PointOf& point, const Quads& q, const Quads& v, quad t) {
  const std::size_t n = q.size();
  const Instant at{q, v, t};
  Quads none(2 * n + 1, 0), motion = none;
  for (std::size_t i = 0; i < n; ++i) motion[i] = v[i];
  motion[2 * n] = 1;
  PointMotion m{Quads(n), Quads(n), 0, 0, 0, 0};
  for (std::size_t i = 0; i < n; ++i) {
    Quads unit = none;
    unit[i] = 1;
    m.Jx[i] = along(point.x, at, unit, none).a;
    m.Jy[i] = along(point.y, at, unit, none).a;
  }
  const Hyper x = along(point.x, at, motion, none), y = along(point.y, at, motion, none);
  return {m.Jx, m.Jy, x.v, y.v, x.a, y.a};
}

/// A spring-damper between a point and the wall, drag on another point, a Rayleigh function; V(q, t).
template <int n>
void springs_and_drag(Report& report, Dice dice) {
  const Inputs q{n}, qt{n, true, false, true}, qv{n, true, true};
  Living T = living(random_kinetic_energy(dice.next(), Inputs{n, false}, 1, Grammar::smooth), dice), V = living(random_potential(dice.next(), qt, 2), dice);
  Living x1 = living(random_force(dice.next(), q, 1), dice), y1 = living(random_force(dice.next(), q, 1), dice),
         x2 = living(random_force(dice.next(), qt, 1), dice), y2 = living(random_force(dice.next(), qt, 1), dice),
         R = living(random_formula(dice.next(), qv, 1, Grammar::smooth), dice);
  Grower g{Dice{dice.next()}, Grammar::smooth};  // R = c (something)², which takes energy out more often than not
  g.times_constant(g.add(Op::square, g.grow(1, Inputs{n, false, true})), Kind::fraction);
  R = living(g.f, dice);
  const double k = dice.between(0.0, 5.0), rest = dice.between(0.0, 2.0), c = dice.one_in(3) ? 0.0 : dice.between(0.0, 1.0),
               b = dice.one_in(4) ? 0.0 : dice.between(0.0, 0.5);
  Asked asked{.start = tame_start(dice, n)};
  asked.t_end = asked.start.t + dice.between(1.0, 4.0);
  bool done = false;
  const std::vector<Living*> all{&T, &V, &x1, &y1, &x2, &y2, &R};
  const Kick kick = random_kick(dice, asked, &done, all);
  const auto prepare = [&] {
    done = false;
    for (Living* each : all) each->restore();
  };
  const PointOf hung{x1.term(n), y1.term(n)}, dragged{x2.term(n), y2.term(n)};
  const Eigen::Vector2d wall(4.0, -3.5);
  const Function x = hung.x, y = hung.y;
  report.model = "T = " + in_words(T.formula, T.at_start.data(), n) + "\n    V = " + in_words(V.formula, V.at_start.data(), n) + "\n    R = " +
                 in_words(R.formula, R.at_start.data(), n) + "\n    spring " + text(k) + ", " + text(rest) + ", " + text(c) + " at " +
                 in_words(x1.formula, x1.at_start.data(), n) +
                 ", " + in_words(y1.formula, y1.at_start.data(), n) + "\n    drag " + text(b) + " at " + in_words(x2.formula, x2.at_start.data(), n) + ", " +
                 in_words(y2.formula, y2.at_start.data(), n);
  Model model{.n = n, .T = {T.term(n)}, .V = {V.term(n)}, .rayleigh = {R.term(n)}};
  model.V.push_back([=](const Hypers& at, const Hypers& v, const Hyper& t) {
    const Hyper dx = x(at, v, t) - Hyper(4.0), dy = y(at, v, t) - Hyper(-3.5), stretch = sqrt(dx * dx + dy * dy) - Hyper(rest);
    return Hyper(0.5) * Hyper(k) * stretch * stretch;
  });
  model.force = [&](const Quads& at, const Quads& v, const Quads&, quad t) {
    const PointMotion p = motion_of_point(hung, at, v, t), d = motion_of_point(dragged, at, v, t);
    const quad dx = p.x - 4, dy = p.y + quad(3.5), length = sqrtq(dx * dx + dy * dy), rate = (dx * p.vx + dy * p.vy) / length;
    const quad speed = sqrtq(d.vx * d.vx + d.vy * d.vy);
    Quads Q(n);
    for (std::size_t i = 0; i < n; ++i)
      Q[i] = -quad(c) * rate * (dx * p.Jx[i] + dy * p.Jy[i]) / length - quad(b) * speed * (d.vx * d.Jx[i] + d.vy * d.Jy[i]);
    return Q;
  };
  report.model += kick.in_words();
  const Happening happening = kick.happening(n);
  const Reference r = reference_motion(model, asked.start.t, packed(asked), asked.t_end, &happening, {}, prepare, dice);
  if (!worth_comparing(report, r)) return;
  const auto sc = qdot::scene(qdot::mechanical_system<n>(TOfVelocity{T.term(n)}, OfPositionAndTime{V.term(n)}), qdot::spring_damper(hung, wall, k, rest, c),
                              qdot::quadratic_drag(dragged, b), qdot::rayleigh(TOfStateAndTime{R.term(n)}));
  check_scene(report, sc, model, asked);
  by_four_methods(report, sc, asked, qdot::events(kick.event()), r, prepare);
}

/// A holonomic constraint that moves and a velocity constraint, from a start that meets both.
template <int n>
void constrained(Report& report, Dice dice) {
  const Inputs q{n}, qt{n, true, false, true};
  Living T = living(random_kinetic_energy(dice.next(), q, 1, Grammar::smooth), dice), V = living(random_potential(dice.next(), q, 1), dice);
  Living phi = living(random_potential(dice.next(), qt, 1), dice), roll = living(random_rolling(dice.next(), qt, 1), dice);
  Asked asked{.start = tame_start(dice, n)};
  asked.t_end = asked.start.t + dice.between(0.5, 2.0);
  bool done = false;
  const std::vector<Living*> all{&T, &V};
  const Kick kick = random_kick(dice, asked, &done, all, false);
  const auto prepare = [&] {
    done = false;
    for (Living* each : all) each->restore();
  };
  const Term f = phi.term(n), a = roll.term(n);
  Instant at = asked.start.instant();
  const auto level = static_cast<double>(value_of(f, at.q, at.qdot, at.t));
  Model model{.n = n,
              .T = {T.term(n)},
              .V = {V.term(n)},
              .holonomic = {[=](const Hypers& x, const Hypers& v, const Hyper& t) { return f.of<Hyper>(x, v, t) - Hyper(level); }},
              .nonholonomic = {a}};
  // The nearest velocities that the constraints allow.
  for (int k = 0; k < 2; ++k) {
    const Equations e = equations_of(model, at);
    Quads none(2 * n + 1, 0), motion = none;
    for (std::size_t i = 0; i < n; ++i) motion[i] = at.qdot[i];
    motion[2 * n] = 1;
    const Quads residual{-along(model.holonomic[0], at, motion, none).a, -along(model.nonholonomic[0], at, none, none).v};
    std::vector<Quads> A(2, Quads(2, 0));
    for (std::size_t r = 0; r < 2; ++r)
      for (std::size_t s = 0; s < 2; ++s)
        for (std::size_t i = 0; i < n; ++i) A[r][s] += e.J[r][i] * e.J[s][i];
    quad least = 0;
    const Quads mu = solved(A, residual, least);
    if (!(least > quad(1e-3))) return void(++report.undecided);
    for (std::size_t i = 0; i < n; ++i) {
      at.qdot[i] += e.J[0][i] * mu[0] + e.J[1][i] * mu[1];
      asked.start.qdot[i] = static_cast<double>(at.qdot[i]);
    }
    at = asked.start.instant();
  }
  report.model = "T = " + in_words(T.formula, T.at_start.data(), n) + "\n    V = " + in_words(V.formula, V.at_start.data(), n) + "\n    phi = " +
                 in_words(phi.formula, phi.at_start.data(), n) + " - " + text(level) + "\n    rolling " + in_words(roll.formula, roll.at_start.data(), n);
  report.model += kick.in_words();
  const Happening happening = kick.happening(n);
  const Reference r = reference_motion(model, asked.start.t, packed(asked), asked.t_end, &happening, {}, prepare, dice);
  if (!worth_comparing(report, r)) return;
  const auto sc = qdot::scene(
      qdot::mechanical_system<n>(TOfState{T.term(n)}, OfPosition{V.term(n)}),
      qdot::holonomic("phi", [=](const auto& x, const auto& t) { return f.template of<ScalarOf<decltype(x)>>(x, x, t) - level; }),
      qdot::nonholonomic("rolling",
                         [=](const auto& x, const auto& v, const auto& t) { return a.template of<ScalarOf<decltype(x)>>(x, v, t); }));
  check_scene(report, sc, model, asked);
  by_four_methods(report, sc, asked, qdot::events(kick.event()), r, prepare);
}

/// A coordinate that follows s(t), and a force F(t) at a point; two or three coordinates, known at run time.
inline void driven(Report& report, Dice dice) {
  const int n = 2 + dice.below(2);
  const auto count = static_cast<std::size_t>(n);
  const Inputs q{n}, t_only{n, false, false, true};
  Living T = living(random_kinetic_energy(dice.next(), q, 1, Grammar::smooth), dice), V = living(random_potential(dice.next(), q, 1), dice);
  Living x1 = living(random_force(dice.next(), q, 1), dice), y1 = living(random_force(dice.next(), q, 1), dice),
         s = living(random_force(dice.next(), t_only, 1), dice), Fx = living(random_force(dice.next(), t_only, 1), dice),
         Fy = living(random_force(dice.next(), t_only, 1), dice);
  const int k = dice.below(n);
  Asked asked{.start = tame_start(dice, n)};
  asked.t_end = asked.start.t + dice.between(0.5, 3.0);
  const Term drive = s.term(n), fx = Fx.term(n), fy = Fy.term(n);
  const Function follows = drive;
  {
    Instant at = asked.start.instant();
    Quads none(2 * count + 1, 0), time = none;
    time[2 * count] = 1;
    const Hyper now = along(follows, at, time, none);
    asked.start.q[static_cast<std::size_t>(k)] = static_cast<double>(now.v);
    asked.start.qdot[static_cast<std::size_t>(k)] = static_cast<double>(now.a);
  }
  bool done = false;
  const std::vector<Living*> all{&T, &V, &x1, &y1, &Fx, &Fy};
  const Kick kick = random_kick(dice, asked, &done, all, false);
  const auto prepare = [&] {
    done = false;
    for (Living* each : all) each->restore();
  };
  const PointOf point{x1.term(n), y1.term(n)};
  report.model = "T = " + in_words(T.formula, T.at_start.data(), n) + "\n    V = " + in_words(V.formula, V.at_start.data(), n) + "\n    q" +
                 std::to_string(k) + " = " + in_words(s.formula, s.at_start.data(), n) + "\n    point " +
                 in_words(x1.formula, x1.at_start.data(), n) + ", " + in_words(y1.formula, y1.at_start.data(), n);
  Model model{.n = n, .T = {T.term(n)}, .V = {V.term(n)}};
  model.holonomic.push_back([=](const Hypers& x, const Hypers& v, const Hyper& t) { return x[static_cast<std::size_t>(k)] - follows(x, v, t); });
  model.force = [&](const Quads& x, const Quads& v, const Quads&, quad t) {
    const PointMotion p = motion_of_point(point, x, v, t);
    const quad X = value_of(fx, x, v, t), Y = value_of(fy, x, v, t);
    Quads Q(count);
    for (std::size_t i = 0; i < count; ++i) Q[i] = p.Jx[i] * X + p.Jy[i] * Y;
    return Q;
  };
  report.model += kick.in_words();
  const Happening happening = kick.happening(n);
  const Reference r = reference_motion(model, asked.start.t, packed(asked), asked.t_end, &happening, {}, prepare, dice);
  if (!worth_comparing(report, r)) return;
  const auto of_time = [](const Term& f, const auto& t) {
    using S = std::remove_cvref_t<decltype(t)>;
    const std::vector<S> none(static_cast<std::size_t>(f.n), S(0.0));
    return f.template of<S>(none, none, t);
  };
  const auto sc = qdot::scene(qdot::mechanical_system(n, TOfState{T.term(n)}, OfPosition{V.term(n)}),
                              qdot::prescribed("drive", k, [=](const auto& t) { return of_time(drive, t); }),
                              qdot::force_at_point(point, [=](const auto& t) { return qdot::vector(of_time(fx, t), of_time(fy, t)); }));
  check_scene(report, sc, model, asked);
  by_four_methods(report, sc, asked, qdot::events(kick.event()), r, prepare);
}

/// A controller with a state of its own.
inline void controlled(Report& report, Dice dice) {
  constexpr int n = 1, both = 2;  // the controller's formulas take (q, z) for coordinates and (q̇, 0) for velocities
  Living T = living(random_kinetic_energy(dice.next(), Inputs{n}, 2, Grammar::smooth), dice), V = living(random_potential(dice.next(), Inputs{n}, 2), dice);
  Living Q = living(random_force(dice.next(), Inputs{both, true, true, true}), dice),
         rate = living(random_force(dice.next(), Inputs{both, true, true, true}), dice);
  Asked asked{.start = tame_start(dice, n), .z = {dice.between(-1.0, 1.0)}};
  asked.t_end = asked.start.t + dice.between(1.0, 5.0);
  bool done = false;
  const std::vector<Living*> all{&T, &V, &Q, &rate};
  const Kick kick = random_kick(dice, asked, &done, all);
  const auto prepare = [&] {
    done = false;
    for (Living* each : all) each->restore();
  };
  const Term force = Q.term(both), zdot = rate.term(both);
  report.model = "T = " + in_words(T.formula, T.at_start.data(), n) + "\n    V = " + in_words(V.formula, V.at_start.data(), n) + "\n    Q = " +
                 in_words(Q.formula, Q.at_start.data(), both) + "\n    zdot = " + in_words(rate.formula, rate.at_start.data(), both);
  Model model{.n = n, .T = {T.term(n)}, .V = {V.term(n)}};
  const auto of = [](const Term& f, const Quads& q, const Quads& v, const Quads& z, quad t) { return value_of(f, Quads{q[0], z[0]}, Quads{v[0], 0}, t); };
  model.force = [&](const Quads& q, const Quads& v, const Quads& z, quad t) { return Quads{of(force, q, v, z, t)}; };
  model.state_rate = [&](const Quads& q, const Quads& v, const Quads& z, quad t) { return Quads{of(zdot, q, v, z, t)}; };
  report.model += kick.in_words();
  const Happening happening = kick.happening(n);
  const Reference r = reference_motion(model, asked.start.t, packed(asked), asked.t_end, &happening, {}, prepare, dice);
  if (!worth_comparing(report, r)) return;
  const auto functor = [](const Term& f) {
    return [f](const auto& q, const auto& v, const auto& z, const auto& t) {
      using S = ScalarOf<decltype(q)>;
      const std::array<S, 2> x{q[0], z[0]}, w{v[0], S(0.0)};
      return qdot::Vector<S, 1>(f.template of<S>(x, w, t));
    };
  };
  const auto sc = qdot::scene(qdot::mechanical_system<n>(TOfState{T.term(n)}, OfPosition{V.term(n)}),
                              qdot::controller(functor(force), functor(zdot), qdot::Vector<double, 1>(asked.z[0])));
  check_scene(report, sc, model, asked);
  by_four_methods(report, sc, asked, qdot::events(kick.event()), r, prepare);
}

}  // namespace fuzz
