// SPDX-License-Identifier: MIT
//
// Euler's equations in four sets of coordinates, as `qdot bench scenes` writes them by hand, are Lagrange's of T = ½ Ω·I Ω with the library's
// rotations, torque included; and so are the tridiagonal equations of a hanging chain, and those in blocks of a
// ladder of four-bars, those of their masses and rods.
#include "catch2_bridge.hpp"

#include <cmath>

#include "bench/four_bar_ladder.hpp"
#include "mechanics/scenes_by_hand.hpp"

using namespace qdot;

namespace {

constexpr double rounded = 1e-12;  // rounding of both, times the condition of M: angles stay 0.4 from the pole
constexpr double rounded_chain = 1e-11;  // the same, times the length of the sums along 40 rods

}  // namespace

TEMPLATE_TEST_CASE("hand-derived rigid bodies are those of T and a torque", "", bench::EulerAnglesBody<true>, bench::RotationVectorBody<true>,
                   bench::QuaternionBody<true>, bench::UnitQuaternionBody<true>, bench::PlacedEulerAnglesBody<true>,
                   bench::PlacedRotationVectorBody<true>, bench::JoinedBodies) {
  CHECK(difference_by_hand<TestType>() < rounded);
}

TEST_CASE("a hand-derived hanging chain is that of its masses and rods") {
  for (const int masses : {1, 2, 10, 40}) {
    Eigen::VectorXd q(2 * masses), v(2 * masses), a(3 * masses), b(3 * masses);
    for (int i = 0; i < 2 * masses; ++i) {
      q[i] = 0.3 * std::sin(1.0 + 3 * i) - (i % 2 == 0 ? 0.0 : 0.5 * (i + 1));
      v[i] = std::cos(2.0 * i);
    }
    const auto solution = constrained_acceleration(bench::hanging_chain(masses), q, v);
    a << solution.qddot, solution.lambda;
    bench::HangingChainByHand{.masses = static_cast<std::size_t>(masses)}(q.data(), v.data(), b.data());
    CHECK((a - b).norm() < rounded_chain * b.norm());
  }
}

TEST_CASE("a hand-derived ladder of four-bars is that of its masses and rods") {
  for (const int loops : {1, 2, 10, 40}) {
    Eigen::VectorXd q(4 * loops), v(4 * loops), a(7 * loops), b(7 * loops);
    for (int i = 0; i < 4 * loops; ++i) {
      q[i] = 0.3 * std::sin(1.0 + 3 * i) + (i % 2 == 1 ? -(i / 4 + 1) : i % 4 == 0 ? 0.0 : 1.0);
      v[i] = std::cos(2.0 * i);
    }
    const auto solution = constrained_acceleration(bench::four_bar_ladder(loops), q, v);
    a << solution.qddot, solution.lambda;
    bench::FourBarLadderByHand{.loops = static_cast<std::size_t>(loops)}(q.data(), v.data(), b.data());
    CHECK((a - b).norm() < rounded_chain * b.norm());
  }
}
