// SPDX-License-Identifier: MIT
//
// Equations as lines, against nested duals and hand derivations.
#include "qdot/mechanics/derive/lines.hpp"

#include <cmath>
#include <memory>
#include <optional>
#include <random>

#include "bench/chain_energies.hpp"
#include "bench/hand_derived.hpp"
#include "catch2_bridge.hpp"
#include "mechanics/many_functions.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/projection.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/effects/scene_motion.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"
#include "qdot/mechanics/derive/kept_lines.hpp"
#include "qdot/mechanics/derived.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/velocity.hpp"

namespace {

using namespace qdot;

// Sums of a few hundred operations, M of a condition up to 1e3.
constexpr double rounding = 1e-11;

template <int n>
State<n> random_state(std::mt19937& random) {
  std::uniform_real_distribution<double> number(0.2, 1.2);
  State<n> state{number(random), Vector<double, n>(), Vector<double, n>()};
  for (int i = 0; i < n; ++i) {
    state.q[i] = number(random);
    state.qdot[i] = number(random) - 0.7;
  }
  return state;
}

// A derivation of energies.
template <int n, class E>
std::shared_ptr<detail::KeptDerivation> derivation_of(const E& energies) {
  auto derivation = std::make_shared<detail::KeptDerivation>();
  derivation->derive(detail::RecordableFunctors::of<n>(energies, n));
  return derivation;
}

// The system of energies, which has lines.
template <int n, class... E>
auto by_lines(const E&... energies) {
  const auto system = mechanical_system<n>(energies...);
  REQUIRE(derivation_of<n>(system.energies())->lines() != nullptr);
  return system;
}

// q̈, M, r and the Jacobian are those of nested duals.
template <int n, class E>
void check_equal(const E& energies, bool has_lines = true) {
  const auto one = mechanical_system<n>(energies);
  REQUIRE((derivation_of<n>(energies)->lines() != nullptr) == has_lines);
  std::mt19937 random(7);
  for (int k = 0; k < 5; ++k) {
    const State<n> s = random_state<n>(random);
    const auto expected = detail::general_mass_and_rhs<n>(energies, s.q, s.qdot, s.t);
    const auto found = mass_and_rhs(one, s.q, s.qdot, s.t);
    CHECK((found.M - expected.M).cwiseAbs().maxCoeff() <= rounding * expected.M.cwiseAbs().maxCoeff());
    CHECK((found.r - expected.r).cwiseAbs().maxCoeff() <= rounding * (1.0 + expected.r.cwiseAbs().maxCoeff()));
    const auto J = acceleration_jacobian(one, s.q, s.qdot, s.t);
    AccelerationJacobian<n> J_expected = J;
    detail::jacobian_by_duals(one, s.q, s.qdot, s.t, J_expected);
    const double size = 1.0 + J_expected.d_q.cwiseAbs().maxCoeff() + J_expected.d_qdot.cwiseAbs().maxCoeff() + J_expected.qddot.cwiseAbs().maxCoeff();
    CHECK((J.qddot - J_expected.qddot).cwiseAbs().maxCoeff() <= rounding * size);
    CHECK((J.d_q - J_expected.d_q).cwiseAbs().maxCoeff() <= rounding * size);
    CHECK((J.d_qdot - J_expected.d_qdot).cwiseAbs().maxCoeff() <= rounding * size);
  }
}

// The lecture's way: a place, and T from its velocity.
struct PendulumByItsPlace {
  double m = 2.0, l = 0.5, g = 9.81;
  auto place(const auto& q) const {
    using std::cos, std::sin;
    return vector(l * sin(q[0]), -l * cos(q[0]));
  }
  auto T(const auto& q, const auto& qdot) const {
    return 0.5 * m * velocity_of([this](const auto& x) { return this->place(x); }, q, qdot).squaredNorm();
  }
  auto V(const auto& q) const {
    const Vector<std::decay_t<decltype(q[0])>, 2> r = place(q);
    return m * g * r[1];
  }
};

// A bead on a wire that is straight for x < 0: no formula.
struct Branching {
  double m = 2.0;
  auto T(const auto& qdot) const { return 0.5 * m * qdot[0] * qdot[0]; }
  auto V(const auto& q) const {
    using S = std::decay_t<decltype(q[0])>;
    return q[0] < 0.5 ? S(0.0 * q[0]) : S(q[0] * q[0] * q[0]);
  }
};
struct WithAbs {
  double m = 2.0;
  auto T(const auto& qdot) const { return 0.5 * m * qdot[0] * qdot[0]; }
  auto V(const auto& q) const {
    using std::abs;
    return 3.0 * abs(q[0]);
  }
};

// A chain that asks for a plain value, which recordings refuse: evaluated by dual numbers.
struct ByDuals : bench::LoopedChain {
  auto T(const auto& q, const auto& qdot) const {
    static_cast<void>(innermost_value(q[0]));
    return bench::LoopedChain::T(q, qdot);
  }
};

struct Logarithm {
  double m = 2.0;
  auto T(const auto& qdot) const { return 0.5 * m * qdot[0] * qdot[0]; }
  auto V(const auto& q) const {
    using std::log;
    return log(q[0]);
  }
};

}  // namespace

// Rates f(φ) φ̇ of sums of angles and of the time, and what only looks like one.
struct SquaresOfVelocities {
  double l = 0.7, omega = 1.3;
  auto T(const auto& q, const auto& v, const auto& t) const {
    using std::cos, std::exp, std::log, std::pow, std::sin, std::sqrt;
    using S = std::decay_t<decltype(t)>;
    const S angle = q[0] + q[1], driven = q[2] - omega * t;
    const S x = l * cos(q[0]) * v[0] + cos(angle) * (v[0] + v[1]) - omega * sin(omega * t), y = l * sin(q[0]) * v[0] + (v[0] + v[1]) * sin(angle);
    const S turning = (v[2] - omega) * sin(driven) * cos(driven), stretched = v[1] / sqrt(q[1] + 2.0) + q[2] * v[2] + exp(t);
    const S shifted = log(q[0] + 2.0) * (v[0] + 0.3), crossed = q[1] * v[0];
    const S mixed = sin(q[0]) * (cos(q[0]) * v[0] + cos(q[1]) * v[1]), doubled = 2.0 * cos(q[0] * q[1]) * (v[0] * q[1] + q[0] * v[1]);
    return S(0.5 * (x * x + y * y) + 2.0 * (v[0] * v[0] + v[2] * v[2]) - 0.1 * turning * turning + 0.4 * stretched * stretched + crossed * crossed +
             0.3 * pow(shifted, 2.0) + 0.2 * doubled * doubled + 0.1 * pow(v[1], 4.0) + 0.2 * v[0] * x + 0.3 * mixed * mixed);
  }
  auto V(const auto& q) const { return q[0] * q[1] - q[2] * q[2]; }
};

// What looks like cos² + sin², and like terms that cancel.
struct TwoAngles {
  auto T(const auto& q, const auto& v) const {
    using std::cos, std::sin;
    const auto x = cos(q[0]) * v[1], y = sin(q[1]) * v[1];
    return x * x + y * y + v[0] * v[0];
  }
  auto V(const auto& q) const { return q[0] * q[1]; }
};
struct Track {
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    const auto x = cos(q[0]) * v[0], y = q[0] * v[0];
    return 0.5 * (x * x + y * y);
  }
  auto V(const auto& q) const { return q[0]; }
};

TEST_CASE("squares and products of velocities give the Coriolis terms of nested duals, whether they are rates or not") {
  check_equal<3>(SquaresOfVelocities{});
  check_equal<2>(TwoAngles{});
  check_equal<1>(Track{});
}

TEST_CASE("a chain that is written as a loop has equations as short as those by hand") {
  // A link has two sines, its share of an acceleration and of a force in x and y, and an entry of M for each link before it.
  const auto lines = []<int n>(std::integral_constant<int, n>) {
    return derivation_of<n>(bench::LoopedChain{})->lines_with_slopes()->equations.table().lines.size();
  };
  CHECK(lines(std::integral_constant<int, 1>()) <= 4);
  CHECK(lines(std::integral_constant<int, 3>()) <= 30 + 3);
  CHECK(lines(std::integral_constant<int, 8>()) <= 80 + 28);
}

TEST_CASE("equations as lines of looped chains equal those derived by hand") {
  std::mt19937 random(3);
  const auto check = [&]<int n>(std::integral_constant<int, n>) {
    const auto chain = by_lines<n>(bench::LoopedChain{});
    for (int k = 0; k < 5; ++k) {
      const State<n> s = random_state<n>(random);
      Vector<double, n> by_hand;
      bench::chain_by_hand<n>(s.q.data(), s.qdot.data(), by_hand.data());
      CHECK((acceleration(chain, s) - by_hand).cwiseAbs().maxCoeff() <= rounding * (1.0 + by_hand.cwiseAbs().maxCoeff()));
    }
  };
  check(std::integral_constant<int, 1>());
  check(std::integral_constant<int, 3>());
  check(std::integral_constant<int, 8>());
}

TEST_CASE("equations as lines take velocities of places") {
  const auto pendulum = by_lines<1>(PendulumByItsPlace{});
  const double a = acceleration(pendulum, State<1>{0.0, Vector<double, 1>(0.4), Vector<double, 1>(1.3)})[0];
  CHECK(std::abs(a + 9.81 / 0.5 * std::sin(0.4)) <= rounding);
}

TEST_CASE("a free mass in spherical coordinates accelerates as its straight line says") {
  const auto mass = by_lines<3>([](const auto& q, const auto& qdot) {  // of r, φ, θ
    using std::sin;
    const auto across = q[0] * sin(q[2]) * qdot[1], down = q[0] * qdot[2];
    return 0.5 * (qdot[0] * qdot[0] + across * across + down * down);
  });
  const double r = 1.3, theta = 0.8, rdot = 0.4, phidot = -0.7, thetadot = 0.9;
  const Vector<double, 3> a = acceleration(mass, State<3>{0.0, {r, 0.3, theta}, {rdot, phidot, thetadot}});
  const double s = std::sin(theta), c = std::cos(theta);
  CHECK(std::abs(a[0] - r * (thetadot * thetadot + s * s * phidot * phidot)) <= rounding);
  CHECK(std::abs(a[1] + 2.0 * phidot * (rdot / r + thetadot * c / s)) <= rounding);
  CHECK(std::abs(a[2] + 2.0 * rdot * thetadot / r - s * c * phidot * phidot) <= rounding);
}

TEST_CASE("M, r and Jacobians by lines equal those of nested duals") {
  check_equal<2>(bench::LoopedChain{});
  check_equal<3>(tests::ManyFunctions{});
}

TEST_CASE("a sum over pairs of links is differentiated as it is written") {
  constexpr int n = 12;
  const auto pairs = by_lines<n>(bench::PairedChain{});
  std::mt19937 random(11);
  for (int k = 0; k < 3; ++k) {
    const State<n> s = random_state<n>(random);
    Vector<double, n> by_hand;
    bench::chain_by_hand<n>(s.q.data(), s.qdot.data(), by_hand.data());
    CHECK((acceleration(pairs, s) - by_hand).cwiseAbs().maxCoeff() <= rounding * (1.0 + by_hand.cwiseAbs().maxCoeff()));
  }
}

TEST_CASE("T and V that are no formulas are evaluated as they are") {
  check_equal<1>(Branching{}, false);
  check_equal<1>(WithAbs{}, false);
}

TEST_CASE("equations as lines have the parameters of their object") {
  // A bead on a line in V = q⁴: q̈ = −4 q³/m.
  for (const double m : {0.0625, 1.0, 2.0}) {
    const auto bead = by_lines<1>([m](const auto& qdot) { return 0.5 * m * qdot[0] * qdot[0]; }, [](const auto& q) { return q[0] * q[0] * q[0] * q[0]; });
    CHECK(acceleration(bead, State<1>{0.0, Vector<double, 1>(0.5), Vector<double, 1>(0.0)})[0] == -0.5 / m);
  }
}

TEST_CASE("equations as lines have no values where T or V has none") {
  const auto system = by_lines<1>(Logarithm{});
  CHECK(acceleration(system, State<1>{0.0, Vector<double, 1>(0.5), Vector<double, 1>(0.0)})[0] == -1.0);
  CHECK_THROWS_AS(acceleration(system, State<1>{0.0, Vector<double, 1>(-0.5), Vector<double, 1>(0.0)}), NonFinite);
  CHECK_THROWS_AS(acceleration_jacobian(system, Vector<double, 1>(-0.5), Vector<double, 1>(0.0)), NonFinite);
}

TEST_CASE("equations as lines have no values where a divisor is zero that they have lost") {
  // V = q/q + q³ + k q^(3/2): q̈ = −3 q² − k 3/2 √q, but at q = 0 there is none.
  const auto check = [](const auto& V, double expected) {
    const auto system = by_lines<1>([](const auto& qdot) { return 0.5 * qdot[0] * qdot[0]; }, V);
    CHECK(acceleration(system, State<1>{0.0, Vector<double, 1>(0.25), Vector<double, 1>(0.0)})[0] == expected);
    CHECK_THROWS_AS(acceleration(system, State<1>{0.0, Vector<double, 1>(0.0), Vector<double, 1>(0.0)}), NonFinite);
  };
  check([](const auto& q) { return q[0] / q[0] + q[0] * q[0] * q[0]; }, -0.1875);
  check([](const auto& q) {
    using std::pow;
    return q[0] / q[0] + q[0] * q[0] * q[0] + pow(q[0], 1.5);
  }, -0.9375);
}

TEST_CASE("of a logarithm and a quotient of one number the logarithm says where lines have values") {
  const auto system = by_lines<1>([](const auto& qdot) { return 0.5 * qdot[0] * qdot[0]; },
                                  [](const auto& q) {
                                    using std::log;
                                    const auto first = log(q[0]);
                                    return first + 1.0 / q[0];
                                  });
  CHECK(acceleration(system, State<1>{0.0, Vector<double, 1>(0.5), Vector<double, 1>(0.0)})[0] == 2.0);
  CHECK_THROWS_AS(acceleration(system, State<1>{0.0, Vector<double, 1>(-0.5), Vector<double, 1>(0.0)}), NonFinite);
}

TEST_CASE("effects and constraints go with lines") {
  const auto tip = holonomic("tip", [](const auto& q) {
    using std::sin;
    return sin(q[0]) + sin(q[1]) + sin(q[2]);
  });
  const auto damping = viscous_damping(Eigen::Vector3d(0.1, 0.2, 0.3));
  const auto fast = scene(by_lines<3>(bench::LoopedChain{}), tip, damping);
  const auto plain = scene(mechanical_system<3>(ByDuals{}), tip, damping);
  const State<3> start = consistent_state(plain, State<3>{0.0, {0.3, -0.2, -0.1}, {0.5, 0.1, -0.6}}).state;
  const auto a = acceleration(fast, start.q, start.qdot, 0.0), b = acceleration(plain, start.q, start.qdot, 0.0);
  CHECK((a - b).cwiseAbs().maxCoeff() <= rounding * (1.0 + b.cwiseAbs().maxCoeff()));
  Eigen::VectorXd y(6);
  y << start.q, start.qdot;
  Eigen::MatrixXd J(6, 6), J_plain(6, 6);
  first_order_form(fast).jacobian(0.0, y, J);
  first_order_form(plain).jacobian(0.0, y, J_plain);
  CHECK((J - J_plain).cwiseAbs().maxCoeff() <= rounding * (1.0 + J_plain.cwiseAbs().maxCoeff()));
}

#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
TEST_CASE("the deprecated word derived leaves energies as they are") {
  const State<2> at{0.0, {0.4, -0.3}, {0.2, 0.5}};
  CHECK(acceleration(mechanical_system<2>(derived<2>(bench::LoopedChain{})), at) == acceleration(mechanical_system<2>(bench::LoopedChain{}), at));
}
