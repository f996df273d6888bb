// SPDX-License-Identifier: MIT
//
// Energies to be written out of more coordinates than equations are derived for.
// message: qdot: written_out is for up to 32 coordinates
#include <qdot/mechanics/written_out.hpp>

int main() { return qdot::written_out<33>([](const auto& qdot) { return qdot.squaredNorm(); }).replays() ? 1 : 0; }
