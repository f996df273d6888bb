// SPDX-License-Identifier: MIT
//
// What a scene cannot have, and what its functors must not return: refused by name, with values and a remedy, before anything
// is copied.
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "../catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

namespace {

using Eigen::Vector2d;
using qdot::Dynamic;
using qdot::holonomic;
using qdot::mechanical_system;
using qdot::scene;
using qdot::Vector;

const auto free_point = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }).with_names({"x", "y"});

// x = 0, and from t = 1 on y = 0 as well: a vector of run-time length.
const auto one_then_two = [](const auto& q, const auto& t) {
  using S = typename std::decay_t<decltype(q)>::Scalar;
  Vector<S, Dynamic> rows(t < 1.0 ? 1 : 2);
  for (Eigen::Index i = 0; i < rows.size(); ++i) rows[i] = q[i];
  return rows;
};

struct Choosy {
  void require_fit(const Vector2d&) const { throw qdot::InvalidValue("this effect fits nothing"); }
  template <class S>
  Vector<S, 2> force(const Vector<S, 2>& q, const Vector<S, 2>&, const S&) const {
    return q;
  }
};

}  // namespace

TEST_CASE("a constraint of run-time length moves as one whose length the compiler knows, declared or not") {
  const auto circle = [](const auto& q) {
    using S = typename std::decay_t<decltype(q)>::Scalar;
    return Vector<S, Dynamic>(Vector<S, Dynamic>::Constant(1, q.squaredNorm() - 1.0));
  };
  const auto known = scene(free_point, holonomic("circle", [](const auto& q) { return q.squaredNorm() - 1.0; }));
  const auto counted = scene(free_point, holonomic("circle", circle));
  const auto declared = scene(free_point, holonomic<1>("circle", circle));
  STATIC_REQUIRE(decltype(counted)::constraints_at_compile_time == Dynamic);
  STATIC_REQUIRE(decltype(declared)::constraints_at_compile_time == 1);
  const Vector2d q(0.6, -0.8), v(0.8, 0.6);
  CHECK((acceleration(counted, q, v) - acceleration(known, q, v)).norm() < 1e-15);
  CHECK(acceleration(declared, q, v) == acceleration(known, q, v));
  CHECK((acceleration(known, q, v) + q).norm() < 1e-15);  // uniform motion on the unit circle
}

TEST_CASE("a constraint whose number of rows changes is named with both numbers") {
  const auto s = scene(free_point, qdot::prescribed("drive", 1, [](const auto& t) { return 0.0 * t; }), holonomic("grip", one_then_two));
  CHECK(constraint_names(s) == std::vector<std::string>{"drive", "grip"});
  const auto complaint =
      "a constraint must have the same number of rows in every state, but 'grip' had 1 at q = 0 when the scene was made, and returned 2 "
      "at t = 2.000000; return a row for each condition at all times";
  const Vector2d q(0, 0), v(0, 0);
  CHECK_THROWS_WITH(constraint_residual(s, q, 2.0), complaint);
  CHECK_THROWS_WITH(constraint_velocity(s, q, v, 2.0), complaint);
  CHECK_THROWS_WITH(constraint_acceleration(s, q, v, v, 2.0), complaint);
  CHECK_THROWS_WITH(constraint_jacobian(s, q, v, 2.0), complaint);
  CHECK_THROWS_WITH(acceleration(s, q, v, 2.0), complaint);
}

TEST_CASE("a number of rows that changes during a run ends it in a named outcome") {
  const auto run = simulate(scene(free_point, holonomic("grip", one_then_two)), qdot::State<2>{0.0, Vector2d(0, 1), Vector2d(0, 2)}, 3.0,
                            qdot::Dop853{});
  REQUIRE(run.outcome == qdot::Outcome::constraint_failure);
  CHECK(run.message.find("'grip' had 1") != std::string::npos);
  CHECK_THAT(run.t, WithinAbs(1.0, 1e-9));
  CHECK_THAT(run.y[1], WithinAbs(3.0, 1e-9));  // y = 1 + 2 t as far as it came
}

TEST_CASE("a constraint that returns another number of rows than it declares is named with both numbers") {
  const auto s = scene(free_point, holonomic<2>("grip", one_then_two));
  CHECK_THROWS_WITH(acceleration(s, Vector2d(0, 0), Vector2d(0, 0), 0.5),
                    "a constraint must have as many rows as it declares, but 'grip' declares 2 and returned 1 at t = 0.500000; make the two "
                    "agree");
  CHECK(acceleration(s, Vector2d(0, 0), Vector2d(0, 0), 1.5) == Vector2d(0, 0));
  const auto skate = scene(free_point, qdot::nonholonomic<1>("skate", [](const auto&, const auto& v) {
                             using S = typename std::decay_t<decltype(v)>::Scalar;
                             return Vector<S, Dynamic>(Vector<S, Dynamic>::Constant(3, v[0]));
                           }));
  CHECK_THROWS_AS(acceleration(skate, Vector2d(0, 0), Vector2d(0, 0)), qdot::ConstraintError);
}

TEST_CASE("an effect on a coordinate that does not exist is refused when the scene is made") {
  const auto at_rest = [](const auto& t) { return 0.0 * t; };
  CHECK_THROWS_WITH(scene(free_point, qdot::prescribed("motor", 2, at_rest)),
                    "an effect can only act on a coordinate of its system, 0 to 1, but the drive 'motor' is given coordinate 2; count "
                    "coordinates from 0");
  CHECK_THROWS_AS(scene(free_point, qdot::prescribed("motor", -1, at_rest)), qdot::InvalidValue);
  CHECK_THROWS_AS(scene(free_point, qdot::dry_friction("block", 2, 0.3)), qdot::InvalidValue);
  CHECK_THROWS_AS(scene(free_point, qdot::regularized_friction(2, 0.3, 1e-3)), qdot::InvalidValue);
  const auto run_time = mechanical_system(2, [](const auto& v) { return 0.5 * v.squaredNorm(); });
  CHECK_THROWS_AS(scene(run_time, qdot::prescribed("motor", 2, at_rest)), qdot::InvalidValue);
  CHECK_THROWS_AS(scene(run_time, qdot::prescribed<2>("motor", at_rest)), qdot::InvalidValue);
  CHECK_THROWS_AS(scene(run_time, qdot::viscous_damping(Eigen::VectorXd::Constant(3, 0.1))), qdot::DimensionError);
  const auto driven = scene(free_point, qdot::prescribed<1>("motor", [](const auto& t) { return t * t; }));
  CHECK(acceleration(driven, Vector2d(0, 0), Vector2d(0, 0)) == Vector2d(0, 2));
}

TEST_CASE("an effect of the user's own may say what it fits") {
  CHECK_THROWS_WITH(scene(free_point, Choosy{}), "this effect fits nothing");
}

TEST_CASE("a force of the wrong length is refused with both lengths") {
  const auto three = [](const auto& q, const auto&) {
    using S = typename std::decay_t<decltype(q)>::Scalar;
    return Vector<S, Dynamic>(Vector<S, Dynamic>::Zero(3));
  };
  CHECK_THROWS_WITH(acceleration(scene(free_point, qdot::generalized_force(three)), Vector2d(0, 0), Vector2d(0, 0)),
                    "a generalized force must have 2 entries, but has 3; return as many entries as there are coordinates (of the point, for "
                    "a force at a point)");
}

TEST_CASE("an effect whose force is not finite is named, alone and beside constraints") {
  const auto root = [](const auto& q, const auto&) {
    using std::sqrt;
    return qdot::vector(0.0 * q[0], sqrt(q[0]));
  };
  const std::string complaint =
      "the force of an effect must be finite, but that of effect 2 of 2 on y is not at t = 0.000000; look there for a division by zero, or a "
      "root or logarithm outside its domain";
  const auto pushed = scene(free_point, qdot::viscous_damping(Vector2d(1, 1)), qdot::generalized_force(root));
  CHECK_THROWS_WITH(acceleration(pushed, Vector2d(-1, 0), Vector2d(0, 0)), complaint);
  const auto guided = scene(free_point, holonomic("line", [](const auto& q) { return q[0] - q[1]; }), qdot::generalized_force(root));
  CHECK_THROWS_WITH(acceleration(guided, Vector2d(-1, -1), Vector2d(0, 0)), complaint);
  const auto run = simulate(pushed, qdot::State<2>{0.0, Vector2d(1, 0), Vector2d(-3, 0)}, 3.0, qdot::Dop853{});
  REQUIRE(run.outcome == qdot::Outcome::non_finite);
  CHECK(run.message.find("effect 2 of 2") != std::string::npos);
  CHECK_THAT(run.t, WithinAbs(std::log(1.5), 1e-3));  // x = 1 − 3 (1 − e^−t) reaches zero
}

TEST_CASE("a constraint that is not finite is named, and never dropped") {
  // A point on y = √(1 − x), which ends at x = 1.
  const auto s = scene(free_point, holonomic("curve", [](const auto& q) {
                         using std::sqrt;
                         return q[1] - sqrt(1.0 - q[0]);
                       }));
  const std::string complaint =
      "a constraint and its derivatives must be finite, but those of 'curve' are not at t = 0.000000; look there for a division by zero, or "
      "a root or logarithm at or outside the edge of its domain";
  CHECK_THROWS_WITH(acceleration(s, Vector2d(2, 0), Vector2d(0, 1)), complaint);
  CHECK_THROWS_WITH(consistent_state(s, qdot::State<2>{0.0, Vector2d(2, 0), Vector2d(0, 0)}), complaint);
  const auto run = simulate(s, qdot::State<2>{0.0, Vector2d(0, 1), Vector2d(1, -0.5)}, 3.0, qdot::Dop853{});
  CHECK(run.outcome == qdot::Outcome::non_finite);
  CHECK(run.message.find("'curve'") != std::string::npos);
}

TEST_CASE("beside several constraints it is the state or T that is named where they are no numbers") {
  const auto both = [](const auto& q) { return qdot::vector(q[1], q[0] * q[0]); };
  const auto free = scene(free_point, holonomic("both", both));
  const double none = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(acceleration(free, Vector2d(none, 0), Vector2d(0, 0)),
                    "the equations of motion must be finite, but x is not at t = 0; check T and V there for a division by zero, a root or "
                    "logarithm outside its domain, or overflow");
  const auto heavy = scene(mechanical_system<2>([](const auto& q, const auto& v) {
                             using std::sqrt;
                             return 0.5 * sqrt(q[0]) * v.squaredNorm();
                           }),
                           holonomic("line", [](const auto& q) { return q[0] - q[1]; }));
  CHECK_THROWS_WITH(acceleration(heavy, Vector2d(-1, -1), Vector2d(1, 1)),
                    "the energies must be finite, but T is nan at t = 0, because sqrt(x) has no value at x = -1 (it needs x >= 0); check it there for a "
                    "division by zero, a root or logarithm outside its domain, or overflow");
}
