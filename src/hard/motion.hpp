#pragma once
// SPDX-License-Identifier: MIT
//
// A system or a scene without its type (AnySystem), so that one compilation of Dop853, Dopri5 and CVODE serves all cases, and the
// rows that come out of their runs. Methods that look into T and V (Taylor, Gauss, splitting) take the system itself.

#include <Eigen/Core>
#include <functional>
#include <string>
#include <utility>

#include "hard/hard_case.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/any_system.hpp"
#include "qdot/integrate/energy_balance.hpp"
#include "qdot/integrate/simulate.hpp"

namespace qdot::hard {

using State_ = Eigen::Ref<const Eigen::VectorXd>;

/// What becomes of the energy: it is constant, or changes by the power of forces and drives.
enum class Energy { conserved, worked_upon };

/// A system or scene without its type, its energy, and the rate of that where it changes.
struct Motion {
  AnySystem system;
  std::function<double(double, const State_&)> energy, energy_rate{};
  bool is_holonomic = false;  // one of its constraints is
};

template <class Sys>
inline constexpr bool has_holonomic_constraints = false;
template <class Sys, class... Effects>
inline constexpr bool has_holonomic_constraints<Scene<Sys, Effects...>> = (HolonomicEffect<Effects, Sys::dof_at_compile_time> || ...);

/// The motion of a system or scene.
template <class Sys>
Motion motion(const Sys& system, Energy energy = Energy::conserved) {
  constexpr int n = Sys::dof_at_compile_time;
  Motion m{.system = system,
           .energy = [system](double t, const State_& y) {
             const Vector<double, n> q = y.head(system.dof()), v = y.segment(system.dof(), system.dof());
             return jacobi_energy(system, q, v, t);
           },
           .is_holonomic = has_holonomic_constraints<Sys>};
  if (energy == Energy::worked_upon)
    m.energy_rate = [system](double t, const State_& y) {
      const Vector<double, n> q = y.head(system.dof()), v = y.segment(system.dof(), system.dof());
      return qdot::energy_rate(system, q, v, t);
    };
  return m;
}

/// A start, an end, and what is known of the end.
struct Problem {
  std::string name;
  double t_end;
  Eigen::VectorXd start;   // [q; q̇] at t = 0
  Eigen::VectorXd exact;   // at t_end
  double reference_digits; // of `exact`
  double gain = 1.0;       // relative change of the end per relative change of the start, in the same scales
  std::string best_published{};
  Eigen::VectorXd scale{};                                    // of each entry of `exact`; empty: the largest of its half
  std::function<Eigen::VectorXd(const State_& y)> seen{};     // what is compared with `exact`; empty: y itself
};

/// −log10 of the largest difference from what is exact, each entry beside its scale.
double digits_reached(const Problem& problem, const State_& y);

/// What a comparison with the reference is good for in double precision.
double digits_good(const Problem& problem);

/// Shown every step, keeps the largest energy error.
class EnergyWatch {
 public:
  explicit EnergyWatch(const Motion& motion);
  void operator()(const StepView& step);
  double largest() const;

 private:
  using OfState = std::function<double(double, const State_&)>;
  const Motion& motion_;
  EnergyMeter<OfState, OfState> meter_;
  double first_ = 0.0, largest_ = 0.0;
  bool begun_ = false;
};

/// The row of a run that has ended.
template <int n>
Row row_of(const Problem& problem, const Motion& motion, const Run<n>& run, std::string method, double energy_drift) {
  Row row{.problem = problem.name, .method = std::move(method)};
  row.digits_reached = run.completed() ? digits_reached(problem, run.y) : 0.0;
  row.digits_good = digits_good(problem);
  row.best_published = problem.best_published;
  row.evaluations = run.statistics.evaluations;
  row.seconds = run.statistics.wall_seconds;
  if (motion.system.is_constrained())
    row.constraint_residual_max =
        motion.is_holonomic ? run.statistics.constraint_residual : run.statistics.constraint_velocity;
  row.energy_drift_max = energy_drift;
  row.outcome = name(run.outcome);
  return row;
}

/// Solves the problem with a method that takes the system itself.
template <class Sys, class Method>
Row solved(const Problem& problem, const Motion& motion, const Sys& system, const Method& method, std::string called,
           Options options) {
  options.keep_trajectory = false;
  EnergyWatch watch(motion);
  const auto run = simulate(system, FirstOrderState{0.0, problem.start}, problem.t_end, method, options, watch);
  return row_of(problem, motion, run, std::move(called), watch.largest());
}

/// The row of a method that cannot reach the good digits, with the reason.
Row limited(Row row, std::string why);

/// Which of the methods that need derivatives only.
enum class By { dop853, dopri5, adams, bdf };

/// Solves the problem; rtol and atol as in the options.
Row solved(const Problem& problem, const Motion& motion, By method, const Options& options);

/// The numbers of two vectors, one after the other.
Eigen::VectorXd joined(const State_& q, const State_& v);

/// A vector of any length from its numbers.
Eigen::VectorXd numbers(std::initializer_list<double> values);

/// "1e-13"
std::string text_of_tolerance(double tolerance);

}  // namespace qdot::hard
