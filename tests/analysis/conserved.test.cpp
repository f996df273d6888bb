// SPDX-License-Identifier: MIT
#include "catch2_bridge.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "qdot/analysis/conserved.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/mechanics/velocity.hpp"
#include "scenes/bead_on_hoop.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/heavy_top.hpp"
#include "scenes/rod_and_ring.hpp"
#include "scenes/spherical_pendulum.hpp"

using namespace qdot;

namespace {

// A point in polar coordinates r, phi in the field of V(r); T by hand, or from positions, in which phi occurs and cancels.
struct Planet {
  bool by_positions = false;
  double push = 0.0;  // F(t) along r, as a potential
  double mu = 1.0;
  double field = 0.0;  // homogeneous, along x

  template <class S>
  S T(const Vector<S, 2>& q, const Vector<S, 2>& v) const {
    using std::cos, std::sin;
    if (!by_positions) return S(0.5 * (v[0] * v[0] + q[0] * q[0] * v[1] * v[1]));
    const auto place = [](const auto& x) { return vector(x[0] * cos(x[1]), x[0] * sin(x[1])); };
    return S(0.5 * velocity_of(place, q, v).squaredNorm());
  }
  template <class S>
  S V(const Vector<S, 2>& q, const S& t) const {
    using std::cos, std::sin, std::sqrt;
    S V = S(-mu / q[0]);
    if (by_positions) V = S(-mu / sqrt(q[0] * cos(q[1]) * q[0] * cos(q[1]) + q[0] * sin(q[1]) * q[0] * sin(q[1])));
    if (field != 0.0) V = S(V - field * q[0] * cos(q[1]));
    if (push != 0.0) V = S(V - push * q[0] * cos(t));
    return V;
  }
};
auto planet(Planet p = {}) { return mechanical_system<2>(p).with_names({"r", "phi"}); }

std::vector<std::string> found(const ConservedQuantities& c) {
  std::vector<std::string> names;
  for (const Conservation& p : c.momenta)
    if (p.found) names.push_back(p.name);
  if (c.jacobi.found) names.push_back(c.jacobi.name);
  if (c.energy.found) names.push_back(c.energy.name);
  return names;
}
using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("a planet keeps its angular momentum and its energy") {
  const auto c = conserved_quantities(planet());
  CHECK(found(c) == Names{"p_phi", "h", "T + V"});
  CHECK(c.cyclic() == std::vector<int>{1});
  CHECK(c.momenta[0].reason == "r occurs in T and V");
  CHECK(c.momenta[1].reason == "phi does not occur in L");
  CHECK(c.energy.reason == "t does not occur in L, and T is a quadratic form of the velocities");
}

TEST_CASE("an angle that occurs in positions and cancels in T is cyclic") {
  const auto c = conserved_quantities(planet({.by_positions = true}));
  CHECK(found(c) == Names{"p_phi", "h", "T + V"});
  CHECK(c.momenta[1].reason == "phi cancels in L: dL/dphi is zero to rounding at scattered points");
}

TEST_CASE("a term that rounding would hide beside others is not overlooked") {
  for (const double field : {1.0, 1e-10, 1e-19}) {
    const auto c = conserved_quantities(planet({.by_positions = true, .mu = 1e44, .field = 1e44 * field}));
    CHECK(found(c) == Names{"h", "T + V"});
  }
}

TEST_CASE("a push that depends on the time takes the energy and leaves the angular momentum") {
  const auto c = conserved_quantities(planet({.push = 0.2}));
  CHECK(found(c) == Names{"p_phi"});
  CHECK(c.jacobi.reason == "t occurs in V");
}

TEST_CASE("an effect takes away what it acts on, and nothing else") {
  // a spring from the origin: along r, and a potential
  const auto radial = generalized_force([](const auto& q, const auto& v) {
    auto Q = q;
    Q[0] = -0.1 * v[0];
    Q[1] = 0.0;
    return Q;
  });
  const auto damped = conserved_quantities(scene(planet(), radial));
  CHECK(found(damped) == Names{"p_phi"});
  CHECK(damped.momenta[1].reason == "phi does not occur in L, and no effect acts on it");
  CHECK(damped.jacobi.reason == "the force of effect 1 does work");

  // no work, but a momentum: a magnetic force, Q = B (r phidot, −r rdot)
  const auto magnetic = generalized_force([](const auto& q, const auto& v) {
    auto Q = q;
    Q[0] = 0.3 * q[0] * v[1];
    Q[1] = -0.3 * q[0] * v[0];
    return Q;
  });
  const auto bent = conserved_quantities(scene(planet(), magnetic));
  CHECK(found(bent) == Names{"h", "T + V"});
  CHECK(bent.momenta[1].reason == "the force of effect 1 acts on phi");

  // the same with a drag that rounding would hide
  const auto dragged = generalized_force([](const auto& q, const auto& v) {
    auto Q = q;
    Q[0] = 3e20 * q[0] * v[1];
    Q[1] = -3e20 * q[0] * v[0] - v[1];
    return Q;
  });
  CHECK(found(conserved_quantities(scene(planet(), dragged))).empty());

  // a ring of radius 2, and the same with a stop in phi and with friction
  const auto ring = holonomic("ring", [](const auto& q) { return q[0] - 2.0; });
  CHECK(found(conserved_quantities(scene(planet(), ring))) == Names{"p_phi", "h", "T + V"});
  const auto drive = conserved_quantities(scene(planet(), ring, prescribed("motor", 1, [](const auto& t) { return 3.0 * t; })));
  CHECK(found(drive).empty());
  CHECK(drive.momenta[1].reason == "the constraint 'motor' acts on phi");
  CHECK(drive.jacobi.reason == "the constraint 'motor' is moved from outside, which does work");
  const auto walls = conserved_quantities(scene(planet(), contact("wall", [](const auto& q) { return 5.0 - q[0]; }), dry_friction("brake", 1, 0.2)));
  CHECK(found(walls).empty());
  CHECK(walls.momenta[1].reason == "the force of 'brake' acts on phi");
  CHECK(walls.jacobi.reason == "'wall': an impact can take energy");
}

TEST_CASE("what the systems of the lecture conserve") {
  const auto top = conserved_quantities(mechanical_system<3>(scenes::HeavyTop{}).with_names({"theta", "phi", "psi"}));
  CHECK(found(top) == Names{"p_phi", "p_psi", "h", "T + V"});
  const auto pendulum = conserved_quantities(mechanical_system<2>(scenes::SphericalPendulum{}).with_names({"theta", "phi"}));
  CHECK(found(pendulum) == Names{"p_phi", "h", "T + V"});
  const auto ring = conserved_quantities(mechanical_system<2>(scenes::RodAndRing{}).with_names({"r", "phi"}));
  CHECK(found(ring) == Names{"h", "T + V"});  // gravity: phi occurs in V
  CHECK(ring.momenta[1].reason == "phi occurs in V");
  CHECK(found(conserved_quantities(mechanical_system<2>(scenes::RodAndRing{.g = 0.0}).with_names({"r", "phi"}))) == Names{"p_phi", "h", "T + V"});
}

TEST_CASE("on a hoop that is driven Jacobi's integral is conserved, and T + V is not found to be") {
  const auto bead = conserved_quantities(mechanical_system<1>(scenes::BeadOnHoop{}).with_names({"theta"}));
  CHECK(found(bead) == Names{"h"});
  CHECK(bead.energy.reason == "T is no quadratic form of the velocities, so that h is another quantity than T + V");
}

TEST_CASE("a double pendulum with damping conserves nothing") {
  const auto damped = conserved_quantities(scene(mechanical_system<2>(scenes::DoublePendulum{}), viscous_damping(Eigen::Vector2d(0.1, 0.0))));
  CHECK(found(damped).empty());
}

TEST_CASE("what branches on the state is not found, and said to be unseen") {
  const auto wall = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); },
                                         [](const auto& q) {
                                           auto V = q[0] * 0.0;
                                           if (q[0] > 1.0) V += q[0] - 1.0;
                                           return V;
                                         });
  const auto c = conserved_quantities(wall);
  CHECK(found(c) == Names{"h"});
  CHECK(c.momenta[1].reason == "T or V asks for signs or sizes of its arguments");
  CHECK(c.jacobi.reason == "neither T nor V takes the time");
}

TEST_CASE("a potential that is flat in floating point is not taken for a constant") {
  const auto step = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                         [](const auto& q) {
                                           using std::tanh;
                                           return tanh(q[0] * 1e9);
                                         });
  CHECK_FALSE(conserved_quantities(step).momenta[0].found);
}

TEST_CASE("a weak term of T that is linear in the velocities is not overlooked beside a strong one") {
  const auto turning = mechanical_system<2>([](const auto& q, const auto& v) { return 5e43 * (v[0] * v[0] + v[1] * v[1]) + 1e20 * q[0] * v[1]; });
  CHECK(found(conserved_quantities(turning)) == Names{"p_q1", "h"});
}

TEST_CASE("the total momentum of three masses on springs is conserved, unless one of them is held") {
  for (const double held : {0.0, 1e-3, 1e-20}) {
    const auto springs = mechanical_system<3>([](const auto& v) { return 0.5 * (v[0] * v[0] + 2.0 * v[1] * v[1] + 3.0 * v[2] * v[2]); },
                                              [held](const auto& q) {
                                                auto V = 0.5 * (q[0] - q[1]) * (q[0] - q[1]) + 0.8 * (q[1] - q[2]) * (q[1] - q[2]);
                                                if (held != 0.0) V += 0.5 * held * q[2] * q[2];
                                                return V;
                                              });
    const auto c = conserved_quantities(springs);
    REQUIRE(c.sums.size() == (held == 0.0 ? 1 : 0));
    if (held == 0.0) CHECK(c.sums[0].name == "p_q0 + p_q1 + p_q2");
    CHECK(conserved_quantities(scene(springs, viscous_damping(Eigen::Vector3d(0.0, 0.1, 0.0)))).sums.empty());
  }
  // a belt without slip between two wheels, as a constraint: q0 - 2 q1 = 0 takes all but p_q0 + p_q1 / 2
  const auto wheels = mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); });
  const auto geared = conserved_quantities(scene(wheels, holonomic("belt", [](const auto& q) { return q[0] - 2.0 * q[1]; })));
  REQUIRE(geared.sums.size() == 1);
  CHECK(geared.sums[0].name == "p_q0 + 0.5 p_q1");
}
