#pragma once
// SPDX-License-Identifier: MIT
//
// A mass matrix that is factored once, and again only where a method starts afresh.
//
// T(qdot) that is quadratic has the same M everywhere, and M q̈ = −∂V/∂q is all there is. Whether T is quadratic is tested: its
// operations are recorded (ad/records/reverse.hpp). Sums of products of two velocities, without a comparison on the way, are
// quadratic wherever else they are evaluated. Anything else, such as the kinetic energy of a relativistic particle, keeps its
// M(q̇).
//
// For systems that cannot be traced (mechanics/derive/traced_motion.hpp), because V branches on the state.
//
// Made when a method begins and never written to afterwards: copies of it may work in several threads.

#include <memory>
#include <utility>

#include "qdot/mechanics/equations/banded_equations.hpp"

namespace qdot::detail {

// Which systems may have one: n at run time (few coordinates known at compile time are as fast without), M positive definite.
template <class Sys>
inline constexpr bool may_keep_inertia = Sys::dof_at_compile_time == Dynamic && Sys::inertia == Inertia::positive_definite &&
                                         Sys::kinetic_signature == KineticSignature::velocity;

template <class Sys, class Real = double>
class ConstantInertia {
 public:
  explicit ConstantInertia(const Sys& system) {
    if constexpr (may_keep_inertia<Sys>) {
      const Eigen::VectorXd rest = Eigen::VectorXd::Zero(system.dof());
      Tape<Real> tape(2 * system.dof());
      TapedState<Real> state(tape, system.dof());
      const Reverse<Real> T = kinetic<Dynamic>(system.energies(), state.q, state.qdot, Reverse<Real>(0.0));
      if (tape.compared || T.degree > 2) return;
      auto M = std::make_shared<BandedMatrix>(banded_mass_matrix(system.energies(), rest, rest, 0.0, tape.reach));
      if (M->factor(singular_pivot<double>(system.dof()))) M_ = std::move(M);  // otherwise acceleration() says what is wrong
    }
  }

  /// True when M is constant and factored.
  bool is_known() const noexcept { return M_ != nullptr; }

  /// q̈ = −M⁻¹ ∂V/∂q, where M is known.
  Eigen::VectorXd acceleration(const Sys& system, const Eigen::VectorXd& q, double t) const {
    Eigen::VectorXd x = potential_force(system.energies(), q, t);
    M_->solve(x);
    return x;
  }

 private:
  std::shared_ptr<const BandedMatrix> M_;  // never written to again
};

}  // namespace qdot::detail
