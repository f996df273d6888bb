// SPDX-License-Identifier: MIT
#include "qdot/analysis/trajectory_optimization.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "catch2_bridge.hpp"
#include "error_message.hpp"

using qdot::error_message;
using qdot::least_integral;
using qdot::minimum_time;
using qdot::trajectory_optimization;
using qdot::OptimalOptions;
using qdot::OptimalOutcome;
using qdot::OptimalTask;

namespace {

const double pi = std::numbers::pi;

// A point of unit mass in the plane, or a cart with a pole, θ from the downward vertical.
struct Mover {
  double g = 0.0, m1 = 1.0, m2 = 0.0, l = 0.5;
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    if (m2 == 0.0) return 0.5 * (v[0] * v[0] + v[1] * v[1]) + 0.0 * q[0];
    return 0.5 * (m1 + m2) * v[0] * v[0] + m2 * l * v[0] * v[1] * cos(q[1]) + 0.5 * m2 * l * l * v[1] * v[1];
  }
  auto V(const auto& q) const {
    using std::cos;
    if (m2 == 0.0) return g * q[1];
    return -m2 * g * l * cos(q[1]);
  }
};
auto mover(Mover of) { return qdot::mechanical_system<2>(of); }

struct Price {
  double effort = 0.0, time = 0.0;
  bool fails = false;
  auto operator()(const auto&, const auto&, const auto& u) const {
    if (fails) throw std::runtime_error("a price of the user's own");
    return effort * u[0] * u[0] + time;
  }
};

// A force that does no work: what guides a bead along a wire.
struct Guide {
  template <class S>
  qdot::Vector<S, 2> operator()(const qdot::Vector<S, 2>&, const qdot::Vector<S, 2>& v, const qdot::Vector<S, 1>& u) const {
    return {-u[0] * v[1], u[0] * v[0]};
  }
};

const auto cart = scene(mover({.g = 9.81, .m2 = 0.3}).with_names({"x", "theta"}), qdot::input("motor", 0));
const auto pushed = scene(mover({}), qdot::input("push", 0));
OptimalTask<2> way(double T, double distance) { return {.start = {0.0, {0.0, 0.0}, {0.0, 0.0}}, .end = {T, {distance, 0.0}, {0.0, 0.0}}}; }

}  // namespace

// u = 6 d/T² − 12 d t/T³ and ∫ u² = 12 d²/T³.
TEST_CASE("the least effort over a distance is a straight line in time") {
  const auto found = trajectory_optimization(pushed, way(2.0, 3.0), least_integral(Price{.effort = 1.0}), OptimalOptions{.intervals = 3});
  INFO(found.message);
  REQUIRE(found.solved());
  CHECK(std::abs(found.cost - 12.0 * 9.0 / 8.0) < 1e-8);
  for (const double t : {0.0, 0.7, 1.9, 2.0}) CHECK(std::abs(found.input(t)[0] - (4.5 - 4.5 * t)) < 1e-7);
  CHECK(std::abs(found.at(1.0).q[0] - 1.5) < 1e-8);
  CHECK(found.miss.cwiseAbs().maxCoeff() < 1e-8);
  const auto bent = trajectory_optimization(pushed, way(2.0, 3.0), least_integral(Price{.effort = 1.0}), [](const auto& t) { return qdot::vector(t * t, t); },
                                   OptimalOptions{.intervals = 3});
  CHECK(std::abs(bent.cost - found.cost) < 1e-8);
  CHECK(error_message([&] { return found.input(2.5); }) ==
        "an optimal motion is asked between its start and its end, but t = 2.5 is not; look at its t and t_end");
}

// Full force to the middle and back: T = 2 √(d/u). The input jumps in the middle of the motion, where a mesh of an even number of intervals has a
// point.
TEST_CASE("the least time over a distance takes all the force there is") {
  auto task = way(3.0, 2.0);
  task.times = {0.5, 10.0};
  task.bounds = {{"push", -2.0, 2.0}};
  const auto found = trajectory_optimization(pushed, task, least_integral(Price{.time = 1.0}), OptimalOptions{.intervals = 8});
  INFO(found.message);
  REQUIRE(found.solved());
  CHECK(std::abs(found.t_end - 2.0) < 1e-6);
  CHECK(std::abs(found.input(0.4)[0] - 2.0) < 1e-4);
  CHECK(std::abs(found.input(1.6)[0] + 2.0) < 1e-4);
}

// From (0, 10) to (10, 5), g = 9.80665: T = 1.801603122453081, a cycloid of radius r = 2.58599960843, along which the guide turns the velocity by
// √(g/r) more than gravity.
TEST_CASE("the brachistochrone is the cycloid") {
  const double g = 9.80665;
  const auto bead = scene(mover({.g = g}), qdot::input<1>("guide", Guide{}));
  const auto found = trajectory_optimization(bead, {.start = {0.0, {0.0, 10.0}, {0.0, 0.0}}, .end = {2.0, {10.0, 5.0}, {5.0, 0.0}},
                                           .free_at_end = {"qdot0", "qdot1"}, .times = {{0.5, 5.0}}},
                                    minimum_time(), OptimalOptions{.intervals = 10, .stages = 5});
  INFO(found.message);
  REQUIRE(found.solved());
  CHECK(std::abs(found.t_end - 1.801603122453081) < 1e-8);
  CHECK(found.miss.cwiseAbs().maxCoeff() < 1e-6);
  CHECK(std::abs(found.at(found.t_end).qdot.norm() - 9.9028531242263711) < 1e-6);
  for (const double t : {0.5, 1.0, 1.5}) CHECK(std::abs(found.input(t)[0] - std::sqrt(g / 2.5859996084327469)) < 1e-4);
}

// M. Kelly, SIAM Review 59 (2017), section 6: 1 kg, 0.3 kg on 0.5 m, 1 m in 2 s, at most 20 N. A test of dymos has 58.8839489745 N² s for it, on 40
// intervals of order 4, and with no force at the end, which can only be dearer.
TEST_CASE("the swing-up of a pole with a bounded force is the published one, and runs to its end") {
  const OptimalTask<2> task{.start = {0.0, {0.0, 0.0}, {0.0, 0.0}}, .end = {2.0, {1.0, pi}, {0.0, 0.0}},
                            .bounds = {{"motor", -20.0, 20.0}, {"x", -2.0, 2.0}}};
  const auto found = trajectory_optimization(cart, task, least_integral(Price{.effort = 1.0}), OptimalOptions{.tolerance = 1e-9});
  INFO(found.message);
  REQUIRE(found.solved());
  CHECK(found.cost < 58.8839489745);
  CHECK(found.cost > 58.8839489745 * 0.998);
  CHECK(found.miss.cwiseAbs().maxCoeff() < 1e-6);

  // Without the jumps of an active bound the cost converges as the order of the stages says: 2s = 4.
  double off[2];
  for (int k = 0; k < 2; ++k) {
    const auto coarse = trajectory_optimization(cart, task, least_integral(Price{.effort = 1.0}),
                                                OptimalOptions{.intervals = 20 << k, .stages = 2, .most_refinements = 0});
    CHECK(coarse.outcome == OptimalOutcome::not_accurate);
    off[k] = std::abs(coarse.cost - found.cost);
  }
  CHECK(std::log2(off[0] / off[1]) > 3.0);

  const auto early = trajectory_optimization(cart, task, least_integral(Price{.effort = 1.0}), OptimalOptions{.most_iterations = 3});
  CHECK(early.outcome == OptimalOutcome::iteration_limit);
  CHECK(early.message.find("as many iterations as were allowed") != std::string::npos);
}

// At full force a unit mass comes ½ · 2 · 1² far.
TEST_CASE("a task that no motion meets ends with the condition that is missed, and by how much") {
  auto task = way(1.0, 3.0);
  task.bounds = {{"push", -2.0, 2.0}};
  task.free_at_end = {"qdot0"};
  const auto found = trajectory_optimization(pushed, task, least_integral(Price{.effort = 1.0}), OptimalOptions{.intervals = 4});
  CHECK(found.outcome == OptimalOutcome::infeasible);
  CHECK(found.message ==
        "trajectory_optimization: no motion near by meets all conditions: q0 must be 3 at the end, but comes no nearer than 1 (off by -2); the nearest one has push at its bound 2 for "
        "100 % of the time; widen a bound, give it more time, or free a condition");
  REQUIRE(found.missed.size() == 1);
  CHECK(found.missed.front().name == "q0");
  CHECK(std::abs(found.missed.front().reached - 1.0) < 1e-6);
  REQUIRE(found.at_bounds.size() == 1);
  CHECK(found.at_bounds.front() == "push");
  CHECK(error_message([&] { return found.at(0.5); }).find("was asked where none was found") != std::string::npos);
}

// By central differences of the exact slopes: (1e-5)² of third derivatives of size 100, and rounding of 1e-10.
TEST_CASE("the curvature of the equations of motion is the slope of their slopes") {
  const auto price = least_integral(Price{.effort = 1.5});
  const qdot::detail::ControlledScene<std::remove_const_t<decltype(pushed)>, std::remove_const_t<decltype(price)>> controlled(cart, price);
  const Eigen::VectorXd x = (Eigen::VectorXd(4) << 0.3, 1.1, -0.7, 2.0).finished(), u = Eigen::VectorXd::Constant(1, 3.0);
  const Eigen::VectorXd weights = (Eigen::VectorXd(5) << 0.4, -0.3, 1.2, 0.8, 0.6).finished();
  const auto weighted = [&](const Eigen::VectorXd& z) {
    return Eigen::VectorXd(controlled.slopes(0.0, z.head(4), z.tail(1)).slopes.transpose() * weights);
  };
  const Eigen::MatrixXd H = controlled.curvature(0.0, x, u, weights, controlled.slopes(0.0, x, u).slopes);
  for (Eigen::Index j = 0; j < 5; ++j) {
    Eigen::VectorXd more(5), less;
    more << x, u;
    less = more;
    more[j] += 1e-5;
    less[j] -= 1e-5;
    CHECK((H.col(j) - (weighted(more) - weighted(less)) / 2e-5).cwiseAbs().maxCoeff() < 1e-6);
  }
}

TEST_CASE("a task that contradicts itself is refused by name") {
  auto task = way(1.0, 3.0);
  task.bounds = {{"q0", -1.0, 2.0}};
  const auto cost = least_integral(Price{.effort = 1.0});
  CHECK(error_message([&] { return trajectory_optimization(pushed, task, cost); }) ==
        "trajectory_optimization: the end must lie within the bounds, but q0 is 3 there, not between -1 and 2; move it, or widen the bound");
  task.bounds = {{"motor", -1.0, 2.0}};
  CHECK(error_message([&] { return trajectory_optimization(pushed, task, cost); }) ==
        "trajectory_optimization: a bound or a free end must be that of something in the scene, but there is no 'motor'; there are q0, q1, qdot0, qdot1, push");
  CHECK_THROWS_WITH(trajectory_optimization(pushed, way(1.0, 1.0), least_integral(Price{.fails = true})), "a price of the user's own");
  CHECK(error_message([&] { return trajectory_optimization(pushed, way(0.0, 1.0), cost); }).find("the end must be later than the start") != std::string::npos);
}

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
TEST_CASE("optimal_motion and least_time are trajectory_optimization and minimum_time by their old names") {
  STATIC_REQUIRE(std::is_same_v<decltype(qdot::least_time()), qdot::MinimumTime>);
  STATIC_REQUIRE(std::is_same_v<decltype(qdot::optimal_motion(pushed, way(2.0, 3.0), qdot::least_time(), {.intervals = 3})), qdot::OptimalMotion<2>>);
  const qdot::OptimalOptions few{.intervals = 3};
  const auto cost = least_integral(Price{.effort = 1.0});
  const auto path = [](const auto& t) { return qdot::vector(t * t, t); };
  CHECK(qdot::optimal_motion(pushed, way(2.0, 3.0), cost, few).cost == trajectory_optimization(pushed, way(2.0, 3.0), cost, few).cost);
  CHECK(qdot::optimal_motion(pushed, way(2.0, 3.0), cost, path, few).solved());
}
#pragma GCC diagnostic pop
