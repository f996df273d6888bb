// SPDX-License-Identifier: MIT
#include "qdot/effects/scene_at_state.hpp"

#include <cmath>

#include "../catch2_bridge.hpp"
#include "error_message.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "qdot/effects/input.hpp"
#include "qdot/integrate/energy_balance.hpp"

namespace {

using Eigen::Vector2d;
using qdot::scene;
using qdot::State;

constexpr double rounding = 1e-13;  // of some ten operations on numbers of the order of ten

constexpr double m = 2.0, l = 1.5, g = 9.81, c = 0.3;

// A pendulum in Cartesian coordinates, on a rod, in air.
const auto bob = qdot::mechanical_system<2>([](const auto&, const auto& v) { return 0.5 * m * v.squaredNorm(); },
                                            [](const auto& q) { return m * g * q[1]; });
const auto rod = qdot::holonomic("rod", [](const auto& q) { return 0.5 * (q.squaredNorm() - l * l); });
const auto air = qdot::rayleigh([](const auto&, const auto& v) { return 0.5 * c * v.squaredNorm(); });
const auto pendulum = scene(bob, rod, air);

// The same by one angle: place, velocity and what the angle's equation says.
struct ByAngle {
  double angle = 0.7, rate = 1.1;
  Vector2d along() const { return {std::cos(angle), std::sin(angle)}; }
  Vector2d outward() const { return {std::sin(angle), -std::cos(angle)}; }
  State<2> state() const { return {0.4, Vector2d(l * outward()), Vector2d(l * rate * along())}; }
  Vector2d acceleration() const { return l * (-(g / l) * std::sin(angle) - c / m * rate) * along() - l * rate * rate * outward(); }
  Vector2d tension() const { return -(m * l * rate * rate + m * g * std::cos(angle)) * outward(); }
};

TEST_CASE("at a state of a pendulum on its rod a scene answers as the pendulum's angle does") {
  const ByAngle hand;
  const State<2> s = hand.state();
  const double speed = l * hand.rate, height = -l * std::cos(hand.angle);
  CHECK((acceleration(pendulum, s) - hand.acceleration()).norm() < 100 * rounding);
  CHECK((reactions(pendulum, s) - hand.tension()).norm() < 100 * rounding);
  CHECK_THAT(power(pendulum, s), WithinAbs(-c * speed * speed, 100 * rounding));
  CHECK_THAT(energy(pendulum, s), WithinAbs(0.5 * m * speed * speed + m * g * height, 100 * rounding));
  CHECK_THAT(lagrangian(pendulum, s), WithinAbs(0.5 * m * speed * speed - m * g * height, 100 * rounding));
  CHECK_THAT(jacobi_energy(pendulum, s), WithinAbs(energy(pendulum, s), 100 * rounding));
}

// What is asked of a system or a scene, by three numbers and by the State that has them.
template <class Model>
void check_of_both(const Model& model, double drag) {
  const Vector2d q(0.3, -1.2), v(0.8, 0.5), a(0.1, 0.2);
  const State<2> s{0.4, q, v};
  const double T = 0.5 * m * v.squaredNorm(), V = m * g * q[1];
  const Vector2d forces = Vector2d(0.0, -m * g) - drag * v;
  CHECK_THAT(kinetic_energy(model, q, v, 0.4), WithinAbs(T, rounding));
  CHECK_THAT(kinetic_energy(model, s), WithinAbs(T, rounding));
  CHECK_THAT(potential_energy(model, q, 0.4), WithinAbs(V, rounding));
  CHECK_THAT(potential_energy(model, s), WithinAbs(V, rounding));
  CHECK_THAT(energy(model, q, v, 0.4), WithinAbs(T + V, rounding));
  CHECK_THAT(energy(model, s), WithinAbs(T + V, rounding));
  CHECK_THAT(lagrangian(model, q, v, 0.4), WithinAbs(T - V, rounding));
  CHECK_THAT(lagrangian(model, s), WithinAbs(T - V, rounding));
  CHECK_THAT(jacobi_energy(model, q, v, 0.4), WithinAbs(T + V, rounding));
  CHECK_THAT(jacobi_energy(model, s), WithinAbs(T + V, rounding));
  CHECK((lagrangian_gradient(model, q, v, 0.4) - Vector2d(0.0, -m * g)).norm() < rounding);
  CHECK((lagrangian_gradient(model, s) - Vector2d(0.0, -m * g)).norm() < rounding);
  CHECK((conjugate_momenta(model, q, v, 0.4) - m * v).norm() < rounding);
  CHECK((conjugate_momenta(model, s) - m * v).norm() < rounding);
  CHECK((mass_matrix(model, q, v, 0.4) - m * Eigen::Matrix2d::Identity()).norm() < rounding);
  CHECK((mass_matrix(model, s) - m * Eigen::Matrix2d::Identity()).norm() < rounding);
  CHECK((rhs(model, q, v, 0.4) - forces).norm() < rounding);
  CHECK((rhs(model, s) - forces).norm() < rounding);
  CHECK((acceleration(model, q, v, 0.4) - forces / m).norm() < rounding);
  CHECK((acceleration(model, s) - forces / m).norm() < rounding);
  CHECK((inverse_dynamics(model, q, v, a, 0.4) - (m * a - forces)).norm() < rounding);
  CHECK((inverse_dynamics(model, s, a) - (m * a - forces)).norm() < rounding);
  CHECK_THAT(power(model, q, v, 0.4), WithinAbs(-drag * v.squaredNorm(), rounding));
  CHECK_THAT(power(model, s), WithinAbs(-drag * v.squaredNorm(), rounding));
  CHECK_THAT(energy_rate(model, q, v, 0.4), WithinAbs(-drag * v.squaredNorm(), rounding));
  CHECK_THAT(energy_rate(model, s), WithinAbs(-drag * v.squaredNorm(), rounding));
  for (const auto& slopes : {acceleration_jacobian(model, q, v, 0.4), acceleration_jacobian(model, s)}) {
    CHECK((slopes.qddot - forces / m).norm() < rounding);
    CHECK(slopes.d_q.norm() < rounding);
    CHECK((slopes.d_qdot + drag / m * Eigen::Matrix2d::Identity()).norm() < rounding);
  }
}

TEST_CASE("a system, a scene without effects and one with air answer the same questions, at a State as at its numbers") {
  check_of_both(bob, 0.0);
  check_of_both(scene(bob), 0.0);
  check_of_both(scene(bob, air), c);
  // Lists, expressions, and one of each.
  const Vector2d q(0.3, -1.2), v(0.8, 0.5);
  for (const double E : {energy(scene(bob, air), {0.3, -1.2}, {0.8, 0.5}), energy(scene(bob, air), q, {0.8, 0.5}), energy(scene(bob, air), q, 0.5 * (v + v)),
                         energy(bob, 2.0 * q - q, v), energy(bob, {0.3, -1.2}, v)})
    CHECK_THAT(E, WithinAbs(0.5 * m * v.squaredNorm() + m * g * q[1], rounding));
  CHECK((mass_matrix(scene(bob, air), q, Vector2d::Zero()) - m * Eigen::Matrix2d::Identity()).norm() < rounding);
  CHECK(power(bob, 2.0 * q, v) == 0.0);
  CHECK(reactions(bob, State<2>{0.0, Vector2d(0.3, -1.2), Vector2d(0.8, 0.5)}) == Vector2d::Zero());
  CHECK(reactions(scene(bob), State<2>{0.0, Vector2d(0.3, -1.2), Vector2d(0.8, 0.5)}) == Vector2d::Zero());
}

TEST_CASE("what a motion needs beyond a scene's own forces is m a + m g + c v, and on the free motion what the rod gives") {
  const ByAngle hand;
  const State<2> s = hand.state();
  const Vector2d wanted(3.0, -1.0);
  CHECK((inverse_dynamics(pendulum, s, wanted) - (m * wanted + Vector2d(0, m * g) + c * s.qdot)).norm() < 100 * rounding);
  CHECK((inverse_dynamics(pendulum, s, acceleration(pendulum, s)) - hand.tension()).norm() < 100 * rounding);
}

TEST_CASE("the Jacobian of a scene at a state is that of its formula, with the effects' own states held") {
  // q̈ = (u − ∇V − c q̇)/m with the input u = z along the first coordinate
  const auto pushed = scene(bob, air, qdot::input("push", 0));
  const State<2> s = {0.0, Vector2d(0.3, -0.2), Vector2d(0.5, 0.1)};
  const Eigen::Matrix<double, 1, 1> push(4.0);
  const auto a = acceleration_jacobian(pushed, s, push);
  CHECK((a.qddot - (Vector2d(push[0], -m * g) - c * s.qdot) / m).norm() < rounding);
  CHECK((a.qddot - acceleration(pushed, s, push)).norm() == 0.0);
  CHECK(a.d_q.norm() < rounding);
  CHECK((a.d_qdot + c / m * Eigen::Matrix2d::Identity()).norm() < rounding);
  CHECK_THAT(power(pushed, s, push), WithinAbs(push[0] * s.qdot[0] - c * s.qdot.squaredNorm(), rounding));
  CHECK_THAT(power(pushed, s), WithinAbs(-c * s.qdot.squaredNorm(), rounding));  // an input begins at zero
  CHECK((acceleration_jacobian(scene(bob), s).qddot - Vector2d(0, -g)).norm() < rounding);
}

using One = qdot::Vector<double, 1>;

const auto ball = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * m * v[0] * v[0]; }, [](const auto& q) { return m * g * q[0]; });
const auto floored = scene(ball, qdot::contact("floor", [](const auto& q) { return q[0]; }));

TEST_CASE("a ball that lies on a floor has the acceleration 0 and the reaction m g, and one that flies, is hit or leaves has -g and 0") {
  const State<1> lies{0.3, One(0.0), One(0.0)};
  CHECK_THAT(acceleration(floored, lies)[0], WithinAbs(0.0, rounding));
  CHECK_THAT(reactions(floored, lies)[0], WithinAbs(m * g, rounding));
  CHECK_THAT(acceleration(floored, lies.q, lies.qdot)[0], WithinAbs(0.0, rounding));
  CHECK_THAT(reactions(floored, lies.q, lies.qdot)[0], WithinAbs(m * g, rounding));
  CHECK_THAT(constrained_acceleration(floored, lies.q, lies.qdot).lambda[0], WithinAbs(m * g, rounding));
  CHECK_THAT(inverse_dynamics(floored, lies, One(0.0))[0], WithinAbs(m * g, rounding));  // what the floor bears
  for (const State<1>& flies : {State<1>{0.0, One(1e-3), One(0.0)}, State<1>{0.0, One(0.0), One(-2.0)}, State<1>{0.0, One(0.0), One(2.0)}}) {
    CHECK_THAT(acceleration(floored, flies)[0], WithinAbs(-g, rounding));
    CHECK(reactions(floored, flies)[0] == 0.0);
  }
  CHECK(qdot::error_message([] { (void)acceleration(floored, State<1>{0.0, One(-0.1), One(0.0)}); }).find("gap of a contact must not be negative") !=
        std::string::npos);
}

// A block of mass m on a table, pulled by P, with friction that holds up to F_s and slides with F_k.
auto pulled(double P, double F_k, double F_s) {
  return scene(qdot::mechanical_system<1>([](const auto& v) { return 0.5 * m * v[0] * v[0]; }, [P](const auto& q) { return -P * q[0]; }),
               qdot::dry_friction("table", 0, F_k, F_s));
}

TEST_CASE("friction at a state slides against the velocity or holds what pulls, and at its limit is asked for its phase") {
  const State<1> rest{0.0, One(0.0), One(0.0)}, forward{0.0, One(0.0), One(2.0)}, backward{0.0, One(0.0), One(-2.0)};
  const auto block = pulled(1.0, 3.0, 4.0);
  CHECK_THAT(acceleration(block, rest)[0], WithinAbs(0.0, rounding));
  CHECK_THAT(reactions(block, rest)[0], WithinAbs(-1.0, rounding));
  CHECK_THAT(acceleration(block, forward)[0], WithinAbs((1.0 - 3.0) / m, rounding));
  CHECK_THAT(acceleration(block, backward)[0], WithinAbs((1.0 + 3.0) / m, rounding));
  CHECK_THAT(rhs(block, forward.q, forward.qdot)[0], WithinAbs(1.0 - 3.0, rounding));
  CHECK_THAT(power(block, forward), WithinAbs(-6.0, rounding));
  CHECK_THAT(power(block, backward.q, backward.qdot), WithinAbs(-6.0, rounding));
  CHECK_THAT(energy_rate(block, forward.q, forward.qdot, 0.0), WithinAbs(-6.0, rounding));
  CHECK_THAT(inverse_dynamics(block, forward, One(0.0))[0], WithinAbs(3.0 - 1.0, rounding));
  CHECK(acceleration_jacobian(block, rest).d_qdot(0, 0) == 0.0);
  CHECK_THAT(acceleration(pulled(6.0, 3.0, 4.0), rest)[0], WithinAbs((6.0 - 3.0) / m, rounding));
  CHECK_THAT(acceleration(pulled(3.0, 3.0, 3.0), rest)[0], WithinAbs(0.0, rounding));  // which both phases say
  const auto at_limit = pulled(4.0, 3.0, 4.0);
  CHECK(qdot::error_message([&] { (void)acceleration(at_limit, rest); }).find("'table' may hold or begin to slip, at its limit of sticking of 4; pass") !=
        std::string::npos);
  CHECK_THAT(acceleration(at_limit, rest, One(1.0))[0], WithinAbs((4.0 - 3.0) / m, rounding));  // phases that are given are taken
}

// A bead on the outside of a circle of radius l: N = m g cos θ − m v²/l.
TEST_CASE("what is hardly open and would be pressed when closed is asked for its phase") {
  const auto circle = scene(bob, qdot::contact("circle", [](const auto& q) {
    using std::sqrt;
    return sqrt(q[0] * q[0] + q[1] * q[1]) - l;
  }));
  const double angle = 0.3, v = 1.0;
  const Vector2d outward(std::sin(angle), std::cos(angle)), along(std::cos(angle), -std::sin(angle));
  const double N = m * g * std::cos(angle) - m * v * v / l;
  CHECK((reactions(circle, State<2>{0.0, l * outward, v * along}) - N * outward).norm() < 100 * rounding);
  const State<2> blurred{0.0, (l + 3e-8) * outward, v * along + 2e-8 * outward}, flies{0.0, (l + 1e-3) * outward, v * along};
  CHECK(qdot::error_message([&] { (void)reactions(circle, blurred); }).find("'circle' may be open or closed, with a gap of 3e-08") != std::string::npos);
  CHECK((reactions(circle, blurred, One(1.0)) - N * outward).norm() < 1e-6 * N);
  CHECK((acceleration(circle, flies) - Vector2d(0.0, -g)).norm() < rounding);
}

// An integrator: ż = q, Q = −z, and z begins at 5.
struct Integrator {
  One initial_state() const { return One(5.0); }
  template <class S, int n>
  qdot::Vector<S, n> force(const qdot::Vector<S, n>&, const qdot::Vector<S, n>&, const qdot::Vector<S, 1>& z, const S&) const {
    return qdot::Vector<S, n>(-z[0]);
  }
  template <class S, int n>
  qdot::Vector<S, 1> state_rate(const qdot::Vector<S, n>& q, const qdot::Vector<S, n>&, const qdot::Vector<S, 1>&, const S&) const {
    return qdot::Vector<S, 1>(q[0]);
  }
};

TEST_CASE("states that are left out are the initial ones") {
  const auto held = scene(ball, Integrator{});
  CHECK_THAT(acceleration(held, One(0.0), One(0.0))[0], WithinAbs(-g - 5.0 / m, rounding));
  CHECK_THAT(rhs(held, One(0.0), One(0.0))[0], WithinAbs(-m * g - 5.0, rounding));
  CHECK_THAT(power(held, One(0.0), One(2.0)), WithinAbs(-10.0, rounding));
}

}  // namespace
