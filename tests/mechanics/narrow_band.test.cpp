// SPDX-License-Identifier: MIT
#include "catch2_bridge.hpp"

#include <cmath>
#include <cstddef>
#include <limits>
#include <random>
#include <vector>

#include "qdot/ad/vector.hpp"
#include "qdot/mechanics/equations/narrow_band.hpp"

using namespace qdot;

namespace {

constexpr double rounded = 1e-12;  // times the condition, which is below 100 here

// Of rows whose numbers are at most `width` apart.
Eigen::MatrixXd band_matrix(Eigen::Index size, Eigen::Index width, std::mt19937& random) {
  std::uniform_real_distribution<double> entry(-1.0, 1.0);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    A(i, i) = 1.0 + 2.0 * static_cast<double>(width);
    for (Eigen::Index j = std::max<Eigen::Index>(0, i - width); j < i; ++j) A(i, j) = A(j, i) = entry(random);
  }
  return A;
}

detail::NarrowBand<> band_of(const Eigen::MatrixXd& A, Eigen::Index width) {
  detail::NarrowBand<> band(static_cast<std::size_t>(A.rows()), static_cast<std::size_t>(width));
  for (Eigen::Index i = 0; i < A.rows(); ++i)
    for (Eigen::Index j = std::max<Eigen::Index>(0, i - width); j <= i; ++j)
      band[band.place(static_cast<std::size_t>(i), static_cast<std::size_t>(j))] = A(i, j);
  return band;
}

constexpr auto no_zeros = [](std::size_t, double, double) { return false; };

}  // namespace

TEST_CASE("a solution by a narrow band times its matrix is what was asked for") {
  std::mt19937 random(1);
  for (Eigen::Index width = 0; width <= 4; ++width)
    for (Eigen::Index size = 1; size <= 12; ++size) {
      CAPTURE(width, size);
      const Eigen::MatrixXd A = band_matrix(size, width, random);
      const Eigen::VectorXd b = Eigen::VectorXd::Random(size);
      auto band = band_of(A, width);
      for (int again = 0; again < 2; ++again) {  // the matrix is still there
        REQUIRE(band.compute(1e-13, no_zeros));
        Eigen::VectorXd x = b;
        band.solve_lower(x.data());
        band.divide(x.data());
        band.solve_upper(x.data());
        CHECK((A * x - b).norm() < rounded);
      }
    }
}

TEST_CASE("a narrow band asks of each pivot that is too small whether it is a zero") {
  // Rows 0, 1, 2 and 3 of a chain whose pivots are all one, but for one that is nothing.
  for (Eigen::Index bad = 0; bad < 4; ++bad) {
    CAPTURE(bad);
    Eigen::MatrixXd L = Eigen::MatrixXd::Identity(4, 4), D = L;
    for (Eigen::Index i = 1; i < 4; ++i)
      if (i - 1 != bad) L(i, i - 1) = 0.5;
    D(bad, bad) = 0.0;
    const Eigen::MatrixXd A = L * D * L.transpose();
    auto band = band_of(A, 1);
    CHECK_FALSE(band.compute(1e-13, no_zeros));
    std::vector<std::size_t> zeros;
    REQUIRE(band.compute(1e-13, [&](std::size_t i, double pivot, double whole) {
      zeros.push_back(i);
      CHECK(pivot == 0.0);
      CHECK(whole == A(bad, bad));
      return true;
    }));
    CHECK(zeros == std::vector<std::size_t>{static_cast<std::size_t>(bad)});
    // L⁻ᵀ e of the zero is a null vector; and what the matrix can give is given.
    Eigen::VectorXd null = Eigen::VectorXd::Unit(4, bad);
    band.solve_upper(null.data());
    CHECK((A * null).norm() < rounded);
    const Eigen::VectorXd b = A * Eigen::VectorXd::Ones(4);
    Eigen::VectorXd x = b;
    band.solve_lower(x.data());
    CHECK(std::abs(x[bad]) < rounded);
    band.divide(x.data());
    band.solve_upper(x.data());
    CHECK((A * x - b).norm() < rounded);
  }
}

TEST_CASE("a narrow band takes nothing for a pivot that is no number, whichever row has it") {
  std::mt19937 random(2);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1.0})
    for (Eigen::Index row = 0; row < 5; ++row) {
      Eigen::MatrixXd A = band_matrix(5, 2, random);
      A(row, row) = bad;
      CHECK_FALSE(band_of(A, 2).compute(1e-13, no_zeros));
    }
}

TEST_CASE("a narrow band has the digits of pivots whose products have none") {
  // 1e-160 squared is no number any more: such rows are taken one by one.
  std::mt19937 random(3);
  const Eigen::MatrixXd A = band_matrix(6, 1, random) * 1e-160;
  const Eigen::VectorXd b = A * Eigen::VectorXd::Ones(6);
  auto band = band_of(A, 1);
  REQUIRE(band.compute(1e-13, no_zeros));
  Eigen::VectorXd x = b;
  band.solve_lower(x.data());
  band.divide(x.data());
  band.solve_upper(x.data());
  CHECK((x - Eigen::VectorXd::Ones(6)).norm() < rounded);
}
