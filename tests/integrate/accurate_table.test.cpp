// SPDX-License-Identifier: MIT
//
// The table of docs/lab/accuracy.md: QDOT_ACCURACY_TABLE=docs/lab/accuracy.md TEST_PROGRAM "[table]"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "../catch2_bridge.hpp"
#include "accurate_scenes.hpp"
#include "qdot/integrate/simulate_to_accuracy.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/taylor.hpp"
#include "qdot/mechanics/system.hpp"

namespace {

using namespace qdot;
using accurate_scenes::Scene;

constexpr double accuracies[] = {1e-3, 1e-6, 1e-9, 1e-12};
constexpr int parts = 50;  // output times

double true_error(const Eigen::MatrixXd& y, const Eigen::MatrixXd& exact) {
  const Eigen::VectorXd sizes = exact.cwiseAbs().rowwise().maxCoeff();
  double largest = 0;
  for (Eigen::Index i = 0; i < exact.rows(); ++i)
    if (sizes[i] > 0) largest = std::max(largest, (y.row(i) - exact.row(i)).cwiseAbs().maxCoeff() / sizes[i]);
  return largest;
}

std::string text(const char* format, double value) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

// T and V of those scenes for which Taylor is tried; one type, so that it is compiled once.
struct Energies {
  std::string name;

  template <class S>
  S T(const Vector<S, 2>& q, const Vector<S, 2>& v) const {
    using std::cos;
    if (name.starts_with("double")) return v[0] * v[0] + 0.5 * v[1] * v[1] + v[0] * v[1] * cos(q[0] - q[1]);
    if (name.starts_with("elastic")) return 0.5 * (v[0] * v[0] + q[0] * q[0] * v[1] * v[1]);
    return 0.5 * (v[0] * v[0] + v[1] * v[1]);
  }
  template <class S>
  S V(const Vector<S, 2>& q) const {
    using std::cos, std::pow, std::sqrt;
    if (name.starts_with("double")) return -9.81 * (2.0 * cos(q[0]) + cos(q[1]));
    if (name.starts_with("elastic")) return 0.5 * 29.43 * (q[0] - 1.0) * (q[0] - 1.0) - 9.81 * q[0] * cos(q[1]);
    if (name.starts_with("fourth")) return 0.5 * q[0] * q[0] + pow(q[0] + q[1] - 1.0, 4);
    if (name.starts_with("Kepler")) return -1.0 / sqrt(q[0] * q[0] + q[1] * q[1]);
    if (name.starts_with("coupled")) return q[0] * q[0] + q[1] * q[1] - q[0] * q[1];
    return 0.5 * (q[0] * q[0] + q[1] * q[1]) + q[0] * q[0] * q[1] - q[1] * q[1] * q[1] / 3.0;  // Hénon-Heiles
  }
};

struct Table {
  std::string rows;
  std::vector<double> costs;    // of requests that were kept, beside the cheapest run that is as accurate
  double worst_honesty = 0;     // error / estimate
  double worst_promise = 0;     // error / accuracy where it was promised
  int kept = 0, asked = 0;
};

template <class System, class Start, class Method>
void add_rows(Table& table, const std::string& name, const System& system, const Start& start, double t_end, const Method& method,
              const Eigen::MatrixXd& exact, const std::vector<double>& times) {
  const Options options{.output_times = times, .keep_trajectory = false};
  // The run that knew the right tolerance: the loosest, of eight a decade, from which on all tighter ones are as accurate.
  // (There are looser ones that happen to be; which, nobody can know.)
  const Eigen::VectorXd sizes = exact.cwiseAbs().rowwise().maxCoeff().cwiseMax(1e-300);
  std::vector<std::pair<double, double>> known;
  for (int k = 12; k <= 8 * 14 + 4; ++k) {
    Options each = options;
    each.rtol = std::pow(10.0, -k / 8.0);
    each.atol = Eigen::VectorXd(each.rtol * sizes);
    each.max_steps = 100'000;
    const auto run = simulate(system, start, t_end, method, each);
    if (run.completed()) known.emplace_back(true_error(run.samples.y, exact), detail::work(run.statistics, sizes.size()));
  }
  table.rows += "| " + name + " ";
  for (const double accuracy : accuracies) {
    const auto result = simulate_to_accuracy(system, start, t_end, method, accuracy, options);
    const double error = true_error(result.run.samples.y, exact);
    double work = 0, least = std::numeric_limits<double>::infinity();
    for (const AccuracyTrial& trial : result.trials) work += trial.work;
    bool within = false;  // tighter tolerances first; the very tightest may be past the floor of rounding
    for (auto each = known.rbegin(); each != known.rend() && (each->first <= accuracy || !within); ++each) {
      within = each->first <= accuracy;
      if (within) least = each->second;
    }
    ++table.asked;
    table.worst_honesty = std::max(table.worst_honesty, error / result.error_estimate);
    INFO(name << ", accuracy " << accuracy << ": error " << error << ", estimate " << result.error_estimate << ", cost " << work / least);
    CHECK(error <= 3 * result.error_estimate);
    const std::string figures = text("%.1e", error) + " / " + text("%.1e", result.error_estimate) + " / ";
    if (result.reached()) {
      ++table.kept;
      table.worst_promise = std::max(table.worst_promise, error / accuracy);
      if (std::isfinite(least)) table.costs.push_back(work / least);
      table.rows += "| " + figures + (std::isfinite(least) ? text("%.2f", work / least) : "–") + " ";
    } else {
      table.rows += "| " + figures + "not reached ";
    }
  }
  table.rows += "|\n";
}

TEST_CASE("a coordinate that begins at zero and is not pushed yet has a power series like any other") {
  constexpr double t_end = 10;
  using accurate_scenes::Real;
  const auto times = accurate_scenes::equal_times(t_end, parts);
  const Eigen::MatrixXd exact = accurate_scenes::columns(accurate_scenes::extrapolated(
      [](Real, const Real* y, Real* d) {
        const Real a = y[0] + y[1] - 1;
        d[0] = y[2], d[1] = y[3], d[2] = -y[0] - 4 * a * a * a, d[3] = -4 * a * a * a;
      },
      {1, 0, 0, 0}, times));
  for (const double accuracy : {1e-3, 1e-6, 1e-9}) {
    const auto result = simulate_to_accuracy(mechanical_system<2>(Energies{"fourth power"}), State<2>{0.0, {1.0, 0.0}, {0.0, 0.0}}, t_end, Taylor{},
                                             accuracy, {.output_times = times, .keep_trajectory = false});
    INFO("accuracy " << accuracy << ": " << result.run.message);
    REQUIRE(result.reached());
    CHECK(true_error(result.run.samples.y, exact) <= accuracy);
    CHECK(result.evaluations < 500);
  }
}

TEST_CASE("estimates are honest and requests cheap, on all motions that are known exactly", "[long][table]") {
  Table dop853, taylor;
  for (const Scene& scene : accurate_scenes::all()) {
    const auto times = accurate_scenes::equal_times(scene.t_end, parts);
    const Eigen::MatrixXd exact = accurate_scenes::columns(scene.exact(times));
    const auto n = static_cast<Eigen::Index>(scene.start.size());
    add_rows(dop853, scene.name, scene.equations, FirstOrderState{0.0, Eigen::Map<const Eigen::VectorXd>(scene.start.data(), n)},
             scene.t_end, Dop853{}, exact, times);
    for (const char* name : {"double", "elastic", "Kepler", "coupled", "Hénon"}) {
      if (!scene.name.starts_with(name)) continue;
      const auto& y = scene.start;
      add_rows(taylor, scene.name, mechanical_system<2>(Energies{scene.name}), State<2>{0.0, {y[0], y[1]}, {y[2], y[3]}}, scene.t_end,
               Taylor{}, exact, times);
    }
  }
  std::string page;
  const auto write = [&](const char* method, const char* cost, Table& table) {
    std::sort(table.costs.begin(), table.costs.end());
    const double median = table.costs[table.costs.size() / 2], most = table.costs.back();
    page += std::string("\n## ") + method + "\n\n| motion | E = 1e-3 | 1e-6 | 1e-9 | 1e-12 |\n|---|---|---|---|---|\n" + table.rows;
    page += "\n" + std::to_string(table.kept) + " of " + std::to_string(table.asked) + " requests were kept. Largest true error / estimate: " +
            text("%.2f", table.worst_honesty) + "; largest true error / E where E was promised: " + text("%.2f", table.worst_promise) +
            ". Cost (" + cost + "): median " + text("%.2f", median) + ", nine in ten below " +
            text("%.2f", table.costs[table.costs.size() * 9 / 10]) + ", most " + text("%.2f", most) + ".\n";
    CHECK(median <= 2.6);
    CHECK(table.costs[table.costs.size() * 9 / 10] <= 4.0);
    CHECK(table.worst_promise <= 1.0);
    CHECK(table.kept * 10 >= table.asked * 9 - 10);  // a planet and a double pendulum at 1e-12 are refused
  };
  write("Dop853", "evaluations", dop853);
  write("Taylor", "evaluations × (order + 1)²", taylor);
  if (const char* path = std::getenv("QDOT_ACCURACY_TABLE")) {
    // Keeps what the page says before its first table.
    std::ifstream before(path);
    std::string lead, line;
    while (std::getline(before, line) && !line.starts_with("## Dop853")) lead += line + "\n";
    while (lead.ends_with("\n\n")) lead.pop_back();
    std::ofstream(path) << lead << page;
  } else {
    std::printf("%s\n", page.c_str());
  }
}

}  // namespace
