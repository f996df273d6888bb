#pragma once
// SPDX-License-Identifier: MIT
//
// Explicit symplectic steps for systems whose energies separate: T(q̇) and V(q).
//
//     const auto run = simulate(kepler, start, 1e5, Splitting{.step = 0.01}, {.keep_trajectory = false});
//
// Over 10⁴ periods the energy error of an accurate method has a sign and adds up: a bound orbit spirals in. A symplectic method keeps
// every phase-space area, as the exact flow does, so its energy error oscillates and does not grow. What grows is the phase along
// the orbit, linearly; a method of order p makes it h^p small.
//
// The recipes, their orders and their sources are in integrate/steps/symplectic_schemes.hpp. Here M is constant (T quadratic in q̇
// alone), and inverted once, or factored where n is known at run time only. Each kick takes one gradient of V, none if the last kick
// was at the same place. With V(q, t) a kick takes V at the time that the drifts before it have reached: the splitting of the motion
// in extended phase space, which keeps the order.
//
// T(q, q̇), as of the double pendulum in its angles, has no exact drift: take Gauss (gauss.hpp), on constraints Rattle (rattle.hpp).

#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "qdot/integrate/stepper.hpp"
#include "qdot/integrate/steps/fixed_step.hpp"
#include "qdot/integrate/steps/symplectic_schemes.hpp"

namespace qdot {

/// A Stepper that makes equal steps of kicks and drifts. Movable.
template <class F>
class SplittingStepper : public detail::FixedStepOf<F> {
  using Base = detail::FixedStepOf<F>;
  using Base::n, Base::dof;

 public:
  /// @throws InvalidValue  step is not positive; the mass matrix depends on the velocities
  SplittingStepper(const F& system, SplittingScheme scheme, double step, const Options& options)
      : Base(system, std::string(detail::splitting(scheme).name), detail::splitting(scheme).order, step,
             options),
        scheme_(detail::splitting(scheme)) {
    qddot_ = Vector<double, n>::Zero(dof());
    invert_mass_matrix();
  }

  /// Starts (afresh) at (t, y); evaluates the accelerations once there.
  ///
  /// @throws as RungeKuttaStepper::reset
  void reset(const TimePoint& at, const Eigen::Ref<const Eigen::VectorXd>& y) {
    this->begin(at, y);
    invert_mass_matrix();
    force_is_current_ = false;
  }

  /// One step towards t_limit: the way there is divided into equal steps.
  bool step(double t_limit) {
    const double end = this->next_end(t_limit);
    const double h = this->h_;
    this->y_old_ = this->y_;
    const typename Base::Y lost_old = this->lost_;
    double reached = 0.0;  // sum of the drifts so far
    const bool evaluated = this->attempt([&] {
      for (std::size_t i = 0; i < scheme_.kicks.size(); ++i) {
        if (scheme_.kicks[i] != 0.0) kick(scheme_.kicks[i] * h, this->clock_.shown(this->elapsed_ + reached * h));
        if (scheme_.drifts[i] == 0.0) continue;
        drift(scheme_.drifts[i] * h);
        reached += scheme_.drifts[i];
      }
      require_finite();
    });
    if (!evaluated) {
      this->y_ = this->y_old_;
      this->lost_ = lost_old;
      force_is_current_ = false;
      ++this->statistics_.rejected_by_error_test;
      return this->give_up(h);
    }
    this->finish(end);
    return true;
  }

 private:
  void invert_mass_matrix() {
    if constexpr (n == Dynamic) {  // there may be many coordinates, and the form keeps M factored
      inverse_.resize(0, 0);
      if (this->form().has_constant_inertia()) return;
    }
    const auto& mechanical = this->form().system();
    inverse_ = detail::inverse_mass_matrix(mechanical, detail::constant_mass_matrix(mechanical, "a splitting method"), 0.0);
    inverse_ = Matrix<double, n>(0.5 * (inverse_ + inverse_.transpose()));  // exactly symmetric, hence symplectic
  }

  void kick(double bh, double t) {
    if (!force_is_current_) {
      accelerate(t);
      ++this->statistics_.evaluations;
      force_is_current_ = true;
    }
    for (Eigen::Index i = 0; i < dof(); ++i) detail::add_compensated(this->y_[dof() + i], this->lost_[dof() + i], bh * qddot_[i]);
  }

  void accelerate(double t) {
    if constexpr (n == Dynamic) {
      if (inverse_.size() == 0) {
        rates_.resize(this->size());
        this->form().write_derivative(t, this->y_.data(), rates_.data());
        qddot_ = rates_.tail(dof());
        return;
      }
    }
    const Vector<double, n> q = this->y_.head(dof());
    const Vector<double, n> qdot = this->y_.tail(dof());
    qddot_.noalias() = inverse_ * detail::lagrangian_gradient<n>(this->form().system().energies(), q, qdot, t);
  }

  void drift(double ah) {
    for (Eigen::Index i = 0; i < dof(); ++i) detail::add_compensated(this->y_[i], this->lost_[i], ah * this->y_[dof() + i]);
    force_is_current_ = false;
  }

  void require_finite() const {
    for (Eigen::Index i = 0; i < this->size(); ++i)
      if (!std::isfinite(this->y_[i]))
        throw NonFinite(this->component_name(i), this->t_,
                        this->component_name(i) + " became " + detail::text_of(this->y_[i]));
  }

  detail::Splitting scheme_;
  Matrix<double, n> inverse_;  // of M; empty where the form keeps M factored
  Eigen::VectorXd rates_;
  Vector<double, n> qddot_;
  bool force_is_current_ = false;  // qddot_ belongs to the present q
};

namespace detail {

// Whether T takes the velocities alone, as the type says. Energies whose type is hidden (mechanics/derive/any_energies.hpp) are asked at run time.
template <class Sys>
inline constexpr bool may_separate = Sys::kinetic_signature == KineticSignature::velocity ||
                                     requires(const typename Sys::EnergiesType& energies) { energies.kinetic_energy_takes_q(); };

}  // namespace detail

/// Symplectic splitting with a fixed step, for T(qdot) quadratic and V(q) or V(q, t).
struct Splitting {
  static constexpr std::string_view name = "splitting";  ///< as statistics call it

  double step = 0.01;                                      ///< longest |h|; the way to t_end is divided equally
  SplittingScheme scheme = SplittingScheme::blanes_moan_6; ///< the recipe

  /// A stepper for `system`, which it copies. Allocates all its memory here.
  ///
  /// @throws InvalidValue  step is not positive; the mass matrix depends on the velocities; T takes the coordinates, where its type is hidden
  template <class Sys>
  SplittingStepper<FirstOrderForm<Sys>> stepper(const FirstOrderForm<Sys>& system, const Options& options) const {
    static_assert(detail::may_separate<Sys>,
                  "qdot: a splitting method needs a kinetic energy of the velocities alone, T(qdot); for T(q, qdot) use "
                  "the symplectic method Gauss, or write the energies in Cartesian coordinates");
    if (detail::kinetic_energy_takes_q<Sys::dof_at_compile_time>(system.system().energies()))
      throw InvalidValue("a splitting method needs a kinetic energy of the velocities alone, T(qdot), and this T takes the coordinates; use Gauss");
    return {system, scheme, step, options};
  }
};

}  // namespace qdot
