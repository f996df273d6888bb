// SPDX-License-Identifier: MIT
//
// What derivatives of a motion cost: a run with k columns of Φ beside the same run without, and one with the adjoint behind it. Central differences would
// take 2k runs more.
#include "qdot/analysis/adjoint.hpp"
#include "qdot/analysis/second_sensitivity.hpp"
#include "qdot/analysis/sensitivity.hpp"
#include "qdot/analysis/taylor_sensitivity.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>

#include "bench/bench.hpp"
#include "bench/chain_energies.hpp"
#include "qdot/effects/dissipation.hpp"

namespace qdot::bench {

namespace {

template <class S>
struct DoublePendulum {
  S m1 = S(1.0), m2 = S(1.0), l1 = S(1.0), l2 = S(1.0);

  constexpr auto T(const auto& q, const auto& v) const {
    using std::cos;
    return 0.5 * (m1 + m2) * l1 * l1 * v[0] * v[0] + 0.5 * m2 * l2 * l2 * v[1] * v[1] + m2 * l1 * l2 * v[0] * v[1] * cos(q[0] - q[1]);
  }
  constexpr auto V(const auto& q) const {
    using std::cos;
    return -9.81 * ((m1 + m2) * l1 * cos(q[0]) + m2 * l2 * cos(q[1]));
  }
};

constexpr auto energies_of = [](const auto& p) {
  using S = std::remove_cvref_t<decltype(p[0])>;
  if constexpr (std::remove_cvref_t<decltype(p)>::RowsAtCompileTime == 1) return DoublePendulum<S>{S(1.0), S(1.0), S(1.0), p[0]};
  else return DoublePendulum<S>{p[0], p[1], p[2], p[3]};
};

// A point of unit mass in a plane, in a landscape of m − 1 waves about a hollow.
template <class P>
struct Waves {
  P p;
  auto T(const auto& v) const { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }
  auto V(const auto& q) const {
    using std::cos;
    auto sum = p[0] * (0.5 * (q[0] * q[0] + q[1] * q[1]));
    for (Eigen::Index k = 1; k < p.size(); ++k) sum = sum + p[k] * cos(0.3 * static_cast<double>(k) * q[0] + 0.2 * static_cast<double>(k) * q[1]);
    return sum;
  }
};
constexpr auto waves_of = [](const auto& p) { return Waves<std::remove_cvref_t<decltype(p)>>{p}; };

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

// A chain of n links with loops: by the time of its start, and by its start.
template <int n>
void add_chain(std::vector<Row>& rows, const Options& options) {
  const State<n> start{0.0, Vector<double, n>::Constant(1.7), Vector<double, n>::Zero()};
  const auto chain = mechanical_system<n>(LoopedChain{});
  const auto plain = [&] { return simulate(chain, start, 3.0, Dop853{}, options).completed(); };
  const std::string name = "chain n=" + std::to_string(n) + ", k = ";
  add_row(rows, name + "1: the time of the start", plain,
          [&] { return sensitivities(chain, start, 3.0, Dop853{}, options, {}, {.start = false, .start_time = true}).completed(); });
  add_row(rows, name + std::to_string(2 * n) + ": the start", plain, [&] { return sensitivities(chain, start, 3.0, Dop853{}, options).completed(); });
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
  add_chain<1>(found.rows, options);
  add_chain<2>(found.rows, options);
  add_chain<3>(found.rows, options);
  add_chain<4>(found.rows, options);
  const auto by_series = [&] { return simulate(pendulum, start, t_end, Taylor{}, options).completed(); };
  add_row(found.rows, "double pendulum by Taylor, k = 1: a length", by_series,
          [&] { return sensitivities(energies_of, one, start, t_end, Taylor{}, options, {}, {.start = false}).completed(); });
  add_row(found.rows, "double pendulum by Taylor, k = 4: the start", by_series,
          [&] { return sensitivities(pendulum, start, t_end, Taylor{}, options).completed(); });
  add_row(found.rows, "double pendulum by Taylor, k = 8: the start and four parameters", by_series,
          [&] { return sensitivities(energies_of, p, start, t_end, Taylor{}, options).completed(); });
  add_row(found.rows, "double pendulum by Taylor, second derivatives by a length", by_series,
          [&] { return second_sensitivities(energies_of, one, start, t_end, Taylor{}, options, {}, {.start = false}).completed(); });
  add_row(found.rows, "double pendulum by Taylor, second derivatives by the start", by_series,
          [&] { return second_sensitivities(pendulum, start, t_end, Taylor{}, options).completed(); });
  const auto family = [&](const Vector<double, 1>& k) { return problem(mechanical_system<2>(DoublePendulum<double>{1.0, 1.0, 1.0, k[0]}), start); };
  add_row(found.rows, "double pendulum, k = 1: a length, by a family", plain,
          [&] { return sensitivities(family, one, t_end, Dop853{}, options).completed(); });
  const auto damped = scene(pendulum, viscous_damping(Eigen::Vector2d(0.1, 0.1)));
  add_row(found.rows, "damped double pendulum, k = 4: the start", [&] { return simulate(damped, start, t_end, Dop853{}, options).completed(); },
          [&] { return sensitivities(damped, start, t_end, Dop853{}, options).completed(); });
  const auto mean = integral([](const auto& q) { return q[0] * q[0]; });
  add_row(found.rows, "double pendulum, the gradient of one integral in 4 parameters, by the adjoint", plain,
          [&] { return adjoint_sensitivities(energies_of, p, start, t_end, mean, Dop853{}, options).completed(); });
  const auto add_waves = [&](const auto& heights, const std::string& name) {
    const auto landscape = mechanical_system<2>(waves_of(heights));
    add_row(found.rows, name, [&] { return simulate(landscape, start, t_end, Dop853{}, options).completed(); },
            [&] { return adjoint_sensitivities(waves_of, heights, start, t_end, mean, Dop853{}, options).completed(); });
  };
  add_waves(Vector<double, 2>(Vector<double, 2>::Constant(0.4)), "waves, the same in 2 parameters");
  add_waves(Vector<double, 4>(Vector<double, 4>::Constant(0.4)), "waves, the same in 4 parameters");
  add_waves(Vector<double, 8>(Vector<double, 8>::Constant(0.3)), "waves, the same in 8 parameters");
  add_waves(Vector<double, 16>(Vector<double, 16>::Constant(0.3)), "waves, the same in 16 parameters");
  add_waves(Vector<double, 32>(Vector<double, 32>::Constant(0.1)), "waves, the same in 32 parameters");
  add_waves(Vector<double, 64>(Vector<double, 64>::Constant(0.1)), "waves, the same in 64 parameters");
  found.note =
      "seconds of a run with k columns of Φ, the least of 60 in turn with the run alone; rtol 1e-10, Dop853 where no other method is named, dense output kept; central differences "
      "take 1 + 2k runs";
  return found;
}

}  // namespace

Benchmark benchmark() {
  return {"sensitivities", "time of a run with its derivatives beside the run alone", measured};
}

}  // namespace qdot::bench
