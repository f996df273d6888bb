#pragma once
// SPDX-License-Identifier: MIT
//
// Do T and V conserve what they must?
//
// Where neither takes the time, h = q̇·∂L/∂q̇ − L is constant on the exact motion, and every step may change it by about
//
//     a = Σᵢ |h(y + wᵢ eᵢ) − h(y)| ,      wᵢ = rtol |yᵢ| + atolᵢ      (of more than 128 coordinates Σ |∂h/∂yᵢ| wᵢ),
//
// which needs no trust in the forces. Over N steps that is N a at most, for h has no sensitivity to earlier errors. A drift above
//
//     energy_drift_limit · (N max a + ε max(|T| + |V|)),       energy_drift_limit = 10³,
//
// is no error of integration. And the drift of a whole run must not exceed a quarter of the largest T, whatever the tolerances allow.
// Otherwise the computed motion is not the system's, and the run ends as energy_drift. (V has an arbitrary constant, T has none.) The
// margin is wide: correct runs came to 0.6 at most, and wrong models exceed 10³ by decades at usual tolerances (docs/reference/outcomes.md).
// Methods with a step of fixed length are not judged. Forces of effects do work: energy_balance.hpp is for them.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "qdot/error.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/statistics.hpp"
#include "qdot/integrate/watch/watched_form.hpp"

namespace qdot::detail {

// M and its factor, and differences of h, cost as n³: of more coordinates a run looks at less.
inline constexpr Eigen::Index most_watched_coordinates = 128;

/// Compares h with what it was where it was begun.
class EnergyWatch {
 public:
  EnergyWatch(const WatchedForm& form, const Options& options) : form_(form), options_(options) {}

  /// Begins at a state from which h ought to be constant, after so many steps of the method.
  void begin(double t, const Eigen::VectorXd& y, long steps);

  /// The trouble with h at an accepted state, if there is some.
  std::optional<Failure> look(double t, const Eigen::VectorXd& y, long steps);

  /// What is to be said of a run that came to its end: its energy may be none of this motion.
  std::optional<Failure> verdict() const;

  /// Writes what was seen.
  void report(Statistics& statistics) const {
    statistics.energy_drift = drift_;
    statistics.energy_allowed = drift_allowed_;
  }

 private:
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();

  void see(const EnergyAt& energy) {
    kinetic_ = std::max(kinetic_, std::abs(energy.T));
    most_ = std::max(most_, energy.size());
  }

  // By how much a step within the tolerances may change h.
  double allowed(double t, const Eigen::VectorXd& y, double h);

  const WatchedForm& form_;
  const Options& options_;
  std::optional<EnergyAt> reference_;     // at the begin
  double before_ = 0.0, t_before_ = 0.0;  // h at the last look
  double largest_ = 0.0, allowed_each_ = 0.0, drift_ = 0.0, drift_allowed_ = 0.0;
  double kinetic_ = 0.0, most_ = 0.0, drift_from_ = 0.0;  // of the whole run
  double largest_change_ = 0.0, change_from_ = 0.0, change_to_ = 0.0;
  long steps_begun_ = 0, looks_begun_ = 0;
  Eigen::VectorXd moved_;
};

inline void EnergyWatch::begin(double t, const Eigen::VectorXd& y, long steps) {
  reference_.reset();
  t_before_ = t;
  steps_begun_ = steps;
  if (steps == 0) drift_ = drift_allowed_ = kinetic_ = most_ = 0.0;
  if (std::isfinite(options_.energy_drift_limit)) reference_ = quietly([&] { return form_.energy(t, y); });
  if (reference_ && !std::isfinite(reference_->h)) reference_.reset();
  if (reference_) before_ = reference_->h, see(*reference_);
  allowed_each_ = largest_ = largest_change_ = 0.0;
  looks_begun_ = 0;
}

inline std::optional<Failure> EnergyWatch::look(double t, const Eigen::VectorXd& y, long steps) {
  if (!reference_) return std::nullopt;
  const std::optional<EnergyAt> now = quietly([&] { return form_.energy(t, y); });
  if (!now || !std::isfinite(now->h)) return std::nullopt;
  const double taken = static_cast<double>(steps - steps_begun_);
  const double drift = std::abs(now->h - reference_->h);
  largest_ = std::max(largest_, now->size());
  see(*now);
  const auto expected = [&] { return taken * allowed_each_ + epsilon * largest_; };
  const bool suspicious = drift > 0.01 * options_.energy_drift_limit * expected();
  if (looks_begun_++ < 4 || looks_begun_ % 8 == 0 || suspicious)
    allowed_each_ = std::max(allowed_each_, quietly([&] { return allowed(t, y, now->h); }).value_or(0.0));
  if (const double change = std::abs(now->h - before_); change > largest_change_) {
    largest_change_ = change;
    change_from_ = t_before_;
    change_to_ = t;
  }
  before_ = now->h;
  t_before_ = t;
  if (drift >= drift_) {
    drift_ = drift;
    drift_from_ = reference_->h;
    drift_allowed_ = expected();
  }
  if (!(drift > options_.energy_drift_limit * expected())) return std::nullopt;
  return Failure{Outcome::energy_drift,
                 sentence({"T(q, qdot) and V(q) conserve the energy ", reference_->h, ", but it has become ", now->h, ", while rtol = ",
                           options_.rtol, " and atol allow a change of ", expected(), "; it changed most between t = ", change_from_,
                           " and t = ", change_to_})};
}

inline std::optional<Failure> EnergyWatch::verdict() const {
  constexpr double too_much = 0.25;
  if (!(drift_ > too_much * kinetic_ && drift_ > options_.energy_drift_limit * epsilon * most_)) return std::nullopt;
  return Failure{Outcome::energy_drift,
                 sentence({"T(q, qdot) and V(q) conserve the energy ", drift_from_, ", but it has changed by ", drift_,
                           ", while T is at most ", kinetic_, ": rtol = ", options_.rtol, " and atol are too loose for this motion"})};
}

inline double EnergyWatch::allowed(double t, const Eigen::VectorXd& y, double h) {
  double sum = 0.0;
  moved_ = y;
  if (y.size() > 2 * most_watched_coordinates) {  // by slopes, here and beside it: where h is smallest it has none
    Eigen::VectorXd weight(y.size());
    for (Eigen::Index i = 0; i < y.size(); ++i) {
      weight[i] = options_.rtol * std::abs(y[i]);
      weight[i] += options_.atol[i];
      moved_[i] = y[i] + weight[i];
    }
    const Eigen::VectorXd here = form_.energy_slopes(t, y), beside = form_.energy_slopes(t, moved_);
    if (here.size() == y.size()) {
      for (Eigen::Index i = 0; i < y.size(); ++i) sum += std::max(here[i], beside[i]) * weight[i];
      return sum;
    }
    moved_ = y;
  }
  for (Eigen::Index i = 0; i < y.size(); ++i) {
    moved_[i] = y[i] + options_.rtol * std::abs(y[i]) + options_.atol[i];
    const double change = std::abs(form_.energy(t, moved_).h - h);
    if (std::isfinite(change)) sum += change;
    moved_[i] = y[i];
  }
  return sum;
}
}  // namespace qdot::detail
