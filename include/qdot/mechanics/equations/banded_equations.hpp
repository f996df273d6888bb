#pragma once
// SPDX-License-Identifier: MIT
//
// Lagrange's equations of many coordinates, each of which feels its neighbours only.
//
//     ∂L/∂q − D ∂L/∂q̇    one sweep back from L, on numbers with a derivative along the motion
//     M                   its diagonal by the same sweep, and where there is more of it one sweep back from T for
//                         `chunk` columns further apart than the reach w of the tape on both sides, which share a direction
//     M q̈ = rhs           L D Lᵀ within the band, n w² operations; for a diagonal M a division each
//
// T and V are evaluated on tapes (ad/records/tape.hpp). So a chain of a thousand masses and springs, a loop over
// neighbours, costs a thousand times one mass. A bare acceleration(), the checks that a run makes of itself, and
// functors that are no formulas use them. A run evaluates equations traced when it began
// (mechanics/derive/traced_motion.hpp), in a tenth of the time. The tape takes the reach, an upper bound, from the
// operations of this evaluation, so functors that branch or sum over varying neighbours cannot make it wrong. Where all
// coordinates meet, w = n − 1: still right, at the cost of the general way.

#include <algorithm>
#include <cstddef>
#include <vector>

#include "qdot/ad/derivatives.hpp"
#include "qdot/ad/records/reverse.hpp"
#include "qdot/mechanics/equations/solve.hpp"

namespace qdot::detail {

// A symmetric matrix of n rows within `reach` of its diagonal, and its L D Lᵀ.
class BandedMatrix {
 public:
  BandedMatrix(Eigen::Index n, Eigen::Index reach)
      : reach_(reach), entries_(zeros<Eigen::MatrixXd>(reach + 1, n)) {}

  Eigen::Index size() const { return entries_.cols(); }
  Eigen::Index reach() const { return reach_; }

  /// Entry (i, j) with i − reach ≤ j ≤ i.
  double& operator()(Eigen::Index i, Eigen::Index j) { return entries_(i - j, j); }
  double operator()(Eigen::Index i, Eigen::Index j) const { return entries_(i - j, j); }

  Eigen::MatrixXd dense() const {
    Eigen::MatrixXd M = zeros<Eigen::MatrixXd>(size(), size());
    for (Eigen::Index j = 0; j < size(); ++j)
      for (Eigen::Index i = j; i < std::min(size(), j + reach_ + 1); ++i) M(i, j) = M(j, i) = (*this)(i, j);
    return M;
  }

  /// Becomes its own L D Lᵀ; false when a pivot is not above `threshold` of its diagonal entry.
  bool factor(double threshold) {
    std::vector<double> diagonal(static_cast<std::size_t>(size()));
    for (Eigen::Index k = 0; k < size(); ++k) diagonal[static_cast<std::size_t>(k)] = *column(k);
    for (Eigen::Index k = 0; k < size(); ++k) {
      double* const l = column(k);
      const double pivot = l[0];
      if (!(pivot > threshold * diagonal[static_cast<std::size_t>(k)])) return false;
      const Eigen::Index below = std::min(reach_, size() - 1 - k);
      for (Eigen::Index j = 1; j <= below; ++j)
        if (l[j] != 0.0) subtract(column(k + j), l[j] / pivot, l + j, below - j + 1);
      for (Eigen::Index j = 1; j <= below; ++j) l[j] /= pivot;
    }
    return true;
  }

  /// x ← M⁻¹ x, after factor().
  void solve(Eigen::VectorXd& x) const {
    for (Eigen::Index k = 0; k < size(); ++k) {
      const Eigen::Index below = std::min(reach_, size() - 1 - k);
      subtract(x.data() + k + 1, x[k], column(k) + 1, below);
    }
    for (Eigen::Index k = size(); k-- > 0;) {
      const double* const l = column(k);
      double sum = x[k] / l[0];
      for (Eigen::Index j = 1; j <= std::min(reach_, size() - 1 - k); ++j) sum -= l[j] * x[k + j];
      x[k] = sum;
    }
  }

 private:
  double* column(Eigen::Index k) { return entries_.data() + k * (reach_ + 1); }
  const double* column(Eigen::Index k) const { return entries_.data() + k * (reach_ + 1); }

  // y ← y − factor·x, `count` numbers.
  static void subtract(double* y, double factor, const double* x, Eigen::Index count) {
    for (Eigen::Index i = 0; i < count; ++i) y[i] -= factor * x[i];
  }

  Eigen::Index reach_;
  Eigen::MatrixXd entries_;  // (i − j, j)
};

// q and q̇ as the first 2n nodes of a tape.
template <class N>
struct TapedState {
  Tape<N>& tape;
  Vector<Reverse<N>, Dynamic> q, qdot;

  TapedState(Tape<N>& t, Eigen::Index n) : tape(t), q(n), qdot(n) {
    for (Eigen::Index i = 0; i < n; ++i) q[i] = tape.variable(i, N(0.0));
    for (Eigen::Index i = 0; i < n; ++i) qdot[i] = tape.variable(n + i, N(0.0), i);
  }
};

// Numbers on tapes are made of Real, a parameter so that programs of few coordinates make none of them.

// M = ∂²T/∂q̇∂q̇ within `reach`.
template <class Real = double, class E>
BandedMatrix banded_mass_matrix(const E& e, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, double t, Eigen::Index reach) {
  using N = Dual<Real, chunk>;
  const Eigen::Index n = q.size();
  const Eigen::Index directions = std::min(n, 2 * reach + 1);
  BandedMatrix M(n, reach);
  std::vector<N> adjoint;
  for (Eigen::Index first = 0; first < directions; first += chunk) {
    Tape<N> tape(2 * n, 14 * n);
    TapedState<N> state(tape, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      state.q[i].value = N(q[i]);
      const Eigen::Index k = i % directions - first;
      state.qdot[i].value = k >= 0 && k < chunk ? N::variable(qdot[i], static_cast<int>(k)) : N(qdot[i]);
    }
    tape.sweep(kinetic<Dynamic>(e, state.q, state.qdot, Reverse<N>(t)), adjoint);
    for (Eigen::Index j = 0; j < n; ++j) {
      const Eigen::Index k = j % directions - first;
      if (k < 0 || k >= chunk) continue;
      for (Eigen::Index i = j; i < std::min(n, j + reach + 1); ++i)
        M(i, j) = adjoint[static_cast<std::size_t>(n + i)].tangent[static_cast<std::size_t>(k)];
    }
  }
  return M;
}

// M and r of M q̈ = r, M within its band.
struct BandedEquations {
  BandedMatrix M;
  Eigen::VectorXd r;
};

// −∂V/∂q.
template <class Real = double, class E>
Eigen::VectorXd potential_force(const E& e, const Eigen::VectorXd& q, double t) {
  Tape<Real> tape(q.size());
  Vector<Reverse<Real>, Dynamic> x(q.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) x[i] = tape.variable(i, q[i]);
  std::vector<Real> adjoint;
  tape.sweep(potential<Dynamic>(e, x, Reverse<Real>(t)), adjoint);
  Eigen::VectorXd force(q.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) force[i] = -adjoint[static_cast<std::size_t>(i)];
  return force;
}

// M of T(q̇). Where T is a quadratic form and no velocities meet, its diagonal is ∂T/∂q̇ at velocities of one.
template <class Real = double, class E>
BandedMatrix mass_matrix_of_velocities(const E& e, const Eigen::VectorXd& qdot) {
  const Eigen::Index n = qdot.size();
  const auto evaluated = [&](Tape<Real>& tape, const auto& velocity) {
    Vector<Reverse<Real>, Dynamic> v(n);
    for (Eigen::Index i = 0; i < n; ++i) v[i] = tape.variable(i, velocity(i));
    return kinetic<Dynamic>(e, v, v, Reverse<Real>(0.0));
  };
  Tape<Real> of_ones(n);
  const Reverse<Real> T = evaluated(of_ones, [](Eigen::Index) { return 1.0; });
  if (of_ones.reach == 0 && !of_ones.compared && T.is_quadratic_form()) {
    std::vector<Real> adjoint;
    of_ones.sweep(T, adjoint);
    BandedMatrix M(n, 0);
    for (Eigen::Index i = 0; i < n; ++i) M(i, i) = adjoint[static_cast<std::size_t>(i)];
    return M;
  }
  if (!of_ones.compared) return banded_mass_matrix(e, qdot, qdot, 0.0, of_ones.reach);
  Tape<Real> here(n);
  evaluated(here, [&](Eigen::Index i) { return qdot[i]; });
  return banded_mass_matrix(e, qdot, qdot, 0.0, here.reach);
}

// T(q̇) and V(q, t) have nothing in common, and p = ∂T/∂q̇ no rate of its own. In T(q, q̇, t), one evaluation along the motion and along all
// velocities at once brings r, and M where it is diagonal.
template <class Real = double, class E>
BandedEquations banded_equations(const E& e, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, double t) {
  if constexpr (kinetic_signature<E, Dynamic>() == KineticSignature::velocity) {
    return {mass_matrix_of_velocities(e, qdot), potential_force(e, q, t)};
  } else {
    using N = Dual<Real, 2>;
    const Eigen::Index n = q.size();
    Tape<N> tape(2 * n, 14 * n);
    TapedState<N> state(tape, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      state.q[i].value.value = q[i];
      state.q[i].value.tangent[0] = qdot[i];
      state.qdot[i].value = N::variable(qdot[i], 1);
    }
    const Reverse<N> time(N::variable(t, 0));
    const Reverse<N> T = kinetic<Dynamic>(e, state.q, state.qdot, time);
    const Eigen::Index reach = tape.reach;
    const Reverse<N> L = T - potential<Dynamic>(e, state.q, time);
    std::vector<N> adjoint;
    tape.sweep(L, adjoint);
    BandedEquations result{reach == 0 ? BandedMatrix(n, 0) : banded_mass_matrix(e, q, qdot, t, reach), Eigen::VectorXd(n)};
    for (Eigen::Index i = 0; i < n; ++i) {
      const N &along_q = adjoint[static_cast<std::size_t>(i)], &along_qdot = adjoint[static_cast<std::size_t>(n + i)];
      result.r[i] = along_q.value - along_qdot.tangent[0];
      if (reach == 0) result.M(i, i) = along_qdot.tangent[1];
    }
    return result;
  }
}

// Where a small change of the state leads: M δq̈ + C δq̇ + K δq = 0, entries (i, j) at row i − j + reach of column j.
struct BandedLinearization {
  Eigen::Index reach = 0;
  Eigen::MatrixXd K, C;
  BandedMatrix M{0, 0};
};

// K = ∂r/∂q and C = ∂r/∂q̇ of the residual r = M q̈ − rhs at fixed q̈ (acceleration_jacobian.hpp).
template <class Real = double, class E>
BandedLinearization banded_linearization(const E& e, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot,
                                         const Eigen::VectorXd& qddot, double t) {
  using Along = Dual<Real, 1>;
  using N = Dual<Along, chunk>;
  const Eigen::Index n = q.size();
  BandedLinearization result;
  result.reach = n - 1;  // until the first evaluation has shown it
  std::vector<N> adjoint;
  bool known = false;
  for (const bool of_q : {true, false}) {
    Eigen::Index directions = known ? std::min(n, 2 * result.reach + 1) : 1;
    for (Eigen::Index first = 0; first < directions; first += chunk) {
      for (bool again = true; again;) {
        again = !known;
        Tape<N> tape(2 * n, 14 * n);
        TapedState<N> state(tape, n);
        for (Eigen::Index i = 0; i < n; ++i) {
          state.q[i].value.value.value = q[i];
          state.q[i].value.value.tangent[0] = qdot[i];
          state.qdot[i].value.value.value = qdot[i];
          state.qdot[i].value.value.tangent[0] = qddot[i];
          const Eigen::Index k = i % directions - first;
          if (k < 0 || k >= chunk) continue;
          const auto d = static_cast<std::size_t>(k);
          (of_q ? state.q : state.qdot)[i].value.tangent[d] = Along(1.0);
          if (!of_q) state.q[i].value.tangent[d].tangent[0] = 1.0;  // q̇ is the rate of q
        }
        const Reverse<N> time(N(Along::variable(t, 0)));
        const Reverse<N> T = kinetic<Dynamic>(e, state.q, state.qdot, time);
        const int reach_of_T = tape.reach;
        const Reverse<N> L = T - potential<Dynamic>(e, state.q, time);
        if (!known) {
          known = true;
          result.reach = tape.reach;
          directions = std::min(n, 2 * result.reach + 1);
          result.K = result.C = zeros<Eigen::MatrixXd>(2 * result.reach + 1, n);
          result.M = banded_mass_matrix(e, q, qdot, t, reach_of_T);
          continue;
        }
        tape.sweep(L, adjoint);
        for (Eigen::Index j = 0; j < n; ++j) {
          const Eigen::Index k = j % directions - first;
          if (k < 0 || k >= chunk) continue;
          const auto d = static_cast<std::size_t>(k);
          for (Eigen::Index i = std::max<Eigen::Index>(0, j - result.reach); i < std::min(n, j + result.reach + 1); ++i)
            (of_q ? result.K : result.C)(i - j + result.reach, j) = adjoint[static_cast<std::size_t>(n + i)].tangent[d].tangent[0] -
                                                                    adjoint[static_cast<std::size_t>(i)].tangent[d].value;
        }
      }
    }
  }
  return result;
}

}  // namespace qdot::detail
