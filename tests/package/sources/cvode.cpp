// SPDX-License-Identifier: MIT
//
// A user of CVODE: a harmonic oscillator is back after its period.
#include <qdot/integrate/cvode.hpp>
#include <qdot/integrate/simulate.hpp>
#include <qdot/qdot.hpp>

#include <cmath>

double position_after(double time);

int main() {
  const double period = 2.0 * std::acos(-1.0);
  return std::abs(position_after(period) - 1.0) < 1e-6 ? 0 : 1;
}
