// SPDX-License-Identifier: MIT
#include "qdot/analysis/generalized_alignment_index.hpp"

#include <cmath>

#include "catch2_bridge.hpp"
#include "error_message.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "scenes/henon_heiles.hpp"

using qdot::generalized_alignment_index;
using qdot::Dop853;
using qdot::State;

namespace {

const qdot::Options fine{.rtol = 1e-11, .atol = 1e-12};

// Two coordinates that know nothing of each other: hills (k < 0), springs of the same stiffness, or pendula.
struct Pair {
  double k = 0.0, g = 0.0;
  auto T(const auto& v) const { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }
  auto V(const auto& q) const {
    using std::cos;
    return 0.5 * k * (q[0] * q[0] + q[1] * q[1]) - g * (cos(q[0]) + cos(q[1]));
  }
};

}  // namespace

// One deviation of each grows like exp(t), one decays: w_1, w_2 in the plane of growth, and the angle between them stays; three of them lie in that plane
// and in what decays, so that the volume of three falls like exp(−2t), of four like exp(−4t).
TEST_CASE("on top of two equal hills the volume of three deviations falls like exp(-2t), of four like exp(-4t)") {
  const auto tops = qdot::mechanical_system<2>(Pair{.k = -1.0});
  for (const int k : {3, 4}) {
    const auto found = generalized_alignment_index(tops, State<2>{0.0, {0.0, 0.0}, {0.0, 0.0}}, 6.0, Dop853{}, fine,
                                                   {.deviations = k, .interval = 1.0, .aligned = 0.0});
    REQUIRE(found.index.size() == 6);
    const double falls = std::log(found.index[3] / found.index[5]) / 2.0;
    CHECK(std::abs(falls - 2.0 * (k - 2)) < 2e-3);  // exp(−2·3) of the start is left in the directions
  }
}

TEST_CASE("deviations of two equal springs of unit frequency keep their angles and lengths") {
  const auto springs = qdot::mechanical_system<2>(Pair{.k = 1.0});
  for (const int k : {2, 4}) {
    const auto found = generalized_alignment_index(springs, State<2>{0.0, {1.0, 0.3}, {0.0, 0.5}}, 50.0, Dop853{}, fine, {.deviations = k});
    CHECK_FALSE(found.chaotic);
    CHECK(found.t == 50.0);
    for (const double index : found.index) CHECK(std::abs(index - 1.0) < 1e-8);
    for (const double growth : found.growth) CHECK(std::abs(growth) < 1e-8);
  }
}

// Skokos, Bountis, Antonopoulos (2007): GALI_2 of regular motions of two coordinates goes to a constant, GALI_3 falls like t^-2 and GALI_4 like t^-4.
TEST_CASE("of two swinging pendula GALI_2 stays, GALI_3 falls like t^-2 and GALI_4 like t^-4") {
  const auto pendula = qdot::mechanical_system<2>(Pair{.g = 1.0});
  const State<2> start{0.0, {1.5, 0.7}, {0.0, 0.4}};
  for (const int k : {2, 3, 4}) {
    CAPTURE(k);
    const auto found = generalized_alignment_index(pendula, start, 1000.0, Dop853{}, fine, {.deviations = k, .interval = 10.0, .aligned = 0.0});
    REQUIRE(found.index.size() == 100);
    double early = 0.0, late = 0.0;  // means over ten looks, as it swings with the motion
    for (std::size_t i = 0; i < 10; ++i) {
      early += std::log(found.index[5 + i]) / 10.0;
      late += std::log(found.index[90 + i]) / 10.0;
    }
    const double power = (late - early) / std::log(955.0 / 105.0);
    CHECK(std::abs(power + 2.0 * (k - 2)) < 0.2);  // terms of 1/t beside the power
    CHECK(found.growth.back() < 2.0 * std::log(1000.0));
  }
}

// The two motions of their figures, of energy 1/8: x = 0 with y = −0.25, ẋ = 0.42081 is chaotic, with λ₁ = 0.047; y = 0.1, ẋ = 0.49057 is not.
TEST_CASE("published motions of Henon and Heiles are found regular and chaotic") {
  const auto system = qdot::mechanical_system<2>(qdot::scenes::HenonHeiles{});
  const auto chaotic = generalized_alignment_index(system, State<2>{0.0, {0.0, -0.25}, {0.42081, 0.0}}, 2000.0, Dop853{}, fine, {.interval = 10.0});
  CHECK(chaotic.chaotic);
  CHECK(chaotic.completed());
  CHECK(chaotic.t > 0.5 * 18.4 / 0.047);
  CHECK(chaotic.t < 2.5 * 18.4 / 0.047);
  CHECK(chaotic.message.starts_with("chaotic: 2 deviations have aligned to "));
  const auto regular = generalized_alignment_index(system, State<2>{0.0, {0.0, 0.1}, {0.49057, 0.0}}, 1000.0, Dop853{}, fine, {.interval = 10.0});
  CHECK_FALSE(regular.chaotic);
  CHECK(regular.index.back() > 1e-2);
}

// Two oscillators with exponents −1, −2 and −1/2, −3: two deviations align with the slowest, and shrink.
TEST_CASE("deviations that align because they decay are no chaos, and friction that sticks takes one") {
  const auto springs = qdot::mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); },
                                                  [](const auto& q) { return q[0] * q[0] + 0.75 * q[1] * q[1]; });
  const auto damped = scene(springs, qdot::viscous_damping(qdot::Vector<double, 2>(3.0, 3.5)));
  const auto found = generalized_alignment_index(damped, State<2>{0.0, {1.0, 0.3}, {0.0, 0.5}}, 60.0, Dop853{}, fine);
  CHECK(found.completed());
  CHECK_FALSE(found.chaotic);
  CHECK(found.index.back() < 1e-8);
  CHECK(std::abs(found.growth.back() + 0.5 * 60.0) < 10.0);
  CHECK(found.message.find("the motion falls onto what attracts it") != std::string::npos);

  const auto block = scene(springs, qdot::dry_friction("pad", 0, 10.0), qdot::viscous_damping(qdot::Vector<double, 2>(0.0, 3.5)));
  const auto stops = generalized_alignment_index(block, State<2>{0.0, {0.2, 1.0}, {1.5, 0.0}}, 10.0, Dop853{}, fine, {.deviations = 4});
  CHECK(stops.outcome == qdot::Outcome::not_differentiable);
  CHECK(stops.message.find("leaves 3 of them") != std::string::npos);
  const auto left = generalized_alignment_index(block, State<2>{0.0, {0.2, 1.0}, {1.5, 0.0}}, 10.0, Dop853{}, fine);
  CHECK(left.completed());
  CHECK_FALSE(left.chaotic);
}

TEST_CASE("an alignment refuses what it cannot watch") {
  const auto springs = qdot::mechanical_system<2>(Pair{.k = 1.0});
  const State<2> start{0.0, {1.0, 0.3}, {0.0, 0.5}};
  const auto message = [&](double t_end, const qdot::GeneralizedAlignmentOptions& options) {
    return qdot::error_message([&] { generalized_alignment_index(springs, start, t_end, Dop853{}, fine, options); });
  };
  CHECK(message(1.0, {.deviations = 1}).starts_with("an alignment is of two deviations or more, but 1 were asked for"));
  CHECK(message(1.0, {.deviations = 5}).starts_with("there must be from 1 to 4 directions"));
  CHECK(message(1.0, {.interval = -1.0}).starts_with("the time between two looks must be positive"));
  CHECK(message(1.0, {.aligned = 2.0}).starts_with("the index below which deviations are aligned must lie from 0 to 1, but is 2"));
  CHECK(message(0.0, {}).starts_with("the end of the run must be finite and not its start"));
}
