#pragma once
// SPDX-License-Identifier: MIT
//
// Watchdogs: what a run looks at besides its steps.
//
// A step that passes its error test may still be worthless: where M is nearly singular its accelerations have no digits left,
// and where V is not what its derivative says (a jump, a parameter that somebody changes) the method follows forces that
// belong to no energy. So now and then an accepted state is looked at:
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
//     time          No step passes over what nobody looked at (integrate/watch/time_watch.hpp).
//     f             of all systems: whether the right-hand side is what it was at the same time and state (integrate/watch/change_watch.hpp).
//     values        T and V must have some. Their slopes are numbers only where they do, but not every value is needed for q̈: a
//                   constant that is NaN, or a sum that overflows, moves nothing. The energy that it makes NaN is one all the same.
//
// When. At the start, after steps 1, 3, 7, 15, 31, 63, then every 61st (a prime: what alternates from step to step, or with another
// short period, must not look the same at all looks), at stop times and at the end; after every step while
// rcond(M) is below 1e-6, and where the step has become eight times shorter since the last look. At stop times and where an event
// changes the state h and f are compared afresh: a legitimate change of the model belongs there. With more than eleven coordinates the looks
// are rarer, n²/64 to n²/8 steps apart, where n counts to 128. They are not counted as evaluations.
// For a double pendulum they cost about one percent of the time with Dopri5 and BDF, and half a percent with Dop853 and Taylor
// (half of what was measured with a look at every 32nd step).

#include <Eigen/Core>
#include <algorithm>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/statistics.hpp"
#include "qdot/integrate/stepper.hpp"
#include "qdot/integrate/watch/branch_watch.hpp"
#include "qdot/integrate/watch/change_watch.hpp"
#include "qdot/integrate/watch/energy_watch.hpp"
#include "qdot/integrate/watch/time_watch.hpp"
#include "qdot/mechanics/equations/cholesky.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot::detail {

// The system whose T and V stand behind a first-order form; nothing for what is of first order by itself.
template <class F>
struct BehindForm {
  static constexpr bool is_mechanical = false, is_scene = false, conserves = false;
};
template <class Sys>
struct BehindForm<FirstOrderForm<Sys>> {
  using System = Sys;
  static constexpr bool is_mechanical = true, is_scene = false;
  static constexpr bool conserves = Sys::autonomous;
  static const Sys& system(const FirstOrderForm<Sys>& form) { return form.system(); }
};
template <class F>
  requires requires(const F& f) { f.scene().system().energies(); }
struct BehindForm<F> {
  using System = std::remove_cvref_t<decltype(std::declval<const F&>().scene().system())>;
  static constexpr bool is_mechanical = true, is_scene = true, conserves = false;
  static const System& system(const F& form) { return form.scene().system(); }
};

// q and q̇ of y = [q; q̇; …].
template <int n>
std::pair<Vector<double, n>, Vector<double, n>> coordinates_of(const Eigen::VectorXd& y, Eigen::Index dof) {
  std::pair<Vector<double, n>, Vector<double, n>> parts{zeros<Vector<double, n>>(dof),
                                                        zeros<Vector<double, n>>(dof)};  // -O2 of g++ 12 takes unset ones for read
  for (Eigen::Index i = 0; i < dof; ++i) {
    parts.first[i] = y[i];
    parts.second[i] = y[dof + i];
  }
  return parts;
}

// Why accelerations have no digits.
template <class Number = double>
[[gnu::cold]] Failure lost_inertia(const Eigen::MatrixXd& M, double rcond, double t, const std::vector<std::string>& names) {
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

#ifdef QDOT_COMPILED
extern template Failure lost_inertia<double>(const Eigen::MatrixXd&, double, double, const std::vector<std::string>&);
#endif

// Of forms whose functors cannot be recorded.
struct NoBranchWatch {
  NoBranchWatch(const auto&, double) {}
};

/// Looks at the accepted states of one run.
template <FirstOrderSystem F>
class Watchdog {
  using Behind = BehindForm<F>;
  static constexpr int n = dof_at_compile_time<F>();
  static constexpr bool looks_at_energy = Behind::conserves;
  struct NotWatched {};
  static constexpr bool looks_at_constraints = requires(const F& f) { requires Behind::is_scene && F::has_constraints; };
  static constexpr bool looks_at_mass = [] {
    if constexpr (Behind::is_mechanical) return Behind::System::inertia == Inertia::positive_definite;
    return false;
  }();

 public:
  static constexpr bool watches_time = TimeWatch<F>::watches;

  Watchdog(const F& system, const Options& options)
      : system_(system), options_(options), clock_(system, options), branches_(system, options.rtol), changes_(AnyModelValues(system), options),
        energy_(energy_watch(system, options)), wait_(shortest_wait()) {}

  /// True when the state after a step of length h ought to be looked at.
  bool is_due(double h) {
    if (++steps_since_ < wait_ && !(h < 0.125 * step_seen_)) return false;
    step_seen_ = h;
    return true;
  }

  /// Begins at a state: the start, or behind a stop time or a change of the state, from where h is compared anew.
  ///
  /// @param another  motion of the same functors, which are believed to be as they were
  void begin(double t, const Eigen::VectorXd& y, [[maybe_unused]] long steps, [[maybe_unused]] bool another = false) {
    changes_.begin(t, y);
    if constexpr (TimeWatch<F>::watches) {
      if (another) clock_.begin_another(t, y);
      else clock_.begin(t, y);
    }
    if constexpr (BranchWatch<F>::watches) branches_.begin();
    steps_since_ = 0;
    if constexpr (looks_at_energy) {
      wait_ = shortest_wait();
      energy_.begin(t, y, steps);
    }
  }

  /// How far towards `landing` a step from (t, y) may go (integrate/watch/time_watch.hpp).
  template <class Y>
  double reach(double t, const Y& y, double landing, bool switches_only = false) {
    if constexpr (TimeWatch<F>::watches) return clock_.reach(t, y, landing, switches_only);
    return (void)t, (void)y, (void)switches_only, landing;
  }
  /// The first time that functors are to be shown of a step from the time t that reach() was asked about last.
  double first_shown(double t) const {
    if constexpr (TimeWatch<F>::watches) return clock_.first_shown();
    return t;
  }
  /// Whether something in the functors switches by time, as they are now.
  bool switches_by_time() const {
    if constexpr (TimeWatch<F>::watches) return clock_.switches_by_time();
    return false;
  }

  /// What a step has passed (integrate/watch/branch_watch.hpp).
  Passage passage(const Clock& clock, const PolynomialView& step, double from, double to, bool on_one_branch) {
    if constexpr (BranchWatch<F>::watches) return branches_.passage(clock, step, from, to, on_one_branch);
    return (void)clock, (void)step, (void)from, (void)to, (void)on_one_branch, Passage();
  }
  /// Whether steps from (t, y) may do so.
  bool may_pass_branches([[maybe_unused]] double t, [[maybe_unused]] const Eigen::VectorXd& y) {
    if constexpr (BranchWatch<F>::watches) return branches_.may_pass(t, y);
    return false;
  }

  /// Looks at an accepted state; the trouble, if there is some.
  ///
  /// @param controlled  the method keeps a tolerance
  std::optional<Failure> look(double t, const Eigen::VectorXd& y, [[maybe_unused]] long steps, [[maybe_unused]] bool controlled) {
    steps_since_ = 0;
    wait_ = std::min(2 * wait_, longest_wait());
    std::optional<Failure> trouble = changes_.look(t);
    if (!trouble) trouble = look_at_values_and_mass(t, y);
    if constexpr (looks_at_energy)
      if (!trouble && controlled) trouble = energy_.look(t, y, steps);
    return trouble;
  }

  /// The same at the start of a run, where there is nothing to compare h with.
  std::optional<Failure> look_at_values_and_mass(double t, const Eigen::VectorXd& y) {
    std::optional<Failure> trouble = look_at_values(t, y);
    return trouble ? trouble : look_at_mass(t, y);
  }

  /// T and V at a state.
  [[gnu::noinline]] std::optional<Failure> look_at_values(double t, const Eigen::VectorXd& y) const {
    if constexpr (Behind::is_mechanical) {
      const auto& system = Behind::system(system_);
      const auto [q, qdot] = coordinates_of<n>(y, system.dof());
      try {
        require_finite_energies(system.energies(), q, qdot, t);
      } catch (const NonFinite& error) {
        return Failure{Outcome::non_finite, error.what()};
      } catch (...) {  // as in quietly()
      }
    }
    return (void)t, (void)y, std::nullopt;
  }

  /// What the functors give now that they did not give before, asked where the method is at its wits' end; nothing if they are as they were.
  std::optional<Failure> change(double t) { return changes_.look(t); }

  /// Keeps what the next look compares with, at a state from which the motion goes on.
  void remember(double t, const Eigen::VectorXd& y) { changes_.remember(t, y); }

  /// rcond at a state.
  [[gnu::noinline]] std::optional<Failure> look_at_mass(double t, const Eigen::VectorXd& y) {
    if constexpr (looks_at_constraints) {
      return look_at_both(t, y);
    } else if constexpr (looks_at_mass) {
      const auto& system = Behind::system(system_);
      const Eigen::Index dof = system.dof();
      if (dof > most_watched_coordinates) return std::nullopt;
      const bool factored = quietly([&] {
        const auto [q, qdot] = coordinates_of<n>(y, dof);
        M_ = mass_matrix_now_and_then(system, q, qdot, t);
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
      return lost_inertia(innermost_values(M_), rcond, t, coordinate_names(system));
    } else {
      return (void)t, (void)y, std::nullopt;
    }
  }

  double mass_rcond() const noexcept { return mass_rcond_; }

  /// What is to be said of a run that came to its end.
  std::optional<Failure> verdict() const {
    if constexpr (looks_at_energy) return energy_.verdict();
    return std::nullopt;
  }

  /// Writes what was seen.
  void report(Statistics& statistics) const {
    statistics.mass_rcond = mass_rcond_;
    statistics.mass_rcond_time = mass_rcond_time_;
    statistics.constraint_rcond = constraint_rcond_;
    statistics.constraint_rcond_time = constraint_rcond_time_;
    if constexpr (looks_at_energy) energy_.report(statistics);
    if constexpr (TimeWatch<F>::watches) statistics.time_resolution = clock_.resolution();
  }

 private:
  static constexpr double closer = 1e-6;  // rcond(M) below which every step is looked at

  // Steps between two looks: M and h's differences grow faster with n than a step does, as far as they are looked at.
  long shortest_wait() const {
    const Eigen::Index dof = std::min(system_.size() / 2, most_watched_coordinates);
    return static_cast<long>(std::max<Eigen::Index>(1, dof * dof / 64));
  }
  long longest_wait() const {
    const Eigen::Index dof = std::min(system_.size() / 2, most_watched_coordinates);
    return static_cast<long>(std::max<Eigen::Index>(61, (dof * dof / 8) | 1));
  }

  static auto energy_watch([[maybe_unused]] const F& system, [[maybe_unused]] const Options& options) {
    if constexpr (looks_at_energy) return EnergyWatch(AnyEnergy(Behind::system(system)), options);
    else return NotWatched{};
  }

  std::optional<Failure> look_at_both(double t, const Eigen::VectorXd& y) {
    const auto seen = quietly([&] { return conditioning(system_.scene(), y, t); });
    if (!seen) return std::nullopt;
    if (seen->mass < mass_rcond_) {
      mass_rcond_ = seen->mass;
      mass_rcond_time_ = t;
    }
    if (seen->constraints < constraint_rcond_) {
      constraint_rcond_ = seen->constraints;
      constraint_rcond_time_ = t;
    }
    if (!(seen->constraints < options_.constraint_rcond_limit)) return std::nullopt;
    const std::vector<std::string> names = constraint_names(system_.scene());
    return Failure{Outcome::constraint_failure,
                   sentence({"rcond of the constraints must not fall below constraint_rcond_limit = ", options_.constraint_rcond_limit, ", but is ",
                             seen->constraints, " at t = ", t, ", where '", names[static_cast<std::size_t>(seen->weakest_constraint)],
                             "' depends on those before it"})};
  }

  const F& system_;
  const Options& options_;
  [[no_unique_address]] std::conditional_t<TimeWatch<F>::watches, TimeWatch<F>, NoTimeWatch> clock_;
  [[no_unique_address]] std::conditional_t<BranchWatch<F>::watches, BranchWatch<F>, NoBranchWatch> branches_;
  ChangeWatch changes_;
  [[no_unique_address]] std::conditional_t<looks_at_energy, EnergyWatch, NotWatched> energy_;
  long wait_, steps_since_ = 0;
  double step_seen_ = 0.0;
  double mass_rcond_ = 1.0, mass_rcond_time_ = 0.0, constraint_rcond_ = 1.0, constraint_rcond_time_ = 0.0;
  Matrix<double, n> M_;
  Cholesky<double, n> mass_;
};

}  // namespace qdot::detail
