// SPDX-License-Identifier: MIT
#include "qdot/analysis/parameter_fit.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "catch2_bridge.hpp"
#include "error_message.hpp"
#include "systems/double_pendulum_of_parameters.hpp"

using qdot::Dop853;
using qdot::Experiment;
using qdot::FitOutcome;
using qdot::Options;
using qdot::parameter_fit;
using qdot::State;

namespace {

const Options fine{.rtol = 1e-12, .atol = 1e-13};

// Normally distributed numbers of which the k-th is always the same: two hashes of k as an angle and a radius.
double normal(std::uint64_t k) {
  const auto uniform = [](std::uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return (static_cast<double>((x ^ (x >> 31)) >> 11) + 0.5) * 0x1p-53;
  };
  return std::sqrt(-2.0 * std::log(uniform(2 * k))) * std::cos(2.0 * std::numbers::pi * uniform(2 * k + 1));
}

std::vector<double> times_to(double end, int count) {
  std::vector<double> times;
  for (int k = 1; k <= count; ++k) times.push_back(end * k / count);
  return times;
}

const systems::DoublePendulumFamily double_pendulum;
using Five = qdot::Vector<double, 5>;

// Angles of a double pendulum with errors of size sigma.
Experiment<2> swing(const Five& p, const State<2>& start, double sigma, std::uint64_t noise) {
  Experiment<2> data{.start = start, .times = times_to(3.0, 60), .measured = Eigen::MatrixXd(2, 60), .sigma = Eigen::Vector2d(sigma, sigma)};
  const auto run = sensitivities(double_pendulum, p, start, 3.0, Dop853{}, fine);  // whose code is there
  for (Eigen::Index k = 0; k < 60; ++k) data.measured.col(k) = run.at(data.times[static_cast<std::size_t>(k)]).q;
  for (Eigen::Index k = 0; k < 120; ++k) data.measured.data()[k] += sigma * normal(noise + static_cast<std::uint64_t>(k));
  return data;
}

// A ball above a floor, tied to the height 5 by a spring: p = (g, e, height, velocity, k).
struct Ball {
  double g = 0.0, k = 0.0;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const { return g * q[0] + 0.5 * k * (q[0] - 5.0) * (q[0] - 5.0); }
};
struct Bounce {
  double e = 1.0;
  void operator()(State<1>& s) const { s.qdot *= -e; }
};
struct BallOf {
  auto operator()(const Five& p) const {
    const auto floor = qdot::event("floor", [](const auto& q) { return q[0]; }).falling().action(Bounce{p[1]});
    return qdot::problem(qdot::mechanical_system<1>(Ball{p[0], p[4]}), State<1>{0.0, {p[2]}, {p[3]}}, qdot::events(floor));
  }
};

// Heights x(t) with errors.
template <class X>
Experiment<1> heights(const X& x, double end, int count, double sigma) {
  Experiment<1> data{.times = times_to(end, count), .measured = Eigen::MatrixXd(1, count)};
  for (int k = 0; k < count; ++k) data.measured(0, k) = x(data.times[static_cast<std::size_t>(k)]) + sigma * normal(static_cast<std::uint64_t>(k));
  if (sigma > 0.0) data.sigma = Eigen::VectorXd::Constant(1, sigma);
  return data;
}

// Dropped from the height h, with bounces.
double dropped(double g, double e, double h, double t) {
  double v = std::sqrt(2 * g * h);
  if (t < v / g) return h - 0.5 * g * t * t;
  for (t -= v / g, v *= e; t > 2 * v / g; v *= e) t -= 2 * v / g;
  return v * t - 0.5 * g * t * t;
}

}  // namespace

TEST_CASE("a double pendulum's mass ratio and lengths come out of noisy angles within three standard deviations, and so does a start that is unknown") {
  const Five truth{{1.0, 0.7, 1.1, 0.9, 9.81}};
  std::vector<Experiment<2>> swings{swing(truth, {0.0, {0.9, 0.5}, {0.0, 0.0}}, 0.01, 0), swing(truth, {0.0, {-0.4, 1.2}, {0.3, 0.0}}, 0.01, 1000)};
  swings[1].start = State<2>{0.0, {-0.3, 1.1}, {0.3, 0.0}};
  swings[1].unknown = {0, 1};
  const auto fit = parameter_fit(
      double_pendulum,
      {{"m1", 1.0, 1.0, 1.0}, {"m2", 1.2, 0.1, 10.0}, {"l1", 0.9, 0.1, 10.0}, {"l2", 1.1, 0.1, 10.0}, {"g", 9.81, 9.81, 9.81}}, swings,
      Dop853{});
  INFO(fit.message);
  REQUIRE(fit.converged());
  CHECK(fit.names[5] == "q0 at the start of experiment 1");
  qdot::Vector<double, 7> expected;
  expected << truth, -0.4, 1.2;
  for (const Eigen::Index i : {1, 2, 3, 5, 6}) {
    CHECK(std::abs(fit.p[i] - expected[i]) < 3 * fit.standard_deviation[i]);
    CHECK(fit.standard_deviation[i] < 0.01);
    CHECK(fit.standard_deviation[i] > 1e-4);
  }
  CHECK(fit.standard_deviation[0] == 0.0);  // held
  CHECK(fit.p[0] == 1.0);
  CHECK(fit.degrees_of_freedom == 235);
  CHECK(std::abs(fit.chi_squared - 235) < 3 * std::sqrt(2 * 235.0));  // χ² has the variance 2n
  CHECK(fit.runs < 20);
  REQUIRE(fit.residuals.size() == 2);
  CHECK_THAT(fit.residuals[0].squaredNorm() + fit.residuals[1].squaredNorm(), WithinAbs(fit.chi_squared, 1e-9));
}

TEST_CASE("what the data cannot tell apart is named: both masses of a pendulum, and its lengths and g") {
  const Five truth{{1.0, 0.7, 1.1, 0.9, 9.81}};
  const auto swings = swing(truth, {0.0, {0.9, 0.5}, {0.0, 0.0}}, 0.01, 0);
  const auto fit = parameter_fit(double_pendulum, {{"m1", 1.0}, {"m2", 1.2}, {"l1", 0.9}, {"l2", 1.1}, {"g", 9.0}}, swings, Dop853{});
  INFO(fit.message);
  CHECK(fit.outcome == FitOutcome::undetermined);
  REQUIRE(fit.open.cols() == 2);
  const auto is_open = [&](const Five& v) {  // in the span of orthogonal columns
    CHECK_THAT(std::abs(fit.open.col(0).dot(fit.open.col(1))), WithinAbs(0.0, 1e-6));
    const Eigen::VectorXd rest = v - fit.open.col(0) * (fit.open.col(0).dot(v) / fit.open.col(0).squaredNorm()) -
                                 fit.open.col(1) * (fit.open.col(1).dot(v) / fit.open.col(1).squaredNorm());
    return rest.norm() < 1e-6;
  };
  CHECK(is_open(Five{{fit.p[0], fit.p[1], 0, 0, 0}}));
  CHECK(is_open(Five{{0, 0, fit.p[2], fit.p[3], fit.p[4]}}));
  CHECK(fit.message.find("nothing that was measured changes with m") != std::string::npos);
  for (int i = 0; i < 5; ++i) CHECK(fit.standard_deviation[i] == std::numeric_limits<double>::infinity());
  // What can be told is right all the same.
  CHECK_THAT(fit.p[1] / fit.p[0], WithinAbs(0.7, 0.02));
  CHECK_THAT(fit.p[4] / fit.p[2], WithinAbs(9.81 / 1.1, 0.05));
}

TEST_CASE("of outputs that depend on parameters themselves the slopes are whole: lengths come out of the height of the tip") {
  const Five truth{{1.0, 0.7, 1.1, 0.9, 9.81}};
  Experiment<2> swings = swing(truth, {0.0, {0.9, 0.5}, {0.0, 0.0}}, 1e-12, 0);
  Eigen::MatrixXd tip(1, swings.measured.cols());
  for (Eigen::Index k = 0; k < tip.cols(); ++k) tip(0, k) = -1.1 * std::cos(swings.measured(0, k)) - 0.9 * std::cos(swings.measured(1, k));
  swings.measured = tip;
  swings.sigma.resize(0);
  const auto height_of_tip = [](const auto& q, const auto&, const auto& p) {
    using std::cos;
    return -p[2] * cos(q[0]) - p[3] * cos(q[1]);
  };
  const auto fit = parameter_fit(double_pendulum, {{"m1", 1.0, 1.0, 1.0}, {"m2", 0.8}, {"l1", 1.05}, {"l2", 0.95}, {"g", 9.81, 9.81, 9.81}},
                                 swings, Dop853{}, fine, height_of_tip);
  INFO(fit.message);
  CHECK(fit.converged());
  CHECK((fit.p - truth).norm() < 1e-9);
}

// y = h + v t − g t²/2: normal equations of a regression.
TEST_CASE("a projectile's g, height and speed and their covariance are those of linear regression") {
  constexpr double sigma = 0.02, close = 1e-9;
  constexpr int count = 25;
  Experiment<1> flight = heights([](double t) { return 3.0 + 4.0 * t - 0.5 * 9.81 * t * t; }, 0.9, count, sigma);
  Eigen::Matrix<double, count, 3> X;
  for (int k = 0; k < count; ++k) {
    const double t = flight.times[static_cast<std::size_t>(k)];
    X.row(k) << -0.5 * t * t, 1.0, t;
  }
  const Eigen::Matrix3d inverse = (X.transpose() * X).inverse();
  const Eigen::Vector3d beta = inverse * (X.transpose() * flight.measured.transpose());
  const double rest = (X * beta - flight.measured.transpose()).squaredNorm();
  const std::vector<Eigen::Index> places{0, 2, 3};
  const auto check = [&](const auto& fit, double variance) {
    INFO(fit.message);
    REQUIRE(fit.converged());
    for (Eigen::Index i = 0; i < 3; ++i) {
      CHECK_THAT(fit.p[places[static_cast<std::size_t>(i)]], WithinAbs(beta[i], close));
      for (Eigen::Index j = 0; j < 3; ++j)
        CHECK_THAT(fit.covariance(places[static_cast<std::size_t>(i)], places[static_cast<std::size_t>(j)]), WithinAbs(variance * inverse(i, j), close));
      CHECK_THAT(fit.standard_deviation[places[static_cast<std::size_t>(i)]], WithinAbs(std::sqrt(variance * inverse(i, i)), close));
    }
  };
  const qdot::FitParameter asked[] = {{"g", 9.0}, {"e", 0.5, 0.5, 0.5}, {"height", 2.0}, {"speed", 0.0}, {"k", 0.0, 0.0, 0.0}};
  const auto known = parameter_fit(BallOf{}, asked, flight, Dop853{}, fine);
  check(known, sigma * sigma);
  CHECK_THAT(known.chi_squared, WithinAbs(rest / (sigma * sigma), 1e-6));
  flight.sigma.resize(0);
  const auto estimated = parameter_fit(BallOf{}, asked, flight, Dop853{}, fine);
  check(estimated, rest / (count - 3));
  CHECK_THAT(estimated.sigma, WithinAbs(std::sqrt(rest / (count - 3)), close));
}

// x = 5 + cos ωt, ∂x/∂k = −t sin ωt/2ω with k = ω².
TEST_CASE("an oscillator's stiffness comes out of exact samples, with the standard deviation of the closed form") {
  constexpr double omega = 2.1, sigma = 0.1;
  Experiment<1> swing = heights([](double t) { return 5.0 + std::cos(omega * t); }, 7.0, 40, 0.0);
  swing.sigma = Eigen::VectorXd::Constant(1, sigma);
  const auto fit = parameter_fit(
      BallOf{}, {{"g", 0.0, 0.0, 0.0}, {"e", 0.5, 0.5, 0.5}, {"height", 6.0, 6.0, 6.0}, {"speed", 0.0, 0.0, 0.0}, {"k", 4.0, 0.0}}, swing,
      Dop853{}, fine);
  INFO(fit.message);
  REQUIRE(fit.converged());
  CHECK_THAT(fit.p[4], WithinAbs(omega * omega, 1e-9));
  double sum = 0.0;
  for (const double t : swing.times) sum += std::pow(t * std::sin(omega * t) / (2 * omega), 2);
  CHECK_THAT(fit.standard_deviation[4], WithinAbs(sigma / std::sqrt(sum), 1e-9));
}

TEST_CASE("restitution comes out of bounces, stays at a bound that is named, and is open before the first bounce") {
  const Experiment<1> bounces = heights([](double t) { return dropped(9.81, 0.8, 1.0, t); }, 1.6, 80, 0.003);
  const auto found = parameter_fit(
      BallOf{}, {{"g", 9.0}, {"e", 0.75, 0.0, 1.0}, {"height", 1.0}, {"speed", 0.0, 0.0, 0.0}, {"k", 0.0, 0.0, 0.0}}, bounces, Dop853{});
  INFO(found.message);
  REQUIRE(found.converged());
  CHECK(std::abs(found.p[0] - 9.81) < 3 * found.standard_deviation[0]);
  CHECK(std::abs(found.p[1] - 0.8) < 3 * found.standard_deviation[1]);
  CHECK(found.standard_deviation[1] < 2e-3);

  const auto bounded = parameter_fit(
      BallOf{}, {{"g", 9.0}, {"e", 0.7, 0.0, 0.78}, {"height", 1.0}, {"speed", 0.0, 0.0, 0.0}, {"k", 0.0, 0.0, 0.0}}, bounces, Dop853{});
  INFO(bounded.message);
  CHECK(bounded.outcome == FitOutcome::at_bound);
  CHECK(bounded.p[1] == 0.78);
  CHECK(bounded.at_bound == std::vector<std::string>{"e"});
  CHECK(bounded.message.find("the data would take e beyond the bound") != std::string::npos);
  CHECK(bounded.chi_squared > found.chi_squared);
  CHECK(bounded.standard_deviation[1] == 0.0);

  const Experiment<1> fall = heights([](double t) { return dropped(9.81, 0.8, 1.0, t); }, 0.4, 20, 0.003);
  const auto open = parameter_fit(
      BallOf{}, {{"g", 9.0}, {"e", 0.75, 0.0, 1.0}, {"height", 1.0}, {"speed", 0.0, 0.0, 0.0}, {"k", 0.0, 0.0, 0.0}}, fall, Dop853{});
  CHECK(open.outcome == FitOutcome::undetermined);
  CHECK(open.message.find("nothing that was measured changes with e; hold one of each") != std::string::npos);
  CHECK(open.standard_deviation[1] == std::numeric_limits<double>::infinity());
  CHECK(open.standard_deviation[0] < 0.1);
}

TEST_CASE("a minimum that does not describe the data is not called the end of work: a stiffness of 9 from a guess of 6.5, over many periods") {
  Experiment<1> swing = heights([](double t) { return 5.0 + std::cos(3.0 * t); }, 15.0, 60, 0.0);
  const auto fitted = [&](double guess) {
    return parameter_fit(BallOf{}, {{"g", 0.0, 0.0, 0.0}, {"e", 0.5, 0.5, 0.5}, {"height", 6.0, 6.0, 6.0}, {"speed", 0.0, 0.0, 0.0}, {"k", guess, 1.0}},
                         swing, Dop853{});
  };
  const auto unknown = fitted(6.5);
  INFO(unknown.message);
  REQUIRE(unknown.converged());
  REQUIRE(std::abs(unknown.p[4] - 9.0) > 0.1);
  CHECK(unknown.message.find("of what the data spread about their means: this minimum does not describe the data; begin at another guess") !=
        std::string::npos);
  swing.sigma = Eigen::VectorXd::Constant(1, 1e-3);
  const auto known = fitted(6.5);
  CHECK(known.message.find("times sigma on average: this minimum does not describe the data; begin at another guess") != std::string::npos);
  CHECK(known.message.find("nothing to do") == std::string::npos);
  CHECK(fitted(9.01).message.find("nothing to do.") != std::string::npos);
}

TEST_CASE("a fit that ends early returns what it has, and says why") {
  const Experiment<1> bounces = heights([](double t) { return dropped(9.81, 0.8, 1.0, t); }, 1.6, 80, 0.003);
  const qdot::FitParameter asked[] = {{"g", 8.5}, {"e", 0.75, 0.0, 1.0}, {"height", 1.0}, {"speed", 0.0, 0.0, 0.0}, {"k", 0.0, 0.0, 0.0}};
  const auto ended = parameter_fit(BallOf{}, asked, bounces, Dop853{}, {}, {}, {.most_runs = 2});
  CHECK(ended.outcome == FitOutcome::run_limit);
  CHECK(ended.message.find("allow more runs") != std::string::npos);
  CHECK(ended.runs == 2);
  const auto failed = parameter_fit(BallOf{}, asked, bounces, Dop853{}, {.max_steps = 3});
  CHECK(failed.outcome == FitOutcome::motion_failed);
  CHECK(failed.message.find("no motion at the guess: experiment 0: step_limit") == 0);
  CHECK(failed.p[0] == 8.5);
  const auto nothing = [](const auto& q) {
    using std::sqrt;
    return sqrt(q[0] - 100.0);
  };
  const auto blind = parameter_fit(BallOf{}, asked, bounces, Dop853{}, {}, nothing);
  CHECK(blind.outcome == FitOutcome::motion_failed);
  CHECK(blind.message.find("is not finite") != std::string::npos);
}

TEST_CASE("a search for least squares stays within bounds, leaves a bound where it began, and turns back from where there is nothing") {
  using qdot::detail::ResidualsAt;
  // Rosenbrock's valley, whose bottom is at (1, 1).
  const auto valley = [](const Eigen::VectorXd& x) {
    ResidualsAt at{x, Eigen::VectorXd(2), Eigen::MatrixXd(2, 2), {}};
    at.r << 10 * (x[1] - x[0] * x[0]), 1 - x[0];
    at.J << -20 * x[0], 10, -1, 0;
    if (x[0] < -2.0) at.trouble = "nothing there";
    return at;
  };
  const auto sought = [&](const Eigen::Vector2d& lower, const Eigen::Vector2d& upper, const Eigen::Vector2d& from) {
    return qdot::detail::BoundedLeastSquares({valley, lower, upper, 200, 1e-12, 0.0}).end(from);
  };
  const Eigen::Vector2d far(9, 9);
  CHECK((sought(-far, far, {-1.2, 1.0}).best.x - Eigen::Vector2d(1, 1)).norm() < 1e-9);
  CHECK((sought({-1.2, -0.5}, far, {-1.2, -0.5}).best.x - Eigen::Vector2d(1, 1)).norm() < 1e-9);
  // On x₁ ≤ 1/4 the least is where 2 (x₀ − 1) − 400 x₀ (1/4 − x₀²) = 0 beyond x₀ = 1/2.
  const auto held = sought(-far, {9, 0.25}, {-1.2, -1.0});
  CHECK(held.held == std::vector<Eigen::Index>{1});
  CHECK(held.best.x[1] == 0.25);
  CHECK_THAT(200 * held.best.x[0] * (held.best.x[0] * held.best.x[0] - 0.25) + held.best.x[0] - 1, WithinAbs(0.0, 1e-6));
  CHECK((sought(-far, far, {-1.99, 8.0}).best.x - Eigen::Vector2d(1, 1)).norm() < 1e-9);
}

TEST_CASE("what is wrong with a question about parameters is said before the first run") {
  Experiment<1> data{.times = {0.1, 0.2}, .measured = Eigen::MatrixXd::Ones(1, 2)};
  const auto asked = [&](const std::vector<Experiment<1>>& experiments, double guess = 9.0) {
    return qdot::error_message([&] {
      parameter_fit(BallOf{}, {{"g", guess, 0.0, 10.0}, {"e", 0.5}, {"height", 1.0}, {"speed", 0.0}, {"k", 0.0}}, experiments, Dop853{});
    });
  };
  CHECK(asked({}) == "parameter_fit: there must be experiments, but there are none; give one at least");
  CHECK(
      asked({data}, 11.0) ==
      "parameter_fit: the guess of 'g' must be finite and lie within its bounds, but is 11 with bounds 0 and 10; choose another guess or other bounds");
  auto wrong = data;
  wrong.times = {0.2, 0.1, 0.3};
  CHECK(asked({wrong}).find("0.1 comes after 0.2; sort them") != std::string::npos);
  wrong = data;
  wrong.measured.resize(1, 3);
  CHECK(asked({wrong}).find("must have 2 entries, but has 3; give outputs × times") != std::string::npos);
  wrong = data;
  wrong.measured(0, 1) = std::numeric_limits<double>::quiet_NaN();
  CHECK(asked({wrong}).find("must be finite, but one is not; leave its time out") != std::string::npos);
  wrong = data;
  wrong.sigma = Eigen::VectorXd::Zero(1);
  CHECK(asked({wrong}).find("a standard deviation must be positive and finite, but sigma[0] of experiment 0 is 0") != std::string::npos);
  CHECK(asked({data, wrong}).find("in all experiments or in none") != std::string::npos);
  wrong = data;
  wrong.unknown = {0};
  CHECK(asked({wrong}).find("an experiment must have a start") != std::string::npos);
  wrong.start = State<1>{0.0, {1.0}, {0.0}};
  wrong.unknown = {2};
  CHECK(asked({wrong}).find("must be those of [q; qdot], 0 to 1, but one of experiment 0 is 2") != std::string::npos);
  wrong = data;
  wrong.measured = Eigen::MatrixXd::Ones(2, 2);
  CHECK(asked({wrong}).find("give a row for each output; without outputs these are the coordinates") != std::string::npos);
}
