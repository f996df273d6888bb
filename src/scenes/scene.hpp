#pragma once
// SPDX-License-Identifier: MIT
//
// What the catalogue says about a scene, beside its T and V.
//
// A scene is a struct as any user of the library writes it: parameters as members, T and V as member functions. Beside it
// stands one `Scene`, plain data: names, units, ranges, where it starts, and what to draw. The program, the examples, the
// tests and the benchmarks all take the scenes from here.

#include <functional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "qdot/ad/vector.hpp"
#include "qdot/mechanics/system.hpp"
#include "qdot/report/animation.hpp"

namespace qdot::scenes {

using report::Drawing;
using report::Point;

/// Which values of a parameter are physical.
enum class Range { any, positive, non_negative };

/// A parameter of a scene, by the name that the literature gives it.
template <class Energies>
struct Parameter {
  std::string name;
  std::variant<double Energies::*, int Energies::*> member;
  std::string unit;
  Range range = Range::any;
  std::string meaning;
};

/// A generalized coordinate; its velocity has the same unit per unit of time.
struct Coordinate {
  std::string name;
  std::string unit;
};

/// A scene of the catalogue. What depends on the parameters (a chain's length) is a function of them.
template <class Energies, int n>
struct Scene {
  static constexpr int dof_at_compile_time = n;

  std::string name;     // snake_case, as typed after `qdot run`
  std::string title;    // as a heading
  std::string summary;  // one or two sentences
  std::vector<Parameter<Energies>> parameters;
  std::function<std::vector<Coordinate>(const Energies&)> coordinates;
  std::function<State<n>(const Energies&)> start;
  double t_end = 10;
  std::string time_unit = "s";
  std::string energy_unit = "J";

  std::function<Drawing(const Energies&)> drawing;  // of the points that `positions` returns
  std::function<std::vector<Point>(const Energies&, const Vector<double, n>& q, double t)> positions;
};

/// An effect that a scene may be given at run time, `--with NAME[=VALUE]`, with one number that says how strong it is.
///
/// Every combination of a scene's optional effects is compiled, and a run takes the one that it asks for: what is off is not
/// in the code that runs.
template <class Energies, class Make>
struct OptionalEffect {
  std::string name;     // snake_case
  double value = 0;     // where --with gives none
  std::string unit;
  Range range = Range::any;
  std::string meaning;  // of the value
  Make make;            // (const Energies&, double value) → the effect
};

template <class Energies, class Make>
OptionalEffect<Energies, Make> optional_effect(std::string name, double value, std::string unit, Range range,
                                               std::string meaning, Make make) {
  return {std::move(name), value, std::move(unit), range, std::move(meaning), std::move(make)};
}

}  // namespace qdot::scenes
