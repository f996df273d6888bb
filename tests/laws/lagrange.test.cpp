// SPDX-License-Identifier: MIT
//
// What must hold for every system: Lagrange's equations against pencil and paper, and among themselves.
#include "catch2_bridge.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <random>

#include "systems/catalogue.hpp"

using namespace qdot;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Sums of a few dozen products, relative to the largest of them.
constexpr double rounding = 1e-13;
// The same behind a linear solve; the mass matrices here have condition numbers up to some thousand.
constexpr double solved = 1e-11;
// Central differences with a step of 1e-6: truncation 1e-12, cancellation 1e-10, both times derivatives of order 100.
constexpr double differenced = 1e-6;

constexpr int samples = 100;

double size(const MatrixXd& m) { return 1.0 + m.cwiseAbs().maxCoeff(); }
double distance(const MatrixXd& a, const MatrixXd& b) { return (a - b).cwiseAbs().maxCoeff() / size(b); }

// The worst value of a law over random states of each system, with the system's name in the report.
template <class Law>
void for_all_systems(double tolerance, const Law& law, int states = samples) {
  static const auto all = systems::catalogue();
  for (const auto& entry : all) {
    const systems::LawSystem& system = *entry;
    std::mt19937 random(20);
    double worst = 0.0;
    for (int sample = 0; sample < states; ++sample) {
      const State<Dynamic> state = system.random_state(random);
      const double error = law(system, state.q, state.qdot, state.t);
      if (!(error <= worst) && !std::isnan(worst)) worst = error;  // NaN sticks
    }
    INFO(system.name);
    CHECK(worst <= tolerance);
  }
}

using Sys = const systems::LawSystem&;
using Vec = const VectorXd&;

}  // namespace

TEST_CASE("M equals the hand-derived one") {
  for_all_systems(rounding, [](Sys s, Vec q, Vec v, double t) { return distance(s.M(q, v, t), s.hand.M(q)); });
}

TEST_CASE("M is symmetric to the bit and positive definite") {
  for_all_systems(0.0, [](Sys s, Vec q, Vec v, double t) {
    const MatrixXd M = s.M(q, v, t);
    const bool definite = Eigen::SelfAdjointEigenSolver<MatrixXd>(M, Eigen::EigenvaluesOnly).eigenvalues()[0] > 0.0;
    return definite && M == M.transpose() ? 0.0 : 1.0;
  });
}

TEST_CASE("rhs equals the hand-derived one") {
  for_all_systems(rounding, [](Sys s, Vec q, Vec v, double t) { return distance(s.rhs(q, v, t), s.hand.rhs(q, v, t)); });
}

TEST_CASE("the accelerations solve the hand-derived equations") {
  for_all_systems(solved, [](Sys s, Vec q, Vec v, double t) {
    const VectorXd expected = s.hand.M(q).llt().solve(s.hand.rhs(q, v, t));
    return distance(s.acceleration(q, v, t), expected);
  });
}

TEST_CASE("the accelerations solve the hand-derived equations by each way that is asked for") {
  for (const By way : {By::duals, By::lines, By::machine_code})
    for_all_systems(solved, [way](Sys s, Vec q, Vec v, double t) {
      const VectorXd expected = s.hand.M(q).llt().solve(s.hand.rhs(q, v, t));
      return distance(s.acceleration(q, v, t, way), expected);
    }, 10);
}

TEST_CASE("M times the accelerations is rhs") {
  for_all_systems(rounding, [](Sys s, Vec q, Vec v, double t) {
    const VectorXd a = s.acceleration(q, v, t);
    return (s.M(q, v, t) * a - s.rhs(q, v, t)).cwiseAbs().maxCoeff() / (size(s.M(q, v, t)) * size(a));
  });
}

TEST_CASE("the kinetic energy is half of qdot M qdot, with the linear part and the part that no velocity moves") {
  for_all_systems(rounding, [](Sys s, Vec q, Vec v, double t) {
    const double quadratic = 0.5 * v.dot(s.hand.M(q) * v);
    return std::abs(s.T(q, v, t) - (quadratic + s.hand_a(q, t).dot(v) + s.hand_T0(q, t))) / (1.0 + quadratic);
  });
}

TEST_CASE("the energy is T + V, and Jacobi's energy function drops the linear part and flips T0") {
  for_all_systems(rounding, [](Sys s, Vec q, Vec v, double t) {
    const double T = s.T(q, v, t), V = s.V(q, v, t), quadratic = 0.5 * v.dot(s.hand.M(q) * v);
    const double energy_error = std::abs(s.energy(q, v, t) - (T + V));
    const double jacobi_error = std::abs(s.jacobi_energy(q, v, t) - (quadratic - s.hand_T0(q, t) + V));
    return std::max(energy_error, jacobi_error) / (1.0 + std::abs(T) + std::abs(V));
  });
}

TEST_CASE("the conjugate momenta are M qdot and the linear part") {
  for_all_systems(rounding, [](Sys s, Vec q, Vec v, double t) {
    return distance(s.momenta(q, v, t), s.hand.M(q) * v + s.hand_a(q, t));
  });
}

TEST_CASE("Jacobi's energy function changes at the rate of the explicit time alone, dh/dt = -dL/dt") {
  for_all_systems(solved, [](Sys s, Vec q, Vec v, double t) {
    return std::abs(s.energy_balance(q, v, t)) / (1.0 + v.norm() * s.rhs(q, v, t).norm());
  });
}

TEST_CASE("a motion run backward obeys the same equations where T has no linear part and time is not mentioned") {
  for_all_systems(rounding, [](Sys s, Vec q, Vec v, double t) {
    if (!s.autonomous || s.hand.a) return 0.0;
    return distance(s.acceleration(q, -v, t), s.acceleration(q, v, t));
  });
}

TEST_CASE("the exact Jacobian of the first-order form agrees with difference quotients") {
  for_all_systems(differenced, [](Sys s, Vec q, Vec v, double t) {
    VectorXd y(2 * s.n);
    y << q, v;
    MatrixXd J(2 * s.n, 2 * s.n);
    s.jacobian(t, y, J);
    MatrixXd quotients = MatrixXd::Zero(2 * s.n, 2 * s.n);
    quotients.topRightCorner(s.n, s.n).setIdentity();
    constexpr double h = 1e-6;
    for (Eigen::Index k = 0; k < 2 * s.n; ++k) {
      VectorXd up = y, down = y;
      up[k] += h;
      down[k] -= h;
      quotients.col(k).tail(s.n) =
          (s.acceleration(up.head(s.n), up.tail(s.n), t) - s.acceleration(down.head(s.n), down.tail(s.n), t)) / (2.0 * h);
    }
    return distance(J, quotients);
  }, 20);
}
