// SPDX-License-Identifier: MIT
//
// A thin disk that rolls without slip: J. Neimark, N. Fufaev, Dynamics of Nonholonomic Systems. Upright rolling is stable if and
// only if v² > g r/3. The ends are computed with 34 digits.
#include "hard/rolling_disk.hpp"

#include "hard/motion.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/integrate/taylor.hpp"

namespace qdot::hard {
namespace {

std::vector<Row> rows() {
  const RollingDisk disk;
  const auto rolling = scene(mechanical_system<5>(disk).with_names({"x", "y", "phi", "delta", "psi"}),
                             nonholonomic("no slip", [r = disk.r](const auto& q, const auto& v) {
                               using std::cos, std::sin;
                               using S = std::decay_t<decltype(v[0] * cos(q[2]))>;
                               return Vector<S, 2>(v[0] - r * cos(q[2]) * v[4], v[1] - r * sin(q[2]) * v[4]);
                             }));
  const auto moving = motion(rolling);
  const double slow = std::sqrt(0.9 * disk.g * disk.r / 3), fast = std::sqrt(1.1 * disk.g * disk.r / 3);
  // At the threshold all entries but x and ψ are the lean of 1e-6 at the start, grown or not, and count by their own sizes.
  const Eigen::VectorXd tiny = numbers({6, 1e-3, 1e-3, 3e-4, 12, 1.2, 1e-3, 1e-3, 3e-4, 2.4});
  const Eigen::VectorXd small = numbers({6, 2e-5, 6e-6, 1e-6, 12, 1.2, 8e-6, 4e-6, 1e-6, 2.4});
  const Problem problems[] = {
      {.name = "rolling disk, leaning, t = 5", .t_end = 5, .start = numbers({0, 0, 0, 0.3, 0, 2, 0, 0, 0, 4}),
       .exact = numbers({1.564976258297926308317, -1.026105654577741747567, -7.778348011991305564045, 0.5301726201286485448758, 24.49093932683328613933,
                        0.2003451993337397188396, -2.643837847589164105670, -2.285568549275755025414, -0.8318953069846001470821, 5.302835755797450693869}),
       .reference_digits = 22, .gain = 10},
      {.name = "rolling disk, v^2 = 0.9 gr/3", .t_end = 5, .start = numbers({0, 0, 0, 0, 0, slow, 0, 0, 1e-6, slow / disk.r}),
       .exact = numbers({6.0652698852433719727, -0.00076758156025569240011, -0.00080903424651544795999, 0.00020968839834323619602, 12.130540085012015961,
                        1.2130537423874337384, -0.00098140223457633690881, -0.0010174534462864328738, 0.00026270719603320620922, 2.4261082787629281637}),
       .reference_digits = 19, .gain = 10, .scale = tiny},
      {.name = "rolling disk, v^2 = 1.1 gr/3", .t_end = 5, .start = numbers({0, 0, 0, 0, 0, fast, 0, 0, 1e-6, fast / disk.r}),
       .exact = numbers({6.70540826492216435, -0.0000229861765331373621, -6.16956356418096733e-10, -1.51657891060497233e-08, 13.4108165299621664,
                        1.34108165299507480, -8.27388850290999678e-10, 8.13542460932634171e-08, 9.99819478796300201e-07, 2.68216330599014959}),
       .reference_digits = 11, .gain = 10, .scale = small}};
  std::vector<Row> rows;
  for (const Problem& problem : problems) {
    const double atol = problem.scale.size() > 0 ? 1e-20 : 1e-15;
    rows.push_back(solved(problem, moving, By::dop853, {.rtol = 2.5e-15, .atol = atol}));
    rows.push_back(solved(problem, moving, rolling, Taylor{}, "taylor, 2.5e-15", {.rtol = 2.5e-15, .atol = atol}));
  }
  return rows;
}

}  // namespace

Case rolling_disk() {
  return {"rolling_disk", "Rolling disk",
          "Two velocity constraints and a sharp threshold. Upright rolling 5 % below the critical speed falls, 5 % above it "
          "sways; a damping method hides the growth, another fakes it. Lean and heading count by their own sizes, 1e-6 to 1e-3.",
          rows};
}

}  // namespace qdot::hard
