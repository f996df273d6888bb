#pragma once
// SPDX-License-Identifier: MIT
//
// q̈ by the equations that the compiler has derived, beside q̈ by nested duals, without and with applied forces, and beside q̈ by hand.

#include <algorithm>
#include <cmath>
#include <random>

#include "bench/chain_energies.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/written_out.hpp"
#include "systems/chain_by_loops.hpp"
#include "systems/solution_by_pivots.hpp"

namespace qdot {

/// What difference_of_ways() gives where the derived equations were not used: they don't exist, or have handed the state on.
inline constexpr double not_derived = 1e9;

/// The worst relative difference at random states with entries of q from `low` to `high`; under applied forces too where asked for.
template <int n, bool under_forces = false, class E>
double difference_of_ways(const E& energies, double low, double high, int samples = 20) {
  const auto system = mechanical_system<n>(written_out<n>(energies));
  using Written = std::decay_t<decltype(system.energies())>;
  if constexpr (!Written::ClosedForm::exists) {
    return not_derived;
  } else {
    std::mt19937 random(29);
    std::uniform_real_distribution<double> position(low, high), other(-2.0, 2.0);
    double worst = 0.0;
    for (int sample = 0; sample < samples; ++sample) {
      Vector<double, n> q, v, Q, a, b;
      for (int i = 0; i < n; ++i) {
        q[i] = position(random);
        v[i] = other(random);
        Q[i] = other(random);
      }
      const double t = other(random);
      if (!detail::closed_form_acceleration<n>(system.energies(), q.data(), v.data(), t, a.data())) return not_derived;
      const Vector<double, n> general = detail::general_acceleration(system, q, v, t);
      worst = std::max(worst, (a - general).norm() / general.norm());
      if constexpr (under_forces) {
        const auto forces = [&Q](const double*, const double*, double* applied) { std::copy_n(Q.data(), n, applied); };
        if (!detail::closed_form_acceleration<n>(system.energies(), q.data(), v.data(), t, b.data(), forces)) return not_derived;
        const Matrix<double, n> M = detail::kinetic_hessian<n>(system.energies(), q, v, t);
        const Vector<double, n> under_force = general + solution_by_pivots(M, Q);
        worst = std::max(worst, (b - under_force).norm() / under_force.norm());
      }
    }
    return worst;
  }
}

/// The relative difference of a chain's derived q̈ from the one derived by hand.
template <int n>
double difference_from_hand() {
  const auto written = written_out<n>(bench::LoopedChain{});
  Eigen::VectorXd q(n), v(n), b(n);
  for (int i = 0; i < n; ++i) {
    q[i] = std::sin(3.0 * i + 1.0);
    v[i] = std::cos(5.0 * i);
  }
  const Eigen::VectorXd a = chain_by_loops(q, v);
  if (!detail::closed_form_acceleration<n>(written, q.data(), v.data(), 0.0, b.data())) return not_derived;
  return (a - b).norm() / a.norm();
}

/// A top whose tip is held, in Euler's angles: its spin is eliminated by formula.
struct HeavyTop {
  double A = 1.3, C = 0.7, mgl = 1.9;
  constexpr auto T(const auto& q, const auto& v) const {
    using std::cos, std::sin;
    const auto across = v[1] * sin(q[0]), along = v[1] * cos(q[0]) + v[2];
    return 0.5 * A * (v[0] * v[0] + across * across) + 0.5 * C * along * along;
  }
  constexpr auto V(const auto& q) const {
    using std::cos;
    return mgl * cos(q[0]);
  }
};

}  // namespace qdot
