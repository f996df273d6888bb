// SPDX-License-Identifier: MIT
//
// Scenes of fixed size, with constraints, friction and contacts that are watched at every step, allocate nothing as they go on.

#include <type_traits>

#include "catch2_bridge.hpp"
#include "count.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/event.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/simulator.hpp"

#if defined(QDOT_TEST_COUNTS_ALLOCATIONS)

namespace {

using namespace qdot;

// A damped pendulum in Cartesian coordinates above a floor that it does not reach.
const auto pendulum =
    scene(mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return 9.81 * q[1]; }),
          holonomic("rod", [](const auto& q) { return q.squaredNorm() - 1.0; }),
          rayleigh([](const auto&, const auto& v) { return 0.01 * v.squaredNorm(); }),
          contact("floor", [](const auto& q) { return q[1] + 1.5; }));
const State<2> start{0.0, Vector<double, 2>(0.6, -0.8), Vector<double, 2>(0.0, 0.0)};

// Allocations of a whole run, the trajectory left out; a function is watched besides that has no zero.
template <class Method>
long allocated_by(const Method& method, double t_end) {
  const auto watched = events(event("high", [](const auto& q) { return q[1] - 2.0; }));
  const long before = memory::allocations;
  const auto run = simulate(pendulum, start, t_end, method, {.rtol = 1e-8, .keep_trajectory = false}, watched);
  const long during = memory::allocations - before;
  REQUIRE(run.completed());
  REQUIRE(run.events.empty());
  return during;
}

}  // namespace

TEMPLATE_TEST_CASE("what a run on constraints with watched events allocates does not grow with its steps", "", Dop853, CvodeBdf) {
  // They do it once, after some hundred evaluations (ad/native/line_evaluator.ipp), of a Jacobian later.
  constexpr double while_lines_become_code = std::is_same_v<TestType, CvodeBdf> ? 320.0 : 80.0;
  const long once = allocated_by(TestType{}, while_lines_become_code);  // the first run may set up what stays
  (void)once;
  CHECK(allocated_by(TestType{}, 2.0 * while_lines_become_code) == allocated_by(TestType{}, while_lines_become_code));
}

// Advances of a simulator after the first few thousand: by then the watch over the model has looked as often as it ever keeps, and lines have become
// machine code.
template <class System, class Start>
long allocated_in_advances(const System& system, const Start& begin, bool ramps = false) {
  Simulator plant(system, begin, Dop853{}, {.rtol = 1e-8});
  constexpr int first = 10000;
  for (int k = 1; k <= first; ++k) REQUIRE(plant.advance_to(1e-3 * k));
  const long before = memory::allocations;
  bool completed = true;
  for (int k = first + 1; k <= first + 900; ++k) {
    if (!plant.input_names().empty()) {
      if (ramps) plant.ramp_input(0, -plant.q()[0], 1e-3 * (k + (k % 3 - 1) * 0.5));  // ends in this advance, with it, or in the next
      if (!ramps) plant.set_input(0, -plant.q()[0]);
    }
    completed = plant.advance_to(1e-3 * k) && completed;
  }
  const long during = memory::allocations - before;
  REQUIRE(completed);
  return during;
}

TEST_CASE("a simulator's advances allocate nothing, on constraints and with inputs") {
  const auto rod = holonomic("rod", [](const auto& q) { return q.squaredNorm() - 1.0; });
  const auto free = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return 9.81 * q[1]; });
  CHECK(allocated_in_advances(scene(free, rod), start) == 0);
  CHECK(allocated_in_advances(scene(free, input("wind", 0)), start) == 0);
  CHECK(allocated_in_advances(scene(free, interpolated(input("wind", 0))), start, true) == 0);
  CHECK(allocated_in_advances(free, start) == 0);
}

#endif
