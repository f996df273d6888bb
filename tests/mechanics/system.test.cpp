// SPDX-License-Identifier: MIT
#include "../catch2_bridge.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/kinematic_system.hpp"

namespace {

using qdot::KineticSignature;
using qdot::mechanical_system;
using qdot::PotentialSignature;
using qdot::Vector;

const auto constant_inertia = [](const auto& qdot) { return 0.5 * qdot.squaredNorm(); };
const auto scleronomic = [](const auto& q, const auto& qdot) { return 0.5 * q[0] * q[0] * qdot[0] * qdot[0]; };
const auto rheonomic = [](const auto& q, const auto& qdot, const auto& t) { return 0.5 * t * q[0] * qdot[0] * qdot[0]; };
const auto spring = [](const auto& q) { return 0.5 * q[0] * q[0]; };
const auto swept_spring = [](const auto& q, const auto& t) { return 0.5 * t * q[0] * q[0]; };

struct BothEnergies {
  double m = 2.0;
  template <class S>
  S T(const Vector<S, 1>& qdot) const {
    return 0.5 * m * qdot[0] * qdot[0];
  }
  template <class S>
  S V(const Vector<S, 1>& q) const {
    return m * q[0];
  }
};

struct AnyLength {
  double m = 2.0;
  template <class S>
  S T(const Vector<S, qdot::Dynamic>& qdot) const {
    return 0.5 * m * qdot.squaredNorm();
  }
  template <class S>
  S V(const Vector<S, qdot::Dynamic>& q) const {
    return m * q.sum();
  }
};

TEST_CASE("the signature of an energy says what physics there is") {
  const auto a = mechanical_system<1>(constant_inertia, spring);
  const auto b = mechanical_system<1>(scleronomic, swept_spring);
  const auto c = mechanical_system<1>(rheonomic, spring);
  using A = decltype(a);
  using B = decltype(b);
  using C = decltype(c);
  STATIC_REQUIRE(A::kinetic_signature == KineticSignature::velocity);
  STATIC_REQUIRE(A::potential_signature == PotentialSignature::position);
  STATIC_REQUIRE(A::autonomous);
  STATIC_REQUIRE(B::kinetic_signature == KineticSignature::state);
  STATIC_REQUIRE(B::potential_signature == PotentialSignature::position_and_time);
  STATIC_REQUIRE_FALSE(B::autonomous);
  STATIC_REQUIRE(C::kinetic_signature == KineticSignature::state_and_time);
  STATIC_REQUIRE_FALSE(C::autonomous);
  CHECK(a.dof() + b.dof() + c.dof() == 3);
}

// A mass that grows as 1 + t, pushed by a force that grows as t.
struct TimeByDefault {
  template <class Q>
  constexpr auto T(const Q& q, const Q& qdot, typename Q::Scalar t = typename Q::Scalar(0.0)) const {
    return 0.5 * (1.0 + t) * qdot[0] * qdot[0] + 0.0 * q[0];
  }
  template <class Q>
  constexpr auto V(const Q& q, const typename Q::Scalar& t = typename Q::Scalar(0.0)) const {
    return -t * q[0];
  }
};

TEST_CASE("an argument of an energy that has a default is given the time") {
  // d/dt (1 + t) q̇ = t
  const auto acceleration_of = [](const auto& system) {
    using Sys = std::remove_cvref_t<decltype(system)>;
    STATIC_REQUIRE_FALSE(Sys::autonomous);
    const Vector<double, Sys::dof_at_compile_time> q = Eigen::VectorXd::Constant(1, 0.3), v = Eigen::VectorXd::Constant(1, 5.0);
    return acceleration(system, q, v, 3.0)[0];
  };
  const auto T = [](const auto& q, const auto& qdot, const auto& t) { return TimeByDefault().T(q, qdot, t); };
  const auto V = []<class Q>(const Q& q, typename Q::Scalar t = typename Q::Scalar(0.0)) { return -t * q[0]; };
  const auto place = [](const auto& q, auto& bodies) { bodies.point_mass(1.0, q); };
  CHECK(acceleration_of(mechanical_system<1>(TimeByDefault{})) == -0.5);
  CHECK(acceleration_of(mechanical_system<1>(T, V)) == -0.5);
  CHECK(acceleration_of(mechanical_system(1, TimeByDefault{})) == -0.5);
  CHECK(acceleration_of(mechanical_system<1>(constant_inertia, V)) == 3.0);
  CHECK(acceleration_of(qdot::kinematic_system<1>(place, V)) == 3.0);
  CHECK(acceleration_of(qdot::kinematic_system(1, place, V)) == 3.0);
}

TEST_CASE("a pack of arguments after those of the state is given the time") {
  const auto V = [](const auto& q, const auto&... t) { return ((0.0 * q[0]) - ... - (t * q[0])); };
  const auto system = mechanical_system<1>([](const auto& q, const auto& qdot, const auto&...) { return 0.5 * qdot[0] * qdot[0] + 0.0 * q[0]; }, V);
  STATIC_REQUIRE(decltype(system)::kinetic_signature == KineticSignature::state_and_time);
  CHECK(acceleration(system, Vector<double, 1>(0.3), Vector<double, 1>(5.0), 3.0)[0] == 3.0);
  STATIC_REQUIRE(decltype(mechanical_system<1>(constant_inertia))::potential_signature == PotentialSignature::position);
}

TEST_CASE("one object with members T and V, two functors, and T alone all make a system") {
  CHECK(mechanical_system<1>(BothEnergies{3.0}).energies().m == 3.0);
  CHECK(mechanical_system(5, AnyLength{3.0}).energies().m == 3.0);
  CHECK(mechanical_system<1>(scleronomic, spring).dof() == 1);
  CHECK(mechanical_system<3>(constant_inertia).dof() == 3);
  CHECK(mechanical_system(7, constant_inertia).dof() == 7);
}

TEST_CASE("a fixed number of coordinates that the stack does not hold goes to the heap by itself") {
  const auto many = mechanical_system<130>([](const auto& qdot) { return 0.5 * qdot.squaredNorm(); }, [](const auto& q) { return 9.81 * q.sum(); });
  CHECK(many.dof() == 130);
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(130);
  CHECK((qdot::acceleration(many, rest, rest).array() + 9.81).abs().maxCoeff() < 1e-14);
}

TEST_CASE("coordinates bear the user's names, and their velocities too") {
  const auto plain = mechanical_system<2>(constant_inertia);
  CHECK(plain.coordinate_name(1) == "q1");
  CHECK(plain.velocity_name(1) == "qdot1");
  const auto named = plain.with_names({"r", "phi"});
  CHECK(named.coordinate_name(1) == "phi");
  CHECK(named.velocity_name(1) == "phidot");
  CHECK(named.with_indefinite_mass_matrix().coordinate_name(0) == "r");
}

TEST_CASE("a wrong number of names or coordinates is refused") {
  CHECK_THROWS_WITH(mechanical_system<2>(constant_inertia).with_names({"r"}),
                    "the list of coordinate names must have 2 entries, but has 1; give one name for each coordinate");
  CHECK_THROWS_WITH(mechanical_system(0, constant_inertia),
                    "the number of coordinates must be at least 1, but is 0; pass the length of q to "
                    "mechanical_system(n, T, V)");
}

}  // namespace
