#pragma once
// SPDX-License-Identifier: MIT
//
// ydot = f(t, y) without the type of the system, as a one-step method evaluates it.
//
// A method's step depends on the number of components only. So steppers are templates of that number, and call f through a table: one or two
// nanoseconds beside the tens that f takes. A user's T, V and effects make the compiler write this small class anew, and no stepper.

#include <Eigen/Core>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "qdot/effects/projection_report.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot::detail {

/// What a one-step method asks of its system.
struct Rates {
  virtual ~Rates() = default;
  virtual Eigen::Index size() const = 0;
  virtual void derivative(double t, const double* y, double* ydot) const = 0;  // size() numbers each
  virtual std::string component_name(Eigen::Index i) const = 0;
  virtual void renew() = 0;  // makes anew what is kept of the functors
  virtual bool is_constrained() const = 0;
  virtual ProjectionReport project(double t, Eigen::Ref<Eigen::VectorXd> y) const = 0;  // nothing where there are no constraints
  // Holds evaluations on the branch that functors have at y, beyond its guards as well, until renew() or leave_branch(); false where none is held.
  virtual bool hold_branch(double, const double*) const { return false; }
  virtual void leave_branch() const {}
};

/// y put back onto the constraints of a form, if it has some.
template <class Form>
ProjectionReport projected_by([[maybe_unused]] const Form& form, [[maybe_unused]] double t, [[maybe_unused]] Eigen::Ref<Eigen::VectorXd> y) {
  if constexpr (!ProjectableSystem<Form>) {
    return {};
  } else if constexpr (requires(ProjectionReport& report) { report = form.project(t, y); }) {
    return form.project(t, y);
  } else {
    const auto report = form.project(t, y);
    return {.residual = report.residual, .velocity_residual = report.velocity_residual};
  }
}
template <class Form>
bool has_constraints([[maybe_unused]] const Form& form) {
  if constexpr (requires { form.is_constrained(); }) return form.is_constrained();
  else return ProjectableSystem<Form>;
}

/// The rates of a copy of a form; Face is Rates or derived from it.
template <FirstOrderSystem Form, class Face = Rates>
class RatesOf : public Face {
 public:
  explicit RatesOf(Form form) : form_(std::move(form)) {}

  const Form& form() const noexcept { return form_; }

  Eigen::Index size() const override { return form_.size(); }
  void derivative(double t, const double* y, double* ydot) const override {
    if constexpr (requires { form_.write_derivative(t, y, ydot); }) {
      form_.write_derivative(t, y, ydot);
    } else {
      const Eigen::Index n = form_.size();
      const Eigen::Ref<const Eigen::VectorXd> from(Eigen::Map<const Eigen::VectorXd>(y, n));
      Eigen::Map<Eigen::VectorXd> rates(ydot, n);
      Eigen::Ref<Eigen::VectorXd> to(rates);
      form_.derivative(t, from, to);
    }
  }
  std::string component_name(Eigen::Index i) const override { return form_.component_name(i); }
  void renew() override { qdot::detail::renew(form_); }
  bool hold_branch([[maybe_unused]] double t, [[maybe_unused]] const double* y) const override {
    if constexpr (requires { form_.hold_branch(t, y); }) return form_.hold_branch(t, y);
    return false;
  }
  void leave_branch() const override {
    if constexpr (requires { form_.leave_branch(); }) form_.leave_branch();
  }
  bool is_constrained() const override { return has_constraints(form_); }
  ProjectionReport project(double t, Eigen::Ref<Eigen::VectorXd> y) const override { return projected_by(form_, t, y); }

 protected:
  Form form_;
};

/// The rates of a system, of which a copy is made.
template <FirstOrderSystem Form>
std::unique_ptr<RatesOf<Form>> rates_of(const Form& form) {
  return std::make_unique<RatesOf<Form>>(form);
}

}  // namespace qdot::detail
