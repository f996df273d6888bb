// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "catch2_bridge.hpp"
#include "error_message.hpp"
#include "qdot/integrate/cvode_automatic.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/simulator.hpp"
#include "qdot/integrate/taylor.hpp"
#include "qdot/mechanics/kinematic_system.hpp"
#include "scenes/double_pendulum.hpp"

// Runs of small systems go behind virtual functions. The oracle is the run of the system's form, whose type is known to all that it goes through.

namespace {

using namespace qdot;

template <int n>
Eigen::VectorXd packed(const State<n>& start) {
  Eigen::VectorXd y(2 * n);
  y << start.q, start.qdot;
  return y;
}

template <class System, int n, class Method>
void check_bits(const System& system, const State<n>& start, double t_end, const Method& method, const Options& options) {
  const auto hidden = simulate(system, start, t_end, method, options);
  const auto known = simulate(first_order_form(system), FirstOrderState{start.t, packed(start)}, t_end, method, options);
  INFO(hidden.statistics.method << ", " << n << " coordinates: " << hidden.message);
  CHECK(hidden.completed());
  CHECK(hidden.t == known.t);
  CHECK(hidden.y == known.y);
  CHECK(hidden.samples.y == known.samples.y);
  CHECK(hidden.statistics.steps == known.statistics.steps);
  CHECK(hidden.statistics.evaluations == known.statistics.evaluations);
  CHECK(hidden.statistics.jacobians == known.statistics.jacobians);
  CHECK(hidden.statistics.method == known.statistics.method);
  CHECK(hidden.statistics.method_reason == known.statistics.method_reason);
}

template <class System, int n>
void check_all_methods(const System& system, const State<n>& start, double t_end) {
  const Options options{.rtol = 1e-8, .atol = 1e-10, .output_times = {t_end / 3}};
  check_bits(system, start, t_end, Dop853{}, options);
  check_bits(system, start, t_end, Dopri5{}, options);
  check_bits(system, start, t_end, Taylor{}, options);
  check_bits(system, start, t_end, CvodeBdf{}, options);
  check_bits(system, start, t_end, CvodeAdams{}, options);
  check_bits(system, start, t_end, Automatic{}, options);
}

// A mass on a spring, whose support moves with the time.
struct DrivenSpring {
  double k = 4.0;
  auto T(const auto& qdot) const { return 0.5 * qdot[0] * qdot[0]; }
  auto V(const auto& q, const auto& t) const {
    using std::sin;
    const auto stretch = q[0] - 0.1 * sin(3.0 * t);
    return 0.5 * k * stretch * stretch;
  }
};

// A ball on a soft floor: V has a branch.
struct SoftFloor {
  auto T(const auto&, const auto& qdot) const { return 0.5 * qdot[0] * qdot[0]; }
  auto V(const auto& q) const {
    using std::min;
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    const S below = min(q[0], S(0.0));
    return 9.81 * q[0] + 500.0 * below * below;
  }
};

// Masses in a row, each with a spring to the next.
struct Row {
  auto T(const auto&, const auto& qdot) const { return 0.5 * qdot.dot(qdot); }
  auto V(const auto& q) const {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    S sum = 0.5 * q[0] * q[0];
    for (Eigen::Index i = 1; i < q.size(); ++i) sum += 0.5 * (q[i] - q[i - 1]) * (q[i] - q[i - 1]) + 0.1 * q[i] * q[i] * q[i] * q[i];
    return sum;
  }
};

}  // namespace

TEST_CASE("runs behind virtual functions have the bits of runs of the form") {
  check_all_methods(mechanical_system<2>(scenes::DoublePendulum{}), State<2>{0.0, {1.7, 1.7}, {0.0, 0.0}}, 2.0);
  check_all_methods(mechanical_system<1>(DrivenSpring{}), State<1>{0.5, {1.0}, {0.0}}, 4.0);
  check_all_methods(mechanical_system<1>(SoftFloor{}), State<1>{0.0, {1.0}, {0.0}}, 2.0);
}

TEST_CASE("runs behind virtual functions have the bits of runs of the form up to eight coordinates, and beyond") {
  const Options options{.rtol = 1e-9, .atol = 1e-9};
  const auto check = [&]<int n>(const Vector<double, n>& q) {
    check_bits(mechanical_system<n>(Row{}), State<n>{0.0, q, Vector<double, n>(Vector<double, n>::Zero())}, 3.0, Dop853{}, options);
    check_bits(mechanical_system<n>(Row{}), State<n>{0.0, q, Vector<double, n>(Vector<double, n>::Zero())}, 3.0, CvodeBdf{}, options);
  };
  check(Vector<double, 3>(Vector<double, 3>::LinSpaced(0.1, 0.7)));
  check(Vector<double, 8>(Vector<double, 8>::LinSpaced(0.1, 0.7)));
  check(Vector<double, 9>(Vector<double, 9>::LinSpaced(0.1, 0.7)));
}

TEST_CASE("runs of positions behind virtual functions have the bits of runs of the form") {
  const auto place = [](const auto& q, auto& bodies) {
    using std::cos, std::sin;
    bodies.point_mass(1.0, vector(q[1] * sin(q[0]), -q[1] * cos(q[0])));
  };
  const auto spring = [](const auto& q) {
    using std::cos;
    return 20.0 * (q[1] - 1.0) * (q[1] - 1.0) - 9.81 * q[1] * cos(q[0]);
  };
  const auto system = kinematic_system<2>(place, spring);
  check_bits(system, State<2>{0.0, {0.5, 1.1}, {0.0, 0.2}}, 3.0, Dop853{}, {.rtol = 1e-10, .atol = 1e-10});
  check_bits(system, State<2>{0.0, {0.5, 1.1}, {0.0, 0.2}}, 3.0, CvodeBdf{}, {.rtol = 1e-8, .atol = 1e-8});
}

TEST_CASE("simulators behind virtual functions have the bits of simulators of the form") {
  const auto system = mechanical_system<2>(scenes::DoublePendulum{});
  const State<2> start{0.0, {1.7, 1.7}, {0.0, 0.0}};
  const auto upright = event("upright", [](const auto& q, const auto&, const auto&) { return q[0]; });
  const auto check = [&](const auto& method) {
    Simulator hidden(system, start, method, {}, upright), known(first_order_form(system), FirstOrderState{0.0, packed(start)}, method, {}, upright);
    std::size_t met = 0;
    for (int i = 1; i <= 20; ++i) {
      CHECK(hidden.advance_to(0.1 * i));
      CHECK(known.advance_to(0.1 * i));
      CHECK(hidden.y() == known.y());
      CHECK(hidden.events().size() == known.events().size());
      met += hidden.events().size();
    }
    CHECK(met > 0);
    CHECK(hidden.component_names() == known.component_names());
  };
  check(Dop853{});
  check(Taylor{});
  check(CvodeBdf{});
  CHECK_THROWS_AS(Simulator(system, State<2>{0.0, {std::nan(""), 0.0}, {0.0, 0.0}}, Dop853{}), InvalidValue);
}

TEST_CASE("each way to q̈ is the same behind virtual functions") {
  const auto system = mechanical_system<2>(scenes::DoublePendulum{});
  for (const By way : {By::duals, By::lines, By::machine_code}) {
    check_bits(system, State<2>{0.0, {1.7, 1.7}, {0.0, 0.0}}, 0.5, Dop853{}, {.rtol = 1e-8, .atol = 1e-8, .by = way});
    check_bits(system.by(way), State<2>{0.0, {1.7, 1.7}, {0.0, 0.0}}, 0.5, CvodeBdf{}, {.rtol = 1e-8, .atol = 1e-8});
  }
}

TEST_CASE("messages of a run behind virtual functions have the user's names") {
  const auto root = [](const auto&, const auto& qdot) { return 0.5 * qdot[0] * qdot[0]; };
  const auto V = [](const auto& q) {
    using std::sqrt;
    return sqrt(q[0]);
  };
  const auto system = mechanical_system<1>(root, V).with_names({"height"});
  const std::string message = error_message([&] { (void)simulate(system, State<1>{0.0, {-1.0}, {0.0}}, 1.0, Dop853{}); });
  CHECK(message.find("sqrt(x) has no value at x = -1") != std::string::npos);
  const auto run = simulate(system, State<1>{0.0, {1.0}, {-3.0}}, 1.0, Dop853{});
  CHECK_FALSE(run.completed());
  CHECK(run.message.find("height") != std::string::npos);
}

TEST_CASE("a start of the wrong size is refused behind virtual functions") {
  const auto system = mechanical_system<2>(scenes::DoublePendulum{});
  State<Dynamic> start{0.0, {1.0, 2.0, 3.0}, {0.0, 0.0, 0.0}};
  CHECK_THROWS_AS(simulate(system, start, 1.0, Dop853{}), DimensionError);
  CHECK_THROWS_AS(simulate(system, start, 1.0, CvodeBdf{}), DimensionError);
  const State<Dynamic> at_rest{0.0, {1.0, 2.0}, {}}, nowhere{0.0, {}, {}};
  CHECK(error_message([&] { (void)simulate(system, at_rest, 1.0, Dop853{}); }).find("qdot must have 2 entries, but has 0") != std::string::npos);
  CHECK_THROWS_AS(simulate(system, nowhere, 1.0, Dop853{}), DimensionError);
  CHECK_THROWS_AS(simulate(system, FirstOrderState{0.0, Eigen::VectorXd::Zero(3)}, 1.0, Dop853{}), DimensionError);
}

TEST_CASE("what a functor throws passes through a run behind virtual functions") {
  const auto T = [](const auto&, const auto& qdot) { return 0.5 * qdot[0] * qdot[0]; };
  const auto V = [](const auto& q) {
    if (q.size() > 0) throw std::runtime_error("no field here");
    return q[0];
  };
  CHECK_THROWS_AS(simulate(mechanical_system<1>(T, V), State<1>{0.0, {1.0}, {0.0}}, 1.0, Dop853{}), std::runtime_error);
}

TEST_CASE("functors that promise not to throw are not asked where they have no value") {
  const auto T = [](const auto& v) noexcept { return 0.5 * v[0] * v[0]; };
  const auto V = [](const auto& q) noexcept {
    using std::sqrt;
    return -3.0 * q[0] + 0.0 * sqrt(1.0 - q[0]);
  };
  const auto run = simulate(mechanical_system<1>(T, V), State<1>{0.0, {0.0}, {1.0}}, 5.0, Dop853{});
  CHECK(run.outcome == Outcome::non_finite);
}

TEST_CASE("T(qdot) is not differentiated with q behind virtual functions") {
  int calls = 0;  // of T, by dual numbers: one for M, none for the forces
  const auto T = [&calls](const auto& v) {
    ++calls;
    return 0.5 * v[0] * v[0];
  };
  const auto V = [](const auto& q) { return 0.5 * q[0] * q[0]; };
  const Options options{.rtol = 1e-9, .atol = 1e-9, .by = By::duals};
  const auto run = simulate(mechanical_system<1>(T, V), State<1>{0.0, {1.0}, {0.0}}, 10.0, Dop853{}, options);
  CHECK(run.completed());
  CHECK(calls < 1.2 * static_cast<double>(run.statistics.evaluations));  // and some looks
}

namespace {

// A method of one's own, made of another: with a stepper of its own.
struct Careful : Taylor {
  template <FirstOrderSystem F>
  auto stepper(const F& system, Options options) const {
    options.max_step = 0.01;
    return Taylor::stepper(system, options);
  }
};

}  // namespace

TEST_CASE("a method that is derived from another keeps its own stepper") {
  const auto system = mechanical_system<1>(DrivenSpring{});
  CHECK(simulate(system, State<1>{0.0, {1.0}, {0.0}}, 1.0, Careful{}).statistics.steps >= 100);
}
