// SPDX-License-Identifier: MIT
//
// Forces of points, bodies and lengths in the accelerations of scenes, by every door, against nested duals.
#include <Eigen/LU>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "bench/chain_energies.hpp"
#include "catch2_bridge.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_motion.hpp"
#include "qdot/mechanics/kinematic_system.hpp"

using namespace qdot;

namespace {

// Rounding of both, and for accelerations times the condition of M.
constexpr double rounded = 1e-12;

struct States {
  std::mt19937 random{7};
  std::uniform_real_distribution<double> number{-1.5, 1.5};
  template <int n>
  Vector<double, n> next(int size = n) {
    Vector<double, n> x(size);
    for (int i = 0; i < size; ++i) x[i] = number(random);
    return x;
  }
};

// The largest difference of a scene's acceleration from that by nested duals, T and V and the forces included.
template <class Sc>
double difference_of_acceleration(const Sc& s) {
  constexpr int n = Sc::dof_at_compile_time;
  using D = Dual<double, 1>;
  const int size = static_cast<int>(s.dof());
  States states;
  double worst = 0.0;
  for (int sample = 0; sample < 20; ++sample) {
    const auto q = states.next<n>(size), v = states.next<n>(size);
    const double t = 0.1 * sample;
    const auto& energies = s.system().energies();
    const Eigen::MatrixXd M = detail::kinetic_hessian<n>(energies, q, v, t);
    Eigen::VectorXd force = detail::lagrange_rhs<n>(energies, q, v, t);
    if constexpr (Sc::has_forces) {
      const auto Q = effect_forces(s, detail::constants<D>(q), detail::constants<D>(v), Vector<D, Sc::states_at_compile_time>(), D(t));
      for (int i = 0; i < size; ++i) force[i] += Q[i].value;
    }
    const Eigen::VectorXd a = M.fullPivLu().solve(force);
    worst = std::max(worst, (acceleration(s, q, v, t) - a).norm() / (1.0 + a.norm()));
    const auto both = mass_and_rhs(s.system(), q, v, t);
    worst = std::max(worst, (both.M - M).norm() / M.norm());
    if constexpr (!Sc::has_forces) worst = std::max(worst, (both.r - force).norm() / (1.0 + force.norm()));
  }
  return worst;
}

// A point that moves with q, and by itself.
struct Arm {
  auto operator()(const auto& q, const auto& t) const {
    using std::cos, std::sin;
    return vector((2.0 + q[0]) * cos(q[1]) + 0.3 * sin(2.0 * t), (2.0 + q[0]) * sin(q[1]) * cos(t));
  }
};
// The joint before the last, or the tip, of a chain of unit links.
template <int links>
struct Joint {
  auto operator()(const auto& q) const {
    using std::cos, std::sin;
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    S x(0.0), y(0.0);
    unroll<links>([&](auto k) __attribute__((always_inline)) {
      x = x + sin(q[k]);
      y = y - cos(q[k]);
    });
    return vector(x, y);
  }
};
struct LoopedTip {
  auto operator()(const auto& q) const {
    using std::cos, std::sin;
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    S x(0.0), y(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      x += sin(q[k]);
      y -= cos(q[k]);
    }
    return vector(x, y);
  }
};
struct Links {
  void operator()(const auto& q, auto& bodies) const {
    bodies.point_mass(1.0, Joint<1>{}(q));
    bodies.point_mass(0.7, Joint<2>{}(q));
  }
};

const auto push = [](const auto& r, const auto& u, const auto& t) {
  using std::cos;
  return vector(-2.0 * r[0] * cos(t) - 0.3 * u[1], 0.7 * u[0] * u[1] + r[1] * r[1]);
};
const auto coupling = [](const auto& q, const auto& v, const auto& t) {
  using std::cos;
  const auto relative = v[1] - v[0];
  return 0.5 * (1.2 + cos(q[0] * t)) * relative * relative;
};
const Eigen::Vector2d wall(4.0, -3.5);

// A potential and nothing else; a term in the Lagrangian with all that there may be of it.
struct Well {
  template <class S, int n>
  S potential_term(const Vector<S, n>& q, const S& t) const {
    using std::cos;
    return 0.8 * q[0] * q[0] * q[1] + cos(q[1] - t);
  }
};
const auto magnetic = velocity_potential([](const auto& q, const auto& v, const auto& t) {
  using std::sin;
  return (q[0] * v[1] - 0.2 * sin(t) * q[1] * v[0]) - 0.05 * (1.0 + q[1] * q[1]) * v[0] * v[0];
});

template <class Sc>
std::string complaint(const Sc& s, const Coordinates<Sc>& q) {
  try {
    const Coordinates<Sc> a = acceleration(s, q, Coordinates<Sc>::Ones(q.size()));
    return a.allFinite() ? "a finite acceleration" : "an acceleration that is not finite";
  } catch (const Error& e) {
    return e.what();
  }
}

}  // namespace

TEST_CASE("accelerations of scenes with forces through every door are those by nested duals") {
  const auto effects = [](const auto& system) {
    return scene(system, force_at_point(Joint<2>{}, push), spring_damper(Joint<1>{}, Arm{}, 3.0, 0.4, 0.7), rayleigh(coupling),
                 torque_on_body([](const auto& q) { return rotation_z(q[1] - q[0]); }, Eigen::Vector3d(0.1, 0.2, 0.6)));
  };
  CHECK(difference_of_acceleration(effects(mechanical_system<2>(bench::UnrolledChain<2>{}))) < rounded);
  CHECK(difference_of_acceleration(effects(mechanical_system<2>(bench::LoopedChain{}))) < rounded);
  CHECK(difference_of_acceleration(effects(kinematic_system<2>(Links{}, gravity_along<1>(-9.81)))) < rounded);
  CHECK(difference_of_acceleration(
            scene(mechanical_system<2>(bench::UnrolledChain<2>{}), magnetic, spring_damper(Joint<1>{}, Arm{}, 3.0, 0.4, 0.7))) < rounded);
  const auto looped = [](const auto& system) { return scene(system, quadratic_drag(LoopedTip{}, 0.3), spring_damper(wall, LoopedTip{}, 3.0, 0.4, 0.7)); };
  CHECK(difference_of_acceleration(looped(mechanical_system<2>(bench::LoopedChain{}))) < rounded);
  CHECK(difference_of_acceleration(looped(kinematic_system<2>(bench::LoopedPositions{}, gravity_along<1>(-9.81)))) < rounded);
  CHECK(difference_of_acceleration(looped(kinematic_system(5, bench::LoopedPositions{}, gravity_along<1>(-9.81)))) < rounded);
}

TEST_CASE("terms of effects in the energies of systems by positions are those by nested duals") {
  const auto links = kinematic_system<2>(Links{}, gravity_along<1>(-9.81));
  const auto loops = kinematic_system<2>(bench::LoopedPositions{}, gravity_along<1>(-9.81));
  CHECK(difference_of_acceleration(scene(links, Well{})) < rounded);
  CHECK(difference_of_acceleration(scene(loops, Well{})) < rounded);
  CHECK(difference_of_acceleration(scene(links, magnetic)) < rounded);
  CHECK(difference_of_acceleration(scene(loops, magnetic, Well{})) < rounded);
  CHECK(difference_of_acceleration(scene(mechanical_system<2>(bench::LoopedChain{}), Well{})) < rounded);
}

TEST_CASE("a damper whose ends meet where they don't move apart pushes nothing") {
  // ℓ = |q₁|, of which duals know that it has no slope where q₁² has none.
  const auto line = [](const auto& q) { return vector(q[1], 0.0 * q[1]); };
  const auto system = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); });
  const auto s = scene(system, spring_damper(line, Eigen::Vector2d(0.0, 0.0), 1.0, 0.5, 0.2),
                       generalized_force([](const auto&, const auto&) { return Eigen::Vector2d(3.0, 4.0); }));
  CHECK(acceleration(s, Eigen::Vector2d(0.4, 0.0), Eigen::Vector2d(1.0, 0.0)) == Eigen::Vector2d(3.0, 4.0));
}

TEST_CASE("a force that is not finite is named by effect and coordinate") {
  const auto line = [](const auto& q) { return vector(q[1]); };
  const auto attraction = [](const auto& r, const auto&) { return vector(-1.0 / (r[0] * r[0])); };
  const auto system = mechanical_system<2>(bench::UnrolledChain<2>{});
  const auto s = scene(system, viscous_damping(Eigen::Vector2d(0.1, 0.1)), force_at_point(line, attraction));
  CHECK(complaint(s, {0.4, 0.0}) ==
        "the force of an effect must be finite, but that of effect 2 of 2 on q0 is not at t = 0.000000; look there for a division by zero, or a "
        "root or logarithm outside its domain");  // on q0 ∞·0, as duals have it
}

TEST_CASE("what is not finite is named where it moves nothing, too") {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const auto fixed = [](const auto& q) {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    return Vector<S, 2>(S(1.0), S(2.0));
  };
  const auto of_time = [](const auto&, const auto& t) { return rotation_z(t); };
  const auto push_by_none = [none](const auto&, const auto&) { return Eigen::Vector2d(none, 0.0); };
  const auto system = mechanical_system<2>(bench::UnrolledChain<2>{});
  const auto named = [](const auto& s, double t) {
    try {
      acceleration(s, Eigen::Vector2d(0.4, 0.9), Eigen::Vector2d(1.0, 1.0), t);
      return std::string("a finite acceleration");
    } catch (const NonFinite& e) {
      return e.component();
    }
  };
  CHECK(named(scene(system, force_at_point(fixed, push_by_none)), 0.0) == "the force of effect 1 of 1");
  CHECK(named(scene(system, torque_on_body(of_time, Eigen::Vector3d(1.0, 1.0, 1.0))), none) == "the force of effect 1 of 1");
  CHECK(named(scene(system, torque_on_body([](const auto& q) { return rotation_z(q[0]); }, Eigen::Vector3d(none, 0.0, 1.0))), 0.0) ==
        "the force of effect 1 of 1");
  CHECK(named(scene(system, rayleigh([](const auto& q, const auto&, const auto& t) { return q[0] * t; })), none) == "the force of effect 1 of 1");
}
