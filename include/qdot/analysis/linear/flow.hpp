#pragma once
// SPDX-License-Identifier: MIT
//
// What the analysis of small motions asks of a system, whatever T, V and effects are behind it:
//
//     ẏ = f(t, y) ,   F = ∂f/∂y ,   y = [q; q̇; z]                       of every system
//     φ(q, t) = 0 ,   J q̇ + ∂φ/∂t = 0 ,   a(q, q̇, t) = 0                of one with constraints, and slopes of these
//
// f and F are those that a stepper sees, so the multipliers are eliminated already and F is exact. Behind this
// interface searches for equilibria and linearizations are compiled once, with matrices of run-time size, and not for
// each scene.

#include <exception>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "qdot/analysis/linear/constraints_at.hpp"
#include "qdot/analysis/linear/kinks.hpp"
#include "qdot/effects/input.hpp"
#include "qdot/effects/rows/constraint_rows.hpp"
#include "qdot/effects/scene_form.hpp"

namespace qdot::detail {

class Flow {
 public:
  virtual ~Flow() = default;
  virtual Eigen::Index dof() const = 0;
  virtual Eigen::Index size() const = 0;
  virtual Eigen::VectorXd rates(double t, const Eigen::VectorXd& y) const = 0;
  virtual Eigen::MatrixXd slopes(double t, const Eigen::VectorXd& y) const = 0;
  virtual ConstraintsAt constraints(double t, const Eigen::VectorXd& y) const = 0;
  virtual std::string name(Eigen::Index i) const = 0;  // of a component of y
  virtual std::vector<std::string> constraint_names() const = 0;
  // The sizes of the terms that cancel in q̈ on constraints, n; zero where they are not known.
  virtual Eigen::VectorXd cancelling(double, const Eigen::VectorXd& y) const { return Eigen::VectorXd::Zero(y.size() > 0 ? dof() : 0); }
  virtual std::vector<Eigen::Index> inputs() const { return {}; }  // their places in y
  virtual std::vector<std::string> input_names() const { return {}; }
  virtual std::vector<Eigen::Index> phases() const { return {}; }  // places in y of phases of contacts and friction, which are held
  virtual void require_slopes(const char*, double, const Eigen::VectorXd&) const {}  // throws where f has a kink

  // x = [q; z] of y = [q; q̇; z].
  Eigen::VectorXd unknowns(const Eigen::VectorXd& y) const {
    Eigen::VectorXd x(y.size() - dof());
    x << y.head(dof()), y.tail(y.size() - 2 * dof());
    return x;
  }

  std::string acceleration_name(Eigen::Index i) const {
    return (i < dof() ? "the acceleration of " : "the rate of ") + name(i < dof() ? i : i + dof());
  }
};

// What f gives at another time: `later`, or, where it is refused there, as by a table that ends, earlier, or nearer; nothing where only t will do.
template <class F>
auto elsewhere_in_time(double t, double later, const F& f) -> std::optional<decltype(f(t))> {
  for (double distance = later; distance > 1e-6 * later; distance *= 0.125)
    for (const double side : {1.0, -1.0}) {
      try {
        auto there = f(t + side * distance);
        if (there.allFinite()) return there;
      } catch (const std::exception&) {  // not a moment that the scene knows
      }
    }
  return std::nullopt;
}

// Of what has the members of a first-order form.
template <class Form>
class FlowOfForm : public Flow {
 public:
  explicit FlowOfForm(Form form) : form_(std::forward<Form>(form)) {}

  Eigen::Index size() const override { return form_.size(); }
  Eigen::VectorXd rates(double t, const Eigen::VectorXd& y) const override {
    Eigen::VectorXd f(y.size());
    form_.derivative(t, y, f);
    return f;
  }
  Eigen::MatrixXd slopes(double t, const Eigen::VectorXd& y) const override {
    Eigen::MatrixXd F(y.size(), y.size());
    form_.jacobian(t, y, F);
    return F;
  }
  std::string name(Eigen::Index i) const override { return form_.component_name(i); }

 protected:
  Form form_;  // or a reference to one
};

// The constraints of a scene at a state; empty where it has none.
template <class Sc>
ConstraintsAt constraints_at([[maybe_unused]] const Sc& scene, [[maybe_unused]] double t,
                             [[maybe_unused]] const Eigen::Ref<const Eigen::VectorXd>& y) {
  ConstraintsAt all;
  if constexpr (Sc::has_constraints) {
    constexpr int n = Sc::dof_at_compile_time;
    using D = Dual<double, 1, RateOfRows>;  // which the accelerations of constraints use, too: nothing more to compile
    const Eigen::Index k = scene.dof();
    const EffectStates<Sc> z = y.template tail<Sc::states_at_compile_time>();
    all.phi = constraint_residual(scene, Vector<double, n>(y.head(k)), t, z);
    all.velocity.resize(all.phi.size());
    all.slopes.resize(all.phi.size(), 2 * k);
    Vector<D, n> q = y.head(k).template cast<D>(), qdot = y.segment(k, k).template cast<D>();
    for (Eigen::Index j = 0; j < 2 * k; ++j) {
      D& seed = j < k ? q[j] : qdot[j - k];
      seed.tangent[0] = 1.0;
      const auto rows = constraint_velocity(scene, q, qdot, D(t), z);
      seed.tangent[0] = 0.0;
      for (Eigen::Index i = 0; i < rows.size(); ++i) {
        all.velocity[i] = rows[i].value;
        all.slopes(i, j) = rows[i].tangent[0];
      }
    }
    std::size_t effect = 0;
    for_each_constraint(scene, z, [&](const auto& e, bool) {
      using E = std::remove_cvref_t<decltype(e)>;
      all.holonomic.insert(all.holonomic.end(), static_cast<std::size_t>(rows_of_constraint<E>(scene, effect++)),
                           HolonomicEffect<E, n>);
    });
  }
  return all;
}

// M⁻¹ (|Jᵀ| |λ|), by the diagonal of M alone where M has no inverse; zero where no constraint acts.
template <class Sc>
Eigen::VectorXd cancelling_accelerations(const Sc& scene, double t, const Eigen::VectorXd& y) {
  constexpr int n = Sc::dof_at_compile_time;
  const Eigen::Index k = scene.dof();
  const Vector<double, n> q = y.head(k), qdot = y.segment(k, k);
  const EffectStates<Sc> z = y.template tail<Sc::states_at_compile_time>();
  if (is_free(scene, z)) return Eigen::VectorXd::Zero(k);
  const Eigen::MatrixXd M = mass_matrix(scene, q, qdot, t), J = constraint_jacobian(scene, q, qdot, t, z);
  const Eigen::VectorXd lambda = constrained_acceleration(scene, q, qdot, t, z).lambda;
  const Eigen::VectorXd forces = J.transpose().cwiseAbs() * lambda.cwiseAbs();
  const Eigen::LLT<Eigen::MatrixXd> factors(M);
  if (succeeded(factors)) return factors.solve(Eigen::MatrixXd::Identity(k, k)).cwiseAbs() * forces;
  Eigen::VectorXd sizes = Eigen::VectorXd::Zero(k);
  for (Eigen::Index i = 0; i < k; ++i)
    if (M(i, i) > 0.0) sizes[i] = forces[i] / M(i, i);
  return sizes;
}

template <class Sc>
class FlowOf final : public FlowOfForm<decltype(first_order_form(std::declval<const Sc&>()))> {
 public:
  explicit FlowOf(const Sc& scene) : FlowOf::FlowOfForm(first_order_form(scene)), scene_(scene) {
    for_each(scene.effects(), []<class E>(const E&) {
      static_assert(
          !requires { E::interpolated_inputs; },
          "qdot: equilibria and linearizations hold their inputs: put input(…) in place of interpolated(input(…))");
    });
  }

  Eigen::Index dof() const override { return scene_.dof(); }
  ConstraintsAt constraints(double t, const Eigen::VectorXd& y) const override { return constraints_at(scene_, t, y); }
  Eigen::VectorXd cancelling(double t, const Eigen::VectorXd& y) const override {
    if constexpr (Sc::has_constraints) return cancelling_accelerations(scene_, t, y);
    else return FlowOf::FlowOfForm::cancelling(t, y);
  }
  std::vector<std::string> constraint_names() const override {
    if constexpr (Sc::has_constraints)
      return qdot::constraint_names(scene_);
    else
      return {};
  }
  void require_slopes(const char* who, double t, const Eigen::VectorXd& y) const override { require_no_kink(who, this->form_, scene_.dof(), t, y); }
  std::vector<Eigen::Index> inputs() const override {
    std::vector<Eigen::Index> places;
    for_each_input(scene_, [&](const auto&, Eigen::Index place, int) { places.push_back(place); });
    return places;
  }
  std::vector<std::string> input_names() const override {
    std::vector<std::string> names;
    for_each_input(scene_, [&](const auto& effect, Eigen::Index, int i) { names.push_back(input_name(effect, i)); });
    return names;
  }
  std::vector<Eigen::Index> phases() const override {
    std::vector<Eigen::Index> places;
    for_each_place(scene_, [&]<class E>(const E&, Eigen::Index place) {
      if constexpr (SwitchingEffect<E, Sc::dof_at_compile_time>)
        for (int i = 0; i < states_of<E>(); ++i) places.push_back(place + i);
    });
    return places;
  }

 private:
  const Sc& scene_;
};

}  // namespace qdot::detail
