// SPDX-License-Identifier: MIT
//
// Which velocity constraints are holonomic? Rolling along a line, a skate, a coin, and a form in disguise.

#include <cmath>
#include <cstdio>
#include <type_traits>

#include <qdot/mechanics/integrability.hpp>
#include <qdot/mechanics/velocity.hpp>
#include <qdot/qdot.hpp>

using namespace qdot;

void report(const char* what, const Integrability& answer) {
  std::printf("%-44s %ld   %-3s        %ld   %.3f\n", what, static_cast<long>(answer.constraints), answer.holonomic ? "yes" : "no",
              static_cast<long>(answer.opened), answer.residual < 1e-12 ? 0.0 : answer.residual);
}

int main() {
  std::printf("%-44s %s\n", "", "rows holonomic opened largest da(X, Y)");

  // A wheel that rolls along a line: ẋ − R θ̇ = 0 is the rate of x − R θ.
  const auto line = [](const auto& q) {
    using S = std::decay_t<decltype(q[0])>;
    return Matrix<S, 1, 2>(S(1), S(-0.3));
  };
  report("wheel on a line, (x, theta)", integrability(line, Vector<double, 2>(0.0, 0.5)));

  // A skate: no velocity across the blade.
  const auto skate = [](const auto& q) {
    using std::cos, std::sin;
    using S = std::decay_t<decltype(q[0])>;
    return Matrix<S, 1, 3>(-sin(q[2]), cos(q[2]), S(0));
  };
  report("skate, (x, y, theta)", integrability(skate, Vector<double, 3>(0.0, 0.0, 0.5)));

  // A coin that rolls upright: it can reach every place with every heading and every side up.
  const auto coin = [](const auto& q) {
    using std::cos, std::sin;
    using S = std::decay_t<decltype(q[0])>;
    Matrix<S, 2, 4> A;
    A << S(1), S(0), S(0), -0.3 * cos(q[2]),  //
        S(0), S(1), S(0), -0.3 * sin(q[2]);
    return A;
  };
  report("coin on a table, (x, y, heading, roll)", integrability(coin, Vector<double, 4>(0.0, 0.0, 0.5, 1.0)));

  // y z dx + x z dy + x y dz times e^x: an integrating factor hides d(x y z).
  const auto disguised = [](const auto& q) {
    using std::exp;
    using S = std::decay_t<decltype(q[0])>;
    return Matrix<S, 1, 3>(exp(q[0]) * q[1] * q[2], exp(q[0]) * q[0] * q[2], exp(q[0]) * q[0] * q[1]);
  };
  report("e^x d(x y z) = 0", integrability(disguised, Vector<double, 3>(1.0, 2.0, 0.5)));

  // y dx + z dy + x dz does not integrate, although no symmetry breaks and nothing looks wrong with it.
  const auto cyclic = [](const auto& q) {
    using S = std::decay_t<decltype(q[0])>;
    return Matrix<S, 1, 3>(q[1], q[2], q[0]);
  };
  report("y dx + z dy + x dz = 0", integrability(cyclic, Vector<double, 3>(1.0, 2.0, 0.5)));
}
