#pragma once
// SPDX-License-Identifier: MIT
//
// The rows, masses and forces of a scene of a given type (effects/equations/scene_rows.hpp): what asks its functors for numbers.

#include <Eigen/Core>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/effects/equations/effect_forces.hpp"
#include "qdot/effects/equations/rows_by_duals.hpp"
#include "qdot/effects/equations/scene_rows.hpp"
#include "qdot/effects/rows/constraint_rows.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/mass_matrix.hpp"

namespace qdot::detail {

// visit(k, effect, index in z, row) of each effect that switches.
template <class Sc, class Visit>
void for_each_switching(const Sc& scene, Visit&& visitor) {
  constexpr int n = Sc::dof_at_compile_time;
  Eigen::Index k = 0, zi = 0, row = 0;
  for_each(scene.effects(), [&](const auto& e) {
    using E = std::remove_cvref_t<decltype(e)>;
    if constexpr (SwitchingEffect<E, n>) visitor(k++, e, zi, row);
    zi += states_of<E>();
    row += constraint_rows_of<E, n>();
  });
}

// How many constraints ask for anything.
template <class Sc, class Z>
Eigen::Index asked(const Sc& scene, const Z& z) {
  Eigen::Index count = Sc::constraints_at_compile_time;
  for_each_switching(scene, [&](Eigen::Index, const auto& e, Eigen::Index zi, Eigen::Index) { count -= e.is_active(z[zi]) ? 0 : 1; });
  return count;
}

/// The rows of a scene. Holds a reference to it, and is made for one call.
template <class Sc>
class SceneRowsOf : public RowsByDuals<Sc::dof_at_compile_time> {
  static_assert(!Sc::has_phases || Sc::constraints_at_compile_time != Dynamic,
                "qdot: beside contacts and dry friction every constraint must have a number of rows known at compile time");

 public:
  using VectorXd = Eigen::VectorXd;

  explicit SceneRowsOf(const Sc& scene) : scene_(scene) {
    this->has_lasting_constraints_ = Sc::has_lasting_constraints;
    std::size_t k = 0;
    for_each(scene.effects(), [&](const auto& e) {
      using E = std::remove_cvref_t<decltype(e)>;
      if constexpr (ConstraintEffect<E, n>)
        this->of_positions_.resize(this->of_positions_.size() + static_cast<std::size_t>(rows_of_constraint<E>(scene, k++)), HolonomicEffect<E, n>);
    });
  }

  const std::vector<SwitchingPart>& parts() const override {
    if constexpr (Sc::has_phases)
      if (parts_.empty()) find_parts();
    return parts_;
  }
  VectorXd initial_states() const override { return scene_.initial_states(); }

  double sticking_limit([[maybe_unused]] Eigen::Index part, [[maybe_unused]] double t, [[maybe_unused]] const VectorXd& q,
                        [[maybe_unused]] const VectorXd& qdot) const override {
    double limit = 0.0;
    if constexpr (Sc::has_phases)
      for_each_switching(scene_, [&]([[maybe_unused]] Eigen::Index k, [[maybe_unused]] const auto& e, Eigen::Index, Eigen::Index) {
        if constexpr (!is_contact<decltype(e)>)
          if (k == part) limit = e.sticking_limit(Q(q), Q(qdot), t);
      });
    return limit;
  }
  Eigen::MatrixXd mass_matrix(double t, const VectorXd& q, const VectorXd& qdot) const override {
    return qdot::mass_matrix(scene_.system(), Q(q), Q(qdot), t);
  }
  MassAndRhs<double, Dynamic> mass_and_rhs(double t, const VectorXd& q, const VectorXd& qdot) const override {
    const MassAndRhs<double, n> both = qdot::mass_and_rhs(scene_.system(), Q(q), Q(qdot), t);
    return {both.M, both.r};
  }
  VectorXd applied_forces([[maybe_unused]] double t, [[maybe_unused]] const VectorXd& q, [[maybe_unused]] const VectorXd& qdot,
                  [[maybe_unused]] const VectorXd& z) const override {
    if constexpr (Sc::has_forces) return effect_forces(scene_, Q(q), Q(qdot), Z(z), t);
    else return {};
  }
  void require_finite_forces([[maybe_unused]] double t, [[maybe_unused]] const VectorXd& q, [[maybe_unused]] const VectorXd& qdot,
                             [[maybe_unused]] const VectorXd& z) const override {
    if constexpr (Sc::has_forces) qdot::detail::require_finite_forces(scene_, Q(q), Q(qdot), t, Z(z));
  }
  void require_finite_acceleration(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& a) const override {
    qdot::detail::require_finite_acceleration(scene_, Q(a), Q(q), Q(qdot), t);
  }
  std::vector<std::string> row_names() const override { return constraint_names(scene_); }
  std::vector<std::string> coordinate_names() const override { return qdot::detail::coordinate_names(scene_); }

 protected:
  static constexpr int n = Sc::dof_at_compile_time;
  using Q = Vector<double, n>;
  using Z = EffectStates<Sc>;
  template <class E>
  static constexpr bool is_contact = UnilateralEffect<std::remove_cvref_t<E>, n>;

  const Sc& scene_;

 private:
  using typename RowsByDuals<n>::Number;
  using typename RowsByDuals<n>::Slope;

  Vector<Number, Dynamic> rows_on(const Vector<Number, n>& q, const Vector<Number, n>& qdot, const Number& t, const VectorXd& z) const override {
    return rows_of<Number>(q, qdot, t, z);
  }
  Vector<Slope, Dynamic> rows_on(const Vector<Slope, n>& q, const Vector<Slope, n>& qdot, const Slope& t, const VectorXd& z) const override {
    return rows_of<Slope>(q, qdot, t, z);
  }
  template <class S>
  Vector<S, Dynamic> rows_of(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t, const VectorXd& z) const {
    const auto found = stacked_rows<S>(scene_, t, Z(z), [&](const auto& e) {
      if constexpr (HolonomicEffect<std::remove_cvref_t<decltype(e)>, n>) return as_rows(e.phi(q, t));
      else return as_rows(e.velocity_constraint(q, qdot, t));
    });
    Vector<S, Dynamic> rows(found.size());
    std::copy_n(found.data(), found.size(), rows.data());
    return rows;
  }

  [[gnu::cold]] void find_parts() const {
    parts_.reserve(Sc::phases_at_compile_time);
    for_each_switching(scene_, [&](Eigen::Index, const auto& e, Eigen::Index zi, Eigen::Index row) {
      SwitchingPart part{.state = zi, .row = row, .name = e.name};
      if constexpr (is_contact<decltype(e)>) {
        part.is_contact = true;
        part.ends_run = e.ends_run;
        part.law = e.law;
        part.hits = e.events.hits;
        part.opens = e.events.opens;
        part.rests = e.events.rests;
      }
      parts_.push_back(std::move(part));
    });
  }

  mutable std::vector<SwitchingPart> parts_;  // found when they are first asked for
};

}  // namespace qdot::detail
