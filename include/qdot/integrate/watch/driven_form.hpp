#pragma once
// SPDX-License-Identifier: MIT
//
// A first-order form without its type, as the loop of a run sees it.
//
// Each T, each V and each choice of effects is a type of its own, and what is a template of it the compiler writes anew for each. The method's
// stepper has to be: it evaluates f ten times in a step. The loop around it asks for little, and seldom: names for messages, guards and projections at
// events, and f for the diagnosis of a run that stands still. So the loop, its events and its diagnosis are compiled once, and ask for that by calls
// (driven_form_of.hpp makes them from a form). So does CVODE, whose loop is its own, and which asks for more.

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "qdot/effects/projection_report.hpp"

namespace qdot {
struct Options;
}

namespace qdot::detail {

class AnyWatch;
struct BandedLinearization;  // mechanics/equations/banded_equations.hpp
struct RecordedMotion;       // mechanics/derive/recorded_energies.hpp
template <class Number>
class TracedEquations;  // mechanics/derive/traced_equations.hpp

/// What a run asks of its system. The members are those of FirstOrderSystem, ProjectableSystem and SwitchingSystem.
struct DrivenForm {
  virtual ~DrivenForm() = default;
  virtual Eigen::Index dof() const = 0;
  virtual Eigen::Index size() const = 0;
  virtual void derivative(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) const = 0;
  virtual std::string component_name(Eigen::Index i) const = 0;
  virtual std::unique_ptr<AnyWatch> watch(const Options& options) const = 0;
  virtual std::string what_is_not_finite(double t, const Eigen::VectorXd& y) const = 0;  // T, V, …; empty if unknown
  virtual std::string way_taken() const { return {}; }                                   // how T and V were evaluated; empty if unknown
  virtual bool is_constrained() const = 0;
  virtual ProjectionReport project(double t, Eigen::Ref<Eigen::VectorXd> y) const = 0;
  virtual bool leap(double, Eigen::VectorXd&) const { return false; }  // takes y over a switch right ahead of it, which no step gets over
  virtual Eigen::Index guard_count() const { return 0; }
  virtual void guards(double, const Eigen::VectorXd&, Eigen::Ref<Eigen::VectorXd>) const {}
  virtual void guard_bands(double, const Eigen::VectorXd&, const Eigen::VectorXd&, Eigen::Ref<Eigen::VectorXd>) const {}
  virtual std::string ending(Eigen::Index) const { return {}; }
  virtual std::vector<std::string> switched(double, Eigen::VectorXd&, const std::vector<bool>&, const Eigen::VectorXd&) const { return {}; }
};

/// What a method asks in addition that is compiled once for all systems. All here is inline: what is compiled by itself has nothing to link with.
struct MethodForm : DrivenForm {
  virtual void jacobian(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::MatrixXd> J) const = 0;
  virtual void renew() = 0;  // makes anew what is kept of the functors
  virtual bool jacobian_changes_fast() const { return false; }  // so that none may be kept from one step to the next

  // Where the number of coordinates is known at run time only: the equations as formulas, which few coordinates meet in. Other systems have none,
  // and are not asked further.
  virtual std::shared_ptr<TracedEquations<double>> equations() const { return nullptr; }
  virtual void run_functors(RecordedMotion&) const {}
  virtual void accelerate(double /*t*/, const double* /*y*/, double* /*a*/, double* /*lambda*/) const {}

  // For functors that are no formulas: M, C, K of the motion near y within their band.
  virtual bool has_band() const { return false; }
  virtual std::shared_ptr<BandedLinearization> linearization(double, const Eigen::Ref<const Eigen::VectorXd>&) const { return nullptr; }
};

}  // namespace qdot::detail
