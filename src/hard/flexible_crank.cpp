// SPDX-License-Identifier: MIT
//
// A slider crank with an elastic rod: B. Simeon, Modelling a flexible slider crank mechanism by a mixed system of DAEs and PDEs
// (1996); Test Set for Initial Value Problem Solvers, problem crank (linear stiffness, no damping, no gravity). The published
// start is off its constraints by 2e-10 and their rates by 1.2e-8, and the published program's π is 3.1415927; this is the
// consistent start with π itself, its end computed with 34 digits.
#include <numbers>
#include <utility>

#include "hard/motion.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/taylor.hpp"

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

// The crank in the elastic coordinates alone: φ₁, φ₂ and x₃ follow from the drive and the slider's guide.
struct ElasticCrank {
  FlexibleCrank crank{};

  // [φ₁, φ₂, x₃, q₁ … q₄] and its rate, from x = [q₁ … q₄], ẋ and t.
  template <class S>
  std::pair<Vector<S, 7>, Vector<S, 7>> all(const Vector<S, 4>& x, const Vector<S, 4>& v, const S& t) const {
    using std::asin, std::cos, std::sin, std::sqrt;
    const S phi1 = crank.omega * t, length = crank.L2 + x[3];
    const S s1 = sin(phi1), c1 = cos(phi1), s2 = -crank.L1 * s1 / length, c2 = sqrt(1.0 - s2 * s2);
    const S rate2 = -(crank.L1 * crank.omega * c1 + v[3] * s2) / (length * c2);
    Vector<S, 7> q, qdot;
    q << phi1, asin(s2), crank.L1 * c1 + length * c2, x[0], x[1], x[2], x[3];
    qdot << S(crank.omega), rate2, -crank.L1 * crank.omega * s1 + v[3] * c2 - length * s2 * rate2, v[0], v[1], v[2], v[3];
    return {q, qdot};
  }
  template <class S>
  S T(const Vector<S, 4>& x, const Vector<S, 4>& v, const S& t) const {
    const auto [q, qdot] = all<S>(x, v, t);
    return crank.T(q, qdot);
  }
  template <class S>
  S V(const Vector<S, 4>& x) const {
    Vector<S, 7> q;
    q << S(0.0), S(0.0), S(0.0), x[0], x[1], x[2], x[3];
    return crank.V(q);
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
  const Eigen::VectorXd start = numbers({0, 0, data.L1 + data.L2 + q4, 0, 0, 0.103339863e-4, q4,  //
                                         data.omega, -data.L1 * data.omega / (data.L2 + q4), -0.268938672e-5, 0.444896105, 0.463434311e-2,
                                         -0.178591076e-5, -0.268938672e-5});
  // Gains: measured with 19 digits, each entry of the start moved by 1e-10 of its size and the state put back on the constraints.
  // With seven coordinates 1e-10 of the slider's 0.45 m leaves 4e-12 m in q₄, 4e-7 of its size, which ring at 2e4 rad/s.
  const Problem problem{.name = "flexible slider crank",
                        .t_end = 0.1,
                        .start = start,
                        .exact = exact,
                        .reference_digits = 18,
                        .gain = 5.7e5,
                        .best_published = "MEBDFI 7.9 (for its own start)",
                        .scale = exact.cwiseAbs()};
  const ElasticCrank elastic{data};
  const Problem alone{.name = "flexible slider crank, elastic coordinates",
                      .t_end = 0.1,
                      .start = joined(start.segment(3, 4), start.segment(10, 4)),
                      .exact = exact,
                      .reference_digits = 18,
                      .gain = 1e3,
                      .best_published = "MEBDFI 7.9 (for its own start)",
                      .scale = exact.cwiseAbs(),
                      .seen = [elastic](const State_& y) {
                        const auto [q, v] = elastic.all<double>(Vector<double, 4>(y.head(4)), Vector<double, 4>(y.tail(4)), 0.1);
                        return joined(q, v);
                      }};
  const auto four = mechanical_system<4>(elastic).with_names({"q1", "q2", "q3", "q4"});
  const auto vibrating = motion(four, Energy::worked_upon);
  // Deflections are 1e-4 to 1e-6 m, their rates 1e-2 to 1e-4 m/s: absolute tolerances well below that.
  const auto atol = [](double rtol) { return AbsoluteTolerance(rtol * 1e-5); };
  return {solved(problem, moving, By::dop853, {.rtol = 1e-14, .atol = atol(1e-14), .max_wall_seconds = 30}),
          solved(problem, moving, crank, Gauss{.step = 4e-5, .stages = 6}, "gauss, 6 stages, h = 4e-5", {}),
          solved(alone, vibrating, By::dop853, {.rtol = 1e-14, .atol = atol(1e-14), .max_step = 3.2e-6, .max_wall_seconds = 30}),
          solved(alone, vibrating, four, Taylor{}, "taylor, 2.5e-15", {.rtol = 2.5e-15, .atol = atol(2.5e-15)})};
}

}  // namespace

Case flexible_crank() {
  return {"flexible_crank", "Flexible slider crank",
          "Undamped elastic modes of up to 2.5e4 rad/s with deflections of 1e-6 to 1e-4 m ride on a crank that is driven at 150 "
          "rad/s. A stiff solver damps them away. Every coordinate counts by its own size, also those of 1e-6. Written with seven "
          "coordinates and three constraints, the rounding of the slider's place, 1e-16 of 0.45 m, is one of 1e-12 in the rod's "
          "stretch; the elastic coordinates alone do not know it.",
          rows};
}

}  // namespace qdot::hard
