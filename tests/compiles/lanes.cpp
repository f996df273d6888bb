// SPDX-License-Identifier: MIT
//
// Equations in lanes, as g++ compiles them with -O3 for a processor without AVX: two lanes to a register. g++ 12 had an internal error here.
#include <qdot/ad/pack.hpp>
#include <qdot/mechanics/derive/lane_equations.hpp>

template class qdot::detail::LaneEquations<1, qdot::Pack<8, 2>>;
template class qdot::detail::LaneEquations<3, qdot::Pack<8, 2>>;
