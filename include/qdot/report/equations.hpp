#pragma once
// SPDX-License-Identifier: MIT
//
// The equations of a system, to be read.
//
//     struct Pendulum { double m = 1, l = 1, g = 9.81;  auto T(…) …  auto V(…) … };
//     const auto e = qdot::equations(system, {{"m", &Pendulum::m}, {"l", &Pendulum::l}, {"g", &Pendulum::g}});
//     e.text(qdot::report::PlainNotation{})
//
// gives the Lagrangian, the momenta, the mass matrix, Lagrange's equations M q̈ = r and, where it has a closed form, q̈. Names are those of the system's
// coordinates (System::with_names) and of the parameters; a parameter that is not named appears as its number. The functors are run once for each set of
// values that report/equations/parameter_letters.hpp asks for, and must be one formula. A T that branches on the state has no equations to be printed.

#include <cstddef>
#include <string>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/mechanics/system.hpp"
#include "qdot/report/equations/derivation.hpp"
#include "qdot/report/equations/expression.hpp"
#include "qdot/report/equations/parameter_letters.hpp"
#include "qdot/report/equations/source.hpp"

namespace qdot {

namespace report {

/// Equations under a heading.
struct EquationSection {
  std::string heading;              ///< "Momenta", …
  std::vector<Equation> equations;  ///< one under the other
};

/// The equations of a system as formulas; text of them by report/equation_text.hpp.
struct Equations : EquationsOfMotion {
  std::vector<std::string> coordinates = {};  ///< their letters

  /// All of it in the order of theory.
  std::vector<EquationSection> sections() const {
    std::vector<EquationSection> all{{"Lagrangian", {{symbol_expression("L"), L}}}, {"Momenta", {}}, {"Mass matrix", {}}, {"Equations of motion", rows}};
    for (std::size_t i = 0; i < p.size(); ++i) {
      Expression name = symbol_expression("p");
      name.parts = {symbol_expression(coordinates[i])};
      all[1].equations.push_back({name, p[i]});
      for (std::size_t j = 0; j <= i; ++j)
        if (!(M[i][j].is_number() && M[i][j].number == 0.0))
          all[2].equations.push_back(
              {symbol_expression("M_" + std::to_string(j + 1) + (p.size() > 9 ? "," : "") + std::to_string(i + 1)), M[i][j]});
    }
    if (!constraints.empty()) all.push_back({"Constraints", constraints});
    if (!qddot.empty()) all.push_back({"Accelerations", qddot});
    return all;
  }
};

/// Beyond this formulas are too long to read, and none are made.
inline constexpr std::size_t most_coordinates_to_read = 16;

namespace detail {

inline void require_readable(const EquationSource& source) {
  if (source.coordinates.size() > most_coordinates_to_read)
    qdot::detail::throw_invalid_value({"equations to be read must have at most ", static_cast<long>(most_coordinates_to_read), " coordinates, but there are ",
                                       static_cast<long>(source.coordinates.size()), "; take a smaller system of the same kind"});
}

}  // namespace detail

/// T = … and V = … as formulas, for a fraction of the cost of all equations.
///
/// @throws NotOneFormula, NotAnalytic, InvalidValue
inline std::vector<Equation> energies_of(const EquationSource& source) {
  detail::require_readable(source);
  const detail::ParameterLetters letters(source.record, source.values);
  return detail::EquationDerivation(letters, source.coordinates, source.parameters).energies();
}

/// @throws NotOneFormula, NotAnalytic, InvalidValue
inline Equations equations_of(const EquationSource& source) {
  detail::require_readable(source);
  const detail::ParameterLetters letters(source.record, source.values);
  Equations e;
  static_cast<EquationsOfMotion&>(e) = detail::EquationDerivation(letters, source.coordinates, source.parameters).equations();
  e.coordinates = source.coordinates;
  return e;
}

}  // namespace report

/// L, p, M, r and q̈ of a system as formulas in the names of its coordinates and parameters.
///
/// Parameters that are not named appear as their numbers. At most 16 coordinates.
///
/// @param parameters  members of the class of T and V: {{"m", &Pendulum::m}, …}
/// @throws NotOneFormula  when values of parameters decide which operations T and V consist of
/// @throws NotAnalytic    when T or V compares values of the state, or has a kink
template <class E, int n, Inertia inertia>
report::Equations equations(const System<E, n, inertia>& system,
                            const std::vector<report::NamedParameter<report::detail::WrittenEnergies<E>>>& parameters = {}) {
  return report::equations_of(report::equation_source(system, parameters));
}

}  // namespace qdot
