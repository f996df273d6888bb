// SPDX-License-Identifier: MIT
//
// Equations that the compiler has derived, or has not: energies at the edge of what can be derived.
#include "catch2_bridge.hpp"

#include <cmath>
#include <type_traits>

#include "mechanics/closed_form_difference.hpp"

using namespace qdot;

namespace {

// A few dozen operations.
constexpr double rounded = 1e-12;

// T is no quadratic form.
struct Relativistic {
  double m = 1.0, c = 3.0, k = 2.0;
  constexpr auto T(const auto& v) const {
    using std::sqrt;
    return -m * c * c * sqrt(1.0 - v.squaredNorm() / (c * c));
  }
  constexpr auto V(const auto& q) const { return 0.5 * k * q.squaredNorm() + q[0] * q[1]; }
};

// Of third and fourth order in the velocities, with a division by one.
struct QuarticInVelocities {
  double a = 0.1;
  constexpr auto T(const auto& q, const auto& v) const {
    const auto w = v[0] * v[0] + v[1] * v[1];
    return 0.5 * w + a * w * w + v[0] * v[0] / (2.0 + v[1] * v[1]) + a * q[0] * v[0] * v[0] * v[1] / (1.0 + q[1] * q[1]);
  }
  constexpr auto V(const auto& q) const { return q[0] * q[1]; }
};

// More factors than a monomial holds.
struct ManyFactors {
  double a = 1.0;
  constexpr auto T(const auto& q, const auto& v) const {
    using std::cos, std::exp, std::sin, std::tanh;
    const auto x = q[0], y = q[1];
    const auto many = exp(x) * exp(y) * cos(x) * cos(y) * sin(x) * sin(y) * x * y * tanh(x) * tanh(y) * exp(x * y) * sin(x * y);
    return 0.5 * a * (many * v[0] * v[0] + v[1] * v[1]);
  }
  constexpr auto V(const auto& q) const { return q[0] + q[1] * q[1]; }
};

struct HighPowers {
  double a = 1.0;
  constexpr auto T(const auto& q, const auto& v) const {
    using std::pow;
    return 0.5 * pow(1.0 + q[0], -12.0) * v[0] * v[0] + 0.5 * pow(q[1], 9.0) * v[1] * v[1] + 0.5 * pow(q[0] * q[1], 1.75) * v[2] * v[2];
  }
  constexpr auto V(const auto& q) const {
    using std::pow;
    return a * pow(q[0], -11.0) + pow(a * q[1] * q[1], 1.5) + pow(q[2], 70.0) + pow(q[2], -0.5) * pow(q[2], -70.0);
  }
};

// All functions of <cmath> with a derivative, in T and in V.
struct AllFunctions {
  double a = 0.7;
  constexpr auto T(const auto& q, const auto& v) const { return 0.5 * sum_of_all(a * q[0]) * v[0] * v[0] + 0.5 * v[1] * v[1]; }
  constexpr auto V(const auto& q) const { return sum_of_all(q[1] * 0.5 + 0.1) * q[0]; }

 private:
  static constexpr auto sum_of_all(const auto& x) {
    using std::acos, std::acosh, std::asin, std::asinh, std::atan, std::atan2, std::atanh, std::cbrt, std::cos, std::cosh, std::erf, std::erfc,
        std::exp, std::expm1, std::hypot, std::log, std::log1p, std::sin, std::sinh, std::sqrt, std::tan, std::tanh;
    return sin(x) + cos(x) + tan(x) + asin(x) - acos(x) + atan(x) + atan2(x, 1.0 + x * x) + atan2(2.0, x) + exp(x) + expm1(x) + log(x) + 10.0 +
           log1p(x) + sinh(x) + cosh(x) + tanh(x) + asinh(x) + acosh(2.0 + x) + atanh(x) + cbrt(x) + erf(x) + erfc(x) + hypot(x, 2.0) + sqrt(x);
  }
};

// Two bodies on a line and a spring between them; and a mass that depends on how far they are apart.
struct FarFromTheOrigin {
  double m = 1.1, k = 0.7, l = 0.3;
  constexpr auto T(const auto& q, const auto& v) const {
    const auto apart = q[1] - q[0];
    return 0.5 * m * v[0] * v[0] + 0.5 * m * (1.0 + apart * apart) * v[1] * v[1];
  }
  constexpr auto V(const auto& q) const {
    const auto longer = q[1] - q[0] - l;
    return 0.5 * k * longer * longer;
  }
};

// What has no derivative, or none that is written down.
template <int which>
struct WithoutClosedForm {
  double e = 1.5;
  constexpr auto T(const auto& q, const auto& v) const {
    using std::abs, std::pow;
    if constexpr (which == 0) return 0.5 * (1.0 + abs(q[0])) * v[0] * v[0] + 0.5 * v[1] * v[1];
    else if constexpr (which == 1) return 0.5 * pow(1.0 + q[0] * q[0], e) * v[0] * v[0] + 0.5 * v[1] * v[1];
    else return 0.5 * (1.0 + q[0] * q[0]) * v.squaredNorm();
  }
  constexpr auto V(const auto& q) const {
    using std::max, std::min, std::pow;
    if constexpr (which == 2) return max(q[0] * q[0], q[1]) - min(q[0], q[1]);
    else if constexpr (which == 3) return pow(2.0 + q[0], q[1]);
    else return q[0] * q[1];
  }
};

// More operations in T than the compiler multiplies out.
struct ManyTerms {
  double a = 0.1;
  constexpr auto T(const auto& q, const auto& v) const {
    using std::sin;
    using S = typename std::decay_t<decltype(q)>::Scalar;
    S sum(0.0);
    for (int k = 0; k < 14; ++k) sum += (2.0 + sin((1.0 + a * k) * q[0] + k * q[1])) * (v[0] + k * v[1]) * (v[0] + k * v[1]);
    return sum;
  }
  constexpr auto V(const auto& q) const { return q[0] * q[1]; }
};

template <class E>
void require_no_closed_form_and_the_same_motion(const E& energies) {
  static_assert(!decltype(written_out<2>(energies))::ClosedForm::exists);
  const Vector<double, 2> q(0.4, 0.7), v(1.1, 0.3);
  const Vector<double, 2> a = acceleration(mechanical_system<2>(energies), q, v), b = acceleration(mechanical_system<2>(written_out<2>(energies)), q, v);
  CHECK((a - b).norm() < rounded * a.norm());
}

}  // namespace

TEST_CASE("derived equations of motion are those of T and V: T that is no quadratic form in the velocities") {
  CHECK(difference_of_ways<2>(Relativistic{.m = 0.3, .c = 4.0}, -1.0, 1.0) < rounded);
  CHECK(difference_of_ways<2>(QuarticInVelocities{.a = 0.03}, -0.5, 0.5) < rounded);
}

TEST_CASE("derived equations of motion are those of T and V: many factors, many terms, high powers, all functions") {
  CHECK(difference_of_ways<2>(ManyFactors{.a = 1.4}, 0.3, 1.2) < rounded);
  CHECK(difference_of_ways<2>(ManyTerms{.a = 0.2}, -1.0, 1.0) < rounded);
  CHECK(difference_of_ways<3>(HighPowers{.a = 1.4}, 0.8, 1.2) < rounded);
  CHECK(difference_of_ways<2>(AllFunctions{.a = 0.6}, 0.2, 0.9) < rounded);
}

TEST_CASE("bodies that are near each other and far from the origin lose no digits in derived equations") {
  const FarFromTheOrigin system{.m = 1.3, .k = 0.9, .l = 0.01};
  for (const double far : {1e3, 1e6, 1e9}) {
    const Vector<double, 2> q(far + 0.3, far + 0.3 + 0.0625), v(0.4, 0.5);
    Vector<double, 2> a;
    REQUIRE(detail::closed_form_acceleration<2>(written_out<2>(system), q.data(), v.data(), 0.0, a.data()));
    // By hand, of the distance, which is exact.
    const double d = q[1] - q[0], force = -system.k * (d - system.l), mass = system.m * (1.0 + d * d);
    const double a0 = (-force - system.m * d * v[1] * v[1]) / system.m;
    const double a1 = (force + system.m * d * v[1] * v[1] - 2.0 * system.m * d * (v[1] - v[0]) * v[1]) / mass;
    CHECK_THAT(a[0], WithinRel(a0, rounded));
    CHECK_THAT(a[1], WithinRel(a1, rounded));
  }
}

TEST_CASE("energies without a closed form are evaluated by their list, and right") {
  require_no_closed_form_and_the_same_motion(WithoutClosedForm<0>{});
  require_no_closed_form_and_the_same_motion(WithoutClosedForm<1>{.e = 2.5});
  require_no_closed_form_and_the_same_motion(WithoutClosedForm<2>{});
  require_no_closed_form_and_the_same_motion(WithoutClosedForm<3>{});
}
