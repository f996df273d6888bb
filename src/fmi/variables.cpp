// SPDX-License-Identifier: MIT
#include "fmi/variables.hpp"

#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <utility>

#include "qdot/error.hpp"

std::unique_ptr<qdot::program::RunnableScene> qdot_scene();  // the user's

namespace qdot::fmi {

namespace {

using program::Model;
using program::OwnState;
using program::RunnableScene;

struct Assignment {
  std::string name;
  std::optional<double> value;
};

Assignment assignment(const std::string& word, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) return {text, std::nullopt};
  const std::string number = text.substr(equals + 1);
  char* end = nullptr;
  const double value = std::strtod(number.c_str(), &end);
  if (number.empty() || *end != '\0' || !std::isfinite(value)) throw InvalidValue(word + " must be NAME=NUMBER, given " + text);
  return {text.substr(0, equals), value};
}

// What an importer cannot be left to change: the form of y, and what stands around it.
std::string form_of(const Model& model) {
  std::string form =
      std::to_string(model.dof()) + " " + std::to_string(model.size()) + " " + std::to_string(model.guard_count()) + (model.is_constrained() ? " c" : "");
  for (const OwnState& z : model.own_states()) form += " " + std::to_string(static_cast<int>(z.kind)) + z.name;
  return form;
}

std::string form_of(const RunnableScene& scene) { return form_of(*scene.model()); }

// Whether an effect can be switched without a change of the form.
bool is_free_to_switch(RunnableScene& scene, const program::EffectInfo& effect) {
  bool same = false;
  try {
    const std::string before = form_of(scene);
    scene.set_effect(effect.name, !effect.on, std::nullopt);
    same = form_of(scene) == before;
  } catch (const Error&) {  // what cannot be switched is not offered
  }
  scene.set_effect(effect.name, effect.on, std::nullopt);
  return same;
}

// Which coordinates and velocities start elsewhere when a parameter is another.
std::vector<bool> starts_that_follow(RunnableScene& scene, Eigen::Index dof) {
  std::vector<bool> follow(static_cast<std::size_t>(2 * dof), false);
  const State<Dynamic> before = scene.start();
  for (const program::ParameterInfo& p : scene.parameters()) {
    if (p.whole) continue;
    for (const double other : {1.01 * p.value + 0.01, 0.99 * p.value - 0.01}) {
      if (!p.range.holds(other)) continue;
      try {
        scene.set_parameter(p.name, other);
        const State<Dynamic> after = scene.start();
        for (Eigen::Index i = 0; i < dof; ++i) {
          if (after.q[i] != before.q[i]) follow[static_cast<std::size_t>(i)] = true;
          if (after.qdot[i] != before.qdot[i]) follow[static_cast<std::size_t>(dof + i)] = true;
        }
      } catch (const Error&) {  // not every value has a start
      }
      scene.set_parameter(p.name, p.value);
      break;
    }
  }
  return follow;
}

std::string per_time(const std::string& unit, const std::string& time, int power) {
  if (unit.empty()) return {};
  return unit + "/" + time + (power == 1 ? "" : "^" + std::to_string(power));
}

void require_different_names(const std::vector<Variable>& all) {
  std::map<std::string, int> seen;
  for (const Variable& v : all) {
    if (v.name.empty() || v.name.find_first_of("\r\n\t") != std::string::npos)
      throw InvalidValue("a variable of an FMU must have a name of one line, but one is called '" + v.name + "'; rename it in the scene");
    if (seen[v.name]++ > 0)
      throw InvalidValue("the variables of an FMU must have names of their own, but two are called '" + v.name + "'; rename one of them in the scene");
  }
}

}  // namespace

std::unique_ptr<RunnableScene> chosen_scene(const Choice& choice) {
  std::unique_ptr<RunnableScene> scene = qdot_scene();
  if (!scene) throw InvalidValue("qdot_scene() must return a scene, but returns none");
  if (scene->name().empty()) scene->set_name(choice.identifier);
  for (const std::string& text : choice.set) {
    const Assignment set = assignment("SET", text);
    if (!set.value) throw InvalidValue("SET must be NAME=NUMBER, given " + text);
    scene->set_parameter(set.name, *set.value);
  }
  for (const std::string& text : choice.with) {
    const Assignment with = assignment("WITH", text);
    scene->set_effect(with.name, true, with.value);
  }
  return scene;
}

Variables variables_of(const Choice& choice) {
  const std::unique_ptr<RunnableScene> scene = chosen_scene(choice);
  const std::shared_ptr<const Model> model = scene->model();
  const auto coordinates = scene->coordinates();
  const State<Dynamic> start = scene->start();
  const Eigen::VectorXd y = model->packed(start);
  const Eigen::Index n = model->dof();

  Variables list;
  list.size = model->size();
  list.constrained = model->is_constrained();
  list.start_time = start.t;
  list.end_time = scene->t_end();
  list.name = scene->name();
  list.title = scene->title();
  list.summary = scene->summary();
  list.time_unit = scene->time_unit();
  const std::string& s = list.time_unit;
  const auto add = [&](Variable v) { return list.all.push_back(std::move(v)), list.all.size() - 1; };

  add({.role = Role::time, .name = "time", .unit = s, .description = "time", .start = start.t});
  for (const program::ParameterInfo& p : scene->parameters())
    add({.role = p.whole ? Role::count : Role::parameter,
         .name = p.name,
         .unit = p.unit,
         .description = p.meaning,
         .start = p.value,
         .range = p.range,
         .of = p.name});
  for (const program::EffectInfo& e : scene->effects()) {
    const bool free = is_free_to_switch(*scene, e);
    if (!free && !e.on) continue;
    add({.role = Role::effect_value, .name = e.name, .unit = e.unit, .description = e.meaning, .start = e.value, .range = e.range, .of = e.name});
    if (free) add({.role = Role::effect_on, .name = e.name + ".on", .description = "whether there is " + e.name, .start = e.on ? 1.0 : 0.0, .of = e.name});
  }

  const std::vector<OwnState> own = model->own_states();
  for (std::size_t i = 0; i < own.size(); ++i) {
    const Eigen::Index place = 2 * n + static_cast<Eigen::Index>(i);
    if (own[i].kind == OwnState::input)
      list.inputs.push_back(add({.role = Role::input, .name = own[i].name, .description = "input", .start = y[place], .place = place}));
  }

  struct Continuous {
    std::string name, unit, rate_unit;
    Eigen::Index place;
  };
  std::vector<Continuous> states;
  for (Eigen::Index i = 0; i < n; ++i) {
    const scenes::Coordinate& c = coordinates[static_cast<std::size_t>(i)];
    states.push_back({model->component_name(i), c.unit, per_time(c.unit, s, 1), i});
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const scenes::Coordinate& c = coordinates[static_cast<std::size_t>(i)];
    states.push_back({model->component_name(n + i), per_time(c.unit, s, 1), per_time(c.unit, s, 2), n + i});
  }
  for (std::size_t i = 0; i < own.size(); ++i)
    if (own[i].kind == OwnState::state) states.push_back({own[i].name, "", "", 2 * n + static_cast<Eigen::Index>(i)});
  const std::vector<bool> follow = starts_that_follow(*scene, n);
  for (const Continuous& x : states) {
    const bool moved = x.place < 2 * n && (list.constrained || model->guard_count() > 0 || follow[static_cast<std::size_t>(x.place)]);
    const std::string what = x.place < n ? "coordinate" : x.place < 2 * n ? "velocity" : "state of an effect";
    list.states.push_back(
        add({.role = Role::state, .name = x.name, .unit = x.unit, .description = what, .start = y[x.place], .place = x.place, .follows_others = moved}));
  }
  for (std::size_t i = 0; i < states.size(); ++i)
    list.rates.push_back(add({.role = Role::rate,
                              .name = "der(" + states[i].name + ")",
                              .unit = states[i].rate_unit,
                              .place = states[i].place,
                              .state_reference = list.states[i]}));

  Eigen::Index guard = 0;
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (own[i].kind != OwnState::phase) continue;
    const Eigen::Index place = 2 * n + static_cast<Eigen::Index>(i);
    list.guards.push_back(add({.role = Role::guard,
                               .name = own[i].name + ".guard",
                               .description = "falls through zero where the phase of " + own[i].name + " ends",
                               .place = guard++}));
    add({.role = Role::phase,
         .name = own[i].name + ".phase",
         .description = "a contact: 1 closed, 0 apart; friction: 0 sticks, 1 or -1 slides",
         .place = place});
  }
  const std::string energy = scene->energy_unit();
  add({.role = Role::kinetic_energy, .name = "kinetic_energy", .unit = energy, .description = "T"});
  add({.role = Role::potential_energy, .name = "potential_energy", .unit = energy, .description = "V"});
  require_different_names(list.all);
  return list;
}

}  // namespace qdot::fmi
