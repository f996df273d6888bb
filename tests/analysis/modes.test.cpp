// SPDX-License-Identifier: MIT
#include "catch2_bridge.hpp"

#include <cmath>

#include "qdot/analysis/modes.hpp"
#include "scenes/bead_on_hoop.hpp"
#include "scenes/cartpole.hpp"
#include "scenes/chain.hpp"
#include "scenes/coupled_oscillators.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/elastic_pendulum.hpp"
#include "scenes/rod_and_ring.hpp"
#include "systems/three_bodies.hpp"

using namespace qdot;
using Eigen::Vector2d;

namespace {

// Eigenvalues of small, well-conditioned symmetric matrices, relative.
constexpr double rounding = 1e-13;
// Published digits: twelve.
constexpr double printed = 5e-12;

// L_n(x) and L_n'(x) from (k+1) L_{k+1} = (2k+1−x) L_k − k L_{k−1} and x L_n' = n (L_n − L_{n−1}).
struct Laguerre {
  long double value, slope;
};
Laguerre laguerre(int n, long double x) {
  long double before = 1.0L, here = 1.0L - x;
  for (int k = 1; k < n; ++k) {
    const long double next = ((2.0L * k + 1.0L - x) * here - k * before) / (k + 1.0L);
    before = here;
    here = next;
  }
  return {here, n * (here - before) / x};
}

// The i-th zero (from 0) by bisection between sign changes, then Newton: long double throughout.
std::vector<long double> laguerre_zeros(int n) {
  std::vector<long double> zeros;
  constexpr long double step = 1e-3L;
  for (long double x = step; static_cast<int>(zeros.size()) < n; x += step) {
    const long double a = laguerre(n, x).value, b = laguerre(n, x + step).value;
    if (a * b > 0.0L) continue;
    long double zero = x + 0.5L * step;
    for (int i = 0; i < 20; ++i) {
      const Laguerre at = laguerre(n, zero);
      zero -= at.value / at.slope;
    }
    zeros.push_back(zero);
  }
  return zeros;
}

}  // namespace

TEST_CASE("the n-link chain swings at the zeros of the Laguerre polynomial L_n") {
  for (int n = 1; n <= 8; ++n) {
    const scenes::Chain chain{.n = n, .m = 0.7, .l = 1.3, .g = 9.81};
    const auto system = mechanical_system(n, chain);
    const auto modes = normal_modes(system, Eigen::VectorXd::Zero(n));
    const std::vector<long double> zeros = laguerre_zeros(n);
    for (int i = 0; i < n; ++i) {
      const double expected = static_cast<double>(zeros[static_cast<std::size_t>(i)]);
      CHECK_THAT(modes.squared_frequencies[i] * chain.l / chain.g, WithinRel(expected, rounding));
    }
  }
}

TEST_CASE("the zeros that the test computes are the published ones") {
  const auto three = laguerre_zeros(3), five = laguerre_zeros(5), eight = laguerre_zeros(8);
  const auto check = [](long double zero, double digits) { CHECK_THAT(static_cast<double>(zero), WithinAbs(digits, printed)); };
  check(three[0], 0.415774556783);
  check(three[1], 2.294280360279);
  check(three[2], 6.289945082937);
  check(five[0], 0.263560319718);
  check(five[1], 1.413403059107);
  check(five[2], 3.596425771041);
  check(five[3], 7.085810005859);
  check(five[4], 12.640800844276);
  check(eight[0], 0.170279632305);
  check(eight[7], 22.863131736889);
}

TEST_CASE("the double pendulum has omega^2 l/g = 2 -+ sqrt 2") {
  const auto system = mechanical_system<2>(scenes::DoublePendulum{});
  const Vector2d omega = normal_modes(system, Vector2d::Zero().eval()).frequencies();
  CHECK_THAT(omega[0], WithinRel(2.39719939786409, rounding));
  CHECK_THAT(omega[1], WithinRel(5.78735129803610, rounding));
}

TEST_CASE("mode shapes are orthogonal with respect to M and K at once") {
  const auto system = mechanical_system(5, scenes::Chain{.n = 5});
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(5);
  const auto motion = small_motion(system, rest);
  const auto modes = normal_modes(system, rest);
  const Eigen::MatrixXd& a = modes.shapes;
  CHECK((a.transpose() * motion.M * a - Eigen::MatrixXd::Identity(5, 5)).norm() < 1e-11);
  const Eigen::MatrixXd stiffness = modes.squared_frequencies.asDiagonal();
  CHECK((a.transpose() * motion.K * a - stiffness).norm() < 1e-11 * stiffness.norm());
}

TEST_CASE("two equal oscillators: in phase the joint is not felt, in antiphase twice") {
  const auto system = mechanical_system<2>(scenes::CoupledOscillators{.m = 1.0, .k = 1.0, .kappa = 1.0});
  const auto modes = normal_modes(system, Vector2d::Zero().eval());
  CHECK_THAT(modes.squared_frequencies[0], WithinRel(1.0, rounding));
  CHECK_THAT(modes.squared_frequencies[1], WithinRel(3.0, rounding));
  CHECK_THAT(modes.shapes(0, 0), WithinAbs(modes.shapes(1, 0), rounding));
  CHECK_THAT(modes.shapes(0, 1), WithinAbs(-modes.shapes(1, 1), rounding));
}

TEST_CASE("a pendulum on a cart: the cart's drift has frequency zero, the other mode that of the book") {
  const auto system = mechanical_system<2>(scenes::Cartpole{});
  const Vector2d omega2 = normal_modes(system, Vector2d(7.0, 0.0)).squared_frequencies;
  CHECK_THAT(omega2[0], WithinAbs(0.0, rounding));
  CHECK_THAT(std::sqrt(omega2[1]), WithinRel(3.83601355576333, rounding));
}

TEST_CASE("the elastic pendulum hangs at l0 + mg/k and is in 2:1 resonance at k = 3 mg/l0") {
  const auto system = mechanical_system<2>(scenes::ElasticPendulum{});
  const Vector2d q = equilibrium_near(system, Vector2d(1.0, 0.2));
  CHECK_THAT(q[0], WithinRel(4.0 / 3.0, rounding));
  CHECK_THAT(q[1], WithinAbs(0.0, rounding));
  const Vector2d omega = normal_modes(system, q).frequencies();
  CHECK_THAT(omega[0], WithinRel(2.71247119800377, rounding));
  CHECK_THAT(omega[1], WithinRel(5.42494239600754, rounding));
}

TEST_CASE("the bead on a turning hoop leaves the bottom for cos theta = g/(Omega^2 R)") {
  const auto system = mechanical_system<1>(scenes::BeadOnHoop{});
  using V1 = Vector<double, 1>;
  CHECK_THAT(normal_modes(system, V1(0.0)).squared_frequencies[0], WithinRel(9.81 - 25.0, rounding));
  CHECK_THROWS_AS(normal_modes(system, V1(0.0)).frequencies(), InvalidValue);
  const V1 q = equilibrium_near(system, V1(1.0));
  CHECK_THAT(q[0], WithinRel(1.16755690380504, rounding));
  CHECK_THAT(normal_modes(system, q).frequencies()[0], WithinRel(4.59897336369760, rounding));
}

TEST_CASE("Lagrange's point L4 has the two frequencies of celestial mechanics, and loses them above Routh's mass ratio") {
  const auto three_bodies = [](double mu) { return mechanical_system<2>(qdot::systems::ThreeBodies{mu}); };
  const double mu = 0.012150585;
  const auto system = three_bodies(mu);
  const Vector2d L4 = equilibrium_near(system, Vector2d(0.45, 0.9));
  CHECK_THAT(L4[0], WithinAbs(0.5 - mu, rounding));
  CHECK_THAT(L4[1], WithinAbs(std::sqrt(3.0) / 2.0, rounding));
  CHECK_THROWS_AS(normal_modes(system, L4), InvalidValue);  // gyroscopic
  const Eigen::VectorXcd lambda = characteristic_exponents(system, L4);
  CHECK_THAT(lambda[3].imag(), WithinRel(0.95450085930080, 1e-12));
  CHECK_THAT(lambda[2].imag(), WithinRel(0.29820816486816, 1e-12));
  CHECK(lambda.real().cwiseAbs().maxCoeff() < 1e-12);
  const double critical = 0.03852089650455;
  for (const double factor : {0.99, 1.01}) {
    const Vector2d point(0.5 - factor * critical, std::sqrt(3.0) / 2.0);
    const double growth = characteristic_exponents(three_bodies(factor * critical), point).real().maxCoeff();
    CHECK((growth > 1e-3) == (factor > 1.0));
  }
}

TEST_CASE("a point that is no equilibrium is refused with the force there") {
  const auto system = mechanical_system<2>(scenes::RodAndRing{});
  CHECK_THROWS_AS(normal_modes(system, Vector2d(0.4, 0.2)), InvalidValue);
  // the endless rod has no bottom along r when it hangs: no equilibrium but r = −ML/2m, φ = 0, where moments balance
  const Vector2d q = equilibrium_near(system, Vector2d(-4.0, 0.1));
  CHECK_THAT(q[0], WithinRel(-5.0, rounding));
  CHECK_THAT(q[1], WithinAbs(0.0, rounding));
}

TEST_CASE("a potential through the length of q has the Hessian that it has: 2 r^2 and r^3 at 0, and r has none") {
  const auto of_length = [](double square, double cube, double length) {
    return mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); },
                                [=](const auto& q) {
                                  const auto r = vector(q[0] - 1e-10, q[1]).norm();
                                  return square * r * r + cube * r * r * r + length * r;
                                });
  };
  for (const double square : {2.0, 2e-26}) {
    const auto system = of_length(square, square, 0.0);
    const Vector2d at = equilibrium_near(system, Vector2d(1e-10, 0.0)), omega2 = normal_modes(system, at).squared_frequencies;
    CHECK(at == Vector2d(1e-10, 0.0));
    for (const double each : omega2) CHECK_THAT(each, WithinRel(2.0 * square, 1e-9));  // a cube of 2⁻⁴⁰ of the place is left
  }
  CHECK((equilibrium_near(of_length(2.0, 0.0, 0.0), Vector2d(0.3, 0.1)) - Vector2d(1e-10, 0.0)).norm() < rounding);
  CHECK_THROWS_WITH(normal_modes(of_length(1.0, 0.0, 1.0), Vector2d(1e-10, 0.0)),
                    "small_motion: the derivatives of the force at rest must be finite, but that on q0 has none with q0 where q0 = 1e-10; look there for the "
                    "root or the length of something that is zero, and round it off, as sqrt(x*x + e*e) does");
}

TEST_CASE("a system that cannot rest is told so") {
  const auto falling = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 9.81 * q[0]; });
  CHECK_THROWS_WITH(equilibrium_near(falling, Vector<double, 1>(0.0)),
                    "equilibrium_near: the generalized force at rest must vanish somewhere near the start, but the search ended at "
                    "q = (0) with dL/dq = (-9.81); start closer, or ask whether this system can rest at all");
}

namespace {

// Two atoms of mass m on a line, with Morse's potential D (1 − exp(−a (r − r₀)))² of their distance.
struct Morse {
  double m, D, a, r0;
  auto T(const auto& v) const { return 0.5 * m * (v[0] * v[0] + v[1] * v[1]); }
  auto V(const auto& q) const {
    using std::exp;
    const auto e = 1.0 - exp(-a * (q[1] - q[0] - r0));
    return D * e * e;
  }
};
// A bond of length r₀ and an angle θ₀ on springs: metres and radians side by side.
struct Bond {
  double m, k, bend, r0, angle;
  auto T(const auto& v) const { return 0.5 * m * (v[0] * v[0] + r0 * r0 * v[1] * v[1]); }
  auto V(const auto& q) const { return 0.5 * k * (q[0] - r0) * (q[0] - r0) + 0.5 * bend * (q[1] - angle) * (q[1] - angle); }
};

}  // namespace

TEST_CASE("two atoms rest at r0 and swing with omega^2 = 4 D a^2/m in whatever units, and 5 % off they do not rest") {
  for (const double length : {1.0, 1e-10, 1e11}) {
    const Morse atoms{1.6e-27 / length, 7e-19 * length, 1.9 / length, 0.74 * length};
    const auto system = mechanical_system<2>(atoms);
    const Vector2d q = equilibrium_near(system, Vector2d(0.1 * length, 0.95 * length));
    CHECK_THAT(q[1] - q[0], WithinRel(atoms.r0, rounding));
    CHECK_THAT(q[0] + q[1], WithinRel(1.05 * length, rounding));  // nothing holds the centre
    const auto modes = normal_modes(system, q);
    CHECK_THAT(modes.squared_frequencies[1], WithinRel(4 * atoms.D * atoms.a * atoms.a / atoms.m, rounding));
    CHECK_THROWS_AS(normal_modes(system, Vector2d(0.0, 1.05 * atoms.r0)), InvalidValue);
    CHECK_THROWS_AS(normal_modes(system, Vector2d(0.0, 1.0001 * atoms.r0)), InvalidValue);
  }
}

TEST_CASE("a bond in metres and its angle in radians are found and swing to the same digits") {
  const Bond water{1e-26, 700.0, 7e-19, 1e-10, 1.8};
  const auto system = mechanical_system<2>(water);
  const Vector2d q = equilibrium_near(system, Vector2d(1.3e-10, 1.5));
  CHECK_THAT(q[0], WithinRel(water.r0, rounding));
  CHECK_THAT(q[1], WithinRel(water.angle, rounding));
  const auto squares = normal_modes(system, q).squared_frequencies;
  CHECK_THAT(squares[0], WithinRel(water.bend / (water.m * water.r0 * water.r0), rounding));
  CHECK_THAT(squares[1], WithinRel(water.k / water.m, rounding));
}
