#pragma once
// SPDX-License-Identifier: MIT
//
// The Jacobian of a scene at accelerations and multipliers that are known, from first-order slopes of its equations:
//
//     M q̈ − Jᵀλ = r + Q ,    J q̈ + c = 0     with c = φ̈ (or ȧ) at q̈ = 0
//
//     [ M  −Jᵀ ] [∂q̈]     [ ∂(r − M q̈) + ∂Q + Σ λ ∂J ]
//     [ J   0  ] [∂λ]  =  [ −∂φ̈  or  −∂ȧ             ] ,    all of the right side at fixed q̈ and λ.
//
// Where functors are formulas, forms have all of it from the lines of one recording, phases that switch as numbers in it
// (mechanics/derive/traced_jacobian.hpp). What is left goes by nested duals, a direction at a time: functors that branch or are no formulas, rows that say
// what others say, numbers that are not finite.
//
// ∂Q comes from dual numbers, one sweep for up to 16 directions, but of effects that know it themselves, as damping does.

#include <algorithm>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/effects/equations/constrained_motion.hpp"
#include "qdot/effects/equations/scene_rows_of.hpp"
#include "qdot/effects/equations/sparse_geometry.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/effects/rows/sparse_solve.hpp"
#include "qdot/effects/scene_motion.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"

namespace qdot::detail {

template <class Sc>  // whether there are forces whose slopes duals have to find
inline constexpr bool has_other_forces = false;
template <class Sys, class... Effects>
inline constexpr bool has_other_forces<Scene<Sys, Effects...>> =
    (((StateEffect<Effects> || ForceEffect<Effects, Scene<Sys, Effects...>::dof_at_compile_time>)&&!KnowsSlopes<Effects>) || ...);

// dr ← dr + the slopes of Jᵀλ = ∂(λ·velocity rows)/∂q̇, for rows of both kinds; backwards, for there may be many coordinates. D is Dual<double, 1>.
template <class D, class Sc>
void add_slopes_of_many_reactions(const Sc& scene, double t, const Eigen::VectorXd& y, const EffectStates<Sc>& z, const Eigen::VectorXd& lambda,
                                  Eigen::MatrixXd& dr) {
  using U = Reverse<D>;
  const Eigen::Index k = scene.dof();
  for (Eigen::Index j = 0; j < 2 * k; ++j) {
    const Vector<D, Dynamic> seeds = seeded<D>(y, j), x = seeds.head(k), v = seeds.segment(k, k);
    Tape<D> tape(k, 4 * k);
    Vector<U, Dynamic> u(k);
    for (Eigen::Index i = 0; i < k; ++i) u[i] = tape.variable(i, v[i]);
    const auto rows = constraint_velocity(scene, Vector<U, Dynamic>(x.template cast<U>()), u, U(D(t)), z);
    U sum(0);
    for (Eigen::Index i = 0; i < rows.size(); ++i) sum += lambda[i] * rows[i];
    std::vector<D> adjoint;
    tape.sweep(sum, adjoint);
    for (Eigen::Index i = 0; i < k; ++i) dr(i, j) += adjoint[static_cast<std::size_t>(i)].tangent[0];
  }
}

template <class Sc>
class SceneJacobian {
  static constexpr int n = Sc::dof_at_compile_time;
  static constexpr int states = Sc::states_at_compile_time;
  static constexpr int m = Sc::constraints_at_compile_time;
  static constexpr int columns = n == Dynamic ? Dynamic : 2 * n + states;
  using Out = Eigen::Ref<Eigen::MatrixXd>;

 public:
  SceneJacobian(const Sc& scene, double t, const Eigen::Ref<const Eigen::VectorXd>& y)
      : scene_(scene), t_(t), y_(y), q_(vector_at<n>(y.data(), scene.dof())),
        qdot_(vector_at<n>(y.data() + scene.dof(), scene.dof())),
        z_(Eigen::Map<const Vector<double, states>>(y.data() + 2 * scene.dof(), states)) {
    const Vector<double, states> z = z_;  // z_ may have no entries, and the compiler wonders about them
    if constexpr (Sc::has_constraints) {
      auto solution = constrained_acceleration(scene_, q_, qdot_, t_, z);
      a_ = std::move(solution.qddot);
      lambda_ = std::move(solution.lambda);
    } else {
      a_ = qdot::acceleration(scene_, q_, qdot_, t_, z);
    }
  }

  /// J ← ∂ẏ/∂y; some of it may not be finite. Nested duals know that a constant has no derivative, however steep the root of it is.
  [[gnu::cold, gnu::noinline]] void write(Out out) const {
    begin(out);
    const Eigen::Index k = dof();
    Matrix<double, n, columns> dr = zeros<Matrix<double, n, columns>>(k, y_.size());               // of the upper right side
    Matrix<double, m, columns> dc = zeros<Matrix<double, m, columns>>(lambda_.size(), y_.size());  // and of the lower
    const auto& energies = scene_.system().energies();
    using D = Dual<double, 1>;
    Vector<D, n> x = constants<D>(q_), v = constants<D>(qdot_);
    const Vector<D, n> fixed_a = constants<D>(a_);
    for (Eigen::Index j = 0; j < 2 * k; ++j) {
      D& seed = j < k ? x[j] : v[j - k];
      seed.tangent[0] = 1.0;
      const Vector<D, n> r = lagrange_residual<n>(energies, x, v, fixed_a, D(t_));
      for (Eigen::Index i = 0; i < k; ++i) dr(i, j) = -r[i].tangent[0];
      seed.tangent[0] = 0.0;
    }
    struct Entries {
      Matrix<double, n, columns>& all;
      auto operator[](Eigen::Index i) const { return all.row(i); }
    };
    add_forces(Entries{dr}, &out);
    if constexpr (Sc::has_constraints) add_constraints(dr, dc);
    if constexpr (may_be_sparse<Sc>) {
      if (solved_sparsely(dr, dc, out)) return;
    }
    if constexpr (Sc::has_constraints) {
      const Eigen::MatrixXd slopes = constrained_slopes(SceneRowsOf<Sc>(scene_), t_, q_, qdot_, z_, dr, dc);
      for (Eigen::Index j = 0; j < y_.size(); ++j)
        for (Eigen::Index i = 0; i < k; ++i) out(k + i, j) = slopes(i, j);
    } else {
      const Matrix<double, n, columns> solution = solved_with_mass_matrix(scene_.system(), mass_matrix(scene_, q_, qdot_, t_), dr, t_);
      for (Eigen::Index j = 0; j < y_.size(); ++j) write_column(out, j, column_of(solution, j));
    }
  }

 private:
  Eigen::Index dof() const { return q_.size(); }

  void begin(Out J) const {
    J.setZero();
    for (Eigen::Index i = 0; i < dof(); ++i) J(i, dof() + i) = 1.0;
  }

  // Adds ∂Q to rows, and writes ∂ż to J, if there is a state.
  template <class Rows>
  void add_forces(Rows&& rows, [[maybe_unused]] Out* J) const {
    for_each(scene_.effects(), [&](const auto& e) {
      if constexpr (KnowsSlopes<std::remove_cvref_t<decltype(e)>>) e.add_slopes(rows);
    });
    if constexpr (has_other_forces<Sc> || Sc::has_states) {
      using D = Dual<double, directions_for<columns>>;
      const Eigen::Index k = dof();
      for (Eigen::Index first = 0; first < y_.size(); first += D::directions) {
        const Vector<D, columns> seeds = seeded<D>(y_, first);
        const Vector<D, n> x = seeds.head(k), v = seeds.segment(k, k);
        const Vector<D, states> w = seeds.template tail<states>();
        Vector<D, n> Q = zeros<Vector<D, n>>(k);
        Vector<D, states> rate;
        if constexpr (has_other_forces<Sc>) Q = summed_forces<ForceSum::unknown_slopes>(scene_, x, v, w, D(t_));
        if constexpr (Sc::has_states) rate = state_rates(scene_, x, v, w, D(t_));
        const Eigen::Index end = std::min<Eigen::Index>(y_.size(), first + D::directions);
        for (Eigen::Index j = first; j < end; ++j) {
          const auto d = static_cast<std::size_t>(j - first);
          for (Eigen::Index i = 0; i < k; ++i) rows[i][j] += Q[i].tangent[d];
          if constexpr (Sc::has_states)
            for (Eigen::Index i = 0; i < states; ++i) (*J)(2 * k + i, j) = rate[i].tangent[d];
        }
      }
    }
  }

  template <int rows, int any>
  static Vector<double, rows> column_of(const Matrix<double, rows, any>& A, Eigen::Index j) {
    return Eigen::Map<const Vector<double, rows>>(A.data() + j * A.rows(), A.rows());
  }
  // Column j of ∂q̈.
  void write_column(Out& out, Eigen::Index j, const Vector<double, n>& column) const {
    for (Eigen::Index i = 0; i < dof(); ++i) out(dof() + i, j) = column[i];
  }

  // Each column of ∂q̈ from sparse factors; false where they see to nothing.
  template <class DR, class DC>
  bool solved_sparsely(const DR& dr, const DC& dc, Out out) const {
    SparseSystem sparse;
    if (!sparse.compute(scene_, q_, qdot_, t_, z_, default_rank_cutoff)) return false;
    for (Eigen::Index j = 0; j < y_.size(); ++j) {
      Vector<double, n> column = column_of(dr, j);
      Eigen::VectorXd rows = column_of(dc, j);
      if (!sparse.factors->solve(sparse.J, column, rows)) return false;
      write_column(out, j, column);
    }
    return true;
  }

  // The constraints' share of dr, and dc.
  template <class DR, class DC>
  void add_constraints(DR& dr, DC& dc) const {
    const SceneRowsOf<Sc> rows(scene_);
    Eigen::MatrixXd slopes = dr, of_rows = dc;
    rows.write_slopes_of_accelerations(t_, q_, qdot_, a_, z_, of_rows);
    if constexpr (n == Dynamic) add_slopes_of_many_reactions<Dual<double, 1>>(scene_, t_, y_, z_, lambda_, slopes);
    else rows.add_slopes_of_reactions(t_, q_, qdot_, lambda_, z_, slopes);
    dr = slopes;
    dc = of_rows;
  }

  const Sc& scene_;
  double t_;
  Vector<double, columns> y_;
  Vector<double, n> q_, qdot_, a_;
  Vector<double, states> z_;
  Vector<double, m> lambda_;
};

}  // namespace qdot::detail
