// SPDX-License-Identifier: MIT
//
// Equations that are derived and kept, by a run and outside of one, against those derived by hand and by dual numbers.
#include "qdot/mechanics/derive/kept_lines.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <thread>
#include <type_traits>
#include <vector>

#include "bench/chain_energies.hpp"
#include "bench/hand_derived.hpp"
#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/effects/scene_motion.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/mechanics/first_order_form.hpp"
#include "qdot/mechanics/kinematic_system.hpp"
#include "qdot/mechanics/velocity.hpp"

namespace {

using namespace qdot;

// Sums of a few hundred operations, M of a condition up to 1e3.
constexpr double rounding = 1e-11;

template <int n>
Vector<double, 2 * n> random_state(std::mt19937& random) {
  std::uniform_real_distribution<double> number(0.2, 1.2);
  Vector<double, 2 * n> y;
  for (int i = 0; i < 2 * n; ++i) y[i] = i < n ? number(random) : number(random) - 0.7;
  return y;
}

template <class Form>
Eigen::VectorXd rates(const Form& form, const Eigen::VectorXd& y, double t = 0.3) {
  Eigen::VectorXd ydot(form.size());
  form.derivative(t, y, ydot);
  return ydot;
}
template <class Form>
Eigen::MatrixXd jacobian_of(const Form& form, const Eigen::VectorXd& y, double t = 0.3) {
  Eigen::MatrixXd J(form.size(), form.size());
  form.jacobian(t, y, J);
  return J;
}

// The lines of a system, or of a form's, at the probe.
template <int n, class Sys>
const detail::DerivedLines* lines_of(const Sys& system) {
  const Vector<double, n> q = Vector<double, n>::Constant(0.4), v = Vector<double, n>::Constant(-0.2);
  const detail::DerivedLines* found = nullptr;
  detail::with_lines<n>(system.kept_lines(), system.energies(), detail::AtState{q.data(), v.data(), 0.7}, [&](const detail::DerivedLines& lines) {
    found = &lines;
    return true;
  });
  return found;
}

double difference(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y) { return (x - y).cwiseAbs().maxCoeff() / (1.0 + y.cwiseAbs().maxCoeff()); }

// Oscillators in a row whose stiffness is somewhere else; written with a loop.
struct Stiff {
  const double* k;
  auto T(const auto& qdot) const {
    using S = std::decay_t<decltype(qdot[0])>;
    S sum(0.0);
    for (Eigen::Index i = 0; i < qdot.size(); ++i) sum += 0.5 * qdot[i] * qdot[i];
    return sum;
  }
  auto V(const auto& q) const {
    using S = std::decay_t<decltype(q[0])>;
    S sum(0.0);
    for (Eigen::Index i = 0; i < q.size(); ++i) sum += 0.5 * *k * q[i] * q[i];
    return sum;
  }
};

// The same energies or places, asking for a plain value, which recordings refuse: evaluated by dual numbers.
template <class E>
struct ByDuals : E {
  auto T(const auto& q, const auto& qdot) const {
    static_cast<void>(innermost_value(q[0]));
    return E::T(q, qdot);
  }
};
struct PlacesByDuals {
  void operator()(const auto& q, auto& bodies) const {
    static_cast<void>(innermost_value(q[0]));
    bench::LoopedPositions{}(q, bodies);
  }
};

// No formula: each spring is slack on one side.
struct Slack {
  auto T(const auto& qdot) const { return Stiff{nullptr}.T(qdot); }
  auto V(const auto& q) const {
    using S = std::decay_t<decltype(q[0])>;
    S sum(0.0);
    for (Eigen::Index i = 0; i < q.size(); ++i)
      if (q[i] > 0.0) sum += 0.5 * q[i] * q[i];
    return sum;
  }
};

// Has a value for positive coordinates only, its derivatives have some elsewhere.
struct Logarithms {
  auto T(const auto& qdot) const { return Stiff{nullptr}.T(qdot); }
  auto V(const auto& q) const {
    using std::log;
    using S = std::decay_t<decltype(q[0])>;
    S sum(0.0);
    for (Eigen::Index i = 0; i < q.size(); ++i) sum += log(q[i]);
    return sum;
  }
};

// Pulls three times as strongly at one place as anywhere else, and takes what is no number for nothing.
struct AtPlace {
  const double *place, *strength;
  auto T(const auto& qdot) const { return Stiff{nullptr}.T(qdot); }
  auto V(const auto& q) const {
    using S = std::decay_t<decltype(q[0])>;
    S sum(0.0);
    for (Eigen::Index i = 0; i < q.size(); ++i) sum += q[i] != q[i] ? S(0.0) : q[i] == *place ? S(3.0 * *strength * q[i]) : S(*strength * q[i]);
    return sum;
  }
};

// Free masses at x_k = q_k − ½ q_{k+1}², each seen from a place that the next one moves.
struct Following {
  auto operator()(const auto& q, const auto& qdot) const {
    using S = std::decay_t<decltype(qdot[0])>;
    S sum(0.0);
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      S v = qdot[i];
      if (i + 1 < q.size()) v -= q[i + 1] * qdot[i + 1];
      sum += 0.5 * v * v;
    }
    return sum;
  }
};

}  // namespace

TEST_CASE("q̈ of looped chains is what is derived by hand, in a run and outside, and its Jacobian what it is by dual numbers") {
  std::mt19937 random(11);
  const auto check = [&]<int n>(std::integral_constant<int, n>) {
    const auto system = mechanical_system<n>(bench::LoopedChain{});
    const auto form = first_order_form(system);
    const auto by_duals = mechanical_system<n>(ByDuals<bench::LoopedChain>{});
    CAPTURE(n);
    REQUIRE(lines_of<n>(form.system()) != nullptr);
    CHECK(system.kept_lines()->once() == nullptr);
    for (int k = 0; k < 3; ++k) {
      const Vector<double, 2 * n> y = random_state<n>(random);
      Vector<double, n> by_hand;
      bench::chain_by_hand<n>(y.data(), y.data() + n, by_hand.data());
      CHECK(difference(rates(form, y).tail(n), by_hand) < rounding);
      const Vector<double, n> q = y.template head<n>(), v = y.template tail<n>();
      CHECK(difference(acceleration(system, q, v), by_hand) < rounding);
      const auto outside = acceleration_jacobian(by_duals, q, v);
      const Eigen::MatrixXd J = jacobian_of(form, y);
      CHECK(difference(J.bottomLeftCorner(n, n), outside.d_q) < rounding);
      CHECK(difference(J.bottomRightCorner(n, n), outside.d_qdot) < rounding);
    }
  };
  check(std::integral_constant<int, 1>());
  check(std::integral_constant<int, 3>());
  check(std::integral_constant<int, 8>());
  check(std::integral_constant<int, 16>());
}

TEST_CASE("in a run, accelerations keep their bits when machine code takes the place of the interpreter") {
  std::mt19937 random(48);
  const auto keeps_bits = [&]<int n>(const auto& form, std::integral_constant<int, n>) {
    const Vector<double, 2 * n> y = random_state<n>(random);
    const Eigen::VectorXd first = rates(form, y);
    for (long k = 0; k < formula::LineEvaluator::begin_after + 2; ++k)
      if (rates(form, y) != first) return false;
    return true;
  };
  const auto check = [&]<int n>(std::integral_constant<int, n> size) {
    const auto system = mechanical_system<n>(bench::LoopedChain{});
    const auto form = first_order_form(system);
    CHECK(keeps_bits(form, size));
    CHECK(form.way_taken().starts_with("machine code") == formula::native_lines_are_possible());
    CHECK(keeps_bits(first_order_form(scene(system, viscous_damping(Vector<double, n>::Constant(0.1)))), size));
  };
  check(std::integral_constant<int, 1>());
  check(std::integral_constant<int, 2>());
  check(std::integral_constant<int, 3>());
  check(std::integral_constant<int, 5>());
  check(std::integral_constant<int, 8>());
}

TEST_CASE("slopes of lines at any accelerations are those of r - M a by dual numbers") {
  constexpr int n = 3;
  using D = Dual<double, 2 * n>;
  std::mt19937 random(14);
  const Vector<double, 2 * n> y = random_state<n>(random);
  const Vector<double, n> a(0.3, -0.7, 1.1);
  detail::KeptDerivation derivation;
  const bench::LoopedChain chain;
  derivation.derive(detail::RecordableFunctors::of<n>(chain, n));
  const detail::DerivedLines* const lines = derivation.lines_with_slopes();
  REQUIRE(lines != nullptr);
  double M[n * (n + 1) / 2];
  detail::SlopeRow<2 * n> rows[n];
  REQUIRE(lines->write_slopes<n>(y.data(), y.data() + n, 0.3, M, rows, [&](const double*, double* to) { return std::copy_n(a.data(), n, to), true; }));
  Vector<D, n> q, v;
  for (int i = 0; i < n; ++i) {
    q[i] = D(y[i]);
    v[i] = D(y[n + i]);
    q[i].tangent[static_cast<std::size_t>(i)] = v[i].tangent[static_cast<std::size_t>(n + i)] = 1.0;
  }
  const Vector<D, n> missed = detail::lagrange_residual<n>(bench::LoopedChain{}, q, v, Vector<D, n>(a.cast<D>()), D(0.3));
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < 2 * n; ++j) CHECK(std::abs(rows[i][j] + missed[i].tangent[static_cast<std::size_t>(j)]) < rounding);
}

TEST_CASE("in a run, free masses stay free when each is seen from a place that the next one moves") {
  // ẍ_k = 0: q̈_k = q_{k+1} q̈_{k+1} + q̇_{k+1}², and the last is zero.
  constexpr int n = 8;
  const auto system = mechanical_system<n>(Following{});
  const auto form = first_order_form(system);
  REQUIRE(lines_of<n>(form.system()) != nullptr);
  std::mt19937 random(13);
  const Vector<double, 2 * n> y = random_state<n>(random);
  Vector<double, n> expected = Vector<double, n>::Zero();
  for (int k = n - 2; k >= 0; --k) expected[k] = y[k + 1] * expected[k + 1] + y[n + k + 1] * y[n + k + 1];
  CHECK(difference(rates(form, y).tail(n), expected) < rounding);
}

TEST_CASE("in a run, forces, potentials and constraints are added to lines as to anything else") {
  std::mt19937 random(12);
  constexpr int n = 5;
  const auto damping = viscous_damping(Vector<double, n>(Vector<double, n>::Constant(0.1)));
  const auto tip = holonomic("tip", [](const auto& q) {
    using std::sin;
    auto x = sin(q[0]);
    for (Eigen::Index i = 1; i < q.size(); ++i) x += sin(q[i]);
    return x - 1.5;
  });
  const auto check = [&](const auto& s, const auto& by_duals) {
    const auto form = first_order_form(s);
    for (int k = 0; k < 3; ++k) {
      const Vector<double, 2 * n> y = random_state<n>(random);
      const Eigen::VectorXd expected = acceleration(by_duals, Vector<double, n>(y.head(n)), Vector<double, n>(y.tail(n)), 0.3);
      CHECK(difference(rates(form, y).tail(n), expected) < rounding);
      CHECK(difference(acceleration(s, Vector<double, n>(y.head(n)), Vector<double, n>(y.tail(n)), 0.3), expected) < rounding);
      const Eigen::MatrixXd J = jacobian_of(form, y);
      for (int j = 0; j < 2 * n; ++j) {  // fourth order: h⁴ and rounding over h
        constexpr double h = 1e-3;
        const auto at = [&](double by) {
          Vector<double, 2 * n> moved = y;
          moved[j] += by;
          return Eigen::VectorXd(acceleration(s, Vector<double, n>(moved.head(n)), Vector<double, n>(moved.tail(n)), 0.3));
        };
        const Eigen::VectorXd slope = (8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h);
        CHECK(difference(J.col(j).tail(n), slope) < 1e-8);
      }
    }
  };
  const auto first = [](const auto& q) {
    using std::cos, std::sin;
    return vector(sin(q[0]), -cos(q[0]));
  };
  const auto wall = [](const auto& q) {
    using S = std::decay_t<decltype(q[0])>;
    return vector(S(3.0), S(0.5));
  };
  const auto check_all = [&](const auto& system, const auto& by_duals) {
    const auto check_with = [&](const auto&... effects) { check(scene(system, effects...), scene(by_duals, effects...)); };
    check_with(damping);
    check_with(tip);
    check_with(damping, tip);
    check_with(spring_damper(first, wall, 20.0, 1.0, 0.4));
    check_with(spring_damper(first, wall, 20.0, 1.0, 0.4), tip);
  };
  check_all(mechanical_system<n>(bench::LoopedChain{}), mechanical_system<n>(ByDuals<bench::LoopedChain>{}));
  check_all(kinematic_system<n>(bench::LoopedPositions{}, uniform_gravity(0.0, -9.81)), kinematic_system<n>(PlacesByDuals{}, uniform_gravity(0.0, -9.81)));
}

// A chain of n links of l on a point that is driven, in a field that is no gravity's.
struct DrivenChain {
  const double* l;
  void operator()(const auto& q, const auto& t, auto& bodies) const {
    using std::cos, std::sin;
    using S = std::decay_t<decltype(t)>;
    S x = 0.1 * sin(3.0 * t), y(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      x += *l * sin(q[k]);
      y -= *l * cos(q[k]);
      bodies.planar_body(1.0 + 0.1 * static_cast<double>(k), 0.02, vector(x, y), q[k]);
    }
  }
};

// Spherical pendulums in a row: velocities are rates of places, but no sums of f(φ) φ̇.
struct SphericalChain {
  void operator()(const auto& q, auto& bodies) const {
    using std::cos, std::sin;
    using S = typename std::decay_t<decltype(q)>::Scalar;
    S x(0.0), y(0.0), z(0.0);
    for (Eigen::Index k = 0; k + 1 < q.size(); k += 2) {
      x += sin(q[k]) * cos(q[k + 1]);
      y += sin(q[k]) * sin(q[k + 1]);
      z -= cos(q[k]);
      bodies.point_mass(1.0, vector(x, y, z));
    }
  }
};

TEST_CASE("in a run, places in space have the accelerations that they have outside of it, by a few lines for each coordinate") {
  const auto system = kinematic_system<6>(SphericalChain{}, uniform_gravity(0.0, 0.0, -9.81));
  const auto form = first_order_form(system);
  const detail::DerivedLines* const lines = lines_of<6>(form.system());
  REQUIRE(lines != nullptr);
  CHECK(lines->equations.table().lines.size() <= 10 * 6);  // 104 where their Coriolis terms are not seen to be those of rates
  std::mt19937 random(8);
  for (int k = 0; k < 3; ++k) {
    const Vector<double, 12> y = random_state<6>(random);
    const Eigen::VectorXd outside = acceleration(system, Vector<double, 6>(y.head(6)), Vector<double, 6>(y.tail(6)), 0.3);
    CHECK(difference(rates(form, y).tail(6), outside) < rounding);
  }
}

TEST_CASE("in a run, places that a loop finds have the accelerations that are derived by hand") {
  std::mt19937 random(5);
  const auto check_chain = [&]<int n>(std::integral_constant<int, n>) {
    const auto form = first_order_form(kinematic_system<n>(bench::LoopedPositions{}, uniform_gravity(0.0, -9.81)));
    REQUIRE(lines_of<n>(form.system()) != nullptr);
    const Vector<double, 2 * n> y = random_state<n>(random);
    Vector<double, n> by_hand;
    bench::chain_by_hand<n>(y.data(), y.data() + n, by_hand.data());
    CHECK(difference(rates(form, y).tail(n), by_hand) < rounding);
  };
  check_chain(std::integral_constant<int, 5>());
  check_chain(std::integral_constant<int, 8>());
  check_chain(std::integral_constant<int, 12>());
}

TEST_CASE("in a run, places that move with time are what they are outside of it, and end it by name when they change behind it") {
  double l = 0.7;
  const auto V = [](const auto& q, const auto& t) {
    using std::cos;
    using S = std::decay_t<decltype(t)>;
    S sum(0.0);
    for (Eigen::Index i = 0; i < q.size(); ++i) sum += (1.0 + 0.2 * t) * cos(q[i]);
    return sum;
  };
  const auto system = kinematic_system<5>(DrivenChain{&l}, V);
  const auto form = first_order_form(system);
  std::mt19937 random(6);
  for (int k = 0; k < 3; ++k) {
    const Vector<double, 10> y = random_state<5>(random);
    const Eigen::VectorXd outside = acceleration(system, Vector<double, 5>(y.head(5)), Vector<double, 5>(y.tail(5)), 0.3);
    CHECK(difference(rates(form, y).tail(5), outside) < rounding);
  }
  const auto run = simulate(system, State<5>{0.0, {1.0, 0.5, -0.3, 0.2, 0.1}, Vector<double, 5>::Zero()}, 40.0, Dop853{}, {.rtol = 1e-8, .atol = 1e-8},
                            [&](const StepView& step) { if (step.t() > 5.0) l = 0.8; });
  CHECK(run.outcome == Outcome::model_changed);
}

TEST_CASE("a run's form keeps lines until a method begins anew, copies have their own, and outside of runs they are checked") {
  double k = 2.0;
  const auto system = mechanical_system<3>(Stiff{&k});
  auto form = first_order_form(system);
  const Vector<double, 6> y(0.4, -0.2, 0.7, 0.1, 0.3, -0.5);
  const Vector<double, 3> q = y.head<3>(), v = y.tail<3>();
  CHECK(difference(rates(form, y).tail(3), -2.0 * q) < rounding);
  auto copy = form;
  k = 5.0;
  CHECK(difference(acceleration(system, q, v), -5.0 * q) < rounding);
  copy.renew();
  CHECK(difference(rates(copy, y).tail(3), -5.0 * q) < rounding);
  form.renew();
  CHECK(difference(rates(form, y).tail(3), -5.0 * q) < rounding);
}

TEST_CASE("outside of runs q̈ is that of what T and V read now, however often it changes") {
  double k = 1.0;
  const auto system = mechanical_system<3>(Stiff{&k});
  const Vector<double, 3> q(0.4, -0.2, 0.7), v(0.1, 0.3, -0.5);
  for (int times = 0; times < 2; ++times)
    for (int i = 1; i <= static_cast<int>(detail::Derivations::most) + 4; ++i) {
      k = 0.5 * i;
      for (int again = 0; again < 2; ++again) {
        CHECK(difference(acceleration(system, q, v), -k * q) < rounding);
        CHECK(difference(acceleration_jacobian(system, q, v).d_q, -k * Eigen::Matrix3d::Identity()) < rounding);
      }
    }
  k = 100.0;  // beyond those that are kept a number that is met once has no lines
  CHECK(lines_of<3>(system) == nullptr);
  CHECK(lines_of<3>(system) != nullptr);
  k = 101.0;
  CHECK(lines_of<3>(system) == nullptr);
  k = 0.5;
  CHECK(lines_of<3>(system) != nullptr);
}

// A spring that is stiffer at each call.
struct Counting {
  mutable double calls = 0.0;
  auto T(const auto& qdot) const { return Stiff{nullptr}.T(qdot); }
  auto V(const auto& q) const {
    calls += 1.0;
    return Stiff{&calls}.V(q);
  }
};

TEST_CASE("outside of runs energies that are others at each call are evaluated at each call") {
  const auto system = mechanical_system<2>(Counting{});
  const Vector<double, 2> q(1.0, -1.0), v(0.0, 0.0);
  double before = 0.0;
  for (int i = 0; i < 40; ++i) {
    const double a = acceleration(system, q, v)[0];
    CHECK(a < before);
    CHECK(a == -std::round(-a));
    before = a;
  }
}

TEST_CASE("outside of runs energies that have values somewhere only have accelerations there") {
  const auto V = [](const auto& q) {
    using std::log;
    return log(q[0] - 5.0) + log(q[1] - 5.0);
  };
  const auto system = mechanical_system<2>([](const auto& qdot) { return 0.5 * (qdot[0] * qdot[0] + qdot[1] * qdot[1]); }, V);
  CHECK(difference(acceleration(system, Vector<double, 2>(6.0, 7.0), Vector<double, 2>(0.0, 0.0)), Vector<double, 2>(-1.0, -0.5)) < rounding);
  const auto form = first_order_form(system);
  CHECK(difference(rates(form, Vector<double, 4>(6.0, 7.0, 0.0, 0.0)).tail(2), Vector<double, 2>(-1.0, -0.5)) < rounding);
}

TEST_CASE("outside of runs q̈ of a number of coordinates that is known at run time is what is derived by hand, and follows what T and V read") {
  std::mt19937 random(21);
  const auto check = [&]<int n>(std::integral_constant<int, n>) {
    const auto system = mechanical_system(n, bench::LoopedChain{});
    for (int k = 0; k < 3; ++k) {
      const Eigen::VectorXd y = random_state<n>(random);
      Vector<double, n> by_hand;
      bench::chain_by_hand<n>(y.data(), y.data() + n, by_hand.data());
      CHECK(difference(acceleration(system, Eigen::VectorXd(y.head(n)), Eigen::VectorXd(y.tail(n))), by_hand) < rounding);
    }
  };
  check(std::integral_constant<int, 1>());
  check(std::integral_constant<int, 3>());
  check(std::integral_constant<int, 32>());
  double k = 1.0;
  const Eigen::VectorXd q = Eigen::Vector3d(0.4, -0.2, 0.7);
  const auto springs = mechanical_system(3, Stiff{&k});
  for (k = 1.0; k < 5.0; k += 1.0) CHECK(difference(acceleration(springs, q, q), -k * q) < rounding);
  const Eigen::Vector3d slack(-0.4, 0.0, -0.7);
  CHECK(difference(acceleration(mechanical_system(3, Slack{}), q, q), slack) < rounding);
}

TEST_CASE("a system, its copies and their runs derive equations once") {
  const auto system = mechanical_system<3>(bench::LoopedChain{});
  const auto copy = system;
  const detail::DerivedLines* const lines = lines_of<3>(system);
  REQUIRE(lines != nullptr);
  CHECK(lines_of<3>(copy) == lines);
  const auto form = first_order_form(copy);
  CHECK(lines_of<3>(form.system()) == lines);
}

TEST_CASE("several threads that share a system get the bits that one alone gets") {
  const Vector<double, 4> q(0.4, -0.2, 0.7, 1.1), v(0.1, 0.3, -0.5, 0.2);
  const Vector<double, 4> alone = acceleration(mechanical_system<4>(bench::LoopedChain{}), q, v);
  const auto system = mechanical_system<4>(bench::LoopedChain{});
  std::vector<int> differing(4, 0);
  std::vector<std::thread> threads;
  for (int& count : differing)
    threads.emplace_back([&] {
      for (int k = 0; k < 2000; ++k) count += acceleration(system, q, v) != alone;
    });
  for (std::thread& each : threads) each.join();
  CHECK(differing == std::vector<int>(4, 0));
}

TEST_CASE("a run whose energies change behind it ends by the name of model_changed, though its lines do not") {
  double k = 1.0;
  const auto system = mechanical_system<3>(Stiff{&k});
  const State<3> start{0.0, {1.0, 0.5, -0.3}, {0.0, 0.0, 0.0}};
  const auto change = [&](const StepView& step) {
    if (step.t() > 5.0) k = 1.5;
  };
  const auto run = simulate(system, start, 40.0, Dop853{}, {.rtol = 1e-8, .atol = 1e-8}, change);
  CHECK(run.outcome == Outcome::model_changed);
  k = 1.0;
  const auto s = scene(system, viscous_damping(Vector<double, 3>(0.0, 0.0, 0.1)));
  const auto damped = simulate(s, start, 40.0, Dop853{}, {.rtol = 1e-8, .atol = 1e-8}, change);
  CHECK(damped.outcome == Outcome::model_changed);
}

TEST_CASE("in a run, energies that compare numbers have lines for each branch that it meets") {
  const auto form = first_order_form(mechanical_system<3>(Slack{}));
  REQUIRE(lines_of<3>(form.system()) != nullptr);
  for (int sides = 0; sides < 16; ++sides) {
    Vector<double, 6> y(0.4, 0.2, 0.7, 0.1, 0.3, -0.5);
    Eigen::Vector3d expected, slopes;
    for (int i = 0; i < 3; ++i) {
      if ((sides >> i) & 1) y[i] = -y[i];
      expected[i] = -std::max(y[i], 0.0);
      slopes[i] = y[i] > 0.0 ? -1.0 : 0.0;
    }
    CHECK(difference(rates(form, y).tail(3), expected) < rounding);
    CHECK(difference(jacobian_of(form, y).bottomLeftCorner(3, 3), slopes.asDiagonal().toDenseMatrix()) < rounding);
    CHECK(difference(acceleration(form.system(), Vector<double, 3>(y.head(3)), Vector<double, 3>(y.tail(3))), expected) < rounding);
  }
}

// A stair of springs, each slack on one side: more branches than a run keeps.
struct Stair {
  const double* edge;
  auto T(const auto& qdot) const { return 0.5 * qdot[0] * qdot[0]; }
  auto V(const auto& q) const {
    using S = std::decay_t<decltype(q[0])>;
    S sum(0.0);
    for (int i = 0; i < 100; ++i)
      if (q[0] > *edge + i) sum += q[0];
    return sum;
  }
};

// A spring with a gap, which is elsewhere.
struct Gap {
  const double *edge, *stiffness;
  auto T(const auto& qdot) const { return 0.5 * qdot[0] * qdot[0]; }
  auto V(const auto& q) const {
    using S = std::decay_t<decltype(q[0])>;
    return q[0] > *edge ? S(0.5 * *stiffness * (q[0] - *edge) * (q[0] - *edge)) : S(0.0 * q[0]);
  }
};

TEST_CASE("outside of runs q̈ of energies that branch is that of what they read now, on either side") {
  double edge = 1.0, stiffness = 3.0;
  const auto system = mechanical_system<1>(Gap{&edge, &stiffness});
  const auto expect = [&](double q) {
    const double expected = q > edge ? -stiffness * (q - edge) : 0.0;
    CHECK(std::abs(acceleration(system, Vector<double, 1>(q), Vector<double, 1>(0.2))[0] - expected) <= rounding);
    CHECK(std::abs(acceleration_jacobian(system, Vector<double, 1>(q), Vector<double, 1>(0.2)).d_q(0, 0) - (q > edge ? -stiffness : 0.0)) <= rounding);
  };
  for (int k = 0; k < 100; ++k) {  // more changes than branches are kept
    edge = 1.0 + 0.01 * (k % 10);
    stiffness = 3.0 + k % 7;
    for (const double q : {0.5, 0.999, 1.001, 1.0501, 2.0}) expect(q), expect(q);
  }
  edge = 1.0;
  expect(0.95);
  edge = 0.9;  // a threshold that no formula of the branch contains
  expect(0.95);
}

// A wall that is there or not, and a mass that depends on where the body is.
struct Switched {
  const bool* enabled;
  const double* edge;
  auto T(const auto& q, const auto& qdot) const {
    using S = std::decay_t<decltype(qdot[0])>;
    return S((q[0] > *edge ? 1.0 : 2.0) * 0.5 * qdot[0] * qdot[0]);
  }
  auto V(const auto& q) const {
    using S = std::decay_t<decltype(q[0])>;
    S sum = 1e15 + 3.0 * q[0];
    if (*enabled && q[0] > 1.5) sum += 40.0 * (q[0] - 1.5);
    return sum;
  }
};

TEST_CASE("outside of runs a term that is switched on, and a threshold that moves at rest, are seen") {
  bool enabled = false;
  double edge = 1.0;
  const auto system = mechanical_system<1>(Switched{&enabled, &edge});
  const auto at = [&](double q) { return acceleration(system, Vector<double, 1>(q), Vector<double, 1>(0.0))[0]; };
  CHECK(at(2.0) == -3.0);
  CHECK(at(0.9) == -1.5);
  enabled = true;
  CHECK(at(2.0) == -43.0);
  edge = 0.85;
  CHECK(at(0.9) == -3.0);
}

// |q| as a root, beside a comparison: a branch that is recorded with a guard of which its hash does not know.
struct Rooted {
  auto T(const auto& qdot) const { return 0.5 * qdot[0] * qdot[0]; }
  auto V(const auto& q) const {
    using std::sqrt;
    using S = std::decay_t<decltype(q[0])>;
    return q[0] > 5.0 ? S(2.0 * q[0]) : S(sqrt(q[0] * q[0]));
  }
};

TEST_CASE("outside of runs a branch that cannot be checked is given up after a few derivations") {
  const auto system = mechanical_system<1>(Rooted{});
  const auto at = [&](double q) { return acceleration(system, Vector<double, 1>(q), Vector<double, 1>(0.0))[0]; };
  for (int k = 0; k < 12; ++k) {
    CHECK(at(0.4) == -1.0);
    CHECK(at(-0.4) == 1.0);
    CHECK(at(6.0) == -2.0);
  }
  const auto form = first_order_form(system);
  CHECK(rates(form, Vector<double, 2>(-0.4, 0.0))[1] == 1.0);
}

TEST_CASE("a scene whose number of coordinates is known at run time has lines of its energies as they are when it begins anew") {
  double k = 1.0, edge = 0.0;
  const auto system = mechanical_system(1, Gap{&edge, &k});
  auto form = first_order_form(scene(system, viscous_damping(Eigen::VectorXd(Eigen::VectorXd::Constant(1, 0.5)))));
  CHECK(std::abs(rates(form, Eigen::Vector2d(2.0, 1.0))[1] + 2.5) < rounding);
  k = 3.0;
  form.renew();
  CHECK(std::abs(rates(form, Eigen::Vector2d(2.0, 1.0))[1] + 6.5) < rounding);
}

TEST_CASE("a Lagrangian that is no energy, of a number of coordinates that is known at run time, is simulated") {
  // L = q̇₀ q̇₁ − q₀ q₁: q̈ = −q.
  const auto system = mechanical_system(2, [](const auto& v) { return v[0] * v[1]; }, [](const auto& q) { return q[0] * q[1]; }).with_indefinite_mass_matrix();
  const auto run = simulate(system, State<Dynamic>{0.0, {1.0, 0.5}, {0.0, 0.0}}, 1.0, Dop853{}, {.rtol = 1e-10, .atol = 1e-10});
  REQUIRE(run.completed());
  CHECK(std::abs(run.state().q[0] - std::cos(1.0)) < 1e-9);
}

TEST_CASE("in a run, energies with more branches than are kept are evaluated by dual numbers beyond these") {
  const double edge = 0.0;
  const auto form = first_order_form(mechanical_system<1>(Stair{&edge}));
  for (int times = 0; times < 2; ++times)
    for (int i = 0; i < 100; ++i) CHECK(rates(form, Vector<double, 2>(i + 0.5, 0.0))[1] == -(i + 1.0));
}

TEST_CASE("a run whose energies branch elsewhere when it begins anew has other lines") {
  double edge = 0.0;
  auto form = first_order_form(mechanical_system<1>(Stair{&edge}));
  CHECK(rates(form, Vector<double, 2>(2.5, 0.0))[1] == -3.0);
  edge = 1.0;
  form.renew();
  CHECK(rates(form, Vector<double, 2>(2.5, 0.0))[1] == -2.0);
}

// Asks whether a number that depends on q is finite, which no guard holds.
struct Asking {
  auto T(const auto& qdot) const { return 0.5 * qdot[0] * qdot[0]; }
  auto V(const auto& q) const {
    using std::isfinite;
    using S = std::decay_t<decltype(q[0])>;
    const S x = 1.0 / q[0];
    return q[0] > 0.0 && isfinite(x) ? S(q[0]) : S(2.0 * q[0]);
  }
};

TEST_CASE("energies that ask for a value itself are evaluated at every state of a run") {
  const auto form = first_order_form(mechanical_system<1>(Asking{}));
  CHECK(rates(form, Vector<double, 2>(1e-310, 0.0))[1] == -2.0);
  CHECK(rates(form, Vector<double, 2>(1.0, 0.0))[1] == -1.0);
  CHECK(rates(form, Vector<double, 2>(-1.0, 0.0))[1] == -2.0);
}

TEST_CASE("energies that ask whether a coordinate has a certain value are asked at every state of a run") {
  double place = 0.0, strength = 1.0;
  const auto system = mechanical_system<3>(AtPlace{&place, &strength});
  const Vector<double, 6> away(0.4, -0.2, 0.7, 0.1, 0.3, -0.5), there(0.4, 0.0, 0.7, 0.1, 0.3, -0.5);
  const auto form = first_order_form(system);
  CHECK(difference(rates(form, away).tail(3), Eigen::Vector3d(-1.0, -1.0, -1.0)) < rounding);
  CHECK(difference(rates(form, there).tail(3), Eigen::Vector3d(-1.0, -3.0, -1.0)) < rounding);
  const auto outside = [&](const Vector<double, 6>& y) { return acceleration(system, Vector<double, 3>(y.head<3>()), Vector<double, 3>(y.tail<3>())); };
  CHECK(difference(outside(there), Eigen::Vector3d(-1.0, -3.0, -1.0)) < rounding);
  place = 0.7;
  CHECK(difference(outside(away), Eigen::Vector3d(-1.0, -1.0, -3.0)) < rounding);
  strength = 2.0;
  CHECK(difference(outside(away), Eigen::Vector3d(-2.0, -2.0, -6.0)) < rounding);
}

TEST_CASE("a root of what moves has lines, which are not used where it is zero") {
  // V = |r|, r = (q₀ + ½ q₁², q₁): a velocity of it is that of a root of numbers that move
  const auto distance = [](const auto& q) {
    using std::sqrt;
    using S = std::decay_t<decltype(q[0])>;
    const S x = q[0] + 0.5 * q[1] * q[1], y = q[1];
    return Vector<S, 1>(sqrt(x * x + y * y));
  };
  const auto system = kinematic_system<2>(
      [distance](const auto& q, auto& bodies) {
        bodies.point_mass(1.0, q);
        bodies.point_mass(2.0, distance(q));
      },
      [](const auto& q) { return q[0]; });
  const auto form = first_order_form(system), by_duals = first_order_form(system.by(By::duals));
  REQUIRE(lines_of<2>(form.system()) != nullptr);
  for (const Vector<double, 4>& y : {Vector<double, 4>(0.3, 0.4, 0.5, -0.2), Vector<double, 4>(-1.0, 2.0, 0.0, 0.7)})
    CHECK(difference(rates(form, y), rates(by_duals, y)) < rounding);
  CHECK_THROWS_AS(rates(form, Vector<double, 4>(0.0, 0.0, 0.5, -0.2)), Error);  // no slope there
}

TEST_CASE("runs of one system share what is derived of its branches, as long as its functors are the same") {
  double stiffness = 1.0;
  const auto system = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                           [&stiffness](const auto& q) {
                                             using std::max;
                                             const auto over = max(0.0, q[0]);
                                             return 0.5 * stiffness * over * over;
                                           });
  const auto derivation = [&](double q) {
    const auto form = first_order_form(system);
    const Eigen::Vector2d y(q, 0.3);
    const double expected = q > 0.0 ? -stiffness * q : 0.0;
    CHECK(std::abs(rates(form, y)[1] - expected) < rounding);
    const double qdot = 0.3;
    return form.system().kept_lines()->once()->template at<1>(system.energies(), detail::AtState{&q, &qdot, 0.0, 1});
  };
  const auto* const taut = derivation(0.5);
  CHECK(taut != nullptr);
  CHECK(derivation(0.7) == taut);
  const auto* const slack = derivation(-0.7);
  CHECK(slack != nullptr);
  CHECK(slack != taut);
  stiffness = 2.0;
  CHECK(derivation(0.5) != taut);
}

TEST_CASE("in a run there is no acceleration where an energy has no value") {
  const auto form = first_order_form(mechanical_system<3>(Logarithms{}));
  const Vector<double, 6> inside(0.5, 1.0, 2.0, 0.0, 0.0, 0.0), outside(0.5, -1.0, 2.0, 0.0, 0.0, 0.0);
  CHECK(difference(rates(form, inside).tail(3), Eigen::Vector3d(-2.0, -1.0, -0.5)) < rounding);
  CHECK_THROWS_AS(rates(form, outside), NonFinite);
}
