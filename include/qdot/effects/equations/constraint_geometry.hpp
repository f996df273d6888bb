#pragma once
// SPDX-License-Identifier: MIT
//
// M and J at a state, factored for questions about displacements: which is the smallest that takes a residual away?
//
//     minimize δᵀM δ   subject to   J δ = r
//
// Scenes with n known to the compiler ask dense factors. Those with n known at run time, which may be large, ask sparse ones first
// (effects/equations/sparse_geometry.hpp).

#include <Eigen/Core>
#include <memory>

#include "qdot/effects/equations/scene_rows.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"

namespace qdot {

/// How near to singular the matrices of a scene with constraints are.
struct Conditioning {
  double mass = 1.0;         ///< smallest pivot of M, scaled to unit diagonal
  double constraints = 1.0;  ///< the same of J M⁻¹ Jᵀ; 1 where no constraint holds, or M is singular by itself
  Eigen::Index weakest_constraint = 0;  ///< the row of that pivot
};

namespace detail {

/// M and J of a scene at one place after another, with the same velocities.
class ConstraintGeometry {
 public:
  using VectorXd = Eigen::VectorXd;

  virtual ~ConstraintGeometry() = default;
  /// @param kept  1 for rows that count, 0 for those that do not; nothing: all
  virtual void move_to(const VectorXd& q, const VectorXd& qdot, const VectorXd& z, const VectorXd* kept = nullptr) = 0;
  /// @throws NonFinite  with the constraint whose rows are not finite
  virtual void require_finite() const = 0;
  /// The smallest δ with J δ = r in the metric of M.
  virtual VectorXd displacement(const VectorXd& r) = 0;
  /// The same in the metric of Σ (δⱼ/sizeⱼ)².
  virtual VectorXd displacement(const VectorXd& r, const VectorXd& size) = 0;
  virtual Eigen::Index rank() const = 0;
  virtual bool has_dependent_rows() const = 0;
  /// Σⱼ |Jᵢⱼ| xⱼ for x ≥ 0.
  virtual double reach(Eigen::Index row, const VectorXd& x) const = 0;
  virtual double length(Eigen::Index row) const = 0;
};

/// That by dense factors. Refers to the rows.
///
/// @param cutoff  relative size below which a row of J counts as dependent
template <class = void>
std::unique_ptr<ConstraintGeometry> dense_geometry(const SceneRows& rows, double t, double cutoff);

/// The same with J and M that are known.
template <class = void>
std::unique_ptr<ConstraintGeometry> dense_geometry(const SceneRows& rows, double t, double cutoff, Eigen::MatrixXd M, Eigen::MatrixXd J);

template <class = void>
Conditioning dense_conditioning(const SceneRows& rows, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& z);

}  // namespace detail
}  // namespace qdot

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template std::unique_ptr<ConstraintGeometry> dense_geometry<void>(const SceneRows&, double, double);
extern template std::unique_ptr<ConstraintGeometry> dense_geometry<void>(const SceneRows&, double, double, Eigen::MatrixXd, Eigen::MatrixXd);
extern template Conditioning dense_conditioning<void>(const SceneRows&, double, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&);
}  // namespace qdot::detail
#else
#include "qdot/effects/equations/constraint_geometry.ipp"
#endif
