#pragma once
// SPDX-License-Identifier: MIT
//
// A scene as the choice of phases sees it: its rows (effects/equations/scene_rows.hpp), and how it moves.

#include <Eigen/Core>
#include <memory>

#include "qdot/effects/equations/scene_rows_of.hpp"
#include "qdot/effects/projection.hpp"
#include "qdot/effects/rows/columns.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/effects/scene_motion.hpp"

namespace qdot::detail {

/// What the choice of phases asks.
class SwitchingScene : public virtual SceneRows {
 public:
  using VectorXd = Eigen::VectorXd;
  struct Forces {
    VectorXd lambda;
    Eigen::Index rank = 0;  // of the rows that are active
  };
  virtual VectorXd acceleration(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z) const = 0;
  virtual VectorXd acceleration_without_lines(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z) const = 0;
  virtual Forces forces(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z) const = 0;
  virtual Forces forces_without_lines(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z) const = 0;
  virtual std::unique_ptr<ConstraintGeometry> geometry(double t) const = 0;
  void project(double t, VectorXd& q, VectorXd& qdot, const VectorXd& z) const {
    Column x(q), v(qdot);
    projected(*this, *geometry(t), x, v, t, z);
    q = x;
    qdot = v;
  }
};

/// That of a scene. Holds a reference to it.
template <class Sc>
class SwitchingSceneOf final : public SwitchingScene, public SceneRowsOf<Sc> {
  using Base = SceneRowsOf<Sc>;
  using typename Base::Q;
  using typename Base::Z;
  using Base::scene_;

 public:
  using VectorXd = Eigen::VectorXd;

  explicit SwitchingSceneOf(const Sc& scene) : Base(scene) {}

  VectorXd acceleration(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z) const override {
    return qdot::acceleration(scene_, Q(q), Q(qdot), t, Z(z));
  }
  VectorXd acceleration_without_lines(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z) const override {
    return qdot::detail::acceleration_without_lines(scene_, Q(q), Q(qdot), t, Z(z));
  }
  Forces forces(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z) const override {
    const auto solution = constrained_acceleration(scene_, Q(q), Q(qdot), t, Z(z));
    return {solution.lambda, solution.rank};
  }
  Forces forces_without_lines(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z) const override {
    const auto solution = constrained_without_lines(scene_, Q(q), Q(qdot), t, Z(z), default_rank_cutoff);
    return {solution.lambda, solution.rank};
  }
  std::unique_ptr<ConstraintGeometry> geometry(double t) const override {
    return std::make_unique<GeometryOf<Sc>>(constraint_geometry(scene_, *this, t, default_rank_cutoff));
  }
};

}  // namespace qdot::detail
