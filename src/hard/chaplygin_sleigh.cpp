// SPDX-License-Identifier: MIT
//
// J. Neimark, N. Fufaev, Dynamics of Nonholonomic Systems. θ, v, ω in closed form, x and y computed with 34 digits.
#include "hard/motion.hpp"
#include "qdot/effects/constraints.hpp"

namespace qdot::hard {
namespace {

// (x, y): contact point of the blade, θ: heading; the centre of mass a ahead of it.
struct Sleigh {
  double m = 1.0, I = 0.5, a = 0.3;

  auto T(const auto& q, const auto& v) const {
    using std::cos, std::sin;
    const auto vx = v[0] - a * sin(q[2]) * v[2], vy = v[1] + a * cos(q[2]) * v[2];
    return 0.5 * m * (vx * vx + vy * vy) + 0.5 * I * v[2] * v[2];
  }
  auto V(const auto& q) const {
    using S = typename std::decay_t<decltype(q)>::Scalar;
    return S(0.0);
  }
};

std::vector<Row> rows() {
  const auto sleigh = scene(mechanical_system<3>(Sleigh{}).with_names({"x", "y", "theta"}),
                            nonholonomic("blade", [](const auto& q, const auto& v) {
                              using std::cos, std::sin;
                              return -v[0] * sin(q[2]) + v[1] * cos(q[2]);
                            }));
  const auto moving = motion(sleigh);
  struct End {
    double t, x, y, theta, v, omega;
  };
  std::vector<Row> rows;
  for (const End& end : {End{5, -1.497188892070253493282, 1.193593499340461349707, 3.300164258313045404067, 0.7378041677038451499586,
                             0.278144609745058850898},
                         End{20, -9.704239952744938891694, -6.599531439531005627820, 4.019764000439729383435, 0.7681143226613141161521,
                             0.0008102338547412688008056}}) {
    const Problem problem{.name = "Chaplygin sleigh, t = " + std::to_string(static_cast<int>(end.t)),
                          .t_end = end.t,
                          .start = numbers({0, 0, 0, 0, 0, 1}),
                          .exact = numbers({end.x, end.y, end.theta, end.v * std::cos(end.theta), end.v * std::sin(end.theta), end.omega}),
                          .reference_digits = 22,
                          .gain = 10};
    rows.push_back(solved(problem, moving, By::dop853, {.rtol = 2.5e-15, .atol = 1e-16}));
    rows.push_back(solved(problem, moving, By::dopri5, {.rtol = 2.5e-15, .atol = 2.5e-15}));
  }
  return rows;
}

}  // namespace

Case chaplygin_sleigh() {
  return {"chaplygin_sleigh", "Chaplygin sleigh",
          "A blade that cannot move sideways: a constraint on velocities that no constraint on positions can replace. Energy is "
          "conserved and yet the rotation dies out; a variational (vakonomic) treatment gives another motion.",
          rows};
}

}  // namespace qdot::hard
