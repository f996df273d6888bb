#pragma once
// SPDX-License-Identifier: MIT
//
// Watchdogs: what a run looks at besides its steps.
//
// A step that passes its error test may still be worthless. A nearly singular M leaves accelerations no digits; a V that jumps or
// changes gives forces that belong to no energy. So now and then an accepted state is looked at:
//
//     rcond(M)    d_min of D⁻½ M D⁻½ = L Δ Lᵀ, M scaled to unit diagonal: a bound of 1/cond from above, in any units. Accelerations
//                 lose log₁₀(1/rcond) of 16 digits; below options.rcond_limit the run ends. Without constraints, to 128 coordinates.
//     J M⁻¹ Jᵀ    the same of constraints, rows scaled to length one in the metric of M. Dependent rows are allowed by default.
//     others      energy (energy_watch.hpp), time (time_watch.hpp), f (change_watch.hpp), and whether T and V have values at all
//
// Looks are at the start, after steps 1, 3, 7, 15, 31, 63, then every 61st, at stop times, at the end, and where the step has become
// eight times shorter. 61 is a prime: what alternates with a short period must not look the same at all looks. More than eleven
// coordinates are looked at every n²/64 to n²/8 steps; a nearly singular M, below 1e-6, at every step.
// Looks cost about one percent with Dopri5 and BDF, half a percent with Dop853 and Taylor (double pendulum; docs/reference/outcomes.md).

#include <Eigen/Core>
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/statistics.hpp"
#include "qdot/integrate/watch/any_watch.hpp"
#include "qdot/integrate/watch/branch_watch.hpp"
#include "qdot/integrate/watch/change_watch.hpp"
#include "qdot/integrate/watch/energy_watch.hpp"
#include "qdot/integrate/watch/time_watch.hpp"
#include "qdot/mechanics/equations/cholesky.hpp"
#include "qdot/mechanics/equations/solve.hpp"

namespace qdot::detail {

// Why accelerations have no digits.
[[gnu::cold]] inline Failure lost_inertia(const Eigen::MatrixXd& M, double rcond, double t, const std::vector<std::string>& names) {
  std::string direction = "some direction";
  try {
    throw_mass_matrix_error(M, t, names);
  } catch (const MassMatrixError& error) {
    direction = direction_text(error.direction(), names);
  } catch (const NonFinite& error) {
    return {Outcome::non_finite, error.what()};
  }
  return {Outcome::singular_mass_matrix, sentence({"rcond(M) must not fall below rcond_limit, but is ", rcond, " at t = ", t,
                                                   ": the motion with velocity along ", direction,
                                                   " has almost no inertia, and its acceleration no digits"})};
}

/// Looks at the accepted states of one run; the first components of y are those of the form.
///
/// @tparam takes_time  T, V or effects take the time
template <bool takes_time>
class Watchdog final : public AnyWatch {
 public:
  Watchdog(std::unique_ptr<const WatchedForm> form, const Options& options)
      : form_(std::move(form)), options_(options), clock_(*form_, options), changes_(*form_, options), own_(form_->size()), wait_(shortest_wait()) {
    if (form_->has_recordable_branches()) branches_.emplace(*form_, options.rtol);
    if (form_->conserves_energy()) energy_.emplace(*form_, options);
  }

  bool is_due(double h) override {
    if (++steps_since_ < wait_ && !(h < 0.125 * step_seen_)) return false;
    step_seen_ = h;
    return true;
  }

  void begin(double t, const Eigen::VectorXd& all, long steps, bool another) override {
    const Eigen::VectorXd& y = own(all);
    changes_.begin(t, y);
    if constexpr (takes_time) another ? clock_.begin_another(t, y) : clock_.begin(t, y);
    (void)another;
    if (branches_) branches_->begin();
    steps_since_ = 0;
    if (energy_) {
      wait_ = shortest_wait();
      energy_->begin(t, y, steps);
    }
  }

  bool watches_time() const override { return takes_time; }
  double reach([[maybe_unused]] double t, [[maybe_unused]] const Eigen::Ref<const Eigen::VectorXd>& y, double landing,
               [[maybe_unused]] bool switches_only) override {
    if constexpr (takes_time) {
      for (Eigen::Index i = 0; i < own_.size(); ++i) own_[i] = y[i];
      return clock_.reach(t, own_, landing, switches_only);
    }
    return landing;
  }
  double first_shown(double t) const override {
    if constexpr (takes_time) return clock_.first_shown();
    return t;
  }
  bool switches_by_time() const override {
    if constexpr (takes_time) return clock_.switches_by_time();
    return false;
  }

  bool may_pass_branches(double t, const Eigen::VectorXd& y) override { return sees_branches = branches_ && branches_->may_pass(t, own(y)); }
  Passage passage(const Clock& clock, const PolynomialView& step, double from, double to, Course course) override {
    return branches_ ? branches_->passage(clock, step, from, to, course) : Passage();
  }

  std::optional<Failure> look(double t, const Eigen::VectorXd& all, long steps, bool controlled) override {
    const Eigen::VectorXd& y = own(all);
    steps_since_ = 0;
    wait_ = std::min(2 * wait_, longest_wait());
    std::optional<Failure> trouble = changes_.look(t, true);
    if (!trouble) trouble = look_at_values_and_mass(t, y);
    if (energy_ && !trouble && controlled) trouble = energy_->look(t, y, steps);
    return trouble;
  }
  std::optional<Failure> look_at_values_and_mass(double t, const Eigen::VectorXd& all) override {
    const Eigen::VectorXd& y = own(all);
    std::optional<Failure> trouble = look_at_values(t, y);
    if (trouble) return trouble;
    return form_->is_constrained() ? look_at_both(t, y) : look_at_mass(t, y);
  }
  std::optional<Failure> change(double t) override { return changes_.look(t); }
  void remember(double t, const Eigen::VectorXd& y) override { changes_.remember(t, own(y)); }
  std::optional<Failure> verdict() const override { return energy_ ? energy_->verdict() : std::nullopt; }
  double mass_rcond() const override { return mass_rcond_; }

  void report(Statistics& statistics) const override {
    statistics.mass_rcond = mass_rcond_;
    statistics.mass_rcond_time = mass_rcond_time_;
    statistics.constraint_rcond = constraint_rcond_;
    statistics.constraint_rcond_time = constraint_rcond_time_;
    if (energy_) energy_->report(statistics);
    if constexpr (takes_time) statistics.time_resolution = clock_.resolution();
  }

 private:
  static constexpr double closer = 1e-6;  // rcond(M) below which every step is looked at

  // Steps between two looks: M and h's differences grow faster with n than a step does, as far as they are looked at.
  long shortest_wait() const {
    const Eigen::Index dof = std::min(form_->size() / 2, most_watched_coordinates);
    return static_cast<long>(std::max<Eigen::Index>(1, dof * dof / 64));
  }
  long longest_wait() const {
    const Eigen::Index dof = std::min(form_->size() / 2, most_watched_coordinates);
    return static_cast<long>(std::max<Eigen::Index>(61, (dof * dof / 8) | 1));
  }

  const Eigen::VectorXd& own(const Eigen::VectorXd& y) {
    if (y.size() == own_.size()) return y;
    for (Eigen::Index i = 0; i < own_.size(); ++i) own_[i] = y[i];
    return own_;
  }

  // T and V at a state.
  std::optional<Failure> look_at_values(double t, const Eigen::VectorXd& y) const {
    try {
      form_->require_energies(t, y);
    } catch (const NonFinite& error) {
      return Failure{Outcome::non_finite, error.what()};
    } catch (...) {  // as in quietly()
    }
    return std::nullopt;
  }

  // rcond(M).
  std::optional<Failure> look_at_mass(double t, const Eigen::VectorXd& y) {
    if (!form_->has_positive_mass() || form_->dof() > most_watched_coordinates) return std::nullopt;
    const bool factored = quietly([&] {
      form_->write_mass(t, y, M_);
      mass_.compute(M_);
      return true;
    }).has_value();
    if (!factored) return std::nullopt;
    const double rcond = mass_.smallest_pivot();
    if (rcond < closer) wait_ = shortest_wait();
    if (rcond < mass_rcond_) {
      mass_rcond_ = rcond;
      mass_rcond_time_ = t;
    }
    if (!(rcond < options_.rcond_limit)) return std::nullopt;
    std::vector<std::string> names;
    for (Eigen::Index i = 0; i < form_->dof(); ++i) names.push_back(form_->component_name(i));
    return lost_inertia(M_, rcond, t, names);
  }

  std::optional<Failure> look_at_both(double t, const Eigen::VectorXd& y) {
    const auto found = quietly([&] { return form_->pivots(t, y); });
    if (!found) return std::nullopt;
    const WatchedForm::Pivots& seen = *found;
    if (seen.mass < mass_rcond_) {
      mass_rcond_ = seen.mass;
      mass_rcond_time_ = t;
    }
    if (seen.constraints < constraint_rcond_) {
      constraint_rcond_ = seen.constraints;
      constraint_rcond_time_ = t;
    }
    if (!(seen.constraints < options_.constraint_rcond_limit)) return std::nullopt;
    const std::vector<std::string> names = form_->row_names();
    return Failure{Outcome::constraint_failure,
                   sentence({"rcond of the constraints must not fall below constraint_rcond_limit = ", options_.constraint_rcond_limit, ", but is ",
                             seen.constraints, " at t = ", t, ", where '", names[static_cast<std::size_t>(seen.weakest_constraint)],
                             "' depends on those before it"})};
  }

  std::unique_ptr<const WatchedForm> form_;
  const Options& options_;
  struct NoTime {
    NoTime(const WatchedForm&, const Options&) {}
  };
  [[no_unique_address]] std::conditional_t<takes_time, TimeWatch, NoTime> clock_;
  std::optional<BranchWatch> branches_;
  ChangeWatch changes_;
  std::optional<EnergyWatch> energy_;
  Eigen::VectorXd own_;
  long wait_, steps_since_ = 0;
  double step_seen_ = 0.0;
  double mass_rcond_ = 1.0, mass_rcond_time_ = 0.0, constraint_rcond_ = 1.0, constraint_rcond_time_ = 0.0;
  Eigen::MatrixXd M_;
  Cholesky<double, Dynamic> mass_;
};

template <bool takes_time>
std::unique_ptr<AnyWatch> watchdog(std::unique_ptr<const WatchedForm> form, const Options& options) {
  return std::make_unique<Watchdog<takes_time>>(std::move(form), options);
}

}  // namespace qdot::detail
