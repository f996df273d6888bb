#pragma once
// SPDX-License-Identifier: MIT
//
// What pencil and paper say about a system: M and rhs in M q̈ = rhs, and the parts of T that are not quadratic in q̇,
//
//     T = ½ q̇ᵀM q̇ + a·q̇ + T₀ .
//
// `LawSystem` is one system as the laws see it: the library's answers on one side, these on the other, both as functions
// of (q, q̇, t) without templates, so that every system is instantiated once for all laws.

#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "qdot/ad/derivatives.hpp"
#include "qdot/mechanics/energy.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot::systems {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct HandDerived {
  std::function<MatrixXd(const VectorXd& q)> M;
  std::function<VectorXd(const VectorXd& q, const VectorXd& v, double t)> rhs;
  std::function<VectorXd(const VectorXd& q, double t)> a = nullptr;   // zero when absent
  std::function<double(const VectorXd& q, double t)> T0 = nullptr;    // zero when absent
  std::vector<double> lowest = {}, highest = {};                      // where states are drawn; [−2, 2] when absent
};

struct LawSystem {
  std::string name;
  Eigen::Index n;
  bool autonomous;
  HandDerived hand;

  std::function<MatrixXd(const VectorXd&, const VectorXd&, double)> M;
  std::function<VectorXd(const VectorXd&, const VectorXd&, double)> rhs, acceleration, momenta;
  std::function<double(const VectorXd&, const VectorXd&, double)> T, V, energy, jacobi_energy;
  std::function<double(const VectorXd&, const VectorXd&, double)> energy_balance;  // dh/dt + ∂L/∂t along the motion
  std::function<void(double, const VectorXd&, MatrixXd&)> jacobian;

  VectorXd hand_a(const VectorXd& q, double t) const { return hand.a ? hand.a(q, t) : VectorXd::Zero(n); }
  double hand_T0(const VectorXd& q, double t) const { return hand.T0 ? hand.T0(q, t) : 0.0; }

  State<Dynamic> random_state(std::mt19937& random) const {
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    State<Dynamic> state{10.0 * unit(random), VectorXd(n), VectorXd(n)};
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double low = hand.lowest.empty() ? -2.0 : hand.lowest[k], high = hand.highest.empty() ? 2.0 : hand.highest[k];
      state.q[i] = low + (high - low) * unit(random);
      state.qdot[i] = -2.0 + 4.0 * unit(random);
    }
    return state;
  }
};

template <class E, int n, Inertia I>
LawSystem law_system(std::string name, const System<E, n, I>& system, HandDerived hand) {
  using Fixed = Vector<double, n>;
  LawSystem law{std::move(name), system.dof(), System<E, n, I>::autonomous, std::move(hand), {}, {}, {}, {}, {}, {}, {}, {}, {}, {}};
  law.M = [system](const VectorXd& q, const VectorXd& v, double t) -> MatrixXd { return mass_matrix(system, Fixed(q), Fixed(v), t); };
  law.rhs = [system](const VectorXd& q, const VectorXd& v, double t) -> VectorXd { return qdot::rhs(system, Fixed(q), Fixed(v), t); };
  law.acceleration = [system](const VectorXd& q, const VectorXd& v, double t) -> VectorXd {
    return qdot::acceleration(system, Fixed(q), Fixed(v), t);
  };
  law.momenta = [system](const VectorXd& q, const VectorXd& v, double t) -> VectorXd {
    return conjugate_momenta(system, Fixed(q), Fixed(v), t);
  };
  law.T = [system](const VectorXd& q, const VectorXd& v, double t) { return kinetic_energy(system, Fixed(q), Fixed(v), t); };
  law.V = [system](const VectorXd& q, const VectorXd&, double t) { return potential_energy(system, Fixed(q), t); };
  law.energy = [system](const VectorXd& q, const VectorXd& v, double t) { return qdot::energy(system, Fixed(q), Fixed(v), t); };
  law.jacobi_energy = [system](const VectorXd& q, const VectorXd& v, double t) {
    return qdot::jacobi_energy(system, Fixed(q), Fixed(v), t);
  };
  law.energy_balance = [system](const VectorXd& q, const VectorXd& v, double t) {
    using D = Dual<double, 1>;
    const Fixed a = qdot::acceleration(system, Fixed(q), Fixed(v), t);
    Vector<D, n> moving_q(q.size()), moving_v(q.size()), still_q(q.size()), still_v(q.size());
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      moving_q[i] = D{q[i]};
      moving_q[i].tangent[0] = v[i];
      moving_v[i] = D{v[i]};
      moving_v[i].tangent[0] = a[i];
      still_q[i] = q[i];
      still_v[i] = v[i];
    }
    const D time = D::variable(t, 0);
    return qdot::jacobi_energy(system, moving_q, moving_v, time).tangent[0] + lagrangian(system, still_q, still_v, time).tangent[0];
  };
  law.jacobian = [system](double t, const VectorXd& y, MatrixXd& J) { first_order_form(system).jacobian(t, y, J); };
  return law;
}

}  // namespace qdot::systems
