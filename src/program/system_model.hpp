#pragma once
// SPDX-License-Identifier: MIT
//
// The equations of motion of one system, bare or in a scene of effects, behind the interface that the commands see.

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "program/any_model.hpp"
#include "program/model_steppers.hpp"
#include "program/runnable_scene.hpp"
#include "qdot/analysis/reference_equations.hpp"
#include "qdot/integrate/energy_balance.hpp"
#include "qdot/integrate/steps/recorded_motion.hpp"
#include "qdot/integrate/watch/energy_slope.hpp"
#include "qdot/integrate/watch/driven_form_of.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot::program {

namespace detail {

// Keeps the compiler from moving an evaluation out of a loop that measures it.
inline void touch(const void* memory) { asm volatile("" : : "g"(memory) : "memory"); }

}  // namespace detail

/// What a model takes from a first-order form, be it that of a system or of a scene.
template <class Form>
class FormModel : public qdot::detail::SparseFormOf<Model, Form> {
 protected:
  using qdot::detail::SparseFormOf<Model, Form>::form_;

 public:
  std::shared_ptr<qdot::detail::RecordedMotion> recorded_on([[maybe_unused]] formula::Recording& recording) const override {
    if constexpr (qdot::detail::is_recordable<Form>::value) {
      return std::make_shared<qdot::detail::RecordedMotion>(qdot::detail::recorded_motion(form_, std::move(recording)));
    } else {
      return nullptr;
    }
  }
  void run_again([[maybe_unused]] qdot::detail::RecordedMotion& motion) const override {
    if constexpr (qdot::detail::is_recordable<Form>::value) qdot::detail::run_again(motion, form_);
  }

 protected:
  explicit FormModel(Form form) : qdot::detail::SparseFormOf<Model, Form>(std::move(form)) {}

  /// T, V and h of the system behind the form.
  template <class Sys>
  static Energies energies_of(const Sys& system, double t, const Eigen::VectorXd& y) {
    const auto at = qdot::detail::energy_at(system, t, y);
    return {at.T, at.V, at.h};
  }
};

template <class Sys>
class SystemModel final : public FormModel<FirstOrderForm<Sys>> {
  using FormModel<FirstOrderForm<Sys>>::form_;

 public:
  explicit SystemModel(Sys system) : FormModel<FirstOrderForm<Sys>>(FirstOrderForm<Sys>(std::move(system))) {}

  Energies energies(double t, const Eigen::Ref<const Eigen::VectorXd>& y) const override {
    return this->energies_of(form_.system(), t, y);
  }
  bool autonomous() const override { return Sys::autonomous; }
  Eigen::VectorXd packed(const State<Dynamic>& start) const override {
    Eigen::VectorXd y(this->size());
    y << start.q, start.qdot;
    return y;
  }
  double energy_rate(double t, const Eigen::Ref<const Eigen::VectorXd>& y) const override {
    const auto state = form_.state(t, y);
    return qdot::energy_rate(form_.system(), state.q, state.qdot, t);
  }
  bool long_derivative(long double t, const LongVector& y, LongVector& ydot) const override {
    qdot::detail::write_derivative(form_.system(), t, y, ydot);
    return true;
  }
  bool bare() const override { return true; }
  Eigen::VectorXd momenta(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& v) const override {
    using Q = Vector<double, Sys::dof_at_compile_time>;
    return conjugate_momenta(form_.system(), Q(q), Q(v), t);
  }
  bool separable() const override { return !qdot::detail::kinetic_energy_takes_q<Sys::dof_at_compile_time>(form_.system().energies()); }
  std::optional<AnyStepper> own_stepper(const std::string& method, double step, const Options& options) const override {
    return own_stepper_of(form_, method, step, options);
  }
  double repeated_acceleration(double t, const Eigen::Ref<const Eigen::VectorXd>& y, int count) const override {
    const auto state = form_.state(t, y);
    double sum = 0;
    for (int i = 0; i < count; ++i) {
      detail::touch(&state);
      sum += acceleration(form_.system(), state.q, state.qdot, t)[0];
    }
    return sum;
  }
};

template <int n, bool timed>
std::shared_ptr<const Model> model_of_energies(ModelEnergies<n, timed> energies, const qdot::detail::SystemParts& parts) {
  using Sys = System<ModelEnergies<n, timed>, n>;
  return std::make_shared<SystemModel<Sys>>(Sys(std::move(energies), parts));
}

#ifdef QDOT_COMPILED_MODELS  // program/models.cpp
extern template std::shared_ptr<const Model> model_of_energies<1, false>(ModelEnergies<1, false>, const qdot::detail::SystemParts&);
extern template std::shared_ptr<const Model> model_of_energies<1, true>(ModelEnergies<1, true>, const qdot::detail::SystemParts&);
extern template std::shared_ptr<const Model> model_of_energies<2, false>(ModelEnergies<2, false>, const qdot::detail::SystemParts&);
extern template std::shared_ptr<const Model> model_of_energies<2, true>(ModelEnergies<2, true>, const qdot::detail::SystemParts&);
extern template std::shared_ptr<const Model> model_of_energies<3, false>(ModelEnergies<3, false>, const qdot::detail::SystemParts&);
extern template std::shared_ptr<const Model> model_of_energies<3, true>(ModelEnergies<3, true>, const qdot::detail::SystemParts&);
#endif

}  // namespace qdot::program
