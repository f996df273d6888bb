// SPDX-License-Identifier: MIT
//
// Projection by lines: where it ends, and what is left to Newton's method with factors.
#include "qdot/effects/rows/kept_projection.ipp"

#include <cmath>
#include <limits>
#include <thread>
#include <type_traits>
#include <vector>

#include "bench/chain_energies.hpp"
#include "catch2_bridge.hpp"
#include "mechanics/form_of_run.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

using namespace qdot;

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr double a_step_away = 1e-10;      // as far as a step leaves the constraints
constexpr double rounded = 40 * epsilon;   // of states of size 1: some ten operations, and the condition of J M⁻¹ Jᵀ
constexpr int many = 100;                  // projections

// Each component moved by another part of a step.
Eigen::VectorXd moved(const Eigen::VectorXd& y, Eigen::Index components, double size = a_step_away) {
  Eigen::VectorXd away = y;
  for (Eigen::Index i = 0; i < components; ++i) away[i] += size * std::sin(1.0 + 2.3 * static_cast<double>(i));
  return away;
}
// Lines leave a state that is there to rounding; Newton's method takes one step at least.
template <class Form>
bool is_by_lines(const Form& form, double t, const Eigen::VectorXd& there) {
  Eigen::VectorXd y = there;
  return form.project(t, y).iterations == 0;
}

// The largest difference of both ways at a state that is near the constraints, and what is left of them.
template <class Scene>
double difference_of_newton(const Scene& scene, const Eigen::VectorXd& rough, double t) {
  constexpr int n = Scene::dof_at_compile_time;
  const auto form = form_of_run(scene), by_newton = first_order_form(scene).by(By::duals);
  Eigen::VectorXd there = rough;
  for (int i = 0; i < 3; ++i) by_newton.project(t, there);
  CHECK(is_by_lines(form, t, there));
  double worst = 0.0;
  for (const double size : {1e-5, 1e-9, a_step_away, 1e-13}) {
    Eigen::VectorXd found = moved(there, 2 * n, size), expected = found;
    const ProjectionReport report = form.project(t, found), of_newton = by_newton.project(t, expected);
    CHECK(report.residual < rounded);
    CHECK(report.velocity_residual < rounded);
    CHECK(std::abs(report.residual_before - of_newton.residual_before) < rounded);  // φ of the library's own sines
    CHECK(report.rank == of_newton.rank);
    CHECK(std::abs(report.moved_q - of_newton.moved_q) < rounded);
    CHECK(std::abs(report.moved_qdot - of_newton.moved_qdot) < rounded);
    worst = std::max(worst, (found - expected).cwiseAbs().maxCoeff());
  }
  return worst;
}
template <int n>
Eigen::VectorXd rough_state(const std::vector<double>& z = {}) {
  Eigen::VectorXd y(2 * n + static_cast<Eigen::Index>(z.size()));
  for (Eigen::Index i = 0; i < 2 * n; ++i) y[i] = 0.4 * std::sin(1.0 + 1.7 * static_cast<double>(i));
  for (std::size_t k = 0; k < z.size(); ++k) y[2 * n + static_cast<Eigen::Index>(k)] = z[k];
  return y;
}

const auto free_point = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return 9.81 * q[1]; });
// ½ (x² + y² − l²) = 0
auto on_a_rod(double length) {
  return scene(free_point, holonomic("rod", [length](const auto& q) { return 0.5 * (q.squaredNorm() - length * length); }));
}

}  // namespace

TEST_CASE("by lines a point goes straight back to its circle, and its velocity to the tangent") {
  const auto form = form_of_run(on_a_rod(1.5));
  const Eigen::VectorXd there = Eigen::Vector4d(0.9, -1.2, 0.4, 0.3);  // a triangle of sides 3, 4 and 5
  CHECK(is_by_lines(form, 0.0, there));
  Eigen::VectorXd y = Eigen::Vector4d(0.9 * (1.0 + 1e-9), -1.2 * (1.0 + 1e-9), 0.4 + 0.6e-9, 0.3 - 0.8e-9);  // both along the rod
  const ProjectionReport report = form.project(0.0, y);
  CHECK((y - there).cwiseAbs().maxCoeff() < rounded);
  CHECK(std::abs(report.residual_before - 1.5 * 1.5 * 1e-9) < rounded);  // ½ l² ((1 + 1e-9)² − 1)
  CHECK(report.iterations == 1);
}

TEST_CASE("by lines coordinates that are all small come back to their own rounding") {
  for (const double unit : {1e-4, 1e-9, 1e-15}) {
    const auto form = form_of_run(on_a_rod(1.5 * unit));
    const Eigen::VectorXd there = unit * Eigen::Vector4d(0.9, -1.2, 0.4, 0.3);
    Eigen::VectorXd y = unit * Eigen::Vector4d(0.9 * (1.0 + 1e-9), -1.2 * (1.0 + 1e-9), 0.4, 0.3);
    CHECK(form.project(0.0, y).iterations <= 2);
    CHECK((y - there).cwiseAbs().maxCoeff() < rounded * unit);
  }
}

TEST_CASE("by lines a state comes to where Newton's method with factors puts it") {
  const auto chain = mechanical_system<4>(bench::LoopedChain{});
  const auto tip = holonomic("tip", bench::TipOfChain<4>{});
  const auto turning = holonomic("turning", [](const auto& q, const auto& t) { return q[0] - 0.3 * t * t; });
  const auto rolling = nonholonomic("rolling", [](const auto& q, const auto& v, const auto& t) {
    using std::cos;
    return v[1] - cos(q[0]) * v[2] - 0.1 * t;
  });
  CHECK(difference_of_newton(scene(chain, tip), rough_state<4>(), 0.0) < rounded);
  CHECK(difference_of_newton(scene(chain, tip, turning), rough_state<4>(), 0.7) < rounded);
  CHECK(difference_of_newton(scene(chain, rolling), rough_state<4>(), 0.7) < rounded);
  CHECK(difference_of_newton(scene(chain, turning, rolling, tip), rough_state<4>(), 0.7) < rounded);
  CHECK(difference_of_newton(scene(mechanical_system<8>(bench::LoopedChain{}), holonomic("tip", bench::TipOfChain<8>{})), rough_state<8>(), 0.0) < rounded);
}

TEST_CASE("lines of one phase are not taken for another") {
  const auto floor = contact("floor", [](const auto& q) { return q[1]; });
  const auto wall = contact("wall", [](const auto& q) { return q[0] - 0.5; });
  const auto s = scene(free_point, floor, wall);
  const auto form = form_of_run(s), by_newton = first_order_form(s).by(By::duals);
  const double closed = static_cast<double>(ContactPhase::closed), apart = static_cast<double>(ContactPhase::apart);
  Eigen::VectorXd on_floor(6), at_wall(6);
  on_floor << 0.7, 1e-11, 1.0, 1e-11, closed, apart;
  at_wall << 0.5 + 1e-11, 1e-11, 1e-11, 1.0, apart, closed;  // it leaves the floor
  for (const Eigen::VectorXd& y : {on_floor, at_wall}) {
    Eigen::VectorXd found = y, expected = y;
    form.project(0.0, found);
    by_newton.project(0.0, expected);
    CHECK((found - expected).cwiseAbs().maxCoeff() < rounded);
  }
}

TEST_CASE("functors that branch are projected by lines of the branch on which the state is") {
  // A rod whose metric is another on each side of x = 0.
  const auto heavier = mechanical_system<2>([](const auto& q, const auto& v) {
    using S = std::remove_cvref_t<decltype(q[0] * v[0])>;
    return q[0] > 0.0 ? S(0.5 * v.squaredNorm()) : S(1.5 * v[0] * v[0] + 0.5 * v[1] * v[1]);
  });
  const auto s = scene(heavier, holonomic("rod", [](const auto& q) { return 0.5 * (q.squaredNorm() - 2.25); }));
  const auto form = form_of_run(s), by_newton = first_order_form(s).by(By::duals);
  for (const double side : {1.0, -1.0, 1.0, -1.0}) {
    const Eigen::VectorXd there = Eigen::Vector4d(0.9 * side, -1.2, 0.4, 0.3 * side);
    CHECK(is_by_lines(form, 0.0, there));
    Eigen::VectorXd found = moved(there, 4), expected = found;
    form.project(0.0, found);
    by_newton.project(0.0, expected);
    CHECK((found - expected).cwiseAbs().maxCoeff() < rounded);
  }
}

TEST_CASE("what is not an ordinary step is Newton's method's, to the bit") {
  const auto same_bits = [](const auto& s, const Eigen::VectorXd& rough) {
    const auto form = form_of_run(s), by_newton = first_order_form(s).by(By::duals);
    Eigen::VectorXd found = rough, expected = rough;
    form.project(0.0, found);
    by_newton.project(0.0, expected);
    return found == expected;
  };
  const Eigen::VectorXd there = Eigen::Vector4d(0.9, -1.2, 0.4, 0.3);
  CHECK(same_bits(on_a_rod(1.5), moved(there, 4, 1e-2)));  // far away
  // A deflection of 1e-6 beside a place of 0.5, whose rounding is no drift: φ = x − 0.5 + u, with little inertia of u.
  const auto light_spring = mechanical_system<2>([](const auto& v) { return 0.5 * v[0] * v[0] + 5e-6 * v[1] * v[1]; },
                                                 [](const auto& q) { return q[1] * q[1]; });
  const auto elastic = scene(light_spring, holonomic("place", [](const auto& q) { return q[0] - 0.5 + q[1]; }));
  const Eigen::VectorXd deflected = Eigen::Vector4d(0.5 - 1e-6, 1e-6, 0.1, -0.1);
  CHECK(same_bits(elastic, Eigen::VectorXd(deflected + Eigen::Vector4d(2 * epsilon, 0.0, 0.0, 0.0))));
}

TEST_CASE("a constraint that is not linear in velocities is left to what looks at its residual afterwards") {
  const auto form = form_of_run(scene(free_point, nonholonomic("speed", [](const auto&, const auto& v) { return v.squaredNorm() - 0.25; })));
  Eigen::VectorXd y = Eigen::Vector4d(0.9, -1.2, 0.41, 0.3);  // one linear step leaves 4e-5
  CHECK_THROWS_AS(form.project(0.0, y), ConstraintError);
}

TEST_CASE("rows that are nearly the same are refused where they contradict each other") {
  const auto form = form_of_run(scene(free_point, holonomic("level", [](const auto& q) { return q[1] + 1.2; }), holonomic("again", [](const auto& q) {
                                        using std::sin;
                                        return q[1] + 1.2 + 1e-5 * (sin(q[0]) - std::sin(0.9));
                                      })));
  Eigen::VectorXd y = Eigen::Vector4d(0.9, -1.2, 0.0, 0.0);
  y[2] = 0.4;  // one row asks for v₁ = 0, the other for 1e-5 cos(q₀) v₀ besides
  CHECK_THROWS_AS(form.project(0.0, y), ConstraintError);
}

TEST_CASE("a state that cannot be projected is refused by lines as without them, and stays as it is") {
  const auto guided = scene(free_point, holonomic("graph", [](const auto& q) {
                              using std::sqrt;
                              return q[1] - sqrt(q[0]);
                            }));
  const auto form = form_of_run(guided);
  const Eigen::VectorXd without_value = Eigen::Vector4d(-1.0, 0.5, 1.0, 1.0);
  Eigen::VectorXd y = without_value;
  CHECK_THROWS_AS(form.project(0.0, y), NonFinite);
  CHECK(y == without_value);
}

TEST_CASE("velocities go back to where Newton's method puts them, if a change of one is another's velocity") {
  // Three carts in relative coordinates, the first held and the last on a rod: φ̇ is zero behind any kick.
  const auto carts = mechanical_system<3>([](const auto& v) {
    const auto second = v[0] + v[1], third = v[0] + v[1] + v[2];
    return v[0] * v[0] + 0.5 * (second * second + third * third);
  });
  const auto first = holonomic("held", [](const auto& q) { return q[0] - 0.5; });
  const auto last = holonomic("rod", [](const auto& q) { return q.sum() - 2.0; });
  const auto held = scene(carts, first, last);
  const auto form = form_of_run(held), by_newton = first_order_form(held).by(By::duals);
  Eigen::VectorXd there(6);
  there << 0.5, 0.75, 0.75, 0.0, 0.3, -0.3;
  CHECK(is_by_lines(form, 0.0, there));
  Eigen::VectorXd kicked = there, expected = there;
  kicked[3] = expected[3] = 0.25;
  const ProjectionReport report = form.project(0.0, kicked);
  by_newton.project(0.0, expected);
  CHECK((kicked - expected).cwiseAbs().maxCoeff() < rounded);
  CHECK(std::abs(kicked[3]) < rounded);
  CHECK(std::abs(kicked[3] + kicked[4] + kicked[5]) < rounded);
  CHECK(report.velocity_residual < rounded);
  kicked[0] = std::nan("");
  CHECK_THROWS_AS(form.project(0.0, kicked), Error);
}

TEST_CASE("where a stop time makes constraints others, steps go to these") {
  double speed = 1.0;
  const auto belt = scene(free_point, nonholonomic("belt", [&speed](const auto&, const auto& v) { return v[0] - speed; }));
  const auto on = [&](const auto& method) {
    speed = 1.0;
    Options options{.rtol = 1e-9, .max_step = 0.01, .stop_times = {5.0}};
    for (int k = 1; k < 400; ++k) options.output_times.push_back(0.025 * k);
    const auto run = simulate(belt, State<2>{0.0, {0.0, 0.0}, {1.0, 0.0}}, 10.0, method, options, [&](const StepView& step) {
      if (step.t() == 5.0) speed = 2.0;
    });
    REQUIRE(run.completed());
    CHECK(run.statistics.projections > 2 * many);
    CHECK(std::abs(run.y[2] - 2.0) < rounded);
    CHECK(std::abs(run.y[0] - 15.0) < 0.011);  // 5 s at 1 m/s, and 5 s at 2 m/s, which the first step does not know before its end
    CHECK(std::abs(run.samples.y(2, run.samples.y.cols() - 1) - 2.0) < rounded);
  };
  on(Dop853{});
  on(Dopri5{});
}

TEST_CASE("threads that share a form project as one does") {
  const auto form = form_of_run(on_a_rod(1.5));
  const Eigen::VectorXd there = Eigen::Vector4d(0.9, -1.2, 0.4, 0.3);
  std::vector<double> worst(3, 0.0);
  std::vector<std::thread> threads;
  for (double& each : worst)
    threads.emplace_back([&] {
      for (int i = 0; i < 2 * many; ++i) {
        Eigen::VectorXd y = moved(there, 4);
        form.project(0.0, y);
        each = std::max({each, std::abs(y.head(2).norm() - 1.5), std::abs(y.head(2).dot(y.tail(2)))});
      }
    });
  for (std::thread& thread : threads) thread.join();
  for (const double each : worst) CHECK(each < rounded);
}

TEST_CASE("a form projects with the same bits however often it is asked, and drift stays as small in a long run") {
  const auto rod = on_a_rod(1.5);
  const auto form = first_order_form(rod);
  const Eigen::VectorXd rough = moved(Eigen::Vector4d(0.9, -1.2, 0.4, 0.3), 4);
  Eigen::VectorXd first = rough, last = rough;
  form.project(0.0, first);
  for (int i = 0; i < many; ++i) {
    last = rough;
    form.project(0.0, last);
  }
  CHECK(first == last);
  const auto run = simulate(rod, State<2>{0.0, {0.9, -1.2}, {0.4, 0.3}}, 400.0, Dop853{}, {.rtol = 1e-12});
  CHECK(run.completed());
  CHECK(run.statistics.projections > 2 * many);
  CHECK(run.statistics.constraint_residual < rounded);
  CHECK(run.statistics.constraint_velocity < rounded);
  const auto energy = [](const auto& y) { return 0.5 * (y[2] * y[2] + y[3] * y[3]) + 9.81 * y[1]; };
  CHECK(std::abs(energy(run.y) - energy(Eigen::Vector4d(0.9, -1.2, 0.4, 0.3))) < 1e-9);  // some thousand steps of 1e-12
}
