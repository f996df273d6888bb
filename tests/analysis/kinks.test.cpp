// SPDX-License-Identifier: MIT
//
// Slopes of the equations where V has a kink.

#include "qdot/analysis/linear/kinks.hpp"

#include <cmath>
#include <string>
#include <type_traits>

#include "catch2_bridge.hpp"
#include "qdot/analysis/linearization.hpp"
#include "qdot/analysis/modes.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"

using namespace qdot;

namespace {

using V1 = Vector<double, 1>;

std::string refusal(const auto& f) {
  try {
    f();
  } catch (const InvalidValue& e) {
    return e.what();
  }
  return {};
}

// A spring of 9 and, to one side of `wall`, one of 4 more; max with its arguments in both orders.
template <bool zero_first>
struct Gap {
  double wall = 0.0;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const {
    using std::max;
    const auto over = [&] {
      if constexpr (zero_first) return max(0.0, q[0] - wall);
      else return max(q[0] - wall, 0.0);
    }();
    return 4.5 * q[0] * q[0] + 2.0 * over * over;
  }
};

}  // namespace

TEST_CASE("max does not ask in which order its arguments are: its slope at a tie") {
  const auto a = acceleration_jacobian(mechanical_system<1>(Gap<true>{}), V1(0.0), V1(0.0));
  const auto b = acceleration_jacobian(mechanical_system<1>(Gap<false>{}), V1(0.0), V1(0.0));
  CHECK(a.d_q(0, 0) == b.d_q(0, 0));
  CHECK(a.d_q(0, 0) == -13.0);  // that of the side of q, which is no constant
  using D = Dual<double, 1>;
  const D x = D::variable(0.5, 0);
  CHECK(max(0.5, x).tangent[0] == 1.0);
  CHECK(max(x, 0.5).tangent[0] == 1.0);
  CHECK(min(D(0.5), x).tangent[0] == 1.0);
  CHECK(min(x, D(0.5)).tangent[0] == 1.0);
}

TEST_CASE("a linearization and modes on a kink are refused with its place") {
  const auto system = mechanical_system<1>(Gap<true>{});
  CHECK(refusal([&] { linearization(system, State<1>{0.0, V1(0.0), V1(0.0)}); }).find("q0 = 0, qdot0 = 0 the comparison max in T or V is a tie") !=
        std::string::npos);
  CHECK(refusal([&] { normal_modes(system, V1(0.0)); }).find("is a tie") != std::string::npos);
  const auto beside = mechanical_system<1>(Gap<true>{0.25});
  CHECK(linearization(beside, State<1>{0.0, V1(0.0), V1(0.0)}).A(1, 0) == -9.0);
  CHECK(std::abs(normal_modes(beside, V1(0.0)).squared_frequencies[0] - 9.0) < 1e-14);
}

TEST_CASE("a comparison of equal numbers whose branches have the same slopes is no kink") {
  const auto cubic = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                          [](const auto& q) {
                                            using std::abs;
                                            return 2.0 * q[0] * q[0] + q[0] * q[0] * abs(q[0]);
                                          });
  CHECK(linearization(cubic, State<1>{0.0, V1(0.0), V1(0.0)}).A(1, 0) == -4.0);
}
