// SPDX-License-Identifier: MIT
//
// Energies that are gone through as lists, against the same energies called directly and against equations derived by hand. A build without
// optimization has no straight-line way; here is what does not depend on it, and the rest in tests/ways and tests/optimized.
#include "catch2_bridge.hpp"

#include "bench/chain_energies.hpp"
#include "mechanics/shaken_chain.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/written_out.hpp"

using namespace qdot;

namespace {

// A hundred operations on numbers of order one to a hundred.
constexpr double rounded = 1e-12;

// As many bodies as the object says.
struct SomeMasses {
  double m = 1.0;
  int bodies = 2;
  constexpr auto T(const auto& qdot) const {
    using S = typename std::decay_t<decltype(qdot)>::Scalar;
    S sum(0.0);
    for (int k = 0; k < 2; ++k) sum += 0.5 * (k < bodies ? m : 3.0 * m) * qdot[k] * qdot[k];
    for (int k = 2; k < bodies; ++k) sum += qdot[0] * qdot[0];
    return sum;
  }
  constexpr auto V(const auto& q) const { return 0.5 * q.squaredNorm(); }
};

}  // namespace

TEST_CASE("a written-out system is the same system: energies, accelerations") {
  const ShakenChain chain{.m = 0.3, .l = 2.1, .g = 1.62, .w = 0.7};
  const auto plain = mechanical_system<2>(chain);
  const auto written = mechanical_system<2>(written_out<2>(chain));
  const Vector<double, 2> q(0.4, -0.7), v(1.1, 0.3);
  const double t = 0.6;
  CHECK(kinetic_energy(written, q, v, t) == kinetic_energy(plain, q, v, t));
  CHECK(potential_energy(written, q, t) == potential_energy(plain, q, t));
  CHECK((acceleration(written, q, v, t) - acceleration(plain, q, v, t)).norm() < rounded);
  static_assert(!decltype(written)::autonomous);
}

TEST_CASE("what a lambda captures is what it has when it is written out") {
  const double m = 0.7, k = 12.0;
  const auto written = written_out<1>([=](const auto& v) { return 0.5 * m * v.squaredNorm(); }, [=](const auto& q) { return 0.5 * k * q.dot(q); });
  CHECK(written.replays());
  const double q = 0.2, v = 0.3;
  const auto L = detail::euler_lagrange_of<1>(written, &q, &v, 0.0);
  CHECK(L.h<0>() == m);
  CHECK(L.x<0>() == -k * q);
}

TEST_CASE("an object that does other operations than the compiler met does not go by the list") {
  CHECK(written_out<2>(SomeMasses{}).replays());
  CHECK(written_out<2>(SomeMasses{.m = 5.0}).replays());
  CHECK(!written_out<2>(SomeMasses{.m = 1.0, .bodies = 4}).replays());
  const auto system = mechanical_system<2>(written_out<2>(SomeMasses{.m = 2.0, .bodies = 4}));
  const Vector<double, 2> q(0.4, -0.7), v(1.1, 0.3);
  const Vector<double, 2> a = acceleration(system, q, v);  // M = diag(m + 2·2, m)
  CHECK_THAT(a[0], WithinAbs(-0.4 / 6.0, rounded));
  CHECK_THAT(a[1], WithinAbs(0.7 / 2.0, rounded));
}

TEST_CASE("a list of another object is refused, not used") {
  const auto other = written_out<2>(SomeMasses{.m = 1.0, .bodies = 4});
  const Vector<double, 2> q(0.4, -0.7), v(1.1, 0.3);
  CHECK_THROWS_AS(detail::euler_lagrange_of<2>(other, q.data(), v.data(), 0.0), InvalidValue);
}

// A branch, and a parameter behind a pointer.
struct OneSided {
  constexpr auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  constexpr auto V(const auto& q) const { return q[0] < 0.0 ? 0.5 * q[0] * q[0] : 0.0 * q[0]; }
};
struct Remote {
  const double* k = nullptr;
  constexpr auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  constexpr auto V(const auto& q) const { return 0.5 * *k * q[0] * q[0]; }
};

TEST_CASE("energies that can be written out are told from those that can't") {
  STATIC_REQUIRE(CanBeWrittenOut<bench::LoopedChain, 4>);
  STATIC_REQUIRE_FALSE(CanBeWrittenOut<bench::LoopedChain, 33>);
  STATIC_REQUIRE_FALSE(CanBeWrittenOut<OneSided, 1>);
  STATIC_REQUIRE_FALSE(CanBeWrittenOut<Remote, 1>);
}
