#pragma once
// SPDX-License-Identifier: MIT
//
// One number that a scene is made of, and models for values of it.
//
// It is a parameter, or the value of an effect that is on. The start stays what it is.

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "program/arguments.hpp"
#include "program/chosen_scene.hpp"

namespace qdot::program {

/// NAME=FROM:TO; FROM may be left out for what it is.
struct Along {
  std::string name;
  std::optional<double> from;
  double to = 0.0;
};

/// @throws UsageError  unless it has this form
inline Along along(const std::string& argument, const std::string& text) {
  const std::size_t equals = text.find('='), colon = text.find(':', equals == std::string::npos ? 0 : equals);
  if (equals == std::string::npos || equals == 0 || colon == std::string::npos)
    throw UsageError(argument + ": must have the form NAME=FROM:TO, or NAME=:TO from what it is, given \"" + text + "\"");
  Along range{text.substr(0, equals), {}, 0.0};
  const std::string from = text.substr(equals + 1, colon - equals - 1), where = argument + " " + range.name;
  if (!from.empty()) range.from = finite_number(where, from);
  range.to = finite_number(where, text.substr(colon + 1));
  if (range.from == range.to) throw UsageError(where + ": must go to another value than it begins with, given " + text.substr(equals + 1));
  return range;
}

/// The models of a scene for values of one of its parameters or effects.
class ModelsAlong {
 public:
  /// @throws UsageError  there is no such number in the scene, or it is a count
  ModelsAlong(const std::string& argument, const std::string& name, const ChosenScene& chosen);

  const std::string& name() const { return name_; }
  const std::string& unit() const { return unit_; }
  std::string label() const { return unit_.empty() ? name_ : name_ + " [" + unit_ + "]"; }
  double value() const { return value_; }  // that the scene was given

  /// @throws Error  when the scene takes no such value
  std::shared_ptr<const Model> operator()(double value) const;

  /// The start with this value: that of a scene may go with its parameters, but where --set has given it.
  State<Dynamic> start(double value) const;

 private:
  void set(double value) const;
  struct Restored {
    const ModelsAlong& models;
    ~Restored() { models.set(models.value_); }
  };

  RunnableScene* scene_;
  std::vector<InitialValue> given_;
  std::string name_, unit_;
  double value_ = 0.0;
  bool is_effect_ = false;
};

inline ModelsAlong::ModelsAlong(const std::string& argument, const std::string& name, const ChosenScene& chosen) 
    : scene_(chosen.scene.get()), given_(chosen.initial_values), name_(name) {
  std::vector<std::string> valid;
  for (const ParameterInfo& p : scene_->parameters()) {
    if (p.name == name && p.whole) throw UsageError(argument + ": must be followed in a number that varies continuously, but " + name + " is a count");
    if (p.name == name) value_ = p.value, unit_ = p.unit;
    if (!p.whole) valid.push_back(p.name);
  }
  for (const EffectInfo& e : scene_->effects()) {
    if (e.name == name && !e.on)
      throw UsageError(argument + ": must be a parameter, or an effect that is on, but " + name + " is off; switch it on by --with " +
                       name);
    if (e.name == name) value_ = e.value, unit_ = e.unit, is_effect_ = true;
    if (e.on) valid.push_back(e.name);
  }
  for (const std::string& each : valid)
    if (each == name) return;
  throw unknown_name(argument, "a parameter of " + scene_->name() + " or an effect that is on", name, valid);
}

inline std::shared_ptr<const Model> ModelsAlong::operator()(double value) const {
  set(value);
  const Restored afterwards{*this};
  return scene_->model();
}

inline State<Dynamic> ModelsAlong::start(double value) const {
  set(value);
  const Restored afterwards{*this};
  return start_with(*scene_, given_);
}

inline void ModelsAlong::set(double value) const {
  if (is_effect_) scene_->set_effect(name_, true, value);
  else scene_->set_parameter(name_, value);
}

}  // namespace qdot::program
