// SPDX-License-Identifier: MIT
#include "program/catalogue.hpp"

#include <functional>

#include "program/arguments.hpp"
#include "program/scene_file.hpp"

namespace qdot::program {

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const NamedScene& scene : named_scenes()) names.push_back(scene.name);
  return names;
}

namespace {

/// Refuses a drawing that hangs on points which are not there.
std::unique_ptr<RunnableScene> drawable(std::unique_ptr<RunnableScene> scene, const std::string& given) {
  const State<Dynamic> start = scene->start();
  const int points = static_cast<int>(scene->positions(start.q, start.t).size());
  if (points == 0) return scene;
  for (const report::Shape& shape : scene->drawing().shapes)
    for (const int point : shape.points)
      if (point < 0 || point >= points)
        throw UsageError("SCENE: " + given + ": the drawing must hang on what positions returns, points 0 to " + std::to_string(points - 1) +
                         ", but names point " + std::to_string(point));
  return scene;
}

}  // namespace

std::function<std::unique_ptr<RunnableScene>()> scene_maker(const std::string& wanted) {
  if (is_scene_file(wanted)) return scene_maker_of_file(wanted);
  for (const NamedScene& entry : named_scenes())
    if (entry.name == wanted)
      return [entry] {
        std::unique_ptr<RunnableScene> scene = entry.make();
        if (scene->name().empty()) scene->set_name(entry.name);
        return scene;
      };
  throw unknown_name("SCENE", "a scene", wanted, scene_names());
}

std::unique_ptr<RunnableScene> make_scene(const std::string& wanted) { return drawable(scene_maker(wanted)(), wanted); }

}  // namespace qdot::program
