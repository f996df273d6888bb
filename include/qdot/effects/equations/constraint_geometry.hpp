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
#include <optional>
#include <type_traits>

#include "qdot/effects/equations/scene_rows.hpp"
#include "qdot/effects/rows/columns.hpp"
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
  virtual ~ConstraintGeometry() = default;
  /// @param kept  1 for rows that count, 0 for those that do not; nothing: all
  virtual void move_to(const Column& q, const Column& qdot, const Column& z, const Column* kept = nullptr) = 0;
  /// @throws NonFinite  with the constraint whose rows are not finite
  virtual void require_finite() const = 0;
  /// The smallest δ with J δ = r in the metric of M.
  virtual Column displacement(const Column& r) = 0;
  /// The smallest δ with J δ = r in the metric of Σ (δⱼ/sizeⱼ)².
  virtual Column displacement(const Column& r, const Column& size) = 0;
  virtual Eigen::Index rank() const = 0;
  virtual bool has_dependent_rows() const = 0;
  /// Σⱼ |Jᵢⱼ| xⱼ for x ≥ 0.
  virtual double reach(Eigen::Index row, const Column& x) const = 0;
  virtual double length(Eigen::Index row) const = 0;
};

struct NoFace {};

/// That by dense factors. Refers to the rows. No allocation for small scenes whose rows are independent.
///
/// @tparam Sizes  AnySizes; or KnownSizes of scenes that run projects often, and then no face
template <class Sizes = AnySizes>
class DenseGeometry final : public std::conditional_t<std::is_same_v<Sizes, AnySizes>, ConstraintGeometry, NoFace> {
  using N = typename Sizes::N;
  using M = typename Sizes::M;

 public:
  /// @param cutoff  relative size below which a row of J counts as dependent
  DenseGeometry(const SceneRows& rows, double t, double cutoff) : rows_(rows), t_(t), cutoff_(cutoff) {}

  void move_to(const N& q, const N& qdot, const Column& z, const M* kept = nullptr);
  void factor(const typename Sizes::NN& mass, const typename Sizes::MN& J);
  void require_finite() const;
  N displacement(const M& r);
  N displacement(const M& r, const N& size);
  Eigen::Index rank() const;
  bool has_dependent_rows() const;
  double reach(Eigen::Index row, const N& x) const;
  double length(Eigen::Index row) const;

 private:
  const SceneRows& rows_;
  double t_, cutoff_;
  typename Sizes::MN J_;
  std::optional<FactorsOf<Sizes>> factors_;
};

/// Conditioning of a scene by dense factors, in phases in which it is free or not.
template <class Sizes>
Conditioning dense_conditioning(const SceneRows& rows, double t, const double* q, const double* qdot, const double* z, bool is_free);

}  // namespace detail
}  // namespace qdot

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template class DenseGeometry<AnySizes>;
extern template Conditioning dense_conditioning<AnySizes>(const SceneRows&, double, const double*, const double*, const double*, bool);
extern template Conditioning dense_conditioning<KnownSizes<1, 1>>(const SceneRows&, double, const double*, const double*, const double*, bool);
extern template Conditioning dense_conditioning<KnownSizes<2, 1>>(const SceneRows&, double, const double*, const double*, const double*, bool);
extern template Conditioning dense_conditioning<KnownSizes<2, 2>>(const SceneRows&, double, const double*, const double*, const double*, bool);
extern template Conditioning dense_conditioning<KnownSizes<3, 1>>(const SceneRows&, double, const double*, const double*, const double*, bool);
extern template Conditioning dense_conditioning<KnownSizes<3, 2>>(const SceneRows&, double, const double*, const double*, const double*, bool);
extern template Conditioning dense_conditioning<KnownSizes<4, 1>>(const SceneRows&, double, const double*, const double*, const double*, bool);
extern template Conditioning dense_conditioning<KnownSizes<4, 2>>(const SceneRows&, double, const double*, const double*, const double*, bool);
}  // namespace qdot::detail
#else
#include "qdot/effects/equations/constraint_geometry.ipp"
#endif
