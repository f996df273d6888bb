// SPDX-License-Identifier: MIT
#include "qdot/analysis/periodic_orbit.hpp"

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "analysis/repeating.hpp"
#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"

using namespace qdot;
using repeating::over_floor;

namespace {

// Runs with rtol = 1e-13 over a few periods keep eleven digits, Newton's method loses none.
constexpr double error = 1e-11;

// A mass at (x, y) on a rod of length 1, in unit gravity, and apart from it an oscillator z.
struct RodAndSpring {
  double k = 0.0;
  auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  auto V(const auto& q) const { return q[1] + 0.5 * k * q[2] * q[2]; }
};
struct Rod {
  auto operator()(const auto& q) const { return q[0] * q[0] + q[1] * q[1] - 1.0; }
};
auto beside_rod(double k) { return scene(mechanical_system<3>(RodAndSpring{k}).with_names({"x", "y", "z"}), holonomic("rod", Rod{})); }
State<3> at_1_3(double z) { return {0.0, Eigen::Vector3d(std::sin(1.3), -std::cos(1.3), z), Eigen::Vector3d::Zero()}; }

bool says(const std::string& message, const char* part) { return message.find(part) != std::string::npos; }

// Of a pendulum with unit frequency at 1.3 rad: 4 K(sin 0.65), and its derivative by the amplitude.
constexpr double T_at_1_3 = 7.019250311844546549770542, dT_by_amplitude = 1.258165472401305335;

}  // namespace

TEST_CASE("a pendulum's orbit has the period of the elliptic integral, whichever is held") {
  const auto pendulum = over_floor({.pull = 1.0});
  const double h = -std::cos(1.3);
  for (const Held& held : {hold_energy(), hold_coordinate(0), hold_energy(h)}) {
    const auto orbit = periodic_orbit_near(pendulum, State<1>{0.0, {1.3}, {0.0}}, 6.5, held);
    INFO(orbit.message);
    REQUIRE(orbit.found());
    CHECK_THAT(orbit.period, WithinAbs(T_at_1_3, error));
    CHECK_THAT(orbit.energy, WithinAbs(h, error));
    CHECK(orbit.conserves_energy);
    CHECK(orbit.undetermined.empty());
    CHECK(orbit.history.size() < 8);
    CHECK(orbit.multipliers.size() == 2);
    for (const Multiplier& m : orbit.multipliers) CHECK((m.trivial && m.value == 1.0));
    CHECK(orbit.stability == OrbitStability::stable_to_first_order);
    // From a turning point farther up it comes back later, by ∂T/∂amplitude.
    if (held.what == Held::What::coordinate) CHECK_THAT(orbit.monodromy(1, 0), WithinAbs(std::sin(1.3) * dT_by_amplitude, 10 * error));
  }
  const auto orbit = periodic_orbit_near(pendulum, State<1>{0.0, {1.0}, {0.0}}, T_at_1_3, hold_period());
  REQUIRE(orbit.found());
  CHECK(orbit.period == T_at_1_3);
  CHECK_THAT(std::acos(-orbit.energy), WithinAbs(1.3, 10 * error));
}

TEST_CASE("a pendulum that goes round advances by a turn in each period") {
  // h = 3 with unit gravity: θ̇² = 2 (3 + cos θ), and T = 2 k K(k), k² = 2/(h + 1) = ½.
  constexpr double K_of_half = 1.854074677301371918;  // Γ(¼)²/(4√π)
  const auto orbit = periodic_orbit_near(over_floor({.pull = 1.0}), State<1>{0.0, {0.0}, {2.7}}, 2.5, hold_energy(3.0),
                                         {.advance = Eigen::VectorXd::Constant(1, 2 * std::numbers::pi)});
  INFO(orbit.message);
  REQUIRE(orbit.found());
  CHECK_THAT(orbit.period, WithinAbs(std::numbers::sqrt2 * K_of_half, error));
}

TEST_CASE("Mathieu's equation has the traces that are known") {
  struct Known {
    double a, q, trace;
  };
  for (const Known& known : {Known{1, 1, -4.396667734798867851}, Known{2, 1, -1.554649354176467812}, Known{-0.2, 1, -1.175676878379037784},
                             Known{0.5, 2, -14.00643323264104821}, Known{10, 5, -2.523257698715790277}}) {
    const auto orbit = periodic_orbit_near(over_floor({.a = known.a, .s = known.q}), State<1>{0.0, {0.0}, {0.0}}, std::numbers::pi, driven());
    INFO(orbit.message << " a = " << known.a << ", q = " << known.q);
    REQUIRE(orbit.found());
    CHECK_THAT(orbit.monodromy.trace(), WithinAbs(known.trace, 1e-10));
    // μ² − trace μ + 1 = 0
    REQUIRE(orbit.multipliers.size() == 2);
    for (const Multiplier& m : orbit.multipliers) {
      const std::complex<double> left = m.value * (m.value - known.trace) + 1.0;
      CHECK(std::abs(left) <= 1e-11 * std::norm(m.value) + m.radius * std::abs(2.0 * m.value - known.trace));
      CHECK(m.radius < 1e-8);
      CHECK_FALSE(m.trivial);
    }
    CHECK(orbit.stability == (std::abs(known.trace) > 2.0 ? OrbitStability::unstable : OrbitStability::stable_to_first_order));
  }
}

TEST_CASE("a pendulum stands on its head where its pivot shakes fast enough") {
  // A pivot that moves by A cos ωt under a pendulum of length 1 with g = 1 changes gravity by −A ω² cos ωt. For small A it
  // stands if A²ω² > 2; Mathieu's a₀(q) = −q²/2 + 7q⁴/128 with q = 2A makes it 0.44 % more at A = 0.1. 2 % leave room for that.
  constexpr double A = 0.1, margin = 0.02;
  for (const bool stands : {true, false}) {
    const double omega = std::sqrt(2.0 * (1.0 + (stands ? margin : -margin))) / A;
    const auto pendulum = over_floor({.pull = 1.0, .shake = -A * omega * omega, .omega = omega});
    const auto orbit = periodic_orbit_near(pendulum, State<1>{0.0, {std::numbers::pi}, {0.0}}, 2 * std::numbers::pi / omega, driven());
    INFO(orbit.message);
    REQUIRE(orbit.found());
    CHECK(orbit.stability == (stands ? OrbitStability::stable_to_first_order : OrbitStability::unstable));
  }
}

TEST_CASE("a ball that bounces without loss has the period and the monodromy matrix of the closed form") {
  constexpr double g = 9.81, h = 1.7;
  const auto ball = over_floor({.g = g}, {}, 0.0);
  for (const Held& held : {hold_energy(), hold_coordinate(0)}) {
    const auto orbit = periodic_orbit_near(ball, State<1>{0.0, {h}, {0.0}}, 1.1, held);
    INFO(orbit.message);
    REQUIRE(orbit.found());
    CHECK_THAT(orbit.period, WithinAbs(2 * std::sqrt(2 * h / g), error));
    // From higher up it comes back later, by ∂T/∂h = √(2/(g h)), and then falls with g.
    Eigen::Matrix2d expected;
    expected << 1, 0, std::sqrt(2 * g / h), 1;
    if (held.what == Held::What::coordinate) CHECK((orbit.monodromy - expected).cwiseAbs().maxCoeff() < 10 * error);
    CHECK(orbit.conserves_energy);
  }
}

TEST_CASE("van der Pol's cycle has its known period, and its multiplier is the exponential of the mean divergence") {
  // By Taylor series of order 40 in 30 digits.
  constexpr double T = 6.66328685932313018970, amplitude = 2.00861986087484313651;
  const auto oscillator = over_floor({.a = 1.0}, {.mu = 1.0});
  const auto orbit = periodic_orbit_near(oscillator, State<1>{0.0, {2.0}, {0.0}}, 6.5, hold_nothing());
  INFO(orbit.message);
  REQUIRE(orbit.found());
  CHECK_THAT(orbit.period, WithinAbs(T, error));
  CHECK_FALSE(orbit.conserves_energy);
  CHECK(orbit.stability == OrbitStability::asymptotically_stable);
  REQUIRE(orbit.multipliers.size() == 2);
  CHECK(orbit.multipliers[0].trivial);

  // Equal weights integrate what is periodic with an error below any power of the spacing.
  constexpr int points = 400;
  Options options{.rtol = 1e-13, .atol = 1e-14};
  for (int k = 1; k <= points; ++k) options.output_times.push_back(k == points ? orbit.period : orbit.period * k / points);
  const auto run = simulate(oscillator, orbit.start(), orbit.period, Dop853{}, options);
  double divergence = 0.0, largest = 0.0;
  for (Eigen::Index k = 0; k < run.samples.y.cols(); ++k) {
    const double q = run.samples.y(0, k);
    divergence += (1.0 - q * q) * orbit.period / points;
    largest = std::max(largest, q);
  }
  const Multiplier& mu = orbit.multipliers[1];
  CHECK_THAT(mu.value.real(), WithinAbs(std::exp(divergence), error));
  CHECK(std::abs(mu.value.real() - std::exp(divergence)) <= mu.radius + 1e-13);
  CHECK(mu.radius < 1e-10);

  const auto from_the_top = periodic_orbit_near(oscillator, State<1>{0.0, {2.01}, {0.0}}, 6.6, hold_nothing());
  REQUIRE(from_the_top.found());
  CHECK_THAT(largest, WithinAbs(amplitude, 1e-3));  // as fine as the 400 points are
}

TEST_CASE("beside a pendulum on a rod, an oscillator's multipliers are those of its phase") {
  constexpr double k = 2.3;
  const auto orbit = periodic_orbit_near(beside_rod(k), at_1_3(0.0), 6.5, hold_energy());
  INFO(orbit.message);
  REQUIRE(orbit.found());
  CHECK_THAT(orbit.period, WithinAbs(T_at_1_3, error));
  const std::complex<double> expected = std::polar(1.0, std::sqrt(k) * T_at_1_3);
  int others = 0;
  for (const Multiplier& m : orbit.multipliers) {
    if (m.trivial) continue;
    ++others;
    const double off = std::min(std::abs(m.value - expected), std::abs(m.value - std::conj(expected)));
    CHECK(off < error);
    CHECK(off <= m.radius);
    CHECK(m.radius < 1e-9);
  }
  CHECK(others == 2);
  CHECK(orbit.stability == OrbitStability::stable_to_first_order);
}

TEST_CASE("what an orbit leaves open is named; where that is a symmetry it decides nothing") {
  const auto orbit = periodic_orbit_near(beside_rod(0.0), at_1_3(4.0), 6.5, hold_energy());
  INFO(orbit.message);
  REQUIRE(orbit.found());
  REQUIRE(orbit.undetermined == std::vector<std::string>{"z"});
  CHECK(orbit.x[2] == 4.0);
  CHECK(orbit.symmetries == std::vector<std::string>{"time and energy", "translation of z and its momentum"});
  CHECK(orbit.multipliers.size() == 4);
  for (const Multiplier& m : orbit.multipliers) CHECK(m.trivial);
  CHECK(orbit.stability == OrbitStability::stable_to_first_order);
}

TEST_CASE("a pendulum with an unstable neighbour is unstable") {
  const auto orbit = periodic_orbit_near(beside_rod(-0.25), at_1_3(0.0), 6.5, hold_energy());
  REQUIRE(orbit.found());
  CHECK(orbit.stability == OrbitStability::unstable);
  CHECK_THAT(orbit.multipliers.front().value.real(), WithinRel(std::exp(0.5 * T_at_1_3), error));
}

TEST_CASE("a search that finds no orbit says what it found") {
  const auto pendulum = over_floor({.pull = 1.0});
  const auto rest = periodic_orbit_near(pendulum, State<1>{0.0, {1.0}, {0.0}}, 6.1, hold_period());  // shorter than any period
  CHECK(rest.outcome == OrbitOutcome::equilibrium);
  CHECK(says(rest.message, "a periodic orbit must move"));

  const auto falls = periodic_orbit_near(over_floor({.g = 1.0}), State<1>{0.0, {1.0}, {0.0}}, 2.0, hold_energy());
  CHECK(falls.outcome == OrbitOutcome::not_closed);
  CHECK(says(falls.message, "the motion must close, but where the search ended, after a period of "));
  CHECK(falls.residual.size() == 2);
  CHECK_FALSE(falls.worst.empty());

  const auto grazes = periodic_orbit_near(over_floor({.a = 1.0}, {}, -1.0 + 3e-13), State<1>{0.0, {1.0}, {0.0}}, 6.0, hold_energy());
  CHECK(grazes.outcome == OrbitOutcome::run_failed);
  CHECK(grazes.run_outcome == Outcome::not_differentiable);
}

TEST_CASE("what cannot be a periodic orbit is refused with the remedy") {
  const auto pendulum = over_floor({.pull = 1.0});
  const State<1> start{0.0, {1.0}, {0.0}};
  CHECK_THROWS_WITH(periodic_orbit_near(pendulum, start, -1.0, hold_energy()),
                    "periodic_orbit_near: the period must be positive and finite, but is -1; give a guess of it");
  CHECK_THROWS_WITH(periodic_orbit_near(pendulum, start, 6.0, hold_coordinate(1)),
                    "periodic_orbit_near: the coordinate that is held must be one of 0 to 0, but is 1; give its index");
  CHECK_THROWS_WITH(periodic_orbit_near(over_floor({.a = 1.0, .s = 1.0}), start, 3.0, hold_energy()),
                    "periodic_orbit_near: nothing may depend on the time, but the rate of qdot0 changes by -2.57038 within 0.93; pass driven(), with the period "
                    "of what drives it");
  const State<1> nowhere{0.0, {std::numeric_limits<double>::quiet_NaN()}, {0.0}};
  CHECK_THROWS_AS(periodic_orbit_near(pendulum, nowhere, 6.0, hold_energy()), InvalidValue);
}

// Hénon and Heiles, V = (x² + y²)/2 + x² y − y³/3, which on x = 0 is a cubic oscillator: its period by an elliptic integral.
TEST_CASE("an orbit whose one coordinate is held closes as well as one whose energy is") {
  const auto system = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) {
    return 0.5 * q.squaredNorm() + q[0] * q[0] * q[1] - q[1] * q[1] * q[1] / 3.0;
  });
  constexpr double T = 6.66726723664999357273;
  const auto on_y = periodic_orbit_near(system, State<2>{0.0, {0.0, 0.4}, {0.0, 0.0}}, 6.5, hold_coordinate(1));
  INFO(on_y.message);
  REQUIRE(on_y.found());
  CHECK_THAT(on_y.period, WithinAbs(T, 10 * error));
  for (const State<2>& start : {State<2>{0.0, {0.05, 0.4}, {0.0, 0.0}}, State<2>{0.0, {0.3, 0.4}, {0.35, 0.0}}, State<2>{0.0, {-0.1, -0.2}, {0.2, 0.0}}}) {
    const auto orbit = periodic_orbit_near(system, start, 6.5, hold_coordinate(1));
    INFO(orbit.message);
    REQUIRE(orbit.found());
    CHECK(orbit.residual.cwiseAbs().maxCoeff() < error);
    CHECK(orbit.x[1] == start.q[1]);
    CHECK(orbit.x[3] == start.qdot[1]);
  }
}
