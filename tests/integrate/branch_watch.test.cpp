// SPDX-License-Identifier: MIT
#include "qdot/integrate/watch/branch_watch.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "catch2_bridge.hpp"
#include "qdot/analysis/sensitivity.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/cvode_automatic.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/mechanics/energy.hpp"

using namespace qdot;

namespace {

using V1 = Vector<double, 1>;

// A body of mass 1 that coasts, but for a force F in a strip from `begins` on, which takes it from v to √(v² + 2 F width).
struct Strip {
  double begins = 1.0, width = 0.1, F = 3.0;

  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const {
    auto potential = 0.0 * q[0];
    if (q[0] > begins) potential -= F * (q[0] - begins);
    if (q[0] > begins + width) potential += F * (q[0] - begins - width);
    return potential;
  }
  double end(double v, double t) const {
    const double into = t - begins / v, out = std::sqrt(v * v + 2.0 * F * width), takes = (out - v) / F;
    return begins + width + out * (into - takes);
  }
};

// Where the strip begins and ends, steps end by their local error, 1e-9 in each of some; an error of the velocity is ten times as much of the place.
constexpr double tolerance = 1e-5;

auto start(double q, double v) { return State<1>{0.0, V1(q), V1(v)}; }

}  // namespace

TEST_CASE("a strip that a step would pass over is felt, however narrow, by every method, forward and backward") {
  const std::vector<std::pair<std::string, AnyMethod<decltype(mechanical_system<1>(Strip{}))>>> methods = {
      {"dop853", Dop853{}}, {"dopri5", Dopri5{}}, {"bdf", CvodeBdf{}}, {"adams", CvodeAdams{}}, {"automatic", Automatic{}}};
  for (const double width : {0.5, 0.1, 1e-2, 1e-4})
    for (const auto& [name, method] : methods) {
      CAPTURE(width, name);
      const Strip strip{.width = width, .F = 0.3 / width};
      const auto run = simulate(mechanical_system<1>(strip), start(0.0, 0.8), 10.0, method);
      REQUIRE(run.completed());
      CHECK(std::abs(run.y[0] - strip.end(0.8, 10.0)) < tolerance);
      const auto back = simulate(mechanical_system<1>(strip), State<1>{10.0, V1(run.y[0]), V1(run.y[1])}, 0.0, method);
      REQUIRE(back.completed());
      CHECK(std::abs(back.y[0]) < 10 * tolerance);
    }
}

TEST_CASE("a strip of a force is felt, and one that a second coordinate passes") {
  const auto free = mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }, [](const auto& q) { return 0.0 * q[0]; });
  const auto wind = generalized_force([](const auto& q, const auto&) {
    auto Q = q;
    Q[0] = 0.0 * q[0];
    Q[1] = q[0] > 1.0 && q[0] < 1.125 ? 2.0 + 0.0 * q[1] : 0.0 * q[1];
    return Q;
  });
  const auto run = simulate(scene(free, wind), State<2>{0.0, {0.0, 0.0}, {0.5, 0.0}}, 10.0, Dop853{});
  REQUIRE(run.completed());
  // In the strip for 1/4 s: q̇₁ = 1/2, then 7.75 s more of it.
  CHECK(std::abs(run.y[3] - 0.5) < tolerance);
  CHECK(std::abs(run.y[1] - (0.0625 + 7.75 * 0.5)) < 10 * tolerance);
}

TEST_CASE("derivatives see a strip that a step would pass over") {
  const Strip strip{.width = 0.05, .F = 4.0};
  const auto of = sensitivities(mechanical_system<1>(strip), start(0.0, 0.8), 10.0, Dop853{}, {.rtol = 1e-11});
  REQUIRE(of.completed());
  const double v = 0.8, out = std::sqrt(v * v + 2.0 * strip.F * strip.width);
  // q(t) = q_out + w (t − t_out) with w the velocity behind: by the place ∂q/∂q₀ = w/v, and ∂q̇/∂v = v/w.
  CHECK(std::abs(of.Phi(0, 0) - out / v) < 1e-7);
  CHECK(std::abs(of.Phi(1, 1) - v / out) < 1e-7);
}

namespace {

// Which branches: one type for all of them.
enum class Case { graze, step, mass_by_time, switched_on, root, vee };
struct Branching {
  Case which;

  template <class X>
  auto T(const X&, const X& v, const auto& t) const {
    using S = std::decay_t<decltype(v[0] + t)>;
    const S twice_T = v[0] * v[0];
    return which == Case::mass_by_time && !(t < 1.5) ? S(2.0 * twice_T) : S(0.5 * twice_T);
  }
  auto V(const auto& q, const auto& t) const {
    using std::sqrt;
    using S = std::decay_t<decltype(q[0] + t)>;
    switch (which) {
      case Case::graze: return q[0] > 1.0 ? S(0.5 * q[0] * q[0] + 0.5 * (q[0] - 1.0)) : S(0.5 * q[0] * q[0]);
      case Case::step: return q[0] > 0.0 ? S(0.5) : S(0.0);
      case Case::switched_on: return t > 1.0 ? S(3.0 - q[0]) : S(0.0);
      case Case::vee: return q[0] < 0.0 ? S(-q[0]) : S(q[0]);
      case Case::root: return sqrt(q[0]) < 1.0 ? S(q[0]) : S(2.0 * q[0]);
      default: return S(0.0);
    }
  }
};
struct ByPlace {  // a mass
  auto T(const auto& q, const auto& v) const { return (q[0] < 0.0 ? 0.5 : 2.0) * v[0] * v[0]; }
  auto V(const auto& q) const { return q[0] * q[0]; }
};

template <class System, int n>
std::string end_of(const System& system, const State<n>& from, double t_end) {
  const auto run = simulate(system, from, t_end, Dop853{}, Options{.rtol = 1e-10, .atol = 1e-12, .max_steps = 100'000});
  return std::string(name(run.outcome)) + ": " + run.message;
}
std::string end_of(Case which, double q, double v, double t_end) { return end_of(mechanical_system<1>(Branching{which}), start(q, v), t_end); }
bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// Friction against v and a spring; or a force towards q + v = 0.
auto pushed(bool friction) {
  return scene(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.0 * q[0]; }),
               generalized_force([friction](const auto& q, const auto& v, const auto&) {
                 auto force = (0.0 * q).eval();
                 if (friction) force[0] = v[0] > 0.0 ? -q[0] - 0.3 : -q[0] + 0.3;
                 else force[0] += q[0] + v[0] > 0.0 ? -1.0 : 1.0;
                 return force;
               }));
}

// A bead on y = 0 up to x = 0, and from there on a step, a slope or a parabola; or on a rope whose length jumps at t = 1.
enum class Rail { step, slope, parabola, rope };
auto on(Rail rail) {
  return scene(mechanical_system<2>([](const auto& v) { return 0.5 * v.dot(v); }, [](const auto& q) { return 9.81 * q[1]; }),
               holonomic("rail", [rail](const auto& q, const auto& t) {
                 using S = std::decay_t<decltype(q[0] + t)>;
                 if (rail == Rail::rope) return t < 1.0 ? S(q.dot(q) - 1.0) : S(q.dot(q) - 2.25);
                 if (!(q[0] > 0.0)) return S(q[1]);
                 return S(q[1] - (rail == Rail::step ? S(0.1) : rail == Rail::slope ? S(0.5 * q[0]) : S(0.25 * q[0] * q[0])));
               }));
}

}  // namespace

TEST_CASE("a method that holds its branch steps to the places where a force jumps, and loses no digits there") {
  // Pieces in closed form, 25 digits by them and by series: 36 places where a count by a loop changes, and a clock whose escapement pushes it once a period.
  constexpr double rtol = 1e-12, after_jumps = 1e-9;  // each place shifts what comes by the local error, over the velocity there
  const Options tight{.rtol = rtol, .atol = rtol};
  const auto coasting = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.0 * q[0]; });
  const auto stairs = scene(coasting, generalized_force([](const auto& q, const auto& v, const auto&) {
                              int n = 0;
                              while (n + 0.5 < q[0]) ++n;
                              while (n - 0.5 > q[0]) --n;
                              return vector(-1.0 * n - 0.05 * v[0]);
                            }));
  const auto clock = scene(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.5 * q[0] * q[0]; }),
                           generalized_force([](const auto& q, const auto& v, const auto&) {
                             using std::abs;
                             return vector((abs(q[0]) < 0.2 && v[0] > 0.0 ? 1.0 : 0.0) - 0.1 * v[0]);
                           }));
  const auto check = [&](const auto& method) {
    const auto down = simulate(stairs, start(5.25, 0.0), 12.0, method, tight);
    REQUIRE(down.completed());
    CHECK(std::abs(down.y[0] - 3.172887162446868320863) < after_jumps);
    CHECK(std::abs(down.y[1] - 2.165797467205666856490) < after_jumps);
    const auto up = simulate(stairs, State<1>{12.0, V1(3.172887162446868320863), V1(2.165797467205666856490)}, 0.0, method, tight);
    REQUIRE(up.completed());
    CHECK(std::abs(up.y[0] - 5.25) < 100 * after_jumps);  // backward damping becomes drive
    const auto period = simulate(clock, start(-1.036027121108406085689, 0.0), 6.282797692867881767438, method, tight);
    REQUIRE(period.completed());
    CHECK(std::abs(period.y[0] + 1.036027121108406085689) < after_jumps);
    CHECK(std::abs(period.y[1]) < after_jumps);
    return down;
  };
  const auto by_eighth_order = check(Dop853{});
  check(Dopri5{});
  if (by_eighth_order.statistics.evaluated_by.find("recorded") != std::string::npos) CHECK(by_eighth_order.statistics.rejected_by_error_test < 10);
}

TEST_CASE("guards that lie close together, that are squares, or that come by the hundred are all met") {
  const auto coasting = [](auto force) {
    return scene(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.0 * q[0]; }),
                 generalized_force([force](const auto& q, const auto&, const auto&) { return vector(force(q[0]) + 0.0 * q[0]); }));
  };
  constexpr double rtol = 1e-9, after_guards = 1e-8;
  // From −1 with 1: 1.1 s to the guards, then 1.9 s under 0.5.
  for (const double gap : {1e-9, 1e-11})
    for (const double first : {0.0, 1.0}) {
      Options options{.rtol = rtol, .atol = rtol};
      if (first > 0.0) options.initial_step = first;
      const auto pushed_twice = coasting([gap](const auto& x) { return (x > 0.1 ? 0.3 : 0.0) + (x > 0.1 + gap ? 0.2 : 0.0); });
      const auto run = simulate(pushed_twice, start(-1.0, 1.0), 3.0, Dop853{}, options);
      REQUIRE(run.completed());
      CHECK(std::abs(run.y[0] - (2.0 + 0.5 * 0.5 * 1.9 * 1.9)) < after_guards);
    }
  // A guard that is a square, and was large once: the same by dual numbers, which hold no branch.
  const auto valley = scene(mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return 0.5 * q[0] * q[0]; }),
                            generalized_force([](const auto& q, const auto& v, const auto&) {
                              const auto height = 1e4 * q[1] * q[1] + 1.02 + q[0];
                              return vector(height < 0.03 ? 50.0 * (0.03 - height) : 0.0 * q[0], -2.0 * v[1]);
                            }));
  const State<2> far{0.0, {1.0, 100.0}, {0.0, -200.0}};
  const auto by_duals = simulate(valley, far, 12.0, Dop853{}, {.rtol = 1e-11, .atol = 1e-11, .by = By::duals});
  for (const double loose : {1e-6, 1e-9}) {
    const auto run = simulate(valley, far, 12.0, Dop853{}, {.rtol = loose, .atol = loose});
    REQUIRE(run.completed());
    CHECK(std::abs(run.y[0] - by_duals.y[0]) < 1e3 * loose);
  }
  // Stairs on the way to an event, and an end that is far away: v² = 100² + 2 Σ 0.001 k for each of 299 steps, and a first half one.
  const auto stairs = simulate(coasting([](const auto& x) { using std::floor; return 1e-3 * floor(x); }), start(0.5, 100.0), 1e10, Dop853{}, {.rtol = rtol},
                               event("far", [](const auto& q) { return q[0] - 300.0; }).stop());
  REQUIRE(stairs.outcome == Outcome::stopped_by_event);
  CHECK(std::abs(stairs.y[1] - std::sqrt(1e4 + 2e-3 * 299 * 300 / 2)) < 1e-6);
}

TEST_CASE("a place that is barely reached between two steps is felt, and one that is touched only is not") {
  // q̈ = −q, and −q − 1/2 beyond 1, from q = 0 with v = 1 + 2⁻²⁰: beyond 1 it stays for 0.00184. In pieces: arcs of circles about 0 and −1/2.
  constexpr double rounding = 1e-11;  // rtol 1e-12 over three units of time
  const auto edge = mechanical_system<1>(Branching{Case::graze});
  for (const double rtol : {1e-10, 1e-12, 1e-14}) {  // the time of the crossing makes 478 times as much of it: ∂q/∂v is −477.8
    const auto run = simulate(edge, start(0.0, 1.0000009536743164), 3.0, Dop853{}, {.rtol = rtol, .atol = 1e-14});
    REQUIRE(run.completed());
    CHECK(std::abs(run.y[0] - 0.140208585166974274) < 478 * std::max(rtol, 1e-14));
    CHECK(std::abs(run.y[1] + 0.990122951958501782) < 478 * std::max(rtol, 1e-14));
  }
  const auto touching = simulate(edge, start(0.0, 1.0), 3.0, Dop853{}, {.rtol = 1e-12, .atol = 1e-14});
  REQUIRE(touching.completed());
  CHECK(std::abs(touching.y[0] - std::sin(3.0)) < rounding);
}

TEST_CASE("a blow that branches ask for ends the run by a name: a step of V, a mass that changes by place or by time") {
  CHECK(contains(end_of(Case::step, -1.0, 2.0, 2.0), "refused_by_model"));
  CHECK(contains(end_of(Case::step, -1.0, 2.0, 2.0), "at t = 0.5, T - V jumps from 2 to 1.5"));
  CHECK(contains(end_of(Case::mass_by_time, 0.5, 1.0, 4.0), "at t = 1.5, a momentum, the derivative of T with respect to a velocity, jumps from 1 to 4"));
  CHECK(contains(end_of(mechanical_system<1>(ByPlace{}), start(-1.0, 0.3), 5.0), "refused_by_model"));
  CHECK(contains(end_of(Case::switched_on, 0.0, 0.0, 2.0), "completed"));  // a V that jumps with time alone is no blow
}

TEST_CASE("an event that takes the blow, or stops the run, comes before its refusal, and a run may begin behind it") {
  const auto step = mechanical_system<1>(Branching{Case::step});
  const auto at_zero = [](const auto& q, const auto&, const auto&) { return q[0]; };
  constexpr double rounding = 1e-9;
  const auto run = simulate(step, start(-1.0, 2.0), 2.0, Dop853{}, {}, event("wall", at_zero).action([](State<1>& state) { state.qdot[0] = std::sqrt(3.0); }));
  REQUIRE(run.completed());  // v = √(2² − 2 · ½) behind it
  CHECK(std::abs(run.y[0] - 1.5 * std::sqrt(3.0)) < rounding);
  CHECK(simulate(step, start(-1.0, 2.0), 2.0, Dop853{}, {}, event("wall", at_zero).stop()).outcome == Outcome::stopped_by_event);
  CHECK(contains(end_of(Case::step, 0.0, 2.0, 2.0), "completed"));
  CHECK(contains(end_of(mechanical_system<1>(ByPlace{}), start(0.0, 1.0), 1.0), "completed"));
}

TEST_CASE("what is continuous is no blow, at rest and at large times") {
  // A frame at rest until t = 1, then accelerated: T = ½ (v + u)², u = max(t − 1, 0).
  const auto frame = mechanical_system<1>([](const auto&, const auto& v, const auto& t) {
    using S = std::decay_t<decltype(v[0] + t)>;
    const S u = t < 1.0 ? S(v[0]) : S(v[0] + (t - 1.0));
    return S(0.5 * u * u);
  }, [](const auto& q) { return 0.0 * q[0]; });
  CHECK(contains(end_of(frame, start(0.0, 0.0), 3.0), "completed"));
  // A mass that burns off at 0.1 a second until 1.7e9 + 5.
  const auto rocket = mechanical_system<1>([](const auto&, const auto& v, const auto& t) {
    using S = std::decay_t<decltype(v[0] + t)>;
    const S m = t < 1.7e9 + 5.0 ? S(1.0 - 0.1 * (t - 1.7e9)) : S(0.5 + 0.0 * t);
    return S(0.5 * m * v[0] * v[0]);
  }, [](const auto& q) { return 0.0 * q[0]; });
  CHECK(contains(end_of(rocket, State<1>{1.7e9, V1(0.0), V1(1.0)}, 1.7e9 + 8.0), "completed"));
  CHECK(contains(end_of(on(Rail::parabola), State<2>{0.0, {0.0, 0.0}, {2.0, 0.0}}, 1.0), "completed"));
  // At rest on a stiff one-sided spring, pushed onto it: (F/k)(1 − cos ωt).
  const auto spring = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) {
    return q[0] < 0.0 ? 0.5e10 * q[0] * q[0] + 9.81 * q[0] : 0.0 * q[0] + 9.81 * q[0];
  });
  CHECK(contains(end_of(spring, start(0.0, 0.0), 1e-4), "completed"));
}

TEST_CASE("a constraint that jumps, or has a kink, ends the run by a name, and one whose curvature jumps does not") {
  const State<2> from{0.0, {-1.0, 0.0}, {2.0, 0.0}};
  CHECK(contains(end_of(on(Rail::step), from, 3.0), "constraint_failure"));
  CHECK(contains(end_of(on(Rail::slope), from, 3.0), "a constraint has a kink"));
  CHECK(contains(end_of(on(Rail::parabola), from, 3.0), "completed"));
  CHECK(contains(end_of(on(Rail::rope), State<2>{0.0, {0.6, -0.8}, {0.0, 0.0}}, 2.0), "at t = 1, a constraint jumps from"));
}

TEST_CASE("a motion that both sides push onto their boundary ends by the name of zeno") {
  // Friction of 0.3 sticks at the fourth stop, at 9.638838644 (arcs of circles); three stops it passes.
  const std::string sticks = end_of(pushed(true), start(2.0, 0.5), 20.0);
  CHECK(contains(sticks, "zeno"));
  CHECK(contains(sticks, "at t = 9.638838644"));
  CHECK(contains(end_of(pushed(false), start(0.5, 0.25), 2.0), "at t = 0.68614066"));  // q̈ = −sgn(q + v) slides from there
  CHECK(contains(end_of(Case::vee, 0.0, 0.0, 1.0), "zeno"));  // at rest where V = |q| is least
  // Backward from a rest that friction holds every past is possible.
  CHECK(contains(end_of(pushed(true), State<1>{20.0, V1(-0.25372045918796404), V1(0.0)}, 0.0), "the motion is not unique"));
}

TEST_CASE("a comparison with NaN ends the run by a name, at its start and later") {
  CHECK(contains(end_of(Case::root, -1.0, 0.0, 1.0), "is asked about NaN"));
  const std::string later = end_of(Case::root, 0.5, -1.0, 3.0);  // q = 1/2 − t − t²/2 is 0 at √2 − 1
  CHECK(contains(later, "non_finite"));
  CHECK(contains(later, "is asked about NaN at t = 0.41421"));
}

TEST_CASE("a functor that compares nothing, and one whose branches are never left, costs no step") {
  const auto plain = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.5 * q[0] * q[0]; });
  const auto guarded = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) {
    return q[0] < 2.0 ? 0.5 * q[0] * q[0] : 0.25 * q[0] * q[0];
  });
  const auto a = simulate(plain, start(1.0, 0.0), 20.0, Dop853{}), b = simulate(guarded, start(1.0, 0.0), 20.0, Dop853{});
  CHECK(a.statistics.steps == b.statistics.steps);
  CHECK(std::abs(a.y[0] - b.y[0]) < 1e-12);
}
