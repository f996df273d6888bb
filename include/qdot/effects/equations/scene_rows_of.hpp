#pragma once
// SPDX-License-Identifier: MIT
//
// The rows, masses and forces of a scene of a given type (effects/equations/scene_rows.hpp): what asks its functors for numbers.

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/effects/equations/effect_forces.hpp"
#include "qdot/effects/equations/rows_by_duals.hpp"
#include "qdot/effects/equations/scene_rows.hpp"
#include "qdot/effects/rows/columns.hpp"
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
  for_each_switching(scene, [&](Eigen::Index, const auto& e, Eigen::Index zi, Eigen::Index) {
    count -= e.is_active(z[zi]) ? 0 : constraint_rows_of<std::remove_cvref_t<decltype(e)>, Sc::dof_at_compile_time>();
  });
  return count;
}

/// The rows of a scene, which must outlive them.
template <class Sc>
class SceneRowsOf : public RowsByDuals<size_of_rows<Sc::dof_at_compile_time>> {
  static_assert(!Sc::has_phases || Sc::constraints_at_compile_time != Dynamic,
                "qdot: beside contacts and dry friction every constraint must have a number of rows known at compile time");

 public:
  explicit SceneRowsOf(const Sc& scene) : scene_(scene) {
    this->has_lasting_constraints_ = Sc::has_lasting_constraints;
    this->count_ = Sc::phases_at_compile_time;
    if constexpr (Sc::constraints_at_compile_time == Dynamic) kinds_.resize(static_cast<std::size_t>(scene.row_counts().total));
    else kinds_.resize(Sc::constraints_at_compile_time);
    this->rows_ = static_cast<Eigen::Index>(kinds_.count());
    this->of_positions_ = kinds_.data();
    char* kind = kinds_.data();
    std::size_t k = 0;
    for_each(scene.effects(), [&](const auto& e) {
      using E = std::remove_cvref_t<decltype(e)>;
      if constexpr (ConstraintEffect<E, n>) kind = std::fill_n(kind, rows_of_constraint<E>(scene, k++), static_cast<char>(HolonomicEffect<E, n>));
    });
  }

  Eigen::Index dof() const override { return scene_.dof(); }
  Eigen::Index states() const override { return Sc::states_at_compile_time; }
  Eigen::VectorXd initial_states() const override { return scene_.initial_states(); }

  double sticking_limit(Eigen::Index part, double t, const Column& q, const Column& qdot) const override {
    return of_friction(part, [&](const auto& e) { return e.sticking_limit(at<Q>(q), at<Q>(qdot), t); });
  }
  double sliding_limit(Eigen::Index part, double t, const Column& q, const Column& qdot) const override {
    return of_friction(part, [&](const auto& e) { return e.sliding_limit(at<Q>(q), at<Q>(qdot), t); });
  }
  void write_mass_matrix(double t, const double* q, const double* qdot, double* M) const override {
    const Matrix<double, n> found = qdot::mass_matrix(scene_.system(), vector_at<n>(q, scene_.dof()), vector_at<n>(qdot, scene_.dof()), t);
    std::copy_n(found.data(), found.size(), M);
  }
  void write_mass_and_rhs(double t, const Column& q, const Column& qdot, double* M, double* r) const override {
    const MassAndRhs<double, n> both = qdot::mass_and_rhs(scene_.system(), at<Q>(q), at<Q>(qdot), t);
    std::copy_n(both.M.data(), both.M.size(), M);
    std::copy_n(both.r.data(), both.r.size(), r);
  }
  Column applied_forces([[maybe_unused]] double t, [[maybe_unused]] const Column& q, [[maybe_unused]] const Column& qdot,
                        [[maybe_unused]] const Column& z) const override {
    if constexpr (Sc::has_forces) return effect_forces(scene_, at<Q>(q), at<Q>(qdot), at<Z>(z), t);
    else return {};
  }
  void require_finite_forces([[maybe_unused]] double t, [[maybe_unused]] const Column& q, [[maybe_unused]] const Column& qdot,
                             [[maybe_unused]] const Column& z) const override {
    if constexpr (Sc::has_forces) qdot::detail::require_finite_forces(scene_, at<Q>(q), at<Q>(qdot), t, at<Z>(z));
  }
  void require_finite_acceleration(double t, const Column& q, const Column& qdot, const Column& a) const override {
    qdot::detail::require_finite_acceleration(scene_, at<Q>(a), at<Q>(q), at<Q>(qdot), t);
  }
  std::vector<std::string> row_names() const override { return constraint_names(scene_); }
  std::vector<std::string> coordinate_names() const override { return qdot::detail::coordinate_names(scene_); }

 protected:
  static constexpr int n = Sc::dof_at_compile_time;
  using Q = Vector<double, n>;
  using Z = EffectStates<Sc>;
  template <class E>
  static constexpr bool is_contact = UnilateralEffect<std::remove_cvref_t<E>, n>;

  template <class V>
  static V at(const Column& x) {
    return vector_at<V::RowsAtCompileTime>(x.data(), x.size());
  }

  const Sc& scene_;

 private:
  SmallStore<char, Sc::constraints_at_compile_time == Dynamic ? 0 : static_cast<std::size_t>(Sc::constraints_at_compile_time)> kinds_;

  using Base = RowsByDuals<size_of_rows<n>>;
  using typename Base::Number;

  void write_rows(const Number* q, const Number* qdot, const Number& t, const double* z, Number* out) const override {
    Vector<Number, n> x(scene_.dof()), v(scene_.dof());
    std::copy_n(q, x.size(), x.data());
    std::copy_n(qdot, v.size(), v.data());
    visit_rows(x, v, t, z, [&](const Number& row) { *out++ = row; });
  }
  void write_rows(double t, const double* q, const double* qdot, const double* z, const typename Base::Along& along, double* values,
                  double* slopes) const override {
    using Slope = Dual<double, 1>;
    Vector<Slope, n> x(scene_.dof()), v(scene_.dof());
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      x[i].value = q[i];
      x[i].tangent[0] = along.q ? along.q[i] : 0.0;
      v[i].value = qdot[i];
      v[i].tangent[0] = along.qdot ? along.qdot[i] : 0.0;
    }
    Slope time(t);
    time.tangent[0] = along.t;
    visit_rows(x, v, time, z, [&](const Slope& row) {
      *values++ = row.value;
      *slopes++ = row.tangent[0];
    });
  }

  // φ or a, row by row.
  template <class S, class Visit>
  void visit_rows(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t, const double* z, const Visit& visit) const {
    std::size_t k = 0;
    for_each_constraint(scene_, vector_at<Sc::states_at_compile_time>(z, Sc::states_at_compile_time), [&](const auto& e, bool is_active) {
      using E = std::remove_cvref_t<decltype(e)>;
      const Eigen::Index rows = rows_of_constraint<E>(scene_, k++);
      if (!is_active) {
        for (Eigen::Index i = 0; i < rows; ++i) visit(S(0.0));
      } else if constexpr (HolonomicEffect<E, n>) {
        visit_part(e, e.phi(q, t), rows, t, visit);
      } else {
        visit_part(e, e.velocity_constraint(q, qdot, t), rows, t, visit);
      }
    });
  }
  template <class E, class Result, class S, class Visit>
  static void visit_part(const E& e, const Result& result, Eigen::Index rows, const S& t, const Visit& visit) {
    require_rows<Result>();
    if constexpr (HasRows<Result>) {
      constexpr int known = constraint_rows_of<E, n>();
      static_assert(known == Dynamic || Result::RowsAtCompileTime == Dynamic || known == Result::RowsAtCompileTime,
                    "qdot: a constraint must return the same number of rows for every scalar");
      require_rows(e, result, rows, t);
      for (Eigen::Index i = 0; i < rows; ++i) visit(S(result[i]));
    } else {
      visit(S(result));
    }
  }

  // value(effect) of a friction; 0 of a contact.
  template <class Value>
  double of_friction([[maybe_unused]] Eigen::Index part, [[maybe_unused]] const Value& value) const {
    double found = 0.0;
    if constexpr (Sc::has_phases)
      for_each_switching(scene_, [&]([[maybe_unused]] Eigen::Index k, [[maybe_unused]] const auto& e, Eigen::Index, Eigen::Index) {
        if constexpr (!is_contact<decltype(e)>)
          if (k == part) found = value(e);
      });
    return found;
  }

  void describe([[maybe_unused]] std::size_t place, [[maybe_unused]] SwitchingPart& part) const override {
    if constexpr (Sc::has_phases)
      for_each_switching(scene_, [&](Eigen::Index k, const auto& e, Eigen::Index zi, Eigen::Index row) {
        if (static_cast<std::size_t>(k) != place) return;
        part.state = zi;
        part.row = row;
        part.rows = constraint_rows_of<std::remove_cvref_t<decltype(e)>, n>();
        part.name = e.name;
        if constexpr (is_contact<decltype(e)>) {
          part.is_contact = true;
          part.ends_run = e.ends_run;
          part.law = e.law;
          part.hits = e.events.hits;
          part.opens = e.events.opens;
          part.rests = e.events.rests;
        }
      });
  }
};

}  // namespace qdot::detail
