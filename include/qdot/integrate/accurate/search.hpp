#pragma once
// SPDX-License-Identifier: MIT
//
// Which tolerance τ makes the whole motion as accurate as E asks, and how sure that is.
//
// Tolerances are local; the global error is κ τ. The motion decides about κ: 1 to 1000 for some swings of a pendulum, 1e12 for
// half a minute of chaos. The difference d_k between run k and the latest, more accurate one is the error of run k, so that
//
//     κ = max_k  (d_k / τ_k) (τ_k / τ)^δ ,        estimate = s κ (τ + 3 ε) .
//
// 3 ε stands for rounding. δ = 0.02 and s = 8, 4, 3 by one, two, more differences are margins, for errors cancel by chance. A run
// is dearer than a tolerance that is too tight, so two runs are chosen before κ is known, for ν natural times of the motion:
//
//     τ₁ = 0.08 E^0.65   at little cost,       τ₂ = 0.001 E^1.1 / (ν / 20)^1.4   enough for four motions in five.
//
// Below 1e-14 the error is mostly rounding: two such runs show it, estimate = max(3 d, 3 κ ε, 50 ε). Runs must differ by τ alone,
// so absolute tolerances go with it. Runs that differ by more than a tenth do not give κ: τ becomes a hundred times tighter.

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
  double work = 0.0;        ///< evaluations of the equations of motion; a Taylor series counts for its order squared
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
  double error_estimate = std::numeric_limits<double>::infinity();  ///< of the run that is returned; ∞: not comparable
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

// How the error of a method goes with its tolerance.
struct ToleranceLaw {
  double slowness = 0.02;                                        // error ∝ τ^{1−slowness}
  double rounding = 3 * std::numeric_limits<double>::epsilon();  // as a tolerance
  double drowned = 1e-14;  // tolerances below are kept so much better that little but rounding is left,
  double times = 16.0;     // so many times better
  double nearest = 4.0;    // ratio of tolerances whose runs err independently
  double second = 1e-3;    // of the second run, beside the accuracy: the lower the order, the dearer is what is not needed

  // τ, with rounding.
  double effect(double tolerance) const { return (tolerance < drowned ? tolerance / times : tolerance) + rounding; }
};

class ToleranceSearch {
 public:
  explicit ToleranceSearch(double accuracy)
      : accuracy_(accuracy), first_(std::min(0.08 * std::pow(accuracy, 0.65), 1e-2)) {}

  // The tolerance of the next run; nothing when another run would not help, or is not needed.
  std::optional<double> next() const {
    if (trials_.empty()) return first_;
    const double last = trials_.back().tolerance;
    const std::optional<double> tolerance = trials_.size() == 1 ? second() : better_than(last);
    if (!tolerance || *tolerance >= tightest_) return tolerance;
    return tightest_ < 0.8 * last ? std::optional(tightest_) : std::nullopt;
  }

  // A run at this tolerance did not come to its end: begin with a tighter one.
  void skipped(double tolerance) { first_ = usable(tolerance / 30); }

  // A run at this tolerance was too much for double.
  void too_tight(double tolerance) { tightest_ = 10 * tolerance; }

  // @param differences    from each of the runs before this one, in their order
  // @param natural_times  that the motion lasts
  void ran(AccuracyTrial trial, const std::vector<double>& differences, double natural_times,
           const ToleranceLaw& law = {}) {
    law_ = law;
    amplification_ = 0.0;
    compared_ = 0;
    for (std::size_t k = 0; k < trials_.size(); ++k) {
      const AccuracyTrial& each = trials_[k];
      const bool alike = each.method == trial.method && each.tolerance <= farthest * trial.tolerance;
      const bool means_something = k + 1 == trials_.size() || (alike && differences[k] <= saturated);
      if (!means_something || (each.tolerance < law.drowned && k > 0)) continue;
      const double effect = law.effect(each.tolerance), ratio = effect / law.effect(trial.tolerance);
      amplification_ = std::max(amplification_, differences[k] / effect * std::pow(ratio, law.slowness));
      ++compared_;
    }
    natural_times_ = natural_times;
    trials_.push_back(std::move(trial));
  }

  bool reached() const { return estimate() <= accuracy_ && difference() <= saturated; }

  // Of the last run; not far below what was seen, whatever κ says.
  double estimate() const {
    constexpr double epsilon = std::numeric_limits<double>::epsilon(), least = 50 * epsilon;
    if (trials_.size() < 2) return std::numeric_limits<double>::infinity();
    const AccuracyTrial &before = trials_[trials_.size() - 2], &last = trials_.back();
    const double d = difference();
    const bool unlike = d > saturated || before.method != last.method || compared_ == 0;
    const double share = unlike ? 1.0 : trials_.size() == 2 ? 0.0 : 0.05;
    const double of_tolerance = std::max({safety(compared_) * amplification_ * law_.effect(last.tolerance), share * d,
                                          std::min(d, accuracy_ / 4), least});
    if (before.tolerance >= law_.drowned || unlike) return of_tolerance;
    return std::max({3 * d, 3 * amplification_ * epsilon, least});
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
      result[k] = {accuracy, seconds * factor, factor, reached() && amplification_ * law_.effect(finest) <= accuracy};
    }
    return result;
  }

 private:
  static constexpr double finest = 2.3e-15;   // that options.rtol may have
  static constexpr double usual = 25.0;       // κ of a motion that lasts for 20 of its natural times; of 137, two in three within a factor of 6
  static constexpr double saturated = 0.1;    // differences beyond say nothing of κ
  static constexpr double farthest = 1e8;     // ratio of tolerances, beyond which κ is not the same
  static constexpr double margin = 0.7;       // of the accuracy is aimed at
  static constexpr double longest_ratio = 3000.0, pair_ratio = 10.0;  // of successive tolerances
  static constexpr std::size_t most_runs = 9;

  // s. κ scatters from one tolerance to the next by factors of 3, and for one in a hundred by 20. Loose tolerances say less about tight ones.
  double safety(int compared) const {
    return compared <= 1 ? 8.0 * std::pow(std::max(accuracy_ / 1e-6, 1.0), 0.1) : compared == 2 ? 4.0 : 3.0;
  }

  static double usable(double tolerance) { return tolerance < 2 * finest ? finest : tolerance; }

  double difference() const { return trials_.back().difference; }

  // What is still needed, with κ as the runs have shown it.
  std::optional<double> better_than(double last) const {
    if (reached() || last <= finest || trials_.size() >= most_runs) return std::nullopt;
    if (difference() > saturated) return usable(std::min(last * 1e-2, accuracy_ * 0.1));
    const double now = law_.effect(last), drowned = law_.drowned;
    const double share = margin * accuracy_ / (safety(compared_ + 1) * amplification_ * now);  // of the present effect
    const double wanted = std::min(now * std::pow(share, 1 / (1 - law_.slowness)) - law_.rounding, last / law_.nearest);
    if (wanted < finest / law_.times) return last > 0.9 * drowned && drowned > finest ? 0.8 * drowned : finest;
    if (wanted < drowned) return std::max(std::min({law_.times * wanted, 0.9 * drowned, last / 1.5}), finest);
    return last <= longest_ratio * wanted ? wanted : pair_ratio * wanted;
  }

  // What four in five motions need that last as long: longer ones amplify more.
  double second() const {
    const double longer = std::clamp(std::pow(std::max(natural_times_, 1.0) / 20, 1.4), 0.05, 100.0);
    const double wanted = std::min(law_.second * std::pow(accuracy_, 1.1) / longer, trials_[0].tolerance / 10);
    constexpr double hardly_drowned = 1.05e-14;
    if (wanted > hardly_drowned) return wanted;
    const bool enough = safety(1) * usual * longer * law_.effect(hardly_drowned) <= accuracy_;
    return enough || law_.drowned == 0 ? hardly_drowned : 0.65 * law_.drowned;
  }

  // work ∝ τ^{−growth}, between the last run and the one that is most unlike it among those that mean something.
  double work_exponent() const {
    for (const AccuracyTrial& trial : trials_) {
      const AccuracyTrial& last = trials_.back();
      if (trial.tolerance > 1e-2 || trial.method != last.method || trial.tolerance < 5 * last.tolerance) continue;
      const double more_work = std::log(last.work / std::max(trial.work, 1.0));
      return std::clamp(more_work / std::log(trial.tolerance / last.tolerance), 0.01, 1.0);
    }
    return 1.0 / 8;
  }

  double accuracy_;
  double first_;                // tolerance of the first run
  double tightest_ = 0.0;       // that double allows, where a run has shown it
  ToleranceLaw law_;
  double natural_times_ = 0.0;
  double amplification_ = 0.0;  // κ, if it is to hold for the last run
  int compared_ = 0;            // runs that say something of κ
  std::vector<AccuracyTrial> trials_;
};

}  // namespace detail
}  // namespace qdot
