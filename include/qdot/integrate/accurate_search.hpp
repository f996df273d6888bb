#pragma once
// SPDX-License-Identifier: MIT
//
// Which tolerance makes the whole motion as accurate as asked, and how sure one can be.
//
// Tolerances are local. What is left of them is  e = κ τ,  with an amplification κ that the motion decides: 1 to 1000 for
// some swings of a pendulum, 1e12 for half a minute of chaos. Rounding is amplified like a tolerance of about 10 ε. So
// κ is found by running twice; the largest difference d_k between run k and the latest one (accurate_motion.hpp) is
// the error of run k, since the latest is the more accurate:
//
//     κ = max_k  d_k / (τ_k + 10 ε) ,        estimate = 3 κ (τ + 10 ε)     for the latest run, τ .
//
// Why the maximum, and why 3. The errors of many steps cancel by chance at one tolerance and not at the next: κ scatters
// by factors of 3, and for one tolerance in a hundred by 20. One pair of runs would be deceived by it; three are hardly
// ever. (Runs whose tolerance is more than 1e8 times that of the latest are of another kind, and left out.) And no run may claim to be far better than the difference that was seen: the estimate is at least
//
//     0.3 d      of the first two runs,          0.05 d      of the last two later,          and 50 ε .
//
// How many runs. A tolerance ten times tighter costs 10^{1/8} = 1.33 times as much (Dop853; Taylor less), so where
// many digits are asked for the two runs that find κ are cheap:
//
//     few digits     3 E, 0.15 E, then if need be the tolerance that κ asks for
//     many digits    1e-4, 3e-5, then 6 τ and τ
//
// Runs that differ by more than a tenth say nothing of κ (chaos, or tolerances too loose to mean anything): then a
// tolerance a hundred times tighter is tried, down to the last digit of double.
//
// The forecast is the cost of the runs, prolonged along the power law of the last two.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace qdot {

/// One of the runs by which an accuracy was reached.
struct AccuracyTrial {
  double tolerance = 0.0;   ///< rtol; atol of a component is the same part of its size
  double difference = 0.0;  ///< from the trial before it; 0 for the first
  double work = 0.0;        ///< evaluations of the equations of motion; those of a Taylor series count for its order squared
  double seconds = 0.0;
  std::string method = {};  ///< as the statistics name it
};

/// What another accuracy would cost.
struct AccuracyForecast {
  double accuracy = 0.0;
  double seconds = 0.0;    ///< of the request, all of its runs
  double factor = 0.0;     ///< beside the cost of this request
  bool reachable = true;   ///< false where double has too few digits for it
};

/// What the runs for an accuracy have found out.
struct AccuracyReport {
  double accuracy = 0.0;        ///< asked for
  double error_estimate = std::numeric_limits<double>::infinity();  ///< of the run that is returned; infinite if nothing could be compared
  std::string worst;            ///< the component in which the error is largest; "" for the time of an event
  double worst_time = 0.0;      ///< where it is
  double event_time_error = 0.0;  ///< largest difference of an event's time between the last two runs
  double rtol = 0.0;            ///< of the run that is returned
  Eigen::VectorXd atol;         ///< the same for each component
  std::vector<AccuracyTrial> trials;              ///< all runs that ended, in their order
  std::array<AccuracyForecast, 3> forecast = {};  ///< for one, two and three more digits
  long evaluations = 0;         ///< of all runs
  double seconds = 0.0;         ///< of all runs

  bool reached() const noexcept { return error_estimate <= accuracy; }
};

namespace detail {

class ToleranceSearch {
 public:
  static constexpr double finest = 2.3e-15;  // that options.rtol may have
  static constexpr double rounding = 10 * std::numeric_limits<double>::epsilon();  // as a tolerance
  static constexpr double saturated = 0.1;   // differences beyond say nothing of κ
  static constexpr double farthest = 1e8;    // ratio of tolerances, beyond which κ is not the same

  explicit ToleranceSearch(double accuracy) : accuracy_(accuracy) {
    if (accuracy >= few_digits) {
      plan_ = {std::min(3 * accuracy, 1e-2), 0.15 * std::min(accuracy, 1e-3)};
    } else {
      plan_ = {1e-4, 3e-5};
    }
  }

  // The tolerance of the next run; nothing when another run would not help, or is not needed.
  std::optional<double> next() const {
    if (trials_.empty()) return plan_[0];
    if (trials_.size() == 1) return plan_[1];
    const double last = trials_.back().tolerance;
    if (reached() || last <= finest || trials_.size() >= most_runs) return std::nullopt;
    if (difference() > saturated) return usable(std::min(last * 1e-2, accuracy_ * 0.1));
    const double wanted = std::min(margin * accuracy_ / (safety * amplification_) - rounding, last / 4);
    if (last <= longest_ratio * wanted) return usable(wanted);
    const double before = pair_ratio * std::max(wanted, finest);  // a run in front of the last one
    return before < last / 4 ? before : finest;
  }

  // A run at this tolerance did not come to its end: begin with tighter ones.
  void skipped(double tolerance) { plan_ = {usable(tolerance / 30), usable(tolerance / 200)}; }

  // @param amplification  κ, from the differences between this run and those before it
  void ran(AccuracyTrial trial, double amplification) {
    amplification_ = amplification;
    trials_.push_back(std::move(trial));
  }

  bool reached() const { return estimate() <= accuracy_ && difference() <= saturated; }

  // Of the last run.
  double estimate() const {
    if (trials_.size() < 2) return std::numeric_limits<double>::infinity();
    const double share = difference() > saturated || trials_[trials_.size() - 2].method != trials_.back().method ? 1.0
                         : trials_.size() == 2                                                               ? 0.3
                                                                                                             : 0.05;
    return std::max({safety * amplification_ * (trials_.back().tolerance + rounding), share * difference(), 5 * rounding});
  }

  const std::vector<AccuracyTrial>& trials() const noexcept { return trials_; }

  // One, two, three more digits.
  std::array<AccuracyForecast, 3> forecast() const {
    std::array<AccuracyForecast, 3> result;
    double seconds = 0.0;
    for (const AccuracyTrial& trial : trials_) seconds += trial.seconds;
    const double growth = work_exponent();
    for (std::size_t k = 0; k < result.size(); ++k) {
      const double times = std::pow(10.0, static_cast<double>(k + 1));
      const double accuracy = accuracy_ / times, factor = std::pow(times, growth);
      const bool reachable = reached() && safety * amplification_ * (finest + rounding) <= accuracy;
      result[k] = {accuracy, seconds * factor, factor, reachable};
    }
    return result;
  }

 private:
  static constexpr double safety = 3.0, margin = 0.6, few_digits = 1e-8;
  static constexpr double longest_ratio = 100.0;  // of the last two tolerances
  static constexpr double pair_ratio = 6.0;       // the same, where they may be chosen
  static constexpr std::size_t most_runs = 9;

  static double usable(double tolerance) { return tolerance < 2 * finest ? finest : tolerance; }

  double difference() const { return trials_.back().difference; }

  // work ∝ τ^{−growth}, between the last run and the one that is most unlike it among those that mean something.
  double work_exponent() const {
    for (const AccuracyTrial& trial : trials_) {
      const AccuracyTrial& last = trials_.back();
      if (trial.tolerance > 1e-3 || trial.method != last.method || trial.tolerance < 5 * last.tolerance) continue;
      return std::clamp(std::log(last.work / std::max(trial.work, 1.0)) / std::log(trial.tolerance / last.tolerance), 0.01, 1.0);
    }
    return 1.0 / 8;
  }

  double accuracy_;
  double amplification_ = 0.0;
  std::array<double, 2> plan_{};
  std::vector<AccuracyTrial> trials_;
};

}  // namespace detail
}  // namespace qdot
