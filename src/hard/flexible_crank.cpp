// SPDX-License-Identifier: MIT
//
// A slider crank with an elastic rod: B. Simeon, Modelling a flexible slider crank mechanism by a mixed system of DAEs and PDEs
// (1996); Test Set for Initial Value Problem Solvers, problem crank (linear stiffness, no damping, no gravity). The published
// start is off its constraints by 2e-10 and their rates by 1.2e-8, and the published program's π is 3.1415927; this is the
// consistent start with π itself, its end computed with 34 digits.
#include <numbers>

#include "hard/motion.hpp"
#include "qdot/effects/constraints.hpp"

namespace qdot::hard {
namespace {

// φ₁: crank, φ₂: rod, x₃: slider; the rod bends by q₁ sin(πx/L) + q₂ sin(2πx/L), and stretches by q₃ in its middle, q₄ at its end.
struct FlexibleCrank {
  static constexpr double pi = std::numbers::pi;
  double M2 = 0.151104, M3 = 0.075552, L1 = 0.15, L2 = 0.3, J1 = 0.002727, J2 = 0.0045339259, E = 2e11, B = 0.008, H = 0.008;
  double omega = 150;

  auto T(const auto& q, const auto& v) const {
    using std::cos, std::sin;
    const auto c = cos(q[0] - q[1]), s = sin(q[0] - q[1]);
    const auto u = M2 * (2.0 * q[5] / 3.0 + q[6] / 6.0), w = M2 * 2.0 * q[3] / pi, xu = M2 * L2 * (q[5] / 3.0 + q[6] / 6.0);
    const auto square = [this](const auto& x) {
      return M2 * (0.5 * x[3] * x[3] + 0.5 * x[4] * x[4] + 8.0 * x[5] * x[5] + 2.0 * x[5] * x[6] + 2.0 * x[6] * x[6]);
    };
    const auto ud = M2 * (2.0 * v[5] / 3.0 + v[6] / 6.0), wd = M2 * 2.0 * v[3] / pi;
    const auto xwd = M2 * L2 * (v[3] / pi - v[4] / (2.0 * pi));
    const auto twist = M2 * (16.0 / (pi * pi * pi) * (q[5] * v[3] - q[3] * v[5]) +
                             (1.0 / pi - 8.0 / (pi * pi * pi)) * (q[6] * v[3] - q[3] * v[6]) -
                             1.0 / (2.0 * pi) * (q[6] * v[4] - q[4] * v[6]));
    return 0.5 * (J1 + M2 * L1 * L1) * v[0] * v[0] + 0.5 * (J2 + 2.0 * xu + square(q)) * v[1] * v[1] + 0.5 * M3 * v[2] * v[2] +
           0.5 * square(v) + L1 * v[0] * v[1] * (c * (M2 * L2 / 2.0 + u) + s * w) + L1 * v[0] * (c * wd - s * ud) + v[1] * (xwd + twist);
  }
  auto V(const auto& q) const {
    const double slender = H / L2 * (H / L2), p4 = pi * pi * pi * pi;
    return 0.5 * (E * B * H / L2) *
           (p4 / 24.0 * slender * q[3] * q[3] + 2.0 * p4 / 3.0 * slender * q[4] * q[4] + 16.0 / 3.0 * q[5] * q[5] -
            16.0 / 3.0 * q[5] * q[6] + 7.0 / 3.0 * q[6] * q[6]);
  }
};

std::vector<Row> rows() {
  const FlexibleCrank data;
  const auto crank = scene(mechanical_system<7>(data).with_names({"phi1", "phi2", "x3", "q1", "q2", "q3", "q4"}),
                           holonomic("slider", [data](const auto& q) {
                             using std::cos, std::sin;
                             using S = typename std::decay_t<decltype(q)>::Scalar;
                             return Vector<S, 2>(data.L1 * sin(q[0]) + (data.L2 + q[6]) * sin(q[1]),
                                                 q[2] - data.L1 * cos(q[0]) - (data.L2 + q[6]) * cos(q[1]));
                           }),
                           prescribed("drive", 0, [data](const auto& t) { return data.omega * t; }));
  const auto moving = motion(crank, Energy::worked_upon);
  const double q4 = 0.169327969e-4;
  const Eigen::VectorXd exact = numbers({15.000000000000000000, -0.33117349882569756443, 0.16973733263990973501, 0.00018931924676570696261,
                                  0.000023757514877702297059, -5.3238968073890997567e-06, -8.3633133378188136533e-06, 150.00000000000000000,
                                  60.253467551311740547, -8.7531163267211953647, -0.030055504881190430363, -0.0055004308826155556909,
                                  0.00049741113361509423982, 0.0011055599762732924120});
  const Problem problem{
      .name = "flexible slider crank",
      .t_end = 0.1,
      .start = numbers({0, 0, data.L1 + data.L2 + q4, 0, 0, 0.103339863e-4, q4,  //
                        data.omega, -data.L1 * data.omega / (data.L2 + q4), -0.268938672e-5, 0.444896105, 0.463434311e-2, -0.178591076e-5, -0.268938672e-5}),
      .exact = exact,
      .reference_digits = 18,
      .gain = 1e3,
      .best_published = "MEBDFI 7.9 (for its own start)",
      .scale = exact.cwiseAbs()};
  // Deflections are 1e-4 to 1e-6 m, their rates 1e-2 to 1e-4 m/s: absolute tolerances well below that.
  const auto atol = [](double rtol) { return AbsoluteTolerance(rtol * 1e-5); };
  return {solved(problem, moving, By::dop853, {.rtol = 1e-12, .atol = atol(1e-12), .max_wall_seconds = 15}),
          solved(problem, moving, By::dopri5, {.rtol = 1e-11, .atol = atol(1e-11), .max_wall_seconds = 15})};
}

}  // namespace

Case flexible_crank() {
  return {"flexible_crank", "Flexible slider crank",
          "Undamped elastic modes of up to 2.5e4 rad/s with deflections of 1e-6 to 1e-4 m ride on a crank that is driven at 150 "
          "rad/s. A stiff solver damps them away. Every coordinate counts by its own size, also those of 1e-6.",
          rows};
}

}  // namespace qdot::hard
