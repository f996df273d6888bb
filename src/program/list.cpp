// SPDX-License-Identifier: MIT
//
// qdot list: the scenes, their degrees of freedom, and their parameters with defaults.
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

int list(const ListOptions& options) {
  std::vector<std::unique_ptr<RunnableScene>> scenes;
  for (const std::string& name : scene_names()) scenes.push_back(make_scene(name));
  if (options.json) {
    std::printf("%s\n", list_json(scenes).c_str());
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
