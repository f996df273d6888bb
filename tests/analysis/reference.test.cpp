// SPDX-License-Identifier: MIT
#include "qdot/analysis/reference.hpp"

#include <cmath>
#include <numbers>

#include "catch2_bridge.hpp"
#include "qdot/effects/dissipation.hpp"
#include "scenes/kepler.hpp"
#include "scenes/pendulum.hpp"

using namespace qdot;

namespace {

// Some dozens of steps, each exact to some units of long double (1.1e-19), amplified by the gain of the motion.
constexpr double precise = 2e-17;

// π/2 / agm(1, k'), the quarter period of an elliptic motion, k' the complementary modulus.
long double complete_elliptic_integral(long double complement) {
  long double a = 1, b = complement;
  while (std::abs(a - b) > 1e-18L * a) {
    const long double mean = (a + b) / 2;
    b = std::sqrt(a * b);
    a = mean;
  }
  return std::numbers::pi_v<long double> / (2 * a);
}

double distance(long double computed, long double expected) { return static_cast<double>(std::abs(computed - expected)); }

}  // namespace

TEST_CASE("the reference of a pendulum is its elliptic motion, to more digits than double has") {
  const scenes::Pendulum pendulum;
  const long double g = pendulum.g, start = 2.5L;
  const long double quarter = complete_elliptic_integral(std::cos(start / 2)) / std::sqrt(g);
  const double t1 = static_cast<double>(quarter), t2 = static_cast<double>(2 * quarter), t20 = static_cast<double>(20 * quarter);
  const auto motion = reference_motion(mechanical_system<1>(pendulum), State<1>{0.0, Vector<double, 1>(2.5), Vector<double, 1>(0.0)}, {t1, t2, t20});

  const long double fastest = 2 * std::sqrt(g) * std::sin(start / 2);
  CHECK(distance(motion.y(0, 0), -fastest * (t1 - quarter)) < precise);
  CHECK(distance(motion.y(1, 0), -fastest) < precise * 10);
  const long double back = g * std::sin(start);  // the acceleration at −2.5
  CHECK(distance(motion.y(0, 1), -start) < precise * 10);
  CHECK(distance(motion.y(1, 1), back * (t2 - 2 * quarter)) < precise * 10);
  CHECK(distance(motion.y(0, 2), start) < 20 * motion.uncertainty * 2.5 + precise * 10);
  CHECK(motion.uncertainty < 1e-15);
}

TEST_CASE("an eccentric Kepler orbit closes, and the reference knows how well it knows that") {
  const long double period = 2 * std::numbers::pi_v<long double>;
  const double t = static_cast<double>(10 * period);
  const auto motion = reference_motion(mechanical_system<2>(scenes::Kepler{}), State<2>{0.0, {0.4, 0.0}, {0.0, 2.0}}, {t});
  INFO(motion.uncertainty * 1e15 << "e-15, gain " << motion.gain);
  const long double late = t - 10 * period;
  // In the pericentre, r = 0.4: 0.4 as double is not 2/5, and changes the period by 3/2 · 2.2e-17 · …; hence the start's own a.
  const long double a = 1 / (2 / static_cast<long double>(0.4) - 4);
  const long double later = late - 10 * period * (std::pow(a, 1.5L) - 1);
  CHECK(distance(motion.y(0, 0), 0.4) < 1e-15);
  CHECK(distance(motion.y(1, 0), 2 * later) < 20 * motion.uncertainty + precise);
  CHECK(distance(motion.y(2, 0), -later / (0.4L * 0.4L)) < 100 * motion.uncertainty + precise);
  CHECK(motion.uncertainty < 1e-12);
}

TEST_CASE("the gain is that of the motion") {
  // A free particle: a relative change of the velocity by δ shows in q(T) = v T as the same δ; one of q(0), beside it, adds at most δ.
  const auto free = mechanical_system<1>([](const auto& qdot) { return 0.5 * qdot[0] * qdot[0]; }, [](const auto& q) { return 0.0 * q[0]; });
  const auto motion = reference_motion(free, State<1>{0.0, Vector<double, 1>(0.0), Vector<double, 1>(2.0)}, {10.0});
  CHECK(motion.gain > 0.5);
  CHECK(motion.gain < 2.5);
  CHECK(distance(motion.y(0, 0), 20.0L) < 1e-16);
}

TEST_CASE("a scene whose effects are forces has a reference") {
  // θ̈ = −g θ − c θ̇ at amplitude 1e-6: the cubic term is 1e-18 · g/6 beside the linear one's 1e-6.
  const auto damped = scene(mechanical_system<1>(scenes::Pendulum{}), viscous_damping(Vector<double, 1>(0.5)));
  const auto motion = reference_motion(damped, State<1>{0.0, Vector<double, 1>(1e-6), Vector<double, 1>(0.0)}, {3.0});
  const long double decay = 0.25L, rate = std::sqrt(static_cast<long double>(9.81) - decay * decay);
  const long double expected = 1e-6L * std::exp(-decay * 3) * (std::cos(rate * 3) + decay / rate * std::sin(rate * 3));
  CHECK(distance(motion.y(0, 0), expected) < 1e-17);
}

TEST_CASE("what cannot have a reference says so") {
  const auto pendulum = mechanical_system<1>(scenes::Pendulum{});
  const State<1> start{0.0, Vector<double, 1>(2.5), Vector<double, 1>(0.0)};
  CHECK_THROWS_AS(reference_motion(pendulum, start, {1e6}, {.max_seconds = 0.01}), NoReference);
  CHECK_THROWS_AS(reference_motion(pendulum, start, {1.0, 0.5}), InvalidValue);
  // A fall into the centre: q̈ = −1/q², singular at t = π/√8 from rest at 1.
  const auto fall = mechanical_system<1>([](const auto& qdot) { return 0.5 * qdot[0] * qdot[0]; }, [](const auto& q) { return -1.0 / q[0]; });
  bool says_so = false;
  try {
    says_so = reference_motion(fall, State<1>{0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)}, {1.2}, {.max_seconds = 2}).uncertainty > 1e-3;
  } catch (const NoReference&) {
    says_so = true;
  }
  CHECK(says_so);
}
