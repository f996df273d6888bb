#pragma once
// SPDX-License-Identifier: MIT
//
// A system whose type is chosen at run time.
//
//     std::map<std::string, AnySystem> plants = {{"swing", pendulum}, {"crane", scene(cart, motor, rod)}};
//     const auto run = simulate(plants.at(name), start, 10.0, Dop853{}, options);
//
// Every T and V, and every choice of effects, is a type of its own; that is what makes q̈ fast. AnySystem hides the type behind
// one indirect call per evaluation, so that a program can keep different systems in one list. The equations are those that the
// compiler made for the type, so a motion has the same bits. Constraints, contacts, own states and the watchdog stay.
//
// The method's loops over y are not unrolled: a run of Dop853 with two coordinates takes 1.3 to 1.5 times as long as with the
// type, less with more of them (./run bench steppers). Methods are Dop853, Dopri5, CvodeBdf and CvodeAdams, compiled once for
// all systems. What needs the functors themselves is asked where the type is known: derivatives with respect to parameters,
// Taylor, the symplectic methods, band structure. Simulator (integrate/simulator.hpp) hides system and method together.

#include <Eigen/Core>
#include <concepts>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/effects/projection_report.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/watch/driven_form_of.hpp"
#include "qdot/mechanics/energy.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot {

namespace detail {

// What users ask of a system, beside what a run and its method ask.
struct HiddenSystem : MethodForm {
  virtual Eigen::VectorXd packed(const State<Dynamic>& state) const = 0;
  virtual double energy(const State<Dynamic>& state) const = 0;
  virtual std::shared_ptr<const HiddenSystem> renewed() const = 0;  // nothing where nothing of the functors is kept
  virtual std::shared_ptr<const HiddenSystem> by(By way) const = 0;  // nothing where there are no T and V
};

template <FirstOrderSystem Form>
class HiddenForm final : public MethodFormOf<HiddenSystem, Form> {
  static constexpr int n = dof_at_compile_time<Form>();
  using MethodFormOf<HiddenSystem, Form>::form_;

 public:
  using MethodFormOf<HiddenSystem, Form>::MethodFormOf;

  Eigen::VectorXd packed(const State<Dynamic>& state) const override {
    return qdot::detail::packed(form_, own(state));
  }
  double energy(const State<Dynamic>& state) const override {
    if constexpr (requires { form_.scene(); }) {
      return qdot::energy(form_.scene().system(), own(state));
    } else if constexpr (requires { form_.system(); }) {
      return qdot::energy(form_.system(), own(state));
    } else {
      throw InvalidValue("an energy needs T and V, but this system was given as first-order equations without them; compute it from y");
    }
  }
  std::shared_ptr<const HiddenSystem> renewed() const override {
    if constexpr (requires(Form& form) { form.renew(); }) {
      auto fresh = std::make_shared<HiddenForm>(form_);
      fresh->renew();
      return fresh;
    } else {
      return nullptr;
    }
  }
  std::shared_ptr<const HiddenSystem> by([[maybe_unused]] By way) const override {
    if constexpr (requires { form_.by(way); }) return std::make_shared<HiddenForm>(form_.by(way));
    else return nullptr;
  }

 private:
  State<n> own(const State<Dynamic>& state) const {
    require_dof(form_, state);
    return State<n>{state.t, state.q, state.qdot};
  }
};

}  // namespace detail

/// A mechanical system, a scene or a FirstOrderSystem of any type. Copies share the system, which is constant.
///
/// For methods it is a system that may have constraints and may switch, whatever is behind it. Whether it has constraints is asked when a run begins, so
/// that CvodeAdams, which keeps none, takes it without.
class AnySystem {
 public:
  static constexpr int size_at_compile_time = Dynamic;  ///< its size is known at run time only

  /// Of a copy of the system or scene.
  template <class System>
    requires(!std::same_as<System, AnySystem>)
  AnySystem(const System& system) {  // NOLINT: a list of systems is written without saying AnySystem for each
    static_assert(requires { first_order_form(system); },
                  "qdot: AnySystem takes a mechanical system, a scene (with <qdot/effects/scene_form.hpp>) or what models FirstOrderSystem");
    using Form = std::remove_cvref_t<decltype(first_order_form(system))>;
    hidden_ = std::make_shared<const detail::HiddenForm<Form>>(Form(first_order_form(system)));
  }

  /// A copy that is evaluated one way (mechanics/by.hpp).
  ///
  /// @throws InvalidValue  a FirstOrderSystem, which has no T and V
  AnySystem by(By way) const {
    AnySystem other(*this);
    other.hidden_ = hidden_->by(way);
    if (!other.hidden_) throw InvalidValue("by must be left out for equations that are of first order: there are no T and V to evaluate");
    return other;
  }

  /// Number of coordinates.
  Eigen::Index dof() const { return hidden_->dof(); }
  /// Number of components of y = [q; q̇; z].
  Eigen::Index size() const { return hidden_->size(); }
  /// ydot ← f(t, y).
  void derivative(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) const { hidden_->derivative(t, y, ydot); }
  /// J ← ∂f/∂y, exact.
  void jacobian(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::MatrixXd> J) const { hidden_->jacobian(t, y, J); }
  /// A coordinate's name, a velocity's, or that of an effect's state.
  std::string component_name(Eigen::Index i) const { return hidden_->component_name(i); }
  /// y of a state; the effects' own states are at their initial values.
  ///
  /// @throws DimensionError  a state of another number of coordinates
  template <int n>
  Eigen::VectorXd packed(const State<n>& state) const {
    return hidden_->packed({state.t, state.q, state.qdot});
  }

  /// Whether there are constraints, which the driver has to keep.
  bool is_constrained() const { return hidden_->is_constrained(); }
  /// Puts y back onto the constraints; nothing where there are none.
  ProjectionReport project(double t, Eigen::Ref<Eigen::VectorXd> y) const { return hidden_->project(t, y); }
  /// Number of contacts and dry frictions.
  Eigen::Index guard_count() const { return hidden_->guard_count(); }
  /// g ← functions that stay ≥ 0 as long as the phases of y last.
  void guards(double t, const Eigen::VectorXd& y, Eigen::Ref<Eigen::VectorXd> g) const { hidden_->guards(t, y, g); }
  /// out ← how large each guard may be and still be zero.
  void guard_bands(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& tolerance, Eigen::Ref<Eigen::VectorXd> out) const {
    hidden_->guard_bands(t, y, tolerance, out);
  }
  /// Name of guard k if the run ends where it falls through zero; otherwise nothing.
  std::string ending(Eigen::Index k) const { return hidden_->ending(k); }
  /// Gives y the velocities and phases that follow when guards have reached zero; says what happened.
  std::vector<std::string> switched(double t, Eigen::VectorXd& y, const std::vector<bool>& fired, const Eigen::VectorXd& tolerance) const {
    return hidden_->switched(t, y, fired, tolerance);
  }
  /// Makes anew what is kept of the functors, a constant M: a method begins with the model as it is then. Copies keep what they have.
  void renew() {
    if (auto fresh = hidden_->renewed()) hidden_ = std::move(fresh);
  }
  /// What a run and its method ask; this object outlives them.
  const detail::MethodForm& driven() const noexcept { return *hidden_; }

 private:
  template <int n>
  friend double energy(const AnySystem& system, const State<n>& state);

  std::shared_ptr<const detail::HiddenSystem> hidden_;
};

/// T + V at a state.
///
/// @throws InvalidValue    a FirstOrderSystem, which has neither
/// @throws DimensionError  a state of another number of coordinates
template <int n>
double energy(const AnySystem& system, const State<n>& state) {
  return system.hidden_->energy({state.t, state.q, state.qdot});
}

}  // namespace qdot
