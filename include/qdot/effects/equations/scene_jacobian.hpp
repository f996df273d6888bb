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
// (mechanics/derive/traced_jacobian.hpp). What is left goes by nested duals: functors that branch or are no formulas, rows that say what others say,
// numbers that are not finite.

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "qdot/ad/records/reverse.hpp"
#include "qdot/effects/equations/constrained_motion.hpp"
#include "qdot/effects/equations/scene_rows_of.hpp"
#include "qdot/effects/equations/sparse_geometry.hpp"
#include "qdot/effects/rows/columns.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/effects/scene_motion.hpp"
#include "qdot/mechanics/equations/lagrange_terms.hpp"
#include "qdot/mechanics/equations/solve.hpp"
#include "qdot/mechanics/mass_matrix.hpp"

namespace qdot::detail {

/// What is asked of a scene for slopes, beside its rows.
class SceneSlopes : public virtual SceneRows {
 public:
  using Slope = Dual<double, 1>;

  /// q̈ and λ.
  virtual AnySolution motion(double t, const Column& q, const Column& qdot, const Column& z) const = 0;
  /// r ← d/dt(∂L/∂q̇) − ∂L/∂q at q̈ = a, n.
  virtual void write_lagrange_residual(double t, const Slope* q, const Slope* qdot, const Column& a, Slope* r) const = 0;
  /// Q ← the forces of effects, n, and rates ← ż.
  virtual void write_forces(double t, const Slope* q, const Slope* qdot, const Slope* z, Slope* Q, Slope* rates) const = 0;
  /// dr ← dr + Σ λ ∂J and dc ← −∂φ̈, −∂ȧ, at q̈ = a.
  virtual void add_slopes_of_rows(double t, const Column& q, const Column& qdot, const Column& z, const AnySolution& at, Table& dr,
                                  Table& dc) const = 0;
  /// slopes ← ∂q̈ of scenes without constraints, and of large ones by sparse factors; false where constrained_slopes() must see to it.
  virtual bool solved(double t, const Column& q, const Column& qdot, const Column& z, const Table& dr, const Table& dc,
                      Table& slopes) const = 0;
};

/// J ← ∂ẏ/∂y at y = [q; q̇; z]; some of it may not be finite. Nested duals know that a constant has no derivative, however steep the root of it is.
template <class = void>
[[gnu::cold]] void write_scene_jacobian(const SceneSlopes& scene, double t, const Eigen::VectorXd& y, Eigen::Ref<Eigen::MatrixXd> J);

// dr ← dr + the slopes of Jᵀλ = ∂(λ·velocity rows)/∂q̇, for rows of both kinds; backwards, for there may be many coordinates. D is Dual<double, 1>.
template <class D, class Sc>
void add_slopes_of_many_reactions(const Sc& scene, double t, const Column& q, const Column& qdot, const EffectStates<Sc>& z,
                                  const Column& lambda, Table& dr) {
  using U = Reverse<D>;
  const Eigen::Index k = scene.dof();
  for (Eigen::Index j = 0; j < 2 * k; ++j) {
    Vector<D, Dynamic> x = constants<D>(vector_at<Dynamic>(q.data(), k)), v = constants<D>(vector_at<Dynamic>(qdot.data(), k));
    (j < k ? x[j] : v[j - k]).tangent[0] = 1.0;
    Tape<D> tape(k, 4 * k);
    Vector<U, Dynamic> u(k);
    for (Eigen::Index i = 0; i < k; ++i) u[i] = tape.variable(i, v[i]);
    const auto rows = constraint_velocity(scene, converted<U>(x), u, U(D(t)), z);
    U sum(0);
    for (Eigen::Index i = 0; i < rows.size(); ++i) sum += lambda[i] * rows[i];
    std::vector<D> adjoint;
    tape.sweep(sum, adjoint);
    for (Eigen::Index i = 0; i < k; ++i) dr(i, j) += adjoint[static_cast<std::size_t>(i)].tangent[0];
  }
}

/// Those of a scene. Holds a reference to it.
template <class Sc>
class SceneSlopesOf final : public SceneSlopes, public SceneRowsOf<Sc> {
  using Base = SceneRowsOf<Sc>;
  using Base::n, Base::scene_;
  using typename Base::Q;
  using typename Base::Z;
  static constexpr int state_count = Sc::states_at_compile_time;

 public:
  using Slope = SceneSlopes::Slope;

  explicit SceneSlopesOf(const Sc& scene) : Base(scene) {}

  AnySolution motion(double t, const Column& q, const Column& qdot, const Column& z) const override {
    AnySolution at;
    if constexpr (Sc::has_constraints) {
      const auto found = constrained_acceleration(scene_, Base::template at<Q>(q), Base::template at<Q>(qdot), t, Base::template at<Z>(z));
      at.qddot = found.qddot;
      at.lambda = found.lambda;
    } else {
      at.qddot = qdot::acceleration(scene_, Base::template at<Q>(q), Base::template at<Q>(qdot), t, Base::template at<Z>(z));
    }
    return at;
  }

  void write_lagrange_residual(double t, const Slope* q, const Slope* qdot, const Column& a, Slope* r) const override {
    const Eigen::Index k = scene_.dof();
    const Vector<Slope, n> found =
        lagrange_residual<n>(scene_.system().energies(), vector_at<n>(q, k), vector_at<n>(qdot, k), converted<Slope>(vector_at<n>(a.data(), k)), Slope(t));
    std::copy_n(found.data(), k, r);
  }

  void write_forces([[maybe_unused]] double t, [[maybe_unused]] const Slope* q, [[maybe_unused]] const Slope* qdot, [[maybe_unused]] const Slope* z,
                    [[maybe_unused]] Slope* forces, [[maybe_unused]] Slope* rates) const override {
    if constexpr (Sc::has_forces || state_count > 0) {
      const Eigen::Index k = scene_.dof();
      const Vector<Slope, n> x = vector_at<n>(q, k), v = vector_at<n>(qdot, k);
      const Vector<Slope, state_count> w = vector_at<state_count>(z, state_count);
      if constexpr (Sc::has_forces) {
        const Vector<Slope, n> sum = effect_forces(scene_, x, v, w, Slope(t));
        std::copy_n(sum.data(), k, forces);
      }
      if constexpr (state_count > 0) {
        const Vector<Slope, state_count> found = state_rates(scene_, x, v, w, Slope(t));
        std::copy_n(found.data(), state_count, rates);
      }
    }
  }

  void add_slopes_of_rows([[maybe_unused]] double t, [[maybe_unused]] const Column& q, [[maybe_unused]] const Column& qdot,
                          [[maybe_unused]] const Column& z, [[maybe_unused]] const AnySolution& at, [[maybe_unused]] Table& dr,
                          [[maybe_unused]] Table& dc) const override {
    if constexpr (Sc::has_constraints) {
      this->write_slopes_of_accelerations(t, q, qdot, at.qddot, z, dc);
      if constexpr (n == Dynamic) add_slopes_of_many_reactions<Slope>(scene_, t, q, qdot, Base::template at<Z>(z), at.lambda, dr);
      else this->add_slopes_of_reactions(t, q, qdot, at.lambda, z, dr);
    }
  }

  bool solved([[maybe_unused]] double t, [[maybe_unused]] const Column& q, [[maybe_unused]] const Column& qdot,
              [[maybe_unused]] const Column& z, [[maybe_unused]] const Table& dr, [[maybe_unused]] const Table& dc,
              [[maybe_unused]] Table& slopes) const override {
    if constexpr (!Sc::has_constraints) {
      Matrix<double, n, Dynamic> right(dr.rows(), dr.cols());
      for (Eigen::Index j = 0; j < dr.cols(); ++j)
        for (Eigen::Index i = 0; i < dr.rows(); ++i) right(i, j) = dr(i, j);
      const Q x = Base::template at<Q>(q), v = Base::template at<Q>(qdot);
      right = solved_with_mass_matrix(scene_.system(), qdot::mass_matrix(scene_.system(), x, v, t), right, t);
      for (Eigen::Index j = 0; j < dr.cols(); ++j)
        for (Eigen::Index i = 0; i < dr.rows(); ++i) slopes(i, j) = right(i, j);
      return true;
    }
    if constexpr (may_be_sparse<Sc>) {
      SparseSystem sparse;
      const Eigen::VectorXd x = vector_at<Dynamic>(q.data(), q.size()), v = vector_at<Dynamic>(qdot.data(), qdot.size());
      if (!sparse.compute(scene_, x, v, t, Base::template at<Z>(z), default_rank_cutoff)) return false;
      for (Eigen::Index j = 0; j < dr.cols(); ++j) {
        Eigen::VectorXd column = vector_at<Dynamic>(dr.data() + j * dr.rows(), dr.rows()), rows = vector_at<Dynamic>(dc.data() + j * dc.rows(), dc.rows());
        if (!sparse.factors->solve(sparse.J, column, rows)) return false;
        std::copy_n(column.data(), column.size(), slopes.data() + j * dr.rows());
      }
      return true;
    }
    return false;
  }
};

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template void write_scene_jacobian<void>(const SceneSlopes&, double, const Eigen::VectorXd&, Eigen::Ref<Eigen::MatrixXd>);
}  // namespace qdot::detail
#else
#include "qdot/effects/equations/scene_jacobian.ipp"
#endif
