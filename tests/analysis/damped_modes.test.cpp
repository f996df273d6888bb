// SPDX-License-Identifier: MIT
#include "catch2_bridge.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "qdot/analysis/damped_modes.hpp"
#include "scenes/bead_on_hoop.hpp"
#include "systems/three_bodies.hpp"

using namespace qdot;
using Eigen::Vector3d;

namespace {

constexpr double rounding = 1e-12;

// Two rods with masses 2 and 1 at their ends, springs 1 and dampers c in the joints, pushed by a force P that follows the second rod: H. Ziegler, 1952.
struct Column {
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return 0.5 * (3.0 * v[0] * v[0] + 2.0 * cos(q[0] - q[1]) * v[0] * v[1] + v[1] * v[1]);
  }
  auto V(const auto& q) const { return 0.5 * (q[0] * q[0] + (q[1] - q[0]) * (q[1] - q[0])); }
};
struct Follower {
  double P = 0.0, c = 0.0;
  auto operator()(const auto& q, const auto& v) const {
    using std::sin;
    auto Q = q;
    Q[0] = P * sin(q[0] - q[1]) - c * (2.0 * v[0] - v[1]);
    Q[1] = -c * (v[1] - v[0]);
    return Q;
  }
};
DampedModes column_under(double P, double c) {
  const auto s = scene(mechanical_system<2>(Column{}), generalized_force(Follower{P, c}));
  return damped_modes(linearization(s, State<2>{0.0, {0.0, 0.0}, {0.0, 0.0}}));
}
// The load at which the column becomes unstable.
double critical_load(double c) {
  double low = 0.5, high = 4.0;
  for (int i = 0; i < 50; ++i) {
    const double P = 0.5 * (low + high);
    (column_under(P, c).stability == Stability::unstable ? high : low) = P;
  }
  return low;
}

// A top by Cardan's angles, which are regular where it stands upright.
struct Top {
  double I1 = 1.0, I3 = 0.7, mgl = 1.962;
  auto T(const auto& q, const auto& v) const {
    using std::cos, std::sin;
    const auto c = cos(q[1]), spin = v[2] + v[0] * sin(q[1]);
    return 0.5 * I1 * (c * c * v[0] * v[0] + v[1] * v[1]) + 0.5 * I3 * spin * spin;
  }
  auto V(const auto& q) const {
    using std::cos;
    return mgl * cos(q[0]) * cos(q[1]);
  }
};

}  // namespace

TEST_CASE("Ziegler's column flutters at P l/k = 7/2 - sqrt 2 without damping") {
  CHECK_THAT(critical_load(0.0), WithinAbs(3.5 - std::sqrt(2.0), 1e-9));
  CHECK(column_under(2.08, 0.0).stability == Stability::stable_in_linear_approximation);
  CHECK(column_under(2.09, 0.0).modes.back().oscillates());
}

TEST_CASE("with little and equal damping Ziegler's column flutters at 41/28 already") {
  // P(c) = 41/28 + c²/2, as the Routh-Hurwitz determinant of the quartic says; at c = 1e-3 the second term is 5e-7.
  CHECK_THAT(critical_load(1e-3), WithinAbs(41.0 / 28.0, 1e-6));
  CHECK(column_under(1.46, 1e-3).stability == Stability::asymptotically_stable);
  CHECK(column_under(1.47, 1e-3).stability == Stability::unstable);
}

TEST_CASE("a sleeping top is stable if and only if (I3 w3)^2 > 4 I1 m g l") {
  const Top top;
  for (const double part : {0.99, 1.01}) {
    const double spin = std::sqrt(part * 4.0 * top.I1 * top.mgl) / top.I3;
    const auto s = scene(mechanical_system<3>(top));
    const auto asleep = steady_motion_near(s, Vector3d(0.0, 0.0, 0.5), Vector3d(0.0, 0.0, spin));
    const DampedModes modes = damped_modes(linearization(s, asleep));
    // the angle of spin drifts when the spin is a little different; the axis is what stability is asked of
    CHECK(modes.stability == (part < 1.0 ? Stability::unstable : Stability::drifting));
    // I1 λ² ∓ i I3 w λ − m g l = 0
    const double half = 0.5 * top.I3 * spin / top.I1, root = half * half - top.mgl / top.I1;
    const std::complex<double> fast =
        std::complex<double>(0.0, half) +
        (root > 0.0 ? std::complex<double>(0.0, std::sqrt(root)) : std::complex<double>(std::sqrt(-root), 0.0));
    double nearest = 1.0;
    for (const auto& lambda : modes.exponents) nearest = std::min(nearest, std::abs(lambda - fast));
    CHECK(nearest < rounding);
  }
}

TEST_CASE(
    "the bottom of a turning hoop loses its stability at W^2 = g/R, and the bead then swings about cos theta = g/(W^2 "
    "R) with W sin theta") {
  const auto at_bottom = [](double part) {
    scenes::BeadOnHoop hoop{};
    hoop.Omega = std::sqrt(part * hoop.g / hoop.R);
    return damped_modes(linearization(mechanical_system<1>(hoop), State<1>{0.0, {0.0}, {0.0}}));
  };
  CHECK(at_bottom(0.999).stability == Stability::stable_in_linear_approximation);
  CHECK(at_bottom(1.0).stability == Stability::drifting);
  CHECK(at_bottom(1.001).stability == Stability::unstable);
  const scenes::BeadOnHoop hoop{};
  const auto s = scene(mechanical_system<1>(hoop));
  const auto aside = equilibrium_near(s, Vector<double, 1>(1.0));
  CHECK_THAT(std::cos(aside.state.q[0]), WithinRel(hoop.g / (hoop.Omega * hoop.Omega * hoop.R), rounding));
  const DampedModes modes = damped_modes(linearization(s, aside));
  CHECK_THAT(modes.modes[0].frequency(), WithinRel(hoop.Omega * std::sin(aside.state.q[0]), rounding));
}

TEST_CASE("L4 of the restricted three-body problem is stable up to Routh's mass ratio") {
  constexpr double routh = 0.03852089650455139708;  // (1 − √(23/27))/2
  const auto at_L4 = [](double mu) {
    const auto system = mechanical_system<2>(qdot::systems::ThreeBodies{mu});
    return damped_modes(linearization(system, State<2>{0.0, {0.5 - mu, std::sqrt(3.0) / 2.0}, {0.0, 0.0}})).stability;
  };
  CHECK(at_L4(routh * (1.0 - 1e-8)) == Stability::stable_in_linear_approximation);
  CHECK(at_L4(routh * (1.0 + 1e-8)) == Stability::unstable);
}

TEST_CASE("exponents are told from the axis as far as rounding allows, whatever the units") {
  Linearization linear;
  const auto with = [&](const Eigen::MatrixXd& A) {
    linear.A = A;
    linear.drift = Eigen::VectorXd::Zero(A.rows());
    linear.q = linear.qdot = Eigen::VectorXd::Zero(1);
    linear.W = Eigen::MatrixXd::Identity(2, A.rows());
    linear.positions = linear.velocities = 1;
    return damped_modes(linear).stability;
  };
  using M = Eigen::MatrixXd;
  for (const double unit : {1e-6, 1.0, 1e6}) {
    for (const double slow : {1e-10, 0.0, -1e-10}) {
      const Stability expected = slow > 0.0   ? Stability::unstable
                                 : slow < 0.0 ? Stability::asymptotically_stable
                                              : Stability::stable_in_linear_approximation;
      CHECK(with((M(2, 2) << slow, unit, -1.0 / unit, slow).finished()) == expected);
    }
    CHECK(with((M(2, 2) << 0, unit, 0, 0).finished()) == Stability::drifting);
    CHECK(with((M(2, 2) << 0, unit, 0, -1.0).finished()) == Stability::stable_in_linear_approximation);
    CHECK(with((M(2, 2) << -1.0, unit, 0, -1.0).finished()) == Stability::asymptotically_stable);
  }
  CHECK_THROWS_AS(frequency_response(linear, 1.0), InvalidValue);
  linear.autonomous = false;
  CHECK_THROWS_WITH(damped_modes(linear), Catch::Matchers::StartsWith("damped_modes: A must be the same at all times, but it changes with t"));
}
