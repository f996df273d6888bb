// SPDX-License-Identifier: MIT
//
// Benchmark A01 of the library of computational benchmark problems for multibody dynamics (M. González et al.): a pendulum from
// the horizontal, 2000 s or 845 periods. θ(t) = −2 arcsin(k cd(√(g/L) t, k)), k = sin(π/4), evaluated with 19 digits; the
// benchmark's own file (ADAMS) has six.
#include <numbers>

#include "hard/motion.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/rattle.hpp"
#include "qdot/integrate/symplectic.hpp"
#include "qdot/integrate/taylor.hpp"

namespace qdot::hard {
namespace {

constexpr double g = 9.81;

struct Bob {
  auto T(const auto& v) const { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }
  auto V(const auto& q) const { return g * q[1]; }
};

struct Angle {
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const {
    using std::cos;
    return -g * cos(q[0]);
  }
};

std::vector<Row> rows() {
  // Relative gain, from the angle to itself: 3.7e3 of π/2 at the start.
  const Problem cartesian{.name = "A01 pendulum, 2000 s, Cartesian",
                          .t_end = 2000,
                          .start = numbers({-1, 0, 0, 0}),
                          .exact = numbers({0.81460306858903215212, -0.58001882783693546159, -1.9566477078826578702, -2.747999117430392282}),
                          .reference_digits = 19,
                          .gain = 5.8e3,
                          .best_published = "ADAMS 6"};
  const Problem angle{.name = "A01 pendulum, 2000 s, angle",
                      .t_end = 2000,
                      .start = numbers({-std::numbers::pi / 2, 0}),
                      .exact = numbers({0.95204452341568319727, -3.3734210235546753876}),
                      .reference_digits = 19,
                      .gain = 5.8e3,
                      .best_published = "ADAMS 6"};
  const auto held = scene(mechanical_system<2>(Bob{}).with_names({"x", "y"}),
                          holonomic("rod", [](const auto& q) { return 0.5 * (q[0] * q[0] + q[1] * q[1] - 1.0); }));
  const auto pendulum = mechanical_system<1>(Angle{});
  const auto moving = motion(held);
  const auto turning = motion(pendulum);
  return {solved(cartesian, moving, By::dop853, {.rtol = 2.5e-15, .atol = 2.5e-15}),
          solved(cartesian, moving, held, Rattle{.step = 0.01, .order = 8}, "rattle8, h = 0.01", {}),
          solved(angle, turning, By::dop853, {.rtol = 2.5e-15, .atol = 1e-16}),
          solved(angle, turning, pendulum, Taylor{}, "taylor, 2.5e-15", {.rtol = 2.5e-15, .atol = 1e-16}),
          solved(angle, turning, pendulum, Splitting{.step = 0.02, .scheme = SplittingScheme::kahan_li_8}, "kahan_li_8, h = 0.02", {}),
          limited(solved(angle, turning, pendulum, Gauss{.step = 0.05, .stages = 6}, "gauss, 6 stages, h = 0.05", {}),
                  "rounding: its energy goes one way, by 3e-13 in 2000 s, with steps of 0.05 and 0.1 alike")};
}

}  // namespace

Case long_pendulum() {
  return {"long_pendulum", "Pendulum over 2000 s (A01)",
          "845 periods, in Cartesian coordinates with a constraint: energy that the projection feeds or takes shows as phase. The "
          "benchmark allows 1e-3; errors of phase grow 3700 times.",
          rows};
}

}  // namespace qdot::hard
