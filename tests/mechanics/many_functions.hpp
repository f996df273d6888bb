#pragma once
// SPDX-License-Identifier: MIT
//
// Energies with all that a formula may have.
#include <cmath>
#include <type_traits>

namespace qdot::tests {

/// Vectors as Eigen has them, every kind of function, and the time.
struct ManyFunctions {
  double a = 0.7, b = 1.3;
  auto T(const auto& q, const auto& qdot, const auto& t) const {
    using std::cos, std::cosh, std::exp, std::sqrt, std::tanh;
    using S = std::decay_t<decltype(t)>;
    const S stretch = qdot.squaredNorm() * (1.0 + exp(-q.dot(q))) + sqrt(1.0 + q[0] * q[0]) * qdot[0] * qdot[1];
    const S turn = (a + cosh(q[1]) + tanh(t) + cos(q[0] / (2.0 + q[1]))) * qdot[2] * qdot[2];
    return S(stretch + 0.5 * turn);
  }
  auto V(const auto& q, const auto& t) const {
    using std::atan2, std::cos, std::hypot, std::log, std::pow, std::sin, std::sqrt;
    using S = std::decay_t<decltype(t)>;
    const S u = q[2] + 2.0;
    const S powers = sqrt(u) * pow(u, 2.5) + pow(u, 1.5) / pow(u, 0.25) + pow(sqrt(u), 3.0) + pow(q[0] + 1.5, q[1]);
    return S(powers + b * log(q[0] + 2.0) + atan2(q[1], q[0] + 3.0) * hypot(q[1], q[2]) + pow(q[0] + 1.0, 2.5) * sin(q[2]) * cos(q[2]) / (1.0 + t) + q.norm());
  }
};

}  // namespace qdot::tests
