// SPDX-License-Identifier: MIT
//
// Power series where rows of constraints depend on each other, or coordinates have no mass.
#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>

#include "../catch2_bridge.hpp"
#include "projected_end.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/taylor.hpp"

namespace {

using namespace qdot;
using Eigen::Vector2d;

constexpr double g = 9.81;

// A pendulum whose rod is given twice, as φ and as 3φ + b tᵏ.
struct Twice {
  double b = 0.0;
  int k = 0;

  template <class S>
  Vector<S, 2> operator()(const Vector<S, 2>& q, const S& t) const {
    const S phi = q[0] * q[0] + q[1] * q[1] - 1.0;
    S more(b);
    for (int i = 0; i < k; ++i) more *= t;
    return {phi, 3.0 * phi + more};
  }
};
auto held_by(Twice rods) {
  return scene(mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return g * q[1]; }),
               holonomic("rods", rods));
}
const State<2> released{0.0, Vector2d(std::sin(1.0), -std::cos(1.0)), Vector2d(0.0, 0.0)};

TEST_CASE("a redundant constraint changes nothing but the split of the force, which is equal") {
  const double angle = -0.46325276873178667;  // after 10 s from 1 rad at rest, from an integration in quadruple precision
  const Eigen::VectorXd y = end_of(held_by({}), released, 10.0);
  CHECK_THAT(y[0], WithinAbs(std::sin(angle), rounding));
  CHECK_THAT(y[1], WithinAbs(-std::cos(angle), rounding));

  const auto form = first_order_form(held_by({}));
  const auto made = detail::PowerSeriesOf<std::remove_cvref_t<decltype(form)>>::made(form, 3);
  detail::PowerSeries& series = *made;
  series.start(0.0, Eigen::Vector4d(0.6, -0.8, 1.6, 1.2).eval().data(), 1.0);
  series.expand(3);
  // One rod has 2λ = g y − v² and λ̇ = 3/2 g ẏ. That is λ₁ + 3 λ₂, of which each row takes half: rows count as if equally long.
  const double lambda = 0.5 * (-0.8 * g - 4.0), rate = 1.5 * g * 1.2;
  CHECK((series.constraints()->multipliers().col(0) - lambda * Vector2d(1.0 / 2, 1.0 / 6)).norm() < 1e-13);
  CHECK((series.constraints()->multipliers().col(1) - rate * Vector2d(1.0 / 2, 1.0 / 6)).norm() < 1e-13);
}

TEST_CASE("rows that contradict each other are named at the start, or end the run where they begin to") {
  const auto at_once = first_order_form(held_by({0.5, 2}));
  auto stepper = Taylor{}.stepper(at_once, tight);
  CHECK_THROWS_AS(stepper.reset(0.0, at_once.packed(released)), ConstraintError);
  const auto later = first_order_form(held_by({0.5, 3}));
  auto other = Taylor{}.stepper(later, tight);
  other.reset(0.0, later.packed(released));
  while (other.t() < 0.1 && other.step(0.1)) {
  }
  INFO("t = " << other.t() << ": " << other.failure().message);
  CHECK(other.t() < 1e-3);
  CHECK(other.failure().outcome == Outcome::constraint_failure);
}

TEST_CASE("a coordinate without mass that a constraint determines takes part, beside damping") {
  // s = x²/2 carries the potential ω² s: x is a damped oscillator.
  static constexpr double omega = 1.7, gamma = 0.1;
  const auto wire = scene(mechanical_system<2>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return omega * omega * q[1]; }),
                          holonomic("wire", [](const auto& q) { return q[1] - 0.5 * q[0] * q[0]; }),
                          viscous_damping(Vector2d(2 * gamma, 0.0)));
  const double t = 5.0, w = std::sqrt(omega * omega - gamma * gamma);
  const Eigen::VectorXd y = end_of(wire, State<2>{0.0, Vector2d(1.0, 0.5), Vector2d(0.0, 0.0)}, t);
  const double x = std::exp(-gamma * t) * (std::cos(w * t) + gamma / w * std::sin(w * t));
  CHECK_THAT(y[0], WithinAbs(x, rounding));
  CHECK_THAT(y[1], WithinAbs(0.5 * x * x, rounding));
}

TEST_CASE("a parallelogram passes the position in which it could fold, or the run ends there by name") {
  // Two cranks and a coupler of length 1, given by the cranks' ends. Level, all three are in line and only two of three rows independent.
  const auto linkage = scene(mechanical_system<4>([](const auto& v) { return 0.5 * v.squaredNorm(); },
                                                  [](const auto& q) { return g * (q[1] + q[3]); }),
                             holonomic("rod", [](const auto& q) {
                               const auto x = q[2] - q[0], y = q[3] - q[1], far = q[2] - 1.0;
                               return vector(q[0] * q[0] + q[1] * q[1] - 1.0, far * far + q[3] * q[3] - 1.0, x * x + y * y - 1.0);
                             }));
  const State<4> upright{0.0, Vector<double, 4>(0.0, 1.0, 1.0, 1.0), Vector<double, 4>(1.0, 0.0, 1.0, 0.0)};
  const auto form = first_order_form(linkage);
  for (const double tol : {1e-6, 1e-9, 1e-13}) {
    auto stepper = Taylor{}.stepper(form, {.rtol = tol, .atol = tol});
    stepper.reset(0.0, form.packed(upright));
    while (stepper.t() != 2.0 && stepper.step(2.0)) {
    }
    INFO("tolerance " << tol << " to t = " << stepper.t() << ": " << stepper.failure().message);
    const Eigen::VectorXd y = stepper.y();
    const double kept = std::max(1e-6, 1e3 * tol);  // of the branch; what is off it grows beside the position
    CHECK_THAT(y[2] - y[0], WithinAbs(1.0, kept));
    CHECK_THAT(y[3] - y[1], WithinAbs(0.0, kept));
    CHECK_THAT(0.5 * y.tail(4).squaredNorm() + g * (y[1] + y[3]), WithinAbs(1.0 + 2 * g, 10 * kept));
    if (stepper.t() == 2.0) continue;
    CHECK(stepper.failure().outcome == Outcome::constraint_failure);
    CHECK(stepper.failure().message.find("as in a singular position") != std::string::npos);
  }
}

}  // namespace
