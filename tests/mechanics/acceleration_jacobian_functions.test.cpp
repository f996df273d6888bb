// SPDX-License-Identifier: MIT
//
// Exact derivatives of q̈ against quotients of differences of q̈.
#include "catch2_bridge.hpp"

#include <cmath>

#include "mechanics/difference_from_quotients.hpp"

using namespace qdot;

namespace {

// Every function that energies are made of, with velocities inside them.
struct Everything {
  template <class S>
  S T(const Vector<S, 2>& q, const Vector<S, 2>& v, const S& t) const {
    using std::atan2, std::cos, std::exp, std::hypot, std::log, std::pow, std::sin, std::sqrt, std::tanh;
    S sum{};  // a value that nothing was assigned to is zero
    sum += (2.0 + sin(q[0] * q[1]) + 0.1 * t) * v[0] * v[0] + exp(0.2 * q[1]) * v[1] * v[1];
    sum += 0.1 * sqrt(1.0 + v[0] * v[0] + q[1] * q[1]) + 0.05 * pow(1.0 + v[1] * v[1], 1.5) + 0.1 * hypot(v[0], 2.0 + q[0]);
    sum += 0.1 * atan2(q[0] * v[1], 3.0 + v[0]) + 0.1 * log(4.0 + v[0] * q[1]) / (3.0 + q[0]) + 0.1 * tanh(v[0] * v[1]);
    sum += 0.1 * pow(2.0 + q[0], 0.3 * v[1]) + 0.02 * max(v[0], v[1]) * abs(v[1]);
    return sum;
  }
  template <class S>
  S V(const Vector<S, 2>& q, const S& t) const {
    using std::cos;
    return cos(q[0] - q[1] + t) + q[0] * q[0] / (1.0 + q[1] * q[1]);
  }
};

}  // namespace

TEST_CASE("derivatives of accelerations are limits of quotients: every function that energies are made of") {
  const Vector<double, 2> q(0.6, -0.4), v(0.9, 0.5);
  CHECK(difference_from_quotients(mechanical_system<2>(Everything{}), q, v, 0.3) < differenced);
}

