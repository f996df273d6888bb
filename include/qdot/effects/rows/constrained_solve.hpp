#pragma once
// SPDX-License-Identifier: MIT
//
// Solving for accelerations and multipliers together: M q̈ − Jᵀ λ = f, J q̈ = γ.
//
// By Gauss's principle q̈ is, of all accelerations that satisfy the constraints, the one nearest to the free a₀ = M⁻¹ f in the metric of
// M. With M = L Lᵀ, B = J L⁻ᵀ, rows scaled to length one, and d = Lᵀ(q̈ − a₀) that is the shortest d with
//
//     B d = γ − J a₀ ,       and then  d = Bᵀ λ ,   (B Bᵀ) λ = γ − J a₀ .
//
//     regular     B Bᵀ (the Schur complement J M⁻¹ Jᵀ) has a Cholesky factor with sound pivots. The fast way.
//     redundant   rows depend on others. Orthogonal decompositions give the shortest d and the multipliers of least norm; the motion
//                 is as unique as ever, only the split of the forces is not. Contradicting rows are an error.
//     idle        a row of zeros that asks for nothing (a contact that is open) takes no part; its multiplier is zero.
//     massless    M alone is singular, but the constraints determine the coordinates without inertia: full pivoting of the whole.
// The rank cut-off, by default 1e-5 of a row's length, is a decision and not a rounding unit. Where constraints become dependent, a
// smaller one takes noise for information.

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "qdot/effects/rows/columns.hpp"
#include "qdot/effects/rows/constraint_rows.hpp"
#include "qdot/effects/rows/dependent_rows.hpp"
#include "qdot/mechanics/equations/cholesky.hpp"
#include "qdot/mechanics/mass_matrix.hpp"

namespace qdot {

namespace detail {

template <class N, class M>
struct SolutionOf {
  N qddot;
  M lambda;                       ///< Jᵀλ is the force of the constraints on the system
  Eigen::Index rank = 0;          ///< of the constraints; below their number when some are redundant
  double smallest_pivot = 1.0;    ///< of the scaled J M⁻¹ Jᵀ, squared sine of the worst row's angle to those before it; by sparse factors about that
};

}  // namespace detail

/// Accelerations and multipliers, M q̈ = f + Jᵀλ: qddot, lambda, the rank of the constraints, and the smallest_pivot of the scaled J M⁻¹ Jᵀ.
template <int n, int m>
struct ConstrainedSolution : detail::SolutionOf<Vector<double, n>, Vector<double, m>> {};

/// Relative size below which a row of J counts as dependent on the others.
inline constexpr double default_rank_cutoff = 1e-5;

namespace detail {

// Names the constraint that is missed by most.
template <class = void>
[[noreturn, gnu::cold]] void throw_contradiction(const std::vector<std::string>& names, const Eigen::VectorXd& miss, Eigen::Index rank, double t);

// Accelerations (first) and multipliers from the whole matrix, for an M that is singular by itself.
template <class = void>
[[gnu::cold]] std::vector<double> pivoted_solution(const Eigen::MatrixXd& M, const Eigen::MatrixXd& J, const double* f, const double* gamma, double t,
                                                   const std::vector<std::string>& constraints, const std::vector<std::string>& coordinates);

// Pivots of M below this fraction are left to the constraints. Not a rounding unit: the last pivot of a singular M is the
// rounding of the ones before, divided by the smallest of them (a unit quaternion near the identity leaves 1e-13).
inline constexpr double massless_pivot = 1e-8;

// A row whose pivot is within this factor of the dependent ones is judged by the factors below, too. Other solvers eliminate and sum in another
// order, so their pivots differ.
inline constexpr double clearly_independent = 100.0;

// Pivots of a row below this fraction are rounding: it says what the rows before it say.
inline constexpr double redundant_pivot = 1e-12;

// Types of what factors hold: of n coordinates and m rows that the compiler knows, and of any number.
template <int n, int m>
struct KnownSizes {
  using N = Vector<double, n>;
  using M = Vector<double, m>;
  using NN = Matrix<double, n>;
  using MN = Matrix<double, m, n>;
  using NM = Matrix<double, n, m>;
  using MM = Matrix<double, m>;
};
struct AnySizes {
  using N = Column;
  using M = Column;
  using NN = Table;
  using MN = Table;
  using NM = Table;
  using MM = Table;
};

// Scenes with few rows ask for what is compiled for their sizes; what needs no allocation for the others takes about twice as long.
template <int n, int m>
inline constexpr bool are_few = n >= 1 && n <= 4 && m >= 1 && m <= 2 && m <= n;

// Factors of one configuration, used for accelerations and for both projections.
template <class Sizes>
class FactorsOf {
  using N = typename Sizes::N;
  using M = typename Sizes::M;
  using Solution = SolutionOf<N, M>;

 public:
  FactorsOf(const typename Sizes::NN& mass, const typename Sizes::MN& J, double cutoff) : M_(mass), J_(J), cutoff_(cutoff) {
    definite_ = cholesky_.compute(mass) && cholesky_.smallest_pivot() > massless_pivot;
    if (!definite_) return;
    // Bᵀ = L⁻¹ Jᵀ with columns scaled to length one.
    Bt_.resize(J.cols(), J.rows());
    for (Eigen::Index i = 0; i < J.rows(); ++i)
      for (Eigen::Index j = 0; j < J.cols(); ++j) Bt_(j, i) = J(i, j);
    cholesky_.solve_lower(Bt_);
    scale_.resize(J.rows());
    for (Eigen::Index i = 0; i < J.rows(); ++i) {
      const double length = std::sqrt(dot(column(i), column(i), J.cols()));
      scale_[i] = length > 0 ? length : 1.0;
      for (Eigen::Index j = 0; j < J.cols(); ++j) Bt_(j, i) /= scale_[i];
      if (length == 0) ++idle_;
    }
    typename Sizes::MM schur(J.rows(), J.rows());
    for (Eigen::Index j = 0; j < J.rows(); ++j)
      for (Eigen::Index i = j; i < J.rows(); ++i) schur(i, j) = dot(column(i), column(j), J.cols());
    if (idle_ > 0)
      for (Eigen::Index i = 0; i < J.rows(); ++i)
        if (schur(i, i) == 0.0) schur(i, i) = 1.0;
    regular_ = schur_.compute(schur) && schur_.smallest_pivot() > cutoff * cutoff;
    smallest_pivot_ = schur_.smallest_pivot();
    rank_ = J.rows() - idle_;
    if (!regular_) rank_ = orthogonal_columns(of_run_time_size(Bt_), cutoff, true).rank;
  }

  // Pivots of M and of the scaled J M⁻¹ Jᵀ, and the row of the latter's smallest. 1 for the constraints where M is singular by itself.
  double mass_pivot() const noexcept { return cholesky_.smallest_pivot(); }
  double constraint_pivot() const noexcept { return smallest_pivot_; }
  Eigen::Index weakest_constraint() const noexcept { return schur_.weakest_row(); }

  // Independent constraints; all of them where M alone is singular and the rank is not judged here.
  Eigen::Index rank() const noexcept { return definite_ ? rank_ : J_.rows(); }

  // q̈ and λ for a force f and γ; names and time are for messages only.
  template <class Names>
  Solution solution(const N& f, const M& gamma, double t, const Names& names) const {
    Solution s;
    if (!definite_) {
      const std::vector<double> both = pivoted_solution(of_run_time_size(M_), of_run_time_size(J_), f.data(), gamma.data(), t, names(), names.coordinates());
      s.qddot.resize(M_.rows());
      s.lambda.resize(J_.rows());
      std::copy_n(both.data(), M_.rows(), s.qddot.data());
      std::copy_n(both.data() + M_.rows(), J_.rows(), s.lambda.data());
      s.rank = J_.rows();
      return s;
    }
    s.rank = rank_;
    s.smallest_pivot = smallest_pivot_;
    s.qddot = f;  // M⁻¹ f = a₀
    cholesky_.solve_lower(s.qddot);
    cholesky_.solve_upper(s.qddot);
    M g(J_.rows());
    double size = 0.0;
    for (Eigen::Index i = 0; i < J_.rows(); ++i) {
      double sum = 0.0, terms = std::abs(gamma[i]);
      for (Eigen::Index j = 0; j < J_.cols(); ++j) {
        sum += J_(i, j) * s.qddot[j];
        terms += std::abs(J_(i, j) * s.qddot[j]);
      }
      g[i] = (gamma[i] - sum) / scale_[i];
      size = std::max(size, terms / scale_[i]);
    }
    N d;
    nearest(g, size, d, s.lambda, t, names);
    cholesky_.solve_upper(d);
    for (Eigen::Index i = 0; i < J_.rows(); ++i) s.lambda[i] /= scale_[i];
    for (Eigen::Index j = 0; j < J_.cols(); ++j) s.qddot[j] += d[j];
    return s;
  }

  // The smallest displacement in the metric of M with J x = r.
  template <class Names>
  N displacement(const M& r, double t, const Names& names) const {
    N d;
    if (!definite_) {
      Eigen::MatrixXd Jt(J_.cols(), J_.rows());
      for (Eigen::Index i = 0; i < J_.rows(); ++i)
        for (Eigen::Index j = 0; j < J_.cols(); ++j) Jt(j, i) = J_(i, j);
      const LeastNorm shortest = least_norm(Jt, r.data(), cutoff_);
      d.resize(J_.cols());
      std::copy_n(shortest.d.data(), d.size(), d.data());
      return d;
    }
    M g(r.size()), lambda;
    for (Eigen::Index i = 0; i < r.size(); ++i) g[i] = r[i] / scale_[i];
    // Newton's iteration corrects what dependent rows leave over; contradictions show in its residual.
    nearest(g, std::numeric_limits<double>::infinity(), d, lambda, t, names);
    cholesky_.solve_upper(d);
    return d;
  }

 private:
  // The shortest d with B d = g, and λ with d = Bᵀλ (both in scaled rows).
  template <class Names>
  void nearest(const M& g, double size, N& d, M& lambda, double t,
               const Names& names) const {
    if (regular_ && (idle_ == 0 || asks_nothing_of_idle_rows(g))) {
      lambda = g;
      schur_.solve_lower(lambda);
      schur_.solve_upper(lambda);
      d.resize(Bt_.rows());
      std::fill_n(d.data(), d.size(), 0.0);
      for (Eigen::Index i = 0; i < g.size(); ++i) add(d.data(), lambda[i], column(i), d.size());
      return;
    }
    const LeastNorm shortest = least_norm(of_run_time_size(Bt_), g.data(), cutoff_);
    d.resize(Bt_.rows());
    lambda.resize(g.size());
    std::copy_n(shortest.d.data(), d.size(), d.data());
    std::copy_n(shortest.lambda.data(), lambda.size(), lambda.data());
    // What rounding and the cut-off may leave over, relative to the terms that cancel.
    if (largest(shortest.miss) > 1e2 * cutoff_ * (size + largest(g)))
      throw_contradiction(names(), shortest.miss, rank_, t);
  }

  const double* column(Eigen::Index i) const { return Bt_.data() + i * Bt_.rows(); }

  bool asks_nothing_of_idle_rows(const M& g) const {
    for (Eigen::Index i = 0; i < g.size(); ++i)
      if (g[i] != 0.0 && largest(column(i), Bt_.rows()) == 0.0) return false;
    return true;
  }

  typename Sizes::NN M_;
  typename Sizes::MN J_;
  double cutoff_;
  CholeskyOf<double, typename Sizes::NN> cholesky_;
  typename Sizes::NM Bt_;  // a row of numbers where n = 1, and so with columns all the same
  M scale_;
  CholeskyOf<double, typename Sizes::MM> schur_;
  bool definite_ = false;
  bool regular_ = false;
  Eigen::Index rank_ = 0;
  Eigen::Index idle_ = 0;  // rows of zeros
  double smallest_pivot_ = 1.0;
};

template <int n, int m>
class ConstrainedFactors : public FactorsOf<KnownSizes<n, m>> {
 public:
  using FactorsOf<KnownSizes<n, m>>::FactorsOf;
};

// The names that a message may need, made only when it does.
template <class Sc>
struct SceneNames {
  const Sc& scene;
  std::vector<std::string> operator()() const { return constraint_names(scene); }
  std::vector<std::string> coordinates() const { return coordinate_names(scene); }
};

}  // namespace detail

}  // namespace qdot

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template void throw_contradiction<void>(const std::vector<std::string>&, const Eigen::VectorXd&, Eigen::Index, double);
extern template std::vector<double> pivoted_solution<void>(const Eigen::MatrixXd&, const Eigen::MatrixXd&, const double*, const double*, double,
                                                           const std::vector<std::string>&, const std::vector<std::string>&);
}  // namespace qdot::detail
#else
#include "qdot/effects/rows/constrained_solve.ipp"
#endif
