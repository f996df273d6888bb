// SPDX-License-Identifier: MIT
//
// R. F. Arenstorf, Periodic solutions of the restricted three body problem, American Journal of Mathematics 85 (1963);
// start and periods: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, II.0. Recomputed with 34
// digits the orbits close to 1e-21.
#include "hard/motion.hpp"
#include "qdot/integrate/taylor.hpp"

namespace qdot::hard {
namespace {

// A satellite between Earth and Moon in their rotating frame: T is the kinetic energy seen from outside.
struct EarthAndMoon {
  double mu = 0.012277471;  // mass of the Moon, of the whole

  auto T(const auto& q, const auto& v) const {
    const auto vx = v[0] - q[1], vy = v[1] + q[0];
    return 0.5 * (vx * vx + vy * vy);
  }
  auto V(const auto& q) const {
    using std::sqrt;
    const auto earth = q[0] + mu, moon = q[0] - (1.0 - mu), y2 = q[1] * q[1];
    return -(1.0 - mu) / sqrt(earth * earth + y2) - mu / sqrt(moon * moon + y2);
  }
};

std::vector<Row> rows() {
  const auto satellite = mechanical_system<2>(EarthAndMoon{}).with_names({"x", "y"});
  const auto moving = motion(satellite);
  std::vector<Row> rows;
  // Gains: of the error in x(0) = 0.994, which is not a double, beside the speed 2.
  struct Orbit {
    const char* name;
    double period, speed, gain;
  };
  for (const Orbit& orbit : {Orbit{"Arenstorf, four loops", 17.0652165601579625588917206249, -2.00158510637908252240537862224, 1.1e6},
                             Orbit{"Arenstorf, three loops", 11.124340337266085134999734047, -2.0317326295573368357302057924, 8.5e5}}) {
    const Eigen::VectorXd start = numbers({0.994, 0.0, 0.0, orbit.speed});
    const Problem problem{.name = orbit.name, .t_end = orbit.period, .start = start, .exact = start, .reference_digits = 21, .gain = orbit.gain};
    rows.push_back(solved(problem, moving, By::dop853, {.rtol = 2.5e-15, .atol = 1e-16}));
    rows.push_back(solved(problem, moving, satellite, Taylor{}, "taylor, 2.5e-15", {.rtol = 2.5e-15, .atol = 1e-16}));
  }
  return rows;
}

}  // namespace

Case arenstorf() {
  return {"arenstorf", "Arenstorf orbits",
          "A satellite passes the Moon at a distance of 0.006 and returns to its start after one period. T has terms of degree "
          "0, 1 and 2 in the velocities. The orbits close to 1e-21 in 34 digits; 0.994 is not a double, and the motion "
          "amplifies its rounding a million times.",
          rows};
}

}  // namespace qdot::hard
