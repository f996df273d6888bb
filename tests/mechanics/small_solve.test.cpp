// SPDX-License-Identifier: MIT
#include "catch2_bridge.hpp"

#include <cmath>
#include <limits>
#include <random>

#include "qdot/ad/vector.hpp"
#include "qdot/mechanics/equations/small_solve.hpp"

using namespace qdot;

namespace {

constexpr double rounded = 1e-12;  // times the condition, which is below 100 here
constexpr double threshold = 1e-13;

// A positive matrix without the entries that `present` leaves away, which are those of uncoupled halves where it is not whole.
template <int n>
Matrix<double, n> random_matrix(std::mt19937& random, bool whole) {
  std::uniform_real_distribution<double> entry(-1.0, 1.0);
  Matrix<double, n> R;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) R(i, j) = entry(random);
  Matrix<double, n> M = R * R.transpose() + Matrix<double, n>::Identity();
  if (!whole)
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        if (i % 2 != j % 2) M(i, j) = 0.0;
  return M;
}

template <int n>
detail::ComponentMask packed(const Matrix<double, n>& M, double* triangle) {
  detail::ComponentMask present = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= i; ++j) {
      triangle[detail::triangle_index(i, j)] = M(i, j);
      if (M(i, j) != 0.0) present |= detail::bit(1, detail::triangle_index(i, j));
    }
  return present;
}

// M times what comes out, less what was asked for.
template <int n>
double missed(bool whole) {
  std::mt19937 random(n);
  double worst = 0.0;
  for (int sample = 0; sample < 20; ++sample) {
    const Matrix<double, n> M = random_matrix<n>(random, whole);
    const Vector<double, n> b = Vector<double, n>::Random();
    double triangle[n * (n + 1) / 2], factors[n * (n + 1) / 2], inverse[n];
    detail::ComponentMask present = packed(M, triangle), mask = ~detail::ComponentMask(0);
    std::copy_n(triangle, n * (n + 1) / 2, factors);
    Vector<double, n> x = b, y = b;
    REQUIRE(detail::solved_in_place<n>(triangle, x.data(), threshold, present));
    REQUIRE(detail::factored_in_place<n>(factors, inverse, threshold, present));
    detail::forward_in_place<n>(factors, y.data(), present, mask);
    for (int i = 0; i < n; ++i) y[i] *= inverse[i];
    detail::backward_in_place<n>(factors, y.data(), present);
    worst = std::max({worst, (M * x - b).norm(), (M * y - b).norm()});
  }
  return worst;
}

}  // namespace

TEST_CASE("a small solution times its matrix is what was asked for, and so is what its factors give") {
  for (const bool whole : {true, false}) {
    CHECK(missed<1>(whole) < rounded);
    CHECK(missed<2>(whole) < rounded);
    CHECK(missed<3>(whole) < rounded);
    CHECK(missed<4>(whole) < rounded);
    CHECK(missed<5>(whole) < rounded);
    CHECK(missed<6>(whole) < rounded);
    CHECK(missed<8>(whole) < rounded);
  }
}

TEST_CASE("pivots of a small solution are fractions of their diagonal entries") {
  // L = (1; 2 1; 3 4 1), D = (1, 2, 3): the diagonal of M is 1, 6, 44
  double M[] = {1.0, 2.0, 6.0, 3.0, 14.0, 44.0}, b[] = {1.0, 0.0, 0.0}, fraction[3];
  CHECK(detail::solved_in_place<3>(M, b, threshold, ~detail::ComponentMask(0), fraction));
  CHECK_THAT(fraction[1], WithinRel(2.0 / 6.0, rounded));
  CHECK_THAT(fraction[2], WithinRel(3.0 / 44.0, rounded));
  double apart[] = {1.0, 0.0, 6.0}, c[] = {1.0, 3.0};
  CHECK(detail::solved_in_place<2>(apart, c, threshold, detail::ComponentMask(0b101), fraction));
  CHECK(fraction[1] == 1.0);
  CHECK(c[1] == 0.5);
}

TEST_CASE("every pivot of a small solution that is too small, negative or no number is noticed") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {0.0, -1.0, 1e-14, nan, infinity})
    for (int at = 0; at < 4; ++at)
      for (const bool coupled : {false, true}) {
        CAPTURE(bad, at, coupled);
        // Unit pivots but for the bad one; where rows are coupled, L has ones below the diagonal.
        Matrix<double, 4> L = Matrix<double, 4>::Identity(), D = L;
        if (coupled) L.triangularView<Eigen::StrictlyLower>().setOnes();
        D(at, at) = bad;
        const Matrix<double, 4> M = L * D * L.transpose();
        double triangle[10], factors[10], inverse[4], b[] = {1.0, 1.0, 1.0, 1.0};
        packed(M, triangle);
        std::copy_n(triangle, 10, factors);
        detail::ComponentMask present = ~detail::ComponentMask(0);
        const double least = bad == 1e-14 && (!coupled || at == 0) ? 2.0 : 1e-12;  // with none before it, its fraction is one
        CHECK_FALSE(detail::solved_in_place<4>(triangle, b, least, present));
        CHECK_FALSE(detail::factored_in_place<4>(factors, inverse, least, present));
      }
}

TEST_CASE("inertias whose product is no number, or has lost its digits, are left to others") {
  for (const double inertia : {1e-160, 1e160}) {
    double M[] = {inertia, 0.5 * inertia, inertia}, again[] = {inertia, 0.5 * inertia, inertia}, b[] = {inertia, inertia}, inverse[2];
    detail::ComponentMask present = ~detail::ComponentMask(0);
    CHECK_FALSE(detail::solved_in_place<2>(M, b, threshold));
    CHECK_FALSE(detail::factored_in_place<2>(again, inverse, threshold, present));
  }
  for (const double inertia : {1e-140, 1e140}) {
    double M[] = {inertia, 0.5 * inertia, inertia}, b[] = {1.5 * inertia, 1.5 * inertia};
    CHECK(detail::solved_in_place<2>(M, b, threshold));
    CHECK_THAT(b[0], WithinRel(1.0, rounded));
    CHECK_THAT(b[1], WithinRel(1.0, rounded));
  }
}
