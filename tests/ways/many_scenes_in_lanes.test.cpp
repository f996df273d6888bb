// SPDX-License-Identifier: MIT
//
// Scenes, and systems that depend on t, in the lanes of a pack: random ones against simulate(), and a damped and driven oscillator against its closed form,
//
//     q̈ + 2 d q̇ + ω² q = a cos Ωt ,    q = C cos Ωt + S sin Ωt + e^(−dt) (A cos wt + B sin wt) ,    w² = ω² − d² .
#include "catch2_bridge.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <type_traits>

#include "bench/chain_energies.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/counter_random.hpp"
#include "qdot/integrate/many_in_lanes.hpp"
#include "qdot/mechanics/kinematic_system.hpp"

using namespace qdot;

namespace {

constexpr std::size_t count = 21;  // no multiple of the lanes
const Options options{.rtol = 1e-10, .atol = 1e-12};

template <class Q>
using ScalarOf = std::remove_cvref_t<decltype(std::declval<Q>()[0])>;

// A damped and driven oscillator with coupling to nobody.
template <class S = double>
struct Driven {
  S omega2 = 4.0, a = 0.7, Omega = 1.3;
  constexpr auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  constexpr auto V(const auto& q, const auto& t) const {
    using std::cos;
    return 0.5 * omega2 * q[0] * q[0] - a * q[0] * cos(Omega * t);
  }
};

// Its closed form from q0, v0 at t0 = 0.
double driven_at(double t, double q0, double v0, double omega2, double a, double Omega, double d) {
  const double r = omega2 - Omega * Omega, s = 2.0 * d * Omega, C = a * r / (r * r + s * s), S = a * s / (r * r + s * s);
  const double w = std::sqrt(omega2 - d * d), A = q0 - C, B = (v0 - S * Omega + d * A) / w;
  return C * std::cos(Omega * t) + S * std::sin(Omega * t) + std::exp(-d * t) * (A * std::cos(w * t) + B * std::sin(w * t));
}

// Two coordinates with a mass matrix that is full and depends on q, and on t where it is driven.
struct Arm {
  double m = 1.0, k = 2.0, g = 3.0;
  constexpr auto T(const auto& q, const auto& v) const {
    using std::cos;
    return 0.5 * m * (2.0 * v[0] * v[0] + v[1] * v[1] + 2.0 * v[0] * v[1] * cos(q[0] - q[1]));
  }
  constexpr auto V(const auto& q) const {
    using std::cos;
    return -g * (2.0 * cos(q[0]) + cos(q[1])) + 0.5 * k * q[0] * q[0];
  }
};
struct Shaken : Arm {
  using Arm::V;
  constexpr auto T(const auto& q, const auto& v, const auto& t) const {
    using std::sin;
    return Arm::T(q, v) + 0.3 * v[0] * sin(2.0 * t) * q[1];
  }
};

// Two bobs of mass m on strings of length l, summed in the scalar of the state.
template <class S = double>
struct Bobs {
  S m = 1.0, l = 1.0;
  constexpr auto T(const auto&, const auto& v) const {
    ScalarOf<decltype(v)> sum = 0.0;
    for (int i = 0; i < 2; ++i) sum += 0.5 * m * l * l * v[i] * v[i];
    return sum;
  }
  constexpr auto V(const auto& q) const {
    using std::cos;
    ScalarOf<decltype(q)> sum = 0.0;
    for (int i = 0; i < 2; ++i) sum -= 9.81 * m * l * cos(q[i]);
    return sum + 0.3 * q[0] * q[1];
  }
};

const auto tip = [](const auto& q) {
  using std::cos, std::sin;
  using S = ScalarOf<decltype(q)>;
  return Vector<S, 2>(S(sin(q[0]) + sin(q[1])), S(-cos(q[0]) - cos(q[1])));
};

State<2> start_of(std::size_t i) {
  CounterRandom random(7, i);
  const double t = random.uniform(-1.0, 2.0);
  return {t, {random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)}, {random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)}};
}

// Rounding of fifty steps, times the growth of neighbours within 4 s.
constexpr double rounded = 1e-10;

// As many steps as alone, and ends apart by rounding.
template <class Sc>
void require_same(const Sc& model, double t_end = 5.0) {
  const auto ends = ensemble(model, count, start_of, t_end, Dop853{}, options, {.threads = 2});
  for (std::size_t i = 0; i < count; ++i) {
    const auto alone = simulate(model, start_of(i), t_end, Dop853{}, options);
    REQUIRE(ends[i].completed());
    CHECK(ends[i].value->outcome == alone.outcome);
    CHECK(ends[i].value->steps == alone.statistics.steps);
    CHECK((ends[i].value->state.q - alone.y.template head<2>()).norm() < rounded);
    CHECK((ends[i].value->state.qdot - alone.y.template segment<2>(2)).norm() < rounded);
  }
}

// What goes on alone, with the bits of simulate().
template <class Sc>
void require_alone(const Sc& model, double t_end = 3.0) {
  const auto turning = [](std::size_t i) {  // q₁ − q₀ = t
    State<2> start = start_of(i);
    start.q[1] = start.q[0] + start.t;
    start.qdot[1] = start.qdot[0] + 1.0;
    return start;
  };
  const auto ends = ensemble(model, 5, turning, t_end, Dop853{}, options, {.threads = 1});
  for (std::size_t i = 0; i < 5; ++i) {
    const auto alone = simulate(model, turning(i), t_end, Dop853{}, options);
    REQUIRE(ends[i].completed());
    CHECK(ends[i].value->outcome == alone.outcome);
    CHECK(ends[i].value->state.q == alone.y.template head<2>());
    CHECK(ends[i].value->steps == alone.statistics.steps);
  }
}

}  // namespace

TEST_CASE("damped and driven oscillators of many starts and parameters end where their closed form says") {
  const auto parameters = [](std::size_t i) {
    CounterRandom random(11, i);
    return Vector<double, 4>(random.uniform(1.0, 9.0), random.uniform(0.0, 1.0), random.uniform(0.5, 2.0), random.uniform(0.0, 0.4));
  };
  const auto oscillators = family<1>([](const auto& p) { return Driven<ScalarOf<decltype(p)>>{p[0], p[1], p[2]}; },
                                     [](const auto& p) { return std::tuple(viscous_damping(Vector<ScalarOf<decltype(p)>, 1>(2.0 * p[3]))); }, parameters);
  const auto start = [](std::size_t i) { return State<1>{0.0, Vector<double, 1>(0.1 * static_cast<double>(i)), Vector<double, 1>(0.5)}; };
  constexpr double t_end = 7.0, error = 1e-8;  // a hundred steps of 1e-10
  const auto ends = ensemble(oscillators, count, start, t_end, Dop853{}, options);
  for (std::size_t i = 0; i < count; ++i) {
    const auto p = parameters(i);
    REQUIRE(ends[i].completed());
    CHECK(std::abs(ends[i].value->state.q[0] - driven_at(t_end, 0.1 * static_cast<double>(i), 0.5, p[0], p[1], p[2], p[3])) < error);
  }
}

TEST_CASE("scenes with random forces that are formulas take as many steps in lanes as alone, each from its own t") {
  CounterRandom random(1, 0);
  const auto some = [&] { return random.uniform(0.05, 0.5); };
  const auto viscous = viscous_damping(Eigen::Vector2d(some(), some()));
  const auto joint = rayleigh([c = some()](const auto& q, const auto& v) { return c * (1.0 + q[0] * q[0]) * (v[1] - v[0]) * (v[1] - v[0]); });
  const auto spring = spring_damper(Eigen::Vector2d(2.0 + some(), some()), tip, 4.0 * some(), 0.3, some());
  const auto law = tension_between(tip, Eigen::Vector2d(0.0, 3.0 + some()), [c = some()](const auto& l, const auto& rate) { return c * l * l + 0.1 * rate; });
  const auto push = force_at_point(tip, [c = some()](const auto& t) {
    using std::sin;
    return vector(sin(3.0 * t), c * t);
  });
  const auto motor = generalized_force([c = some()](const auto& q, const auto& v, const auto& t) {
    using std::cos;
    using S = ScalarOf<decltype(v)>;
    return Vector<S, 2>(S(cos(2.0 * t) - c * v[0]), S(-c * q[1]));
  });
  const auto torque = torque_on_body([](const auto& q) { return rotation_z(q[1]); }, Eigen::Vector3d(0.1, 0.2, some()));
  const auto magnet = velocity_potential([c = some()](const auto& q, const auto& v) { return c * (q[0] * v[1] - q[1] * v[0]); });
  require_same(scene(mechanical_system<2>(Arm{}), viscous, push, torque));
  require_same(scene(mechanical_system<2>(Arm{}), joint, spring, magnet));
  require_same(scene(mechanical_system<2>(Shaken{}), law, motor, regularized_friction(1, some(), 1.0)));
}

TEST_CASE("forces go in lanes beside positions") {
  const auto placed = kinematic_system<2>(bench::UnrolledPositions<2>{}, gravity_along<1>(-9.81));
  CHECK(detail::lines_of_recorded<2>(detail::systems_of(placed).recorded(), 0) != nullptr);
  const auto sprung = scene(placed, spring_damper(Eigen::Vector2d(2.0, 0.5), tip, 2.0, 0.3, 0.1));
  CHECK(detail::lines_of_recorded<2>(detail::systems_of(sprung).recorded(), 0) != nullptr);
  require_same(placed);
  require_same(scene(placed, viscous_damping(Eigen::Vector2d(0.1, 0.2))));
}

TEST_CASE("chains with plain loops go in lanes up to 16 links, and end where they do alone") {
  const auto check = [&]<int n>(std::integral_constant<int, n>) {
    const auto chain = mechanical_system<n>(bench::LoopedChain{});
    const auto start = [](std::size_t i) {
      CounterRandom random(5, i);
      State<n> s{0.0, Vector<double, n>::Zero(n), Vector<double, n>::Zero(n)};
      for (int k = 0; k < n; ++k) s.q[k] = random.uniform(-0.3, 0.3);
      return s;
    };
    const auto ends = ensemble(chain, 9, start, 0.3, Dop853{}, options, {.threads = 1});
    for (std::size_t i = 0; i < 9; ++i) {
      const auto alone = simulate(chain, start(i), 0.3, Dop853{}, options);
      REQUIRE(ends[i].completed());
      if (n <= 8) CHECK(ends[i].value->steps == alone.statistics.steps);  // beyond, M is eliminated in another order
      CHECK((ends[i].value->state.q - alone.y.template head<n>()).norm() < rounded);
    }
  };
  check(std::integral_constant<int, 2>());
  check(std::integral_constant<int, 9>());
  check(std::integral_constant<int, 16>());
}

TEST_CASE("forces in lanes are lines: their functors are not asked for numbers at each evaluation") {
  std::atomic<long> asked{0};
  const auto pushed = scene(mechanical_system<2>(Arm{}), generalized_force([&asked](const auto&, const auto& v) {
                              using S = ScalarOf<decltype(v)>;
                              if constexpr (std::is_same_v<S, double>) ++asked;
                              return Vector<S, 2>(S(-0.1 * v[0]), S(-0.2 * v[1]));
                            }));
  long evaluations = 0;
  for (const auto& end : ensemble(pushed, count, start_of, 5.0, Dop853{}, options, {.threads = 1})) evaluations += end.value->evaluations;
  CHECK(asked < evaluations / 4);  // at starts and ends
}

TEST_CASE("a captured number that changes while motions go in lanes is met by all motions that begin afterwards") {
  double k = 1.0;
  constexpr std::size_t change = 12, motions = 30;
  const auto start = [&k](std::size_t i) {
    if (i == change) k = 4.0;
    return State<1>{0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)};
  };
  const auto T = [](const auto& v) { return 0.5 * v[0] * v[0]; };
  const auto check = [&](const auto& model) {
    k = 1.0;
    const auto ends = ensemble(model, motions, start, 1.0, Dop853{}, options, {.threads = 1});
    for (std::size_t i = change; i < motions; ++i) CHECK(std::abs(ends[i].value->state.q[0] - std::cos(2.0)) < 1e-8);
  };
  check(mechanical_system<1>(T, [&k](const auto& q) { return 0.5 * k * q[0] * q[0]; }));
  check(scene(mechanical_system<1>(T), generalized_force([&k](const auto& q, const auto&) {
                using S = ScalarOf<decltype(q)>;
                return Vector<S, 1>(S(-k * q[0]));
              })));
}

TEST_CASE("motions with a force that branches end where they do alone, and where lanes part at an event") {
  // A brake that is smooth where it begins, so that steps do not hang on the last bit.
  const auto brake = [](const auto& v) {
    using S = std::remove_cvref_t<decltype(v)>;
    const bool fast = v > 0.5;
    if (!fast) return S(0.0);
    const S x = v - 0.5;
    return S(-x * x * x * x * x * x * x * x * x * x);
  };
  const auto braked =
      scene(mechanical_system<2>(Arm{}),
            generalized_force([brake](const auto&, const auto& v) { return Vector<ScalarOf<decltype(v)>, 2>(brake(v[0]), brake(v[1])); }));
  constexpr double beside = 1e-7;  // a kink in the tenth derivative: errors of steps that are within the tolerance
  const auto ends = ensemble(braked, count, start_of, 4.0, Dop853{}, options);
  const auto again = ensemble(braked, count, start_of, 4.0, Dop853{}, options, {.threads = 1, .chunk = 3});
  for (std::size_t i = 0; i < count; ++i) {
    REQUIRE(ends[i].completed());
    CHECK((ends[i].value->state.q - simulate(braked, start_of(i), 4.0, Dop853{}, options).y.head<2>()).norm() < beside);
    CHECK(ends[i].value->state.q == again[i].value->state.q);
  }
  const auto over = event("over", [](const auto& q) {
    using S = ScalarOf<decltype(q)>;
    return q[0] > 0.0 ? S(q[0] - 0.5) : S(q[0] + 0.5);
  }).stop();
  const auto stopped = ensemble(mechanical_system<2>(Arm{}), count, start_of, 4.0, Dop853{}, options, over);
  for (std::size_t i = 0; i < count; ++i) {
    const auto alone = simulate(mechanical_system<2>(Arm{}), start_of(i), 4.0, Dop853{}, options, over);
    CHECK(stopped[i].value->outcome == alone.outcome);
    CHECK(std::abs(stopped[i].value->state.t - alone.t) < 1e-8);  // of events, by steps that are cut elsewhere
  }
}

TEST_CASE("what cannot share a pack goes alone: constraints, contacts, dry friction, states of effects, and forces of plain numbers only") {
  const auto arm = mechanical_system<2>(Arm{});
  require_alone(scene(arm, holonomic("turns", [](const auto& q, const auto& t) { return q[1] - q[0] - t; })));
  require_alone(scene(arm, dry_friction("joint", 0, 0.3)));
  require_alone(scene(
      arm,
      controller([](const auto& q, const auto&, const auto& z, const auto&) { return Vector<ScalarOf<decltype(q)>, 2>(-z[0], 0.0 * z[0]); },
                 [](const auto& q, const auto&, const auto& z, const auto&) { return Vector<ScalarOf<decltype(q)>, 1>(q[0] - z[0]); },
                 Vector<double, 1>(0.2))));
  require_alone(scene(arm, generalized_force([](const Vector<double, 2>& q, const Vector<double, 2>& v) {
                        return Vector<double, 2>(-0.1 * v[0], 0.2 * q[0]);
                      })));
}

TEST_CASE("a push that begins and ends between two steps is felt in a lane as alone") {
  const auto pushed = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                           [](const auto& q, const auto& t) {
                                             using std::exp;
                                             const auto s = (t - 8.0) / 0.01;
                                             return 0.5 * q[0] * q[0] - q[0] * exp(-s * s);
                                           });
  const auto ends = ensemble(pushed, 9, [](std::size_t i) { return State<1>{0.1 * static_cast<double>(i), Vector<double, 1>(0.0),
                                                                                 Vector<double, 1>(0.0)}; }, 10.0, Dop853{}, options);
  const double impulse = 0.01 * std::sqrt(3.14159265358979323846) * std::exp(-0.25e-4);  // of a Gauss bell on an oscillator of frequency 1
  for (const auto& end : ends) {
    REQUIRE(end.completed());
    CHECK(std::abs(end.value->state.q[0] - impulse * std::sin(2.0)) < 1e-9);
  }
}

TEST_CASE("scenes and systems with t end with the same bits for any number of threads, any chunk and any order") {
  const auto model = scene(mechanical_system<2>(Shaken{}), viscous_damping(Eigen::Vector2d(0.1, 0.2)), quadratic_drag(tip, 0.2));
  const auto plain = ensemble(model, count, start_of, 4.0, Dop853{}, options, {.threads = 1});
  const auto others = ensemble(model, count, start_of, 4.0, Dop853{}, options, {.threads = 3, .chunk = 2});
  auto turned = ensemble(model, count, [](std::size_t i) { return start_of(count - 1 - i); }, 4.0, Dop853{}, options);
  std::reverse(turned.begin(), turned.end());
  for (std::size_t i = 0; i < count; ++i) {
    CHECK(plain[i].value->state.q == others[i].value->state.q);
    CHECK(plain[i].value->state.q == turned[i].value->state.q);
    CHECK(plain[i].value->state.qdot == turned[i].value->state.qdot);
  }
}

TEST_CASE("parameters of a family may enter loops that sum in the scalar of the state") {
  const auto parameters = [](std::size_t i) { return Vector<double, 2>(1.0 + 0.1 * static_cast<double>(i), 2.0 - 0.05 * static_cast<double>(i)); };
  const auto bobs = family<2>([](const auto& p) { return Bobs<ScalarOf<decltype(p)>>{p[0], p[1]}; }, parameters);
  CHECK(detail::lines_of_recorded<2>(detail::systems_of(bobs).recorded(), 2) != nullptr);
  const auto ends = ensemble(bobs, count, start_of, 4.0, Dop853{}, options);
  for (std::size_t i = 0; i < count; ++i) {
    const auto p = parameters(i);
    REQUIRE(ends[i].completed());
    CHECK((ends[i].value->state.q - simulate(mechanical_system<2>(Bobs<>{p[0], p[1]}), start_of(i), 4.0, Dop853{}, options).y.head<2>()).norm() < rounded);
  }
}

TEST_CASE("scenes of a family go in lanes with parameters of their own effects") {
  const auto parameters = [](std::size_t i) {
    CounterRandom random(3, i);
    return Vector<double, 3>(random.uniform(0.5, 2.0), random.uniform(0.0, 0.3), random.uniform(1.0, 3.0));
  };
  const auto effects = [](const auto& p) {
    using P = ScalarOf<decltype(p)>;
    return std::tuple(viscous_damping(Vector<P, 2>(p[1], 2.0 * p[1])), generalized_force([w = P(p[2])](const auto&, const auto& v, const auto& t) {
                        using std::sin;
                        using S = ScalarOf<decltype(v)>;
                        return Vector<S, 2>(S(sin(w * t)), S(0.0));
                      }),
                      spring_damper(tip, Eigen::Vector2d(1.0, 2.0), 1.0, 0.2, 0.1));
  };
  const auto arms = family<2>([](const auto&) { return Arm{}; }, effects, parameters);
  const auto ends = ensemble(arms, count, start_of, 4.0, Dop853{}, options);
  for (std::size_t i = 0; i < count; ++i) {
    const auto one = std::apply([](const auto&... e) { return scene(mechanical_system<2>(Arm{}), e...); }, effects(parameters(i)));
    const auto alone = simulate(one, start_of(i), 4.0, Dop853{}, options);
    REQUIRE(ends[i].completed());
    CHECK(ends[i].value->steps == alone.statistics.steps);
    CHECK((ends[i].value->state.q - alone.y.head<2>()).norm() < rounded);
  }
}
