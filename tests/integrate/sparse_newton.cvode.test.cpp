// SPDX-License-Identifier: MIT
//
// Newton's equations of many coordinates, beside the dense Jacobian of the same scene.
#include "qdot/integrate/cvode/sparse.hpp"

#include <cmath>
#include <type_traits>

#include <Eigen/LU>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/cvode_automatic.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

using namespace qdot;

namespace {

constexpr double rounded = 1e-10;  // times the condition of 1 − γ ∂f/∂y

// Masses in a plane, neighbours of which share a part of their inertia; a field that turns with time.
struct Points {
  auto T(const auto& v) const {
    typename std::remove_cvref_t<decltype(v)>::Scalar sum(0.0);
    for (Eigen::Index i = 0; i < v.size(); ++i) {
      sum += 0.5 * (1.0 + 0.1 * static_cast<double>(i % 7)) * v[i] * v[i];
      if (i > 1) sum += 0.1 * v[i] * v[i - 2];
    }
    return sum;
  }
  auto V(const auto& q, const auto& t) const {
    using std::sin;
    typename std::remove_cvref_t<decltype(q)>::Scalar sum(0.0);
    for (Eigen::Index i = 1; i < q.size(); i += 2) sum += 9.81 * q[i] + sin(t) * q[i] * q[i - 1];
    return sum;
  }
};

struct Anchored {
  auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  auto V(const auto& q) const { return 0.5 * q.squaredNorm(); }
};

auto rods = [](const auto& q) {
  using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
  Vector<S, Dynamic> rows(q.size() / 2);
  for (Eigen::Index k = 0; k < rows.size(); ++k) {
    const S x = k == 0 ? S(q[0]) : q[2 * k] - q[2 * k - 2], y = k == 0 ? S(q[1]) : q[2 * k + 1] - q[2 * k - 1];
    rows[k] = 0.5 * (x * x + y * y - 1.0);
  }
  return rows;
};

Eigen::VectorXd waves(Eigen::Index n, double phase) {
  Eigen::VectorXd x(n);
  for (Eigen::Index i = 0; i < n; ++i) x[i] = std::sin(phase + 2.3 * static_cast<double>(i));
  return x;
}

template <class Form>
void check_newton(const Form& form, double t, double gamma) {
  const Eigen::Index size = form.size();
  const Eigen::VectorXd y = waves(size, 0.3), b = waves(size, 1.7);
  Eigen::MatrixXd J(size, size);
  form.jacobian(t, y, J);
  const Eigen::VectorXd expected = (Eigen::MatrixXd::Identity(size, size) - gamma * J).partialPivLu().solve(b);
  detail::cvode::Messages messages{[](bool, const char*, void*) noexcept {}, nullptr};
  const auto context = detail::cvode::make_context(messages);
  const detail::SparseFormOf<detail::MethodForm, Form> hidden(form);
  detail::cvode::SparseNewton<> newton(hidden, std::move(*form.equations()), context.get());
  newton.linearize(t, y);
  for (const double other : {0.5 * gamma, gamma}) newton.assemble(other);
  Eigen::VectorXd x(size), right = b;
  const auto x_vector = detail::cvode::owned<detail::cvode::VectorHandle>(N_VMake_Serial(detail::cvode::index(size), x.data(), context.get()), "vector");
  const auto b_vector = detail::cvode::owned<detail::cvode::VectorHandle>(N_VMake_Serial(detail::cvode::index(size), right.data(), context.get()), "vector");
  REQUIRE(SUNLinSolSetup(newton.solver(), newton.matrix()) == 0);
  REQUIRE(SUNLinSolSolve(newton.solver(), newton.matrix(), x_vector.get(), b_vector.get(), 0.0) == 0);
  CHECK((x - expected).norm() < rounded * expected.norm());
}

}  // namespace

TEST_CASE("a sparse Newton step is that of the dense Jacobian, free and on constraints of both kinds") {
  constexpr int m = 8;
  const auto points = mechanical_system(2 * m, Points{});
  for (const double gamma : {1e-3, 0.2, -0.1}) {
    check_newton(first_order_form(points), 0.8, gamma);
    check_newton(first_order_form(scene(points, holonomic("rods", rods),
                                        nonholonomic("blade",
                                                     [](const auto& q, const auto& v) {
                                                       using std::cos, std::sin;
                                                       return v[0] * sin(q[3]) - v[1] * cos(q[3]);
                                                     }),
                                        viscous_damping(Eigen::VectorXd(Eigen::VectorXd::LinSpaced(2 * m, 0.1, 0.4))))),
                 0.8, gamma);
  }
}

TEST_CASE("BDF follows a chain of forty rods as Dop853 does, also where one of them is there twice") {
  constexpr int m = 40;
  State<Dynamic> start{0.0, Eigen::VectorXd(2 * m), Eigen::VectorXd::Zero(2 * m)};
  for (int k = 0; k < m; ++k) {
    start.q[2 * k] = (k + 1) * std::sin(0.3);
    start.q[2 * k + 1] = -(k + 1) * std::cos(0.3);
  }
  const auto s = scene(mechanical_system(2 * m, Points{}), holonomic("rods", rods));
  const auto twice = scene(mechanical_system(2 * m, Points{}), holonomic("rods", rods), holonomic("the fifth", [](const auto& q) { return rods(q)[4]; }));
  const auto bdf = simulate(s, start, 0.02, CvodeBdf{}, {.rtol = 1e-9, .atol = 1e-9, .keep_trajectory = false});
  const auto redundant = simulate(twice, start, 0.02, CvodeBdf{}, {.rtol = 1e-9, .atol = 1e-9, .keep_trajectory = false});
  const auto explicitly = simulate(s, start, 0.02, Dop853{}, {.rtol = 1e-11, .atol = 1e-11, .keep_trajectory = false});
  REQUIRE(bdf.completed());
  REQUIRE(redundant.completed());
  REQUIRE(explicitly.completed());
  constexpr double global_error = 1e-6;  // some hundred steps at 1e-9
  CHECK((bdf.y - explicitly.y).cwiseAbs().maxCoeff() < global_error);
  CHECK((redundant.y - explicitly.y).cwiseAbs().maxCoeff() < global_error);
}

TEST_CASE("of many masses in syrup Automatic sees soon that only stability holds its step") {
  // q″ = −q − c q̇ with c = 1e4, from rest: the slow root is −1/c to 1e-8 of it, and q = exp(−t/c).
  constexpr Eigen::Index n = 600;
  constexpr double c = 1e4;
  const auto s = scene(mechanical_system(n, Anchored{}), viscous_damping(Eigen::VectorXd(Eigen::VectorXd::Constant(n, c))));
  const State<Dynamic> start{0.0, Eigen::VectorXd::Ones(n), Eigen::VectorXd::Zero(n)};
  const auto run = simulate(s, start, 100.0, Automatic{}, {.rtol = 1e-6, .atol = 1e-9, .keep_trajectory = false});
  REQUIRE(run.completed());
  CHECK(run.statistics.method == "dop853, cvode_bdf");
  CHECK(run.statistics.steps < 1000);  // 100 c / 6 by an explicit method
  CHECK((run.y.head(n).array() - std::exp(-100.0 / c)).abs().maxCoeff() < 1e-6);
}
