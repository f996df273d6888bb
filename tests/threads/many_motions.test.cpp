// SPDX-License-Identifier: MIT
//
// Many motions in threads are the same bits as one after another; under the thread sanitizer.
#include "qdot/integrate/ensemble.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "catch2_bridge.hpp"
#include "error_message.hpp"
#include "qdot/integrate/counter_random.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

using namespace qdot;

namespace {

struct Pendulum {
  double l = 1.0;
  auto T(const auto& v) const { return 0.5 * l * l * v[0] * v[0]; }
  auto V(const auto& q) const {
    using std::cos;
    return -9.81 * l * cos(q[0]);
  }
};

double angle_of(std::size_t i) {
  CounterRandom random(7, i);
  const State<1> start{0.0, Vector<double, 1>(random.uniform(-3.0, 3.0)), Vector<double, 1>(0.0)};
  const auto run = simulate(mechanical_system<1>(Pendulum{1.0 + 0.05 * random.normal()}), start, 1.0 + static_cast<double>(i % 5), Dop853{},
                            {.rtol = 1e-8, .keep_trajectory = false});
  return run.y[0];
}

}  // namespace

TEST_CASE("many motions in threads are the bits of one after another, whatever the threads and chunks") {
  constexpr std::size_t count = 101;
  for (const EnsembleOptions& many : {EnsembleOptions{.threads = 1}, EnsembleOptions{.threads = 4}, EnsembleOptions{.threads = 3, .chunk = 7},
                                      EnsembleOptions{.threads = 2, .chunk = std::numeric_limits<std::size_t>::max()}, EnsembleOptions{}}) {
    const auto all = ensemble(count, angle_of, many);
    REQUIRE(all.size() == count);
    std::size_t same = 0;
    for (std::size_t i = 0; i < count; ++i) same += all[i].value == angle_of(i);
    CHECK(same == count);
  }
}

TEST_CASE("a reduction sees motions in the order of their numbers, and one at a time") {
  const auto number = [](std::size_t i) { return 1.0 / static_cast<double>(1 + i); };
  double expected = 0.0;
  for (std::size_t i = 0; i < 5000; ++i) expected += number(i);
  std::size_t next = 0;
  const double sum = ensemble(
      5000, number, 0.0,
      [&](double& value, std::size_t i, Kept<double>&& kept) {
        CHECK(i == next);
        ++next;
        value += *kept.value;
      },
      {.threads = 4, .chunk = 3});
  CHECK(sum == expected);  // to the bit: the same order
}

TEST_CASE("what a motion throws stays with its number, and the rest goes on") {
  const auto all = ensemble(
      50,
      [](std::size_t i) {
        if (i == 13) throw std::runtime_error("unlucky");
        if (i == 14) throw 14;
        return i;
      },
      {.threads = 3});
  for (std::size_t i = 0; i < all.size(); ++i) CHECK(all[i].completed() == (i != 13 && i != 14));
  CHECK(all[13].message() == "unlucky");
  CHECK(all[14].message() == "what was thrown is no std::exception");
  CHECK(all[15].message().empty());
  CHECK(*all[49].value == 49);
}

TEST_CASE("what a reduction throws ends the study") {
  const auto stop = [](int&, std::size_t i, Kept<std::size_t>&&) {
    if (i == 20) throw std::runtime_error("enough");
  };
  CHECK_THROWS_AS(ensemble(100'000, [](std::size_t i) { return i; }, 0, stop, {.threads = 4}), std::runtime_error);
  CHECK(ensemble(0, [](std::size_t i) { return i; }).empty());
  CHECK(error_message([] { ensemble(1, [](std::size_t i) { return i; }, {.threads = -2}); }).find("must not be negative, but is -2") != std::string::npos);
}

TEST_CASE("random numbers by counter are those that their authors publish") {
  using Words = std::array<std::uint32_t, 4>;  // known answers of Random123 for Philox 4x32-10
  CHECK(philox({0, 0, 0, 0}, {0, 0}) == Words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8});
  CHECK(philox({~0u, ~0u, ~0u, ~0u}, {~0u, ~0u}) == Words{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd});
  CHECK(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}) == Words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1});
}

TEST_CASE("random numbers have the moments of their distributions, and neighbours have nothing in common") {
  constexpr int count = 20'000;
  constexpr double sigma = 5.0;  // standard deviations that a mean may be off
  double u = 0.0, u2 = 0.0, z = 0.0, z2 = 0.0, both = 0.0;
  for (int i = 0; i < count; ++i) {
    CounterRandom random(42, static_cast<std::uint64_t>(i)), next(42, static_cast<std::uint64_t>(i + 1));
    const double a = random.uniform(), b = random.normal();
    u += a, u2 += a * a, z += b, z2 += b * b, both += (a - 0.5) * (next.uniform() - 0.5);
  }
  const double root = std::sqrt(static_cast<double>(count));
  CHECK(std::abs(u / count - 0.5) < sigma * std::sqrt(1.0 / 12) / root);
  CHECK(std::abs(u2 / count - 1.0 / 3) < sigma * std::sqrt(4.0 / 45) / root);
  CHECK(std::abs(z / count) < sigma / root);
  CHECK(std::abs(z2 / count - 1.0) < sigma * std::sqrt(2.0) / root);
  CHECK(std::abs(both / count) < sigma / 12 / root);
}
