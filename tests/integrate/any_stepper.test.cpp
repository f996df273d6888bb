// SPDX-License-Identifier: MIT
#include <cmath>
#include <map>
#include <string>
#include <type_traits>
#include <utility>

#include "catch2_bridge.hpp"
#include "first_order_systems.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/symplectic.hpp"
#include "qdot/integrate/taylor.hpp"
#include "scenes/cartesian_pendulum.hpp"
#include "scenes/kepler.hpp"

namespace {

using namespace qdot;

const auto kepler = mechanical_system<2>(scenes::Kepler{});
const State<2> ellipse{0.0, {0.4, 0.0}, {0.0, 2.0}};

template <class Method>
void check_same(const Method& method) {
  const Options options{.rtol = 1e-9, .atol = 1e-9, .output_times = {1.0, 2.5}};
  const auto plain = simulate(kepler, ellipse, 3.0, method, options);
  const auto hidden = simulate(kepler, ellipse, 3.0, AnyMethod<decltype(kepler)>(method), options);
  CHECK(hidden.completed());
  CHECK(hidden.y == plain.y);
  CHECK(hidden.samples.y == plain.samples.y);
  CHECK(hidden.trajectory.y(1.7) == plain.trajectory.y(1.7));
  CHECK(hidden.statistics.steps == plain.statistics.steps);
  CHECK(hidden.statistics.evaluations == plain.statistics.evaluations);
  CHECK(hidden.statistics.method == plain.statistics.method);
}

}  // namespace

TEST_CASE("a method behind a name makes the same run, to the last bit") {
  check_same(Taylor{});
  check_same(Dop853{});
  check_same(CvodeBdf{});
  check_same(Gauss{.step = 0.05});
  check_same(Splitting{.step = 0.05});
}

TEST_CASE("methods of different types stand in one map") {
  const std::map<std::string, AnyMethod<decltype(kepler)>> methods = {{"taylor", Taylor{}}, {"dopri5", Dopri5{}}};
  for (const auto& [name, method] : methods) CHECK(simulate(kepler, ellipse, 1.0, method).statistics.method == name);
}

TEST_CASE("a stepper moves with all that it knows") {
  AnyStepper stepper = any_stepper(Dop853{}, test::oscillator(), {});
  stepper.reset(0.0, test::vector({1, 0}));
  REQUIRE(stepper.step(10.0));
  const double t = stepper.t();
  AnyStepper moved = std::move(stepper);
  CHECK(moved.t() == t);
  REQUIRE(moved.step(10.0));
  CHECK(moved.t_previous() == t);
  CHECK_THAT(moved.y()[0], WithinAbs(std::cos(moved.t()), 1e-8));
}

TEST_CASE("constraints are kept, whoever projects") {
  const scenes::CartesianPendulum rod;
  const auto rigid = scene(mechanical_system<2>(rod), holonomic("rod", [l = rod.l](const auto& q) { return 0.5 * (q[0] * q[0] + q[1] * q[1] - l * l); }));
  const State<2> start{0.0, {rod.l, 0.0}, {0.0, 0.0}};
  const Options options{.rtol = 1e-8, .atol = 1e-8};
  const auto check = [&](const auto& method) {
    const auto plain = simulate(rigid, start, 2.0, method, options);
    using Scene = std::remove_cvref_t<decltype(rigid)>;
    const auto hidden = simulate(rigid, start, 2.0, AnyMethod<Scene>(method), options);
    CHECK(hidden.completed());
    CHECK(hidden.y == plain.y);
    CHECK(hidden.statistics.projections == plain.statistics.projections);
    CHECK(hidden.statistics.projections > 0);
    CHECK(hidden.statistics.constraint_residual < 1e-9);
    CHECK(hidden.trajectory.y(1.3) == plain.trajectory.y(1.3));
  };
  check(Dop853{});
  check(CvodeBdf{});
}
