// SPDX-License-Identifier: MIT
//
// Motions that go side by side in the lanes of a pack end where they end alone, and one that fails does not disturb the others. Orbits about a
// centre have closed forms: from the pericentre of an ellipse of semi-axis 1 and strength μ the apocentre comes after π/√μ, and the
// pericentre again after 2π/√μ.
#include "catch2_bridge.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "error_message.hpp"
#include "qdot/integrate/counter_random.hpp"
#include "qdot/integrate/many_in_lanes.hpp"

using namespace qdot;

namespace {

template <class S = double>
struct Orbit {
  S mu = 1.0;
  auto T(const auto& qdot) const { return 0.5 * (qdot[0] * qdot[0] + qdot[1] * qdot[1]); }
  auto V(const auto& q) const {
    using std::sqrt;
    return -mu / sqrt(q[0] * q[0] + q[1] * q[1]);
  }
};

// The same, but at its `left`-th question V throws.
struct Refusing {
  int* left;
  auto T(const auto& qdot) const { return Orbit<>{}.T(qdot); }
  auto V(const auto& q) const {
    if (--*left == 0) throw StopRequest("enough");
    return Orbit<>{}.V(q);
  }
};

constexpr double pi = std::numbers::pi;
constexpr std::size_t count = 37;  // no multiple of the lanes, so that some have nothing to do at the end
const auto orbit = mechanical_system<2>(Orbit<>{});
const Options options{.rtol = 1e-11, .atol = 1e-13};

// An ellipse of semi-axis 1 about μ, begun at its pericentre.
State<2> at_pericentre(double e, double mu = 1.0) { return {0.0, {1.0 - e, 0.0}, {0.0, std::sqrt(mu * (1.0 + e) / (1.0 - e))}}; }
double eccentricity(std::size_t i) { return CounterRandom(5, i).uniform(0.0, 0.7); }
// Starts are functions, of one type: what runs from them is compiled once.
State<2> start_of(std::size_t i) { return at_pericentre(eccentricity(i)); }
State<2> start_from_the_last(std::size_t i) { return start_of(count - 1 - i); }
State<2> start_with_failures(std::size_t i) {
  if (i == 3) throw std::runtime_error("no start");
  if (i == 7) return {0.0, {0.0, 0.0}, {1.0, 0.0}};   // V is infinite there
  if (i == 11) return {0.0, {1.0, 0.0}, {0.0, 0.0}};  // falls into the centre
  if (i == 12) return {0.0, {std::numeric_limits<double>::quiet_NaN(), 0.0}, {0.0, 0.0}};
  return start_of(i);
}

// Of an orbit of eccentricity 0.7, by the pericentre where the error along the orbit shows most: steps of 1e-11 for one turn, times its gain there.
constexpr double after_one_turn = 1e-8;

const auto apocentre = event("apocentre", [](const auto& q, const auto& qdot) { return q[0] * qdot[0] + q[1] * qdot[1]; }).falling().stop();

bool are_the_same(const std::vector<Kept<MotionEnd<2>>>& a, const std::vector<Kept<MotionEnd<2>>>& b) {
  bool same = a.size() == b.size();
  for (std::size_t i = 0; same && i < a.size(); ++i)
    same = a[i].completed() && b[i].completed() && a[i].value->state.q == b[i].value->state.q && a[i].value->state.qdot == b[i].value->state.qdot;
  return same;
}

}  // namespace

TEST_CASE("orbits of many eccentricities, side by side, are back at their pericentres after one period") {
  const auto ends = ensemble(orbit, count, start_of, 2 * pi, Dop853{}, options);
  for (std::size_t i = 0; i < count; ++i) {
    REQUIRE(ends[i].completed());
    CHECK(ends[i].value->completed());
    CHECK(ends[i].value->state.t == 2 * pi);
    CHECK((ends[i].value->state.q - start_of(i).q).norm() < after_one_turn);
  }
}

TEST_CASE("a motion takes as many steps in a lane as alone, and ends where it does within rounding") {
  const auto ends = ensemble(orbit, count, start_of, 5.0, Dop853{}, options);
  constexpr double steps_of_rounding = 1e-12;  // fifty steps of some units each, times the gain of an orbit of eccentricity 0.7
  for (std::size_t i = 0; i < count; ++i) {
    const auto alone = simulate(orbit, start_of(i), 5.0, Dop853{}, options);
    REQUIRE(ends[i].completed());
    CHECK(ends[i].value->steps == alone.statistics.steps);
    CHECK(ends[i].value->evaluations <= alone.statistics.evaluations);  // without those of dense output
    CHECK((ends[i].value->state.q - alone.y.head<2>()).norm() < steps_of_rounding);
  }
}

TEST_CASE("orbits of many strengths go side by side, each by its own parameter, backwards as well") {
  const auto strength = [](std::size_t i) { return Vector<double, 1>(1.0 + 0.1 * static_cast<double>(i)); };
  const auto orbits = family<2>([](const auto& p) { return Orbit<std::remove_cvref_t<decltype(p[0])>>{p[0]}; }, strength);
  const auto start = [&](std::size_t i) { return at_pericentre(0.3, strength(i)[0]); };
  const auto ends = ensemble(orbits, count, start, 2 * pi, Dop853{}, options, apocentre, {.threads = 2});
  for (std::size_t i = 0; i < count; ++i) {
    REQUIRE(ends[i].completed());
    const MotionEnd<2>& end = *ends[i].value;
    CHECK(end.outcome == Outcome::stopped_by_event);
    CHECK(end.event == "apocentre");
    constexpr double half_a_turn = 1e-9;
    CHECK(std::abs(end.state.t - pi / std::sqrt(strength(i)[0])) < half_a_turn);
    CHECK(std::abs(end.state.q.norm() - 1.3) < half_a_turn);
  }
  const auto before = ensemble(orbits, count, [&](std::size_t i) { return State<2>{pi / std::sqrt(strength(i)[0]), {-1.3, 0.0},
                                                                                        -start(i).qdot * 0.7 / 1.3}; }, 0.0, Dop853{}, options);
  for (std::size_t i = 0; i < count; ++i) CHECK((before[i].value->state.q - start(i).q).norm() < after_one_turn);
}

TEST_CASE("ends are the same bits for any number of threads, any chunk and any order of motions") {
  const auto plain = ensemble(orbit, count, start_of, 5.0, Dop853{}, options, {.threads = 1});
  CHECK(are_the_same(plain, ensemble(orbit, count, start_of, 5.0, Dop853{}, options, {.threads = 3, .chunk = 5})));
  CHECK(are_the_same(plain, ensemble(orbit, count, start_of, 5.0, Dop853{}, options, {.threads = 1, .chunk = 1})));
  auto turned = ensemble(orbit, count, start_from_the_last, 5.0, Dop853{}, options);
  std::reverse(turned.begin(), turned.end());
  CHECK(are_the_same(plain, turned));
  const double sum = ensemble(orbit, count, start_of, 5.0, Dop853{}, options, EventList<>{}, 0.0,
                              [](double& x, std::size_t, auto&& kept) { x += kept.value->state.q[0]; });
  double expected = 0.0;
  for (const auto& end : plain) expected += end.value->state.q[0];
  CHECK(sum == expected);
}

TEST_CASE("a motion that fails says what simulate() says of it, and its neighbours go on") {
  const auto ends = ensemble(orbit, count, start_with_failures, 5.0, Dop853{}, options);
  const auto plain = ensemble(orbit, count, start_of, 5.0, Dop853{}, options);
  for (std::size_t i = 0; i < count; ++i) {
    if (i == 3) {
      CHECK(ends[i].message() == "no start");
    } else if (i == 7 || i == 12) {
      CHECK(ends[i].message() == error_message([&] { simulate(orbit, start_with_failures(i), 5.0, Dop853{}, options); }));
    } else if (i == 11) {
      const auto alone = simulate(orbit, start_with_failures(i), 5.0, Dop853{}, options);
      REQUIRE(ends[i].completed());
      CHECK(ends[i].value->outcome == alone.outcome);
      CHECK(ends[i].value->message == alone.message);
      CHECK(!ends[i].value->completed());
    } else {
      CHECK(ends[i].value->state.q == plain[i].value->state.q);
    }
  }
}

TEST_CASE("budgets, stop times and bad options are kept as one by one") {
  const auto few = ensemble(orbit, 3, start_of, 5.0, Dop853{}, {.rtol = 1e-11, .max_steps = 4});
  for (const auto& end : few) CHECK(end.value->outcome == Outcome::step_limit);
  CHECK(few[1].value->message == simulate(orbit, start_of(1), 5.0, Dop853{}, {.rtol = 1e-11, .max_steps = 4}).message);
  const Options stopping{.rtol = 1e-11, .stop_times = {2.0}};
  CHECK(ensemble(orbit, 2, start_of, 5.0, Dop853{}, stopping)[1].value->state.q == simulate(orbit, start_of(1), 5.0, Dop853{}, stopping).y.head<2>());
  CHECK_THROWS_AS(ensemble(orbit, 2, start_of, 5.0, Dop853{}, {.rtol = -1.0}), InvalidValue);
  CHECK_THROWS_AS(ensemble(orbit, 2, start_of, std::nan(""), Dop853{}, options), InvalidValue);
  CHECK_THROWS_AS(ensemble(orbit, 2, start_of, 1.0, Dop853{}, options, {.threads = -1}), InvalidValue);
  CHECK(ensemble(orbit, 0, start_of, 5.0, Dop853{}, options).empty());
}

TEST_CASE("a functor that throws in a pack is asked again by each motion alone") {
  constexpr double two_ways = 1e-11;  // rtol: a motion that went alone was evaluated by another way, and its steps differ by rounding
  for (const int asked : {1, 60}) {
    int left = asked;
    const auto refusing = mechanical_system<2>(Refusing{&left});
    const auto ends = ensemble(refusing, 9, start_of, 5.0, Dop853{}, options, {.threads = 1});
    const auto plain = ensemble(orbit, 9, start_of, 5.0, Dop853{}, options, {.threads = 1});
    CHECK(left < 0);
    for (std::size_t i = 0; i < 9; ++i) {  // it refuses once, and not who asks again
      REQUIRE(ends[i].completed());
      CHECK(ends[i].value->completed());
      CHECK((ends[i].value->state.q - plain[i].value->state.q).norm() < two_ways);
    }
  }
}
