// SPDX-License-Identifier: MIT
//
// Scenes by lines against nested duals: the same M, r, J and γ from the functors' definitions, solved as a whole.
#include "qdot/effects/scene_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <Eigen/LU>

#include "bench/chain_energies.hpp"
#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/mechanics/kinematic_system.hpp"
#include "qdot/mechanics/rotation.hpp"

using namespace qdot;

namespace {

// Rounding of both, times the condition of M and of J M⁻¹ Jᵀ.
constexpr double rounded = 1e-12, rounded_derivatives = 1e-11;

using bench::TipOfChain;
const auto moving_pair = [](const auto& q, const auto& t) {
  using std::cos, std::sin;
  return vector(sin(q[0]) - 0.2 * cos(t), q[0] * q[1] - sin(2.0 * t));
};
// The same pair as a vector of run-time length, which loses a row.
const auto pair_that_breaks = [](const auto& q, const auto& t) {
  using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
  return t < 2.0 ? Vector<S, Dynamic>(moving_pair(q, t)) : Vector<S, Dynamic>(q.head(1));
};
const auto skate = [](const auto& q, const auto& v, const auto& t) {
  using std::cos, std::sin;
  return v[0] * sin(q[1]) - v[1] * cos(q[0]) + cos(t);
};

// K = [M −Jᵀ; J 0] and its right-hand side, all of it by nested duals.
template <class Sc>
struct Whole {
  static constexpr int n = Sc::dof_at_compile_time, m = Sc::constraints_at_compile_time;
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n + m, n + m);
  Eigen::VectorXd both;  // q̈, λ

  Whole(const Sc& s, const Vector<double, n>& q, const Vector<double, n>& v, double t, const EffectStates<Sc>& z) {
    const auto rows = constraint_rows(s, q, v, t, z);
    Eigen::VectorXd right(n + m);
    Vector<double, n> force = detail::lagrange_rhs<n>(s.system().energies(), q, v, t);
    if constexpr (Sc::has_forces) force += effect_forces(s, q, v, z, t);
    right << force, rows.gamma;
    K.topLeftCorner(n, n) = detail::kinetic_hessian<n>(s.system().energies(), q, v, t);
    K.topRightCorner(n, m) = -rows.J.transpose();
    K.bottomLeftCorner(m, n) = rows.J;
    for (int i = 0; i < m; ++i)
      if (rows.J.row(i).isZero(0.0)) K(n + i, n + i) = 1.0;  // not active
    both = K.fullPivLu().solve(right);
  }

  // ∂q̈/∂(q, q̇) at fixed q̈ and λ, a direction at a time.
  Eigen::MatrixXd jacobian(const Sc& s, const Vector<double, n>& q, const Vector<double, n>& v, double t, const EffectStates<Sc>& z) const {
    using D = Dual<double, 1>;
    Eigen::MatrixXd right(n + m, 2 * n);
    const Vector<double, n> a = both.head(n);
    for (int j = 0; j < 2 * n; ++j) {
      Vector<D, n> x = detail::constants<D>(q), u = detail::constants<D>(v);
      (j < n ? x[j] : u[j - n]).tangent[0] = 1.0;
      const Vector<D, n> fixed = detail::constants<D>(a);
      Vector<D, n> r = -detail::lagrange_residual<n>(s.system().energies(), x, u, fixed, D(t));
      if constexpr (Sc::has_forces) r += effect_forces(s, x, u, Vector<D, Sc::states_at_compile_time>(z.template cast<D>()), D(t));
      const auto J = constraint_jacobian(s, x, u, D(t), z);
      const auto c = constraint_acceleration(s, x, u, fixed, D(t), z);
      for (int i = 0; i < n; ++i) {
        D sum = r[i];
        for (int k = 0; k < m; ++k) sum += J(k, i) * both[n + k];
        right(i, j) = sum.tangent[0];
      }
      for (int k = 0; k < m; ++k) right(n + k, j) = -c[k].tangent[0];
    }
    return K.fullPivLu().solve(right).topRows(n);
  }
};

struct Worst {
  double acceleration = 0.0, reaction = 0.0, jacobian = 0.0;
};

template <class Sc>
Worst differences(const Sc& s, const EffectStates<Sc>& z = EffectStates<Sc>()) {
  constexpr int n = Sc::dof_at_compile_time;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.5, 1.5);
  Worst worst;
  for (int sample = 0; sample < 20; ++sample) {
    Vector<double, n> q, v;
    for (int i = 0; i < n; ++i) {
      q[i] = uniform(random);
      v[i] = uniform(random);
    }
    const double t = uniform(random);
    const Whole<Sc> whole(s, q, v, t, z);
    const double size = 1.0 + whole.both.norm();
    if (whole.both.norm() > 1e3) continue;  // near a dead point; the condition is another then
    const auto solution = constrained_acceleration(s, q, v, t, z);
    worst.acceleration = std::max(worst.acceleration, (solution.qddot - whole.both.head(n)).norm() / size);
    worst.reaction = std::max(worst.reaction, (solution.lambda - whole.both.tail(Sc::constraints_at_compile_time)).norm() / size);
    const SceneForm<Sc> form(s);
    Eigen::VectorXd y(form.size());
    y << q, v, z;
    Eigen::MatrixXd J(form.size(), form.size());
    form.jacobian(t, y, J);
    const Eigen::MatrixXd expected = whole.jacobian(s, q, v, t, z);
    worst.jacobian = std::max(worst.jacobian, (J.block(n, 0, n, 2 * n) - expected).norm() / (1.0 + expected.norm()) / size);
  }
  return worst;
}

void check(const Worst& worst) {
  CHECK(worst.acceleration < rounded);
  CHECK(worst.reaction < rounded);
  CHECK(worst.jacobian < rounded_derivatives);
}

// The Jacobian of a scene by its form beside the one by nested duals.
template <class Sc>
double difference_of_jacobians(const Sc& s, const EffectStates<Sc>& z = EffectStates<Sc>()) {
  constexpr int n = Sc::dof_at_compile_time;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0.3, 1.2);
  double worst = 0.0;
  const auto form = first_order_form(s);
  for (int sample = 0; sample < 20; ++sample) {
    Eigen::VectorXd y(2 * n + z.size());
    for (double& x : y) x = uniform(random);
    y.tail(z.size()) = z;
    const double t = uniform(random);
    Eigen::MatrixXd of_form(y.size(), y.size()), reference(y.size(), y.size());
    form.jacobian(t, y, of_form);
    detail::write_scene_jacobian(detail::SceneSlopesOf<Sc>(s), t, y, reference);
    worst = std::max(worst, (of_form - reference).norm() / (1.0 + reference.norm()));
  }
  return worst;
}

// A cart that is moved, a rod on it in the plane, and a spring to the ground by the functions of <cmath>.
struct CartAndRod {
  void operator()(const auto& q, const auto& t, auto& bodies) const {
    using std::cos, std::sin;
    const auto x = q[0] + 0.3 * sin(2.0 * t);
    bodies.point_mass(2.0, vector(x));
    bodies.planar_body(1.0, 0.2, vector(x + 0.5 * sin(q[1]), -0.5 * cos(q[1])), q[1] + 0.1 * q[0] * q[0]);
  }
};
const auto spring_of_functions = [](const auto& q, const auto& t) {
  using std::atan2, std::exp, std::hypot, std::pow, std::sqrt;
  return 3.0 * sqrt(1.0 + q[0] * q[0]) + exp(0.2 * q[1]) / (2.0 + q[0]) + hypot(q[0], q[1]) * t + atan2(q[1], q[0]) + pow(q[0], q[1]) - pow(q[1], 3);
};

// T and V as they are, of time as well.
struct DrivenPair {
  auto T(const auto& q, const auto& v, const auto& t) const {
    using std::cos;
    return (0.7 + 0.1 * cos(t)) * v[0] * v[0] + 0.4 * v[1] * v[1] + 0.3 * cos(q[0] - q[1]) * v[0] * v[1] + 0.2 * t * q[0] * v[1];
  }
  auto V(const auto& q, const auto& t) const { return spring_of_functions(q, t); }
};

template <int n>
Vector<double, n> some_damping() {
  return Vector<double, n>::LinSpaced(n, 0.1, 0.4);
}

}  // namespace

TEST_CASE("constraints and damping give what nested duals give, by every way to M and r") {
  const auto straight = scene(mechanical_system<3>(bench::UnrolledChain<3>{}), viscous_damping(some_damping<3>()),
                              nonholonomic("skate", skate), holonomic("tip", TipOfChain<3>{}));
  STATIC_REQUIRE(detail::has_rates<std::remove_cvref_t<decltype(straight)>>);
  check(differences(straight));
  check(differences(scene(mechanical_system<5>(bench::LoopedChain{}), viscous_damping(some_damping<5>()), holonomic("tip", TipOfChain<5>{}))));
  check(differences(scene(kinematic_system<3>(bench::UnrolledPositions<3>{}, gravity_along<1>(-9.81)), holonomic("pair", moving_pair))));
}

// A body by a quaternion whose length has no inertia, and one that an other constraint has to hold as well.
struct TurningBody {
  auto T(const auto& p, const auto& v) const {
    const auto w = body_angular_velocity_of([](const auto& x) { return rotation_from_quaternion(x); }, p, v);
    return 0.5 * (1.0 * w[0] * w[0] + 2.0 * w[1] * w[1] + 2.5 * w[2] * w[2]);
  }
  auto V(const auto& p) const { return 0.3 * p[0] * p[3]; }
};

TEST_CASE("what constraints lend to a mass matrix that is singular changes neither accelerations nor multipliers") {
  const auto body = mechanical_system<4>(TurningBody{}).with_indefinite_mass_matrix();
  const auto length = holonomic("length", [](const auto& p, const auto& t) { return 0.5 * (p.squaredNorm() - 1.0 - 0.1 * t * t); });
  check(differences(scene(body, length)));
  check(differences(scene(body, viscous_damping(some_damping<4>()), length, nonholonomic("skate", skate))));
}

TEST_CASE("a contact takes part where it is closed, and asks for nothing where it is open") {
  const auto s = scene(mechanical_system<2>(bench::UnrolledChain<2>{}), contact("wall", TipOfChain<2>{}),
                       holonomic("first", [](const auto& q) { return q[0] - 0.5 * q[1]; }));
  EffectStates<std::remove_cvref_t<decltype(s)>> z = s.initial_states();
  for (const bool closed : {false, true}) {
    INFO(closed);
    z[0] = static_cast<double>(closed ? ContactPhase::closed : ContactPhase::apart);
    REQUIRE(std::get<0>(s.effects()).is_active(z[0]) == closed);
    check(differences(s, z));
  }
}

TEST_CASE("rows that depend on each other fall to the general way, which finds them") {
  const auto s = scene(mechanical_system<2>(bench::UnrolledChain<2>{}), holonomic("tip", TipOfChain<2>{}),
                       holonomic("again", [](const auto& q) { return 2.0 * TipOfChain<2>{}(q); }));
  const auto solution = constrained_acceleration(s, Vector<double, 2>(0.4, 0.9), Vector<double, 2>(0.3, -0.2));
  CHECK(solution.rank == 1);
  const auto once = scene(mechanical_system<2>(bench::UnrolledChain<2>{}), holonomic("tip", TipOfChain<2>{}));
  const auto expected = constrained_acceleration(once, Vector<double, 2>(0.4, 0.9), Vector<double, 2>(0.3, -0.2));
  CHECK((solution.qddot - expected.qddot).norm() < rounded * (1.0 + expected.qddot.norm()));
}

TEST_CASE("a constraint of run-time length that declares its rows goes this way, and is named when it has others") {
  const auto s = scene(mechanical_system<2>(bench::UnrolledChain<2>{}), holonomic<2>("pair", pair_that_breaks));
  STATIC_REQUIRE(detail::has_rates<std::remove_cvref_t<decltype(s)>>);
  check(differences(s));
  CHECK_THROWS_WITH(acceleration(s, Vector<double, 2>(0.4, 0.9), Vector<double, 2>(0.3, -0.2), 3.0),
                    "a constraint must have as many rows as it declares, but 'pair' declares 2 and returned 1 at t = 3.000000; make the two agree");
}

TEST_CASE("a constraint at a time that is no number is named, though J and gamma may be numbers") {
  const auto s = scene(mechanical_system<2>(bench::UnrolledChain<2>{}), holonomic("drive", [](const auto& q, const auto& t) { return q[0] - t * t; }));
  const auto none = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(acceleration(s, Vector<double, 2>(0.4, 0.9), Vector<double, 2>(0.3, -0.2), none), NonFinite);
}

TEST_CASE("nearly dependent rows have one rank, whoever is asked") {
  // sin² of the angle between both rows, in the metric of M, from below the square of the cut-off to far above it
  for (const double small : {3e-6, 1e-5, 2e-5, 5e-5, 3e-4}) {
    CAPTURE(small);
    const auto s = scene(mechanical_system<2>(bench::UnrolledChain<2>{}),
                         holonomic("both", [small](const auto& q) { return vector(q[0] + small * q[1], q[0]); }));
    const Vector<double, 2> q(0.4, 0.9), v(0.3, -0.2);
    const detail::ConstrainedFactors<2, 2> factors(mass_matrix(s, q, v), constraint_jacobian(s, q, v, 0.0), default_rank_cutoff);
    const auto solution = constrained_acceleration(s, q, v);
    CHECK(solution.rank == factors.rank());
    if (factors.constraint_pivot() < detail::clearly_independent * default_rank_cutoff * default_rank_cutoff)
      CHECK(solution.smallest_pivot == factors.constraint_pivot());
  }
}

TEST_CASE("slopes of positions, energies, potentials and forces give the Jacobian that nested duals give") {
  const auto spring = spring_damper([](const auto& q) { return vector(q[0], 0.2 * q[1]); }, Eigen::Vector2d(-1.0, 0.5), 20.0, 1.2, 0.5);
  CHECK(difference_of_jacobians(scene(kinematic_system<2>(CartAndRod{}, spring_of_functions), spring)) < rounded_derivatives);
  CHECK(difference_of_jacobians(scene(kinematic_system<2>(CartAndRod{}, gravity_along<1>(-9.81)), spring, holonomic("curve", spring_of_functions))) <
        rounded_derivatives);
  CHECK(difference_of_jacobians(scene(mechanical_system<2>(DrivenPair{}), spring, holonomic("curve", spring_of_functions))) < rounded_derivatives);
  CHECK(difference_of_jacobians(scene(mechanical_system<2>(bench::LoopedChain{}), spring, nonholonomic("skate", skate))) <
        rounded_derivatives);
  CHECK(difference_of_jacobians(scene(mechanical_system<4>(bench::LoopedChain{}), viscous_damping(some_damping<4>()),
                                      holonomic("tip", TipOfChain<4>{}))) <
        rounded_derivatives);
}

// Two bodies in space, the second on a joint of the first, neither in its main axes; three coordinates turn both, each in its own way.
struct JoinedBodies {
  void operator()(const auto& q, auto& bodies) const {
    Eigen::Matrix3d I;
    I << 2.0, 0.1, -0.2, 0.1, 2.5, 0.3, -0.2, 0.3, 3.0;
    const auto R = euler_rotation_313(q[0], q[1], q[2]);
    const auto r = vector(0.4 * R(0, 2), 0.4 * R(1, 2), 0.4 * R(2, 2));
    bodies.rigid_body(1.1, I, r, R);
    const auto turned = rotation_from_vector(vector(q[1], q[2], q[0]));
    const auto joint = vector(2.0 * r[0], 2.0 * r[1], 2.0 * r[2]);
    bodies.rigid_body(RigidBody{0.7, {0.1, -0.2, 0.3}, 2.0 * I}, joint, turned);
  }
};

template <class Sys, int n>
double difference_of_jacobians(const Sys& system, const Vector<double, n>& q, const Vector<double, n>& v) {
  const auto fast = acceleration_jacobian(system, q, v, 0.7);
  auto expected = fast;
  detail::jacobian_by_duals(system, q, v, 0.7, expected);
  return std::max((fast.d_q - expected.d_q).norm() / expected.d_q.norm(), (fast.d_qdot - expected.d_qdot).norm() / expected.d_qdot.norm());
}

TEST_CASE("the Jacobian of bodies by their positions is the one by nested duals") {
  CHECK(difference_of_jacobians(kinematic_system<2>(CartAndRod{}, spring_of_functions), Vector<double, 2>(0.4, 0.9),
                                Vector<double, 2>(0.3, -1.2)) < rounded_derivatives);
  const auto bodies = kinematic_system<3>(JoinedBodies{}, uniform_gravity(0.0, 0.0, -9.81));
  const Vector<double, 3> q(0.4, 0.9, -0.3), v(0.3, -1.2, 2.0);
  CHECK(difference_of_jacobians(bodies, q, v) < rounded_derivatives);
}

TEST_CASE("the Jacobian of a scene without constraints, in one pass with its accelerations, is the one by nested duals") {
  const auto pull = generalized_force([](const auto& q, const auto& v) {
    using std::sin;
    return Vector<std::remove_cvref_t<decltype(q[0] * v[0])>, 2>(sin(q[1]) * v[0], q[0] * v[1] * v[1]);
  });
  const auto s = scene(mechanical_system<2>(DrivenPair{}), viscous_damping(some_damping<2>()), pull);
  STATIC_REQUIRE(detail::has_traced_jacobian<std::remove_cvref_t<decltype(s)>>);
  CHECK(difference_of_jacobians(s) < rounded_derivatives);
  const auto form = first_order_form(s);
  const Eigen::VectorXd y = Eigen::Vector4d(0.4, 0.9, 0.3, -1.2);
  Eigen::VectorXd alone(4), beside(4);
  Eigen::MatrixXd J(4, 4);
  form.derivative(0.7, y, alone);
  form.derivative_and_jacobian(0.7, y, beside, J);
  CHECK((alone - beside).norm() < rounded * alone.norm());
}

TEST_CASE("a motor's current has its rows and columns in the Jacobian") {
  const auto motor = controller(
      [](const auto&, const auto&, const auto& z, const auto&) {
        using S = typename std::decay_t<decltype(z)>::Scalar;
        return Vector<S, 2>(2.0 * z[0] * z[0], S(0.0));
      },
      [](const auto& q, const auto& qdot, const auto& z, const auto&) {
        using S = typename std::decay_t<decltype(q)>::Scalar;
        return Vector<S, 1>(12.0 - q[1] * z[0] - 2.0 * qdot[0]);
      },
      Vector<double, 1>(1.5));
  const Vector<double, 1> z(1.5);
  CHECK(difference_of_jacobians(scene(mechanical_system<2>(bench::UnrolledChain<2>{}), motor, holonomic("tip", TipOfChain<2>{})), z) < rounded_derivatives);
}

TEST_CASE("where the root of a constant is differentiated, the Jacobian is that of the constant") {
  const auto steep = holonomic("tip", [](const auto& q) {
    using std::sqrt, std::sin;
    return sin(q[0]) + sin(q[1]) + sqrt(0.0 * q[0]);
  });
  const auto plain = holonomic("tip", TipOfChain<2>{});
  const auto jacobian = [](const auto& constraint) {
    const SceneForm<std::remove_cvref_t<decltype(scene(mechanical_system<2>(bench::UnrolledChain<2>{}), constraint))>> form(
        scene(mechanical_system<2>(bench::UnrolledChain<2>{}), constraint));
    Eigen::MatrixXd J(4, 4);
    form.jacobian(0.0, Eigen::Vector4d(0.4, 0.9, 0.3, -0.2), J);
    return J;
  };
  CHECK((jacobian(steep) - jacobian(plain)).norm() < rounded_derivatives * jacobian(plain).norm());
}
