// SPDX-License-Identifier: MIT
//
// Bodies that turn, by the lines of a run, against nested duals, which know nothing but R(q).
#include "qdot/mechanics/derive/free_turns.hpp"
#include "qdot/mechanics/derive/traced_equations.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

#include "catch2_bridge.hpp"
#include "mechanics/form_of_run.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/mechanics/kinematic_system.hpp"
#include "systems/library_rotations.hpp"

using namespace qdot;

namespace {

constexpr double rounded = 1e-11;  // of some hundred operations, and the condition of M away from poles

// T = ½ Ω·I Ω with all of I, a rotor of constant spin along an axis, and ½ κ (p·ṗ)² or another inertia of what is no rotation: of each coordinate, one that
// varies, or one of another sum of p_i ṗ_i.
enum class Length { massless, own, plain, other, uneven };
template <class Rotation, Length length = Length::massless, bool has_rotor = false>
struct Turning {
  auto T(const auto& q, const auto& v) const {
    const auto w = body_angular_velocity_of(Rotation{}, q, v);
    auto turning = 0.5 * (1.0 * w[0] * w[0] + 2.0 * w[1] * w[1] + 2.5 * w[2] * w[2]) + 0.2 * w[0] * w[1] - 0.1 * w[1] * w[2];
    if constexpr (has_rotor) turning += 0.7 * w[2];
    if constexpr (length == Length::own) turning += 0.5 * 1.5 * q.dot(v) * q.dot(v);
    if constexpr (length == Length::plain) turning += 0.5 * 1.5 * v.squaredNorm();
    if constexpr (length == Length::uneven) {
      const auto sum = q[0] * v[0] + 2.0 * q[1] * v[1] + q[2] * v[2] + q[3] * v[3];
      turning += 0.5 * sum * sum;
    }
    if constexpr (length == Length::other) turning += 0.5 * (1.0 + q[1] * q[1]) * v.dot(v);
    return turning;
  }
  auto V(const auto& q) const { return 0.7 * q[0] * q[2]; }
};
template <class Rotation, Length length = Length::massless, bool has_rotor = false>
auto turning() { return mechanical_system<Rotation::n>(Turning<Rotation, length, has_rotor>{}); }
template <class Rotation>
auto torque() { return torque_on_body(Rotation{}, Eigen::Vector3d(0.3, -0.2, 0.5)); }

const Eigen::Matrix3d tensor = (Eigen::Matrix3d() << 1.0, 0.1, 0.0, 0.1, 2.0, -0.2, 0.0, -0.2, 2.5).finished();

// The largest difference of the lines of a run from dual numbers, states in a range of each coordinate, at times up to 1.
template <class Scene>
double difference_of_duals(const Scene& s, double lowest, double highest, bool lines_are_expected = true) {
  constexpr int n = Scene::dof_at_compile_time;
  std::mt19937 random{11};
  std::uniform_real_distribution<double> position(lowest, highest), velocity(-1.0, 1.0);
  const auto state = [&] {
    Eigen::VectorXd y(2 * n);
    for (int i = 0; i < n; ++i) y[i] = position(random), y[n + i] = velocity(random);
    return y;
  };
  const auto form = form_of_run(s), duals = first_order_form(s.by(By::duals));
  evaluate_until_lines(form, state());
  CHECK(is_by_lines(form.way_taken()) == (lines_are_expected || !formula::native_lines_are_possible()));
  double worst = 0.0;
  for (int sample = 0; sample < 30; ++sample) {
    const Eigen::VectorXd y = state();
    Eigen::VectorXd found(2 * n), expected(2 * n);
    form.derivative(0.03 * sample, y, found);
    duals.derivative(0.03 * sample, y, expected);
    worst = std::max(worst, (found - expected).norm() / (1.0 + expected.norm()));
  }
  return worst;
}
template <class Rotation>
double difference_of_turning(double lowest, double highest) {
  return std::max(difference_of_duals(scene(turning<Rotation>()), lowest, highest),
                  difference_of_duals(scene(turning<Rotation>(), torque<Rotation>()), lowest, highest));
}

// How many free turns a form is seen to have.
template <class System>
std::size_t free_turns_of(const System& system) {
  detail::TracedEquations<double> e(System::dof_at_compile_time, 0);
  detail::run_energies<System::dof_at_compile_time>(e.motion, system.energies());
  e.finds_free_turns = true;
  e.derive(false, {});
  return e.free_turns.size();
}

// A body and a mass that slides along one of its axes: Ω is not alone in T.
struct WithSlider {
  template <class S>
  S T(const Vector<S, 4>& q, const Vector<S, 4>& v) const {
    const auto R = [](const auto& x) { return euler_rotation_321(x[0], x[1], x[2]); };
    const auto w = body_angular_velocity_of(R, q, v);
    const auto mass = velocity_of([&](const auto& x) {
      const auto turn = R(x);
      return vector(turn(0, 1) * x[3], turn(1, 1) * x[3], turn(2, 1) * x[3]);
    }, q, v);
    return 0.5 * detail::quadratic_form(tensor, w) + 0.3 * mass.squaredNorm();
  }
  auto V(const auto& q) const { return 2.0 * q[3] * q[3]; }
};
// A wheel on an axle that is apart from the body, and one that changes its moments of inertia.
template <bool changes>
struct WithWheel {
  template <class S>
  S T(const Vector<S, 4>& q, const Vector<S, 4>& v) const {
    using std::cos;
    const auto w = body_angular_velocity_of([](const auto& x) { return euler_rotation_321(x[0], x[1], x[2]); }, q, v);
    const S T = 0.5 * (3.0 * w[0] * w[0] + 2.0 * w[1] * w[1] + w[2] * w[2] + 0.4 * v[3] * v[3]);
    if constexpr (changes) return T + cos(q[3]) * w[0] * w[0];
    else return T;
  }
  auto V(const auto& q) const { return 0.5 * q[3] * q[3]; }
};
// A rotor that is driven about an axis of the body: a product of Ω and another velocity.
struct WithRotor {
  template <class S>
  S T(const Vector<S, 4>& q, const Vector<S, 4>& v) const {
    const auto w = body_angular_velocity_of([](const auto& x) { return euler_rotation_321(x[0], x[1], x[2]); }, q, v);
    return 0.5 * detail::quadratic_form(tensor, w) + 0.3 * w[0] * v[3] + 0.15 * v[3] * v[3];
  }
  auto V(const auto& q) const { return 0.5 * q[3] * q[3] + 0.2 * q[1]; }
};
// Two bodies, one turned by angles that are no coordinates, one by those of the other.
struct Geared {
  template <class S>
  S T(const Vector<S, 3>& q, const Vector<S, 3>& v) const {
    const auto half = body_angular_velocity_of([](const auto& x) { return euler_rotation_313(0.5 * x[0], x[1], 2.0 * x[2]); }, q, v);
    const auto whole = body_angular_velocity_of([](const auto& x) { return euler_rotation_313(x[0], x[1], x[2]); }, q, v);
    return 0.5 * (detail::quadratic_form(tensor, half) + whole.squaredNorm()) + 0.1 * half[0] * whole[1];
  }
  auto V(const auto& q) const { return 0.3 * q[1]; }
};
// A matrix that is no rotation any more: an entry is written to.
struct Written {
  template <class S>
  S T(const Vector<S, 3>& q, const Vector<S, 3>& v) const {
    const auto w = body_angular_velocity_of([](const auto& x) {
      auto R = euler_rotation_313(x[0], x[1], x[2]);
      R(0, 2) = R(0, 2) + 0.1 * x[1];
      return R;
    }, q, v);
    return 0.5 * w.squaredNorm() + 0.5 * v.squaredNorm();
  }
  auto V(const auto& q) const { return 0.3 * q[1]; }
};
// Angles with other velocities than their own.
struct Foreign {
  template <class S>
  S T(const Vector<S, 3>& q, const Vector<S, 3>& v) const {
    const Vector<S, 3> twice = 2.0 * v;
    const auto w = body_angular_velocity_of([](const auto& x) { return euler_rotation_313(x[0], x[1], x[2]); }, q, twice);
    return 0.5 * detail::quadratic_form(tensor, w);
  }
  auto V(const auto& q) const { return 0.3 * q[1]; }
};

}  // namespace

TEST_CASE("by lines bodies have the accelerations that dual numbers find: Euler's angles, vectors, free and under torques") {
  CHECK(difference_of_turning<ByAngles<3, 1, 3>>(0.3, 1.2) < rounded);
  CHECK(difference_of_turning<ByAngles<3, 2, 3>>(0.3, 1.2) < rounded);
  CHECK(difference_of_turning<ByAngles<2, 1, 2>>(0.3, 1.2) < rounded);
  CHECK(difference_of_turning<ByAngles<1, 3, 1>>(0.3, 1.2) < rounded);
  CHECK(difference_of_turning<ByAngles<3, 2, 1>>(0.3, 1.2) < rounded);
  CHECK(difference_of_turning<ByAngles<2, 3, 1>>(0.3, 1.2) < rounded);
  CHECK(difference_of_turning<ByAngles<2, 1, 3>>(0.3, 1.2) < rounded);
  CHECK(difference_of_turning<ByAngles<1, 3, 2>>(0.3, 1.2) < rounded);
  CHECK(difference_of_turning<ByVector>(0.5, 1.5) < rounded);
  CHECK(difference_of_turning<ByVector>(-0.2, 0.2) < rounded);
  CHECK(difference_of_turning<ByVector>(-0.6, 0.6) < rounded);  // on both sides of |u| = 1/2
  CHECK(difference_of_duals(scene(turning<ByVector>()), -1e-9, 1e-9) < rounded);
}

TEST_CASE("by lines quaternions have the accelerations that dual numbers find: with an inertia of their length, another one, or of unit length") {
  CHECK(difference_of_duals(scene(turning<ByQuaternion, Length::own>()), 0.3, 1.0) < rounded);
  CHECK(difference_of_duals(scene(turning<ByQuaternion, Length::own>(), torque<ByQuaternion>()), 0.3, 1.0) < rounded);
  CHECK(difference_of_duals(scene(turning<ByQuaternion, Length::other>()), 0.3, 1.0) < rounded);
  const auto free = turning<ByQuaternion>().with_indefinite_mass_matrix();
  const auto unit = holonomic("unit length", [](const auto& p) { return 0.5 * (p.squaredNorm() - 1.0); });
  const auto plane = holonomic("plane", [](const auto& p) { return p[0] + 0.2 * p[1] - 0.3 * p[2] * p[3] - 0.8; });
  CHECK(difference_of_duals(scene(free, unit), 0.3, 1.0) < rounded);
  CHECK(difference_of_duals(scene(free, unit, torque<ByQuaternion>()), 0.3, 1.0) < rounded);
  CHECK(difference_of_duals(scene(free, plane), 0.3, 1.0) < rounded);
  CHECK(difference_of_duals(scene(free, unit, plane), 0.3, 1.0) < rounded);
}

TEST_CASE("a rotation is solved for by itself only where it is free of all else") {
  CHECK(free_turns_of(turning<ByAngles<3, 1, 3>>()) == 1);
  CHECK(free_turns_of(turning<ByQuaternion>()) == 1);
  CHECK(free_turns_of(turning<ByQuaternion, Length::own>()) == 1);
  CHECK(free_turns_of(turning<ByQuaternion, Length::other>()) == 0);
  CHECK(free_turns_of(turning<ByQuaternion, Length::plain>()) == 0);
  CHECK(free_turns_of(turning<ByQuaternion, Length::uneven>()) == 0);
  CHECK(free_turns_of(turning<ByAngles<3, 1, 3>, Length::other>()) == 0);
  CHECK(free_turns_of(turning<ByAngles<3, 1, 3>, Length::plain>()) == 0);
  CHECK(free_turns_of(mechanical_system<4>(WithRotor{})) == 0);
  CHECK(free_turns_of(turning<ByAngles<3, 1, 3>, Length::massless, true>()) == 1);
  CHECK(free_turns_of(mechanical_system<4>(WithSlider{})) == 0);
  CHECK(free_turns_of(mechanical_system<4>(WithWheel<false>{})) == 1);
  CHECK(free_turns_of(mechanical_system<4>(WithWheel<true>{})) == 0);
  CHECK(free_turns_of(mechanical_system<3>(Geared{})) == 0);
  CHECK(free_turns_of(mechanical_system<3>(Written{})) == 0);
  CHECK(free_turns_of(mechanical_system<3>(Foreign{})) == 0);
}

TEST_CASE("bodies that are not free, rotors, and rotations of other numbers have the accelerations that dual numbers find") {
  CHECK(difference_of_duals(scene(turning<ByAngles<3, 1, 3>, Length::other>()), 0.3, 1.2) < rounded);
  CHECK(difference_of_duals(scene(turning<ByAngles<3, 1, 3>, Length::massless, true>()), 0.3, 1.2) < rounded);
  CHECK(difference_of_duals(scene(turning<ByAngles<3, 1, 3>, Length::plain>()), 0.3, 1.2) < rounded);
  CHECK(difference_of_duals(scene(turning<ByQuaternion, Length::plain>()), 0.3, 1.0) < rounded);
  CHECK(difference_of_duals(scene(turning<ByQuaternion, Length::uneven>()), 0.3, 1.0) < rounded);
  CHECK(difference_of_duals(scene(mechanical_system<4>(WithRotor{})), 0.3, 1.2) < rounded);
  CHECK(difference_of_duals(scene(mechanical_system<4>(WithSlider{})), 0.3, 1.2) < rounded);
  CHECK(difference_of_duals(scene(mechanical_system<4>(WithWheel<false>{})), 0.3, 1.2) < rounded);
  CHECK(difference_of_duals(scene(mechanical_system<4>(WithWheel<true>{})), 0.3, 1.2) < rounded);
  CHECK(difference_of_duals(scene(mechanical_system<3>(Geared{})), 0.3, 1.2) < rounded);
  CHECK(difference_of_duals(scene(mechanical_system<3>(Written{})), 0.3, 1.2) < rounded);
  CHECK(difference_of_duals(scene(mechanical_system<3>(Foreign{})), 0.3, 1.2) < rounded);
}

TEST_CASE("bodies by where they are have the same lines: free, on a joint, off their centre of mass, driven") {
  const auto still = [](const auto& q) { return vector(0.0 * q[0], 0.0 * q[0], 0.0 * q[0]); };
  const auto free = kinematic_system<3>([=](const auto& q, auto& bodies) { bodies.rigid_body(1.5, tensor, still(q), euler_rotation_313(q[0], q[1], q[2])); });
  CHECK(free_turns_of(free) == 1);
  CHECK(difference_of_duals(scene(free), 0.3, 1.2) < rounded);
  const auto joint = kinematic_system<6>([=](const auto& q, auto& bodies) {
    const auto R = euler_rotation_313(q[0], q[1], q[2]);
    const auto S = euler_rotation_321(q[3], q[4], q[5]);
    bodies.rigid_body(1.0, tensor, vector(R(0, 2), R(1, 2), R(2, 2)), R);
    bodies.rigid_body(2.0, tensor, vector(2.0 * R(0, 2) + S(0, 1), 2.0 * R(1, 2) + S(1, 1), 2.0 * R(2, 2) + S(2, 1)), S);
  }, uniform_gravity(0.0, 0.0, -9.81));
  CHECK(free_turns_of(joint) == 0);
  CHECK(difference_of_duals(scene(joint), 0.3, 1.2) < rounded);
  const RigidBody off{1.5, Eigen::Vector3d(0.2, -0.1, 0.4), Eigen::Matrix3d(tensor + Eigen::Matrix3d::Identity())};
  const auto top = kinematic_system<3>([=](const auto& q, auto& bodies) { bodies.rigid_body(off, still(q), euler_rotation_313(q[0], q[1], q[2])); },
                                       uniform_gravity(0.0, 0.0, -9.81));
  CHECK(difference_of_duals(scene(top), 0.3, 1.2) < rounded);
  const auto driven = kinematic_system<2>([=](const auto& q, const auto& t, auto& bodies) {
    bodies.rigid_body(1.5, tensor, vector(q[0] * t, 0.2 * t, q[1]), euler_rotation_313(0.5 * t * t, q[0], q[1]));
  });
  CHECK(difference_of_duals(scene(driven), 0.3, 1.2) < rounded);
}

// Angles that are constants leave entries of Ω that are velocities, which other masses have as well.
TEST_CASE("turns about axes that are fixed have the accelerations that dual numbers find, with other masses on the same coordinates") {
  const auto still = [](const auto& q) { return vector(0.0 * q[0], 0.0 * q[0], 0.0 * q[0]); };
  const auto number = [](const auto& q, double x) { return std::remove_cvref_t<decltype(q[0])>(x); };
  const auto gravity = uniform_gravity(0.0, -9.81, 0.0);
  const auto pan_and_tilt = kinematic_system<2>([=](const auto& q, auto& bodies) {
    const auto R = euler_rotation_321(q[0], q[1], number(q, 0.0));
    bodies.rigid_body(1.5, tensor, still(q), R);
    bodies.point_mass(0.7, vector(R(0, 0) + q[1], R(1, 0), R(2, 0) + q[0]));
  }, gravity);
  CHECK(difference_of_duals(scene(pan_and_tilt), 0.3, 1.2) < rounded);
  const auto arm = kinematic_system<2>([=](const auto& q, auto& bodies) {
    using std::cos, std::sin;
    const auto R = euler_rotation_321(q[0], number(q, 0.0), number(q, 0.0));
    const auto Q = euler_rotation_321(q[1], number(q, 0.0), number(q, 0.0));
    bodies.rigid_body(1.0, tensor, vector(sin(q[0]), -cos(q[0]), 0.0 * q[0]), R);
    bodies.rigid_body(2.0, tensor, vector(2.0 * sin(q[0]) + sin(q[1]), -2.0 * cos(q[0]) - cos(q[1]), 0.0 * q[0]), Q);
  }, gravity);
  CHECK(difference_of_duals(scene(arm), 0.3, 1.2) < rounded);
  const auto tilted = kinematic_system<2>([=](const auto& q, auto& bodies) {
    const auto R = rotation_from_vector(vector(0.6 * q[0], 0.64 * q[0], 0.48 * q[0]));
    bodies.rigid_body(1.0, tensor, vector(R(0, 2), R(1, 2), R(2, 2)), R);
    bodies.rigid_body(1.0, tensor, vector(R(0, 2) + q[1], R(1, 2), R(2, 2)), euler_rotation_321(number(q, 0.3), number(q, 0.2), q[0] + q[1]));
  }, gravity);
  CHECK(difference_of_duals(scene(tilted), 0.3, 0.45) < rounded);
}

// Two coordinates without inertia, each decided by a constraint of its own.
TEST_CASE("where constraints decide all coordinates a run has their accelerations") {
  const auto massless = mechanical_system<2>([](const auto& q, const auto& v) { return 0.0 * q[0] * v[0] * v[1]; },
                                             [](const auto& q) { return q[0] * q[1]; }).with_indefinite_mass_matrix();
  const auto both = scene(massless, holonomic("first", [](const auto& q) { return 0.5 * q[0] * q[0] - 0.5; }),
                          holonomic("second", [](const auto& q) { return q[1] * q[1] * q[1] - 1.0; }));
  const auto form = form_of_run(both);
  Eigen::VectorXd y(4), found(4);
  y << 1.0, 1.0, 0.5, 0.25;
  evaluate_until_lines(form, y);
  form.derivative(0.0, y, found);
  CHECK(std::abs(found[2] + 0.25) < rounded);   // q₀ q̈₀ + q̇₀² = 0
  CHECK(std::abs(found[3] + 0.125) < rounded);  // 3 q₁² q̈₁ + 6 q₁ q̇₁² = 0
}

// Where Euler's angles have no inverse, M is singular, which the general way names; near it lines are left.
TEST_CASE("at a pole of Euler's angles a run by lines says what is wrong, and close to it the general way goes on") {
  const auto system = scene(turning<ByAngles<3, 1, 3>>());
  const auto form = form_of_run(system), duals = first_order_form(system.by(By::duals));
  Eigen::VectorXd y(6), found(6), expected(6);
  y << 0.4, 0.8, 0.3, 0.1, 0.2, 0.3;
  evaluate_until_lines(form, y);
  y[1] = 0.0;
  CHECK_THROWS_AS(form.derivative(0.0, y, found), SingularMassMatrix);
  y[1] = 1e-9;
  CHECK_THROWS_AS(form.derivative(0.0, y, found), SingularMassMatrix);
  constexpr double close = 1e-4, lost_there = 1e-5;  // sin θ = 1e-4: M has a condition of 1e8
  y[1] = close;
  form.derivative(0.0, y, found);
  duals.derivative(0.0, y, expected);
  CHECK((found - expected).norm() < lost_there * expected.norm());
}

// Free body: |I Ω| is constant in space, and the energy; its rotation vector grows beyond 1/2, where its formulas change.
TEST_CASE("a long run by a rotation vector keeps the angular momentum of a free body through both of its formulas") {
  const auto body = kinematic_system<3>([](const auto& u, auto& bodies) {
    bodies.rigid_body(1.0, tensor, vector(0.0 * u[0], 0.0 * u[0], 0.0 * u[0]), rotation_from_vector(u));
  });
  const auto momentum = [&](const auto& y) {
    const Eigen::Vector3d q = y.head(3), v = y.segment(3, 3);
    return Eigen::Vector3d(rotation_from_vector(q) * (tensor * body_angular_velocity_of(ByVector{}, q, v)));
  };
  // A swing about the axis of the largest moment, held back by a spring of the rotation, crosses |u| = 1/2 some hundred times.
  const auto start = State<3>{0.0, Vector<double, 3>(0.0, 0.0, 0.1), Vector<double, 3>(0.01, 0.02, 0.3)};
  const auto run = simulate(body, start, 4.0, Dop853{}, {.rtol = 1e-13, .atol = 1e-13, .max_step = 0.005});
  REQUIRE(run.completed());
  Eigen::VectorXd first(6);
  first << start.q, start.qdot;
  CHECK((momentum(run.y) - momentum(first)).norm() < 1e-11 * momentum(first).norm());
  const auto sprung = mechanical_system<3>([](const auto& q, const auto& v) {
    const auto w = body_angular_velocity_of(ByVector{}, q, v);
    return 0.5 * detail::quadratic_form(tensor, w);
  }, [](const auto& q) { return 2.0 * q.squaredNorm(); });
  const auto swing = simulate(sprung, start, 60.0, Dop853{}, {.rtol = 1e-12, .atol = 1e-12});
  const auto by_duals = simulate(sprung.by(By::duals), start, 60.0, Dop853{}, {.rtol = 1e-12, .atol = 1e-12});
  REQUIRE(swing.completed());
  CHECK((swing.y - by_duals.y).norm() < 1e-8);  // sixty seconds at 1e-12, steps that end at other places
}
