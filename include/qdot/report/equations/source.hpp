#pragma once
// SPDX-License-Identifier: MIT
//
// T and V as something that can be recorded, whatever functors are behind them.
//
// Formulas in letters need T and V to be run again with other values of the parameters (report/equations/parameter_letters.hpp). A source is a function that
// does that, with the names. It is all of equations that depends on the user's types.

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/ad/formula/recording.hpp"
#include "qdot/ad/vector.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot::report {

/// What functors return, recorded once. Variables are q, q̇ and t.
struct RecordedFormulas {
  formula::Recording recording = {};
  std::vector<int> outputs = {};
};

/// Records them with these values of the parameters.
using RecordFormulas = std::function<RecordedFormulas(const std::vector<double>& parameters)>;

/// A parameter by the name that it has in formulas.
template <class Energies>
struct NamedParameter {
  std::string name;
  double Energies::*member;
};

/// What equations are derived from, whatever T and V are behind it.
struct EquationSource {
  std::vector<std::string> coordinates = {};
  std::vector<std::string> parameters = {};
  std::vector<double> values = {};
  RecordFormulas record = {};  // T, V, and rows of constraints
};

namespace detail {

// A recording whose variables are q, q̇ and t, of what `run` returns.
template <int n, class Run>
RecordedFormulas recorded(Eigen::Index dof, const Run& run) {
  RecordedFormulas f;
  const auto variables = [&](Eigen::Index first) {
    Vector<formula::Recorded, n> x(dof);
    for (Eigen::Index i = 0; i < dof; ++i) x[i] = formula::Recorded(f.recording, f.recording.graph.variable(static_cast<int>(first + i)));
    return x;
  };
  const Vector<formula::Recorded, n> q = variables(0), v = variables(dof);
  const formula::Recorded t(f.recording, f.recording.graph.variable(static_cast<int>(2 * dof)));
  const auto add = [&](const formula::Recorded& x) { f.outputs.push_back(x.node_in(f.recording)); };
  run(q, v, t, add);
  return f;
}

struct NoRows {
  template <class E, class Q, class S, class Add>
  void operator()(const E&, const Q&, const Q&, const S&, const Add&) const {}
};

}  // namespace detail

/// T and V of these energies, which are recorded with other values of the named members.
///
/// @param rows  rows(energies, q, q̇, t, add) adds what constraints demand to be zero
template <int n, class E, class Rows = detail::NoRows>
EquationSource equation_source(const E& energies, std::vector<std::string> coordinates, const std::vector<NamedParameter<E>>& parameters,
                               const Rows& rows = {}) {
  EquationSource s{.coordinates = std::move(coordinates)};
  std::vector<double E::*> members;
  for (const NamedParameter<E>& p : parameters) {
    s.parameters.push_back(p.name);
    s.values.push_back(energies.*p.member);
    members.push_back(p.member);
  }
  s.record = [energies, members, rows, dof = static_cast<Eigen::Index>(s.coordinates.size())](const std::vector<double>& values) {
    E changed(energies);
    for (std::size_t j = 0; j < members.size(); ++j) changed.*members[j] = values[j];
    return detail::recorded<n>(dof, [&](const auto& q, const auto& v, const auto& t, const auto& add) {
      add(qdot::detail::kinetic<n>(changed, q, v, t));
      add(qdot::detail::potential<n>(changed, q, t));
      rows(changed, q, v, t, add);
    });
  };
  return s;
}

namespace detail {

// What a user wrote, whatever evaluates it.
template <class E>
const auto& written_energies(const E& e) {
  if constexpr (requires { e.energies(); }) {
    return e.energies();
  } else {
    return e;
  }
}
template <class E>
using WrittenEnergies = std::decay_t<decltype(written_energies(std::declval<const E&>()))>;

}  // namespace detail

/// T and V of a system, and its names.
template <class E, int n, Inertia inertia>
EquationSource equation_source(const System<E, n, inertia>& system, const std::vector<NamedParameter<detail::WrittenEnergies<E>>>& parameters = {}) {
  std::vector<std::string> names;
  for (Eigen::Index i = 0; i < system.dof(); ++i) names.push_back(system.coordinate_name(i));
  return equation_source<n>(detail::written_energies(system.energies()), std::move(names), parameters);
}

}  // namespace qdot::report
