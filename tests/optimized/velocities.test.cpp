// SPDX-License-Identifier: MIT
//
// Velocities inside T, against nested duals, which differentiate the whole of T twice. More of them are in tests/ways/velocities.test.cpp.
#include "qdot/mechanics/velocity.hpp"

#include "catch2_bridge.hpp"
#include "qdot/mechanics/rigid_body.hpp"
#include "systems/velocities_in_T.hpp"

using namespace qdot;
using test::difference, test::Turning;

namespace {

constexpr double rounded = 1e-12;  // times the condition of M, which is moderate

// A function of velocities, of which the value alone is asked for: what q̇ does to T must not get lost.
struct OfVelocities {
  auto T(const auto& q, const auto& v) const {
    const auto square = value_and_velocity_of([](const auto& x) { return (1.0 + x[1] * x[1]) * x[0] * x[0]; }, v, q).value;
    return 0.5 * (v[0] * v[0] + (1.0 + q[0] * q[0]) * v[1] * v[1]) + 0.1 * square;
  }
  auto V(const auto& q) const { return 0.3 * q[0] * q[1]; }
};

// Positions that hold what they should be given: the coordinate and the velocity are constants along the motion, and T depends on them.
struct Captured {
  auto T(const auto& q, const auto& v) const {
    const typename std::decay_t<decltype(q)>::Scalar length(1.5);
    const auto there = velocity_of([&](const auto& x) { return vector(length * x[0] * q[1], x[1] * v[0]); }, q, v);
    return 0.5 * there.squaredNorm() + 0.5 * (v[0] * v[0] + v[1] * v[1]);
  }
  auto V(const auto& q) const { return 0.3 * q[0] * q[1]; }
};

// A point on a moving circle. Twice its velocity is the rate of nothing that is there: it goes by duals, and T is four times as large.
template <int times>
struct Swung {
  auto T(const auto& q, const auto& v, const auto& t) const {
    using std::cos, std::sin;
    const auto place = [](const auto& x, const auto& s) { return vector(x[1] * sin(x[0]) + 0.3 * sin(s), -x[1] * cos(x[0])); };
    if constexpr (times == 1) return 0.5 * velocity_of(place, q, v, t).squaredNorm() + 0.1 * v[1] * v[1];
    else return 0.125 * velocity_of([&](const auto& x) { return place(x, 0.0 * x[0]); }, q, (2.0 * v).eval()).squaredNorm() + 0.1 * v[1] * v[1];
  }
  auto V(const auto& q) const { return 0.5 * q[1] * q[1]; }
};

// One coordinate: twice its velocity, a coordinate that is captured, and a velocity that is.
enum class Which { swung, coordinate, velocity };
template <Which which>
struct OfOne {
  auto T(const auto& q, const auto& v) const {
    using std::cos, std::sin;
    if constexpr (which == Which::swung) {
      return 0.125 * velocity_of([](const auto& x) { return vector(sin(x[0]), x[0] * cos(x[0])); }, q, (2.0 * v).eval()).squaredNorm();
    } else {
      const auto held = which == Which::coordinate ? q[0] : v[0];
      return 0.5 * v[0] * v[0] + 0.1 * velocity_of([&](const auto& x) { return vector(sin(x[0]) * held, cos(x[0])); }, q, v).squaredNorm();
    }
  }
  auto V(const auto& q) const { return 0.3 * q[0] * q[0]; }
};

// A chain of two, by a function of its own for each link.
struct LinkByLink {
  auto T(const auto& q, const auto& v) const {
    using std::cos, std::sin;
    using S = std::decay_t<decltype(cos(q[0]) * v[0])>;
    S sum(0.0), x(0.0), y(0.0);
    const auto link = [&](int i) {
      x = x + cos(q[i]) * v[i];
      y = y + sin(q[i]) * v[i];
      sum = sum + 0.5 * (x * x + y * y);
    };
    unroll<2>([&](auto i) { link(i); });
    return sum;
  }
  auto V(const auto& q) const {
    using std::cos;
    return -9.81 * (2.0 * cos(q[0]) + cos(q[1]));
  }
};

// A potential that takes one rotation or another.
struct OneOrAnother {
  bool first;
  auto T(const auto& q, const auto& v) const { return 0.5 * (v[0] * v[0] + (1.0 + q[0] * q[0]) * v[1] * v[1] + 2.0 * v[2] * v[2]); }
  auto V(const auto& q) const {
    const auto R = first ? euler_rotation_313(q[0], q[1], q[2]) : euler_rotation_321(q[0], q[1], q[2]);
    return 0.3 * R(2, 0) + 0.4 * R(1, 1);
  }
};

}  // namespace

TEST_CASE("angular velocities and velocities in T give what second derivatives give") {
  CHECK(difference<4>(Turning{}) < rounded);
  CHECK(difference<2>(Swung<1>{}) < rounded);
}

TEST_CASE("the value of a function of velocities keeps what they do to T") { CHECK(difference<2>(OfVelocities{}) < rounded); }

TEST_CASE("what is not the rate of the coordinates in T is differentiated in full") {
  CHECK(difference<2>(Swung<2>{}) < rounded);
  CHECK(difference<2>(Captured{}) < rounded);
  CHECK(difference<1>(OfOne<Which::swung>{}) < rounded);
  CHECK(difference<1>(OfOne<Which::coordinate>{}) < rounded);
  CHECK(difference<1>(OfOne<Which::velocity>{}) < rounded);
}

TEST_CASE("an energy that has a function for its parts is differentiated as any other") { CHECK(difference<2>(LinkByLink{}) < rounded); }

TEST_CASE("rotations of one kind and another are of one type in potentials") {
  CHECK(difference<3>(OneOrAnother{true}) < rounded);
  CHECK(difference<3>(OneOrAnother{false}) < rounded);
}
