// SPDX-License-Identifier: MIT
//
// Old names, which are accepted until 0.4, give what the new ones give. That each brings a warning is in tests/compile_fail/old_names.cpp; those that
// need Ipopt or MPI are in trajectory_optimization.test.cpp and mpi/ensemble_mpi.test.cpp.
#include <cstddef>
#include <type_traits>
#include <vector>

#include "catch2_bridge.hpp"
#include "qdot/analysis/accuracy.hpp"
#include "qdot/analysis/adjoint.hpp"
#include "qdot/analysis/alignment.hpp"
#include "qdot/analysis/lyapunov.hpp"
#include "qdot/analysis/motion_between.hpp"
#include "qdot/analysis/orbit_family.hpp"
#include "qdot/analysis/regulator.hpp"
#include "qdot/analysis/sampled.hpp"
#include "qdot/effects/choice.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/scene_at_state.hpp"
#include "qdot/integrate/accurate_simulation.hpp"
#include "qdot/integrate/energy_balance.hpp"
#include "qdot/integrate/many_in_lanes.hpp"
#include "qdot/integrate/moment.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/simulate_many.hpp"
#include "qdot/mechanics/ensemble.hpp"

using qdot::Dop853;
using qdot::Options;
using qdot::State;
using One = qdot::Vector<double, 1>;

namespace {

struct Spring {
  double k = 1.0;
  template <class S>
  S T(const qdot::Vector<S, 1>& qdot) const {
    return 0.5 * qdot[0] * qdot[0];
  }
  template <class S>
  S V(const qdot::Vector<S, 1>& q) const {
    return 0.5 * k * q[0] * q[0];
  }
};

const auto spring = qdot::mechanical_system<1>(Spring{});
const auto damped = scene(spring, qdot::viscous_damping(One(0.1)));
const State<1> start{0.0, One(1.0), One(0.0)};
const auto place = qdot::end_value([](const auto& q) { return q[0]; });

// A stepper of a user that was written for an older qdot.
struct OldStepper {
  double begun_at = 0.0;
  double t() const { return 3.0; }
  qdot::TimePoint moment() const { return {1.0, 2.0, 1.0}; }
  void reset(const qdot::TimePoint& at, double) { begun_at = at.elapsed; }
};

}  // namespace

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"

TEST_CASE("old names of types and outcomes are the new ones") {
  STATIC_REQUIRE(std::is_same_v<qdot::Moment, qdot::TimePoint>);
  STATIC_REQUIRE(std::is_same_v<qdot::MotionBetween<2>, qdot::BoundaryValueSolution<2>>);
  STATIC_REQUIRE(std::is_same_v<decltype(motion_between(spring, One(0.0), 0.0, One(1.0), 1.0)), qdot::MotionBetween<1>>);
  STATIC_REQUIRE(std::is_same_v<decltype(scene(spring, qdot::only_if<false>(1))), decltype(scene(spring, qdot::optional<false>(1)))>);
  CHECK(name(qdot::Outcome::event_accumulation) == "zeno");
  CHECK(name(qdot::Outcome::step_collapse) == "step_too_small");
}

TEST_CASE("a stepper that has moment() in place of time_point() counts from its origin") {
  OldStepper stepper;
  CHECK(qdot::detail::time_point_of(stepper).elapsed == 2.0);
  qdot::detail::reset_at(stepper, qdot::TimePoint(1.0, 0.5, 1.0), 0.0);
  CHECK(stepper.begun_at == 0.5);
  auto own = Dop853{}.stepper(first_order_form(spring), Options{});
  own.reset(2.0, Eigen::Vector2d(1.0, 0.0));
  CHECK(own.moment().origin == 2.0);
}

TEST_CASE("motion_residual is inverse_dynamics, of systems and of scenes") {
  const One q(0.3), v(-0.2), a(0.7);
  const Eigen::Vector<double, 0> z;
  const State<1> at{0.0, q, v};
  CHECK(motion_residual(spring, q, v, a) == inverse_dynamics(spring, q, v, a));
  CHECK(motion_residual(spring, at, a) == inverse_dynamics(spring, at, a));
  CHECK(motion_residual(damped, q, v, a) == inverse_dynamics(damped, q, v, a));
  CHECK(motion_residual(damped, q, v, a, 0.0, z) == inverse_dynamics(damped, q, v, a));
  CHECK(motion_residual(damped, at, a, z) == inverse_dynamics(damped, at, a));
}

TEST_CASE("then is action, and energy_meter is energy_balance") {
  const auto wall = qdot::event("wall", [](const auto& q) { return q[0]; }).falling();
  const auto bounce = [](State<1>& s) { s.qdot *= -0.5; };
  auto meter = energy_meter(spring), balance = energy_balance(spring);
  const auto old = simulate(spring, start, 3.0, Dop853{}, {}, meter, wall.then(bounce));
  const auto run = simulate(spring, start, 3.0, Dop853{}, {}, balance, wall.action(bounce));
  CHECK(run.events.size() == 1);
  CHECK(old.y == run.y);
  CHECK(meter.balance().impacts == balance.balance().impacts);
}

TEST_CASE("accurate_simulation is simulate_to_accuracy") {
  CHECK(accurate_simulation(spring, start, 2.0, Dop853{}, 1e-8, {.keep_trajectory = false}).run.y ==
        simulate_to_accuracy(spring, start, 2.0, Dop853{}, 1e-8, {.keep_trajectory = false}).run.y);
}

TEST_CASE("simulate_many is ensemble, with lists in braces, too") {
  const auto square = [](std::size_t i) { return i * i; };
  const auto all = qdot::simulate_many(4, square, {.threads = 1});
  CHECK(all[3].value == 9u);
  CHECK(qdot::simulate_many(4, square, std::size_t(0), [](std::size_t& sum, std::size_t, auto&& kept) { sum += *kept.value; }) == 14u);
  const auto start_of = [](std::size_t i) { return State<1>{0.0, One(1.0 + static_cast<double>(i)), One(0.0)}; };
  const auto passes = qdot::event("passes", [](const auto& q) { return q[0]; }).stop();
  const auto end_of = [](const auto& ends) { return ends[1].value->state.q[0]; };
  const double end = end_of(ensemble(spring, 2, start_of, 1.0, Dop853{}, {.rtol = 1e-9}, {.threads = 1}));
  CHECK(end_of(simulate_many(spring, 2, start_of, 1.0, Dop853{}, {.rtol = 1e-9}, {.threads = 1})) == end);
  CHECK(end_of(simulate_many(spring, 2, start_of, 3.0, Dop853{}, {}, passes)) == end_of(ensemble(spring, 2, start_of, 3.0, Dop853{}, {}, passes)));
  const auto add = [](double& sum, std::size_t, auto&& kept) { sum += kept.value->state.q[0]; };
  CHECK(simulate_many(spring, 2, start_of, 1.0, Dop853{}, {}, qdot::events(), 0.0, add) ==
        ensemble(spring, 2, start_of, 1.0, Dop853{}, {}, qdot::events(), 0.0, add));
}

TEST_CASE("regulator is lqr, and sampled_regulator is sampled_lqr") {
  const Eigen::MatrixXd E = Eigen::MatrixXd::Identity(1, 1);
  CHECK(qdot::regulator(E, E, E, E).K == qdot::lqr(E, E, E, E).K);
  CHECK(qdot::sampled_regulator(E, E, E, E).K == qdot::sampled_lqr(E, E, E, E).K);
  const auto linear = linearization(scene(spring, qdot::input("push", 0)), State<1>{0.0, One(0.0), One(0.0)});
  const Eigen::MatrixXd Q = Eigen::MatrixXd::Identity(2, 2);
  CHECK(qdot::regulator(linear, Q, E).K == qdot::lqr(linear, Q, E).K);
  CHECK(qdot::regulator(sampled(linear, 0.1), Q, E).K == qdot::lqr(sampled(linear, 0.1), Q, E).K);
}

TEST_CASE("functional_gradient is adjoint_sensitivities of systems, parameters and families") {
  CHECK(functional_gradient(spring, start, 1.0, place, Dop853{}).by_start == adjoint_sensitivities(spring, start, 1.0, place, Dop853{}).by_start);
  const auto family = [](const auto& p) { return problem(qdot::mechanical_system<1>(Spring{p[0]}), start, qdot::events()); };
  CHECK(functional_gradient(family, One(2.0), 1.0, place, Dop853{}).by_parameters ==
        adjoint_sensitivities(family, One(2.0), 1.0, place, Dop853{}).by_parameters);
}

TEST_CASE("other questions about motions have the old answers") {
  const Eigen::Matrix2d Phi{{1.0, 2.0}, {0.0, 1.0}};
  CHECK(qdot::stretching(Phi).sigma == qdot::finite_time_lyapunov(Phi).sigma);
  CHECK(alignment(spring, start, 1.0, Dop853{}).index == generalized_alignment_index(spring, start, 1.0, Dop853{}).index);
  CHECK(motion_between(spring, One(0.0), 0.0, One(1.0), 1.0).S == boundary_value_problem(spring, One(0.0), 0.0, One(1.0), 1.0).S);
  CHECK(motion_between(scene(spring), One(0.0), 0.0, One(1.0), 1.0).found());
  CHECK(motion_between(spring, One(0.0), 0.0, One(1.0), 1.0, [](const auto& t) { return qdot::vector(t); }, {.legs = 2}).found());
  const qdot::FamilyOptions few{.most_orbits = 2};
  CHECK(family_of_orbits(spring, start, 6.3, qdot::in_energy(0.6), few).orbits.size() ==
        continue_orbits(spring, start, 6.3, qdot::in_energy(0.6), few).orbits.size());
  const qdot::StudyOptions options{.tolerances = {1e-6}, .outputs = 2, .seconds_per_cell = 1e-4};
  CHECK(accuracy_study(spring, start, 1.0, options, qdot::by_tolerance("dop853", Dop853{})).measurements.size() == 1);
  CHECK(qdot::accuracy_study(reference_motion(spring, start, {1.0}), 0.0, std::vector<qdot::Contender>(), {}, options).measurements.empty());
}

#pragma GCC diagnostic pop
