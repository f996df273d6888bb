// SPDX-License-Identifier: MIT
//
// Accelerations of a run by lines that end with them, beside those by dual numbers; and what is left to other ways.
#include "qdot/mechanics/derive/kept_rates.ipp"

#include <algorithm>
#include <cmath>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include "bench/chain_energies.hpp"
#include "catch2_bridge.hpp"
#include "mechanics/form_of_run.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/any_system.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/simulator.hpp"
#include "qdot/mechanics/first_order_form.hpp"
#include "qdot/mechanics/kinematic_system.hpp"

using namespace qdot;

namespace {

constexpr double rounded = 1e-11;  // some hundred operations, and the condition of M of a chain of eight
// q and q̇, and behind them the states of effects.
template <int n>
Eigen::VectorXd state(double shift, const Eigen::VectorXd& z = {}) {
  Eigen::VectorXd y(2 * n + z.size());
  for (Eigen::Index i = 0; i < 2 * n; ++i) y[i] = std::sin(1.0 + shift + 1.7 * static_cast<double>(i));
  y.tail(z.size()) = z;
  return y;
}
template <int n, class System>
double difference_of_duals(const System& system, const Eigen::VectorXd& z = {}) {
  const auto form = form_of_run(system);
  const auto duals = first_order_form(system.by(By::duals));
  evaluate_until_lines(form, state<n>(0.0, z));
  CHECK(is_by_lines(form.way_taken()));
  double worst = 0.0;
  for (int k = 0; k < 20; ++k) {
    const Eigen::VectorXd y = state<n>(0.3 * k, z);
    Eigen::VectorXd found(y.size()), expected(y.size());
    form.derivative(0.2, y, found);
    duals.derivative(0.2, y, expected);
    worst = std::max(worst, (found - expected).norm() / expected.norm());
  }
  return worst;
}

template <int n, class E>
double difference_from_duals(const E& energies) {
  return difference_of_duals<n>(mechanical_system<n>(energies));
}

struct ThreeBodies {
  auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  auto V(const auto& q) const {
    using std::sqrt;
    const auto inverse = [&](int a, int b) {
      const auto x = q[2 * a] - q[2 * b], y = q[2 * a + 1] - q[2 * b + 1];
      return 1.0 / sqrt(x * x + y * y);
    };
    return -inverse(0, 1) - inverse(0, 2) - inverse(1, 2);
  }
};
// One that is driven, and whose rod is as long as the caller says.
struct Driven {
  const double* length;
  auto T(const auto& q, const auto& v, const auto& t) const {
    using std::cos;
    const double l = *length;
    const auto drive = 0.3 * cos(2.0 * t);
    return 0.5 * l * l * (2.0 * v[0] * v[0] + v[1] * v[1]) + l * l * v[0] * v[1] * cos(q[0] - q[1]) + l * drive * (v[0] * cos(q[0]) + v[1] * cos(q[1]));
  }
  auto V(const auto& q) const {
    using std::cos;
    return -9.81 * (*length) * (2.0 * cos(q[0]) + cos(q[1]));
  }
};
// An inertia of the first coordinate that is zero where both angles are, less beside, and a root that has no value for q₁ < −1.
struct Ends {
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return (q[0] * q[0] - 0.5 * q[1] * q[1] * cos(q[0])) * v[0] * v[0] + 0.5 * v[1] * v[1];
  }
  auto V(const auto& q) const {
    using std::cos, std::sqrt;
    return cos(q[0]) * cos(q[1]) + sqrt(1.0 + q[1]);
  }
};

}  // namespace

TEST_CASE("a run's accelerations by lines are those by dual numbers") {
  CHECK(difference_from_duals<2>(bench::LoopedChain{}) < rounded);
  CHECK(difference_from_duals<3>(bench::UnrolledChain<3>{}) < rounded);
  CHECK(difference_from_duals<4>(bench::LoopedChain{}) < rounded);
  CHECK(difference_from_duals<7>(bench::LoopedChain{}) < rounded);
  CHECK(difference_from_duals<8>(bench::LoopedChain{}) < rounded);
  CHECK(difference_from_duals<6>(ThreeBodies{}) < rounded);
  const double length = 1.3;
  CHECK(difference_from_duals<2>(Driven{&length}) < rounded);
}

TEST_CASE("scenes with forces and bodies by their positions have such lines, too") {
  const auto chain = mechanical_system<4>(bench::LoopedChain{});
  CHECK(difference_of_duals<4>(scene(chain, viscous_damping(Vector<double, 4>(0.1, 0.2, 0.3, 0.4)))) < rounded);
  const auto push = generalized_force([](const auto& q, const auto& v, const auto& t) {
    using std::cos;
    using S = std::remove_cvref_t<decltype(q[0] * v[0])>;
    return Vector<S, 4>(S(cos(3.0 * t)), S(-0.1 * v[1] * q[0]), S(0.0), S(0.2));
  });
  CHECK(difference_of_duals<4>(scene(chain, push)) < rounded);
  const auto places = [](const auto& q, auto& bodies) {
    using std::cos, std::sin;
    bodies.point_mass(1.0, vector(sin(q[0]), -cos(q[0])));
    bodies.planar_body(2.0, 0.3, vector(sin(q[0]) + sin(q[1]), -cos(q[0]) - cos(q[1])), q[1]);
  };
  const auto bodies = kinematic_system<2>(places, uniform_gravity(0.0, -9.81));
  CHECK(difference_of_duals<2>(bodies) < rounded);
  CHECK(difference_of_duals<2>(scene(bodies, viscous_damping(Vector<double, 2>(0.1, 0.2)))) < rounded);
}

TEST_CASE("scenes with constraints have lines to accelerations, with forces and without") {
  const auto guided = [](auto length) {
    constexpr int n = length;
    return scene(mechanical_system<n>(bench::LoopedChain{}), holonomic("tip", bench::TipOfChain<n>{}));
  };
  CHECK(difference_of_duals<2>(guided(std::integral_constant<int, 2>())) < rounded);
  CHECK(difference_of_duals<4>(guided(std::integral_constant<int, 4>())) < rounded);
  CHECK(difference_of_duals<5>(guided(std::integral_constant<int, 5>())) < rounded);
  CHECK(difference_of_duals<8>(guided(std::integral_constant<int, 8>())) < rounded);
  const auto chain = mechanical_system<4>(bench::LoopedChain{});
  const auto damping = viscous_damping(Vector<double, 4>(0.1, 0.2, 0.3, 0.4));
  const auto turning = holonomic("turning", [](const auto& q, const auto& t) { return q[0] - 0.3 * t * t; });
  const auto rolling = nonholonomic("rolling", [](const auto& q, const auto& v) {
    using std::cos;
    return v[1] - cos(q[0]) * v[2] - 0.1;
  });
  CHECK(difference_of_duals<4>(scene(chain, damping, turning)) < rounded);
  CHECK(difference_of_duals<4>(scene(chain, rolling)) < rounded);
  CHECK(difference_of_duals<4>(scene(chain, damping, turning, rolling, holonomic("tip", bench::TipOfChain<4>{}))) < rounded);
  CHECK(difference_of_duals<6>(scene(mechanical_system<6>(bench::LoopedChain{}), holonomic("tip", bench::TipOfChain<6>{}), holonomic("held", [](const auto& q) {
                                       return q[1] - 0.2;
                                     }))) < rounded);
}

TEST_CASE("states of effects and phases have their rates by lines, and another phase goes another way") {
  const auto chain = mechanical_system<2>(bench::LoopedChain{});
  const auto servo = controller(
      [](const auto& q, const auto& v, const auto& z, const auto&) {
        using S = std::remove_cvref_t<decltype(q[0] * v[0] * z[0])>;
        return Vector<S, 2>(S(-2.0 * z[0]), S(-0.3 * v[1]));
      },
      [](const auto& q, const auto&, const auto& z, const auto&) {
        using S = std::remove_cvref_t<decltype(q[0] * z[0])>;
        return Vector<S, 1>(S(q[0] - 0.5 * z[0]));
      },
      Vector<double, 1>(0.2));
  CHECK(difference_of_duals<2>(scene(chain, servo), Vector<double, 1>(0.7)) < rounded);
  const auto floor = contact("floor", [](const auto& q) {
    using std::cos;
    return 3.0 - cos(q[0]) - cos(q[1]);
  });
  const auto landed = scene(chain, servo, floor);
  const double closed = static_cast<double>(ContactPhase::closed), apart = static_cast<double>(ContactPhase::apart);
  CHECK(difference_of_duals<2>(landed, Vector<double, 2>(0.7, closed)) < rounded);
  const auto form = form_of_run(landed);
  evaluate_until_lines(form, state<2>(0.0, Vector<double, 2>(0.7, closed)));
  const Eigen::VectorXd free = state<2>(0.4, Vector<double, 2>(0.7, apart));
  Eigen::VectorXd found(6), expected(6);
  form.derivative(0.2, free, found);
  first_order_form(landed.by(By::duals)).derivative(0.2, free, expected);
  CHECK((found - expected).norm() < rounded * expected.norm());
}

TEST_CASE("a constraint that is said twice, and one that has no slope, are seen to as without lines") {
  const auto chain = mechanical_system<2>(bench::LoopedChain{});
  const auto once = scene(chain, holonomic("tip", bench::TipOfChain<2>{}));
  const auto twice = scene(chain, holonomic("tip", bench::TipOfChain<2>{}), holonomic("again", bench::TipOfChain<2>{}));
  const auto form = form_of_run(twice);
  const Eigen::VectorXd y = state<2>(0.1);
  evaluate_until_lines(form, y);
  Eigen::VectorXd found(4), expected(4);
  form.derivative(0.0, y, found);
  first_order_form(once).derivative(0.0, y, expected);
  CHECK((found - expected).norm() < rounded * expected.norm());
  const auto flat = form_of_run(scene(chain, holonomic("flat", [](const auto& q) { return (q[0] - 0.5) * (q[0] - 0.5); })));
  evaluate_until_lines(flat, y);
  CHECK_THROWS_AS(flat.derivative(0.0, Eigen::VectorXd(Eigen::Vector4d(0.5, 0.1, 0.3, 0.0)), found), ConstraintError);
}

TEST_CASE("a constraint that becomes another in a run by lines ends the run by its name") {
  double height = 0.0;
  const auto rail = holonomic("rail", [&height](const auto& q) {
    using std::cos;
    return cos(q[0]) + cos(q[1]) - 1.7 + height;
  });
  const auto s = scene(mechanical_system<2>(bench::LoopedChain{}), rail);
  const double angle = std::acos(0.85);
  const auto observer = [&](const StepView& step) { height = step.t() > 300.0 ? 0.05 : 0.0; };
  const auto run = simulate(s, State<2>{0.0, {angle, -angle}, {0.4, 0.4}}, 400.0, Dop853{}, {.rtol = 1e-10}, observer);
  CHECK(run.statistics.evaluations > 2 * evaluations_until_lines);
  CHECK(run.outcome == Outcome::model_changed);
}

TEST_CASE("a force that becomes another in a run by lines ends the run by its name") {
  double strength = 1.0;
  const auto push = generalized_force([&strength](const auto& q, const auto&) {
    using S = std::remove_cvref_t<decltype(q[0])>;
    return Vector<S, 2>(S(strength), S(0.0));
  });
  const auto s = scene(mechanical_system<2>(bench::LoopedChain{}), push);
  const auto observer = [&](const StepView& step) { strength = step.t() > 300.0 ? 1.5 : 1.0; };
  const auto run = simulate(s, State<2>{0.0, {0.3, 0.2}, {0.0, 0.0}}, 400.0, Dop853{}, {.rtol = 1e-10}, observer);
  CHECK(run.statistics.evaluations > 2 * evaluations_until_lines);  // most of them before the change
  CHECK(run.outcome == Outcome::model_changed);
}

TEST_CASE("a controller that throws, or has no value any more, ends a run by lines") {
  struct Lost {};
  enum class Then { holds, throws, is_nan } then = Then::holds;
  const auto servo = controller(
      [&then](const auto& q, const auto& v, const auto& z, const auto&) {
        using S = std::remove_cvref_t<decltype(q[0] * v[0] * z[0])>;
        if (then == Then::throws) throw Lost{};
        const double gain = then == Then::is_nan ? std::nan("") : 0.1;
        return Vector<S, 2>(S(-gain * z[0]), S(0.0));
      },
      [](const auto& q, const auto&, const auto& z, const auto&) {
        using S = std::remove_cvref_t<decltype(q[0] * z[0])>;
        return Vector<S, 1>(S(q[0] - 0.5 * z[0]));
      },
      Vector<double, 1>(0.2));
  const auto s = scene(mechanical_system<2>(bench::LoopedChain{}), servo);
  const auto run_until_lost = [&](Then what) {
    then = Then::holds;
    const auto observer = [&](const StepView& step) { then = step.t() > 200.0 ? what : Then::holds; };
    return simulate(s, State<2>{0.0, {0.3, 0.2}, {0.0, 0.0}}, 300.0, Dop853{}, {.rtol = 1e-10}, observer);
  };
  const auto held = run_until_lost(Then::holds);
  CHECK(held.completed());
  CHECK(held.statistics.evaluations > 2 * evaluations_until_lines);
  CHECK_THROWS_AS(run_until_lost(Then::throws), Lost);
  CHECK(run_until_lost(Then::is_nan).outcome == Outcome::non_finite);
}

TEST_CASE("on one constraint a coordinate that is light has its acceleration to rounding") {
  for (const double light : {1e-3, 1e-7, 1e-12}) {  // T = ½ (v₀² + m v₁²), φ = q₁ − sin q₀, V = ½ k q₁²
    const auto energies = mechanical_system<2>([light](const auto& v) { return 0.5 * (v[0] * v[0] + light * v[1] * v[1]); },
                                               [](const auto& q) {
                                                 using std::cos;
                                                 return 0.5 * q[1] * q[1] + cos(q[1]) + 0.3 * cos(q[0]);
                                               });
    const auto form = form_of_run(scene(energies, holonomic("path", [](const auto& q) {
                                          using std::sin;
                                          return q[1] - sin(q[0]);
                                        })));
    const Eigen::VectorXd y = Eigen::Vector4d(0.7, std::sin(0.7), 0.4, 0.4 * std::cos(0.7));
    evaluate_until_lines(form, y);
    CHECK(is_by_lines(form.way_taken()));
    Eigen::VectorXd found(4);
    form.derivative(0.0, y, found);
    // By hand, with c = cos q₀: (1 + m c²) q̈₀ = Q₀ + c (Q₁ + m s v₀²), q̈₁ = c q̈₀ − s v₀²
    const double s = std::sin(0.7), c = std::cos(0.7), Q0 = 0.3 * s, Q1 = -y[1] + std::sin(y[1]), bend = s * 0.4 * 0.4;
    const double a0 = (Q0 + c * (Q1 + light * bend)) / (1.0 + light * c * c);
    CHECK(std::abs(found[2] - a0) < 1e-14);
    CHECK(std::abs(found[3] - (c * a0 - bend)) < 1e-14);
  }
}

// V has a kink at q₀ = 0: ∂V/∂q₀ is −sin q₀ cos q₁, and 2 q₀ besides where q₀ > 0.
TEST_CASE("functors that compare have lines on each side") {
  const auto bounded = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); },
                                            [](const auto& q) {
                                              using std::cos, std::max;
                                              const auto over = max(0.0, q[0]);
                                              return cos(q[0]) * cos(q[1]) + over * over;
                                            });
  const auto form = form_of_run(bounded);
  evaluate_until_lines(form, Eigen::Vector4d(-0.7, 0.4, 0.0, 0.0));
  CHECK(is_by_lines(form.way_taken()));
  for (const double q : {-0.7, 0.7, -0.2, 0.1, 1e-300, -1e-300, 0.0}) {
    Eigen::VectorXd ydot(4);
    form.derivative(0.0, Eigen::VectorXd(Eigen::Vector4d(q, 0.4, 0.0, 0.0)), ydot);
    CHECK(std::abs(ydot[2] - (std::sin(q) * std::cos(0.4) - (q > 0.0 ? 2.0 * q : 0.0))) < rounded);
  }
}

// Sixteen branches are kept; the others go as without lines.
TEST_CASE("functors with many branches have the numbers of each") {
  const auto stairs = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); },
                                           [](const auto& q) {
                                             using std::cos, std::floor;
                                             return cos(q[1]) * cos(q[0]) + floor(q[0]) * q[0];
                                           });
  const auto form = form_of_run(stairs);
  evaluate_until_lines(form, Eigen::Vector4d(0.5, 0.4, 0.0, 0.0));
  for (int k = 0; k < 40; ++k) {
    const double q = 0.5 + (k * 7) % 40;
    Eigen::VectorXd ydot(4);
    form.derivative(0.0, Eigen::VectorXd(Eigen::Vector4d(q, 0.4, 0.0, 0.0)), ydot);
    CHECK(std::abs(ydot[2] - (std::sin(q) * std::cos(0.4) - std::floor(q))) < rounded * (1.0 + q));
  }
}

TEST_CASE("threads that share a form whose functors compare have the numbers of one, whatever branches they are on") {
  const auto folds = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); },
                                          [](const auto& q) {
                                            using std::abs, std::cos, std::floor;
                                            return cos(q[1]) * cos(q[0]) + abs(q[1]) + floor(q[0]) * q[0];
                                          });
  const auto form = form_of_run(folds);
  evaluate_until_lines(form, Eigen::Vector4d(0.5, 0.4, 0.0, 0.0));
  const auto worst_of = [&](int thread) {
    double worst = 0.0;
    for (int k = 0; k < 400; ++k) {
      const double q0 = 0.5 + (k + 3 * thread) % 6, q1 = (k + thread) % 2 == 0 ? 0.4 : -0.4;
      Eigen::VectorXd ydot(4);
      form.derivative(0.0, Eigen::VectorXd(Eigen::Vector4d(q0, q1, 0.0, 0.0)), ydot);
      worst = std::max(worst, std::abs(ydot[2] - (std::sin(q0) * std::cos(q1) - std::floor(q0))));
    }
    return worst;
  };
  std::vector<double> worst(3);
  std::vector<std::thread> threads;
  for (int thread = 0; thread < 3; ++thread) threads.emplace_back([&, thread] { worst[static_cast<std::size_t>(thread)] = worst_of(thread); });
  for (std::thread& thread : threads) thread.join();
  for (const double each : worst) CHECK(each < 10 * rounded);
}

// No guard holds what they read.
TEST_CASE("functors that read a value itself, or ask whether it is infinite, have no lines") {
  const auto with_scale = [](const auto& is_above) {
    return mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); },
                                [=](const auto& q) {
                                  using std::cos;
                                  return cos(q[0]) * cos(q[1]) * (is_above(q[0]) ? 2.0 : 1.0);
                                });
  };
  const auto check = [&](const auto& system) {
    const auto form = form_of_run(system);
    evaluate_until_lines(form, Eigen::Vector4d(1.5, 0.4, 0.0, 0.0));
    for (const double q : {1.5, -0.5}) {
      Eigen::VectorXd ydot(4);
      form.derivative(0.0, Eigen::VectorXd(Eigen::Vector4d(q, 0.4, 0.0, 0.0)), ydot);
      CHECK(std::abs(ydot[2] - std::sin(q) * std::cos(0.4) * (q > 0.0 ? 2.0 : 1.0)) < rounded);
    }
  };
  check(with_scale([](const auto& x) { return innermost_value(x) > 0.0; }));
  check(with_scale([](const auto& x) {
    using std::exp, std::isinf;
    return isinf(exp(800.0 * x));
  }));
}

TEST_CASE("where functors are others by then, lines are derived anew") {
  double length = 1.0;
  auto form = form_of_run(mechanical_system<2>(Driven{&length}));
  const Eigen::VectorXd y = state<2>(0.4);
  evaluate_until_lines(form, y);
  for (const double l : {1.0, 2.0, 0.5}) {
    length = l;
    form.renew();
    const auto same = first_order_form(mechanical_system<2>(Driven{&l}).by(By::duals));
    Eigen::VectorXd found(4), expected(4);
    for (int i = 0; i < 2; ++i) {
      form.derivative(0.7, y, found);
      same.derivative(0.7, y, expected);
      CHECK((found - expected).norm() < rounded * expected.norm());
      evaluate_until_lines(form, y);
    }
  }
}

TEST_CASE("an inertia that ends and a root without a value are refused by their names") {
  const auto form = form_of_run(mechanical_system<2>(Ends{}));
  evaluate_until_lines(form, Eigen::Vector4d(0.5, 0.3, 0.1, 0.2));
  CHECK(is_by_lines(form.way_taken()));
  Eigen::VectorXd ydot(4);
  CHECK_THROWS_AS(form.derivative(0.0, Eigen::VectorXd(Eigen::Vector4d(0.0, 0.0, 0.1, 0.2)), ydot), SingularMassMatrix);
  CHECK_THROWS_AS(form.derivative(0.0, Eigen::VectorXd(Eigen::Vector4d(0.1, 0.5, 0.1, 0.2)), ydot), IndefiniteMassMatrix);
  CHECK_THROWS_AS(form.derivative(0.0, Eigen::VectorXd(Eigen::Vector4d(2.5, -1.5, 0.1, 0.2)), ydot), NonFinite);
}

TEST_CASE("threads that share a form have the numbers of one") {
  const auto form = form_of_run(mechanical_system<4>(bench::LoopedChain{}));
  const auto duals = first_order_form(mechanical_system<4>(bench::LoopedChain{}).by(By::duals));
  std::vector<double> worst(3, 0.0);
  std::vector<std::thread> threads;
  for (double& each : worst)
    threads.emplace_back([&] {
      for (int i = 0; i < evaluations_until_lines; ++i) {
        const Eigen::VectorXd y = state<4>(0.001 * i);
        Eigen::VectorXd found(8), expected(8);
        form.derivative(0.0, y, found);
        if (i % 100 != 0) continue;
        duals.derivative(0.0, y, expected);
        each = std::max(each, (found - expected).norm() / expected.norm());
      }
    });
  for (std::thread& thread : threads) thread.join();
  for (const double each : worst) CHECK(each < rounded);
}

TEST_CASE("a form of one's own and a simulator have the same bits, however often they are asked") {
  const auto chain = mechanical_system<4>(bench::LoopedChain{});
  const auto form = first_order_form(chain);
  const Eigen::VectorXd y = state<4>(0.2);
  Eigen::VectorXd first(8), last(8);
  form.derivative(0.0, y, first);
  evaluate_until_lines(form, y);
  form.derivative(0.0, y, last);
  CHECK(first == last);
  Simulator plant(chain, State<4>{0.0, {0.3, 0.2, 0.1, -0.1}, Vector<double, 4>::Zero()}, Dop853{}, {.rtol = 1e-9});
  const auto saved = plant.save();
  const auto gone_on = [&] {
    for (int k = 1; k <= 400; ++k) REQUIRE(plant.advance_to(1e-2 * k));
    return Vector<double, 4>(plant.q());
  };
  const Vector<double, 4> q = gone_on();
  plant.restore(saved);
  CHECK(q == gone_on());
}

TEST_CASE("a run of a hidden system has the bits of one of its type, however long it is") {
  const auto chain = mechanical_system<2>(bench::LoopedChain{});
  const State<2> start{0.0, {0.3, 0.2}, {0.0, 0.1}};
  const auto typed = simulate(chain, start, 60.0, Dop853{}, {.rtol = 1e-10});
  const auto hidden = simulate(AnySystem(chain), State<Dynamic>{0.0, start.q, start.qdot}, 60.0, Dop853{}, {.rtol = 1e-10});
  CHECK(typed.statistics.evaluations > 2 * evaluations_until_lines);
  CHECK(typed.y == hidden.y);
}

TEST_CASE("a Jacobian where the acceleration is infinite is refused") {
  const auto form = first_order_form(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                                          [](const auto& q, const auto& t) {
                                                            using std::exp;
                                                            return -q[0] * exp(t);
                                                          }));
  Eigen::MatrixXd J(2, 2);
  CHECK_THROWS_AS(form.jacobian(1000.0, Eigen::VectorXd(Eigen::Vector2d(0.1, 0.2)), J), NonFinite);
}
