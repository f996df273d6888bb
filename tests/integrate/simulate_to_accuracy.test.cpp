// SPDX-License-Identifier: MIT
#include "qdot/integrate/simulate_to_accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "../catch2_bridge.hpp"
#include "accurate_scenes.hpp"
#include "qdot/integrate/runge_kutta.hpp"

namespace {

using namespace qdot;
using accurate_scenes::Equations;
using accurate_scenes::Scene;

constexpr double honest = 3.0;  // times its estimate, at most, is a true error

FirstOrderState start_of(const Scene& scene) {
  return {0.0, Eigen::Map<const Eigen::VectorXd>(scene.start.data(), static_cast<Eigen::Index>(scene.start.size()))};
}

// Of a run's samples: the largest error of a component beside the largest value of that component.
double true_error(const Samples& samples, const Eigen::MatrixXd& exact) {
  const Eigen::VectorXd sizes = exact.cwiseAbs().rowwise().maxCoeff();
  double largest = 0;
  for (Eigen::Index i = 0; i < exact.rows(); ++i)
    if (sizes[i] > 0) largest = std::max(largest, (samples.y.row(i) - exact.row(i)).cwiseAbs().maxCoeff() / sizes[i]);
  return largest;
}

Equations equations(Eigen::Index n, std::function<void(double, const double*, double*)> f) { return {std::move(f), n}; }

const auto double_pendulum = [](double, const double* y, double* d) {
  const double c = std::cos(y[0] - y[1]), s = std::sin(y[0] - y[1]);
  const double f1 = -s * y[3] * y[3] - 2 * 9.81 * std::sin(y[0]), f2 = s * y[2] * y[2] - 9.81 * std::sin(y[1]), det = 2 - c * c;
  d[0] = y[2], d[1] = y[3], d[2] = (f1 - c * f2) / det, d[3] = (2 * f2 - c * f1) / det;
};

TEST_CASE("the references of the accuracy tests agree with published digits") {
  constexpr double rounding = 5e-13;  // of 0.4 and of ten turns: neither is a double, and the phase of Kepler's motion feels it
  for (const Scene& scene : accurate_scenes::all()) {
    const auto ends = [&](double t, const std::vector<double>& published) {
      const auto y = scene.exact({t})[0];
      for (std::size_t i = 0; i < published.size(); ++i)
        CHECK_THAT(static_cast<double>(y[i]), WithinAbs(published[i], rounding));
    };
    INFO(scene.name);
    if (scene.name == "pendulum, 1 rad, t = 100") ends(10, {-0.46325276873178667, 2.6365495135496304});
    if (scene.name == "Kepler, e = 0.6, 10 turns") ends(20 * std::numbers::pi, {0.4, 0, 0, 2});
    if (scene.name == "Mathews-Lakshmanan, t = 30") ends(5, {-1.93540662584544});
    if (scene.name == "free rigid body, t = 100") ends(1, {0.8022007530563608603754581, 0.5970543960107885695316666, 0.8196351111414528990710796});
    if (scene.name == "double pendulum, t = 3")
      ends(3, {1.9234881444441958, 1.1485248782344042, 1.1168305154489508, -0.3371732877010639});
    if (scene.name == "Hénon-Heiles, t = 100")
      ends(100, {-0.0401942378760688168, 0.6790169217720216421, 0.0384509289518598345, 0.0485948315530036422});
  }
}

TEST_CASE("the error of the whole motion is what was asked for, and three times its estimate at most") {
  constexpr int parts = 40;  // most of these times lie between steps
  int reached = 0, in_two_runs = 0;
  for (const Scene& scene : accurate_scenes::all()) {
    const auto times = accurate_scenes::equal_times(scene.t_end, parts);
    const Eigen::MatrixXd exact = accurate_scenes::columns(scene.exact(times));
    for (const double accuracy : {1e-3, 1e-6, 1e-9, 1e-12}) {
      const auto result = simulate_to_accuracy(scene.equations, start_of(scene), scene.t_end, Dop853{}, accuracy,
                                               {.output_times = times, .keep_trajectory = false});
      const double error = true_error(result.run.samples, exact);
      INFO(scene.name << ", accuracy " << accuracy << ": error " << error << ", estimate " << result.error_estimate);
      CHECK(error <= honest * result.error_estimate);
      CHECK(result.reached() == result.run.completed());
      if (result.reached()) {
        ++reached;
        if (result.trials.size() == 2) ++in_two_runs;
        CHECK(error <= accuracy);
      } else {
        CHECK(accuracy < 1e-9);
        CHECK(result.run.outcome == Outcome::accuracy_not_reached);
      }
    }
  }
  CHECK(reached >= 76);      // of 80; the others are amplified more than 12 digits allow
  CHECK(in_two_runs >= 54);  // of these: the third run is for motions that amplify more than most
}

TEST_CASE("a tolerance that double does not allow is not the end of the search") {
  constexpr double asked = 1e-12, lasts = 20;  // natural times
  detail::ToleranceSearch search(asked);
  const double first = search.next().value();
  search.ran({.tolerance = first}, {}, lasts);
  const double second = search.next().value();
  CHECK(second < first / 10);
  search.too_tight(second);
  const double third = search.next().value();
  CHECK(third == Approx(10 * second));
  CHECK(std::isinf(search.estimate()));
  search.ran({.tolerance = third, .difference = first}, {first}, lasts);  // κ = 1
  CHECK(search.estimate() >= third);
  CHECK(search.reached());
  CHECK_FALSE(search.next().has_value());
}

TEST_CASE("rounding is told from truncation by two runs that have nothing else") {
  constexpr double asked = 1e-12, amplification = 1e4, rounding = 1e-13;  // a planet, ten times round
  detail::ToleranceSearch search(asked);
  std::vector<double> tolerances;
  while (const auto tolerance = search.next()) {
    REQUIRE(tolerances.size() < 6);
    const auto error = [&](double each) { return each < 1e-14 ? rounding : amplification * each; };
    std::vector<double> differences;
    for (const double each : tolerances) differences.push_back(error(each));
    search.ran({.tolerance = *tolerance, .difference = differences.empty() ? 0.0 : differences.back()}, differences, 20);
    tolerances.push_back(*tolerance);
  }
  REQUIRE(tolerances.size() >= 3);
  CHECK(tolerances.back() < tolerances[tolerances.size() - 2]);
  CHECK(tolerances[tolerances.size() - 2] < 1e-14);
  constexpr double by_tolerance_alone = 8 * amplification * (3 * 2.2e-16 + 2.3e-15 / 16);  // one run says what is amplified
  CHECK(search.estimate() < by_tolerance_alone / 5);
  CHECK(search.estimate() >= 3 * rounding);
}

TEST_CASE("rounding that two runs show is believed, be it more than their tolerances foretell") {
  constexpr double shown = 1e-9;  // a stiff spring: rounding of its length is a large force
  detail::ToleranceSearch search(1e-12);
  search.ran({.tolerance = 1e-9}, {}, 20);
  search.ran({.tolerance = 6e-15, .difference = 1e-7}, {1e-7}, 20);
  search.ran({.tolerance = 2.3e-15, .difference = shown}, {1e-7, shown}, 20);
  CHECK(search.estimate() >= 2 * shown);
  CHECK_FALSE(search.reached());
}

// A request for the motion of f, which takes double and long double, must be kept, honestly and at no great cost.
template <class F>
void check_reached(const F& f, const std::vector<double>& start, double t_end, double accuracy, long dearest) {
  using accurate_scenes::Real;
  const auto times = accurate_scenes::equal_times(t_end, 40);
  const auto n = static_cast<Eigen::Index>(start.size());
  const auto exact = accurate_scenes::columns(
      accurate_scenes::extrapolated([&](Real t, const Real* y, Real* d) { f(t, y, d); }, start, times));
  const auto result = simulate_to_accuracy(equations(n, [&](double t, const double* y, double* d) { f(t, y, d); }),
                                           FirstOrderState{0.0, Eigen::Map<const Eigen::VectorXd>(start.data(), n)}, t_end, Dop853{}, accuracy,
                                           {.output_times = times, .keep_trajectory = false});
  const double error = true_error(result.run.samples, exact);
  INFO("accuracy " << accuracy << ": error " << error << ", estimate " << result.error_estimate << ", evaluations " << result.evaluations);
  REQUIRE(result.reached());
  CHECK(error <= accuracy);
  CHECK(error <= honest * result.error_estimate);
  CHECK(result.evaluations <= dearest);
}

TEST_CASE("components that begin at zero, or as rounding errors, do not make the start hard") {
  const double accuracy = GENERATE(1e-3, 9e-9, 1e-11);
  const auto pushed = [](auto t, const auto* y, auto* d) {  // hanging at rest; the push begins with nothing, too
    const auto c = std::cos(y[0] - y[1]), s = std::sin(y[0] - y[1]), push = std::sin(t);
    const auto f1 = -s * y[3] * y[3] - 2 * 9.81 * std::sin(y[0]) + push * push, f2 = s * y[2] * y[2] - 9.81 * std::sin(y[1]);
    d[0] = y[2], d[1] = y[3], d[2] = (f1 - c * f2) / (2 - c * c), d[3] = (2 * f2 - c * f1) / (2 - c * c);
  };
  check_reached(pushed, {0, 0, 0, 0}, 10, accuracy, 8'000);
  check_reached(pushed, {0, 1e-17, 0, 0}, 10, accuracy, 8'000);
  const auto fourth_powers = [](auto, const auto* y, auto* d) {  // V = ½ q₀² + (q₁ − q₀)⁴ + (q₂ − q₁)⁴
    const auto a = y[1] - y[0], b = y[2] - y[1];
    for (int i = 0; i < 3; ++i) d[i] = y[3 + i];
    d[3] = -y[0] + 4 * a * a * a, d[4] = 4 * (b * b * b - a * a * a), d[5] = -4 * b * b * b;
  };
  check_reached(fourth_powers, {1, 0, 0, 0, 0, 0}, 10, accuracy, 9'000);
  const auto chain = [](auto, const auto* y, auto* d) {
    for (int i = 0; i < 8; ++i) {
      d[i] = y[8 + i];
      d[8 + i] = i == 0 ? -y[0] : 100 * (y[i - 1] - y[i]);
      if (i < 7) d[8 + i] += 100 * (y[i + 1] - y[i]);
    }
  };
  check_reached(chain, {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 10, accuracy, 30'000);
}

TEST_CASE("near a pole of the coordinates, where rates are large for an instant, promises are kept") {
  // A spherical pendulum in angles, thrown past the lowest point by p/θ̇; exact: the point on its rod, which knows no pole.
  using accurate_scenes::Real;
  constexpr double theta = 0.3, p = 1e-4, t_end = 20, accuracy = 1e-9;
  const double turn = p / (std::sin(theta) * std::sin(theta));
  const auto times = accurate_scenes::equal_times(t_end, 50);
  const auto angles = equations(4, [](double, const double* y, double* d) {
    const double s = std::sin(y[0]), c = std::cos(y[0]);
    d[0] = y[2], d[1] = y[3], d[2] = s * (c * y[3] * y[3] - 9.81), d[3] = -2 * c / s * y[2] * y[3];
  });
  const auto result = simulate_to_accuracy(angles, FirstOrderState{0.0, Eigen::Vector4d(theta, 0, 0, turn)}, t_end, Dop853{}, accuracy,
                                           {.output_times = times, .keep_trajectory = false});
  REQUIRE(result.reached());
  const Real x0 = std::sin(Real(theta)), z0 = -std::cos(Real(theta)), v0 = x0 * turn;
  const auto rod = [&](Real, const Real* u, Real* d) {  // u: what is added to the start
    const Real r[] = {x0 + u[0], u[1], z0 + u[2]}, v[] = {u[3], v0 + u[4], u[5]}, g = 9.81;
    const Real tension = (g * r[2] - v[0] * v[0] - v[1] * v[1] - v[2] * v[2]) / (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    for (int i = 0; i < 3; ++i) d[i] = v[i], d[3 + i] = tension * r[i];
    d[5] -= g;
  };
  const auto exact = accurate_scenes::extrapolated(rod, {0, 0, 0, 0, 0, 0}, times);
  const double theta_size = theta, thetadot_size = std::sqrt(2 * 9.81 * (1 - std::cos(theta)));
  double error = 0, phi_size = 0, phi_error = 0;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const Real *u = exact[k].data(), x = x0 + u[0], rho = std::hypot(x, u[1]), full_turn = 2 * std::numbers::pi_v<Real>;
    const Eigen::Vector4d y = result.run.samples.y.col(static_cast<Eigen::Index>(k));
    const Real at = std::atan2(rho, -(z0 + u[2])), rate = -(z0 + u[2]) * (x * u[3] + u[1] * (v0 + u[4])) / rho + rho * u[5];
    Real phi = std::atan2(u[1], x);
    phi += full_turn * std::round((y[1] - phi) / full_turn);
    error = std::max({error, static_cast<double>(std::abs(y[0] - at)) / theta_size, static_cast<double>(std::abs(y[2] - rate)) / thetadot_size});
    phi_error = std::max(phi_error, static_cast<double>(std::abs(y[1] - phi)));
    phi_size = std::max(phi_size, std::abs(y[1]));
  }
  error = std::max(error, phi_error / phi_size);
  INFO("error " << error << ", estimate " << result.error_estimate << ", phi up to " << phi_size);
  CHECK(phi_size > 60);
  CHECK(error <= accuracy);
  CHECK(error <= honest * result.error_estimate);
}

TEST_CASE("what chaos makes of rounding is not called accurate") {
  // Forty seconds of a double pendulum amplify errors by some 1e17.
  const auto result = simulate_to_accuracy(equations(4, double_pendulum), FirstOrderState{0.0, Eigen::Vector4d(2.0, 2.5, 0.0, 0.0)},
                                           60.0, Dop853{}, 1e-6);
  CHECK(result.run.outcome == Outcome::accuracy_not_reached);
  CHECK(result.error_estimate > 1e-2);
  CHECK(result.run.t == 60.0);
  CHECK(result.run.message.find("accuracy_not_reached: the error of the whole motion must be at most 1e-06, but is estimated at") == 0);
  CHECK_FALSE(result.forecast[0].reachable);
}

TEST_CASE("a component that is zero but for rounding does not spoil the others") {
  // Three masses on springs, the middle one pulled from both sides alike: 0.1 and 0.2 make its force a rounding error.
  const auto springs = equations(6, [](double, const double* y, double* d) {
    for (int i = 0; i < 3; ++i) d[i] = y[3 + i];
    d[3] = -1.1 * y[0] + 0.1 * (y[1] - y[0]);
    d[4] = 0.1 * (y[0] - y[1]) + 0.1 * (y[2] - y[1]) - 0.3 * (y[0] + y[2]);
    d[5] = -1.1 * y[2] + 0.1 * (y[1] - y[2]);
  });
  Eigen::VectorXd y(6);
  y << 1.0 / 3, 0, -1.0 / 3, 0, 1e-17, 0;
  const auto result = simulate_to_accuracy(springs, FirstOrderState{0.0, y}, 20.0, Dop853{}, 1e-9);
  CHECK(result.reached());
  CHECK(std::abs(result.run.y[0] - std::cos(std::sqrt(1.2) * 20.0) / 3) < 1e-9);
}

TEST_CASE("impacts are compared on either side of them, and their times count") {
  constexpr double g = 9.81, restitution = 0.8;
  const auto ball = equations(2, [](double, const double* y, double* d) { d[0] = y[1], d[1] = -9.81; });
  // The step of a parabola is exact, so that only the impacts can err; air makes it an honest problem.
  const auto in_air = equations(2, [](double, const double* y, double* d) {
    d[0] = y[1], d[1] = -9.81 - 0.2 * y[1] * std::abs(y[1]);
  });
  const auto floor = event("floor", [](const auto& q) { return q[0]; }).falling().action([](double, Eigen::VectorXd& y) {
    y[0] = std::abs(y[0]);
    y[1] *= -restitution;
  });
  const FirstOrderState drop{0.0, Eigen::Vector2d(1.0, 0.0)};
  const auto exact = simulate_to_accuracy(ball, drop, 2.0, Dop853{}, 1e-9, {}, events(floor));
  REQUIRE(exact.reached());
  REQUIRE(exact.run.events.size() >= 2);
  const double first = std::sqrt(2 / g);
  CHECK(std::abs(exact.run.events[0].t - first) < 1e-9);
  CHECK(std::abs(exact.run.events[1].t - first * (1 + 2 * restitution)) < 1e-9);

  const auto result = simulate_to_accuracy(in_air, drop, 2.0, Dop853{}, 1e-7, {}, events(floor));
  const auto reference = simulate(in_air, drop, 2.0, Dop853{}, {.rtol = 1e-14, .atol = 1e-15}, events(floor));
  REQUIRE(result.reached());
  REQUIRE(result.run.events.size() == reference.events.size());
  double late = 0;
  for (std::size_t k = 0; k < reference.events.size(); ++k)
    late = std::max(late, std::abs(result.run.events[k].t - reference.events[k].t));
  constexpr double duration = 2.0;
  CHECK(late <= 1e-7 * duration);
  CHECK(late <= honest * result.error_estimate * duration);
  CHECK(result.event_time_error <= result.error_estimate * duration / 0.05);
}

TEST_CASE("a run that stops at an event is compared there") {
  const auto pendulum = equations(2, [](double, const double* y, double* d) { d[0] = y[1], d[1] = -9.81 * std::sin(y[0]); });
  const auto bottom = event("bottom", [](const auto& y) { return y[0]; }).falling().stop();
  const auto result = simulate_to_accuracy(pendulum, FirstOrderState{0.0, Eigen::Vector2d(2.5, 0.0)}, 5.0, Dop853{}, 1e-9, {}, events(bottom));
  CHECK(result.reached());
  CHECK(result.run.outcome == Outcome::stopped_by_event);
  CHECK(std::abs(result.run.t - 3.29593224651612 / 4) < 5e-9);  // a quarter of the period 4 √(l/g) K
}

TEST_CASE("a run that cannot go on says so, not that it is inaccurate") {
  const auto fall = equations(2, [](double, const double* y, double* d) { d[0] = y[1], d[1] = -1 / (y[0] * y[0]); });
  const auto result = simulate_to_accuracy(fall, FirstOrderState{0.0, Eigen::Vector2d(0.4, 0.0)}, 2.0, Dop853{}, 1e-6);
  CHECK_FALSE(result.reached());
  CHECK(failed(result.run.outcome));
  CHECK(result.run.outcome != Outcome::accuracy_not_reached);
  CHECK(std::abs(result.run.t - std::numbers::pi * std::sqrt(0.064 / 8)) < 1e-5);
}

TEST_CASE("limits hold for all runs together") {
  const auto result = simulate_to_accuracy(equations(4, double_pendulum), FirstOrderState{0.0, Eigen::Vector4d(1.7, 1.7, 0.0, 0.0)},
                                           10.0, Dop853{}, 1e-10, {.max_evaluations = 9000});
  CHECK_FALSE(result.reached());
  CHECK(result.evaluations < 9100);
  CHECK_THROWS_WITH(simulate_to_accuracy(equations(4, double_pendulum), FirstOrderState{0.0, Eigen::Vector4d::Zero()}, 1.0, Dop853{}, 0.0),
                    "the accuracy must lie between 0 and 1, but is 0; ask for the relative error of the whole motion, say 1e-6");
}

TEST_CASE("the forecast for three more digits is what they cost") {
  const auto scenes = accurate_scenes::all();
  for (const std::size_t i : {std::size_t{0}, std::size_t{2}, std::size_t{15}}) {
    const Scene& scene = scenes[i];
    INFO(scene.name);
    const auto work = [&](double accuracy) {
      return simulate_to_accuracy(scene.equations, start_of(scene), scene.t_end, Dop853{}, accuracy);
    };
    const auto now = work(1e-6), then = work(1e-9);
    CHECK(now.forecast[2].accuracy == Approx(1e-9));
    CHECK(now.forecast[2].reachable);
    const double factor = static_cast<double>(then.trials.back().work) / static_cast<double>(now.trials.back().work);
    CHECK(now.forecast[2].factor > factor / 2);  // both runs are a little better than asked, not equally so
    CHECK(now.forecast[2].factor < factor * 2);
    CHECK(now.forecast[0].factor > 1);
    CHECK(now.forecast[1].factor > now.forecast[0].factor);
  }
}

TEST_CASE("a trajectory that is kept is as accurate between the times at which it was compared") {
  const Scene scene = accurate_scenes::all()[0];
  const auto result = simulate_to_accuracy(scene.equations, start_of(scene), scene.t_end, Dop853{}, 1e-8);
  REQUIRE(result.reached());
  CHECK(result.run.samples.t.empty());
  const auto times = accurate_scenes::equal_times(scene.t_end, 333);
  const Eigen::MatrixXd exact = accurate_scenes::columns(scene.exact(times));
  Samples samples{times, Eigen::MatrixXd(2, static_cast<Eigen::Index>(times.size()))};
  for (std::size_t k = 0; k < times.size(); ++k) samples.y.col(static_cast<Eigen::Index>(k)) = result.run.trajectory.y(times[k]);
  CHECK(true_error(samples, exact) <= honest * result.error_estimate);
}

}  // namespace

TEST_CASE("a model that the first of several runs has left changed is refused") {
  double k = 1.0;
  const auto spring = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [&k](const auto& q) { return 0.5 * k * q[0] * q[0]; });
  const State<1> start{0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)};
  CHECK(simulate_to_accuracy(spring, start, 3.0, Dop853{}, 1e-8).run.completed());
  const auto stiffer = events(event("stiffer", [](const auto&, const auto&, const auto& t) { return t - 1.0; }).action([&k](State<1>&) { k = 4.0; }));
  CHECK_THROWS_AS(simulate_to_accuracy(spring, start, 3.0, Dop853{}, 1e-8, Options{}, stiffer), InvalidValue);
}
