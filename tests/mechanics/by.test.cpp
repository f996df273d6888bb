// SPDX-License-Identifier: MIT
#include "qdot/mechanics/by.hpp"

#include <cmath>
#include <string>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/effects/scene_motion.hpp"
#include "qdot/integrate/any_system.hpp"
#include "qdot/integrate/automatic.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/simulator.hpp"
#include "qdot/integrate/taylor.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"

namespace {

using namespace qdot;

// Of some ten operations.
constexpr double rounding = 1e-14;
// What two runs of other roundings differ by, and the tolerance of both.
constexpr double tolerance = 1e-9;

constexpr By ways[] = {By::fastest, By::duals, By::lines, By::machine_code};
const char* const words[] = {"dual numbers, as asked", "recorded formulas, interpreted, as asked"};

// Masses in a row, each tied to the next one, written with a loop; q̈ᵢ = q_{i−1} − 2 qᵢ + q_{i+1} for unit masses and springs.
struct Row {
  auto T(const auto& qdot) const {
    using S = std::decay_t<decltype(qdot[0])>;
    S sum(0.0);
    for (Eigen::Index i = 0; i < qdot.size(); ++i) sum += 0.5 * qdot[i] * qdot[i];
    return sum;
  }
  auto V(const auto& q) const {
    using S = std::decay_t<decltype(q[0])>;
    S sum = 0.5 * q[0] * q[0];
    for (Eigen::Index i = 1; i < q.size(); ++i) sum += 0.5 * (q[i] - q[i - 1]) * (q[i] - q[i - 1]);
    return sum;
  }
};
const Vector<double, 2> q{0.3, -0.5}, qdot_{0.7, 0.2}, expected{-1.1, 0.8};  // (q1 − 2 q0, q0 − q1)

// A pendulum in Cartesian coordinates on a rod of length 1; at rest on its side it falls freely.
auto on_a_rod() {
  return scene(mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }, [](const auto& x) { return 10.0 * x[1]; }),
               holonomic("rod", [](const auto& x) { return x[0] * x[0] + x[1] * x[1] - 1.0; }));
}

// Asks for a value itself, which no recording can hold.
struct Table {
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& x) const {
    static_cast<void>(innermost_value(x[0]));
    return 0.5 * x[0] * x[0];
  }
};

struct Decay {
  static constexpr int size_at_compile_time = 1;
  Eigen::Index size() const { return 1; }
  void derivative(double, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) const { ydot = -y; }
  void jacobian(double, const Eigen::Ref<const Eigen::VectorXd>&, Eigen::Ref<Eigen::MatrixXd> J) const { J(0, 0) = -1.0; }
  std::string component_name(Eigen::Index) const { return "y"; }
};

}  // namespace

TEST_CASE("accelerations and their slopes are the same by each way") {
  const auto fixed = mechanical_system<2>(Row{});
  const auto counted = mechanical_system(2, Row{});
  for (const By way : ways) {
    CHECK((acceleration(fixed, q, qdot_, 0.0, way) - expected).norm() <= rounding);
    CHECK((acceleration(fixed, State<2>{0.0, q, qdot_}, way) - expected).norm() <= rounding);
    CHECK((acceleration(counted, Eigen::VectorXd(q), Eigen::VectorXd(qdot_), 0.0, way) - expected).norm() <= rounding);
    const Eigen::Matrix2d slopes{{-2.0, 1.0}, {1.0, -1.0}};
    const auto written = [&](const auto& form) {
      Eigen::MatrixXd J(4, 4);
      Eigen::VectorXd y(4);
      y << q, qdot_;
      form.jacobian(0.0, y, J);
      return Eigen::Matrix2d(J.bottomLeftCorner(2, 2));
    };
    CHECK((acceleration_jacobian(fixed.by(way), q, qdot_).d_q - slopes).norm() <= rounding);
    CHECK((written(first_order_form(fixed.by(way))) - slopes).norm() <= rounding);
    CHECK((written(first_order_form(counted.by(way))) - slopes).norm() <= rounding);
  }
}

TEST_CASE("accelerations and multipliers on a constraint are the same by each way") {
  for (const By way : ways) {
    const auto on = on_a_rod().by(way);
    const auto solution = constrained_acceleration(on, Vector<double, 2>(1.0, 0.0), Vector<double, 2>(0.0, 3.0));
    CHECK((solution.qddot - Vector<double, 2>(-9.0, -10.0)).norm() <= 10 * rounding);
    CHECK(std::abs(solution.lambda[0] + 4.5) <= 10 * rounding);  // 2 x λ = −v²
  }
}

TEST_CASE("a run goes the way of its options and says so") {
  const auto row = mechanical_system<2>(Row{});
  const State<2> start{0.0, q, qdot_};
  const auto run_by = [&](const auto& system, By way) { return simulate(system, start, 3.0, Dop853{}, Options{.rtol = 1e-11, .by = way}); };
  const auto fastest = run_by(row, By::fastest);
  CHECK(run_by(row, By::duals).statistics.evaluated_by == words[0]);
  CHECK(run_by(row, By::lines).statistics.evaluated_by == words[1]);
  CHECK(run_by(row.by(By::lines), By::fastest).statistics.evaluated_by == words[1]);
  CHECK(run_by(AnySystem(row), By::duals).statistics.evaluated_by == words[0]);
  const std::string native = run_by(row, By::machine_code).statistics.evaluated_by;
  if (formula::native_lines_are_possible()) CHECK(native == "machine code of recorded formulas, as asked");
  else CHECK(native.starts_with("recorded formulas, interpreted, because there is no machine code"));
  for (const By way : ways) CHECK((run_by(row, way).y - fastest.y).norm() <= tolerance);
  Simulator simulator(row, start, Dop853{}, Options{.rtol = 1e-11, .by = By::duals});
  REQUIRE(simulator.advance(3.0));
  CHECK((simulator.y() - fastest.y).norm() <= tolerance);
}

TEST_CASE("bare calls of a scene go each way, too") {
  // On the rod at 0.3 rad with 1.5 rad/s: the angle's acceleration is −10 sin 0.3.
  const double angle = 0.3, rate = 1.5, s = std::sin(angle), c = std::cos(angle);
  const State<2> state{0.0, {s, -c}, {rate * c, rate * s}};
  const Vector<double, 2> expected_on_rod{-10.0 * s * c - rate * rate * s, -10.0 * s * s + rate * rate * c};
  for (const By way : ways) {
    CHECK((acceleration(on_a_rod(), state, way) - expected_on_rod).norm() <= tolerance);
    CHECK((acceleration(on_a_rod(), state.q, state.qdot, 0.0, way) - expected_on_rod).norm() <= tolerance);
    CHECK((acceleration(mechanical_system<2>(Row{}), State<2>{0.0, q, qdot_}, way) - expected).norm() <= tolerance);
  }
}

TEST_CASE("Taylor goes by lines or machine code with the same bits, and refuses dual numbers, which have no series") {
  const auto row = mechanical_system<2>(Row{});
  const State<2> start{0.0, q, qdot_};
  const auto run_by = [&](By way) { return simulate(row, start, 3.0, Taylor{}, Options{.by = way}); };
  const auto fastest = run_by(By::fastest);
  CHECK(fastest.statistics.evaluated_by == "power series of recorded formulas");
  for (const By way : {By::lines, By::machine_code}) CHECK(run_by(way).y == fastest.y);
  REQUIRE_THROWS_AS(run_by(By::duals), InvalidValue);
  const auto automatic = simulate(row, start, 3.0, AutomaticWith<Dopri5>{}, Options{.by = By::duals});
  CHECK(automatic.statistics.evaluated_by == words[0]);
  CHECK((automatic.y - fastest.y).norm() <= tolerance);
  CHECK(simulate(row, start, 3.0, AutomaticWith<Dopri5>{}).statistics.evaluated_by == "power series of recorded formulas");
}

TEST_CASE("what cannot be recorded goes by dual numbers, whatever is asked, and the run says why") {
  const auto run = simulate(mechanical_system<1>(Table{}), State<1>{0.0, {1.0}, {0.0}}, 1.0, Dop853{}, Options{.by = By::lines});
  CHECK(std::abs(run.state().q[0] - std::cos(1.0)) <= tolerance);
  CHECK(run.statistics.evaluated_by == "dual numbers, because T or V asks for a plain value, compares in too many ways, or is too long to be recorded");
  const auto pushed = scene(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& x) { return 0.5 * x[0] * x[0]; }),
                            generalized_force([](const auto& x, const auto&, const auto&) {
                              static_cast<void>(innermost_value(x[0]));
                              return std::remove_cvref_t<decltype(x)>(0.0 * x);
                            }));
  const auto under_force = simulate(pushed, State<1>{0.0, {1.0}, {0.0}}, 1.0, Dop853{});
  CHECK(std::abs(under_force.state().q[0] - std::cos(1.0)) <= 1e-6);
  CHECK(under_force.statistics.evaluated_by.ends_with("; effects are called as they are"));
}

TEST_CASE("a copy that goes another way leaves the system as it was, and keeps what it derives") {
  const auto row = mechanical_system<2>(Row{});
  CHECK(row.by(By::lines).kept_lines()->shared() == row.by(By::lines).kept_lines()->shared());
  CHECK(row.by(By::lines).kept_lines()->shared() != row.kept_lines()->shared());
  CHECK(row.kept_lines()->by() == By::fastest);
  CHECK(row.by(By::duals).with_names({"a", "b"}).kept_lines()->by() == By::duals);
}

TEST_CASE("equations of first order, which have no T and V, take no way") {
  const auto run = [](const auto& system) { simulate(system, FirstOrderState{0.0, Eigen::VectorXd::Ones(1)}, 1.0, Dop853{}, Options{.by = By::duals}); };
  REQUIRE_THROWS_AS(run(Decay{}), InvalidValue);
  REQUIRE_THROWS_AS(run(AnySystem(Decay{})), InvalidValue);
}
