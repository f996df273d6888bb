// SPDX-License-Identifier: MIT
#include "catch2_bridge.hpp"

#include <cmath>
#include <vector>

#include "qdot/analysis/noether.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/forces.hpp"

using namespace qdot;
using Catch::Matchers::EndsWith;
using Catch::Matchers::StartsWith;

namespace {

constexpr double rounding = 1e-13;

// A particle of mass m in the plane: −mu/r, and k x² / 2 along x.
struct Particle {
  double m = 1.0, mu = 0.0, k = 0.0;
  auto T(const auto& v) const { return 0.5 * m * (v[0] * v[0] + v[1] * v[1]); }
  auto V(const auto& q) const {
    using std::sqrt;
    auto V = 0.5 * k * q[0] * q[0];
    if (mu != 0.0) V -= mu / sqrt(q[0] * q[0] + q[1] * q[1]);
    return V;
  }
};
auto particle(Particle p) { return mechanical_system<2>(p).with_names({"x", "y"}); }

struct Rotation {
  auto operator()(const auto& s, const auto& q) const {
    using std::cos, std::sin;
    return vector(q[0] * cos(s) - q[1] * sin(s), q[0] * sin(s) + q[1] * cos(s));
  }
};
struct Boost {  // to a frame that moves along x
  auto operator()(const auto& s, const auto& q, const auto& t) const { return vector(q[0] + s * t, q[1]); }
};

}  // namespace

TEST_CASE("rotation is a symmetry of a central field, and its integral the angular momentum") {
  const auto system = particle({.m = 2.0, .mu = 3.0});
  const auto L = noether_integral(system, Rotation{});
  CHECK_THAT(L(State<2>{0.3, {0.7, -0.4}, {0.2, 1.1}}), WithinRel(2.0 * (0.7 * 1.1 + 0.4 * 0.2), rounding));
  CHECK(L.violation().states == 16);
}

TEST_CASE("an anisotropic field violates rotation by its torque") {
  const auto system = particle({.mu = 3.0, .k = 0.8});
  const State<2> state{0.0, {0.7, -0.4}, {0.2, 1.1}};
  const auto torque = symmetry_violation(system, Rotation{}, NoGauge{}, std::vector<State<2>>{state});
  CHECK_FALSE(torque.is_symmetry());
  CHECK_THAT(torque.rate, WithinRel(0.8 * 0.7 * -0.4, 1e-12));  // −k x times ξ_x = −y
  CHECK_THROWS_WITH(
      noether_integral(system, Rotation{}, NoGauge{}, std::vector<State<2>>{state}),
      StartsWith(
          "noether_integral: the motion must not change under the transformation, but p.dq'/ds - F changes at the rate -0.224, a sum of terms of size"));
}

TEST_CASE("a boost is a symmetry of a free particle with the gauge term m x, and says where it was at t = 0") {
  const auto system = particle({.m = 2.0});
  const auto gauge = [](const auto& q) { return 2.0 * q[0]; };
  const auto I = noether_integral(system, Boost{}, gauge);
  CHECK_THAT(I(State<2>{3.0, {1.0, 0.0}, {0.5, 0.2}}), WithinRel(2.0 * (0.5 * 3.0 - 1.0), rounding));
  CHECK_THROWS_WITH(noether_integral(system, Boost{}), EndsWith("choose a symmetry, or give the gauge term F(q, t) whose rate this is"));
}

TEST_CASE("a force takes a symmetry away, unless it is one that the symmetry does not feel") {
  const auto along_y = generalized_force([](const auto& q, const auto& v) {
    auto Q = q;
    Q[0] = 0.0;
    Q[1] = -0.3 * v[1];
    return Q;
  });
  const auto s = scene(particle({}), along_y);
  const auto shift_x = [](const auto& s1, const auto& q) { return vector(q[0] + s1, q[1]); };
  const auto shift_y = [](const auto& s1, const auto& q) { return vector(q[0], q[1] + s1); };
  CHECK_THAT(noether_integral(s, shift_x)(State<2>{0.0, {1.0, 2.0}, {0.6, 0.7}}), WithinRel(0.6, rounding));
  CHECK_THROWS_WITH(noether_integral(s, shift_y), StartsWith("noether_integral: the motion must not change under the transformation"));
}

TEST_CASE("a transformation keeps to the constraints, or is refused") {
  const auto bob = scene(particle({}), holonomic("rod", [](const auto& q) { return 0.5 * (q.squaredNorm() - 1.0); }));
  CHECK_THAT(noether_integral(bob, Rotation{})(State<2>{0.0, {0.6, -0.8}, {0.4, 0.3}}), WithinRel(0.5, rounding));
  CHECK_THROWS_WITH(noether_integral(bob, Boost{}), StartsWith("noether_integral: a transformation must keep to the constraints, but at x = "));
}

TEST_CASE("what is the identity at s = 0 nowhere, or moves nothing, is refused") {
  CHECK_THROWS_WITH(noether_integral(particle({}), [](const auto& s, const auto& q) { return vector(q[0] + s + 1.0, q[1]); }),
                    EndsWith("let s = 0 be the identity"));
  CHECK_THROWS_WITH(noether_integral(particle({}), [](const auto&, const auto& q) { return vector(q[0], q[1]); }), EndsWith("let q' depend on s"));
}
