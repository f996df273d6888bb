#pragma once
// SPDX-License-Identifier: MIT
//
// A scene in first-order form, y = [q; q̇; z], which is what a stepper sees.
//
// The Jacobian is exact and needs no derivative of a linear solve. At fixed accelerations and multipliers the
// equations are residuals of first derivatives only,
//
//     r(y) = d/dt(∂L/∂q̇) − ∂L/∂q − ΣQ − Jᵀλ ,      c(y) = φ̈ (or ȧ) at these q̈ ,
//
// and the implicit function theorem gives [∂q̈; −∂λ] from the matrix that has just been factored:
//
//     [ M  −Jᵀ ] [∂q̈]      [∂r]
//     [ J   0  ] [∂λ]  = − [∂c] .
//
// Where n is known at run time, that matrix is sparse (sparse_solve.hpp), and Jᵀλ comes from one sweep back for all coordinates.
//
// project(t, y) puts a state back onto the constraints; steppers call it after every accepted step. Where constraints
// switch, their phases are part of z, and guards(), guard_bands() and switched() are what the driver needs to change them.

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "qdot/effects/projection.hpp"
#include "qdot/effects/switching.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot {

/// A scene as ẏ = f(t, y), y = [q; q̇; z]. Models FirstOrderSystem.
template <class Sc>
class SceneForm {
  static constexpr int n = Sc::dof_at_compile_time;
  static constexpr int states = Sc::states_at_compile_time;
  static constexpr int m = Sc::constraints_at_compile_time;

 public:
  static constexpr int dof_at_compile_time = n;
  static constexpr int size_at_compile_time = n == Dynamic ? Dynamic : 2 * n + states;
  static constexpr bool has_constraints = Sc::has_constraints;

  explicit SceneForm(Sc scene) : scene_(std::move(scene)) {}

  const Sc& scene() const noexcept { return scene_; }
  Eigen::Index dof() const noexcept { return scene_.dof(); }
  Eigen::Index size() const noexcept { return 2 * scene_.dof() + states; }

  /// ydot ← [q̇; q̈; ż].
  ///
  /// @throws as acceleration() of the scene
  void derivative(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) const {
    const Eigen::Index k = dof();
    const Vector<double, n> q = y.head(k);
    const Vector<double, n> qdot = y.segment(k, k);
    const Vector<double, states> z = y.tail(states);
    ydot.head(k) = qdot;
    ydot.segment(k, k) = acceleration(scene_, q, qdot, t, z);
    if constexpr (Sc::has_states) ydot.tail(states) = state_rates(scene_, q, qdot, z, t);
  }

  /// J ← ∂ẏ/∂y, exact.
  ///
  /// @throws as acceleration() of the scene, and NonFinite where a derivative is not finite
  void jacobian(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::MatrixXd> out) const {
    write_jacobian<true>(t, y, out);
    if (detail::all_finite(out.data(), out.size())) return;
    write_jacobian<false>(t, y, out);  // which knows that a constant has no derivative, however steep the root of it is
    detail::require_finite_derivatives(
        out, t, [this](Eigen::Index i) { return "the rate of " + component_name(i); }, [this](Eigen::Index j) { return component_name(j); });
  }

  /// Puts y back onto the constraints; nothing where there are none.
  ///
  /// @throws ConstraintError  when the state is too far away from them
  ProjectionReport project(double t, Eigen::Ref<Eigen::VectorXd> y) const
    requires has_constraints
  {
    Vector<double, n> q = y.head(dof());
    Vector<double, n> qdot = y.segment(dof(), dof());
    const Vector<double, states> z = y.tail(states);
    if (detail::is_free(scene_, z)) return {};
    const ProjectionReport report = qdot::project(scene_, q, qdot, t, default_rank_cutoff, z);
    y.head(dof()) = q;
    y.segment(dof(), dof()) = qdot;
    return report;
  }

  /// Number of contacts and dry frictions.
  Eigen::Index guard_count() const
    requires(Sc::has_phases)
  {
    return detail::Switching<Sc>::count();
  }

  /// g ← functions that stay ≥ 0 as long as the phases of y last.
  void guards(double t, const Eigen::VectorXd& y, Eigen::Ref<Eigen::VectorXd> g) const
    requires(Sc::has_phases)
  {
    detail::Switching<Sc>(scene_).guards(t, y.head(dof()), y.segment(dof(), dof()), y.tail(states), g);
  }

  /// out ← how large each guard may be and still be zero, given what is zero in each component of y.
  void guard_bands(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& tolerance, Eigen::Ref<Eigen::VectorXd> out) const
    requires(Sc::has_phases)
  {
    detail::Switching<Sc>(scene_).bands(t, y.head(dof()), y.segment(dof(), dof()), y.tail(states), tolerance, out);
  }

  /// Name of guard k if the run ends where it falls through zero; otherwise nothing.
  std::string ending(Eigen::Index k) const
    requires(Sc::has_phases)
  {
    return detail::Switching<Sc>(scene_).ending(k);
  }

  /// Gives y the velocities and phases that follow when the guards `fired` have reached zero; says what happened.
  ///
  /// @throws ConstraintError  when a gap is negative, or no phases fit together
  std::vector<std::string> switched(double t, Eigen::VectorXd& y, const std::vector<bool>& fired, const Eigen::VectorXd& tolerance) const
    requires(Sc::has_phases)
  {
    Vector<double, n> q = y.head(dof());
    Vector<double, n> qdot = y.segment(dof(), dof());
    Vector<double, states> z = y.tail(states);
    std::vector<std::string> happened = detail::Switching<Sc>(scene_).settle(t, q, qdot, z, fired, tolerance);
    y << q, qdot, z;
    return happened;
  }

  std::string component_name(Eigen::Index i) const {
    if (i < dof()) return scene_.coordinate_name(i);
    if (i < 2 * dof()) return scene_.velocity_name(i - dof());
    return "z" + std::to_string(i - 2 * dof());
  }

  /// y = [q; q̇; z₀] of a state; the effects' own states start at their initial values.
  Vector<double, size_at_compile_time> packed(const State<n>& state) const {
    detail::require_sizes(scene_, state.q, state.qdot);
    Vector<double, size_at_compile_time> y(size());
    y << state.q, state.qdot, scene_.initial_states();
    return y;
  }

  State<n> state(double t, const Eigen::Ref<const Eigen::VectorXd>& y) const {
    return State<n>{t, y.head(dof()), y.segment(dof(), dof())};
  }

 private:
  // The same, with the derivatives of the system's own equations from records, or from nested duals a direction at a time.
  template <bool recorded>
  void write_jacobian(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::MatrixXd> out) const {
    const Eigen::Index k = dof();
    const Vector<double, n> q = y.head(k);
    const Vector<double, n> qdot = y.segment(k, k);
    const Vector<double, states> z = y.tail(states);
    Vector<double, n> a;
    Vector<double, m> lambda;
    if constexpr (Sc::has_constraints) {
      const auto solution = constrained_acceleration(scene_, q, qdot, t, z);
      a = solution.qddot;
      lambda = solution.lambda;
    } else {
      a = acceleration(scene_, q, qdot, t, z);
    }
    Matrix<double, n, size_at_compile_time> dr = Matrix<double, n, size_at_compile_time>::Zero(k, size());  // −∂r/∂y
    Matrix<double, m, size_at_compile_time> dc(lambda.size(), size());                                     // −∂c/∂y
    out.setZero();
    out.block(0, k, k, k).setIdentity();

    const auto& energies = scene_.system().energies();
    if constexpr (recorded) {
      detail::for_each_residual<n>(energies, q, qdot, a, t, [&](int i, int first, const double* residual) {
        for (int j = 0; j < std::min(detail::residual_directions, 2 * static_cast<int>(k) - first); ++j)
          dr(i, (first + j) / 2 + (j % 2 == 0 ? 0 : k)) = residual[j];
      });
    } else {
      using D = Dual<double, 1>;
      Vector<D, n> x = detail::constants<D>(q), v = detail::constants<D>(qdot);
      const Vector<D, n> fixed_a = detail::constants<D>(a);
      for (Eigen::Index j = 0; j < 2 * k; ++j) {
        D& seed = j < k ? x[j] : v[j - k];
        seed.tangent[0] = 1.0;
        const Vector<D, n> r = detail::lagrange_residual<n>(energies, x, v, fixed_a, D(t));
        for (Eigen::Index i = 0; i < k; ++i) dr(i, j) = -r[i].tangent[0];
        seed.tangent[0] = 0.0;
      }
    }
    if constexpr (Sc::has_forces || Sc::has_constraints || Sc::has_states) add_effects(t, y, a, lambda, dr, dc, out);
    if constexpr (detail::may_be_sparse<Sc>) {
      if (solved_sparsely(q, qdot, t, z, dr, dc, out)) return;
    }
    const Matrix<double, n> M = mass_matrix(scene_, q, qdot, t);
    if constexpr (Sc::has_constraints) {
      const detail::ConstrainedFactors<n, m> factors(M, constraint_jacobian(scene_, q, qdot, t, z), default_rank_cutoff);
      for (Eigen::Index j = 0; j < size(); ++j)
        out.block(k, j, k, 1) =
            factors.solution(Vector<double, n>(dr.col(j)), Vector<double, m>(dc.col(j)), t, detail::SceneNames<Sc>{scene_}).qddot;
    } else {
      out.block(k, 0, k, size()) = detail::solved_with_mass_matrix(scene_.system(), M, dr, t);
    }
  }

  // Each column of ∂q̈ from sparse factors; false where they see to nothing.
  template <class DR, class DC>
  bool solved_sparsely(const Vector<double, n>& q, const Vector<double, n>& qdot, double t, const Vector<double, states>& z, const DR& dr,
                       const DC& dc, Eigen::Ref<Eigen::MatrixXd> out) const {
    detail::SparseSystem sparse;
    if (!sparse.compute_without_r(scene_, q, qdot, t, z, default_rank_cutoff)) return false;
    for (Eigen::Index j = 0; j < size(); ++j) {
      Vector<double, n> column = dr.col(j);
      Vector<double, m> rows = dc.col(j);
      if (!sparse.factors.solve(column, rows)) return false;
      out.block(q.size(), j, q.size(), 1) = column;
    }
    return true;
  }

  // Jᵀλ = ∂(λ·velocity rows)/∂q̇, for rows of both kinds; backwards where there may be many.
  template <class D>
  Vector<D, n> reactions_of(const Vector<double, m>& lambda, const Vector<D, n>& x, const Vector<D, n>& v, double t,
                            const Vector<double, states>& z) const {
    const auto sum_of = [&]<class U>(const Vector<U, n>& u) {
      const auto rows = constraint_velocity(scene_, Vector<U, n>(x.template cast<U>()), u, U(D(t)), z);
      U sum(0);
      for (Eigen::Index i = 0; i < rows.size(); ++i) sum += lambda[i] * rows[i];
      return sum;
    };
    if constexpr (n == Dynamic) {
      detail::Tape<D> tape;
      Vector<detail::Reverse<D>, n> u(v.size());
      for (Eigen::Index i = 0; i < v.size(); ++i) u[i] = detail::Reverse<D>(v[i], tape.variable(static_cast<int>(i)), &tape);
      std::vector<D> adjoint;
      tape.sweep(sum_of(u).node, adjoint);
      return Eigen::Map<const Vector<D, n>>(adjoint.data(), v.size());
    } else {
      return gradient([&](const auto& u) { return sum_of(u); }, v);
    }
  }

  // The effects' share of dr, dc, and the derivatives of ż.
  template <class DR, class DC>
  void add_effects(double t, const Eigen::Ref<const Eigen::VectorXd>& y, const Vector<double, n>& a, const Vector<double, m>& lambda, DR& dr,
                   DC& dc, Eigen::Ref<Eigen::MatrixXd> out) const {
    using D = Dual<double, detail::directions_for<size_at_compile_time>>;
    const Eigen::Index k = dof();
    const Vector<double, size_at_compile_time> at = y;
    [[maybe_unused]] const Vector<double, states> z = y.tail(states);
    [[maybe_unused]] const Vector<D, n> fixed_a = a.template cast<D>();
    for (Eigen::Index first = 0; first < size(); first += D::directions) {
      const Vector<D, size_at_compile_time> seeds = detail::seeded<D>(at, first);
      const Vector<D, n> x = seeds.head(k);
      const Vector<D, n> v = seeds.segment(k, k);
      const Vector<D, states> w = seeds.template tail<states>();
      Vector<D, n> Q = Vector<D, n>::Zero(k);
      if constexpr (Sc::has_forces) Q = effect_forces(scene_, x, v, w, D(t));
      Vector<D, m> c(lambda.size());
      if constexpr (Sc::has_constraints) {
        Q += reactions_of(lambda, x, v, t, z);
        c = constraint_acceleration(scene_, x, v, fixed_a, D(t), z);
      }
      Vector<D, states> rate;
      if constexpr (Sc::has_states) rate = state_rates(scene_, x, v, w, D(t));
      const Eigen::Index end = std::min<Eigen::Index>(size(), first + D::directions);
      for (Eigen::Index j = first; j < end; ++j) {
        const auto d = static_cast<std::size_t>(j - first);
        for (Eigen::Index i = 0; i < k; ++i) dr(i, j) += Q[i].tangent[d];
        for (Eigen::Index i = 0; i < lambda.size(); ++i) dc(i, j) = -c[i].tangent[d];
        for (Eigen::Index i = 0; i < states; ++i) out(2 * k + i, j) = rate[i].tangent[d];
      }
    }
  }

  Sc scene_;
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
