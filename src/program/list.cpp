// SPDX-License-Identifier: MIT
//
// The command qdot list prints the scenes, their degrees of freedom, and their parameters with defaults. With a scene's name it prints T and V of
// that scene, units, ranges and meanings, and a command to begin with.
#include <cstddef>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "program/catalogue.hpp"
#include "program/commands.hpp"
#include "program/json.hpp"
#include "program/methods.hpp"
#include "qdot/report/equation_text.hpp"
#include "qdot/report/equations.hpp"
#include "qdot/report/number.hpp"

namespace qdot::program {

namespace {

// "length of the rod; positive"
std::string with_range(const std::string& meaning, const std::string& range) {
  return range == "any" ? meaning : meaning + (meaning.empty() ? "" : "; ") + range;
}

// "2", or "2n" where a count says how many.
std::string degrees_of_freedom(const RunnableScene& scene) {
  const std::vector<ParameterInfo> parameters = scene.parameters();
  const std::size_t dof = scene.coordinates().size();
  if (parameters.empty() || !parameters.front().whole) return std::to_string(dof);
  const auto& [name, count] = std::pair(parameters.front().name, static_cast<std::size_t>(parameters.front().value));
  if (dof == count) return name;
  if (dof == count * count) return name + "²";
  return dof % count == 0 ? std::to_string(dof / count) + name : std::to_string(dof);
}

// T = … and V = …, where they are formulas that one can read.
void show_energies(const RunnableScene& scene) {
  constexpr std::size_t readable = 6;  // coordinates
  const report::EquationSource source = scene.equation_source();
  if (source.coordinates.size() > readable) return;
  try {
    for (const report::Equation& e : report::energies_of(source))
      std::printf("  %s = %s\n", report::text_of(e.left, report::PlainNotation{}).c_str(), report::text_of(e.right, report::PlainNotation{}).c_str());
    std::printf("\n");
  } catch (const Error& error) {
    std::printf("  T and V cannot be written down: %s\n\n", error.what());
  }
}

// Something else than the default of the first parameter, as an example.
std::string example(const RunnableScene& scene, const std::string& given) {
  std::string text = "qdot run " + given;
  for (const ParameterInfo& p : scene.parameters()) {
    const double other = p.whole ? p.value + 1 : p.value == 0 ? 1 : 2 * p.value;
    if (!p.range.holds(other)) continue;
    text += " --set " + p.name + "=" + report::exact_text(other);
    break;
  }
  if (!scene.effects().empty()) text += " --with " + scene.effects().front().name + "=" + report::exact_text(scene.effects().front().value);
  return text + " --out out/" + scene.name();
}

// What a scene is, and its names as --set and --with take them, with what they mean.
void show(const RunnableScene& scene, const std::string& given) {
  const auto row = [](const std::string& name, double value, const std::string& unit, const std::string& meaning) {
    std::string line = "  " + name + std::string(name.size() < 16 ? 17 - name.size() : 1, ' ');
    const std::string number = report::exact_text(value);
    line += std::string(number.size() < 12 ? 12 - number.size() : 0, ' ') + number + "  " + unit;
    if (!meaning.empty()) line += std::string(unit.size() < 10 ? 11 - unit.size() : 1, ' ') + meaning;
    std::printf("%s\n", line.substr(0, line.find_last_not_of(' ') + 1).c_str());
  };
  std::printf("%s\n", (scene.title() == scene.name() ? scene.name() : scene.name() + ": " + scene.title()).c_str());
  if (!scene.summary().empty()) std::printf("%s\n", scene.summary().c_str());
  std::printf("\n");
  show_energies(scene);
  if (!scene.parameters().empty()) std::printf("parameters, --set NAME=VALUE\n");
  for (const ParameterInfo& p : scene.parameters())
    row(p.name, p.value, p.unit, with_range(p.meaning, p.whole ? "a whole number " + p.range.text() : p.range.text()));
  std::printf("%sstart, --set NAME=VALUE\n", scene.parameters().empty() ? "" : "\n");
  const std::vector<scenes::Coordinate> coordinates = scene.coordinates();
  const State<Dynamic> start = scene.start();
  for (Eigen::Index i = 0; i < start.q.size(); ++i) {
    const scenes::Coordinate& c = coordinates[static_cast<std::size_t>(i)];
    row("q" + std::to_string(i), start.q[i], c.unit, c.name);
  }
  for (Eigen::Index i = 0; i < start.q.size(); ++i) {
    const scenes::Coordinate& c = coordinates[static_cast<std::size_t>(i)];
    row("qdot" + std::to_string(i), start.qdot[i], c.unit.empty() ? "" : c.unit + "/" + scene.time_unit(), c.name + "dot");
  }
  if (!scene.effects().empty()) std::printf("\neffects, --with NAME=VALUE\n");
  for (const EffectInfo& e : scene.effects()) row(e.name, e.value, e.unit, with_range(e.meaning, e.range.text()));
  std::printf("\nends at t = %s %s, or --t-end T\n", report::exact_text(scene.t_end()).c_str(), scene.time_unit().c_str());
  std::printf("\nfor example: %s\n", example(scene, given).c_str());
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
    show(*scenes.front(), *options.scene);
    return 0;
  }
  std::printf("%-20s %3s  %s\n", "scene", "dof", "parameters [effects, --with NAME=VALUE]");
  for (const auto& scene : scenes) {
    std::string parameters;
    for (const ParameterInfo& p : scene->parameters()) {
      parameters += (parameters.empty() ? "" : " ") + p.name + "=" + report::exact_text(p.value);
    }
    for (const EffectInfo& e : scene->effects()) parameters += " [" + e.name + "=" + report::exact_text(e.value) + "]";
    std::printf("%-20s %3s  %s\n", scene->name().c_str(), degrees_of_freedom(*scene).c_str(), parameters.c_str());
  }
  std::printf("\n%-20s %s\n", "method", "what it is for (--method NAME)");
  for (const MethodInfo& method : methods()) std::printf("%-20s %s\n", method.name.c_str(), method.summary.c_str());
  return 0;
}

}  // namespace qdot::program
