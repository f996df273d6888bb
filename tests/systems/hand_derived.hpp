#pragma once
// SPDX-License-Identifier: MIT
//
// What pencil and paper say about a system: M and rhs in M q̈ = rhs, and the parts of T that are not quadratic in q̇,
//
//     T = ½ q̇ᵀM q̇ + a·q̇ + T₀ .
//
// `LawSystem` is one system as the laws see it: the library's answers on one side, these on the other, both as functions
// of (q, q̇, t) without templates, so that every system is instantiated once for all laws. The library's are virtual functions: a
// std::function makes the compiler write fifteen functions for each.

#include <functional>
#include <memory>
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

  LawSystem(std::string name_, Eigen::Index n_, bool autonomous_, HandDerived hand_)
      : name(std::move(name_)), n(n_), autonomous(autonomous_), hand(std::move(hand_)) {}
  virtual ~LawSystem() = default;

  virtual MatrixXd M(const VectorXd& q, const VectorXd& v, double t) const = 0;
  virtual VectorXd rhs(const VectorXd& q, const VectorXd& v, double t) const = 0;
  virtual VectorXd acceleration(const VectorXd& q, const VectorXd& v, double t, By way = By::fastest) const = 0;
  virtual VectorXd momenta(const VectorXd& q, const VectorXd& v, double t) const = 0;
  virtual double T(const VectorXd& q, const VectorXd& v, double t) const = 0;
  virtual double V(const VectorXd& q, const VectorXd& v, double t) const = 0;
  virtual double energy(const VectorXd& q, const VectorXd& v, double t) const = 0;
  virtual double jacobi_energy(const VectorXd& q, const VectorXd& v, double t) const = 0;
  virtual double energy_balance(const VectorXd& q, const VectorXd& v, double t) const = 0;  // dh/dt + ∂L/∂t along the motion
  virtual void jacobian(double t, const VectorXd& y, MatrixXd& J) const = 0;

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

template <class E, int dof, Inertia I>
class LawSystemOf final : public LawSystem {
 public:
  LawSystemOf(std::string name_, const System<E, dof, I>& system, HandDerived hand_)
      : LawSystem(std::move(name_), system.dof(), System<E, dof, I>::autonomous, std::move(hand_)), system_(system) {}

  MatrixXd M(const VectorXd& q, const VectorXd& v, double t) const override { return mass_matrix(system_, Fixed(q), Fixed(v), t); }
  VectorXd rhs(const VectorXd& q, const VectorXd& v, double t) const override { return qdot::rhs(system_, Fixed(q), Fixed(v), t); }
  VectorXd acceleration(const VectorXd& q, const VectorXd& v, double t, By way) const override {
    return qdot::acceleration(system_, Fixed(q), Fixed(v), t, way);
  }
  VectorXd momenta(const VectorXd& q, const VectorXd& v, double t) const override {
    return conjugate_momenta(system_, Fixed(q), Fixed(v), t);
  }
  double T(const VectorXd& q, const VectorXd& v, double t) const override { return kinetic_energy(system_, Fixed(q), Fixed(v), t); }
  double V(const VectorXd& q, const VectorXd&, double t) const override { return potential_energy(system_, Fixed(q), t); }
  double energy(const VectorXd& q, const VectorXd& v, double t) const override { return qdot::energy(system_, Fixed(q), Fixed(v), t); }
  double jacobi_energy(const VectorXd& q, const VectorXd& v, double t) const override {
    return qdot::jacobi_energy(system_, Fixed(q), Fixed(v), t);
  }
  double energy_balance(const VectorXd& q, const VectorXd& v, double t) const override {
    using D = Dual<double, 1>;
    const Fixed a = qdot::acceleration(system_, Fixed(q), Fixed(v), t);
    Vector<D, dof> moving_q(q.size()), moving_v(q.size()), still_q(q.size()), still_v(q.size());
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      moving_q[i] = D{q[i]};
      moving_q[i].tangent[0] = v[i];
      moving_v[i] = D{v[i]};
      moving_v[i].tangent[0] = a[i];
      still_q[i] = q[i];
      still_v[i] = v[i];
    }
    const D time = D::variable(t, 0);
    return qdot::jacobi_energy(system_, moving_q, moving_v, time).tangent[0] + lagrangian(system_, still_q, still_v, time).tangent[0];
  }
  void jacobian(double t, const VectorXd& y, MatrixXd& J) const override { first_order_form(system_).jacobian(t, y, J); }

 private:
  using Fixed = Vector<double, dof>;
  System<E, dof, I> system_;
};

template <class E, int n, Inertia I>
std::unique_ptr<const LawSystem> law_system(std::string name, const System<E, n, I>& system, HandDerived hand) {
  return std::make_unique<LawSystemOf<E, n, I>>(std::move(name), system, std::move(hand));
}

}  // namespace qdot::systems
