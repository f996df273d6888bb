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

namespace {

By way_named(const std::string& name) {
  const std::pair<const char*, By> ways[] = {{"fastest", By::fastest}, {"duals", By::duals}, {"lines", By::lines}, {"machine_code", By::machine_code}};
  std::vector<std::string> valid;
  for (const auto& [known, way] : ways) {
    if (name == known) return way;
    valid.push_back(known);
  }
  throw unknown_name("--by", "a way to evaluate T and V", name, valid);
}

}  // namespace

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

void choose_way(RunnableScene& scene, const SceneOptions& options) {
  if (options.by) scene.set_by(way_named(*options.by));
}

std::vector<InitialValue> configured(RunnableScene& scene, const std::vector<std::string>& settings) {
  std::vector<std::string> valid;
  for (const ParameterInfo& p : scene.parameters()) valid.push_back(p.name);
  std::vector<Assignment> others;
  for (const std::string& text : settings) {
    const Assignment set = assignment("--set", text);
    if (std::find(valid.begin(), valid.end(), set.name) == valid.end()) {
      others.push_back(set);
      continue;
    }
    try {
      scene.set_parameter(set.name, set.value);
    } catch (const InvalidValue& error) {
      throw UsageError(std::string("--set: ") + error.what());
    }
  }
  std::vector<InitialValue> values;
  if (others.empty()) return values;
  const std::vector<ComponentNames> names = names_of_start(scene);  // whose number parameters decide
  for (const ComponentNames& each : names) {
    valid.push_back(each.name);
    if (each.plain != each.name) valid.push_back(each.plain);
  }
  for (const Assignment& set : others) {
    const auto found = std::find_if(names.begin(), names.end(), [&](const ComponentNames& each) { return set.name == each.name || set.name == each.plain; });
    if (found == names.end()) throw unknown_name("--set", "a parameter or initial value of " + scene.name(), set.name, valid);
    values.push_back({found - names.begin(), set.value});
  }
  return values;
}

State<Dynamic> start_with(const RunnableScene& scene, const std::vector<InitialValue>& values) {
  State<Dynamic> start = scene.start();
  const Eigen::Index n = start.q.size();
  for (const auto& [place, value] : values) (place < n ? start.q[place] : start.qdot[place - n]) = value;
  return start;
}

std::vector<ComponentNames> names_of_start(const RunnableScene& scene) {
  std::vector<ComponentNames> names;
  const auto coordinates = scene.coordinates();
  const std::string time = scene.time_unit();
  for (const bool rate : {false, true})
    for (std::size_t i = 0; i < coordinates.size(); ++i) {
      const auto& [name, unit] = coordinates[i];
      names.push_back({name + (rate ? "dot" : ""), (rate ? "qdot" : "q") + std::to_string(i),
                       rate && !time.empty() ? (unit.empty() ? "1" : unit) + "/" + time : unit});
    }
  return names;
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
  chosen.initial_values = configured(*chosen.scene, options.set);
  chosen.start = start_with(*chosen.scene, chosen.initial_values);
  choose_effects(*chosen.scene, options);
  choose_way(*chosen.scene, options);
  chosen.model = model_of(*chosen.scene);
  return chosen;
}

}  // namespace qdot::program
