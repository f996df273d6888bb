#pragma once
// SPDX-License-Identifier: MIT
//
// What a run asks of its system (driven_form.hpp), from a form of any type.
//
// Code that asks more of a form without its type derives an interface of its own from MethodForm. The class that answers derives from
// MethodFormOf of that interface, as in AnySystem, or from SparseFormOf, as in the program qdot. CVODE asks MethodForm itself.
//
// A form may hide another one's type, because its methods are to be compiled once for many systems as well. Then it has driven(), the form behind it.
// Where it is more than that form, it has watch(options) instead, which gives the watchdog of the form behind it.

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/effects/projection_report.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/steps/rates.hpp"
#include "qdot/integrate/watch/any_watch.hpp"
#include "qdot/integrate/watch/driven_form.hpp"
#include "qdot/mechanics/energy.hpp"
#include "qdot/mechanics/equations/banded_equations.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot::detail {

// The energies' part in a NaN.
template <class F>
std::string non_finite_energy(const F& system, double t, const Eigen::VectorXd& y) {
  using Behind = BehindForm<F>;
  if constexpr (Behind::is_mechanical) {
    constexpr int n = Behind::System::dof_at_compile_time;
    const auto& mechanical = Behind::system(system);
    const Eigen::Index dof = mechanical.dof();
    const EnergyAt energy = energy_at(mechanical, t, y);
    if (!std::isfinite(energy.T)) return sentence({"T is ", energy.T});
    if (!std::isfinite(energy.V)) return sentence({"V is ", energy.V});
    if (!std::isfinite(energy.h)) return "T is finite, but not its derivative with the velocities";
    const auto [q, qdot] = coordinates_of<n>(y, dof);
    const Vector<double, n> g = general_gradient<n>(mechanical.energies(), q, qdot, t);
    for (Eigen::Index i = 0; i < dof; ++i)
      if (!std::isfinite(g[i])) return sentence({"T and V are finite, but not the derivative of T - V with ", mechanical.coordinate_name(i)});
    if constexpr (Behind::is_scene) return "T, V and their first derivatives are finite, so it is an effect or the mass matrix";
  }
  return (void)system, (void)t, (void)y, std::string();
}

/// What a run asks, of a form; Face is DrivenForm or derived from it, Held the form or a reference to it.
template <class Face, class Held>
class SmoothFormOf : public Face {
 protected:
  using Form = std::remove_cvref_t<Held>;

 public:
  explicit SmoothFormOf(Held form) : form_(std::forward<Held>(form)) {}

  Eigen::Index dof() const override { return qdot::detail::dof(form_); }
  Eigen::Index size() const override { return form_.size(); }
  void derivative(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) const override { form_.derivative(t, y, ydot); }
  std::string component_name(Eigen::Index i) const override { return form_.component_name(i); }
  std::unique_ptr<AnyWatch> watch(const Options& options) const override { return watch_of(form_, options); }
  std::string what_is_not_finite(double t, const Eigen::VectorXd& y) const override { return non_finite_energy(form_, t, y); }
  std::string way_taken() const override {
    if constexpr (requires { form_.way_taken(); }) return form_.way_taken();
    else if constexpr (requires { form_.driven().way_taken(); }) return form_.driven().way_taken();
    else return {};
  }
  bool is_constrained() const override { return has_constraints(form_); }
  bool leap([[maybe_unused]] double t, [[maybe_unused]] Eigen::VectorXd& y) const override {
    if constexpr (requires { form_.leap(t, y); }) return form_.leap(t, y);
    return false;
  }
  ProjectionReport project(double t, Eigen::Ref<Eigen::VectorXd> y) const override { return projected_by(form_, t, y); }

 protected:
  Held form_;
};

template <class Face, class Held>
class SwitchingFormOf : public SmoothFormOf<Face, Held> {
 public:
  using SmoothFormOf<Face, Held>::SmoothFormOf;

  Eigen::Index guard_count() const override { return this->form_.guard_count(); }
  void guards(double t, const Eigen::VectorXd& y, Eigen::Ref<Eigen::VectorXd> g) const override { this->form_.guards(t, y, g); }
  void guard_bands(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& tolerance, Eigen::Ref<Eigen::VectorXd> out) const override {
    this->form_.guard_bands(t, y, tolerance, out);
  }
  std::string ending(Eigen::Index k) const override { return this->form_.ending(k); }
  std::vector<std::string> switched(double t, Eigen::VectorXd& y, const std::vector<bool>& fired, const Eigen::VectorXd& tolerance) const override {
    return this->form_.switched(t, y, fired, tolerance);
  }
};

template <class Face, class Held>
using DrivenFormOf = std::conditional_t<SwitchingSystem<std::remove_cvref_t<Held>>, SwitchingFormOf<Face, Held>, SmoothFormOf<Face, Held>>;

/// The Jacobian in addition, of a copy of the form; Face is MethodForm or derived from it.
template <class Face, class Form>
class MethodFormOf : public DrivenFormOf<Face, Form> {
 public:
  explicit MethodFormOf(Form form) : DrivenFormOf<Face, Form>(std::move(form)) {}

  void jacobian(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::MatrixXd> J) const override { form_.jacobian(t, y, J); }
  void renew() override { detail::renew(form_); }
  bool jacobian_changes_fast() const override {
    if constexpr (requires { form_.driven().jacobian_changes_fast(); }) return form_.driven().jacobian_changes_fast();
    else return requires { requires Form::jacobian_changes_fast; };
  }

 protected:
  using DrivenFormOf<Face, Form>::form_;
};

/// All that a method asks, for systems whose Newton equations may be solved as sparse or banded.
template <class Face, class Form>
class SparseFormOf : public MethodFormOf<Face, Form> {
  static constexpr bool is_traced = requires(const Form& form, RecordedMotion& motion) { form.run_functors(motion); };
  static constexpr bool is_banded = requires(const Form& form, const Eigen::Ref<const Eigen::VectorXd>& y) { form.linearization(0.0, y); };
  static constexpr bool is_hidden = requires(const Form& form) { form.driven().equations(); };

 public:
  /// Whether a system of the type may have equations that few coordinates meet in. A class that hides a type declares may_be_sparse itself, where the
  /// sparse solvers are worth their compile time.
  static constexpr bool may_be_sparse = is_traced || is_banded || requires { requires Form::may_be_sparse; };

  using MethodFormOf<Face, Form>::MethodFormOf;

  std::shared_ptr<TracedEquations<double>> equations() const override {
    if constexpr (is_hidden) return form_.driven().equations();
    else if constexpr (is_traced) return form_.equations();
    else return nullptr;
  }
  void run_functors([[maybe_unused]] RecordedMotion& motion) const override {
    if constexpr (is_hidden) form_.driven().run_functors(motion);
    else if constexpr (is_traced) form_.run_functors(motion);
  }
  void accelerate([[maybe_unused]] double t, [[maybe_unused]] const double* y, [[maybe_unused]] double* a, [[maybe_unused]] double* lambda) const override {
    if constexpr (is_hidden) form_.driven().accelerate(t, y, a, lambda);
    else if constexpr (is_traced) form_.accelerate(t, y, a, lambda);
  }
  bool has_band() const override {
    if constexpr (is_hidden) return form_.driven().has_band();
    else return is_banded;
  }
  std::shared_ptr<BandedLinearization> linearization([[maybe_unused]] double t, [[maybe_unused]] const Eigen::Ref<const Eigen::VectorXd>& y) const override {
    if constexpr (is_hidden) return form_.driven().linearization(t, y);
    else if constexpr (is_banded) return std::make_shared<BandedLinearization>(form_.linearization(t, y));
    else return nullptr;
  }

 protected:
  using MethodFormOf<Face, Form>::form_;
};

// A form as its run sees it, as long as the form lives.
template <class Form>
decltype(auto) driven_form(const Form& form) {
  if constexpr (requires { form.driven(); }) return (form.driven());
  else return DrivenFormOf<DrivenForm, const Form&>(form);
}

}  // namespace qdot::detail
