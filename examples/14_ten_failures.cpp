// SPDX-License-Identifier: MIT
//
// Ten models that cannot work, and what each is told: the rule, the values that broke it, and what to do. What is wrong before the
// first step is an exception; what goes wrong on the way is an outcome, with the motion up to there.

#include <cmath>
#include <cstdio>
#include <limits>

#include <qdot/effects/constraints.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/qdot.hpp>

using namespace qdot;
using V1 = Vector<double, 1>;
using V2 = Vector<double, 2>;

// Runs what ought to fail, and prints its message.
template <class Attempt>
void show(const char* what, const Attempt& attempt) {
  try {
    std::printf("%s\n  %s\n\n", what, attempt().message.c_str());
  } catch (const Error& error) {
    std::printf("%s\n  %s\n\n", what, error.what());
  }
}

// Two coordinates; the cases differ in T and V only.
enum Kind { massless_y, linear_in_velocity, polar };
struct Energies {
  Kind kind;
  auto T(const auto& q, const auto& v) const {
    if (kind == linear_in_velocity) return q[0] * v[1] - q[1] * v[0];
    return 0.5 * v[0] * v[0] + (kind == polar ? 0.5 * q[0] * q[0] * v[1] * v[1] : 0.0 * v[1]);
  }
  auto V(const auto& q) const { return 0.5 * (q[0] * q[0] + q[1] * q[1]); }
};
auto planar(Kind kind) { return mechanical_system<2>(Energies{kind}); }

// One coordinate, x; V falls without bottom at x = 0, or ends at x = 1.
struct Well {
  bool bottomless;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const {
    using std::log, std::sqrt;
    return bottomless ? log(q[0]) : sqrt(1.0 - q[0]);
  }
};

int main() {
  const V2 q(1.0, 0.5), rest(0.0, 0.0);
  const auto from = [](const auto& system, const auto& start) { return simulate(system, start, 5.0, Dop853{}); };
  show("1. a coordinate without mass", [&] { return from(planar(massless_y).with_names({"x", "y"}), State<2>{0.0, q, rest}); });
  show("2. a Lagrangian linear in the velocities", [&] { return from(planar(linear_in_velocity), State<2>{0.0, q, rest}); });
  show("3. polar coordinates at their origin",
       [&] { return from(planar(polar).with_names({"r", "phi"}), State<2>{0.0, V2(0.0, 1.0), V2(1.0, 0.0)}); });

  const auto point = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }).with_names({"x", "y"});
  const auto rod = holonomic("rod", [](const auto& x) { return x.squaredNorm() - 1.0; });
  const auto guide = holonomic("guide", [](const auto& x) { return x[1] + 2.0; });
  show("4. constraints that cannot be met together", [&] { return from(scene(point, rod, guide), State<2>{0.0, V2(0.0, -1.0), rest}); });
  show("5. a start that is off its constraint", [&] { return from(scene(point, rod), State<2>{0.0, V2(0.6, 0.9), rest}); });

  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const auto well = mechanical_system<1>(Well{true}).with_names({"x"}), cliff = mechanical_system<1>(Well{false}).with_names({"x"});
  show("6. a start that is not a number", [&] { return from(well, State<1>{0.0, V1(nan), V1(0.0)}); });
  show("7. an end that is not finite", [&] { return simulate(well, State<1>{0.0, V1(1.0), V1(0.0)}, infinity, Dop853{}); });
  show("8. a force that becomes infinite", [&] { return from(well, State<1>{0.0, V1(1.0), V1(0.0)}); });
  show("9. the root of a negative number", [&] { return from(cliff, State<1>{0.0, V1(0.0), V1(0.0)}); });

  const auto ball = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& x) { return 9.81 * x[0]; });
  show("10. a ball that bounces infinitely often", [&] {
    const auto bounce = event("floor", [](const auto& x) { return x[0]; }).falling().action([](State<1>& s) { s.qdot *= -0.5; });
    return simulate(ball, State<1>{0.0, V1(1.0), V1(0.0)}, 5.0, Dop853{}, {}, events(bounce));
  });
}
