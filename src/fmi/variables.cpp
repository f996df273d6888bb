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

// The list of variables as it is made, and the scene that it is made of.
class VariablesOfScene {
 public:
  // The list begins with time.
  explicit VariablesOfScene(RunnableScene& scene)
      : scene_(scene), model_(scene.model()), coordinates_(scene.coordinates()), own_(model_->own_states()), n_(model_->dof()) {
    const State<Dynamic> start = scene.start();
    y_ = model_->packed(start);
    list_.size = model_->size();
    list_.constrained = model_->is_constrained();
    list_.start_time = start.t;
    list_.end_time = scene.t_end();
    list_.name = scene.name();
    list_.title = scene.title();
    list_.summary = scene.summary();
    list_.time_unit = scene.time_unit();
    add({.role = Role::time, .name = "time", .unit = list_.time_unit, .description = "time", .start = start.t});
  }

  void add_parameters() {
    for (const program::ParameterInfo& p : scene_.parameters())
      add({.role = p.whole ? Role::count : Role::parameter,
           .name = p.name,
           .unit = p.unit,
           .description = p.meaning,
           .start = p.value,
           .range = p.range,
           .of = p.name});
  }

  void add_effects() {
    for (const program::EffectInfo& e : scene_.effects()) {
      const bool free = is_free_to_switch(scene_, e);
      if (!free && !e.on) continue;
      add({.role = Role::effect_value, .name = e.name, .unit = e.unit, .description = e.meaning, .start = e.value, .range = e.range, .of = e.name});
      if (free) add({.role = Role::effect_on, .name = e.name + ".on", .description = "whether there is " + e.name, .start = e.on ? 1.0 : 0.0, .of = e.name});
    }
  }

  void add_inputs() {
    for (std::size_t i = 0; i < own_.size(); ++i) {
      const Eigen::Index place = place_of_own(i);
      if (own_[i].kind == OwnState::input)
        list_.inputs.push_back(add({.role = Role::input, .name = own_[i].name, .description = "input", .start = y_[place], .place = place}));
    }
  }

  void add_states_and_rates() {
    const std::vector<Continuous> states = continuous_states();
    const std::vector<bool> follow = starts_that_follow(scene_, n_);
    for (const Continuous& x : states) {
      const bool moved = x.place < 2 * n_ && (list_.constrained || model_->guard_count() > 0 || follow[static_cast<std::size_t>(x.place)]);
      const std::string what = x.place < n_ ? "coordinate" : x.place < 2 * n_ ? "velocity" : "state of an effect";
      list_.states.push_back(
          add({.role = Role::state, .name = x.name, .unit = x.unit, .description = what, .start = y_[x.place], .place = x.place, .follows_others = moved}));
    }
    for (std::size_t i = 0; i < states.size(); ++i)
      list_.rates.push_back(add({.role = Role::rate,
                                 .name = "der(" + states[i].name + ")",
                                 .unit = states[i].rate_unit,
                                 .place = states[i].place,
                                 .state_reference = list_.states[i]}));
  }

  // With the guard that ends each.
  void add_phases() {
    Eigen::Index guard = 0;
    for (std::size_t i = 0; i < own_.size(); ++i) {
      if (own_[i].kind != OwnState::phase) continue;
      list_.guards.push_back(add({.role = Role::guard,
                                  .name = own_[i].name + ".guard",
                                  .description = "falls through zero where the phase of " + own_[i].name + " ends",
                                  .place = guard++}));
      add({.role = Role::phase,
           .name = own_[i].name + ".phase",
           .description = "a contact: 1 closed, 0 apart; friction: 0 sticks, 1 or -1 slides",
           .place = place_of_own(i)});
    }
  }

  void add_energies() {
    const std::string energy = scene_.energy_unit();
    add({.role = Role::kinetic_energy, .name = "kinetic_energy", .unit = energy, .description = "T"});
    add({.role = Role::potential_energy, .name = "potential_energy", .unit = energy, .description = "V"});
  }

  Variables list() && { return std::move(list_); }

 private:
  struct Continuous {
    std::string name, unit, rate_unit;
    Eigen::Index place;
  };

  // Coordinates, velocities and states of effects, in their order in y.
  std::vector<Continuous> continuous_states() const {
    const std::string& s = list_.time_unit;
    std::vector<Continuous> states;
    for (Eigen::Index i = 0; i < n_; ++i) {
      const scenes::Coordinate& c = coordinates_[static_cast<std::size_t>(i)];
      states.push_back({model_->component_name(i), c.unit, per_time(c.unit, s, 1), i});
    }
    for (Eigen::Index i = 0; i < n_; ++i) {
      const scenes::Coordinate& c = coordinates_[static_cast<std::size_t>(i)];
      states.push_back({model_->component_name(n_ + i), per_time(c.unit, s, 1), per_time(c.unit, s, 2), n_ + i});
    }
    for (std::size_t i = 0; i < own_.size(); ++i)
      if (own_[i].kind == OwnState::state) states.push_back({own_[i].name, "", "", place_of_own(i)});
    return states;
  }

  // Of a state of an effect, in y.
  Eigen::Index place_of_own(std::size_t i) const { return 2 * n_ + static_cast<Eigen::Index>(i); }

  // The reference of the new variable.
  std::size_t add(Variable v) { return list_.all.push_back(std::move(v)), list_.all.size() - 1; }

  RunnableScene& scene_;
  std::shared_ptr<const Model> model_;
  std::vector<scenes::Coordinate> coordinates_;
  std::vector<OwnState> own_;
  Eigen::Index n_;
  Eigen::VectorXd y_;  // at the start
  Variables list_;
};

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
  VariablesOfScene listed(*scene);
  listed.add_parameters();
  listed.add_effects();
  listed.add_inputs();
  listed.add_states_and_rates();
  listed.add_phases();
  listed.add_energies();
  Variables list = std::move(listed).list();
  require_different_names(list.all);
  return list;
}

}  // namespace qdot::fmi
