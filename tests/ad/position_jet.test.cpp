// SPDX-License-Identifier: MIT
//
// Numbers that know how they move, against nested duals.
#include "catch2_bridge.hpp"

#include <cmath>

#include "qdot/ad/dual_math.hpp"
#include "qdot/ad/places/position_jet.hpp"

using namespace qdot;
using namespace qdot::detail;

namespace {

constexpr double rounded = 1e-14;  // a dozen operations on numbers of size one
constexpr double x = 0.7, y = -1.3, xdot = 0.4, ydot = 0.9;

// J, ẋ and s against nested duals: along (q̇, 0), twice, and along each coordinate.
template <class F>
void check(const F& f) {
  using S = PositionJet<2>;
  const S jet = S(f(S::coordinate<0>(x, xdot), S::coordinate<1>(y, ydot))).whole();
  using D = Dual<double, 1>;
  using DD = Dual<D, 1>;
  const auto along = [](double at, double rate) {
    DD moving{D(at)};
    moving.value.tangent[0] = rate;
    moving.tangent[0] = D(rate);
    return moving;
  };
  const DD moved = f(along(x, xdot), along(y, ydot));
  CHECK_THAT(jet.value, WithinAbs(moved.value.value, rounded));
  CHECK_THAT(jet.has_rate ? jet.rate : 0.0, WithinAbs(moved.tangent[0].value, rounded));
  CHECK_THAT(jet.has_bend ? jet.bend : 0.0, WithinAbs(moved.tangent[0].tangent[0], rounded));
  const double by_x = f(D::variable(x, 0), D(y)).tangent[0], by_y = f(D(x), D::variable(y, 0)).tangent[0];
  CHECK_THAT(has(jet.mask, 0) ? jet.J<0>() : 0.0, WithinAbs(by_x, rounded));
  CHECK_THAT(has(jet.mask, 1) ? jet.J<1>() : 0.0, WithinAbs(by_y, rounded));
}

}  // namespace

TEST_CASE("squares know how they move, in sums and products with each other and with all else") {
  check([](const auto& u, const auto&) { return u * u; });
  check([](const auto& u, const auto& v) { return 0.5 * (u * u + v * v - 1.7); });
  check([](const auto& u, const auto& v) { return u * u + v; });
  check([](const auto& u, const auto& v) { return v - u * u; });
  check([](const auto& u, const auto& v) { return u * u - v * v; });
  check([](const auto& u, const auto& v) { return -(u * u) * v; });
  check([](const auto& u, const auto& v) { return (u * u) * (v * v); });
  check([](const auto& u, const auto& v) { return (u * u) / (1.0 + v * v); });
  check([](const auto& u, const auto& v) {
    const auto s = u * u + v * v;
    return s * s;
  });
}

TEST_CASE("functions of squares know how they move") {
  check([](const auto& u, const auto& v) {
    using std::sqrt;
    return sqrt(u * u + v * v);
  });
  check([](const auto& u, const auto& v) {
    using std::sqrt;
    return 2.0 - sqrt(u * u + v * v) / 3.0 + sqrt(u + 1.0) * v;
  });
  check([](const auto& u, const auto& v) {
    using std::sin, std::exp;
    return sin(u * u) + exp(v * v - 2.0);
  });
  check([](const auto& u, const auto& v) {
    using std::atan2, std::hypot;
    return atan2(u * u, v * v) + hypot(u * u, v);
  });
}
