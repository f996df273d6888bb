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

// A positive matrix, of two halves that are not coupled where it is not whole.
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
void write_triangle(const Matrix<double, n>& M, double* triangle) {
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= i; ++j) triangle[detail::triangle_index(i, j)] = M(i, j);
}

// M times what comes out, less what was asked for.
template <int n>
double missed(bool whole) {
  std::mt19937 random(n);
  double worst = 0.0;
  for (int sample = 0; sample < 20; ++sample) {
    const Matrix<double, n> M = random_matrix<n>(random, whole);
    const Vector<double, n> b = Vector<double, n>::Random();
    double triangle[n * (n + 1) / 2];
    write_triangle(M, triangle);
    Vector<double, n> x = b;
    REQUIRE(detail::solved_in_place<n>(triangle, x.data(), threshold));
    worst = std::max(worst, (M * x - b).norm());
  }
  return worst;
}

}  // namespace

TEST_CASE("a small solution times its matrix is what was asked for") {
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
        double triangle[10], b[] = {1.0, 1.0, 1.0, 1.0};
        write_triangle(M, triangle);
        const double least = bad == 1e-14 && (!coupled || at == 0) ? 2.0 : 1e-12;  // with none before it, its fraction is one
        CHECK_FALSE(detail::solved_in_place<4>(triangle, b, least));
      }
}

TEST_CASE("inertias whose product is no number, or has lost its digits, are left to others") {
  for (const double inertia : {1e-160, 1e160}) {
    double M[] = {inertia, 0.5 * inertia, inertia}, b[] = {inertia, inertia};
    CHECK_FALSE(detail::solved_in_place<2>(M, b, threshold));
  }
  for (const double inertia : {1e-140, 1e140}) {
    double M[] = {inertia, 0.5 * inertia, inertia}, b[] = {1.5 * inertia, 1.5 * inertia};
    CHECK(detail::solved_in_place<2>(M, b, threshold));
    CHECK_THAT(b[0], WithinRel(1.0, rounded));
    CHECK_THAT(b[1], WithinRel(1.0, rounded));
  }
}
