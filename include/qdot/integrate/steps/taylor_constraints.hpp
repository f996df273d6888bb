#pragma once
// SPDX-License-Identifier: MIT
//
// Constraints on power series.
//
// On constraints Lagrange's equations get a force and a condition for each row: d/dt p = g + Wᵀλ, c = 0, where c = φ̇ or a, W = ∂c/∂q̇.
// With s = (t − t₀)/τ, λ = λ₀ + λ₁ s + … is *one order behind*: p_k follows from forces of order k − 1, and q̇_k stands in p_k and c_k
// only beside a factor of order 0 (taylor_equations.hpp). With p_k = M₀ q̇_k + r_k and c_k = W₀ q̇_k + e_k each order solves
//
//     [ M₀  −W₀ᵀ ] [ q̇_k             ]     [ τ (g + u)_{k−1}/k − r_k ]
//     [ W₀    0  ] [ (τ/k) λ_{k−1}   ]  =  [ − e_k                   ] ,       u_{k−1} = Σ_{j=1…k−1} W_jᵀ λ_{k−1−j} ,
//
// with one factorization per step. A series that begins on the constraints stays on them; a projection at the step's end removes what
// is cut off. Weak pivots are left to effects/rows/constrained_solve.hpp, which decides about the rank. Near a singular position,
// where a linkage could fold, an error δ of one order is δ/σ in the next, σ the sine of the weakest row's angle to the others. So steps
// shrink towards it, and taylor.hpp ends the run. What switches on and off (contacts, dry friction) has no power series.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "qdot/ad/series/sweep.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/steps/recorded_motion.hpp"
#include "qdot/mechanics/derive/dense_factors.hpp"

namespace qdot::detail {

template <int n, int m>
class ConstrainedFactors;  // effects/rows/constrained_solve.hpp

/// Constraints in the recurrence of a motion's series.
struct ConstraintPart {
  virtual ~ConstraintPart() = default;
  virtual void factor(const taylor::Sweep& sweep, const Eigen::MatrixXd& M, bool mass_is_constant, double t) = 0;
  /// Whether the sweep solves by itself, with the factors that write_factors() gives it: M is definite and rows are independent.
  virtual bool is_regular() const = 0;
  virtual void write_factors(taylor::Sweep& sweep) const = 0;
  virtual void note_multipliers(const taylor::Sweep& sweep, int k) = 0;  // of order k − 1, where the sweep has solved
  virtual void add_known_reactions(const taylor::Sweep& sweep, int k, double factor, Eigen::VectorXd& f) = 0;
  virtual void solve(const taylor::Sweep& sweep, int k, double factor, Eigen::VectorXd& f) = 0;
  virtual const Eigen::MatrixXd& multipliers() const = 0;
  virtual double weakest_pivot() const = 0;
  virtual const std::string& weakest_name() const = 0;
};

/// What messages call rows and coordinates.
struct ConstraintNames {
  std::vector<std::string> rows, columns;
  const std::vector<std::string>& operator()() const { return rows; }
  const std::vector<std::string>& coordinates() const { return columns; }
};

/// The part of a motion's series that its constraints need: W and λ.
///
/// @tparam Factors  of the general solution, where rows or M leave something open; compiled only where a scene has constraints
template <class Factors = ConstrainedFactors<Dynamic, Dynamic>>
class ConstraintSeries final : public ConstraintPart {
  // Which pivots are too weak to trust, if any.
  enum class Verdict { regular, redundant, massless };
  // The decisions of effects/rows/constrained_solve.hpp: a fraction of M's diagonal, and the square of a row's sine to the others.
  static constexpr double weak_mass = 1e-8, weak_row = 1e-10;

 public:
  ConstraintSeries() = default;
  ConstraintSeries(const RecordedMotion& motion, const taylor::Sweep& sweep, std::vector<std::string> coordinates, int highest_order)
      : names_{motion.row_names, std::move(coordinates)} {
    const std::size_t dof = motion.q.size();
    for (const int node : motion.rows) rows_.push_back(sweep.slot(node));
    for (std::size_t i = 0; i < motion.jacobian.size(); ++i) {
      const int slot = sweep.slot(motion.jacobian[i]);
      jacobian_.push_back(slot);
      if (motion.recording.graph[motion.jacobian[i]].kind != formula::Kind::constant)
        moving_.push_back({slot, static_cast<Eigen::Index>(i / dof), static_cast<Eigen::Index>(i % dof)});
    }
    const auto rows = static_cast<Eigen::Index>(rows_.size());
    W_ = Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(dof));
    factors_ = DenseConstrainedFactors<Dynamic>(dof, rows_.size());
    gamma_ = Eigen::VectorXd::Zero(rows);
    displacement_ = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(dof), rows);
    least_ = Eigen::MatrixXd::Zero(rows, rows);
    lambda_ = Eigen::MatrixXd::Zero(rows, highest_order);
    moving_W_.setZero(static_cast<Eigen::Index>(moving_.size()), highest_order);
    moving_lambda_ = moving_W_;
    sums_.setZero(static_cast<Eigen::Index>(moving_.size()));
  }

  /// Factors the matrix of the expansion point.
  ///
  /// @throws NonFinite, ConstraintError, SingularMassMatrix  as constrained_acceleration()
  void factor(const taylor::Sweep& sweep, const Eigen::MatrixXd& M, bool mass_is_constant, double t) override {
    t_ = t;
    if (is_factored_ && mass_is_constant && moving_.empty() && verdict_ == Verdict::regular) return;
    is_factored_ = false;
    for (Eigen::Index i = 0, next = 0; i < W_.rows(); ++i)
      for (Eigen::Index j = 0; j < W_.cols(); ++j, ++next) W_(i, j) = sweep.value(jacobian_[static_cast<std::size_t>(next)]);
    for (Eigen::Index i = 0; i < W_.rows(); ++i)
      for (Eigen::Index j = 0; j < W_.cols(); ++j) {
        if (std::isfinite(W_(i, j))) continue;
        const std::string& name = names_.rows[static_cast<std::size_t>(i)];
        throw NonFinite(sentence({"the constraint '", name, "'"}), t,
                        sentence({"a constraint and its derivatives must be finite, but those of '", name, "' are not at t = ", t,
                                  "; look there for a division by zero, or a root or logarithm at or outside the edge of its domain"}));
      }
    for (Eigen::Index i = 0, next = 0; i < W_.rows(); ++i)
      for (Eigen::Index j = 0; j < W_.cols(); ++j, ++next) factors_.J[static_cast<std::size_t>(next)] = W_(i, j);
    verdict_ = !factors_.compute_mass(M, weak_mass) ? Verdict::massless : factors_.compute_rows(weak_row) ? Verdict::regular : Verdict::redundant;
    if (verdict_ != Verdict::regular) reveal_rank(M);
    is_factored_ = true;
  }

  bool is_regular() const noexcept override { return verdict_ == Verdict::regular; }
  void write_factors(taylor::Sweep& sweep) const override {
    factors_.write_mass_factors(sweep.mass_factors().data());
    factors_.write_row_factors(sweep.row_factors().data());
  }
  void note_multipliers(const taylor::Sweep& sweep, int k) override {
    for (Eigen::Index i = 0; i < lambda_.rows(); ++i) lambda_(i, k - 1) = sweep.multiplier(static_cast<std::size_t>(i));
  }

  /// f ← f + factor · u_{k−1}, before order k is begun.
  void add_known_reactions(const taylor::Sweep& sweep, int k, double factor, Eigen::VectorXd& f) override {
    if (k == 1 || moving_.empty()) return;
    for (std::size_t i = 0; i < moving_.size(); ++i) moving_W_(static_cast<Eigen::Index>(i), k - 1) = sweep.latest(moving_[i].slot);
    double* const sums = sums_.data();
    const Eigen::Index entries = sums_.size();
    std::fill_n(sums, entries, 0.0);
    for (int j = 1; j < k; ++j) {
      const double *const W = moving_W_.data() + j * entries, *const lambda = moving_lambda_.data() + (k - 1 - j) * entries;
      for (Eigen::Index i = 0; i < entries; ++i) sums[i] += W[i] * lambda[i];
    }
    for (std::size_t i = 0; i < moving_.size(); ++i) f[moving_[i].column] += factor * sums[i];
  }

  /// f ← q̇_k, where f is the right-hand side's first part; notes λ_{k−1}.
  ///
  /// @throws ConstraintError, SingularMassMatrix  as constrained_acceleration(), at k = 1
  void solve(const taylor::Sweep& sweep, int k, double factor, Eigen::VectorXd& f) override {
    for (Eigen::Index i = 0; i < gamma_.size(); ++i) gamma_[i] = -sweep.latest(rows_[static_cast<std::size_t>(i)]);
    if (k == 1 && verdict_ == Verdict::redundant) write_solution(f, gamma_);  // which finds rows that contradict each other
    else solve_in_place(f, gamma_);
    for (Eigen::Index i = 0; i < gamma_.size(); ++i) lambda_(i, k - 1) = gamma_[i] / factor;
    for (std::size_t i = 0; i < moving_.size(); ++i)
      moving_lambda_(static_cast<Eigen::Index>(i), k - 1) = lambda_(moving_[i].row, k - 1);
  }

  /// f, g ← v, μ with M v − Wᵀμ = f and W v = g at the expansion point.
  void solve_in_place(Eigen::VectorXd& f, Eigen::VectorXd& g) const {
    if (verdict_ == Verdict::regular) {
      factors_.solve(f.data(), g.data());
    } else if (verdict_ == Verdict::massless) {
      write_solution(f, g);
    } else {
      factors_.solve_mass(f.data());
      g -= W_ * f;
      f += displacement_ * g;
      g = (least_ * g).eval();
    }
  }

  /// Column k is coefficient k of λ, for k one below the order of the motion's series.
  const Eigen::MatrixXd& multipliers() const noexcept override { return lambda_; }

  /// The smallest pivot of the rows at the expansion point, the square of a sine, and the row's name.
  double weakest_pivot() const noexcept override { return verdict_ == Verdict::massless ? 1.0 : factors_.weakest(weak_row).pivot; }
  const std::string& weakest_name() const override { return names_.rows[factors_.weakest(weak_row).row]; }

 private:
  void write_solution(Eigen::VectorXd& f, Eigen::VectorXd& g) const {
    const auto both = revealed_->solution(f, g, t_, names_);
    f = both.qddot;
    g = both.lambda;
  }
  void reveal_rank(const Eigen::MatrixXd& M) {
    constexpr double cutoff = 1e-5;  // default_rank_cutoff
    revealed_.emplace(M, W_, cutoff);
    if (verdict_ != Verdict::redundant) return;
    for (Eigen::Index i = 0; i < W_.rows(); ++i) {
      std::fill_n(gamma_.data(), gamma_.size(), 0.0);
      gamma_[i] = 1.0;
      const auto d = revealed_->displacement(gamma_, t_, names_);
      for (Eigen::Index j = 0; j < d.size(); ++j) displacement_(j, i) = d[j];
    }
    least_ = displacement_.transpose() * M * displacement_;
  }

  struct Moving {  // an entry of W that is not constant
    int slot;
    Eigen::Index row, column;
  };

  ConstraintNames names_;
  std::vector<int> rows_, jacobian_;  // slots of c and of W, row by row
  std::vector<Moving> moving_;
  Eigen::MatrixXd moving_W_, moving_lambda_;  // an entry's W, and its row's λ; column by order
  Eigen::VectorXd sums_;
  double t_ = 0.0;
  bool is_factored_ = false;
  Verdict verdict_ = Verdict::regular;
  DenseConstrainedFactors<Dynamic> factors_;
  std::optional<Factors> revealed_;  // where pivots are weak
  Eigen::MatrixXd W_;
  // Where rows are redundant: q̇ is M⁻¹f + D (γ − W M⁻¹f), with W D r = r and D r as short as the metric of M allows. Dᵀ M D gives the multipliers.
  Eigen::MatrixXd displacement_;  // D
  Eigen::MatrixXd least_;            // Dᵀ M D
  Eigen::VectorXd gamma_;
  Eigen::MatrixXd lambda_;
};

}  // namespace qdot::detail
