#pragma once
// SPDX-License-Identifier: MIT
//
// J, φ̇, φ̈ and their slopes by dual numbers of one kind.
//
// The functors of constraints are run on the kind of numbers that T and V are run on, Dual<Dual<Dual<double, 1>, 1>, k>: with outer parts ε_i, a middle
// part η and an inner part δ. What is asked for is a matter of what these parts are at first:
//
//     J       q + ε_i                                        the ε_i part of φ; of a, with q̇ + ε_i
//     φ̈       q + q̇ δ + (q̇ + q̈ δ) η ,  t + δ + η            the ηδ part of φ
//     ȧ       q + q̇ δ ,  q̇ + q̈ δ ,  t + δ                   the δ part of a
//     ∂φ̈/∂y   the same with ε_i on q_i, or on both q̇_i       the ε_i ηδ part
//     ∂J/∂y   q + ε_i, and δ on one component of y           the ε_i δ part
//
// So a functor is compiled once for all of it. More is computed than each question needs; runs ask for lines (mechanics/derive/solved_rates.hpp) first.
// φ and φ̇ alone, of which there are more, are found by Dual<double, 1>.

#include <Eigen/Core>
#include <algorithm>

#include "qdot/effects/equations/scene_rows.hpp"
#include "qdot/mechanics/equations/lagrange_terms.hpp"

namespace qdot::detail {

/// Rows of a scene with n coordinates.
template <int n>
class RowsByDuals : public virtual SceneRows {
 public:
  MatrixXd jacobian(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z) const override {
    MatrixXd J = zeros<MatrixXd>(rows(), q.size());
    for (const bool of_positions : {true, false}) {
      if (!has_rows(of_positions)) continue;
      Motion m(q, qdot, t);
      for (Eigen::Index first = 0; first < q.size(); first += Number::directions) {
        const Eigen::Index end = std::min<Eigen::Index>(q.size(), first + Number::directions);
        Numbers& seeds = of_positions ? m.q : m.qdot;
        for (Eigen::Index j = first; j < end; ++j) seeds[j].tangent[at(j - first)].value.value = 1.0;
        const auto found = rows_on(m.q, m.qdot, m.t, z);
        for (Eigen::Index j = first; j < end; ++j) {
          seeds[j].tangent[at(j - first)].value.value = 0.0;
          for (Eigen::Index i = 0; i < rows(); ++i)
            if (is_of_positions(i) == of_positions) J(i, j) = found[i].tangent[at(j - first)].value.value;
        }
      }
    }
    return J;
  }

  VectorXd residual(double t, const VectorXd& q, const VectorXd& z) const override {
    const Vector<Slope, n> x = constants<Slope>(Vector<double, n>(q));
    return values(rows_on(x, x, Slope(t), z), [](const Slope& phi) { return phi.value; }, [](const Slope&) { return 0.0; });
  }

  VectorXd velocity(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& z) const override {
    Vector<Slope, n> x = constants<Slope>(Vector<double, n>(q));
    for (Eigen::Index i = 0; i < q.size(); ++i) x[i].tangent[0] = qdot[i];
    const auto found = rows_on(x, constants<Slope>(Vector<double, n>(qdot)), Slope::variable(t, 0), z);
    return values(found, [](const Slope& phi) { return phi.tangent[0]; }, [](const Slope& a) { return a.value; });
  }

  VectorXd row_accelerations(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& a, const VectorXd& z) const override {
    const Motion m(q, qdot, t, &a);
    return values(rows_on(m.q, m.qdot, m.t, z), [](const Number& phi) { return phi.value.tangent[0].tangent[0]; },
                  [](const Number& row) { return row.value.value.tangent[0]; });
  }

  /// dc ← −∂φ̈/∂y and −∂ȧ/∂y at fixed q̈ = a, for y = [q; q̇] in the first 2n columns.
  void write_slopes_of_accelerations(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& a, const VectorXd& z, MatrixXd& dc) const {
    const Eigen::Index k = q.size();
    Motion m(q, qdot, t, &a);
    const auto seed = [&](Eigen::Index j, std::size_t d, double one) {
      Number& x = m.q[j < k ? j : j - k];
      if (j < k) {
        x.tangent[d].value.value = one;
      } else {
        x.tangent[d].value.tangent[0] = x.tangent[d].tangent[0].value = one;
        m.qdot[j - k].tangent[d].value.value = one;
      }
    };
    for (Eigen::Index first = 0; first < 2 * k; first += Number::directions) {
      const Eigen::Index end = std::min<Eigen::Index>(2 * k, first + Number::directions);
      for (Eigen::Index j = first; j < end; ++j) seed(j, at(j - first), 1.0);
      const auto found = rows_on(m.q, m.qdot, m.t, z);
      for (Eigen::Index j = first; j < end; ++j) {
        const std::size_t d = at(j - first);
        seed(j, d, 0.0);
        for (Eigen::Index i = 0; i < rows(); ++i)
          dc(i, j) = -(is_of_positions(i) ? found[i].tangent[d].tangent[0].tangent[0] : found[i].tangent[d].value.tangent[0]);
      }
    }
  }

  /// dr ← dr + Σ λ_i ∂J_i/∂y, n rows.
  void add_slopes_of_reactions(double t, const VectorXd& q, const VectorXd& qdot, const VectorXd& lambda, const VectorXd& z, MatrixXd& dr) const {
    const Eigen::Index k = q.size();
    for (const bool of_positions : {true, false}) {
      if (!has_rows(of_positions)) continue;
      Motion m(q, qdot, t);
      Numbers& seeds = of_positions ? m.q : m.qdot;
      for (Eigen::Index j = 0; j < (of_positions ? k : 2 * k); ++j) {
        double& along = (j < k ? m.q[j] : m.qdot[j - k]).value.value.tangent[0];
        along = 1.0;
        for (Eigen::Index first = 0; first < k; first += Number::directions) {
          const Eigen::Index end = std::min<Eigen::Index>(k, first + Number::directions);
          for (Eigen::Index i = first; i < end; ++i) seeds[i].tangent[at(i - first)].value.value = 1.0;
          const auto found = rows_on(m.q, m.qdot, m.t, z);
          for (Eigen::Index i = first; i < end; ++i) {
            seeds[i].tangent[at(i - first)].value.value = 0.0;
            for (Eigen::Index row = 0; row < rows(); ++row)
              if (is_of_positions(row) == of_positions) dr(i, j) += lambda[row] * found[row].tangent[at(i - first)].value.tangent[0];
          }
        }
        along = 0.0;
      }
    }
  }

 protected:
  using Number = TermDual<Spare, n>;
  using Slope = Dual<double, 1>;
  using Numbers = Vector<Number, n>;

  /// φ of rows that restrict positions, and a of the others; rows of parts that are not active are zero.
  virtual Vector<Number, Dynamic> rows_on(const Vector<Number, n>& q, const Vector<Number, n>& qdot, const Number& t, const VectorXd& z) const = 0;
  virtual Vector<Slope, Dynamic> rows_on(const Vector<Slope, n>& q, const Vector<Slope, n>& qdot, const Slope& t, const VectorXd& z) const = 0;

 private:
  // A state, or with accelerations the motion through it.
  struct Motion {
    Numbers q, qdot;
    Number t;

    Motion(const VectorXd& x, const VectorXd& v, double time, const VectorXd* a = nullptr)
        : q(constants<Number>(Vector<double, n>(x))), qdot(constants<Number>(Vector<double, n>(v))), t(time) {
      if (a == nullptr) return;
      t.value.value.tangent[0] = t.value.tangent[0].value = 1.0;
      for (Eigen::Index i = 0; i < x.size(); ++i) {
        q[i].value.value.tangent[0] = q[i].value.tangent[0].value = v[i];
        q[i].value.tangent[0].tangent[0] = qdot[i].value.value.tangent[0] = (*a)[i];
      }
    }
  };

  static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }
  template <class Found, class OfPhi, class OfVelocity>
  VectorXd values(const Found& found, const OfPhi& of_phi, const OfVelocity& of_velocity) const {
    VectorXd all(rows());
    for (Eigen::Index i = 0; i < rows(); ++i) all[i] = is_of_positions(i) ? of_phi(found[i]) : of_velocity(found[i]);
    return all;
  }
};

#ifdef QDOT_COMPILED
extern template class RowsByDuals<1>;
extern template class RowsByDuals<2>;
extern template class RowsByDuals<3>;
extern template class RowsByDuals<4>;
extern template class RowsByDuals<5>;
extern template class RowsByDuals<6>;
extern template class RowsByDuals<7>;
extern template class RowsByDuals<8>;
#endif

}  // namespace qdot::detail
