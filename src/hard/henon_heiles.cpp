// SPDX-License-Identifier: MIT
//
// M. Hénon, C. Heiles, The applicability of the third integral of motion, Astronomical Journal 69 (1964). The ends are computed
// with 34 digits.
#include "hard/motion.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/symplectic.hpp"
#include "qdot/integrate/taylor.hpp"

namespace qdot::hard {
namespace {

struct HenonHeiles {
  auto T(const auto& v) const { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }
  auto V(const auto& q) const {
    return 0.5 * (q[0] * q[0] + q[1] * q[1]) + q[0] * q[0] * q[1] - q[1] * q[1] * q[1] / 3.0;
  }
};

std::vector<Row> rows() {
  const auto star = mechanical_system<2>(HenonHeiles{});
  const auto moving = motion(star);
  const Eigen::VectorXd start = numbers({0.1, 0.0, 0.0, 0.5}), scale = Eigen::VectorXd::Constant(4, 0.5);
  const Problem problems[] = {
      {.name = "Hénon–Heiles, t = 100", .t_end = 100, .start = start,
       .exact = numbers({-0.04019423787606881679440, 0.6790169217720216421347, 0.03845092895185983450203, 0.04859483155300364224311}),
       .reference_digits = 22, .gain = 22, .scale = scale},
      {.name = "Hénon–Heiles, t = 1000", .t_end = 1000, .start = start,
       .exact = numbers({-0.02086965494729550759515, -0.3816308413466973386429, 0.05684673704038535149340, 0.2719722325678037368140}),
       .reference_digits = 20, .gain = 640, .scale = scale},
      {.name = "Hénon–Heiles, t = 10000", .t_end = 10000, .start = start,
       .exact = numbers({0.01864524495754428017077, -0.1656765459141336545866, 0.05332505845391211495516, -0.4758608296934925988538}),
       .reference_digits = 18, .gain = 6300, .scale = scale}};
  std::vector<Row> rows;
  for (const Problem& problem : problems) {
    rows.push_back(solved(problem, moving, star, Taylor{}, "taylor, 2.5e-15, h ≤ 0.05", {.rtol = 2.5e-15, .atol = 1e-17, .max_step = 0.05}));
    rows.push_back(solved(problem, moving, star, Splitting{.step = 0.05, .scheme = SplittingScheme::kahan_li_8}, "kahan_li_8, h = 0.05", {}));
    rows.push_back(solved(problem, moving, star, Dop853{}, "dop853, 2.5e-15, h ≤ 0.03", {.rtol = 2.5e-15, .atol = 1e-15, .max_step = 0.03}));
  }
  return rows;
}

}  // namespace

Case henon_heiles() {
  return {"henon_heiles", "Hénon–Heiles",
          "A star in a galaxy, 1600 turns by t = 10⁴. Nothing but energy plots is published; the reference has 18 to 22 digits. "
          "What counts is bias: an error of the energy of one sign becomes an error of phase that grows like t². Steps are held "
          "short: at 2.5e-15 alone Dop853 takes 0.042 and reaches 10.3 digits at t = 10⁴, Taylor takes 0.29 and reaches 10.7.",
          rows};
}

}  // namespace qdot::hard
