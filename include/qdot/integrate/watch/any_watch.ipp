#pragma once
// SPDX-License-Identifier: MIT
//
// Watchdogs: what a run looks at besides its steps.
//
// A step that passes its error test may still be worthless. Where M is nearly singular its accelerations have no digits left.
// Where V is not what its derivative says (a jump, a parameter that changes), the method follows forces that belong to no energy.
// So now and then an accepted state is looked at:
//
//     rcond(M)      the smallest pivot of M scaled to unit diagonal, d_min of D⁻½ M D⁻½ = L Δ Lᵀ: a bound of 1/cond from
//                   above, mostly within a factor of ten, that does not change with the units. Accelerations lose
//                   log₁₀(1/rcond) of 16 digits; below options.rcond_limit = 1e-13 the run ends, and the direction that has
//                   lost its inertia is named. Known for positive definite M of up to 128 coordinates, without constraints
//                   (which may carry what has no mass).
//     J M⁻¹ Jᵀ      the same for scenes with constraints, rows scaled to length one in the metric of M; of more than 128 coordinates
//                   by sparse factors, without rcond(M). Dependent rows are allowed (effects/rows/constrained_solve.hpp), so its limit is
//                   0 unless one is given.
//     energy        Where neither T nor V takes the time, whether they conserve what they must (integrate/watch/energy_watch.hpp).
//     time          No step passes over time that was not looked at (integrate/watch/time_watch.hpp).
//     f             of all systems: whether the right-hand side is what it was at the same time and state (integrate/watch/change_watch.hpp).
//     values        T and V must have some. Their slopes are numbers only where they do, but not every value is needed for q̈: a
//                   constant that is NaN, or a sum that overflows, moves nothing. The energy that it makes NaN is one all the same.
//
// When. At the start, after steps 1, 3, 7, 15, 31, 63, then every 61st, at stop times and at the end. 61 is a prime: what alternates from
// step to step, or with another short period, must not look the same at all looks. Also after every step while rcond(M) is below 1e-6, and
// where the step has become eight times shorter since the last look. At stop times and where an event changes the state h and f are compared
// afresh: a legitimate change of the model belongs there. With more than eleven coordinates the looks are rarer, n²/64 to n²/8 steps apart,
// where n counts to 128. They are not counted as evaluations. For a double pendulum they cost about one percent of the time with Dopri5 and
// BDF, and half a percent with Dop853 and Taylor. That is half of what was measured with a look at every 32nd step.
//
// This is the work of any_watch.hpp. Programs that link qdot::compiled do not read it: the library has it.

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
