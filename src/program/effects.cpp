// SPDX-License-Identifier: MIT
//
// qdot effects SCENE: what one evaluation of q̈ costs with each optional effect alone and with all of them, beside the bare
// scene in the same run.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "program/arguments.hpp"
#include "program/catalogue.hpp"
#include "program/commands.hpp"

namespace qdot::program {

namespace {

struct Variant {
  std::string name;
  std::shared_ptr<const Model> model;
  Eigen::VectorXd y;
  int count = 1;  // evaluations in one measurement
  double nanoseconds = std::numeric_limits<double>::infinity();
};

double seconds(const Variant& v, double t) {
  const auto began = std::chrono::steady_clock::now();
  v.model->repeated_acceleration(t, v.y, v.count);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
}

/// The least of many short measurements, in which all variants take turns.
void measure(std::vector<Variant>& variants, double t) {
  constexpr double shortest = 2e-4;
  constexpr int rounds = 60;
  for (Variant& v : variants) {
    while (seconds(v, t) < shortest) v.count *= 2;
  }
  for (int round = 0; round < rounds; ++round) {
    for (Variant& v : variants) v.nanoseconds = std::min(v.nanoseconds, 1e9 * seconds(v, t) / v.count);
  }
}

}  // namespace

int effects(const EffectsOptions& options) {
  const std::unique_ptr<RunnableScene> scene = make_scene(options.scene);
  const State<Dynamic> start = start_with(*scene, configured(*scene, options.set));
  const std::vector<EffectInfo> available = scene->effects();
  std::vector<Variant> variants;
  const auto add = [&](const std::string& name) {
    Variant v{.name = name, .model = scene->model(), .y = {}};
    v.y = v.model->packed(start);
    if (v.model->is_constrained()) v.model->project(start.t, v.y);
    variants.push_back(std::move(v));
  };
  add("bare");
  for (const EffectInfo& effect : available) {
    scene->set_effect(effect.name, true, std::nullopt);
    add(effect.name);
    scene->set_effect(effect.name, false, std::nullopt);
  }
  if (available.size() > 1) {
    for (const EffectInfo& effect : available) scene->set_effect(effect.name, true, std::nullopt);
    add("all");
    for (const EffectInfo& effect : available) scene->set_effect(effect.name, false, std::nullopt);
  }
  add("bare again, all switched off");
  measure(variants, start.t);

  const double bare = variants.front().nanoseconds;
  if (options.json) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const Variant& v : variants) {
      rows.push_back({{"effects", v.name}, {"ns", v.nanoseconds}, {"evaluations_per_second", 1e9 / v.nanoseconds}, {"ratio", v.nanoseconds / bare}});
    }
    std::printf("%s\n", nlohmann::ordered_json{{"scene", scene->name()}, {"rows", rows}}.dump(2).c_str());
    return 0;
  }
  std::printf("%s: one evaluation of the accelerations\n", scene->name().c_str());
  std::printf("  %-30s %10s %16s %8s\n", "effects", "ns", "evaluations/s", "ratio");
  for (const Variant& v : variants) {
    std::printf("  %-30s %10.1f %16.3g %8.2f\n", v.name.c_str(), v.nanoseconds, 1e9 / v.nanoseconds, v.nanoseconds / bare);
  }
  if (available.empty()) std::printf("  the scene has no optional effects\n");
  return 0;
}

}  // namespace qdot::program
