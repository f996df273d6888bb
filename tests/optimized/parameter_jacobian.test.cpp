// SPDX-License-Identifier: MIT
//
// ∂q̈/∂p as straight-line code, which exists only with the optimizer on, against the differentiated solution by Cramer's rule, derived by hand.
#include "catch2_bridge.hpp"

#include <cmath>
#include <type_traits>

#include "qdot/mechanics/parameter_jacobian.hpp"

using namespace qdot;

namespace {

constexpr double rounded = 1e-12;  // some hundred operations on numbers of size 10

// Two pendulums, the pivot of the first driven: x = a sin ωt. An odd number of parameters, some of them in T, some in V, some beside the time.
template <class S>
struct DrivenDoublePendulum {
  S m1, m2, l1, l2, g, a, omega;
  auto T(const auto& q, const auto& v, const auto& t) const {
    using std::cos;
    const auto drive = a * omega * cos(omega * t);
    return 0.5 * (m1 + m2) * l1 * l1 * v[0] * v[0] + 0.5 * m2 * l2 * l2 * v[1] * v[1] + m2 * l1 * l2 * v[0] * v[1] * cos(q[0] - q[1]) +
           drive * ((m1 + m2) * l1 * v[0] * cos(q[0]) + m2 * l2 * v[1] * cos(q[1]));
  }
  auto V(const auto& q) const {
    using std::cos;
    return -(m1 + m2) * g * l1 * cos(q[0]) - m2 * g * l2 * cos(q[1]);
  }
};

}  // namespace

TEST_CASE("with the optimizer on derivatives with respect to parameters equal those of the differentiated solution") {
  const Vector<double, 7> p{{1.3, 0.7, 0.9, 1.4, 9.81, 0.2, 3.0}};
  for (const double t : {0.0, 0.4, 2.1}) {
    const Vector<double, 2> q(0.8 + t, -0.4), qdot(1.1, -2.3 * t);
    const auto J = acceleration_jacobian_wrt_parameters<DrivenDoublePendulum>(p, q, qdot, t);
    const auto by_hand = [&](const auto& x) {
      using S = typename std::remove_cvref_t<decltype(x)>::Scalar;
      using std::sin;
      const double c = std::cos(q[0] - q[1]), s = std::sin(q[0] - q[1]);
      const S push = x[5] * x[6] * x[6] * sin(x[6] * t);  // minus the pivot's acceleration
      const S A = (x[0] + x[1]) * x[2] * x[2], b = x[1] * x[2] * x[3] * c, d = x[1] * x[3] * x[3];
      const S u = -x[1] * x[2] * x[3] * s * qdot[1] * qdot[1] + (x[0] + x[1]) * x[2] * (push * std::cos(q[0]) - x[4] * std::sin(q[0]));
      const S w = x[1] * x[2] * x[3] * s * qdot[0] * qdot[0] + x[1] * x[3] * (push * std::cos(q[1]) - x[4] * std::sin(q[1]));
      const S det = A * d - b * b;
      return Vector<S, 2>((u * d - b * w) / det, (A * w - b * u) / det);
    };
    const auto expected = value_and_jacobian(by_hand, p);
    CHECK((J.qddot - expected.value).norm() < rounded * expected.value.norm());
    CHECK((J.d_p - expected.jacobian).norm() < rounded * expected.jacobian.norm());
  }
}
