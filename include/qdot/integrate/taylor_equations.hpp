#pragma once
// SPDX-License-Identifier: MIT
//
// Lagrange's equations on power series.
//
// Written with the momenta, Lagrange's equations need no second derivative but the mass matrix:
//
//     d/dt p = g ,      p = ∂L/∂q̇,   g = ∂L/∂q .
//
// Let q, q̇, p, g be power series in s = (t − t₀)/τ. Then, order by order,
//
//     q_{k+1} = τ q̇_k / (k + 1)            p_{k+1} = τ g_k / (k + 1) .
//
// p is a function of q and q̇, so its coefficient k + 1 also is
//
//     p_{k+1} = M₀ q̇_{k+1} + r_{k+1},       r_{k+1}: the same with q̇_{k+1} = 0,
//
// for the highest coefficient enters every product only once, beside coefficients of order 0. Hence
//
//     M₀ q̇_{k+1} = τ g_k / (k + 1) − r_{k+1} .
//
// M is wanted at the expansion point only: it is factored once per step, and every further order costs two
// triangular solves and one sweep through the graphs of p and g (taylor_sweep.hpp). These come from one
// recording of L by reverse differentiation and have a few times the operations of T and V themselves: a
// chain of n links costs O(n) per order, where its equations of motion, written out, have O(n²) terms.

#include <Eigen/LU>
#include <cmath>
#include <string>
#include <vector>

#include "qdot/ad/taylor_recording.hpp"
#include "qdot/ad/taylor_sweep.hpp"
#include "qdot/integrate/one_step.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"

namespace qdot::detail {

// L D Lᵀ of a symmetric positive definite matrix, in place and without roots.
template <int n>
class MassFactors {
 public:
  // False if a pivot is not positive beyond rounding.
  bool factor(const Matrix<double, n>& M) {
    const Eigen::Index size = M.rows();
    L_ = M;
    inverse_.resize(size);
    for (Eigen::Index k = 0; k < size; ++k) {
      double d = M(k, k);
      for (Eigen::Index j = 0; j < k; ++j) d -= L_(k, j) * L_(k, j) / inverse_[j];
      if (!(d > singular_pivot<double>(size) * M(k, k))) return false;
      inverse_[k] = 1.0 / d;
      for (Eigen::Index i = k + 1; i < size; ++i) {
        double x = L_(i, k);
        for (Eigen::Index j = 0; j < k; ++j) x -= L_(i, j) * L_(k, j) / inverse_[j];
        L_(i, k) = x * inverse_[k];
      }
    }
    return true;
  }

  void solve_in_place(Vector<double, n>& x) const {
    const Eigen::Index size = x.size();
    for (Eigen::Index j = 0; j + 1 < size; ++j)
      for (Eigen::Index i = j + 1; i < size; ++i) x[i] -= L_(i, j) * x[j];
    for (Eigen::Index i = 0; i < size; ++i) x[i] *= inverse_[i];
    for (Eigen::Index i = size - 1; i-- > 0;)
      for (Eigen::Index j = i + 1; j < size; ++j) x[i] -= L_(j, i) * x[j];
  }

 private:
  Matrix<double, n> L_;
  Vector<double, n> inverse_;  // of D
};

/// The power series of a mechanical system's motion from a state.
///
/// @tparam Sys  System<…>; its functors are run once, in the constructor
template <class Sys>
class LagrangeSeries {
  static constexpr int n = Sys::dof_at_compile_time;
  static constexpr int size_at_compile_time = n == Dynamic ? Dynamic : 2 * n;
  using Energies = typename Sys::EnergiesType;

 public:
  /// @throws NotAnalytic  T or V compares values or has a kink
  LagrangeSeries(const Sys& system, int highest_order) : system_(system) {
    using taylor::Recorded;
    static_assert(CallsT<Energies, Recorded, n> && CallsV<Energies, Recorded, n> &&
                      kinetic_returns_scalar<Energies, Recorded, n>() && potential_returns_scalar<Energies, Recorded, n>(),
                  "qdot: the Taylor method runs T and V once with a scalar that records operations, but they do not take "
                  "every scalar: take `const auto& q`, or make them a template <class S>; or use Dop853");
    const Eigen::Index dof = system.dof();
    taylor::Recording recording;
    taylor::Graph& graph = recording.graph;
    std::vector<int> q_nodes, v_nodes;
    Vector<Recorded, n> q(dof), v(dof);
    for (Eigen::Index i = 0; i < dof; ++i) {
      q_nodes.push_back(graph.variable(static_cast<int>(i)));
      q[i] = Recorded(recording, q_nodes.back());
    }
    for (Eigen::Index i = 0; i < dof; ++i) {
      v_nodes.push_back(graph.variable(static_cast<int>(dof + i)));
      v[i] = Recorded(recording, v_nodes.back());
    }
    const int t_node = graph.variable(static_cast<int>(2 * dof));
    const Recorded t(recording, t_node);
    const int T = kinetic<n>(system.energies(), q, v, t).node_in(recording);
    const int V = potential<n>(system.energies(), q, t).node_in(recording);
    const int L = graph.difference(T, V);

    const std::vector<int> p = graph.gradient(T, v_nodes);
    const std::vector<int> g = graph.gradient(L, q_nodes);
    taylor::SweepOutputs outputs{.early = p, .series = g, .values = {}, .late = v_nodes};
    std::vector<int> mass;
    for (Eigen::Index i = 0; i < dof; ++i) {
      const std::vector<int> row = graph.gradient(p[static_cast<std::size_t>(i)], v_nodes);
      for (Eigen::Index j = 0; j <= i; ++j) {
        mass.push_back(row[static_cast<std::size_t>(j)]);
        mass_is_constant_ = mass_is_constant_ && graph[mass.back()].kind == taylor::Kind::constant;
      }
    }
    outputs.values = mass;
    for (const auto& assumption : recording.assumptions) outputs.values.push_back(assumption.node);
    // Variables are series even where no output contains them: their coefficients are the motion.
    outputs.series.insert(outputs.series.end(), q_nodes.begin(), q_nodes.end());
    outputs.series.push_back(t_node);
    sweep_ = taylor::Sweep(graph, outputs, highest_order);

    const auto slots = [&](const std::vector<int>& nodes) {
      std::vector<int> result;
      for (const int node : nodes) result.push_back(sweep_.slot(node));
      return result;
    };
    motion_ = slots(q_nodes);
    for (const int slot : slots(v_nodes)) motion_.push_back(slot);
    p_ = slots(p);
    g_ = slots(g);
    mass_ = slots(mass);
    t_ = sweep_.slot(t_node);
    for (const auto& assumption : recording.assumptions) assumptions_.push_back({sweep_.slot(assumption.node), assumption.value});
    coefficients_.setZero(2 * dof, highest_order + 1);
    M_.setZero(dof, dof);
    solution_.setZero(dof);
  }

  /// Orders 0 and 1 at a state: column 1 of coefficients() is then time_unit·[q̇; q̈].
  ///
  /// @throws MassMatrixError, NonFinite  as acceleration(); NonFinite also where a formula is not analytic
  template <class Y>
  void start(double t, const Y& y, double time_unit) {
    const Eigen::Index dof = system_.value.dof();
    unit_ = time_unit;
    for (Eigen::Index i = 0; i < 2 * dof; ++i) sweep_.set(motion_[index(i)], coefficients_(i, 0) = y[i]);
    sweep_.set(t_, t);
    sweep_.start();
    for (const auto& [slot, value] : assumptions_)
      if (sweep_.value(slot) == value)
        throw NonFinite("a Taylor coefficient", t,
                        "T or V asks whether a quantity is exactly " + text_of(value) + ", and at t = " + text_of(t) +
                            " it is, so the motion may not be analytic there; use Dop853");
    factor_mass_matrix(t);
    make_order(1);
  }

  /// Orders 2 to `order`, after start().
  void expand(int order) {
    for (int k = 2; k <= order; ++k) {
      sweep_.complete(k - 1);
      make_order(k);
    }
  }

  /// The series: row i of column k is coefficient k of y = [q; q̇] in s = (t − t₀)/time_unit.
  const Matrix<double, size_at_compile_time, Dynamic>& coefficients() const noexcept { return coefficients_; }

 private:
  static std::size_t index(Eigen::Index i) { return static_cast<std::size_t>(i); }

  void make_order(int k) {
    const Eigen::Index dof = system_.value.dof();
    const double factor = unit_ / k;
    for (Eigen::Index i = 0; i < dof; ++i) {
      solution_[i] = factor * sweep_.latest(g_[index(i)]);
      sweep_.set(motion_[index(i)], coefficients_(i, k) = factor * coefficients_(dof + i, k - 1));
    }
    for (Eigen::Index i = 0; i < dof; ++i) sweep_.set(motion_[index(dof + i)], 0.0);
    sweep_.set(t_, k == 1 ? unit_ : 0.0);
    sweep_.advance(k);
    for (Eigen::Index i = 0; i < dof; ++i) solution_[i] -= sweep_.latest(p_[index(i)]);
    if constexpr (Sys::inertia == Inertia::positive_definite) {
      factors_.solve_in_place(solution_);
    } else {
      solution_ = Vector<double, n>(inverse_ * solution_);
    }
    for (Eigen::Index i = 0; i < dof; ++i) sweep_.set(motion_[index(dof + i)], coefficients_(dof + i, k) = solution_[i]);
  }

  void factor_mass_matrix(double t) {
    if (mass_is_constant_ && mass_is_factored_) return;
    std::size_t next = 0;
    for (Eigen::Index i = 0; i < M_.rows(); ++i)
      for (Eigen::Index j = 0; j <= i; ++j) M_(i, j) = M_(j, i) = sweep_.value(mass_[next++]);
    mass_is_factored_ = false;
    if constexpr (Sys::inertia == Inertia::positive_definite) {
      if (!factors_.factor(M_)) throw_mass_matrix_error(M_, t, coordinate_names(system_.value));
    } else {
      inverse_ = solved_with_mass_matrix(system_.value, M_, Matrix<double, n>(Matrix<double, n>::Identity(M_.rows(), M_.rows())), t);
    }
    mass_is_factored_ = true;
  }

  Replaceable<Sys> system_;
  taylor::Sweep sweep_;
  std::vector<int> motion_, p_, g_, mass_;  // slots; motion: q, then q̇
  int t_ = 0;
  struct Assumption {
    int slot;
    double value;
  };
  std::vector<Assumption> assumptions_;
  bool mass_is_constant_ = true, mass_is_factored_ = false;
  Matrix<double, n> M_, inverse_;
  MassFactors<n> factors_;
  Vector<double, n> solution_;
  double unit_ = 1.0;
  Matrix<double, size_at_compile_time, Dynamic> coefficients_;
};

}  // namespace qdot::detail
