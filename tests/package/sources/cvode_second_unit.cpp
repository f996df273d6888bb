// SPDX-License-Identifier: MIT
#include <qdot/integrate/cvode.hpp>
#include <qdot/integrate/simulate.hpp>
#include <qdot/qdot.hpp>

double position_after(double time) {
  const auto oscillator = qdot::mechanical_system<1>([](const auto& qdot) { return 0.5 * qdot[0] * qdot[0]; },
                                                     [](const auto& q) { return 0.5 * q[0] * q[0]; });
  qdot::State<1> start;
  start.q << 1.0;
  start.qdot << 0.0;
  const auto run = qdot::simulate(oscillator, start, time, qdot::CvodeAdams{}, {.rtol = 1e-10});
  return run.state().q[0];
}
