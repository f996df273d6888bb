#pragma once
// SPDX-License-Identifier: MIT
//
// From a scene with its type to a scene without: the one template that every scene's .cpp instantiates. A scene with optional
// effects or with constraints is that of effect_variants.hpp.

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "program/runnable_scene.hpp"
#include "program/system_model.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/system.hpp"
#include "qdot/mechanics/written_out.hpp"
#include "qdot/report/equations/source.hpp"
#include "qdot/report/number.hpp"
#include "scenes/scene.hpp"

namespace qdot::program {

/// The largest count that a whole-numbered parameter may have; beyond it one evaluation takes seconds.
inline constexpr int largest_count = 500;

inline void require_physical(const std::string& what, scenes::Range range, double value) {
  using scenes::Range;
  if (std::isfinite(value) && (range == Range::any || (range == Range::positive ? value > 0 : value >= 0))) return;
  const char* rule = range == Range::any ? "finite" : range == Range::positive ? "positive" : "zero or positive";
  throw InvalidValue(what + " must be " + rule + ", given " + report::exact_text(value));
}

/// A scene of the catalogue with its own copy of the energies, whose members are the parameters.
template <class E, int n>
class SceneRunner : public RunnableScene {
 public:
  explicit SceneRunner(scenes::Scene<E, n> scene) : scene_(std::move(scene)) {}

  std::string name() const override { return scene_.name; }
  std::string title() const override { return scene_.title; }
  std::string summary() const override { return scene_.summary; }
  std::string time_unit() const override { return scene_.time_unit; }
  std::string energy_unit() const override { return scene_.energy_unit; }
  double t_end() const override { return scene_.t_end; }

  std::vector<ParameterInfo> parameters() const override {
    std::vector<ParameterInfo> infos;
    for (const auto& p : scene_.parameters) {
      const double value = std::visit([&](auto member) { return static_cast<double>(energies_.*member); }, p.member);
      infos.push_back({p.name, value, std::holds_alternative<int E::*>(p.member), p.unit, p.range, p.meaning});
    }
    return infos;
  }

  void set_parameter(const std::string& name, double value) override {
    for (const auto& p : scene_.parameters) {
      if (p.name != name) continue;
      if (const auto* whole = std::get_if<int E::*>(&p.member)) {
        if (!(value >= 1 && value <= largest_count) || value != std::floor(value)) {
          throw InvalidValue(p.name + " (" + p.meaning + ") must be a whole number from 1 to " +
                             std::to_string(largest_count) + ", given " + report::exact_text(value));
        }
        energies_.**whole = static_cast<int>(value);
        return;
      }
      require_physical(p.name + " (" + p.meaning + ")", p.range, value);
      energies_.*std::get<double E::*>(p.member) = value;
      return;
    }
    throw InvalidValue(scene_.name + " has no parameter named " + name);
  }

  std::vector<scenes::Coordinate> coordinates() const override { return scene_.coordinates(energies_); }

  State<Dynamic> start() const override {
    const State<n> start = scene_.start(energies_);
    return {start.t, start.q, start.qdot};
  }

  void set_effect(const std::string& name, bool, std::optional<double>) override {
    throw InvalidValue(scene_.name + " has no effect named " + name);
  }

  report::EquationSource equation_source() const override { return equation_source_with(report::detail::NoRows{}); }

  report::Drawing drawing() const override { return scene_.drawing(energies_); }

  std::vector<report::Point> positions(const Eigen::Ref<const Eigen::VectorXd>& q, double t) const override {
    return scene_.positions(energies_, Vector<double, n>(q), t);
  }

 protected:
  const E& energies() const { return energies_; }

  template <class Rows>
  report::EquationSource equation_source_with(const Rows& rows) const {
    std::vector<std::string> names;
    std::vector<report::NamedParameter<E>> parameters;
    for (const auto& coordinate : coordinates()) names.push_back(coordinate.name);
    for (const auto& p : scene_.parameters)
      if (const auto* member = std::get_if<double E::*>(&p.member)) parameters.push_back({p.name, *member});
    return report::equation_source<n>(energies_, std::move(names), parameters, rows);
  }

  /// T and V alone; not compiled for a scene that never is.
  std::shared_ptr<const Model> bare_model() const { return std::make_shared<SystemModel<decltype(system())>>(system()); }

  auto system() const {
    std::vector<std::string> names;
    for (const auto& coordinate : coordinates()) names.push_back(coordinate.name);
    if constexpr (n == Dynamic) {
      return mechanical_system(static_cast<Eigen::Index>(names.size()), energies_).with_names(names);
    } else if constexpr (CanBeWrittenOut<E, n>) {
      return mechanical_system<n>(written_out<n>(energies_)).with_names(names);
    } else {
      return mechanical_system<n>(energies_).with_names(names);
    }
  }

 private:
  scenes::Scene<E, n> scene_;
  E energies_;
};

/// A scene without effects.
template <class E, int n>
class BareScene final : public SceneRunner<E, n> {
 public:
  using SceneRunner<E, n>::SceneRunner;
  std::shared_ptr<const Model> model() const override { return this->bare_model(); }
};

template <class E, int n>
std::unique_ptr<RunnableScene> runnable(scenes::Scene<E, n> scene) {
  return std::make_unique<BareScene<E, n>>(std::move(scene));
}

}  // namespace qdot::program
