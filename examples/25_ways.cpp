// SPDX-License-Identifier: MIT
//
// Ways between two places: the action of paths that are no motions, a throw, three ways of a pendulum from its lowest point back to it. And a great
// circle that is not the shortest.

#include <cmath>
#include <cstdio>
#include <numbers>

#include <qdot/analysis/action.hpp>
#include <qdot/analysis/boundary_value_problem.hpp>
#include <qdot/qdot.hpp>

using namespace qdot;

struct Ball {
  double m = 1.0, g = 9.81;
  auto T(const auto& v) const { return 0.5 * m * v.squaredNorm(); }
  auto V(const auto& q) const { return m * g * q[1]; }
};

struct Pendulum {
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const {
    using std::cos;
    return -cos(q[0]);
  }
};

// A point on the unit sphere, θ from the pole and φ round it.
struct OnSphere {
  auto T(const auto& q, const auto& v) const {
    using std::sin;
    const auto radius = sin(q[0]);
    return 0.5 * (v[0] * v[0] + radius * radius * v[1] * v[1]);
  }
  auto V(const auto& q) const { return 0.0 * q[0]; }
};

void print(const char* what, const auto& way) {
  std::printf("%s: %s, S = %.6f, index %d", what, name(way.outcome), way.S, way.index);
  for (const ConjugatePoint& point : way.conjugate_points) std::printf(", conjugate at t = %.6f (%d)", point.t, point.multiplicity);
  std::printf("\n");
}

int main() {
  const double pi = std::numbers::pi;
  const auto ball = mechanical_system<2>(Ball{});
  const auto thrown = boundary_value_problem(ball, vector(0.0, 0.0), 0.0, vector(10.0, 2.0), 1.5);
  print("a throw by 10 m and 2 m up in 1.5 s", thrown);
  std::printf("  it leaves with (%.4f, %.4f) m/s\n", thrown.start.qdot[0], thrown.start.qdot[1]);
  for (const double bend : {0.0, 0.5, 1.0, 1.5}) {
    const auto path = [&](const auto& t) { return vector(10.0 / 1.5 * t, 2.0 / 1.5 * t + bend * 0.5 * 9.81 * t * (1.5 - t)); };
    std::printf("  a path with %.1f times its bend: S = %.6f\n", bend, action(ball, path, 0.0, 1.5).S);
  }

  const auto pendulum = mechanical_system<1>(Pendulum{});
  const auto from_rest = boundary_value_problem(pendulum, vector(0.0), 0.0, vector(0.0), 4.0);
  print("a pendulum from 0 to 0 in 4 s, from the straight line", from_rest);
  for (const double side : {1.0, -1.0}) {
    const auto swing = [&](const auto& t) {
      using std::sin;
      return vector(side * 2.0 * sin(0.25 * pi * t));
    };
    const auto way = boundary_value_problem(pendulum, vector(0.0), 0.0, vector(0.0), 4.0, swing);
    print("  from a swing", way);
    std::printf("    its angle after 2 s: %.6f\n", way.at(2.0).q[0]);
  }
  const auto too_exact = boundary_value_problem(mechanical_system<2>(OnSphere{}), vector(0.5 * pi, 0.0), 0.0, vector(0.5 * pi, pi), 1.0);
  print("to the antipode", too_exact);
  print("along the equator by 5 rad, the long way round", boundary_value_problem(mechanical_system<2>(OnSphere{}), vector(0.5 * pi, 0.0), 0.0,
                                                                                 vector(0.5 * pi, 5.0), 1.0));
}
