// SPDX-License-Identifier: MIT
//
// Power series of constrained motions, against closed forms.
#include <bit>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "../catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/taylor.hpp"

namespace {

using namespace qdot;
using Eigen::Vector2d;

constexpr double g = 9.81;
const Options tight{.rtol = 1e-13, .atol = 1e-14, .keep_trajectory = false};
constexpr double rounding = 1e-12;  // of some hundred steps, beside a motion of size 1 to 10

// A bead in the plane, on a guide that is chosen at run time: one type, so compiled once.
struct Guide {
  enum Shape { circle, turning_rod, corner } shape;

  template <class S>
  S operator()(const Vector<S, 2>& q, const S& t) const {
    using std::cos, std::sin, std::abs;
    if (shape == circle) return q[0] * q[0] + q[1] * q[1] - 1.0;
    if (shape == turning_rod) return q[1] * cos(t) - q[0] * sin(t);
    return abs(q[0]) + q[1];
  }
};

// V of a bead at (x, y), with a soft wall beyond x = 0.3 if asked for.
template <class S>
S height(const S& x, const S& y, double weight, bool walled) {
  using std::max;
  if (!walled) return weight * y;
  const S over = max(S(x - 0.3), S(0.0));
  return weight * y + 200.0 * over * over;
}

auto bead_on(Guide::Shape shape, bool walled = false) {
  const double weight = shape == Guide::circle ? g : 0.0;
  return scene(mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); },
                                    [weight, walled](const auto& q) { return height(q[0], q[1], weight, walled); }),
               holonomic("guide", Guide{shape}));
}

const State<2> released{0.0, Vector2d(std::sin(1.0), -std::cos(1.0)), Vector2d(0.0, 0.0)};  // on the circle
const State<2> spun{0.0, Vector2d(0.5, 0.0), Vector2d(0.0, 0.5)};                           // on the rod
Vector2d on_rod(double t) { return 0.5 * std::cosh(t) * Vector2d(std::cos(t), std::sin(t)); }

auto run_on(Guide::Shape shape, const State<2>& start, double t_end, const Taylor& method = {}, const Options& options = tight) {
  return simulate(bead_on(shape), start, t_end, method, options, events(event("lowest", [](const auto& q) { return q[0]; })));
}

TEST_CASE("the pendulum in Cartesian coordinates moves as its angle does, with residuals at rounding") {
  const double angle = -0.46325276873178667;  // after 10 s from 1 rad at rest, from an integration in quadruple precision
  const auto run = run_on(Guide::circle, released, 10.0);
  REQUIRE(run.completed());
  CHECK_THAT(run.y[0], WithinAbs(std::sin(angle), rounding));
  CHECK_THAT(run.y[1], WithinAbs(-std::cos(angle), rounding));
  CHECK(run.statistics.constraint_residual < 2e-15);
  CHECK(run.statistics.constraint_velocity < 1e-14);
  const auto back = run_on(Guide::circle, run.state(), 0.0);
  REQUIRE(back.completed());
  CHECK((back.state().q - released.q).norm() < 10 * rounding);
}

TEST_CASE("between steps the series is on the circle and moves with the rod's angle, events and samples included") {
  Options options = tight;
  options.keep_trajectory = true;
  options.output_times = {0.1, 0.77, 1.5};
  const auto run = run_on(Guide::circle, released, 2.0, {}, options);
  REQUIRE(run.completed());
  constexpr double period = 2.13913760055869;  // 4 √(l/g) K(sin² ½)
  REQUIRE(run.events.size() == 2);
  CHECK_THAT(run.events[0].t, WithinAbs(period / 4, rounding));
  CHECK_THAT(run.events[1].t, WithinAbs(3 * period / 4, rounding));
  for (int i = 0; i < 3; ++i) CHECK_THAT(run.samples.y.col(i).head(2).norm(), WithinAbs(1.0, 1e-15));
  for (double t = 0.0; t < 2.0; t += 0.0371) {
    const Eigen::VectorXd y = run.trajectory.y(t);
    CHECK_THAT(y.head(2).norm(), WithinAbs(1.0, rounding));
    CHECK_THAT(0.5 * y.tail(2).squaredNorm() + g * y[1], WithinAbs(-g * std::cos(1.0), 10 * rounding));
  }
}

TEST_CASE("the multipliers' series is the rod's force and its rates") {
  const auto form = first_order_form(bead_on(Guide::circle));
  const auto made = detail::PowerSeriesOf<std::remove_cvref_t<decltype(form)>>::made(form, 4);
  detail::PowerSeries& series = *made;
  const Vector2d q(std::sin(0.3), -std::cos(0.3)), v = 2.0 * Vector2d(std::cos(0.3), std::sin(0.3));
  Eigen::Vector4d y;
  y << q, v;
  series.start(0.0, y.data(), 1.0);
  series.expand(4);
  // 2λ = −(v² − g y) with v² = 4 − 2g (y − y₀) on the circle: λ̇ = 3/2 g ẏ.
  CHECK_THAT(series.constraints()->multipliers()(0, 0), WithinAbs(-0.5 * (4.0 - g * q[1]), 1e-14));
  CHECK_THAT(series.constraints()->multipliers()(0, 1), WithinAbs(1.5 * g * v[1], 1e-13));
  CHECK_THAT(series.constraints()->multipliers()(0, 2), WithinAbs(1.5 * g * series.coefficients()(1, 2), 1e-13));
}

TEST_CASE("a series with multipliers by machine code has the bits of that by the interpreter") {
  constexpr int order = 12;
  const auto form = first_order_form(bead_on(Guide::circle));
  const auto series = detail::PowerSeriesOf<std::remove_cvref_t<decltype(form)>>::made(form, order);
  const Eigen::Vector4d y(0.6, -0.8, 1.6, 1.2);
  const auto bits = [&] {
    series->start(0.0, y.data(), 0.25);
    series->expand(order);
    std::vector<std::uint64_t> all;
    for (int k = 0; k <= order; ++k)
      for (Eigen::Index i = 0; i < 4; ++i) all.push_back(std::bit_cast<std::uint64_t>(series->coefficients()(i, k)));
    for (int k = 0; k < order; ++k) all.push_back(std::bit_cast<std::uint64_t>(series->constraints()->multipliers()(0, k)));
    return all;
  };
  const std::vector<std::uint64_t> interpreted = bits();
  for (long i = 0; i < 2 * formula::LineEvaluator::begin_after / order; ++i) REQUIRE(bits() == interpreted);
}

TEST_CASE("a bead on a turning rod goes out as cosh t, forward and backward in time") {
  for (const double t : {4.0, -4.0}) {
    const auto run = run_on(Guide::turning_rod, spun, t);
    REQUIRE(run.completed());
    CHECK((run.y.head(2) - on_rod(t)).norm() < rounding * on_rod(t).norm());
    CHECK(run.statistics.constraint_residual < 1e-13);
  }
}

TEST_CASE("on a constraint Taylor converges with the order asked for, forward and backward in time") {
  const auto error = [&](int order, double t_end, double h) {
    const auto run = run_on(Guide::turning_rod, spun, t_end, Taylor{.order = order},
                            {.rtol = 0.9, .atol = 1e9, .initial_step = h, .max_step = h, .keep_trajectory = false});
    return (run.y.head(2) - on_rod(t_end)).norm();
  };
  for (const int order : {4, 7, 9})
    for (const double t_end : {2.0, -2.0}) {
      const double h = order < 8 ? 0.2 : 0.4, coarse = error(order, t_end, h), fine = error(order, t_end, h / 2);
      INFO("order " << order << " to t = " << t_end << ": errors " << coarse << ", " << fine);
      CHECK(std::log2(coarse / fine) > order - 0.6);
      CHECK(std::log2(coarse / fine) < order + 2.1);
    }
}

TEST_CASE("a branch in a constraint is refused in words") {
  auto stepper = Taylor{}.stepper(first_order_form(bead_on(Guide::corner)), tight);
  CHECK_THROWS_WITH(stepper.reset(0.0, Eigen::Vector4d(-1.0, -1.0, 0.5, 0.5)),
                    "a Taylor series needs constraints that are one formula everywhere, but the constraint 'guide' has the function abs in the constraint "
                    "'guide'; use Dop853, which takes them as they are");
}

TEST_CASE("a bead on a circle swings against a soft wall as its angle does") {
  const auto angle = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) {
    using S = std::remove_cvref_t<decltype(q[0])>;
    using std::cos, std::sin;
    return height(S(sin(q[0])), S(-cos(q[0])), g, true);
  });
  const double start = -1.0;
  const State<2> released_left{0.0, Vector2d(std::sin(start), -std::cos(start)), Vector2d(0.0, 0.0)};
  const auto bead = simulate(bead_on(Guide::circle, true), released_left, 6.0, Taylor{}, tight);
  const auto by_angle = simulate(angle, State<1>{0.0, Vector<double, 1>(start), Vector<double, 1>(0.0)}, 6.0, Taylor{}, tight);
  CHECK(bead.completed());
  CHECK_THAT(bead.y[0], WithinAbs(std::sin(by_angle.y[0]), rounding));
  CHECK_THAT(bead.y[2], WithinAbs(std::cos(by_angle.y[0]) * by_angle.y[1], 10 * rounding));
}

TEST_CASE("eighty coordinates with as many constraints are factored, on the heap") {
  // M = 2 and W = 1 of size 80: 2 v − μ = f and v = 3.
  constexpr int n = 80;
  detail::DenseConstrainedFactors<detail::unrolled_size<n>> factors(n, n);
  static_assert(sizeof factors < 1000);
  for (std::size_t i = 0; i < n; ++i) factors.J[n * i + i] = 1.0;
  REQUIRE(factors.compute_mass(Matrix<double, n>(2 * Matrix<double, n>::Identity()), 1e-8));
  REQUIRE(factors.compute_rows(1e-10));
  CHECK(factors.weakest(1e-10).pivot == 1.0);
  Vector<double, n> f = Vector<double, n>::LinSpaced(1.0, 80.0), mu = Vector<double, n>::Constant(3.0);
  factors.solve(f.data(), mu.data());
  CHECK((f - Vector<double, n>::Constant(3.0)).norm() < 1e-13);
  CHECK((mu - (Vector<double, n>::Constant(6.0) - Vector<double, n>::LinSpaced(1.0, 80.0))).norm() < 1e-12);
}

}  // namespace
