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

#include "qdot/effects/rows/sparse_solve.hpp"
#include "qdot/effects/scene_motion.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"

namespace qdot::detail {

template <class Sc>  // whether there are forces whose slopes duals have to find
inline constexpr bool has_other_forces = false;
template <class Sys, class... Effects>
inline constexpr bool has_other_forces<Scene<Sys, Effects...>> =
    (((StateEffect<Effects> || ForceEffect<Effects, Scene<Sys, Effects...>::dof_at_compile_time>)&&!KnowsSlopes<Effects>) || ...);

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
    const Matrix<double, n> M = mass_matrix(scene_, q_, qdot_, t_);
    if constexpr (Sc::has_constraints) {
      const ConstrainedFactors<n, m> factors(M, constraint_jacobian(scene_, q_, qdot_, t_, z_), default_rank_cutoff);
      for (Eigen::Index j = 0; j < y_.size(); ++j)
        write_column(out, j, factors.solution(column_of(dr, j), column_of(dc, j), t_, SceneNames<Sc>{scene_}).qddot);
    } else {
      const Matrix<double, n, columns> solution = solved_with_mass_matrix(scene_.system(), M, dr, t_);
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
      Vector<double, m> rows = column_of(dc, j);
      if (!sparse.factors.solve(sparse.J, column, rows)) return false;
      write_column(out, j, column);
    }
    return true;
  }

  // Jᵀλ = ∂(λ·velocity rows)/∂q̇, for rows of both kinds; backwards where there may be many.
  template <class D>
  Vector<D, n> reactions_of(const Vector<D, n>& x, const Vector<D, n>& v) const {
    const auto sum_of = [&]<class U>(const Vector<U, n>& u) {
      const auto rows = constraint_velocity(scene_, Vector<U, n>(x.template cast<U>()), u, U(D(t_)), z_);
      U sum(0);
      for (Eigen::Index i = 0; i < rows.size(); ++i) sum += lambda_[i] * rows[i];
      return sum;
    };
    if constexpr (n == Dynamic) {
      Tape<D> tape(v.size(), 4 * v.size());
      Vector<Reverse<D>, n> u(v.size());
      for (Eigen::Index i = 0; i < v.size(); ++i) u[i] = tape.variable(i, v[i]);
      std::vector<D> adjoint;
      tape.sweep(sum_of(u), adjoint);
      return Eigen::Map<const Vector<D, n>>(adjoint.data(), v.size());
    } else {
      return gradient(marked<SlopeOfRows>(sum_of), v);
    }
  }

  // The constraints' share of dr, and dc. A direction at a time: it is hardly ever asked for, and sooner compiled.
  template <class DR, class DC>
  void add_constraints(DR& dr, DC& dc) const {
    using D = Dual<double, 1>;
    const Eigen::Index k = dof();
    const Vector<D, n> fixed_a = a_.template cast<D>();
    for (Eigen::Index first = 0; first < 2 * k; first += D::directions) {
      const Vector<D, columns> seeds = seeded<D>(y_, first);
      const Vector<D, n> x = seeds.head(k), v = seeds.segment(k, k);
      const Vector<D, n> Q = reactions_of(x, v);
      const Vector<D, m> c = constraint_acceleration(scene_, x, v, fixed_a, D(t_), z_);
      const Eigen::Index end = std::min<Eigen::Index>(2 * k, first + D::directions);
      for (Eigen::Index j = first; j < end; ++j) {
        const auto d = static_cast<std::size_t>(j - first);
        for (Eigen::Index i = 0; i < k; ++i) dr(i, j) += Q[i].tangent[d];
        for (Eigen::Index i = 0; i < lambda_.size(); ++i) dc(i, j) = -c[i].tangent[d];
      }
    }
  }

  const Sc& scene_;
  double t_;
  Vector<double, columns> y_;
  Vector<double, n> q_, qdot_, a_;
  Vector<double, states> z_;
  Vector<double, m> lambda_;
};

}  // namespace qdot::detail
