// SPDX-License-Identifier: MIT
#include <array>

#include "../catch2_bridge.hpp"
#include "qdot/ad/derivatives.hpp"

namespace {

using qdot::Dual;
using D2 = Dual<double, 2>;
using DD = Dual<D2, 3>;

TEST_CASE("an independent variable has derivative one along itself and zero along the others") {
  const D2 x = D2::variable(0.7, 1);
  CHECK(x.value == 0.7);
  CHECK(x.tangent == std::array<double, 2>{0.0, 1.0});
}

TEST_CASE("sums, products and quotients follow Leibniz's rules") {
  // x = 3, y = −2:  (xy)′ = x′y + xy′,  (x/y)′ = (x′y − xy′)/y²
  const D2 x = D2::variable(3.0, 0);
  const D2 y = D2::variable(-2.0, 1);
  CHECK((x + y).tangent == std::array<double, 2>{1.0, 1.0});
  CHECK((x - y).tangent == std::array<double, 2>{1.0, -1.0});
  CHECK((x * y).tangent == std::array<double, 2>{-2.0, 3.0});
  CHECK((x / y).value == -1.5);
  CHECK((x / y).tangent == std::array<double, 2>{-0.5, -0.75});
  CHECK((-x).tangent == std::array<double, 2>{-1.0, 0.0});
}

TEST_CASE("a plain number is a constant whatever its type and wherever it stands") {
  const D2 x = D2::variable(3.0, 0);
  CHECK((2 * x + 1).value == 7.0);
  CHECK((2 * x + 1).tangent[0] == 2.0);
  CHECK((1 - x).tangent[0] == -1.0);
  CHECK((x - 1.0F).value == 2.0);
  CHECK((6 / x).tangent[0] == -6.0 / 9.0);
  CHECK((x / 2L).tangent[0] == 0.5);
  const DD u = DD::variable(x, 2);
  CHECK((u * 2 - 1.5).value.value == 4.5);
  CHECK((x * u).tangent[2].value == 3.0);
  CHECK((u * x).value.tangent[0] == 6.0);
}

TEST_CASE("compound assignment equals the operator") {
  D2 x = D2::variable(3.0, 0);
  const D2 y = D2::variable(-2.0, 1);
  x += y;
  x *= y;
  x -= 4.0;
  x /= y;  // ((3 + y) y − 4)/y = 3 + y − 4/y at y = −2: 3, slope 1 + 4/y² = 2 in y and 1 in x
  CHECK(x.value == 3.0);
  CHECK(x.tangent == std::array<double, 2>{1.0, 2.0});
}

TEST_CASE("an aliased operand is read before it is written") {
  D2 x = D2::variable(3.0, 0);
  x *= x;
  CHECK(x.tangent[0] == 6.0);
  const D2& the_same = x;
  x /= the_same;
  CHECK(x.value == 1.0);
  CHECK(x.tangent[0] == 0.0);
}

TEST_CASE("comparisons look at values only") {
  const D2 x = D2::variable(3.0, 0);
  const D2 y(3.0);
  CHECK(x == y);
  CHECK(x <= y);
  CHECK_FALSE(x != y);
  CHECK(x > 2);
  CHECK(1.0 < x);
}

TEST_CASE("a dual of duals carries exact second derivatives") {
  // f = x³ y at (2, 5): f_xx = 6xy = 60, f_xy = 3x² = 12
  using Nested = Dual<D2, 2>;
  const Nested x = Nested::variable(D2::variable(2.0, 0), 0);
  const Nested y = Nested::variable(D2::variable(5.0, 1), 1);
  const Nested f = x * x * x * y;
  CHECK(f.tangent[0].tangent[0] == 60.0);
  CHECK(f.tangent[0].tangent[1] == 12.0);
  CHECK(f.tangent[1].tangent[0] == 12.0);
  CHECK(f.tangent[1].tangent[1] == 0.0);
}

TEST_CASE("float and long double work inside") {
  const auto x = Dual<float, 1>::variable(2.0F, 0);
  CHECK((x * x).tangent[0] == 4.0F);
  const auto y = Dual<long double, 1>::variable(1.0L, 0);
  CHECK((y / 3).tangent[0] == 1.0L / 3.0L);
}

TEST_CASE("dual arithmetic works in constant expressions") {
  constexpr D2 x = D2::variable(3.0, 0);
  constexpr D2 y = x * x + 2.0 * x;
  static_assert(y.value == 15.0 && y.tangent[0] == 8.0);
  SUCCEED();
}

template <class X, class Y>
concept Addable = requires(X x, Y y) { x + y; };

TEST_CASE("perturbations of two unrelated derivatives do not mix") {
  struct First {};
  struct Second {};
  STATIC_REQUIRE_FALSE(Addable<Dual<double, 1, First>, Dual<double, 1, Second>>);
  STATIC_REQUIRE(Addable<Dual<double, 1, First>, Dual<double, 1, First>>);
  STATIC_REQUIRE(Addable<Dual<Dual<double, 1, First>, 1, Second>, Dual<double, 1, First>>);
}

TEST_CASE("the plain number below any depth of duals is found") {
  CHECK(qdot::innermost_value(4.0) == 4.0);
  CHECK(qdot::innermost_value(DD(D2(4.0))) == 4.0);
}

}  // namespace
