#pragma once
// SPDX-License-Identifier: MIT
//
// Variational equations as a system that methods take.

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "qdot/analysis/variations/equations.hpp"

namespace qdot::detail {

// What besides events may change a state between steps: projections, and with them the phases of contacts and friction.
enum class Changes { none, projections, phases };

// [y; columns of Φ] as a first-order system. Models FirstOrderSystem; where it may, ProjectableSystem and SwitchingSystem, too.
template <Changes changes>
class VariationalForm;
template <>
class VariationalForm<Changes::none> {
 public:
  static constexpr int size_at_compile_time = Eigen::Dynamic;
  static constexpr int dof_at_compile_time = Eigen::Dynamic;

  explicit VariationalForm(VariationalEquations& equations) : equations_(&equations) {}

  VariationalEquations& equations() const noexcept { return *equations_; }
  Eigen::Index size() const noexcept { return equations_->size(); }
  Eigen::Index dof() const noexcept { return equations_->dof(); }
  void renew() { equations_->renew(); }
  bool leap(double t, Eigen::VectorXd& both) const { return equations_->leap && equations_->leap(t, both); }

  std::unique_ptr<AnyWatch> watch(const Options& options) const { return equations_->watch(options); }

  void write_derivative(double t, const double* y, double* ydot) const { equations_->write_rates(t, y, ydot); }
  // Rates of second derivatives are left out: series have their own, and events ask for those of y.
  void derivative(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) const {
    ydot.tail(equations_->state_size() * equations_->pairs).setZero();
    equations_->write_rates(t, y.data(), ydot.data());
  }
  // ∂f/∂y for y and for each column of Φ. That ∂f/∂y changes with y is left out. An implicit method's iteration converges all the same, for y's own
  // part is whole, and its limit does not depend on J.
  void jacobian(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::MatrixXd> J) const {
    const Eigen::Index n = equations_->state_size();
    J.setZero();
    equations_->write_state_jacobian(t, y.data(), J.topLeftCorner(n, n));
    for (Eigen::Index j = 1; j <= equations_->columns(); ++j) J.block(n * j, n * j, n, n) = J.topLeftCorner(n, n);
  }

  std::string component_name(Eigen::Index i) const {
    const Eigen::Index n = equations_->state_size();
    if (i < n) return equations_->state_name(i);
    Eigen::Index a = i / n - 1, b = 0;
    const Eigen::Index columns = equations_->columns();
    if (a < columns) return sentence({"the derivative of ", equations_->state_name(i % n), " with respect to ", equations_->column_name(a)});
    for (b = a - columns, a = 0; b >= columns - a; ++a) b -= columns - a;
    return sentence({"the second derivative of ", equations_->state_name(i % n), " with respect to ", equations_->column_name(a), " and ",
                     equations_->column_name(a + b)});
  }

 protected:
  VariationalEquations* equations_;
};
template <>
class VariationalForm<Changes::projections> : public VariationalForm<Changes::none> {
 public:
  using VariationalForm<Changes::none>::VariationalForm;
  ProjectionReport project(double t, Eigen::Ref<Eigen::VectorXd> y) const { return equations_->project(t, y); }
};
template <>
class VariationalForm<Changes::phases> : public VariationalForm<Changes::projections> {
 public:
  using VariationalForm<Changes::projections>::VariationalForm;
  Eigen::Index guard_count() const { return equations_->guard_count(); }
  std::string ending(Eigen::Index k) const { return equations_->ending(k); }
  void guards(double t, const Eigen::VectorXd& y, Eigen::Ref<Eigen::VectorXd> g) const { equations_->guards(t, y, g); }
  void guard_bands(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& tolerance, Eigen::Ref<Eigen::VectorXd> g) const {
    equations_->guard_bands(t, y, tolerance, g);
  }
  std::vector<std::string> switched(double t, Eigen::VectorXd& y, const std::vector<bool>& fired, const Eigen::VectorXd& tolerance) const {
    return equations_->switched(t, y, fired, tolerance);
  }
};

// The form where the compiler knows how many components there are: sums of stages without a loop. For explicit methods, which ask for nothing else.
template <Changes changes, int size_>
class SizedVariationalForm : public VariationalForm<changes> {
 public:
  static constexpr int size_at_compile_time = size_;
  using VariationalForm<changes>::VariationalForm;
  Eigen::Index size() const noexcept { return size_; }
};

}  // namespace qdot::detail
