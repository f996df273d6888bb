#pragma once
// SPDX-License-Identifier: MIT
//
// What qdot_add_fmu was told, and what it asks for: all that its own small sources need to know.

#include <string>
#include <vector>

namespace qdot::fmi {

/// What qdot_add_fmu was told.
struct Choice {
  std::string identifier;         // of the model: the name of its files
  std::string version;            // of qdot
  std::vector<std::string> set;   // "l=2"
  std::vector<std::string> with;  // "damping" or "damping=0.2"
};

/// Written by qdot_add_fmu.
const Choice& choice();

/// The text of modelDescription.xml.
///
/// @throws InvalidValue  the choice does not fit the scene, or the scene contradicts itself
std::string model_description();

}  // namespace qdot::fmi
