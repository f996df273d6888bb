// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "../catch2_bridge.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "scenes/double_pendulum.hpp"

namespace {

using namespace qdot;
using detail::Dop853Coefficients;
using detail::Dopri5Coefficients;

// Every rooted tree with `vertices` vertices, as the list of its root's subtrees, each multiset once.
struct Tree {
  std::vector<Tree> branches;
  int vertices() const {
    int sum = 1;
    for (const Tree& branch : branches) sum += branch.vertices();
    return sum;
  }
  // γ: the number of vertices times the product of γ over the branches.
  double density() const {
    double product = vertices();
    for (const Tree& branch : branches) product *= branch.density();
    return product;
  }
  // Stage i's elementary weight: the product over the branches of Σⱼ aᵢⱼ (weight of the branch at j).
  template <class C>
  double at_stage(std::size_t i) const {
    double product = 1.0;
    for (const Tree& branch : branches) {
      double sum = 0.0;
      for (std::size_t j = 0; j < i; ++j) sum += C::a[i][j] * branch.at_stage<C>(j);
      product *= sum;
    }
    return product;
  }
};

std::vector<std::vector<Tree>> trees_up_to(int order) {
  std::vector<std::vector<Tree>> trees(static_cast<std::size_t>(order) + 1);
  trees[1].push_back({});
  for (int vertices = 2; vertices <= order; ++vertices) {
    std::vector<Tree> smaller;
    for (int v = 1; v < vertices; ++v) smaller.insert(smaller.end(), trees[static_cast<std::size_t>(v)].begin(), trees[static_cast<std::size_t>(v)].end());
    std::vector<Tree> chosen;
    const std::function<void(std::size_t, int)> choose = [&](std::size_t first, int left) {
      if (left == 0) trees[static_cast<std::size_t>(vertices)].push_back({chosen});
      for (std::size_t k = first; k < smaller.size(); ++k) {
        const int size = smaller[k].vertices();
        if (size > left) continue;
        chosen.push_back(smaller[k]);
        choose(k, left - size);
        chosen.pop_back();
      }
    };
    choose(0, vertices - 1);
  }
  return trees;
}

// Sums of a dozen products of numbers up to 44.
constexpr double coefficient_rounding = 2e-13;

template <class C, class Weights>
double worst_order_condition(const Weights& b, int order) {
  double worst = 0.0;
  for (const auto& of_this_size : trees_up_to(order))
    for (const Tree& tree : of_this_size) {
      double sum = 0.0;
      for (std::size_t i = 0; i < C::stages; ++i) sum += b[i] * tree.at_stage<C>(i);
      worst = std::max(worst, std::abs(sum - 1.0 / tree.density()));
    }
  return worst;
}

TEST_CASE("there are 1, 1, 2, 4, 9, 20, 48, 115 rooted trees") {
  const auto trees = trees_up_to(8);
  const std::vector<std::size_t> known = {0, 1, 1, 2, 4, 9, 20, 48, 115};  // OEIS A000081
  for (std::size_t k = 0; k < known.size(); ++k) CHECK(trees[k].size() == known[k]);
}

TEST_CASE("Dop853 fulfils all 200 conditions of order 8, and not those of order 9") {
  CHECK(worst_order_condition<Dop853Coefficients>(Dop853Coefficients::a[12], 8) < coefficient_rounding);
  CHECK(worst_order_condition<Dop853Coefficients>(Dop853Coefficients::a[12], 9) > 1e-6);
}

TEST_CASE("Dopri5 fulfils all 17 conditions of order 5, and not those of order 6") {
  CHECK(worst_order_condition<Dopri5Coefficients>(Dopri5Coefficients::a[6], 5) < coefficient_rounding);
  CHECK(worst_order_condition<Dopri5Coefficients>(Dopri5Coefficients::a[6], 6) > 1e-6);
}

TEST_CASE("the embedded weights are of order 5 and 3") {
  std::array<double, 13> order_5{}, order_3{};
  for (std::size_t j = 0; j < 12; ++j) {
    order_5[j] = Dop853Coefficients::a[12][j] - Dop853Coefficients::e[j];
    order_3[j] = Dop853Coefficients::a[12][j] - Dop853Coefficients::e_low[j];
  }
  CHECK(worst_order_condition<Dop853Coefficients>(order_5, 5) < coefficient_rounding);
  CHECK(worst_order_condition<Dop853Coefficients>(order_5, 6) > 1e-6);
  CHECK(worst_order_condition<Dop853Coefficients>(order_3, 3) < coefficient_rounding);
  CHECK(worst_order_condition<Dop853Coefficients>(order_3, 4) > 1e-6);
}

TEST_CASE("each stage lies at the time that its row says") {
  for (std::size_t i = 0; i < Dop853Coefficients::total; ++i) {
    double sum = 0.0;
    for (const double a : Dop853Coefficients::a[i]) sum += a;
    CHECK_THAT(sum, WithinAbs(Dop853Coefficients::c[i], coefficient_rounding));
  }
}

// ½ − Σ bᵢ cᵢ without rounding: products and sums with their errors (fused multiply-add; Knuth's TwoSum).
template <class C>
double exact_half_defect() {
  double sum = 0.5, low = 0.0;
  const auto add = [&](double x) {
    const double s = sum + x, z = s - sum;
    low += (sum - (s - z)) + (x - z);
    sum = s;
  };
  for (std::size_t i = 0; i < static_cast<std::size_t>(C::stages); ++i) {
    const double product = -C::a[static_cast<std::size_t>(C::stages)][i] * C::c[i];
    add(product);
    low += std::fma(-C::a[static_cast<std::size_t>(C::stages)][i], C::c[i], -product);
  }
  return sum + low;
}

TEST_CASE("what the rounding of b and c leaves of one half is known to ten digits") {
  CHECK_THAT(Dop853Coefficients::half_defect, WithinRel(exact_half_defect<Dop853Coefficients>(), 1e-10));
  CHECK_THAT(Dopri5Coefficients::half_defect, WithinRel(exact_half_defect<Dopri5Coefficients>(), 1e-10));
  CHECK(Dop853Coefficients::c[11] == 1.0);  // the stage that carries it
  CHECK(Dopri5Coefficients::c[5] == 1.0);
}

TEST_CASE("rounding moves an oscillator's energy by less than 1e-14 of it in 160 turns") {
  // Sums of weights that are rounded, and not of differences, move it by 2·4.6e-16 h in each unit of time: 4.6e-14 to here.
  const auto half_square = [](const auto& x) { return 0.5 * x[0] * x[0]; };
  const auto oscillator = mechanical_system<1>(half_square, half_square);
  const State<1> start{0.0, Eigen::Matrix<double, 1, 1>(1.0), Eigen::Matrix<double, 1, 1>(0.3)};
  const auto run = simulate(oscillator, start, 1000.0, Dop853{},
                            {.rtol = 1e-13, .atol = 1e-13, .initial_step = 0.05, .max_step = 0.05, .keep_trajectory = false});
  const double energy = 0.5 * run.y.squaredNorm();
  CHECK(std::abs(energy - 0.545) < 0.545e-14);
  CHECK(run.statistics.steps == 20000);
}

// The double pendulum of unit masses and lengths, released from (1.7, 1.7) at rest. The end at t = 3 is from a Taylor
// series in quadruple precision, good to all digits given.
const auto double_pendulum = mechanical_system<2>(scenes::DoublePendulum{});
const State<2> release{0.0, {1.7, 1.7}, {0.0, 0.0}};
const Eigen::Vector4d end_at_3(1.9234881444441958, 1.1485248782344042, 1.1168305154489508, -0.3371732877010639);

TEST_CASE("the error falls with the tolerance down to rounding") {
  for (const double tol : {1e-5, 1e-7, 1e-9, 1e-11, 1e-13}) {
    const auto run = simulate(double_pendulum, release, 3.0, Dop853{}, {.rtol = tol, .atol = tol});
    CHECK(run.completed());
    CHECK(run.t == 3.0);
    CHECK((run.y - end_at_3).norm() < 50 * tol);  // the motion amplifies errors by some tens in 3 s
  }
  const auto few = simulate(double_pendulum, release, 3.0, Dopri5{}, {.rtol = 1e-6, .atol = 1e-6});
  CHECK((few.y - end_at_3).norm() < 1e-3);
}

TEST_CASE("a force of the time alone is taken at each stage's own time") {
  // q̈ = cos t from rest: q = 1 − cos t, q̇ = sin t
  const auto pushed = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q, const auto& t) {
    using std::cos;
    return -q[0] * cos(t);
  });
  const State<1> rest{0.0, Vector<double, 1>(0.0), Vector<double, 1>(0.0)};
  const Eigen::Vector2d end(1.0 - std::cos(3.0), std::sin(3.0));
  CHECK((simulate(pushed, rest, 3.0, Dop853{}, {.rtol = 1e-10, .atol = 1e-10}).y - end).norm() < 50 * 1e-10);
  CHECK((simulate(pushed, rest, 3.0, Dopri5{}, {.rtol = 1e-7, .atol = 1e-7}).y - end).norm() < 50 * 1e-7);
}

// Steps of equal length: tolerances that nothing fails, and a first step that is the longest one allowed.
template <class Method>
double end_error(const Method& method, double h, double t_end) {
  const auto run = simulate(double_pendulum, release, t_end, method,
                            {.rtol = 0.9, .atol = 1e6, .initial_step = h, .max_step = h, .keep_trajectory = false});
  const auto exact = simulate(double_pendulum, release, t_end, Dop853{}, {.rtol = 1e-14, .atol = 1e-14});
  return (run.y - exact.y).norm();
}

TEST_CASE("the order of convergence is 8 and 5, forward and backward in time") {
  for (const double t_end : {1.0, -1.0}) {
    const double order_8 = std::log2(end_error(Dop853{}, 1.0 / 8, t_end) / end_error(Dop853{}, 1.0 / 16, t_end));
    CHECK(order_8 > 7.4);
    CHECK(order_8 < 9.2);
    const double order_5 = std::log2(end_error(Dopri5{}, 1.0 / 64, t_end) / end_error(Dopri5{}, 1.0 / 128, t_end));
    CHECK(order_5 > 4.6);
    CHECK(order_5 < 5.6);
  }
}

TEST_CASE("dense output is of order 7 and 4 inside a step and meets the ends") {
  const auto exact = simulate(double_pendulum, release, 1.0, Dop853{}, {.rtol = 1e-14, .atol = 1e-14});
  const auto middle_error = [&](const auto& method, double h) {
    const auto run = simulate(double_pendulum, release, h, method, {.rtol = 0.9, .atol = 1e6, .initial_step = h});
    CHECK(run.statistics.steps == 1);
    CHECK((run.trajectory.y(h) - run.y).norm() < 1e-14);
    double worst = 0.0;
    for (const double s : {0.3, 0.5, 0.8}) worst = std::max(worst, (run.trajectory.y(s * h) - exact.trajectory.y(s * h)).norm());
    return worst;
  };
  const double order_7 = std::log2(middle_error(Dop853{}, 0.2) / middle_error(Dop853{}, 0.1));
  CHECK(order_7 > 7.5);  // one step of a method of order p errs by h^(p + 1)
  CHECK(order_7 < 9.5);
  const double order_4 = std::log2(middle_error(Dopri5{}, 0.05) / middle_error(Dopri5{}, 0.025));
  CHECK(order_4 > 4.5);
  CHECK(order_4 < 6.0);
}

TEST_CASE("forth and back returns to the start") {
  const auto forth = simulate(double_pendulum, release, 3.0, Dop853{}, {.rtol = 1e-11, .atol = 1e-11});
  const auto back = simulate(double_pendulum, forth.state(), 0.0, Dop853{}, {.rtol = 1e-11, .atol = 1e-11});
  CHECK(back.t == 0.0);
  CHECK((back.y - Eigen::Vector4d(1.7, 1.7, 0, 0)).norm() < 100 * 1e-11);
}

TEST_CASE("tolerances hold per component") {
  // A pendulum beside an uncoupled slow oscillation of amplitude 1e8: x = A cos(t/10).
  const double A = 1e8;
  const auto both = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); },
                                         [](const auto& q) {
                                           using std::cos;
                                           return -9.81 * cos(q[0]) + 0.005 * q[1] * q[1];
                                         });
  const auto alone = mechanical_system<1>([](const auto& v) { return 0.5 * v.squaredNorm(); },
                                          [](const auto& q) {
                                            using std::cos;
                                            return -9.81 * cos(q[0]);
                                          });
  const Options options{.rtol = 1e-9, .atol = 1e-9};
  const auto beside = simulate(both, State<2>{0.0, {1.0, A}, {0.0, 0.0}}, 10.0, Dop853{}, options);
  const auto exact = simulate(alone, State<1>{0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)}, 10.0, Dop853{},
                              {.rtol = 1e-13, .atol = 1e-13});
  CHECK_THAT(beside.y[0], WithinAbs(exact.y[0], 1e-7));
  CHECK_THAT(beside.y[1], WithinAbs(A * std::cos(1.0), 1e-7 * A));
  CHECK(beside.statistics.limiting_component() % 2 == 0);  // the pendulum's angle or speed
}

// A system without a Lagrangian behind it, of run-time size.
struct Pole {
  static constexpr int size_at_compile_time = Dynamic;
  Eigen::Index size() const { return 1; }
  void derivative(double, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> ydot) const { ydot[0] = y[0] * y[0]; }
  void jacobian(double, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::MatrixXd> J) const { J(0, 0) = 2 * y[0]; }
  std::string component_name(Eigen::Index) const { return "y"; }
};

TEST_CASE("a solution that runs to infinity ends with its name and what was good") {
  // ẏ = y², y(0) = 1: y = 1/(1 − t)
  const auto run = simulate(Pole{}, FirstOrderState{0.0, Eigen::VectorXd::Constant(1, 1.0)}, 2.0, Dop853{}, {.rtol = 1e-10});
  CHECK((run.outcome == Outcome::step_too_small || run.outcome == Outcome::non_finite));
  CHECK(run.message.find("dop853") != std::string::npos);
  CHECK_THAT(run.t, WithinAbs(1.0, 1e-6));
  CHECK_THAT(run.trajectory.y(0.9)[0], WithinRel(10.0, 1e-7));
  CHECK(run.statistics.evaluations < 20000);
}

TEST_CASE("a model that leaves its domain shortens the step, and is named when that does not help") {
  // V = −⅔ (1 − q)^{3/2}: q̈ = −√(1 − q), NaN beyond q = 1
  const auto edge = mechanical_system<1>([](const auto& v) { return 0.5 * v.squaredNorm(); },
                                         [](const auto& q) {
                                           using std::sqrt;
                                           return -2.0 / 3.0 * (1.0 - q[0]) * sqrt(1.0 - q[0]);
                                         });
  const auto run = simulate(edge, State<1>{0.0, Vector<double, 1>(0.0), Vector<double, 1>(2.0)}, 5.0, Dop853{}, {.rtol = 1e-8});
  CHECK(run.outcome == Outcome::non_finite);
  CHECK(run.y[0] <= 1.0);
  CHECK(run.y[0] > 0.9999);
  CHECK(run.statistics.rejected() > 0);
}

TEST_CASE("a stepper lands on its limit, keeps its memory and refuses to turn round") {
  const auto form = first_order_form(double_pendulum);
  auto stepper = Dop853{}.stepper(form, {.rtol = 1e-8});
  static_assert(Stepper<decltype(stepper)>);
  stepper.reset(0.0, form.packed(release));
  CHECK(stepper.step(1.0));
  const double* const memory = stepper.polynomial().coefficients;
  while (stepper.t() != 1.0) REQUIRE(stepper.step(1.0));
  CHECK(stepper.t() == 1.0);
  CHECK_THROWS_AS(stepper.step(0.5), InvalidValue);
  CHECK(stepper.polynomial().degree == 7);
  stepper.reset(0.0, form.packed(release));
  CHECK(stepper.step(-1.0));
  CHECK(stepper.polynomial().coefficients == memory);
}

TEST_CASE("a system whose functors capture can be stepped, and its stepper be assigned") {
  const double omega = 2.0;
  const auto oscillator = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                               [omega](const auto& q) { return 0.5 * omega * omega * q[0] * q[0]; });
  const auto form = first_order_form(oscillator);
  auto stepper = Dop853{}.stepper(form, {});
  stepper = Dop853{}.stepper(form, {.rtol = 1e-12});
  stepper.reset(0.0, Eigen::Vector2d(1.0, 0.0));
  while (stepper.t() != 1.0) REQUIRE(stepper.step(1.0));
  CHECK_THAT(stepper.y()[0], WithinAbs(std::cos(2.0), 1e-10));
}

TEST_CASE("the first step is a number, however small the sizes of the motion and its tolerance") {
  // An oscillator of size 1e-300: cos 1; and a fall from rest at 0, whose force is 1e308 tolerances: −½ g.
  const auto oscillator = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.5 * q[0] * q[0]; });
  const auto fall = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 9.81 * q[0]; });
  const auto check = [&](const auto& method) {
    for (const double atol : {3e-308, 1e-305}) {
      const auto small = simulate(oscillator, State<1>{0.0, Vector<double, 1>(1e-300), Vector<double, 1>(0.0)}, 1.0, method, {.rtol = 1e-9, .atol = atol});
      INFO(small.message);
      CHECK(small.completed());
      CHECK(std::abs(small.y[0] / 1e-300 - std::cos(1.0)) < 1e-6);
      const auto fallen = simulate(fall, State<1>{0.0, Vector<double, 1>(0.0), Vector<double, 1>(0.0)}, 1.0, method, {.rtol = 1e-9, .atol = atol});
      INFO(fallen.message);
      CHECK(fallen.completed());
      CHECK(std::abs(fallen.y[0] + 0.5 * 9.81) < 1e-8);
    }
  };
  check(Dop853{});
  check(Dopri5{});
}

TEST_CASE("a limit some rounding units away is reached") {
  const auto form = first_order_form(double_pendulum);
  auto stepper = Dop853{}.stepper(form, {});
  stepper.reset(3.0, form.packed(release));
  const double next = std::nextafter(3.0, 4.0);
  CHECK(stepper.step(next));
  CHECK(stepper.t() == next);
}

}  // namespace
