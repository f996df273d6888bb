#pragma once
// SPDX-License-Identifier: MIT
//
// Cases of functors: random energies and places, each through every door that takes it, at several states.

#include <cstddef>

#include "doors.hpp"
#include "functors.hpp"

namespace fuzz {

inline constexpr int states_per_case = 3;

/// Energies that interpret a formula; n coordinates, or up to five where they are known at run time only.
template <int n, Arguments arguments>
void interpreted_energies(Report& report, Dice dice) {
  constexpr int largest = 5;
  const int size = n == qdot::Dynamic ? 1 + dice.below(largest) : n;
  const Inputs positions = inputs_of(size, arguments);
  const Formula T = random_kinetic_energy(dice.next(), positions, size < 3 ? 2 : 1);
  const Formula V = random_formula(dice.next(), {size, true, false, positions.t}, 3);
  const Constants of_T = random_constants(T, dice), of_V = random_constants(V, dice);
  const Term t{&T, of_T.data(), size}, v{&V, of_V.data(), size};
  report.model = "T = " + in_words(T, of_T.data(), size) + "\n    V = " + in_words(V, of_V.data(), size);
  const Model model{.n = size, .T = {t}, .V = {v}};
  const auto system = [&] {
    const auto made = [&](auto kinetic, auto potential) {
      if constexpr (n == qdot::Dynamic) return qdot::mechanical_system(size, kinetic, potential);
      else return qdot::mechanical_system<n>(kinetic, potential);
    };
    if constexpr (arguments == Arguments::velocity) return made(TOfVelocity{t}, OfPosition{v});
    else if constexpr (arguments == Arguments::state) return made(TOfState{t}, OfPosition{v});
    else return made(TOfStateAndTime{t}, OfPositionAndTime{v});
  }();
  for (int k = 0; k < states_per_case; ++k) {
    const Start start = random_start(dice, size);
    check_door(report, n == qdot::Dynamic ? "T and V, n at run time" : "T and V in loops", system, model, verdict_on(model, start.instant()), start);
  }
}

/// Energies that are types of their own: as an expression, unrolled, and in a loop.
template <std::uint64_t seed, int n, Arguments arguments>
void written_energies(Report& report, Dice dice) {
  Written<seed, n, arguments, Style::nested> nested;
  using W = decltype(nested);
  const Constants of_T = random_constants(W::formula_T, dice), of_V = random_constants(W::formula_V, dice);
  Written<seed, n, arguments, Style::unrolled> unrolled;
  Written<seed, n, arguments, Style::looped> looped;
  const auto set = [&](auto& energies) {
    std::copy_n(of_T.begin(), W::formula_T.constants, energies.constants_T.begin());
    std::copy_n(of_V.begin(), W::formula_V.constants, energies.constants_V.begin());
  };
  set(nested), set(unrolled), set(looped);
  report.model = "T = " + in_words(W::formula_T, of_T.data(), n) + "\n    V = " + in_words(W::formula_V, of_V.data(), n);
  const Model model{.n = n, .T = {Term{&W::formula_T, of_T.data(), n}}, .V = {Term{&W::formula_V, of_V.data(), n}}};
  const auto as_expression = qdot::mechanical_system<n>(nested), as_list = qdot::mechanical_system<n>(unrolled), as_loop = qdot::mechanical_system<n>(looped);
  for (int k = 0; k < states_per_case; ++k) {
    const Start start = random_start(dice, n);
    const Verdict verdict = verdict_on(model, start.instant());
    check_door(report, "T and V as expressions", as_expression, model, verdict, start);
    check_door(report, "T and V unrolled", as_list, model, verdict, start);
    check_door(report, "T and V in loops of their own", as_loop, model, verdict, start);
  }
}

/// Places of bodies, with a further term in T that keeps M regular.
template <std::uint64_t seed, int n, bool moved>
void written_places(Report& report, Dice dice) {
  using P = WrittenPlaces<seed, n, moved, Style::nested>;
  P nested;
  WrittenPlaces<seed, n, moved, Style::looped> looped;
  nested.constants = {random_constants(P::template formula<0>, dice), random_constants(P::template formula<1>, dice),
                      random_constants(P::template formula<2>, dice), random_constants(P::template formula<3>, dice),
                      random_constants(P::template formula<4>, dice)};
  nested.m1 = dice.one_in(4) ? 0.0 : dice.between(0.1, 3.0);
  nested.m2 = dice.one_in(4) ? nested.m1 : dice.between(0.1, 3.0);
  looped.constants = nested.constants;
  looped.m1 = nested.m1, looped.m2 = nested.m2;
  const double flywheel = dice.between(0.1, 2.0), gx = dice.between(-3.0, 3.0), gy = dice.one_in(3) ? 0.0 : -9.81;
  const auto extra = [flywheel](const auto& v) { return 0.5 * flywheel * v.squaredNorm(); };
  const auto place = [&](auto formula, std::size_t k) { return Function(Term{formula, nested.constants[k].data(), n}); };
  const Function x1 = place(&P::template formula<0>, 0), y1 = place(&P::template formula<1>, 1), x2 = place(&P::template formula<2>, 2),
                 y2 = place(&P::template formula<3>, 3), x3 = place(&P::template formula<1>, 1), y3 = place(&P::template formula<2>, 2),
                 angle = place(&P::template formula<4>, 4);
  const auto in_words_of = [&](auto formula, std::size_t k) { return in_words(formula, nested.constants[k].data(), n); };
  report.model = "m1 = " + text(nested.m1) + " at " + in_words_of(P::template formula<0>, 0) + ", " +
                 in_words_of(P::template formula<1>, 1) + "\n    m2 = " + text(nested.m2) + " at " +
                 in_words_of(P::template formula<2>, 2) + ", " + in_words_of(P::template formula<3>, 3) + "\n    m3 = " + text(nested.m3) +
                 " at the second and third of these, I = " + text(nested.inertia) + " turned by " + in_words_of(P::template formula<4>, 4);
  Model model{.n = n, .masses = {{nested.m1, {x1, y1}}, {nested.m2, {x2, y2}}, {nested.m3, {x3, y3}}, {nested.inertia, {angle}}}};
  model.T.push_back([flywheel](const Hypers&, const Hypers& v, const Hyper&) {
    Hyper sum;
    for (const Hyper& u : v) sum = sum + u * u;
    return 0.5 * Hyper(flywheel) * sum;
  });
  model.V.push_back([=, m1 = nested.m1, m2 = nested.m2, m3 = nested.m3](const Hypers& q, const Hypers& v, const Hyper& t) {
    return -(Hyper(gx) * (m1 * x1(q, v, t) + m2 * x2(q, v, t) + m3 * x3(q, v, t)) + Hyper(gy) * (m1 * y1(q, v, t) + m2 * y2(q, v, t) + m3 * y3(q, v, t)));
  });
  const auto gravity = qdot::uniform_gravity(gx, gy);
  const auto placed = qdot::kinematic_system<n>(nested, gravity, extra), in_loops = qdot::kinematic_system<n>(looped, gravity, extra);
  for (int k = 0; k < states_per_case; ++k) {
    const Start start = random_start(dice, n);
    const Verdict verdict = verdict_on(model, start.instant());
    check_door<false>(report, "places", placed, model, verdict, start);
    check_door<false>(report, "places in loops", in_loops, model, verdict, start);
  }
}

}  // namespace fuzz
