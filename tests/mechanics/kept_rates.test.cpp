// SPDX-License-Identifier: MIT
//
// Accelerations and multipliers by lines that a system keeps are those of the functors as they are at each call, beside those by dual numbers.
#include "qdot/mechanics/derive/kept_rates.hpp"

#include <cmath>
#include <thread>
#include <vector>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/effects/scene_motion.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/rotation.hpp"

using namespace qdot;

namespace {

constexpr double rounded = 1e-12;  // some hundred operations, and a condition below a hundred

template <class Sc>
double difference_from_duals(const Sc& s, const Coordinates<Sc>& q, const Coordinates<Sc>& qdot, double t = 0.3) {
  const auto expected = acceleration(s.by(By::duals), q, qdot, t);
  return (acceleration(s, q, qdot, t) - expected).norm() / (1.0 + expected.norm());
}
template <class Sc>
double difference_of_multipliers(const Sc& s, const Coordinates<Sc>& q, const Coordinates<Sc>& qdot, const EffectStates<Sc>& z) {
  const auto found = constrained_acceleration(s, q, qdot, 0.3, z), expected = constrained_acceleration(s.by(By::duals), q, qdot, 0.3, z);
  CHECK(found.rank == expected.rank);
  return (found.lambda - expected.lambda).norm() / (1.0 + expected.lambda.norm()) + (found.qddot - expected.qddot).norm() / (1.0 + expected.qddot.norm());
}

struct Pair {
  double m = 1.0;
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return 0.5 * (2.0 * v[0] * v[0] + m * v[1] * v[1]) + 0.7 * v[0] * v[1] * cos(q[0] - q[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -9.81 * (2.0 * cos(q[0]) + cos(q[1]));
  }
};
const Eigen::Vector2d q(0.4, 0.9), v(0.8, -0.3);

// Whether all lengths, each of them told after the first two calls, are noticed.
template <class Sc>
double worst_of_changes(const Sc& s, double& captured) {
  double worst = 0.0;
  for (int k = 0; k < 40; ++k) {
    captured = 1.0 + 0.05 * (k / 2) + (k % 4 == 3 ? 0.5 : 0.0);
    for (int again = 0; again < 3; ++again) worst = std::max(worst, difference_from_duals(s, q, v));
  }
  return worst;
}

}  // namespace

TEST_CASE("a number that an effect or an energy has captured is looked at in each call") {
  double x = 1.0;
  const auto pair = mechanical_system<2>(Pair{});
  const auto tip = [&x](const auto& at) {
    using std::cos, std::sin;
    return vector(x * sin(at[0]) + sin(at[1]), -x * cos(at[0]) - cos(at[1]));
  };
  CHECK(worst_of_changes(scene(pair, force_at_point(tip, Eigen::Vector2d(0.3, -0.8))), x) < rounded);
  CHECK(worst_of_changes(scene(pair, spring_damper(tip, Eigen::Vector2d(0.1, 0.2), 3.0, 0.4, 0.7)), x) < rounded);
  CHECK(worst_of_changes(scene(pair, rayleigh([&x](const auto&, const auto& w) { return 0.3 * x * w[0] * w[1]; })), x) < rounded);
  CHECK(worst_of_changes(scene(pair, torque_on_body([&x](const auto& at) { return rotation_z(x * at[0]); }, Eigen::Vector3d(0.0, 0.0, 0.4))), x) < rounded);
  CHECK(worst_of_changes(scene(pair, holonomic("tip", [&tip](const auto& at) { return tip(at)[1]; })), x) < rounded);
  CHECK(worst_of_changes(scene(pair, nonholonomic("skate", [&x](const auto& at, const auto& w) { return w[0] + x * at[1] * w[1]; })), x) < rounded);
  CHECK(worst_of_changes(scene(mechanical_system<2>([&x](const auto& at, const auto& w) { return Pair{x}.T(at, w); },
                                                    [](const auto& at) { return Pair{}.V(at); }),
                               viscous_damping(Eigen::Vector2d(0.1, 0.2))), x) < rounded);
}

TEST_CASE("more values than are kept are no trouble, nor are values that come back") {
  double x = 1.0;
  const auto s = scene(mechanical_system<2>(Pair{}), generalized_force([&x](const auto& at, const auto&) { return vector(x * at[0], at[1]); }));
  double worst = 0.0;
  for (int k = 0; k < 300; ++k) {
    x = 1.0 + 0.01 * (k % 150);
    for (int again = 0; again < 2; ++again) worst = std::max(worst, difference_from_duals(s, q, v));
  }
  CHECK(worst < rounded);
}

TEST_CASE("functors that differ in what is differentiated only are told apart") {
  // At the point that is asked, the values are the same numbers of the same formulas: x₀ x₀, once with one of them held.
  bool holds = false;
  const auto swinging = mechanical_system<2>(
      [&holds](const auto& at, const auto& w) {
        const auto held = at[0];
        const auto moved = velocity_of([&](const auto& x) { return vector(x[0] * (holds ? decltype(x[0] * held)(held) : x[0] * 1.0), x[1] * 1.0); }, at, w);
        return 0.5 * (moved.squaredNorm() + w[0] * w[0]);
      },
      [](const auto& at) { return at[0] * at[1]; });
  const auto drag = rayleigh([&holds](const auto&, const auto& w) { return (holds ? 0.25 : 0.5) * w[0] * w[0]; });
  for (int k = 0; k < 6; ++k) {
    holds = k % 2 == 1;
    CHECK(difference_from_duals(scene(swinging, drag), q, v) < rounded);
  }
}

TEST_CASE("what is held while something is differentiated is told apart from what moves") {
  // Both formulas are a square, and only what the derivative goes along tells them apart: x x, and x times a number that is x.
  bool holds = false;
  const auto square = [&holds](const auto& moving, const auto& held) {
    using Number = std::remove_cvref_t<decltype(moving * 1.0)>;
    const Number factor = holds ? Number(held) : Number(moving);
    return moving * factor;
  };
  const auto by_velocity = mechanical_system<2>(
      [&](const auto& at, const auto& w) {
        return 0.5 * velocity_of([&](const auto& x) { return vector(square(x[0], at[0]), square(x[1], at[1])); }, at, w).squaredNorm();
      },
      [](const auto& at) { return at[0] * at[1]; });
  const auto by_slope = mechanical_system<2>([](const auto& w) { return 0.5 * w.squaredNorm(); }, [&](const auto& at) {
    return at[1] * derivative([&](const auto& x) { return square(x, at[0]); }, at[0]);
  });
  for (int k = 0; k < 6; ++k) {
    holds = k % 2 == 1;
    CHECK(difference_from_duals(scene(by_velocity, viscous_damping(Eigen::Vector2d(0.1, 0.2))), q, v) < rounded);
    CHECK(difference_from_duals(scene(by_slope, viscous_damping(Eigen::Vector2d(0.1, 0.2))), q, v) < rounded);
  }
}

TEST_CASE("functors that ask whether numbers are equal have lines beside where they are") {
  double rest = 0.0;
  const auto drag = generalized_force([&rest](const auto&, const auto& w) {
    using S = std::remove_cvref_t<decltype(w[0] * 1.0)>;
    using std::sqrt;
    const S speed = w[0] == rest ? S(0.0) : S(sqrt(w[0] * w[0] + w[1] * w[1]));
    return vector(S(-0.3 * speed * w[0]), S(-0.3 * speed * w[1]));
  });
  const auto s = scene(mechanical_system<2>(Pair{}), drag);
  for (int k = 0; k < 3; ++k) {
    CHECK(difference_from_duals(s, q, v) < rounded);
    CHECK(difference_from_duals(s, q, Eigen::Vector2d(rest, 0.2)) < rounded);
  }
  rest = 0.8;  // where the first state is
  CHECK(difference_from_duals(s, q, v) < rounded);
  CHECK(difference_from_duals(s, q, Eigen::Vector2d(0.0, 0.2)) < rounded);
}

TEST_CASE("each combination of phases has lines of its own, and multipliers of its rows") {
  const auto tip = [](const auto& at) {
    using std::cos;
    return cos(at[0]) + cos(at[1]);
  };
  const auto s = scene(mechanical_system<2>(Pair{}), contact("wall", tip), holonomic("first", [](const auto& at) { return at[0] - 0.5 * at[1] * at[1]; }));
  EffectStates<std::remove_cvref_t<decltype(s)>> z = s.initial_states();
  for (int k = 0; k < 12; ++k) {
    z[0] = static_cast<double>(k % 3 == 0 ? ContactPhase::closed : ContactPhase::apart);
    CHECK(difference_of_multipliers(s, q, v, z) < rounded);
  }
}

TEST_CASE("multipliers are found where constraints lend inertia, and where a body is solved for by its turning") {
  const auto turning = mechanical_system<4>(
      [](const auto& p, const auto& w) {
        const auto omega = body_angular_velocity_of([](const auto& x) { return rotation_from_quaternion(x); }, p, w);
        return 0.5 * (1.0 * omega[0] * omega[0] + 2.0 * omega[1] * omega[1] + 2.5 * omega[2] * omega[2]);
      },
      [](const auto& p) { return 0.3 * p[0] * p[3]; });
  const auto body = turning.with_indefinite_mass_matrix();
  const auto length = holonomic("length", [](const auto& p, const auto& t) { return 0.5 * (p.squaredNorm() - 1.0 - 0.1 * t * t); });
  const Vector<double, 4> p(0.5, 0.6, -0.3, 0.4), rate(0.2, -0.4, 0.3, 0.7);
  const Vector<double, 0> none;
  CHECK(difference_of_multipliers(scene(body, length), p, rate, none) < rounded);
  const auto two = scene(body, length, nonholonomic("skate", [](const auto& x, const auto& w) { return w[1] + x[0] * w[2]; }));
  CHECK(difference_of_multipliers(two, p, rate, none) < rounded);
  const auto by_angles = mechanical_system<3>(
      [](const auto& a, const auto& w) {
        const auto omega = body_angular_velocity_of([](const auto& x) { return euler_rotation_313(x[0], x[1], x[2]); }, a, w);
        return 0.5 * (1.0 * omega[0] * omega[0] + 2.0 * omega[1] * omega[1] + 2.5 * omega[2] * omega[2]);
      },
      [](const auto& a) { return 0.3 * a[0]; });
  const auto held = scene(by_angles, holonomic("held", [](const auto& a) { return a[0] - 0.3 * a[1] * a[2]; }));
  CHECK(difference_of_multipliers(held, Eigen::Vector3d(0.4, 0.9, 0.2), Eigen::Vector3d(0.3, -0.5, 0.8), none) < rounded);
}

TEST_CASE("threads that share a system have the numbers of one, whatever they have captured") {
  const auto pair = mechanical_system<2>(Pair{});
  double worst[4] = {};
  {
    std::vector<std::jthread> threads;
    for (int k = 0; k < 4; ++k)
      threads.emplace_back([&, k] {
        for (int j = 0; j < 60; ++j) {
          const double c = 0.1 * (1 + (j + k) % 7);
          const auto s = scene(pair, viscous_damping(Eigen::Vector2d(c, 0.2)));
          worst[k] = std::max(worst[k], difference_from_duals(s, q, v));
        }
      });
  }
  for (const double of_one : worst) CHECK(of_one < rounded);
}

TEST_CASE("a run takes the lines of the phases that it is in") {
  const auto tip = [](const auto& at) {
    using std::cos;
    return cos(at[0]) + cos(at[1]);
  };
  const auto s = scene(mechanical_system<2>(Pair{}), contact("wall", tip));
  auto form = first_order_form(s);
  const auto by_duals = first_order_form(s.by(By::duals));
  form.renew();  // a leg begins, and functors are looked at no more
  Eigen::VectorXd y(form.size()), ydot(form.size()), expected(form.size());
  y << q, v, s.initial_states();
  for (int k = 0; k < 12; ++k) {
    y[4] = static_cast<double>(k % 3 == 0 ? ContactPhase::closed : ContactPhase::apart);
    form.derivative(0.3, y, ydot);
    by_duals.derivative(0.3, y, expected);
    CHECK((ydot - expected).norm() < rounded * (1.0 + expected.norm()));
  }
}

TEST_CASE("a form that no run has begun with looks at its functors in each evaluation") {
  double k = 1.0;
  const auto system = mechanical_system<2>([](const auto& w) { return 0.5 * w.squaredNorm(); }, [&k](const auto& at) { return k * at[0] * at[1]; });
  const auto free = first_order_form(system);
  const auto held = first_order_form(scene(system, holonomic("held", [&k](const auto& at) { return at[0] - k * at[1]; })));
  const Eigen::VectorXd y = (Eigen::VectorXd(4) << 0.5, 0.25, 0.0, 0.0).finished();
  Eigen::VectorXd ydot(4);
  for (const double next : {1.0, 5.0, 2.0}) {
    k = next;
    free.derivative(0.0, y, ydot);
    CHECK(ydot[2] == -0.25 * k);
    held.derivative(0.0, y, ydot);
    CHECK(std::abs(ydot[2] - k * ydot[3]) < rounded * k);
  }
}

TEST_CASE("comparisons that a recording answers by itself, or makes by itself, do not shift the answers of others") {
  double c = 2.0;
  const auto system = mechanical_system<2>([](const auto& w) { return 0.5 * w.squaredNorm(); },
                                           [&c](const auto& at) {
                                             using S = std::remove_cvref_t<decltype(at[0] * 1.0)>;
                                             using std::sqrt;
                                             const S first = at[0] > 0.0 ? S(c * at[0]) : S(3.0 * at[0]);
                                             const S last = at[0] - at[0] > 1.0 ? S(0.1 * at[0]) : S(0.0 * at[0]);
                                             return S(first + sqrt(at[1] * at[1]) + last);
                                           });
  for (const double next : {2.0, 7.0, 7.0, 3.0}) {
    c = next;
    for (const double at : {0.5, -0.5}) CHECK(acceleration(system, Eigen::Vector2d(at, 0.5), Eigen::Vector2d(0.0, 0.0))[0] == (at > 0.0 ? -c : -3.0));
  }
}

TEST_CASE("energies by derivatives of rotations, and by positions of which a part stands still, are those by dual numbers") {
  const auto slewed = mechanical_system<2>(
      [](const auto& at, const auto& w) {
        using S = std::remove_cvref_t<decltype(at[0] * w[0])>;
        const Vector<S, 3> slope = derivative([&](const auto& s) {
          const auto frame = [](const auto& x) { return euler_rotation_313(x[0], x[1], x[0]); };
          using D = std::remove_cvref_t<decltype(s)>;
          return Vector<D, 3>(body_angular_velocity_of(frame, vector(D(s), D(at[1])), vector(D(w[0]), D(w[1]))));
        }, S(at[0]));
        return S(0.5 * (w[0] * w[0] + w[1] * w[1]) + 0.01 * slope.squaredNorm());
      },
      [](const auto& at) { return at[0] * at[1]; });
  const auto half = mechanical_system<2>(
      [](const auto& at, const auto& w) {
        using S = std::remove_cvref_t<decltype(at[0] * w[0])>;
        const auto moved = velocity_of([](const auto& x) { return vector(x[0] * x[1], x[1] * x[1]); }, vector(S(2.0), S(at[0])), vector(S(0.0), S(w[0])));
        return S(moved.squaredNorm() + w[1] * w[1]);
      },
      [](const auto& at) { return at[0] * at[1]; });
  const auto by_duals = [](const auto& system) { return acceleration(system, q, v, 0.0, By::duals); };
  for (int k = 0; k < 3; ++k) {
    CHECK((acceleration(slewed, q, v) - by_duals(slewed)).norm() < rounded);
    CHECK((acceleration(half, q, v) - by_duals(half)).norm() < rounded);
  }
}
