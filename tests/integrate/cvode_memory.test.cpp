// SPDX-License-Identifier: MIT
//
// Steps and resets allocate nothing: every malloc of the program, CVODE's included, is counted.

#include <type_traits>

#include "catch2_bridge.hpp"
#include "first_order_systems.hpp"
#include "memory/count.hpp"
#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/cvode_automatic.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/symplectic.hpp"
#include "qdot/integrate/taylor.hpp"

#if defined(QDOT_TEST_COUNTS_ALLOCATIONS)

namespace {

using memory::allocations;

// The oscillator without std::function and strings, so that all allocations are the stepper's.
struct Plain {
  static constexpr int size_at_compile_time = 2;
  Eigen::Index size() const { return 2; }
  void derivative(double, const test::In& y, test::OutVector d) const {
    d[0] = y[1];
    d[1] = -y[0];
  }
  void jacobian(double, const test::In&, test::OutMatrix J) const { J << 0, 1, -1, 0; }
  std::string component_name(Eigen::Index i) const { return i == 0 ? "x" : "xdot"; }
};

}  // namespace

TEST_CASE("the counter of allocations sees those of CVODE") {
  const long before = allocations;
  const auto stepper = qdot::CvodeBdf{}.stepper(Plain{}, {});
  REQUIRE(allocations > before + 50);  // about 80 for the solver, its context, matrix and vectors
}

TEMPLATE_TEST_CASE("after its first step a stepper allocates nothing, resets and dense output included", "",
                   qdot::CvodeBdf, qdot::CvodeAdams, qdot::Dop853, qdot::Dopri5, qdot::Automatic, qdot::AnyMethod<Plain>) {
  const Eigen::VectorXd start = test::vector({1.0, 0.0});
  Eigen::VectorXd out(2);
  auto stepper = [] {
    if constexpr (std::is_same_v<TestType, qdot::AnyMethod<Plain>>) {
      return TestType(qdot::Dop853{}).stepper(Plain{}, {});
    } else {
      return TestType{}.stepper(Plain{}, {});
    }
  }();
  stepper.reset(0.0, start);
  stepper.step(1.0);
  const long before = allocations;
  for (int repetition = 0; repetition < 3; ++repetition) {
    const double t_end = repetition % 2 == 0 ? 20.0 : -20.0;
    stepper.reset(0.0, start);
    while (stepper.t() != t_end) {
      stepper.step(t_end);
      stepper.interpolate(0.5 * (stepper.t_previous() + stepper.t()), out);
    }
  }
  REQUIRE(allocations == before);
  REQUIRE(stepper.statistics().steps > 100);
}

TEST_CASE("nor does one that is made for T and V, whatever its order") {
  const auto oscillator = qdot::mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); },
                                                     [](const auto& q) { return 0.5 * q.squaredNorm(); });
  const auto form = qdot::first_order_form(oscillator);
  const Eigen::VectorXd start = test::vector({1.0, 0.0, 0.0, 0.5});
  Eigen::VectorXd out(4);
  const auto check = [&](auto stepper, const char* name) {
    INFO(name);
    stepper.reset(0.0, start);
    stepper.step(1.0);
    stepper.interpolate(0.5 * stepper.t(), out);
    const auto there_and_back = [&] {
      for (const double t_end : {20.0, -20.0}) {
        stepper.reset(0.0, start);
        while (stepper.t() != t_end) {
          stepper.step(t_end);
          stepper.interpolate(0.5 * (stepper.t_previous() + stepper.t()), out);
        }
      }
    };
    for (int k = 0; k < 12; ++k) there_and_back();  // by then lines are made, if they pay, and machine code (mechanics/derive/kept_rates.ipp)
    const long before = allocations;
    there_and_back();
    REQUIRE(allocations == before);
    REQUIRE(stepper.statistics().steps > 20);
  };
  check(qdot::Taylor{}.stepper(form, {}), "taylor");
  check(qdot::Automatic{}.stepper(form, {}), "auto");
  for (const int stages : {1, 2, 3, 4, 8}) check(qdot::Gauss{.step = 0.1, .stages = stages}.stepper(form, {}), "gauss");
  using enum qdot::SplittingScheme;
  for (const auto scheme : {verlet, yoshida_4, mclachlan_atela_4, blanes_moan_4, kahan_li_6, blanes_moan_6, kahan_li_8})
    check(qdot::Splitting{.step = 0.1, .scheme = scheme}.stepper(form, {}), "splitting");
}

TEST_CASE("what a run allocates does not grow with its steps") {
  const auto allocated_by = [](double t_end) {
    const long before = allocations;
    const auto run = qdot::simulate(Plain{}, qdot::FirstOrderState{0.0, test::vector({1.0, 0.0})}, t_end,
                                    qdot::CvodeBdf{}, {.keep_trajectory = false});
    REQUIRE(run.completed());
    return allocations - before;
  };
  REQUIRE(allocated_by(100.0) == allocated_by(1.0));
}

#endif
