// SPDX-License-Identifier: MIT
//
// Columns of the variational equations against the differentiated solution by Cramer's rule, derived by hand.
#include "catch2_bridge.hpp"

#include <cmath>
#include <type_traits>

#include "qdot/ad/dual_eigen.hpp"
#include "qdot/analysis/variations/variations.hpp"

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

// q̈ by Cramer's rule.
template <class S>
Vector<S, 2> acceleration_by_hand(const Vector<S, 7>& x, const Vector<S, 2>& q, const Vector<S, 2>& v, double t) {
  using std::cos, std::sin;
  const S c = cos(q[0] - q[1]), s = sin(q[0] - q[1]);
  const S push = x[5] * x[6] * x[6] * sin(x[6] * t);  // minus the pivot's acceleration
  const S A = (x[0] + x[1]) * x[2] * x[2], b = x[1] * x[2] * x[3] * c, d = x[1] * x[3] * x[3];
  const S u = -x[1] * x[2] * x[3] * s * v[1] * v[1] + (x[0] + x[1]) * x[2] * (push * cos(q[0]) - x[4] * sin(q[0]));
  const S w = x[1] * x[2] * x[3] * s * v[0] * v[0] + x[1] * x[3] * (push * cos(q[1]) - x[4] * sin(q[1]));
  const S det = A * d - b * b;
  return Vector<S, 2>((u * d - b * w) / det, (A * w - b * u) / det);
}

const Vector<double, 7> parameters{{1.3, 0.7, 0.9, 1.4, 9.81, 0.2, 3.0}};

// The same pendulums by two of their parameters.
constexpr auto of_two_lengths = [](const auto& l) {
  using S = std::remove_cvref_t<decltype(l[0])>;
  return DrivenDoublePendulum<S>{S(1.3), S(0.7), l[0], l[1], S(9.81), S(0.2), S(3.0)};
};

}  // namespace

TEST_CASE("columns of the variational equations equal the hand-derived solution along them") {
  using Model = detail::EnergiesModel<FirstOrderForm<System<DrivenDoublePendulum<double>, 2>>, EventList<>, decltype(of_two_lengths), 2>;
  const Vector<double, 2> l(0.9, 1.4);
  for (const By way : {By::fastest, By::lines, By::duals})
    for (const bool with_start : {false, true})
      for (const bool with_time : {false, true}) {
        const auto system = mechanical_system<2>(of_two_lengths(l)).by(way);
        const detail::Variations<Model> equations(Model{{first_order_form(system), {}}, of_two_lengths, l}, with_start, with_time);
        const Eigen::Index others = (with_start ? 4 : 0) + (with_time ? 1 : 0), columns = others + 2;
        Eigen::VectorXd both(4 * (columns + 1)), rates = Eigen::VectorXd::Zero(both.size());
        for (Eigen::Index i = 0; i < both.size(); ++i) both[i] = std::sin(1.0 + 2.0 * static_cast<double>(i));  // a state, and any columns
        const double t = 0.4;
        equations.write_rates(t, both.data(), rates.data());
        for (Eigen::Index j = 0; j <= columns; ++j) {
          using D = Dual<double, 1>;
          Vector<D, 7> x = parameters.cast<D>();
          Vector<D, 2> q = both.head(2).cast<D>(), v = both.segment(2, 2).cast<D>();
          if (j > 0)
            for (int i = 0; i < 2; ++i) {
              q[i].tangent[0] = both[4 * j + i];
              v[i].tangent[0] = both[4 * j + 2 + i];
            }
          if (const Eigen::Index parameter = j - 1 - others; parameter >= 0) x[2 + parameter].tangent[0] = 1.0;
          const Vector<D, 2> a = acceleration_by_hand<D>(x, q, v, t);
          for (int i = 0; i < 2; ++i) {
            INFO("column " << j << " of " << columns << ", entry " << i);
            const double expected = j == 0 ? a[i].value : a[i].tangent[0];
            CHECK(std::abs(rates[4 * j + 2 + i] - expected) < 10 * rounded * (1.0 + std::abs(expected)));
            CHECK(rates[4 * j + i] == both[4 * j + 2 + i]);
          }
        }
      }
}
