#pragma once
// SPDX-License-Identifier: MIT
//
// A scene with inputs, its cost, and their exact first and second derivatives.
//
//     ẋ = f(t, x, u) ,   x = [q; q̇] ,   q̈ = a(t, x, u) ,      and a running cost ℓ(q, q̇, u, t)
//
// Nothing is differentiated through the solution of M q̈ = …. With the residual R(q, q̇, u, t, a) = M a − rhs − ΣQ = 0, of which M = ∂R/∂a, and y =
// (x, u, t),
//
//     J = ∂a/∂y = −M⁻¹ ∂R/∂y ,        λ·∂²a/∂y² = −[1; J]ᵀ ∂²(μ·R)/∂(y, a)² [1; J] ,     μ = M⁻¹ λ ,
//
// since R is linear in a. The second derivative along two directions is one evaluation of R on a dual of duals, seeded with [1; J] itself: (2n + m +
// 1)(2n + m + 2)/2 of them for all.

#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>

#include "qdot/ad/dual.hpp"
#include "qdot/ad/dual_eigen.hpp"
#include "qdot/ad/dual_math.hpp"
#include "qdot/effects/input.hpp"
#include "qdot/effects/scene_motion.hpp"

namespace qdot::detail {

// ẋ and ℓ at a moment, and their slopes in y = (x, u, t); the last row is that of ℓ.
struct ControlledRates {
  Eigen::VectorXd f;
  Eigen::MatrixXd slopes;
};

class Controlled {
 public:
  virtual ~Controlled() = default;
  virtual Eigen::Index states() const = 0;  // 2n
  virtual Eigen::Index inputs() const = 0;
  virtual std::string state_name(Eigen::Index i) const = 0;
  virtual std::string input_name(Eigen::Index i) const = 0;
  virtual Eigen::VectorXd rates(double t, const Eigen::VectorXd& x, const Eigen::VectorXd& u) const = 0;  // ẋ
  virtual ControlledRates slopes(double t, const Eigen::VectorXd& x, const Eigen::VectorXd& u) const = 0;
  // ∂²(weights·(ẋ, ℓ))/∂y², with slopes from there.
  virtual Eigen::MatrixXd curvature(double t, const Eigen::VectorXd& x, const Eigen::VectorXd& u, const Eigen::VectorXd& weights,
                                    const Eigen::MatrixXd& slopes) const = 0;
  // What the end costs, and its slopes in (x, t).
  virtual double end_cost(const Eigen::VectorXd& xt) const = 0;
  virtual Eigen::VectorXd end_slope(const Eigen::VectorXd& xt) const = 0;
  virtual Eigen::MatrixXd end_curvature(const Eigen::VectorXd& xt) const = 0;
};

template <class Sc>
inline constexpr int inputs_of = 0;
template <class Sys, class... Effects>
inline constexpr int inputs_of<Scene<Sys, Effects...>> = (0 + ... + (requires { Effects::is_input; } ? states_of<Effects>() : 0));

struct OuterSlope {};
struct InnerSlope {};

template <class Sc, class Cost>
class ControlledScene final : public Controlled {
  static constexpr int n = Sc::dof_at_compile_time, m = Sc::states_at_compile_time;
  using Inner = Dual<double, 1, InnerSlope>;
  using Twice = Dual<Inner, 1, OuterSlope>;
  static_assert(!Sc::has_constraints, "qdot: optimal motions need a scene without constraints and contacts: choose coordinates that know of them");
  static_assert(inputs_of<Sc> > 0 && inputs_of<Sc> == m,
                "qdot: optimal motions need a scene with inputs, input(\"motor\", 0), and no other effect with a state of its own");

 public:
  ControlledScene(const Sc& scene, const Cost& cost) : scene_(scene), cost_(cost) {
    for_each_input(scene_, [&](const auto& effect, Eigen::Index, int i) { names_.push_back(qdot::detail::input_name(effect, i)); });
  }

  Eigen::Index states() const override { return 2 * scene_.dof(); }
  Eigen::Index inputs() const override { return m; }
  std::string state_name(Eigen::Index i) const override { return i < scene_.dof() ? scene_.coordinate_name(i) : scene_.velocity_name(i - scene_.dof()); }
  std::string input_name(Eigen::Index i) const override { return names_[static_cast<std::size_t>(i)]; }

  Eigen::VectorXd rates(double t, const Eigen::VectorXd& x, const Eigen::VectorXd& u) const override {
    const Eigen::Index k = scene_.dof();
    Eigen::VectorXd f(2 * k);
    const Eigen::VectorXd a = acceleration(scene_, Vector<double, n>(x.head(k)), Vector<double, n>(x.tail(k)), t, Vector<double, m>(u));
    f << x.tail(k), a;  // which what throws in between would leave half done
    return f;
  }

  ControlledRates slopes(double t, const Eigen::VectorXd& x, const Eigen::VectorXd& u) const override {
    const Eigen::Index k = scene_.dof(), N = 2 * k, size = N + m + 1;
    ControlledRates result{Eigen::VectorXd(N + 1), Eigen::MatrixXd::Zero(N + 1, size)};
    result.f.head(N) = rates(t, x, u);
    Point at = point(t, x, u, result.f.tail(k + 1).head(k));
    Eigen::MatrixXd dR(k, size);
    for (Eigen::Index j = 0; j < size; ++j) {
      at[j].tangent[0] = Inner(1.0);
      const Vector<Twice, n> R = residual(at);
      for (Eigen::Index i = 0; i < k; ++i) dR(i, j) = R[i].tangent[0].value;
      const Twice cost = running_cost(at);
      result.f[N] = cost.value.value;
      result.slopes(N, j) = cost.tangent[0].value;
      at[j].tangent[0] = Inner(0.0);
      if (j >= k && j < N) result.slopes(j - k, j) = 1.0;
    }
    result.slopes.middleRows(k, k) = -factors(t, x).solve(dR);
    return result;
  }

  Eigen::MatrixXd curvature(double t, const Eigen::VectorXd& x, const Eigen::VectorXd& u, const Eigen::VectorXd& weights,
                            const Eigen::MatrixXd& slopes) const override {
    const Eigen::Index k = scene_.dof(), N = 2 * k, size = N + m + 1;
    const Eigen::VectorXd mu = factors(t, x).solve(Eigen::VectorXd(weights.segment(k, k)));
    Point at = point(t, x, u, rates(t, x, u).tail(k));
    Eigen::MatrixXd H(size, size);
    const auto seed = [&](Eigen::Index i, bool outer, double by) {
      const auto add = [&](Twice& z, double slope) { (outer ? z.tangent[0].value : z.value.tangent[0]) = by * slope; };
      add(at[i], 1.0);
      for (Eigen::Index row = 0; row < k; ++row) add(at[size + row], slopes(k + row, i));
    };
    for (Eigen::Index i = 0; i < size; ++i) {
      seed(i, true, 1.0);
      for (Eigen::Index j = 0; j <= i; ++j) {
        seed(j, false, 1.0);
        const Vector<Twice, n> R = residual(at);
        double sum = weights[N] != 0.0 ? weights[N] * running_cost(at).tangent[0].tangent[0] : 0.0;
        for (Eigen::Index row = 0; row < k; ++row) sum -= mu[row] * R[row].tangent[0].tangent[0];
        H(i, j) = H(j, i) = sum;
        seed(j, false, 0.0);
      }
      seed(i, true, 0.0);
    }
    return H;
  }

  double end_cost(const Eigen::VectorXd& xt) const override {
    return cost_.template at_end<n>(Vector<double, n>(xt.head(scene_.dof())), Vector<double, n>(xt.segment(scene_.dof(), scene_.dof())),
                                    xt[xt.size() - 1]);
  }
  Eigen::VectorXd end_slope(const Eigen::VectorXd& xt) const override {
    Eigen::VectorXd slope(xt.size());
    for (Eigen::Index i = 0; i < xt.size(); ++i) slope[i] = end_slopes(xt, i, i).value.tangent[0];
    return slope;
  }
  Eigen::MatrixXd end_curvature(const Eigen::VectorXd& xt) const override {
    Eigen::MatrixXd H(xt.size(), xt.size());
    for (Eigen::Index i = 0; i < xt.size(); ++i)
      for (Eigen::Index j = 0; j <= i; ++j) H(i, j) = H(j, i) = end_slopes(xt, i, j).tangent[0].tangent[0];
    return H;
  }

 private:
  using Point = Vector<Twice, Dynamic>;  // (q, q̇, u, t, a)

  Point point(double t, const Eigen::VectorXd& x, const Eigen::VectorXd& u, const Eigen::VectorXd& a) const {
    Eigen::VectorXd all(x.size() + m + 1 + a.size());
    all << x, u, t, a;
    return all.cast<Twice>();
  }
  Vector<Twice, n> residual(const Point& at) const {
    const Eigen::Index k = scene_.dof();
    const Vector<Twice, n> q = at.head(k), qdot = at.segment(k, k), a = at.tail(k);
    const Vector<Twice, m> u = at.segment(2 * k, m);
    const Twice t = at[2 * k + m];
    Vector<Twice, n> R = lagrange_residual<n>(scene_.system().energies(), q, qdot, a, t);
    const Vector<Twice, n> Q = effect_forces(scene_, q, qdot, u, t);
    for (Eigen::Index i = 0; i < k; ++i) R[i] -= Q[i];
    return R;
  }
  Twice running_cost(const Point& at) const {
    const Eigen::Index k = scene_.dof();
    const Vector<Twice, n> q = at.head(k), qdot = at.segment(k, k);
    const Vector<Twice, m> u = at.segment(2 * k, m);
    return cost_.template running<n>(q, qdot, u, at[2 * k + m]);
  }
  Twice end_slopes(const Eigen::VectorXd& xt, Eigen::Index outer, Eigen::Index inner) const {
    const Eigen::Index k = scene_.dof();
    Vector<Twice, Dynamic> at = xt.cast<Twice>();
    at[outer].tangent[0].value = 1.0;
    at[inner].value.tangent[0] = 1.0;
    const Vector<Twice, n> q = at.head(k), qdot = at.segment(k, k);
    return cost_.template at_end<n>(q, qdot, at[2 * k]);
  }
  Eigen::FullPivLU<Eigen::MatrixXd> factors(double t, const Eigen::VectorXd& x) const {
    const Eigen::Index k = scene_.dof();
    const Vector<double, n> q = x.head(k), qdot = x.tail(k);
    return Eigen::FullPivLU<Eigen::MatrixXd>(Eigen::MatrixXd(mass_matrix(scene_.system(), q, qdot, t)));
  }

  const Sc& scene_;
  const Cost& cost_;
  std::vector<std::string> names_;
};

}  // namespace qdot::detail
