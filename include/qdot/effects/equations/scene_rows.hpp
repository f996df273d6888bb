#pragma once
// SPDX-License-Identifier: MIT
//
// The rows, masses and forces of a scene, for code that does not depend on the scene's type.
//
// What a run asks at each step it has as lines. Other code is asked now and then: for projections far from the constraints, for rows that depend on each
// other, for the phases of contacts and friction. No scene's type enters it, so that qdot::compiled can have it. It asks for rows, masses and forces by
// virtual functions, and for numbers of run-time size. effects/equations/scene_rows_of.hpp has those of a scene.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "qdot/effects/contact.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "qdot/effects/impact.hpp"
#include "qdot/effects/rows/columns.hpp"
#include "qdot/error.hpp"

namespace qdot::detail {

/// The phases as numbers in z: a contact is apart or closed, a friction slides with the sign of its velocity or sticks; what is undecided is not active.
struct PhaseNumber {
  static constexpr double apart = static_cast<double>(ContactPhase::apart), closed = static_cast<double>(ContactPhase::closed);
  static constexpr double sticks = static_cast<double>(FrictionPhase::sticks), undecided = static_cast<double>(FrictionPhase::undecided),
                          begins = static_cast<double>(FrictionPhase::begins);
};

/// A contact or a dry friction.
struct SwitchingPart {
  bool is_contact = false, ends_run = false;
  Eigen::Index state = 0, row = 0;  // its first places in z and among the rows of all constraints
  Eigen::Index rows = 1;            // several of friction in a plane
  std::string name{}, hits{}, opens{}, rests{};
  ImpactLaw law{};

  double active() const { return is_contact ? PhaseNumber::closed : PhaseNumber::sticks; }
  bool is_active(const Eigen::VectorXd& z) const { return z[state] == active(); }
  bool has(Eigen::Index other_row) const { return other_row >= row && other_row < row + rows; }
  /// |its part of a column of rows|, with its sign where it is one.
  double size_in(const Eigen::Ref<const Eigen::VectorXd>& column) const { return rows == 1 ? column[row] : column.segment(row, rows).norm(); }

  // Of friction in a plane (plane_friction.hpp): the velocity that gives its reference direction, and what stands for its speed.
  bool is_plane() const { return rows > 1; }
  double& inverse_speed(Eigen::VectorXd& z) const { return z[state + 1 + rows]; }
  auto reference(Eigen::VectorXd& z) const { return z.segment(state + 1, rows); }
};

class SceneRows;
// parts ← the contacts and frictions of rows.
template <class Rows = SceneRows>
[[gnu::cold]] void find_parts(const Rows& rows, std::vector<SwitchingPart>& parts);

/// What is asked of a scene; z are the effects' own states, and a row of a part that is not active is zero.
class SceneRows {
 public:
  using VectorXd = Eigen::VectorXd;

  virtual ~SceneRows() = default;
  SceneRows(const SceneRows&) = delete;
  SceneRows& operator=(const SceneRows&) = delete;
  Eigen::Index rows() const { return rows_; }
  bool is_of_positions(Eigen::Index row) const { return of_positions_[row] != 0; }  // or else of velocities alone
  bool has_rows(bool of_positions) const {
    return std::find(of_positions_, of_positions_ + rows_, static_cast<char>(of_positions)) != of_positions_ + rows_;
  }
  bool has_lasting_constraints() const { return has_lasting_constraints_; }

  /// The contacts and frictions, which are found when they are first asked for, by one thread.
  const std::vector<SwitchingPart>& parts() const {
    if (parts_.size() != count_) find_parts(*this, parts_);
    return parts_;
  }
  virtual Eigen::Index dof() const = 0;
  virtual Eigen::Index states() const = 0;
  virtual VectorXd initial_states() const = 0;
  Eigen::Index count() const { return static_cast<Eigen::Index>(count_); }
  VectorXd with_all_active(VectorXd z) const {
    for (const SwitchingPart& part : parts()) z[part.state] = part.active();
    return z;
  }
  VectorXd with_none_active(VectorXd z) const {
    for (const SwitchingPart& part : parts()) z[part.state] = PhaseNumber::undecided;
    return z;
  }
  std::vector<Eigen::Index> active_rows(const VectorXd& z) const {
    std::vector<Eigen::Index> rows;
    for (const SwitchingPart& part : parts())
      for (Eigen::Index i = 0; part.is_active(z) && i < part.rows; ++i) rows.push_back(part.row + i);
    return rows;
  }
  /// How many rows ask for anything.
  Eigen::Index asked(const VectorXd& z) const {
    Eigen::Index count = rows_;
    for (const SwitchingPart& part : parts()) count -= part.is_active(z) ? 0 : part.rows;
    return count;
  }
  bool is_free(const VectorXd& z) const { return !has_lasting_constraints_ && active_rows(z).empty(); }

  virtual double sticking_limit(Eigen::Index part, double t, const Column& q, const Column& qdot) const = 0;
  virtual double sliding_limit(Eigen::Index part, double t, const Column& q, const Column& qdot) const = 0;
  // Numbers one after the other, matrices column by column.
  virtual void write_mass_matrix(double t, const double* q, const double* qdot, double* M) const = 0;
  virtual void write_jacobian(double t, const double* q, const double* qdot, const double* z, double* J) const = 0;
  virtual void write_residual(double t, const double* q, const double* z, double* phi) const = 0;                            // φ
  virtual void write_velocity(double t, const double* q, const double* qdot, const double* z, double* velocity) const = 0;  // φ̇ and a
  virtual void write_mass_and_rhs(double t, const Column& q, const Column& qdot, double* M, double* r) const = 0;  // without forces of effects
  virtual Column applied_forces(double t, const Column& q, const Column& qdot, const Column& z) const = 0;               // empty where there are none
  virtual Column row_accelerations(double t, const Column& q, const Column& qdot, const Column& a, const Column& z) const = 0;  // φ̈, ȧ with q̈ = a
  virtual std::vector<std::string> row_names() const = 0;
  virtual std::vector<std::string> coordinate_names() const = 0;
  Table mass_matrix(double t, const Column& q, const Column& qdot) const {
    Table M(q.size(), q.size());
    write_mass_matrix(t, q.data(), qdot.data(), M.data());
    return M;
  }
  Table jacobian(double t, const Column& q, const Column& qdot, const Column& z) const {
    Table J(rows(), q.size());
    write_jacobian(t, q.data(), qdot.data(), z.data(), J.data());
    return J;
  }
  Column residual(double t, const Column& q, const Column& z) const {
    Column phi(rows());
    write_residual(t, q.data(), z.data(), phi.data());
    return phi;
  }
  Column velocity(double t, const Column& q, const Column& qdot, const Column& z) const {
    Column rates(rows());
    write_velocity(t, q.data(), qdot.data(), z.data(), rates.data());
    return rates;
  }
  /// J q̈ = γ.
  Column gamma(double t, const Column& q, const Column& qdot, const Column& z) const {
    return negated(row_accelerations(t, q, qdot, Column(q.size(), 0.0), z));
  }
  /// Generalized forces without those of constraints.
  Column rhs(double t, const Column& q, const Column& qdot, const Column& z) const {
    Table M(q.size(), q.size());
    Column f(q.size());
    write_mass_and_rhs(t, q, qdot, M.data(), f.data());
    const Column Q = applied_forces(t, q, qdot, z);
    for (Eigen::Index i = 0; i < Q.size(); ++i) f[i] += Q[i];
    return f;
  }

  /// @throws NonFinite  with the effect whose force is not finite
  virtual void require_finite_forces(double t, const Column& q, const Column& qdot, const Column& z) const = 0;
  /// @throws NonFinite  with what made accelerations a that are not finite
  virtual void require_finite_acceleration(double t, const Column& q, const Column& qdot, const Column& a) const = 0;
  /// @throws NonFinite  with the constraint whose rows are not finite
  void require_finite_rows(double t, const Table& values) const {
    for (Eigen::Index i = 0; i < values.rows(); ++i)
      for (Eigen::Index j = 0; j < values.cols(); ++j)
        if (!std::isfinite(values(i, j))) throw_row_not_finite(i, t);
  }
  void require_finite_column(double t, const double* values) const {
    for (Eigen::Index i = 0; i < rows(); ++i)
      if (!std::isfinite(values[i])) throw_row_not_finite(i, t);
  }

 protected:
  SceneRows() = default;

  Eigen::Index rows_ = 0;
  const char* of_positions_ = nullptr;  // of each row
  std::size_t count_ = 0;               // of contacts and frictions
  bool has_lasting_constraints_ = false;

 private:
  virtual void describe(std::size_t k, SwitchingPart& part) const = 0;
  template <class Rows>
  friend void find_parts(const Rows& rows, std::vector<SwitchingPart>& parts);
  [[noreturn, gnu::cold]] void throw_row_not_finite(Eigen::Index row, double t) const {
    const std::string name = row_names()[static_cast<std::size_t>(row)];
    throw NonFinite(sentence({"the constraint '", name, "'"}), t,
                    sentence({"a constraint and its derivatives must be finite, but those of '", name, "' are not at t = ", std::to_string(t),
                              "; look there for a division by zero, or a root or logarithm at or outside the edge of its domain"}));
  }

  mutable std::vector<SwitchingPart> parts_;
};

template <class Rows>
void find_parts(const Rows& rows, std::vector<SwitchingPart>& parts) {
  parts.resize(rows.count_);
  for (std::size_t k = 0; k < parts.size(); ++k) rows.describe(k, parts[k]);
}
#ifdef QDOT_COMPILED
extern template void find_parts<SceneRows>(const SceneRows&, std::vector<SwitchingPart>&);
#endif

/// Names for messages of FactorsOf (effects/rows/constrained_solve.hpp).
struct NamesOfRows {
  const SceneRows& of;
  std::vector<std::string> operator()() const { return of.row_names(); }
  std::vector<std::string> coordinates() const { return of.coordinate_names(); }
};

}  // namespace qdot::detail
