#pragma once
// SPDX-License-Identifier: MIT
//
// What one says about a scene, beside its T and V.
//
// A scene is a struct as any user of the library writes it: parameters as members, T and V as member functions. Beside it
// stands one `Scene`, plain data: names, units, ranges, where it starts, and what to draw. All of it is optional:
//
//     Scene<Swing, 1>{}                                             coordinates q0, q1, …, from zero, at rest, plots only
//     Scene<Swing, 1>{.parameters = {{"l", &Swing::l}}, .start = {0.3}}
//
// What depends on the parameters (a chain's coordinates, where its pivot is drawn) is a function of them, in place of the value.
// The program's catalogue is written so, and so is a user's own file (own_scene.hpp); examples, tests and benchmarks take T, V
// and starts from here, too.

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <functional>
#include <initializer_list>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "qdot/ad/vector.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/system.hpp"
#include "qdot/report/animation.hpp"
#include "qdot/report/number.hpp"

namespace qdot::scenes {

using report::Drawing;
using report::Point;

/// Which values of a parameter are physical; none is infinite.
struct Range {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool without_least = false;

  static const Range any, positive, non_negative;

  /// Both ends included.
  static constexpr Range between(double least, double most) { return {least, most, false}; }

  bool holds(double value) const { return std::isfinite(value) && (without_least ? value > least : value >= least) && value <= most; }

  /// "positive", "zero or positive", "from 0 to 1"; "any" where all numbers will do.
  std::string text() const {
    const bool bounded = std::isfinite(most);
    if (!std::isfinite(least)) return bounded ? "at most " + report::exact_text(most) : "any";
    if (bounded) return "from " + report::exact_text(least) + " to " + report::exact_text(most);
    if (least == 0) return without_least ? "positive" : "zero or positive";
    return (without_least ? "more than " : "at least ") + report::exact_text(least);
  }
};

inline constexpr Range Range::any{};
inline constexpr Range Range::positive{0, std::numeric_limits<double>::infinity(), true};
inline constexpr Range Range::non_negative{0, std::numeric_limits<double>::infinity(), false};

/// A parameter of a scene, by the name that the literature gives it; its default is that of the member.
template <class Energies>
struct Parameter {
  std::string name;
  std::variant<double Energies::*, int Energies::*> member;
  std::string unit = "";
  Range range = Range::any;
  std::string meaning = "";
};

/// A generalized coordinate; its velocity has the same unit per unit of time.
struct Coordinate {
  std::string name;
  std::string unit = "";
};

/// A list of items, or a function of the parameters that returns it.
template <class Energies, class List, class Item>
class ByParameters {
 public:
  ByParameters() = default;
  ByParameters(std::initializer_list<Item> items) : ByParameters(List{std::vector<Item>(items)}) {}
  ByParameters(List list) : function_([list = std::move(list)](const Energies&) { return list; }) {}
  template <class F>
    requires std::is_invocable_r_v<List, const F&, const Energies&>
  ByParameters(F function) : function_(std::move(function)) {}

  explicit operator bool() const { return static_cast<bool>(function_); }
  List operator()(const Energies& energies) const { return function_(energies); }

 private:
  std::function<List(const Energies&)> function_;
};

/// Where a scene starts: {q…} at rest, {q…, q̇…}, a state, or a function of the parameters that returns one.
template <class Energies, int n>
class Start {
 public:
  Start() = default;
  Start(std::initializer_list<double> values)
    requires(n != Dynamic)
      : Start([values = std::vector<double>(values)](const Energies&) { return state_of(values); }) {}
  Start(State<n> state) : Start([state = std::move(state)](const Energies&) { return state; }) {}
  template <class F>
    requires std::is_invocable_r_v<State<n>, const F&, const Energies&>
  Start(F function) : function_(std::move(function)) {}

  explicit operator bool() const { return static_cast<bool>(function_); }

  /// @throws InvalidValue  a list of another length than n or 2n
  State<n> operator()(const Energies& energies) const { return function_(energies); }

 private:
  static State<n> state_of(const std::vector<double>& values) {
    constexpr auto count = static_cast<std::size_t>(n);
    if (values.size() != count && values.size() != 2 * count)
      throw InvalidValue("start must have one number for each coordinate, or those and one for each velocity, " + std::to_string(n) + " or " +
                         std::to_string(2 * n) + " of them, but has " + std::to_string(values.size()));
    State<n> state{0.0, Vector<double, n>::Zero(), Vector<double, n>::Zero()};
    for (std::size_t i = 0; i < values.size(); ++i)
      (i < count ? state.q : state.qdot)[static_cast<Eigen::Index>(i % count)] = values[i];
    return state;
  }

  std::function<State<n>(const Energies&)> function_;
};

/// The points that a drawing hangs on: a function of (parameters, q) or (parameters, q, t).
template <class Energies, int n>
class Positions {
  using Q = Vector<double, n>;

 public:
  Positions() = default;
  template <class F>
    requires std::is_invocable_r_v<std::vector<Point>, const F&, const Energies&, const Q&, double>
  Positions(F function) : function_(std::move(function)) {}
  template <class F>
    requires std::is_invocable_r_v<std::vector<Point>, const F&, const Energies&, const Q&>
  Positions(F function) : function_([function = std::move(function)](const Energies& e, const Q& q, double) { return std::invoke(function, e, q); }) {}

  explicit operator bool() const { return static_cast<bool>(function_); }
  std::vector<Point> operator()(const Energies& energies, const Q& q, double t) const { return function_(energies, q, t); }

 private:
  std::function<std::vector<Point>(const Energies&, const Q&, double)> function_;
};

/// What one says about a scene.
template <class Energies, int n>
struct Scene {
  static constexpr int dof_at_compile_time = n;

  std::string name = "";     // snake_case, as typed after `qdot run`; of a scene in a file, the file's where it has none
  std::string title = "";    // as a heading; the name where there is none
  std::string summary = "";  // one or two sentences
  std::vector<Parameter<Energies>> parameters = {};
  ByParameters<Energies, std::vector<Coordinate>, Coordinate> coordinates = {};  // q0, q1, … where none are named; run-time n needs them
  Start<Energies, n> start = {};                                                 // zero, and at rest, where there is none
  double t_end = 10;
  std::string time_unit = "s";
  std::string energy_unit = "J";

  ByParameters<Energies, Drawing, report::Shape> drawing = {};  // of what `positions` returns; a line through it and a disk at its end where there is none
  Positions<Energies, n> positions = {};                        // no animation without them
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

/// An effect of which no more is said than its name and how strong it is.
template <class Energies, class Make>
OptionalEffect<Energies, Make> optional_effect(std::string name, double value, Make make) {
  return {std::move(name), value, "", Range::any, "", std::move(make)};
}

}  // namespace qdot::scenes
