#pragma once
// SPDX-License-Identifier: MIT
//
// A scene without its type: what the program's commands see, whatever T and V are behind it.
//
// The templates of a scene (its duals, its equations of motion) are compiled once, in a file of the scene's own
// (scene_runner.hpp). Everything else talks to these two interfaces.

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "qdot/analysis/linear/constraints_at.hpp"
#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/watch/driven_form.hpp"
#include "qdot/report/animation.hpp"
#include "scenes/scene.hpp"

namespace qdot::detail {
struct RecordedMotion;  // mechanics/derive/recorded_energies.hpp
}

namespace qdot::formula {
struct Recording;  // ad/formula/recording.hpp
}

namespace qdot::report {
struct EquationSource;  // report/equations/source.hpp
}

namespace qdot::program {

/// A parameter as a table shows it.
struct ParameterInfo {
  std::string name;
  double value = 0;
  bool whole = false;  // a count
  std::string unit;
  scenes::Range range = scenes::Range::any;
  std::string meaning;
};

/// T, V and Jacobi's energy function at one state.
struct Energies {
  double kinetic = 0;
  double potential = 0;
  double jacobi = 0;

  double total() const { return kinetic + potential; }
};

/// An optional effect as a table shows it.
struct EffectInfo {
  std::string name;
  bool on = false;
  double value = 0;
  std::string unit;
  scenes::Range range = scenes::Range::any;
  std::string meaning;
};

/// What holds a constraint at one state.
struct Reaction {
  std::string name;
  double lambda = 0;
};

/// One of the effects' own states, a component of y behind q and q̇.
struct OwnState {
  enum Kind { state, input, phase, held };  // held from one event to the next, as a phase is
  Kind kind = state;
  std::string name;  // of an input; of the contact or friction whose phase it is; "z0", "z1", … of others
};

using LongVector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

/// The equations of motion for fixed parameters, y = [q; q̇; z] with the states z of effects that have some.
class Model : public qdot::detail::MethodForm {
 public:
  virtual Energies energies(double t, const Eigen::Ref<const Eigen::VectorXd>& y) const = 0;
  virtual bool autonomous() const = 0;

  /// What z is made of.
  virtual std::vector<OwnState> own_states() const { return {}; }

  /// y = [q; q̇; z(0)].
  virtual Eigen::VectorXd packed(const State<Dynamic>& start) const = 0;

  /// Work per time of what is in neither T nor V.
  virtual double power(double, const Eigen::Ref<const Eigen::VectorXd>&) const { return 0.0; }

  /// Rate of Jacobi's energy function on a motion: the power, and what explicit time in the energies adds.
  virtual double energy_rate(double, const Eigen::Ref<const Eigen::VectorXd>&) const { return 0.0; }

  virtual std::vector<Reaction> reactions(double, const Eigen::Ref<const Eigen::VectorXd>&) const { return {}; }

  /// Generalized forces of the constraints, Jᵀλ, and of the effects, ΣQ; empty where there are none.
  virtual Eigen::VectorXd constraint_forces(double, const Eigen::VectorXd&) const { return {}; }
  virtual Eigen::VectorXd applied_forces(double, const Eigen::VectorXd&) const { return {}; }

  /// The derivative with more digits, for references; false, with nothing done, where the equations hold in double only.
  virtual bool long_derivative(long double, const LongVector&, LongVector&) const { return false; }

  /// Whether T and V are all that there is.
  virtual bool bare() const { return false; }

  /// Whether T is a function of the velocities alone.
  virtual bool separable() const { return false; }

  /// Whether constraints are holonomic and last, T is one of the velocities alone, and there are no forces.
  virtual bool fits_rattle() const { return false; }

  /// T, V, the forces and the constraints as a graph; nothing where equations switch, or an effect takes no recording scalar.
  ///
  /// @throws NotAnalytic  one of them compares values or has a kink
  std::shared_ptr<qdot::detail::RecordedMotion> recorded_motion() const;

  /// The graph of recorded_motion(), added to a recording of other models of the scene, which is moved from.
  virtual std::shared_ptr<qdot::detail::RecordedMotion> recorded_on(qdot::formula::Recording&) const { return nullptr; }
  /// Runs the same functors once more on what has been recorded.
  virtual void run_again(qdot::detail::RecordedMotion&) const {}

  /// p = ∂L/∂q̇ at (t, q, q̇).
  virtual Eigen::VectorXd momenta(double, const Eigen::VectorXd&, const Eigen::VectorXd&) const = 0;
  // d/dt p = F and ż, for methods that step momenta (integrate/steps/form_mechanics.hpp); a bare scene's own steppers know them.
  virtual Eigen::MatrixXd inverse_mass(double, const Eigen::VectorXd&, const Eigen::VectorXd&) const { return {}; }
  virtual Eigen::VectorXd force(double, const Eigen::VectorXd&) const { return {}; }
  virtual Eigen::VectorXd state_rates(double, const Eigen::VectorXd&) const { return {}; }
  virtual Eigen::VectorXd state_accelerations(double, const Eigen::VectorXd&, const Eigen::VectorXd&) const { return {}; }

  /// The stepper of a method that is made for the scene itself (model_steppers.hpp); nothing where there is none.
  virtual std::optional<AnyStepper> own_stepper(const std::string&, double, const Options&) const { return std::nullopt; }

  /// Evaluates q̈ at y `count` times, and returns a number that depends on all of them.
  virtual double repeated_acceleration(double t, const Eigen::Ref<const Eigen::VectorXd>& y, int count) const = 0;

  /// Constraints and their slopes in the phases of y; empty where there are none.
  virtual qdot::detail::ConstraintsAt constraints_at(double, const Eigen::Ref<const Eigen::VectorXd>&) const { return {}; }
  /// The ways δ, a column each, with J δ = changes that are shortest in the metric of M; no columns where nothing is constrained.
  virtual Eigen::MatrixXd displacements(double, const Eigen::Ref<const Eigen::VectorXd>&, const Eigen::MatrixXd& /*changes*/) const { return {}; }
  virtual std::vector<std::string> constraint_names() const { return {}; }
};

/// A scene with values for its parameters.
class RunnableScene {
 public:
  virtual ~RunnableScene() = default;

  virtual std::string name() const = 0;
  virtual void set_name(const std::string& name) = 0;
  virtual std::string title() const = 0;
  virtual std::string summary() const = 0;
  virtual std::string time_unit() const = 0;
  virtual std::string energy_unit() const = 0;
  virtual double t_end() const = 0;

  virtual std::vector<ParameterInfo> parameters() const = 0;

  /// Gives a parameter a value.
  ///
  /// @throws InvalidValue  when the value is not physical; the name must be one of parameters()
  virtual void set_parameter(const std::string& name, double value) = 0;

  virtual std::vector<EffectInfo> effects() const { return {}; }

  /// Switches an effect on or off; without a value it keeps the one that it has.
  ///
  /// @throws InvalidValue  when the value is not physical; the name must be one of effects()
  virtual void set_effect(const std::string& name, bool on, std::optional<double> value) = 0;

  /// How T and V are to be evaluated in models that are made from now on.
  virtual void set_by(By way) = 0;

  // What follows depends on the parameters.
  virtual std::vector<scenes::Coordinate> coordinates() const = 0;
  virtual State<Dynamic> start() const = 0;
  virtual std::shared_ptr<const Model> model() const = 0;

  /// T, V and the constraints that the scene always has, for formulas of them.
  virtual report::EquationSource equation_source() const = 0;
  virtual report::Drawing drawing() const = 0;

  /// Where the points of the drawing are; none for a scene without a view.
  virtual std::vector<report::Point> positions(const Eigen::Ref<const Eigen::VectorXd>& q, double t) const = 0;
};

}  // namespace qdot::program
