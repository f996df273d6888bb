#pragma once
// SPDX-License-Identifier: MIT
//
// A scene in first-order form, y = [q; q̇; z], which is what a stepper sees.
//
// The Jacobian is exact and needs no derivative of a linear solve. Formulas are recorded for it, once in each combination of phases
// (mechanics/derive/traced_jacobian.hpp); what is left goes by nested duals (effects/equations/scene_jacobian.hpp).
//
// project(t, y) puts a state back onto the constraints; steppers call it after every accepted step. Where constraints
// switch, their phases are part of z, and guards(), guard_bands() and switched() are what the driver needs to change them.

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/effects/equations/phases_at_state.hpp"
#include "qdot/effects/equations/scene_jacobian.hpp"
#include "qdot/effects/equations/switching.hpp"
#include "qdot/effects/projection.hpp"
#include "qdot/effects/rows/kept_projection.hpp"
#include "qdot/effects/rows/traced_constraints.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"
#include "qdot/mechanics/derive/kept_equations.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot {

/// A scene as ẏ = f(t, y), y = [q; q̇; z]. Models FirstOrderSystem.
template <class Sc>
class SceneForm {
  static constexpr int n = Sc::dof_at_compile_time;
  static constexpr int states = Sc::states_at_compile_time;
  static constexpr int m = Sc::constraints_at_compile_time;
  static constexpr bool is_traced = detail::is_traced_scene<Sc>;
  static constexpr bool has_traced_jacobian = detail::has_traced_jacobian<Sc>;
  static constexpr bool has_rates = detail::has_rates<Sc>;
  static constexpr bool has_projection_lines =
      has_rates && Sc::has_constraints && Sc::SystemType::inertia == Inertia::positive_definite;
  using Traced = std::conditional_t<Sc::has_constraints, detail::TracedConstraints, detail::TracedRates>;

 public:
  static constexpr int dof_at_compile_time = n;                                         ///< n, or Dynamic
  static constexpr int size_at_compile_time = n == Dynamic ? Dynamic : 2 * n + states;  ///< 2n and the states of effects, or Dynamic
  static constexpr bool has_constraints = Sc::has_constraints;                          ///< as the scene has it
  static constexpr bool has_forces = Sc::has_forces;                                    ///< likewise
  static constexpr bool jacobian_changes_fast = Sc::has_plane_friction;                 ///< so that none may be kept from one step to the next
  static constexpr bool functors_are_recordable = detail::is_recordable_scene<Sc>;      ///< T, V and effects take every scalar

  explicit SceneForm(Sc scene) : scene_(std::move(scene)) { detail::keep_lines(scene_, scene_.system()); }

  /// The scene behind it.
  const Sc& scene() const noexcept { return scene_; }
  /// A copy that is evaluated one way (mechanics/by.hpp).
  SceneForm by(By way) const { return SceneForm(scene_.by(way)); }

  /// Traces the functors again where they are others by now.
  void renew()
    requires(is_traced || has_traced_jacobian || detail::may_keep_lines<typename Sc::SystemType::EnergiesType, n>)
  {
    if constexpr (has_traced_jacobian) jacobian_.renew(recordable());
    if constexpr (has_rates) rates_.renew(recordable());
    if constexpr (is_traced) traced_.renew(recordable());
    detail::renew_lines(scene_, scene_.system());
  }

  /// Whether the functors have been recorded, in which nothing may be compared.
  bool is_recorded() const
    requires is_traced
  {
    return use_traced([](Traced&) { return true; });
  }

  /// Holds evaluations on the branch that the functors have at y, beyond its guards as well, until leave_branch() or renew(); false where none is held.
  bool hold_branch(double t, const double* y) const
    requires has_rates
  {
    double ydot[2 * n + states];
    return by_lines() && rates_.hold_branch(*scene_.system().kept_lines(), [this] { return recordable(); }, t, y, phases(y), ydot);
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
      if (const auto* const lines = rates_.latest(*scene_.system().kept_lines(), detail::run_any_scene<Sc>))
        return detail::way_of_lines(detail::are_native(*lines), scene_.system().kept_lines()->by(), false);
    if constexpr (is_traced)
      use_traced([&](Traced& traced) {
        way = detail::way_of_lines(traced.are_native(), scene_.system().kept_lines()->by(), traced.are_long());
        return true;
      });
    if (!way.empty()) return way;
    return detail::way_taken(scene_.system()) + (by_lines() ? "; effects are called as they are" : "");
  }

  /// Number of coordinates.
  Eigen::Index dof() const noexcept { return scene_.dof(); }
  /// Number of components of y = [q; q̇; z].
  Eigen::Index size() const noexcept { return 2 * scene_.dof() + states; }

  /// ydot ← [q̇; q̈; ż].
  ///
  /// @throws as acceleration() of the scene
  void derivative(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) const {
    write_derivative(t, y.data(), ydot.data());
  }

  /// ydot ← [q̇; q̈; ż] for size() numbers one after the other.
  void write_derivative(double t, const double* y, double* ydot) const {
    const Eigen::Index k = dof();
    if constexpr (is_traced) {
      std::copy_n(y + k, k, ydot);
      const auto write = [&](Traced& traced) {
        if constexpr (has_constraints) return traced.write(y, y + k, t, y + 2 * k, ydot + k, nullptr, ydot + 2 * k);
        else return traced.write(y, y + k, t, y + 2 * k, ydot + k, ydot + 2 * k);
      };
      if (use_traced(write)) return;
    }
    if constexpr (has_rates)
      if (may_be_lines() && rates_.write(*scene_.system().kept_lines(), [this] { return recordable(); }, t, y, phases(y), ydot)) return;
    const Vector<double, n> q = q_of(y), qdot = qdot_of(y);
    const Vector<double, states> z = z_of(y);
    std::copy_n(qdot.data(), k, ydot);
    const Vector<double, n> a = acceleration(scene_, q, qdot, t, z);
    std::copy_n(a.data(), k, ydot + k);
    if constexpr (Sc::has_states) {
      const Vector<double, states> rates = state_rates(scene_, q, qdot, z, t);
      std::copy_n(rates.data(), states, ydot + 2 * k);
    }
  }

  /// J ← ∂ẏ/∂y, exact.
  ///
  /// @throws as acceleration() of the scene, and NonFinite where a derivative is not finite
  void jacobian(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::MatrixXd> out) const { write_jacobian(t, y, nullptr, out); }

  /// ydot ← f(t, y) and J ← ∂ẏ/∂y, for little more than J alone where functors are recorded, and for f besides where not.
  ///
  /// @throws as jacobian()
  void derivative_and_jacobian(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot, Eigen::Ref<Eigen::MatrixXd> out) const {
    write_jacobian(t, y, ydot.data(), out);
  }

  /// Puts y back onto the constraints; nothing where there are none.
  ///
  /// @throws ConstraintError  when the state is too far away from them
  ProjectionReport project(double t, Eigen::Ref<Eigen::VectorXd> y) const
    requires has_constraints
  {
    const Vector<double, states> z = z_of(y.data());
    if (detail::is_free(scene_, z)) return {};
    ProjectionReport report;
    if constexpr (has_projection_lines) {
      if (may_be_lines()) {
        const auto now = phases(y.data());
        double ydot[2 * n + states];
        if (const auto lines = rates_.at(*scene_.system().kept_lines(), [this] { return recordable(); }, t, y.data(), now, ydot)) {
          const auto& projection = lines->attached([&] { return detail::projection_by_lines(*lines); });
          if (static_cast<const detail::AnyProjection&>(projection).project(t, y.data(), now, report)) return report;
        }
      }
    }
    Vector<double, n> q = q_of(y.data()), qdot = qdot_of(y.data());
    const auto project_on = [&](detail::TracedConstraints* traced) {
      report = detail::projected(scene_, q, qdot, t, default_rank_cutoff, z, traced);
      return true;
    };
    bool done = false;
    if constexpr (is_traced) done = use_traced([&](Traced& traced) { return project_on(&traced); });
    if (!done) project_on(nullptr);
    std::copy_n(qdot.data(), dof(), std::copy_n(q.data(), dof(), y.data()));
    return report;
  }

  /// Number of contacts and dry frictions.
  Eigen::Index guard_count() const
    requires(Sc::has_phases)
  {
    return static_cast<Eigen::Index>(Sc::phases_at_compile_time);
  }

  /// g ← functions that stay ≥ 0 as long as the phases of y last.
  void guards(double t, const Eigen::VectorXd& y, Eigen::Ref<Eigen::VectorXd> g, bool are_smooth = false) const
    requires(Sc::has_phases)
  {
    detail::write_guards(scene_, t, q_of(y.data()), qdot_of(y.data()), z_of(y.data()), g, are_smooth);
  }

  /// out ← how large each guard may be and still be zero, given what is zero in each component of y.
  void guard_bands(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& tolerance, Eigen::Ref<Eigen::VectorXd> out) const
    requires(Sc::has_phases)
  {
    detail::write_guard_bands(detail::SwitchingSceneOf<Sc>(scene_), t, q_of(y.data()), qdot_of(y.data()), z_of(y.data()), tolerance, out);
  }

  /// Whether something has moved the gap of a closed contact, so that it is no longer zero.
  bool gap_has_moved(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& tolerance) const
    requires(Sc::has_phases)
  {
    return detail::gap_has_moved(detail::SwitchingSceneOf<Sc>(scene_), t, q_of(y.data()), qdot_of(y.data()), z_of(y.data()), tolerance);
  }

  /// Name of guard k if the run ends where it falls through zero; otherwise nothing.
  std::string ending(Eigen::Index k) const
    requires(Sc::has_phases)
  {
    const detail::SwitchingPart part = detail::SceneRowsOf<Sc>(scene_).parts()[static_cast<std::size_t>(k)];
    return part.ends_run ? part.name : std::string();
  }

  /// Name of the contact or friction of guard k.
  std::string guard_name(Eigen::Index k) const
    requires(Sc::has_phases)
  {
    return detail::SceneRowsOf<Sc>(scene_).parts()[static_cast<std::size_t>(k)].name;
  }

  /// Gives y the velocities and phases that follow when the guards `fired` have reached zero; says what happened.
  ///
  /// @param left_out  those whose own guards are taken apart from this, and whose phases stay as they are; none where it is null
  /// @throws ConstraintError  when a gap is negative, or no phases fit together
  std::vector<std::string> switched(double t, Eigen::VectorXd& y, const std::vector<bool>& fired, const Eigen::VectorXd& tolerance,
                                    const std::vector<bool>* left_out = nullptr) const
    requires(Sc::has_phases)
  {
    Eigen::VectorXd q = q_of(y.data()), qdot = qdot_of(y.data()), z = z_of(y.data());
    std::vector<std::string> happened = detail::settle(detail::SwitchingSceneOf<Sc>(scene_), t, q, qdot, z, fired, tolerance, left_out);
    std::copy_n(z.data(), states, std::copy_n(qdot.data(), dof(), std::copy_n(q.data(), dof(), y.data())));
    return happened;
  }

  /// The equations, traced anew: what an implicit method asks where few coordinates meet.
  std::shared_ptr<detail::TracedEquations<double>> equations() const
    requires is_traced
  {
    if (!by_lines()) throw InvalidValue("a scene that is evaluated by dual numbers has no recorded equations");
    return detail::recorded_equations(recordable());
  }
  /// Runs the functors on a recording.
  void run_functors(detail::RecordedMotion& motion) const
    requires is_traced
  {
    detail::run_scene(motion, scene_, nullptr);
  }
  /// The phases of contacts and dry frictions in y.
  auto phases(const double* y) const { return detail::phases_in(scene_, y + 2 * dof()); }
  /// a ← q̈ and lambda ← λ at y.
  void accelerate(double t, const double* y, double* a, double* lambda) const
    requires is_traced
  {
    const Eigen::Index k = dof();
    if constexpr (has_constraints) {
      std::vector<double> rates(states);
      if (use_traced([&](Traced& traced) { return traced.write(y, y + k, t, y + 2 * k, a, lambda, rates.data()); })) return;
      const Vector<double, n> q = q_of(y), qdot = qdot_of(y);
      const Vector<double, states> z = z_of(y);
      const auto solution = constrained_acceleration(scene_, q, qdot, t, z);
      std::copy_n(solution.qddot.data(), k, a);
      std::copy_n(solution.lambda.data(), solution.lambda.size(), lambda);
    } else {
      Eigen::VectorXd ydot(size());
      write_derivative(t, y, ydot.data());
      std::copy_n(ydot.data() + k, k, a);
    }
  }

  /// Jᵀλ at y, the generalized forces of the constraints; lambda ← λ.
  Vector<double, n> constraint_forces(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::VectorXd& lambda) const
    requires has_constraints
  {
    const Eigen::Index k = dof();
    Vector<double, n> forces(k);
    if constexpr (is_traced) {
      std::vector<double> a(static_cast<std::size_t>(k)), rates(states);
      const double* const state = y.data();
      const auto write = [&](Traced& traced) {
        lambda.resize(static_cast<Eigen::Index>(traced.rows()));
        if (!traced.write(state, state + k, t, state + 2 * k, a.data(), lambda.data(), rates.data())) return false;
        traced.pull(lambda.data(), forces.data());
        return true;
      };
      if (use_traced(write)) return forces;
    }
    const Vector<double, n> q = q_of(y.data()), qdot = qdot_of(y.data());
    const Vector<double, states> z = z_of(y.data());
    lambda = constrained_acceleration(scene_, q, qdot, t, z).lambda;
    return constraint_jacobian(scene_, q, qdot, t, z).transpose() * lambda;
  }

  /// A coordinate's name, a velocity's, or that of an effect's state.
  [[gnu::cold, gnu::noinline]] std::string component_name(Eigen::Index i) const {
    if (i < dof()) return scene_.coordinate_name(i);
    if (i < 2 * dof()) return scene_.velocity_name(i - dof());
    return detail::sentence({"z", i - 2 * dof()});
  }

  /// y = [q; q̇; z₀] of a state; the effects' own states start at their initial values.
  Vector<double, size_at_compile_time> packed(const State<n>& state) const {
    detail::require_sizes(scene_, state.q, state.qdot);
    Vector<double, size_at_compile_time> y(size());
    const Vector<double, states> z = scene_.initial_states();
    std::copy_n(z.data(), states, std::copy_n(state.qdot.data(), dof(), std::copy_n(state.q.data(), dof(), y.data())));
    return y;
  }

  /// The time, q and q̇ of y.
  State<n> state(double t, const Eigen::Ref<const Eigen::VectorXd>& y) const {
    return State<n>{t, q_of(y.data()), qdot_of(y.data())};
  }

 private:
  // The parts of y = [q; q̇; z].
  Vector<double, n> q_of(const double* y) const { return detail::vector_at<n>(y, dof()); }
  Vector<double, n> qdot_of(const double* y) const { return detail::vector_at<n>(y + dof(), dof()); }
  Vector<double, states> z_of(const double* y) const { return detail::vector_at<states>(y + 2 * dof(), states); }

  // J, and ẏ if it is wanted.
  void write_jacobian(double t, const Eigen::Ref<const Eigen::VectorXd>& y, double* ydot, Eigen::Ref<Eigen::MatrixXd> out) const {
    if constexpr (has_traced_jacobian) {
      if (by_lines() && jacobian_.template write<detail::unrolled_size<n>>(recordable(), phases(y.data()), t, y.data(), ydot, out)) return;
    }
    if (ydot) write_derivative(t, y.data(), ydot);
    detail::write_scene_jacobian(detail::SceneSlopesOf<Sc>(scene_), t, y, out);
    if (detail::all_finite(out.data(), out.size())) return;
    const auto slopes_at = [this, t](const Eigen::VectorXd& place, Eigen::MatrixXd& J) {
      J.resize(size(), size());
      detail::write_scene_jacobian(detail::SceneSlopesOf<Sc>(scene_), t, place, J);
    };
    if (Eigen::MatrixXd limit; detail::slopes_in_the_limit(y, dof(), limit, slopes_at)) {
      out = limit;
      return;
    }
    detail::require_finite_derivatives(
        out, t, [this](Eigen::Index i) { return detail::sentence({"the rate of ", component_name(i)}); }, [this](Eigen::Index j) { return component_name(j); });
  }

  detail::RecordableForm recordable() const { return detail::recordable_scene(scene_); }
  // Whether lines of a run may be used.
  bool may_be_lines() const { return by_lines() && !scene_.system().kept_lines()->is_aside(); }
  bool by_lines() const { return scene_.system().kept_lines()->may_be_lines(); }
  // use(traced) with what was traced; false where there is nothing.
  template <class Use>
  bool use_traced(const Use& use) const
    requires is_traced
  {
    return by_lines() && traced_.use([this] { return trace(); }, use);
  }

  // One for a run: equations are traced when it begins, if n is known at run time only.
  std::unique_ptr<Traced> trace() const
    requires is_traced
  {
    if constexpr (has_constraints) return detail::traced_constraints(recordable(), default_rank_cutoff);
    else return detail::traced_rates(recordable());
  }

  Sc scene_;
  [[no_unique_address]] std::conditional_t<is_traced, detail::KeptMotion<Traced>, std::tuple<>> traced_;
  [[no_unique_address]] std::conditional_t<has_traced_jacobian, detail::KeptJacobians, std::tuple<int>> jacobian_;
  [[no_unique_address]] std::conditional_t<has_rates, detail::RunRates, std::tuple<long>> rates_;
};

/// The first-order form of a scene; that of its system where it has no effects.
template <class Sys, class... Effects>
auto first_order_form(const Scene<Sys, Effects...>& scene) {
  if constexpr (sizeof...(Effects) == 0) {
    return first_order_form(scene.system());
  } else {
    return SceneForm<Scene<Sys, Effects...>>(scene);
  }
}

}  // namespace qdot
