// SPDX-License-Identifier: MIT
#include "../catch2_bridge.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "systems/chain_by_loops.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/mechanics/first_order_form.hpp"

using namespace qdot;

namespace {

using Eigen::VectorXd;

// Rounding of some operations for each neighbour.
constexpr double rounded = 1e-12;

// Equal masses between equal springs, the outer ones fixed to walls; counts its springs and masses.
struct MassesAndSprings {
  double m = 1.3, k = 2.1;
  long* visits = nullptr;

  auto T(const auto& qdot) const {
    typename std::decay_t<decltype(qdot)>::Scalar sum(0.0);
    for (Eigen::Index i = 0; i < qdot.size(); ++i) {
      sum += 0.5 * m * qdot[i] * qdot[i];
      if (visits != nullptr) ++*visits;
    }
    return sum;
  }
  auto V(const auto& q) const {
    auto sum = 0.5 * k * q[0] * q[0];
    for (Eigen::Index i = 1; i < q.size(); ++i) {
      const auto stretch = q[i] - q[i - 1];
      sum += 0.5 * k * stretch * stretch;
      if (visits != nullptr) ++*visits;
    }
    return sum + 0.5 * k * q[q.size() - 1] * q[q.size() - 1];
  }
};

VectorXd random_vector(Eigen::Index n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> entry(-1.0, 1.0);
  VectorXd v(n);
  for (double& x : v) x = entry(random);
  return v;
}

TEST_CASE("a thousand masses feel the difference of their neighbours") {
  const MassesAndSprings chain;
  const Eigen::Index n = 1000;
  const VectorXd q = random_vector(n, 1), v = random_vector(n, 2), a = acceleration(mechanical_system(n, chain), q, v);
  double worst = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double left = i > 0 ? q[i - 1] : 0.0, right = i + 1 < n ? q[i + 1] : 0.0;
    worst = std::max(worst, std::abs(a[i] - chain.k / chain.m * (left - 2.0 * q[i] + right)));
  }
  CHECK(worst < rounded);
}

TEST_CASE("the work for one acceleration grows with the number of masses, not faster") {
  const auto visits_for = [](Eigen::Index n) {
    long visits = 0;
    const auto system = mechanical_system(n, MassesAndSprings{.visits = &visits});
    acceleration(system, random_vector(n, 1), random_vector(n, 2));
    return static_cast<double>(visits) / static_cast<double>(n);
  };
  CHECK(visits_for(4000) <= 1.01 * visits_for(400));
  CHECK(visits_for(4000) < 4.0);
}

TEST_CASE("a dense mass matrix of many coordinates is within its own band") {
  // The chain of links that is known at compile time and derived by hand.
  const Eigen::Index n = 48;
  const auto T = [](const auto& q, const auto& v) {
    using std::cos, std::sin;
    typename std::decay_t<decltype(q)>::Scalar vx(0.0), vy(0.0), sum(0.0);
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      vx += cos(q[i]) * v[i];
      vy += sin(q[i]) * v[i];
      sum += 0.5 * (vx * vx + vy * vy);
    }
    return sum;
  };
  const auto V = [](const auto& q) {
    using std::cos;
    typename std::decay_t<decltype(q)>::Scalar y(0.0), sum(0.0);
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      y -= cos(q[i]);
      sum += 9.81 * y;
    }
    return sum;
  };
  const VectorXd q = random_vector(n, 1), v = random_vector(n, 2), a = acceleration(mechanical_system(n, T, V), q, v);
  const VectorXd by_hand = chain_by_loops(q, v);
  CHECK((a - by_hand).norm() < 100.0 * rounded * by_hand.norm());
}

TEST_CASE("rods that share their ends have a banded mass matrix, and one without inertia is named") {
  // T = Σ ⅙ m (v_i² + v_i v_{i+1} + v_{i+1}²): consistent masses of a line of elements, M = m/6 [1 4 1].
  const auto T = [](const auto& v) {
    typename std::decay_t<decltype(v)>::Scalar sum(0.0);
    for (Eigen::Index i = 0; i + 1 < v.size(); ++i) sum += (v[i] * v[i] + v[i] * v[i + 1] + v[i + 1] * v[i + 1]) / 6.0;
    return sum;
  };
  const auto V = [](const auto& q) { return 0.5 * q.squaredNorm(); };
  const Eigen::Index n = 200;
  const VectorXd q = random_vector(n, 3), a = acceleration(mechanical_system(n, T, V), q, VectorXd::Zero(n));
  VectorXd residual = q;
  for (Eigen::Index i = 0; i < n; ++i) {
    residual[i] += (i == 0 || i == n - 1 ? 1.0 : 2.0) / 3.0 * a[i];
    if (i > 0) residual[i] += a[i - 1] / 6.0;
    if (i + 1 < n) residual[i] += a[i + 1] / 6.0;
  }
  CHECK(residual.norm() < 10.0 * rounded);

  long evaluations = 0;
  const auto without_one = [&](const auto& v) {
    ++evaluations;
    return 0.5 * (v.squaredNorm() - v[70] * v[70]);
  };
  const auto massless = mechanical_system(n, without_one, V);
  try {
    acceleration(massless, q, q);
    FAIL("no inertia along q70 was not noticed");
  } catch (const SingularMassMatrix& error) {
    CHECK(std::string(error.what()).find("q70") != std::string::npos);
  }
  CHECK(evaluations < n);  // an error, too, is found within the band: nested duals would take some n²/16
}

TEST_CASE("the mass matrix of any T of velocities alone is its Hessian, quadratic form or not") {
  const Eigen::Index n = 12;
  const VectorXd v = random_vector(n, 5);
  const auto check = [&](const auto& T) {
    const auto system = mechanical_system(n, T, NoPotential{});
    const Eigen::MatrixXd M = detail::mass_matrix_of_velocities(system.energies(), v).dense();
    const Eigen::MatrixXd expected = detail::kinetic_hessian<Dynamic>(system.energies(), v, v, 0.0);
    CHECK((M - expected).cwiseAbs().maxCoeff() < rounded * expected.cwiseAbs().maxCoeff());
  };
  const auto sum_of = [](const auto& term) {
    return [term](const auto& qdot) {
      typename std::decay_t<decltype(qdot)>::Scalar sum(0.0);
      for (Eigen::Index i = 0; i < n; ++i) sum += term(qdot, i);
      return sum;
    };
  };
  check(sum_of([](const auto& u, auto i) { return (1.0 + 0.1 * static_cast<double>(i)) * u[i] * u[i]; }));
  check(sum_of([](const auto& u, auto i) { return u[i] * u[i] + 3.0 * u[i] + 2.0; }));
  check(sum_of([](const auto& u, auto i) { return (u[i] + 1.0) * (u[i] - 2.0); }));
  check(sum_of([](const auto& u, auto i) { return u[i] * u[i] + 0.2 * u[i] * u[(i + 1) % u.size()]; }));
  check(sum_of([](const auto& u, auto i) { return u[i] * u[i] * u[i] * u[i] + u[i] * u[i]; }));
  check(sum_of([](const auto& u, auto i) { return u[i] > 0.5 ? 1.5 * u[i] * u[i] : 0.5 * u[i] * u[i]; }));
  check([&](const auto& u) {
    using std::sqrt;
    auto square = u[0] * u[0];
    for (Eigen::Index i = 1; i < n; ++i) square += u[i] * u[i];
    return -2.0 * sqrt(20.0 - square);
  });
}

TEST_CASE("a constant mass matrix is factored once for a run, one that only looks constant is not") {
  const Eigen::Index n = 40;
  const State<Dynamic> start{0.0, random_vector(n, 1), random_vector(n, 2)};
  const auto coupled = [](const auto& v) { return 0.5 * v.squaredNorm() + 0.1 * v[0] * v[1]; };
  const auto V = [](const auto& q) { return 0.25 * q.squaredNorm() * q.squaredNorm(); };
  const auto form_of = [&](const auto& T) { return first_order_form(mechanical_system(n, T, V)); };
  const auto difference = [&](const auto& form) {
    VectorXd ydot(2 * n);
    form.derivative(0.0, form.packed(start), ydot);
    return (ydot.tail(n) - acceleration(form.system(), start.q, start.qdot)).norm();
  };
  long evaluations = 0;
  const auto counted = form_of([&](const auto& v) {
    ++evaluations;
    return coupled(v);
  });
  CHECK(difference(counted) < rounded);
  const long at_start = evaluations;
  VectorXd ydot(2 * n);
  for (int k = 0; k < 100; ++k) counted.derivative(0.1 * k, counted.packed(start), ydot);
  CHECK(evaluations == at_start);
  // Quartic and relativistic, by traced equations, and with two branches, by the general way.
  CHECK(difference(form_of([&](const auto& v) { return coupled(v) + v[3] * v[3] * v[3] * v[3]; })) < rounded);
  CHECK(difference(form_of([](const auto& v) {
          using std::sqrt;
          return -9.0 * sqrt(1.0 - v.squaredNorm() / 81.0);
        })) < rounded);
  CHECK(difference(form_of([&](const auto& v) { return v[0] > 0.5 ? 2.0 * coupled(v) : coupled(v); })) == 0.0);
}

TEST_CASE("M, C and K within their band are those of the dense Jacobian") {
  // Neighbours that couple in positions and velocities, with nothing constant.
  const auto T = [](const auto& q, const auto& v) {
    using std::cos;
    auto sum = 0.5 * v[0] * v[0];
    for (Eigen::Index i = 1; i < q.size(); ++i) sum += (0.5 + 0.1 * cos(q[i])) * v[i] * v[i] + 0.2 * cos(q[i] - q[i - 1]) * v[i] * v[i - 1];
    return sum;
  };
  const auto V = [](const auto& q) {
    using std::cos;
    auto sum = -cos(q[0]);
    for (Eigen::Index i = 2; i < q.size(); ++i) sum += cos(q[i] - q[i - 2]);
    return sum;
  };
  const Eigen::Index n = 20;
  const auto system = mechanical_system(n, T, V);
  const State<Dynamic> at{0.0, random_vector(n, 1), random_vector(n, 2)};
  const auto form = first_order_form(system);
  const auto near = form.linearization(0.0, form.packed(at));
  CHECK(near.reach == 2);
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n), C = K;
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = std::max<Eigen::Index>(0, j - 2); i < std::min(n, j + 3); ++i) {
      K(i, j) = near.K(i - j + 2, j);
      C(i, j) = near.C(i - j + 2, j);
    }
  const auto dense = acceleration_jacobian(system, at.q, at.qdot);
  const Eigen::MatrixXd M = mass_matrix(system, at.q, at.qdot);
  CHECK((near.M.dense() - M).norm() < rounded);
  CHECK((K + M * dense.d_q).norm() < 10.0 * rounded);
  CHECK((C + M * dense.d_qdot).norm() < 10.0 * rounded);
}

TEST_CASE("a thousand masses and springs swing in their normal modes through CVODE") {
  // q_i(t) = Σ_r A_r sin(π r (i + 1)/(n + 1)) cos ω_r t,  ω_r = 2 √(k/m) sin(π r/(2 n + 2))
  const MassesAndSprings chain;
  const Eigen::Index n = 1000;
  const auto mode = [&](double r, double t) {
    VectorXd q(n);
    const double omega = 2.0 * std::sqrt(chain.k / chain.m) * std::sin(0.5 * std::numbers::pi * r / double(n + 1));
    for (Eigen::Index i = 0; i < n; ++i) q[i] = std::sin(std::numbers::pi * r * double(i + 1) / double(n + 1)) * std::cos(omega * t);
    return q;
  };
  const double t_end = 5.0;
  const auto system = mechanical_system(n, chain);
  const State<Dynamic> start{0.0, mode(3, 0.0) + 0.2 * mode(700, 0.0), VectorXd::Zero(n)};
  const Options options{.rtol = 1e-9, .atol = 1e-11, .keep_trajectory = false};
  constexpr double global_error = 1e-6;  // of some hundred steps at rtol 1e-9
  const VectorXd expected = mode(3, t_end) + 0.2 * mode(700, t_end);
  const auto adams = simulate(system, start, t_end, CvodeAdams{.corrector = Corrector::fixed_point}, options);
  REQUIRE(adams.outcome == Outcome::completed);
  CHECK((adams.y.head(n) - expected).cwiseAbs().maxCoeff() < global_error);
  // Newton's equations within their band; a dense factorization would take minutes here.
  const auto bdf = simulate(system, start, t_end, CvodeBdf{}, options);
  REQUIRE(bdf.outcome == Outcome::completed);
  CHECK((bdf.y.head(n) - expected).cwiseAbs().maxCoeff() < global_error);
}

}  // namespace
