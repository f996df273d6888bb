#pragma once
// SPDX-License-Identifier: MIT
//
// Work and precision: methods run at rows of tolerances or steps, their errors against a reference, and what they cost.
//
// This is the study itself; work_precision.hpp makes one from a system and some methods. Each cell, a method at one setting, is run
//
//     once with outputs      how it ends, its states at the reference's times, its energies
//     many times without     counts of evaluations, and the CPU time of this thread: median and minimum
//
//     error        at the end, and the largest at the output times; of the worst component, beside the largest value that the
//                  component takes on the motion
//     energy       largest |h − h_reference| at the output times, h Jacobi's energy function, beside the largest kinetic energy
//
// Steps of fixed length are chosen so that the output times are ends of steps: what is measured there is the method and
// not its interpolation. Runs that fail are kept, with their outcome. An error below ten times the reference's own uncertainty
// says nothing, and counts as that.

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <ctime>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "qdot/analysis/reference.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/steps/one_step.hpp"

namespace qdot {

/// What is compared, and how long it may take.
struct WorkPrecisionOptions {
  std::vector<double> tolerances = {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14};  ///< rtol = atol
  int outputs = 32;                ///< equal distances at whose ends errors are measured
  double seconds_per_cell = 0.05;  ///< of repeated runs, for one method at one setting
  double longest_run = 2.0;        ///< seconds; settings that are likely to take longer are left out
  ReferenceOptions reference = {};  ///< of the reference motion
};

/// Counts of one run of steps alone.
struct RunCounts {
  long steps = 0, rejected = 0, evaluations = 0, jacobians = 0;  ///< as Statistics has them
};

/// A run whose states and energies are looked at, and what it cost.
struct ObservedRun : RunCounts {
  Outcome outcome = Outcome::completed;                                   ///< how it ended
  std::string message{};                                                  ///< with the numbers
  double t = 0.0;                                                         ///< time reached
  Eigen::MatrixXd states{};                                               ///< at the output times that were reached, a column each
  double constraint_residual = std::numeric_limits<double>::quiet_NaN();  ///< largest |φ| after a step; NaN without constraints
  std::vector<double> energy_times{}, energy_change{};                    ///< times of (some of) the steps, and h − h(0) there
};

/// One method at one tolerance or step: its run, without states, its energies relative to the largest kinetic energy, counts of a run without output.
struct Measurement : ObservedRun {
  std::string method{};                                             ///< its name
  double setting = 0.0;                                             ///< tolerance, or length of a step
  bool fixed_step = false;                                          ///< which of the two
  double end_error = std::numeric_limits<double>::quiet_NaN();      ///< relative; NaN where the end was not reached
  double largest_error = std::numeric_limits<double>::quiet_NaN();  ///< at the output times; NaN where the end was not reached
  double energy_error = std::numeric_limits<double>::quiet_NaN();   ///< relative to the largest kinetic energy
  double cpu_median = std::numeric_limits<double>::quiet_NaN();     ///< seconds
  double cpu_minimum = std::numeric_limits<double>::quiet_NaN();    ///< seconds
  int runs = 0;                                                     ///< behind these two

  /// Whether t_end was reached.
  bool completed() const noexcept { return outcome == Outcome::completed; }
};

/// A reference, and how close the methods came at what price.
struct WorkPrecision {
  ReferenceMotion reference;              ///< against which errors are measured
  double energy_scale = 1.0;              ///< largest kinetic energy at the output times
  bool energy_conserved = true;           ///< the reference keeps its energy
  std::vector<Measurement> measurements;  ///< of all methods at all settings

  /// The smallest error that the reference can show.
  double visible_error() const noexcept { return 10 * reference.uncertainty; }

  /// The completed run of the least CPU time whose largest error is not above `error`; nothing if none came so close.
  const Measurement* cheapest(double error) const {
    const Measurement* best = nullptr;
    if (error < visible_error()) return best;
    for (const Measurement& m : measurements)
      if (m.completed() && m.largest_error <= error && (best == nullptr || m.cpu_median < best->cpu_median)) best = &m;
    return best;
  }

  /// The cheapest run for errors 1e-1, 1e-2, … as far as any method came.
  std::vector<const Measurement*> cheapest_by_decade() const {
    std::vector<const Measurement*> rows;
    for (int k = 1; const Measurement* m = cheapest(std::pow(10.0, -k)); ++k) rows.push_back(m);
    return rows;
  }
};

/// Equal distances from t0 to t_end: t0 left out, t_end included.
inline std::vector<double> output_times(double t0, double t_end, int count) {
  std::vector<double> times;
  for (int k = 1; k <= count; ++k) times.push_back(k == count ? t_end : t0 + (t_end - t0) * k / count);
  return times;
}

/// A method as the study sees it, its type and that of the system hidden.
struct Contender {
  std::string name;                                                        ///< of the method
  bool fixed_step = false;                                                 ///< whether its setting is a step, or a tolerance
  std::function<ObservedRun(double setting)> observed;                     ///< one run with outputs
  std::function<std::function<RunCounts()>(double setting)> ready_to_run;  ///< makes a run of steps alone, to be repeated
};

/// Energies of a state, for the study.
struct EnergyFunctions {
  std::function<double(double t, const Eigen::VectorXd& y)> jacobi{}, kinetic{};  ///< may be empty: no energies are looked at
};

namespace detail {

// Time that this thread has spent on a processor [s].
inline double thread_cpu_seconds() {
#if defined(CLOCK_THREAD_CPUTIME_ID)
  timespec now{};
  if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now) == 0) return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
#endif
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

// Fills in counts and times of repeated runs.
template <class = void>  // compiled only where it is called
void time_runs(Measurement& m, const std::function<RunCounts()>& run, double seconds) {
  constexpr double shortest = 5e-5;  // the clock costs a microsecond
  constexpr std::size_t least = 5, most = 101;
  double began = thread_cpu_seconds();
  static_cast<RunCounts&>(m) = run();
  const double once = std::max(thread_cpu_seconds() - began, 1e-9);
  const int together = static_cast<int>(std::ceil(std::min(1000.0, shortest / once)));
  std::vector<double> times;
  double spent = once;
  if (once > seconds) times.push_back(once);
  while (times.size() < most && (spent < seconds || (times.size() < least && spent < 4 * seconds))) {
    began = thread_cpu_seconds();
    for (int k = 0; k < together; ++k) run();
    const double time = thread_cpu_seconds() - began;
    spent += time;
    times.push_back(time / together);
  }
  m.runs = static_cast<int>(times.size());
  std::sort(times.begin(), times.end());
  m.cpu_minimum = times.front();
  m.cpu_median = times.size() % 2 == 1 ? times[times.size() / 2] : 0.5 * (times[times.size() / 2 - 1] + times[times.size() / 2]);
}

template <class = void>  // compiled only where it is called
Measurement measurement(const WorkPrecision& study, const Contender& contender, double setting, double seconds,
                        const EnergyFunctions& energies) {
  Measurement m;
  try {
    static_cast<ObservedRun&>(m) = contender.observed(setting);
  } catch (const NotAnalytic&) {  // a method that was not made for this is no measurement
    throw;
  } catch (...) {
    Failure refused = refusal();
    m.outcome = refused.outcome;
    m.message = std::move(refused.message);
  }
  m.method = contender.name;
  m.setting = setting;
  m.fixed_step = contender.fixed_step;
  for (double& change : m.energy_change) change /= study.energy_scale;
  const Eigen::MatrixXd states = std::exchange(m.states, {});
  const ReferenceMotion& reference = study.reference;
  if (!m.completed() || states.cols() != reference.y.cols()) return m;
  m.largest_error = 0.0;
  if (energies.jacobi) m.energy_error = 0.0;
  for (std::size_t k = 0; k < reference.t.size(); ++k) {
    const Eigen::VectorXd y = states.col(static_cast<Eigen::Index>(k));
    m.end_error = reference.error(k, y);
    if (!(m.end_error <= m.largest_error)) m.largest_error = m.end_error;
    if (!energies.jacobi) continue;
    const Eigen::VectorXd exact = reference.y.col(static_cast<Eigen::Index>(k)).template cast<double>();
    const double e = std::abs(energies.jacobi(reference.t[k], y) - energies.jacobi(reference.t[k], exact)) / study.energy_scale;
    if (!(e <= m.energy_error)) m.energy_error = e;
  }
  time_runs(m, contender.ready_to_run(setting), seconds);
  return m;
}

// Numbers of steps between two output times: from about one radian a step, each √2 times more.
template <class = void>  // compiled only where it is called
std::vector<long> step_counts(const ReferenceMotion& reference, double spacing) {
  double fastest = 0.0;
  for (Eigen::Index i = 0; i < reference.scale.size(); ++i) fastest = std::max(fastest, reference.rate[i] / reference.scale[i]);
  std::vector<long> counts;
  for (int k = 0; k < 40; ++k) {
    const long count = std::max(1L, std::lround(std::abs(spacing) * fastest * std::pow(2.0, 0.5 * k)));
    if (counts.empty() || count != counts.back()) counts.push_back(count);
  }
  return counts;
}

}  // namespace detail

/// Runs the contenders against a reference.
///
/// @param t0        start of the motion; the output times are those of the reference
/// @param contenders  by_tolerance(), by_step(), or hand-made
/// @param progress  called before each measurement with the method and its setting; may be empty
template <class = void>  // compiled only where it is called
WorkPrecision work_precision(ReferenceMotion reference, double t0, const std::vector<Contender>& contenders,
                             const EnergyFunctions& energies, const WorkPrecisionOptions& options = {},
                             const std::function<void(const std::string&, double)>& progress = {}) {
  WorkPrecision study;
  study.reference = std::move(reference);
  const ReferenceMotion& exact = study.reference;
  if (exact.t.empty()) throw InvalidValue("a work-precision study needs a reference at one time at least, but it has none");
  if (energies.jacobi) {
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest, kinetic = 0.0;
    for (std::size_t k = 0; k < exact.t.size(); ++k) {
      const Eigen::VectorXd y = exact.y.col(static_cast<Eigen::Index>(k)).cast<double>();
      const double h = energies.jacobi(exact.t[k], y);
      lowest = std::min(lowest, h);
      highest = std::max(highest, h);
      kinetic = std::max(kinetic, std::abs(energies.kinetic(exact.t[k], y)));
    }
    study.energy_scale = kinetic > 0 ? kinetic : 1.0;
    study.energy_conserved = highest - lowest <= 1e-9 * study.energy_scale;
  }
  const double spacing = (exact.t.back() - t0) / static_cast<double>(exact.t.size());
  for (const Contender& contender : contenders) {
    std::vector<double> settings = options.tolerances;
    if (contender.fixed_step) {
      settings.clear();
      for (const long count : detail::step_counts(exact, spacing)) settings.push_back(std::abs(spacing) / static_cast<double>(count));
    }
    double best = std::numeric_limits<double>::infinity();
    int idle = 0;  // settings in a row that brought nothing
    for (const double setting : settings) {
      if (progress) progress(contender.name, setting);
      const auto began = std::chrono::steady_clock::now();
      Measurement m = detail::measurement(study, contender, setting, options.seconds_per_cell, energies);
      const double took = m.completed() ? m.cpu_median : std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
      if (!contender.fixed_step && !m.completed()) ++idle;
      if (contender.fixed_step) {
        idle = m.largest_error <= 0.8 * best || !(best < 1e-5) ? 0 : idle + 1;
        if (m.largest_error < best) best = m.largest_error;
      }
      study.measurements.push_back(std::move(m));
      if (1.7 * took > options.longest_run || idle >= 2) break;
    }
  }
  return study;
}

// Old names, accepted until 0.4.

using StudyOptions [[deprecated("qdot: say WorkPrecisionOptions")]] = WorkPrecisionOptions;
using AccuracyStudy [[deprecated("qdot: say WorkPrecision")]] = WorkPrecision;

/// work_precision() by its old name.
template <class = void>  // compiled only where it is called
[[deprecated("qdot: say work_precision()")]]
WorkPrecision accuracy_study(ReferenceMotion reference, double t0, const std::vector<Contender>& contenders,
                             const EnergyFunctions& energies, const WorkPrecisionOptions& options = {},
                             const std::function<void(const std::string&, double)>& progress = {}) {
  return work_precision(std::move(reference), t0, contenders, energies, options, progress);
}

}  // namespace qdot
