// SPDX-License-Identifier: MIT
#include <cmath>
#include <string>
#include <vector>

#include "catch2_bridge.hpp"
#include "first_order_systems.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/cvode_automatic.hpp"
#include "qdot/integrate/simulate.hpp"
#include "scenes/elastic_pendulum.hpp"
#include "scenes/pendulum.hpp"

namespace {

using namespace qdot;
using test::vector;

constexpr double pi = 3.14159265358979323846;

bool mentions(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// A spring of 1e8 N/m: its oscillation, 1600 times a second, is damped away in a millisecond, and what is left is a pendulum.
auto stiff_elastic_pendulum() {
  const scenes::ElasticPendulum energies{.m = 1.0, .k = 1e8, .l0 = 1.0, .g = 9.81};
  return scene(mechanical_system<2>(energies), viscous_damping(Vector<double, 2>(2e4, 0.0)));
}

const State<2> swinging{0.0, {1.0, 0.5}, {0.0, 0.0}};

// A unit mass on a line, and V that compares: one type, so that it is compiled once.
enum class Kink { floor, gap, valley, hill, asked };
struct WithKink {
  Kink kink;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  template <class S>
  S V(const Vector<S, 1>& q) const {
    using std::abs, std::isfinite, std::max, std::min;
    const S x = q[0], below = min(x, S(0.0)), beyond = max(S(abs(x) - 0.5), S(0.0));
    switch (kink) {
      case Kink::floor: return S(9.81 * x + 0.5 * 1e4 * below * below);
      case Kink::gap: return S(2.0 * beyond * beyond);
      case Kink::valley: return S(3.0 * abs(x));
      case Kink::hill: return S(-abs(x));
      default: return isfinite(x) ? S(0.5 * x * x) : S(x);
    }
  }
};
auto with(Kink kink) { return mechanical_system<1>(WithKink{kink}); }
State<1> on_line(double q, double v) { return {0.0, Vector<double, 1>(q), Vector<double, 1>(v)}; }

// A unit mass on a spring of rate 2/s, and a force that compares.
enum class Law { pulse, braked, friction };
struct Oscillator {
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const { return 2.0 * q[0] * q[0]; }
};
auto pushed(Law law) {
  return scene(mechanical_system<1>(Oscillator{}), generalized_force([law](const auto& q, const auto& v, const auto& t) {
                 using S = std::decay_t<decltype(q[0] * t)>;
                 const S x = v[0];
                 if (law == Law::pulse) return t > 1.0 && t < 1.001 ? S(300.0 + 0.0 * q[0]) : S(0.0 * q[0]);
                 if (law == Law::braked) return x > 1.0 ? S(1.0 - x) : S(0.0 * x);
                 return x > 0.0 ? S(-1.0 + 0.0 * x) : S(1.0 + 0.0 * x);
               }));
}

// A bob on a spring without friction, in Cartesian coordinates: the direction in which it is stiff turns.
struct SpringPendulum {
  double k = 1e6;
  auto T(const auto& v) const { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }
  auto V(const auto& q) const {
    using std::sqrt;
    const auto stretch = sqrt(q[0] * q[0] + q[1] * q[1]) - 1.0;
    return 0.5 * k * stretch * stretch + 9.81 * q[1];
  }
};

// ẏ = J y.
test::FirstOrder linear(const Eigen::MatrixXd& J) {
  return {std::vector<std::string>(static_cast<std::size_t>(J.rows()), "y"), [J](double, const test::In& y, test::OutVector d) { d.noalias() = J * y; },
          [J](double, const test::In&, test::OutMatrix result) { result = J; }};
}

// A mass on a soft spring with a chain of stiff ones behind it, each with a damper: C = 2ζ/ω K for the fastest, of frequency ω.
Eigen::MatrixXd stiff_chain(double damping) {
  constexpr int n = 6;
  constexpr double k = 1e6, omega = 2e3;
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n), J = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  for (int i = 1; i < n; ++i) K(i, i) += k, K(i - 1, i - 1) += k, K(i, i - 1) -= k, K(i - 1, i) -= k;
  J.topRightCorner(n, n).setIdentity();
  J.bottomRightCorner(n, n) = -2 * damping / omega * K;
  K(0, 0) += 1.0;
  J.bottomLeftCorner(n, n) = -K;
  return J;
}

}  // namespace

TEST_CASE("an undamped stiff spring is followed as accurately as by the method that it began with") {
  // From an extrapolation to order 16 in long double.
  const auto exact = vector({0.27579188117637898, -0.96124680252520355, -4.1742585935314550, -1.1976757661387461});
  struct Case {
    double tolerance, error;  // of Dop853 at 1e-3, of Taylor else, twice
  };
  const auto [tolerance, error] = GENERATE(Case{1e-3, 1e-3}, Case{1e-6, 2e-5}, Case{1e-9, 3e-7});
  const auto run = simulate(mechanical_system<2>(SpringPendulum{}), State<2>{0.0, {1.0, 0.0}, {0.0, 0.0}}, 10.0, Automatic{},
                            {.rtol = tolerance, .atol = tolerance, .keep_trajectory = false});
  REQUIRE(run.completed());
  INFO(run.statistics.method_reason);
  CHECK((run.y - exact).cwiseAbs().maxCoeff() < error);
  CHECK(run.statistics.method == (tolerance > 1e-4 ? "dop853" : "taylor"));
}

TEST_CASE("what swings undamped is not stiff, alive or at rest; damped, it is") {
  const double tolerance = GENERATE(1e-3, 1e-6, 1e-9);
  const Options options{.rtol = tolerance, .atol = tolerance, .keep_trajectory = false};
  const auto method = [&](const auto& system, const Eigen::VectorXd& y, double t_end = 3.0) {
    const auto run = simulate(system, FirstOrderState{0.0, y}, t_end, Automatic{}, options);
    CHECK(run.completed());
    return run.statistics.method;
  };
  Eigen::VectorXd displaced = Eigen::VectorXd::Zero(12);
  displaced.head(6).setOnes();  // the stiff springs as they like to be
  CHECK(method(linear(stiff_chain(0.0)), displaced) == "dop853");
  CHECK(method(linear(stiff_chain(0.05)), displaced) == "dop853");
  CHECK(mentions(method(linear(stiff_chain(2.0)), displaced, 50.0), "cvode_bdf"));
  // A charge at rest in crossed fields of 1e4: it gyrates so little that it only drifts.
  Eigen::MatrixXd gyration = Eigen::MatrixXd::Zero(4, 4);
  gyration(0, 2) = gyration(1, 3) = 1.0;
  gyration(2, 0) = -1.0, gyration(2, 3) = 1e4, gyration(3, 2) = -1e4;
  CHECK(method(linear(gyration), vector({1, 0, 0, -1e-4})) == "dop853");
  // What grows fast is not stiff either, and least of all from rest.
  CHECK(method(linear(Eigen::Matrix2d{{1e3, 0}, {0, -1.0}}), vector({0, 1})) == "dop853");
}

TEST_CASE("a stiff method that gains little is left, and not soon tried again") {
  // The damped spring turns with the pendulum, and BDF needs a step for each degree or so.
  const auto damped = scene(mechanical_system<2>(SpringPendulum{}), generalized_force([](const auto& q, const auto& v) {
                              const auto rate = 400.0 * (q[0] * v[0] + q[1] * v[1]) / (q[0] * q[0] + q[1] * q[1]);
                              return qdot::vector(-rate * q[0], -rate * q[1]);
                            }));
  const State<2> start{0.0, {1.0, 0.0}, {0.0, 0.0}};
  const Options options{.rtol = 1e-6, .atol = 1e-6, .keep_trajectory = false};
  const auto exact = simulate(damped, start, 10.0, Dop853{}, {.rtol = 1e-11, .atol = 1e-11, .keep_trajectory = false});
  const auto automatic = simulate(damped, start, 10.0, Automatic{}, options);
  const auto stiff = simulate(damped, start, 10.0, CvodeBdf{}, options);
  REQUIRE(automatic.completed());
  INFO(automatic.statistics.method_reason);
  CHECK(automatic.statistics.method == "taylor, cvode_bdf");
  CHECK(mentions(automatic.statistics.method_reason, "; taylor from t = "));
  CHECK(5 * (automatic.y - exact.y).norm() < (stiff.y - exact.y).norm());
}

TEST_CASE("a pendulum given by T and V goes by its power series, and the run says why") {
  const auto pendulum = mechanical_system<1>(scenes::Pendulum{});
  const auto run = simulate(pendulum, State<1>{0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)}, 10.0, Automatic{}, {.rtol = 1e-12, .atol = 1e-12});
  CHECK(run.completed());
  CHECK(run.statistics.method == "taylor");
  CHECK(mentions(run.statistics.method_reason, "taylor: T and V are formulas"));
  // From an integration in quadruple precision.
  CHECK_THAT(run.y[0], WithinAbs(-0.46325276873178667, 1e-10));
}

TEST_CASE("few digits, or a system that is more than T and V, begin with Dop853") {
  const auto pendulum = mechanical_system<1>(scenes::Pendulum{});
  const State<1> start = on_line(1.0, 0.0);
  const auto few = simulate(pendulum, start, 10.0, Automatic{}, {.rtol = 1e-3, .atol = 1e-3});
  CHECK(few.statistics.method == "dop853");
  CHECK(mentions(few.statistics.method_reason, "few digits"));
  const auto kink = simulate(with(Kink::valley), start, 10.0, Automatic{}, {.rtol = 1e-3, .atol = 1e-3});
  CHECK(kink.statistics.method == "dop853");
  CHECK(mentions(kink.statistics.method_reason, "few digits"));
  const auto given = simulate(test::pendulum(), FirstOrderState{0.0, vector({3, 0})}, 50.0, Automatic{}, {.rtol = 1e-8, .atol = 1e-8});
  CHECK(given.statistics.method == "dop853");
  CHECK(mentions(given.statistics.method_reason, "more than T and V"));
}

TEST_CASE("V that branches goes by power series, one for each branch, and is right behind its kinks at every tolerance") {
  const double tolerance = GENERATE(1e-6, 1e-9, 1e-12);
  constexpr double g = 9.81, w = 100.0, speed = 2.0;
  const double flight = 2 * speed / g, on_floor = 2 / w * (pi - std::atan(speed * w / g));
  struct Case {
    Kink kink;
    double q0, v0, t, q, v;
  };
  for (const Case& c : {
           Case{Kink::floor, 0.0, speed, 6 * (flight + on_floor), 0.0, speed},
           Case{Kink::valley, 1.5, 0.0, 8.0 + 0.5, 1.5 * (1 - 0.25), -1.5},  // each quarter takes a second
           Case{Kink::gap, 0.0, 1.0, 3 * (pi + 2.0) + 0.25, 0.25, 1.0},      // half a turn of rate 2 at each end, and a second in the gap each way
       }) {
    CAPTURE(static_cast<int>(c.kink), tolerance);
    const auto run = simulate(with(c.kink), on_line(c.q0, c.v0), c.t, Automatic{}, {.rtol = tolerance, .atol = 1e-2 * tolerance, .keep_trajectory = false});
    CHECK(run.completed());
    CHECK(run.statistics.method == "taylor");
    CHECK(mentions(run.statistics.method_reason, "taylor: T and V are formulas on each branch"));
    // A speed changes with the acceleration, at most g, while the motion is late by as much.
    CHECK_THAT(run.y[0], WithinAbs(c.q, 50 * tolerance));
    CHECK_THAT(run.y[1], WithinAbs(c.v, 50 * g * tolerance));
  }
}

TEST_CASE("a push of a millisecond is felt by power series, and turns an oscillation as the integral of its force says") {
  const auto run = simulate(pushed(Law::pulse), on_line(1.0, 0.0), 7.0, Automatic{}, {.rtol = 1e-12, .atol = 1e-14, .keep_trajectory = false});
  CHECK(run.statistics.method == "taylor");
  CHECK(mentions(run.statistics.method_reason, "taylor: T, V and the forces are formulas on each branch"));
  const auto wave = [](double t) { return std::cos(2 * t); };
  CHECK_THAT(run.y[0], WithinAbs(wave(7.0) + 300.0 / 4 * (wave(7.0 - 1.001) - wave(7.0 - 1.0)), 1e-11));
}

TEST_CASE("a force with a kink in the speed keeps its power series, and friction at rest ends by name") {
  // Up to x' = 1 undamped: x = cos 2t, whose speed stays below that from the start to the first turn and beyond, till sin 2t = −1/2.
  const double met = 7 * pi / 12;
  const auto run = simulate(pushed(Law::braked), on_line(1.0, 0.0), met + 0.5, Automatic{}, {.rtol = 1e-12, .atol = 1e-14, .keep_trajectory = false});
  CHECK(run.statistics.method == "taylor");
  // From there x" = −4 x + 1 − x', about 1/4 with the damping 1/2.
  const double rate = std::sqrt(15.0) / 2, from = std::cos(2 * met) - 0.25, c = std::cos(rate * 0.5), s = std::sin(rate * 0.5);
  CHECK_THAT(run.y[0], WithinAbs(0.25 + std::exp(-0.25) * (from * c + (1.0 + 0.5 * from) / rate * s), 1e-11));
  const auto friction = simulate(pushed(Law::friction), on_line(0.3, 0.0), 20.0, Automatic{}, {.rtol = 1e-9, .atol = 1e-9});
  CHECK(friction.outcome == Outcome::zeno);
  CHECK_THAT(friction.t, WithinAbs(pi / 2, 1e-8));  // a half swing about 1/4 leads from 0.3 to 0.2, where friction holds
  CHECK(mentions(friction.message, "the comparison > in the force of an effect"));
}

TEST_CASE("a spring by a sensor of many cells, none of which the motion shows, is handed to Dop853") {
  // The place is rounded down to a multiple of w, so that the force is that of the spring to half a cell.
  const double w = 1e-5;
  const auto sensed = scene(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.0 * q[0]; }),
                            generalized_force([w](const auto& q, const auto&) {
                              using std::floor;
                              return -w * (floor(q[0] / w) + 0.5);
                            }));
  const auto run = simulate(sensed, on_line(1.0, 0.0), 7.0, Automatic{}, {.rtol = 1e-6, .atol = 1e-6, .keep_trajectory = false});
  REQUIRE(run.completed());
  CHECK(run.statistics.method == "taylor, dop853");
  CHECK(run.statistics.steps < 40'000);  // there are 400 000 cells on the way
  CHECK_THAT(run.y[0], WithinAbs(std::cos(7.0), 1e-4));
}

TEST_CASE("what Taylor refuses goes by Dop853 from the start: plain numbers, constraints that branch, dual numbers") {
  const Options options{.rtol = 1e-10, .atol = 1e-10, .keep_trajectory = false};
  const auto asked = simulate(with(Kink::asked), on_line(1.0, 0.0), 5.0, Automatic{}, options);
  CHECK(asked.statistics.method == "dop853");
  CHECK(mentions(asked.statistics.method_reason, "dop853: T or V asks for a plain number"));
  CHECK_THAT(asked.y[0], WithinAbs(std::cos(5.0), 1e-8));
  const auto bead = scene(mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }, [](const auto& q) { return 0.0 * q[0]; }),
                          holonomic("guide", [](const auto& q) {
                            using S = std::decay_t<decltype(q[0])>;
                            return q[0] < 5.0 ? S(q[1] - q[0]) : S(q[1] - 5.0);
                          }));
  const auto run = simulate(bead, State<2>{0.0, {-1.0, -1.0}, {0.5, 0.5}}, 3.0, Automatic{}, options);
  CHECK(run.statistics.method == "dop853");
  CHECK(mentions(run.statistics.method_reason, "dop853: the constraint 'guide' asks for a plain number, or is a constraint with a branch or a kink"));
  CHECK_THAT(run.y[0], WithinAbs(0.5, 1e-9));
  const auto by_duals = simulate(with(Kink::gap), on_line(0.0, 1.0), 0.25, Automatic{}, {.rtol = 1e-10, .atol = 1e-10, .by = By::duals});
  CHECK(by_duals.statistics.method == "dop853");
  CHECK(mentions(by_duals.statistics.method_reason, "dual numbers have no power series"));
}

TEST_CASE("a motion that may go two ways ends where Dop853 ends it, and a start at zero without atol is no reason to refuse a run") {
  const auto hill = simulate(with(Kink::hill), on_line(0.0, 0.0), 1.0, Automatic{}, {.rtol = 1e-9, .atol = 1e-9});
  CHECK(hill.outcome == Outcome::refused_by_model);
  const auto run = simulate(with(Kink::valley), on_line(0.0, 3.0), 1.0, Automatic{}, {.rtol = 1e-9, .atol = 0.0});
  CHECK(run.completed());
  CHECK(mentions(run.statistics.method_reason, "dop853"));
  CHECK_THAT(run.y[0], WithinAbs(3.0 - 1.5, 1e-8));
}

TEST_CASE("an oscillation that goes on is followed and not called stiff, at any tolerance") {
  const double tolerance = GENERATE(1e-2, 1e-3, 1e-5, 1e-9);
  const auto run = simulate(test::oscillator(), FirstOrderState{0.0, vector({1, 0})}, 200.0, Automatic{}, {.rtol = tolerance, .atol = tolerance});
  CHECK(run.completed());
  CHECK(run.statistics.method == "dop853");
}

TEST_CASE("a stiff spring with friction is handed to BDF, which needs a twentieth of the evaluations") {
  const Options options{.rtol = 1e-7, .atol = 1e-9, .keep_trajectory = false};
  const auto system = stiff_elastic_pendulum();
  const auto automatic = simulate(system, swinging, 1.0, Automatic{}, options);
  const auto explicit_ = simulate(system, swinging, 1.0, Dop853{}, options);
  REQUIRE(automatic.completed());
  REQUIRE(explicit_.completed());
  CHECK(automatic.statistics.method == "taylor, cvode_bdf");
  CHECK(mentions(automatic.statistics.method_reason, "taylor: T, V and the forces are formulas"));
  CHECK(mentions(automatic.statistics.method_reason, "; cvode_bdf from t = "));
  CHECK(mentions(automatic.statistics.method_reason, "stability, not accuracy"));
  const long cost = automatic.statistics.evaluations + 4 * automatic.statistics.jacobians;
  CHECK(20 * cost < explicit_.statistics.evaluations);
  CHECK_THAT(automatic.y[1], WithinAbs(explicit_.y[1], 1e-5));
}

TEST_CASE("van der Pol's oscillator with its jumps costs little more than with BDF from the start") {
  const auto start = FirstOrderState{0.0, vector({2, 0})};
  const Options options{.rtol = 1e-6, .atol = 1e-6, .keep_trajectory = false};
  const auto cost = [](const Statistics& s) { return s.evaluations + 2 * s.jacobians; };
  const auto automatic = simulate(test::van_der_pol(1e-6), start, 2.0, Automatic{}, options);
  const auto stiff = simulate(test::van_der_pol(1e-6), start, 2.0, CvodeBdf{}, options);
  REQUIRE(automatic.completed());
  CHECK(mentions(automatic.statistics.method, "cvode_bdf"));
  CHECK(cost(automatic.statistics) < 3 * cost(stiff.statistics));
}

TEST_CASE("when the friction goes, so does BDF") {
  // ẏ = −k(t) y + cos t with k falling from 1e5 to 1 at t = 1.
  const auto k = [](double t) { return t < 1.0 ? 1e5 : 1.0; };
  const test::FirstOrder fading{{"y"},
                                [k](double t, const test::In& y, test::OutVector d) { d[0] = -k(t) * y[0] + std::cos(t); },
                                [k](double t, const test::In&, test::OutMatrix J) { J(0, 0) = -k(t); }};
  const auto run = simulate(fading, FirstOrderState{0.0, vector({1})}, 100.0, Automatic{}, {.rtol = 1e-8, .atol = 1e-10});
  REQUIRE(run.completed());
  CHECK(run.statistics.method == "dop853, cvode_bdf");
  CHECK(mentions(run.statistics.method_reason, "; dop853 from t = "));
  CHECK_THAT(run.y[0], WithinAbs((std::cos(100.0) + std::sin(100.0)) / 2, 1e-6));
}

TEST_CASE("a choice depends on nothing but the run: twice the same is the same to the last bit") {
  const Options options{.rtol = 1e-7, .atol = 1e-9};
  const auto form = first_order_form(stiff_elastic_pendulum());
  const Eigen::VectorXd y0 = form.packed(swinging);
  auto stepper = Automatic{}.stepper(form, options);
  Eigen::VectorXd first;
  long steps = 0;
  for (int round = 0; round < 2; ++round) {  // the same stepper again, which must forget
    const long before = stepper.statistics().steps;
    stepper.reset(0.0, y0);
    while (stepper.t() != 0.1) REQUIRE(stepper.step(0.1));
    if (round == 0) {
      first = stepper.y();
      steps = stepper.statistics().steps - before;
    } else {
      CHECK(first == stepper.y());
      CHECK(steps == stepper.statistics().steps - before);
    }
  }
}

TEST_CASE("it goes backward, and lands where it is told") {
  const auto forth = simulate(test::pendulum(), FirstOrderState{0.0, vector({2, 0})}, 3.7, Automatic{}, {.rtol = 1e-11, .atol = 1e-11, .stop_times = {1.1}});
  CHECK(forth.t == 3.7);
  CHECK(forth.statistics.restarts == 1);
  const auto back = simulate(test::pendulum(), FirstOrderState{forth.t, forth.y}, 0.0, Automatic{}, {.rtol = 1e-11, .atol = 1e-11});
  CHECK(back.t == 0.0);
  CHECK((back.y - vector({2, 0})).norm() < 1e-8);
}

TEST_CASE("a start at which a force is not analytic begins with Dop853") {
  const auto dragged = scene(mechanical_system<1>(scenes::Pendulum{}), quadratic_drag([](const auto& q) {
                               using std::cos, std::sin;
                               return qdot::vector(sin(q[0]), -cos(q[0]));
                             }, 0.1));
  const Options options{.rtol = 1e-9, .atol = 1e-9};
  const auto run = simulate(dragged, State<1>{0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)}, 5.0, Automatic{}, options);
  REQUIRE(run.completed());
  CHECK(mentions(run.statistics.method, "dop853"));
  CHECK(mentions(run.statistics.method_reason, "the motion is not analytic at the start"));
}

TEST_CASE("what no method can do is a named outcome") {
  const auto pole = simulate(test::blow_up(), FirstOrderState{0.0, vector({1})}, 2.0, Automatic{});
  CHECK(failed(pole.outcome));
  CHECK(pole.t > 0.99);
  const auto nan = simulate(test::pendulum_until(1.0, [](test::OutVector d) { d[1] = test::nan; }), FirstOrderState{0.0, vector({1, 0})}, 2.0, Automatic{});
  CHECK(nan.outcome == Outcome::non_finite);
  CHECK(nan.t > 0.9);
}
