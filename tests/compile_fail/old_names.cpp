// SPDX-License-Identifier: MIT
//
// Old names: the compiler says the new one of each. They give warnings, and the last one an error, so that there is something to refuse. Of the alias
// templates, MotionBetween and OptimalMotion, g++ warns and clang++ does not.
// message: qdot: say time_point()
// message: qdot: say TimePoint
// message: qdot: say zeno
// message: qdot: say step_too_small
// message: qdot: say inverse_dynamics()
// message: qdot: say optional()
// message: qdot: say action()
// message: qdot: say energy_balance()
// message: qdot: say simulate_to_accuracy()
// message: qdot: say ensemble()
// message: qdot: say EnsembleOptions
// message: qdot: say WorkPrecisionOptions
// message: qdot: say WorkPrecision
// message: qdot: say work_precision()
// message: qdot: say GeneralizedAlignmentOptions
// message: qdot: say GeneralizedAlignmentIndex
// message: qdot: say generalized_alignment_index()
// message: qdot: say BoundaryValueOptions
// message: qdot: say BoundaryValueOutcome
// message: qdot: say boundary_value_problem()
// message: qdot: say Lqr
// message: qdot: say lqr()
// message: qdot: say SampledLqr
// message: qdot: say sampled_lqr()
// message: qdot: say AdjointSensitivities
// message: qdot: say adjoint_sensitivities()
// message: qdot: say continue_orbits()
// message: qdot: say FiniteTimeLyapunov
// message: qdot: say finite_time_lyapunov()
#include <qdot/qdot.hpp>

#include <qdot/analysis/accuracy.hpp>
#include <qdot/analysis/adjoint.hpp>
#include <qdot/analysis/alignment.hpp>
#include <qdot/analysis/lyapunov.hpp>
#include <qdot/analysis/motion_between.hpp>
#include <qdot/analysis/orbit_family.hpp>
#include <qdot/analysis/regulator.hpp>
#include <qdot/analysis/sampled.hpp>
#include <qdot/integrate/accurate_simulation.hpp>
#include <qdot/integrate/energy_balance.hpp>
#include <qdot/integrate/simulate_many.hpp>

namespace {

using One = qdot::Vector<double, 1>;
using qdot::Dop853;

qdot::Moment moment;
qdot::ManyOptions many;
qdot::StudyOptions study_options;
qdot::AccuracyStudy study;
qdot::AlignmentOptions alignment_options;
qdot::Alignment found;
qdot::BetweenOptions between_options;
qdot::BetweenOutcome between_outcome;
qdot::MotionBetween<1> between;
qdot::Regulator held;
qdot::SampledRegulator held_at_ticks;
qdot::FunctionalGradient gradient;
qdot::Stretching axes;

}  // namespace

int main() {
  const auto system = qdot::mechanical_system<1>([](const auto& qdot) { return 0.5 * qdot.dot(qdot); }, [](const auto& q) { return 0.5 * q.dot(q); });
  const qdot::State<1> start{0.0, One(1.0), One(0.0)};
  const Eigen::MatrixXd E = Eigen::MatrixXd::Identity(1, 1);
  auto meter = energy_meter(system);
  const auto bounce = qdot::event("floor", [](const auto& q) { return q[0]; }).then([](qdot::State<1>& s) { s.qdot *= -0.5; });
  const auto damped = scene(system, qdot::only_if<true>(qdot::viscous_damping(One(0.1))));
  const auto run = simulate(damped, start, 1.0, Dop853{}, {}, bounce, meter);
  if (run.outcome == qdot::Outcome::event_accumulation || run.outcome == qdot::Outcome::step_collapse) return 1;
  static_cast<void>(motion_residual(system, start, One(0.0)));
  static_cast<void>(accurate_simulation(system, start, 1.0, Dop853{}, 1e-6));
  static_cast<void>(qdot::simulate_many(3, [](std::size_t i) { return i; }));
  static_cast<void>(accuracy_study(system, start, 1.0, {}, qdot::by_tolerance("dop853", Dop853{})));
  static_cast<void>(alignment(system, start, 1.0, Dop853{}));
  static_cast<void>(motion_between(system, One(0.0), 0.0, One(1.0), 1.0));
  static_cast<void>(qdot::regulator(E, E, E, E));
  static_cast<void>(qdot::sampled_regulator(E, E, E, E));
  static_cast<void>(functional_gradient(system, start, 1.0, qdot::end_value([](const auto& q) { return q[0]; }), Dop853{}));
  static_cast<void>(family_of_orbits(system, start, 6.0, qdot::in_energy(2.0)));
  static_cast<void>(qdot::stretching(E));
#pragma GCC diagnostic error "-Wdeprecated-declarations"
  return Dop853{}.stepper(first_order_form(system), qdot::Options{}).moment().elapsed > 0.0 ? 1 : 0;
}
