#pragma once
// SPDX-License-Identifier: MIT
//
// A system or a scene whose type is forgotten, so that one compilation of Dop853, Dopri5 and CVODE serves all cases, and the
// rows that come out of their runs. Methods that look into T and V (Taylor, Gauss, splitting) take the system itself.

#include <Eigen/Core>
#include <functional>
#include <string>
#include <utility>

#include "hard/hard_case.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/energy_balance.hpp"
#include "qdot/integrate/simulate.hpp"

namespace qdot::hard {

using State_ = Eigen::Ref<const Eigen::VectorXd>;

/// What becomes of the energy: it is constant, or changes by the power of forces and drives.
enum class Energy { conserved, worked_upon };

/// A first-order system without its type. Models FirstOrderSystem.
class Motion {
 public:
  static constexpr int size_at_compile_time = Dynamic;
  static constexpr int dof_at_compile_time = Dynamic;

  Eigen::Index size() const { return size_; }
  Eigen::Index dof() const { return dof_; }
  std::string component_name(Eigen::Index i) const { return component_name_(i); }
  void derivative(double t, const State_& y, Eigen::Ref<Eigen::VectorXd> ydot) const { derivative_(t, y, ydot); }

  /// @throws InvalidValue  where the motion was made without Jacobian
  void jacobian(double t, const State_& y, Eigen::Ref<Eigen::MatrixXd> J) const {
    if (!jacobian_) throw InvalidValue("an implicit method needs a Jacobian; make the motion by stiff_motion()");
    jacobian_(t, y, J);
  }

  double energy(double t, const State_& y) const { return energy_(t, y); }
  double energy_rate(double t, const State_& y) const { return energy_rate_ ? energy_rate_(t, y) : 0.0; }
  bool conserves_energy() const { return !energy_rate_; }
  bool is_holonomic() const { return holonomic_; }

 protected:
  template <bool with_jacobian, class Sys>
  static Motion of(const Sys& system, Energy energy) {
    constexpr int n = Sys::dof_at_compile_time;
    const auto form = first_order_form(system);
    Motion m;
    m.size_ = form.size();
    m.dof_ = system.dof();
    m.derivative_ = [form](double t, const State_& y, Eigen::Ref<Eigen::VectorXd> ydot) { form.derivative(t, y, ydot); };
    m.component_name_ = [form](Eigen::Index i) { return form.component_name(i); };
    if constexpr (with_jacobian)
      m.jacobian_ = [form](double t, const State_& y, Eigen::Ref<Eigen::MatrixXd> J) { form.jacobian(t, y, J); };
    m.energy_ = [system](double t, const State_& y) {
      const Vector<double, n> q = y.head(system.dof()), v = y.segment(system.dof(), system.dof());
      if constexpr (requires { system.system(); }) {
        return jacobi_energy(system.system(), q, v, t);
      } else {
        return jacobi_energy(system, q, v, t);
      }
    };
    if (energy == Energy::worked_upon)
      m.energy_rate_ = [system](double t, const State_& y) {
        const Vector<double, n> q = y.head(system.dof()), v = y.segment(system.dof(), system.dof());
        return qdot::energy_rate(system, q, v, t);
      };
    return m;
  }

  template <bool, class Sys>
  friend auto forgotten(const Sys& system, Energy energy);

  Eigen::Index size_ = 0, dof_ = 0;
  bool holonomic_ = false;
  std::function<void(double, const State_&, Eigen::Ref<Eigen::VectorXd>)> derivative_;
  std::function<void(double, const State_&, Eigen::Ref<Eigen::MatrixXd>)> jacobian_;
  std::function<double(double, const State_&)> energy_, energy_rate_;
  std::function<std::string(Eigen::Index)> component_name_;
};

/// The same with constraints. Models ProjectableSystem.
class ConstrainedMotion : public Motion {
 public:
  explicit ConstrainedMotion(Motion motion) : Motion(std::move(motion)) {}

  ProjectionReport project(double t, Eigen::Ref<Eigen::VectorXd> y) const { return project_(t, y); }

 private:
  template <bool, class Sys>
  friend auto forgotten(const Sys& system, Energy energy);
  template <class Sys>
  struct Holonomic;
  template <class Sys, class... Effects>
  struct Holonomic<Scene<Sys, Effects...>> {
    static constexpr bool value = (HolonomicEffect<Effects, Sys::dof_at_compile_time> || ...);
  };

  std::function<ProjectionReport(double, Eigen::Ref<Eigen::VectorXd>)> project_;
};

template <bool with_jacobian, class Sys>
auto forgotten(const Sys& system, Energy energy) {
  if constexpr (requires { requires Sys::has_constraints; }) {
    ConstrainedMotion m(Motion::of<with_jacobian>(system, energy));
    m.holonomic_ = ConstrainedMotion::Holonomic<Sys>::value;
    m.project_ = [form = first_order_form(system)](double t, Eigen::Ref<Eigen::VectorXd> y) { return form.project(t, y); };
    return m;
  } else {
    return Motion::of<with_jacobian>(system, energy);
  }
}

/// The motion of a system or scene, for explicit methods.
template <class Sys>
auto motion(const Sys& system, Energy energy = Energy::conserved) {
  return forgotten<false>(system, energy);
}

/// The motion with its exact Jacobian, for implicit methods as well.
template <class Sys>
auto stiff_motion(const Sys& system, Energy energy = Energy::conserved) {
  return forgotten<true>(system, energy);
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
Row row_of(const Problem& problem, const Motion& motion, const Run<n>& run, std::string method, bool constrained, double energy_drift) {
  Row row{.problem = problem.name, .method = std::move(method)};
  row.digits_reached = run.completed() ? digits_reached(problem, run.y) : 0.0;
  row.digits_good = digits_good(problem);
  row.best_published = problem.best_published;
  row.evaluations = run.statistics.evaluations;
  row.seconds = run.statistics.wall_seconds;
  if (constrained)
    row.constraint_residual_max =
        motion.is_holonomic() ? run.statistics.constraint_residual : run.statistics.constraint_velocity;
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
  constexpr bool constrained = requires { requires Sys::has_constraints; };
  return row_of(problem, motion, run, std::move(called), constrained, watch.largest());
}

/// The row of a method that cannot reach the good digits, with the reason.
Row limited(Row row, std::string why);

/// Which of the methods that need derivatives only.
enum class By { dop853, dopri5, adams, bdf };

/// Solves the problem; rtol and atol as in the options.
Row solved(const Problem& problem, const Motion& motion, By method, const Options& options);
Row solved(const Problem& problem, const ConstrainedMotion& motion, By method, const Options& options);

/// The numbers of two vectors, one after the other.
Eigen::VectorXd joined(const State_& q, const State_& v);

/// A vector of any length from its numbers.
Eigen::VectorXd numbers(std::initializer_list<double> values);

/// "1e-13"
std::string text_of_tolerance(double tolerance);

}  // namespace qdot::hard
