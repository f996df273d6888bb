#pragma once
// SPDX-License-Identifier: MIT
//
// A scene with effects: those that belong to it (the rod of a pendulum in Cartesian coordinates), and those that a run may
// switch on. Each combination of optional effects is a type, compiled here, 2ᵏ of them. A run asks once which one it wants. Then
// it steps equations that hold the terms of its effects and no test of what is on.

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "program/scene_runner.hpp"
#include "qdot/analysis/linear/flow.hpp"
#include "qdot/analysis/reference_equations.hpp"
#include "qdot/effects/input.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/rattle.hpp"
#include "qdot/integrate/steps/form_mechanics.hpp"
#include "qdot/integrate/steps/recorded_motion.hpp"

namespace qdot::program {

template <class Sc>
class SceneModel final : public FormModel<SceneForm<Sc>> {
  static constexpr int n = Sc::dof_at_compile_time;
  static constexpr bool has_traced_constraints = qdot::detail::is_traced_scene<Sc> && Sc::has_constraints;
  using FormModel<SceneForm<Sc>>::form_;
  using Behind = qdot::detail::Mechanics<SceneForm<Sc>>;

 public:
  explicit SceneModel(Sc scene) : FormModel<SceneForm<Sc>>(SceneForm<Sc>(std::move(scene))) {}

  Energies energies(double t, const Eigen::Ref<const Eigen::VectorXd>& y) const override {
    return this->energies_of(form_.scene().system(), t, y);
  }
  bool autonomous() const override { return false; }
  std::vector<OwnState> own_states() const override {
    std::vector<OwnState> all;
    if constexpr (Sc::has_states) qdot::detail::for_each(form_.scene().effects(), [&]<class E>(const E& effect) {
      for (int i = 0; i < qdot::detail::states_of<E>(); ++i) {
        if constexpr (requires { E::is_input; }) {
          all.push_back({OwnState::input, qdot::detail::input_name(effect, i)});
        } else if constexpr (SwitchingEffect<E, n>) {
          all.push_back({i == 0 ? OwnState::phase : OwnState::held, i == 0 ? effect.name : effect.name + "_" + std::to_string(i)});
        } else {
          all.push_back({OwnState::state, "z" + std::to_string(all.size())});
        }
      }
    });
    return all;
  }
  Eigen::VectorXd packed(const State<Dynamic>& start) const override {
    return form_.packed(State<n>{start.t, start.q, start.qdot});
  }
  double power(double t, const Eigen::Ref<const Eigen::VectorXd>& y) const override {
    const auto state = form_.state(t, y);
    return qdot::power(form_.scene(), state.q, state.qdot, t, states(y));
  }
  double energy_rate(double t, const Eigen::Ref<const Eigen::VectorXd>& y) const override {
    const auto state = form_.state(t, y);
    if constexpr (!has_traced_constraints) {
      return qdot::energy_rate(form_.scene(), state.q, state.qdot, t, states(y));
    } else {
      Eigen::VectorXd lambda, force = form_.constraint_forces(t, y, lambda);
      if constexpr (Sc::has_forces) force += effect_forces(form_.scene(), state.q, state.qdot, states(y), t);
      return state.qdot.dot(force) + qdot::energy_rate(form_.scene().system(), state.q, state.qdot, t);
    }
  }
  std::vector<Reaction> reactions([[maybe_unused]] double t, [[maybe_unused]] const Eigen::Ref<const Eigen::VectorXd>& y) const override {
    std::vector<Reaction> all;
    if constexpr (Sc::has_constraints) {
      Eigen::VectorXd lambda;
      form_.constraint_forces(t, y, lambda);
      const std::vector<std::string> names = qdot::constraint_names(form_.scene());
      for (std::size_t i = 0; i < names.size(); ++i) all.push_back({names[i], lambda[static_cast<Eigen::Index>(i)]});
    }
    return all;
  }
  Eigen::VectorXd constraint_forces([[maybe_unused]] double t, [[maybe_unused]] const Eigen::VectorXd& y) const override {
    Eigen::VectorXd lambda;
    if constexpr (Sc::has_constraints) return form_.constraint_forces(t, y, lambda);
    return lambda;
  }
  Eigen::VectorXd applied_forces([[maybe_unused]] double t, [[maybe_unused]] const Eigen::VectorXd& y) const override {
    if constexpr (Sc::has_forces) {
      const auto state = form_.state(t, y);
      return effect_forces(form_.scene(), state.q, state.qdot, states(y), t);
    }
    return {};
  }
  bool long_derivative([[maybe_unused]] long double t, [[maybe_unused]] const LongVector& y,
                       [[maybe_unused]] LongVector& ydot) const override {
    if constexpr (qdot::detail::has_any_scalar<Sc>::value) qdot::detail::write_derivative(form_.scene(), t, y, ydot);
    return qdot::detail::has_any_scalar<Sc>::value;
  }
  bool fits_rattle() const override { return qdot::detail::fits_rattle<SceneForm<Sc>>::value; }
  Eigen::VectorXd momenta(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& v) const override { return Behind::momenta(form_, q, v, t); }
  Eigen::MatrixXd inverse_mass(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& v) const override {
    return Behind::inverse_mass(form_, q, v, t);
  }
  Eigen::VectorXd force(double t, const Eigen::VectorXd& y) const override {
    const auto state = form_.state(t, y);
    return Behind::force(form_, state.q, state.qdot, states(y), t);
  }
  Eigen::VectorXd state_rates([[maybe_unused]] double t, [[maybe_unused]] const Eigen::VectorXd& y) const override {
    if constexpr (Sc::has_states) {
      const auto state = form_.state(t, y);
      return Behind::zdot(form_, state.q, state.qdot, states(y), t);
    }
    return {};
  }
  Eigen::VectorXd state_accelerations([[maybe_unused]] double t, [[maybe_unused]] const Eigen::VectorXd& y,
                                      [[maybe_unused]] const Eigen::VectorXd& ydot) const override {
    if constexpr (Sc::has_states) {
      const auto state = form_.state(t, y), rate = form_.state(t, ydot);
      return Behind::zddot(form_, state.q, state.qdot, rate.qdot, states(y), states(ydot), t);
    }
    return {};
  }
  std::optional<AnyStepper> own_stepper(const std::string& method, [[maybe_unused]] double step, [[maybe_unused]] const Options& options) const override {
    if constexpr (qdot::detail::fits_rattle<SceneForm<Sc>>::value)
      if (method.starts_with("rattle")) return any_stepper(Rattle{.step = step, .order = method.back() - '0'}, form_, options);
    return std::nullopt;
  }
  double repeated_acceleration(double t, const Eigen::Ref<const Eigen::VectorXd>& y, int count) const override {
    const auto state = form_.state(t, y);
    const auto z = states(y);
    double sum = 0;
    for (int i = 0; i < count; ++i) {
      detail::touch(&state);
      sum += acceleration(form_.scene(), state.q, state.qdot, t, z)[0];
    }
    return sum;
  }

  qdot::detail::ConstraintsAt constraints_at([[maybe_unused]] double t, [[maybe_unused]] const Eigen::Ref<const Eigen::VectorXd>& y) const override {
    if constexpr (Sc::has_constraints) return qdot::detail::constraints_at(form_.scene(), t, y);
    return {};
  }
  Eigen::MatrixXd displacements([[maybe_unused]] double t, [[maybe_unused]] const Eigen::Ref<const Eigen::VectorXd>& y,
                                [[maybe_unused]] const Eigen::MatrixXd& changes) const override {
    Eigen::MatrixXd ways;
    if constexpr (Sc::has_constraints) {
      const auto state = form_.state(t, y);
      const EffectStates<Sc> z = states(y);
      if (qdot::detail::is_free(form_.scene(), z)) return ways;
      const qdot::detail::SceneRowsOf<Sc> rows(form_.scene());
      auto geometry = qdot::detail::constraint_geometry(form_.scene(), rows, t, default_rank_cutoff);
      geometry.move_to(state.q, state.qdot, z);
      ways.resize(form_.dof(), changes.cols());
      for (Eigen::Index j = 0; j < changes.cols(); ++j) ways.col(j) = Eigen::VectorXd(geometry.displacement(Eigen::VectorXd(changes.col(j))));
    }
    return ways;
  }
  std::vector<std::string> constraint_names() const override {
    if constexpr (Sc::has_constraints) return qdot::constraint_names(form_.scene());
    return {};
  }

 private:
  static EffectStates<Sc> states(const Eigen::Ref<const Eigen::VectorXd>& y) {
    return y.tail(Sc::states_at_compile_time);
  }
};

/// The effects that a scene always has: none.
struct NoEffects {
  template <class E>
  std::tuple<> operator()(const E&) const {
    return {};
  }
};

namespace detail {

// Whether an effect is a constraint that lasts, as a formula.
template <int n, class Effect>
constexpr bool has_rows() {
  if constexpr (ConstraintEffect<Effect, n>) return qdot::detail::effect_is_recordable<Effect, n>();
  return false;
}

template <int n, class Effects>
inline constexpr bool any_has_rows = false;
template <int n, class... Effects>
inline constexpr bool any_has_rows<n, std::tuple<Effects...>> = (has_rows<n, Effects>() || ...);

// What a constraint demands to be zero, if an effect is one that lasts.
template <int n, class Effect, class Q, class S, class Add>
void add_rows([[maybe_unused]] const Effect& effect, [[maybe_unused]] const Q& q, [[maybe_unused]] const Q& v, [[maybe_unused]] const S& t,
              [[maybe_unused]] const Add& add) {
  if constexpr (has_rows<n, Effect>()) {
    const auto rows = [&] {
      if constexpr (HolonomicEffect<Effect, n>) {
        return qdot::detail::as_rows(effect.phi(q, t));
      } else {
        return qdot::detail::as_rows(effect.velocity_constraint(q, v, t));
      }
    }();
    for (Eigen::Index i = 0; i < rows.size(); ++i) add(rows[i]);
  }
}

}  // namespace detail

template <class E, int n, class Always, class... Makes>
class EffectScene final : public SceneRunner<E, n> {
  static constexpr std::size_t count = sizeof...(Makes);

 public:
  EffectScene(scenes::Scene<E, n> scene, Always always, scenes::OptionalEffect<E, Makes>... optional)
      : SceneRunner<E, n>(std::move(scene)), always_(std::move(always)), optional_(std::move(optional)...) {
    std::apply([&](const auto&... e) { infos_ = {EffectInfo{e.name, false, e.value, e.unit, e.range, e.meaning}...}; }, optional_);
  }

  std::vector<EffectInfo> effects() const override { return {infos_.begin(), infos_.end()}; }

  void set_effect(const std::string& name, bool on, std::optional<double> value) override {
    for (EffectInfo& info : infos_) {
      if (info.name != name) continue;
      if (value) {
        require_physical(info.name, info.meaning, info.range, *value);
        info.value = *value;
      }
      info.on = on;
      return;
    }
    SceneRunner<E, n>::set_effect(name, on, value);
  }

  std::shared_ptr<const Model> model() const override { return variant<0>(always_(this->energies())); }

  report::EquationSource equation_source() const override {
    // Effects are made with other parameters than the user's, to see where these go, and not all take them (a restitution of 1.01).
    if constexpr (!detail::any_has_rows<n, std::decay_t<std::invoke_result_t<const Always&, const E&>>>) {
      return SceneRunner<E, n>::equation_source();
    } else {
      return this->equation_source_with([always = always_](const E& e, const auto& q, const auto& v, const auto& t, const auto& add) {
        std::apply([&](const auto&... effect) { (detail::add_rows<n>(effect, q, v, t, add), ...); }, always(e));
      });
    }
  }

 private:
  template <std::size_t i, class... Chosen>
  std::shared_ptr<const Model> variant(const std::tuple<Chosen...>& chosen) const {
    if constexpr (i < count) {
      if (!infos_[i].on) return variant<i + 1>(chosen);
      return variant<i + 1>(std::tuple_cat(chosen, std::make_tuple(std::get<i>(optional_).make(this->energies(), infos_[i].value))));
    } else if constexpr (sizeof...(Chosen) == 0) {
      return this->bare_model();
    } else {
      return std::apply([&](const auto&... effect) -> std::shared_ptr<const Model> {
        auto composed = scene(this->system(), effect...);
        return std::make_shared<SceneModel<decltype(composed)>>(std::move(composed));
      }, chosen);
    }
  }

  Always always_;
  std::tuple<scenes::OptionalEffect<E, Makes>...> optional_;
  std::array<EffectInfo, count> infos_;
};

/// A scene with effects that a run may switch on.
template <class E, int n, class... Makes>
std::unique_ptr<RunnableScene> runnable(scenes::Scene<E, n> scene, scenes::OptionalEffect<E, Makes>... optional)
  requires(sizeof...(Makes) > 0)
{
  static_assert(qdot::detail::require_energies<E, n>());  // here, so that compilers show the line of the user's file
  return std::make_unique<EffectScene<E, n, NoEffects, Makes...>>(std::move(scene), NoEffects{}, std::move(optional)...);
}

/// A scene that always has the effects always(energies), a tuple, and others that a run may switch on.
template <class Always, class E, int n, class... Makes>
std::unique_ptr<RunnableScene> runnable_with(Always always, scenes::Scene<E, n> scene, scenes::OptionalEffect<E, Makes>... optional) {
  static_assert(qdot::detail::require_energies<E, n>());
  return std::make_unique<EffectScene<E, n, Always, Makes...>>(std::move(scene), std::move(always), std::move(optional)...);
}

}  // namespace qdot::program
