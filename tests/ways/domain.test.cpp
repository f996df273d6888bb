// SPDX-License-Identifier: MIT
//
// Where an energy has no value there is no acceleration, and where an acceleration has no derivative there is no Jacobian, by whichever door the
// energies came in. By the ways that exist with the optimizer on, where all doors do.
#include "catch2_bridge.hpp"

#include <cmath>
#include <string>

#include "qdot/mechanics/acceleration_jacobian.hpp"
#include "qdot/mechanics/kinematic_system.hpp"

using namespace qdot;
using Eigen::Vector2d;

namespace {

constexpr double rounded = 1e-14;  // of a dozen operations

// Unit masses. A spring that cannot be longer than R pulls the first one: its force k q/(1 − q²/R²) is a number beyond R too, where V has none. What
// acts upon the second is simpler where it has a value, and has an edge where q is zero, but for b = 0.
struct FiniteSpring {
  double k = 2.0, R = 1.5, b = 1.0;
  constexpr auto T(const auto& v) const { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }
  constexpr auto V(const auto& q) const {
    using std::log, std::pow, std::sqrt;
    return -0.5 * k * R * R * log(1.0 - q[0] * q[0] / (R * R)) + pow(sqrt(1.0 + q[1]), 2) + pow(b * b * q[1] * q[1], 0.75);
  }
};
const Vector2d within(1.2, 0.5), outside(1.6, -1.5), at_the_edge(1.2, 0.0);

// Whatever else has a slope where it has no value, and a root in T.
struct Functions {
  double a = 1.0;
  constexpr auto T(const auto& q, const auto& v) const {
    using std::sqrt;
    const auto root = sqrt(q[0]);
    return 0.5 * (1.0 + a * root * root) * v.squaredNorm();
  }
  constexpr auto V(const auto& q) const {
    using std::acos, std::acosh, std::asin, std::atanh, std::log1p, std::pow;
    return a * (atanh(q[1]) + asin(q[2]) - acos(q[3]) + log1p(q[4]) + acosh(q[5]) + q[6] * q[6] / q[6] + pow(pow(q[7], -1.0), -1.0));
  }
};

// What the doors are given has one type each, whatever f is: each system is compiled once.
template <class E>
struct PotentialOf {
  E e;
  auto operator()(const auto& q) const { return e.V(q); }
};
const auto T = [](const auto& v) { // a loop that the compiler does not see through
  auto sum = 0.5 * v[0] * v[0];
  for (Eigen::Index i = 1; i < v.size(); ++i) sum += 0.5 * v[i] * v[i];
  return sum;
};
const auto as_a_point = [](const auto& q, auto& bodies) { bodies.point_mass(1.0, vector(q[0], q[1])); };

// f(system, q) for each way to give the energies to the library.
template <class E, class F>
void for_each_door(const E& e, const Vector2d& at, const F& f) {
  const PotentialOf<E> V{e};
  f("as it is", mechanical_system<2>(e), at);
  f("with a loop", mechanical_system<2>(T, V), at);
  for (const int n : {2, 40}) {
    Eigen::VectorXd q = Eigen::VectorXd::Zero(n);
    q[0] = at[0];
    q[1] = at[1];
    f(n == 2 ? "of run-time size" : "of many coordinates", mechanical_system(n, T, V), q);
  }
  f("as positions", kinematic_system<2>(as_a_point, V), at);
}

// What acceleration() or its derivative calls not finite.
template <class F>
std::string blamed(const F& evaluate) {
  try {
    return std::to_string(evaluate());
  } catch (const NonFinite& error) {
    return error.component();
  }
}

}  // namespace

TEST_CASE("no door gives an acceleration where V has no value, and all give it where it has one") {
  const FiniteSpring spring;
  for (int i = 0; i < 2; ++i) {
    Vector2d at = within;
    at[i] = outside[i];
    for_each_door(spring, at, [&](const std::string& door, const auto& system, const auto& q) {
      INFO(door << ", coordinate " << i);
      CHECK(blamed([&] { return acceleration(system, q, decltype(acceleration(system, q, q))(0.1 * q))[0]; }) == "V");
    });
  }
  for_each_door(spring, within, [&](const std::string& door, const auto& system, const auto& q) {
    INFO(door);
    auto rest = q;
    rest.setZero();
    const double s = within[0] / spring.R, pull = spring.k * within[0] / (1.0 - s * s);
    const Vector2d expected(-pull, -1.0 - 1.5 * std::sqrt(within[1]));
    CHECK((acceleration(system, q, rest).head(2) - expected).norm() < rounded * pull);
    const double stiffness = spring.k * (1.0 + s * s) / ((1.0 - s * s) * (1.0 - s * s));
    CHECK_THAT(acceleration_jacobian(system, q, rest).d_q(0, 0), WithinAbs(-stiffness, 10 * rounded * stiffness));
  });
}

TEST_CASE("there are accelerations where all functions of the energies have values, and nowhere else") {
  const auto derives = [](const auto& system, const auto& q) {
    auto v = q;
    v.setConstant(0.1);
    try {
      return acceleration(system, q, v).allFinite();
    } catch (const NonFinite&) {
      return false;
    }
  };
  const auto spring = mechanical_system<2>(FiniteSpring{});
  CHECK(derives(spring, within));
  CHECK(derives(spring, Vector2d(-1.2, -1.0)));
  const auto functions = mechanical_system<8>(Functions{});
  Vector<double, 8> good, bad;
  good << 0.1, 0.9, -0.9, 0.9, -0.9, 1.1, 0.1, -0.1;
  bad << -0.1, 1.1, -1.1, 1.1, -1.1, -1.1, 0.0, 0.0;
  CHECK(derives(functions, good));
  for (int i = 0; i < 8; ++i) {
    INFO(i);
    auto q = good;
    q[i] = bad[i];
    CHECK(!derives(functions, q));
    if (i >= 2) continue;
    Vector2d at = within;
    at[i] = outside[i];
    CHECK(!derives(spring, at));
  }
}

TEST_CASE("no door gives a Jacobian where an acceleration has no derivative") {
  for_each_door(FiniteSpring{}, at_the_edge, [&](const std::string& door, const auto& system, const auto& q) {
    INFO(door);
    auto rest = q;
    rest.setZero();
    CHECK_THAT(acceleration(system, q, rest)[1], WithinAbs(-1.0, rounded));
    const std::string name = blamed([&] { return acceleration_jacobian(system, q, rest).d_q(1, 1); });
    CHECK(name.find("the derivative of the acceleration of") == 0);
  });
}

TEST_CASE("what is multiplied by zero has no derivative, however steep it would be, by every door") {
  for_each_door(FiniteSpring{.b = 0.0}, at_the_edge, [&](const std::string& door, const auto& system, const auto& q) {
    INFO(door);
    auto rest = q;
    rest.setZero();
    const auto J = acceleration_jacobian(system, q, rest);
    CHECK_THAT(J.qddot[1], WithinAbs(-1.0, rounded));
    CHECK_THAT(J.d_q(1, 1), WithinAbs(0.0, rounded));
    CHECK((J.d_q(0, 1) == 0.0 && J.d_q(1, 0) == 0.0 && J.d_qdot.isZero(0.0)));
  });
}
