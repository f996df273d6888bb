// SPDX-License-Identifier: MIT
//
// qdot list: the scenes, their degrees of freedom, and their parameters with defaults; qdot list SCENE: one of them, with units and meanings.
#include <cstddef>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "program/catalogue.hpp"
#include "program/commands.hpp"
#include "program/json.hpp"
#include "program/methods.hpp"
#include "qdot/report/number.hpp"

namespace qdot::program {

namespace {

// Names of one scene as --set and --with take them, with what they mean.
void show(const RunnableScene& scene) {
  const auto row = [](const std::string& name, double value, const std::string& unit, const std::string& meaning) {
    std::printf("  %-16s %12s  %-10s %s\n", name.c_str(), report::exact_text(value).c_str(), unit.c_str(), meaning.c_str());
  };
  std::printf("%s: %s\n%s\n\nparameters, --set NAME=VALUE\n", scene.name().c_str(), scene.title().c_str(), scene.summary().c_str());
  for (const ParameterInfo& p : scene.parameters()) row(p.name, p.value, p.unit, p.meaning);
  std::printf("\nstart, --set NAME=VALUE\n");
  const std::vector<scenes::Coordinate> coordinates = scene.coordinates();
  const State<Dynamic> start = scene.start();
  for (Eigen::Index i = 0; i < start.q.size(); ++i) {
    const scenes::Coordinate& c = coordinates[static_cast<std::size_t>(i)];
    row("q" + std::to_string(i), start.q[i], c.unit, c.name);
  }
  for (Eigen::Index i = 0; i < start.q.size(); ++i) {
    const scenes::Coordinate& c = coordinates[static_cast<std::size_t>(i)];
    row("qdot" + std::to_string(i), start.qdot[i], c.unit + "/" + scene.time_unit(), c.name + "dot");
  }
  if (!scene.effects().empty()) std::printf("\neffects, --with NAME=VALUE\n");
  for (const EffectInfo& e : scene.effects()) row(e.name, e.value, e.unit, e.meaning);
  std::printf("\nends at t = %s %s, or --t-end T\n", report::exact_text(scene.t_end()).c_str(), scene.time_unit().c_str());
}

}  // namespace

int list(const ListOptions& options) {
  std::vector<std::unique_ptr<RunnableScene>> scenes;
  for (const std::string& name : options.scene ? std::vector<std::string>{*options.scene} : scene_names()) scenes.push_back(make_scene(name));
  if (options.json) {
    std::printf("%s\n", list_json(scenes).c_str());
    return 0;
  }
  if (options.scene) {
    show(*scenes.front());
    return 0;
  }
  std::printf("%-20s %3s  %s\n", "scene", "dof", "parameters [effects, --with NAME=VALUE]");
  for (const auto& scene : scenes) {
    std::string parameters;
    for (const ParameterInfo& p : scene->parameters()) {
      parameters += (parameters.empty() ? "" : " ") + p.name + "=" + report::exact_text(p.value);
    }
    for (const EffectInfo& e : scene->effects()) parameters += " [" + e.name + "=" + report::exact_text(e.value) + "]";
    const bool counted = scene->parameters().front().whole;
    const std::string dof = counted ? scene->parameters().front().name : std::to_string(scene->coordinates().size());
    std::printf("%-20s %3s  %s\n", scene->name().c_str(), dof.c_str(), parameters.c_str());
  }
  std::printf("\n%-20s %s\n", "method", "what it is for (--method NAME)");
  for (const MethodInfo& method : methods()) std::printf("%-20s %s\n", method.name.c_str(), method.summary.c_str());
  return 0;
}

}  // namespace qdot::program
