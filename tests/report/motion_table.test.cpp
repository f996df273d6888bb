// SPDX-License-Identifier: MIT
#include "qdot/report/motion_table.hpp"

#include <cmath>

#include "../catch2_bridge.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/report/csv.hpp"

namespace {

using namespace qdot;

constexpr double run_error = 1e-8;  // of Dop853 at rtol = 1e-10 over one turn, its dense output included

const auto oscillator = mechanical_system<1>([](const auto&, const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.5 * q[0] * q[0]; });

TEST_CASE("a table of a motion has its states at equal times, ends included, by the coordinates' names") {
  const auto run = simulate(oscillator, State<1>{1.0, {1.0}, {0.0}}, 3.0, Dop853{}, {.rtol = 1e-10});
  const report::Table table = report::motion_table(oscillator, run, 5);
  REQUIRE(table.rows() == 5);
  CHECK(report::csv(table).substr(0, 16) == "t,q0,qdot0\n1,1,0");
  for (std::size_t i = 0; i < 5; ++i) {
    const double t = 1.0 + 0.5 * static_cast<double>(i);
    CHECK(table.column("t").values[i] == t);
    CHECK_THAT(table.column("q0").values[i], WithinAbs(std::cos(t - 1.0), run_error));
    CHECK_THAT(table.column("qdot0").values[i], WithinAbs(-std::sin(t - 1.0), run_error));
  }
}

TEST_CASE("a table of samples has a row for each output time that the run reached") {
  const auto run = simulate(oscillator, State<1>{0.0, {1.0}, {0.0}}, 2.0, Dop853{}, {.rtol = 1e-10, .output_times = {0.25, 2.0}, .keep_trajectory = false});
  const report::Table table = report::sample_table(oscillator, run);
  REQUIRE(table.rows() == 2);
  CHECK(table.column("t").values == std::vector<double>{0.25, 2.0});
  CHECK_THAT(table.column("q0").values[0], WithinAbs(std::cos(0.25), run_error));
  CHECK_THROWS_AS(report::motion_table(oscillator, run, 5), InvalidValue);  // nothing was kept
}

TEST_CASE("a table that cannot be says what it needs") {
  const auto run = simulate(oscillator, State<1>{0.0, {1.0}, {0.0}}, 1.0, Dop853{});
  CHECK_THROWS_AS(report::motion_table(oscillator, run, 1), InvalidValue);
  CHECK_THROWS_AS(report::sample_table(oscillator, run), InvalidValue);
  const auto plane = mechanical_system<2>([](const auto&, const auto& v) { return 0.5 * v.squaredNorm(); },
                                          [](const auto& q) { return 0.5 * q.squaredNorm(); });
  CHECK_THROWS_AS(report::motion_table(plane, run, 3), DimensionError);
}

}  // namespace
