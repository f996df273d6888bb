// SPDX-License-Identifier: MIT
//
// Taylor, Gauss and Rattle step scenes of fixed size without allocating, resets and dense output included.

#include "catch2_bridge.hpp"
#include "count.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/rattle.hpp"
#include "qdot/integrate/taylor.hpp"

#if defined(QDOT_TEST_COUNTS_ALLOCATIONS)

namespace {

using namespace qdot;

template <class Form, class Stepper>
void check(const Form& form, const State<2>& start, Stepper stepper) {
  const Eigen::VectorXd y = form.packed(start);
  Eigen::VectorXd out(y.size());
  stepper.reset(0.0, y);
  stepper.step(1.0);
  stepper.interpolate(0.5 * stepper.t(), out);
  const auto there_and_back = [&] {
    for (const double t_end : {4.0, -0.5}) {  // backward the drag makes speeds infinite before t = −1.5
      stepper.reset(0.0, y);
      while (stepper.t() != t_end) {
        REQUIRE(stepper.step(t_end));
        stepper.interpolate(0.5 * (stepper.t_previous() + stepper.t()), out);
      }
    }
  };
  for (long k = 0; k < formula::LineEvaluator::begin_after; ++k) form.derivative(0.0, y, out);  // lines become machine code (ad/native/line_evaluator.ipp)
  for (int k = 0; k < 6; ++k) there_and_back();
  const long before = memory::allocations;
  there_and_back();
  CHECK(memory::allocations == before);
  CHECK(stepper.statistics().steps > 8);
}

const auto particle = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return 9.81 * q[1] + 0.5 * q[0] * q[0]; });
const State<2> start{0.0, Vector<double, 2>(0.6, -0.8), Vector<double, 2>(0.4, 0.3)};

}  // namespace

TEST_CASE("on forces with states of their own Taylor and Gauss allocate nothing") {
  const auto form = first_order_form(scene(particle, viscous_damping(Vector<double, 2>(0.1, 0.2)), quadratic_drag([](const auto& q) { return q; }, 0.1),
                                           controller([](const auto& q, const auto&, const auto& z, const auto&) { return vector(z[0], 0.0 * q[1]); },
                                                      [](const auto& q, const auto&, const auto& z, const auto&) { return vector(-q[0] - z[0]); },
                                                      Vector<double, 1>(0.5))));
  check(form, start, Taylor{}.stepper(form, {}));
  check(form, start, Gauss{.step = 0.05, .stages = 3}.stepper(form, {}));
}

TEST_CASE("on constraints Rattle, Gauss and Taylor allocate nothing") {
  const auto form = first_order_form(scene(particle, holonomic("rod", [](const auto& q) { return q.squaredNorm() - 1.0; })));
  check(form, start, Rattle{.step = 0.05, .order = 4}.stepper(form, {}));
  check(form, start, Gauss{.step = 0.05, .stages = 2}.stepper(form, {}));
  check(form, start, Taylor{}.stepper(form, {}));
}

#endif
