// SPDX-License-Identifier: MIT
//
// Large scenes: what a step costs for each coordinate, from a hundred of them to a million.
//
// T and V are written with loops over neighbours, the number of coordinates is known at run time, and nothing else is said. What a run takes before its
// first step, tracing and a first look, is a row of its own.
#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <vector>

#include "bench/bench.hpp"
#include "bench/hanging_chain.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/symplectic.hpp"

namespace qdot::bench {

namespace {

struct UnitMasses {
  auto T(const auto& v) const {
    typename std::remove_cvref_t<decltype(v)>::Scalar sum(0.0);
    for (Eigen::Index i = 0; i < v.size(); ++i) sum += 0.5 * v[i] * v[i];
    return sum;
  }
};

/// Masses on a line between two walls, springs with a quadratic part (Fermi, Pasta, Ulam).
struct Lattice : UnitMasses {
  auto V(const auto& q) const {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    S sum(0.0);
    for (Eigen::Index i = 0; i <= q.size(); ++i) {
      const S d = (i < q.size() ? q[i] : S(0.0)) - (i > 0 ? q[i - 1] : S(0.0));
      sum += 0.5 * d * d + 0.25 / 3.0 * d * d * d;
    }
    return sum;
  }
};

/// A square net of masses that move out of their plane, threads under tension between neighbours, its edge held: V = Σ √(1 + d²).
struct Net : UnitMasses {
  auto V(const auto& q) const {
    using std::sqrt;
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    const auto side = static_cast<Eigen::Index>(std::llround(std::sqrt(static_cast<double>(q.size()))));
    const auto height = [&](Eigen::Index i, Eigen::Index j) { return i < 0 || j < 0 || i == side || j == side ? S(0.0) : S(q[side * i + j]); };
    S sum(0.0);
    for (Eigen::Index i = 0; i <= side; ++i)
      for (Eigen::Index j = 0; j <= side; ++j) {
        const S right = height(i, j) - height(i, j - 1), down = height(i, j) - height(i - 1, j);
        if (i < side) sum += sqrt(1.0 + right * right);
        if (j < side) sum += sqrt(1.0 + down * down);
      }
    return sum;
  }
};

// Of the processor: the machine may have others to serve.
double seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

struct Cost {
  double step = 0.0, begin = 0.0;  // ns for each coordinate
};

// The median of some groups of steps in one run, and what came before the first.
template <class Sc, class Method>
Cost cost_of(const Sc& scene, const State<Dynamic>& start, const Method& method, double h) {
  constexpr long groups = 9;
  const auto n = static_cast<double>(start.q.size());
  const long group = std::max<long>(1, std::lround(100'000 / n));
  const Options options{.rtol = 1e-3, .atol = 1e-3, .initial_step = h, .max_step = h, .keep_trajectory = false};
  std::vector<double> times;
  long count = 0;
  const double began = seconds();
  (void)simulate(scene, start, h * static_cast<double>(1 + groups * group), method, options, [&](const StepView&) {
    if (count++ % group == 0) times.push_back(seconds());
  });
  std::vector<double> each;
  for (std::size_t k = 1; k < times.size(); ++k) each.push_back((times[k] - times[k - 1]) / static_cast<double>(group));
  std::nth_element(each.begin(), each.begin() + static_cast<std::ptrdiff_t>(each.size() / 2), each.end());
  const double step = each[each.size() / 2];
  return {1e9 * step / n, 1e9 * std::max(0.0, times.front() - began - step) / n};
}

template <class Make, class Start, class Method>
void add_rows(std::vector<Row>& rows, const std::string& name, const std::vector<Eigen::Index>& sizes, const Make& make, const Start& start_of,
              const Method& method, double h) {
  double smallest = 0.0;
  for (const Eigen::Index n : sizes) {
    const Cost cost = cost_of(make(n), start_of(n), method, h);
    if (smallest == 0.0) smallest = cost.step;
    std::string memory;
    if (n >= 1'000'000) memory = ", " + std::to_string(std::llround(1048.576 * peak_megabytes() / static_cast<double>(n))) + " kB for each coordinate";
    rows.push_back({name + ", n = " + std::to_string(n), cost.step, smallest, "n = " + std::to_string(sizes.front()), "ns"});
    rows.push_back({name + ", n = " + std::to_string(n) + ", before its first step" + memory, cost.begin, cost.step, "a step", "ns"});
  }
}

State<Dynamic> at_rest(Eigen::Index n, const auto& coordinate) {
  State<Dynamic> start{0.0, Eigen::VectorXd(n), Eigen::VectorXd::Zero(n)};
  for (Eigen::Index i = 0; i < n; ++i) start.q[i] = coordinate(i);
  return start;
}

Findings measured() {
  Findings found;
  const auto wave = [](Eigen::Index n) { return at_rest(n, [](Eigen::Index i) { return std::sin(0.37 * static_cast<double>(i)); }); };
  const auto slanted = [](Eigen::Index n) {
    return at_rest(n, [](Eigen::Index i) { return (i % 2 == 0 ? std::sin(0.3) : -std::cos(0.3)) * static_cast<double>(i / 2 + 1); });
  };
  const std::vector<Eigen::Index> line{100, 1000, 10'000, 100'000, 1'000'000}, square{100, 1024, 10'000, 99'856, 1'000'000};
  const auto lattice = [](Eigen::Index n) { return mechanical_system(n, Lattice{}); };
  const auto net = [](Eigen::Index n) { return mechanical_system(n, Net{}); };
  add_rows(found.rows, "lattice, Verlet", line, lattice, wave, Splitting{.step = 0.05, .scheme = SplittingScheme::verlet}, 0.05);
  add_rows(found.rows, "net, Verlet", square, net, wave, Splitting{.step = 0.05, .scheme = SplittingScheme::verlet}, 0.05);
  add_rows(found.rows, "lattice, Dop853", line, lattice, wave, Dop853{}, 0.05);
  const auto chain = [](Eigen::Index n) { return hanging_chain(static_cast<int>(n / 2)); };
  const std::vector<Eigen::Index> to_a_hundred_thousand{100, 1000, 10'000, 100'000};
  add_rows(found.rows, "hanging chain of rods, Dop853", to_a_hundred_thousand, chain, slanted, Dop853{}, 1e-3);
  add_rows(found.rows, "lattice, CvodeBdf", to_a_hundred_thousand, lattice, wave, CvodeBdf{}, 1e-3);
  add_rows(found.rows, "hanging chain of rods, CvodeBdf", to_a_hundred_thousand, chain, slanted, CvodeBdf{}, 1e-4);
  found.note =
      "CPU for each step and coordinate, the median of nine groups of steps of one run; a step of Dop853 is twelve evaluations, or sixteen with constraints";
  return found;
}

}  // namespace

Benchmark benchmark() {
  return {"large", "what a step costs for each coordinate, from a hundred to a million", measured};
}

}  // namespace qdot::bench
