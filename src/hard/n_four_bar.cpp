// SPDX-License-Identifier: MIT
//
// Benchmark A02 (IFToMM): two four-bar loops in a row, all rods of length 1. The motion is that of one angle from the vertical,
// 3 p̈ = 3.5 g sin p, computed with 34 digits.
#include "hard/motion.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/integrate/taylor.hpp"

namespace qdot::hard {
namespace {

constexpr double g = 9.81;

// Tips (x₀, y₀), (x₁, y₁), (x₂, y₂) of three cranks on the ground at x = 0, 1, 2, joined by two couplers. Uniform rods: with
// ends P and Q, T = (|Ṗ|² + Ṗ·Q̇ + |Q̇|²)/6.
struct FiveRods {
  auto T(const auto& v) const {
    const auto dot = [&](int i, int j) { return v[2 * i] * v[2 * j] + v[2 * i + 1] * v[2 * j + 1]; };
    return (2.0 * dot(0, 0) + 3.0 * dot(1, 1) + 2.0 * dot(2, 2) + dot(0, 1) + dot(1, 2)) / 6.0;
  }
  auto V(const auto& q) const { return g * (q[1] + 1.5 * q[3] + q[5]); }
};

struct OneAngle {
  auto T(const auto& v) const { return 1.5 * v[0] * v[0]; }
  auto V(const auto& q) const {
    using std::cos;
    return 3.5 * g * cos(q[0]);
  }
};

std::vector<Row> rows() {
  const auto rods = scene(mechanical_system<6>(FiveRods{}).with_names({"x0", "y0", "x1", "y1", "x2", "y2"}),
                          holonomic("rod", [](const auto& q) {
                            using S = typename std::decay_t<decltype(q)>::Scalar;
                            const auto length = [](const S& x, const S& y) { return S(0.5 * (x * x + y * y - 1.0)); };
                            Vector<S, 5> phi;
                            phi << length(q[0], q[1]), length(q[2] - 1.0, q[3]), length(q[4] - 2.0, q[5]), length(q[2] - q[0], q[3] - q[1]),
                                length(q[4] - q[2], q[5] - q[3]);
                            return phi;
                          }));
  const auto moving = motion(rods);
  const double x = 0.3284581115408153786522, y = 0.9445185381786009621613, vx = 1.423051470206944123281, vy = -0.4948688454870429589909;
  const Problem singular{.name = "A02 four-bar, N = 2, 10 s",
                         .t_end = 10,
                         .start = numbers({0, 1, 1, 1, 2, 1, 1, 0, 1, 0, 1, 0}),
                         .exact = numbers({x, y, 1 + x, y, 2 + x, y, vx, vy, vx, vy, vx, vy}),
                         .reference_digits = 22,
                         .gain = 40 / default_rank_cutoff,  // in line, what lies below the cut-off is undecided
                         .best_published = "EXUDYN 5.6"};
  const Problem closed{.name = "A02 four-bar, N = 2, 10 s, one angle",
                       .t_end = 10,
                       .start = numbers({0, 1}),
                       .exact = numbers({x, y, vx, vy}),
                       .reference_digits = 22,
                       .gain = 40,
                       .best_published = "EXUDYN 5.6",
                       .seen = [](const State_& s) {
                         return numbers({std::sin(s[0]), std::cos(s[0]), std::cos(s[0]) * s[1], -std::sin(s[0]) * s[1]});
                       }};
  const auto angle = mechanical_system<1>(OneAngle{});
  const auto turning = motion(angle);
  return {solved(singular, moving, By::dop853, {.rtol = 1e-12, .atol = 1e-12, .max_wall_seconds = 6}),
          solved(singular, moving, By::dopri5, {.rtol = 1e-11, .atol = 1e-11, .max_wall_seconds = 6}),
          solved(closed, turning, By::dop853, {.rtol = 2.5e-15, .atol = 1e-16}),
          solved(closed, turning, angle, Taylor{}, "taylor, 2.5e-15", {.rtol = 2.5e-15, .atol = 1e-16})};
}

}  // namespace

Case n_four_bar() {
  return {"n_four_bar", "N-four-bar through its singular positions (A02)",
          "When the cranks lie level all five rods are in line: the constraints lose rank, the multipliers are undefined, and the "
          "mechanism could fold. It passes there twice a turn. A rank cut-off of 1e-3 costs four digits, one of 1e-7 leaves the "
          "branch with every residual small.",
          rows};
}

}  // namespace qdot::hard
