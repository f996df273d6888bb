// SPDX-License-Identifier: MIT
//
// The models of most scenes, compiled once for all (program/any_model.hpp): of one to three coordinates, and of one with T or V of the time.
#include "program/system_model.hpp"

namespace qdot::program {
template std::shared_ptr<const Model> model_of_energies<1, false>(ModelEnergies<1, false>, const qdot::detail::SystemParts&);
template std::shared_ptr<const Model> model_of_energies<1, true>(ModelEnergies<1, true>, const qdot::detail::SystemParts&);
template std::shared_ptr<const Model> model_of_energies<2, false>(ModelEnergies<2, false>, const qdot::detail::SystemParts&);
template std::shared_ptr<const Model> model_of_energies<3, false>(ModelEnergies<3, false>, const qdot::detail::SystemParts&);
}  // namespace qdot::program
