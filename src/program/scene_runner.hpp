#pragma once
// SPDX-License-Identifier: MIT
//
// From a scene with its type to a scene without: the one template that every scene instantiates in a file of its own, which src/CMakeLists.txt makes
// for most of them. A scene with optional effects or with constraints is that of effect_variants.hpp.

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "program/runnable_scene.hpp"
#include "program/system_model.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/system.hpp"
#include "qdot/report/equations/source.hpp"
#include "qdot/report/number.hpp"
#include "scenes/scene.hpp"

namespace qdot::program {

/// The largest count that a whole-numbered parameter may have; its range may end before.
inline constexpr double largest_count = 1e6;

/// The range of a whole-numbered parameter.
inline scenes::Range whole_range(const scenes::Range& range) { return scenes::Range::between(std::max(1.0, range.least), std::min(largest_count, range.most)); }

inline void require_physical(const std::string& name, const std::string& meaning, const scenes::Range& range, double value) {
  if (range.holds(value)) return;
  const std::string rule = range.text();
  throw InvalidValue(name + (meaning.empty() ? "" : " (" + meaning + ")") + " must be " + (rule == "any" ? "finite" : rule) + ", given " +
                     report::exact_text(value));
}

/// A scene of the catalogue with its own copy of the energies, whose members are the parameters.
template <class E, int n>
class SceneRunner : public RunnableScene {
 public:
  /// @throws InvalidValue  the scene contradicts itself: a default out of its range, a start of another length than the coordinates
  explicit SceneRunner(scenes::Scene<E, n> scene) : scene_(std::move(scene)) {
    for (const ParameterInfo& p : parameters()) {
      if (p.whole || p.name.empty()) continue;
      require_physical("the default of " + p.name, p.meaning, p.range, p.value);
    }
    start();
    if (scene_.drawing && !scene_.positions) throw InvalidValue("a drawing must have positions to hang on, but there are none: give .positions");
  }

  std::string name() const override { return scene_.name; }
  void set_name(const std::string& name) override { scene_.name = name; }
  std::string title() const override { return scene_.title.empty() ? scene_.name : scene_.title; }
  std::string summary() const override { return scene_.summary; }
  std::string time_unit() const override { return scene_.time_unit; }
  std::string energy_unit() const override { return scene_.energy_unit; }
  double t_end() const override { return scene_.t_end; }

  std::vector<ParameterInfo> parameters() const override {
    std::vector<ParameterInfo> infos;
    for (const auto& p : scene_.parameters) {
      const double value = std::visit([&](auto member) { return static_cast<double>(energies_.*member); }, p.member);
      const bool whole = std::holds_alternative<int E::*>(p.member);
      infos.push_back({p.name, value, whole, p.unit, whole ? whole_range(p.range) : p.range, p.meaning});
    }
    return infos;
  }

  void set_parameter(const std::string& name, double value) override {
    for (const auto& p : scene_.parameters) {
      if (p.name != name) continue;
      if (const auto* whole = std::get_if<int E::*>(&p.member)) {
        const scenes::Range range = whole_range(p.range);
        if (!range.holds(value) || value != std::floor(value))
          throw InvalidValue(p.name + (p.meaning.empty() ? "" : " (" + p.meaning + ")") + " must be a whole number " + range.text() +
                             ", given " + report::exact_text(value));
        energies_.*(*whole) = static_cast<int>(value);
        return;
      }
      require_physical(p.name, p.meaning, p.range, value);
      energies_.*std::get<double E::*>(p.member) = value;
      return;
    }
    throw InvalidValue(scene_.name + " has no parameter named " + name);
  }

  std::vector<scenes::Coordinate> coordinates() const override {
    std::vector<scenes::Coordinate> named;
    if (scene_.coordinates) {
      named = scene_.coordinates(energies_);
      if (named.empty() || (n != Dynamic && named.size() != static_cast<std::size_t>(n)))
        throw InvalidValue("coordinates must name each of " + (n == Dynamic ? std::string("them") : std::to_string(n)) + ", but name " +
                           std::to_string(named.size()));
    } else if constexpr (n == Dynamic) {
      throw InvalidValue("coordinates must be given where their number is not known to the compiler: .coordinates is a function of the parameters");
    } else {
      for (int i = 0; i < n; ++i) named.push_back({"q" + std::to_string(i), ""});
    }
    return named;
  }

  State<Dynamic> start() const override {
    const auto count = static_cast<Eigen::Index>(coordinates().size());
    if (!scene_.start) return {0.0, Eigen::VectorXd::Zero(count), Eigen::VectorXd::Zero(count)};
    const State<n> start = scene_.start(energies_);
    if (start.q.size() != count || start.qdot.size() != count)
      throw InvalidValue("start must have " + std::to_string(count) + " coordinates and as many velocities, but has " +
                         std::to_string(start.q.size()) + " and " +
                         std::to_string(start.qdot.size()));
    return {start.t, start.q, start.qdot};
  }

  void set_effect(const std::string& name, bool, std::optional<double>) override {
    throw InvalidValue(scene_.name + " has no effect named " + name);
  }

  void set_by(By way) override { by_ = way; }

  report::EquationSource equation_source() const override { return equation_source_with(report::detail::NoRows{}); }

  report::Drawing drawing() const override {
    if (scene_.drawing) return scene_.drawing(energies_);
    const State<Dynamic> at = start();
    std::vector<int> points(positions(at.q, at.t).size());
    if (points.empty()) return {};
    std::iota(points.begin(), points.end(), 0);
    const int last = points.back();
    return {.shapes = {report::line(std::move(points)), report::disk(last)}};
  }

  std::vector<report::Point> positions(const Eigen::Ref<const Eigen::VectorXd>& q, double t) const override {
    if (!scene_.positions) return {};
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
  std::shared_ptr<const Model> bare_model() const {
    using Sys = decltype(system());
    if constexpr (n != Dynamic && n <= most_hidden_coordinates && qdot::detail::RecordableEnergies<typename Sys::EnergiesType, n>) {
      constexpr bool timed = !Sys::autonomous;
      const Sys bare = system();
      return model_of_energies<n, timed>(ModelEnergies<n, timed>(bare.energies()), bare.parts());
    } else {
      return std::make_shared<SystemModel<Sys>>(system());
    }
  }

  auto system() const {
    std::vector<std::string> names;
    for (const auto& coordinate : coordinates()) names.push_back(coordinate.name);
    if constexpr (n == Dynamic) {
      return mechanical_system(static_cast<Eigen::Index>(names.size()), energies_).with_names(names).by(by_);
    } else {
      return mechanical_system<n>(energies_).with_names(names).by(by_);
    }
  }

 private:
  scenes::Scene<E, n> scene_;
  E energies_;
  By by_ = By::fastest;
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
  static_assert(qdot::detail::require_energies<E, n>());  // here, so that compilers show the line of the user's file
  return std::make_unique<BareScene<E, n>>(std::move(scene));
}

}  // namespace qdot::program
