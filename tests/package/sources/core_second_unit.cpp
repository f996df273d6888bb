// SPDX-License-Identifier: MIT
#ifdef EIGEN_WORLD_VERSION // core_in_one_unit.cpp
#define EIGEN_WAS_THERE
#endif
#include <qdot/fwd.hpp>

// As the header of a user says it, to files that read neither Eigen nor qdot.
double energy_in_second_unit();
double energy_at_end(const qdot::Trajectory<1>& motion, const qdot::Options& options);
void settle(qdot::AnySystem* system, qdot::Simulator* simulator, qdot::Outcome outcome);
#if defined(EIGEN_WORLD_VERSION) && !defined(EIGEN_WAS_THERE)
#error "qdot/fwd.hpp includes Eigen"
#endif

#include <qdot/integrate/simulator.hpp>
#include <qdot/qdot.hpp>

double energy_in_second_unit() {
  const auto free_point = qdot::mechanical_system<1>([](const auto& qdot) { return 0.5 * qdot[0] * qdot[0]; },
                                                     [](const auto& q) { return 0.5 * q[0] * q[0]; });
  const Eigen::Matrix<double, 1, 1> q(1.0), qdot(1.0);
  return qdot::energy(free_point, q, qdot);
}

double energy_at_end(const qdot::Trajectory<1>& motion, const qdot::Options& options) {
  const qdot::State<1> end = motion.back();
  return end.qdot[0] * end.qdot[0] + (options.rtol > 0 ? end.q[0] * end.q[0] : 0.0);
}
