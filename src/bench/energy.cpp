// SPDX-License-Identifier: MIT
//
// What ten thousand periods do to the energy of a planet, e = 0.6. A symplectic method's error does not grow, that of Taylor at its
// tightest tolerance walks at random with the rounding. That of other methods grows with the time. The picture is drawn as
// out/kepler_energy.svg.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "bench/bench.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/symplectic.hpp"
#include "qdot/integrate/taylor.hpp"
#include "qdot/report/file.hpp"
#include "qdot/report/svg.hpp"
#include "scenes/kepler.hpp"

namespace qdot::bench {
namespace {

constexpr double period = 6.283185307179586;
constexpr double periods = 1e4;

// Largest relative energy error between one mark of time and the next.
struct History {
  std::string method;
  double microseconds = 0;                     // for each period
  std::vector<double> marks{}, largest{};      // in periods
  double until(double mark) const {            // over all of the run so far
    double most = 0.0;
    for (std::size_t i = 0; i < marks.size() && marks[i] <= mark * 1.001; ++i) most = std::max(most, largest[i]);
    return most;
  }
};

template <class Method>
History followed(const std::string& name, const Method& method, const Options& options) {
  History history{.method = name};
  for (double exponent = 0.0; exponent < 4.01; exponent += 0.125) history.marks.push_back(std::pow(10.0, exponent));
  history.largest.assign(history.marks.size(), 0.0);
  const auto form = first_order_form(mechanical_system<2>(scenes::Kepler{}));
  auto stepper = method.stepper(form, options);
  Eigen::VectorXd y(4);
  y << 0.4, 0.0, 0.0, 2.0;
  const double t_end = period * periods;
  const auto began = std::chrono::steady_clock::now();
  stepper.reset(0.0, y);
  std::size_t window = 0;
  while (stepper.t() != t_end && stepper.step(t_end)) {
    const auto& at = stepper.y();
    const long double x = at[0], z = at[1], u = at[2], w = at[3];
    const double error = static_cast<double>(std::abs(0.5L * (u * u + w * w) - 1.0L / std::sqrt(x * x + z * z) + 0.5L) / 0.5L);
    while (window + 1 < history.marks.size() && stepper.t() > history.marks[window] * period) ++window;
    history.largest[window] = std::max(history.largest[window], error);
  }
  history.microseconds = std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - began).count() / periods;
  return history;
}

Findings energy() {
  std::vector<History> all;
  const Options fixed{};
  all.push_back(followed("dop853, rtol 1e-13", Dop853{}, {.rtol = 1e-13, .atol = 1e-13}));
  all.push_back(followed("verlet, 1000 steps a period", Splitting{.step = period / 1000, .scheme = SplittingScheme::verlet}, fixed));
  all.push_back(followed("blanes_moan_6, 100 steps a period", Splitting{.step = period / 100}, fixed));
  all.push_back(followed("gauss, 4 stages, 60 steps a period", Gauss{.step = period / 60, .stages = 4}, fixed));
  all.push_back(followed("kahan_li_8, 300 steps a period", Splitting{.step = period / 300, .scheme = SplittingScheme::kahan_li_8}, fixed));
  all.push_back(followed("taylor, rtol 2.5e-15", Taylor{}, {.rtol = 2.5e-15, .atol = 1e-16}));

  Findings findings;
  report::Plot plot{.title = "Kepler's problem, e = 0.6: relative error of the energy over 10⁴ periods",
                    .x = {.label = "periods", .scale = report::Scale::logarithmic},
                    .y = {.label = "largest |E − E₀| / |E₀| in each eighth of a decade", .scale = report::Scale::logarithmic},
                    .height = 420};
  for (const History& history : all) {
    char text[200];
    std::snprintf(text, sizeof text, "kepler e=0.6, %s: energy error %.1e, %.1e, %.1e after 1e2, 1e3, 1e4 periods", history.method.c_str(),
                  history.until(1e2), history.until(1e3), history.until(1e4));
    findings.rows.push_back({text, history.microseconds, all[0].microseconds, "dop853", "us/period"});
    plot.series.push_back({.label = history.method, .x = history.marks, .y = history.largest});
  }
  report::Series root{.label = "∝ √t", .x = {1.0, 1e4}, .y = {2e-16, 2e-14}};
  plot.series.push_back(root);
  const std::string path = "out/kepler_energy.svg";
  std::error_code ignored;
  std::filesystem::create_directories("out", ignored);
  try {
    report::write_files({{path, report::svg(plot)}});
    findings.note = "The picture is " + path + ".";
  } catch (const report::UnwritableFile& problem) {
    findings.note = std::string("No picture: ") + problem.what();
  }
  return findings;
}

}  // namespace

Benchmark benchmark() {
  return {"energy", "error of the energy over ten thousand periods of a planet, and the time for a period", energy};
}

}  // namespace qdot::bench
