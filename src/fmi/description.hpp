#pragma once
// SPDX-License-Identifier: MIT
//
// modelDescription.xml: the variables of a scene, and what the library can do, in the form of FMI 3.0.
//
// The token at its head is a number for all of the rest. The importer gives it back when it instantiates, so a library beside the description of another
// one is noticed.

#include <string>

#include "fmi/variables.hpp"

namespace qdot::fmi {

struct Description {
  std::string token;
  std::string xml;
};

Description description_of(const Choice& choice, const Variables& variables);

}  // namespace qdot::fmi
