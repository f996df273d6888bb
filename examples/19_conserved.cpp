// SPDX-License-Identifier: MIT
//
// What a motion keeps, and what that is good for. A spinning top loses two of its three coordinates, and a driven hoop keeps something
// that is not its energy. Symmetries that no coordinate shows are given to the library. Two systems are those of the program, in src/scenes.

#include <cmath>
#include <cstdio>

#include <qdot/analysis/conserved.hpp>
#include <qdot/analysis/hamiltonian.hpp>
#include <qdot/analysis/noether.hpp>
#include <qdot/analysis/routh.hpp>
#include <qdot/effects/dissipation.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulate.hpp>
#include <scenes/bead_on_hoop.hpp>
#include <scenes/heavy_top.hpp>

using namespace qdot;

void show(const char* title, const ConservedQuantities& all) {
  std::printf("%s\n", title);
  for (const auto& p : all.momenta) std::printf("  %-12s %-10s %s\n", p.name.c_str(), p.found ? "conserved" : "not found", p.reason.c_str());
  for (const auto& s : all.sums) std::printf("  %-12s %-10s %s\n", s.name.c_str(), "conserved", s.reason.c_str());
  for (const auto& e : {all.jacobi, all.energy}) std::printf("  %-12s %-10s %s\n", e.name.c_str(), e.found ? "conserved" : "not found", e.reason.c_str());
}

// Two particles in the plane that attract each other, and a third body that may stand at the origin.
struct Pair {
  double sun = 0.0;

  auto T(const auto& v) const { return 0.5 * (v[0] * v[0] + v[1] * v[1]) + 1.5 * (v[2] * v[2] + v[3] * v[3]); }
  auto V(const auto& q) const {
    using std::hypot;
    auto V = -1.0 / hypot(q[0] - q[2], q[1] - q[3]);
    if (sun != 0.0) V -= sun / hypot(q[0], q[1]);
    return V;
  }
};

int main() {
  const auto top = mechanical_system<3>(scenes::HeavyTop{}).with_names({"theta", "phi", "psi"});
  show("a heavy top", conserved_quantities(top));
  show("with friction at its tip", conserved_quantities(scene(top, viscous_damping(Eigen::Vector3d(0.0, 0.0, 0.01)))));
  show("a bead on a driven hoop", conserved_quantities(mechanical_system<1>(scenes::BeadOnHoop{}).with_names({"theta"})));

  const State<3> start{0.0, {0.6, 0.0, 0.0}, {0.0, 0.0, 8.0}};
  const auto reduced = routh_reduction<1, 2>(top, start);
  const Options tight{.rtol = 1e-12, .atol = 1e-12};
  const auto full = simulate(top, start, 5.0, Dop853{}, tight);
  const auto theta_alone = simulate(reduced.scene(), reduced.start, 5.0, Dop853{}, tight);
  std::printf("\nthe top as a motion of theta in V_eff, p_phi = %.6f, p_psi = %.6f\n", reduced.momenta[0], reduced.momenta[1]);
  for (const double t : {1.0, 3.0, 5.0}) {
    const State<3> x = full.trajectory.at(t), y = reduced.full_state(t, theta_alone.trajectory.y(t));
    std::printf("  t = %.0f   theta %.9f and %.9f   phi %.9f and %.9f\n", t, x.q[0], y.q[0], x.q[1], y.q[1]);
  }

  const auto shift = [](const auto& s, const auto& q) { return vector(q[0] + s, q[1], q[2] + s, q[3]); };
  const auto turn = [](const auto& s, const auto& q) {
    using std::cos, std::sin;
    return vector(q[0] * cos(s) - q[1] * sin(s), q[0] * sin(s) + q[1] * cos(s), q[2] * cos(s) - q[3] * sin(s), q[2] * sin(s) + q[3] * cos(s));
  };
  const auto boost = [](const auto& s, const auto& q, const auto& t) { return vector(q[0] + s * t, q[1], q[2] + s * t, q[3]); };
  const auto pair = mechanical_system<4>(Pair{}).with_names({"x1", "y1", "x2", "y2"});
  const State<4> now{2.0, {1.0, 0.0, -0.5, 0.2}, {0.0, 0.7, 0.3, -0.2}};
  std::printf("\n");
  show("two particles that attract each other", conserved_quantities(pair));
  std::printf("momentum %.3f, angular momentum %.3f, m x - p t %.3f\n", noether_integral(pair, shift)(now),
              noether_integral(pair, turn)(now), -noether_integral(pair, boost, [](const auto& q) { return q[0] + 3.0 * q[2]; })(now));
  try {
    noether_integral(mechanical_system<4>(Pair{.sun = 5.0}), shift);
  } catch (const InvalidValue& e) {
    std::printf("beside a sun: %s\n", e.what());
  }

  const Eigen::Vector3d q(0.6, 0.0, 0.0), p = conjugate_momenta(top, q, Eigen::Vector3d(0.2, 0.5, 8.0));
  const auto rates = phase_velocity(top, q, p);
  std::printf("\nH = %.6f   dq/dt = (%.3f, %.3f, %.3f)   dp/dt = (%.3f, %.3f, %.3f)\n", hamiltonian(top, q, p), rates.qdot[0], rates.qdot[1], rates.qdot[2],
              rates.pdot[0], rates.pdot[1], rates.pdot[2]);
  const auto p_theta = [](const auto&, const auto& momenta) { return momenta[0]; };
  std::printf("{p_theta, H} = %.3f\n", poisson_bracket(p_theta, hamiltonian_of(top), q, p));
}
