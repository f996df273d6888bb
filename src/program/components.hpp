#pragma once
// SPDX-License-Identifier: MIT
//
// The components of y = [q; q̇; z] as one names them: q0 … or the scene's own names, with their units.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "program/arguments.hpp"
#include "program/chosen_scene.hpp"
#include "qdot/report/number.hpp"

namespace qdot::program {

/// A component as lists show it: ten digits, and rounding about zero is zero.
inline std::string number_text(double x) { return report::rounded_text(std::abs(x) < 1e-12 ? 0.0 : x, 10); }

struct Components {
  std::vector<std::string> names, units;
  Eigen::Index dof = 0;

  explicit Components(const ChosenScene& chosen);

  /// The place of a coordinate or velocity in y.
  ///
  /// @throws UsageError  unless it is one of q and q̇
  Eigen::Index place(const char* argument, const std::string& name, const std::string& scene) const;

  /// Those of several, NAME,NAME,….
  std::vector<Eigen::Index> places(const char* argument, const std::string& text, const std::string& scene) const;

  /// "theta [rad]".
  std::string label(Eigen::Index i) const;
};

inline Components::Components(const ChosenScene& chosen) : dof(chosen.model->dof()) {
  for (const ComponentNames& entry : names_of_start(*chosen.scene)) {
    names.push_back(entry.name);
    units.push_back(entry.unit);
  }
  for (const OwnState& state : chosen.model->own_states()) {
    names.push_back(state.name);
    units.emplace_back();
  }
}

inline Eigen::Index Components::place(const char* argument, const std::string& name, const std::string& scene) const {
  std::vector<std::string> valid;
  for (Eigen::Index i = 0; i < 2 * dof; ++i) {
    const std::string plain = i < dof ? "q" + std::to_string(i) : "qdot" + std::to_string(i - dof);
    if (name == plain || name == names[static_cast<std::size_t>(i)]) return i;
    valid.push_back(names[static_cast<std::size_t>(i)]);
    if (plain != valid.back()) valid.push_back(plain);
  }
  throw unknown_name(argument, "a coordinate or velocity of " + scene, name, valid);
}

inline std::vector<Eigen::Index> Components::places(const char* argument, const std::string& text, const std::string& scene) const {
  std::vector<Eigen::Index> all;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    all.push_back(place(argument, text.substr(from, comma - from), scene));
    from = comma + 1;
  }
  return all;
}

inline std::string Components::label(Eigen::Index i) const {
  const auto k = static_cast<std::size_t>(i);
  return units[k].empty() ? names[k] : names[k] + " [" + units[k] + "]";
}

}  // namespace qdot::program
