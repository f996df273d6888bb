// SPDX-License-Identifier: MIT
//
// Andrews' squeezing mechanism: W. Schiehlen (ed.), Multibody Systems Handbook (1990); E. Hairer, G. Wanner, Solving Ordinary
// Differential Equations II, VII.7; Test Set for Initial Value Problem Solvers, problem andrews; benchmark A03 of the library of
// computational benchmark problems for multibody dynamics. The ends are computed with 34 digits and keep T + V to 1e-24. The end
// printed by the Test Set is off by −2.2e-10 in T + V, and right to 9.6 digits in q, 7.3 in q̇.
#include "hard/motion.hpp"
#include "qdot/effects/constraints.hpp"

namespace qdot::hard {
namespace {

// Seven bodies; crank β, and the angles θ (to the crank), γ, φ, δ, ω, ε of the others. m, kg, N.
struct SqueezingMechanism {
  double m1 = 0.04325, m2 = 0.00365, m3 = 0.02373, m4 = 0.00706, m5 = 0.0705, m6 = 0.00706, m7 = 0.05498;
  double i1 = 2.194e-6, i2 = 4.41e-7, i3 = 5.255e-6, i4 = 5.667e-7, i5 = 1.169e-5, i6 = 5.667e-7, i7 = 1.912e-5;
  double xa = -0.06934, ya = -0.00227, xb = -0.03635, yb = 0.03273, xc = 0.014, yc = 0.072;
  double d = 0.028, da = 0.0115, e = 0.02, ea = 0.01421, rr = 0.007, ra = 0.00092, ss = 0.035, sa = 0.01874, sb = 0.01043;
  double sc = 0.018, sd = 0.02, ta = 0.02308, tb = 0.00916, u = 0.04, ua = 0.01228, ub = 0.00449, zf = 0.02, zt = 0.04, fa = 0.01421;
  double c0 = 4530, l0 = 0.07785, torque = 0.033;

  auto T(const auto& q, const auto& v) const {
    using std::cos, std::sin;
    const double e4 = e - ea, f6 = zf - fa;
    const auto w2 = v[0] + v[1], w4 = v[3] + v[4], w6 = v[5] + v[6];
    const auto speed2 = rr * rr * v[0] * v[0] - 2.0 * rr * da * cos(q[1]) * v[0] * w2 + da * da * w2 * w2;
    const auto speed4 = e4 * e4 * w4 * w4 + 2.0 * zt * e4 * sin(q[3]) * v[4] * w4 + zt * zt * v[4] * v[4];
    const auto speed6 = f6 * f6 * w6 * w6 - 2.0 * u * f6 * sin(q[5]) * v[6] * w6 + u * u * v[6] * v[6];
    return 0.5 * ((m1 * ra * ra + i1) * v[0] * v[0] + m2 * speed2 + i2 * w2 * w2 + (m3 * (sa * sa + sb * sb) + i3) * v[2] * v[2] +
                  m4 * speed4 + i4 * w4 * w4 + (m5 * (ta * ta + tb * tb) + i5) * v[4] * v[4] + m6 * speed6 + i6 * w6 * w6 +
                  (m7 * (ua * ua + ub * ub) + i7) * v[6] * v[6]);
  }
  // A spring from (xc, yc) to a point of the third body, and the constant torque on the crank.
  auto V(const auto& q) const {
    using std::cos, std::sin, std::sqrt;
    const auto x = xb + sd * cos(q[2]) + sc * sin(q[2]) - xc, y = yb + sd * sin(q[2]) - sc * cos(q[2]) - yc;
    const auto stretch = sqrt(x * x + y * y) - l0;
    return 0.5 * c0 * stretch * stretch - torque * q[0];
  }
  auto loops(const auto& q) const {
    using std::cos, std::sin;
    using S = typename std::decay_t<decltype(q)>::Scalar;
    const S x = rr * cos(q[0]) - d * cos(q[0] + q[1]), y = rr * sin(q[0]) - d * sin(q[0] + q[1]);
    Vector<S, 6> phi;
    phi << x - ss * sin(q[2]) - xb, y + ss * cos(q[2]) - yb,                                            //
        x - e * sin(q[3] + q[4]) - zt * cos(q[4]) - xa, y + e * cos(q[3] + q[4]) - zt * sin(q[4]) - ya,  //
        x - zf * cos(q[5] + q[6]) - u * sin(q[6]) - xa, y - zf * sin(q[5] + q[6]) + u * cos(q[6]) - ya;
    return phi;
  }
};

Motion mechanism() {
  const SqueezingMechanism data;
  return motion(scene(mechanical_system<7>(data).with_names({"beta", "theta", "gamma", "phi", "delta", "omega", "epsilon"}),
                      holonomic("loop", [data](const auto& q) { return data.loops(q); })));
}

std::vector<Problem> problems() {
  const Eigen::VectorXd start =
      joined(numbers({-0.0617138900142764496358948458001, 0, 0.455279819163070380255912382449, 0.222668390165885884674473185609,
                      0.487364979543842550225598953530, -0.222668390165885884674473185609, 1.23054744454982119249735015568}),
             Eigen::VectorXd::Zero(7));
  const Eigen::VectorXd at_30_ms = numbers({15.81077119515370709712, -15.75637105841183946973, 0.04082224011964580485828, -0.5347301163420795937702,
                                            0.5244099658799540693717, 0.5347301163420795937702, 1.048080741041937873069, 1139.920302259106064198,
                                            -1424.379295177540073196, 11.03291191061859374533, 19.29337410503204083163, 0.5735699148295024538177,
                                            -19.29337410503204083163, 0.3231791492491308749907});
  const Eigen::VectorXd at_50_ms = numbers({33.82586776695451733227, -33.58343151746386849838, 0.1133950738125990150253, -0.4078528656018844424931,
                                            0.5260604449169958271327, 0.4078528656018844424931, 1.056902429434962830987, 1144.535502653847468403,
                                            -1336.033722651192454033, -190.9370686042946246821, -334.3170608708646535803, 0.8758650829430151613949,
                                            334.3170608708646535803, -39.61728897835299501756});
  return {{.name = "Andrews, 0.03 s", .t_end = 0.03, .start = start, .exact = at_30_ms, .reference_digits = 21, .gain = 250, .best_published = "PSIDE 7.3"},
          {.name = "Andrews, 0.05 s (A03)", .t_end = 0.05, .start = start, .exact = at_50_ms, .reference_digits = 19, .gain = 1000}};
}

std::vector<Row> rows() {
  const auto moving = mechanism();
  std::vector<Row> rows;
  for (const Problem& problem : problems()) {
    rows.push_back(solved(problem, moving, By::dop853, {.rtol = 2.5e-15, .atol = 1e-15}));
    rows.push_back(solved(problem, moving, By::dopri5, {.rtol = 2.5e-15, .atol = 2.5e-15}));
  }
  return rows;
}

}  // namespace

Case andrews() {
  return {"andrews", "Andrews' squeezing mechanism",
          "Seven bodies in three closed loops, one degree of freedom, 1140 rad/s after 0.03 s. Given to index-3 solvers it "
          "stalls near five digits. The usual published end state is right to 9.6 digits in q and 7.3 in the velocities.",
          rows};
}

}  // namespace qdot::hard
