// SPDX-License-Identifier: MIT
//
// When does a double pendulum first turn over? A thousand motions, from every corner of a map of starts, and once more from starts that are not known exactly.

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include <qdot/integrate/counter_random.hpp>
#include <qdot/integrate/many_in_lanes.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulate.hpp>
#include <qdot/integrate/ensemble.hpp>

using namespace qdot;

struct DoublePendulum {
  double g = 9.81;

  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return v[0] * v[0] + 0.5 * v[1] * v[1] + v[0] * v[1] * cos(q[0] - q[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -g * (2.0 * cos(q[0]) + cos(q[1]));
  }
};

const auto pendulum = mechanical_system<2>(DoublePendulum{});
const Options options{.rtol = 1e-7, .keep_trajectory = false};

// An angle passes π.
const auto over = events(event("inner", [](const auto& q) { using std::abs; return std::numbers::pi - abs(q[0]); }).stop(),
                         event("outer", [](const auto& q) { using std::abs; return std::numbers::pi - abs(q[1]); }).stop());

int main() {
  // Angles from −3 to 3 rad, the outer one to the right, the inner one upward. They differ in their starts alone, and go side by side.
  constexpr std::size_t wide = 51, high = 13;
  const auto corner = [](std::size_t i) {
    return State<2>{0.0, {3.0 - 6.0 * static_cast<double>(i / wide) / (high - 1), -3.0 + 6.0 * static_cast<double>(i % wide) / (wide - 1)}, {0.0, 0.0}};
  };
  const auto map = ensemble(pendulum, wide * high, corner, 4.0, Dop853{}, options, over);
  for (std::size_t row = 0; row < high; ++row) {
    std::string line;
    for (std::size_t column = 0; column < wide; ++column) {
      const auto& end = *map[row * wide + column].value;
      const double t = end.completed() ? 4.0 : end.state.t;
      line += t < 1.0 ? '#' : t < 2.0 ? '+' : t < 4.0 ? '.' : ' ';
    }
    std::printf("%s\n", line.c_str());
  }

  // The same start two hundred times, known to a hundredth of a radian.
  struct Sums {
    int over = 0;
    double t = 0.0, t2 = 0.0;
  };
  const auto uncertain = [](std::size_t i) {
    CounterRandom random(2026, i);
    const double first = 2.6 + 0.01 * random.normal(), second = 0.5 + 0.01 * random.normal();
    const auto run = simulate(pendulum, State<2>{0.0, {first, second}, {0.0, 0.0}}, 4.0, Dop853{}, options, over);
    return run.outcome == Outcome::stopped_by_event ? run.t : HUGE_VAL;
  };
  const Sums sums = ensemble(200, uncertain, Sums{}, [](Sums& sum, std::size_t, Kept<double>&& kept) {
    if (!std::isfinite(*kept.value)) return;
    ++sum.over;
    sum.t += *kept.value;
    sum.t2 += *kept.value * *kept.value;
  });
  const double mean = sums.t / sums.over;
  std::printf("from (2.6, 0.5) ± 0.01 rad: %d of 200 turn over within 4 s, at t = %.3f ± %.3f s\n", sums.over, mean,
              std::sqrt(sums.t2 / sums.over - mean * mean));
}
