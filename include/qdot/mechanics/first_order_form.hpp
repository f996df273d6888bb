#pragma once
// SPDX-License-Identifier: MIT
//
// Second-order equations as a first-order system, which is all that a stepper sees:
//
//     y = [q; q̇],      ẏ = [q̇; q̈(q, q̇, t)],      ∂ẏ/∂y = [ 0        1       ]
//                                                            [ ∂q̈/∂q   ∂q̈/∂q̇ ]
//
// A stepper asks for the derivative, perhaps for the Jacobian, and for the name of a component when
// something goes wrong with it. The concept FirstOrderSystem says just that; anything that models it
// can be stepped, with or without a Lagrangian behind it.

#include <algorithm>
#include <array>
#include <concepts>
#include <memory>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/mechanics/acceleration_jacobian.hpp"
#include "qdot/mechanics/derive/kept_equations.hpp"
#include "qdot/mechanics/derive/kept_motion.hpp"
#include "qdot/mechanics/derive/kept_rates.hpp"
#include "qdot/mechanics/equations/constant_inertia.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"

namespace qdot {

/// What a stepper needs to know of ẏ = f(t, y).
template <class F>
concept FirstOrderSystem = requires(const F& f, double t, const Eigen::Ref<const Eigen::VectorXd>& y,
                                    Eigen::Ref<Eigen::VectorXd> ydot, Eigen::Ref<Eigen::MatrixXd> J, Eigen::Index i) {
  { F::size_at_compile_time } -> std::convertible_to<int>;           // number of components, or Dynamic
  { f.size() } -> std::convertible_to<Eigen::Index>;                 // the same, always known
  { f.derivative(t, y, ydot) };                                      // ydot ← f(t, y); may throw
  { f.jacobian(t, y, J) };                                           // J ← ∂f/∂y, exact; may throw
  { f.component_name(i) } -> std::convertible_to<std::string>;       // for messages
};

/// A first-order system that knows how to put a state back onto its constraints.
template <class F>
concept ProjectableSystem = FirstOrderSystem<F> && requires(const F& f, double t, Eigen::Ref<Eigen::VectorXd> y) {
  { f.project(t, y).residual } -> std::convertible_to<double>;           // y ← nearest consistent state; may throw
  { f.project(t, y).velocity_residual } -> std::convertible_to<double>;  // what is left of the two residuals
};

/// A first-order system whose equations switch between phases (in contact or apart, sticking or slipping).
///
/// The present phases are part of y. A guard is a function that stays ≥ 0 as long as its phase lasts. The driver finds where one
/// falls through zero, and lets the system choose the phases (and the velocities) that follow. The tolerance is that of the
/// method for each component of y: what is smaller cannot be told from zero.
template <class F>
concept SwitchingSystem = FirstOrderSystem<F> && requires(const F& f, double t, const Eigen::VectorXd& y, Eigen::VectorXd& changed,
                                                          Eigen::Ref<Eigen::VectorXd> g, const std::vector<bool>& fired,
                                                          Eigen::Index k) {
  { f.guard_count() } -> std::convertible_to<Eigen::Index>;
  { f.ending(k) } -> std::same_as<std::string>;                                  // name of guard k if the run ends at it
  { f.guards(t, y, g) };                                                        // g ← the guards in the phases of y
  { f.guard_bands(t, y, y, g) };                                                // (t, y, tolerance): their sizes of zero
  { f.switched(t, changed, fired, y) } -> std::same_as<std::vector<std::string>>;  // changes y; names what happened
};

/// A mechanical system in first-order form, y = [q; q̇]. Models FirstOrderSystem.
///
/// Holds a copy of the system. Evaluations allocate nothing for fixed n.
template <class Sys>
class FirstOrderForm {
  static constexpr int n = Sys::dof_at_compile_time;
  static constexpr bool has_traced_jacobian =
      Sys::inertia == Inertia::positive_definite && n <= 64 && detail::RecordableEnergies<typename Sys::EnergiesType, n>;
  static constexpr bool has_rates = has_traced_jacobian && detail::may_have_rates<n>;

 public:
  static constexpr int size_at_compile_time = n == Dynamic ? Dynamic : 2 * n;  ///< 2n, or Dynamic

  explicit FirstOrderForm(Sys system) : system_(std::move(system)), inertia_(system_) { detail::keep_lines(system_, system_); }

  /// The system behind it.
  const Sys& system() const noexcept { return system_; }
  /// A copy that is evaluated one way (mechanics/by.hpp).
  FirstOrderForm by(By way) const { return FirstOrderForm(system_.by(way)); }

  /// Traces T and V again where they are others by now, and factors a constant M again.
  void renew()
    requires(n == Dynamic || has_traced_jacobian || detail::may_keep_lines<typename Sys::EnergiesType, n>)
  {
    detail::renew_lines(system_, system_);
    if constexpr (has_traced_jacobian) jacobian_.renew(recordable());
    if constexpr (has_rates) rates_.renew(recordable());
    if constexpr (detail::TracedSystem<Sys>) traced_.renew(recordable());
    inertia_ = detail::ConstantInertia<Sys>(system_);
  }

  /// Whether M is the same everywhere, as seen from the operations of T.
  bool has_constant_inertia() const
    requires(n == Dynamic)
  {
    bool constant = inertia_.is_known();
    if constexpr (detail::TracedSystem<Sys>) use_traced([&](detail::TracedRates& m) { return constant = m.mass_is_constant(); });
    return constant;
  }

  /// Whether T and V have been recorded, in which nothing may be compared.
  bool is_recorded() const
    requires(n == Dynamic && detail::TracedSystem<Sys>)
  {
    return use_traced([](detail::TracedRates&) { return true; });
  }

  /// Holds evaluations on the branch that the functors have at y, beyond its guards as well, until leave_branch() or renew(); false where none is held.
  bool hold_branch(double t, const double* y) const
    requires has_rates
  {
    double ydot[2 * n];
    const detail::KeptLines& kept = *system_.kept_lines();
    return kept.may_be_lines() && rates_.hold_branch(kept, [this] { return recordable(); }, t, y, {}, ydot);
  }
  /// Holds none any more.
  void leave_branch() const
    requires has_rates
  {
    rates_.leave_branch();
  }

  /// In words, how the last evaluation went.
  std::string way_taken() const {
    std::string way;
    if constexpr (has_rates)
      if (const auto* const lines = rates_.latest(*system_.kept_lines(), detail::plain_system))
        return detail::way_of_lines(detail::are_native(*lines), system_.kept_lines()->by(), false);
    if constexpr (detail::TracedSystem<Sys>)
      use_traced([&](detail::TracedRates& m) {
        way = detail::way_of_lines(m.are_native(), system_.kept_lines()->by(), m.are_long());
        return true;
      });
    return way.empty() ? detail::way_taken(system_) : way;
  }

  /// Number of components, 2n.
  Eigen::Index size() const noexcept { return 2 * system_.dof(); }

  /// ydot ← [q̇; q̈].
  ///
  /// @throws as acceleration()
  void derivative(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) const {
    write_derivative(t, y.data(), ydot.data());
  }

  /// ydot ← [q̇; q̈] for size() numbers one after the other.
  void write_derivative(double t, const double* y, double* ydot) const {
    const Eigen::Index dof = system_.dof();
    if constexpr (has_rates) {
      const detail::KeptLines& kept = *system_.kept_lines();
      if (kept.may_be_lines() && !kept.is_aside() && rates_.write(kept, [this] { return recordable(); }, t, y, {}, ydot)) return;
    }
    double* const rates = std::copy_n(y + dof, dof, ydot);
    if constexpr (detail::TracedSystem<Sys>) {
      if (use_traced([&](detail::TracedRates& traced) { return traced.write(y, y + dof, t, y, rates, nullptr); })) return;
    }
    const Vector<double, n> q = detail::vector_at<n>(y, dof), qdot = detail::vector_at<n>(y + dof, dof);
    if constexpr (detail::may_keep_inertia<Sys>) {
      if (inertia_.is_known() && system_.kept_lines()->is_fastest()) {
        const Vector<double, Dynamic> a = inertia_.acceleration(system_, q, t);
        detail::require_finite_acceleration(system_, a, q, qdot, t);
        std::copy_n(a.data(), a.size(), rates);
        return;
      }
    }
    const Vector<double, n> a = acceleration(system_, q, qdot, t);
    std::copy_n(a.data(), a.size(), rates);
  }

  /// J ← ∂ẏ/∂y, 2n×2n, exact.
  ///
  /// @throws as acceleration()
  void jacobian(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::MatrixXd> J) const {
    write_both(t, y, nullptr, J);
  }
  /// ydot ← [q̇; q̈] and J ← ∂ẏ/∂y, for about what J costs alone.
  ///
  /// @throws as acceleration()
  void derivative_and_jacobian(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot, Eigen::Ref<Eigen::MatrixXd> J) const {
    write_both(t, y, ydot.data(), J);
  }

  /// M, C, K of the motion near y, within their band: what an implicit method solves with where neighbours meet.
  detail::BandedLinearization linearization(double t, const Eigen::Ref<const Eigen::VectorXd>& y) const
    requires(Sys::dof_at_compile_time == Dynamic && Sys::inertia == Inertia::positive_definite)
  {
    const auto [q, qdot] = parts(y);
    return detail::banded_linearization(system_.energies(), q, qdot, Eigen::VectorXd(acceleration(system_, q, qdot, t)), t);
  }

  /// The equations, traced anew: what an implicit method asks where few coordinates meet.
  std::shared_ptr<detail::TracedEquations<double>> equations() const
    requires detail::TracedSystem<Sys>
  {
    if (!system_.kept_lines()->may_be_lines()) throw InvalidValue("a system that is evaluated by dual numbers has no recorded equations");
    return detail::recorded_equations(recordable());
  }
  /// Runs the functors on a recording.
  void run_functors(detail::RecordedMotion& m) const
    requires detail::TracedSystem<Sys>
  {
    detail::run_energies<n>(m, system_.energies());
  }
  /// a ← q̈ at y; the last argument is for the multipliers of scenes.
  void accelerate(double t, const double* y, double* a, double*) const
    requires detail::TracedSystem<Sys>
  {
    Eigen::VectorXd ydot(size());
    write_derivative(t, y, ydot.data());
    std::copy_n(ydot.data() + system_.dof(), system_.dof(), a);
  }

  /// "phi" for a coordinate, "phidot" for a velocity.
  [[gnu::cold, gnu::noinline]] std::string component_name(Eigen::Index i) const {
    return i < system_.dof() ? system_.coordinate_name(i) : system_.velocity_name(i - system_.dof());
  }

  /// y = [q; q̇] of a state.
  Vector<double, size_at_compile_time> packed(const State<n>& state) const {
    detail::require_sizes(system_, state.q, state.qdot);
    Vector<double, size_at_compile_time> y(size());
    std::copy_n(state.qdot.data(), state.qdot.size(), std::copy_n(state.q.data(), state.q.size(), y.data()));
    return y;
  }

  /// The state of y = [q; q̇] at time t.
  State<n> state(double t, const Eigen::Ref<const Eigen::VectorXd>& y) const {
    auto [q, qdot] = parts(y);
    return State<n>{t, std::move(q), std::move(qdot)};
  }

 private:
  void write_both(double t, const Eigen::Ref<const Eigen::VectorXd>& y, double* ydot, Eigen::Ref<Eigen::MatrixXd> J) const {
    if constexpr (has_traced_jacobian) {
      if (system_.kept_lines()->may_be_lines() && jacobian_.template write<detail::unrolled_size<n>>(recordable(), {}, t, y.data(), ydot, J)) return;
    }
    const auto [q, qdot] = parts(y);
    const AccelerationJacobian<n> a = acceleration_jacobian(system_, q, qdot, t);
    const Eigen::Index dof = q.size();
    if (ydot) std::copy_n(a.qddot.data(), dof, std::copy_n(y.data() + dof, dof, ydot));
    for (Eigen::Index j = 0; j < dof; ++j)
      for (Eigen::Index i = 0; i < dof; ++i) {
        J(i, j) = 0.0;
        J(i, dof + j) = i == j ? 1.0 : 0.0;
        J(dof + i, j) = a.d_q(i, j);
        J(dof + i, dof + j) = a.d_qdot(i, j);
      }
  }
  // use(motion) with the traced motion; false where there is none.
  template <class Use>
  bool use_traced(const Use& use) const {
    return system_.kept_lines()->may_be_lines() && traced_.use([&] { return detail::traced_rates(recordable()); }, use);
  }
  detail::RecordableForm recordable() const { return detail::recordable(system_); }

  // q and q̇ of y, a vector each.
  std::pair<Vector<double, n>, Vector<double, n>> parts(const Eigen::Ref<const Eigen::VectorXd>& y) const {
    const Eigen::Index dof = system_.dof();
    return {detail::vector_at<n>(y.data(), dof), detail::vector_at<n>(y.data() + dof, dof)};
  }

  Sys system_;
  detail::ConstantInertia<Sys> inertia_;  // factored once in a leg, where M is constant and V no formula
  [[no_unique_address]] std::conditional_t<n == Dynamic, detail::KeptMotion<detail::TracedRates>, std::tuple<>> traced_;
  [[no_unique_address]] std::conditional_t<has_traced_jacobian, detail::KeptJacobians, std::tuple<int>> jacobian_;
  [[no_unique_address]] std::conditional_t<has_rates, detail::RunRates, std::tuple<long>> rates_;
};

namespace detail {

// Makes anew what a system keeps of its functors, if it keeps something: a method begins with the model as it is then.
template <class F>
void renew(F& system) {
  if constexpr (requires { system.renew(); }) system.renew();
}

}  // namespace detail

/// The first-order form of a mechanical system.
template <class E, int n, Inertia inertia>
FirstOrderForm<System<E, n, inertia>> first_order_form(const System<E, n, inertia>& system) {
  return FirstOrderForm<System<E, n, inertia>>(system);
}

/// A system that is of first order already is its own first-order form.
template <FirstOrderSystem F>
const F& first_order_form(const F& f) {
  return f;
}

namespace detail {

/// The first-order form of a system, evaluated one way.
///
/// @throws InvalidValue  a system that has no T and V to evaluate
template <class Sys>
auto form_by(const Sys& system, By way) {
  using Form = std::remove_cvref_t<decltype(first_order_form(system))>;
  if (way == By::fastest) return Form(first_order_form(system));
  if constexpr (requires { Form(system.by(way)); }) return Form(system.by(way));
  else if constexpr (requires { first_order_form(system.by(way)); }) return Form(first_order_form(system.by(way)));
  else {
    throw InvalidValue("by must be left out for equations that are of first order, given without T and V or made by an analysis; ask it of the system, "
                       "system.by(By::duals)");
    return Form(first_order_form(system));
  }
}

}  // namespace detail
}  // namespace qdot
