// SPDX-License-Identifier: MIT
#include <algorithm>
#include <type_traits>
#include <utility>

#include "../catch2_bridge.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/taylor.hpp"
#include "qdot/mechanics/written_out.hpp"

namespace {

using namespace qdot;

// Coefficients beside the largest of their order: sums of some twenty terms, over a dozen orders that each take up the errors of those before.
constexpr double rounding_of_orders = 1e-12;
constexpr int order = 14;

// The largest difference of two series beside the largest coefficient of the same order.
template <class Series>
double largest_difference(const Series& a, const auto& b) {
  double largest = 0.0;
  for (Eigen::Index k = 0; k <= order; ++k)
    largest = std::max(largest, (a.coefficients().col(k) - b.coefficients().col(k)).cwiseAbs().maxCoeff() /
                                    (1e-300 + b.coefficients().col(k).cwiseAbs().maxCoeff()));
  return largest;
}

// The series of energies with and without a plan, at a state.
template <int n, class E>
struct BothSeries {
  using Planned = FirstOrderForm<System<decltype(written_out<n>(std::declval<E>())), n>>;
  using Recorded = FirstOrderForm<System<E, n>>;
  detail::LagrangeSeries<Planned> planned;
  detail::LagrangeSeries<Recorded> recorded;

  explicit BothSeries(const E& e)
      : planned(Planned(mechanical_system<n>(written_out<n>(e))), order), recorded(Recorded(mechanical_system<n>(e)), order) {}

  double difference_at(const Vector<double, 2 * n>& y) {
    planned.start(0.3, y, 0.125);
    planned.expand(order);
    recorded.start(0.3, y, 0.125);
    recorded.expand(order);
    return largest_difference(planned, recorded);
  }
};

struct DoublePendulum {
  double m1 = 1.0, m2 = 1.0, l1 = 1.0, l2 = 1.0, g = 9.81;
  constexpr auto T(const auto& q, const auto& qdot) const {
    return 0.5 * (m1 + m2) * l1 * l1 * qdot[0] * qdot[0] + 0.5 * m2 * l2 * l2 * qdot[1] * qdot[1] +
           m2 * l1 * l2 * qdot[0] * qdot[1] * cos(q[0] - q[1]);
  }
  constexpr auto V(const auto& q) const { return -(m1 + m2) * g * l1 * cos(q[0]) - m2 * g * l2 * cos(q[1]); }
};

// Sums with plain loops.
template <int n>
struct Chain {
  double m = 1.0, l = 1.0, g = 9.81;
  constexpr auto T(const auto& q, const auto& qdot) const {
    typename std::decay_t<decltype(q)>::Scalar vx(0.0), vy(0.0), sum(0.0);
    for (int k = 0; k < n; ++k) {
      vx += l * cos(q[k]) * qdot[k];
      vy += l * sin(q[k]) * qdot[k];
      sum += 0.5 * m * (vx * vx + vy * vy);
    }
    return sum;
  }
  constexpr auto V(const auto& q) const {
    typename std::decay_t<decltype(q)>::Scalar y(0.0), sum(0.0);
    for (int k = 0; k < n; ++k) {
      y -= l * cos(q[k]);
      sum += m * g * y;
    }
    return sum;
  }
};

struct Kepler {
  double mu = 1.0;
  constexpr auto T(const auto& qdot) const { return 0.5 * (qdot[0] * qdot[0] + qdot[1] * qdot[1]); }
  constexpr auto V(const auto& q) const { return -mu / sqrt(q[0] * q[0] + q[1] * q[1]); }
};

// Every kind of node: quotients, powers, squares, functions of one and of two arguments, the time.
struct AllKinds {
  double a = 0.7, b = 1.9;
  constexpr auto T(const auto& q, const auto& qdot, const auto& t) const {
    return 0.5 * qdot[0] * qdot[0] * (2.0 + atan2(q[1], 2.0 + q[0] * q[0])) / (1.0 + exp(q[1])) +
           0.5 * a * qdot[1] * qdot[1] * (3.0 + sin(t)) + 0.1 * qdot[0] * qdot[1] * tanh(q[0]);
  }
  constexpr auto V(const auto& q, const auto& t) const {
    return log(2.0 + q[0] * q[0] * q[1] * q[1]) + b * pow(1.5 + sin(q[0]), 2.5) + hypot(q[0], q[1] + b) * cos(a * t) +
           pow(q[1], 3) + atan(q[0] - q[1]) + cosh(q[1]) / (2.0 + cos(q[0])) + asin(0.25 * q[0]) - erf(q[1]) + expm1(q[0]) +
           cbrt(3.0 + q[0]) + log1p(q[1] * q[1]) + sinh(q[0]) + tan(0.3 * q[1]) + acos(0.2 * q[0]) + asinh(q[1]) +
           acosh(2.5 + q[0]) + atanh(0.2 * q[1]) + erfc(q[0]);
  }
};

struct WithKink {
  constexpr auto T(const auto& qdot) const { return 0.5 * qdot[0] * qdot[0]; }
  constexpr auto V(const auto& q) const { return abs(q[0]); }
};

}  // namespace

TEST_CASE("a series that was planned while compiling equals one that was recorded", "[motion_plan]") {
  BothSeries<2, DoublePendulum> pendulum({.m1 = 1.3, .m2 = 0.4, .l1 = 0.8, .l2 = 1.7, .g = 9.8});
  CHECK(pendulum.planned.is_planned());
  CHECK_FALSE(pendulum.recorded.is_planned());
  CHECK(pendulum.difference_at({0.5, -0.8, 1.2, 0.3}) < rounding_of_orders);
  CHECK(pendulum.difference_at({2.5, 0.1, -3.0, 4.0}) < rounding_of_orders);

  BothSeries<3, Chain<3>> chain({.m = 0.6, .l = 1.1, .g = 9.8});
  CHECK(chain.planned.is_planned());
  CHECK(chain.difference_at((Vector<double, 6>() << 0.5, -0.8, 1.2, 0.3, 2.0, -1.0).finished()) < rounding_of_orders);

  BothSeries<2, Kepler> planet({.mu = 1.7});
  CHECK(planet.planned.is_planned());
  CHECK(planet.difference_at({0.4, 0.1, -0.2, 2.0}) < rounding_of_orders);
}

TEST_CASE("every kind of operation can be planned", "[motion_plan]") {
  BothSeries<2, AllKinds> series({.a = 0.9, .b = 1.4});
  CHECK(series.planned.is_planned());
  CHECK(series.difference_at({0.5, 0.3, 0.4, -0.6}) < rounding_of_orders);
}

TEST_CASE("one plan serves all parameters, also equal, zero and negative ones", "[motion_plan]") {
  for (const DoublePendulum& e : {DoublePendulum{}, DoublePendulum{.m1 = 0.0}, DoublePendulum{.g = 0.0}, DoublePendulum{.g = -9.81},
                                  DoublePendulum{.m1 = 2.0, .m2 = 2.0, .l1 = 2.0, .l2 = 2.0, .g = 2.0}}) {
    BothSeries<2, DoublePendulum> series(e);
    CHECK(series.planned.is_planned());
    CHECK(series.difference_at({0.5, -0.8, 1.2, 0.3}) < rounding_of_orders);
  }
}

TEST_CASE("energies that are not analytic have no plan and are refused as ever", "[motion_plan]") {
  const auto form = first_order_form(mechanical_system<1>(written_out<1>(WithKink{})));
  using Form = std::decay_t<decltype(form)>;
  CHECK_THROWS_AS(detail::LagrangeSeries<Form>(form, order), NotAnalytic);
}

TEST_CASE("a planned motion keeps to Kepler's ellipse", "[motion_plan]") {
  const auto system = mechanical_system<2>(written_out<2>(Kepler{}));
  const State<2> perihelion{0.0, {0.4, 0.0}, {0.0, 2.0}};  // e = 0.6, a = 1
  constexpr double one_turn = 6.283185307179586;
  const auto run = simulate(system, perihelion, one_turn, Taylor{}, {.rtol = 1e-13, .atol = 1e-13});
  REQUIRE(run.completed());
  // Ten steps or so in each of which 1e-13 is lost, and grows with the derivative of the end by the start, about 10.
  constexpr double after_one_turn = 1e-11;
  CHECK((run.trajectory.back().q - perihelion.q).norm() < after_one_turn);
  CHECK((run.trajectory.back().qdot - perihelion.qdot).norm() < after_one_turn);
}
