// SPDX-License-Identifier: MIT
//
// A flyball governor with stiff spring-dampers, benchmark A05 of the library of computational benchmark problems for multibody
// dynamics. The end is computed with 34 digits; EXUDYN agrees to 4e-11 after Richardson's extrapolation.
#include <numbers>

#include "hard/motion.hpp"
#include "qdot/effects/dissipation.hpp"

namespace qdot::hard {
namespace {

// α: shaft, s: height of the slider, b₁, b₂: rods below the horizontal, hinged at distance a from the shaft at height h.
struct Governor {
  double g = 9.81, a = 0.05, h = 1.0, m = 0.3, mp = 5.0, ms = 3.0;
  double shaft = 0.3 * 2e-4 / 12, slider = 3 * 0.02 / 12, along = 0.3 * 2e-4 / 12, across = 0.3 * (1 + 1e-4) / 12;

  auto T(const auto& q, const auto& v) const {
    using std::cos, std::sin;
    const auto inertia = [this](const auto& b) {  // of a rod and its ball about the shaft
      const auto c = cos(b), s = sin(b), middle = a + 0.5 * c, end = a + c;
      return m * middle * middle + along * s * s + across * c * c + mp * end * end;
    };
    return 0.5 * (shaft + slider + inertia(q[2]) + inertia(q[3])) * v[0] * v[0] + 0.5 * ms * v[1] * v[1] +
           0.5 * (m / 4 + across + mp) * (v[2] * v[2] + v[3] * v[3]);
  }
  auto V(const auto& q) const {
    using std::sin;
    return ms * g * q[1] - (0.5 * m + mp) * g * (sin(q[2]) + sin(q[3]));
  }
};

std::vector<Row> rows() {
  const Governor data;
  // In the turning plane of a rod: its middle, and the spring's foot on the slider.
  const auto middle = [=](Eigen::Index rod) {
    return [=](const auto& q) {
      using std::cos, std::sin;
      using S = typename std::decay_t<decltype(q)>::Scalar;
      return Vector<S, 2>(data.a + 0.5 * cos(q[rod]), data.h - 0.5 * sin(q[rod]));
    };
  };
  const auto foot = [=](const auto& q) {
    using S = typename std::decay_t<decltype(q)>::Scalar;
    return Vector<S, 2>(S(data.a), q[1]);
  };
  const double K = 8e5, C = 4e4, rest = 0.5;
  const auto governor = scene(mechanical_system<4>(data).with_names({"alpha", "s", "b1", "b2"}), spring_damper(middle(2), foot, K, rest, C),
                              spring_damper(middle(3), foot, K, rest, C));
  const auto moving = motion(governor, Energy::worked_upon);
  const double b = 0.39007370184644508054, bdot = 0.80846705134557740027, pi = std::numbers::pi;
  const Eigen::VectorXd exact = numbers({55.935409909102378768, 0.61962291706136565882, b, b, 5.5482036226549265825, -0.74760335416433246769, bdot, bdot});
  const Problem problem{.name = "A05 flyball governor, 10 s",
                        .t_end = 10,
                        .start = numbers({0, 0.5, pi / 6, pi / 6, 2 * pi, 0, 0, 0}),
                        .exact = exact,
                        .reference_digits = 19,
                        .gain = 4e3,  // the springs' force is K times a difference of lengths: rounding these is K l₀ ε, beside 100 N of load
                        .best_published = "EXUDYN, extrapolated: 10",
                        .scale = exact.cwiseAbs()};
  return {limited(solved(problem, moving, By::bdf, {.rtol = 1e-13, .atol = 1e-14}), "order 5: the errors of its steps, each below 1e-13, add up"),
          solved(problem, moving, By::dop853, {.rtol = 1e-14, .atol = 1e-15, .max_wall_seconds = 15}),
          solved(problem, moving, By::dopri5, {.rtol = 1e-13, .atol = 1e-14, .max_wall_seconds = 15})};
}

}  // namespace

Case flyball_governor() {
  return {"flyball_governor", "Stiff flyball governor (A05)",
          "Dampers of 4e4 N s/m make eigenvalues of down to −8.1e3 1/s beside a swing of 1 Hz: at 1e-6 an explicit method of order "
          "8 needs 91000 evaluations, BDF 2100. Every coordinate counts by its own size.",
          rows};
}

}  // namespace qdot::hard
