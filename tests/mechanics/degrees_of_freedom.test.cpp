// SPDX-License-Identifier: MIT
#include "catch2_bridge.hpp"

#include <cmath>
#include <limits>

#include "qdot/mechanics/degrees_of_freedom.hpp"
#include "qdot/mechanics/velocity.hpp"

using namespace qdot;

namespace {

// Rod (x_G, y_G, φ) hinged at the origin, ring (x, y) on the rod.
constexpr double half = 0.75;
const auto rod_and_ring = [](const auto& x) {
  using std::cos;
  using std::sin;
  return vector(x[0] - half * cos(x[2]), x[1] - half * sin(x[2]), x[4] * cos(x[2]) - x[3] * sin(x[2]));
};

Vector<double, 5> rod_and_ring_at(double r, double phi) {
  Vector<double, 5> x;
  x << half * std::cos(phi), half * std::sin(phi), phi, r * std::cos(phi), r * std::sin(phi);
  return x;
}

}  // namespace

TEST_CASE("the rod with the ring has 3 + 2 − 3 = 2 degrees of freedom") {
  const ConstraintRank rank = constraint_rank(rod_and_ring, rod_and_ring_at(0.4, 0.2));
  CHECK(rank.coordinates == 5);
  CHECK(rank.equations == 3);
  CHECK(rank.rank == 3);
  CHECK(rank.degrees_of_freedom == 2);
  CHECK(rank.dependent.empty());
  CHECK(rank.clear());
}

TEST_CASE("a constraint written twice, in any units, counts once and is named") {
  const auto twice = [](const auto& x) {
    const auto phi = rod_and_ring(x);
    return vector(phi[0], phi[1], 1e6 * phi[0] - 3.0 * phi[1], phi[2]);
  };
  const ConstraintRank rank = constraint_rank(twice, rod_and_ring_at(0.4, 0.2));
  CHECK(rank.rank == 3);
  CHECK(rank.degrees_of_freedom == 2);
  CHECK(rank.dependent == std::vector<Eigen::Index>{2});
  CHECK(rank.gap > 1e10);
}

TEST_CASE("a parallelogram with a third parallel bar has one degree of freedom, and one equation too many") {
  // three equal cranks at x = 0, 1, 2 that carry a plate (x, y, φ); their angles a, b, c
  const auto linkage = [](const auto& x) {
    using std::cos;
    using std::sin;
    return vector(x[0] - cos(x[3]), x[1] - sin(x[3]),                                          //
                  x[0] + cos(x[2]) - 1.0 - cos(x[4]), x[1] + sin(x[2]) - sin(x[4]),            //
                  x[0] + 2.0 * cos(x[2]) - 2.0 - cos(x[5]), x[1] + 2.0 * sin(x[2]) - sin(x[5]));
  };
  Vector<double, 6> x;
  x << std::cos(0.7), std::sin(0.7), 0.0, 0.7, 0.7, 0.7;
  const ConstraintRank rank = constraint_rank(linkage, x);
  CHECK(rank.equations == 6);
  CHECK(rank.rank == 5);
  CHECK(rank.degrees_of_freedom == 1);
  CHECK(rank.dependent.size() == 1);
}

TEST_CASE("a rigid body of four points has six degrees of freedom; a fifth point's four bars are one too many") {
  const auto bars = [](const auto& x) {
    using S = std::decay_t<decltype(x[0])>;
    const Eigen::Index points = x.size() / 3;
    Vector<S, Dynamic> phi(points * (points - 1) / 2);
    Eigen::Index row = 0;
    for (Eigen::Index i = 0; i < points; ++i) {
      for (Eigen::Index j = 0; j < i; ++j) phi[row++] = (x.segment(3 * i, 3) - x.segment(3 * j, 3)).squaredNorm();
    }
    return phi;
  };
  Eigen::VectorXd x(15);
  x << 0.0, 0.0, 0.0, 1.0, 0.0, 0.1, 0.2, 1.1, 0.0, 0.3, 0.2, 0.9, -0.7, 0.4, 0.5;
  CHECK(degrees_of_freedom(bars, x.head(12)) == 6);
  const ConstraintRank rank = constraint_rank(bars, x);
  CHECK(rank.degrees_of_freedom == 6);
  CHECK(rank.dependent == std::vector<Eigen::Index>{9});  // ten bars, the last to be added is superfluous
}

TEST_CASE("no constraints leave every coordinate free; more rows than columns cannot bind more than there is") {
  CHECK(rank_of_rows(Eigen::MatrixXd(0, 4)).degrees_of_freedom == 4);
  Eigen::MatrixXd rows(3, 2);
  rows << 1.0, 0.0, 1.0, 1.0, 0.0, 1.0;
  const ConstraintRank rank = rank_of_rows(rows);
  CHECK(rank.degrees_of_freedom == 0);
  CHECK(rank.dependent == std::vector<Eigen::Index>{2});
}

TEST_CASE("a constraint without gradient binds nothing and is named") {
  const auto squared = [](const auto& x) {
    const auto g = x[0] * x[0] + x[1] * x[1] - 1.0;
    return vector(g * g);
  };
  const ConstraintRank rank = constraint_rank(squared, Vector<double, 2>(0.6, 0.8));
  CHECK(rank.rank == 0);
  CHECK(rank.dependent == std::vector<Eigen::Index>{0});
}

TEST_CASE("rows that are nearly parallel are kept or dropped in the open: the gap is small") {
  Eigen::MatrixXd rows(3, 3);
  rows << 1.0, 0.0, 0.0, 1.0, 1e-9, 0.0, 1.0, 0.0, 1e-11;
  const ConstraintRank rank = rank_of_rows(rows);
  CHECK(rank.rank == 2);
  CHECK_FALSE(rank.clear());
  CHECK(rank.dependent.size() == 1);
}

TEST_CASE("a Jacobian that is not finite is refused by the constraint's number") {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Identity(2, 2);
  rows(1, 0) = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(rank_of_rows(rows), "the gradient of constraint 1 must be finite, but it is not; choose a configuration "
                                        "where the constraint is smooth");
  CHECK_THROWS_AS(rank_of_rows(rows, 0.0), InvalidValue);
}
