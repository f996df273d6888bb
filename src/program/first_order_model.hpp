#pragma once
// SPDX-License-Identifier: MIT
//
// A model of a scene as what integrates it wants it: all scenes are one type there.

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "program/runnable_scene.hpp"
#include "qdot/integrate/watch/driven_form.hpp"

namespace qdot::program {

/// A model as the steppers want it: a value with the members of FirstOrderSystem.
struct FirstOrderModel {
  static constexpr int size_at_compile_time = Dynamic;
  static constexpr bool may_be_sparse = true;  // some scenes are of as many bodies as one asks for
  std::shared_ptr<const Model> model;

  const qdot::detail::MethodForm& driven() const { return *model; }

  Eigen::Index dof() const { return model->dof(); }
  Eigen::Index size() const { return model->size(); }
  void derivative(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) const {
    model->derivative(t, y, ydot);
  }
  void jacobian(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::MatrixXd> J) const {
    model->jacobian(t, y, J);
  }
  std::string component_name(Eigen::Index i) const { return model->component_name(i); }
  /// Places in y of the effects' own states that vary continuously.
  std::vector<Eigen::Index> own_states() const {
    std::vector<Eigen::Index> places;
    const std::vector<OwnState> all = model->own_states();
    for (std::size_t i = 0; i < all.size(); ++i)
      if (all[i].kind == OwnState::state) places.push_back(2 * dof() + static_cast<Eigen::Index>(i));
    return places;
  }
};

/// A model with constraints, which the steppers then keep.
struct ConstrainedModel : FirstOrderModel {
  ProjectionReport project(double t, Eigen::Ref<Eigen::VectorXd> y) const { return model->project(t, y); }
};

/// A model whose constraints switch on and off at events.
struct SwitchingModel : ConstrainedModel {
  Eigen::Index guard_count() const { return model->guard_count(); }
  void guards(double t, const Eigen::VectorXd& y, Eigen::Ref<Eigen::VectorXd> g) const { model->guards(t, y, g); }
  void guard_bands(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& tolerance, Eigen::Ref<Eigen::VectorXd> out) const {
    model->guard_bands(t, y, tolerance, out);
  }
  std::string ending(Eigen::Index k) const { return model->ending(k); }
  std::vector<std::string> switched(double t, Eigen::VectorXd& y, const std::vector<bool>& fired, const Eigen::VectorXd& tolerance) const {
    return model->switched(t, y, fired, tolerance);
  }
};

}  // namespace qdot::program
