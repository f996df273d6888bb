// SPDX-License-Identifier: MIT
//
// Power series of a body that rolls and of a linkage.
#include <cmath>

#include "../catch2_bridge.hpp"
#include "projected_end.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/projecting_stepper.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/taylor.hpp"
#include "scenes/slider_crank.hpp"

namespace {

using namespace qdot;
using Eigen::Vector3d;

TEST_CASE("a sleigh that does not slip sideways goes straight in the end, as its closed form does") {
  static constexpr double m = 1.0, I = 0.3, a = 0.5, turn = 1.3;
  const auto sleigh = scene(mechanical_system<3>([](const auto& q, const auto& v) {
                              using std::cos, std::sin;
                              const auto x = v[0] - a * sin(q[2]) * v[2], y = v[1] + a * cos(q[2]) * v[2];
                              return 0.5 * m * (x * x + y * y) + 0.5 * I * v[2] * v[2];
                            }, [](const auto& q) { return 0.0 * q[0]; }),
                            nonholonomic("blade", [](const auto& q, const auto& v) {
                              using std::cos, std::sin;
                              return v[1] * cos(q[2]) - v[0] * sin(q[2]);
                            }));
  const double V = turn * std::sqrt((I + m * a * a) / m), kappa = m * a * V / (I + m * a * a);
  for (const double t : {4.0, -4.0}) {
    const Eigen::VectorXd y = end_of(sleigh, State<3>{0.0, Vector3d::Zero(), Vector3d(0.0, 0.0, turn)}, t);
    CHECK_THAT(y[5], WithinAbs(turn / std::cosh(kappa * t), rounding));
    CHECK_THAT(y[3] * std::cos(y[2]) + y[4] * std::sin(y[2]), WithinAbs(V * std::tanh(kappa * t), rounding));
    CHECK_THAT(y[2], WithinAbs(turn / kappa * std::atan(std::sinh(kappa * t)), rounding));
  }
}

auto linkage_of(const scenes::SliderCrank& crank) {
  return scene(mechanical_system<3>(crank), holonomic("loop", [r = crank.r, l = crank.l](const auto& q) {
                 using std::cos, std::sin;
                 return vector(r * cos(q[0]) + l * cos(q[1]) - q[2], r * sin(q[0]) - l * sin(q[1]));
               }));
}

TEST_CASE("a slider and its crank move as they do by Dop853, and as the crank's angle says") {
  const scenes::SliderCrank crank;
  const auto linkage = linkage_of(crank);
  const State<3> start = scenes::slider_crank().start(crank);
  const Eigen::VectorXd y = end_of(linkage, start, 1.0), other = end_of(linkage, start, 1.0, Dop853{});
  CHECK((y - other).norm() < 10 * rounding);  // after ten radians
  const double s = crank.r * std::sin(y[0]);
  CHECK_THAT(y[2], WithinAbs(crank.r * std::cos(y[0]) + std::sqrt(crank.l * crank.l - s * s), 1e-15));
}

TEST_CASE("steps leap over singular positions, where the linkage could fold, and stay on their branch") {
  const scenes::SliderCrank crank{.r = 0.5, .l = 0.5};  // folds where the crank stands upright
  const auto linkage = linkage_of(crank);
  const State<3> start = scenes::slider_crank().start(crank);
  const Eigen::VectorXd y = end_of(linkage, start, 1.0, Taylor{}, {.rtol = 1e-9, .atol = 1e-9});
  constexpr double on_branch = 1e-6;  // errors across a branch grow as one over the distance from where it leaves
  CHECK(y[0] > 3.0);  // it folds at π/2
  CHECK_THAT(y[1], WithinAbs(y[0], on_branch));
  CHECK_THAT(y[2], WithinAbs(2 * crank.r * std::cos(y[0]), on_branch));
  CHECK_THAT(energy(linkage, Vector3d(y.head(3)), Vector3d(y.tail(3))), WithinRel(energy(linkage, start.q, start.qdot), on_branch));
}

}  // namespace
