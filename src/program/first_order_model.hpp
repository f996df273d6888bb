#pragma once
// SPDX-License-Identifier: MIT
//
// A model of a scene as what integrates it wants it: all scenes are one type there.

#include <memory>
#include <string>

#include <Eigen/Core>

#include "program/runnable_scene.hpp"
#include "qdot/integrate/watch/held_watch.hpp"

namespace qdot::program {

/// A model as the steppers want it: a value with the members of FirstOrderSystem.
struct FirstOrderModel {
  static constexpr int size_at_compile_time = Dynamic;
  using Watchdog = qdot::detail::HeldWatch;
  std::shared_ptr<const Model> model;

  std::unique_ptr<qdot::detail::AnyWatch> watch(const Options& options) const { return model->watch(options); }

  Eigen::Index dof() const { return model->dof(); }
  Eigen::Index size() const { return model->size(); }
  void derivative(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) const {
    model->derivative(t, y, ydot);
  }
  void jacobian(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::MatrixXd> J) const {
    model->jacobian(t, y, J);
  }
  std::string component_name(Eigen::Index i) const { return model->component_name(i); }
};

}  // namespace qdot::program
