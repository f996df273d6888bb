// SPDX-License-Identifier: MIT
//
// acceleration() of written-out systems, which goes by derived equations where the optimizer is on: against equations derived by hand, and
// against the same system not written out where a state or an object is none of theirs.
#include "catch2_bridge.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "bench/chain_energies.hpp"
#include "bench/hand_derived.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_motion.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/written_out.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/elastic_pendulum.hpp"
#include "scenes/heavy_top.hpp"
#include "scenes/kepler.hpp"
#include "scenes/rod_and_ring.hpp"
#include "scenes/spherical_pendulum.hpp"

using namespace qdot;

namespace {

// Rounding of both, times the condition of M.
constexpr double rounded = 1e-12;
constexpr double rounded_long_chain = 1e-11;

template <int n, class E, class Hand>
double difference(const E& energies, const Hand& hand, double low, double high) {
  const auto system = mechanical_system<n>(written_out<n>(energies));
  if (!system.energies().has_closed_form()) return 1e9;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> position(low, high), velocity(-2.0, 2.0);
  double worst = 0.0;
  for (int sample = 0; sample < 50; ++sample) {
    Vector<double, n> q, v, a;
    for (int i = 0; i < n; ++i) {
      q[i] = position(random);
      v[i] = velocity(random);
    }
    hand(q.data(), v.data(), a.data());
    worst = std::max(worst, (a - acceleration(system, q, v)).norm() / a.norm());
  }
  return worst;
}

// What acceleration() throws, in its own words.
template <int n, class System>
std::string complaint(const System& system, const Vector<double, n>& q, const Vector<double, n>& v) {
  try {
    const Vector<double, n> a = acceleration(system, q, v);
    return a.allFinite() ? "a finite acceleration" : "an acceleration that is not finite";
  } catch (const Error& e) {
    return e.what();
  }
}
template <int n, class E>
void check_same_complaint(const E& energies, const Vector<double, n>& q, const Vector<double, n>& v, const std::string& part) {
  const std::string plain = complaint<n>(mechanical_system<n>(energies), q, v);
  CHECK(plain.find(part) != std::string::npos);
  CHECK(complaint<n>(mechanical_system<n>(written_out<n>(energies)), q, v) == plain);
}

struct Spring {
  double k = 2.0;
  constexpr auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  constexpr auto V(const auto& q) const { return 0.5 * k * q.squaredNorm(); }
};

// A pendulum on a cart whose rail is shaken; T and V of the time.
struct Shaken {
  double m = 0.4, l = 0.9, w = 1.3;
  constexpr auto T(const auto& q, const auto& v, const auto& t) const {
    using std::cos, std::sin;
    const auto x = v[0] + 0.2 * w * cos(w * t);
    return 0.5 * x * x + 0.5 * m * (x * x + 2.0 * l * cos(q[1]) * x * v[1] + l * l * v[1] * v[1]);
  }
  constexpr auto V(const auto& q, const auto& t) const {
    using std::cos;
    return m * 9.81 * l * (1.0 - cos(q[1])) + q[0] * t;
  }
};

// The largest difference between M and r of written-out energies and those of nested duals of the same energies as they are.
template <int n, class E>
double difference_of_equations(const E& energies, double lowest, double highest) {
  const auto written = written_out<n>(energies);
  const auto system = mechanical_system<n>(written);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(lowest, highest);
  double worst = 0.0;
  for (int i = 0; i < 100; ++i) {
    Vector<double, n> q, v;
    for (int k = 0; k < n; ++k) q[k] = uniform(random), v[k] = uniform(random);
    const double t = uniform(random);
    const auto expected = detail::general_mass_and_rhs<n>(energies, q, v, t);
    MassAndRhs<double, n> found{expected.M, expected.r};
    const bool derived = written.equations_in_closed_form(detail::AtState{q.data(), v.data(), t}, detail::CopyTo<n>{found.M, found.r});
    const auto asked = mass_and_rhs(system, q, v, t);
    if (!derived) return HUGE_VAL;
    const double scale = 1.0 + expected.M.cwiseAbs().maxCoeff() + expected.r.cwiseAbs().maxCoeff();
    for (const auto& one : {found, asked})
      worst = std::max({worst, (one.M - expected.M).cwiseAbs().maxCoeff() / scale, (one.r - expected.r).cwiseAbs().maxCoeff() / scale});
  }
  return worst;
}

// Another potential energy than the one that was written out.
struct Stiffened : decltype(written_out<2>(Spring{})) {
  using Base = decltype(written_out<2>(Spring{}));
  explicit Stiffened(const Base& base) : Base(base) {}
  auto V(const auto& q) const { return 5.0 * q.squaredNorm(); }
};

}  // namespace

TEST_CASE("accelerations of written-out systems are those that one derives by hand") {
  CHECK(difference<2>(scenes::RodAndRing{}, bench::RodAndRingByHand{}, 0.3, 1.2) < rounded);
  CHECK(difference<2>(scenes::SphericalPendulum{}, bench::SphericalPendulumByHand{}, 0.3, 1.2) < rounded);
  CHECK(difference<2>(scenes::Kepler{}, bench::KeplerByHand{}, 0.3, 1.2) < rounded);
  CHECK(difference<2>(scenes::ElasticPendulum{}, bench::ElasticPendulumByHand{}, 0.3, 1.2) < rounded);
  CHECK(difference<2>(scenes::DoublePendulum{}, bench::DoublePendulumByHand{}, -2.0, 2.0) < rounded);
  CHECK(difference<3>(scenes::HeavyTop{}, bench::HeavyTopByHand{}, 0.3, 1.2) < rounded);
}

TEST_CASE("accelerations of written-out chains are those that one derives by hand") {
  CHECK(difference<1>(bench::LoopedChain{}, bench::chain_by_hand<1>, -2.0, 2.0) < rounded);
  CHECK(difference<3>(bench::LoopedChain{}, bench::chain_by_hand<3>, -2.0, 2.0) < rounded);
  CHECK(difference<12>(bench::LoopedChain{}, bench::chain_by_hand<12>, -2.0, 2.0) < rounded_long_chain);
}

TEST_CASE("applied forces act on a written-out system as on the same system as it is: coordinates that are eliminated and kept") {
  const auto pushed = [](const auto& system) {
    return scene(system, generalized_force([](const auto& at, const auto& u) {
                   return Vector<typename std::decay_t<decltype(at)>::Scalar, 3>(0.3 * at - 0.1 * u);
                 }));
  };
  const Vector<double, 3> q(0.4, -0.7, 1.1), v(0.3, 0.8, -0.5);
  const Vector<double, 3> a = acceleration(pushed(mechanical_system<3>(scenes::HeavyTop{.I1 = 0.6})), q, v);
  const Vector<double, 3> b = acceleration(pushed(mechanical_system<3>(written_out<3>(scenes::HeavyTop{.I1 = 0.6}))), q, v);
  CHECK((a - b).norm() < rounded * a.norm());
}

TEST_CASE("a state or an object without accelerations is refused in the same words, written out or not") {
  const Vector<double, 2> q(0.3, 0.8), v(0.1, 0.2);
  check_same_complaint<3>(scenes::HeavyTop{}, {0.0, 0.2, 0.3}, {0.1, 0.2, 4.0}, "no kinetic energy");
  check_same_complaint<2>(scenes::DoublePendulum{.m1 = 0.0, .m2 = 0.0}, q, v, "all of it is zero");
  check_same_complaint<2>(scenes::DoublePendulum{.l2 = 0.0}, q, v, "no kinetic energy");
  check_same_complaint<2>(scenes::DoublePendulum{.m1 = -3.0}, q, v, "no positive kinetic energy");
  const double nan = std::nan("");
  for (const double bad : {nan, HUGE_VAL, -HUGE_VAL}) {
    check_same_complaint<2>(scenes::DoublePendulum{}, {bad, 0.1}, v, "finite");
    check_same_complaint<2>(scenes::DoublePendulum{}, q, {0.1, bad}, "finite");
    check_same_complaint<2>(scenes::DoublePendulum{.g = bad}, q, v, "finite");
  }
}

TEST_CASE("the mass matrix and the right-hand side that the compiler has derived are those of nested duals") {
  CHECK(difference_of_equations<3>(scenes::HeavyTop{.I1 = 0.6}, 0.3, 1.2) < rounded);
  CHECK(difference_of_equations<2>(scenes::DoublePendulum{.l2 = 1.7}, -2.0, 2.0) < rounded);
  CHECK(difference_of_equations<2>(scenes::Kepler{}, 0.3, 1.2) < rounded);
  CHECK(difference_of_equations<4>(bench::LoopedChain{}, -2.0, 2.0) < rounded);
  CHECK(difference_of_equations<2>(Shaken{}, -2.0, 2.0) < rounded);
}

TEST_CASE("energies that are made from written-out ones and have a potential energy of their own move by that") {
  const auto system = mechanical_system<2>(Stiffened(written_out<2>(Spring{})));
  const Vector<double, 2> a = acceleration(system, Vector<double, 2>(0.3, 0.8), Vector<double, 2>(0.1, 0.2));
  CHECK_THAT(a[0], WithinAbs(-3.0, rounded));
  CHECK_THAT(a[1], WithinAbs(-8.0, rounded));
}
