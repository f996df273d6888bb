// SPDX-License-Identifier: MIT
//
// How the rows of the hard cases are measured.
#include "hard/motion.cpp"

#include "../catch2_bridge.hpp"

using namespace qdot;
using namespace qdot::hard;

TEST_CASE("digits are counted beside the largest entry of each half, or beside the scale that is given") {
  Problem problem{.name = "", .t_end = 1, .start = numbers({0, 0, 0, 0}), .exact = numbers({100, 1, 1e-3, 1e-5}), .reference_digits = 20};
  CHECK_THAT(digits_reached(problem, numbers({100, 1.0001, 1e-3, 1e-5})), WithinAbs(6.0, 1e-9));
  CHECK_THAT(digits_reached(problem, numbers({100, 1, 1e-3, 1.1e-5})), WithinAbs(3.0, 1e-9));
  problem.scale = numbers({1, 1, 1, 1e-5});
  CHECK_THAT(digits_reached(problem, numbers({100, 1, 1e-3, 1.1e-5})), WithinAbs(1.0, 1e-9));
  CHECK(digits_reached(problem, numbers({100, std::nan(""), 1, 1})) == 0.0);
}

TEST_CASE("the digits of a comparison end where the reference's end, or those of an amplified rounding") {
  Problem problem{.name = "", .t_end = 1, .start = {}, .exact = {}, .reference_digits = 6};
  CHECK(digits_good(problem) == 6.0);
  problem.reference_digits = 22;
  problem.gain = 1e4;
  CHECK_THAT(digits_good(problem), WithinAbs(15.65 - 4, 0.01));
}

TEST_CASE("a motion whose type is forgotten is stepped like the system itself") {
  const auto system = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.5 * q[0] * q[0]; });
  const Problem problem{.name = "oscillator", .t_end = 2.0, .start = numbers({1, 0}), .exact = numbers({std::cos(2.0), -std::sin(2.0)}),
                        .reference_digits = 16};
  const Row row = solved(problem, motion(system), hard::By::dop853, {.rtol = 1e-13, .atol = 1e-14});
  const auto run = simulate(system, FirstOrderState{0.0, problem.start}, 2.0, Dop853{}, {.rtol = 1e-13, .atol = 1e-14, .keep_trajectory = false});
  CHECK(row.evaluations - run.statistics.evaluations == 3);  // dense output of the first step, for the energy at its beginning
  CHECK(row.digits_reached == digits_reached(problem, run.y));
  CHECK(row.digits_reached > 12.5);
  CHECK(*row.energy_drift_max < 1e-13);
  CHECK(row.outcome == "completed");
}
