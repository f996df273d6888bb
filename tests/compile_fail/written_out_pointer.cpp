// SPDX-License-Identifier: MIT
//
// A class to be written out whose parameter is elsewhere, where it may change: it would be read once only.
// message: qdot: written_out reads the parameters of T and V once
#include <qdot/mechanics/written_out.hpp>

namespace {
constexpr double stiff = 3.0;
struct Spring {
  const double* k = &stiff;
  constexpr auto T(const auto& qdot) const { return 0.5 * qdot[0] * qdot[0]; }
  constexpr auto V(const auto& q) const { return 0.5 * *k * q[0] * q[0]; }
};
}  // namespace

int main() { return qdot::written_out<1>(Spring{}).replays() ? 1 : 0; }
