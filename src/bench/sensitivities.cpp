// SPDX-License-Identifier: MIT
//
// What derivatives of a motion cost: a run with k columns of Φ beside the same run without. Central differences would take 2k runs more.
#include "qdot/analysis/sensitivity.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>

#include "bench/bench.hpp"
#include "qdot/effects/dissipation.hpp"

namespace qdot::bench {

namespace {

template <class S>
struct DoublePendulum {
  S m1, m2, l1, l2;

  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return 0.5 * (m1 + m2) * l1 * l1 * v[0] * v[0] + 0.5 * m2 * l2 * l2 * v[1] * v[1] + m2 * l1 * l2 * v[0] * v[1] * cos(q[0] - q[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -9.81 * ((m1 + m2) * l1 * cos(q[0]) + m2 * l2 * cos(q[1]));
  }
};

constexpr auto energies_of = [](const auto& p) {
  using S = std::remove_cvref_t<decltype(p[0])>;
  if constexpr (std::remove_cvref_t<decltype(p)>::RowsAtCompileTime == 1) return DoublePendulum<S>{S(1.0), S(1.0), S(1.0), p[0]};
  else return DoublePendulum<S>{p[0], p[1], p[2], p[3]};
};

// Seconds of the shortest of many runs, with and without derivatives in turn.
void add_row(std::vector<Row>& rows, const std::string& name, const auto& plain, const auto& derived) {
  double alone = std::numeric_limits<double>::infinity(), both = alone;
  const auto shorten = [](double& best, const auto& work) {
    const auto began = std::chrono::steady_clock::now();
    const bool completed = work();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    if (completed) best = std::min(best, seconds);
  };
  for (int repeat = 0; repeat < 60; ++repeat) {
    shorten(alone, plain);
    shorten(both, derived);
  }
  rows.push_back({name, both, alone, "the run alone", "s"});
}

Findings measured() {
  Findings found;
  const Options options{.rtol = 1e-10, .atol = 1e-12};
  const State<2> start{0.0, {1.7, 1.7}, {0.0, 0.0}};
  const double t_end = 3.0;
  const Eigen::Vector4d p = Eigen::Vector4d::Ones();
  const Vector<double, 1> one(1.0);
  const auto pendulum = mechanical_system<2>(energies_of(p));
  const auto plain = [&] { return simulate(pendulum, start, t_end, Dop853{}, options).completed(); };
  add_row(found.rows, "double pendulum, k = 1: a length", plain,
          [&] { return sensitivities(energies_of, one, start, t_end, Dop853{}, options, {}, {.start = false}).completed(); });
  add_row(found.rows, "double pendulum, k = 4: the start", plain, [&] { return sensitivities(pendulum, start, t_end, Dop853{}, options).completed(); });
  add_row(found.rows, "double pendulum, k = 8: the start and four parameters", plain,
          [&] { return sensitivities(energies_of, p, start, t_end, Dop853{}, options).completed(); });
  const auto family = [&](const Vector<double, 1>& k) { return problem(mechanical_system<2>(DoublePendulum<double>{1.0, 1.0, 1.0, k[0]}), start); };
  add_row(found.rows, "double pendulum, k = 1: a length, by a family", plain,
          [&] { return sensitivities(family, one, t_end, Dop853{}, options).completed(); });
  const auto damped = scene(pendulum, viscous_damping(Eigen::Vector2d(0.1, 0.1)));
  add_row(found.rows, "damped double pendulum, k = 4: the start", [&] { return simulate(damped, start, t_end, Dop853{}, options).completed(); },
          [&] { return sensitivities(damped, start, t_end, Dop853{}, options).completed(); });
  found.note = "seconds of a run with k columns of Φ, the least of 60 in turn with the run alone; rtol 1e-10, Dop853, dense output kept; central differences "
               "take 1 + 2k runs";
  return found;
}

}  // namespace

Benchmark sensitivities_benchmark() {
  return {"sensitivities", "time of a run with its derivatives beside the run alone", measured};
}

}  // namespace qdot::bench
