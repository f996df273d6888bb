#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of shared_forces.hpp, and how rows answer to forces. A program that links qdot::compiled has them from there.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "qdot/effects/equations/shared_forces.hpp"
#include "qdot/effects/equations/scene_rows.hpp"
#include "qdot/effects/rows/bounded_minimum.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/equations/cholesky.hpp"

namespace qdot::detail {

// How rows of switching constraints answer to forces along them.
template <class = void>  // compiled only where it is called
class Responses {
  using VectorXd = Eigen::VectorXd;
  using MatrixXd = Eigen::MatrixXd;

 public:
  Responses(const SceneRows& scene, double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z, std::vector<Eigen::Index> rows)
      : rows_(std::move(rows)), has_lasting_(scene.has_lasting_constraints()), J_(scene.jacobian(t, q, qdot, scene.with_all_active(z))),
        lasting_(scene.jacobian(t, q, qdot, scene.with_none_active(z))), M_(scene.mass_matrix(t, q, qdot)),
        factors_(solvable_mass(), lasting_, default_rank_cutoff) {
    const auto count = static_cast<Eigen::Index>(rows_.size());
    W_.resize(q.size(), count);
    A_.resize(count, count);
    length_.resize(count);
    const bool judges = has_lasting_ && reference_.compute(reference_mass());
    for (Eigen::Index i = 0; i < count; ++i) {
      const VectorXd along = J_.row(rows_[at(i)]).transpose();
      const VectorXd answer = factors_.solution(along, VectorXd::Zero(lasting_.rows()), t, NamesOfRows{scene}).qddot;
      for (Eigen::Index j = 0; j < q.size(); ++j) W_(j, i) = answer[j];
      const double square = along.dot(answer), without = judges ? along.dot(VectorXd(reference_.solve(along))) : square;
      length_[i] = square > dependent_pivot * without ? std::sqrt(square) : 0.0;
    }
    for (Eigen::Index i = 0; i < count; ++i)
      for (Eigen::Index j = 0; j < count; ++j)
        A_(i, j) = i == j ? 1.0 : is_decided(i) || is_decided(j) ? 0.0 : J_.row(rows_[at(i)]).dot(W_.col(j)) / (length_[i] * length_[j]);
    for (Eigen::Index i = 0; i < count; ++i)
      for (Eigen::Index j = 0; j < i; ++j) A_(i, j) = A_(j, i) = 0.5 * (A_(i, j) + A_(j, i));
  }

  const MatrixXd& A() const { return A_; }              // scaled to a diagonal of 1
  double length(Eigen::Index i) const { return length_[i]; }           // √(J M⁻¹ Jᵀ): λ length is scaled, as w/length
  bool is_decided(Eigen::Index i) const { return length_[i] == 0.0; }  // the lasting constraints alone decide what the row does
  const ConstrainedFactors<Dynamic, Dynamic>& factors() const { return factors_; }
  const MatrixXd& J() const { return J_; }
  const std::vector<Eigen::Index>& rows() const { return rows_; }

 private:
  static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

  static void lend(MatrixXd& M, const MatrixXd& J) {
    const double of_M = M.cwiseAbs().maxCoeff(), of_J = J.squaredNorm();
    if (of_J > 0) M += ((of_M > 0 ? of_M : 1.0) / of_J) * (J.transpose() * J);
  }
  // Rows lend inertia to what has none: M + ϱ JᵀJ has the same q̈.
  MatrixXd solvable_mass() {
    MatrixXd M = M_;
    if (!has_lasting_ && !(reference_.compute(M) && reference_.smallest_pivot() > massless_pivot)) lend(M, J_);
    return M;
  }
  MatrixXd reference_mass() {
    MatrixXd M = M_;
    if (!(reference_.compute(M) && reference_.smallest_pivot() > massless_pivot)) lend(M, lasting_);
    return M;
  }

  std::vector<Eigen::Index> rows_;
  bool has_lasting_;
  MatrixXd J_, lasting_, M_;
  Cholesky<double, Dynamic> reference_;
  ConstrainedFactors<Dynamic, Dynamic> factors_;
  MatrixXd W_, A_;
  VectorXd length_;
};

// The active rows of a scene, of which at least one depends on others.
template <class = void>  // compiled only where it is called
class ActiveRows {
  using VectorXd = Eigen::VectorXd;

 public:
  ActiveRows(const SceneRows& scene, double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z, const VectorXd& lambda)
      : scene_(scene), responses_(scene, t, q, qdot, z, scene.active_rows(z)) {
    const auto count = static_cast<Eigen::Index>(responses_.rows().size());
    for (Eigen::Index i = 0; i < count; ++i)
      if (!responses_.is_decided(i)) places_.push_back(i);
    const auto size = static_cast<Eigen::Index>(places_.size());
    x_.resize(size);
    lower_ = upper_ = x_;
    for (Eigen::Index k = 0; k < scene.count(); ++k) {
      const SwitchingPart& part = scene.parts()[at(k)];
      for (Eigen::Index i = 0; i < size; ++i) {
        if (!part.has(row_of(i))) continue;
        const double length = responses_.length(places_[at(i)]);
        effect_.push_back(k);
        x_[i] = lambda[row_of(i)] * length;
        upper_[i] = part.is_contact ? std::numeric_limits<double>::infinity() : scene.sticking_limit(k, t, q, qdot) * length;
        lower_[i] = part.is_contact ? 0.0 : -upper_[i];
      }
    }
    N_ = null_space(part_of(responses_.A(), places_));
    for (Eigen::Index i = 0; i < size; ++i)
      if (const SwitchingPart& part = scene.parts()[at(effect_[at(i)])]; part.is_plane() && N_.cols() > 0 && N_.row(i).norm() > apart)
        refuse_plane(t, part.name);
  }

  // lambda ← the shortest within the bounds, where there is one; what is left of the lasting constraints' follows from the others.
  void split(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z, VectorXd& lambda) const {
    VectorXd x = x_;
    if (N_.cols() == 0 || !shorten(x, N_, lower_, upper_)) return;
    for (Eigen::Index i = 0; i < x.size(); ++i) lambda[row_of(i)] = x[i] / responses_.length(places_[at(i)]);
    if (!scene_.has_lasting_constraints()) return;
    VectorXd f = scene_.rhs(t, q, qdot, z);
    for (const Eigen::Index row : responses_.rows()) f += lambda[row] * responses_.J().row(row).transpose();
    const VectorXd gamma = scene_.gamma(t, q, qdot, scene_.with_none_active(z));
    const VectorXd lasting = responses_.factors().solution(f, gamma, t, NamesOfRows{scene_}).lambda;
    for (Eigen::Index r = 0; r < lambda.size(); ++r)
      if (std::find(responses_.rows().begin(), responses_.rows().end(), r) == responses_.rows().end()) lambda[r] = lasting[r];
  }

  SharedForces shared(Eigen::Index effects) const {
    const auto size = static_cast<Eigen::Index>(places_.size());
    SharedForces result{std::vector<int>(at(effects), -1), std::vector<int>(at(effects), 0), std::vector<double>(at(effects), 0.0),
                        std::vector<double>(at(effects), 0.0)};
    int sets = 0;
    for (Eigen::Index first = 0; first < size; ++first) {
      if (result.set[at(effect_[at(first)])] >= 0 || N_.row(first).norm() < apart) continue;
      std::vector<Eigen::Index> members{first};
      result.set[at(effect_[at(first)])] = sets;
      for (std::size_t k = 0; k < members.size(); ++k)
        for (Eigen::Index i = 0; i < size; ++i)
          if (result.set[at(effect_[at(i)])] < 0 && std::abs(N_.row(i).dot(N_.row(members[k]))) > apart) {
            result.set[at(effect_[at(i)])] = sets;
            members.push_back(i);
          }
      ++sets;
      judge(members, result);
    }
    return result;
  }

 private:
  static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }
  Eigen::Index row_of(Eigen::Index i) const { return responses_.rows()[at(places_[at(i)])]; }

  static constexpr double apart = 1e-9;

  [[noreturn, gnu::cold]] static void refuse_plane(double t, const std::string& name) {
    throw ConstraintError(name, t, 0.0,
                          sentence({"what sticks in a plane must not share its force, but at t = ", t, " other constraints hold '", name,
                                    "' as well, or its velocity has fewer directions than components; give it a velocity of fewer components, or leave one "
                                    "of the frictions out"}));
  }

  void judge(const std::vector<Eigen::Index>& members, SharedForces& result) const {
    const auto size = static_cast<Eigen::Index>(members.size());
    Eigen::VectorXd x(size), lower(size), upper(size), unit(size);
    Eigen::MatrixXd N(size, N_.cols());
    double strongest = 0.0, load = 0.0;
    for (Eigen::Index i = 0; i < size; ++i) {
      const Eigen::Index from = members[at(i)];
      x[i] = x_[from];
      lower[i] = lower_[from];
      upper[i] = upper_[from];
      N.row(i) = N_.row(from);
      load = std::max(load, std::abs(x[i]));
      if (std::isfinite(upper[i])) strongest = std::max(strongest, upper[i]);
    }
    const bool holds = strongest > 0;
    const double most = holds ? 1.0 : load > 0 ? load : 1.0;
    for (Eigen::Index i = 0; i < size; ++i) unit[i] = std::isfinite(upper[i]) ? upper[i] : holds ? strongest : 1.0;
    const Margin margin = detail::margin(x, N, lower, upper, unit, most);
    for (Eigen::Index i = 0; i < size; ++i) {
      const Eigen::Index from = members[at(i)];
      const std::size_t effect = at(effect_[at(from)]);
      const double length = responses_.length(places_[at(from)]), force = unit[i] / length;
      result.stops[effect] = margin.stops[at(i)];
      result.ease[effect] = margin.mu / most;
      result.guard[effect] = (i == 0 ? margin.mu : most) * (std::isfinite(upper[i]) ? force * force : force);
    }
  }

  const SceneRows& scene_;
  Responses<> responses_;
  std::vector<Eigen::Index> places_, effect_;  // of the rows that are not decided
  VectorXd x_, lower_, upper_;
  Eigen::MatrixXd N_;
};

template <class>
SharedForces shared_forces(const SceneRows& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& z,
                           const Eigen::VectorXd& lambda) {
  return ActiveRows<>(scene, t, q, qdot, z, lambda).shared(scene.count());
}

template <class>
void split_forces(const SceneRows& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& z,
                  Eigen::VectorXd& lambda) {
  ActiveRows<>(scene, t, q, qdot, z, lambda).split(t, q, qdot, z, lambda);
}

}  // namespace qdot::detail
