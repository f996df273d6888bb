// SPDX-License-Identifier: MIT
#include "catch2_bridge.hpp"

#include <cmath>
#include <limits>

#include "error_message.hpp"
#include "qdot/analysis/steady_state.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "qdot/effects/forces.hpp"
#include "scenes/heavy_top.hpp"

using namespace qdot;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// Newton's method with exact slopes ends at the rounding of well-conditioned equations.
constexpr double rounding = 1e-12;

// A mass in the vertical plane under a wind from the side, one that may shake, and drag in x.
struct Wind {
  double F = 0.0, shake = 0.0;
  auto operator()(const auto& q, const auto& v, const auto& t) const {
    using std::sin;
    auto Q = q;
    Q[0] = F - 0.3 * v[0];
    Q[1] = shake * sin(t);
    return Q;
  }
};
struct Mass {
  double g = 9.81, k = 0.0;  // a spring that pulls y to 0
  auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  auto V(const auto& q) const { return g * q[1] + 0.5 * k * q[1] * q[1]; }
};

// 0 where (x, y) is at the distance l from the origin; x = 3 where l is 0
struct Rod {
  double l;
  auto operator()(const auto& q) const {
    auto phi = 0.5 * (q[0] * q[0] + q[1] * q[1] - l * l);
    if (l == 0.0) phi = q[0] - 3.0;
    return phi;
  }
};
auto on_rods(double F, double l, double other) {
  return scene(mechanical_system<2>(Mass{}), holonomic("rod", Rod{l}), holonomic("other", Rod{other}),
               generalized_force(Wind{.F = F}));
}
auto in_the_wind(Mass mass, Wind wind) { return scene(mechanical_system<2>(mass), generalized_force(wind)); }

// holds q at 0.4
struct Integrating {
  Vector<double, 1> initial_state() const { return Vector<double, 1>::Zero(); }
  template <class S>
  Vector<S, 1> force(const Vector<S, 1>& q, const Vector<S, 1>& v, const Vector<S, 1>& z, const S&) const {
    return Vector<S, 1>(-5.0 * (q[0] - 0.4) - 2.0 * v[0] + z[0]);
  }
  template <class S>
  Vector<S, 1> state_rate(const Vector<S, 1>& q, const Vector<S, 1>&, const Vector<S, 1>&, const S&) const {
    return Vector<S, 1>(0.4 - q[0]);
  }
};

}  // namespace

TEST_CASE(
    "a pendulum in the wind rests at tan theta = F/mg, and its rod carries the resultant, however often it is written "
    "down") {
  const double F = 4.0, l = 1.3;
  const auto s = on_rods(F, l, l);
  const auto found = equilibrium_near(s, Vector2d(0.3, -1.0));
  const double resultant = std::hypot(F, 9.81);
  CHECK_THAT(found.state.q[0], WithinRel(l * F / resultant, rounding));
  CHECK_THAT(found.state.q[1], WithinRel(-l * 9.81 / resultant, rounding));
  CHECK_THAT(found.lambda.sum() * l, WithinRel(-resultant, rounding));  // J = (x, y), so Jᵀλ pulls towards the hinge
  CHECK(found.redundant == 1);
  // near the top there is the other one
  CHECK_THAT(equilibrium_near(s, Vector2d(-0.3, 1.0)).state.q[0], WithinRel(-l * F / resultant, rounding));
}

TEST_CASE("a controller's own state comes to rest, too: an integrator holds a weight without error") {
  const auto s = scene(mechanical_system<1>([](const auto& v) { return 1.5 * v[0] * v[0]; },
                                            [](const auto& q) { return 3.0 * 9.81 * q[0]; }),
                       Integrating{});
  const auto found = equilibrium_near(s, Vector<double, 1>(0.0));
  CHECK_THAT(found.state.q[0], WithinRel(0.4, rounding));
  CHECK_THAT(found.z[0], WithinRel(3.0 * 9.81, rounding));
}

TEST_CASE("a cyclic coordinate keeps the value that it started with") {
  const auto found = equilibrium_near(in_the_wind({.k = 20.0}, {}), Vector2d(7.0, 0.4));
  CHECK(found.state.q[0] == 7.0);
  CHECK_THAT(found.state.q[1], WithinRel(-9.81 / 20.0, rounding));
}

TEST_CASE("what falls freely drifts steadily in the wind at F/c only if something holds it up") {
  const auto found = steady_motion_near(in_the_wind({.k = 20.0}, {.F = 1.2}), Vector2d(7.0, 0.4), Vector2d(4.0, 0.0));
  CHECK_THAT(found.state.q[1], WithinRel(-9.81 / 20.0, rounding));
  CHECK_THROWS_AS(steady_motion_near(in_the_wind({}, {.F = 1.2}), Vector2d(7.0, 0.4), Vector2d(4.0, 0.0)),
                  InvalidValue);
}

TEST_CASE("a top precesses steadily where I1 cos theta phi'^2 - I3 w phi' + m g l = 0") {
  const scenes::HeavyTop top{};
  const auto system = mechanical_system<3>(top);
  const double slow = 0.9, spin = 3.42;
  const auto found = steady_motion_near(system, Vector3d(0.6, 0.0, 0.0), Vector3d(0.0, slow, spin));
  const double c = std::cos(found.state.q[0]);
  const double w = spin + slow * c;
  CHECK_THAT(top.I1 * c * slow * slow - top.I3 * w * slow + top.m * top.g * top.l, WithinAbs(0.0, rounding));
  CHECK(c > 0.5);
  // with too much spin no angle does, and the search ends where Euler's angles do
  CHECK_THROWS_AS(steady_motion_near(system, Vector3d(0.6, 0.0, 0.0), Vector3d(0.0, slow, 4.0)), SingularMassMatrix);
}

TEST_CASE("what cannot rest is told so, with what is left and of which coordinate") {
  const auto falling = in_the_wind({}, {});
  CHECK_THROWS_WITH(equilibrium_near(falling, Vector2d(0.0, 1.0)),
                    "equilibrium_near: all accelerations must vanish somewhere near the start, but where the search "
                    "ended, at (q0 = 0, q1 = 1), the "
                    "acceleration of q1 is -9.81; start closer, or ask whether this scene can rest at all");
  CHECK_THROWS_AS(equilibrium_near(on_rods(0.0, 1.0, 0.0), Vector2d(0.9, 0.1)), Error);
  CHECK_THROWS_WITH(equilibrium_near(falling, Vector2d(0.0, std::numeric_limits<double>::quiet_NaN())),
                    "equilibrium_near: the start must be finite, but q1 is not; give every entry a number");
  CHECK_THROWS_AS(equilibrium_near(falling, Eigen::VectorXd::Zero(3).eval()), DimensionError);
}

TEST_CASE("what depends on the time, or on a coordinate that turns, is no steady motion") {
  CHECK_THROWS_WITH(equilibrium_near(in_the_wind({.k = 1.0}, {.shake = 1.0}), Vector2d(0.0, 0.1)),
                    "equilibrium_near: nothing may depend on the time, but the acceleration of q1 changes by 0.841471 "
                    "within a time of 1; fix the time in what "
                    "takes it, or choose coordinates that move along");
  CHECK_THROWS_WITH(steady_motion_near(in_the_wind({.k = 20.0}, {}), Vector2d(0.0, 0.1), Vector2d(0.0, 0.5)),
                    "steady_motion_near: a coordinate that turns must be cyclic, but the acceleration of q1 changes "
                    "with q1 by -20 per unit; give q1 the rate 0, or "
                    "choose coordinates in which the motion looks the same at all times");
}

TEST_CASE("what falls rests on its floor, what hangs leaves it, and friction holds what it can") {
  const auto weight = [](double k) {  // on a spring whose other end is at the height 1
    return scene(qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                            [k](const auto& q) { return 9.81 * q[0] + 0.5 * k * (q[0] - 1.0) * (q[0] - 1.0); }),
                 qdot::contact("floor", [](const auto& q) { return q[0]; }));
  };
  const qdot::Vector<double, 1> above(0.7), on(0.0);
  for (const auto& start : {above, on}) {
    CAPTURE(start[0]);
    const auto fallen = equilibrium_near(weight(0.0), start), lies = equilibrium_near(weight(2.0), start), hangs = equilibrium_near(weight(20.0), start);
    CHECK(std::abs(fallen.state.q[0]) < 1e-12);
    CHECK(std::abs(fallen.lambda[0] - 9.81) < 1e-12);
    CHECK(std::abs(lies.state.q[0]) < 1e-12);
    CHECK(std::abs(lies.lambda[0] - (9.81 - 2.0)) < 1e-12);
    CHECK(lies.z[0] == 1.0);
    CHECK(std::abs(hangs.state.q[0] - (1.0 - 9.81 / 20.0)) < 1e-12);
    CHECK(hangs.z[0] == 0.0);
  }
  const auto block = [](double F) {
    return scene(qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 5.0 * q[0] * q[0]; }),
                 qdot::dry_friction("pad", 0, F));
  };
  const auto held = equilibrium_near(block(3.0), qdot::Vector<double, 1>(0.2));
  CHECK(held.state.q[0] == 0.2);
  CHECK(std::abs(held.lambda[0] - 2.0) < 1e-12);
  CHECK(qdot::error_message([&] { equilibrium_near(block(1.5), qdot::Vector<double, 1>(0.2)); }).find("'pad' would have to hold 2 and holds up to 1.5") !=
        std::string::npos);
}

namespace {

// Masses m in the vertical plane at (q₂ᵢ, q₂ᵢ₊₁), each on a rod of length l that hangs from the one before.
struct HangingMasses {
  Eigen::Index n;
  double m, g;
  auto T(const auto& v) const { return 0.5 * m * v.squaredNorm(); }
  auto V(const auto& q) const {
    auto height = 0.0 * q[0];
    for (Eigen::Index i = 0; i < n; ++i) height = height + q[2 * i + 1];
    return m * g * height;
  }
};
struct HangingRods {
  Eigen::Index n;
  double l;
  bool twice = false;
  template <class Q>
  auto operator()(const Q& q) const {
    using S = typename Q::Scalar;
    Vector<S, Dynamic> phi(twice ? n + 1 : n);
    for (Eigen::Index i = 0; i < n; ++i) {
      S x = q[2 * i], y = q[2 * i + 1];
      if (i > 0) {
        x = x - q[2 * i - 2];
        y = y - q[2 * i - 1];
      }
      phi[i] = 0.5 * (x * x + y * y - l * l);
    }
    if (twice) phi[n] = 3.0 * phi[0];
    return phi;
  }
};

void check_that_rods_hang(Eigen::Index n, double l, double m, double g, bool twice = false) {
  INFO(n << " rods of length " << l);
  const auto hanging = scene(mechanical_system(2 * n, HangingMasses{n, m, g}), holonomic("rods", HangingRods{n, l, twice}));
  Eigen::VectorXd start(2 * n), straight(2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    start[2 * i] = l * (n > 5 ? 0.02 : 0.2) * std::sin(1.0 + static_cast<double>(i));
    start[2 * i + 1] = -0.97 * l * static_cast<double>(i + 1);
    straight[2 * i] = 0.0;
    straight[2 * i + 1] = -l * static_cast<double>(i + 1);
  }
  const auto found = equilibrium_near(hanging, start);
  CHECK((found.state.q - straight).cwiseAbs().maxCoeff() <= rounding * l);
  CHECK_THAT((found.lambda[0] + (twice ? 3.0 * found.lambda[n] : 0.0)) * l, WithinRel(-static_cast<double>(n) * m * g, 1e3 * rounding));
  CHECK(found.redundant == (twice ? 1 : 0));
  CHECK((equilibrium_near(hanging, straight).state.q - straight).cwiseAbs().maxCoeff() <= rounding * l);
}

}  // namespace

TEST_CASE("rods in Cartesian coordinates hang straight down, however many, in whatever units, and the first carries all") {
  for (const Eigen::Index n : {1, 2, 3, 5, 12}) {
    check_that_rods_hang(n, 1.0, 0.7, 9.81);
    check_that_rods_hang(n, 1e-10, 1e-26, 1e15);
    check_that_rods_hang(n, 1e11, 1e30, 1e-3);
  }
  check_that_rods_hang(3, 1.0, 0.7, 9.81, true);
  check_that_rods_hang(60, 1.0, 0.7, 9.81);
}
