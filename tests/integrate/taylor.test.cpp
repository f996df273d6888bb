// SPDX-License-Identifier: MIT
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "../catch2_bridge.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/taylor.hpp"
#include "qdot/mechanics/velocity.hpp"

namespace {

using namespace qdot;

constexpr double pi = 3.14159265358979323846;
constexpr double tolerances[] = {1e-6, 1e-9, 1e-12, 1e-13, 2.5e-15};

// n bobs of mass 1 on rods of length 1, angles from the downward vertical.
struct Chain {
  template <class S>
  S T(const Vector<S, Dynamic>& q, const Vector<S, Dynamic>& qdot) const {
    using std::cos, std::sin;
    S vx(0.0), vy(0.0), sum(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      vx += cos(q[k]) * qdot[k];
      vy += sin(q[k]) * qdot[k];
      sum += vx * vx + vy * vy;
    }
    return 0.5 * sum;
  }
  template <class S>
  S V(const Vector<S, Dynamic>& q) const {
    using std::cos;
    S y(0.0), sum(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) sum += y -= cos(q[k]);
    return 9.81 * sum;
  }
};

State<Dynamic> at_rest(Eigen::Index n, double angle) {
  return {0.0, Eigen::VectorXd::Constant(n, angle), Eigen::VectorXd::Zero(n)};
}

// A unit mass on a line in one of several potentials: one type for all of them, so that the methods are compiled once.
enum class Well { quartic, quadratic_and_quartic, sixteenth, pendulum, edge, spring };
struct Particle {
  Well well;
  double omega = 1.0;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const {
    using S = std::remove_cvref_t<decltype(q[0])>;
    using std::cos, std::pow;
    switch (well) {
      case Well::quartic: return S(0.25 * q[0] * q[0] * q[0] * q[0]);
      case Well::quadratic_and_quartic: return S(0.5 * q[0] * q[0] + 0.25 * pow(q[0], 4));
      case Well::sixteenth: return S(pow(q[0], 16) / 16.0);  // the first coefficient after t is that of t¹⁷
      case Well::pendulum: return S(-9.81 * cos(q[0]));
      case Well::edge: return S(-2.0 / 3.0 * pow(1.0 - q[0], 1.5));
      default: return S(0.5 * omega * omega * q[0] * q[0]);
    }
  }
};
auto particle(Well well, double omega = 1.0) { return mechanical_system<1>(Particle{well, omega}); }
State<1> on_line(double x, double v) { return {0.0, Vector<double, 1>(x), Vector<double, 1>(v)}; }

// By a method that shares nothing with series but the functors.
template <class System, class Start>
Eigen::VectorXd reference(const System& system, const Start& start, double t) {
  return simulate(system, start, t, Dop853{}, {.rtol = 1e-14, .atol = 1e-15, .keep_trajectory = false}).y;
}

// Every kind of node: quotients, powers, squares, functions of one and of two arguments, the time.
struct AllKinds {
  auto T(const auto& q, const auto& v, const auto& t) const {
    using std::atan2, std::exp, std::hypot, std::sin, std::tanh;
    return 0.5 * v[0] * v[0] * (2.0 + atan2(q[1], 2.0 + q[0] * q[0])) / (1.0 + exp(q[1])) + 0.5 * v[1] * v[1] * (3.0 + sin(t)) +
           0.1 * v[0] * v[1] * tanh(q[0]) + 0.2 * hypot(q[0], q[0]) * v[1] * v[1];
  }
  auto V(const auto& q, const auto& t) const {
    using std::acos, std::acosh, std::asin, std::asinh, std::atan, std::atanh, std::cbrt, std::cos, std::cosh, std::erf, std::erfc, std::expm1, std::hypot,
        std::log, std::log1p, std::pow, std::sin, std::sinh, std::tan;
    return log(2.0 + q[0] * q[0] * q[1] * q[1]) + 1.4 * pow(1.5 + sin(q[0]), 2.5) + hypot(q[0], q[1] + 1.9) * cos(0.7 * t) + pow(q[1], 3) +
           atan(q[0] - q[1]) + cosh(q[1]) / (2.0 + cos(q[0])) + asin(0.25 * q[0]) - erf(q[1]) + expm1(q[0]) + cbrt(3.0 + q[0]) + log1p(q[1] * q[1]) +
           sinh(q[0]) + tan(0.3 * q[1]) + acos(0.2 * q[0]) + asinh(q[1]) + acosh(2.5 + q[0]) + atanh(0.2 * q[1]) + erfc(q[0]);
  }
};

struct TwoRods {
  double m1 = 1.0, g = 9.81;
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return 0.5 * (m1 + 1.0) * v[0] * v[0] + 0.5 * v[1] * v[1] + v[0] * v[1] * cos(q[0] - q[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -(m1 + 1.0) * g * cos(q[0]) - g * cos(q[1]);
  }
};

TEST_CASE("the series fulfils the equations of motion, whatever T and V depend on") {
  const auto check = [](const auto& system, const auto& q, const auto& v, double t0) {
    using Sys = std::decay_t<decltype(system)>;
    constexpr int order = 20;
    const auto made = detail::PowerSeriesOf<FirstOrderForm<Sys>>::made(FirstOrderForm<Sys>(system), order);
    detail::PowerSeries& series = *made;
    const Eigen::Index n = system.dof();
    Eigen::VectorXd y(2 * n);
    y << q, v;
    const double unit = 0.5, t = t0 + 0.02, s = 0.02 / unit;
    series.start(t0, y.data(), unit);
    series.expand(order);
    Eigen::VectorXd at = Eigen::VectorXd::Zero(2 * n), rate = at;
    for (int k = order; k >= 0; --k) at = at * s + series.coefficients().col(k);
    for (int k = order; k >= 1; --k) rate = rate * s + k * series.coefficients().col(k);
    using V = Vector<double, Sys::dof_at_compile_time>;
    const V qddot = acceleration(system, V(at.head(n)), V(at.tail(n)), t);
    CHECK((rate.head(n) / unit - at.tail(n)).norm() < 1e-13);
    CHECK((rate.tail(n) / unit - qddot).norm() < 1e-11 * (1 + qddot.norm()));
  };
  using Eigen::Vector2d;
  check(mechanical_system<2>(AllKinds{}), Vector2d(0.5, 0.3), Vector2d(0.4, -0.6), 0.2);
  for (const TwoRods& rods : {TwoRods{}, TwoRods{.m1 = 0.0}, TwoRods{.g = 0.0}, TwoRods{.g = -9.81}})
    check(mechanical_system<2>(rods), Vector2d(0.5, -0.8), Vector2d(1.2, 0.3), 0.0);
  check(mechanical_system(5, Chain{}), Eigen::VectorXd(Eigen::VectorXd::LinSpaced(5, 0.2, 1.9)),
        Eigen::VectorXd(Eigen::VectorXd::LinSpaced(5, -1.0, 0.7)), 0.0);
  // A driven pivot, T(q, q̇, t), and a potential that depends on time.
  check(mechanical_system<2>(
            [](const auto& q, const auto& v, const auto& t) {
              using std::cos, std::sin;
              const auto vx = v[1] + 0.3 * cos(2.0 * t) + v[0] * cos(q[0]);
              const auto vy = v[0] * sin(q[0]);
              return 0.5 * (vx * vx + vy * vy) + 0.5 * v[1] * v[1];
            },
            [](const auto& q, const auto& t) {
              using std::cos, std::sin;
              return -9.81 * cos(q[0]) + 0.5 * q[1] * q[1] * (2.0 + sin(t));
            }),
        Vector2d(0.7, -0.2), Vector2d(0.3, 1.1), 0.4);
  // Relativistic: T is not quadratic in q̇, M depends on q̇.
  check(mechanical_system<1>(
            [](const auto& v) {
              using std::sqrt;
              return 1.0 - sqrt(1.0 - v[0] * v[0]);
            },
            [](const auto& q) { return 0.5 * q[0] * q[0]; }),
        Vector<double, 1>(0.3), Vector<double, 1>(0.6), 0.0);
  // A Lagrangian with an indefinite mass matrix: ẋẏ − xy + ⅓x³.
  check(mechanical_system<2>([](const auto& v) { return v[0] * v[1]; },
                             [](const auto& q) { return q[0] * q[1] - q[0] * q[0] * q[0] / 3.0; })
            .with_indefinite_mass_matrix(),
        Vector2d(0.4, 0.1), Vector2d(-0.3, 0.5), 0.0);
  // Positions instead of velocities: T through dual numbers of the recording scalar.
  check(mechanical_system<2>(
            [](const auto& q, const auto& v) {
              const auto place = [](const auto& x) {
                using std::cos, std::sin;
                return vector(x[0] * cos(x[1]), x[0] * sin(x[1]));
              };
              return 0.5 * velocity_of(place, q, v).squaredNorm();
            },
            [](const auto& q) { return -1.0 / q[0]; }),
        Vector2d(1.2, 0.3), Vector2d(0.1, 0.8), 0.0);
}

// The bits of the coefficients of one expansion; after `evaluations` of them orders are made by machine code, where there is some.
std::vector<std::uint64_t> bits_of(detail::PowerSeries& series, const Eigen::VectorXd& y, int order) {
  series.start(0.1, y.data(), 0.25);
  series.expand(order);
  std::vector<std::uint64_t> bits;
  for (int k = 0; k <= order; ++k)
    for (Eigen::Index i = 0; i < y.size(); ++i) bits.push_back(std::bit_cast<std::uint64_t>(series.coefficients()(i, k)));
  return bits;
}
constexpr long expansions_till_native = 2 * formula::LineEvaluator::begin_after / 12;

TEST_CASE("the series of a motion by machine code has the bits of that by the interpreter") {
  constexpr int order = 12;
  const auto form = first_order_form(mechanical_system<2>(AllKinds{}));
  const auto series = detail::PowerSeriesOf<std::remove_cvref_t<decltype(form)>>::made(form, order);
  const Eigen::Vector4d y(0.5, 0.3, 0.4, -0.6);
  const std::vector<std::uint64_t> interpreted = bits_of(*series, y, order);
  for (long i = 0; i < expansions_till_native; ++i) REQUIRE(bits_of(*series, y, order) == interpreted);
}

TEST_CASE("a reset makes new equations after is_current() has said that the functors changed") {
  double k = 1.0;
  const auto spring = [&k](const auto& q) { return 0.5 * k * q[0] * q[0]; };
  const auto form = first_order_form(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, spring));
  auto stepper = Taylor{}.stepper(form, {.rtol = 1e-12, .atol = 1e-12});
  const Eigen::Vector2d y(1.0, 0.0);
  stepper.reset(0.0, y);
  for (int i = 0; i < 3; ++i) REQUIRE(stepper.step(9.0));
  CHECK(stepper.is_current());
  k = 4.0;
  CHECK_FALSE(stepper.is_current());
  CHECK_FALSE(stepper.is_current());
  stepper.reset(0.0, y);
  REQUIRE(stepper.step(0.25));
  CHECK_THAT(stepper.y()[0], WithinAbs(std::cos(2.0 * stepper.t()), 1e-11));  // ten times the tolerance
}

TEST_CASE("the double pendulum is right to the tolerance") {
  // From a Taylor series in quadruple precision.
  const Eigen::Vector4d end(1.9234881444441958, 1.1485248782344042, 1.1168305154489508, -0.3371732877010639);
  for (const double tol : tolerances) {
    const auto run = simulate(mechanical_system(2, Chain{}), at_rest(2, 1.7), 3.0, Taylor{}, {.rtol = tol, .atol = tol});
    CHECK(run.completed());
    CHECK(run.t == 3.0);
    CHECK((run.y - end).norm() < std::max(20 * tol, 1e-13));
  }
}

TEST_CASE("pendulums released at rest from the horizontal are right at every tolerance") {
  // Three of four coefficients of every series vanish at the start; a step chosen from two of them is absurd.
  for (const Eigen::Index n : {1, 2, 3}) {
    const auto system = mechanical_system(n, Chain{});
    const Eigen::VectorXd exact = reference(system, at_rest(n, pi / 2), 3.0);
    for (const double tol : tolerances) {
      const auto run = simulate(system, at_rest(n, pi / 2), 3.0, Taylor{}, {.rtol = tol, .atol = tol});
      CHECK(run.completed());
      CHECK((run.y - exact).norm() < std::max(200 * tol, 5e-12));  // the motion of three is chaotic
    }
  }
}

TEST_CASE("potentials that are flat where the motion starts are right at every tolerance") {
  const auto check = [](Well well, double amplification) {
    const auto system = particle(well);
    const Eigen::VectorXd exact = reference(system, on_line(0.0, 1.0), 10.0);
    for (const double tol : tolerances) {
      const auto run = simulate(system, on_line(0.0, 1.0), 10.0, Taylor{}, {.rtol = tol, .atol = tol});
      CHECK(run.completed());
      CHECK((run.y - exact).norm() < std::max(amplification * tol, 1e-11));
    }
  };
  check(Well::quartic, 50);
  check(Well::quadratic_and_quartic, 50);
  check(Well::sixteenth, 500);
  const auto tiny = simulate(particle(Well::quadratic_and_quartic), on_line(1e-300, 1.0), 10.0, Taylor{}, {.rtol = 1e-12});
  CHECK_THAT(0.5 * tiny.y[1] * tiny.y[1] + 0.5 * tiny.y[0] * tiny.y[0] + 0.25 * std::pow(tiny.y[0], 4), WithinAbs(0.5, 1e-11));
}

TEST_CASE("whole powers of zero have a series, however high: x'' = t^80 gives t^82/6642") {
  const auto pushed = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                           [](const auto& q, const auto& t) {
                                             using std::pow;
                                             return -q[0] * (0.75 * pow(t, 80) + 0.25 * pow(t, 80.0));
                                           });
  const auto run = simulate(pushed, on_line(0.0, 0.0), 1.0, Taylor{}, {.rtol = 1e-12, .atol = 1e-15});
  CHECK(run.completed());
  CHECK_THAT(run.y[0], WithinAbs(1.0 / 6642.0, 1e-13));
}

TEST_CASE("under a constant force the series ends with the square of time") {
  // A momentum and a force that are constants in the recording: x at constant speed, y in uniform gravity.
  const auto T = [](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); };
  const auto thrown = mechanical_system<2>(T, [](const auto& q) { return 9.81 * q[1]; });
  const auto run = simulate(thrown, State<2>{0.0, {0.0, 0.0}, {10.0, 4.0}}, 0.5, Taylor{});
  CHECK(run.completed());
  CHECK(run.statistics.steps <= 2);
  const Eigen::Vector4d parabola(5.0, 4.0 * 0.5 - 0.5 * 9.81 * 0.25, 10.0, 4.0 - 9.81 * 0.5);
  CHECK((run.y - parabola).norm() < 1e-14);
}

TEST_CASE("the Taylor stepper holds its tolerances per component") {
  for (const double A : {1.0, 1e8, 1e12}) {
    const auto both = mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); },
                                           [](const auto& q) {
                                             using std::cos;
                                             return -9.81 * cos(q[0]) + 0.005 * q[1] * q[1];
                                           });
    const auto alone = particle(Well::pendulum);
    const Eigen::VectorXd exact = reference(alone, on_line(1.0, 0.0), 10.0);
    const auto run = simulate(both, State<2>{0.0, {1.0, A}, {0.0, 0.0}}, 10.0, Taylor{}, {.rtol = 1e-9, .atol = 1e-9});
    CHECK_THAT(run.y[0], WithinAbs(exact[0], 2e-8));
    CHECK_THAT(run.y[1], WithinAbs(A * std::cos(1.0), 1e-8 * A));
  }
}

TEST_CASE("the order of convergence is the order asked for, forward and backward in time") {
  // A planet with e = 0.19: no coefficient vanishes, and the nearest pole in complex time is a whole unit away.
  const auto planet = mechanical_system<2>([](const auto& q, const auto& v) { return 0.5 * (v[0] * v[0] + q[0] * q[0] * v[1] * v[1]); },
                                           [](const auto& q) { return -1.0 / q[0]; });
  const State<2> start{0.0, {1.0, 0.0}, {0.1, 1.1}};
  for (const double t_end : {2.0, -2.0}) {
    const Eigen::VectorXd exact = reference(planet, start, t_end);
    for (const int order : {6, 9, 12}) {
      const auto error = [&](double h) {
        return (simulate(planet, start, t_end, Taylor{.order = order},
                         {.rtol = 0.9, .atol = 1e9, .max_step = h, .keep_trajectory = false}).y - exact).norm();
      };
      const double h = order == 6 ? 0.125 : order == 9 ? 0.25 : 0.5;
      const double measured = std::log2(error(h) / error(h / 2));
      INFO("order " << order << " to t = " << t_end << ", errors " << error(h) << ", " << error(h / 2));
      CHECK(measured > order - 0.7);
      CHECK(measured < order + 2.0);
    }
  }
}

TEST_CASE("forth and back returns to the start, and the series is the dense output") {
  const auto system = mechanical_system(2, Chain{});
  const Options options{.rtol = 1e-12, .atol = 1e-12};
  const auto forth = simulate(system, at_rest(2, 1.7), 3.0, Taylor{}, options);
  const auto back = simulate(system, forth.state(), 0.0, Taylor{}, options);
  CHECK(back.t == 0.0);
  CHECK((back.y - Eigen::Vector4d(1.7, 1.7, 0, 0)).norm() < 100 * 1e-12);
  for (const double t : {0.1, 1.0, 1.777, 2.999})
    CHECK((forth.trajectory.y(t) - back.trajectory.y(t)).norm() < 100 * 1e-12);
}

TEST_CASE("the energy of a Kepler orbit changes by rounding only") {
  const auto kepler = mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); },
                                           [](const auto& q) {
                                             using std::sqrt;
                                             return -1.0 / sqrt(q[0] * q[0] + q[1] * q[1]);
                                           });
  double worst = 0.0;
  const auto run = simulate(kepler, State<2>{0.0, {0.4, 0.0}, {0.0, 2.0}}, 500 * 2 * pi, Taylor{},
                            {.rtol = 2.5e-15, .atol = 1e-16, .keep_trajectory = false}, [&](const StepView& step) {
                              worst = std::max(worst, std::abs(energy(kepler, State<2>{0.0, step.q(), step.qdot()}) + 0.5));
                            });
  CHECK(run.completed());
  CHECK(worst < 1e-14);
}

// A unit mass on a line, and V that compares: one type, so that it is compiled once.
enum class Kink { gap, ball, valley, ledge, oscillator, moving, ramp, equal, shelf, saw, pulse, switched, stairs, hill, root, step };
struct Branching {
  Kink kink;
  double k = 1.0;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  template <class S>
  S V(const Vector<S, 1>& q, const S& t) const {
    using std::abs, std::floor, std::max, std::min, std::sqrt;
    const S& x = q[0];
    switch (kink) {
      case Kink::gap: return S(2.0 * max(S(abs(x) - 0.5), S(0.0)) * max(S(abs(x) - 0.5), S(0.0)));
      case Kink::ball: return S(9.81 * x + 0.5 * k * min(x, S(0.0)) * min(x, S(0.0)));
      case Kink::valley: return S(k * abs(x));
      case Kink::ledge: return S(-0.1 * min(x, S(0.25)));
      case Kink::oscillator: return S(x * x - (x > 0.4 ? S(0.6 * (x - 0.4)) : S(0.0)));
      case Kink::moving: return S(x * x - (x > 0.1 * t ? S(0.5 * (x - 0.1 * t)) : S(0.0)));
      case Kink::ramp: return S(2.0 * x * x - max(S(t - 1.0), S(0.0)) * x);
      case Kink::equal: return x < 0.3 ? S(x * x) : S(0.5 * 2.0 * x * x);
      case Kink::shelf: return S(0.5 * x * x + (x > 1.0 ? S(0.5 * (x - 1.0)) : S(0.0)));
      case Kink::saw: return S(x * x - 1.5 * (t - floor(t) - 0.5) * x);
      case Kink::pulse: return S(-(t > 1.0 && t < 1.001 ? S(1000.0 * x) : S(0.0)));
      case Kink::switched: return S(0.5 * x * x - (t < 2.0 ? x : S(0.0)));
      case Kink::stairs: return S((floor(x) + 0.5) * x - 0.5 * floor(x) * (floor(x) + 1.0));
      case Kink::hill: return S(-abs(x));
      case Kink::root: return sqrt(x) < 1.0 ? S(x) : S(2.0 * x - 1.0);
      default: return x > 0.0 ? S(0.5) : S(0.0);
    }
  }
};
auto branching(Kink kink, double k = 1.0) { return mechanical_system<1>(Branching{kink, k}); }

const Options tight{.rtol = 1e-13, .atol = 1e-15, .keep_trajectory = false};
constexpr double rounded_in_a_run = 2e-14;  // of positions and speeds of the order of one, after ten to fifty steps

TEST_CASE("V that branches is right to rounding behind its kinks, forward and backward in time") {
  struct Case {
    Kink kink;
    double k, t0, q0, v0, t, q, v, margin;  // closed forms in 25 digits; how many times more than others rounding is enlarged
  };
  for (const Case& c : {
           Case{Kink::gap, 1.0, 0.0, 1.5, 0.0, 10.0, -1.259687912858821273848146, -1.300575680314233731659481, 1},
           Case{Kink::gap, 1.0, 10.0, 1.5, 0.0, 0.0, -1.259687912858821273848146, 1.300575680314233731659481, 1},
           Case{Kink::ball, 1e4, 0.0, 1.0, 0.0, 10.0, 0.6044745637802028657758592, 2.785715179021792989973506, 20},
           Case{Kink::ball, 1e8, 0.0, 0.25, 0.0, 22.75, 0.1273879125589800937704475, -1.551015523968993252382314, 100},  // 50 contacts of 0.3 ms
           Case{Kink::valley, 1.25, 0.0, 1.0, 0.4, 53.0, 0.9141949928350652538435864, -0.6119742787996378554616161, 10},
           Case{Kink::valley, 1.0, 0.0, 0.0, 1.0, 3.0, -0.5, 0.0, 1},  // begins on the kink
           Case{Kink::ledge, 1.0, 0.0, 0.0, 0.0, 4.0, 0.6444271909999159033890110, 0.2236067977499789758472527, 1},
           Case{Kink::oscillator, 1.0, 0.0, -1.0, 0.2, 12.0, 1.228449695305241455092401, 0.1263421013566283346984647, 1},
           Case{Kink::moving, 1.0, 0.0, -0.8, 0.0, 9.0, -0.5871981017949785405949225, -0.9656903442227850063908590, 1},
           Case{Kink::ramp, 1.0, 0.0, 0.3, 0.0, 8.0, 1.338876236441125829577846, 0.3885576854470807719157037, 1},
           Case{Kink::equal, 1.0, 0.0, -1.0, 0.0, 9.0, -0.9869789215995270908975227, 0.2274757495568903761116619, 1},
           Case{Kink::shelf, 1.0, 0.0, 0.0, 1.0000009536743164, 3.0, 0.1402085851669742744600183, -0.9901229519585017824459486, 500},  // 1e-6 above it
           Case{Kink::shelf, 1.0, 0.0, 0.0, 1.0, 3.0, 0.1411200080598672221007448, -0.9899924966004454572715728, 1},  // touches it
           Case{Kink::saw, 1.0, 0.0, 0.2, 0.0, 10.25, -0.1434818898731495568663519, -0.2353178072798059511330324, 1},
           Case{Kink::switched, 1.0, 0.0, 0.0, 0.0, 5.0, -1.273654682063671721738212, -1.100044282723005690993899, 1},
           // a push of a millisecond, whose ends the run lands on to some units in the last place of t
           Case{Kink::pulse, 1.0, 0.0, 0.0, 0.0, 10.0, 8.999499999999008903017739, 0.9999999999998898658759572, 1000},
           Case{Kink::pulse, 1.0, 10.0, 8.9995, 1.0, 0.0, -1.108553249196120244339208e-13, 1.101341240428155288100243e-13, 1000},
       }) {
    const auto run = simulate(branching(c.kink, c.k), State<1>{c.t0, Vector<double, 1>(c.q0), Vector<double, 1>(c.v0)}, c.t, Taylor{}, tight);
    CAPTURE(static_cast<int>(c.kink), c.k, c.t0, run.message);
    CHECK(run.completed());
    CHECK_THAT(run.y[0], WithinAbs(c.q, c.margin * rounded_in_a_run));
    CHECK_THAT(run.y[1], WithinAbs(c.v, c.margin * rounded_in_a_run));
    CHECK(run.statistics.rejected_by_error_test == 0);
    CHECK(run.statistics.steps < 300);
  }
}

TEST_CASE("a ball on a soft floor is back after a flight of 2v/g and a contact of (2/w)(pi - atan(v w/g)), at every tolerance") {
  constexpr double g = 9.81, v = 2.0;
  for (const double k : {1e2, 1e4, 1e6}) {
    const double w = std::sqrt(k), period = 2 * v / g + 2 / w * (pi - std::atan(v * w / g));
    for (const double tol : {1e-6, 1e-10, 1e-13}) {
      const auto run = simulate(branching(Kink::ball, k), on_line(0.0, v), 3 * period, Taylor{}, {.rtol = tol, .atol = 1e-2 * tol, .keep_trajectory = false});
      CAPTURE(k, tol);
      CHECK(std::abs(run.y[0]) < 20 * tol);
      CHECK(std::abs(run.y[1] - v) < 20 * g * tol);  // it falls with g while it is late
      CHECK(run.statistics.rejected_by_error_test < 3);
    }
  }
}

TEST_CASE("more branches than are kept come and go: a spring in eighty straight pieces swings with the period that is summed up") {
  // V runs through n²/2 at whole n, so v² = 2E − n² there, and every piece has one force.
  constexpr double start = 40.5;
  const double twice_energy = 40.0 * 40.0 + start;
  double quarter = 0.0, faster = std::sqrt(twice_energy);
  for (int n = 0; n < 40; ++n) {
    const double slower = std::sqrt(twice_energy - (n + 1.0) * (n + 1.0));
    quarter += (faster - slower) / (n + 0.5);
    faster = slower;
  }
  quarter += faster / start;
  const auto run = simulate(branching(Kink::stairs), on_line(start, 0.0), 4 * quarter, Taylor{}, tight);
  CHECK_THAT(run.y[0], WithinAbs(start, 1e-11));
  CHECK_THAT(run.y[1], WithinAbs(0.0, 1e-11));  // of speeds up to 40
  CHECK(run.statistics.steps < 200);
}

TEST_CASE("two pendulums one above the other, with a wall for the upper one, keep their energy and return") {
  const auto walled = mechanical_system(2, [](const auto& q, const auto& v) { return Chain{}.T(q, v); },
                                        [](const auto& q) {
                                          using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
                                          using std::max;
                                          const S over = max(S(q[0] - 0.5), S(0.0));
                                          return S(Chain{}.V(q) + 2e3 * over * over);
                                        });
  const auto start = at_rest(2, -1.2);
  const auto there = simulate(walled, start, 4.0, Taylor{}, tight);
  CHECK(there.completed());
  CHECK_THAT(energy(walled, there.state()), WithinAbs(energy(walled, start), 1e-11));
  CHECK((simulate(walled, there.state(), 0.0, Taylor{}, tight).y - Eigen::Vector4d(-1.2, -1.2, 0, 0)).norm() < 1e-9);  // the motion is chaotic
}

TEST_CASE("a flight in a ring, whose own series allows any step, is not taken past the ring by the series of the distance, which does not") {
  const auto ring = mechanical_system(2, [](const auto& q, const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]) + 0.0 * q[0]; }, [](const auto& q) {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    using std::sqrt;
    const S r = sqrt(q[0] * q[0] + q[1] * q[1]);
    return r > 1.0 ? S(200.0 * (r - 1.0) * (r - 1.0) + 9.81 * q[1]) : S(9.81 * q[1]);
  });
  const State<Dynamic> start{0.0, Eigen::Vector2d(0.8, 0.1), Eigen::Vector2d(0.0, 0.0)};
  for (const double tol : {1e-6, 1e-12, 2.5e-15}) {
    const auto run = simulate(ring, start, 5.0, Taylor{}, {.rtol = tol, .atol = tol, .keep_trajectory = false});
    CAPTURE(tol, run.message);
    CHECK(run.completed());
    CHECK_THAT(energy(ring, run.state()), WithinAbs(0.981, std::max(100 * tol, 1e-12)));  // which nothing takes; after a dozen bounces
  }
}

TEST_CASE("a motion that turns on a kink is not taken for one that passes it") {
  const auto run = simulate(branching(Kink::stairs), on_line(1.0, 0.0), 20.0, Taylor{}, {.rtol = 1e-9, .atol = 1e-9, .keep_trajectory = false});
  CHECK(run.completed());
  // A quarter of the swing takes the time from rest to a place 1 away by the force 1/2: 2 s, and four of them a turn.
  CHECK_THAT(run.y[0], WithinAbs(-1.0, 1e-7));
}

TEST_CASE("a motion that no branch holds ends by name, and so does one that may go two ways") {
  const auto rest = simulate(branching(Kink::valley), on_line(0.0, 0.0), 3.0, Taylor{});
  CHECK(rest.outcome == Outcome::zeno);
  CHECK(rest.message.find("the function abs in T or V is met at t = 0, and each of its sides leads the motion back to it") != std::string::npos);
  const auto hill = simulate(branching(Kink::hill), on_line(0.0, 0.0), 1.0, Taylor{});
  CHECK(hill.outcome == Outcome::refused_by_model);
  CHECK(hill.message.find("the function abs in T or V is met at t = 0, where the motion begins, and each of its sides leads it away") != std::string::npos);
  CHECK_THAT(simulate(branching(Kink::hill), on_line(0.0, 1.0), 1.0, Taylor{}).y[0], WithinAbs(1.5, 1e-14));
}

TEST_CASE("a comparison of what is not a number is named") {
  const auto root = simulate(branching(Kink::root), on_line(1.0, 0.0), 3.0, Taylor{}, tight);  // at q = 0 after sqrt(2) s
  CHECK(root.outcome == Outcome::non_finite);
  CHECK_THAT(root.t, WithinAbs(std::sqrt(2.0), 1e-12));
  CHECK(root.message.find("the comparison < in T or V") != std::string::npos);
  CHECK(simulate(branching(Kink::root), on_line(-1.0, 0.0), 3.0, Taylor{}, tight).outcome == Outcome::non_finite);
}

TEST_CASE("a place where V jumps, which no force shows, is named") {
  const auto run = simulate(branching(Kink::step), on_line(-1.0, 2.0), 2.0, Taylor{}, tight);
  CHECK(run.outcome == Outcome::refused_by_model);
  CHECK_THAT(run.t, WithinAbs(0.5, 1e-14));
  CHECK(run.message.find("the comparison > in T or V") != std::string::npos);
}

TEST_CASE("steps end on the branches of time without a run around them, and a reset sees functors that have changed") {
  double k = 1.0;
  const auto pushed = [&k](const auto& q, const auto& t) {
    using S = std::remove_cvref_t<decltype(t)>;
    return t < 1.0 ? S(0.0 * q[0]) : S(0.5 * k * (q[0] - 1.0) * (q[0] - 1.0));
  };
  const auto form = first_order_form(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, pushed));
  auto stepper = Taylor{}.stepper(form, {.rtol = 1e-12, .atol = 1e-12});
  const auto end = [&] {
    stepper.reset(0.0, Eigen::Vector2d(0.0, 1.0));
    bool landed = false;
    while (stepper.t() < 3.0) {
      REQUIRE(stepper.step(3.0));
      landed = landed || stepper.t() == 1.0;
    }
    CHECK(landed);
    return stepper.y()[0];
  };
  CHECK_THAT(end(), WithinAbs(1.0 + std::sin(2.0), 1e-11));  // ten times the tolerance
  CHECK(stepper.is_current());
  k = 4.0;
  CHECK_FALSE(stepper.is_current());
  CHECK_THAT(end(), WithinAbs(1.0 + std::sin(4.0) / 2, 1e-11));
}

TEST_CASE("a motion that runs into a point where V is not analytic ends there with its name") {
  // V = −⅔ (1 − q)^{3/2}, reached with speed
  const auto edge = particle(Well::edge);
  const auto run = simulate(edge, on_line(0.0, 2.0), 5.0, Taylor{}, {.rtol = 1e-9});
  CHECK_FALSE(run.completed());
  CHECK(run.y[0] <= 1.0);
  CHECK(run.y[0] > 0.9);
  CHECK(run.statistics.evaluations < 5000);

  // |r|³ at the origin itself: the force is finite, its series is not.
  const auto cubic = mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); },
                                          [](const auto& q) {
                                            using std::pow;
                                            return pow(q[0] * q[0] + q[1] * q[1], 1.5);
                                          });
  try {
    const auto at_origin = simulate(cubic, State<2>{0.0, {0.0, 0.0}, {1.0, 0.5}}, 1.0, Taylor{});
    CHECK(at_origin.outcome == Outcome::non_finite);
    CHECK(at_origin.message.find("Dop853") != std::string::npos);
  } catch (const NonFinite&) {
    SUCCEED("refused at the start");
  }
}

TEST_CASE("fast and slow systems are the same in their own unit of time") {
  for (const double omega : {1e-12, 1.0, 1e12, 1e20}) {
    const auto oscillator = particle(Well::spring, omega);
    const auto run = simulate(oscillator, on_line(1.0, 0.0), 2.0 / omega, Taylor{},
                              {.rtol = 1e-12, .atol = {1e-14, 1e-14 * omega}});
    CHECK(run.completed());
    CHECK_THAT(run.y[0], WithinAbs(std::cos(2.0), 1e-11));
    CHECK(run.statistics.steps < 20);
  }
}

}  // namespace
