#pragma once
// SPDX-License-Identifier: MIT
//
// The rows of a scene with contacts and dry friction, for code that does not depend on the scene's type.
//
// Which contacts are closed and which frictions stick is chosen at events and at states that come without phases. That is much code, which no scene's
// type enters, so that qdot::compiled can have it: it asks for rows and masses by virtual functions, and for numbers of run-time size. What a run asks
// at each step, the guards, is with the scene's type (effects/equations/switching.hpp), but for rows that share their forces.

#include <Eigen/Core>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/effects/contact.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "qdot/effects/equations/effect_forces.hpp"
#include "qdot/effects/impact.hpp"
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

/// The phases as numbers in z: a contact is apart or closed, a friction slides with the sign of its velocity or sticks; what is undecided is not active.
struct PhaseNumber {
  static constexpr double apart = static_cast<double>(ContactPhase::apart), closed = static_cast<double>(ContactPhase::closed);
  static constexpr double sticks = static_cast<double>(FrictionPhase::sticks), undecided = static_cast<double>(FrictionPhase::undecided);
};

/// A contact or a dry friction.
struct SwitchingPart {
  bool is_contact = false, ends_run = false;
  Eigen::Index state = 0, row = 0;  // its places in z and among the rows of all constraints
  std::string name{}, hits{}, opens{}, rests{};
  ImpactLaw law{};

  double active() const { return is_contact ? PhaseNumber::closed : PhaseNumber::sticks; }
  bool is_active(const Eigen::VectorXd& z) const { return z[state] == active(); }
};

/// What is asked of a scene to find forces along its rows; z are the effects' own states, and a row of a part that is not active is zero.
class SwitchingRows {
 public:
  using VectorXd = Eigen::VectorXd;

  virtual ~SwitchingRows() = default;
  const std::vector<SwitchingPart>& parts() const { return parts_; }
  Eigen::Index count() const { return static_cast<Eigen::Index>(parts_.size()); }
  Eigen::Index rows() const { return rows_; }
  bool has_lasting_constraints() const { return has_lasting_constraints_; }
  const VectorXd& initial_states() const { return initial_states_; }
  VectorXd with_all_active(VectorXd z) const {
    for (const SwitchingPart& part : parts_) z[part.state] = part.active();
    return z;
  }
  VectorXd with_none_active(VectorXd z) const {
    for (const SwitchingPart& part : parts_) z[part.state] = PhaseNumber::undecided;
    return z;
  }
  std::vector<Eigen::Index> active_rows(const VectorXd& z) const {
    std::vector<Eigen::Index> rows;
    for (const SwitchingPart& part : parts_)
      if (part.is_active(z)) rows.push_back(part.row);
    return rows;
  }
  bool is_free(const VectorXd& z) const { return !has_lasting_constraints_ && active_rows(z).empty(); }

  virtual double sticking_limit(Eigen::Index part, double t, const VectorXd& q, const VectorXd& qdot) const = 0;
  virtual Eigen::MatrixXd mass_matrix(double t, const VectorXd& q, const VectorXd& qdot) const = 0;
  virtual VectorXd rhs(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z) const = 0;
  virtual Eigen::MatrixXd jacobian(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z) const = 0;
  virtual VectorXd residual(double t, const VectorXd& q, const VectorXd& z) const = 0;                        // φ
  virtual VectorXd velocity(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z) const = 0;  // φ̇ and a
  virtual VectorXd row_accelerations(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& a, const VectorXd& z) const = 0;  // φ̈, ȧ with q̈ = a
  virtual std::vector<std::string> row_names() const = 0;
  virtual std::vector<std::string> coordinate_names() const = 0;
  /// J q̈ = γ.
  VectorXd gamma(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z) const {
    return -row_accelerations(t, q, qdot, VectorXd::Zero(q.size()), z);
  }

 protected:
  std::vector<SwitchingPart> parts_;
  Eigen::Index rows_ = 0;
  bool has_lasting_constraints_ = false;
  VectorXd initial_states_;
};

/// Names for messages of ConstrainedFactors.
struct NamesOfRows {
  const SwitchingRows& of;
  std::vector<std::string> operator()() const { return of.row_names(); }
  std::vector<std::string> coordinates() const { return of.coordinate_names(); }
};

/// The rows of a scene. Holds a reference to it, and is made for one call.
template <class Sc>
class SwitchingRowsOf : public virtual SwitchingRows {
  static_assert(Sc::constraints_at_compile_time != Dynamic,
                "qdot: beside contacts and dry friction every constraint must have a number of rows known at compile time");

 public:
  explicit SwitchingRowsOf(const Sc& scene) : scene_(scene) {
    rows_ = Sc::constraints_at_compile_time;
    has_lasting_constraints_ = Sc::has_lasting_constraints;
    initial_states_ = scene.initial_states();
    parts_.reserve(Sc::phases_at_compile_time);
    for_each_switching(scene, [&](Eigen::Index, const auto& e, Eigen::Index zi, Eigen::Index row) {
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

  double sticking_limit([[maybe_unused]] Eigen::Index part, [[maybe_unused]] double t, [[maybe_unused]] const VectorXd& q,
                        [[maybe_unused]] const VectorXd& qdot) const override {
    double limit = 0.0;
    for_each_switching(scene_, [&]([[maybe_unused]] Eigen::Index k, [[maybe_unused]] const auto& e, Eigen::Index, Eigen::Index) {
      if constexpr (!is_contact<decltype(e)>)
        if (k == part) limit = e.sticking_limit(Q(q), Q(qdot), t);
    });
    return limit;
  }
  Eigen::MatrixXd mass_matrix(double t, const VectorXd& q, const VectorXd& qdot) const override {
    return qdot::mass_matrix(scene_.system(), Q(q), Q(qdot), t);
  }
  VectorXd rhs(double t, const VectorXd& q, const VectorXd& qdot, [[maybe_unused]] const VectorXd& z) const override {
    Q f = qdot::rhs(scene_.system(), Q(q), Q(qdot), t);
    if constexpr (Sc::has_forces) f += effect_forces(scene_, Q(q), Q(qdot), Z(z), t);
    return f;
  }
  Eigen::MatrixXd jacobian(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z) const override {
    return constraint_jacobian(scene_, Q(q), Q(qdot), t, Z(z));
  }
  VectorXd residual(double t, const VectorXd& q, const VectorXd& z) const override { return constraint_residual(scene_, Q(q), t, Z(z)); }
  VectorXd velocity(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z) const override {
    return constraint_velocity(scene_, Q(q), Q(qdot), t, Z(z));
  }
  VectorXd row_accelerations(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& a, const VectorXd& z) const override {
    return constraint_acceleration(scene_, Q(q), Q(qdot), Q(a), t, Z(z));
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
};

}  // namespace qdot::detail
