// SPDX-License-Identifier: MIT
#include "program/chosen_scene.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "program/arguments.hpp"
#include "program/catalogue.hpp"

namespace qdot::program {

void choose_effects(RunnableScene& scene, const SceneOptions& options) {
  std::vector<std::string> valid;
  for (const EffectInfo& effect : scene.effects()) valid.push_back(effect.name);
  const auto choose = [&](const char* option, const std::string& text, bool on) {
    const bool valued = on && text.find('=') != std::string::npos;
    const std::string name = valued ? assignment(option, text).name : text;
    if (valid.empty()) {
      throw UsageError(std::string(option) + ": must name an effect of the scene; " + scene.name() + " has no effect \"" + name +
                       "\" (it has none)");
    }
    if (std::find(valid.begin(), valid.end(), name) == valid.end()) {
      throw unknown_name(option, "an effect of " + scene.name(), name, valid);
    }
    try {
      scene.set_effect(name, on, valued ? std::optional(assignment(option, text).value) : std::nullopt);
    } catch (const InvalidValue& error) {
      throw UsageError(std::string(option) + ": " + error.what());
    }
  };
  for (const std::string& text : options.with) choose("--with", text, true);
  for (const std::string& text : options.without) choose("--without", text, false);
}

State<Dynamic> configured(RunnableScene& scene, const std::vector<std::string>& settings) {
  std::vector<std::string> valid;
  for (const ParameterInfo& p : scene.parameters()) valid.push_back(p.name);
  std::vector<Assignment> initial_values;
  for (const std::string& text : settings) {
    const Assignment set = assignment("--set", text);
    if (std::find(valid.begin(), valid.end(), set.name) == valid.end()) {
      initial_values.push_back(set);
      continue;
    }
    try {
      scene.set_parameter(set.name, set.value);
    } catch (const InvalidValue& error) {
      throw UsageError(std::string("--set: ") + error.what());
    }
  }
  State<Dynamic> start = scene.start();
  if (initial_values.empty()) return start;
  std::vector<std::pair<std::string, double*>> places;
  for (Eigen::Index i = 0; i < start.q.size(); ++i) places.emplace_back(std::string("q").append(std::to_string(i)), &start.q[i]);
  for (Eigen::Index i = 0; i < start.q.size(); ++i) places.emplace_back(std::string("qdot").append(std::to_string(i)), &start.qdot[i]);
  for (const auto& [name, place] : places) valid.push_back(name);
  for (const Assignment& set : initial_values) {
    const auto found = std::find_if(places.begin(), places.end(), [&](const auto& p) { return p.first == set.name; });
    if (found == places.end()) {
      throw unknown_name("--set", "a parameter or initial value of " + scene.name(), set.name, valid);
    }
    *found->second = set.value;
  }
  return start;
}

std::shared_ptr<const Model> model_of(const RunnableScene& scene) {
  try {
    return scene.model();
  } catch (const InvalidValue& error) {
    throw UsageError(std::string("--set: ") + error.what());
  }
}

ChosenScene chosen_scene(const SceneOptions& options) { return chosen_scene(options, make_scene(options.scene)); }

ChosenScene chosen_scene(const SceneOptions& options, std::unique_ptr<RunnableScene> scene) {
  ChosenScene chosen;
  chosen.scene = std::move(scene);
  chosen.start = configured(*chosen.scene, options.set);
  choose_effects(*chosen.scene, options);
  chosen.model = model_of(*chosen.scene);
  return chosen;
}

}  // namespace qdot::program
