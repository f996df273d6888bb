// SPDX-License-Identifier: MIT
#include "qdot/analysis/work_precision.hpp"

#include <cmath>

#include "catch2_bridge.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/symplectic.hpp"
#include "scenes/harmonic_oscillator.hpp"
#include "scenes/kepler.hpp"

using namespace qdot;

namespace {

const State<2> pericentre{0.0, {0.4, 0.0}, {0.0, 2.0}};
constexpr double two_periods = 12.566370614359172;

const WorkPrecisionOptions short_study{.tolerances = {1e-4, 1e-8, 1e-12}, .outputs = 8, .seconds_per_cell = 1e-4, .longest_run = 60};

}  // namespace

TEST_CASE("errors of a study are those against the closed orbit") {
  const auto kepler = mechanical_system<2>(scenes::Kepler{});
  const auto study = work_precision(kepler, pericentre, two_periods, short_study, by_tolerance("dopri5", Dopri5{}));
  REQUIRE(study.measurements.size() == 3);
  for (const Measurement& m : study.measurements) {
    INFO(m.method << " " << m.setting);
    REQUIRE(m.completed());
    // After two periods the motion is back at its start, but for the rounding of 4π (7e-16) and of 0.4.
    const auto run = simulate(kepler, pericentre, two_periods, Dopri5{}, {.rtol = m.setting, .atol = m.setting});
    double expected = 0;
    const Eigen::Vector4d start(0.4, 0, 0, 2);
    for (Eigen::Index i = 0; i < 4; ++i) expected = std::max(expected, std::abs(run.y[i] - start[i]) / study.reference.scale[i]);
    CHECK_THAT(m.end_error, WithinAbs(expected, 0.01 * expected + 2e-14));
    CHECK(m.largest_error >= m.end_error);
    CHECK(m.evaluations == run.statistics.evaluations);  // the dense output of dopri5 costs none
    CHECK(m.cpu_minimum > 0);
    CHECK(m.cpu_median >= m.cpu_minimum);
  }
}

TEST_CASE("halving the step of a symplectic method of order 4 divides its error by 16") {
  const auto oscillator = mechanical_system<1>(scenes::HarmonicOscillator{});
  const State<1> start{0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)};
  const auto study = work_precision(oscillator, start, 10.0, short_study,
                                    by_step("bm4", [](double h) { return Splitting{.step = h, .scheme = SplittingScheme::blanes_moan_4}; }));
  int compared = 0;
  for (const Measurement& a : study.measurements)
    for (const Measurement& b : study.measurements) {
      if (std::abs(a.setting / b.setting - 2) > 1e-12 || b.largest_error < 1e-11 || a.largest_error > 1e-4) continue;
      CHECK_THAT(a.largest_error / b.largest_error, WithinAbs(16, 3));
      ++compared;
    }
  CHECK(compared >= 2);
  CHECK(study.energy_conserved);
}

TEST_CASE("the cheapest run is the least of those that are accurate enough") {
  WorkPrecision study;
  study.reference.uncertainty = 0.9e-12;
  const auto add = [&](const char* method, double error, double cpu, Outcome outcome = Outcome::completed) {
    Measurement m;
    m.method = method;
    m.largest_error = error;
    m.cpu_median = cpu;
    m.outcome = outcome;
    study.measurements.push_back(m);
  };
  add("a", 1e-4, 1.0);
  add("b", 1e-6, 2.0);
  add("c", 1e-7, 0.5, Outcome::step_too_small);
  add("d", 5e-14, 8.0);  // better than the reference can tell
  CHECK(study.cheapest(1e-3)->method == "a");
  CHECK(study.cheapest(1e-5)->method == "b");
  CHECK(study.cheapest(1e-9)->method == "d");
  CHECK(study.cheapest(1e-13) == nullptr);
  CHECK(study.cheapest_by_decade().size() == 11);  // to 1e-11, ten times the uncertainty
}

TEST_CASE("a run that fails is kept with its outcome") {
  const auto free = mechanical_system<1>([](const auto& qdot) { return 0.5 * qdot[0] * qdot[0]; }, [](const auto& q) { return 0.0 * q[0]; });
  ReferenceMotion reference = reference_motion(free, State<1>{0.0, Vector<double, 1>(0.0), Vector<double, 1>(1.0)}, {1.0, 2.0});
  Contender broken{"broken", false, [](double) -> ObservedRun { throw NonFinite("q", 0.7, "q must be finite, but is not"); }, {}};
  Contender stuck{"stuck", false, [](double) { return ObservedRun{{1, 2, 3, 4}, Outcome::step_too_small, "stuck", 0.5}; }, {}};
  WorkPrecisionOptions options = short_study;
  const auto study = work_precision(reference, 0.0, {broken, stuck}, {}, options);
  REQUIRE(study.measurements.size() == 4);  // given up after the second failure of each
  CHECK(study.measurements[0].outcome == Outcome::non_finite);
  CHECK(study.measurements[2].outcome == Outcome::step_too_small);
  CHECK(study.measurements[2].evaluations == 3);
  CHECK(std::isnan(study.measurements[2].largest_error));
  CHECK(study.cheapest(1.0) == nullptr);
}
