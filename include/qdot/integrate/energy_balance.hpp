#pragma once
// SPDX-License-Identifier: MIT
//
// The energy balance of a run: where the energy went, and whether all of it is accounted for.
//
//     h(t) − h(t₀) = ∫ (P − ∂L/∂t) dt + Σ Δh      h = q̇·∂L/∂q̇ − L,  which is T + V unless L depends on time or oddly on q̇
//
// P = q̇·(ΣQ + Jᵀλ) is the power of all that is in neither T nor V; Δh is lost in impacts. A conservative
// system has neither, and its balance is the drift of the energy itself. With friction, motors and impacts the energy
// may go up and down, and it is the balance that tells a good run from one that gains energy out of nothing:
//
//     auto meter = energy_balance(scene);
//     simulate(scene, start, t_end, Dop853{}, {}, meter);
//     meter.balance().residual
//
// The meter is an observer. It integrates P over each step by Gauss' formula with five points on the step's own dense output. So
// the residual is that of the motion and not of the integral.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <type_traits>
#include <utility>

#include "qdot/ad/derivatives.hpp"
#include "qdot/effects/scene_motion.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/mechanics/energy.hpp"

namespace qdot {

/// Energies of a run, in the units of T.
struct EnergyBalance {
  double initial = 0.0;        ///< h at the start
  double final = 0.0;          ///< h at the end
  double work = 0.0;           ///< ∫ (P − ∂L/∂t) dt: done on the system, negative where it is dissipated
  double impacts = 0.0;        ///< Σ Δh of the jumps
  double residual = 0.0;       ///< largest |h − h(t₀) − work − impacts| over all steps
  double largest_change = 0.0; ///< largest |h − h(t₀)|
};

/// Rate of h on a motion: P − ∂L/∂t. Zero for a system whose energies do not depend on time.
template <class E, int n, Inertia inertia>
double energy_rate(const System<E, n, inertia>& system, const std::type_identity_t<Vector<double, n>>& q,
                   const std::type_identity_t<Vector<double, n>>& qdot, double t = 0.0) {
  if constexpr (System<E, n, inertia>::autonomous) {
    return 0.0;
  } else {
    return -derivative(detail::marked<void>([&](const auto& s) {
      using D = std::remove_cvref_t<decltype(s)>;
      const Vector<D, n> x = q.template cast<D>(), v = qdot.template cast<D>();
      return D(detail::kinetic<n>(system.energies(), x, v, s) - detail::potential<n>(system.energies(), x, s));
    }), t);
  }
}

/// Rate of h of a scene: the power of its effects and constraints, and what explicit time in its energies adds.
template <class Sys, class... Effects>
double energy_rate(const Scene<Sys, Effects...>& scene, const Coordinates<Sys>& q, const Coordinates<Sys>& qdot, double t,
                   const EffectStates<Scene<Sys, Effects...>>& z) {
  return power(scene, q, qdot, t, z) + energy_rate(scene.system(), q, qdot, t);
}
template <class Sys, class... Effects>
double energy_rate(const Scene<Sys, Effects...>& scene, const Coordinates<Sys>& q, const Coordinates<Sys>& qdot, double t = 0.0) {
  return energy_rate(scene, q, qdot, t, detail::states_at(scene, q, qdot, t));
}
/// Rate of h at a State, of a system or a scene.
template <HasEnergies M>
double energy_rate(const M& model, const State<M::dof_at_compile_time>& state) {
  return energy_rate(model, state.q, state.qdot, state.t);
}

/// The observer that keeps an energy balance, from functors h(t, y) and rate(t, y).
template <class Energy, class Rate>
class EnergyMeter {
 public:
  EnergyMeter(Energy h, Rate rate) : h_(std::move(h)), rate_(std::move(rate)) {}

  /// Takes the step into account.
  void operator()(const StepView& step) {
    if (!t_) begin(step);
    const double h = h_(step.t(), step.y());
    if (step.t() == *t_) {
      balance_.impacts += h - balance_.final;
    } else if (!is_zero()) {
      // Gauss' formula on [−1, 1].
      constexpr std::array<double, 5> x{-0.90617984593866399, -0.53846931010568309, 0.0, 0.53846931010568309, 0.90617984593866399};
      constexpr std::array<double, 5> w{0.23692688505618909, 0.47862867049936647, 0.56888888888888889, 0.47862867049936647,
                                        0.23692688505618909};
      const double middle = 0.5 * (step.t() + *t_), half = 0.5 * (step.t() - *t_);
      for (std::size_t i = 0; i < x.size(); ++i)
        balance_.work += half * w[i] * rate_(middle + half * x[i], step.y_at(middle + half * x[i]));
    }
    t_ = step.t();
    balance_.final = h;
    const double change = h - balance_.initial;
    balance_.largest_change = std::max(balance_.largest_change, std::abs(change));
    balance_.residual = std::max(balance_.residual, std::abs(change - balance_.work - balance_.impacts));
  }

  /// What was found so far; zeros before the first step.
  const EnergyBalance& balance() const noexcept { return balance_; }

 private:
  // A rate may know that it is zero always, which spares the dense output.
  bool is_zero() const {
    if constexpr (requires { rate_.is_zero(); }) return rate_.is_zero();
    return false;
  }

  void begin(const StepView& step) {
    t_ = step.t_previous();
    balance_.initial = balance_.final = h_(*t_, step.y_at(*t_));
  }

  Energy h_;
  Rate rate_;
  std::optional<double> t_;  // as far as the balance goes
  EnergyBalance balance_;
};

/// An observer for simulate() that keeps the energy balance of a system or scene, which must outlive it.
template <class Sys>
auto energy_balance(const Sys& system) {
  constexpr int n = Sys::dof_at_compile_time;
  const auto h = [&system](double t, const Eigen::Ref<const Eigen::VectorXd>& y) {
    const Eigen::Index k = system.dof();
    const Vector<double, n> q = y.head(k), qdot = y.segment(k, k);
    return jacobi_energy(system.system(), q, qdot, t);
  };
  const auto rate = [&system](double t, const Eigen::Ref<const Eigen::VectorXd>& y) {
    const Eigen::Index k = system.dof();
    const Vector<double, n> q = y.head(k), qdot = y.segment(k, k);
    if constexpr (requires { Sys::states_at_compile_time; }) {
      return energy_rate(system, q, qdot, t, EffectStates<Sys>(y.tail(Sys::states_at_compile_time)));
    } else {
      return energy_rate(system, q, qdot, t);
    }
  };
  return EnergyMeter(h, rate);
}

// Old names, accepted until 0.4.

/// energy_balance() by its old name.
template <class Sys>
[[deprecated("qdot: say energy_balance()")]]
auto energy_meter(const Sys& system) {
  return energy_balance(system);
}

}  // namespace qdot
