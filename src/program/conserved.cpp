// SPDX-License-Identifier: MIT
//
// qdot conserved SCENE: which momenta are conserved, whether Jacobi's integral is, and whether it is T + V; with the reasons, and the values at
// the start.
#include "qdot/analysis/conserved.hpp"

#include <cstddef>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "program/arguments.hpp"
#include "program/catalogue.hpp"
#include "program/commands.hpp"
#include "qdot/report/equations/source.hpp"
#include "qdot/report/number.hpp"

namespace qdot::program {

namespace {

using Json = nlohmann::ordered_json;

using qdot::detail::RecordedEffect, qdot::detail::RecordedMotion, qdot::detail::RecordedScene;

// T and V of the scene alone.
void record_energies(RecordedScene& recorded, const RunnableScene& scene) {
  const report::EquationSource source = scene.equation_source();
  RecordedMotion& m = recorded.motion;
  const auto dof = static_cast<Eigen::Index>(recorded.names.size());
  try {
    report::RecordedFormulas formulas = source.record(source.values);
    m.recording = std::move(formulas.recording);
    recorded.T = formulas.outputs[0];
    recorded.V = formulas.outputs[1];
  } catch (const NotAnalytic&) {
    recorded.unreadable = "T or V asks for signs or sizes of its arguments";
  }
  m.q = qdot::detail::new_variables(m.recording, 0, dof);
  m.qdot = qdot::detail::new_variables(m.recording, dof, dof);
  m.t = m.recording.graph.variable(static_cast<int>(2 * dof));
}

// What is added to the equations of T and V: forces all together, and the rows of constraints.
void record_effects(RecordedScene& recorded) {
  RecordedMotion& m = recorded.motion;
  formula::Graph& graph = m.recording.graph;
  const std::size_t n = m.q.size();
  const auto first_force = m.returned.begin() + 2;  // behind T and V, where there are forces
  if (m.returned.size() >= 2 + n + m.rows.size()) {
    RecordedEffect forces{.name = "the effects", .unreadable = "", .force = {}, .J = {}, .drift = {}};
    forces.force.assign(first_force, first_force + static_cast<std::ptrdiff_t>(n));
    recorded.effects.push_back(forces);
  }
  for (std::size_t row = 0; row < m.rows.size(); ++row) {
    RecordedEffect constraint{.name = "'" + m.row_names[row] + "'", .unreadable = "", .force = {}, .J = {}, .drift = {}};
    int drift = m.rows[row];
    for (std::size_t i = 0; i < n; ++i) {
      const int slope = m.jacobian[row * n + i];
      constraint.J.push_back(slope);
      drift = graph.difference(drift, graph.product(slope, m.qdot[i]));
    }
    constraint.drift.push_back(drift);
    recorded.effects.push_back(constraint);
  }
}

RecordedScene recorded_scene(const RunnableScene& scene, const Model& model) {
  RecordedScene recorded;
  for (const auto& coordinate : scene.coordinates()) recorded.names.push_back(coordinate.name);
  recorded.autonomous = model.autonomous();
  recorded.variables = static_cast<std::size_t>(model.size()) + 1;
  std::shared_ptr<RecordedMotion> motion;
  try {
    motion = model.recorded_motion();
  } catch (const NotAnalytic&) {  // an effect, or T or V
  }
  if (motion) {
    recorded.motion = *motion;
    recorded.T = motion->returned[0];
    recorded.V = motion->returned[1];
    record_effects(recorded);
    return recorded;
  }
  record_energies(recorded, scene);
  if (!model.bare()) recorded.effects.push_back({.name = "an effect", .unreadable = "switches or is no formula", .force = {}, .J = {}, .drift = {}});
  return recorded;
}

// A quantity and its value at the start, if it has one.
struct ConservedValue {
  Conservation quantity;
  std::optional<double> at_start;
};

std::string json_of(const RunnableScene& scene, const std::vector<ConservedValue>& values) {
  Json json;
  json["scene"] = scene.name();
  json["conserved"] = Json::array();
  json["not_found"] = Json::array();
  for (const ConservedValue& v : values) {
    Json entry;
    entry["name"] = v.quantity.name;
    entry["at_start"] = nullptr;
    if (v.at_start) entry["at_start"] = *v.at_start;
    entry["reason"] = v.quantity.reason;
    json[v.quantity.found ? "conserved" : "not_found"].push_back(entry);
  }
  return json.dump(2);
}

}  // namespace

int conserved(const ConservedOptions& options) {
  const auto [scene, start, model, given] = chosen_scene(options);
  const RecordedScene recorded = recorded_scene(*scene, *model);
  std::vector<double> momenta;
  if (recorded.unreadable.empty()) {
    formula::Graph graph = recorded.motion.recording.graph;
    std::vector<double> at(recorded.variables, 0.0);
    for (Eigen::Index i = 0; i < start.q.size(); ++i) {
      at[static_cast<std::size_t>(i)] = start.q[i];
      at[static_cast<std::size_t>(start.q.size() + i)] = start.qdot[i];
    }
    at[static_cast<std::size_t>(2 * start.q.size())] = start.t;
    for (const int p : graph.gradient(recorded.T, recorded.motion.qdot)) momenta.push_back(qdot::detail::values_of_graph(graph, p, at).back().value);
  }
  const Energies energies = model->energies(start.t, model->packed(start));
  const ConservedQuantities all = qdot::detail::ConservedSearch(recorded).quantities();
  std::vector<ConservedValue> values;
  for (std::size_t i = 0; i < all.momenta.size(); ++i) values.push_back({all.momenta[i], i < momenta.size() ? std::optional(momenta[i]) : std::nullopt});
  for (const ConservedSum& sum : all.sums) {
    double value = 0.0;
    for (std::size_t i = 0; i < momenta.size(); ++i) value += sum.coefficients[static_cast<Eigen::Index>(i)] * momenta[i];
    values.push_back({{sum.name, true, sum.reason}, value});
  }
  values.push_back({all.jacobi, energies.jacobi});
  values.push_back({all.energy, energies.total()});
  if (options.json) {
    std::printf("%s\n", json_of(*scene, values).c_str());
    return 0;
  }
  std::printf("%s\n", scene->name().c_str());
  for (const ConservedValue& v : values)
    std::printf("  %-9s  %-9s  %-19s  %s\n", v.quantity.name.c_str(), v.quantity.found ? "conserved" : "not found",
                v.at_start ? report::exact_text(*v.at_start).c_str() : "", v.quantity.reason.c_str());
  return 0;
}

}  // namespace qdot::program
