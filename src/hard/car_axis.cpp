// SPDX-License-Identifier: MIT
//
// A car axis on a bumpy road: S. Schneider, thesis, Geneva 1994; Test Set for Initial Value Problem Solvers, problem caraxis. The
// end is computed with 34 digits; of the two that circulate one has λ₂ right to 7.1 digits.
#include "hard/motion.hpp"
#include "qdot/effects/constraints.hpp"

namespace qdot::hard {
namespace {

// Ends of the axis (xl, yl), (xr, yr) on springs; the right wheel follows the road.
struct CarAxis {
  double K = 10 * 0.01 * 0.01 / 2, g = 1.0, k = 1.0, L = 1.0, L0 = 0.5, r = 0.1, w = 10.0;

  auto road(const auto& t) const {
    using std::sin, std::sqrt;
    const auto yb = r * sin(w * t);
    return Vector<std::decay_t<decltype(yb)>, 2>(sqrt(L * L - yb * yb), yb);
  }
  auto T(const auto& v) const { return 0.5 * K * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3]); }
  auto V(const auto& q, const auto& t) const {
    using std::sqrt;
    const auto wheel = road(t);
    const auto x = q[2] - wheel[0], y = q[3] - wheel[1];
    const auto left = sqrt(q[0] * q[0] + q[1] * q[1]) - L0, right = sqrt(x * x + y * y) - L0;
    return 0.5 * k * (left * left + right * right) + K * g * (q[1] + q[3]);
  }
};

Motion axis() {
  const CarAxis data;
  const auto axis = scene(mechanical_system<4>(data).with_names({"xl", "yl", "xr", "yr"}),
                          holonomic("spring", [data](const auto& q, const auto& t) {
                            const auto wheel = data.road(t);
                            return q[0] * wheel[0] + q[1] * wheel[1];
                          }),
                          holonomic("axle", [data](const auto& q) {
                            const auto x = q[0] - q[2], y = q[1] - q[3];
                            return x * x + y * y - data.L * data.L;
                          }));
  return motion(axis, Energy::worked_upon);
}

Problem problem() {
  return {.name = "car axis",
          .t_end = 3.0,
          .start = numbers({0, 0.5, 1, 0.5, -0.5, 0, -0.5, 0}),
          .exact = numbers({0.0493455784275240921315268, 0.496989460230008106762934, 1.04174252488542611519478, 0.373911027265365819357898,
                            -0.0770583684035920842839406, 0.00744686659206841649140175, 0.0175568157535417366297406, 0.770341043779601063120643}),
          .reference_digits = 24,
          .gain = 49,
          .best_published = "deTestSet 9.2"};
}

std::vector<Row> rows() {
  const auto moving = axis();
  return {solved(problem(), moving, By::dop853, {.rtol = 2.5e-15, .atol = 1e-16}),
          solved(problem(), moving, By::dopri5, {.rtol = 2.5e-15, .atol = 2.5e-15})};
}

}  // namespace

Case car_axis() {
  return {"car_axis", "Car axis",
          "The inertia is tiny beside the springs, and one of the two constraints contains the time: the road moves the right "
          "wheel. IDA is unstable on it and DASKR stops at t = 0.072. Dropping the explicit time gives a plausible, wrong motion.",
          rows};
}

}  // namespace qdot::hard
