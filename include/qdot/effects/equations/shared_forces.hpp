#pragma once
// SPDX-License-Identifier: MIT
//
// Contacts and frictions that share a force: a beam on three supports, a table on four legs, two brakes on one shaft.
//
// Their rows depend on each other, so only sums of their forces follow from the motion. Any split within the bounds is as good, λ ≥ 0 of contacts and
// |λ| ≤ F_s of friction: none opens and none slips as long as there is one. So these have one guard together, how far inside all bounds a split
// can be; and where forces are asked for, they are the shortest split within the bounds.
//
// Lasting constraints have their part in the rows first: what is left is A = J M⁻¹ Jᵀ on the motions that they allow.

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/effects/equations/effect_forces.hpp"
#include "qdot/effects/rows/bounded_minimum.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"

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

// z with all switching constraints active, or none.
template <class Sc, class Z>
Z with_all_active(const Sc& scene, Z z) {
  for_each_switching(scene, [&](Eigen::Index, const auto& e, Eigen::Index zi, Eigen::Index) {
    z[zi] = UnilateralEffect<std::remove_cvref_t<decltype(e)>, Sc::dof_at_compile_time> ? 1.0 : 0.0;
  });
  return z;
}
template <class Sc, class Z>
Z with_none_active(const Sc& scene, Z z) {
  for_each_switching(scene, [&](Eigen::Index, const auto&, Eigen::Index zi, Eigen::Index) { z[zi] = 2.0; });
  return z;
}

// How rows of switching constraints answer to forces along them.
template <class Sc>
class Responses {
  static constexpr int n = Sc::dof_at_compile_time, m = Sc::constraints_at_compile_time;
  using Q = Vector<double, n>;

 public:
  template <class Z>
  Responses(const Sc& scene, double t, const Q& q, const Q& qdot, const Z& z, std::vector<Eigen::Index> rows)
      : rows_(std::move(rows)), J_(constraint_jacobian(scene, q, qdot, t, with_all_active(scene, z))),
        lasting_(constraint_jacobian(scene, q, qdot, t, with_none_active(scene, z))), M_(mass_matrix(scene.system(), q, qdot, t)),
        factors_(solvable_mass(), lasting_, default_rank_cutoff) {
    const auto count = static_cast<Eigen::Index>(rows_.size());
    W_.resize(q.size(), count);
    A_.resize(count, count);
    length_.resize(count);
    const bool judges = Sc::has_lasting_constraints && reference_.compute(reference_mass());
    for (Eigen::Index i = 0; i < count; ++i) {
      const Q along = J_.row(rows_[at(i)]).transpose();
      const Q answer = factors_.solution(along, Vector<double, m>::Zero(), t, SceneNames<Sc>{scene}).qddot;
      for (Eigen::Index j = 0; j < q.size(); ++j) W_(j, i) = answer[j];
      const double square = along.dot(answer), without = judges ? along.dot(Q(reference_.solve(along))) : square;
      length_[i] = square > dependent_pivot * without ? std::sqrt(square) : 0.0;
    }
    for (Eigen::Index i = 0; i < count; ++i)
      for (Eigen::Index j = 0; j < count; ++j)
        A_(i, j) = i == j ? 1.0 : is_decided(i) || is_decided(j) ? 0.0 : J_.row(rows_[at(i)]).dot(W_.col(j)) / (length_[i] * length_[j]);
    for (Eigen::Index i = 0; i < count; ++i)
      for (Eigen::Index j = 0; j < i; ++j) A_(i, j) = A_(j, i) = 0.5 * (A_(i, j) + A_(j, i));
  }

  const Eigen::MatrixXd& A() const { return A_; }       // scaled to a diagonal of 1
  const Eigen::MatrixXd& W() const { return W_; }       // accelerations by a force of 1 along each row
  double length(Eigen::Index i) const { return length_[i]; }  // √(J M⁻¹ Jᵀ): λ length is scaled, as w/length
  bool is_decided(Eigen::Index i) const { return length_[i] == 0.0; }  // the lasting constraints alone decide what the row does
  const ConstrainedFactors<n, m>& factors() const { return factors_; }
  const Matrix<double, m, n>& J() const { return J_; }
  const std::vector<Eigen::Index>& rows() const { return rows_; }

 private:
  static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

  static void lend(Matrix<double, n>& M, const Matrix<double, m, n>& J) {
    const double of_M = M.cwiseAbs().maxCoeff(), of_J = J.squaredNorm();
    if (of_J > 0) M += ((of_M > 0 ? of_M : 1.0) / of_J) * (J.transpose() * J);
  }
  // Rows lend inertia to what has none: M + ϱ JᵀJ has the same q̈.
  Matrix<double, n> solvable_mass() {
    Matrix<double, n> M = M_;
    if (!Sc::has_lasting_constraints && !(reference_.compute(M) && reference_.smallest_pivot() > massless_pivot)) lend(M, J_);
    return M;
  }
  Matrix<double, n> reference_mass() {
    Matrix<double, n> M = M_;
    if (!(reference_.compute(M) && reference_.smallest_pivot() > massless_pivot)) lend(M, lasting_);
    return M;
  }

  std::vector<Eigen::Index> rows_;
  Matrix<double, m, n> J_, lasting_;
  Matrix<double, n> M_;
  Cholesky<double, n> reference_;
  ConstrainedFactors<n, m> factors_;
  Eigen::MatrixXd W_, A_;
  Eigen::VectorXd length_;
};

// What active rows that share forces have of them.
struct SharedForces {
  std::vector<int> set;         // of each switching effect: which set it belongs to, −1 if its force is its own
  std::vector<int> stops;       // the bound that the set's way out is stopped by: −1 the lower, 1 the upper, 0 none
  std::vector<double> guard;    // of the first effect of each set how far inside its bounds the set is; of the others a positive number
  std::vector<double> ease;     // the same of all effects, as a fraction of the load
};

// The active rows of a scene, of which at least one depends on others.
template <class Sc>
class ActiveRows {
  static constexpr int n = Sc::dof_at_compile_time, m = Sc::constraints_at_compile_time;
  using Q = Vector<double, n>;

 public:
  template <class Z>
  ActiveRows(const Sc& scene, double t, const Q& q, const Q& qdot, const Z& z, const Vector<double, m>& lambda)
      : scene_(scene), responses_(scene, t, q, qdot, z, active(scene, z)) {
    const auto count = static_cast<Eigen::Index>(responses_.rows().size());
    for (Eigen::Index i = 0; i < count; ++i)
      if (!responses_.is_decided(i)) places_.push_back(i);
    const auto size = static_cast<Eigen::Index>(places_.size());
    x_.resize(size);
    lower_ = upper_ = x_;
    for_each_switching(scene, [&](Eigen::Index k, const auto& e, Eigen::Index, Eigen::Index row) {
      for (Eigen::Index i = 0; i < size; ++i) {
        if (row_of(i) != row) continue;
        const double length = responses_.length(places_[at(i)]);
        effect_.push_back(k);
        x_[i] = lambda[row] * length;
        if constexpr (UnilateralEffect<std::remove_cvref_t<decltype(e)>, n>) {
          lower_[i] = 0.0;
          upper_[i] = std::numeric_limits<double>::infinity();
        } else {
          upper_[i] = e.sticking_limit(q, qdot, t) * length;
          lower_[i] = -upper_[i];
        }
      }
    });
    N_ = null_space(part_of(responses_.A(), places_));
  }

  // lambda ← the shortest within the bounds, where there is one; what is left of the lasting constraints' follows from the others.
  template <class Z>
  void split(double t, const Q& q, const Q& qdot, const Z& z, Vector<double, m>& lambda) const {
    Eigen::VectorXd x = x_;
    if (N_.cols() == 0 || !shorten(x, N_, lower_, upper_)) return;
    for (Eigen::Index i = 0; i < x.size(); ++i) lambda[row_of(i)] = x[i] / responses_.length(places_[at(i)]);
    if constexpr (Sc::has_lasting_constraints) {
      Q f = rhs(scene_.system(), q, qdot, t);
      if constexpr (Sc::has_forces) f += effect_forces(scene_, q, qdot, z, t);
      for (const Eigen::Index row : responses_.rows()) f += lambda[row] * responses_.J().row(row).transpose();
      const auto gamma = constraint_rows(scene_, q, qdot, t, with_none_active(scene_, z)).gamma;
      const auto lasting = responses_.factors().solution(f, gamma, t, SceneNames<Sc>{scene_}).lambda;
      for (Eigen::Index r = 0; r < lambda.size(); ++r)
        if (std::find(responses_.rows().begin(), responses_.rows().end(), r) == responses_.rows().end()) lambda[r] = lasting[r];
    }
  }

  SharedForces shared(Eigen::Index effects) const {
    constexpr double apart = 1e-9;
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

  template <class Z>
  static std::vector<Eigen::Index> active(const Sc& scene, const Z& z) {
    std::vector<Eigen::Index> rows;
    for_each_switching(scene, [&](Eigen::Index, const auto& e, Eigen::Index zi, Eigen::Index row) {
      if (e.is_active(z[zi])) rows.push_back(row);
    });
    return rows;
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

  const Sc& scene_;
  Responses<Sc> responses_;
  std::vector<Eigen::Index> places_, effect_;  // of the rows that are not decided
  Eigen::VectorXd x_, lower_, upper_;
  Eigen::MatrixXd N_;
};

// How many constraints ask for anything.
template <class Sc, class Z>
Eigen::Index asked(const Sc& scene, const Z& z) {
  Eigen::Index count = Sc::constraints_at_compile_time;
  for_each_switching(scene, [&](Eigen::Index, const auto& e, Eigen::Index zi, Eigen::Index) { count -= e.is_active(z[zi]) ? 0 : 1; });
  return count;
}

}  // namespace qdot::detail
