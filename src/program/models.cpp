// SPDX-License-Identifier: MIT
//
// The models of one to three coordinates, compiled once for all scenes (program/any_model.hpp).
#include "program/system_model.hpp"

namespace qdot::program {
template std::shared_ptr<const Model> model_of_energies<1, false>(ModelEnergies<1, false>, const qdot::detail::SystemParts&);
template std::shared_ptr<const Model> model_of_energies<1, true>(ModelEnergies<1, true>, const qdot::detail::SystemParts&);
template std::shared_ptr<const Model> model_of_energies<2, false>(ModelEnergies<2, false>, const qdot::detail::SystemParts&);
template std::shared_ptr<const Model> model_of_energies<2, true>(ModelEnergies<2, true>, const qdot::detail::SystemParts&);
template std::shared_ptr<const Model> model_of_energies<3, false>(ModelEnergies<3, false>, const qdot::detail::SystemParts&);
template std::shared_ptr<const Model> model_of_energies<3, true>(ModelEnergies<3, true>, const qdot::detail::SystemParts&);
}  // namespace qdot::program
